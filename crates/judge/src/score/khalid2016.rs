//! Protocols `khalid2016/1` and `khalid2016/2`: detection of tracking errors in time (Khalid et al. 2016, Section 4.1).
//!
//! * Error: O_t = 1 - Dice (Eq. 10). Frames without annotation keep the state before them.
//! * Event: the first frame of a run with O_t = 1 that follows a frame with O_t < 1 (Eq. 11 and text).
//! * Detection: the first frame of a run of alarms.
//! * Matching: one-to-one within 5 frames, nearest first, then earliest ([`super::matching`]).
//! * TP = matched pairs, FP = unmatched detections, FN = unmatched events.
//! * TN = the remaining frames from frame 11 (1-based) of the track on: those that are neither a
//!   detection nor an unmatched event.
//!
//! Measures pool these counts over a suite. The paper does not say how it pairs detections with errors
//! nor which frames can be true negatives; the counts implied by its Table 1 (FP + TN between 6474 and
//! 6522 on 6717 frames) fit ten start-up frames left out of each sequence.
//!
//! The paper runs the trackers of its Table 2 under VOT's reset protocol and does not say what becomes of a restart, which
//! comes five frames after a failure, within the five frames in which a detection counts. In `khalid2016/1` the track goes
//! on over it; in `khalid2016/2` it begins a new track, see [`super::restarts`]. Without restarts both give the same.

use super::chance::Chance;
use super::frames::truth::Rule;
use super::matching;
use super::protocol::{Protocol, TrackScore};
use super::restarts::Restarts;

/// Protocol `khalid2016/1`.
pub const PROTOCOL: Protocol = Protocol {
    name: "khalid2016/1",
    summary: "first frames of O_t = 1 against first frames of alarms, one-to-one within 5 frames",
    positives: "events",
    frame: None,
    restarts: Restarts::PartOfTrack,
    chance: Chance::within(TOLERANCE),
    score,
};

/// Protocol `khalid2016/2`, in which each restart begins a new track.
pub const NEW_TRACK: Protocol = Protocol {
    name: "khalid2016/2",
    summary: "as khalid2016/1, but a restart of the tracker begins a new track and is never a detection",
    restarts: Restarts::NewTrack,
    ..PROTOCOL
};

/// Largest distance in frames at which a detection matches an event, before or after it.
pub const TOLERANCE: usize = 5;

/// Number of frames at the start of a track that are never true negatives.
pub const START_UP: usize = 10;

/// First frames of the runs with error 1 that follow a frame with error below 1.
pub fn events(error: &[f64]) -> Vec<usize> {
    Rule::NoOverlap.losses(error).into_iter().map(|loss| loss.start).collect()
}

fn score(error: &[f64], alarm: &[bool], _: &[i32]) -> TrackScore {
    let (events, detections) = (events(error), crate::detector::run_starts(alarm));
    let matches = matching::match_nearest(&events, &detections, TOLERANCE);
    TrackScore::of_matches(START_UP..error.len(), events, detections, matches)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::score::testing::{counts, error, set};

    // Worked by hand on 60 frames: failures start at 20 and 45; alarms start at 18 (matches 20),
    // 30 (false), 52 (too late for 45). TN = 50 late frames - 3 detections - 1 missed event.
    #[test]
    fn counts_a_hand_worked_track() {
        let s = score(&error(60, &[[20, 30], [45, 60]]), &set(60, &[[18, 22], [30, 31], [52, 60]]), &[]);
        assert_eq!(s.events, [20, 45]);
        assert_eq!(s.detections, [18, 30, 52]);
        assert_eq!(s.matches, [(0, 0)]);
        assert_eq!(s.counts, counts(1, 2, 1, 46));
        assert_eq!(score(&[], &[], &[]).counts, counts(0, 0, 0, 0));
    }

    #[test]
    fn events_follow_a_frame_on_target_and_frames_without_annotation_keep_the_state() {
        let n = f64::NAN;
        assert_eq!(events(&[1.0, 1.0, 0.2, 1.0, 1.0]), [3]);
        assert_eq!(events(&[0.1, n, 1.0, n, 1.0, n, 0.5, 1.0]), [2, 7]);
    }
}
