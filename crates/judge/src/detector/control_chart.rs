//! Control charts, shared by `cusum` and `page-hinkley`: sums of a signal's deviations from its normal level.
//!
//! ```text
//! sigma = max(standard deviation of y[0], ..., y[start - 1], floor max(1, |y[0]|, ..., |y[start - 1]|))
//! z[t]  = (mu[t] - y[t]) / sigma   with `below`          z[t] = (y[t] - mu[t]) / sigma   with `above`
//! S[t]  = max(0, S[t-1] + z[t] - k),   S[start - 1] = 0          alarm at t when S[t] >= h
//! ```
//!
//! `y` is the signal, `mu` its normal level and `sigma` its normal deviation, all in the signal's unit; `S`, `k` and
//! `h` are in units of `sigma`, and `h` is the parameter `below` or `above`. `t` is a 0-based frame. The standard
//! deviation divides by `start - 1`. High values of `S`, the score, are suspicious; it is 0 in the frames of the start,
//! which therefore have no alarm.
//!
//! An alarm lasts until the signal is back, `z <= release`, and the sum then starts again from 0; until then it does not
//! fall below `h`.
//!
//! The floor keeps a start that is constant but for rounding from turning rounding into an alarm: without it,
//! `sigma` is 0 or nearly so.

use super::level::{self, Level};
use super::prelude::*;

/// Parameters; exactly one of `below` and `above` is given.
#[derive(Debug, Clone, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Params {
    /// Alarm if the sum of deviations below the normal level reaches this, `h`, in standard deviations, above
    /// 0; 5 is usual.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub below: Option<f64>,
    /// Alarm if the sum of deviations above the normal level reaches this, `h`, in standard deviations, above
    /// 0; 5 is usual.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub above: Option<f64>,
    /// Deviation that is allowed in each frame, in standard deviations, 0 to 1000; usually half of the shift
    /// to be found.
    pub k: f64,
    /// Number of frames at the start of a track that are assumed to be good, 2 to 100000.
    pub start: usize,
    /// Deviation at which an alarm ends, in standard deviations, -1000 to 1000; 0 is the normal level itself.
    pub release: f64,
    /// Least standard deviation, as a share of the largest absolute value of the start (at least 1); 1e-12 to
    /// 1.
    pub floor: f64,
}

impl Default for Params {
    fn default() -> Self {
        Self { below: None, above: None, k: 0.5, start: 25, release: 0.0, floor: 1e-6 }
    }
}

/// A detector that alarms if the sum of deviations is too large.
///
/// The normal level is the mean of the start or, with `RUNNING`, that of the frames up to the current one that do not
/// follow an alarm frame.
#[derive(Debug, Clone)]
pub(super) struct ControlChart<const RUNNING: bool> {
    params: Params,
    limit: Level,
}

impl<const RUNNING: bool> Plugin for ControlChart<RUNNING> {
    type Params = Params;

    const RANGES: &'static [Range] = &[
        Range::of("below").above(0.0),
        Range::of("above").above(0.0),
        Range::within("start", 2.0, 100_000.0),
        Range::within("k", 0.0, 1000.0),
        Range::within("release", -1000.0, 1000.0),
        Range::within("floor", 1e-12, 1.0),
    ];

    fn make(params: Params) -> Result<Self, ParamError> {
        let limit = Level::new(level::Params { below: params.below, above: params.above })?;
        Ok(Self { params, limit })
    }
}

impl<const RUNNING: bool> Causal for ControlChart<RUNNING> {
    type Memory = Sum;

    fn facts(&self) -> Facts {
        Facts { threshold: Some(self.limit.value), frames_to_recover: 1, ..Facts::default() }
    }

    fn step(&self, memory: &mut Sum, values: &[f64]) -> Step {
        let Params { k, start, release, floor, .. } = self.params;
        let limit = self.limit.value;
        let Sum { first, normal, mean, sum, in_alarm } = memory;
        let Some(normal) = normal else {
            first.push(values[0]);
            if first.len() >= start {
                let of_start = Start::of(first, floor);
                *mean = RunningMean { mean: of_start.mean, count: start };
                *normal = Some(of_start);
                *first = Vec::new();
            }
            return Step::new(0.0, false);
        };
        let y = values[0] / normal.scale;
        if RUNNING && !*in_alarm {
            mean.add(y);
        }
        let above = (y - mean.mean) / normal.deviation;
        let z = if self.limit.is_least { -above } else { above };
        let least = if *in_alarm { limit } else { 0.0 };
        *sum = (*sum + z.clamp(-f64::MAX, f64::MAX) - k).clamp(least, f64::MAX);
        if *in_alarm && z <= release {
            *sum = 0.0;
        }
        *in_alarm = *sum >= limit;
        Step::new(*sum, *in_alarm)
    }
}

/// State of the chart: the sum S of the last frame, and its parts.
#[derive(Debug, Default, Serialize, Deserialize)]
pub(super) struct Sum {
    /// Values of the start, until the start is over.
    first: Vec<f64>,
    normal: Option<Start>,
    mean: RunningMean,
    sum: f64,
    in_alarm: bool,
}

