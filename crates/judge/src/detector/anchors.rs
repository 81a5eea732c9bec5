//! Anchors: detectors that do not read the signal, to compare others with.
//!
//! | kind | alarm in frame `t`, from 0 |
//! |---|---|
//! | `never` | never: recall is 0, and there is no false positive |
//! | `always` | always: one run of alarms, which begins in the first frame |
//! | `periodic` | when `t >= phase` and `(t - phase) mod period = 0` |
//! | `random` | with P = `rate` in frame 0, 0 after an alarm, and `rate / (1 - rate)` after a frame without one |
//! | `oracle` | when O\[t\] >= 1 - 1e-12: exactly while the tracker has lost the target |
//!
//! The score is the alarm, 1 or 0.
//!
//! With a period of 2 or more every alarm of `periodic` is a detection of its own, and a period of `2 r + 1` puts one
//! within `r` frames of nearly every event: its recall shows what a tolerance of `r` frames gives for free.
//!
//! By this rule, `random` has P(alarm at t) = `rate` for all t. As alarms are never adjacent, each is a
//! detection of its own, and the expected number of detections in n frames is exactly `n rate`. Independently
//! drawn alarms would merge into fewer detections. The draws depend on the seed alone.
//!
//! `O` is the tracking error, Eq. 10 of Khalid, Cavallaro and Rinner (BMVC 2016): 1 where the boxes of tracker and ground
//! truth do not touch. The paper's Eq. 11 says `O[t] = 1`; the margin allows for rounding. A frame without ground truth
//! (NaN, or beyond the end of `O`) keeps the label of the frame before it, and a track begins without alarm.

use super::prelude::*;
use crate::num::seed;
use rand::RngExt;

/// Least error that counts as 1.
const FAILURE: f64 = 1.0 - 1e-12;

pub(crate) const NEVER: Entry<dyn Detector> =
    Entry::of::<Constant<false>>("never", 1, "an anchor: no alarm in any frame");

pub(crate) const ALWAYS: Entry<dyn Detector> =
    Entry::of::<Constant<true>>("always", 1, "an anchor: alarm in every frame");

pub(crate) const PERIODIC: Entry<dyn Detector> =
    Entry::of::<Periodic>("periodic", 1, "an anchor: a one-frame alarm in every period")
        .example("{ period = 11 }")
        .more(&["{ period = 2, phase = 1 }"]);

pub(crate) const RANDOM: Entry<dyn Detector> =
    Entry::of::<Random>("random", 1, "an anchor: isolated one-frame alarms at a given rate")
        .example("{ rate = 0.04 }")
        .more(&["{ rate = 0.5 }"]);

pub(crate) const ORACLE: Entry<dyn Detector> = Entry::of::<Oracle>(
    "oracle",
    1,
    "an anchor: alarm exactly while the ground truth says the target is lost",
);

/// Facts of an anchor whose losses end after so many frames in a row without an alarm.
fn anchor(frames_to_recover: usize) -> Facts {
    Facts { needs_signal: false, frames_to_recover, ..Facts::default() }
}

/// Output of a detector that is defined by its alarms.
fn output(alarm: Vec<bool>) -> DetectorOutput {
    let score = alarm.iter().map(|&a| f64::from(u8::from(a))).collect();
    DetectorOutput { score, alarm, ..DetectorOutput::default() }
}

#[derive(Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
struct Constant<const ALARM: bool> {}

impl<const ALARM: bool> PlainParams for Constant<ALARM> {}

impl<const ALARM: bool> Detector for Constant<ALARM> {
    fn facts(&self) -> Facts {
        anchor(1)
    }

    fn detect(&self, input: &Input<'_>) -> DetectorOutput {
        output(vec![ALARM; input.signal.len()])
    }
}

#[derive(Debug, Clone, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
struct Periodic {
    /// Number of frames from one alarm to the next, at least 2.
    period: usize,
    /// Frame of the first alarm, less than the period.
    #[serde(default)]
    phase: usize,
}

impl PlainParams for Periodic {
    const RANGES: &'static [Range] = &[Range::of("period").at_least(2.0)];

