//! `relative-drop`: the signal against its own mean over the frames called good, as trackers judge their
//! response map: LMCF (Wang, Liu and Huang, CVPR 2017) and FuCoLoT (`track_fclt_tracker.m`).
//!
//! ```text
//! m[t] = mean of y over the last `window` frames before t without an alarm
//! rule = "ratio":    r[t] = y[t] / m[t]             rule = "excess":    r[t] = (m[t] - y[t]) / y[t]
//! alarm at t when r[t] < below          or          alarm at t when r[t] >= above
//! ```
//!
//! `y` and `m` are in the signal's unit, `r` (the score) has none; `t` is a 0-based frame. A drop of the signal is a
//! low `ratio` and a high `excess`: for signals where high values are good `below` goes with `ratio` and `above`
//! with `excess`, for the others the other way round. For positive signals `excess` r is `ratio` 1 / (1 + r).
//!
//! LMCF, as it is usually quoted, calls a response reliable when its APCE is at least 0.45 of the mean and its maximum
//! 0.7 of it: `below = 0.45`. FuCoLoT: `rule = "excess", above = 1.7, window = 100, least = 5`, where the frames that
//! it tracks are good and its first decision is in the sixth one; it loses its target above 1.7, here at 1.7 too.
//!
//! Choices where the sources are silent: without `window` all good frames are in the mean. The rules are
//! for signals above 0; frames in which `m` is not above 0 score as a frame of the mean does (1 and 0), without an
//! alarm. A signal of 0 or less below a positive mean has the largest finite `excess`.

use super::control_chart::RunningMean;
use super::level::{self, Level};
use super::prelude::*;
use std::collections::VecDeque;

pub(crate) const ENTRY: Entry<dyn Detector> = Entry::of::<RelativeDrop>(
    "relative-drop",
    1,
    "alarm while the signal is off its mean over the frames called good by too large a factor",
)
.example("{ below = 0.45 }")
.more(&[
    "{ above = 1.3, window = 3, least = 2 }",
    "{ rule = \"excess\", above = 1.7, window = 100, least = 5 }",
    "{ rule = \"excess\", below = -0.3 }",
]);

/// Rule by which a value is compared with the mean.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Rule {
    /// Value divided by the mean.
    Ratio,
    /// Mean minus value, divided by the value.
    Excess,
}

/// Parameters; exactly one of `below` and `above` is given.
#[derive(Debug, Clone, SmartDefault, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Params {
    /// Alarm if the score is less than this; below 1 for `ratio`, below 0 for `excess`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub below: Option<f64>,
    /// Alarm if the score is this or more; above 1 for `ratio`, above 0 for `excess`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub above: Option<f64>,
    /// Rule by which a value is compared with the mean.
    #[default(Rule::Ratio)]
    pub rule: Rule,
    /// Number of latest good frames over which the mean is taken, 1 to 10000; by default all.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub window: Option<usize>,
    /// Number of good frames before the first decision, 1 to 10000 and at most `window`. Frames before it
    /// count as good.
    #[default(1)]
    pub least: usize,
}

#[derive(Debug, Clone)]
pub struct RelativeDrop {
    params: Params,
    level: Level,
}

impl Plugin for RelativeDrop {
    type Params = Params;

    const RANGES: &'static [Range] = &[Range::of("below"), Range::of("above"), WINDOW, LEAST];

    fn make(params: Params) -> Result<Self, ParamError> {
        let Params { below, above, rule, window, least } = params;
        let level = Level::new(level::Params { below, above })?;
        // A signal that keeps its mean is never an alarm, whatever its sums are rounded to.
        let (ordinary, words) = match (level.is_least, rule) {
            (true, Rule::Ratio) => (level.value < 1.0, "below 1"),
            (false, Rule::Ratio) => (level.value > 1.0, "above 1"),
            (true, Rule::Excess) => (level.value < 0.0, "below 0"),
            (false, Rule::Excess) => (level.value > 0.0, "above 0"),
        };
        ParamError::unless(ordinary, level.key(), words, level.value)?;
        check_least(least, window)?;
        Ok(Self { params, level })
    }
}

impl RelativeDrop {
    /// Score of a value; `None` if the mean allows none.
    fn score(&self, y: f64, mean: f64) -> Option<f64> {
        let score = match self.params.rule {
            Rule::Ratio => y / mean,
            Rule::Excess if y > 0.0 => (mean - y) / y,
            Rule::Excess => f64::MAX,
        };
        (mean > 0.0).then_some(score.clamp(-f64::MAX, f64::MAX))
    }
}

impl Causal for RelativeDrop {
    type Memory = GoodFrames;

    fn facts(&self) -> Facts {
        Facts { threshold: Some(self.level.value), direction: self.level.direction(), ..Facts::default() }
    }

    fn begin(&self) -> GoodFrames {
        GoodFrames::new(self.params.window)
    }

    fn step(&self, good: &mut GoodFrames, values: &[f64]) -> Step {
        let Params { rule, least, .. } = self.params;
        let even = if rule == Rule::Ratio { 1.0 } else { 0.0 };
        let score = if good.count() < least { None } else { self.score(values[0], good.mean()) };
        let alarm = score.is_some_and(|r| self.level.is_alarm(r));
        if !alarm {
            good.add(values[0]);
        }
        Step::new(score.unwrap_or(even), alarm)
    }
}

