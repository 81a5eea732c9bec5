//! The list of the metrics of detectors.

use super::{Kind, Metric, Source, Value};
use crate::direction::Direction::{HigherIsBetter, LowerIsBetter, Neither};
use crate::score::chance::Chance;
use crate::score::counts::Counts;
use crate::score::frames::list::{FRAME_METRICS, FrameMetric};
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
    value: Value::Pooled(|_| None),
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

/// Every metric of detectors, by name: those of counts, scores and runs, then those of frames.
pub const METRICS: &[Metric] = &{
    let mut all = [OTHERS[0]; OTHERS.len() + FRAME_METRICS.len()];
    let mut k = 0;
    while k < all.len() {
        all[k] = if k < OTHERS.len() { OTHERS[k] } else { of_frames(k - OTHERS.len()) };
        k += 1;
    }
    all
};

/// The metric of a measure of frames.
const fn of_frames(index: usize) -> Metric {
    let FrameMetric { name, heading, direction, unit, formula, .. } = FRAME_METRICS[index];
    let source = Source::Frames;
    Metric {
        name,
        heading,
        direction,
        unit,
        kind: Kind::Real,
        source,
        formula,
        value: Value::Frames(index),
        ..SUMMED
    }
}

const OTHERS: &[Metric] = &[
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
        value: Value::Pooled(|p| p.counts.precision()),
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
        value: Value::Pooled(|p| p.counts.recall()),
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
        value: Value::Pooled(|p| p.counts.f_score()),
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
        value: Value::Pooled(|p| p.counts.fpr()),
    },
    Metric {
        name: "score_mean",
        heading: "mean normalized score",
        value: Value::Pooled(|p| p.score.map(|s| s.0)),
        ..SCORED
    },
    Metric {
        name: "score_std",
        heading: "deviation of normalized scores",
        value: Value::Pooled(|p| p.score.map(|s| s.1)),
        ..SCORED
    },
    Metric {
        name: "score_mean_std",
        heading: "normalized score",
        kind: Kind::MeanAndDeviation,
        value: Value::Pooled(|p| p.score.map(|s| s.0)),
        ..SCORED
    },
    Metric {
        name: "tp",
        heading: "true positives",
        direction: HigherIsBetter,
        unit: "detections",
        value: Value::Pooled(|p| Some(p.counts.tp as f64)),
        ..SUMMED
    },
    Metric {
        name: "fp",
        heading: "false positives",
        direction: LowerIsBetter,
        unit: "detections",
        value: Value::Pooled(|p| Some(p.counts.fp as f64)),
        ..SUMMED
    },
    Metric {
        name: "fn",
        heading: "false negatives",
        direction: LowerIsBetter,
        unit: "events",
        value: Value::Pooled(|p| Some(p.counts.fn_ as f64)),
        ..SUMMED
    },
    Metric {
        name: "tn",
        heading: "true negatives",
        direction: Neither,
        unit: "frames",
        value: Value::Pooled(|p| Some(p.counts.tn as f64)),
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
        value: Value::Pooled(|p| Some((p.counts.tp + p.counts.fn_) as f64)),
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
        value: Value::Pooled(|p| Some((p.counts.tp + p.counts.fp) as f64)),
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
        value: Value::Pooled(|p| p.counts.accuracy()),
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
        value: Value::Pooled(|p| p.counts.informedness()),
    },
    Metric {
        name: "reverse_runs",
        heading: "runs backwards in time",
        unit: "runs",
        value: Value::Pooled(|p| Some(p.effort.runs as f64)),
        ..REVERSED
    },
    Metric {
        name: "reverse_frames",
        heading: "frames of all runs backwards",
        unit: "frames",
        value: Value::Pooled(|p| Some(p.effort.frames as f64)),
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
        value: Value::Pooled(|p| p.chance?.expected_f1(&p.counts)),
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
        value: Value::Pooled(|p| p.chance?.f_over_chance(&p.counts)),
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
        value: Value::Pooled(|p| p.counts.miss_rate()),
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
        value: Value::Pooled(|p| p.counts.false_alarms_per_1000()),
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
        value: Value::Pooled(|p| p.counts.detections_per_1000()),
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
        value: Value::Pooled(|p| p.counts.events_per_1000()),
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
        value: Value::Pooled(|p| p.delay),
    },
];
