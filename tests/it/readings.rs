//! Readings beside published numbers, on rendered sequences.

use crate::tools::{Place, Row, experiment, number};

const READINGS: &str = r#"tracker = [
    { name = "ncc", label = "NCC", protocol = "vot-reset" },
    { name = "ncc", label = "NCC nearby", like = "NCC", search = 0.5, protocol = "vot-reset" },
]
method = [
    { name = "RgbHist" },
    { name = "RgbHist 16 bins", like = "RgbHist", signal = { bins = 16 } },
    { name = "RgbHist anew", like = "RgbHist", protocol = "khalid2016/2" },
    { name = "oracle", detector = { kind = "oracle" } },
    { name = "oracle anew", like = "oracle", protocol = "khalid2016/2" },
]
table = [{ name = "detection", rows = ["precision", "recall", "f_score", "score_mean_std"], columns = "method" }]
published = [
    { table = "detection", tracker = "NCC", row = "recall", values = { RgbHist = ".60" } },
    { table = "detection", tracker = "NCC", row = "score_mean_std", values = { RgbHist = ".67±.16" } },
]
"#;

/// A place with the experiment.
fn place(readings: &str) -> Place {
    Place::with(&[("my.toml", &experiment("mine/readings", "synthetic-vot", readings))])
}

#[test]
fn readings_have_the_published_numbers_of_what_they_are_like_and_are_ranked() {
    let place = place(READINGS);
    place.run("run my.toml --quiet").ends(0);
    let readings = place.rows("results/mine/readings/readings.csv");
    let of = |tracker: &str, method: &str, statistic: &str| {
        let fits = |r: &&Row| r["tracker"] == tracker && r["method"] == method && r["statistic"] == statistic;
        readings.iter().find(fits).unwrap_or_else(|| panic!("{tracker}, {method}, {statistic}")).clone()
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
    // `explain` knows the pieces, whose counts are tested where the protocols are.
    let pieces = place.rows("results/mine/readings/pieces.csv");
    assert!(pieces.iter().all(|piece| number(piece, "first") <= number(piece, "last")));
    let explain = "explain mine/readings/detection recall 'RgbHist anew' --tracker NCC --sequence";
    place.run(&format!("{explain} '{}'", pieces[0]["sequence"])).ends(0);
}

#[test]
fn wrong_readings_are_told_by_name() {
    for (from, to, words) in [
        ("like = \"RgbHist\", signal", "like = \"RbgHist\", signal", ["RbgHist", "RgbHist"]),
        ("like = \"NCC\"", "like = \"KCF\"", ["KCF", "NCC"]),
        (
            "detector = { kind = \"oracle\" }",
            "protocol = \"khalid2016/2\", signal.kind = \"uncertainty\", detector.kind = \"arte\"",
            ["backwards", "khalid2016/2"],
        ),
    ] {
        let text = READINGS.replace(from, to);
        assert_ne!(text, READINGS);
        place(&text).run("run my.toml --quiet").ends(2).tells(words[0]).tells(words[1]);
    }
}
