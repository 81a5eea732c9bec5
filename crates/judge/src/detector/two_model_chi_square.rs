//! Two sliding windows and a chi-square test, the rival Two-MChi in SanMiguel and Cavallaro (CVIU 131,
//! 2015), after Gustafsson, "Adaptive Filtering and Change Detection" (2000).
//!
//! ```text
//! m1, v   mean and unbiased variance of the N frames that end before the last L
//! m2      mean of the last L frames, t - L + 1 .. t
//! mean:   T[t] = (m1 - m2)^2 / (v / N + v / L)              chi-square with 1 degree of freedom
//! energy: T[t] = sum over the last L of (y - m1)^2 / v      chi-square with L degrees of freedom
//! alarm at t when T[t] > h,  P(chi-square > h) = alpha
//! ```
//!
//! `y` is the signal, `m1` and `m2` are in its unit, `v` in its square; `T` has no unit, `t` is a 0-based
//! frame. High values of `T` are bad; while there are fewer than N + L frames it is 0. Frames at the start in
//! which the signal is exactly 0 are left out: c_t has no reference there yet.
//!
//! Paper to code: L is `length`, alpha as for the paper's own method. The paper only says that the two
//! windows differ in length, that one is taken as free of changes and that the data are taken as Gaussian;
//! the book's text was not available. Choices: N is `reference` times `length` but at least
//! `least_reference`, right before the test window; `v` is at least `variance_floor`; the means are
//! compared, and `energy` is the other reading of "chi-square test".
//!
//! Alarms last while the two windows differ, after a fall as well as after a rise. A run of alarms with m2 >=
//! m1 therefore begins with the change +1, one with m2 < m1 with -1 (the track is consistent again), even if
//! one directly follows the other. The end of an alarm is not a change; the reference window has merely
//! caught up.

use super::consistency;
use super::prelude::*;
use statrs::distribution::{ChiSquared, ContinuousCDF};

pub(crate) const ENTRY: Entry<dyn Detector> = Entry::of::<TwoModelChiSquare>(
    "two-model-chi-square",
    1,
    "chi-square test of the last frames against a longer window before them",
)
.example("{ length = 5, alpha = 0.005 }")
.more(&[
    "{ test = \"energy\", length = 3, least_reference = 2, alpha = 0.05 }",
    "{ length = 1, reference = 9, variance_floor = 0.01 }",
]);

/// Statistic that is tested.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Test {
    /// Means of the two windows.
    Mean,
    /// Energy of the last frames about the mean before them.
    Energy,
}

#[derive(Debug, Clone, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Params {
    /// Length of the test window in frames, L, 1 to 10000.
    pub length: usize,
    /// Length of the reference window in units of `length`, 1 to 100.
    pub reference: usize,
    /// Least length of the reference window in frames, 2 to 10000.
    pub least_reference: usize,
    /// Probability of an alarm if nothing changes, 1e-6 to 0.5.
    pub alpha: f64,
    /// Least variance, in the square of the signal's unit, finite and above 0.
    pub variance_floor: f64,
    /// Statistic that is tested.
    pub test: Test,
}

impl Default for Params {
    fn default() -> Self {
        let test = Test::Mean;
        Self { length: 5, reference: 2, least_reference: 10, alpha: 0.005, variance_floor: 1e-8, test }
    }
}

#[derive(Debug, Clone)]
pub struct TwoModelChiSquare {
    params: Params,
    threshold: f64,
}

impl Plugin for TwoModelChiSquare {
    type Params = Params;

    const RANGES: &'static [Range] = &[
        Range::within("length", 1.0, 10_000.0),
        Range::within("reference", 1.0, 100.0),
        Range::within("least_reference", 2.0, 10_000.0),
        // Nearer to 1, 1 - alpha has too few digits for a quantile.
        Range::within("alpha", 1e-6, 0.5),
        Range::of("variance_floor").above(0.0),
    ];

    fn make(params: Params) -> Result<Self, ParamError> {
        let freedom = match params.test {
            Test::Mean => 1.0,
            Test::Energy => params.length as f64,
        };
        let refuse = |message: String| ParamError { message, key: Some("length"), span: None };
        let chi_square = ChiSquared::new(freedom).map_err(|e| refuse(e.to_string()))?;
        Ok(Self { threshold: chi_square.inverse_cdf(1.0 - params.alpha), params })
    }
}

