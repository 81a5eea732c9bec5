//! Measures frame by frame: their file, tables and ranks of them, and the protocols that count frames and losses.

use crate::tools::{Place, number};
use trackfail::results;

const SPEC: &str = r#"schema = 1
name = "small"
title = "t"
protocol = "frames/1"
suites.test = "synthetic-otb"
tracker = [{ name = "still" }]
method = [
    { name = "level", signal.kind = "rgb-histogram", detector = { kind = "level", below = 0.6 } },
    { name = "turned", signal.kind = "rgb-histogram", detector = { kind = "level", above = 0.6 }, protocol = "frames-clear/1" },
    { name = "losses", signal.kind = "rgb-histogram", detector.kind = "level", grid = { below = [0.5, 0.6] }, protocol = "range/1" },
    { name = "nab", signal.kind = "rgb-histogram", detector = { kind = "level", below = 0.6 }, protocol = "nab/1" },
    { name = "oracle", detector.kind = "oracle" },
    { name = "always", detector.kind = "always" },
    { name = "never", detector.kind = "never" },
]
[[table]]
name = "frames"
rows = ["f_score", "f_over_chance", "auroc", "false_alarms_at_half", "range_f", "nab"]
columns = "method"
methods = ["level", "turned", "nab", "oracle", "always", "never"]
[[table]]
name = "board"
rank = "auroc"
[[claim]]
text = "Nothing is better than the truth"
holds = "auroc[level] < auroc[oracle]"
"#;

/// The tracker scored over the histogram as its confidence, by the rules of three programs.
fn over_a_confidence() -> String {
    let analysis = |(name, rules): (&str, &str)| {
        format!(
            "[[analysis]]\nname = \"{name}\"\nsuites = [\"test\"]\nsignal.kind = \"rgb-histogram\"\n\
             compute = {{ kind = \"longterm\", rules = \"longterm/{rules}/1\" }}\n\
             [[table]]\nname = \"{name}\"\nshows = \"{name}.overall\"\n"
        )
    };
    let all = [("vot", "vot-toolkit"), ("pysot", "pysot"), ("all", "pytracking")].map(analysis).concat();
    let holds = "finding[vot.lt_f] > 0 && finding[pysot.lt_f] < 1";
    format!("{all}[[claim]]\ntext = \"F lies between\"\nholds = \"{holds}\"\nrequired = true\n")
}

/// A place with the results of an experiment.
fn run(spec: &str) -> Place {
    let place = Place::with(&[("a.toml", spec)]);
    place.run("run a.toml -q").ends(0);
    place
}

fn kept(name: &str) -> String {
    format!("results/small/{name}")
}

#[test]
fn every_method_has_measures_of_frames() {
    let place = run(&format!("{SPEC}{}", over_a_confidence()));
    let measures = place.rows(&kept("frame_measures.csv"));
    let of = |method: &str| measures.iter().find(|r| r["method"] == method).unwrap();
    assert_eq!(measures.iter().filter(|r| r["method"] == "losses").count(), 2);
    for anchor in ["always", "never"] {
        let row = of(anchor);
        assert_eq!((number(row, "auroc"), number(row, "false_alarms_at_half")), (0.5, 1000.0), "{anchor}");
    }
    let oracle = of("oracle");
    for name in ["auroc", "auprc", "auroc_low", "auroc_high", "range_precision", "range_recall", "range_f"] {
        assert_eq!(number(oracle, name), 1.0, "{name}");
    }
    assert_eq!((number(oracle, "false_alarms_at_half"), number(oracle, "delay_at_half")), (0.0, 0.0));
    let (level, turned) = (of("level"), of("turned"));
    assert!((number(level, "auroc") + number(turned, "auroc") - 1.0).abs() < 1e-12);
    let [low, area, high] = ["auroc_low", "auroc", "auroc_high"].map(|name| number(level, name));
    assert!(low < area && area < high, "{low} {area} {high}");
    assert_eq!(level["ece"], "");
    // Another threshold or protocol has the same scores.
    for other in measures.iter().filter(|r| r["method"] == "losses" || r["method"] == "nab") {
        assert_eq!((&other["auroc"], &other["auprc_low"]), (&level["auroc"], &level["auprc_low"]));
    }
    let table = place.rows(&kept("tables/board.csv"));
    let value = |method: &str, column: &str| {
        table.iter().find(|r| r["row"] == method && r["column"] == column).unwrap()["ours"].clone()
    };
    // The score of `turned` has the other sign, those of the others are that of `level`.
    let first = if area > 0.5 { "1.0" } else { "2.0" };
    assert_eq!((value("level", "rank").as_str(), value("level", "low")), (first, level["auroc_low"].clone()));
    assert_eq!((value("oracle", "rank"), value("always", "auroc")), (String::new(), "0.5".to_string()));
    let told =
        ["Nothing is better than the truth", "columns low and high are a 95 % interval over sequences"];
    place.holds("reports/small/report.md", &told, &[]);
    let [vot, pysot, all] = ["vot", "pysot", "all"].map(|name| {
        let table = place.rows(&kept(&format!("tables/{name}.csv")));
        number(table.iter().find(|r| r["column"] == "F").unwrap(), "ours")
    });
    assert!([vot, pysot, all].iter().all(|f| (0.0..=1.0).contains(f)) && vot != all, "{vot} {pysot} {all}");

    // Results of a program that did not have these measures.
    let manifest = kept("manifest.json");
    let mut read = place.json(&manifest);
    assert!(read["files"].as_object_mut().unwrap().remove("frame_measures.csv").is_some());
    place.write(&manifest, read.to_string());
    place.remove(&kept("frame_measures.csv"));
    place.run("report small").ends(0);
    let table = place.rows(&kept("tables/frames.csv"));
    let ours = |row: &str| &table.iter().find(|r| r["row"] == row && r["column"] == "level").unwrap()["ours"];
    assert_eq!(ours("auroc"), "");
    assert_ne!(ours("f_score"), "");
}

