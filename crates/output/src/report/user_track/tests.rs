use super::*;
use crate::report::sequences::json::Said;
use crate::report::verdict::{Stretch, stretches, verdict};
use crate::results::detections;
use crate::testing::judged_method;
use proptest::prelude::*;
use std::sync::Arc;
use trackfail_core::image::Frame;
use trackfail_core::plugin;
use trackfail_core::region::Rect;
use trackfail_dataset::{Frames, user_frames};
use trackfail_methods::detector::{DETECTORS, Input};

/// Frames of 160 x 120 pixels with some texture.
fn texture(t: usize) -> Frame {
    Frame::from_fn(160, 120, |x, y| [(x * 7 + t) as u8, (y * 5) as u8, (x * y / 16) as u8])
}

fn video(frames: usize) -> Sequence {
    let rendered = Frames::Rendered(Arc::new(texture), frames);
    Sequence { frames: rendered, ..user_frames::without_frames("a <video>", frames) }
}

/// The tracks as a user's video.
fn shown(sequence: &Sequence, tracks: Vec<UserTrack>) -> UserVideo<'_> {
    UserVideo { sequence, tracks, facts: vec![("boxes".to_string(), "a&b.txt".to_string())] }
}

/// Track that is lost in frames 20 to 29 and absent in the last five, with results of `methods` methods.
fn track(target: Option<i64>, frames: usize, methods: usize) -> UserTrack {
    let state = |t: usize| match t {
        20..30 => TargetState::Lost,
        t if t + 5 >= frames => TargetState::Absent,
        _ => TargetState::Tracking,
    };
    let score = |k: usize, t: usize| match state(t) {
        TargetState::Lost => Some(0.9),
        TargetState::Absent => None,
        TargetState::Tracking => Some(((t * 7919 + k) % 997) as f64 / 20_000.0),
    };
    let method = |k: usize| {
        let score = (0..frames).map(|t| score(k, t)).collect();
        judged_method(&format!("M{k}"), (0..frames).map(state).collect(), score, Some(0.8))
    };
    let judged = JudgedTrack { target, first: 1, methods: (0..methods).map(method).collect() };
    let rect = |t: usize| Region::Rect(Rect::new(20.0 + (t % 90) as f64, 30.0, 40.0, 50.0));
    UserTrack { judged, regions: (0..frames).map(|t| (t + 3 < frames).then(|| rect(t))).collect() }
}

#[test]
fn frames_that_say_most_come_first() {
    let tracks = [track(None, 60, 1)];
    assert_eq!(telling_frames(&tracks, 60, 6), [20, 0, 59, 30, 25, 15]);
    assert_eq!(telling_frames(&tracks, 60, 2), [20, 0]);
    assert_eq!(telling_frames(&tracks, 60, 1000).len(), 60);
    assert!(telling_frames(&[], 0, 5).is_empty());
    assert_eq!(telling_frames(&[], 3, 5), [0, 2, 1]);
}

#[test]
fn a_frame_shows_box_state_and_score() {
    let sequence = video(60);
    let one = shown(&sequence, vec![track(None, 60, 1)]);
    let frame = sequence.frame(25).unwrap();
    let has = |drawn: &Frame, rgb: [u8; 3]| drawn.bytes().chunks(3).any(|pixel| pixel == rgb);
    let (vermilion, green) = ([0xD5, 0x5E, 0x00], [0x00, 0x9E, 0x73]);
    let lost = one.drawn(25, &frame);
    assert!(has(&lost, vermilion) && !has(&lost, green));
    let good = one.drawn(5, &frame);
    assert!(has(&good, green) && !has(&good, vermilion));
    // The line above says more than the number of the frame: it covers more of the frame.
    let covered = |drawn: &Frame| (0..160).filter(|x| drawn.pixel(*x, 1) == [0x20; 3]).count();
    let two = shown(&sequence, vec![track(Some(1), 60, 1), track(Some(2), 60, 1)]);
    assert!(covered(&lost) > 2 * covered(&two.drawn(25, &frame)));
    // Without a box there is only the line.
    let gone = two.drawn(59, &frame);
    assert_eq!(gone.row(60), frame.row(60));
}

