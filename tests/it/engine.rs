//! Which results a change computes again; shards, merging, two runs at once.

use crate::tools::{Place, Ran, assert_same_files, files, sequence};
use std::collections::BTreeMap;
use trackfail::image::{Frame, encode_png};

const SPEC: &str = r#"schema = 1
name = "mine/try"
title = "A try"
protocol = "khalid2016/1"
seed = 7
suites = { test = "otb-dtef20", train = "otb-dtef20" }
tracker = [{ name = "ncc" }, { name = "scripted", losses = [{ frame = 40, length = 10 }], jitter = 2.0 }]
table = [{ name = "t", rows = ["recall"], columns = "method" }]
method = [
    { name = "RAW", signal = { kind = "distribution-field", layers = 8 }, detector = { kind = "level", below = 0.5 } },
    { name = "Hist", signal.kind = "rgb-histogram", detector = { kind = "level", below = 0.9 } },
    { name = "Trained", signal.kind = "rgb-histogram", detector = { kind = "level", below = { train = "train", maximise = "f_score", grid = { from = 0.5, to = 0.9, step = 0.1 } } } },
    { name = "Random", detector = { kind = "random", rate = 0.05 } },
]
"#;

/// Frames of the two sequences of the suite that a data root has.
const SEQUENCES: [(&str, u32); 2] = [("Couple", 140), ("Crossing", 120)];

const IMAGE: &str = "data/otb/Couple/img/0007.png";

/// A data root with the two sequences, and the experiment.
fn place() -> Place {
    let place = Place::with(&[("try.toml", SPEC)]);
    SEQUENCES.iter().for_each(|(name, frames)| sequence(&place, name, *frames));
    place
}

/// Another height of the box in the first frame.
fn change_truth(place: &Place, sequence: &str) {
    let name = format!("data/otb/{sequence}/groundtruth_rect.txt");
    place.write(&name, place.read(&name).replacen(",16,12", ",16,13", 1));
}

const RUN: &str = "run try.toml --data-root data --allow-missing";

fn run_into(place: &Place, results: &str, more: &str) -> Ran {
    let ran = place.run(&format!("{RUN} --results {results} --reports {results}-reports {more}"));
    // The sequences are not the pinned ones, which a run says at the end.
    ran.ends(if more.contains("--shard") { 0 } else { 3 })
}

/// Computed and cached results by stage.
pub type Tally = BTreeMap<String, (usize, usize)>;

/// Those of a run into `results`.
fn run(place: &Place) -> Tally {
    tally(&run_into(place, "results", ""))
}

/// Cells of a dry run by state.
fn states(place: &Place) -> BTreeMap<String, usize> {
    let mut states = BTreeMap::new();
    for line in place.run(&format!("{RUN} --dry-run --format csv")).out.lines().skip(1) {
        *states.entry(line.rsplit(',').next().unwrap().to_string()).or_insert(0) += 1;
    }
    states
}

/// The line of a cell, `sequence,tracker,run,method`, in a dry run with reasons.
fn why(place: &Place, cell: &str) -> String {
    let text = place.run(&format!("{RUN} --dry-run --verbose --format csv")).out;
    assert!(text.starts_with("sequence,tracker,run,method,params,state,because\n"), "{text}");
    text.lines().find(|line| line.starts_with(&format!("{cell},"))).unwrap().to_string()
}

/// Those that a run tells.
pub fn tally(ran: &Ran) -> Tally {
    let line = ran.err.lines().find(|l| l.contains("tracks") && l.contains("cached")).expect("a tally");
    let parts = line.split_once(": ").unwrap().1.split("; ");
    let read = |part: &str| {
        let words: Vec<&str> = part.split_whitespace().collect();
        (words[0].to_string(), (words[1].parse().unwrap(), words[3].parse().unwrap()))
    };
    parts.map(read).collect()
}

/// Computed results of tracks, signals and labels.
fn computed(tally: &Tally) -> (usize, usize, usize) {
    (tally["tracks"].0, tally["signals"].0, tally["labels"].0)
}

