//! Helpers for tests of `arte` and `arte-star`: scripted reverse runs, and short texts.

use super::machine::{Events, Machine, TRANSITIONS};
use super::{Condition, Quality};
use crate::detector::Reverse;
use std::cell::RefCell;

/// Scripted reverse runs that record their calls.
pub struct Fake {
    answer: Box<dyn Fn(usize, usize) -> Option<f64>>,
    asked: RefCell<Vec<(usize, usize)>>,
}

impl Fake {
    /// Creates reverse runs whose error is a function of the frames `from` and `to`.
    pub fn new(answer: impl Fn(usize, usize) -> Option<f64> + 'static) -> Self {
        Self { answer: Box::new(answer), asked: RefCell::default() }
    }

    /// Creates reverse runs that always give the same error.
    pub fn always(answer: Option<f64>) -> Self {
        Self::new(move |_, _| answer)
    }

    /// Frames `from` and `to` of all calls.
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

/// One letter per frame: `o` for LOCKED-ON, `i` for LOCKING-IN, `s` for SCANNING.
pub fn letters(quality: &Quality) -> String {
    let letter = |c: &Condition| match c {
        Condition::LockedOn => 'o',
        Condition::LockingIn => 'i',
        Condition::Scanning => 's',
    };
    quality.condition.iter().map(letter).collect()
}

/// One letter per frame: `x` for an alarm, `.` for none.
pub fn marks(alarm: &[bool]) -> String {
    alarm.iter().map(|a| if *a { 'x' } else { '.' }).collect()
}

/// Rows of [`TRANSITIONS`] that a machine applies for these events, with the answers of checks from
/// `quality`. The conditions must agree with those in `quality`.
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
