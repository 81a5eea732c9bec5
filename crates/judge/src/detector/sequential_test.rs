//! `sequential-test`: a test by betting, whose probability of ever raising a false alarm is bounded ("e-process";
//! Waudby-Smith and Ramdas, "Estimating means of bounded random variables by betting", JRSS B 86, 2024; for
//! monitors of quality: arXiv 2602.12983).
//!
//! ```text
//! M[t] = (y[t] - low) / (high - low),   eps = (below - low) / (high - low)           with `below`
//! M[t] = (high - y[t]) / (high - low),  eps = (high - above) / (high - low)          with `above`
//! X[t] = product over i = 0, ..., t of (1 + l[i] (eps - M[i]))           alarm at t when X[t] >= 1 / alpha
//! g[i] = eps - mu[i],  l[i] = g[i] / (v[i] + g[i]^2) cut to [0, largest_bet / (1 - eps)]     (aGRAPA)
//! mu[i] = (1/2 + sum of M[j]) / (n + 1),  v[i] = (1/4 + sum of (M[j] - mu[j+1])^2) / (n + 1)
//! ```
//!
//! The sums are over the `n` frames `j < i`, or the last `window` of them, so that the bet `l[i]` is made before
//! `M[i]` is seen. `M` is the quality, 1 is good; it, `eps`, `l` and `X` have no unit. `y`, `low`, `high`, `below`
//! and `above` are in the signal's unit, and `y` is cut to `[low, high]`; `t` is a 0-based frame. The score is ln X,
//! high is suspicious, and its threshold ln(1 / alpha).
//!
//! Guarantee (Ville's inequality): if `E(M[t] | M[0], ..., M[t-1]) >= eps` in every frame, then the probability that
//! there is any alarm, in a track of any length, is at most `alpha`. The frames need be neither independent nor alike.
//! It says nothing else: not that a tracker on target keeps that mean (which is for `below`, `above`, `low` and `high`
//! to ensure); nothing about alarms after the mean has once been lower, such as those after a recovery; nothing about
//! how soon, or whether, a loss is found; and with `after = "restart"` it holds for each test alone, not for a track.
//!
//! Choices: `alpha = 0.05`. A bet takes at most half of what it may (`largest_bet`; at 1 one frame could end the
//! wealth X for good). All earlier frames are in `mu` and `v`, as published: after n good frames it takes a number
//! of bad ones proportional to n until there is a bet at all. A `window` is faster, with the same guarantee.

use super::level::{self, Level};
use super::prelude::*;
use std::collections::VecDeque;

pub(crate) const ENTRY: Entry<dyn Detector> = Entry::of::<SequentialTest>(
    "sequential-test",
    1,
    "alarm when a test by betting rejects that the signal's mean is good (bounded false alarms)",
)
.example("{ below = 0.5 }")
.more(&[
    "{ above = 0.03, low = -0.5, alpha = 0.3, window = 4 }",
    "{ below = 0.6, alpha = 0.3, largest_bet = 0.9, after = \"restart\" }",
]);

/// Behavior after an alarm.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum After {
    /// The test continues: the alarm lasts while X >= 1 / alpha.
    Continue,
    /// A new test begins with X = 1 and the same bets; the alarm lasts one frame.
    Restart,
}

/// Parameters; exactly one of `below` and `above` is given.
#[derive(Debug, Clone, SmartDefault, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Params {
    /// Least good mean of the signal, in the signal's unit, between `low` and `high`. A lower mean is an
    /// alarm.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub below: Option<f64>,
    /// Largest good mean of the signal, in the signal's unit, between `low` and `high`. A higher mean is an
    /// alarm.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub above: Option<f64>,
    /// Least possible value of the signal. Smaller values count as this.
    pub low: f64,
    /// Largest possible value of the signal, above `low`. Larger values count as this.
    #[default(1.0)]
    pub high: f64,
    /// Largest probability of an alarm on a good track, 1e-12 to 0.5.
    #[default(0.05)]
    pub alpha: f64,
    /// Largest bet, as a share of the bet that could lose everything, 0.01 to 0.99.
    #[default(0.5)]
    pub largest_bet: f64,
    /// Number of latest frames from which the bets are computed, 1 to 100000; by default all.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub window: Option<usize>,
    /// Behavior after an alarm.
    #[default(After::Continue)]
    pub after: After,
}

#[derive(Debug, Clone)]
pub struct SequentialTest {
    params: Params,
    mean: Level,
}

