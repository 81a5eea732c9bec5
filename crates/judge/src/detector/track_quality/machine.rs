//! The condition of a tracker as a state machine (SanMiguel, Cavallaro and Martinez, IEEE TIP 21(5), 2012).
//!
//! ```text
//! LOCKED-ON   large increase   SCANNING     the track is lost
//! SCANNING    large increase   SCANNING
//! SCANNING    large decrease   LOCKED-ON    recovery check
//! SCANNING    small decrease   LOCKING-IN
//! LOCKING-IN  large increase   SCANNING
//! LOCKING-IN  large decrease   LOCKED-ON    recovery check
//! LOCKING-IN  waiting over     LOCKED-ON    recovery check
//! ```
//!
//! The machine begins LOCKED-ON with a successful track. In each (0-based) frame only the first matching row
//! is applied. A successful track that is lost becomes unsuccessful, and the frame before becomes the
//! reference; an unsuccessful track keeps its reference. An accepted check makes the track successful. A
//! rejected check leaves it unsuccessful and LOCKED-ON, on a distractor, until the next increase and decrease
//! cause another check.
//!
//! Source: the three conditions, the two statuses and the recovery check are the paper's, the meanings of the
//! three thresholds those of SanMiguel and Cavallaro, CVIU 131, 2015, section 6. The table is a
//! reconstruction, as the paper's own was not at hand. Its choices:
//!
//! * LOCKING-IN ends after `locking_in_limit` frames without an increase (`waiting over`), as a slow
//!   re-acquisition, which is never a large decrease, would not be checked otherwise;
//! * increases come before decreases. After a rise and half a fall the uncertainty can be well above the
//!   least and well below the largest of one window; the tracker is then not taken to be locked on again.
//!   This is what the second row is for: without it the machine would swing between LOCKED-ON and SCANNING
//!   as long as both are in the window, with a check against an ever later reference each time;
//! * the reference is the last frame before the change (`reference_lag` = 1). A change that is noticed late
//!   has its reference in the track that is lost already, where the way back may lead as well. On the
//!   stand-ins for D1 and D2 a lag of 25 frames is no better (`sanmiguel2015/table4`): checks are accepted wrongly
//!   because particles that are spread widely find the target again on their way back;
//! * large decreases come before small ones of the same frame, and before the end of waiting.

use super::Condition::{self, LockedOn, LockingIn, Scanning};
use super::Rules;

/// An event of a frame that the machine reacts to.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Event {
    /// The uncertainty has risen strongly: from consistent to inconsistent.
    LargeIncrease,
    /// The uncertainty has fallen strongly: from inconsistent to consistent.
    LargeDecrease,
    /// The uncertainty has fallen slightly: the hypotheses become more accurate.
    SmallDecrease,
    /// LOCKING-IN has reached its time limit.
    WaitingOver,
}

impl Event {
    /// Name of the event in files and figures.
    pub fn name(self) -> &'static str {
        match self {
            Self::LargeIncrease => "large increase",
            Self::LargeDecrease => "large decrease",
            Self::SmallDecrease => "small decrease",
            Self::WaitingOver => "waiting over",
        }
    }
}

/// Whether each of the first three events happens in a frame, in their order; the machine itself knows the last one.
pub type Events = [bool; 3];

/// Action that a transition takes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Action {
    /// A successful track becomes unsuccessful, and the frame before becomes the reference.
    Lose,
    /// Recovery check: the track becomes successful if the check is accepted, else unsuccessful.
    Check,
    /// No action.
    Nothing,
}

impl Action {
    /// Name of the action in files and figures.
    pub fn name(self) -> &'static str {
        match self {
            Self::Lose => "track lost",
            Self::Check => "recovery check",
            Self::Nothing => "nothing",
        }
    }
}

/// A transition: one row of the table.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Transition {
    /// The condition before.
    pub from: Condition,
    /// The event that triggers it.
    pub on: Event,
    /// The condition from this frame on.
    pub to: Condition,
    /// Action of the transition.
    pub then: Action,
}

const fn row(from: Condition, on: Event, to: Condition, then: Action) -> Transition {
    Transition { from, on, to, then }
}

/// Table of transitions. In each frame the first matching row is applied.
pub static TRANSITIONS: &[Transition] = &[
    row(LockedOn, Event::LargeIncrease, Scanning, Action::Lose),
    row(Scanning, Event::LargeIncrease, Scanning, Action::Nothing),
    row(Scanning, Event::LargeDecrease, LockedOn, Action::Check),
    row(Scanning, Event::SmallDecrease, LockingIn, Action::Nothing),
    row(LockingIn, Event::LargeIncrease, Scanning, Action::Nothing),
    row(LockingIn, Event::LargeDecrease, LockedOn, Action::Check),
    row(LockingIn, Event::WaitingOver, LockedOn, Action::Check),
];

/// Condition of a tracker and status of its track, from frame to frame.
#[derive(Debug, Clone)]
pub(super) struct Machine {
    rules: Rules,
    /// Condition after the last step.
    pub condition: Condition,
    /// True if the track is successful after the last step.
    pub successful: bool,
    /// Reference frame of checks, before the track was lost; 0 if it never was.
    reference: usize,
    locking_in_since: usize,
}

impl Machine {
    /// Starts LOCKED-ON and successful, with frame 0 as reference.
    pub fn new(rules: Rules) -> Self {
        Self { rules, condition: LockedOn, successful: true, reference: 0, locking_in_since: 0 }
    }

    /// Processes the events of frame `t`, which increases from step to step, and returns the index of the row
    /// that was applied. For a recovery check, `check` is called with the reference frame and returns true to
    /// accept.
    pub fn step(&mut self, t: usize, events: Events, check: impl FnOnce(usize) -> bool) -> Option<usize> {
        let Rules { locking_in_limit: limit, reference_lag: lag, .. } = self.rules;
        let waited = self.condition == LockingIn && t.saturating_sub(self.locking_in_since) >= limit;
        let happens = |event: Event| events.get(event as usize).copied().unwrap_or(waited);
        let place = TRANSITIONS.iter().position(|r| r.from == self.condition && happens(r.on))?;
        let row = TRANSITIONS[place];
        match row.then {
            Action::Lose if self.successful => {
                self.successful = false;
                self.reference = t.saturating_sub(lag);
            }
            Action::Check => self.successful = check(self.reference),
            Action::Lose | Action::Nothing => {}
        }
        if row.to == LockingIn {
            self.locking_in_since = t;
        }
        self.condition = row.to;
        Some(place)
    }
}

#[cfg(test)]
mod tests;
