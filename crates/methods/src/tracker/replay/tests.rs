use super::*;
use crate::tracker::testing;
use trackfail_core::plugin::{Plugin, RawParams, read_params};
use trackfail_dataset::suite::Catalog;
use trackfail_dataset::{Frames, Numbering, Sequence};
use trackfail_testing::assert_says;

/// The data roots of a test: one folder.
fn roots(root: &tempfile::TempDir) -> Vec<PathBuf> {
    vec![root.path().to_path_buf()]
}

/// Reader of a folder, with `more` parameters.
fn replay_of(results: &str, more: &str) -> Params {
    let params = format!("{{ results = '{results}'{more} }}");
    let params = toml::de::ValueDeserializer::parse(&params).unwrap();
    Params::new(read_params(RawParams::Toml(params)).unwrap()).unwrap()
}

fn replay(results: &str) -> Params {
    replay_of(results, "")
}

/// The parameter at fault, if parameters are refused.
fn refused(params: &str) -> Option<&'static str> {
    ENTRY.build_from_text(&format!("{{ {params} }}")).err().expect(params).key
}

/// A sequence that uses frames 3 and 4 of the official range 2..=5.
fn sequence() -> Sequence {
    let numbering = Numbering { first: 3, official: (2, 5) };
    Sequence { numbering, frames: Frames::Files(vec![]), ..testing::rendered("S", 2) }
}

fn with_files(files: &[(&str, &str)]) -> tempfile::TempDir {
    trackfail_testing::folder(files.iter().map(|(name, text)| (format!("results/a/{name}"), text)))
}

/// A run of a sequence in a folder with these files, read with `more` parameters.
fn read_run(
    more: &str,
    files: &[(&str, &str)],
    sequence: &Sequence,
    run: u32,
) -> Result<Vec<TrackerState>, TrackerError> {
    replay_of("a", more).read(sequence, run, &roots(&with_files(files)))
}

/// The first run.
fn read(files: &[(&str, &str)], sequence: &Sequence) -> Result<Vec<TrackerState>, TrackerError> {
    read_run("", files, sequence, 0)
}

fn confidences(states: &[TrackerState]) -> Vec<Option<f64>> {
    states.iter().map(|s| s.confidence).collect()
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
        // As many lines as the official range, though the last two are empty.
        ("S.txt", "1,1,1,1\n2,1,1,1\n3,1,1,1\n\n", 0, [1.0, 2.0]),
        ("S_001.txt", "7,1,1,1\n8,1,1,1\n", 0, [6.0, 7.0]),
        ("S_003.txt", four, 2, [1.0, 2.0]),
        ("S/S_001.txt", "1\n4,4,2,2", 0, [9.0, 4.0]),
        ("S/S_012.txt", "\u{feff}1.0000\r\n2\r\n", 11, [9.0, 9.0]),
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
        let files = [(file, text), ("S/S_001_time.txt", "1\n1"), ("S_time.txt", "0.1")];
        assert_eq!(lefts(&read_run("", &files, &sequence(), run).unwrap()), want, "{file}");
    }
}

#[test]
fn the_first_pixel_may_be_given() {
    for (file, text, default, base, moved) in [
        ("S.txt", "7,1,1,1\n8,1,1,1", [6.0, 7.0], 0, [7.0, 8.0]),
        ("S.json", JSON, [1.0, 2.0], 0, [2.0, 3.0]),
        ("S/S_001.txt", "7,1,1,1\n8,1,1,1", [6.0, 7.0], 0, [7.0, 8.0]),
        // The truth of the first frame is no part of the file and does not move.
        ("S/S_001.txt", "1\n8,1,1,1", [9.0, 8.0], 1, [9.0, 7.0]),
    ] {
        let given =
            [(1 - base, default), (base, moved)].map(|(base, want)| (format!(", base = {base}"), want));
        for (more, want) in given.into_iter().chain([(String::new(), default)]) {
            let states = read_run(&more, &[(file, text)], &sequence(), 0).unwrap();
            assert_eq!(lefts(&states), want, "{file}{more}");
        }
    }
    for bad in ["2", "-1", "'0'", "0.5", "true"] {
        refused(&format!("results = 'a', base = {bad}"));
    }
    let config = ENTRY.build_from_text("{ results = \"a\", base = 0 }").unwrap();
    assert_eq!(config.params()["base"], 0);
    // Not given is no key of an address, so that those of before stay.
    assert!(ENTRY.build_from_text(ENTRY.example).unwrap().params().get("base").is_none());
}

