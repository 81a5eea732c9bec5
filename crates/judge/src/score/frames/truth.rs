//! Frames that are lost, good or left out, and the ranges of lost frames.
//!
//! ```text
//! overlap (IoU) = d / (2 - d),   d = 1 - O_t
//! frames/1:        lost: O_t = 1                 good: every other frame
//! frames-clear/1:  lost: overlap < 0.1           good: overlap >= 0.5          left out: those between
//! ```
//!
//! `O_t` is the tracking error of [`super::super::overlap`] in `[0, 1]`; `t` is a 0-based frame. Frames without
//! annotation (NaN) are neither lost nor good; for ranges they have the state of the frame before them. Frames that are
//! left out end a range. A loss is a range of lost frames after a frame that was not lost, as the events of
//! `khalid2016/1`: a track that begins lost has no loss until it was on target.

use std::ops::Range;

/// Overlap (IoU) below which a frame is lost by `frames-clear/1`.
pub const CLEARLY_LOST: f64 = 0.1;
/// Overlap (IoU) from which on a frame is good by `frames-clear/1`.
pub const CLEARLY_GOOD: f64 = 0.5;

/// A track with the output of a detector. Each list has one value per frame.
#[derive(Debug, Clone, Copy)]
pub struct ScoredTrack<'a> {
    /// Index of the sequence. Tracks of one sequence are drawn together in bootstrap samples.
    pub sequence: usize,
    /// Tracking error O_t, NaN where there is no ground truth.
    pub error: &'a [f64],
    /// Finite scores. High scores speak for a failure.
    pub score: &'a [f64],
    /// True in frames in which the detector alarms at its own threshold.
    pub alarm: &'a [bool],
}

/// Rule by which frames count as lost or good.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Rule {
    /// Rule of `frames/1`: lost without overlap.
    NoOverlap,
    /// Rule of `frames-clear/1`: lost or good if the overlap is clear.
    Clear,
}

impl Rule {
    /// True if a frame with this tracking error is lost; `None` if it is left out or not annotated.
    pub fn judge(self, error: f64) -> Option<bool> {
        let dice = 1.0 - error;
        let overlap = dice / (2.0 - dice);
        match self {
            _ if error.is_nan() => None,
            Self::NoOverlap => Some(error >= 1.0),
            Self::Clear if error >= 1.0 || overlap < CLEARLY_LOST => Some(true),
            Self::Clear if overlap < CLEARLY_GOOD => None,
            Self::Clear => Some(false),
        }
    }

    /// For each frame, true if the target is lost. A frame without annotation has the state of the frame
    /// before it.
    pub fn lost(self, error: &[f64]) -> Vec<bool> {
        let state = |lost: &mut bool, error: &f64| {
            if !error.is_nan() {
                *lost = self.judge(*error) == Some(true);
            }
            Some(*lost)
        };
        error.iter().scan(false, state).collect()
    }

    /// Ranges of lost frames that follow a frame that was not lost.
    pub fn losses(self, error: &[f64]) -> Vec<Range<usize>> {
        // A track that is lost in its first annotated frame was not on target before.
        let first = error.iter().position(|e| !e.is_nan());
        runs(&self.lost(error)).into_iter().filter(|run| Some(run.start) != first).collect()
    }
}

/// Ranges in which the flags are true.
pub fn runs(frames: &[bool]) -> Vec<Range<usize>> {
    let starts = crate::detector::run_starts(frames).into_iter();
    let end = |from: usize| frames[from..].iter().position(|set| !set).map_or(frames.len(), |n| from + n);
    starts.map(|from| from..end(from)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::score::khalid2016;
    use proptest::prelude::*;

    const N: f64 = f64::NAN;

    // By hand: IoU 0.1 is a Dice overlap of 2/11, IoU 0.5 one of 2/3.
    #[test]
    fn rules_at_their_borders() {
        let judged = |error: f64| [Rule::NoOverlap, Rule::Clear].map(|rule| rule.judge(error));
        let of_iou = |iou: f64| judged(1.0 - 2.0 * iou / (1.0 + iou));
        let (nearly_off, between, on) = ([Some(false), Some(true)], [Some(false), None], [Some(false); 2]);
        assert_eq!(judged(1.0), [Some(true); 2]);
        assert_eq!([0.001, 0.0999].map(of_iou), [nearly_off; 2]);
        assert_eq!([0.1001, 0.4999].map(of_iou), [between; 2]);
        assert_eq!([of_iou(0.5001), judged(0.0)], [on; 2]);
        // Neighboring numbers: no error has an overlap of exactly .1 or .5.
        for (error, nearer, farther) in [(9.0_f64 / 11.0, between, nearly_off), (1.0 / 3.0, on, between)] {
            let last =
                [error.next_down(), error, error.next_up()].into_iter().rfind(|e| judged(*e) == nearer);
            assert_eq!(last.map(|last| judged(last.next_up())), Some(farther), "{error}");
        }
        assert_eq!(judged(N), [None; 2]);
    }

    // By hand: 0.95 is an IoU of 0.026, 0.7 one of 0.18.
    #[test]
    fn losses_of_a_hand_worked_track() {
        let error = [1.0, 0.2, 0.95, 1.0, N, 0.95, 0.7, N, 1.0, N, 0.1];
        assert_eq!(Rule::NoOverlap.losses(&error), [3..5, 8..10]);
        assert_eq!(Rule::Clear.losses(&error), [2..6, 8..10]);
        assert_eq!(runs(&Rule::NoOverlap.lost(&error)), [0..1, 3..5, 8..10]);
        assert!(Rule::Clear.losses(&[]).is_empty() && Rule::Clear.losses(&[1.0, 1.0]).is_empty());
    }

    proptest! {
        // By the definition: frames that are lost where the annotated frame before was on target.
        #[test]
        fn losses_start_where_khalids_events_are(
            error in prop::collection::vec(prop_oneof![Just(1.0), Just(N), 0.0..1.0_f64], 0..60),
        ) {
            let was_on_target = |t: usize| error[..t].iter().rfind(|e| !e.is_nan()).is_some_and(|e| *e < 1.0);
            let starts: Vec<usize> = (0..error.len()).filter(|t| error[*t] >= 1.0 && was_on_target(*t)).collect();
            prop_assert_eq!(starts, khalid2016::events(&error));
        }
    }
}
