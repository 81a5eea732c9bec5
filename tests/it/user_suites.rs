//! Sequences of the user's own: from a folder to a suite, an experiment, and its report.

use crate::tools::{Place, experiment, suite};

const FRAMES: usize = 30;

/// Two GOT-10k sequences whose target moves two pixels a frame, with three repetitions of a tracker that
/// loses it from frame 16 on in the second sequence.
fn data_root() -> Place {
    let place = Place::new();
    for (name, lost) in [("GOT-10k_Val_000001", FRAMES), ("GOT-10k_Val_000002", 15)] {
        let folder = format!("got/val/{name}");
        place.frames(&format!("{folder}/00000000.png"), FRAMES as u32, (96, 48), |t, x, y| {
            let inside = (2 * t..2 * t + 16).contains(&x) && (10..26).contains(&y);
            [x as u8, y as u8, if inside { 255 } else { 0 }]
        });
        let (mut truth, mut boxes) = (String::new(), String::new());
        for t in 0..FRAMES {
            // Pixels count from 1.
            truth += &format!("{}.0000,11.0000,16.0000,16.0000\n", 2 * t + 1);
            boxes += &format!("{:.3},11.000,16.000,16.000\n", if t < lost { 2 * t + 1 } else { 80 });
        }
        place.write(&format!("{folder}/groundtruth.txt"), truth);
        for run in 1..=3 {
            place.write(&format!("results/got/T/{name}/{name}_00{run}.txt"), &boxes);
        }
        place.write(&format!("results/got/T/{name}/{name}_time.txt"), "0.1,0.1,0.1\n");
    }
    place
}

const SPEC: &str = r#"tracker = [{ name = "replay", results = "got/T", label = "T", runs = 3 }]
method = [{ name = "CovF" }]
table = [{ name = "t", rows = ["recall", "events"], columns = "method" }]
"#;

const ADD: &str = "data add my-got got/val --format got10k --data-root .";

#[test]
fn a_folder_becomes_a_suite_an_experiment_and_a_report() {
    let place = data_root();
    place.write("spec.toml", experiment("mine/got", "my-got", SPEC));
    let run = |spec: &str| place.run(&format!("run {spec} --data-root . --results r"));
    run("spec.toml").ends(2).tells("unknown suite `my-got`");
    let added = place.run(ADD).ends(0);
    assert!(added.out.starts_with("my-got: 2 sequences, in "), "{}", added.out);
    place.run(ADD).ends(2).tells("my-got is in ");
    place.run("list suites --data-root .").says("my-got");
    let checked = place.run("data verify my-got --data-root .").ends(0).out;
    assert_eq!(checked.matches("  ok\n").count(), 2, "{checked}");
    place.run("data list my-got --data-root .").says("2 of 2 sequences are here");

    let ran = run("spec.toml").ends(0);
    assert!(!ran.err.contains("has a result of run"), "{}", ran.err);
    place.write("once.toml", experiment("mine/once", "my-got", &SPEC.replace("runs = 3", "runs = 2")));
    run("once.toml").ends(0).tells("warning: T: GOT-10k_Val_000001 has a result of run 3, but `runs` is 2");
    let mut events = place.rows("r/mine/got/scores.csv");
    events.retain(|r| r["method"] == "CovF" && r["sequence"] != "*");
    let lost = |name: &str| events.iter().filter(|r| r["sequence"] == name && r["events"] == "1").count();
    assert_eq!((lost("GOT-10k_Val_000001"), lost("GOT-10k_Val_000002"), events.len()), (0, 3, 6));

    // A changed sequence of one's own is to be restored.
    place.write("got/val/GOT-10k_Val_000001/groundtruth.txt", "1,11,16,16\n".repeat(FRAMES));
    let told = place.run("data verify my-got --data-root .").ends(3).never_says("fetch");
    let told = told.tells("not as pinned: my-got/GOT-10k_Val_000001; this suite is one of your own");
    told.tells("restore its folder");
    // The report needs neither the data root nor its suites.
    place.remove("datasets.lock");
    place.run("report --results r --reports again").ends(0);
    assert!(place.has("again/mine/got/index.html"));
}

#[test]
fn a_wrong_file_of_suites_is_named_and_left_as_it_is() {
    let place = data_root();
    let wrong = "schema = 2\n\n[[suite]]\nname = \"x\"\nformat = \"oct\"\n";
    place.write("datasets.lock", wrong);
    for verb in [ADD, "data list --data-root .", "run --data-root ."] {
        place.run(verb).ends(3).tells("datasets.lock, line 5");
    }
    assert_eq!(place.read("datasets.lock"), wrong);
    for (name, folder, code, words) in [
        ("otb-100", "got/val", 2, "built-in suite"),
        ("mine", "got/nothing", 3, "no folder under the data root"),
        ("mine", "results", 3, "no sequence"),
    ] {
        std::fs::remove_file(place.path("datasets.lock")).ok();
        place.run(&format!("data add {name} {folder} --format got10k --data-root .")).ends(code).tells(words);
        assert!(!place.has("datasets.lock"));
    }
}

/// A suite of boxes alone.
fn boxes_lock() -> String {
    suite("my-boxes", "otb-boxes", &[("Walk", "truth/Walk.txt")])
}

