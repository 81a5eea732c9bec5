//! How far the headline number of each method, or of each tracker that an analysis scored, can be trusted, from
//! `scores.csv` or `analyses.json` alone: intervals, tests of each pair, and mean ranks.
//!
//! Units are sequences, with the counts of all runs summed; the number of a tracker is the mean over sequences of a
//! column in the table `sequences` of the first analysis that has one. Methods are compared on the same tracker and by
//! the same protocol. Anchors and most points of a grid have intervals, but no ranks and no tests: anchors are a
//! reference, and a grid is a search for one method, which is ranked at its published parameters. See [`trackfail_core::num::pooled`] and [`trackfail_core::num::ranks`]
//! for the statistics.

mod diagram;
mod field;
mod verdict;

use super::layouts::{self, cell, group, of_suite, table};
use super::pairs;
use crate::figure::{Dots, Ranks};
use crate::results::{CellScore, Results};
use crate::sampling::{LEVEL, MIN_SEQUENCES, SAMPLES, Sampling, mean_of_sum, metric_of_sum};
use crate::table::layout::{self, Cell, TableLayout};
use crate::table::number::Style;
use crate::table::suites::suites_note;
use field::{Competitor, Field, fields, first_by_sequence, tracker_fields};
use rayon::prelude::*;
use std::collections::BTreeMap;
use trackfail_core::direction::Direction;
use trackfail_core::num::{pooled, ranks};
use trackfail_engine::spec::Experiment;
use trackfail_engine::spec::table::Side;
use trackfail_methods::score::chance::Chance;
use trackfail_methods::score::metric::Source;
use trackfail_methods::score::{Metric, TrackerMetric};

/// The tables and figures of a report that say how far its numbers can be trusted.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Uncertainty {
    /// The tables `uncertainty` and `pairs`.
    pub tables: Vec<TableLayout>,
    /// The figure `ranks`, and one for each measure of trackers: name, figure and caption.
    pub ranks: Vec<(String, Ranks, String)>,
    /// Why tables or figures are missing.
    pub note: Option<String>,
    /// The best method or tracker in a sentence, with how sure that is.
    pub verdict: Option<String>,
    /// All of them with their intervals, as a figure with its caption.
    pub headline: Option<(Dots, String)>,
    /// The rows of the first table that are ranked.
    pub ranked: Option<TableLayout>,
    /// The best method of each tracker by the verdict.
    pub best: Vec<String>,
}

/// The metric that a report is ordered by. Of the metrics in its tables of methods it is F, or else informedness, or else
/// the first that has a direction and comes from counts; F where there is none. (A ratio such as recall, which is 1 for
/// a method that always raises the alarm, orders nothing by itself.)
pub fn headline(experiment: &Experiment) -> Metric {
    let of_methods = experiment.tables.iter().filter(|t| t.shows.is_none());
    let metrics: Vec<Metric> = of_methods
        .flat_map(|t| match &t.rows {
            Side::Metrics(metrics) => metrics.clone(),
            _ => t.metric.into_iter().collect(),
        })
        .collect();
    // The effort of reverse runs and measures of frames are not computed from counts of detections.
    let is_other = |m: &Metric| matches!(m.source(), Source::Effort | Source::Frames);
    let fits = |m: &Metric| !is_other(m) && m.direction() != Direction::Neither;
    let whole = [Metric::F_SCORE, Metric::INFORMEDNESS].into_iter().find(|m| metrics.contains(m));
    whole.or_else(|| metrics.into_iter().find(fits)).unwrap_or(Metric::F_SCORE)
}

/// Most competitors of which all pairs are tested: with more, the correction for their number leaves no test any power.
const MAX_COMPETITORS: usize = 12;

/// A measure of a method or a tracker.
#[derive(Debug, Clone, PartialEq)]
enum Measured {
    /// A metric of counts, in the order of [`Counts`].
    Counted(Metric),
    /// The mean over sequences of a column of an analysis, as [`counts_of_column`] counts.
    Mean(String),
}

impl Measured {
    /// Its name for people.
    fn title(&self) -> String {
        match self {
            Self::Counted(metric) => metric.title(),
            Self::Mean(column) => column.clone(),
        }
    }

    fn direction(&self) -> Direction {
        match self {
            Self::Counted(metric) => metric.direction(),
            Self::Mean(column) => {
                TrackerMetric::of_heading(column).map_or(Direction::HigherIsBetter, |m| m.direction)
            }
        }
    }

