//! The metrics of tables, one entry each: name, heading, direction, unit, formula and function.
//!
//! Experiment files, tables, `explain`, pages and the tables of `docs/metrics.md` are made from [`METRICS`].
//! A new metric is one entry there, or in the list of [measures of frames](super::frames::list), and nothing
//! else. The associated constants are for code that uses a certain metric; an unknown name does not compile.

mod list;

pub use list::METRICS;

use super::counts::Counts;
use super::pooled::Pooled;
use crate::direction::Direction;
use crate::plugin::{suggest, unknown};

/// A metric that tables can show and training can maximize.
#[derive(Clone, Copy)]
pub struct Metric {
    name: &'static str,
    /// Name in running text.
    pub heading: &'static str,
    direction: Direction,
    /// Unit of the values; empty for numbers without a unit.
    pub unit: &'static str,
    /// Form in which the values are shown.
    pub kind: Kind,
    /// Input from which the metric is computed.
    pub source: Source,
    /// Formula of the counts, or a description in words.
    pub formula: &'static str,
    value: Value,
}

/// Function that computes a value from such numbers.
type Of<T> = fn(&T) -> Option<f64>;

/// Source from which a metric's value is computed.
#[derive(Clone, Copy)]
pub(super) enum Value {
    /// A function of the counts. The formula names counts, or is plain text.
    Counts(Of<Counts>),
    /// A function of the pooled numbers.
    Pooled(Of<Pooled>),
    /// A function of the pooled numbers, with a note after the formula.
    Noted(Of<Pooled>, fn(&Pooled) -> String),
    /// The measure of frames with the metric's name.
    Frames,
}

/// Form in which values of a metric are shown.
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

/// Input from which a metric is computed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Source {
    /// The counts and, for metrics of chance, the protocol.
    Counts,
    /// The scores of all frames.
    Scores,
    /// The frames of matched events and detections.
    Delays,
    /// The runs of the tracker backwards in time.
    Effort,
    /// The scores and alarms of all frames, with the frames in which the target is lost.
    Frames,
}

impl std::fmt::Debug for Metric {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(self.name)
    }
}

/// Metrics are equal if their names are, since names are unique in the list.
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
    /// Number of false positives.
    pub const FP: Self = named("fp");
    /// Recall minus FPR.
    pub const INFORMEDNESS: Self = named("informedness");
    /// Number of runs backwards in time.
    pub const REVERSE_RUNS: Self = named("reverse_runs");
    /// F above that of random detections.
    pub const F_OVER_CHANCE: Self = named("f_over_chance");
    /// Median delay of matched detections, in frames.
    pub const DELAY_MEDIAN: Self = named("delay_median");

    /// Creates a metric without a unit.
    pub(super) const fn new(
        name: &'static str,
        heading: &'static str,
        direction: Direction,
        (kind, source): (Kind, Source),
        value: Value,
    ) -> Self {
        Self { name, heading, direction, unit: "", kind, source, formula: "", value }
    }

    pub(super) const fn with_unit(self, unit: &'static str) -> Self {
        Self { unit, ..self }
    }

    pub(super) const fn with_formula(self, formula: &'static str) -> Self {
        Self { formula, ..self }
    }

    pub(super) const fn with_direction(self, direction: Direction) -> Self {
        Self { direction, ..self }
    }

    const fn shown_as(self, kind: Kind) -> Self {
        Self { kind, ..self }
    }

    /// Metric of this name in experiment files; `None` if it is unknown.
    pub fn from_name(name: &str) -> Option<Self> {
        METRICS.iter().find(|m| m.name == name).copied()
    }

    /// Names of all metrics, in the order of the list.
    pub fn names() -> impl Iterator<Item = &'static str> + Clone {
        METRICS.iter().map(|m| m.name)
    }

    /// Message about an unknown metric, which may be a heading used in tables, such as `F1`.
    pub fn unknown(word: &str) -> String {
        let is_shown = |m: &&Self| m.heading.split(' ').any(|part| part.eq_ignore_ascii_case(word));
        let near: Vec<&str> = METRICS.iter().filter(is_shown).map(|m| m.name).collect();
        match near.as_slice() {
            [] => unknown("metric", word, Self::names()),
            near => suggest("metric", word, near),
        }
    }

    /// Name in experiment files, tables and results.
    pub fn name(self) -> &'static str {
        self.name
    }

    /// Name as the heading of a row or column: `False alarms per 1000 frames`.
    pub fn title(self) -> String {
        let mut letters = self.heading.chars();
        letters.next().map_or_else(String::new, |first| first.to_uppercase().chain(letters).collect())
    }

    /// Direction in which values are better.
    pub fn direction(self) -> Direction {
        self.direction
    }

    /// Formula with the counts of a pooled number filled in.
    pub fn filled(self, pooled: &Pooled) -> String {
        let formula = self.formula;
        match self.value {
            Value::Counts(_) => match in_numbers(formula, &pooled.counts) {
                same if same == formula => same,
                numbers => format!("{formula} = {numbers}"),
            },
            Value::Noted(_, note) => format!("{formula}{}", note(pooled)),
            Value::Pooled(_) | Value::Frames => formula.to_string(),
        }
    }

    /// Value of the metric; `None` if a denominator is 0 or an input is unknown. [`Kind::MeanAndDeviation`]
    /// returns the mean.
    pub fn value(self, pooled: &Pooled) -> Option<f64> {
        match self.value {
            Value::Counts(of) => of(&pooled.counts),
            Value::Pooled(of) | Value::Noted(of, _) => of(pooled),
            Value::Frames => pooled.frames.as_ref()?.get(self.name),
        }
    }

    /// True if the metric is computed from events and detections: from their counts, or from the delays of matches.
    pub fn is_of_counts(self) -> bool {
        matches!(self.source, Source::Counts | Source::Delays)
    }

    /// True if the metric is computed from the scores and alarms of all frames, see [`crate::score::frames`].
    pub fn is_of_frames(self) -> bool {
        self.source == Source::Frames
    }

    /// Bounds of the interval over sequences; `None` unless the metric is of [`Source::Frames`] and has one.
    pub fn interval(self, pooled: &Pooled) -> Option<(f64, f64)> {
        pooled.frames.as_ref()?.bounds(self.name)
    }

    /// True if the metric is a count, shown without decimals.
    pub fn is_count(self) -> bool {
        self.kind == Kind::Count
    }
}

/// Formula with the counts in place of their names: `6 / (6 + 4 + 5)` for `2 TP / (2 TP + FP + FN)`.
fn in_numbers(formula: &str, counts: &Counts) -> String {
    let Counts { tp, fp, fn_, tn } = *counts;
    let numbers = [("2 TP", 2 * tp), ("TP", tp), ("FP", fp), ("FN", fn_), ("TN", tn)];
    let fill = |text: String, (name, number): (&str, u64)| text.replace(name, &number.to_string());
    numbers.into_iter().fold(formula.replace("1000 ", "1000 * "), fill)
}

/// Metric of this name, at compile time. An unknown name does not compile.
const fn named(name: &str) -> Metric {
    let mut k = 0;
    while !equal(METRICS[k].name.as_bytes(), name.as_bytes()) {
        k += 1;
    }
    METRICS[k]
}

const fn equal(a: &[u8], b: &[u8]) -> bool {
    match (a, b) {
        ([], []) => true,
        ([x, a @ ..], [y, b @ ..]) => *x == *y && equal(a, b),
        _ => false,
    }
}

#[cfg(test)]
mod tests;
