//! The metrics of tables, one entry each: name, heading, direction, unit, formula and function.
//!
//! Experiment files, tables, `explain`, pages and the docs (`docs/metrics.md`, see [`super::metrics_page`]) are made
//! from [`METRICS`]. A new metric is one entry there and nothing else. The associated constants are handles for code
//! that asks for a certain metric; a name that is not in the list does not compile.

use super::chance::Chance;
use super::counts::Counts;
use super::pooled::Pooled;
use crate::direction::Direction::{self, HigherIsBetter, LowerIsBetter, Neither};

/// A number that tables can show and training can maximize.
#[derive(Clone, Copy)]
pub struct Metric {
    name: &'static str,
    heading: &'static str,
    direction: Direction,
    unit: &'static str,
    kind: Kind,
    source: Source,
    formula: &'static str,
    filled: fn(&Pooled) -> String,
    value: fn(&Pooled) -> Option<f64>,
}

/// How the values of a metric are shown.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// A whole number.
    Count,
    /// A share or rate.
    Ratio,
    /// Any other real number.
    Real,
    /// A mean, shown as `mean±deviation` of the normalized scores.
    MeanAndDeviation,
}

/// Input of a metric.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Source {
    /// The counts, and for metrics of chance the protocol.
    Counts,
    /// The scores of all frames.
    Scores,
    /// The frames of matched events and detections.
    Delays,
    /// The runs of the tracker backwards in time.
    Effort,
}

impl std::fmt::Debug for Metric {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(self.name)
    }
}

/// Metrics are equal when their names are; names are unique in the list.
impl PartialEq for Metric {
    fn eq(&self, other: &Self) -> bool {
        self.name == other.name
    }
}

impl Eq for Metric {}

impl Metric {
    /// TP / (TP + FP).
    pub const PRECISION: Self = named("precision");
    /// TP / (TP + FN).
    pub const RECALL: Self = named("recall");
    /// Harmonic mean of precision and recall.
    pub const F_SCORE: Self = named("f_score");
    /// FP / (FP + TN).
    pub const FPR: Self = named("fpr");
    /// Mean of the normalized scores.
    pub const SCORE_MEAN: Self = named("score_mean");
    /// Standard deviation of the normalized scores.
    pub const SCORE_STD: Self = named("score_std");
    /// True positives.
    pub const TP: Self = named("tp");
    /// False positives.
    pub const FP: Self = named("fp");
    /// False negatives.
    pub const FN: Self = named("fn");
    /// True negatives.
    pub const TN: Self = named("tn");
    /// Ground-truth events.
    pub const EVENTS: Self = named("events");
    /// Detections.
    pub const DETECTIONS: Self = named("detections");
    /// Recall minus FPR.
    pub const INFORMEDNESS: Self = named("informedness");
    /// Runs backwards in time.
    pub const REVERSE_RUNS: Self = named("reverse_runs");
    /// Frames of all runs backwards.
    pub const REVERSE_FRAMES: Self = named("reverse_frames");
    /// F beyond that of random detections.
    pub const F_OVER_CHANCE: Self = named("f_over_chance");
    /// Median delay of matched detections, in frames.
    pub const DELAY_MEDIAN: Self = named("delay_median");

    /// The metric of a name as experiment files use it.
    pub fn from_name(name: &str) -> Option<Self> {
        METRICS.iter().find(|m| m.name == name).copied()
    }

    /// Every name, in the order of the list.
    pub fn names() -> impl Iterator<Item = &'static str> + Clone {
        METRICS.iter().map(|m| m.name)
    }

    /// Its name in experiment files, tables and results.
    pub fn name(self) -> &'static str {
        self.name
    }

    /// Name in running text.
    pub fn heading(self) -> &'static str {
        self.heading
    }

    /// Whether larger or smaller is better.
    pub fn direction(self) -> Direction {
        self.direction
    }

    /// The unit of its values; empty for a number without unit.
    pub fn unit(self) -> &'static str {
        self.unit
    }

    /// How its values are shown.
    pub fn kind(self) -> Kind {
        self.kind
    }

    /// Its input.
    pub fn source(self) -> Source {
        self.source
    }

    /// How it is computed, in words or as a formula of the counts.
    pub fn formula(self) -> &'static str {
        self.formula
    }

    /// The formula with the counts of a pooled number filled in.
    pub fn filled(self, pooled: &Pooled) -> String {
        format!("{}{}", self.formula, (self.filled)(pooled))
    }

    /// Its value; `None` where a denominator is 0 or what it needs is unknown. [`Kind::MeanAndDeviation`] gives the
    /// mean.
    pub fn value(self, pooled: &Pooled) -> Option<f64> {
        (self.value)(pooled)
    }

    /// Whether the part of a suite with an attribute may have it.
    pub fn is_of_counts(self) -> bool {
        matches!(self.source, Source::Counts | Source::Delays)
    }

    /// Whether it is a count, shown without decimals.
    pub fn is_count(self) -> bool {
        self.kind == Kind::Count
    }
}

/// The metric of a name, at compile time.
const fn named(name: &str) -> Metric {
    let mut k = 0;
    while k < METRICS.len() {
        if equal(METRICS[k].name.as_bytes(), name.as_bytes()) {
            return METRICS[k];
        }
        k += 1;
    }
    panic!("no metric has this name")
}

const fn equal(a: &[u8], b: &[u8]) -> bool {
    let mut k = 0;
    while k < a.len() && k < b.len() && a[k] == b[k] {
        k += 1;
    }
    k == a.len() && k == b.len()
}

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
        heading: "mean of the normalized scores",
        value: |p| p.score.map(|s| s.0),
        ..SCORED
    },
    Metric {
        name: "score_std",
        heading: "standard deviation of the normalized scores",
        value: |p| p.score.map(|s| s.1),
        ..SCORED
    },
    Metric {
        name: "score_mean_std",
        heading: "mean and standard deviation of the normalized scores",
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
        heading: "expected F1 of as many detections at random",
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
];

#[cfg(test)]
mod tests;
