//! Measures frame by frame: their file, tables and ranks of them, and the protocols that count frames and losses.

use crate::tools::{rows, trackfail};
use serde_json::Value;
use std::collections::BTreeMap;
use std::path::Path;
use trackfail::results;

const SPEC: &str = r#"schema = 1
name = "small"
title = "t"
protocol = "frames/1"
[suites]
test = "synthetic-otb"
[[tracker]]
name = "still"
[[method]]
name = "level"
signal.kind = "rgb-histogram"
detector = { kind = "level", below = 0.6 }
[[method]]
name = "turned"
signal.kind = "rgb-histogram"
detector = { kind = "level", above = 0.6 }
protocol = "frames-clear/1"
[[method]]
name = "losses"
signal.kind = "rgb-histogram"
detector = { kind = "level" }
grid = { below = [0.5, 0.6] }
protocol = "range/1"
[[method]]
name = "nab"
signal.kind = "rgb-histogram"
detector = { kind = "level", below = 0.6 }
protocol = "nab/1"
[[method]]
name = "oracle"
detector = { kind = "oracle" }
[[method]]
name = "always"
detector = { kind = "always" }
[[method]]
name = "never"
detector = { kind = "never" }
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

fn read(root: &Path, name: &str) -> String {
    std::fs::read_to_string(root.join("results/small").join(name)).unwrap()
}

fn run(root: &Path) {
    std::fs::write(root.join("a.toml"), SPEC).unwrap();
    trackfail().current_dir(root).args(["run", "a.toml", "-q"]).assert().success();
}

type Row = BTreeMap<String, String>;

fn number(row: &Row, name: &str) -> f64 {
    row[name].parse().unwrap_or_else(|_| panic!("{name}: {row:?}"))
}

#[test]
fn every_method_has_measures_of_frames() {
    let root = tempfile::tempdir().unwrap();
    let root = root.path();
    run(root);
    let measures = rows(&read(root, "frame_measures.csv"));
    let of = |method: &str| measures.iter().find(|r| r["method"] == method).unwrap();
    assert_eq!(measures.iter().filter(|r| r["method"] == "losses").count(), 2);
    for anchor in ["always", "never"] {
        let row = of(anchor);
        assert_eq!((number(row, "auroc"), number(row, "false_alarms_at_half")), (0.5, 1000.0), "{anchor}");
        let share = number(row, "lost_frames") / (number(row, "lost_frames") + number(row, "good_frames"));
        assert!((number(row, "auprc") - share).abs() < 1e-12 && (number(row, "aurc") - share).abs() < 1e-9);
    }
    let oracle = of("oracle");
    for name in ["auroc", "auprc", "auroc_low", "auroc_high", "range_precision", "range_recall", "range_f"] {
        assert_eq!(number(oracle, name), 1.0, "{name}");
    }
    assert_eq!((number(oracle, "false_alarms_at_half"), number(oracle, "delay_at_half")), (0.0, 0.0));
    // Half in probation or less: the best of a loss that goes on then is below 1.
    assert!(
        number(oracle, "nab") > 90.0
            && number(of("always"), "nab") < 0.0
            && number(of("never"), "nab") == 0.0
    );
    let (level, turned) = (of("level"), of("turned"));
    assert!((number(level, "auroc") + number(turned, "auroc") - 1.0).abs() < 1e-12);
    assert!(
        number(level, "auroc_low") < number(level, "auroc")
            && number(level, "auroc") < number(level, "auroc_high")
    );
    assert_eq!(level["ece"], "");
    // Another threshold or protocol has the same scores.
    for other in measures.iter().filter(|r| r["method"] == "losses" || r["method"] == "nab") {
        assert_eq!((&other["auroc"], &other["auprc_low"]), (&level["auroc"], &level["auprc_low"]));
    }
    let table = rows(&read(root, "tables/board.csv"));
    let value = |method: &str, column: &str| {
        let cell = table.iter().find(|r| r["row"] == method && r["column"] == column).unwrap();
        cell["ours"].clone()
    };
    // The score of `turned` has the other sign, those of the others are that of `level`.
    let first = if number(level, "auroc") > 0.5 { "1.0" } else { "2.0" };
    assert_eq!((value("level", "rank").as_str(), value("level", "low")), (first, level["auroc_low"].clone()));
    assert_eq!((value("oracle", "rank"), value("always", "auroc")), (String::new(), "0.5".to_string()));
    let page = std::fs::read_to_string(root.join("reports/small/report.md")).unwrap();
    assert!(page.contains("Nothing is better than the truth"));
    assert!(page.contains("The columns low and high are"), "{page}");
}

