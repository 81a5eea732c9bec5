//! Methods that learn, methods of some trackers only, repetitions, and analyses.

use crate::tools::{Place, Ran, Row, assert_same_files, assert_says, experiment, files};
use serde_json::Value;
use std::collections::BTreeSet;
use std::path::PathBuf;

const SPEC: &str = r#"schema = 1
name = "mine/learning"
title = "A try"
protocol = "sanmiguel2015/1"
seed = 7
suites = { test = "synthetic-d1", train = "synthetic-d1" }
tracker = [
    { name = "color-particle-filter", label = "PF", particles = 20, runs = 2, training_runs = 3 },
    { name = "still" },
]
table = [
    { name = "f", rows = ["length"], columns = "method", metric = "f_score", methods = ["AVU", "normal", "EmpTh"] },
    { name = "cuts", shows = "sums.cuts" },
]
figure = [
    { name = "sweep", kind = "sweep", metric = "f_score", x = "length", methods = ["AVU", "EmpTh"] },
    { name = "cuts", kind = "chart", shows = "sums.cuts-1" },
]
method = [
    { name = "AVU", trackers = ["PF"], grid = { length = [1, 5, 20] } },
    { name = "normal", trackers = ["PF"], signal = { kind = "uncertainty-change", settling = 25 }, detector = { kind = "accumulated-validation", length = 5, train = "train", approximation = "normal" } },
    { name = "EmpTh", trackers = ["PF"] },
    { name = "RgbHist", trackers = ["still"], protocol = "khalid2016/1" },
]
claim = [
    { text = "the convolution is nearer", holds = "finding[sums.deviation-convolution] < finding[sums.deviation-clt]" },
]
analysis = [
    { name = "sums", compute = { kind = "cut-values", lengths = [1, 5], shown_lengths = [1, 5, 20] }, signal.kind = "uncertainty-change", suites = ["train"], trackers = ["PF"] },
]
"#;

fn run(place: &Place, spec: &str, more: &str) -> Ran {
    place.write("learning.toml", spec);
    place.run(&format!("run learning.toml {more}"))
}

/// The models of an experiment, by the names of their files.
fn models(place: &Place, experiment: &str) -> Vec<(String, Value)> {
    let read = |path: PathBuf| {
        let model: Value = serde_json::from_slice(&std::fs::read(&path).unwrap()).unwrap();
        (path.display().to_string(), model)
    };
    place.list(&format!("results/mine/{experiment}/models")).into_iter().map(read).collect()
}

#[test]
fn models_are_learned_once_and_the_same_for_any_number_of_threads() {
    let (one, two) = (Place::new(), Place::new());
    // 18 sequences, 3 runs of training data, and one run of the other tracker; AVU's three lengths and `normal` share a
    // model; then a threshold and an analysis.
    let first = run(&one, SPEC, "--jobs 1").ends(0).tells("tracks 72 computed, 0 cached");
    first.tells("models 3 computed, 0 cached");
    run(&two, SPEC, "--jobs 2");
    assert_same_files(one.root(), two.root());
    run(&one, SPEC, "--jobs 1").tells("tracks 0 computed, 72 cached").tells("models 0 computed, 3 cached");

    let scores = one.rows("results/mine/learning/scores.csv");
    for (method, tracker, count) in [("AVU", "PF", 18 * 2 * 3), ("RgbHist", "still", 18)] {
        let is_cell = |r: &&Row| r["method"] == method && r["sequence"] != "*";
        let cells: Vec<_> = scores.iter().filter(is_cell).collect();
        assert_eq!(cells.len(), count, "{method}");
        assert!(cells.iter().all(|r| r["tracker"] == tracker && r["status"] == "ok"), "{method}");
    }

    let models = models(&one, "learning");
    assert_eq!(models.len(), 5);
    // One model, with the cut value of each length.
    let cut = |length: usize| {
        let end = format!("-avu-length-{length}-pf.json");
        let model = &models.iter().find(|(name, _)| name.ends_with(&end)).unwrap().1;
        assert_eq!(model["params"], format!("length={length}"));
        model["threshold"].as_f64().unwrap()
    };
    assert!(0.0 < cut(1) && cut(1) < cut(5) && cut(5) < cut(20), "{} {} {}", cut(1), cut(5), cut(20));
    let model = &models.iter().find(|(name, _)| name.contains("avu")).unwrap().1;
    assert_eq!((&model["runs"], &model["tuned_on_test"]), (&3.into(), &true.into()));
}