#[test]
fn a_change_computes_exactly_the_results_that_depend_on_it() {
    let place = place();
    assert_eq!(states(&place), [("missing".to_string(), 16)].into());
    let never = "missing,\"it was never computed here, or has been removed\"";
    assert!(why(&place, "Couple,ncc,0,RAW").ends_with(never));
    assert_eq!(computed(&run(&place)), (4, 8, 16));
    let before = run(&place);
    assert_eq!(computed(&before), (0, 0, 0));
    assert_eq!(before["labels"].1, 16, "all from the store");
    assert_eq!(states(&place), [("cached".to_string(), 16)].into());

    // Modification times and comments are no ingredients.
    let touched = std::fs::File::options().append(true).open(place.path(IMAGE)).unwrap();
    touched.set_modified(std::time::UNIX_EPOCH).unwrap();
    place.write("try.toml", format!("# a comment\n{SPEC}"));
    assert_eq!(computed(&run(&place)), (0, 0, 0));

    let check = |from: &str, to: &str, cell: &str, because: &str, expected: (usize, usize, usize)| {
        place.write("try.toml", SPEC.replace(from, to));
        assert_eq!(states(&place).get("stale"), Some(&expected.2), "{because}");
        let why = why(&place, cell);
        assert!(why.contains("stale") && why.contains(because), "{why}");
        assert_eq!(computed(&run(&place)), expected, "{because}");
        assert_eq!(computed(&run(&place)), (0, 0, 0), "{because}");
    };
    for (from, to, cell, because, expected) in [
        // A threshold: the labels of its method.
        ("below = 0.5", "below = 0.4", "ncc,0,RAW", "detector level: below was 0.5, is 0.4", (0, 0, 4)),
        // A parameter of a signal: that signal and the labels of its methods.
        ("layers = 8", "layers = 16", "ncc,0,RAW", "distribution-field: layers was 8, is 16", (0, 4, 4)),
        // Candidates of training: the models, and the labels of trained methods, whose addresses hold the model's.
        ("to = 0.9", "to = 0.8", "ncc,0,Trained", "training of below: candidate", (0, 0, 4)),
        // The seed: the tracker and the detector that draw random numbers.
        ("seed = 7", "seed = 8", "scripted,0,Hist", "tracker scripted: seed was", (2, 4, 10)),
    ] {
        check(from, to, &format!("Couple,{cell}"), because, expected);
    }
    place.write("try.toml", SPEC);
    assert_eq!(computed(&run(&place)), (0, 0, 0), "what was there before still is");
    // Before: a signal with several values a frame was computed again by every run.
    let wide = "{ name = \"Wide\", signal = { kind = \"watchdog-agreement\", values = [\"overlap\", \"score\"] }, \
                detector.kind = \"agreement\" },\n]\n";
    place.write("try.toml", SPEC.trim_end_matches("]\n").to_string() + wide);
    assert_eq!(computed(&run(&place)), (0, 4, 4));
    assert_eq!(computed(&run(&place)), (0, 0, 0));

    // One byte of an image, and one of the annotation: all results of that sequence.
    let frame = trackfail::image::decode(&place.bytes(IMAGE)).unwrap();
    let changed = Frame::from_fn(64, 48, |x, y| {
        let at = 3 * (y * 64 + x);
        let [r, g, b] = [frame.bytes()[at], frame.bytes()[at + 1], frame.bytes()[at + 2]];
        if (x, y) == (0, 0) { [r ^ 1, g, b] } else { [r, g, b] }
    });
    place.write(IMAGE, encode_png(&changed).unwrap());
    check("", "", "Couple,ncc,0,RAW", "tracker ncc: frames and truth was", (2, 4, 10));
    assert!(why(&place, "Crossing,ncc,0,RAW").ends_with(",cached,"));
    assert_eq!(run(&place)["models"], (0, 2));
    change_truth(&place, "Crossing");
    check("", "", "Crossing,scripted,0,Random", "tracker scripted: frames and truth was", (2, 4, 10));
}

#[test]
fn cells_are_cached_only_with_their_tracks_and_signals() {
    let place = place();
    run(&place);
    for pack in place.list("results/.store/packs") {
        let bytes = std::fs::read(&pack).unwrap();
        std::fs::remove_file(&pack).unwrap();
        let states = states(&place);
        let again = run(&place);
        let computed = again.values().map(|(computed, _)| computed).sum::<usize>();
        assert!(computed > 0, "{} was needed by nothing", pack.display());
        // Models are not cells: their loss alone shows in no cell.
        let only_a_model = again["models"].0 == computed;
        assert_eq!(states.get("cached") == Some(&16), only_a_model, "{states:?}");
        std::fs::write(&pack, bytes).unwrap();
    }
}

