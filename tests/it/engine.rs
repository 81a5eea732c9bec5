//! Which results a change computes again; shards, merging, two runs at once.

use crate::tools::{assert_same_files, trackfail};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::Output;
use trackfail::image::{Frame, encode_png};

const SPEC: &str = r#"schema = 1
name = "mine/try"
title = "A try"
protocol = "khalid2016/1"
seed = 7

[suites]
test = "otb-dtef20"
train = "otb-dtef20"

[[tracker]]
name = "ncc"

[[tracker]]
name = "scripted"
losses = [{ frame = 40, length = 10 }]
jitter = 2.0

[[method]]
name = "RAW"
signal = { kind = "distribution-field", layers = 8 }
detector = { kind = "level", below = 0.5 }

[[method]]
name = "Hist"
signal = { kind = "rgb-histogram" }
detector = { kind = "level", below = 0.9 }

[[method]]
name = "Trained"
signal = { kind = "rgb-histogram" }
detector = { kind = "level", below = { train = "train", maximise = "f_score", grid = { from = 0.5, to = 0.9, step = 0.1 } } }

[[method]]
name = "Random"
detector = { kind = "random", rate = 0.05 }

[[table]]
name = "t"
rows = ["recall"]
columns = "method"
"#;

/// Frames of the two sequences of the suite that [`Place`] has.
const SEQUENCES: [(&str, u32); 2] = [("Couple", 140), ("Crossing", 120)];

/// A data root with two sequences in OTB layout, and a results folder.
struct Place {
    dir: tempfile::TempDir,
}

impl Place {
    fn new() -> Self {
        let dir = tempfile::tempdir().unwrap();
        for (name, frames) in SEQUENCES {
            let folder = dir.path().join("data/otb").join(name);
            std::fs::create_dir_all(folder.join("img")).unwrap();
            let mut truth = String::new();
            for t in 0..frames {
                let (x, y) = (8 + t / 5, 10 + t % 7);
                let frame = Frame::from_fn(64, 48, |column, row| {
                    let inside =
                        (x..x + 16).contains(&(column as u32)) && (y..y + 12).contains(&(row as u32));
                    let texture = ((column * 31 + row * 17) % 64) as u8;
                    if inside { [200, texture, 60 + 3 * (t % 20) as u8] } else { [texture, 90, 120] }
                });
                let path = folder.join(format!("img/{:04}.png", t + 1));
                std::fs::write(path, encode_png(&frame).unwrap()).unwrap();
                truth += &format!("{},{},16,12\n", x + 1, y + 1);
            }
            std::fs::write(folder.join("groundtruth_rect.txt"), truth).unwrap();
        }
        let place = Self { dir };
        place.spec(SPEC);
        place
    }

    fn path(&self, name: &str) -> PathBuf {
        self.dir.path().join(name)
    }

    fn spec(&self, text: &str) {
        std::fs::write(self.path("try.toml"), text).unwrap();
    }

    fn command(&self, verb: &str, results: &str) -> assert_cmd::Command {
        let mut command = trackfail();
        command.arg(verb).arg(self.path("try.toml")).arg("--data-root").arg(self.path("data"));
        command.arg("--results").arg(self.path(results));
        command
    }

    fn run_into(&self, results: &str, more: &[&str]) -> Output {
        let mut command = self.command("run", results);
        command
            .arg("--reports")
            .arg(self.path(&format!("{results}-reports")))
            .arg("--allow-missing")
            .args(more);
        let output = command.output().unwrap();
        // The sequences are not the pinned ones, which a run says at the end.
        let code = if more.contains(&"--shard") { 0 } else { 3 };
        assert_eq!(output.status.code(), Some(code), "{}", String::from_utf8_lossy(&output.stderr));
        output
    }

    /// Computed and cached results by stage, of a run into `results`.
    fn run(&self) -> BTreeMap<String, (usize, usize)> {
        tally(&self.run_into("results", &[]))
    }

    /// Cells of a dry run by state.
    fn states(&self) -> BTreeMap<String, usize> {
        let output =
            self.command("run", "results").args(["--dry-run", "--allow-missing", "--format", "csv"]).output();
        let text = String::from_utf8(output.unwrap().stdout).unwrap();
        let mut states = BTreeMap::new();
        for line in text.lines().skip(1) {
            *states.entry(line.rsplit(',').next().unwrap().to_string()).or_insert(0) += 1;
        }
        states
    }