impl TwoModelChiSquare {
    /// T, and m2 - m1 in some unit, for a reference window followed by the test window.
    fn statistic(&self, reference: &[f64], test: &[f64]) -> (f64, f64) {
        // In units of the largest value nothing overflows, and a constant signal is constant exactly.
        let unit = reference.iter().chain(test).fold(0.0_f64, |most, y| most.max(y.abs()));
        if unit == 0.0 {
            return (0.0, 0.0);
        }
        let (n, l) = (reference.len() as f64, test.len() as f64);
        let m1 = reference.iter().map(|y| y / unit).sum::<f64>() / n;
        let m2 = test.iter().map(|y| y / unit).sum::<f64>() / l;
        let variance = reference.iter().map(|y| (y / unit - m1).powi(2)).sum::<f64>() / (n - 1.0);
        let variance = variance.max(self.params.variance_floor / unit / unit);
        let (distance, scale) = match self.params.test {
            Test::Mean => ((m1 - m2).powi(2), variance / n + variance / l),
            Test::Energy => (test.iter().map(|y| (y / unit - m1).powi(2)).sum(), variance),
        };
        // Of enormous signals the floor is 0 and the quotient may be infinite.
        let statistic = if distance == 0.0 { 0.0 } else { (distance / scale).min(f64::MAX) };
        (statistic, m2 - m1)
    }

    fn compare(&self, signal: &[f64]) -> DetectorOutput {
        let Params { length, reference, least_reference, .. } = self.params;
        let before = (reference * length).max(least_reference);
        let frames = signal.len();
        let mut score = vec![0.0; frames];
        let mut alarm = vec![false; frames];
        let mut changes = vec![0; frames];
        let mut sign = 0;
        for (window, t) in signal.windows(before + length).zip(before + length - 1..) {
            let (reference, test) = window.split_at(before);
            let (statistic, rise) = self.statistic(reference, test);
            score[t] = statistic;
            alarm[t] = statistic > self.threshold;
            let now = match (alarm[t], rise < 0.0) {
                (false, _) => 0,
                (true, false) => 1,
                (true, true) => -1,
            };
            if now != sign {
                changes[t] = now;
            }
            sign = now;
        }
        DetectorOutput { score, alarm, changes: Some(changes), ..DetectorOutput::default() }
    }
}

impl Detector for TwoModelChiSquare {
    fn facts(&self) -> Facts {
        Facts { threshold: Some(self.threshold), frames_to_recover: 1, ..Facts::default() }
    }