#[test]
fn a_targets_number_may_be_spelled_otherwise() {
    assert_eq!(files::spellings("Jogging-1"), ["Jogging-1", "Jogging_1", "Jogging.1"]);
    assert_eq!(files::spellings("car-racing-12"), ["car-racing-12", "car-racing_12", "car-racing.12"]);
    for plain in ["Girl2", "-1", "GOT-10k_Val_000001", "car-001", "a-b", "a-"] {
        assert_eq!(files::spellings(plain), [plain]);
    }
    let boxes = "7,1,1,1\n8,1,1,1";
    let second = Sequence { name: "S-2".into(), ..sequence() };
    for file in ["S-2.txt", "S_2.txt", "S.2.txt", "S_2_001.txt", "S_2/S_2_001.txt", "../a_000/S_2.txt"] {
        let states = read(&[(file, boxes), ("S.txt", "1,1,1,1"), ("S_1.txt", "")], &second).unwrap();
        assert_eq!(lefts(&states), [6.0, 7.0], "{file}");
    }
    match read(&[("S_2.txt", boxes), ("S.2.txt", boxes)], &second) {
        Err(TrackerError::Broken(m)) => assert!(m.contains("S_2.txt") && m.contains("S.2.txt"), "{m}"),
        other => panic!("{other:?}"),
    }
}

// tracker_benchmark's own results of STRUCK have `BasketBall.json` for the sequence Basketball.
#[test]
fn a_name_may_differ_in_capital_letters() {
    let boxes = "7,1,1,1\n8,1,1,1";
    let ball = Sequence { name: "Ball-2".into(), ..sequence() };
    for (file, beside) in [
        ("BALL-2.txt", "ball-2_Scores.txt"),
        ("baLL_2.TXT", "ball_2_scores.txt"),
        ("ball-2_001.txt", "Ball-2_001_scores.txt"),
        ("Longterm/ball-2/BALL-2_001.txt", "Longterm/ball-2/ball-2_001_scores.txt"),
        ("../a_000/ball.2.txt", "../a_000/Ball.2_scores.txt"),
    ] {
        let states = read(&[(file, boxes), (beside, "0.5\n0.25\n"), ("Ball-3.txt", boxes)], &ball);
        let states = states.unwrap_or_else(|e| panic!("{file}: {e}"));
        assert_eq!(lefts(&states), [6.0, 7.0], "{file}");
        assert_eq!(confidences(&states), [Some(0.5), Some(0.25)], "{file}");
    }
    // The very name comes first, and one of two others has to be meant.
    let root = with_files(&[("Ball-2.txt", boxes), ("ball-2.txt", "1,1,1,1")]);
    if root.path().join("results/a").read_dir().unwrap().count() == 2 {
        assert_eq!(lefts(&replay("a").read(&ball, 0, &roots(&root)).unwrap()), [6.0, 7.0]);
        let error = read(&[("BALL-2.txt", boxes), ("ball-2.txt", boxes)], &ball).unwrap_err().to_string();
        ["both", "BALL-2.txt", "ball-2.txt"].iter().for_each(|words| assert_says(&error, words));
    }
    // A short one is a fault, whatever its name.
    assert_says(read(&[("BALL-2.txt", "1,1,1,1")], &ball).unwrap_err(), "BALL-2.txt: 1 boxes");
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
    assert!(second.contains("S_002.txt") && second.contains("nothing in a_001"), "{second}");
    // Results are the same wherever the data are.
    assert!(!second.contains(&*root.path().to_string_lossy()), "{second}");
}