    /// The line of a cell, `sequence,tracker,run,method`, in a dry run with reasons.
    fn why(&self, cell: &str) -> String {
        let mut command = self.command("run", "results");
        command.args(["--dry-run", "--verbose", "--allow-missing", "--format", "csv"]);
        let text = String::from_utf8(command.output().unwrap().stdout).unwrap();
        assert!(text.starts_with("sequence,tracker,run,method,params,state,because\n"), "{text}");
        text.lines().find(|line| line.starts_with(&format!("{cell},"))).unwrap().to_string()
    }
}

fn tally(output: &Output) -> BTreeMap<String, (usize, usize)> {
    let text = String::from_utf8_lossy(&output.stderr);
    let line = text.lines().find(|l| l.contains("tracks") && l.contains("cached")).expect("a tally");
    let parts = line.split_once(": ").unwrap().1.split("; ");
    let read = |part: &str| {
        let words: Vec<&str> = part.split_whitespace().collect();
        (words[0].to_string(), (words[1].parse().unwrap(), words[3].parse().unwrap()))
    };
    parts.map(read).collect()
}

/// Computed results of tracks, signals and labels.
fn computed(tally: &BTreeMap<String, (usize, usize)>) -> (usize, usize, usize) {
    (tally["tracks"].0, tally["signals"].0, tally["labels"].0)
}

// Before: a signal with several values a frame was computed again by every run.
#[test]
fn signals_with_several_values_come_from_the_store() {
    let place = Place::new();
    let wide = "[[method]]\nname = \"Wide\"\nsignal = { kind = \"watchdog-agreement\", values = [\"overlap\", \"score\"] }\ndetector = { kind = \"agreement\" }\n";
    place.spec(&SPEC.replacen("[[method]]", &format!("{wide}\n[[method]]"), 1));
    assert_eq!(computed(&place.run()), (4, 12, 20));
    assert_eq!(computed(&place.run()), (0, 0, 0));
}

#[test]
fn a_change_computes_exactly_the_results_that_depend_on_it() {
    let place = Place::new();
    assert_eq!(place.states(), [("missing".to_string(), 16)].into());
    assert!(place.why("Couple,ncc,0,RAW").ends_with("missing,it was never computed here"));
    assert_eq!(computed(&place.run()), (4, 8, 16));
    let before = place.run();
    assert_eq!(computed(&before), (0, 0, 0));
    assert_eq!(before["labels"].1, 16, "all from the store");
    assert_eq!(place.states(), [("cached".to_string(), 16)].into());

    // Modification times and comments are no ingredients.
    let image = place.path("data/otb/Couple/img/0007.png");
    let touched = std::fs::File::options().append(true).open(&image).unwrap();
    touched.set_modified(std::time::UNIX_EPOCH).unwrap();
    place.spec(&format!("# a comment\n{SPEC}"));
    assert_eq!(computed(&place.run()), (0, 0, 0));

    let check = |text: &str, cell: &str, because: &str, stale: usize, expected: (usize, usize, usize)| {
        place.spec(text);
        assert_eq!(place.states().get("stale"), Some(&stale), "{because}");
        let why = place.why(cell);
        assert!(why.contains("stale") && why.contains(because), "{why}");
        assert_eq!(computed(&place.run()), expected, "{because}");
        assert_eq!(computed(&place.run()), (0, 0, 0), "{because}");
    };
    // A threshold: the labels of its method.
    let threshold = SPEC.replace("below = 0.5", "below = 0.4");
    check(&threshold, "Couple,ncc,0,RAW", "detector level: below was 0.5, is 0.4", 4, (0, 0, 4));
    // A parameter of a signal: that signal and the labels of its methods.
    let signal = SPEC.replace("layers = 8", "layers = 16");
    check(&signal, "Couple,ncc,0,RAW", "signal distribution-field: layers was 8, is 16", 4, (0, 4, 4));
    // Candidates of training: the models, and the labels of trained methods, whose addresses hold the model's.
    let grid = SPEC.replace("to = 0.9", "to = 0.8");
    check(&grid, "Couple,ncc,0,Trained", "training of below: candidate", 4, (0, 0, 4));
    // The seed: the tracker and the detector that draw random numbers.
    let seed = SPEC.replace("seed = 7", "seed = 8");
    check(&seed, "Couple,scripted,0,Hist", "tracker scripted: seed was", 10, (2, 4, 10));
    assert_eq!(
        computed(&{
            place.spec(SPEC);
            place.run()
        }),
        (0, 0, 0),
        "what was there before still is"
    );

    // One byte of an image, and one of the annotation: all results of that sequence.
    let mut bytes = std::fs::read(&image).unwrap();
    let frame = trackfail::image::decode(&bytes).unwrap();
    let changed = Frame::from_fn(64, 48, |x, y| {
        let at = 3 * (y * 64 + x);
        let [r, g, b] = [frame.bytes()[at], frame.bytes()[at + 1], frame.bytes()[at + 2]];
        if (x, y) == (0, 0) { [r ^ 1, g, b] } else { [r, g, b] }
    });
    bytes = encode_png(&changed).unwrap();
    std::fs::write(&image, bytes).unwrap();
    check(SPEC, "Couple,ncc,0,RAW", "tracker ncc: frames and truth was", 10, (2, 4, 10));
    assert!(place.why("Crossing,ncc,0,RAW").ends_with(",cached,"));
    assert_eq!(place.run()["models"], (0, 2));
    let path = place.path("data/otb/Crossing/groundtruth_rect.txt");
    let truth = std::fs::read_to_string(&path).unwrap();
    std::fs::write(&path, truth.replacen(",16,12", ",16,13", 1)).unwrap();
    check(SPEC, "Crossing,scripted,0,Random", "tracker scripted: frames and truth was", 10, (2, 4, 10));
}

