//! Laws of all protocols.

use super::testing::{counts, error, set, track};
use super::*;
use crate::detector::changes;
use proptest::prelude::*;

// On 100 frames with one loss from 50 to 60. The only detection of `always` is in the first frame that is judged;
// `never` has none; the oracle is right everywhere.
#[test]
fn anchors_have_their_closed_forms() {
    let (error, oracle) = (error(100, &[[50, 60]]), set(100, &[[50, 60]]));
    let of_events = |n, tn| [counts(0, 1, n, tn), counts(0, 0, n, tn), counts(n, 0, 0, tn)];
    // Of ranges that detection is in a frame that could be silent.
    let of_losses = |tn| [counts(0, 1, 1, tn - 1), counts(0, 0, 1, tn), counts(1, 0, 0, tn)];
    let of_good_frames = [counts(0, 0, 90, 10), counts(90, 10, 0, 0), counts(90, 0, 0, 10)];
    let of_lost_frames = [counts(10, 90, 0, 0), counts(0, 0, 10, 90), counts(10, 0, 0, 90)];
    let expected = [
        ("khalid2016/1", of_events(1, 89)),
        ("khalid2016/2", of_events(1, 89)),
        ("sanmiguel2015/1", of_events(2, 97)),
        ("sanmiguel2015-unsigned/1", of_events(2, 97)),
        ("sanmiguel2015-segmentation/1", of_good_frames),
        ("frames/1", of_lost_frames),
        ("frames-clear/1", of_lost_frames),
        ("range/1", of_losses(99)),
        ("nab/1", of_losses(84)),
    ];
    assert_eq!(PROTOCOLS.len(), expected.len());
    for (protocol, (name, expected)) in PROTOCOLS.iter().zip(expected) {
        assert_eq!((protocol.name, super::protocol(name).map(|p| p.name)), (name, Some(name)));
        let of = |alarm: &[bool]| (protocol.score)(&error, alarm, &changes(alarm)).counts;
        assert_eq!([&[true; 100][..], &[false; 100], &oracle[..]].map(of), expected, "{name}");
    }
    assert_eq!(frames::protocols::FRAMES.chance.f_over_chance(&of_lost_frames[0]), Some(0.0));
}

proptest! {
    #[test]
    fn every_event_detection_and_frame_is_counted_once((error, alarm, changes) in track()) {
        let known = error.iter().filter(|e| !e.is_nan()).count() as u64;
        for p in PROTOCOLS {
            let s = (p.score)(&error, &alarm, &changes);
            let c = s.counts;
            // Frames of the start that are never silent, and frames from an event to its detection.
            let (start, delays) = match p.name {
                "khalid2016/1" | "khalid2016/2" => (khalid2016::START_UP, -5..=5),
                name if name.starts_with("sanmiguel2015") => (1, -5..=5),
                _ => (0, 0..=15),
            };
            if p.frame.is_some() {
                prop_assert_eq!(c.tp + c.fp + c.fn_ + c.tn, known, "{}", p.name);
            } else {
                prop_assert_eq!(c.tp, s.matches.len() as u64, "{}", p.name);
                prop_assert_eq!(c.tp + c.fp, s.detections.len() as u64, "{}", p.name);
                prop_assert_eq!(c.tp + c.fn_, s.events.len() as u64, "{}", p.name);
                prop_assert!(c.tn as usize <= error.len().saturating_sub(start), "{}", p.name);
            }
            prop_assert!(s.events.is_sorted() && s.detections.is_sorted(), "{}", p.name);
            let in_order = |a: &(usize, usize), b: &(usize, usize)| a.0 < b.0 && (start > 0 || a.1 < b.1);
            prop_assert!(s.matches.is_sorted_by(in_order), "{}", p.name);
            prop_assert!(s.delays().all(|delay| delays.contains(&delay)), "{}", p.name);
        }
    }
}
