//! From counts to measures.
//!
//! ```text
//! precision P = TP / (TP + FP)      recall R = TP / (TP + FN)      FPR = FP / (FP + TN)
//! F = 2 TP / (2 TP + FP + FN)       the harmonic mean of P and R
//! accuracy = (TP + TN) / (TP + FP + FN + TN)              informedness J = R - FPR
//! miss rate = 1 - R              false alarms per 1000 frames = 1000 FP / (TP + FP + FN + TN)
//! ```
//!
//! All lie in `[0, 1]` but J in `[-1, 1]`, which is 0 for labels that have nothing to do with the truth (Youden,
//! "Index for rating diagnostic tests", Cancer 3, 1950), and false alarms; high is good except for FPR, miss rate
//! and false alarms. F over chance is in [`super::chance`]. The delay of a detection is its frame less that of
//! the event it matches, negative where it comes first. A ratio whose denominator is 0 has no value (`None`),
//! which is never written as 0. Pooled measures come from summed counts.

use super::chance::Chance;
use crate::detector::track_quality::Effort;
use crate::direction::Direction;
use serde::{Deserialize, Serialize};

/// True and false positives and negatives.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
pub struct Counts {
    /// Detections that match an event.
    pub tp: u64,
    /// Detections that match none.
    pub fp: u64,
    /// Events that no detection matches.
    pub fn_: u64,
    /// Frames that are rightly silent.
    pub tn: u64,
}

impl std::iter::Sum for Counts {
    fn sum<I: Iterator<Item = Self>>(all: I) -> Self {
        all.fold(Self::default(), |a, b| Self {
            tp: a.tp + b.tp,
            fp: a.fp + b.fp,
            fn_: a.fn_ + b.fn_,
            tn: a.tn + b.tn,
        })
    }
}

fn ratio(numerator: u64, denominator: u64) -> Option<f64> {
    (denominator > 0).then(|| numerator as f64 / denominator as f64)
}

impl Counts {
    /// Share of detections that match an event.
    pub fn precision(&self) -> Option<f64> {
        ratio(self.tp, self.tp + self.fp)
    }

    /// Share of events that are matched.
    pub fn recall(&self) -> Option<f64> {
        ratio(self.tp, self.tp + self.fn_)
    }

    /// Harmonic mean of precision and recall; 0 for a silent detector where there are events.
    pub fn f_score(&self) -> Option<f64> {
        ratio(2 * self.tp, 2 * self.tp + self.fp + self.fn_)
    }

    /// False positives per frame that ought to be silent.
    pub fn fpr(&self) -> Option<f64> {
        ratio(self.fp, self.fp + self.tn)
    }

    /// Share of frames that are labelled rightly.
    pub fn accuracy(&self) -> Option<f64> {
        ratio(self.tp + self.tn, self.tp + self.fp + self.fn_ + self.tn)
    }

    /// Share of events that no detection matches.
    pub fn miss_rate(&self) -> Option<f64> {
        ratio(self.fn_, self.tp + self.fn_)
    }

    /// False positives per 1000 frames that the protocol counts.
    pub fn false_alarms_per_1000(&self) -> Option<f64> {
        Some(1000.0 * ratio(self.fp, self.tp + self.fp + self.fn_ + self.tn)?)
    }

    /// Recall less false positive rate.
    pub fn informedness(&self) -> Option<f64> {
        Some(self.recall()? - self.fpr()?)
    }
}

/// A number that tables can show and training can maximise.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Metric {
    /// TP / (TP + FP).
    Precision,
    /// TP / (TP + FN).
    Recall,
    /// Harmonic mean of the two.
    FScore,
    /// FP / (FP + TN).
    Fpr,
    /// Mean of the normalised scores.
    ScoreMean,
    /// Standard deviation of the normalised scores.
    ScoreStd,
    /// Both, as `mean ± deviation`.
    ScoreMeanStd,
    /// True positives.
    Tp,
    /// False positives.
    Fp,
    /// False negatives.
    Fn,
    /// True negatives.
    Tn,
    /// Ground-truth events.
    Events,
    /// Detections.
    Detections,
    /// (TP + TN) / all.
    Accuracy,
    /// Recall less FPR.
    Informedness,
    /// Runs backwards in time.
    ReverseRuns,
    /// Frames of all runs backwards.
    ReverseFrames,
    /// Expected F of as many detections at random.
    FByChance,
    /// F beyond that of random detections: 0 for these, 1 for the best.
    FOverChance,
    /// FN / (TP + FN).
    MissRate,
    /// False positives per 1000 frames.
    FalseAlarms,
    /// Median delay of matched detections, in frames.
    DelayMedian,
}

