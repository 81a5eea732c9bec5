//! Features of the fused detector: each input against its own past on the same track.
//!
//! ```text
//! x[t]     value of the input in frame t; of motions ln(1e-3 + value)
//! now      x[t]
//! worst5   worst of the last 5 values                    mean5    their mean
//! worst20  worst of the last 20 values                   mean20   their mean
//! slope20  slope of a line through the last 20 values, times 20
//! change   x[t] - mean of the first 20 values            (of motions the logarithm of a ratio)
//! z        (x[t] - median of the past) / (1.4826 MAD of the past + floor), cut at 10
//! missing  1 in a frame without a value, else 0
//! ```
//!
//! Inputs from a network have only the first three features.
//!
//! `t` is a 0-based frame. The past is the last 100 values before frame t. A frame in which an input is
//! missing does not change its history. In such a frame, `now`, `change` and `z` have no value; before the first value,
//! no feature but `missing` has one. A feature without a value has no effect on the score.

use super::inputs::FusedInput;
use crate::direction::Direction;
use serde::{Deserialize, Serialize};
use std::collections::VecDeque;

/// Number of values for `worst20`, `mean20` and `slope20`, and of the first values that `change` compares
/// with.
const LONG: usize = 20;
/// Number of values for `worst5` and `mean5`.
const SHORT: usize = 5;
/// Number of past values that `z` compares with.
const PAST: usize = 100;
/// Value added to motions before taking the logarithm.
const MOTION_FLOOR: f64 = 1e-3;
/// Bound of `z`.
const MAX_Z: f64 = 10.0;
/// Value added to the spread of the past in `z`, in the unit of the input. Without it, any noise after a
/// nearly constant past would give the largest `z`.
const SPREAD_FLOOR: f64 = 0.02;
/// The same value for motions, in units of the logarithm: a change by a tenth is noise.
const MOTION_SPREAD_FLOOR: f64 = 0.1;

/// Names of an input's features, in order.
pub const FEATURES: [&str; 9] =
    ["now", "worst5", "mean5", "worst20", "mean20", "slope20", "change", "z", "missing"];

/// History of an input, of bounded size.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "((f64, usize), VecDeque<f64>)")]
pub struct InputHistory {
    /// Sum and number of the first values.
    early: (f64, usize),
    /// Up to [`PAST`] values, the latest at the end.
    past: VecDeque<f64>,
    /// The past values in ascending order.
    #[serde(skip)]
    sorted: Vec<f64>,
}

impl TryFrom<((f64, usize), VecDeque<f64>)> for InputHistory {
    type Error = &'static str;

    /// The history as it is saved, checked.
    fn try_from((early, past): ((f64, usize), VecDeque<f64>)) -> Result<Self, Self::Error> {
        let is_finite = early.0.is_finite() && past.iter().all(|value| value.is_finite());
        if !is_finite || early.1 > LONG || past.len() > PAST {
            return Err("not the history of an input");
        }
        let mut sorted = Vec::from(past.clone());
        sorted.sort_by(f64::total_cmp);
        Ok(Self { early, past, sorted })
    }
}

impl InputHistory {
    /// Features of the input in the next frame; NaN for those without a value.
    pub fn features(&mut self, input: &FusedInput, value: f64) -> impl Iterator<Item = f64> + use<> {
        self.push(input, value).into_iter().take(input.features)
    }

    /// All features in the next frame, in the order of [`FEATURES`].
    pub(super) fn push(&mut self, input: &FusedInput, value: f64) -> [f64; FEATURES.len()] {
        let x = transformed(input, value);
        let z = self.robust_z(x, if input.is_motion { MOTION_SPREAD_FLOOR } else { SPREAD_FLOOR });
        self.remember(x);
        let [now, worst5, mean5, worst20, mean20, slope20, change] = self.windows(input, x);
        let missing = f64::from(u8::from(!x.is_finite()));
        [now, worst5, mean5, worst20, mean20, slope20, change, z, missing]
    }

    /// Adds the value of the next frame without computing features.
    pub fn pass(&mut self, input: &FusedInput, value: f64) {
        self.remember(transformed(input, value));
    }

    fn remember(&mut self, x: f64) {
        if !x.is_finite() {
            return;
        }
        if self.early.1 < LONG {
            self.early = (self.early.0 + x, self.early.1 + 1);
        }
        let oldest = if self.past.len() == PAST { self.past.pop_front() } else { None };
        if let Some(oldest) = oldest {
            self.sorted.remove(self.sorted.partition_point(|value| *value < oldest));
        }
        self.past.push_back(x);
        self.sorted.insert(self.sorted.partition_point(|value| *value < x), x);
    }

    /// Features over windows, from `now` to `change`.
    fn windows(&self, input: &FusedInput, now: f64) -> [f64; 7] {
        let last = |count: usize| self.past.iter().skip(self.past.len().saturating_sub(count)).copied();
        let worst = |count| match input.good {
            Direction::LowerIsBetter => last(count).fold(f64::NAN, f64::max),
            _ => last(count).fold(f64::NAN, f64::min),
        };
        let mean = |count: usize| last(count).sum::<f64>() / self.past.len().min(count) as f64;
        let early = self.early.0 / self.early.1 as f64;
        [now, worst(SHORT), mean(SHORT), worst(LONG), mean(LONG), slope(last(LONG)), now - early]
    }

    /// Distance of a value from the past, in robust deviations; 0 without a past.
    fn robust_z(&self, x: f64, floor: f64) -> f64 {
        let Some(middle) = self.median().filter(|_| x.is_finite()) else {
            return if x.is_finite() { 0.0 } else { f64::NAN };
        };
        ((x - middle) / (1.4826 * median_deviation(&self.sorted, middle) + floor)).clamp(-MAX_Z, MAX_Z)
    }

    fn median(&self) -> Option<f64> {
        let half = self.sorted.len() / 2;
        let upper = self.sorted.get(half)?;
        let lower = if self.sorted.len().is_multiple_of(2) { self.sorted.get(half - 1)? } else { upper };
        Some((lower + upper) / 2.0)
    }

    /// Median of the past, in the unit of the input; `None` without a past.
    pub fn usual(&self, input: &FusedInput) -> Option<f64> {
        self.median().map(|x| if input.is_motion { x.exp() - MOTION_FLOOR } else { x })
    }
}

/// Value of an input as it is compared, for motions its logarithm; NaN if it is missing.
fn transformed(input: &FusedInput, value: f64) -> f64 {
    match value.is_finite() {
        true if input.is_motion => (MOTION_FLOOR + value.max(0.0)).ln(),
        true => value,
        false => f64::NAN,
    }
}

/// Median distance of values from `middle`.
fn median_deviation(values: &[f64], middle: f64) -> f64 {
    let mut distances: Vec<f64> = values.iter().map(|value| (value - middle).abs()).collect();
    crate::num::summary::median(&mut distances).unwrap_or_default()
}

/// Slope of the line through equally spaced values, times [`LONG`]; 0 with fewer than 3 values.
fn slope(values: impl Iterator<Item = f64> + Clone) -> f64 {
    let count = values.clone().count();
    if count < 3 {
        return if count == 0 { f64::NAN } else { 0.0 };
    }
    let middle = (count - 1) as f64 / 2.0;
    let (mut products, mut squares) = (0.0, 0.0);
    for (at, value) in values.enumerate() {
        let away = at as f64 - middle;
        products += away * value;
        squares += away * away;
    }
    LONG as f64 * products / squares
}
