//! The list of the metrics of detectors.

use super::{Kind, Metric, Source};
use crate::direction::Direction::{HigherIsBetter, LowerIsBetter, Neither};
use crate::score::chance::Chance;
use crate::score::counts::Counts;
use crate::score::pooled::Pooled;

/// TP, FP, FN and TN.
fn four(pooled: &Pooled) -> [u64; 4] {
    let Counts { tp, fp, fn_, tn } = pooled.counts;
    [tp, fp, fn_, tn]
}

/// Expected true positives of as many detections at random; NaN for an unknown protocol.
fn expected(pooled: &Pooled) -> f64 {
    pooled.chance.map_or(f64::NAN, |chance: Chance| chance.expected_true_positives(&pooled.counts))
}

/// Common to counts that are summed.
const SUMMED: Metric = Metric {
    name: "",
    heading: "",
    direction: Neither,
    unit: "",
    kind: Kind::Count,
    source: Source::Counts,
    formula: "sum over sequences and runs",
    filled: |_| String::new(),
    value: |_| None,
};

/// Common to the metrics of scores.
const SCORED: Metric = Metric {
    kind: Kind::Real,
    source: Source::Scores,
    formula: "mean and standard deviation of the scores of all frames, each run's brought to 0..1 by its own minimum \
              and maximum; runs of constant score are left out",
    ..SUMMED
};

/// Common to the metrics of reverse runs.
const REVERSED: Metric = Metric {
    direction: LowerIsBetter,
    source: Source::Effort,
    formula: "sum over sequences and runs; counted while the tracker was run backwards, see checks.csv",
    ..SUMMED
};

/// Common to the metrics of frames; the measures are in [`crate::score::frames`].
const FRAMED: Metric =
    Metric { direction: HigherIsBetter, kind: Kind::Real, source: Source::Frames, ..SUMMED };

