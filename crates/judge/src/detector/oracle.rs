//! The anchor that knows the truth: alarm exactly while the tracker has lost the target.
//!
//! ```text
//! alarm at t when O[t] >= 1 - 1e-12
//! ```
//!
//! `O` is the tracking error, Eq. 10 of Khalid, Cavallaro and Rinner (BMVC 2016): 1 where the boxes of
//! tracker and ground truth do not touch. `t` is a 0-based frame. The paper's Eq. 11 says `O[t] = 1`; the
//! margin allows for rounding. A frame without ground truth (NaN, or beyond the end of `O`) keeps the
//! label of the frame before it, and a track begins without alarm. It does not read the signal; its score
//! is 1 in alarms and 0 elsewhere.

use super::{Detector, DetectorOutput, Input};
use crate::plugin::{Entry, RawParams, read_params, show_params};
use serde::{Deserialize, Serialize};

/// Smallest error that counts as 1.
const FAILURE: f64 = 1.0 - 1e-12;

/// The list's entry.
pub const ENTRY: Entry<dyn Detector> = Entry {
    kind: "oracle",
    version: 1,
    summary: "an anchor: alarm exactly while the ground truth says the target is lost",
    example: "{}",
    more: &[],
    build: |raw: RawParams<'_>| Ok(Box::new(Oracle(read_params(raw)?))),
    schema: || schemars::schema_for!(Params),
};

/// Parameters: none.
#[derive(Debug, Clone, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Params {}

/// The detector.
#[derive(Debug, Clone)]
pub struct Oracle(pub Params);

impl Detector for Oracle {
    fn params(&self) -> serde_json::Value {
        show_params(&self.0)
    }

    fn needs_signal(&self) -> bool {
        false
    }

    fn frames_to_recover(&self) -> usize {
        1
    }

    fn detect(&self, input: &Input<'_>) -> DetectorOutput {
        let mut label = false;
        let errors = input.error.iter().copied().chain(std::iter::repeat(f64::NAN));
        let alarm: Vec<bool> = errors
            .take(input.signal.len())
            .map(|error| {
                if !error.is_nan() {
                    label = error >= FAILURE;
                }
                label
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

    #[test]
    fn follows_the_error_and_keeps_the_label_without_one() {
        let error = [f64::NAN, 0.2, 1.0, f64::NAN, 1.0 - 1e-13, 0.999, f64::NAN, 1.0];
        let detector = ENTRY.build_from_text("{}").unwrap();
        let output =
            detector.detect(&Input { signal: &[0.0; 9], error: &error, seed: 0, reverse: None, more: &[] });
        assert_eq!(output.alarm, [false, false, true, true, true, false, false, true, true]);
    }
}