/// Range of `window`; `LEAST` is that of `least`. [`check_least`] compares both.
pub(super) const WINDOW: Range = Range::within("window", 1.0, 10_000.0);
pub(super) const LEAST: Range = Range::within("least", 1.0, 10_000.0);

/// Refuses a first decision that needs more good frames than the window holds.
pub(super) fn check_least(least: usize, window: Option<usize>) -> Result<(), ParamError> {
    let is_fine = window.is_none_or(|window| least <= window);
    ParamError::unless(is_fine, "least", "at most `window`", least)
}

/// Values of a signal in the good frames so far.
#[derive(Debug, Serialize, Deserialize)]
pub(super) enum GoodFrames {
    All(RunningMean),
    Last(VecDeque<f64>, usize),
}

impl Default for GoodFrames {
    fn default() -> Self {
        Self::new(None)
    }
}

impl GoodFrames {
    pub(super) fn new(window: Option<usize>) -> Self {
        match window {
            None => Self::All(RunningMean::default()),
            Some(window) => Self::Last(VecDeque::with_capacity(window), window),
        }
    }

    pub(super) fn add(&mut self, y: f64) {
        match self {
            Self::All(mean) => mean.add(y),
            Self::Last(values, window) => {
                if values.len() >= *window {
                    values.pop_front();
                }
                values.push_back(y);
            }
        }
    }

    pub(super) fn count(&self) -> usize {
        match self {
            Self::All(mean) => mean.count,
            Self::Last(values, _) => values.len(),
        }
    }

    pub(super) fn mean(&self) -> f64 {
        match self {
            Self::All(mean) => mean.mean,
            Self::Last(values, _) => {
                let mut mean = RunningMean::default();
                values.iter().for_each(|y| mean.add(*y));
                mean.mean
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn detect(text: &str, signal: &[f64]) -> DetectorOutput {
        crate::detector::testing::detect(&ENTRY, text, signal)
    }

    // By hand: the mean is 4 until 2.5 is in it, as the alarm of 1 is not; then (4 + 4 + 2.5) / 3 = 3.5.
    #[test]
    fn the_mean_of_good_frames_is_compared() {
        let output = detect("{ below = 0.5 }", &[4.0, 4.0, 1.0, 2.5, 1.75, 1.5]);
        assert_eq!(output.score[..5], [1.0, 1.0, 0.25, 0.625, 0.5]);
        assert_eq!(output.alarm, [false, false, true, false, false, true]);
        // The mean of 4, 4, 2.5 and 1.75 is 3.0625.
        assert!((output.score[5] - 1.5 / 3.0625).abs() < 1e-15);
        // Low values are good: 8 is twice the mean 4, and stays out of it.
        let output = detect("{ above = 2.0 }", &[4.0, 8.0, 7.0, 11.0]);
        assert_eq!((output.score, output.alarm), (vec![1.0, 2.0, 1.75, 2.0], vec![false, true, false, true]));
    }

    // By hand, with FuCoLoT's numbers: five good frames of 2.7, a first decision in the sixth, (2.7 - 1) / 1 = 1.7, a
    // hair below and above it, and a window that forgets.
    #[test]
    fn the_form_of_fucolot() {
        let text = "{ rule = \"excess\", above = 1.7, window = 100, least = 5 }";
        let steady = [2.7; 5];
        for (last, alarm) in [(1.0001, false), (0.9999, true), (0.0, true), (-1.0, true)] {
            let signal: Vec<f64> = steady.iter().copied().chain([last]).collect();
            assert_eq!(detect(text, &signal).alarm[5], alarm, "{last}");
        }
        assert_eq!(detect(text, &[2.7, 0.1, 0.1, 0.1, 0.1]).alarm, [false; 5]);
        // 100 frames of 3, 100 of 2: the mean is 2 by then, and 0.9 an excess of 1.1 / 0.9 < 1.7 of it, not of 3.
        let mut signal = vec![3.0; 100];
        signal.resize(200, 2.0);
        signal.push(0.9);
        let output = detect(text, &signal);
        assert!((output.score[200] - 1.1 / 0.9).abs() < 1e-12 && !output.alarm[200]);
    }

    #[test]
    fn a_mean_that_is_not_positive_allows_no_decision() {
        // By hand: the means before the frames are none, -1, -3, -3/2 and 1.
        let output = detect("{ below = 0.5 }", &[-1.0, -5.0, 1.5, 8.5, -9.0]);
        assert_eq!(output.score[..4], [1.0; 4]);
        assert!((output.score[4] + 9.0).abs() < 1e-13, "{}", output.score[4]);
        assert_eq!(output.alarm, [false, false, false, false, true]);
        assert_eq!(detect("{ rule = \"excess\", above = 1.0 }", &[0.0, 0.0]).score, [0.0, 0.0]);
    }

    proptest! {
        #[test]
        fn an_excess_is_a_ratio(signal in prop::collection::vec(0.01_f64..2.0, 0..64), limit in 0.1_f64..3.0) {
            let excess = detect(&format!("{{ rule = \"excess\", above = {limit:?}, window = 9 }}"), &signal);
            let ratio = detect(&format!("{{ below = {:?}, window = 9 }}", 1.0 / (1.0 + limit)), &signal);
            prop_assert_eq!(excess.alarm, ratio.alarm);
        }

        #[test]
        fn a_window_as_long_as_the_track_is_none(signal in prop::collection::vec(-1.0_f64..2.0, 0..64)) {
            prop_assert_eq!(detect("{ below = 0.6 }", &signal), detect("{ below = 0.6, window = 64 }", &signal));
        }
    }
}