#[test]
fn counts_of_frames_and_losses_are_taken_apart() {
    let root = tempfile::tempdir().unwrap();
    let root = root.path();
    run(root);
    let explain = |words: &[&str]| -> Vec<Value> {
        let command =
            trackfail().current_dir(root).arg("explain").args(words).args(["--format", "json"]).output();
        let output = command.unwrap();
        assert!(output.status.success(), "{words:?}: {}", String::from_utf8_lossy(&output.stderr));
        serde_json::from_slice(&output.stdout).unwrap()
    };
    let scores = rows(&read(root, "scores.csv"));
    for method in ["level", "turned", "nab"] {
        for part in explain(&["small/frames", "auroc", method]) {
            let name = part["sequence"].as_str().unwrap();
            let mine = scores.iter().find(|r| r["method"] == method && r["sequence"] == name).unwrap();
            let listed = explain(&["small/frames", "auroc", method, "--sequence", name]);
            for (counted, outcome) in [("tp", "hit"), ("fp", "false alarm"), ("fn", "missed")] {
                let sum: u64 = if method == "nab" {
                    listed.iter().filter(|r| r["outcome"] == outcome).count() as u64
                } else {
                    let stretches = listed.iter().filter(|r| r["counts as"] == counted);
                    stretches.map(|r| r["frames"].as_u64().unwrap()).sum()
                };
                assert_eq!(sum.to_string(), mine[counted], "{method} {name} {counted}");
            }
            // A sequence with a loss has an area of its own, and without it there is another one.
            assert!(part["without"].as_f64().is_some_and(|v| (0.0..=1.0).contains(&v)), "{part}");
        }
    }
}

/// Results of a program that did not have these measures.
#[test]
fn results_without_the_file_are_read() {
    let root = tempfile::tempdir().unwrap();
    let root = root.path();
    run(root);
    let manifest = root.join("results/small/manifest.json");
    let mut read: Value = serde_json::from_slice(&std::fs::read(&manifest).unwrap()).unwrap();
    assert!(read["files"].as_object_mut().unwrap().remove("frame_measures.csv").is_some());
    std::fs::write(&manifest, serde_json::to_vec(&read).unwrap()).unwrap();
    std::fs::remove_file(root.join("results/small/frame_measures.csv")).unwrap();
    trackfail().current_dir(root).args(["report", "small"]).assert().success();
    let table = rows(&std::fs::read_to_string(root.join("results/small/tables/frames.csv")).unwrap());
    let ours =
        |row: &str| table.iter().find(|r| r["row"] == row && r["column"] == "level").unwrap()["ours"].clone();
    assert_eq!(ours("auroc"), "");
    assert_ne!(ours("f_score"), "");
}

/// Analyses that read a signal and the regions of the same tracks.
#[test]
fn trackers_are_scored_over_a_confidence() {
    let root = tempfile::tempdir().unwrap();
    let root = root.path();
    let part = |name: &str, rules: &str| {
        format!(
            "[[analysis]]\nname = \"{name}\"\nsuites = [\"test\"]\nsignal = {{ kind = \"rgb-histogram\" }}\n\
             compute = {{ kind = \"longterm\", rules = \"longterm/{rules}/1\" }}\n\
             [[table]]\nname = \"{name}\"\nshows = \"{name}.overall\"\n"
        )
    };
    let claim = "[[claim]]\ntext = \"F lies between\"\nholds = \"finding[vot.lt_f] > 0 && finding[pysot.lt_f] < 1\"\nrequired = true\n";
    let head = "schema = 1\nname = \"small\"\ntitle = \"t\"\n[suites]\ntest = \"synthetic-otb\"\n[[tracker]]\nname = \"ncc\"\n";
    let spec =
        [head, &part("vot", "vot-toolkit"), &part("pysot", "pysot"), &part("all", "pytracking"), claim]
            .concat();
    std::fs::write(root.join("a.toml"), &spec).unwrap();
    trackfail().current_dir(root).args(["run", "a.toml", "-q"]).assert().success();
    let f = |name: &str| {
        let table = rows(&read(root, &format!("tables/{name}.csv")));
        number(table.iter().find(|r| r["column"] == "F").unwrap(), "ours")
    };
    assert!([f("vot"), f("pysot"), f("all")].iter().all(|f| (0.0..=1.0).contains(f)));
    assert_ne!(f("vot"), f("all"));
    let without = spec.replace("signal = { kind = \"rgb-histogram\" }\n", "");
    std::fs::write(root.join("a.toml"), without).unwrap();
    trackfail().current_dir(root).args(["run", "a.toml", "-q"]).assert().code(2);
}