impl Metric {
    const ALL: [(Self, &'static str); 22] = [
        (Self::Precision, "precision"),
        (Self::Recall, "recall"),
        (Self::FScore, "f_score"),
        (Self::Fpr, "fpr"),
        (Self::ScoreMean, "score_mean"),
        (Self::ScoreStd, "score_std"),
        (Self::ScoreMeanStd, "score_mean_std"),
        (Self::Tp, "tp"),
        (Self::Fp, "fp"),
        (Self::Fn, "fn"),
        (Self::Tn, "tn"),
        (Self::Events, "events"),
        (Self::Detections, "detections"),
        (Self::Accuracy, "accuracy"),
        (Self::Informedness, "informedness"),
        (Self::ReverseRuns, "reverse_runs"),
        (Self::ReverseFrames, "reverse_frames"),
        (Self::FByChance, "f_by_chance"),
        (Self::FOverChance, "f_over_chance"),
        (Self::MissRate, "miss_rate"),
        (Self::FalseAlarms, "false_alarms_per_1000"),
        (Self::DelayMedian, "delay_median"),
    ];

    /// The metric of a name as experiment files use it.
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.iter().find(|(_, n)| *n == name).map(|(m, _)| *m)
    }

    /// Every name.
    pub fn names() -> impl Iterator<Item = &'static str> + Clone {
        Self::ALL.iter().map(|(_, n)| *n)
    }

    /// Its name in experiment files and results.
    pub fn name(self) -> &'static str {
        Self::ALL.iter().find(|(m, _)| *m == self).map_or("", |(_, n)| n)
    }

    /// Whether larger or smaller is better.
    pub fn direction(self) -> Direction {
        match self {
            Self::Precision
            | Self::Recall
            | Self::FScore
            | Self::Tp
            | Self::Accuracy
            | Self::Informedness
            | Self::FOverChance => Direction::HigherIsBetter,
            Self::Fpr
            | Self::Fp
            | Self::Fn
            | Self::ReverseRuns
            | Self::ReverseFrames
            | Self::MissRate
            | Self::FalseAlarms => Direction::LowerIsBetter,
            _ => Direction::Neither,
        }
    }

    /// Whether it is made of counts alone, so that it can be had of any part of a suite.
    pub fn is_of_counts(self) -> bool {
        !matches!(
            self,
            Self::ScoreMean | Self::ScoreStd | Self::ScoreMeanStd | Self::ReverseRuns | Self::ReverseFrames
        )
    }

    /// Whether it is a count, shown without decimals.
    pub fn is_count(self) -> bool {
        matches!(
            self,
            Self::Tp
                | Self::Fp
                | Self::Fn
                | Self::Tn
                | Self::Events
                | Self::Detections
                | Self::ReverseRuns
                | Self::ReverseFrames
        )
    }
}

/// Everything pooled over a suite for one method and tracker.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Pooled {
    /// Summed counts.
    pub counts: Counts,
    /// Mean and deviation of the normalised scores.
    pub score: Option<(f64, f64)>,
    /// What trackers did again.
    pub effort: Effort,
    /// How random detections match by the method's protocol, where it is known.
    pub chance: Option<Chance>,
    /// Median delay of matched detections, in frames.
    pub delay: Option<f64>,
}

impl Pooled {
    /// The value of a metric; [`Metric::ScoreMeanStd`] gives the mean.
    pub fn value(&self, metric: Metric) -> Option<f64> {
        let c = &self.counts;
        match metric {
            Metric::Precision => c.precision(),
            Metric::Recall => c.recall(),
            Metric::FScore => c.f_score(),
            Metric::Fpr => c.fpr(),
            Metric::ScoreMean | Metric::ScoreMeanStd => self.score.map(|s| s.0),
            Metric::ScoreStd => self.score.map(|s| s.1),
            Metric::Tp => Some(c.tp as f64),
            Metric::Fp => Some(c.fp as f64),
            Metric::Fn => Some(c.fn_ as f64),
            Metric::Tn => Some(c.tn as f64),
            Metric::Events => Some((c.tp + c.fn_) as f64),
            Metric::Detections => Some((c.tp + c.fp) as f64),
            Metric::Accuracy => c.accuracy(),
            Metric::Informedness => c.informedness(),
            Metric::ReverseRuns => Some(self.effort.runs as f64),
            Metric::ReverseFrames => Some(self.effort.frames as f64),
            Metric::FByChance => self.chance?.f_score(c),
            Metric::FOverChance => self.chance?.f_over_chance(c),
            Metric::MissRate => c.miss_rate(),
            Metric::FalseAlarms => c.false_alarms_per_1000(),
            Metric::DelayMedian => self.delay,
        }
    }
}

