//! Methods in order of a metric, and how sure their ranks are.
//!
//! The order is that of the metric pooled over all sequences. A bootstrap over sequences says how much it depends on
//! which sequences a suite has ([`crate::sampling`]). `first` is the share of samples in which a method has rank 1, `keeps
//! rank` the share in which it has the rank of the table.
//!
//! A rank is 1 plus the number of methods that are better, so equal methods share theirs, and both are first.
//! Where the counts of a sample give no value (precision without a detection), the method ranks behind all that have
//! one. Anchors stand where their value puts them, but have no rank and do not push others down; nor do methods that have no
//! result for cells that others have one for.
//!
//! Metrics of frames ([`trackfail_methods::score::frames`]) are not made of counts: methods are ranked by value, and the bounds of the
//! metric's own bootstrap interval stand in place of the two shares.

use super::layout::{Cell, Group, Label, LabelKind, Origin, Row, TableLayout, is_anchor};
use super::number::Style;
use crate::results::Measure;
use crate::results::{CellScore, method_label};
use crate::sampling::{SAMPLES, Sampling, metric_of_sum, numbers};
use std::cmp::Ordering;
use std::collections::BTreeMap;
use trackfail_core::direction::Direction;
use trackfail_core::num::pooled::Draws;
use trackfail_engine::spec::table::Table;
use trackfail_engine::spec::{Experiment, TEST};
use trackfail_methods::score::chance::Chance;
use trackfail_methods::score::{Counts, Metric, Pooled};

/// One method of a leaderboard.
struct Candidate {
    label: String,
    of: Origin,
    is_anchor: bool,
    /// Cells without a result, where other methods have one.
    failed: usize,
    value: Option<f64>,
    /// Interval of the value, for metrics of frames.
    interval: Option<(f64, f64)>,
    /// Counts on each sequence.
    counts: Vec<Counts>,
    chance: Option<Chance>,
}

impl Candidate {
    fn is_ranked(&self) -> bool {
        !self.is_anchor && self.failed == 0
    }
}

/// How sure a rank is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Stability {
    /// The rank on all sequences.
    pub rank: usize,
    /// Share of samples with rank 1.
    pub first: f64,
    /// Share of samples with the rank on all sequences.
    pub keeps: f64,
}

/// A method's counts on every sequence, and how its protocol matches random detections.
type CountsOfMethod<'a> = (&'a [Counts], Option<Chance>);

fn value(counts: Counts, chance: Option<Chance>, metric: Metric) -> Option<f64> {
    metric.value(&Pooled { counts, chance, ..Pooled::default() })
}

/// Orders values of a metric, better ones first; a value is better than none.
fn compare(a: Option<f64>, b: Option<f64>, metric: Metric) -> Ordering {
    let order = match (a, b) {
        (Some(a), Some(b)) => a.total_cmp(&b),
        (a, b) => return b.is_some().cmp(&a.is_some()),
    };
    if metric.direction() == Direction::LowerIsBetter { order } else { order.reverse() }
}

/// The rank of each value, from 1; equal values share theirs.
fn ranks(values: &[Option<f64>], metric: Metric) -> Vec<usize> {
    let better = |v: &Option<f64>| values.iter().filter(|w| compare(**w, *v, metric).is_lt()).count();
    values.iter().map(|v| 1 + better(v)).collect()
}

/// The ranks of methods on all sequences, and how often samples give the same ranks; never without samples.
fn stability(methods: &[CountsOfMethod<'_>], metric: Metric, draws: Option<&Draws>) -> Vec<Stability> {
    let all: Vec<Option<f64>> =
        methods.iter().map(|(c, chance)| value(c.iter().copied().sum(), *chance, metric)).collect();
    let on_all = ranks(&all, metric);
    let in_samples = |(counts, chance): &CountsOfMethod<'_>| {
        let units: Vec<[i64; 4]> = counts.iter().copied().map(numbers).collect();
        draws?.values(&units, |sum| metric_of_sum(metric, *chance, sum))
    };
    let sampled: Vec<Vec<f64>> = methods.iter().filter_map(in_samples).collect();
    let samples = sampled.first().map_or(0, Vec::len);
    let (mut first, mut keeps) = (vec![0_usize; methods.len()], vec![0_usize; methods.len()]);
    for sample in 0..samples {
        let values: Vec<Option<f64>> =
            sampled.iter().map(|values| Some(values[sample]).filter(|v| !v.is_nan())).collect();
        for (k, rank) in ranks(&values, metric).into_iter().enumerate() {
            first[k] += usize::from(rank == 1);
            keeps[k] += usize::from(rank == on_all[k]);
        }
    }
    let share = |n: usize| n as f64 / samples.max(1) as f64;
    let of = |(k, rank): (usize, usize)| Stability { rank, first: share(first[k]), keeps: share(keeps[k]) };
    on_all.into_iter().enumerate().map(of).collect()
}

