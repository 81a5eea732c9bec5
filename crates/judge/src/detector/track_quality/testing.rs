//! Helpers of the tests of both detectors: a tracker that runs backwards by script, and short words.

use super::machine::{Events, Machine, TRANSITIONS};
use super::{Condition, Quality};
use crate::detector::Reverse;
use std::cell::RefCell;

/// Runs backwards by script and remembers what it was asked.
pub struct Fake {
    answer: Box<dyn Fn(usize, usize) -> Option<f64>>,
    asked: RefCell<Vec<(usize, usize)>>,
}

impl Fake {
    /// The answer is a function of the frames `from` and `to`.
    pub fn new(answer: impl Fn(usize, usize) -> Option<f64> + 'static) -> Self {
        Self { answer: Box::new(answer), asked: RefCell::default() }
    }

    /// The same answer to everything.
    pub fn always(answer: Option<f64>) -> Self {
        Self::new(move |_, _| answer)
    }

    /// The frames `from` and `to` of every question.
    pub fn asked(&self) -> Vec<(usize, usize)> {
        self.asked.borrow().clone()
    }
}

impl Reverse for Fake {
    fn error(&self, from: usize, to: usize) -> Option<f64> {
        self.asked.borrow_mut().push((from, to));
        (self.answer)(from, to)
    }
}

/// A letter a frame: `o` for LOCKED-ON, `i` for LOCKING-IN, `s` for SCANNING.
pub fn letters(quality: &Quality) -> String {
    let letter = |c: &Condition| match c {
        Condition::LockedOn => 'o',
        Condition::LockingIn => 'i',
        Condition::Scanning => 's',
    };
    quality.condition.iter().map(letter).collect()
}

/// A letter a frame: `x` for an alarm, `.` for none.
pub fn marks(alarm: &[bool]) -> String {
    alarm.iter().map(|a| if *a { 'x' } else { '.' }).collect()
}

/// The rows of [`TRANSITIONS`] that these events take a machine through, with a check's answer from
/// `quality`; the conditions must be those in `quality`.
pub fn rows(locking_in_limit: usize, events: &[Events], quality: &Quality) -> Vec<usize> {
    let mut machine = Machine::new(locking_in_limit, 1);
    let mut used = Vec::new();
    for (t, events) in events.iter().enumerate() {
        let accepted = |_| quality.checks.iter().any(|c| c.frame == t && c.accepted);
        if let Some(row) = machine.step(t, *events, accepted) {
            used.extend(TRANSITIONS.iter().position(|r| r == row));
        }
        assert_eq!(machine.condition(), quality.condition[t], "frame {t}");
    }
    used
}