#[test]
fn cells_are_cached_only_with_their_tracks_and_signals() {
    let place = Place::new();
    place.run();
    let packs = std::fs::read_dir(place.path("results/.store/packs")).unwrap();
    for pack in packs.map(|e| e.unwrap().path()).collect::<Vec<_>>() {
        let bytes = std::fs::read(&pack).unwrap();
        std::fs::remove_file(&pack).unwrap();
        let states = place.states();
        let models = place.run_into("results", &[]);
        let computed = tally(&models).values().map(|(computed, _)| computed).sum::<usize>();
        assert!(computed > 0, "{} was needed by nothing", pack.display());
        // Models are not cells: their loss alone shows in no cell.
        let only_a_model = tally(&models)["models"].0 == computed;
        assert_eq!(states.get("cached") == Some(&16), only_a_model, "{states:?}");
        std::fs::write(&pack, bytes).unwrap();
    }
}

#[test]
fn a_damaged_store_is_reported_and_computed_again() {
    let place = Place::new();
    place.run();
    let clean = place.path("clean");
    copy(&place.path("results/mine"), &clean);
    let packs: Vec<PathBuf> =
        std::fs::read_dir(place.path("results/.store/packs")).unwrap().map(|e| e.unwrap().path()).collect();
    for (k, pack) in packs.iter().enumerate() {
        let bytes = std::fs::read(pack).unwrap();
        let damaged = match k % 3 {
            0 => bytes[..bytes.len() / 2].to_vec(),
            1 => Vec::new(),
            _ => bytes.iter().enumerate().map(|(i, b)| if i == 40 { b ^ 8 } else { *b }).collect(),
        };
        std::fs::write(pack, damaged).unwrap();
    }
    let output = place.run_into("results", &[]);
    let told = String::from_utf8_lossy(&output.stderr).matches("are computed again").count();
    assert_eq!(told, packs.len(), "{}", String::from_utf8_lossy(&output.stderr));
    assert_same_files(&place.path("results/mine"), &clean);
    assert_eq!(computed(&place.run()), (0, 0, 0));
    // A store of another version is refused.
    std::fs::write(place.path("results/.store/format"), "trackfail-store 99\n").unwrap();
    let output = place.command("run", "results").arg("--allow-missing").output().unwrap();
    assert_eq!(output.status.code(), Some(1));
    assert!(String::from_utf8_lossy(&output.stderr).contains("another program version"));
}

fn copy(from: &Path, to: &Path) {
    for entry in walkdir::WalkDir::new(from) {
        let entry = entry.unwrap();
        let target = to.join(entry.path().strip_prefix(from).unwrap());
        if entry.file_type().is_dir() {
            std::fs::create_dir_all(target).unwrap();
        } else {
            std::fs::copy(entry.path(), target).unwrap();
        }
    }
}

