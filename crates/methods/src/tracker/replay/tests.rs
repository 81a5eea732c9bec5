use super::*;
use crate::dataset::suite::Catalog;
use crate::dataset::{Frames, Numbering};
use crate::region::Rect;
use crate::tracker::testing;

/// The data roots of a test, one.
fn roots(root: &tempfile::TempDir) -> Vec<PathBuf> {
    vec![root.path().to_path_buf()]
}

fn replay(results: &str) -> Replay {
    let text = format!("{{ results = \"{results}\" }}");
    Replay::new(read_params(RawParams::parse(&text).unwrap()).unwrap()).unwrap()
}

/// Frames 3 and 4 of official 2..=5.
fn sequence() -> Sequence {
    Sequence {
        name: "S".into(),
        numbering: Numbering { first: 3, official: (2, 5) },
        truth: vec![Some(Region::Rect(Rect::new(9.0, 9.0, 9.0, 9.0))); 2],
        attributes: vec![],
        frame_attributes: vec![],
        digest: "0".into(),
        frames: Frames::Files(vec![].into()),
    }
}

fn with_files(files: &[(&str, &str)]) -> tempfile::TempDir {
    let root = tempfile::tempdir().unwrap();
    for (name, text) in files {
        let path = root.path().join("results/a").join(name);
        std::fs::create_dir_all(path.parent().unwrap()).unwrap();
        std::fs::write(path, text).unwrap();
    }
    root
}

fn lefts(states: &[TrackerState]) -> Vec<f64> {
    states.iter().map(|s| s.region.rect().x).collect()
}

const JSON: &str = r#"[{"startFrame":1,"endFrame":4,"resType":"rect",
    "res":[[1,1,1,1],[2,1,1,1],[3,1,1,1],[4,1,1,1]]},
    {"startFrame":4,"endFrame":5,"resType":"rect","res":[[4,1,1,1],[5,1,1,1]]}]"#;

#[test]
fn formats_and_runs() {
    let four = "1,1,1,1\n2,1,1,1\n3,1,1,1\n4,1,1,1";
    for (file, text, run, want) in [
        ("S.json", JSON, 0, [1.0, 2.0]),
        ("S.txt", four, 0, [1.0, 2.0]),
        ("S.txt", "7,1,1,1\n8,1,1,1\n", 0, [6.0, 7.0]),
        ("S_001.txt", "7,1,1,1\n8,1,1,1\n", 0, [6.0, 7.0]),
        ("S_003.txt", four, 2, [1.0, 2.0]),
        ("S/S_001.txt", "1\n4,4,2,2", 0, [9.0, 4.0]),
        ("S/S_012.txt", "1\n2", 11, [9.0, 9.0]),
        // GOT-10k, three repetitions; of the official range and of the range used.
        ("S/S_001.txt", "1.000,1.000,1.000,1.000\n2,1,1,1\n3,1,1,1\n4,1,1,1\n", 0, [1.0, 2.0]),
        ("S/S_003.txt", "\u{feff}7,1,1,1\r\n8,1,1,1\r\n", 2, [6.0, 7.0]),
        // pytracking, without a run's number and with.
        ("S.txt", "7\t1\t1\t1\n8\t1\t1\t1\n", 0, [6.0, 7.0]),
        ("../a_000/S.txt", "7\t1\t1\t1\n8\t1\t1\t1\n", 0, [6.0, 7.0]),
        ("../a_004/S.txt", "7\t1\t1\t1\n8\t1\t1\t1\n", 4, [6.0, 7.0]),
        // pysot, and blanks.
        ("S.txt", "7.5,1.5,1.0,1.0\n8.25,1,1,1\n", 0, [6.5, 7.25]),
        ("S.txt", "7 1 1,  1\n8 1\t1 1", 0, [6.0, 7.0]),
    ] {
        let root = with_files(&[(file, text), ("S/S_001_time.txt", "1\n1"), ("S_time.txt", "0.1")]);
        let states = replay("a").read(&sequence(), run, &roots(&root));
        assert_eq!(lefts(&states.unwrap()), want, "{file}");
    }
}