    /// 1 where larger values are better, -1 where smaller ones are.
    fn sign(&self) -> f64 {
        if self.direction() == Direction::LowerIsBetter { -1.0 } else { 1.0 }
    }

    fn style(&self) -> Style {
        match self {
            Self::Counted(metric) => Style::of_metric(*metric),
            Self::Mean(_) => Style::DEFAULT,
        }
    }

    /// The measure from the summed counts of all units.
    fn value(&self, chance: Chance, counts: &[i64; 4]) -> Option<f64> {
        match self {
            Self::Counted(metric) => metric_of_sum(*metric, Some(chance), counts),
            Self::Mean(_) => mean_of_sum(counts),
        }
    }

    /// How it is computed, for captions.
    fn way(&self) -> &'static str {
        match self {
            Self::Counted(_) => "from the summed counts of all sequences",
            Self::Mean(_) => "the mean over sequences",
        }
    }
}

/// Intervals, tests and ranks of an experiment's methods, from the counts of [`Results::scores`], and of the trackers that
/// an analysis scored.
pub fn measure(results: &Results, scores: &[CellScore]) -> Uncertainty {
    let experiment = &results.experiment;
    let trackers = tracker_fields(results);
    if experiment.methods.is_empty() && trackers.is_empty() {
        return Uncertainty::default();
    }
    let present = results.manifest.suite.present.len();
    if present < MIN_SEQUENCES {
        let note = format!(
            "No intervals, tests and ranks: they need {MIN_SEQUENCES} sequences of the suite, and {present} are here."
        );
        return Uncertainty { note: Some(note), ..Uncertainty::default() };
    }
    let mut all: Vec<(String, Measured, Vec<Field>)> = Vec::new();
    if !experiment.methods.is_empty() {
        all.push((String::new(), Measured::Counted(headline(experiment)), fields(results, scores)));
    }
    for (measured, field) in trackers {
        all.push((format!("-{}", pairs::measure_name(&measured.title())), measured, vec![field]));
    }
    let of_methods = layouts::suite(results);
    let compared = first_by_sequence(results).filter(|a| !a.shares.is_empty());
    let of_trackers = compared.map_or(of_methods.clone(), |a| format!("Suite {}.", suites_note(a)));
    let mut uncertainty = Uncertainty::default();
    let sampling = Sampling::new(experiment);
    for (k, (suffix, measured, fields)) in all.iter().enumerate() {
        let suite = if matches!(measured, Measured::Mean(_)) { &of_trackers } else { &of_methods };
        let ranked: Vec<Option<Ranked>> = fields.iter().map(|f| rank(f, measured)).collect();
        let mut tables = vec![intervals(fields, &ranked, measured, &sampling)];
        let duels = duels(fields, measured, &sampling);
        if k == 0 {
            uncertainty.verdict = verdict::verdict(fields, [&tables[0], &duels], measured);
            uncertainty.headline = verdict::dots(fields, &tables[0], measured, (experiment, suite));
            uncertainty.best = verdict::best_names(fields, [&tables[0], &duels], measured);
            uncertainty.ranked = Some(of_suite(ranked_rows(&tables[0], fields, measured), results, suite));
        }
        tables.extend((!duels.groups.is_empty()).then_some(duels));
        tables.iter_mut().for_each(|table| table.name.push_str(suffix));
        uncertainty.tables.extend(tables.into_iter().map(|table| of_suite(table, results, suite)));
        let diagram = diagram::diagram(fields, &ranked, measured, suite);
        match diagram {
            Some(Ok((ranks, caption))) => uncertainty.ranks.push((format!("ranks{suffix}"), ranks, caption)),
            Some(Err(reason)) => uncertainty.note = uncertainty.note.or(Some(reason)),
            None => {}
        }
    }
    uncertainty
}

/// The mean ranks of a field.
struct Ranked {
    /// Mean ranks of those that compete, by label.
    mean_ranks: BTreeMap<String, f64>,
    /// Sequences in which all of them have a value.
    blocks: usize,
    p: Option<f64>,
    critical: f64,
}

fn rank(field: &Field, measured: &Measured) -> Option<Ranked> {
    let competing: Vec<&Competitor> = field.competitors.iter().filter(|c| c.competes).collect();
    let values = |sequence: &String| -> Option<Vec<f64>> {
        competing.iter().map(|c| measured.value(field.chance, c.counts.get(sequence)?)).collect()
    };
    let blocks: Vec<Vec<f64>> = competing.first()?.counts.keys().filter_map(values).collect();
    if blocks.len() < MIN_SEQUENCES {
        return None;
    }
    let found = ranks::friedman(&blocks, measured.direction() != Direction::LowerIsBetter)?;
    let critical = ranks::critical_difference(LEVEL, competing.len(), blocks.len())?;
    let mean_ranks = competing.iter().map(|c| c.label.clone()).zip(found.mean_ranks).collect();
    Some(Ranked { mean_ranks, blocks: found.blocks, p: found.test.map(|t| t.1), critical })
}

