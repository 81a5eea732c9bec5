//! Messages that tracker programs are sent, and the states made of their answers.
#![cfg(unix)]

use super::testing::{FRAMES, Kind, Script, rect, sequence};
use super::*;
use crate::tracker::testing::{context, ramp};
use std::path::Path;
use trackfail_core::image::{decode, encode_png};
use trackfail_core::region::Rect;
use trackfail_dataset::{Frames, Sequence};
use trackfail_testing::assert_says;

mod faults;

fn moved(x: f64) -> TrackerState {
    TrackerState::tracked(Region::Rect(Rect::new(x, 2.5, 3.0, 4.0)))
}

/// The track of a script that answers.
fn whole_track() -> [TrackerState; FRAMES] {
    [TrackerState::initialized(rect()), moved(1.0), moved(2.0), moved(3.0)]
}

fn turned() -> Region {
    Region::Polygon(vec![(1.0, 1.0), (5.0, 2.0), (4.0, 6.0), (0.0, 5.0)])
}

#[test]
fn a_program_gets_frames_and_its_answers_are_the_track() {
    let script = Script::new(Kind::Lines, "answer");
    // Each start runs it anew.
    for _ in 0..2 {
        assert_eq!(script.track(FRAMES).unwrap(), whole_track());
    }
    assert_eq!(script.read("environment"), "99 4 more \n");
    let log = script.read("log");
    let lines: Vec<Vec<&str>> = log.lines().map(|l| l.split('\t').collect()).collect();
    let words: Vec<&str> = lines.iter().map(|line| line[0]).collect();
    assert_eq!(words, ["init", "frame", "frame", "frame", "quit"].repeat(2));
    assert_eq!(lines[0][2], "2,3.5,4,5");
    for (t, line) in lines.iter().take(FRAMES).enumerate() {
        let seen = std::fs::read(script.folder.path().join(format!("seen{t}.png"))).unwrap();
        assert_eq!(decode(&seen).unwrap(), ramp(t));
        assert!(!Path::new(line[1]).parent().unwrap().exists(), "the folder is gone");
    }
}

#[test]
fn two_written_frames_are_kept() {
    let mut images = Images::new().unwrap();
    let paths: Vec<_> = (0..5).map(|t| images.path(None, &ramp(t)).unwrap()).collect();
    assert_eq!(paths.iter().map(|p| p.exists()).collect::<Vec<_>>(), [false, false, false, true, true]);
}

#[test]
fn frames_in_files_are_sent_as_their_paths() {
    let dir = tempfile::tempdir().unwrap();
    let path = |t: usize| dir.path().join(if t == 2 { "a\tb.png".into() } else { format!("{t}.png") });
    (0..FRAMES).for_each(|t| std::fs::write(path(t), encode_png(&ramp(t)).unwrap()).unwrap());
    let frames = Frames::Files((0..FRAMES).map(path).collect());
    let sequence = Sequence { frames, ..sequence() };
    let script = Script::new(Kind::Lines, "answer");
    let (mut tracker, _) = script.start(&sequence, 1, &rect()).unwrap();
    (2..FRAMES).for_each(|t| drop(tracker.update(&sequence.frame(t).unwrap()).unwrap()));
    let log = script.read("log");
    let sent: Vec<&str> = log.lines().filter_map(|l| l.split('\t').nth(1)).collect();
    assert_eq!([sent[0], sent[2]].map(PathBuf::from), [path(1), path(3)]);
    // A path with a tab cannot be sent.
    assert_says(sent[1], "trackfail-frames-");
    let seen = std::fs::read(script.folder.path().join("seen1.png")).unwrap();
    assert_eq!(decode(&seen).unwrap(), ramp(2));
}

#[test]
fn polygons_are_sent_to_programs_that_read_them() {
    let whole = turned().rect();
    for (regions, expected) in [
        (Regions::Polygon, "1,1,5,2,4,6,0,5".to_string()),
        (Regions::Rectangle, format!("{},{},{},{}", whole.x, whole.y, whole.w, whole.h)),
    ] {
        let mut script = Script::new(Kind::Lines, "say() { echo 0,0,4,0,4,3; }; answer");
        script.program.regions = regions;
        let (mut tracker, first) = script.start(&sequence(), 0, &turned()).unwrap();
        assert_eq!(first, TrackerState::initialized(turned()));
        let triangle = Region::Polygon(vec![(0.0, 0.0), (4.0, 0.0), (4.0, 3.0)]);
        assert_eq!(tracker.update(&ramp(1)).unwrap(), TrackerState::tracked(triangle));
        assert_eq!(script.read("log").lines().next().unwrap().split('\t').nth(2), Some(expected.as_str()));
    }
}

