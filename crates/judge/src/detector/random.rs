//! The anchor that alarms at random: isolated one-frame alarms at a given rate.
//!
//! ```text
//! P(alarm at 0) = rate
//! P(alarm at t | none at t - 1) = rate / (1 - rate)
//! P(alarm at t | one at t - 1) = 0
//! ```
//!
//! `t` is a 0-based frame. From these follows P(alarm at t) = rate for every t, and since no two alarms
//! touch, each is a detection of its own: the expected number of detections in n frames is exactly `n
//! rate`. Frames drawn independently would run together and give fewer.
//!
//! It does not read the signal; its score is 1 in alarms and 0 elsewhere. Its draws come from its seed alone.

use super::{Detector, DetectorOutput, Input};
use crate::num::seed;
use crate::plugin::{Entry, ParamError, RawParams, read_params, show_params};
use rand::RngExt;
use serde::{Deserialize, Serialize};

/// The list's entry.
pub const ENTRY: Entry<dyn Detector> = Entry {
    kind: "random",
    version: 1,
    summary: "an anchor: isolated one-frame alarms at a given rate",
    example: "{ rate = 0.04 }",
    more: &["{ rate = 0.5 }"],
    build: |raw: RawParams<'_>| Ok(Box::new(Random::new(read_params(raw)?)?)),
    schema: || schemars::schema_for!(Params),
};

/// Parameters.
#[derive(Debug, Clone, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Params {
    /// Expected alarms per frame, from 0 to 0.5.
    pub rate: f64,
}

/// The detector.
#[derive(Debug, Clone)]
pub struct Random(Params);

impl Random {
    /// Checks the parameters.
    ///
    /// # Errors
    /// When one is outside its documented range.
    pub fn new(params: Params) -> Result<Self, ParamError> {
        if !(0.0..=0.5).contains(&params.rate) {
            return Err(ParamError::out_of_range("rate", "from 0 to 0.5", params.rate));
        }
        Ok(Self(params))
    }
}

impl Detector for Random {
    fn params(&self) -> serde_json::Value {
        show_params(&self.0)
    }

    fn uses_seed(&self) -> bool {
        true
    }

    fn needs_signal(&self) -> bool {
        false
    }

    fn detect(&self, input: &Input<'_>) -> DetectorOutput {
        let rate = self.0.rate;
        let mut rng = seed::rng(input.seed);
        let mut chance = rate;
        let alarm: Vec<bool> = (0..input.signal.len())
            .map(|_| {
                // One draw a frame, so that a longer track begins like a shorter one.
                let now = rng.random::<f64>() < chance;
                chance = if now { 0.0 } else { rate / (1.0 - rate) };
                now
            })
            .collect();
        DetectorOutput {
            score: alarm.iter().map(|&a| f64::from(u8::from(a))).collect(),
            alarm,
            ..DetectorOutput::default()
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn alarms(rate: f64, seed: u64, frames: usize) -> Vec<bool> {
        let signal = vec![0.0; frames];
        Random::new(Params { rate })
            .unwrap()
            .detect(&Input { signal: &signal, error: &[], seed, reverse: None, more: &[] })
            .alarm
    }

    // P(alarm) = rate in every frame. Over 200000 frames the standard deviation of the mean is below
    // sqrt(rate / 200000), as neighbors are negatively correlated; five of them are allowed.
    #[test]
    fn the_rate_is_kept_and_alarms_are_isolated() {
        for rate in [0.01, 0.1, 0.3, 0.5] {
            let alarm = alarms(rate, 7, 200_000);
            let count = alarm.iter().filter(|&&a| a).count();
            assert_eq!(super::super::run_starts(&alarm).len(), count);
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
    fn seeds_differ_and_bounds_hold() {
        assert_ne!(alarms(0.2, 1, 500), alarms(0.2, 2, 500));
        assert!(alarms(0.0, 1, 500).iter().all(|a| !a));
        for text in ["{}", "{ rate = -0.1 }", "{ rate = 0.6 }", "{ rate = nan }"] {
            assert!(ENTRY.build_from_text(text).is_err(), "{text}");
        }
    }
}
