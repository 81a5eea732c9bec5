//! The list of the measures of frames: an entry is a metric of tables, a column of `frame_measures.csv` with its bounds, and the
//! function that computes it.

use super::alarms::{AtHalf, Reached};
use super::bootstrap::{Samples, interval};
use super::coverage::Areas;
use super::measures::Sampled;
use super::range::RangeScore;
use super::ranking::{auroc, average_precision};
use super::sweep::Sweep;
use super::warning::HORIZONS;
use crate::direction::Direction::{self, HigherIsBetter, LowerIsBetter};

/// A measure of a detector frame by frame, pooled over the tracks of a suite.
#[derive(Clone, Copy)]
pub struct FrameMetric {
    /// Its name in experiments, tables and files.
    pub name: &'static str,
    /// Its name in running text.
    pub heading: &'static str,
    /// Whether larger or smaller is better.
    pub direction: Direction,
    /// Its unit; empty for a number without unit.
    pub unit: &'static str,
    /// How it is computed.
    pub formula: &'static str,
    /// Meaning of its column.
    pub meaning: &'static str,
    /// Whether files of earlier versions may lack it.
    pub is_recent: bool,
    /// Its interval over sequences, if it has one.
    pub bounds: Option<Bounds>,
    /// Its value.
    pub of: Of,
}

