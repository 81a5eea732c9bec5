//! Protocols `sanmiguel2015/1` and `sanmiguel2015-unsigned/1`: detection of changes between consistent and
//! inconsistent tracking (SanMiguel and Cavallaro, CVIU 131, 2015, Section 7, Eq. 18-23).
//!
//! * Error: e_t = 1 - Dice (Eq. 18); the tracker is inconsistent where e_t = 1 (Eq. 19). Frames without
//!   annotation keep the state before them, and a track is consistent until its first annotation.
//! * Event: d_t = e^b_t - e^b_(t-1) for t > 0 (Eq. 20), +1 from consistent to inconsistent, -1 back. As
//!   d_0 = 0, a track that is lost in its first frame has no event there, but one, of -1, when it is found.
//! * Detection: every change that the detector reports, of both signs, also in the first frame.
//! * Matching: one-to-one within 5 frames, nearest first, then earliest ([`super::matching`]); a detection
//!   can match events of its own sign only. The `unsigned` protocol ignores the signs.
//! * TP = matched pairs, FP = unmatched detections, FN = unmatched events.
//! * TN = the remaining frames from the second on: those that are neither a detection nor an unmatched
//!   event. The paper gives none; precision, recall and F do not use them.
//!
//! Measures pool these counts over a suite. The paper does not say how it pairs detections with
//! changes beyond the window of 5 frames; signs are the likely reading, since it names both directions. Nearest
//! first takes the best pair, not the most pairs, so the unsigned protocol can find fewer than the signed
//! one where changes of both signs are within 10 frames, though never less than half.

use super::chance::Chance;
use super::frames::truth::Rule;
use super::matching;
use super::protocol::{Protocol, TrackScore};
use super::restarts::Restarts;
use crate::detector::changes;

/// Protocol `sanmiguel2015/1`, which matches only changes of the same sign.
pub const SIGNED: Protocol = Protocol {
    name: "sanmiguel2015/1",
    summary: "changes of both signs against those of e_t = 1, one-to-one by sign within 5 frames",
    positives: "events",
    frame: None,
    restarts: Restarts::PartOfTrack,
    chance: Chance { is_signed: true, ..Chance::within(TOLERANCE) },
    score: |error, _, changes| score(error, changes, &[1, -1]),
};

/// Protocol `sanmiguel2015-unsigned/1`, which ignores signs.
pub const UNSIGNED: Protocol = Protocol {
    name: "sanmiguel2015-unsigned/1",
    summary: "as sanmiguel2015/1, but a detection may match a change of either sign",
    chance: Chance::within(TOLERANCE),
    score: |error, _, changes| score(error, changes, &[0]),
    ..SIGNED
};

/// Largest distance in frames at which a detection matches an event, before or after it.
pub const TOLERANCE: usize = 5;

/// Change into each frame (Eq. 20): +1 where the target is lost, -1 where it is found, 0 elsewhere.
///
/// `error` has one tracking error per frame in `[0, 1]`, NaN without annotation.
pub fn events(error: &[f64]) -> Vec<i32> {
    let mut events = changes(&Rule::NoOverlap.lost(error));
    if let Some(first) = events.first_mut() {
        *first = 0;
    }
    events
}

/// Frames in which the change has this sign; sign 0 stands for both.
fn frames(changes: &[i32], sign: i32) -> Vec<usize> {
    let is_it = |change: i32| change != 0 && (sign == 0 || change.signum() == sign);
    (0..changes.len()).filter(|t| is_it(changes[*t])).collect()
}