/// Median of delays in frames, the mean of the two in the middle of an even number; none of none.
pub fn median_delay(mut delays: Vec<i64>) -> Option<f64> {
    delays.sort_unstable();
    let n = delays.len();
    (n > 0).then(|| (delays[(n - 1) / 2] + delays[n / 2]) as f64 / 2.0)
}

/// Mean and standard deviation of scores that are min-max normalised a sequence (Khalid et al. 2016,
/// Eq. 12): `z' = (z - min Z) / (max Z - min Z)`, where Z is the scores of one sequence.
///
/// The normalised values of all sequences are pooled; the deviation is the population's. Sequences of
/// constant score have no normalised values and are left out. `None` when nothing is left.
pub fn normalised_mean_std(sequences: impl IntoIterator<Item = impl AsRef<[f64]>>) -> Option<(f64, f64)> {
    let mut normalised = Vec::new();
    for scores in sequences {
        let scores = scores.as_ref();
        let (low, high) =
            scores.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), &z| (l.min(z), h.max(z)));
        if high > low {
            normalised.extend(scores.iter().map(|z| (z - low) / (high - low)));
        }
    }
    let n = normalised.len() as f64;
    let mean = normalised.iter().sum::<f64>() / n;
    let variance = normalised.iter().map(|z| (z - mean).powi(2)).sum::<f64>() / n;
    (!normalised.is_empty()).then(|| (mean, variance.sqrt()))
}

#[cfg(test)]
mod tests {
    use super::*;

    // Khalid et al. 2016, Table 1, DTEF: the counts implied by its ratios.
    #[test]
    fn reproduces_the_papers_ratios_from_its_counts() {
        let c = Counts { tp: 30, fp: 242, fn_: 12, tn: 6475 - 242 };
        let three = |v: Option<f64>| format!("{:.3}", v.unwrap());
        assert_eq!(three(c.precision()), "0.110");
        assert_eq!(three(c.recall()), "0.714");
        assert_eq!(three(c.f_score()), "0.191");
        assert_eq!(three(c.fpr()), "0.037");
    }

    #[test]
    fn a_ratio_without_denominator_has_no_value() {
        let silent = Counts { tp: 0, fp: 0, fn_: 3, tn: 10 };
        assert_eq!(silent.precision(), None);
        assert_eq!(silent.recall(), Some(0.0));
        assert_eq!(silent.f_score(), Some(0.0));
        assert_eq!(Counts::default().f_score(), None);
        assert_eq!((Counts::default().accuracy(), silent.informedness()), (None, Some(0.0)));
        assert_eq!(Counts::default().fpr(), None);
    }

    #[test]
    fn misses_false_alarms_and_delays_by_hand() {
        let c = Counts { tp: 3, fp: 4, fn_: 1, tn: 492 };
        assert_eq!((c.miss_rate(), c.false_alarms_per_1000()), (Some(0.25), Some(8.0)));
        assert_eq!((Counts::default().miss_rate(), Counts::default().false_alarms_per_1000()), (None, None));
        assert_eq!(median_delay(vec![5, -1, 2]), Some(2.0));
        assert_eq!(median_delay(vec![3, -4, 0, 1]), Some(0.5));
        assert_eq!(median_delay(vec![]), None);
        let pooled = Pooled { counts: c, delay: Some(2.0), ..Pooled::default() };
        assert_eq!((pooled.value(Metric::DelayMedian), pooled.value(Metric::FOverChance)), (Some(2.0), None));
    }

    // Worked by hand: [0, 1, 2] -> 0, .5, 1 and [4, 4] has no range; mean .5, variance 1/6.
    #[test]
    fn normalises_each_sequence_by_itself() {
        let (mean, std) = normalised_mean_std([&[0.0, 1.0, 2.0][..], &[4.0, 4.0][..]]).unwrap();
        assert_eq!(mean, 0.5);
        assert!((std - (1.0_f64 / 6.0).sqrt()).abs() < 1e-15);
        assert_eq!(normalised_mean_std([&[1.0, 1.0][..]]), None);
    }
}