/// The bounds of a bootstrap interval over sequences at 95 %.
#[derive(Clone, Copy)]
pub struct Bounds {
    /// Names of the columns of the lower and the upper bound.
    pub names: [&'static str; 2],
    /// The bounds.
    pub of: fn(&Scores<'_>, &Samples) -> Option<(f64, f64)>,
}

/// Source of a measure.
#[derive(Clone, Copy)]
pub enum Of {
    /// The scores alone, whatever the threshold.
    Scores(fn(&Scores<'_>) -> Option<f64>),
    /// The alarms of the detector's own threshold.
    Alarms(fn(&Alarms) -> Option<f64>),
}

/// The scores of all tracks in their order, and what follows from it.
pub struct Scores<'a> {
    /// By the rule of `frames/1`.
    pub(super) all: &'a Sweep,
    /// By the rule of `frames-clear/1`.
    pub(super) clear: &'a Sweep,
    /// Imminent and safe frames for each of [`HORIZONS`].
    pub(super) warning: &'a [Sweep; HORIZONS.len()],
    /// At the threshold that half of the losses reach.
    pub(super) half: Option<AtHalf>,
    /// At each number of false alarms.
    pub(super) reached: &'a Reached<'a, 'a>,
    /// Below the risk-coverage curves.
    pub(super) areas: Option<Areas>,
    /// Calibration, of scores that are probabilities.
    pub(super) ece: Option<f64>,
    /// In bootstrap samples, where there are any.
    pub(super) sampled: Sampled,
}

/// Measures of the alarms of the detector's own threshold.
pub struct Alarms {
    /// As ranges.
    pub(super) range: RangeScore,
    /// By the Numenta Anomaly Benchmark.
    pub(super) nab: Option<f64>,
}

/// Common to all.
const REAL: FrameMetric = FrameMetric {
    name: "",
    heading: "",
    direction: HigherIsBetter,
    unit: "",
    formula: "",
    meaning: "",
    is_recent: false,
    bounds: None,
    of: Of::Scores(|_| None),
};

/// Every measure of frames, in the order of its columns.
pub const FRAME_METRICS: &[FrameMetric] = &[
    FrameMetric {
        name: "auroc",
        heading: "area under the ROC curve",
        formula: "P(score of a lost frame > that of a good one) + P(equal) / 2; lost: overlap 0, good: all others",
        meaning: "Area under the ROC curve; lost: overlap 0, good: all others",
        bounds: Some(Bounds {
            names: ["auroc_low", "auroc_high"],
            of: |s, _| interval(s.sampled.auroc.clone()),
        }),
        of: Of::Scores(|s| auroc(s.all)),
        ..REAL
    },
    FrameMetric {
        name: "auprc",
        heading: "average precision",
        formula: "sum over thresholds of the gain in recall times precision, frame by frame; lost: overlap 0",
        meaning: "Average precision; lost: overlap 0",
        bounds: Some(Bounds {
            names: ["auprc_low", "auprc_high"],
            of: |s, samples| samples.average_precision(s.all),
        }),
        of: Of::Scores(|s| average_precision(s.all)),
        ..REAL
    },
    FrameMetric {
        name: "auroc_clear",
        heading: "area under the ROC curve, clear frames",
        formula: "as auroc; lost: overlap (IoU) below 0.1, good: from 0.5 on, the others left out",
        meaning: "As `auroc`; lost: overlap (IoU) below 0.1, good: from 0.5 on",
        bounds: Some(Bounds {
            names: ["auroc_clear_low", "auroc_clear_high"],
            of: |s, samples| interval(samples.auroc(s.clear)),
        }),
        of: Of::Scores(|s| auroc(s.clear)),
        ..REAL
    },
    FrameMetric {
        name: "auprc_clear",
        heading: "average precision, clear frames",
        formula: "as auprc; lost: overlap (IoU) below 0.1, good: from 0.5 on, the others left out",
        meaning: "As `auprc`; lost: overlap (IoU) below 0.1, good: from 0.5 on",
        of: Of::Scores(|s| average_precision(s.clear)),
        ..REAL
    },
    FrameMetric {
        name: "false_alarms_at_half",
        heading: "false alarms where half of the losses are found",
        direction: LowerIsBetter,
        unit: "per 1000 good frames",
        formula: "1000 (good frames with an alarm) / (good frames), at the largest threshold that half of the losses reach within 15 frames",
        meaning: "False alarms at the threshold that half of the losses reach within 15 frames",
        bounds: Some(Bounds {
            names: ["false_alarms_at_half_low", "false_alarms_at_half_high"],
            of: |s, samples| s.reached.interval(samples),
        }),
        of: Of::Scores(|s| s.half?.false_alarms),
        ..REAL
    },
    FrameMetric {
        name: "delay_at_half",
        heading: "mean delay where half of the losses are found",
        direction: LowerIsBetter,
        unit: "frames",
        formula: "mean over the losses found of their first frame at the threshold of false_alarms_at_half, less that of the loss",
        meaning: "Mean delay of the losses found at that threshold",
        of: Of::Scores(|s| Some(s.half?.delay)),
        ..REAL
    },
    FrameMetric {
        name: "arl0_at_half",
        heading: "frames between false alarms where half of the losses are found",
        unit: "frames",
        formula: "good frames / runs of alarms that begin in one, at the threshold of false_alarms_at_half",
        meaning: "Good frames for each run of false alarms at that threshold",
        of: Of::Scores(|s| s.half?.arl0),
        ..REAL
    },
    FrameMetric {
        name: "found_at_2",
        heading: "losses found at 2 false alarms per 1000 good frames",
        formula: "losses of which at most 2 of 1000 good frames reach the highest score within 15 frames / losses",
        meaning: "Share of the losses found within 15 frames, where at most 2 of 1000 good frames alarm",
        is_recent: true,
        of: Of::Scores(|s| s.reached.found(2.0)),
        ..REAL
    },
    FrameMetric {
        name: "found_at_5",
        heading: "losses found at 5 false alarms per 1000 good frames",
        formula: "losses of which at most 5 of 1000 good frames reach the highest score within 15 frames / losses",
        meaning: "Share of the losses found within 15 frames, where at most 5 of 1000 good frames alarm",
        is_recent: true,
        bounds: Some(Bounds {
            names: ["found_at_5_low", "found_at_5_high"],
            of: |s, _| interval(s.sampled.found_at_5.clone()),
        }),
        of: Of::Scores(|s| s.reached.found(5.0)),
        ..REAL
    },
    FrameMetric {
        name: "auroc_within_5",
        heading: "area under the ROC curve, lost within 5 frames",
        formula: "as auroc; lost: a loss begins within the next 5 frames, good: none does; left out: frames that are lost, and those that fewer than 5 frames follow, unless a loss begins in them",
        meaning: "As `auroc` for frames that are not lost; lost: a loss begins within the next 5 frames",
        is_recent: true,
        bounds: Some(Bounds {
            names: ["auroc_within_5_low", "auroc_within_5_high"],
            of: |s, samples| interval(samples.auroc(&s.warning[0])),
        }),
        of: Of::Scores(|s| auroc(&s.warning[0])),
        ..REAL
    },
    FrameMetric {
        name: "auroc_within_15",
        heading: "area under the ROC curve, lost within 15 frames",
        formula: "as auroc; lost: a loss begins within the next 15 frames, good: none does; left out: frames that are lost, and those that fewer than 15 frames follow, unless a loss begins in them",
        meaning: "As `auroc` for frames that are not lost; lost: a loss begins within the next 15 frames",
        is_recent: true,
        bounds: Some(Bounds {
            names: ["auroc_within_15_low", "auroc_within_15_high"],
            of: |s, samples| interval(samples.auroc(&s.warning[1])),
        }),
        of: Of::Scores(|s| auroc(&s.warning[1])),
        ..REAL
    },
    FrameMetric {
        name: "auroc_within_30",
        heading: "area under the ROC curve, lost within 30 frames",
        formula: "as auroc; lost: a loss begins within the next 30 frames, good: none does; left out: frames that are lost, and those that fewer than 30 frames follow, unless a loss begins in them",
        meaning: "As `auroc` for frames that are not lost; lost: a loss begins within the next 30 frames",
        is_recent: true,
        bounds: Some(Bounds {
            names: ["auroc_within_30_low", "auroc_within_30_high"],
            of: |s, samples| interval(samples.auroc(&s.warning[2])),
        }),
        of: Of::Scores(|s| auroc(&s.warning[2])),
        ..REAL
    },
    FrameMetric {
        name: "aurc",
        heading: "area under the risk-coverage curve",
        direction: LowerIsBetter,
        formula: "mean over coverages of the share of lost frames among the frames of lowest scores",
        meaning: "Area under the risk-coverage curve",
        of: Of::Scores(|s| Some(s.areas?.aurc)),
        ..REAL
    },
    FrameMetric {
        name: "augrc",
        heading: "area under the generalized risk-coverage curve",
        direction: LowerIsBetter,
        formula: "mean over coverages c of c times the share of lost frames among the share c of frames of lowest scores",
        meaning: "Area under the generalized risk-coverage curve",
        of: Of::Scores(|s| Some(s.areas?.augrc)),
        ..REAL
    },
    FrameMetric {
        name: "ece",
        heading: "expected calibration error",
        direction: LowerIsBetter,
        formula: "sum over 10 bins of the share of frames times |share of good frames - mean score|; for scores that are probabilities",
        meaning: "Expected calibration error, of scores that are probabilities",
        of: Of::Scores(|s| s.ece),
        ..REAL
    },
    FrameMetric {
        name: "range_precision",
        heading: "precision of alarm ranges",
        formula: "mean over runs of alarms of their share of lost frames, divided by the number of losses met",
        meaning: "Range-based precision of the method's alarms",
        of: Of::Alarms(|a| a.range.precision),
        ..REAL
    },
    FrameMetric {
        name: "range_recall",
        heading: "recall of lost ranges",
        formula: "mean over ranges of lost frames of their share of frames with an alarm, divided by the number of runs of alarms met",
        meaning: "Range-based recall of the method's alarms",
        of: Of::Alarms(|a| a.range.recall),
        ..REAL
    },
    FrameMetric {
        name: "range_f",
        heading: "F1 of ranges",
        formula: "2 P R / (P + R); P: range_precision, R: range_recall",
        meaning: "F1 of `range_precision` and `range_recall`",
        of: Of::Alarms(|a| a.range.f_score()),
        ..REAL
    },
    FrameMetric {
        name: "nab",
        heading: "NAB score",
        formula: "100 (raw score + losses) / (2 losses), standard profile: 0 for no alarm, 100 for an alarm in the first frame of every loss and no other",
        meaning: "NAB score of the method's alarms, standard profile",
        of: Of::Alarms(|a| a.nab),
        ..REAL
    },
];
