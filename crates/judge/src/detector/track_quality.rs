//! Track quality without ground truth: the condition of a tracker, and if its track can be trusted
//! (SanMiguel, Cavallaro and Martinez, IEEE TIP 21(5), 2012; SanMiguel and Cavallaro, CVIU 131, 2015, section
//! 6). Shared by `arte` and `arte-star`.
//!
//! # Recovery checks
//!
//! A check tests if a tracker that is locked on again follows its target (SanMiguel,
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

pub mod machine;

#[cfg(test)]
pub(super) mod testing;

use super::{DetectorOutput, Input, Reverse};
use crate::plugin::Range;
use machine::{Events, Machine};
use serde::{Deserialize, Serialize};

/// Condition of a tracker, estimated from its uncertainty.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub enum Condition {
    /// The tracker follows something: its target or, on an unsuccessful track, something else.
    LockedOn,
    /// The hypotheses of the tracker converge.
    LockingIn,
    /// The hypotheses of the tracker are spread while it searches for the target.
    Scanning,
}

impl Condition {
    /// Number of the condition in files and figures.
    pub fn level(self) -> f64 {
        match self {
            Self::LockedOn => 1.0,
            Self::LockingIn => 0.5,
            Self::Scanning => 0.0,
        }
    }

    /// Name of the condition in files and figures.
    pub fn name(self) -> &'static str {
        match self {
            Self::LockedOn => "locked-on",
            Self::LockingIn => "locking-in",
            Self::Scanning => "scanning",
        }
    }
}

/// A recovery check, which runs the tracker backwards to test if it has recovered.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Check {
    /// Frame in which the check was made, from 0.
    pub frame: usize,
    /// Frame to which the run goes back, the last one before the track was lost; from 0.
    pub reference: usize,
    /// Tracking error in that frame between the forward and the backward run, in `[0, 1]`; `None` without a
    /// run.
    pub error: Option<f64>,
    /// True if the track counts as successful again.
    pub accepted: bool,
}

/// Steps by which a detector arrived at its labels.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Quality {
    /// Condition in each frame.
    pub condition: Vec<Condition>,
    /// Recovery checks, in order of frames.
    pub checks: Vec<Check>,
    /// Frames in which a row of the [table](machine::TRANSITIONS) was applied, with the index of the row.
    pub transitions: Vec<(usize, usize)>,
}

impl Quality {
    /// Number and length of the runs backwards.
    pub fn effort(&self) -> Effort {
        let run = self.checks.iter().filter(|c| c.error.is_some());
        run.map(|c| Effort { runs: 1, frames: (c.frame - c.reference) as u64 }).sum()
    }
}

/// Amount of runs backwards in time.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Effort {
    /// Number of runs.
    pub runs: u64,
    /// Number of frames of all runs together.
    pub frames: u64,
}

impl std::iter::Sum for Effort {
    fn sum<I: Iterator<Item = Self>>(all: I) -> Self {
        all.fold(Self::default(), |a, b| Self { runs: a.runs + b.runs, frames: a.frames + b.frames })
    }
}

/// Range of `accept_below`; the ranges of the other shared parameters follow.
pub(super) const ACCEPT_BELOW: Range = Range::of("accept_below").above(0.0).at_most(1.0);
pub(super) const REVERSE_LIMIT: Range = Range::within("reverse_limit", 0.0, 100_000.0);
pub(super) const LOCKING_IN_LIMIT: Range = Range::within("locking_in_limit", 1.0, 100_000.0);
pub(super) const REFERENCE_LAG: Range = Range::within("reference_lag", 1.0, 100_000.0);

/// Settings of the state machine and of its recovery checks.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Rules {
    /// Error below which a check is accepted, tau_4.
    pub accept_below: f64,
    /// Most frames of a run backwards.
    pub reverse_limit: usize,
    /// Number of frames from the first of LOCKING-IN after which it ends.
    pub locking_in_limit: usize,
    /// Number of frames from the reference of a check to the frame in which the track was lost; 1 is the last one before it.
    pub reference_lag: usize,
}

impl Rules {
    /// Labels each frame of an unsuccessful track and records the steps. `events` has one entry per frame.
    pub(super) fn follow(
        &self,
        input: &Input<'_>,
        (score, events): (Vec<f64>, Vec<Events>),
    ) -> DetectorOutput {
        let mut machine = Machine::new(*self);
        let mut quality = Quality::default();
        let mut alarm = Vec::with_capacity(events.len());
        for (t, events) in events.into_iter().enumerate() {
            let row = machine.step(t, events, |reference| {
                let check = self.check(input.reverse, t, reference);
                quality.checks.push(check);
                check.accepted
            });
            quality.transitions.extend(row.map(|row| (t, row)));
            quality.condition.push(machine.condition);
            alarm.push(!machine.successful);
        }
        DetectorOutput { score, alarm, quality: Some(quality), ..DetectorOutput::default() }
    }

    /// Checks in `frame` if the tracker follows the target of the earlier frame `reference` again.
    fn check(&self, reverse: Option<&dyn Reverse>, frame: usize, reference: usize) -> Check {
        let near = frame.saturating_sub(reference) <= self.reverse_limit;
        let error = reverse.filter(|_| near).and_then(|reverse| reverse.error(frame, reference));
        Check { frame, reference, error, accepted: error.is_some_and(|e| e < self.accept_below) }
    }
}

#[cfg(test)]
mod tests {
    use super::testing::Fake;
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
