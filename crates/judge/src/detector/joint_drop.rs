//! `joint-drop`: compares each of several signals with its own mean over good frames. A frame is good if all
//! signals stay near their means. LMCF (Wang, Liu and Huang, CVPR 2017) judges its response map in this way,
//! by APCE and peak.
//!
//! ```text
//! m[i,t] = mean of y[i] over the last `window` frames before t without an alarm
//! r[i,t] = y[i,t] / m[i,t]
//! s[t]   = min over i of r[i,t] / below[i]                alarm at t when s[t] < 1
//! ```
//!
//! `y[i]` are the signals, for which high values are good, in their units; `r` and `s` (the score) have none; `t` is a
//! 0-based frame. With one signal, `below = [b]` alarms where `relative-drop` with `below = b` does.
//!
//! LMCF, as it is usually quoted: `below = [0.45, 0.7]` with `response-apce` and `response-peak`; its own code is not
//! public, and one implementation has 0.5 and 0.9 (KCF_APCE).
//!
//! Choices where the source is silent: without `window` all good frames are in the means; the frames of all signals are
//! good together; a signal whose mean is not above 0 does not speak.

use super::prelude::*;
use super::relative_drop::{GoodFrames, LEAST, WINDOW, check_least};

pub(crate) const ENTRY: Entry<dyn Detector> = Entry::of::<Params>(
    "joint-drop",
    1,
    "alarm while any of several signals is below its share of its mean over the frames called good",
)
.example("{ below = [0.45, 0.7] }");

#[derive(Debug, Clone, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Params {
    /// For each signal, the share of its mean below which it alarms, above 0 and below 1; 1 to 16 signals.
    pub below: Vec<f64>,
    /// Number of latest good frames over which means are taken, 1 to 10000; by default all.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub window: Option<usize>,
    /// Number of good frames before the first decision, 1 to 10000 and at most `window`. Frames before it
    /// count as good.
    #[serde(default = "least")]
    pub least: usize,
}

fn least() -> usize {
    1
}

impl PlainParams for Params {
    const RANGES: &'static [Range] = &[Range::of("below").above(0.0).below(1.0), WINDOW, LEAST];

    fn check(&self) -> Result<(), ParamError> {
        let signals = self.below.len();
        ParamError::unless((1..=16).contains(&signals), "below", "1 to 16 shares", signals)?;
        check_least(self.least, self.window)
    }
}

impl Causal for Params {
    /// Good frames of each signal.
    type Memory = Vec<GoodFrames>;

    fn facts(&self) -> Facts {
        let (signals, direction) = (self.below.len(), Direction::HigherIsBetter);
        Facts { signals, threshold: Some(1.0), direction, ..Facts::default() }
    }

    fn begin(&self) -> Vec<GoodFrames> {
        self.below.iter().map(|_| GoodFrames::new(self.window)).collect()
    }

    fn step(&self, good: &mut Vec<GoodFrames>, values: &[f64]) -> Step {
        let of = |((y, good), below): ((&f64, &GoodFrames), &f64)| {
            let mean = good.mean();
            let speaks = good.count() >= self.least && mean > 0.0;
            if speaks { (y / mean / below).clamp(-f64::MAX, f64::MAX) } else { 1.0 / below }
        };
        let score = values.iter().zip(&*good).zip(&self.below).map(of).fold(f64::MAX, f64::min);
        let alarm = score < 1.0;
        if !alarm {
            good.iter_mut().zip(values).for_each(|(good, y)| good.add(*y));
        }
        Step::new(score, alarm)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::detector::{relative_drop, testing::alone};
    use proptest::prelude::*;

    fn detect(below: &[f64], signals: &[&[f64]]) -> DetectorOutput {
        detect_within(None, below, signals)
    }

    fn detect_within(window: Option<usize>, below: &[f64], signals: &[&[f64]]) -> DetectorOutput {
        let detector = Params { below: below.to_vec(), window, least: 1 };
        detector.detect(&Input { more: &signals[1..], ..alone(signals[0]) })
    }

    // By hand: the means are 10 and 1 in frames 1 and 2; the alarm in frame 2 keeps both values out of the means.
    #[test]
    fn any_signal_alarms_and_all_lose_the_frame() {
        let apce = [10.0, 10.0, 8.0, 4.0, 10.0];
        let peak = [1.0, 1.0, 0.6, 1.0, 1.0];
        let output = detect(&[0.45, 0.7], &[&apce, &peak]);
        assert_eq!(output.alarm, [false, false, true, true, false]);
        let scores = [1.0 / 0.7, 1.0 / 0.7, 0.6 / 0.7, 0.4 / 0.45, 1.0 / 0.7];
        assert!(output.score.iter().zip(scores).all(|(s, e)| (s - e).abs() < 1e-12), "{:?}", output.score);
    }

    // By hand. The means are none, 0 and 1/2. Then none, 10 and 7.5, or 5 in a window of one frame.
    #[test]
    fn a_mean_of_0_says_nothing_and_a_score_of_1_is_good() {
        assert_eq!(detect(&[0.5], &[&[0.0, 1.0, 0.25]]).score, [2.0, 2.0, 1.0]);
        let signal = [10.0, 5.0, 2.5];
        assert_eq!(detect(&[0.5], &[&signal]).alarm, [false, false, true]);
        assert_eq!(detect_within(Some(1), &[0.5], &[&signal]).alarm, [false; 3]);
    }

    proptest! {
        #[test]
        fn one_signal_alarms_as_relative_drop_does(
            signal in proptest::collection::vec(0.0..5.0_f64, 1..60),
            below in 0.1..0.9_f64,
        ) {
            let params = relative_drop::Params { below: Some(below), ..relative_drop::Params::default() };
            let input = alone(&signal);
            let alone = relative_drop::RelativeDrop::new(params).unwrap().detect(&input);
            let joint = detect(&[below], &[&signal]);
            let away = |(a, s): (&f64, &f64)| (a - below).abs() > 1e-9 || (s - 1.0).abs() > 1e-9;
            prop_assume!(alone.score.iter().zip(&joint.score).all(away));
            prop_assert_eq!(alone.alarm, joint.alarm);
        }

        #[test]
        fn the_order_of_signals_and_their_scales_do_not_matter(
            pairs in proptest::collection::vec((0.0..5.0_f64, 0.0..5.0_f64), 1..40),
            scale in 0..4,
        ) {
            let (a, b): (Vec<f64>, Vec<f64>) = pairs.into_iter().unzip();
            let larger: Vec<f64> = b.iter().map(|y| y * 2.0_f64.powi(scale)).collect();
            prop_assert_eq!(detect(&[0.4, 0.6], &[&a, &b]), detect(&[0.6, 0.4], &[&larger, &a]));
        }
    }
}
