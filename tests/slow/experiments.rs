//! The papers' experiments that need no data.

use crate::tools::{assert_same_files, rows, trackfail};
use std::path::Path;
use trackfail::detector::track_quality::machine::TRANSITIONS;

/// The model that comes with the program is what its experiment learns.
#[test]
fn the_built_in_model_is_that_of_its_experiment() {
    let root = tempfile::tempdir().unwrap();
    let results = root.path().join("results");
    trackfail()
        .args(["run", "sanmiguel2015/built-in-model", "--quiet", "--results"])
        .arg(&results)
        .current_dir(root.path())
        .assert()
        .success();
    let learned = results.join("sanmiguel2015/built-in-model/models/001-avu-pf.json");
    let ours = Path::new(env!("CARGO_MANIFEST_DIR")).join("assets/models/color-particle-filter.json");
    assert_eq!(std::fs::read_to_string(learned).unwrap(), std::fs::read_to_string(ours).unwrap());
}

fn fig15(folder: &Path, jobs: &str) {
    let mut command = trackfail();
    command
        .args(["run", "sanmiguel2015/fig15", "--runs", "1", "--jobs", jobs, "--quiet"])
        .current_dir(folder);
    command.assert().success();
}

#[test]
fn the_papers_figure_and_the_state_diagram_are_the_same_with_one_and_two_threads() {
    let (one, two) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
    fig15(one.path(), "1");
    fig15(two.path(), "2");
    assert_same_files(one.path(), two.path());
    let results = one.path().join("results/sanmiguel2015/fig15");
    let checks = std::fs::read_to_string(results.join("checks.csv")).unwrap();
    let header = "suite,sequence,tracker,run,method,params,frame,reference,error,accepted";
    assert_eq!(checks.lines().next().unwrap(), header);
    // Every run backwards that is counted is listed.
    let measures = rows(&std::fs::read_to_string(results.join("measures.csv")).unwrap());
    for method in ["ARTE", "ARTE*"] {
        let row = measures.iter().find(|r| r["method"] == method).unwrap();
        let listed = rows(&checks);
        let mine = || listed.iter().filter(|r| r["method"] == method && !r["error"].is_empty());
        assert_eq!(row["reverse_runs"].parse::<usize>().unwrap(), mine().count());
        let frames = |r: &std::collections::BTreeMap<String, String>| {
            r["frame"].parse::<i64>().unwrap() - r["reference"].parse::<i64>().unwrap()
        };
        assert_eq!(row["reverse_frames"].parse::<i64>().unwrap(), mine().map(frames).sum::<i64>());
    }
    let diagram = one.path().join("reports/sanmiguel2015/fig15/figures/machine.svg");
    let diagram = std::fs::read_to_string(diagram).unwrap();
    for row in TRANSITIONS {
        assert!(diagram.contains(row.on.name()) && diagram.contains(row.from.name()), "{row:?}");
    }
}

/// Times differ, but they are there, and what is counted beside them does not.
#[test]
fn times_are_told_by_stage() {
    let folder = tempfile::tempdir().unwrap();
    let text = std::fs::read_to_string(
        Path::new(env!("CARGO_MANIFEST_DIR")).join("experiments/sanmiguel2015/table5.toml"),
    );
    let text = text.unwrap().replace("repeats = 5", "repeats = 1");
    std::fs::write(folder.path().join("table5.toml"), text).unwrap();
    let mut command = trackfail();
    command.args(["run", "table5.toml", "--runs", "1", "--quiet"]).current_dir(folder.path());
    command.assert().success();
    let tables = folder.path().join("results/sanmiguel2015/table5/tables");
    let table = std::fs::read_to_string(tables.join("table5.csv")).unwrap();
    for stage in ["signal", "detection", "reverse tracking", "total", "tracking", "reverse runs"] {
        assert!(table.contains(stage), "{stage}: {table}");
    }
    let measures = std::fs::read_to_string(tables.join("../measures.csv")).unwrap();
    let runs: Vec<f64> = rows(&measures).iter().map(|r| r["reverse_runs"].parse().unwrap()).collect();
    let frames = std::fs::read_to_string(tables.join("../manifest.json")).unwrap();
    let manifest: serde_json::Value = serde_json::from_str(&frames).unwrap();
    let present = manifest["suite"]["present"].as_array().unwrap();
    let frames: u64 = present.iter().map(|s| s[1].as_u64().unwrap()).sum();
    let shown: Vec<f64> = table
        .lines()
        .filter_map(|line| line.split_once("reverse runs,"))
        .filter_map(|(_, rest)| rest.split(',').nth(1)?.parse().ok())
        .collect();
    for (runs, shown) in runs.iter().zip(&shown) {
        assert!((1000.0 * runs / frames as f64 - shown).abs() < 0.01, "{runs} in {frames} frames: {shown}");
    }
    // ARTE, ARTE* and five anchors; times are of the first two.
    assert_eq!((runs.len(), shown.len()), (7, 2));
}