    fn check(&self) -> Result<(), ParamError> {
        ParamError::unless(self.phase < self.period, "phase", "less than the period", self.phase)
    }
}

impl Detector for Periodic {
    fn facts(&self) -> Facts {
        anchor(RECOVERY_FRAMES)
    }

    fn detect(&self, input: &Input<'_>) -> DetectorOutput {
        output((0..input.signal.len()).map(|t| t % self.period == self.phase).collect())
    }
}

#[derive(Debug, Clone, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
struct Random {
    /// Expected alarms per frame, from 0 to 0.5.
    rate: f64,
}

impl PlainParams for Random {
    const RANGES: &'static [Range] = &[Range::within("rate", 0.0, 0.5)];
}

impl Detector for Random {
    fn facts(&self) -> Facts {
        Facts { uses_seed: true, ..anchor(RECOVERY_FRAMES) }
    }

    fn detect(&self, input: &Input<'_>) -> DetectorOutput {
        let mut rng = seed::rng(input.seed);
        let mut chance = self.rate;
        let alarm = |_| {
            // One draw a frame, so that a longer track begins like a shorter one.
            let now = rng.random::<f64>() < chance;
            chance = if now { 0.0 } else { self.rate / (1.0 - self.rate) };
            now
        };
        output((0..input.signal.len()).map(alarm).collect())
    }
}

#[derive(Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
struct Oracle {}

impl PlainParams for Oracle {}

impl Detector for Oracle {
    fn facts(&self) -> Facts {
        anchor(1)
    }

    fn detect(&self, input: &Input<'_>) -> DetectorOutput {
        let mut label = false;
        let errors = input.error.iter().copied().chain(std::iter::repeat(f64::NAN));
        let alarm = |error: f64| {
            if !error.is_nan() {
                label = error >= FAILURE;
            }
            label
        };
        output(errors.take(input.signal.len()).map(alarm).collect())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::detector::run_starts;
    use crate::detector::testing::{alone, built, detect};

    fn alarms(rate: f64, seed: u64, frames: usize) -> Vec<bool> {
        Random { rate }.detect(&Input { seed, ..alone(&vec![0.0; frames]) }).alarm
    }

    #[test]
    fn periodic_alarms_by_hand() {
        let output = detect(&PERIODIC, "{ period = 3, phase = 1 }", &[0.0; 8]);
        assert_eq!(run_starts(&output.alarm), [1, 4, 7]);
        assert_eq!(output.score, [0.0, 1.0, 0.0, 0.0, 1.0, 0.0, 0.0, 1.0]);
    }

    // P(alarm) = rate in every frame. Over 200000 frames the standard deviation of the mean is below
    // sqrt(rate / 200000), as neighbors are negatively correlated; five of them are allowed.
    #[test]
    fn the_rate_is_kept_and_alarms_are_isolated() {
        for rate in [0.0, 0.01, 0.1, 0.3, 0.5] {
            let alarm = alarms(rate, 7, 200_000);
            let count = alarm.iter().filter(|&&a| a).count();
            assert_eq!(run_starts(&alarm).len(), count);
            let off = count as f64 / 2e5 - rate;
            assert!(off.abs() <= 5.0 * (rate / 2e5).sqrt(), "{rate}: off by {off}");
        }
    }

    // The first frames of 20000 seeds: the chain starts in its stationary law.
    #[test]
    fn the_rate_holds_from_the_first_frame_on() {
        for t in 0..3 {
            let count = (0..20_000).filter(|&seed| alarms(0.3, seed, 3)[t]).count();
            assert!((count as f64 / 2e4 - 0.3).abs() < 5.0 * (0.21_f64 / 2e4).sqrt());
        }
    }

    #[test]
    fn the_oracle_follows_the_error_and_keeps_the_label_without_one() {
        let error = [f64::NAN, 0.2, 1.0, f64::NAN, FAILURE, 0.999, f64::NAN, 1.0];
        let output = built(&ORACLE, "{}").detect(&Input { error: &error, ..alone(&[0.0; 9]) });
        assert_eq!(output.alarm, [false, false, true, true, true, false, false, true, true]);
    }
}