const BOXES_SPEC: &str = r#"suites.train = "synthetic-d1"
tracker = [{ name = "replay", results = "T", label = "T" }, { name = "kcf", label = "KCF" }]
method = [{ name = "DTEF" }, { name = "Two-MChi" }, { name = "oracle", detector = { kind = "oracle" } }]
analysis = [
    { name = "ope", compute = { kind = "success", rules = "otb-matlab/1" }, suites = ["test"] },
    { name = "change", compute = { kind = "uncertainty-model" }, signal.kind = "uncertainty", suites = ["test"] },
]
table = [
    { name = "t", rows = ["recall", "events"], columns = "method" },
    { name = "trackers", shows = "ope.overall" },
]
"#;

/// A method that needs frames or a posterior is listed as not run; the rest runs, and the exit code is that of success.
#[test]
fn boxes_alone_run_the_methods_that_need_no_more() {
    let spec = experiment("mine/boxes", "my-boxes", BOXES_SPEC);
    let place = Place::with(&[("data/datasets.lock", &boxes_lock()), ("spec.toml", &spec)]);
    place.write("data/truth/Walk.txt", "1,1,9,9\n".repeat(30));
    place.write("data/results/T/Walk.txt", "1,1,9,9\n".repeat(20) + &"50,1,9,9\n".repeat(10));
    // The first root has nothing.
    place.folder("empty");
    let run =
        |more: &str| place.run(&format!("run spec.toml --data-root empty --data-root data {more}")).ends(0);
    run("")
        .says("DTEF was not run on T (1 cell): it needs frames, and the suite has boxes only")
        .says("Two-MChi was not run on T (1 cell): it needs a tracker that gives its posterior")
        .says("oracle was not run on KCF (1 cell): it needs frames, and the suite has boxes only")
        .says("analysis ope was not run on KCF: it needs frames, and the suite has boxes only")
        .says("analysis change was not run on T: it needs a tracker that gives its posterior");
    let scores = place.read("results/mine/boxes/scores.csv");
    assert!(scores.contains("\"not run: needs frames, and the suite has boxes only\""), "{scores}");
    place.holds("reports/mine/boxes/index.html", &["DTEF was not run on KCF"], &["Without a result"]);
    let dry = run("--dry-run --format csv").out;
    assert_eq!(dry.lines().filter(|line| line.contains("absent")).count(), 5, "{dry}");
    // A share of the cells has none that failed either.
    run("--results s --shard 1/1");
}

const WITHOUT_BOX_SPEC: &str = r#"schema = 1
name = "mine/boxes"
title = "Frames without a box"
suites.test = "my-boxes"
analysis = [
    { name = "got10k", compute = { kind = "success", rules = "got10k/1" }, suites = ["test"], trackers = ["absent", "repeat"] },
    { name = "overlap", compute.kind = "average-overlap", suites = ["test"], trackers = ["absent", "repeat"] },
    { name = "vot", compute.kind = "longterm", signal.kind = "confidence", suites = ["test"], trackers = ["empty"] },
]
table = [{ name = "overlap", shows = "overlap.overall" }, { name = "vot", shows = "vot.overall" }]
tracker = [
    { name = "replay", results = "T", label = "absent", without_area = "absent" },
    { name = "replay", results = "T", label = "repeat", without_area = "repeat" },
    { name = "replay", results = "empty", label = "empty", without_area = "absent" },
]
"#;

// got10k 0.1.3 for a box and 29 times 0,0,0,0 on a target that stands still: success 20/21 in the first frame alone; a test of
// its rules has more. vot-toolkit 0.9.0, `vot/analysis/longterm.py`, for no box in five frames of 30: a confidence that is
// missing is 0, and the first frame is known by a mark, which overlaps nothing.
#[test]
fn frames_without_a_box_count_as_the_words_of_the_experiment_say() {
    let place = Place::with(&[("datasets.lock", &boxes_lock()), ("spec.toml", WITHOUT_BOX_SPEC)]);
    place.write("truth/Walk.txt", "1,1,9,9\n".repeat(30));
    place.write("results/T/Walk.txt", "1,1,9,9\n".to_string() + &"0,0,0,0\n".repeat(29));
    let lines = |one: &str, none: &str| one.repeat(20) + &none.repeat(5) + &one.repeat(5);
    place.write("results/empty/Walk.txt", lines("1,1,9,9\n", "nan,nan,nan,nan\n"));
    place.write("results/empty/Walk_confidence.value", lines("0.9\n", "\n"));
    place.run("run spec.toml --results r --data-root .").ends(0);
    let found = place.json("r/mine/boxes/analyses.json");
    for (analysis, tracker, name, expected) in [
        ("got10k", "absent", "success_auc", 20.0 / 21.0 / 30.0),
        ("got10k", "repeat", "success_auc", 20.0 / 21.0),
        ("overlap", "absent", "ao", 0.0),
        ("overlap", "repeat", "ao", 1.0),
        ("vot", "empty", "lt_precision", 24.0 / 25.0),
        ("vot", "empty", "lt_recall", 24.0 / 30.0),
    ] {
        let is_it = |a: &&serde_json::Value| a["analysis"] == analysis && a["tracker"] == tracker;
        let numbers =
            found.as_array().unwrap().iter().find(is_it).unwrap()["findings"]["numbers"].as_array().unwrap();
        let number = numbers.iter().find(|n| n[0] == name).unwrap()[1].as_f64().unwrap();
        assert!((number - expected).abs() < 1e-12, "{analysis} {tracker} {name}: {number}");
    }
}