#[test]
fn merged_shards_equal_one_run_byte_for_byte() {
    let place = Place::new();
    place.run_into("whole", &[]);
    // Into one store.
    for share in ["3/3", "1/3", "2/3"] {
        place.run_into("shared", &["--shard", share]);
    }
    assert!(!place.path("shared/mine").exists(), "a shard has no tables");
    // Training and the cells of trained methods are left.
    let last = tally(&place.run_into("shared", &[]));
    assert_eq!((computed(&last), last["models"].0), ((0, 0, 4), 2));
    assert_same_files(&place.path("whole"), &place.path("shared"));
    // Into stores of their own, which are then merged.
    for share in ["1/2", "2/2"] {
        place.run_into(&format!("part{}", &share[..1]), &["--shard", share]);
    }
    let merge = || {
        let mut merge = trackfail();
        merge.arg("merge").arg(place.path("part1")).arg(place.path("part2"));
        merge.arg("--results").arg(place.path("joined"));
        merge.output().unwrap()
    };
    assert!(merge().status.success());
    assert!(String::from_utf8_lossy(&merge().stdout).contains("0 records added"));
    assert_eq!(computed(&tally(&place.run_into("joined", &[]))), (0, 0, 4));
    assert_same_files(&place.path("whole"), &place.path("joined"));
    let output = trackfail().args(["merge", "/nowhere"]).output().unwrap();
    assert_eq!(output.status.code(), Some(2));
}

#[test]
fn two_runs_at_once_write_the_same_files() {
    let place = Place::new();
    place.run_into("whole", &[]);
    std::thread::scope(|scope| {
        for _ in 0..2 {
            scope.spawn(|| place.run_into("results", &[]));
        }
    });
    assert_same_files(&place.path("whole"), &place.path("results"));
    assert_same_files(&place.path("whole-reports"), &place.path("results-reports"));
}

#[test]
fn force_computes_everything_again_with_the_same_results() {
    let place = Place::new();
    place.run();
    let before = place.path("before");
    copy(&place.path("results/mine"), &before);
    let output = place.run_into("results", &["--force"]);
    assert_eq!(computed(&tally(&output)), (4, 8, 16));
    assert_same_files(&place.path("results/mine"), &before);
    assert_eq!(computed(&place.run()), (0, 0, 0));
}

#[test]
fn a_cell_that_takes_too_long_fails_and_the_tables_are_written() {
    let place = Place::new();
    let output =
        place.command("run", "results").args(["--allow-missing", "--timeout", "1e-9"]).output().unwrap();
    assert_eq!(output.status.code(), Some(4));
    let text = String::from_utf8_lossy(&output.stderr);
    assert!(text.contains("took longer than 0.000000001 s"), "{text}");
    let scores = std::fs::read_to_string(place.path("results/mine/try/scores.csv")).unwrap();
    assert!(scores.contains("failed: Couple: took longer") && !scores.contains(",ok"));
    assert_eq!(place.states(), [("missing".to_string(), 16)].into(), "failures are not stored");
}

#[cfg(unix)]
#[test]
fn a_sequence_that_cannot_be_read_fails_alone() {
    let place = Place::new();
    let image = place.path("data/otb/Couple/img/0007.png");
    std::fs::remove_file(&image).unwrap();
    // Reading a pipe without a writer would block.
    assert!(std::process::Command::new("mkfifo").arg(&image).status().unwrap().success());
    let output = place.command("run", "results").arg("--allow-missing").output().unwrap();
    let text = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(4), "{text}");
    assert!(text.contains("0007.png: not a file"), "{text}");
    assert_eq!(place.states(), [("absent".to_string(), 8), ("cached".to_string(), 8)].into());
}

#[test]
fn a_small_store_evicts_the_least_recently_used_packs() {
    let place = Place::new();
    place.run();
    let size = |place: &Place| -> u64 {
        std::fs::read_dir(place.path("results/.store/packs"))
            .unwrap()
            .map(|e| e.unwrap().metadata().unwrap().len())
            .sum()
    };
    let full = size(&place);
    // Other annotations change all results; the limit leaves no room for those that were not used.
    for (name, _) in SEQUENCES {
        let path = place.path(&format!("data/otb/{name}/groundtruth_rect.txt"));
        let truth = std::fs::read_to_string(&path).unwrap();
        std::fs::write(&path, truth.replacen(",16,12", ",16,13", 1)).unwrap();
    }
    place.run_into("results", &["--store-limit", "0.000001"]);
    assert!(size(&place) <= full + full / 2, "{} of {full}", size(&place));
    assert_eq!(computed(&place.run()), (0, 0, 0), "the packs of the last run are still there");
}
