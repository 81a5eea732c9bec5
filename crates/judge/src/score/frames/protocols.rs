//! Protocols `frames/1`, `frames-clear/1`, `range/1` and `nab/1`: counts of alarms against lost frames or losses.
//!
//! * `frames/1` and `frames-clear/1` count frames: TP are lost frames with an alarm, FP good frames with one, FN lost
//!   frames without, TN good frames without. What is lost and good is in [`super::truth`]; other frames do not count. Events
//!   are the losses.
//! * `range/1` and `nab/1` count ranges: TP are ranges of lost frames in whose first 16 frames a run of alarms begins, FN
//!   the others; FP are all other runs of alarms, also those that begin later in a range or a second time; TN are the
//!   frames that are left. `nab/1` leaves the frames of probation out ([`super::nab`]); what goes on when they end begins
//!   there.
//! * In all of them a detection is the first frame of a run of alarms, and it matches an event when it is the first one in
//!   the event's frame or up to 15 frames after it, while the target is lost.
//!
//! The measures of the same names ([`super::ranking`], [`super::range`], [`super::nab`]) are not made of
//! these counts. An alarm counts for its own frame, or for one loss, never for all frames of a loss.

use super::super::restarts::Restarts;
use super::alarms::{WITHIN, first_frames};
use super::nab::probation;
use super::truth::{Rule, runs};
use crate::detector::run_starts;
use crate::score::chance::Chance;
use crate::score::counts::Place;
use crate::score::protocol::{Protocol, TrackScore};
use std::ops::Range;

/// Protocol `frames/1`.
pub const FRAMES: Protocol = Protocol {
    name: "frames/1",
    summary: "frame by frame: alarms against frames without overlap",
    positives: "lost frames",
    frame: Some(|error, alarm| place(Rule::NoOverlap, error, alarm)),
    restarts: Restarts::PartOfTrack,
    chance: Chance::within(0),
    score: |error, alarm, _| score_frames(Rule::NoOverlap, error, alarm),
};

/// Protocol `frames-clear/1`.
pub const FRAMES_CLEAR: Protocol = Protocol {
    name: "frames-clear/1",
    summary: "frame by frame: alarms against frames with an overlap below 0.1; from there to 0.5 none counts",
    frame: Some(|error, alarm| place(Rule::Clear, error, alarm)),
    score: |error, alarm, _| score_frames(Rule::Clear, error, alarm),
    ..FRAMES
};

/// Protocol `range/1`.
pub const RANGE: Protocol = Protocol {
    name: "range/1",
    summary: "ranges without overlap against runs of alarms that begin in their first 16 frames",
    positives: "losses",
    frame: None,
    restarts: Restarts::PartOfTrack,
    chance: Chance::after(WITHIN),
    score: |error, alarm, _| score_ranges(&Rule::NoOverlap.lost(error), alarm, 0),
};

/// Protocol `nab/1`.
pub const NAB: Protocol = Protocol {
    name: "nab/1",
    summary: "as range/1, without the first 15 % of each track",
    score: |error, alarm, _| score_ranges(&Rule::NoOverlap.lost(error), alarm, probation(error.len())),
    ..RANGE
};

/// Matches ranges (with frames from `first` on) and detections: each range with the first detection in its
/// first frames.
fn matches(ranges: &[Range<usize>], detections: &[usize]) -> Vec<(usize, usize)> {
    let found = |(k, range): (usize, &Range<usize>)| {
        let first = detections.partition_point(|d| *d < range.start);
        detections.get(first).filter(|d| first_frames(range).contains(d)).map(|_| (k, first))
    };
    ranges.iter().enumerate().filter_map(found).collect()
}

/// Count of a frame by a rule; `None` if the frame does not count.
fn place(rule: Rule, error: f64, alarm: bool) -> Option<Place> {
    Some(Place::of(rule.judge(error)?, alarm))
}

fn score_frames(rule: Rule, error: &[f64], alarm: &[bool]) -> TrackScore {
    let counts = error.iter().zip(alarm).filter_map(|(e, alarm)| place(rule, *e, *alarm)).collect();
    let (losses, detections) = (rule.losses(error), run_starts(alarm));
    let matches = matches(&losses, &detections);
    TrackScore { counts, events: losses.into_iter().map(|l| l.start).collect(), detections, matches }
}

/// Counts of ranges. Frames before `first` do not count.
fn score_ranges(lost: &[bool], alarm: &[bool], first: usize) -> TrackScore {
    let from = |frames: &[bool]| frames.get(first..).unwrap_or_default().to_vec();
    let (ranges, starts) = (runs(&from(lost)), run_starts(&from(alarm)));
    let matches = matches(&ranges, &starts);
    let events = ranges.into_iter().map(|r| r.start + first).collect();
    let detections = starts.into_iter().map(|t| t + first).collect();
    TrackScore::of_matches(first..lost.len(), events, detections, matches)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::score::testing::{counts, error, set};

    // By hand: 100 frames, lost in 20-49 and 80-89, alarms in 15-24 (begins too early), 36-39 (the sixteenth frame after
    // 20 is 35), 85-99.
    #[test]
    fn counts_a_hand_worked_track() {
        let (error, alarm) = (error(100, &[[20, 50], [80, 90]]), set(100, &[[15, 25], [36, 40], [85, 100]]));
        let s = (FRAMES.score)(&error, &alarm, &[]);
        assert_eq!(s.counts, counts(5 + 4 + 5, 5 + 10, 26, 45));
        assert_eq!((s.events, s.detections, s.matches), (vec![20, 80], vec![15, 36, 85], vec![(1, 2)]));
        let s = (RANGE.score)(&error, &alarm, &[]);
        assert_eq!(s.counts, counts(1, 2, 1, 96));
        assert_eq!((s.events, s.matches), (vec![20, 80], vec![(1, 2)]));
        // From frame 15 on the first alarm begins in frame 15 of the track.
        let s = (NAB.score)(&error, &alarm, &[]);
        assert_eq!(s.counts, counts(1, 2, 1, 81));
        assert_eq!((s.events, s.detections), (vec![20, 80], vec![15, 36, 85]));
    }

    // By hand: errors .95 (an IoU of .03) are lost, .6 (.25) do not count, .2 (.67) are good.
    #[test]
    fn frames_of_little_overlap_are_lost_or_left_out() {
        let error = [0.2, 0.95, 0.6, 0.6, 0.2, f64::NAN];
        let s = (FRAMES_CLEAR.score)(&error, &[false, true, true, false, true, true], &[]);
        assert_eq!(s.counts, counts(1, 1, 0, 1));
        assert_eq!((s.events, s.matches), (vec![1], vec![(0, 0)]));
        let s = (FRAMES.score)(&error, &[false, true, true, false, true, true], &[]);
        assert_eq!(s.counts, counts(0, 3, 0, 2));
    }

    // An alarm in one of 50 lost frames finds one frame, or one range, and not 50 frames.
    #[test]
    fn one_alarm_does_not_stand_for_a_whole_loss() {
        let (error, alarm) = (error(100, &[[30, 80]]), set(100, &[[40, 41]]));
        assert_eq!((FRAMES.score)(&error, &alarm, &[]).counts, counts(1, 0, 49, 50));
        assert_eq!((RANGE.score)(&error, &alarm, &[]).counts, counts(1, 0, 0, 99));
    }
}