#[test]
fn the_first_pixel_may_be_given() {
    for (file, text, default, other) in [
        ("S.txt", "7,1,1,1\n8,1,1,1", [6.0, 7.0], (0, [7.0, 8.0])),
        ("S.json", JSON, [1.0, 2.0], (0, [2.0, 3.0])),
        ("S/S_001.txt", "7,1,1,1\n8,1,1,1", [6.0, 7.0], (0, [7.0, 8.0])),
        // The truth of the first frame is no part of the file and does not move.
        ("S/S_001.txt", "1\n8,1,1,1", [9.0, 8.0], (1, [9.0, 7.0])),
    ] {
        let root = with_files(&[(file, text)]);
        let read = |params: String| {
            let replay = Replay::new(read_params(RawParams::parse(&params).unwrap()).unwrap()).unwrap();
            lefts(&replay.read(&sequence(), 0, &roots(&root)).unwrap())
        };
        assert_eq!(read("{ results = \"a\" }".into()), default, "{file}");
        let (base, moved) = other;
        assert_eq!(read(format!("{{ results = \"a\", base = {base} }}")), moved, "{file}");
        assert_eq!(read(format!("{{ results = \"a\", base = {} }}", 1 - base)), default, "{file}");
    }
    for bad in ["2", "-1", "\"0\"", "0.5", "true"] {
        assert!(ENTRY.build_from_text(&format!("{{ results = \"a\", base = {bad} }}")).is_err(), "{bad}");
    }
    let config = ENTRY.build_from_text("{ results = \"a\", base = 0 }").unwrap();
    assert_eq!(config.params()["base"], 0);
    // Not given is no key of an address, so that those of before stay.
    assert!(ENTRY.build_from_text(ENTRY.example).unwrap().params().get("base").is_none());
}

#[test]
fn a_targets_number_may_be_spelled_otherwise() {
    assert_eq!(spellings("Jogging-1"), ["Jogging-1", "Jogging_1", "Jogging.1"]);
    assert_eq!(spellings("car-racing-12"), ["car-racing-12", "car-racing_12", "car-racing.12"]);
    for plain in ["Girl2", "-1", "GOT-10k_Val_000001", "car-001", "a-b", "a-"] {
        assert_eq!(spellings(plain), [plain]);
    }
    let boxes = "7,1,1,1\n8,1,1,1";
    let second = Sequence { name: "S-2".into(), ..sequence() };
    for file in ["S-2.txt", "S_2.txt", "S.2.txt", "S_2_001.txt", "S_2/S_2_001.txt", "../a_000/S_2.txt"] {
        let root = with_files(&[(file, boxes), ("S.txt", "1,1,1,1"), ("S_1.txt", "")]);
        let states = replay("a").read(&second, 0, &roots(&root)).unwrap();
        assert_eq!(lefts(&states), [6.0, 7.0], "{file}");
    }
    let root = with_files(&[("S_2.txt", boxes), ("S.2.txt", boxes)]);
    match replay("a").read(&second, 0, &roots(&root)) {
        Err(TrackerError::Broken(m)) => assert!(m.contains("S_2.txt") && m.contains("S.2.txt"), "{m}"),
        other => panic!("{other:?}"),
    }
}

#[test]
fn absent_results_are_missing() {
    let root = with_files(&[("S.txt", "1,1,1,1"), ("T_001.txt", "")]);
    let missing = |result: Result<Vec<TrackerState>, TrackerError>| match result {
        Err(TrackerError::Missing(message)) => message,
        other => panic!("{other:?}"),
    };
    assert!(missing(replay("a").read(&sequence(), 0, &[])).contains("--data-root"));
    assert!(missing(replay("b").read(&sequence(), 0, &roots(&root))).contains("S/S_001.txt"));
    let second = missing(replay("a").read(&sequence(), 1, &roots(&root)));
    assert!(second.contains("S_002.txt") && second.contains("a_001 beside"), "{second}");
}

#[test]
fn files_that_do_not_fit_are_errors() {
    for (files, run, word) in [
        (&[("S.json", JSON)][..], 1, "start later"),
        (&[("S.json", JSON)], 2, "no run 2"),
        (&[("S.txt", "1,1,1,1")], 0, "1 boxes"),
        (&[("S.txt", "1,1,1,1\n1,1,1,1\n1,1,1,1")], 0, "3 boxes"),
        (&[("S.txt", "1,1,1,1\n1,1,0,1")], 0, "S.txt: line 2"),
        (&[("S.txt", "1,1,1,1\n1,nan,1,1")], 0, "S.txt, line 2"),
        (&[("S.txt", "")], 0, "empty"),
        (&[("S/S_001.txt", "1")], 0, "1 lines for 2"),
        (&[("S.txt", "1,1,1,1\n1,1,1,1"), ("S.json", JSON)], 0, "both"),
        (&[("S.txt", "1,1,1,1\n1,1,1,1"), ("../a_000/S.txt", "1,1,1,1\n1,1,1,1")], 0, "a_000/S.txt"),
        (&[("S/S_001.txt", "0\n1")], 0, "S_001.txt, line 1: neither"),
        (&[("S/S_001.txt", "1,1\n1,1")], 0, "S_001.txt, line 1: neither"),
        (&[("S/S_001.txt", "5,5,1,1\n1")], 0, "S_001.txt, line 2: 1 numbers"),
        (&[("S/S_001.txt", "5,5,1,1\n5,5,1,inf")], 0, "S_001.txt, line 2"),
        (&[("S/S_001.txt", "5,5,1,1\n5,5,1,0")], 0, "S_001.txt: line 2"),
        (&[("S/S_001.txt", "5,5,1,1\n5,5,1,1\n5,5,1,1")], 0, "3 boxes"),
        (&[("S/S_001.txt", "5,5,1,1")], 0, "1 boxes"),
        (&[("../a_001/S.txt", "7\t1\t1\t1\n8\t1\t0\t1")], 1, "S.txt: line 2"),
    ] {
        let root = with_files(files);
        match replay("a").read(&sequence(), run, &roots(&root)) {
            Err(e @ (TrackerError::Broken(_) | TrackerError::Results(_))) => {
                assert!(e.to_string().contains(word), "{e}");
            }
            other => panic!("{files:?}: {other:?}"),
        }
    }
}