#[test]
fn a_reduced_number_of_runs_is_noted_in_every_table() {
    let place = Place::new();
    run(&place, SPEC, "--runs 1 --export-tracks exported").ends(0);
    // The filter's regions are polygons, its first one is the annotation: all lines are boxes.
    for tracker in ["PF", "still"] {
        let files = files(&place.path(&format!("exported/{tracker}")));
        assert_eq!(files.len(), 18);
        let boxes = files.values().flat_map(|text| str::from_utf8(text).unwrap().lines());
        assert!(boxes.clone().count() > 18 * 9 && boxes.clone().all(|line| line.split(',').count() == 4));
    }
    for name in ["f.md", "cuts.md"] {
        let notes = ["PF: 1 run of 2", "PF: 1 run of 3 to learn from"];
        place.holds(&format!("results/mine/learning/tables/{name}"), &notes, &[]);
    }
    assert_says(place.read("reports/mine/learning/report.md"), "was tuned on the test suite itself");
}

const OTHERS: &str = r#"seed = 7
tracker = [{ name = "still" }, { name = "ncc" }, { name = "ncc", label = "NCC that looks near", search = 0.5 }]
table = [{ name = "f", rows = ["f_score", "tp"], columns = "method" }]
method = [
    { name = "companions", signal.kind = "companion-overlap", detector = { kind = "level", below = { train = "others", maximise = "f_score", grid = { from = 0.1, to = 0.9, step = 0.2 } } } },
    { name = "jumps", signal.kind = "box-motion", detector = { kind = "level", above = { train = "others", maximise = "f_score", grid = { quantiles = 5 } } } },
    { name = "joint", signal = [{ kind = "companion-overlap" }, { kind = "companion-overlap", statistic = "share" }], detector = { kind = "joint-drop", below = [0.5, 0.5] } },
]
"#;

#[test]
fn thresholds_come_from_other_videos_and_trackers_the_same_for_threads_and_shards() {
    let (one, two, shards) = (Place::new(), Place::new(), Place::new());
    let others = experiment("mine/others", "synthetic-d1", OTHERS);
    run(&one, &others, "--jobs 1").ends(0);
    run(&two, &others, "--jobs 2");
    ["--shard 2/2", "--shard 1/2"].into_iter().for_each(|share| drop(run(&shards, &others, share).ends(0)));
    run(&shards, &others, "").tells("tracks 0 computed, 54 cached");
    assert_same_files(one.root(), two.root());
    assert_same_files(&one.path("results/mine"), &shards.path("results/mine"));

    let models = models(&one, "others");
    assert_eq!(models.len(), 2 * 3);
    for (_, model) in models {
        assert_eq!(model["tuned_on_test"], false);
        let folds = model["folds"].as_array().unwrap();
        assert!(folds.iter().all(|fold| fold["value"].is_number()), "{folds:?}");
        let names = folds.iter().flat_map(|fold| fold["left_out"].as_array().unwrap());
        let names: BTreeSet<&str> = names.map(|name| name.as_str().unwrap()).collect();
        assert_eq!((folds.len(), names.len()), (10, 18));
    }
    let table = one.read("results/mine/others/tables/f.md");
    assert_says(table, "companions, jumps: learned from other videos and other trackers");

    run(&one, &others, "--compact").ends(0);
    assert!(!one.has("results/mine/others/models"));
    // A detector is given as many signals as it reads.
    let text = others.replace("below = [0.5, 0.5]", "below = [0.5]");
    run(&one, &text, "").ends(2).tells("method `joint` reads 1 signals, and 2 are given");
}
