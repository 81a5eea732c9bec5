//! Track quality without ground truth: the condition of a tracker, and whether its track can be trusted
//! (SanMiguel, Cavallaro and Martinez, IEEE TIP 21(5), 2012; SanMiguel and Cavallaro, CVIU 131, 2015,
//! section 6). Shared by `arte` and `arte-star`.

pub mod machine;
pub mod recovery;

#[cfg(test)]
pub(super) mod testing;

use super::Input;
use crate::plugin::Range;
use machine::{Events, Machine, TRANSITIONS};
use recovery::Recovery;
use serde::{Deserialize, Serialize};

/// The condition of a tracker.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub enum Condition {
    /// It follows something: its target or, while the track is unsuccessful, something else.
    LockedOn,
    /// Its hypotheses draw together.
    LockingIn,
    /// Its hypotheses are spread; it looks for its target.
    Scanning,
}

impl Condition {
    /// Its number in files and figures.
    pub fn level(self) -> f64 {
        match self {
            Self::LockedOn => 1.0,
            Self::LockingIn => 0.5,
            Self::Scanning => 0.0,
        }
    }

    /// Its name in files and figures.
    pub fn name(self) -> &'static str {
        match self {
            Self::LockedOn => "locked-on",
            Self::LockingIn => "locking-in",
            Self::Scanning => "scanning",
        }
    }
}

/// A recovery check: whether the tracker has recovered, by a run backwards.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Check {
    /// The frame in which it was made, from 0.
    pub frame: usize,
    /// The frame that the run goes back to, the last one before the track was lost; from 0.
    pub reference: usize,
    /// Tracking error in that frame between the way forward and the way back, in `[0, 1]`; `None` without a run.
    pub error: Option<f64>,
    /// Whether the track counts as successful again.
    pub accepted: bool,
}

/// The steps by which a detector came to its labels.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Quality {
    /// The condition in each frame.
    pub condition: Vec<Condition>,
    /// The checks, in order of frames.
    pub checks: Vec<Check>,
    /// Frames in which a row of the [table](machine::TRANSITIONS) was taken, with the row.
    pub transitions: Vec<(usize, usize)>,
}

impl Quality {
    /// The runs of the tracker backwards.
    pub fn effort(&self) -> Effort {
        let run = self.checks.iter().filter(|c| c.error.is_some());
        run.map(|c| Effort { runs: 1, frames: (c.frame - c.reference) as u64 }).sum()
    }
}

/// Runs of trackers backwards in time.
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

/// Ranges of the parameters that the detectors share.
pub(super) const ACCEPT_BELOW: Range = Range::of("accept_below").above(0.0).at_most(1.0);
pub(super) const REVERSE_LIMIT: Range = Range::within("reverse_limit", 0.0, 100_000.0);
pub(super) const LOCKING_IN_LIMIT: Range = Range::within("locking_in_limit", 1.0, 100_000.0);
pub(super) const REFERENCE_LAG: Range = Range::within("reference_lag", 1.0, 100_000.0);

/// Settings of the machine and of its recovery checks.
#[derive(Debug, Clone, Copy)]
pub(super) struct Rules {
    recovery: Recovery,
    locking_in_limit: usize,
    reference_lag: usize,
}

impl Rules {
    /// Rules for parameters that are in their ranges.
    pub(super) fn new(
        accept_below: f64,
        reverse_limit: usize,
        locking_in_limit: usize,
        reference_lag: usize,
    ) -> Self {
        Self { recovery: Recovery { accept_below, reverse_limit }, locking_in_limit, reference_lag }
    }

    /// Labels each frame whether the track is unsuccessful, and gives the steps that led there; as long as `events`.
    pub(super) fn follow(&self, input: &Input<'_>, events: &[Events]) -> (Vec<bool>, Quality) {
        let mut machine = Machine::new(self.locking_in_limit, self.reference_lag);
        let mut quality = Quality::default();
        let mut alarm = Vec::with_capacity(events.len());
        for (t, events) in events.iter().enumerate() {
            let row = machine.step(t, *events, |reference| {
                let check = self.recovery.check(input.reverse, t, reference);
                quality.checks.push(check);
                check.accepted
            });
            let place = row.and_then(|row| TRANSITIONS.iter().position(|known| known == row));
            quality.transitions.extend(place.map(|place| (t, place)));
            quality.condition.push(machine.condition());
            alarm.push(!machine.successful());
        }
        (alarm, quality)
    }
}
