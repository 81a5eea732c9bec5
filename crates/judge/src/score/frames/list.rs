//! List of the measures of frames. An entry is a metric of tables, a column of `frame_measures.csv` with its
//! bounds, and the function that computes it.

use super::alarms::{AtHalf, Losses};
use super::bootstrap::{Samples, interval};
use super::coverage::Areas;
use super::measures::Sampled;
use super::range::RangeScore;
use super::ranking::{auroc, average_precision};
use super::sweep::Sweep;
use super::warning::HORIZONS;
use crate::direction::Direction::{HigherIsBetter, LowerIsBetter};
use crate::score::metric::{Kind, Metric, Source, Value};

/// A measure of a detector by frame, pooled over the tracks of a suite.
#[derive(Clone, Copy)]
pub struct FrameMetric {
    /// Metric in tables.
    pub metric: Metric,
    /// Meaning of the column in the file.
    pub meaning: &'static str,
    /// True if files of earlier versions may lack the measure.
    pub is_recent: bool,
    /// Bounds of the bootstrap interval over sequences at 95 %; `None` if the measure has no interval.
    pub bounds: Option<BoundsOf>,
    /// Function that computes the value.
    pub of: Of,
}

/// Function that computes the bounds of an interval.
pub type BoundsOf = fn(&Scores<'_>, &Samples) -> Option<(f64, f64)>;

/// Source of a measure: scores or alarms.
#[derive(Clone, Copy)]
pub enum Of {
    /// The scores, independent of the threshold.
    Scores(fn(&Scores<'_>) -> Option<f64>),
    /// The alarms at the detector's own threshold.
    Alarms(fn(&Alarms) -> Option<f64>),
}

/// Scores of all tracks in sorted order, with quantities derived from the order.
pub struct Scores<'a> {
    /// Sorted frames by the rule of `frames/1`.
    pub(super) all: &'a Sweep,
    /// Sorted frames by the rule of `frames-clear/1`.
    pub(super) clear: &'a Sweep,
    /// Sorted imminent and safe frames for each of [`HORIZONS`].
    pub(super) warning: &'a [Sweep; HORIZONS.len()],
    /// Measures at the threshold that half of the losses reach.
    pub(super) half: Option<AtHalf>,
    /// Losses, with the numbers of good frames at or above the peak of each.
    pub(super) losses: &'a Losses<'a>,
    /// Areas under the risk-coverage curves.
    pub(super) areas: Option<Areas>,
    /// Calibration error, for scores that are probabilities.
    pub(super) ece: Option<f64>,
    /// Measures in bootstrap samples, if there are any.
    pub(super) sampled: Sampled,
}

/// Measures of the alarms at the detector's own threshold.
pub struct Alarms {
    /// Precision and recall of ranges.
    pub(super) range: RangeScore,
    /// Score of the Numenta Anomaly Benchmark.
    pub(super) nab: Option<f64>,
}

/// All measures of frames, in the order of their columns.
pub const FRAME_METRICS: &[FrameMetric] = &[
    score("auroc", "area under the ROC curve", |s| auroc(s.all))
        .formula("P(score of a lost frame > that of a good one) + P(equal) / 2; lost: overlap 0, good: all others")
        .meaning("Area under the ROC curve; lost: overlap 0, good: all others")
        .bounds(|s, _| interval(s.sampled.auroc.clone())),
    score("auprc", "average precision", |s| average_precision(s.all))
        .formula("sum over thresholds of the gain in recall times precision, frame by frame; lost: overlap 0")
        .meaning("Average precision; lost: overlap 0")
        .bounds(|s, samples| samples.average_precision(s.all)),
    score("auroc_clear", "area under the ROC curve, clear frames", |s| auroc(s.clear))
        .formula("as auroc; lost: overlap (IoU) below 0.1, good: from 0.5 on, the others left out")
        .meaning("As `auroc`; lost: overlap (IoU) below 0.1, good: from 0.5 on")
        .bounds(|s, samples| interval(samples.auroc(s.clear))),
    score("auprc_clear", "average precision, clear frames", |s| average_precision(s.clear))
        .formula("as auprc; lost: overlap (IoU) below 0.1, good: from 0.5 on, the others left out")
        .meaning("As `auprc`; lost: overlap (IoU) below 0.1, good: from 0.5 on"),
    score("false_alarms_at_half", "false alarms where half of the losses are found", |s| s.half?.false_alarms)
        .lower()
        .unit("per 1000 good frames")
        .formula("1000 (good frames with an alarm) / (good frames), at the largest threshold that half of the losses reach within 15 frames")
        .meaning("False alarms at the threshold that half of the losses reach within 15 frames")
        .bounds(|s, samples| s.losses.interval(samples)),
    score("delay_at_half", "mean delay where half of the losses are found", |s| Some(s.half?.delay))
        .lower()
        .unit("frames")
        .formula("mean over the losses found of their first frame at the threshold of false_alarms_at_half, less that of the loss")
        .meaning("Mean delay of the losses found at that threshold"),
    score("arl0_at_half", "frames between false alarms where half of the losses are found", |s| s.half?.arl0)
        .unit("frames")
        .formula("good frames / runs of alarms that begin in one, at the threshold of false_alarms_at_half")
        .meaning("Good frames for each run of false alarms at that threshold"),
    score("found_at_2", "losses found at 2 false alarms per 1000 good frames", |s| s.losses.found(2.0))
        .formula("losses of which at most 2 of 1000 good frames reach the highest score within 15 frames / losses")
        .meaning("Share of the losses found within 15 frames, where at most 2 of 1000 good frames alarm")
        .recent(),
    score("found_at_5", "losses found at 5 false alarms per 1000 good frames", |s| s.losses.found(5.0))
        .formula("losses of which at most 5 of 1000 good frames reach the highest score within 15 frames / losses")
        .meaning("Share of the losses found within 15 frames, where at most 5 of 1000 good frames alarm")
        .bounds(|s, _| interval(s.sampled.found_at_5.clone()))
        .recent(),
    score("auroc_within_5", "area under the ROC curve, lost within 5 frames", |s| auroc(&s.warning[0]))
        .formula("as auroc; lost: a loss begins within the next 5 frames, good: none does; left out: frames that are lost, and those that fewer than 5 frames follow, unless a loss begins in them")
        .meaning("As `auroc` for frames that are not lost; lost: a loss begins within the next 5 frames")
        .bounds(|s, samples| interval(samples.auroc(&s.warning[0])))
        .recent(),
    score("auroc_within_15", "area under the ROC curve, lost within 15 frames", |s| auroc(&s.warning[1]))
        .formula("as auroc; lost: a loss begins within the next 15 frames, good: none does; left out: frames that are lost, and those that fewer than 15 frames follow, unless a loss begins in them")
        .meaning("As `auroc` for frames that are not lost; lost: a loss begins within the next 15 frames")
        .bounds(|s, samples| interval(samples.auroc(&s.warning[1])))
        .recent(),
    score("auroc_within_30", "area under the ROC curve, lost within 30 frames", |s| auroc(&s.warning[2]))
        .formula("as auroc; lost: a loss begins within the next 30 frames, good: none does; left out: frames that are lost, and those that fewer than 30 frames follow, unless a loss begins in them")
        .meaning("As `auroc` for frames that are not lost; lost: a loss begins within the next 30 frames")
        .bounds(|s, samples| interval(samples.auroc(&s.warning[2])))
        .recent(),
    score("aurc", "area under the risk-coverage curve", |s| Some(s.areas?.aurc))
        .lower()
        .formula("mean over coverages of the share of lost frames among the frames of lowest scores")
        .meaning("Area under the risk-coverage curve"),
    score("augrc", "area under the generalized risk-coverage curve", |s| Some(s.areas?.augrc))
        .lower()
        .formula("mean over coverages c of c times the share of lost frames among the share c of frames of lowest scores")
        .meaning("Area under the generalized risk-coverage curve"),
    score("ece", "expected calibration error", |s| s.ece)
        .lower()
        .formula("sum over 10 bins of the share of frames times |share of good frames - mean score|; for scores that are probabilities")
        .meaning("Expected calibration error, of scores that are probabilities"),
    alarm("range_precision", "precision of alarm ranges", |a| a.range.precision)
        .formula("mean over runs of alarms of their share of lost frames, divided by the number of losses met")
        .meaning("Range-based precision of the method's alarms"),
    alarm("range_recall", "recall of lost ranges", |a| a.range.recall)
        .formula("mean over ranges of lost frames of their share of frames with an alarm, divided by the number of runs of alarms met")
        .meaning("Range-based recall of the method's alarms"),
    alarm("range_f", "F1 of ranges", |a| a.range.f_score())
        .formula("2 P R / (P + R); P: range_precision, R: range_recall")
        .meaning("F1 of `range_precision` and `range_recall`"),
    alarm("nab", "NAB score", |a| a.nab)
        .formula("100 (raw score + losses) / (2 losses), standard profile: 0 for no alarm, 100 for an alarm in the first frame of every loss and no other")
        .meaning("NAB score of the method's alarms, standard profile"),
];

/// A measure of scores for which larger values are better.
const fn score(name: &'static str, heading: &'static str, of: fn(&Scores<'_>) -> Option<f64>) -> FrameMetric {
    let metric = Metric::new(name, heading, HigherIsBetter, (Kind::Real, Source::Frames), Value::Frames);
    FrameMetric { metric, meaning: "", is_recent: false, bounds: None, of: Of::Scores(of) }
}

/// A measure of alarms for which larger values are better.
const fn alarm(name: &'static str, heading: &'static str, of: fn(&Alarms) -> Option<f64>) -> FrameMetric {
    FrameMetric { of: Of::Alarms(of), ..score(name, heading, |_| None) }
}

impl FrameMetric {
    const fn lower(self) -> Self {
        Self { metric: self.metric.with_direction(LowerIsBetter), ..self }
    }

    const fn unit(self, unit: &'static str) -> Self {
        Self { metric: self.metric.with_unit(unit), ..self }
    }

    const fn formula(self, formula: &'static str) -> Self {
        Self { metric: self.metric.with_formula(formula), ..self }
    }

    const fn meaning(self, meaning: &'static str) -> Self {
        Self { meaning, ..self }
    }

    const fn bounds(self, of: BoundsOf) -> Self {
        Self { bounds: Some(of), ..self }
    }

    const fn recent(self) -> Self {
        Self { is_recent: true, ..self }
    }
}