/// Every metric of detectors, by name.
pub const METRICS: &[Metric] = &[
    Metric {
        name: "precision",
        heading: "precision",
        direction: HigherIsBetter,
        unit: "",
        kind: Kind::Ratio,
        source: Source::Counts,
        formula: "TP / (TP + FP)",
        filled: |p| {
            let [tp, fp, ..] = four(p);
            format!(" = {tp} / ({tp} + {fp})")
        },
        value: |p| p.counts.precision(),
    },
    Metric {
        name: "recall",
        heading: "recall",
        direction: HigherIsBetter,
        unit: "",
        kind: Kind::Ratio,
        source: Source::Counts,
        formula: "TP / (TP + FN)",
        filled: |p| {
            let [tp, _, fn_, _] = four(p);
            format!(" = {tp} / ({tp} + {fn_})")
        },
        value: |p| p.counts.recall(),
    },
    Metric {
        name: "f_score",
        heading: "F1 score",
        direction: HigherIsBetter,
        unit: "",
        kind: Kind::Ratio,
        source: Source::Counts,
        formula: "2 TP / (2 TP + FP + FN)",
        filled: |p| {
            let [tp, fp, fn_, _] = four(p);
            format!(" = {} / ({} + {fp} + {fn_})", 2 * tp, 2 * tp)
        },
        value: |p| p.counts.f_score(),
    },
    Metric {
        name: "fpr",
        heading: "false positive rate",
        direction: LowerIsBetter,
        unit: "",
        kind: Kind::Ratio,
        source: Source::Counts,
        formula: "FP / (FP + TN)",
        filled: |p| {
            let [_, fp, _, tn] = four(p);
            format!(" = {fp} / ({fp} + {tn})")
        },
        value: |p| p.counts.fpr(),
    },
    Metric {
        name: "score_mean",
        heading: "mean normalized score",
        value: |p| p.score.map(|s| s.0),
        ..SCORED
    },
    Metric {
        name: "score_std",
        heading: "deviation of normalized scores",
        value: |p| p.score.map(|s| s.1),
        ..SCORED
    },
    Metric {
        name: "score_mean_std",
        heading: "normalized score",
        kind: Kind::MeanAndDeviation,
        value: |p| p.score.map(|s| s.0),
        ..SCORED
    },
    Metric {
        name: "tp",
        heading: "true positives",
        direction: HigherIsBetter,
        unit: "detections",
        value: |p| Some(p.counts.tp as f64),
        ..SUMMED
    },
    Metric {
        name: "fp",
        heading: "false positives",
        direction: LowerIsBetter,
        unit: "detections",
        value: |p| Some(p.counts.fp as f64),
        ..SUMMED
    },
    Metric {
        name: "fn",
        heading: "false negatives",
        direction: LowerIsBetter,
        unit: "events",
        value: |p| Some(p.counts.fn_ as f64),
        ..SUMMED
    },
    Metric {
        name: "tn",
        heading: "true negatives",
        direction: Neither,
        unit: "frames",
        value: |p| Some(p.counts.tn as f64),
        ..SUMMED
    },
    Metric {
        name: "events",
        heading: "ground-truth events",
        direction: Neither,
        unit: "events",
        kind: Kind::Count,
        source: Source::Counts,
        formula: "TP + FN",
        filled: |p| {
            let [tp, _, fn_, _] = four(p);
            format!(" = {tp} + {fn_}")
        },
        value: |p| Some((p.counts.tp + p.counts.fn_) as f64),
    },
    Metric {
        name: "detections",
        heading: "detections",
        direction: Neither,
        unit: "detections",
        kind: Kind::Count,
        source: Source::Counts,
        formula: "TP + FP",
        filled: |p| {
            let [tp, fp, ..] = four(p);
            format!(" = {tp} + {fp}")
        },
        value: |p| Some((p.counts.tp + p.counts.fp) as f64),
    },
    Metric {
        name: "accuracy",
        heading: "accuracy",
        direction: HigherIsBetter,
        unit: "",
        kind: Kind::Ratio,
        source: Source::Counts,
        formula: "(TP + TN) / (TP + FP + FN + TN)",
        filled: |p| {
            let [tp, fp, fn_, tn] = four(p);
            format!(" = ({tp} + {tn}) / ({tp} + {fp} + {fn_} + {tn})")
        },
        value: |p| p.counts.accuracy(),
    },
    Metric {
        name: "informedness",
        heading: "informedness (Youden's J)",
        direction: HigherIsBetter,
        unit: "",
        kind: Kind::Real,
        source: Source::Counts,
        formula: "TP / (TP + FN) - FP / (FP + TN)",
        filled: |p| {
            let [tp, fp, fn_, tn] = four(p);
            format!(" = {tp} / ({tp} + {fn_}) - {fp} / ({fp} + {tn})")
        },
        value: |p| p.counts.informedness(),
    },
    Metric {
        name: "reverse_runs",
        heading: "runs backwards in time",
        unit: "runs",
        value: |p| Some(p.effort.runs as f64),
        ..REVERSED
    },
    Metric {
        name: "reverse_frames",
        heading: "frames of all runs backwards",
        unit: "frames",
        value: |p| Some(p.effort.frames as f64),
        ..REVERSED
    },
    Metric {
        name: "f_by_chance",
        heading: "F1 by chance",
        direction: Neither,
        unit: "",
        kind: Kind::Ratio,
        source: Source::Counts,
        formula: "2 TP0 / (2 TP + FP + FN)",
        filled: |p| {
            let [tp, fp, ..] = four(p);
            let hits = expected(p);
            format!("; TP0 = {hits:.2}, the true positives expected of {} detections at random", tp + fp)
        },
        value: |p| p.chance?.expected_f1(&p.counts),
    },
    Metric {
        name: "f_over_chance",
        heading: "F1 over chance",
        direction: HigherIsBetter,
        unit: "",
        kind: Kind::Real,
        source: Source::Counts,
        formula: "(F - F0) / (1 - F0)",
        filled: |p| {
            let [tp, fp, fn_, _] = four(p);
            let (hits, both) = (expected(p), 2 * tp + fp + fn_);
            format!(
                "; F = {} / {both}; F0 = 2 * {hits:.2} / {both}, with the true positives expected of {} detections \
                 at random",
                2 * tp,
                tp + fp
            )
        },
        value: |p| p.chance?.f_over_chance(&p.counts),
    },
    Metric {
        name: "miss_rate",
        heading: "miss rate",
        direction: LowerIsBetter,
        unit: "",
        kind: Kind::Ratio,
        source: Source::Counts,
        formula: "FN / (TP + FN)",
        filled: |p| {
            let [tp, _, fn_, _] = four(p);
            format!(" = {fn_} / ({tp} + {fn_})")
        },
        value: |p| p.counts.miss_rate(),
    },
    Metric {
        name: "false_alarms_per_1000",
        heading: "false alarms per 1000 frames",
        direction: LowerIsBetter,
        unit: "per 1000 frames",
        kind: Kind::Ratio,
        source: Source::Counts,
        formula: "1000 FP / (TP + FP + FN + TN)",
        filled: |p| {
            let [tp, fp, fn_, tn] = four(p);
            format!(" = 1000 * {fp} / ({tp} + {fp} + {fn_} + {tn})")
        },
        value: |p| p.counts.false_alarms_per_1000(),
    },
    Metric {
        name: "detections_per_1000",
        heading: "detections per 1000 frames",
        direction: Neither,
        unit: "per 1000 frames",
        kind: Kind::Ratio,
        source: Source::Counts,
        formula: "(1000 TP + 1000 FP) / (TP + FP + FN + TN)",
        filled: |p| {
            let [tp, fp, fn_, tn] = four(p);
            format!(" = (1000 * {tp} + 1000 * {fp}) / ({tp} + {fp} + {fn_} + {tn})")
        },
        value: |p| p.counts.detections_per_1000(),
    },
    Metric {
        name: "events_per_1000",
        heading: "events per 1000 frames",
        direction: Neither,
        unit: "per 1000 frames",
        kind: Kind::Ratio,
        source: Source::Counts,
        formula: "(1000 TP + 1000 FN) / (TP + FP + FN + TN)",
        filled: |p| {
            let [tp, fp, fn_, tn] = four(p);
            format!(" = (1000 * {tp} + 1000 * {fn_}) / ({tp} + {fp} + {fn_} + {tn})")
        },
        value: |p| p.counts.events_per_1000(),
    },
    Metric {
        name: "delay_median",
        heading: "median delay",
        direction: Neither,
        unit: "frames",
        kind: Kind::Real,
        source: Source::Delays,
        formula: "median over the matched detections of their frame less that of the event",
        filled: |p| format!("; {} detections are matched", p.counts.tp),
        value: |p| p.delay,
    },
    Metric {
        name: "auroc",
        heading: "area under the ROC curve",
        formula: "P(score of a lost frame > that of a good one) + P(equal) / 2; lost: overlap 0, good: all others",
        value: |p| p.frames?.auroc,
        ..FRAMED
    },
    Metric {
        name: "auprc",
        heading: "average precision",
        formula: "sum over thresholds of the gain in recall times precision, frame by frame; lost: overlap 0",
        value: |p| p.frames?.auprc,
        ..FRAMED
    },
    Metric {
        name: "auroc_clear",
        heading: "area under the ROC curve, clear frames",
        formula: "as auroc; lost: overlap (IoU) below 0.1, good: from 0.5 on, the others left out",
        value: |p| p.frames?.auroc_clear,
        ..FRAMED
    },
    Metric {
        name: "auprc_clear",
        heading: "average precision, clear frames",
        formula: "as auprc; lost: overlap (IoU) below 0.1, good: from 0.5 on, the others left out",
        value: |p| p.frames?.auprc_clear,
        ..FRAMED
    },
    Metric {
        name: "false_alarms_at_half",
        heading: "false alarms where half of the losses are found",
        direction: LowerIsBetter,
        unit: "per 1000 good frames",
        formula: "1000 (good frames with an alarm) / (good frames), at the largest threshold that half of the losses reach within 15 frames",
        value: |p| p.frames?.false_alarms_at_half,
        ..FRAMED
    },
    Metric {
        name: "delay_at_half",
        heading: "mean delay where half of the losses are found",
        direction: LowerIsBetter,
        unit: "frames",
        formula: "mean over the losses found of their first frame at the threshold of false_alarms_at_half, less that of the loss",
        value: |p| p.frames?.delay_at_half,
        ..FRAMED
    },
    Metric {
        name: "arl0_at_half",
        heading: "frames between false alarms where half of the losses are found",
        unit: "frames",
        formula: "good frames / runs of alarms that begin in one, at the threshold of false_alarms_at_half",
        value: |p| p.frames?.arl0_at_half,
        ..FRAMED
    },
    Metric {
        name: "found_at_2",
        heading: "losses found at 2 false alarms per 1000 good frames",
        formula: "losses of which at most 2 of 1000 good frames reach the highest score within 15 frames / losses",
        value: |p| p.frames?.found_at_2,
        ..FRAMED
    },
    Metric {
        name: "found_at_5",
        heading: "losses found at 5 false alarms per 1000 good frames",
        formula: "losses of which at most 5 of 1000 good frames reach the highest score within 15 frames / losses",
        value: |p| p.frames?.found_at_5,
        ..FRAMED
    },
    Metric {
        name: "aurc",
        heading: "area under the risk-coverage curve",
        direction: LowerIsBetter,
        formula: "mean over coverages of the share of lost frames among the frames of lowest scores",
        value: |p| p.frames?.aurc,
        ..FRAMED
    },
    Metric {
        name: "augrc",
        heading: "area under the generalized risk-coverage curve",
        direction: LowerIsBetter,
        formula: "mean over coverages c of c times the share of lost frames among the share c of frames of lowest scores",
        value: |p| p.frames?.augrc,
        ..FRAMED
    },
    Metric {
        name: "ece",
        heading: "expected calibration error",
        direction: LowerIsBetter,
        formula: "sum over 10 bins of the share of frames times |share of good frames - mean score|; for scores that are probabilities",
        value: |p| p.frames?.ece,
        ..FRAMED
    },
    Metric {
        name: "range_precision",
        heading: "precision of alarm ranges",
        formula: "mean over runs of alarms of their share of lost frames, divided by the number of losses met",
        value: |p| p.frames?.range_precision,
        ..FRAMED
    },
    Metric {
        name: "range_recall",
        heading: "recall of lost ranges",
        formula: "mean over ranges of lost frames of their share of frames with an alarm, divided by the number of runs of alarms met",
        value: |p| p.frames?.range_recall,
        ..FRAMED
    },
    Metric {
        name: "range_f",
        heading: "F1 of ranges",
        formula: "2 P R / (P + R); P: range_precision, R: range_recall",
        value: |p| p.frames?.range_f,
        ..FRAMED
    },
    Metric {
        name: "nab",
        heading: "NAB score",
        formula: "100 (raw score + losses) / (2 losses), standard profile: 0 for no alarm, 100 for an alarm in the first frame of every loss and no other",
        value: |p| p.frames?.nab,
        ..FRAMED
    },
];
