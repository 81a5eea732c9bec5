//! Time and memory of large inputs, at 1/8, 1/4, 1/2 and all of them, each in a process of its own.
//!
//! - `boxes`: 280 sequences of 2500 frames with the result files of 8 trackers, 5.6 million boxes, scored, pooled, tabled
//!   and reported into an empty folder. There are no pixels, and the digests of the sequences are known.
//! - `cells`: an experiment of 1,000,000 cells, laid out and looked up in an empty store.
//!
//! Where twice the input costs much more than twice the time, something is superlinear.

use std::collections::BTreeMap;
use std::fmt::Write;
use std::path::Path;
use std::process::Command;
use std::sync::Arc;
use std::time::Instant;
use trackfail::dataset::suite::{Catalog, Loaded};
use trackfail::dataset::user_frames::without_frames;
use trackfail::dataset::{Frames, Sequence};
use trackfail::engine::store::Store;
use trackfail::engine::{ExperimentPlan, Options, Stop, run};
use trackfail::image::Frame;
use trackfail::region::{Rect, Region};
use trackfail::report;
use trackfail::results::{self, Detail, Results, RunRecord};
use trackfail::spec;
use trackfail_benches::many_cells;

const SEQUENCES: usize = 280;
const FRAMES: usize = 2500;
const TRACKERS: usize = 8;
/// Runs of the tracker of `cells`, see [`many_cells`].
const RUNS: usize = 500;

/// A suite must be known by name; its sequences are made here.
const SUITE: &str = r#"schema = 2
suite = [{ name = "boxes", title = "Boxes alone", format = "otb", source = "", licence = "", sequence = [
    { name = "q000", folder = "boxes/q000" },
], how_to_get = "" }]
"#;

const BOXES: &str = r#"
schema = 1
name = "boxes"
title = "Boxes alone"
protocol = "khalid2016/1"
suites.test = "boxes"
tracker = [TRACKERS]
method = [
    { name = "periodic", detector = { kind = "periodic", period = 25 } },
    { name = "random", detector = { kind = "random", rate = 0.04 } },
]
analysis = [{ name = "ope", compute = { kind = "success", rules = "otb-matlab/1" }, suites = ["test"] }]
table = [
    { name = "overall", shows = "ope.overall" },
    { name = "sequences", shows = "ope.sequences", column = "success AUC" },
    { name = "methods", rows = ["precision", "recall", "f_score", "tp", "fp", "fn"], columns = "method" },
]
figure = [{ name = "success", kind = "chart", shows = "ope.success" }]
"#;

/// Whole numbers below `below` without an order to be seen, the same every time.
fn noise(seed: usize) -> impl FnMut(u64) -> f64 {
    let mut state = seed as u64 * 0x9e37_79b9_7f4a_7c15 + 1;
    move |below| {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        ((state >> 33) % below) as f64
    }
}

/// A target that wanders through a picture of 640 x 480 pixels.
fn sequence(s: usize) -> Sequence {
    let mut number = noise(s);
    let (mut x, mut y) = (300.0, 200.0);
    let mut next = || {
        x = f64::clamp(x + number(13) - 6.0, 0.0, 560.0);
        y = f64::clamp(y + number(13) - 6.0, 0.0, 400.0);
        Some(Region::Rect(Rect::new(x, y, 60.0 + number(9), 50.0 + number(9))))
    };
    Sequence {
        truth: (0..FRAMES).map(|_| next()).collect(),
        attributes: ["OCC", "SV", "FM"][..s % 4].iter().map(ToString::to_string).collect(),
        digest: format!("{s:064x}").into(),
        frames: Frames::Rendered(Arc::new(|_: usize| Frame::from_fn(1, 1, |_, _| [0; 3])), FRAMES),
        ..without_frames(&format!("q{s:03}"), FRAMES)
    }
}

/// Writes the boxes of a tracker: near the target, and off it for 60 frames out of 500.
fn write_track(root: &Path, tracker: usize, sequence: &Sequence, seed: usize) {
    let folder = root.join(format!("results/T{tracker}"));
    std::fs::create_dir_all(&folder).expect("a folder");
    let mut number = noise(seed);
    let mut text = String::new();
    for (t, truth) in sequence.truth.iter().enumerate() {
        let truth = truth.as_ref().map_or(Rect::new(0.0, 0.0, 9.0, 9.0), Region::rect);
        let off = if (t + 37 * seed) % 500 > 440 { 90.0 } else { 0.0 };
        let near = |v: f64, by: f64| v + 1.0 + by / 100.0;
        let (x, y) = (near(truth.x + off, number(1000)), near(truth.y + off, number(1000)));
        writeln!(text, "{x:.2},{y:.2},{:.2},{:.2}", truth.w, truth.h + number(500) / 100.0).expect("text");
    }
    std::fs::write(folder.join(format!("{}.txt", sequence.name)), text).expect("a file");
}