/// A p-value as it is shown.
fn p_text(p: f64) -> String {
    if p < 0.0001 { "<0.0001".to_string() } else { format!("{p:.4}") }
}

fn direction(measured: &Measured) -> &'static str {
    match measured.direction() {
        Direction::HigherIsBetter => "larger is better",
        Direction::LowerIsBetter => "smaller is better",
        Direction::Neither => "neither large nor small is better",
    }
}

fn intervals(
    fields: &[Field],
    ranked: &[Option<Ranked>],
    measured: &Measured,
    sampling: &Sampling,
) -> TableLayout {
    let of_field = |(field, ranked): (&Field, &Option<Ranked>)| {
        let mut heading = vec![field.label.clone()];
        if let Some(r) = ranked {
            let p =
                r.p.map_or_else(|| "no differences".to_string(), |p| format!("Friedman's p {}", p_text(p)));
            let ranks =
                format!("ranks over {} sequences, {p}, critical difference {:.2}", r.blocks, r.critical);
            heading.push(if field.label.is_empty() { ranks } else { format!("({ranks})") });
        }
        let heading = heading.join(" ").trim_start().to_string();
        let bounds = bounds(field, measured, sampling);
        let row = |(c, bounds): (&Competitor, Option<(f64, f64)>)| {
            let shown = |v| measured.style().format(v);
            let rank = ranked.as_ref().and_then(|r| r.mean_ranks.get(&c.label).copied());
            let cells = vec![
                cell(measured.value(field.chance, &c.total()), shown),
                cell(bounds.map(|b| b.0), shown),
                cell(bounds.map(|b| b.1), shown),
                cell(Some(c.counts.len() as f64), |v| Style::COUNT.format(v)),
                cell(rank, |v| format!("{v:.2}")),
                cell(ranked.as_ref().and_then(|r| r.p).filter(|_| rank.is_some()), p_text),
            ];
            (c.label.clone(), cells)
        };
        group(&field.label, heading, field.competitors.iter().zip(bounds).map(row).collect())
    };
    let groups = fields.iter().zip(ranked).map(of_field).collect();
    let is_counted = matches!(measured, Measured::Counted(_));
    let not_ranked =
        if is_counted { " Anchors are not ranked, and of a grid only the published point." } else { "" };
    let caption = format!(
        "{} ({}), {}, with 95 % bounds by bootstrap over sequences ({SAMPLES} samples), and mean rank, 1 the best.{not_ranked}",
        measured.title(),
        direction(measured),
        measured.way(),
    );
    let who = if is_counted { "method" } else { "tracker" };
    let title = measured.title();
    let columns = [title.as_str(), "95 % from", "95 % to", "sequences", "mean rank", "Friedman's p"];
    table("uncertainty", caption, who, &columns, groups)
}

/// The rows of the table of intervals that are ranked, the best of each field first.
fn ranked_rows(table: &TableLayout, fields: &[Field], measured: &Measured) -> TableLayout {
    let mut table = table.clone();
    for (group, field) in table.groups.iter_mut().zip(fields) {
        let competing = |label: &str| field.competitors.iter().find(|c| c.competes && c.label == label);
        group.rows.retain_mut(|row| {
            let competitor = competing(&row.label.name);
            if let Some(competitor) = competitor {
                row.label.shown = competitor.spoken();
            }
            competitor.is_some()
        });
        let value = |row: &layout::Row| row.cells[0].value.map_or(f64::INFINITY, |v| -measured.sign() * v);
        group.rows.sort_by(|a, b| value(a).total_cmp(&value(b)));
    }
    table.groups.retain(|group| !group.rows.is_empty());
    table.caption.push_str(" Here are those that are ranked; the table below has all.");
    table
}

/// The interval of every competitor of a field.
fn bounds(field: &Field, measured: &Measured, sampling: &Sampling) -> Vec<Option<(f64, f64)>> {
    let of_one = |competitor: &Competitor| {
        let counts: Vec<[i64; 4]> = competitor.counts.values().copied().collect();
        sampling.interval(&counts, |c| measured.value(field.chance, c))
    };
    field.competitors.par_iter().map(of_one).collect()
}

