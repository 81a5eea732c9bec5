//! Methods in order of a metric, with the certainty of each rank.
//!
//! Methods are ordered by the metric pooled over all sequences. A bootstrap over sequences
//! ([`crate::sampling`]) shows how much the order depends on the choice of sequences. `first` is the share of
//! samples in which a method has rank 1, `keeps rank` the share in which it has the rank of the table.
//!
//! A rank is 1 plus the number of better methods, so equal methods share a rank. If the counts of a sample
//! give no value (precision without a detection), the method ranks after all with a value. Anchors are listed
//! by their value, but have no rank and do not affect those of others. The same holds for methods without a
//! result in cells in which others have one.
//!
//! Metrics of frames ([`trackfail_methods::score::frames`]) are not made of counts. For these, methods are
//! ranked by value, and the bounds of the metric's own bootstrap interval replace the two shares.

use super::build::{self, number};
use super::layout::{Cell, Group, Label, LabelKind, Origin, TableLayout, is_anchor, sentence};
use super::number::Style;
use crate::results::{Measure, method_label};
use crate::sampling::{BySequence, MIN_SEQUENCES, Units, along, metric_of_sum};
use std::cmp::Ordering;
use std::collections::BTreeSet;
use trackfail_core::direction::Direction;
use trackfail_engine::spec::table::Table;
use trackfail_engine::spec::{Experiment, TEST};
use trackfail_methods::score::Metric;

/// Certainty of a rank.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Stability {
    /// Rank on all sequences.
    rank: usize,
    /// Share of samples with rank 1.
    first: f64,
    /// Share of samples with the rank on all sequences.
    keeps: f64,
}

/// Compares values, better ones first. Any value is better than `None`.
pub fn better_first(a: Option<f64>, b: Option<f64>, direction: Direction) -> Ordering {
    match (a, b) {
        (Some(a), Some(b)) if direction == Direction::LowerIsBetter => a.total_cmp(&b),
        (Some(a), Some(b)) => b.total_cmp(&a),
        (a, b) => b.is_some().cmp(&a.is_some()),
    }
}

/// Rank of each value, from 1. Equal values share a rank.
fn ranks(values: &[Option<f64>], direction: Direction) -> Vec<usize> {
    let is_better = |a: &Option<f64>, b: &Option<f64>| better_first(*a, *b, direction).is_lt();
    values.iter().map(|v| 1 + values.iter().filter(|w| is_better(w, v)).count()).collect()
}

/// Rank of each value on all sequences, and the shares of samples with the same and with the first rank.
/// `sampled` has the values of each sample, NaN for none.
fn stability(values: &[Option<f64>], sampled: &[Vec<f64>], direction: Direction) -> Vec<Stability> {
    let samples = sampled.first().map_or(0, Vec::len);
    let in_sample = |sample: usize| {
        let values = sampled.iter().map(|values| Some(values[sample]).filter(|v| !v.is_nan()));
        ranks(&values.collect::<Vec<_>>(), direction)
    };
    let drawn: Vec<Vec<usize>> = (0..samples).map(in_sample).collect();
    let of_rank = |k: usize, rank: usize| drawn.iter().filter(|ranks| ranks.get(k) == Some(&rank)).count();
    let share = |k: usize, rank: usize| of_rank(k, rank) as f64 / samples.max(1) as f64;
    let sure = |(k, rank)| Stability { rank, first: share(k, 1), keeps: share(k, rank) };
    ranks(values, direction).into_iter().enumerate().map(sure).collect()
}

