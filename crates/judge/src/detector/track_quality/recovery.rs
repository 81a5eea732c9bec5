//! The recovery check, which tests if a tracker that is locked on again follows its target (SanMiguel,
//! Cavallaro and Martinez, IEEE TIP 21(5), 2012; the time-reversibility constraint).
//!
//! ```text
//! accepted   <=>   frame - reference <= reverse_limit  and  e < tau_4
//! ```
//!
//! `e`, without unit and in `[0, 1]`, 0 best, is the tracking error in frame `reference` between the estimate
//! on the way forward and that of the same tracker, run back from `frame` with its state of that frame
//! ([`Reverse::error`]); both frames count from 0. `reference` is the last frame before the track was lost.
//!
//! Paper to code: tau_4 is `accept_below`, 0.8, the default in the authors' released program; that it is this
//! threshold is an inference, and comparing one frame by tracking error is a reconstruction. Choices:
//!
//! * if the reference is more than `reverse_limit` frames back, the check is rejected without a run. A later
//!   frame would be near enough, but it belongs to the doubtful track, which would be compared with itself;
//! * without a tracker that runs backwards, or when its run breaks, the check is rejected.

use super::{Check, Rules};
use crate::detector::Reverse;

impl Rules {
    /// Checks in `frame` if the tracker follows the target of the earlier frame `reference` again.
    pub(super) fn check(&self, reverse: Option<&dyn Reverse>, frame: usize, reference: usize) -> Check {
        let near = frame.saturating_sub(reference) <= self.reverse_limit;
        let error = reverse.filter(|_| near).and_then(|reverse| reverse.error(frame, reference));
        Check { frame, reference, error, accepted: error.is_some_and(|e| e < self.accept_below) }
    }
}

#[cfg(test)]
mod tests {
    use super::super::testing::Fake;
    use super::*;

    const RULES: Rules =
        Rules { accept_below: 0.8, reverse_limit: 200, locking_in_limit: 25, reference_lag: 1 };

    // The error at the reference decides. Beyond the limit of 200 frames nothing is run.
    #[test]
    fn checks_by_hand() {
        let of = |answer: Option<f64>, frame: usize| {
            let reverse = Fake::always(answer);
            let check = RULES.check(Some(&reverse), frame, 10);
            assert_eq!((check.frame, check.reference), (frame, 10));
            (check.error.map(f64::to_bits), check.accepted, reverse.asked())
        };
        for (error, accepted) in [(0.0, true), (0.79, true), (0.8, false), (1.0, false), (f64::NAN, false)] {
            assert_eq!(of(Some(error), 30), (Some(error.to_bits()), accepted, vec![(30, 10)]), "{error}");
        }
        assert_eq!(of(None, 19), (None, false, vec![(19, 10)]));
        assert_eq!(of(Some(0.0), 210), (Some(0), true, vec![(210, 10)]));
        assert_eq!(of(Some(0.0), 211), (None, false, vec![]));
        let none = Check { frame: 19, reference: 10, error: None, accepted: false };
        assert_eq!(RULES.check(None, 19, 10), none);
    }
}