/// One method against another.
struct Duel {
    label: String,
    difference: Option<f64>,
    bounds: Option<(f64, f64)>,
    p: Option<f64>,
    sequences: usize,
}

fn duel(
    (a, b): (&Competitor, &Competitor),
    of: impl Fn(&[i64; 4]) -> Option<f64>,
    sampling: &Sampling,
) -> Duel {
    let both: Vec<([i64; 4], [i64; 4])> =
        a.counts.iter().filter_map(|(sequence, x)| Some((*x, *b.counts.get(sequence)?))).collect();
    let label = format!("{} against {}", a.label, b.label);
    let mut duel = Duel { label, difference: None, bounds: None, p: None, sequences: both.len() };
    if both.len() < MIN_SEQUENCES {
        return duel;
    }
    if let Some(tested) = pooled::permutation(&both, &of, SAMPLES, sampling.seed_of(&[&a.label, &b.label])) {
        duel.difference = Some(tested.difference);
        duel.p = Some(tested.p);
        duel.bounds = sampling.difference(&both, of);
    }
    duel
}

/// The pairs that are tested: all of them or, of many competitors, the best one with each of the others.
fn duellists<'a>(
    competing: &[&'a Competitor],
    measured: &Measured,
    of: impl Fn(&[i64; 4]) -> Option<f64>,
) -> Vec<(&'a Competitor, &'a Competitor)> {
    if competing.len() <= MAX_COMPETITORS {
        let pair = |i: usize| (i + 1..competing.len()).map(move |j| (i, j));
        return (0..competing.len()).flat_map(pair).map(|(i, j)| (competing[i], competing[j])).collect();
    }
    let value = |c: &Competitor| {
        let value = of(&c.total())?;
        Some(if measured.direction() == Direction::LowerIsBetter { -value } else { value })
    };
    let values: Vec<f64> = competing.iter().map(|c| value(c).unwrap_or(f64::NEG_INFINITY)).collect();
    let best = (0..values.len()).rev().max_by(|a, b| values[*a].total_cmp(&values[*b]));
    let against = |best: usize| (0..competing.len()).filter(move |k| *k != best).map(move |k| (best, k));
    best.into_iter().flat_map(against).map(|(i, j)| (competing[i], competing[j])).collect()
}

fn duels(fields: &[Field], measured: &Measured, sampling: &Sampling) -> TableLayout {
    let of_field = |field: &Field| {
        let competing: Vec<&Competitor> = field.competitors.iter().filter(|c| c.competes).collect();
        let of = |c: &[i64; 4]| measured.value(field.chance, c);
        let all = duellists(&competing, measured, of);
        let duels: Vec<Duel> = all.par_iter().map(|pair| duel(*pair, of, sampling)).collect();
        let known: Vec<f64> = duels.iter().filter_map(|d| d.p).collect();
        let mut adjusted = ranks::holm(&known).into_iter();
        let signed = |v| measured.style().format_signed(v);
        let row = |d: Duel| {
            let holm = d.p.and_then(|_| adjusted.next());
            let cells = vec![
                cell(d.difference, signed),
                cell(d.bounds.map(|b| b.0), signed),
                cell(d.bounds.map(|b| b.1), signed),
                cell(d.p, p_text),
                cell(holm, p_text),
                cell(Some(d.sequences as f64), |v| Style::COUNT.format(v)),
            ];
            (d.label, cells)
        };
        let rows: Vec<(String, Vec<Cell>)> = duels.into_iter().map(row).collect();
        (!rows.is_empty()).then(|| group(&field.label, field.label.clone(), rows))
    };
    let caption = format!(
        "Difference of {} ({}) on the same sequences, {}, with 95 % bounds by bootstrap over sequences ({SAMPLES} \
         samples) and the two-sided p of the permutation test that exchanges the numbers of the two within sequences (all patterns up to {} sequences that differ, else {SAMPLES} random \
         ones), by itself and after Holm's correction for all pairs of its group. Of more than {MAX_COMPETITORS} methods, the \
         best is tested against each of the others.",
        measured.title(),
        direction(measured),
        measured.way(),
        pooled::EXACT_UP_TO
    );
    let columns = ["difference", "95 % from", "95 % to", "p", "p (Holm)", "sequences"];
    table("pairs", caption, "pair", &columns, fields.iter().filter_map(of_field).collect())
}

#[cfg(test)]
mod tests;
