//! The anchor that alarms for one frame in every `period`, whatever happens.
//!
//! ```text
//! alarm at t when t >= phase and (t - phase) mod period = 0
//! ```
//!
//! `t` is a 0-based frame. With a period of 2 or more every alarm is a detection of its own, and a period
//! of `2 r + 1` puts one within `r` frames of nearly every event: its recall shows what a tolerance of `r`
//! frames gives for free. It does not read the signal; its score is 1 in alarms and 0 elsewhere.

use super::{Detector, DetectorOutput, Input};
use crate::plugin::{Entry, ParamError, RawParams, read_params, show_params};
use serde::{Deserialize, Serialize};

/// The list's entry.
pub const ENTRY: Entry<dyn Detector> = Entry {
    kind: "periodic",
    version: 1,
    summary: "an anchor: a one-frame alarm in every period",
    example: "{ period = 11 }",
    more: &["{ period = 2, phase = 1 }"],
    build: |raw: RawParams<'_>| Ok(Box::new(Periodic::new(read_params(raw)?)?)),
    schema: || schemars::schema_for!(Params),
};

/// Parameters.
#[derive(Debug, Clone, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Params {
    /// Frames from one alarm to the next, at least 2.
    pub period: usize,
    /// Frame of the first alarm, less than the period.
    #[serde(default)]
    pub phase: usize,
}

/// The detector.
#[derive(Debug, Clone)]
pub struct Periodic(Params);

impl Periodic {
    /// Checks the parameters.
    ///
    /// # Errors
    /// When one is outside its documented range.
    pub fn new(params: Params) -> Result<Self, ParamError> {
        if params.period < 2 {
            return Err(ParamError::out_of_range("period", "2 frames or more", params.period));
        }
        if params.phase >= params.period {
            return Err(ParamError::out_of_range("phase", "less than the period", params.phase));
        }
        Ok(Self(params))
    }
}

impl Detector for Periodic {
    fn params(&self) -> serde_json::Value {
        show_params(&self.0)
    }

    fn needs_signal(&self) -> bool {
        false
    }

    fn detect(&self, input: &Input<'_>) -> DetectorOutput {
        let Params { period, phase } = self.0;
        let alarm: Vec<bool> = (0..input.signal.len()).map(|t| t % period == phase).collect();
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

    #[test]
    fn by_hand() {
        let detector = ENTRY.build_from_text("{ period = 3, phase = 1 }").unwrap();
        let output =
            detector.detect(&Input { signal: &[0.0; 8], error: &[], seed: 0, reverse: None, more: &[] });
        assert_eq!(super::super::run_starts(&output.alarm), [1, 4, 7]);
        assert_eq!(output.score, [0.0, 1.0, 0.0, 0.0, 1.0, 0.0, 0.0, 1.0]);
    }

    #[test]
    fn parameters_out_of_range_are_refused() {
        for text in ["{}", "{ period = 1 }", "{ period = 0 }", "{ period = 3, phase = 3 }"] {
            assert!(ENTRY.build_from_text(text).is_err(), "{text}");
        }
    }
}
