//! Readings beside published numbers, and restarts under both protocols, on rendered sequences.

use crate::tools::{Place, Row, number};

const EXPERIMENT: &str = r#"
schema = 1
name = "mine/readings"
title = "Readings"
protocol = "khalid2016/1"
suites.test = "synthetic-vot"
tracker = [
    { name = "ncc", label = "NCC", protocol = "vot-reset" },
    { name = "ncc", label = "NCC nearby", like = "NCC", search = 0.5, protocol = "vot-reset" },
]

[[method]]
name = "RgbHist"

[[method]]
name = "RgbHist 16 bins"
like = "RgbHist"
signal = { bins = 16 }

[[method]]
name = "RgbHist anew"
like = "RgbHist"
protocol = "khalid2016/2"

[[method]]
name = "oracle"
detector = { kind = "oracle" }

[[method]]
name = "oracle anew"
like = "oracle"
protocol = "khalid2016/2"

[[table]]
name = "detection"
rows = ["precision", "recall", "f_score", "score_mean_std"]
columns = "method"

[[published]]
table = "detection"
tracker = "NCC"
row = "recall"
values = { RgbHist = ".60" }

[[published]]
table = "detection"
tracker = "NCC"
row = "score_mean_std"
values = { RgbHist = ".67±.16" }
"#;

/// A place with the results of the experiment.
fn finished() -> Place {
    let place = Place::with(&[("my.toml", EXPERIMENT)]);
    place.run("run my.toml --quiet").ends(0);
    place
}

#[test]
fn readings_have_the_published_numbers_of_what_they_are_like_and_are_ranked() {
    let place = finished();
    let readings = place.rows("results/mine/readings/readings.csv");
    let of = |tracker: &str, method: &str, statistic: &str| {
        let is_it =
            |r: &&Row| r["tracker"] == tracker && r["method"] == method && r["statistic"] == statistic;
        readings.iter().find(is_it).unwrap_or_else(|| panic!("{tracker}, {method}, {statistic}")).clone()
    };
    // Both readings of the tracker and all of the method belong to one group, with the same published numbers and units.
    for tracker in ["NCC", "NCC nearby"] {
        for method in ["RgbHist", "RgbHist 16 bins", "RgbHist anew"] {
            for (statistic, published) in [("recall", "0.6"), ("score_mean", "0.67"), ("score_std", "0.16")] {
                let row = of(tracker, method, statistic);
                assert_eq!((row["of_tracker"].as_str(), row["of_method"].as_str()), ("NCC", "RgbHist"));
                assert_eq!(row["published"], published);
                assert_eq!(row["scale"], of("NCC", "RgbHist", statistic)["scale"]);
            }
        }
    }
    // The discrepancy is the root mean square of the three differences in their units.
    let squares = ["recall", "score_mean", "score_std"].map(|statistic| {
        let row = of("NCC", "RgbHist 16 bins", statistic);
        (number(&row, "difference") / number(&row, "scale")).powi(2)
    });
    let want = (squares.iter().sum::<f64>() / 3.0).sqrt();
    let found = number(&of("NCC", "RgbHist 16 bins", "discrepancy"), "ours");
    assert!((found - want).abs() < 1e-9, "{found} {want}");
    let first: f64 =
        readings.iter().filter(|r| r["statistic"] == "discrepancy").map(|r| number(r, "first")).sum();
    assert!((first - 1.0).abs() < 1e-9, "{first}");
    assert!(place.has("reports/mine/readings/figures/readings-rgbhist-ncc.svg"));
    let table = place.read("results/mine/readings/tables/readings.md");
    assert!(table.contains("RgbHist (as it is)") && table.contains("RgbHist anew on NCC nearby"), "{table}");
}

#[test]
fn nobody_is_paid_for_a_restart() {
    let place = finished();
    let scores = place.rows("results/mine/readings/scores.csv");
    let pooled = |method: &str, key: &str| -> u64 {
        let is_it = |r: &&Row| r["sequence"] == "*" && r["tracker"] == "NCC" && r["method"] == method;
        scores.iter().find(is_it).unwrap()[key].parse().unwrap()
    };
    // The oracle finds every failure under both; pieces leave out what was skipped.
    for method in ["oracle", "oracle anew"] {
        assert_eq!((pooled(method, "fn"), pooled(method, "fp")), (0, 0), "{method}");
    }
    assert_eq!(pooled("oracle", "tp"), pooled("oracle anew", "tp"));
    assert!(pooled("oracle", "tp") > 0 && pooled("oracle anew", "tn") < pooled("oracle", "tn"));
    // The histogram jumps at a restart: without it fewer failures are found, and there are fewer detections.
    assert!(pooled("RgbHist anew", "tp") <= pooled("RgbHist", "tp"));
    assert!(pooled("RgbHist anew", "detections") < pooled("RgbHist", "detections"));
    // `explain` counts as the run did.
    let pieces = place.rows("results/mine/readings/pieces.csv");
    assert!(pieces.iter().all(|p| p["first"].parse::<u32>().unwrap() <= p["last"].parse::<u32>().unwrap()));
    let sequence = &pieces[0]["sequence"];
    let explain = "explain mine/readings/detection recall 'RgbHist anew' --tracker NCC --sequence";
    place.run(&format!("{explain} '{sequence}'")).ends(0);
}

#[test]
fn wrong_readings_are_told_by_name() {
    let wrong = |from: &str, to: &str, words: &[&str]| {
        let text = EXPERIMENT.replace(from, to);
        assert_ne!(text, EXPERIMENT);
        let ran = Place::with(&[("my.toml", &text)]).run("run my.toml --quiet").ends(2);
        words.iter().fold(ran, |ran, word| ran.tells(word));
    };
    wrong("like = \"RgbHist\"\nsignal", "like = \"RbgHist\"\nsignal", &["RbgHist", "RgbHist"]);
    wrong("like = \"NCC\"", "like = \"KCF\"", &["KCF", "NCC"]);
    wrong("signal = { bins = 16 }", "signal = { bin = 16 }", &["bin"]);
    wrong("columns = \"method\"", "columns = \"method\"\npublished = \"table9\"", &["table9"]);
    wrong(
        "like = \"oracle\"\nprotocol",
        "signal = { kind = \"uncertainty\" }\ndetector = { kind = \"arte\" }\nprotocol",
        &["backwards", "khalid2016/2"],
    );
}
