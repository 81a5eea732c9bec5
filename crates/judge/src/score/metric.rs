//! The metrics of tables, one entry each: name, heading, direction, unit, formula and function.
//!
//! Experiment files, tables, `explain`, pages and the docs (`docs/metrics.md`, see [`super::metrics_page`]) are made
//! from [`METRICS`]. A new metric is one entry there, or in the list of [measures of frames](super::frames::list), and nothing else. The associated constants are handles for code
//! that asks for a certain metric; a name that is not in the list does not compile.

mod list;

pub use list::METRICS;

use super::pooled::Pooled;
use crate::direction::Direction;
use crate::plugin::{suggest, unknown};

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
    value: Value,
}

/// Where a metric's value comes from.
#[derive(Clone, Copy)]
enum Value {
    /// A function of the pooled numbers.
    Pooled(fn(&Pooled) -> Option<f64>),
    /// The measure of frames of this index in their list.
    Frames(usize),
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
    /// The scores and alarms of all frames, against whether the target is lost.
    Frames,
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

    /// The message about a word that names no metric; it may be one of the names that tables show, such as `F1`.
    pub fn unknown(word: &str) -> String {
        let is_shown = |m: &&Self| m.heading.split(' ').any(|part| part.eq_ignore_ascii_case(word));
        let near: Vec<&str> = METRICS.iter().filter(is_shown).map(|m| m.name).collect();
        match near.as_slice() {
            [] => unknown("metric", word, Self::names()),
            near => suggest("metric", word, near),
        }
    }

    /// Its name in experiment files, tables and results.
    pub fn name(self) -> &'static str {
        self.name
    }

    /// Name in running text.
    pub fn heading(self) -> &'static str {
        self.heading
    }

    /// Name as the heading of a row or column: `False alarms per 1000 frames`.
    pub fn title(self) -> String {
        let mut letters = self.heading.chars();
        letters.next().map_or_else(String::new, |first| first.to_uppercase().chain(letters).collect())
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
        match self.value {
            Value::Pooled(value) => value(pooled),
            Value::Frames(index) => pooled.frames?.value(index),
        }
    }

    /// Whether the part of a suite with an attribute may have it.
    pub fn is_of_counts(self) -> bool {
        matches!(self.source, Source::Counts | Source::Delays)
    }

    /// Whether it is made of the scores and alarms of all frames, see [`crate::score::frames`].
    pub fn is_of_frames(self) -> bool {
        self.source == Source::Frames
    }

    /// Bounds of its interval over sequences, for those of [`Source::Frames`] that have one.
    pub fn interval(self, pooled: &Pooled) -> Option<(f64, f64)> {
        match self.value {
            Value::Pooled(_) => None,
            Value::Frames(index) => pooled.frames?.bounds(index),
        }
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

#[cfg(test)]
mod tests;