/// Makes the table of an experiment with `rank`, one group for each tracker.
pub fn leaderboard(
    experiment: &Experiment,
    table: &Table,
    measures: &[Measure],
    units: &Units,
    data_note: &str,
) -> TableLayout {
    let metric = table.ranked.unwrap_or(Metric::F_SCORE);
    let trackers = experiment.trackers.iter().map(|t| t.label.as_str());
    let group = |tracker: &str| {
        let mine = measures.iter().filter(|m| m.tracker == tracker && m.attribute.is_none() && m.done > 0);
        let shown = mine.filter(|m| table.methods.contains(&m.method)).collect();
        group(experiment, tracker, metric, shown, units)
    };
    let groups: Vec<Group> = trackers.filter_map(group).collect();
    let caption = sentence(table.caption.clone().unwrap_or_else(|| experiment.title.clone()));
    let (beside, how) = if metric.is_of_frames() {
        (["low", "high"], "The columns low and high are a 95 % interval over sequences")
    } else {
        (
            ["first", "keeps rank"],
            "The columns first and keeps rank are shares of bootstrap samples in which a method is first, or has this rank",
        )
    };
    let has_failed = groups.iter().flat_map(|g| &g.rows).flat_map(|r| &r.cells).any(|c| c.failed > 0);
    let left_out = if has_failed { " † No result where other methods have one, so no rank." } else { "" };
    let suite = &experiment.suites[TEST];
    let caption = format!("{caption} {how}. Suite {suite}: {data_note}.{left_out}");
    let columns = ["rank".into(), Label::of_metric(metric), beside[0].into(), beside[1].into()];
    TableLayout {
        data: data_note.to_string(),
        latex: table.latex.clone(),
        ..build::table(&table.name, caption, "method", columns, groups)
    }
}

/// Rows of a tracker, from the measures of its methods; `None` without any.
fn group(
    experiment: &Experiment,
    tracker: &str,
    metric: Metric,
    mut all: Vec<&Measure>,
    units: &Units,
) -> Option<Group> {
    let most = all.iter().map(|m| m.done).max()?;
    // Equal methods stay in the order of the experiment.
    all.sort_by(|a, b| better_first(a.value(metric), b.value(metric), metric.direction()));
    let is_ranked = |m: &Measure| m.done == most && !is_anchor(experiment, &m.method);
    let ranked: Vec<&Measure> = all.iter().copied().filter(|m| is_ranked(m)).collect();
    let counts = all.iter().filter_map(|m| units.of_measure(m));
    let sequences: BTreeSet<&String> = counts.flat_map(|counts| counts.keys()).collect();
    let none = BySequence::new();
    let samples = |m: &&Measure| {
        let counts = along(units.of_measure(m).unwrap_or(&none), sequences.iter().copied());
        units.sampling.values(&counts, |sum| metric_of_sum(metric, m.pooled.chance, sum))
    };
    let sampled: Vec<Vec<f64>> =
        if metric.is_of_frames() { Vec::new() } else { ranked.iter().filter_map(samples).collect() };
    let values: Vec<Option<f64>> = ranked.iter().map(|m| m.value(metric)).collect();
    let mut sure = stability(&values, &sampled, metric.direction()).into_iter();
    let row = |m: &&Measure| {
        let sure = if is_ranked(m) { sure.next() } else { None };
        let (low, high) = if metric.is_of_frames() {
            metric.interval(&m.pooled).unzip()
        } else {
            sure.filter(|_| sequences.len() >= MIN_SEQUENCES).map(|s| (s.first, s.keeps)).unzip()
        };
        let value = Cell {
            failed: most - m.done,
            of: Some(Origin::ranked(m, metric)),
            ..number(m.value(metric), Style::of_metric(metric))
        };
        let beside = [low, high].map(|value| number(value, Style::DEFAULT));
        let cells = [number(sure.map(|s| s.rank as f64), Style::COUNT), value].into_iter().chain(beside);
        let kind = if is_anchor(experiment, &m.method) { LabelKind::Anchor } else { LabelKind::Result };
        (Label { kind, ..method_label(&m.method, &m.params).into() }, cells.collect::<Vec<Cell>>())
    };
    Some(build::group(tracker, format!("{tracker} ({} sequences)", sequences.len()), all.iter().map(row)))
}

#[cfg(test)]
mod tests;