// The oracle finds every loss: the difference to a method is what that method lacks.
#[test]
fn methods_of_a_leaderboard_are_compared_on_the_same_tracks_and_compact_results_have_no_frames() {
    let root = tempfile::tempdir().unwrap();
    let root = root.path();
    let spec = SPEC.replace("title = \"t\"", "title = \"t\"\nleaderboard = true");
    let families = "family = \"resting\"\n[[tracker]]\nname = \"still\"\nlabel = \"other\"\nfamily = \"others\"\n[[method]]";
    std::fs::write(root.join("a.toml"), spec.replacen("[[method]]", families, 1)).unwrap();
    trackfail().current_dir(root).args(["run", "a.toml", "-q"]).assert().success();
    let measures = rows(&read(root, "frame_measures.csv"));
    // A family of one tracker has that one's measures; one source alone is no pool of its own.
    let level = |tracker: &str| measures.iter().find(|r| r["method"] == "level" && r["tracker"] == tracker);
    assert_eq!(level("* others").unwrap()["auroc"], level("other").unwrap()["auroc"]);
    assert!(number(level("*").unwrap(), "losses") == 2.0 * number(level("* resting").unwrap(), "losses"));
    assert!(measures.iter().all(|row| !row["tracker"].contains(" on ")));
    let breakdown = read(root, "tables/breakdown.md");
    assert!(
        ["| all |", "| others |", "| resting |"].iter().all(|row| breakdown.contains(row)),
        "{breakdown}"
    );
    let all = |method: &str| measures.iter().find(|r| r["method"] == method && r["tracker"] == "*").unwrap();
    let pairs = rows(&read(root, "frame_pairs.csv"));
    assert!(pairs.iter().all(|r| r["method"] != "losses" && r["other"] != "losses"), "{pairs:?}");
    let pair = pairs.iter().find(|r| r["method"] == "level" && r["other"] == "oracle").unwrap();
    for measure in ["auroc", "found_at_5"] {
        let difference = number(pair, &format!("{measure}_difference"));
        let bounds = ["low", "high"].map(|end| number(pair, &format!("{measure}_difference_{end}")));
        assert!((difference - (number(all("level"), measure) - 1.0)).abs() < 1e-12, "{pair:?}");
        assert!(bounds[0] <= difference && difference <= bounds[1] && bounds[1] <= 0.0, "{pair:?}");
    }
    // `compare` has the numbers of the tables, of one experiment and of two.
    let compare = |words: &[&str]| {
        let mut command = trackfail();
        command.current_dir(root).arg("compare").args(words).args(["--in", "small", "--format", "csv"]);
        String::from_utf8(command.output().unwrap().stdout).unwrap()
    };
    let auroc = rows(&compare(&["level", "oracle", "--metric", "auroc"]));
    assert_eq!(number(&auroc[0], "A - B"), number(pair, "auroc_difference"));
    assert_eq!(number(&auroc[0], "95% from"), number(pair, "auroc_difference_low"));
    let pooled = rows(&compare(&["level", "oracle", "--metric", "pooled f_score", "--tracker", "other"]));
    let counted = rows(&read(root, "measures.csv"));
    for (side, method) in [("A", "level"), ("B", "oracle")] {
        let mine = counted.iter().find(|r| r["method"] == method && r["tracker"] == "other").unwrap();
        assert_eq!(number(&pooled[0], side), number(mine, "f_score"), "{method}");
    }
    assert!(number(&pooled[0], "95% from") <= number(&pooled[0], "A - B"), "{pooled:?}");
    let twice = rows(&compare(&["level", "level", "--in", "small", "--metric", "f_score"]));
    assert_eq!(number(&twice[0], "A - B"), 0.0);
    let differences = read(root, "tables/differences.md");
    assert!(differences.contains("| level |") && !differences.contains("| oracle |"), "{differences}");
    let [board, scores] = ["tables/board.csv", "scores.csv"].map(|name| read(root, name));
    trackfail().current_dir(root).args(["run", "a.toml", "-q", "--compact"]).assert().success();
    let there = |name: &str| root.join("results/small").join(name).exists();
    for name in ["frames.parquet", "signals.parquet", "truth.parquet", "models"] {
        assert!(!there(name), "{name}");
    }
    assert_eq!(read(root, "tables/board.csv"), board);
    assert!(!there("scores.csv"));
    let packed = results::Results::read(&root.join("results/small")).unwrap().scores().unwrap();
    assert_eq!(packed, results::scores::read(scores.into_bytes()).unwrap());
    assert_eq!(read(root, "tables/differences.md"), differences);
    trackfail().current_dir(root).arg("report").assert().success();
    let page = std::fs::read_to_string(root.join("reports/small/index.html")).unwrap();
    assert!(page.contains("level") && !page.contains("id=\"sequences\""));
}