/// Matches changes of each sign in `signs` separately; sign 0 stands for both together.
fn score(error: &[f64], changes: &[i32], signs: &[i32]) -> TrackScore {
    let truth = events(error);
    let (events, detections) = (frames(&truth, 0), frames(changes, 0));
    let mut matches = Vec::new();
    for &sign in signs {
        let (e, d) = (frames(&truth, sign), frames(changes, sign));
        let place = |all: &[usize], frame: usize| all.partition_point(|t| *t < frame);
        let pairs = matching::match_nearest(&e, &d, TOLERANCE).into_iter();
        matches.extend(pairs.map(|(i, j)| (place(&events, e[i]), place(&detections, d[j]))));
    }
    matches.sort_unstable();
    TrackScore::of_matches(1..error.len(), events, detections, matches)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::score::testing::{counts, error, track};
    use proptest::prelude::*;

    fn reported(length: usize, at: &[(usize, i32)]) -> Vec<i32> {
        let mut changes = vec![0; length];
        at.iter().for_each(|(t, sign)| changes[*t] = *sign);
        changes
    }

    // By hand on 60 frames: events +20, -30, +45. Of the detections, +19 matches 20, where +18 is farther
    // away, and -34 matches 30; -46 is next to +45 but of the other sign, and +55 is too late for it.
    // TN = 59 frames - 5 detections - 1 missed event.
    #[test]
    fn counts_a_hand_worked_track() {
        let changes = reported(60, &[(18, 1), (19, 1), (34, -1), (46, -1), (55, 1)]);
        let error = error(60, &[[20, 30], [45, 60]]);
        let s = (SIGNED.score)(&error, &[], &changes);
        assert_eq!(s.events, [20, 30, 45]);
        assert_eq!(s.detections, [18, 19, 34, 46, 55]);
        assert_eq!(s.matches, [(0, 1), (1, 2)]);
        assert_eq!(s.counts, counts(2, 3, 1, 53));
        let s = (UNSIGNED.score)(&error, &[], &changes);
        assert_eq!(s.matches, [(0, 1), (1, 2), (2, 3)]);
        assert_eq!(s.counts, counts(3, 2, 0, 54));
    }

    // By hand: a missed event in the frame of a false detection is one frame that is not silent.
    #[test]
    fn a_frame_is_counted_once() {
        let s = (SIGNED.score)(&error(40, &[[20, 40]]), &[], &reported(40, &[(20, -1)]));
        assert_eq!(s.counts, counts(0, 1, 1, 38));
    }

    #[test]
    fn a_found_target_is_an_event_and_frames_without_annotation_keep_the_state() {
        let n = f64::NAN;
        assert_eq!(events(&[1.0, 1.0, 0.2, 1.0, 1.0]), [0, 0, -1, 1, 0]);
        assert_eq!(events(&[0.1, n, 1.0, n, 1.0, n, 0.5, 1.0]), [0, 0, 1, 0, 0, 0, -1, 1]);
        assert_eq!(events(&[n, 1.0, n, 0.0]), [0, 1, 0, -1]);
    }

    // By hand: events +10 and -16, detections +6 and -12. By sign both pairs are 4 apart; without, 10 and
    // 12 are nearest, and 6 and 16 are left alone.
    #[test]
    fn signs_can_help_the_greedy_matching() {
        let error = error(40, &[[10, 16]]);
        let changes = reported(40, &[(6, 1), (12, -1)]);
        assert_eq!((SIGNED.score)(&error, &[], &changes).counts.tp, 2);
        assert_eq!((UNSIGNED.score)(&error, &[], &changes).counts.tp, 1);
    }

    proptest! {
        #[test]
        fn swapping_the_signs_of_both_changes_nothing((mut error, _, changes) in track()) {
            // The start has no sign to be swapped.
            error.insert(0, 0.2);
            let changes = [vec![0], changes].concat();
            let turned: Vec<f64> = error.iter().map(|e| if *e == 1.0 { 0.2 } else { e * 5.0 }).collect();
            let negated: Vec<i32> = changes.iter().map(|c| -c).collect();
            for protocol in [SIGNED, UNSIGNED] {
                let score = (protocol.score)(&error, &[], &changes);
                prop_assert_eq!(score, (protocol.score)(&turned, &[], &negated));
            }
        }

        #[test]
        fn signs_are_kept((error, _, changes) in track()) {
            let truth = events(&error);
            let signed = (SIGNED.score)(&error, &[], &changes);
            let unsigned = (UNSIGNED.score)(&error, &[], &changes);
            for (event, detection) in &signed.matches {
                prop_assert_eq!(truth[signed.events[*event]], changes[signed.detections[*detection]]);
            }
            // Both are maximal, and the signed pairs are pairs of the unsigned protocol, too.
            prop_assert!(2 * unsigned.counts.tp >= signed.counts.tp);
        }
    }
}