#[test]
fn files_that_do_not_fit_are_errors() {
    let fails = |files: &[(&str, &str)], run, words: &str| match read_run("", files, &sequence(), run) {
        Err(e @ (TrackerError::Broken(_) | TrackerError::File(_))) => assert_says(e, words),
        other => panic!("{files:?}: {other:?}"),
    };
    let (one, two) = ("1,1,1,1", "1,1,1,1\n1,1,1,1");
    for (files, run, words) in [
        (&[("S.json", JSON)][..], 1, "start later"),
        (&[("S.json", JSON)], 2, "no run 2"),
        (&[("../a_001/S.txt", "7\t1\t1\t1\n8\t1\t0\t1")], 1, "S.txt: line 2"),
        (&[("S.txt", two), ("S_confidence.value", "1\n1\n1\n")], 0, "3 values for 2 boxes"),
        (&[("S.txt", two), ("S_all_scores.txt", "1\nx\n")], 0, "S_all_scores.txt, line 2"),
        (&[("S.txt", two), ("S.json", JSON)], 0, "both"),
        (&[("S.txt", two), ("../a_000/S.txt", two)], 0, "a_000/S.txt"),
    ] {
        fails(files, run, words);
    }
    // vot-toolkit 0.9.0 writes trajectories as bytes by default: struct.pack("<hI", 1, 2), and so on.
    let (bytes, five, no_area) = ("\u{1}\0\u{2}\0\0\0", "1,7,1,1,1\n2,8,1,1,1\n", "1,1,1,1\n1,1,0,1");
    for (file, words, texts) in [
        ("S.txt", "1 boxes", &[one][..]),
        ("S.txt", "3 boxes", &["1,1,1,1\n1,1,1,1\n1,1,1,1"]),
        ("S.txt", "S.txt, line 1: 5 numbers", &[five]),
        ("S.txt", "leave the others out", &[five]),
        ("S.txt", "S.txt: line 2", &[no_area]),
        ("S.txt", "`without_area = \"absent\"` takes this as", &[no_area]),
        ("S.txt", "S.txt: line 2: a coordinate is not", &["1,1,1,1\n1,nan,1,1"]),
        ("S.txt", "S.txt: line 2: an empty line", &["1,1,1,1\n\n1,1,1,1\n1,1,1,1"]),
        ("S.txt", "several targets (1, 2)", &["2,1,5,5,5,5,1\n2,2,5,5,5,5,1"]),
        ("S.txt", "frame 4: no row", &["2,1,5,5,5,5,1\n"]),
        ("S.txt", "empty", &[""]),
        ("S.csv", "there is no frame", &["v,o,3,true,1,0,1,0,1\n"]),
        ("S/S_001.bin", "S_001.bin: ", &[bytes]),
        ("S/S_001.bin", "write_trajectory", &[bytes]),
        ("S/S_001.txt", "1 lines for 2", &["1"]),
        ("S/S_001.txt", "S_001.txt, line 1: neither", &["0\n1", "1,1\n1,1", "1.5\n1", "\n1\n1"]),
        ("S/S_001.txt", "S_001.txt, line 1: neither", &["1,2,3,4,5,6,7,8\n1"]),
        ("S/S_001.txt", "S_001.txt, line 1", &["x,y,w,h\n1,1,1,1"]),
        ("S/S_001.txt", "S_001.txt, line 2", &["5,5,1,1\n1", "5,5,1,1\n5,5,1,inf"]),
        ("S/S_001.txt", "S_001.txt: line 2", &["5,5,1,1\n5,5,1,0"]),
        ("S/S_001.txt", "1 boxes", &["5,5,1,1"]),
    ] {
        texts.iter().for_each(|text| fails(&[(file, *text)], 0, words));
    }
}

