//! Methods that learn, methods of some trackers only, repetitions, and analyses.

use crate::tools::{assert_same_files, rows, trackfail};
use std::path::Path;
use std::process::Output;

const SPEC: &str = r#"schema = 1
name = "mine/learning"
title = "A try"
protocol = "sanmiguel2015/1"
seed = 7

[suites]
test = "synthetic-d1"
train = "synthetic-d1"

[[tracker]]
name = "color-particle-filter"
label = "PF"
particles = 20
runs = 2
training_runs = 3

[[tracker]]
name = "still"

[[method]]
name = "AVU"
trackers = ["PF"]
grid = { length = [1, 5, 20] }

[[method]]
name = "normal"
trackers = ["PF"]
signal = { kind = "uncertainty-change", settling = 25 }
detector = { kind = "accumulated-validation", length = 5, train = "train", approximation = "normal" }

[[method]]
name = "EmpTh"
trackers = ["PF"]

[[method]]
name = "RgbHist"
trackers = ["still"]
protocol = "khalid2016/1"

[[analysis]]
name = "sums"
signal = { kind = "uncertainty-change" }
compute = { kind = "cut-values", lengths = [1, 5], shown_lengths = [1, 5, 20] }
suites = ["train"]
trackers = ["PF"]

[[table]]
name = "f"
rows = ["length"]
columns = "method"
metric = "f_score"
methods = ["AVU", "normal", "EmpTh"]

[[table]]
name = "cuts"
shows = "sums.cuts"

[[figure]]
name = "sweep"
kind = "sweep"
metric = "f_score"
x = "length"
methods = ["AVU", "EmpTh"]

[[figure]]
name = "cuts"
kind = "chart"
shows = "sums.cuts-1"

[[claim]]
text = "the convolution is nearer"
holds = "finding[sums.deviation-convolution] < finding[sums.deviation-clt]"
"#;

fn run(folder: &Path, more: &[&str]) -> Output {
    run_spec(SPEC, folder, more)
}

fn run_spec(text: &str, folder: &Path, more: &[&str]) -> Output {
    let spec = folder.join("learning.toml");
    std::fs::write(&spec, text).unwrap();
    let mut command = trackfail();
    command.arg("run").arg(&spec).args(more);
    command.arg("--results").arg(folder.join("results")).arg("--reports").arg(folder.join("reports"));
    command.output().unwrap()
}

