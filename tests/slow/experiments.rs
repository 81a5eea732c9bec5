//! The papers' experiments that need no data.

use crate::tools::{Place, Row, assert_same_files};
use trackfail::detector::track_quality::machine::TRANSITIONS;

/// The model that comes with the program is what its experiment learns.
#[test]
fn the_built_in_model_is_that_of_its_experiment() {
    let place = Place::new();
    place.run("run sanmiguel2015/built-in-model --quiet").ends(0);
    let learned = place.read("results/sanmiguel2015/built-in-model/models/001-avu-pf.json");
    assert_eq!(learned, own("assets/models/color-particle-filter.json"));
}

/// A file of the checkout.
fn own(name: &str) -> String {
    std::fs::read_to_string(std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join(name)).unwrap()
}

#[test]
fn the_papers_figure_and_the_state_diagram_are_the_same_with_one_and_two_threads() {
    let (one, two) = (Place::new(), Place::new());
    for (place, jobs) in [(&one, 1), (&two, 2)] {
        place.run(&format!("run sanmiguel2015/fig15 --runs 1 --jobs {jobs} --quiet")).ends(0);
    }
    assert_same_files(one.root(), two.root());
    let results = "results/sanmiguel2015/fig15";
    let header = "suite,sequence,tracker,run,method,params,frame,reference,error,accepted";
    assert_eq!(one.read(&format!("{results}/checks.csv")).lines().next().unwrap(), header);
    let listed = one.rows(&format!("{results}/checks.csv"));
    // Every run backwards that is counted is listed.
    let measures = one.rows(&format!("{results}/measures.csv"));
    for method in ["ARTE", "ARTE*"] {
        let row = measures.iter().find(|r| r["method"] == method).unwrap();
        let mine = || listed.iter().filter(|r| r["method"] == method && !r["error"].is_empty());
        assert_eq!(row["reverse_runs"].parse::<usize>().unwrap(), mine().count());
        let frames = |r: &Row| r["frame"].parse::<i64>().unwrap() - r["reference"].parse::<i64>().unwrap();
        assert_eq!(row["reverse_frames"].parse::<i64>().unwrap(), mine().map(frames).sum::<i64>());
    }
    let diagram = one.read("reports/sanmiguel2015/fig15/figures/machine.svg");
    for row in TRANSITIONS {
        assert!(diagram.contains(row.on.name()) && diagram.contains(row.from.name()), "{row:?}");
    }
}

/// Times differ, but they are there, and what is counted beside them does not.
#[test]
fn times_are_told_by_stage() {
    let text = own("experiments/sanmiguel2015/table5.toml").replace("repeats = 5", "repeats = 1");
    let place = Place::with(&[("table5.toml", &text)]);
    place.run("run table5.toml --runs 1 --quiet").ends(0);
    let results = "results/sanmiguel2015/table5";
    let table = place.read(&format!("{results}/tables/table5.csv"));
    for stage in ["signal", "detection", "reverse tracking", "total", "tracking", "reverse runs"] {
        assert!(table.contains(stage), "{stage}: {table}");
    }
    let measures = place.rows(&format!("{results}/measures.csv"));
    let runs: Vec<f64> = measures.iter().map(|r| r["reverse_runs"].parse().unwrap()).collect();
    let manifest = place.json(&format!("{results}/manifest.json"));
    let present = manifest["suite"]["present"].as_array().unwrap();
    let frames: u64 = present.iter().map(|s| s[1].as_u64().unwrap()).sum();
    let counts = table.lines().filter_map(|line| line.split_once("reverse runs,")?.1.split(',').nth(1));
    let shown: Vec<f64> = counts.filter_map(|count| count.parse().ok()).collect();
    for (runs, shown) in runs.iter().zip(&shown) {
        assert!((1000.0 * runs / frames as f64 - shown).abs() < 0.01, "{runs} in {frames} frames: {shown}");
    }
    // ARTE, ARTE* and five anchors; times are of the first two.
    assert_eq!((runs.len(), shown.len()), (7, 2));
}