// Two frames of confidence .75 and .25 after the first, as each tool writes them.
#[test]
fn a_confidence_is_read_with_the_boxes() {
    let sequence = testing::rendered("S", 3);
    let (vot, boxes) = ("1\n9,9,9,9\n9,9,9,9\n", "9,9,9,9\n9,9,9,9\n9,9,9,9\n");
    let (tabs, times) = ("9\t9\t9\t9\n9\t9\t9\t9\n9\t9\t9\t9\n", "0.1\n0.1\n0.1\n");
    let oxuva = "S,0,2,true,0.75,0.025,0.05,0.0375,0.075\r\nS,0,3,true,0.25,0.025,0.05,0.0375,0.075\r\n";
    let mot = "1,7,9,9,9,9,-1,-1,-1,-1\n2,7,9,9,9,9,0.75,-1,-1,-1\n3,7,9,9,9,9,0.25,-1,-1,-1\n";
    for (files, first) in [
        (
            &[
                ("longterm/S/S_001.txt", vot),
                ("longterm/S/S_001_confidence.value", "\n0.750000\n0.250000\n"),
                ("longterm/S/S_time.txt", times),
            ][..],
            None,
        ),
        (
            &[
                ("S/S_001.txt", vot),
                ("S/S_001_confidence.value", "\n0.75\n0.25\n"),
                ("S/S_001_time.value", times),
            ],
            None,
        ),
        (&[("S.txt", tabs), ("S_object_presence_scores.txt", "1.000000\n0.750000\n0.250000\n")], Some(1.0)),
        (&[("../a_000/S.txt", boxes), ("../a_000/S_all_scores.txt", "1.00\n0.75\n0.25\n")], Some(1.0)),
        (&[("S_bboxes.txt", boxes), ("S_scores.txt", "10000\n0.75\n0.25\n")], Some(10_000.0)),
        (&[("S.csv", oxuva)], None),
        (&[("S.txt", mot)], None),
    ] {
        let root = with_files(files);
        let roots = roots(&root);
        let states = replay("a").read(&sequence, 0, &roots).unwrap();
        assert_eq!(confidences(&states), [first, Some(0.75), Some(0.25)], "{files:?}");
        assert!(states[1..].iter().all(|s| s.status == Status::Tracked), "{files:?}");
        let context = RunContext { data_roots: &roots, ..testing::context(&sequence, 0) };
        assert!(replay("a").gives_confidence(&context));
        let files_read = replay("a").inputs(&context).unwrap();
        let beside = files.iter().filter(|(name, _)| name.contains("scores") || name.contains("confidence"));
        assert_eq!(files_read.len(), 1 + beside.count(), "{files:?}");
    }
    // Rows that have a confidence need no file beside, unless it is named.
    let files =
        [("S.txt", "1,7,9,9,9,9,1\n2,7,9,9,9,9,.75\n3,7,9,9,9,9,.25\n"), ("S_scores.txt", "3\n4\n5\n")];
    for (more, want) in [("", [1.0, 0.75, 0.25]), (", confidence = 'scores'", [3.0, 4.0, 5.0])] {
        let states = read_run(more, &files, &sequence, 0).unwrap();
        assert_eq!(confidences(&states), want.map(Some), "{more}");
    }
    // The official range is longer than the one used: as many values as boxes.
    let four = "1,1,1,1\n2,1,1,1\n3,1,1,1\n4,1,1,1";
    let states = read(&[("S.txt", four), ("S_confidence.value", "1\n2\n3\n4")], &super::tests::sequence());
    assert_eq!(confidences(&states.unwrap()), [Some(2.0), Some(3.0)]);
}

#[test]
fn two_confidences_are_an_error_unless_one_is_named() {
    let boxes = ("S.txt", "7,1,1,1\n8,1,1,1\n");
    let read = |more: &str| {
        let files = [boxes, ("S_all_scores.txt", "1\n2"), ("S_confidence.value", "3\n4")];
        let states = read_run(more, &files, &sequence(), 0);
        states.map(|s| s[1].confidence).map_err(|e| e.to_string())
    };
    ["S_all_scores.txt", "S_confidence.value"]
        .iter()
        .for_each(|name| assert_says(read("").unwrap_err(), name));
    assert_eq!(read(", confidence = 'all_scores'"), Ok(Some(2.0)));
    assert_eq!(read(", confidence = 'confidence'"), Ok(Some(4.0)));
    assert_says(read(", confidence = 'motion'").unwrap_err(), "S_motion.value or S_motion.txt");
    for bad in ["", "../x", "a/b", "a.b"] {
        assert_eq!(refused(&format!("results = 'a', confidence = '{bad}'")), Some("confidence"), "{bad}");
    }
    // A folder, and a link to nothing, in the place of a confidence or of boxes.
    for (files, name) in
        [(&[boxes, ("S_confidence.value/x", "")][..], "S_confidence.value"), (&[("S.txt/x", "")], "S.txt")]
    {
        let error = super::tests::read(files, &sequence()).unwrap_err().to_string();
        assert!(error.contains(name) && error.contains("not a file"), "{error}");
    }
    #[cfg(unix)]
    {
        let linked = with_files(&[boxes]);
        let place = linked.path().join("results/a/S_scores.txt");
        std::os::unix::fs::symlink("gone.txt", &place).unwrap();
        assert_says(replay("a").read(&sequence(), 0, &roots(&linked)).unwrap_err(), "S_scores.txt");
    }
}

