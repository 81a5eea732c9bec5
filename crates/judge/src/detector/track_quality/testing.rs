//! Helpers for tests of `arte` and `arte-star`: scripted reverse runs, and short texts.

use super::machine::TRANSITIONS;
use super::{Condition, Quality};
use crate::detector::testing::alone;
use crate::detector::{DetectorOutput, Input, Reverse};
use proptest::prelude::*;
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

    /// Answers that depend on the frames alone, about half of them good.
    pub fn mixed() -> Self {
        Self::new(|from, to| Some(((from * 7 + to * 3) % 16) as f64 / 10.0))
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

/// The input of a signal with a way back.
pub fn with<'a>(signal: &'a [f64], reverse: &'a Fake) -> Input<'a> {
    Input { reverse: Some(reverse), ..alone(signal) }
}

/// The steps of a track.
pub fn quality(output: &DetectorOutput) -> &Quality {
    output.quality.as_ref().unwrap()
}

/// One letter per frame: `o` for LOCKED-ON, `i` for LOCKING-IN, `s` for SCANNING.
pub fn letters(output: &DetectorOutput) -> String {
    let letter = |c: &Condition| match c {
        Condition::LockedOn => 'o',
        Condition::LockingIn => 'i',
        Condition::Scanning => 's',
    };
    quality(output).condition.iter().map(letter).collect()
}

/// One letter per frame: `x` for an alarm, `.` for none.
pub fn marks(alarm: &[bool]) -> String {
    alarm.iter().map(|a| if *a { 'x' } else { '.' }).collect()
}

/// Rows of the table that were applied, in order. Each leads from the condition of the frame before to its own.
pub fn rows(output: &DetectorOutput) -> Vec<usize> {
    let quality = quality(output);
    for &(t, row) in &quality.transitions {
        let before = t.checked_sub(1).map_or(Condition::LockedOn, |t| quality.condition[t]);
        assert_eq!((TRANSITIONS[row].from, TRANSITIONS[row].to), (before, quality.condition[t]), "frame {t}");
    }
    quality.transitions.iter().map(|(_, row)| *row).collect()
}

/// Checks the law of both detectors: alarms begin with a rise above the threshold and end with an accepted check, whose
/// reference is the last frame without one.
pub fn check_alarms(output: &DetectorOutput, threshold: f64) {
    let quality = quality(output);
    for (t, alarm) in output.alarm.iter().enumerate() {
        let before = t.checked_sub(1).is_some_and(|t| output.alarm[t]);
        let accepted = quality.checks.iter().any(|c| c.frame == t && c.accepted);
        if *alarm && !before {
            assert!(output.score[t] > threshold && quality.condition[t] == Condition::Scanning, "frame {t}");
        }
        assert_eq!(before && !alarm, accepted, "frame {t}");
    }
    for check in &quality.checks {
        // The first frame, where the alarm is on from there.
        let last = (0..check.frame).rev().find(|t| !output.alarm[*t]);
        assert_eq!(last.unwrap_or(0), check.reference);
    }
}

/// Values that stay at a level for a while, with noise.
pub fn levels(
    level: impl Strategy<Value = f64>,
    noise: std::ops::Range<f64>,
    pieces: std::ops::Range<usize>,
) -> impl Strategy<Value = Vec<f64>> {
    let piece = (level, prop::collection::vec(noise, 1..25));
    prop::collection::vec(piece, pieces)
        .prop_map(|all| all.iter().flat_map(|(level, noise)| noise.iter().map(move |n| level * n)).collect())
}
