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

use super::Check;
use crate::detector::Reverse;

/// Settings of recovery checks.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Recovery {
    /// Error below which a check is accepted, tau_4.
    pub accept_below: f64,
    /// Most frames of a run backwards.
    pub reverse_limit: usize,
}

impl Recovery {
    /// Checks in `frame` if the tracker follows the target of the earlier frame `reference` again.
    pub fn check(&self, reverse: Option<&dyn Reverse>, frame: usize, reference: usize) -> Check {
        let near = frame.saturating_sub(reference) <= self.reverse_limit;
        let error = reverse.filter(|_| near).and_then(|reverse| reverse.error(frame, reference));
        Check { frame, reference, error, accepted: error.is_some_and(|e| e < self.accept_below) }
    }
}

#[cfg(test)]
mod tests {
    use super::super::testing::Fake;
    use super::*;

    const RECOVERY: Recovery = Recovery { accept_below: 0.8, reverse_limit: 200 };

    #[test]
    fn the_error_at_the_reference_decides() {
        for (error, accepted) in [(0.0, true), (0.79, true), (0.8, false), (1.0, false), (f64::NAN, false)] {
            let reverse = Fake::always(Some(error));
            let check = RECOVERY.check(Some(&reverse), 30, 10);
            assert_eq!((check.frame, check.reference, check.accepted), (30, 10, accepted), "{error}");
            assert_eq!(check.error.map(f64::to_bits), Some(error.to_bits()));
            assert_eq!(reverse.asked(), [(30, 10)]);
        }
    }

    #[test]
    fn without_an_answer_or_beyond_the_limit_it_is_rejected() {
        let none = |frame| Check { frame, reference: 10, error: None, accepted: false };
        assert_eq!(RECOVERY.check(None, 19, 10), none(19));
        assert_eq!(RECOVERY.check(Some(&Fake::always(None)), 19, 10), none(19));
        let reverse = Fake::always(Some(0.0));
        assert!(RECOVERY.check(Some(&reverse), 210, 10).accepted);
        assert_eq!(RECOVERY.check(Some(&reverse), 211, 10), none(211));
        // Nothing was run for it.
        assert_eq!(reverse.asked(), [(210, 10)]);
    }
}
