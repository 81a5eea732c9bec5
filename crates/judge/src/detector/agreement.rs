//! `agreement`: a loss if a second tracker (watchdog) is confident of another place; an alarm if that is
//! news. Nothing is learned.
//!
//! ```text
//! r[t]      (1 - I[t]) s[t]                        I: overlap of watchdog and tracker, s: the watchdog's score
//! p[t]      r / (r + 20 (1 - r))                   the score: the odds of r over 20
//! fresh     I > 0 in one of the last `window` frames before t, or in t
//! a[t]      p[t] if fresh, else p[t] / 1000        compared with the threshold
//! alarm     from a[t] >= threshold on, while p[t] >= threshold
//! ```
//!
//! The signals are the values `overlap` and `score` of `watchdog-agreement`, both in `[0, 1]`; `t` is a
//! 0-based frame, and the boxes coincide before frame 0. `p` is the probability of a loss; it stays high
//! while the loss lasts. An alarm marks an event: a watchdog that has been apart from the tracker for longer
//! than the window either has lost the target itself or has raised its alarm already, and raises no more.
//! Once the tracker touches the watchdog again, a new alarm is possible.
//!
//! `budget` is the largest number of good frames among 1000 at or above the threshold that the user accepts;
//! the threshold for it is that of the worst of three sources of videos (docs/fused.md). `threshold` sets it outright.
//!
//! Source: none. Choices: the product, whose factors say where and how sure; the factor 20 of the odds, which logistic
//! regression on the sources together gives (slope .96, offset -3.02); a window of 20 frames, against 40 and 80 on inner
//! folds of videos.

use super::prelude::*;
use super::threshold_within;
use crate::num::fixed;

pub(crate) const ENTRY: Entry<dyn Detector> = Entry::of::<Params>(
    "agreement",
    1,
    "lost where a watchdog is sure of another place, with an alarm while that is news",
)
.more(&["{ budget = 2.0, window = 10 }", "{ threshold = 0.5 }"]);

/// Factor of the probability for an old disagreement.
const OLD: f64 = 0.001;

/// Odds `r / (1 - r)` at which a loss has probability 1/2.
const EVEN: f64 = 20.0;

/// Budgets of false alarms per 1000 good frames, with thresholds that keep them on each of the sources OTB,
/// VOT2014 and UAV123 (10 frames per second).
const THRESHOLDS: [(f64, f64); 6] =
    [(1.0, 0.997), (2.0, 0.9894), (5.0, 0.9486), (10.0, 0.8823), (20.0, 0.7271), (50.0, 0.3986)];

#[derive(Debug, Clone, SmartDefault, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Params {
    /// Most false alarms per 1000 good frames, 0.000001 to 1000.
    #[default(5.0)]
    pub budget: f64,
    /// Threshold, above 0 and at most 1; replaces that for the budget.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub threshold: Option<f64>,
    /// Number of frames during which a disagreement is news, 0 to 10000.
    #[default(20)]
    pub window: u32,
}

impl PlainParams for Params {
    const RANGES: &'static [Range] = &[
        Range::within("budget", 1e-6, 1000.0),
        Range::of("threshold").above(0.0).at_most(1.0),
        Range::within("window", 0.0, 10_000.0),
    ];
}

impl Params {
    fn limit(&self) -> f64 {
        self.threshold.or_else(|| threshold_within(&THRESHOLDS, self.budget)).unwrap_or(1.0)
    }
}

/// State of the detector between frames.
#[derive(Debug, Clone, Copy, Default, Serialize, Deserialize)]
pub struct Memory {
    /// Frames since watchdog and tracker overlapped.
    apart: u32,
    /// True while an alarm is on.
    alarm: bool,
}

impl Causal for Params {
    type Memory = Memory;

    fn facts(&self) -> Facts {
        Facts { signals: 2, threshold: Some(self.limit()), gives_probability: true, ..Facts::default() }
    }

    fn step(&self, memory: &mut Memory, values: &[f64]) -> Step {
        let (overlap, score) = inputs(values);
        let apart = (1.0 - overlap) * score;
        let lost = apart / (apart + EVEN * (1.0 - apart));
        memory.apart = if overlap > 0.0 { 0 } else { memory.apart.saturating_add(1) };
        let raising = if memory.apart <= self.window { lost } else { OLD * lost };
        memory.alarm = raising >= self.limit() || (memory.alarm && lost >= self.limit());
        Step { alarm_score: Some(raising), ..Step::new(lost, memory.alarm) }
    }

    fn reason(&self, values: &[f64]) -> Option<String> {
        let (overlap, score) = inputs(values);
        let (overlap, score) = (fixed(overlap, 2), fixed(score, 2));
        Some(format!("overlap with the watchdog {overlap}, which is sure of its place by {score}"))
    }
}

/// Overlap and score from the signal values, both in `[0, 1]`. A missing score counts as 1.
fn inputs(values: &[f64]) -> (f64, f64) {
    let unit = |k: usize| values.get(k).copied().unwrap_or(1.0).clamp(0.0, 1.0);
    (unit(0), unit(1))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::detector::testing;

    fn output(text: &str, overlap: &[f64], score: &[f64]) -> DetectorOutput {
        testing::built(&ENTRY, text).detect(&Input { more: &[score], ..testing::alone(overlap) })
    }

    // By hand, with a window of two frames: apart from frame 2 on, news in 2 and 3; the alarm lasts while p does.
    #[test]
    fn an_alarm_is_raised_by_news_and_held_by_the_state() {
        let overlap = [0.9, 0.5, 0.0, 0.0, 0.0, 0.0, 0.25, 0.0];
        let score = [1.0, 0.5, 0.25, 0.5, 0.9, 0.5, 1.0, 1.0];
        let found = output("{ threshold = 0.0476, window = 2 }", &overlap, &score);
        let apart: Vec<String> = found.score.iter().map(|p| fixed(20.0 * p / (1.0 + 19.0 * p), 3)).collect();
        assert_eq!(apart.join(" "), "0.100 0.250 0.250 0.500 0.900 0.500 0.750 1.000");
        let old: Vec<bool> = found.compared().iter().zip(&found.score).map(|(a, p)| a < p).collect();
        assert_eq!(old, [false, false, false, false, true, true, false, false]);
        assert_eq!(found.compared()[4], OLD * found.score[4]);
        assert_eq!(found.alarm, [false, false, false, true, true, true, true, true]);
        // A disagreement that begins unsure and is old when it becomes sure raises nothing.
        let late = output("{ threshold = 0.05, window = 2 }", &[0.0; 5], &[0.1, 0.1, 0.1, 0.9, 0.9]);
        assert_eq!(late.alarm, [false; 5]);
        // What is sure reaches a threshold of 1, as news and after it.
        assert_eq!(output("{ threshold = 1.0, window = 1 }", &[0.0; 4], &[1.0; 4]).alarm, [true; 4]);
        let judged = testing::built(&ENTRY, "{}").stream().unwrap().push(&[0.0, 1.0]);
        assert_eq!(judged.reasons, ["overlap with the watchdog 0.00, which is sure of its place by 1.00"]);
    }

    #[test]
    fn a_larger_budget_has_no_higher_threshold() {
        let of = |budget: f64| Params { budget, ..Params::default() }.limit();
        assert!(THRESHOLDS.windows(2).all(|pair| pair[0].0 < pair[1].0 && pair[0].1 >= pair[1].1));
        let (found, places) = ([0.5, 3.0, THRESHOLDS[2].0, 1000.0].map(of), [0, 1, 2, 5]);
        assert_eq!(found, places.map(|k: usize| THRESHOLDS[k].1));
    }
}