/// Mean and standard deviation of the start of a track.
#[derive(Debug, Serialize, Deserialize)]
struct Start {
    /// Unit of `mean` and `deviation`, in the signal's unit: the largest absolute value, at least 1. In this
    /// unit sums cannot overflow, and values up to 1 keep their bits.
    scale: f64,
    mean: f64,
    deviation: f64,
}

impl Start {
    /// Mean and deviation of at least two values. The deviation is at least `floor`.
    fn of(values: &[f64], floor: f64) -> Self {
        let scale = values.iter().fold(1.0_f64, |largest, y| largest.max(y.abs()));
        let mut mean = RunningMean::default();
        values.iter().for_each(|y| mean.add(y / scale));
        let squares: f64 = values.iter().map(|y| (y / scale - mean.mean).powi(2)).sum();
        let deviation = (squares / (values.len() as f64 - 1.0)).sqrt();
        Self { scale, mean: mean.mean, deviation: deviation.max(floor) }
    }
}

/// Mean of the values added so far; 0 before the first one.
#[derive(Debug, Clone, Copy, Default, Serialize, Deserialize)]
pub(super) struct RunningMean {
    pub mean: f64,
    pub count: usize,
}

impl RunningMean {
    /// Adds a value. The difference is halved first, so that values of opposite sign cannot overflow.
    pub fn add(&mut self, value: f64) {
        self.count = self.count.saturating_add(1);
        self.mean += 2.0 * ((value / 2.0 - self.mean / 2.0) / self.count as f64);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::detector::testing::alone;
    use proptest::prelude::*;
    use trackfail_testing::assert_near;

    fn chart(running: bool, params: Params, signal: &[f64]) -> DetectorOutput {
        match running {
            true => ControlChart::<true>::new(params).unwrap().detect(&alone(signal)),
            false => ControlChart::<false>::new(params).unwrap().detect(&alone(signal)),
        }
    }

    const BOTH: [bool; 2] = [false, true];

    fn above(h: f64) -> Params {
        Params { above: Some(h), ..Params::default() }
    }

    #[test]
    fn rounding_after_a_constant_start_is_no_alarm() {
        for level in [0.0_f64, 1e-300, 0.04, 0.1 + 0.2, 1.0, 1e9, 1e300] {
            let up = level + 4.0 * f64::EPSILON * level.max(1.0);
            let flat = [level; 25];
            let signal: Vec<f64> = flat.iter().copied().chain((0..5000).map(|_| up)).collect();
            let wavy: Vec<f64> = (0..5000).map(|t| if t % 3 == 0 { level } else { up }).collect();
            for (normal, signal) in BOTH.iter().flat_map(|n| [(*n, &signal), (*n, &wavy)]) {
                for params in [above(5.0), Params { below: Some(5.0), ..Params::default() }] {
                    assert!(chart(normal, params, signal).score.iter().all(|s| *s < 0.01), "{level}");
                }
            }
            let jump: Vec<f64> = flat.iter().copied().chain([level + level.max(1.0)]).collect();
            assert!(BOTH.iter().all(|n| chart(*n, above(5.0), &jump).alarm[25]), "{level}");
        }
    }

    // python3: statistics.mean(x), statistics.stdev(x) for x = [.5, .25, -1, .125] and for [1e308, -1e308, 1e308]:
    // mean -0.03125; 1/3 and 2 / sqrt(3) of 1e308
    #[test]
    fn the_start_is_that_of_the_statistics_module() {
        let start = Start::of(&[0.5, 0.25, -1.0, 0.125], 1e-6);
        assert_near([start.scale, start.mean, start.deviation], [1.0, -0.03125, STDEV], 1e-15, "");
        let start = Start::of(&[1e308, -1e308, 1e308], 1e-6);
        assert_near([start.mean, start.deviation], [1.0 / 3.0, 2.0 / 3.0_f64.sqrt()], 1e-15, "huge");
        assert_eq!(Start::of(&[0.5; 9], 1e-6).deviation, 1e-6);
    }
    const STDEV: f64 = 0.6643841132959156;

    proptest! {
        // A second form of the same sum: M = m - min m of the plain cumulative sum m, which starts at 0.
        #[test]
        fn before_the_first_alarm_the_sum_is_the_rise_above_the_minimum(
            signal in prop::collection::vec(-1.0_f64..1.0, 5..80),
            k in 0.0_f64..1.0,
        ) {
            let start = &signal[..5];
            let mean = start.iter().sum::<f64>() / 5.0;
            let sigma = (start.iter().map(|y| (y - mean).powi(2)).sum::<f64>() / 4.0).sqrt().max(1e-6);
            for normal in BOTH {
                let score = chart(normal, Params { start: 5, k, ..above(1e12) }, &signal).score;
                prop_assert_eq!(&score[..5], &[0.0; 5]);
                let (mut total, mut minimum) = (0.0_f64, 0.0_f64);
                for t in 5..signal.len() {
                    let until = if normal { t + 1 } else { 5 };
                    let level = signal[..until].iter().sum::<f64>() / until as f64;
                    total += (signal[t] - level) / sigma - k;
                    minimum = minimum.min(total);
                    prop_assert!((score[t] - (total - minimum)).abs() <= 1e-9 * (1.0 + total.abs()), "{}", t);
                }
            }
        }
    }
}
