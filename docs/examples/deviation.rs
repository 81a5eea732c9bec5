//! `deviation`: alarm where the signal leaves the mean of its last frames by too many standard deviations.
//!
//! ```text
//! m[t], s[t] = mean and standard deviation of y[t - window], ..., y[t - 1]
//! z[t]       = |y[t] - m[t]| / s[t]            alarm at t when z[t] > k
//! ```
//!
//! `y`, `m` and `s` are in the signal's unit, `z` and `k` have none; `t` is a 0-based frame. High values of
//! `z` are suspicious. Frames before `window` score 0, and `s` is at least 1e-12. Source: none, it is an example.

use super::prelude::*;

pub(crate) const ENTRY: Entry<dyn Detector> =
    Entry::of::<Params>("deviation", 1, "alarm where the signal leaves the mean of its last frames")
        .example("{ window = 20, k = 4.0 }");

#[derive(Debug, Clone, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Params {
    /// Frames that the mean and the deviation are taken over, at least 2.
    pub window: usize,
    /// Standard deviations that are still ordinary, above 0.
    pub k: f64,
}

impl PlainParams for Params {
    const RANGES: &'static [Range] = &[Range::of("window").at_least(2.0), Range::of("k").above(0.0)];
}

impl Detector for Params {
    fn facts(&self) -> Facts {
        Facts { threshold: Some(self.k), ..Facts::default() }
    }

    fn detect(&self, input: &Input<'_>) -> DetectorOutput {
        let Params { window, k } = *self;
        let z = |t: usize| {
            let Some(past) = t.checked_sub(window).map(|from| &input.signal[from..t]) else { return 0.0 };
            let mean = past.iter().sum::<f64>() / window as f64;
            let variance = past.iter().map(|y| (y - mean).powi(2)).sum::<f64>() / window as f64;
            (input.signal[t] - mean).abs() / variance.sqrt().max(1e-12)
        };
        let score: Vec<f64> = (0..input.signal.len()).map(z).collect();
        let alarm = score.iter().map(|z| *z > k).collect();
        DetectorOutput { score, alarm, ..DetectorOutput::default() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    // By hand: the mean of 1 and 3 is 2, their deviation 1, and 5 is 3 deviations away.
    #[test]
    fn a_jump_is_an_alarm() {
        let detector = ENTRY.build_from_text("{ window = 2, k = 2.5 }").unwrap();
        let input = Input { signal: &[1.0, 3.0, 5.0], error: &[], seed: 0, reverse: None, more: &[] };
        let output = detector.detect(&input);
        assert_eq!(output.score, [0.0, 0.0, 3.0]);
        assert_eq!(output.alarm, [false, false, true]);
    }
}