    fn detect(&self, input: &Input<'_>) -> DetectorOutput {
        consistency::on_defined_frames(input.signal, |signal| self.compare(signal))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use trackfail_testing::assert_near;

    fn detect(text: &str, signal: &[f64]) -> DetectorOutput {
        crate::detector::testing::detect(&ENTRY, text, signal)
    }

    const SIGNAL: [f64; 25] = [
        0.10, 0.12, 0.09, 0.11, 0.13, 0.10, 0.08, 0.12, 0.11, 0.10, 0.09, 0.12, 0.11, 0.50, 0.62, 0.58, 0.55,
        0.61, 0.57, 0.12, 0.10, 0.11, 0.09, 0.10, 0.12,
    ];

    /// The statistics of the frames from 8 on, of windows of 6 and 3 frames, by their definition.
    fn by_definition(is_energy: bool) -> [f64; 17] {
        std::array::from_fn(|k| {
            let (a, b) = (&SIGNAL[k..k + 6], &SIGNAL[k + 6..k + 9]);
            let [of_a, of_b] = [a, b].map(|y| y.iter().sum::<f64>() / y.len() as f64);
            let squares = |y: &[f64]| y.iter().map(|y| (y - of_a).powi(2)).sum::<f64>();
            let variance = squares(a) / 5.0;
            match is_energy {
                true => squares(b) / variance,
                false => (of_a - of_b).powi(2) / (variance / 6.0 + variance / 3.0),
            }
        })
    }

    // Sums of 0.1 and the like leave about 1e-14 of a squared difference of means.
    fn near(got: &[f64], want: &[f64]) {
        let in_parts =
            |values: &[f64]| values.iter().zip(want).map(|(v, w)| v / w.max(1.0)).collect::<Vec<_>>();
        assert_eq!(got.len(), want.len());
        assert_near(in_parts(got), in_parts(want), 1e-11, "");
    }

    #[test]
    fn statistics_are_those_of_their_definition() {
        // python3 with numpy: the statistics of frame 15.
        near(&[by_definition(false)[7], by_definition(true)[7]], &[3074.18699187, 4665.914634146]);
        let mean = detect("{ length = 3, least_reference = 2 }", &SIGNAL);
        assert_eq!(mean.score[..8], [0.0; 8]);
        near(&mean.score[8..], &by_definition(false));
        let alarms: Vec<usize> = (0..25).filter(|t| mean.alarm[*t]).collect();
        assert_eq!(alarms, [13, 14, 15, 16, 21, 22]);
        let changes = mean.changes.unwrap();
        assert_eq!((changes[13], changes[21]), (1, -1));
        assert_eq!(changes.iter().filter(|c| **c != 0).count(), 2);
        let energy = detect("{ length = 3, least_reference = 2, test = \"energy\" }", &SIGNAL);
        near(&energy.score[8..], &by_definition(true));
    }

    // scipy.stats.chi2.isf(alpha, df)
    #[test]
    fn thresholds_agree_with_scipy() {
        for (text, want) in [
            ("{}", 7.879438576622417),
            ("{ alpha = 0.05 }", 3.841458820694124),
            ("{ alpha = 1e-6 }", 23.928126976934827),
            ("{ alpha = 0.5 }", 0.4549364231195724),
            ("{ test = \"energy\", length = 5 }", 16.749602343639044),
            ("{ test = \"energy\", length = 60 }", 91.95169815962974),
            ("{ test = \"energy\", length = 10000 }", 10368.033052761462),
        ] {
            let got = ENTRY.build_from_text(text).unwrap().facts().threshold.unwrap();
            assert!((got / want - 1.0).abs() < 1e-9, "{text}: {got} {want}");
        }
    }

    // By hand: N = 2, L = 1. Frames 3 and 4 leave 0 for 1 and for -9: two changes without a gap between.
    #[test]
    fn a_fall_that_follows_a_rise_is_a_change_of_its_own() {
        let output = detect("{ length = 1, least_reference = 2 }", &[0.0, 1e-3, 0.0, 1.0, -9.0, -4.0, -4.0]);
        assert_eq!(output.alarm, [false, false, false, true, true, false, false]);
        assert_eq!(output.changes.unwrap(), [0, 0, 0, 1, -1, 0, 0]);
    }

    // By hand: the floor is in the squared unit of the signal, whatever its largest value is.
    #[test]
    fn the_floor_of_the_variance_is_in_the_unit_of_the_signal() {
        let text = "{ length = 1, least_reference = 2, variance_floor = 0.01 }";
        near(&detect(text, &[10.0, 10.0, 20.0]).score[2..], &[100.0 / (0.01 / 2.0 + 0.01)]);
    }

    #[test]
    fn a_constant_never_alarms() {
        for test in ["mean", "energy"] {
            let text = format!("{{ length = 7, test = \"{test}\" }}");
            for level in [0.0, 0.1, -3.3, 1e300] {
                assert_eq!(detect(&text, &[level; 60]).score, [0.0; 60], "{text} {level}");
            }
            // The windows are 14 and 7 frames: from frame 8 + 20 on they hold the constant alone.
            let start: Vec<f64> = (0..80).map(|t| if t < 8 { f64::from(t * t) } else { 0.3 }).collect();
            let output = detect(&text, &start);
            assert!(output.score[28..].iter().all(|t| *t == 0.0));
            assert!(output.score[27] != 0.0);
        }
    }
}