#[test]
fn a_confidence_is_used_if_it_is_named() {
    let confidences = |kind, named: Option<&str>| -> Vec<Option<f64>> {
        let mut script = Script::new(kind, "begin; answer");
        script.program.confidence = named.map(String::from);
        let setup = script.tracker();
        assert_eq!(setup.gives_confidence(&context(&sequence(), 0)), named.is_some());
        assert_eq!(setup.params()["confidence"].as_str(), named);
        script.track(3).unwrap().into_iter().map(|state| state.confidence).collect()
    };
    assert_eq!(confidences(Kind::Lines, None), [None; 3]);
    assert_eq!(confidences(Kind::Lines, Some("any")), [Some(0.25); 3]);
    assert_eq!(confidences(Kind::Trax, None), [None; 3]);
    assert_eq!(confidences(Kind::Trax, Some("confidence")), [Some(0.0), Some(0.1), Some(0.2)]);
    // The property of another name, or of none, is no fault; a word is.
    assert_eq!(confidences(Kind::Trax, Some("score")), [None; 3]);
    let text = "say() { echo @@TRAX:state 1,2,3,4 confidence=high; }; begin; answer";
    let mut script = Script::new(Kind::Trax, text);
    script.program.confidence = Some("confidence".into());
    script.fails(Some(0), "its property `confidence`: `high` is no number");
}

#[test]
fn version_and_protocol_are_parameters_and_the_seed_counts_unless_it_is_deterministic() {
    let mut script = Script::new(Kind::Lines, "");
    let expected = serde_json::json!(
        { "program": "mine", "version": "7", "protocol": "lines", "regions": "rectangle" }
    );
    assert_eq!(script.tracker().params(), expected);
    assert!(script.tracker().facts().uses_seed);
    script.program.deterministic = true;
    script.program.digest = vec!["/a/b".into()];
    assert!(!script.tracker().facts().uses_seed);
    let inputs = script.tracker().inputs(&context(&sequence(), 0)).unwrap();
    assert_eq!(inputs, [Path::new("/a/b")]);
}

#[test]
fn trax_trackers_of_versions_1_to_3_are_followed() {
    for version in ["", "trax.version=1", "trax.version=2", "\"trax.version=3\" trax.channels=color;"] {
        // Lines that are no messages are skipped; some confirm the end.
        let hello = format!("echo loading; echo '@@TRAX:hello {version} trax.name=x'");
        let script = Script::new(Kind::Trax, &format!("{hello}; answer; echo @@TRAX:quit"));
        assert_eq!(script.track(FRAMES).unwrap(), whole_track(), "{version}");
        assert_eq!(script.read("environment"), "99 4 more 1\n");
        let log = script.read("log");
        let lines: Vec<&str> = log.lines().collect();
        for (line, begin, end) in [(0, "initialize", " \"2,3.5,4,5\""), (1, "frame", "")] {
            assert!(lines[line].starts_with(&format!("@@TRAX:{begin} \"file:///")), "{log}");
            assert!(lines[line].ends_with(&format!(".png\"{end}")), "{log}");
        }
        assert_eq!((lines.len(), lines[FRAMES]), (FRAMES + 1, "@@TRAX:quit"));
    }
}

#[test]
fn in_version_4_the_image_follows_the_region() {
    let script = Script::new(Kind::Trax, "echo @@TRAX:hello trax.version=4; ask; answer");
    assert_eq!(script.track(3).unwrap()[1..], [moved(1.0), moved(2.0)]);
    let log = script.read("log");
    let words: Vec<_> = log.lines().map(|l| l.split(' ').next().unwrap()).collect();
    let (i, f) = ("@@TRAX:initialize", "@@TRAX:frame");
    assert_eq!(words, [i, f, f, f, "@@TRAX:quit"]);
    assert_eq!(log.lines().next(), Some("@@TRAX:initialize \"2,3.5,4,5\""));
}

#[test]
fn trax_trackers_get_the_regions_they_read() {
    for (regions, region, expected) in [
        ("rectangle;polygon;", turned(), "\"1,1,5,2,4,6,0,5\""),
        ("rectangle;polygon;", rect(), "\"2,3.5,4,5\""),
        ("polygon;mask;", rect(), "\"2,3.5,6,3.5,6,8.5,2,8.5\""),
        ("rectangle;", Region::Polygon(rect().corners()), "\"2,3.5,4,5\""),
    ] {
        let script =
            Script::new(Kind::Trax, &format!("echo '@@TRAX:hello \"trax.region={regions}\"'; answer"));
        drop(script.start(&sequence(), 0, &region).unwrap());
        assert!(script.read("log").lines().next().unwrap().ends_with(expected), "{regions}");
    }
}

#[test]
fn an_answer_without_a_place_repeats_the_last() {
    let script = Script::new(Kind::Trax, "say() { echo @@TRAX:state 0; }; begin; answer");
    let again = || TrackerState::tracked(rect());
    assert_eq!(script.track(3).unwrap(), [TrackerState::initialized(rect()), again(), again()]);
}