#[test]
fn frames_without_a_box_may_be_absence_or_the_last_box_again() {
    let sequence = testing::rendered("S", 3);
    let rules = [("absent", Status::Absent), ("repeat", Status::Repeated)]
        .map(|(rule, status)| (format!(", without_area = '{rule}'"), status));
    for (file, text) in [
        ("S.txt", "5,1,1,1\n6,1,0,1\n7,1,1,1\n"),
        ("S.txt", "5,1,1,1\nnan,nan,nan,nan\n7,1,1,1\n"),
        ("S.txt", "5,1,1,1\n\n7,1,1,1\n"),
        ("S.txt", "1,2,5,1,1,1,1\n3,2,7,1,1,1,1\n"),
        ("S/S_001.txt", "5,1,1,1\nNaN,NaN,NaN,NaN\n7,1,1,1\n"),
        ("S.csv", "S,0,1,true,1,0.0125,0.025,0,1\nS,0,2,false,0,0,0,0,0\nS,0,3,true,1,0.01875,0.02,0,1"),
    ] {
        for (rule, status) in &rules {
            let states = read_run(rule, &[(file, text)], &sequence, 0);
            let states = states.unwrap_or_else(|e| panic!("{text}: {e}"));
            assert_eq!(lefts(&states), [4.0, 4.0, 6.0], "{text}");
            assert_eq!([states[1].status, states[2].status], [*status, Status::Tracked], "{text}");
        }
        assert_says(read(&[(file, text)], &sequence).unwrap_err(), "2: ");
    }
    // VOT's own files begin with a mark, and count from 0.
    let vot = [("S/S_001.txt", "1\n\n5,1,1,1\n")];
    let states = read_run(&rules[0].0, &vot, &sequence, 0).unwrap();
    assert_eq!((lefts(&states), states[1].status), (vec![9.0, 9.0, 5.0], Status::Absent));
    assert!(read(&vot, &sequence).is_err());
    // Infinity is no word for absence, nor is a first frame without a box.
    for text in
        ["5,1,1,1\n1,inf,1,1\n1,1,1,1", "nan,nan,nan,nan\n1,1,1,1\n1,1,1,1", "5,1,0,1\n6,1,1,1\n7,1,1,1"]
    {
        for (rule, _) in &rules {
            assert!(read_run(rule, &[("S.txt", text)], &sequence, 0).is_err(), "{text}{rule}");
        }
    }
    // The tracks of the first version are not taken for those of this one.
    assert_eq!(replay_of("a", &rules[1].0).shown()["without_area"], "repeat/2");
}

// The tracker ran in frame 2, and the range used begins with 3.
#[test]
fn rows_after_the_start_are_no_initialization() {
    let states = read(&[("S.txt", "1,7,5,5,5,5,1\n2,7,6,5,5,5,1\n3,7,7,5,5,5,1\n")], &sequence()).unwrap();
    assert_eq!((lefts(&states), states[0].status), (vec![5.0, 6.0], Status::Tracked));
    let lost = [("S.txt", "1,7,5,5,5,5,1\n3,7,6,5,5,5,1\n")];
    for more in ["", ", without_area = 'absent'"] {
        assert_says(read_run(more, &lost, &sequence(), 0).unwrap_err(), "frame 3: no row");
    }
}

// The frame of the start has no row, nor have those that nobody asked for.
#[test]
fn frames_that_nobody_asked_for_are_skipped() {
    let files = [("vid1_obj2.csv", "vid1,obj2,3,true,0.5,0.25,0.5,0.5,0.75\r\n")];
    let states = read(&files, &testing::rendered("vid1_obj2", 3)).unwrap();
    let status: Vec<Status> = states.iter().map(|s| s.status).collect();
    assert_eq!(status, [Status::Initialized, Status::Skipped, Status::Tracked]);
    assert_eq!(lefts(&states), [9.0, 9.0, 80.0]);
}

#[test]
fn paths_stay_under_the_data_root() {
    for bad in ["", "/etc", "../x", "a/../b", "a//b", "./a", "a/.", "a\\b", "a/"] {
        assert_eq!(refused(&format!("results = '{bad}'")), Some("results"), "{bad}");
    }
    refused("results = 'a', more = 1");
    refused("results = 'a', label = ' '");
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
}