#[test]
fn a_page_of_2000_frames_is_below_three_megabytes_and_needs_nothing_beside_it() {
    let sequence = video(2000);
    let page = shown(&sequence, vec![track(None, 2000, 16)]).page().unwrap();
    assert!(page.len() < 3_000_000, "{}", page.len());
    assert!(page.matches("data:image/jpeg;base64,").count() > 50);
    assert!(page.contains("Lost from frame 21 to 30; found again."), "the verdict");
    assert!(page.contains("a &lt;video&gt;") && page.contains("a&amp;b.txt") && !page.contains("<video>"));
    let markup = page.split("<script").next().unwrap();
    assert!(!markup.contains(" src=") && !markup.contains("url("));
    assert!(page.contains("img-src data:; script-src 'sha256-"));
}

#[test]
fn a_page_without_frames_has_no_pictures() {
    let sequence = user_frames::without_frames("boxes", 60);
    let video = shown(&sequence, vec![track(Some(3), 60, 1), track(Some(-1), 60, 1)]);
    let page = video.page().unwrap();
    assert!(!page.contains("data:image"));
    assert!(page.contains("Target 3: Lost from frame 21") && page.contains("Target -1: Lost"));
    let svg = video.plot().unwrap().to_svg().unwrap();
    assert!(svg.contains("target 3, M0") && !svg.contains("data:image"));
}

#[test]
fn a_figure_has_stills_panels_and_the_verdict() {
    let sequence = video(60);
    let figure = shown(&sequence, vec![track(None, 60, 2)]).plot().unwrap();
    assert_eq!((figure.stills.len(), figure.rows.len()), (5, 2));
    assert!(figure.note.starts_with("Lost from frame 21 to 30; found again."));
    let numbers: Vec<u32> = figure.stills.iter().map(|still| still.number).collect();
    assert_eq!(numbers, [1, 21, 26, 31, 60]);
    let svg = figure.to_svg().unwrap();
    assert!(svg.contains("threshold 0.8") && svg.contains("target lost") && !svg.contains("Oₜ"));
    assert!(figure.to_png().unwrap().starts_with(b"\x89PNG"));
}

/// Judged track with these frames: the score of each, and true if it has a box.
fn judged(frames: &[(f64, bool)]) -> JudgedTrack {
    let detector = plugin::find(DETECTORS, "level").unwrap();
    let detector = detector.build_from_text("{ above = 0.8 }").unwrap();
    let signal: Vec<f64> = frames.iter().map(|(p, _)| *p).collect();
    let error = vec![f64::NAN; frames.len()];
    let output =
        detector.detect(&Input { signal: &signal, more: &[], error: &error, seed: 0, reverse: None });
    let present: Vec<bool> = frames.iter().map(|(_, present)| *present).collect();
    let mut method = JudgedMethod::new("M", &*detector, &output, 0, &present);
    method.is_probability = true;
    JudgedTrack { target: None, first: 1, methods: vec![method] }
}

proptest! {
    // The law: CSV, table of stretches, strip of the page and drawn frames have one state for each frame.
    #[test]
    fn all_outputs_agree_on_every_frame(
        frames in prop::collection::vec((prop::sample::select(vec![0.05, 0.4, 0.55, 0.7, 0.9]), prop::bool::weighted(0.8)), 1..80),
    ) {
        let judged = judged(&frames);
        let method = &judged.methods[0];
        let text = String::from_utf8(detections::csv(&[&judged]).unwrap()).unwrap();
        let words: Vec<String> =
            text.lines().skip(1).map(|line| line.rsplit(',').next().unwrap().to_string()).collect();
        let stretches = stretches(method);
        let said = Said::of_states(method);
        let is_within = |runs: &[usize], t: usize| runs.chunks(2).any(|run| (run[0]..=run[1]).contains(&t));
        let region = Some(Region::Rect(Rect::new(1.0, 1.0, 5.0, 5.0)));
        let track = UserTrack { regions: vec![region; frames.len()], judged: judged.clone() };
        for (t, word) in words.iter().enumerate() {
            let here: Vec<&Stretch> = stretches.iter().filter(|s| s.frames.contains(&t)).collect();
            prop_assert!(here.len() <= 1, "frame {t} is in {here:?}");
            let of_table = here.first().map_or("tracking", |stretch| stretch.state.word());
            prop_assert_eq!(of_table, word, "frame {}", t);
            prop_assert_eq!(is_within(&said.lost, t), word == "lost");
            prop_assert_eq!(is_within(&said.absent, t), word == "absent");
            prop_assert_eq!(track.state(t).word(), word);
        }
        let sentence = verdict(&judged, method);
        prop_assert_eq!(sentence.starts_with("Lost "), words.iter().any(|word| word == "lost"), "{}", sentence);
        prop_assert!(sentence.matches(". ").count() <= 1, "{}", sentence);
    }
}