#[test]
fn boxes_without_area_may_be_repeated_and_are_marked() {
    let files = [("S.txt", "5,1,1,1\n6,1,0,1"), ("T.txt", "5,1,0,1\n6,1,1,1")];
    let root = with_files(&files);
    let mut repeat = replay("a");
    repeat.0.without_area = WithoutArea::Repeat;
    let states = repeat.read(&sequence(), 0, &roots(&root)).unwrap();
    assert_eq!((lefts(&states), states[1].status), (vec![4.0, 4.0], Status::Skipped));
    let other = Sequence { name: "T".into(), ..sequence() };
    assert!(repeat.read(&other, 0, &roots(&root)).is_err());
}

#[test]
fn paths_stay_under_the_data_root() {
    for bad in ["", "/etc", "../x", "a/../b", "a//b", "./a", "a/.", "a\\\\b", "a/"] {
        let text = format!("{{ results = \"{bad}\" }}");
        let error = ENTRY.build_from_text(&text).err().unwrap();
        assert_eq!(error.key, Some("results"), "{bad}");
    }
    assert!(ENTRY.build_from_text("{ results = \"a\", more = 1 }").is_err());
    assert!(ENTRY.build_from_text("{ results = \"a\", label = \" \" }").is_err());
    let config = ENTRY.build_from_text(ENTRY.example).unwrap();
    assert_eq!(config.params()["results"], "otb/OPE/STRUCK");
    assert_eq!(config.params()["without_area"], "error");
}

#[test]
fn plays_in_order_and_again() {
    let root = with_files(&[("S.json", JSON)]);
    let s = sequence();
    let context = RunContext { data_roots: &roots(&root), ..testing::context(&s, 0) };
    let frame = Frame::new(1, 1, vec![0; 3]);
    let region = s.truth[0].clone().unwrap();
    for _ in 0..2 {
        let (mut tracker, first) = replay("a").start(&context, &frame, &region).unwrap();
        // The file starts one frame before the range used, so this is no initialization.
        assert_eq!((first.region.rect().x, first.status), (1.0, Status::Tracked));
        assert_eq!(tracker.update(&frame).unwrap().region.rect().x, 2.0);
        assert!(tracker.update(&frame).is_err());
    }
}

#[trackfail_testing::needs(real_data)]
#[test]
fn real_results_cover_the_real_sequences() {
    let root = trackfail_testing::real_data();
    let otb = Catalog::default().suite("otb-dtef20").unwrap().load(std::slice::from_ref(&root)).sequences;
    for tracker in ["OPE/STRUCK", "OPE/MEEM", "OPE/MUSTer", "TRE/IVT"] {
        let config = replay(&format!("otb/{tracker}"));
        for s in &otb {
            let states = config.read(s, 0, std::slice::from_ref(&root)).unwrap();
            assert_eq!(states.len(), s.len());
            assert_eq!(states[0].status, Status::Initialized);
            // OTB starts every tracker with the ground truth; Struck rounds, IVT draws its own.
            let truth = s.truth[0].as_ref().unwrap();
            let share = states[0].region.intersection(truth) / truth.area();
            assert!(share > 0.9, "{tracker} {}: {share}", s.name);
        }
    }
    let vot = Catalog::default().suite("vot2014").unwrap().load(std::slice::from_ref(&root)).sequences;
    for (tracker, runs) in [
        ("GOTURN/baseline", 3),
        ("PFTracker/baseline_lite", 1),
        ("CFTTracker/baseline_lite", 1),
        ("kalman/baseline_lite_25", 1),
    ] {
        let config = replay(&format!("vot2014/{tracker}"));
        for s in &vot {
            for run in 0..runs {
                let states = config.read(s, run, std::slice::from_ref(&root)).unwrap();
                assert_eq!(states.len(), s.len());
            }
            assert!(matches!(
                config.read(s, runs, std::slice::from_ref(&root)),
                Err(TrackerError::Missing(_))
            ));
        }
    }
}