fn told(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

#[test]
fn models_are_learned_once_and_the_same_for_any_number_of_threads() {
    let (one, two) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
    let first = run(one.path(), &["--jobs", "1"]);
    assert_eq!(first.status.code(), Some(0), "{}", told(&first));
    run(two.path(), &["--jobs", "2"]);
    assert_same_files(one.path(), two.path());

    // 18 sequences, 3 runs of training data, and one run of the other tracker.
    let text = told(&first);
    assert!(text.contains("tracks 72 computed, 0 cached"), "{text}");
    // AVU's three lengths and `normal` share a model; then a threshold and an analysis.
    assert!(text.contains("models 3 computed, 0 cached"), "{text}");
    let again = told(&run(one.path(), &["--jobs", "1"]));
    assert!(again.contains("tracks 0 computed, 72 cached"), "{again}");
    assert!(again.contains("models 0 computed, 3 cached"), "{again}");

    let folder = one.path().join("results/mine/learning");
    let scores = rows(&std::fs::read_to_string(folder.join("scores.csv")).unwrap());
    let cells = |method: &str| {
        scores.iter().filter(|r| r["method"] == method && r["sequence"] != "*").collect::<Vec<_>>()
    };
    assert_eq!(cells("AVU").len(), 18 * 2 * 3);
    assert!(cells("AVU").iter().all(|r| r["tracker"] == "PF" && r["status"] == "ok"));
    assert_eq!(cells("RgbHist").len(), 18);
    assert!(cells("RgbHist").iter().all(|r| r["tracker"] == "still"));

    let models: Vec<_> =
        std::fs::read_dir(folder.join("models")).unwrap().map(|e| e.unwrap().path()).collect();
    assert_eq!(models.len(), 5);
    // One model, with the cut value of each length.
    let cut = |length: usize| {
        let end = format!("-avu-length-{length}-pf.json");
        let path = models.iter().find(|p| p.to_string_lossy().ends_with(&end)).unwrap();
        let model: serde_json::Value = serde_json::from_slice(&std::fs::read(path).unwrap()).unwrap();
        assert_eq!(model["params"], format!("length={length}"));
        model["threshold"].as_f64().unwrap()
    };
    assert!(0.0 < cut(1) && cut(1) < cut(5) && cut(5) < cut(20), "{} {} {}", cut(1), cut(5), cut(20));
    let model = models.iter().find(|p| p.to_string_lossy().contains("avu")).unwrap();
    let model: serde_json::Value = serde_json::from_slice(&std::fs::read(model).unwrap()).unwrap();
    assert_eq!(model["runs"], 3);
    assert_eq!(model["tuned_on_test"], true);
    assert!(model["threshold"].as_f64().unwrap() > 0.0);
    let weights = model["model"]["consistency"]["mixture"]["components"].as_array().unwrap().iter();
    let total: f64 = weights.map(|c| c["weight"].as_f64().unwrap()).sum();
    assert!((total - 1.0).abs() < 1e-6);
}

#[test]
fn a_reduced_number_of_runs_is_noted_in_every_table() {
    let dir = tempfile::tempdir().unwrap();
    let exported = dir.path().join("exported");
    run(dir.path(), &["--runs", "1", "--export-tracks", exported.to_str().unwrap()]);
    // The filter's regions are polygons, its first one is the annotation: all lines are boxes.
    for tracker in ["PF", "still"] {
        let files: Vec<_> = std::fs::read_dir(exported.join(tracker)).unwrap().collect();
        assert_eq!(files.len(), 18);
        for file in files {
            let text = std::fs::read_to_string(file.unwrap().path()).unwrap();
            assert!(
                text.lines().count() > 9 && text.lines().all(|line| line.split(',').count() == 4),
                "{text}"
            );
        }
    }
    let tables = dir.path().join("results/mine/learning/tables");
    for name in ["f.md", "cuts.md"] {
        let table = std::fs::read_to_string(tables.join(name)).unwrap();
        assert!(
            table.contains("PF: 1 run of 2") && table.contains("PF: 1 run of 3 to learn from"),
            "{table}"
        );
    }
    let report = std::fs::read_to_string(dir.path().join("reports/mine/learning/report.md")).unwrap();
    assert!(report.contains("was tuned on the test suite itself"), "{report}");
}

#[test]
fn a_signal_of_the_posterior_is_not_run_on_a_tracker_without_one() {
    let dir = tempfile::tempdir().unwrap();
    let spec = dir.path().join("none.toml");
    let text = "schema = 1\nname = \"none\"\ntitle = \"None\"\nprotocol = \"sanmiguel2015/1\"\n[suites]\n\
                test = \"synthetic-vot\"\n[[tracker]]\nname = \"still\"\n[[method]]\nname = \"M-model\"\n";
    std::fs::write(&spec, text).unwrap();
    let mut command = trackfail();
    command.arg("run").arg(&spec).arg("--results").arg(dir.path().join("r")).arg("--reports").arg(dir.path());
    let output = command.output().unwrap();
    assert_eq!(output.status.code(), Some(0), "{}", told(&output));
    let said = String::from_utf8_lossy(&output.stdout);
    let line = "M-model was not run on still (9 cells): it needs a tracker that gives its posterior";
    assert!(said.contains(line), "{said}");
}

const OTHERS: &str = r#"schema = 1
name = "mine/others"
title = "A try"
protocol = "khalid2016/1"
seed = 7

[suites]
test = "synthetic-d1"

[[tracker]]
name = "still"

[[tracker]]
name = "ncc"

[[tracker]]
name = "ncc"
label = "NCC that learns"
update_rate = 0.1

[[method]]
name = "companions"
signal = { kind = "companion-overlap" }
detector = { kind = "level", below = { train = "others", maximise = "f_score", grid = { from = 0.1, to = 0.9, step = 0.2 } } }

[[method]]
name = "jumps"
signal = { kind = "box-motion" }
detector = { kind = "level", above = { train = "others", maximise = "f_score", grid = { quantiles = 5 } } }

[[method]]
name = "joint"
signal = [{ kind = "companion-overlap" }, { kind = "companion-overlap", statistic = "share" }]
detector = { kind = "joint-drop", below = [0.5, 0.5] }

[[table]]
name = "f"
rows = ["f_score", "tp"]
columns = "method"
"#;

#[test]
fn thresholds_come_from_other_videos_and_trackers_the_same_for_threads_and_shards() {
    let place = |name: &str| (name.to_string(), tempfile::tempdir().unwrap());
    let [one, two, shards] = ["one", "two", "shards"].map(place);
    let first = run_spec(OTHERS, one.1.path(), &["--jobs", "1"]);
    assert_eq!(first.status.code(), Some(0), "{}", told(&first));
    run_spec(OTHERS, two.1.path(), &["--jobs", "2"]);
    for shard in ["2/2", "1/2"] {
        assert!(run_spec(OTHERS, shards.1.path(), &["--shard", shard]).status.success());
    }
    assert!(told(&run_spec(OTHERS, shards.1.path(), &[])).contains("tracks 0 computed, 54 cached"));
    assert_same_files(one.1.path(), two.1.path());
    assert_same_files(&one.1.path().join("results/mine"), &shards.1.path().join("results/mine"));

    let folder = one.1.path().join("results/mine/others");
    let models: Vec<_> =
        std::fs::read_dir(folder.join("models")).unwrap().map(|e| e.unwrap().path()).collect();
    assert_eq!(models.len(), 2 * 3);
    for path in models {
        let model: serde_json::Value = serde_json::from_slice(&std::fs::read(path).unwrap()).unwrap();
        assert_eq!(model["tuned_on_test"], false);
        let folds = model["folds"].as_array().unwrap();
        assert!(folds.iter().all(|fold| fold["value"].is_number()), "{folds:?}");
        let names = folds.iter().flat_map(|fold| fold["left_out"].as_array().unwrap());
        let mut names: Vec<&str> = names.map(|name| name.as_str().unwrap()).collect();
        names.sort_unstable();
        names.dedup();
        assert_eq!((folds.len(), names.len()), (10, 18));
    }
    let table = std::fs::read_to_string(folder.join("tables/f.md")).unwrap();
    assert!(table.contains("companions, jumps: learned from other videos and other trackers"), "{table}");

    let compact = run_spec(OTHERS, one.1.path(), &["--compact"]);
    assert_eq!(compact.status.code(), Some(0), "{}", told(&compact));
    assert!(!folder.join("models").exists());
}

#[test]
fn a_detector_is_given_as_many_signals_as_it_reads() {
    let dir = tempfile::tempdir().unwrap();
    let text = OTHERS.replace("below = [0.5, 0.5]", "below = [0.5]");
    let output = run_spec(&text, dir.path(), &[]);
    assert_eq!(output.status.code(), Some(2));
    let message = told(&output);
    assert!(message.contains("method `joint` reads 1 signals, and 2 are given"), "{message}");
}