#[test]
fn a_damaged_store_is_reported_and_computed_again() {
    let place = place();
    run(&place);
    let clean = place.path("clean");
    for (name, bytes) in files(&place.path("results/mine")) {
        place.write(&format!("clean/{}", name.display()), bytes);
    }
    let packs = place.list("results/.store/packs");
    for (k, pack) in packs.iter().enumerate() {
        let bytes = std::fs::read(pack).unwrap();
        let damaged = match k % 3 {
            0 => bytes[..bytes.len() / 2].to_vec(),
            1 => Vec::new(),
            _ => bytes.iter().enumerate().map(|(i, b)| if i == 40 { b ^ 8 } else { *b }).collect(),
        };
        std::fs::write(pack, damaged).unwrap();
    }
    let ran = run_into(&place, "results", "");
    assert_eq!(ran.err.matches("are computed again").count(), packs.len(), "{}", ran.err);
    assert_same_files(&place.path("results/mine"), &clean);
    assert_eq!(computed(&run(&place)), (0, 0, 0));
    // All is computed again on demand, with the same results.
    assert_eq!(computed(&tally(&run_into(&place, "results", "--force"))), (4, 8, 16));
    assert_same_files(&place.path("results/mine"), &clean);
    assert_eq!(computed(&run(&place)), (0, 0, 0));
    // A store of another version is refused.
    place.write("results/.store/format", "trackfail-store 99\n");
    place.run(RUN).ends(1).tells("another program version");
}

#[test]
fn shards_and_two_runs_equal_one_run() {
    let place = place();
    run_into(&place, "whole", "");
    std::thread::scope(|scope| {
        for _ in 0..2 {
            scope.spawn(|| run_into(&place, "results", ""));
        }
    });
    assert_same_files(&place.path("whole"), &place.path("results"));
    assert_same_files(&place.path("whole-reports"), &place.path("results-reports"));
    // Into one store.
    for share in ["3/3", "1/3", "2/3"] {
        run_into(&place, "shared", &format!("--shard {share}"));
    }
    assert!(!place.has("shared/mine"), "a shard has no tables");
    // Training and the cells of trained methods are left.
    let last = tally(&run_into(&place, "shared", ""));
    assert_eq!((computed(&last), last["models"].0), ((0, 0, 4), 2));
    assert_same_files(&place.path("whole"), &place.path("shared"));
    // Into stores of their own, which are then merged.
    for share in [1, 2] {
        run_into(&place, &format!("part{share}"), &format!("--shard {share}/2"));
    }
    let merge = || place.run("merge part1 part2 --results joined").ends(0);
    merge();
    merge().says("0 records added");
    assert_eq!(computed(&tally(&run_into(&place, "joined", ""))), (0, 0, 4));
    assert_same_files(&place.path("whole"), &place.path("joined"));
    place.run("merge /nowhere").ends(2);
}

#[test]
fn cells_that_fail_leave_the_others_and_are_not_stored() {
    let place = place();
    place.run(&format!("{RUN} --timeout 1e-9")).ends(4).tells("took longer than 0.000000001 s");
    place.holds("results/mine/try/scores.csv", &["failed: Couple: took longer"], &[",ok"]);
    assert_eq!(states(&place), [("missing".to_string(), 16)].into());
    // Reading a pipe without a writer would block.
    place.shell(&format!("rm {IMAGE} && mkfifo {IMAGE}")).ends(0);
    place.run(RUN).ends(4).tells("0007.png: not a file");
    assert_eq!(states(&place), [("absent".to_string(), 8), ("cached".to_string(), 8)].into());
}

#[test]
fn a_small_store_evicts_the_least_recently_used_packs() {
    let place = place();
    run(&place);
    let size = || -> u64 {
        place.list("results/.store/packs").iter().map(|pack| pack.metadata().unwrap().len()).sum()
    };
    let full = size();
    // Other annotations change all results; the limit leaves no room for those that were not used.
    SEQUENCES.iter().for_each(|(name, _)| change_truth(&place, name));
    run_into(&place, "results", "--store-limit 0.000001");
    assert!(size() <= full + full / 2, "{} of {full}", size());
    assert_eq!(computed(&run(&place)), (0, 0, 0), "the packs of the last run are still there");
}