impl Plugin for SequentialTest {
    type Params = Params;

    const RANGES: &'static [Range] = &[
        Range::of("below"),
        Range::of("above"),
        Range::of("low"),
        Range::of("high"),
        Range::within("alpha", 1e-12, 0.5),
        Range::within("largest_bet", 0.01, 0.99),
        Range::within("window", 1.0, 100_000.0),
    ];

    fn make(params: Params) -> Result<Self, ParamError> {
        let mean = Level::new(level::Params { below: params.below, above: params.above })?;
        let Params { low, high, .. } = params;
        let is_above = (high - low).is_finite() && high > low;
        ParamError::unless(is_above, "high", "finite and above `low`", high)?;
        let test = Self { params, mean };
        let eps = test.quality(mean.value);
        ParamError::unless(eps > 0.0 && eps < 1.0, mean.key(), "between `low` and `high`", mean.value)?;
        Ok(test)
    }
}

impl SequentialTest {
    /// Quality M of a value of the signal.
    fn quality(&self, y: f64) -> f64 {
        let Params { low, high, .. } = self.params;
        let y = y.clamp(low, high);
        let from = if self.mean.is_least { y - low } else { high - y };
        from / (high - low)
    }

    fn limit(&self) -> f64 {
        -self.params.alpha.ln()
    }
}

impl Causal for SequentialTest {
    /// State of the bets, and ln X.
    type Memory = (Bets, f64);

    fn facts(&self) -> Facts {
        let frames_to_recover = if self.params.after == After::Continue { 1 } else { RECOVERY_FRAMES };
        Facts { threshold: Some(self.limit()), frames_to_recover, ..Facts::default() }
    }

    fn begin(&self) -> (Bets, f64) {
        let eps = self.quality(self.mean.value);
        (Bets { eps, largest: self.params.largest_bet / (1.0 - eps), ..Bets::default() }, 0.0)
    }

    fn step(&self, (bets, wealth): &mut (Bets, f64), values: &[f64]) -> Step {
        let quality = self.quality(values[0]);
        *wealth += (bets.next() * (bets.eps - quality)).ln_1p();
        bets.add(quality, self.params.window);
        let step = Step::new(*wealth, *wealth >= self.limit());
        if step.alarm && self.params.after == After::Restart {
            *wealth = 0.0;
        }
        step
    }

    fn is_memory(&self, (bets, wealth): &(Bets, f64)) -> bool {
        let (begin, _) = self.begin();
        let in_window = bets.frames.iter().flat_map(|(quality, square)| [quality, square]);
        let mut numbers = [&bets.sum, &bets.squares, &bets.count].into_iter().chain(in_window);
        wealth.is_finite()
            && bets.frames.len() <= self.params.window.unwrap_or(0)
            && (bets.eps, bets.largest) == (begin.eps, begin.largest)
            && numbers.all(|number| number.is_finite() && *number >= 0.0)
    }
}

/// Bets, and the sums from which they are computed.
#[derive(Debug, Default, Serialize, Deserialize)]
pub(super) struct Bets {
    eps: f64,
    largest: f64,
    /// Quality of each frame in the window, with the squared deviation from the mean at that time; empty
    /// without a window.
    frames: VecDeque<(f64, f64)>,
    /// Sum of the qualities; the sum of the squared deviations follows.
    sum: f64,
    squares: f64,
    count: f64,
}

impl Bets {
    fn mean(&self) -> f64 {
        (0.5 + self.sum) / (self.count + 1.0)
    }

    /// Bet on the next frame.
    fn next(&self) -> f64 {
        let gap = self.eps - self.mean();
        let variance = (0.25 + self.squares) / (self.count + 1.0);
        (gap / (variance + gap * gap)).clamp(0.0, self.largest)
    }

    /// Adds the quality of a frame and removes the oldest one when `window` is full.
    fn add(&mut self, quality: f64, window: Option<usize>) {
        self.sum += quality;
        self.count += 1.0;
        if window.is_some_and(|window| self.frames.len() >= window)
            && let Some((past, square)) = self.frames.pop_front()
        {
            self.sum = (self.sum - past).max(0.0);
            self.squares = (self.squares - square).max(0.0);
            self.count -= 1.0;
        }
        let square = (quality - self.mean()).powi(2);
        self.squares += square;
        if window.is_some() {
            self.frames.push_back((quality, square));
        }
    }
}

#[cfg(test)]
mod tests;