// Before: the counts of `both` on NCC stood against those of `still` on the other tracker alone.
#[test]
fn methods_are_compared_on_the_tracks_that_both_have() {
    let method = |name: &str, trackers: &str, below: f64| {
        format!(
            "[[method]]\nname = \"{name}\"\ntrackers = {trackers}\nsignal.kind = \"rgb-histogram\"\n\
             detector = {{ kind = \"level\", below = {below} }}\n"
        )
    };
    let head = "schema = 1\nname = \"small\"\ntitle = \"t\"\nprotocol = \"frames/1\"\nsuites.test = \"synthetic-otb\"\n\
                tracker = [{ name = \"still\" }, { name = \"ncc\" }]\n";
    let methods =
        [("both", "[\"still\", \"ncc\"]", 0.6), ("rest", "[\"still\"]", 0.5), ("go", "[\"ncc\"]", 0.5)];
    let place = run(&(head.to_string() + &methods.map(|(name, on, below)| method(name, on, below)).concat()));
    let compare = |words: &str| place.run(&format!("compare {words} --in small --format csv"));
    let told = compare("both rest").ends(0).tells("left out are 20 of A\n");
    assert_eq!(told.out, compare("both rest --tracker still").ends(0).out);
    assert_ne!(told.out, compare("both go").ends(0).out);
    compare("rest go").refuses(2, "A has 20 tracks and B 20, none of which both have");
    place.write("b.toml", head.replace("\"small\"", "\"other\"") + &method("both", "[\"still\"]", 0.6));
    place.run("run b.toml -q").ends(0);
    place.run("compare results/small results/other").ends(0).tells("left out are 20 of A\n");
}

// The oracle finds every loss: the difference to a method is what that method lacks.
#[test]
fn methods_of_a_leaderboard_are_compared_on_the_same_tracks_and_compact_results_have_no_frames() {
    let trackers = "[{ name = \"still\", family = \"resting\" }, { name = \"still\", label = \"other\", family = \"others\" }]";
    let spec = SPEC.replace("title = \"t\"", "title = \"t\"\nleaderboard = true");
    let place = run(&spec.replace("[{ name = \"still\" }]", trackers));
    let measures = place.rows(&kept("frame_measures.csv"));
    // A family of one tracker has that one's measures; one source alone is no pool of its own.
    let of = |method: &str, tracker: &str| {
        measures.iter().find(|r| r["method"] == method && r["tracker"] == tracker).unwrap()
    };
    assert_eq!(of("level", "* others")["auroc"], of("level", "other")["auroc"]);
    assert!(number(of("level", "*"), "losses") == 2.0 * number(of("level", "* resting"), "losses"));
    assert!(measures.iter().all(|row| !row["tracker"].contains(" on ")));
    place.holds(&kept("tables/breakdown.md"), &["| all |", "| others |", "| resting |"], &[]);
    let pairs = place.rows(&kept("frame_pairs.csv"));
    assert!(pairs.iter().all(|r| r["method"] != "losses" && r["other"] != "losses"), "{pairs:?}");
    let pair = pairs.iter().find(|r| r["method"] == "level" && r["other"] == "oracle").unwrap();
    for measure in ["auroc", "found_at_5"] {
        let difference = number(pair, &format!("{measure}_difference"));
        let bounds = ["low", "high"].map(|end| number(pair, &format!("{measure}_difference_{end}")));
        assert!((difference - (number(of("level", "*"), measure) - 1.0)).abs() < 1e-12, "{pair:?}");
        assert!(bounds[0] <= difference && difference <= bounds[1] && bounds[1] <= 0.0, "{pair:?}");
    }
    // `compare` has the numbers of the tables, of one experiment and of two.
    let compare = |line: &str| place.run(&format!("compare {line} --in small --format csv")).rows().remove(0);
    let auroc = compare("level oracle --metric auroc");
    assert_eq!(number(&auroc, "A - B"), number(pair, "auroc_difference"));
    assert_eq!(number(&auroc, "95% from"), number(pair, "auroc_difference_low"));
    let pooled = compare("level oracle --metric 'pooled f_score' --tracker other");
    let counted = place.rows(&kept("measures.csv"));
    for (side, method) in [("A", "level"), ("B", "oracle")] {
        let mine = counted.iter().find(|r| r["method"] == method && r["tracker"] == "other").unwrap();
        assert_eq!(number(&pooled, side), number(mine, "f_score"), "{method}");
    }
    assert!(number(&pooled, "95% from") <= number(&pooled, "A - B"), "{pooled:?}");
    assert_eq!(number(&compare("level level --in small --metric f_score"), "A - B"), 0.0);
    let differences = place.read(&kept("tables/differences.md"));
    assert!(differences.contains("| level |") && !differences.contains("| oracle |"), "{differences}");
    let [board, scores] = ["tables/board.csv", "scores.csv"].map(|name| place.read(&kept(name)));
    place.run("run a.toml -q --compact").ends(0);
    for name in ["frames.parquet", "signals.parquet", "truth.parquet", "models", "scores.csv"] {
        assert!(!place.has(&kept(name)), "{name}");
    }
    assert_eq!(place.read(&kept("tables/board.csv")), board);
    let packed = results::Results::read(&place.path("results/small")).unwrap().scores().unwrap();
    assert_eq!(packed, results::scores::read(scores.into_bytes()).unwrap());
    assert_eq!(place.read(&kept("tables/differences.md")), differences);
    place.run("report").ends(0);
    place.holds("reports/small/index.html", &["level"], &["id=\"sequences\""]);
}