/// Seconds of each stage, from result files to a report.
fn boxes(sequences: usize) -> Vec<(&'static str, f64)> {
    let dir = tempfile::tempdir().expect("a folder");
    let root = dir.path();
    let loaded: Vec<Sequence> = (0..sequences).map(sequence).collect();
    for tracker in 0..TRACKERS {
        loaded.iter().enumerate().for_each(|(s, q)| write_track(root, tracker, q, s * TRACKERS + tracker));
    }
    let tracker = |k: usize| format!("{{ name = \"replay\", results = \"T{k}\", label = \"T{k}\" }},");
    let text = BOXES.replace("TRACKERS", &(0..TRACKERS).map(tracker).collect::<String>());
    let mut catalog = Catalog::default();
    catalog.add_file(Path::new("datasets.lock"), SUITE.as_bytes()).expect("a suite");
    let experiment = spec::parse_with("boxes", &text, &catalog, None).expect("a valid experiment");

    let mut clock = Clock::start();
    let suite = Loaded { wanted: loaded.len(), sequences: loaded, ..Loaded::default() };
    let roots = [root.to_path_buf()];
    let suites = BTreeMap::from([("test".to_string(), suite)]);
    let plan = ExperimentPlan::new(&experiment, suites, &roots, &Stop::default()).expect("a plan");
    clock.lap("plan");
    let store = Store::open(&root.join("out")).expect("a store");
    let options = Options { data_roots: roots.to_vec(), ..Options::default() };
    let outcome = run::run(&plan, &store, &options).expect("cells");
    assert!(outcome.cells.iter().all(|c| c.result.is_ok()), "cells failed");
    clock.lap("run");
    let folder = root.join("out/boxes");
    results::write(&folder, &experiment, &outcome, &RunRecord::here(None, 0.0), Detail::Frames)
        .expect("written");
    drop(outcome);
    drop((store, plan));
    clock.lap("write");
    report::write(&Results::read(&folder).expect("results"), &folder.join("report")).expect("a report");
    clock.lap("report");
    clock.0
}

/// Seconds of laying out and of looking up the cells of some runs.
fn cells(runs: usize) -> Vec<(&'static str, f64)> {
    let experiment = many_cells(runs);
    let dir = tempfile::tempdir().expect("a folder");
    let store = Store::open(dir.path()).expect("a store");
    let mut clock = Clock::start();
    let suites = run::load(&experiment, &[]).expect("suites");
    let plan = ExperimentPlan::new(&experiment, suites, &[], &Stop::default()).expect("a plan");
    clock.lap("plan");
    assert_eq!(plan.states(&store).len(), 20 * 100 * runs);
    clock.lap("look up");
    clock.0
}

struct Clock(Vec<(&'static str, f64)>, Instant);

impl Clock {
    fn start() -> Self {
        Self(Vec::new(), Instant::now())
    }

    fn lap(&mut self, what: &'static str) {
        self.0.push((what, self.1.elapsed().as_secs_f64()));
        self.1 = Instant::now();
    }
}

/// A number of this process's status in Linux, in KiB.
fn status(name: &str) -> Option<f64> {
    let text = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = text.lines().find_map(|line| line.strip_prefix(name))?;
    line.trim_start_matches(':').split_whitespace().next()?.parse().ok()
}

fn main() {
    let words: Vec<String> = std::env::args().skip(1).filter(|a| a != "--bench").collect();
    if let [what, size] = words.as_slice()
        && let Ok(size) = size.parse()
    {
        let laps = if what == "boxes" { boxes(size) } else { cells(size) };
        let total: f64 = laps.iter().map(|(_, s)| s).sum();
        let laps: Vec<String> = laps.iter().map(|(lap, s)| format!("{lap} {s:.2}")).collect();
        let memory = status("VmHWM").map_or("-".to_string(), |kib| format!("{:.0} MiB", kib / 1024.0));
        println!("{what:<6} {size:>5} {total:>8.2} s {memory:>9}   {}", laps.join(", "));
        return;
    }
    let own = std::env::current_exe().expect("this program");
    for (what, all) in [("boxes", SEQUENCES), ("cells", RUNS)] {
        if words.first().is_some_and(|wanted| wanted != what) {
            continue;
        }
        for part in [8, 4, 2, 1] {
            let size = (all / part).to_string();
            let status = Command::new(&own).args([what, &size]).status().expect("this program runs");
            assert!(status.success(), "{what} {size} failed");
        }
    }
}
