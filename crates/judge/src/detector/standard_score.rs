//! A level of the signal in standard deviations of its own values. This is a reading of detectors whose
//! published threshold may be in that unit (CovF's 2.3 is near 2.326, the 99 % point of a normal
//! distribution).
//!
//! ```text
//! z[t] = (y[t] - m) / s            alarm at t when z[t] < below          or          z[t] >= above
//! ```
//!
//! `y` is the signal and `t` a 0-based frame; `z` has no unit. `m` and `s` are mean and standard deviation
//! (of the population) of `y` over the `span` frames before t (`over = "frames-before"`, z = 0 until there
//! are as many), or over all frames of the track (`over = "track"`, which looks ahead: a track can only be
//! judged as a whole). Where the values do not vary by more than one part in 10^9 of the largest, `z` is 0.
//! The signal declares whether high or low values are bad.
//!
//! Source: none; the detector serves to compare readings with published numbers.

use super::prelude::*;
use crate::detector::level::{self, Level};
use std::collections::VecDeque;

pub(crate) const ENTRY: Entry<dyn Detector> = Entry::of::<StandardScore>(
    "standard-score",
    1,
    "alarm while the signal is a number of standard deviations from its mean, of the frames before or of the track",
)
.example("{ above = 2.3, span = 25 }")
.more(&["{ above = 1.0 }"]);

/// Frames over which mean and deviation are taken.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Over {
    /// The `span` frames before the current one.
    FramesBefore,
    /// All frames of the track.
    Track,
}

/// Parameters; exactly one of `below` and `above` is given.
#[derive(Debug, Clone, SmartDefault, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Params {
    /// Alarm if z is less than this.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub below: Option<f64>,
    /// Alarm if z is this or more.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub above: Option<f64>,
    /// Frames over which mean and deviation are taken.
    #[default(Over::FramesBefore)]
    pub over: Over,
    /// Number of frames before the current one, 2 to 100000.
    #[default(25)]
    pub span: usize,
}

#[derive(Debug, Clone)]
pub struct StandardScore {
    over: Over,
    before: FramesBefore,
}

/// The detector of [`Over::FramesBefore`].
#[derive(Debug, Clone)]
struct FramesBefore {
    span: usize,
    level: Level,
}

impl Plugin for StandardScore {
    type Params = Params;

    const RANGES: &'static [Range] =
        &[Range::of("below"), Range::of("above"), Range::within("span", 2.0, 100_000.0)];

    fn make(params: Params) -> Result<Self, ParamError> {
        let Params { below, above, over, span } = params;
        let level = Level::new(level::Params { below, above })?;
        Ok(Self { over, before: FramesBefore { span, level } })
    }
}

/// Standard score of a value relative to others; 0 if these do not vary.
fn standard_score(value: f64, among: &[f64]) -> f64 {
    let count = among.len() as f64;
    let mean = among.iter().sum::<f64>() / count;
    let deviation = (among.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / count).sqrt();
    let largest = among.iter().fold(0.0_f64, |largest, v| largest.max(v.abs()));
    if deviation > 1e-9 * largest { ((value - mean) / deviation).clamp(-f64::MAX, f64::MAX) } else { 0.0 }
}

impl Detector for StandardScore {
    fn facts(&self) -> Facts {
        Causal::facts(&self.before)
    }

    fn stream(&self) -> Option<Box<dyn Stream>> {
        if self.over == Over::FramesBefore { self.before.stream() } else { None }
    }

    fn detect(&self, input: &Input<'_>) -> DetectorOutput {
        if self.over == Over::FramesBefore {
            return self.before.detect(input);
        }
        let score: Vec<f64> = input.signal.iter().map(|y| standard_score(*y, input.signal)).collect();
        let alarm = score.iter().map(|z| self.before.level.is_alarm(*z)).collect();
        DetectorOutput { score, alarm, ..DetectorOutput::default() }
    }
}

impl Causal for FramesBefore {
    /// The last `span` values.
    type Memory = VecDeque<f64>;

    fn facts(&self) -> Facts {
        Facts { threshold: Some(self.level.value), direction: self.level.direction(), ..Facts::default() }
    }

    fn step(&self, before: &mut VecDeque<f64>, values: &[f64]) -> Step {
        let is_full = before.len() >= self.span;
        let score = if is_full { standard_score(values[0], before.make_contiguous()) } else { 0.0 };
        if is_full {
            before.pop_front();
        }
        before.push_back(values[0]);
        Step::new(score, self.level.is_alarm(score))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn detect(text: &str, signal: &[f64]) -> DetectorOutput {
        crate::detector::testing::detect(&ENTRY, text, signal)
    }

    // scipy.stats.zscore([1, 2, 4, 1]): -0.8164966, 0, 1.6329932, -0.8164966 (SciPy 1.17; the deviation of the population).
    #[test]
    fn scores_of_a_track_agree_with_scipy() {
        let output = detect("{ above = 1.0, over = \"track\" }", &[1.0, 2.0, 4.0, 1.0]);
        let want = [-0.816_496_580_927_726, 0.0, 1.632_993_161_855_452, -0.816_496_580_927_726];
        trackfail_testing::assert_near(&output.score, want, 1e-14, "");
        assert_eq!(output.alarm, [false, false, true, false]);
    }

    // By hand: of 1 and 3 mean 2, deviation 1; of 3 and 4 mean 3.5, deviation .5.
    #[test]
    fn frames_before_by_hand() {
        let output = detect("{ below = -1.0, span = 2 }", &[1.0, 3.0, 4.0, 2.0]);
        assert_eq!(output.score, [0.0, 0.0, 2.0, -3.0]);
        assert_eq!(output.alarm, [false, false, false, true]);
    }

    #[test]
    fn a_score_is_finite() {
        let output = detect("{ above = 9.0, span = 2 }", &[1e-160, 2e-160, 1e200]);
        assert_eq!(output.score, [0.0, 0.0, f64::MAX]);
    }

    // By hand: beside a million, a deviation of 1e-4 is rounding.
    #[test]
    fn what_hardly_varies_has_no_score() {
        assert_eq!(standard_score(1e6 + 1e-4, &[1e6 + 1e-4, 1e6 - 1e-4]), 0.0);
        assert!((standard_score(1e6 + 1e-2, &[1e6 + 1e-2, 1e6 - 1e-2]) - 1.0).abs() < 1e-6);
    }

    proptest! {
        #[test]
        fn unit_and_origin_do_not_matter(
            signal in proptest::collection::vec(-3.0..3.0_f64, 3..60), scale in 0.1..50.0_f64, shift in -9.0..9.0_f64,
        ) {
            let moved: Vec<f64> = signal.iter().map(|v| scale * v + shift).collect();
            for over in ["track", "frames-before"] {
                let text = format!("{{ above = 2.3, span = 5, over = \"{over}\" }}");
                for (a, b) in detect(&text, &signal).score.iter().zip(detect(&text, &moved).score) {
                    prop_assert!((a - b).abs() < 1e-6 * (1.0 + a.abs()));
                }
            }
        }
    }
}