/// The methods of a tracker with their counts, in the order of the experiment.
fn candidates(
    experiment: &Experiment,
    table: &Table,
    metric: Metric,
    measures: &[Measure],
    scores: &[CellScore],
    tracker: &str,
) -> Vec<Candidate> {
    let shown = |m: &&Measure| {
        m.tracker == tracker && m.attribute.is_none() && table.methods.contains(&m.method) && m.done > 0
    };
    let shown: Vec<&Measure> = measures.iter().filter(shown).collect();
    // Indices of the sequences on which any method has a result, in order of their names.
    let mut places: BTreeMap<&str, usize> = BTreeMap::new();
    let mut mine: BTreeMap<(&str, &str), Vec<&CellScore>> = BTreeMap::new();
    for s in scores.iter().filter(|s| s.tracker == tracker && table.methods.contains(&s.method)) {
        places.insert(&s.sequence, 0);
        mine.entry((&s.method, &s.params)).or_default().push(s);
    }
    places.values_mut().enumerate().for_each(|(k, place)| *place = k);
    let most = shown.iter().map(|m| m.done).max();
    let candidate = |m: &&Measure| {
        let mut counts = vec![Counts::default(); places.len()];
        let is_anchor = is_anchor(experiment, &m.method);
        for s in mine.get(&(m.method.as_str(), m.params.as_str())).into_iter().flatten() {
            let sum = &mut counts[places[s.sequence.as_str()]];
            *sum = [*sum, s.counts].into_iter().sum();
        }
        Candidate {
            label: method_label(&m.method, &m.params),
            of: Origin::ranked(m, metric),
            is_anchor,
            failed: most.unwrap_or(0) - m.done,
            value: m.value(metric),
            interval: metric.interval(&m.pooled),
            counts,
            chance: m.pooled.chance,
        }
    };
    shown.iter().map(candidate).collect()
}

/// Makes the table that an experiment asks for with `rank`, a group for each tracker.
pub fn leaderboard(
    experiment: &Experiment,
    table: &Table,
    measures: &[Measure],
    scores: &[CellScore],
    data_note: &str,
) -> TableLayout {
    let metric = table.ranked.unwrap_or(Metric::F_SCORE);
    let (mut groups, sampling) = (Vec::new(), Sampling::new(experiment));
    for tracker in experiment.trackers.iter().map(|t| t.label.as_str()) {
        let mut all = candidates(experiment, table, metric, measures, scores, tracker);
        if all.is_empty() {
            continue;
        }
        // Equal methods stay in the order of the experiment.
        all.sort_by(|a, b| compare(a.value, b.value, metric));
        let ranked: Vec<CountsOfMethod<'_>> =
            all.iter().filter(|c| c.is_ranked()).map(|c| (c.counts.as_slice(), c.chance)).collect();
        let draws = sampling.draws(all[0].counts.len()).filter(|_| !metric.is_of_frames());
        let enough = draws.is_some();
        let mut sure = if metric.is_of_frames() {
            let values: Vec<Option<f64>> = all.iter().filter(|c| c.is_ranked()).map(|c| c.value).collect();
            let ranks = ranks(&values, metric).into_iter();
            ranks.map(|rank| Stability { rank, first: 0.0, keeps: 0.0 }).collect()
        } else {
            stability(&ranked, metric, draws.as_deref())
        }
        .into_iter();
        let rows = all.iter().map(|c| {
            let sure = if c.is_ranked() { sure.next() } else { None };
            let (first, keeps) =
                (sure.filter(|_| enough).map(|s| s.first), sure.filter(|_| enough).map(|s| s.keeps));
            let beside = if metric.is_of_frames() { c.interval.unzip() } else { (first, keeps) };
            let cells = [
                (sure.map(|s| s.rank as f64), Style::COUNT),
                (c.value, Style::of_metric(metric)),
                (beside.0, Style::DEFAULT),
                (beside.1, Style::DEFAULT),
            ];
            let cell = |(value, style): (Option<f64>, Style)| Cell {
                value,
                ours: value.map(|v| style.format(v)),
                ..Cell::default()
            };
            let mut cells = cells.map(cell);
            cells[1].failed = c.failed;
            cells[1].of = Some(c.of.clone());
            let kind = if c.is_anchor { LabelKind::Anchor } else { LabelKind::Result };
            let label = Label { kind, ..c.label.as_str().into() };
            Row { label, direction: Direction::Neither, cells: cells.into() }
        });
        groups.push(Group {
            label: format!("{tracker} ({} sequences)", all[0].counts.len()),
            key: tracker.to_string(),
            published_tracker: None,
            has_ours: true,
            rows: rows.collect(),
        });
    }
    let mut caption = table.caption.clone().unwrap_or_else(|| experiment.title.clone());
    if !caption.ends_with('.') {
        caption.push('.');
    }
    let suite = &experiment.suites[TEST];
    let name = metric.heading();
    let (beside, how) = if metric.is_of_frames() {
        let how = "low, high: bounds of its 95 % bootstrap interval over sequences, where it has one (equal methods share a \
                   rank; anchors have none)";
        (["low", "high"], how.to_string())
    } else {
        let how = format!(
            "first, keeps rank: shares of {SAMPLES} bootstrap samples of the sequences in which a method is first, and in \
             which it has its rank here (equal ones share a rank; anchors have none)"
        );
        (["first", "keeps rank"], how)
    };
    let is_left_out =
        |group: &Group| group.rows.iter().any(|row| row.cells.iter().any(|cell| cell.failed > 0));
    let left_out = match groups.iter().any(is_left_out) {
        true => " † No result where other methods have one, so no rank.",
        false => "",
    };
    TableLayout {
        name: table.name.clone(),
        caption: format!("{caption} In order of {name}; {how}. Suite {suite}: {data_note}.{left_out}"),
        data: data_note.to_string(),
        corner: "method".to_string(),
        columns: vec!["rank".into(), Label::of_metric(metric), beside[0].into(), beside[1].into()],
        latex: table.latex.clone(),
        groups,
    }
}

#[cfg(test)]
mod tests;
