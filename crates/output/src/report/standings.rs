//! Which method or tracker is the best, and how sure that is: the one list that the tables `uncertainty`, `pairs` and
//! `differences` (and, beside it, `breakdown`), the figure and the sentence at the head of a page, and the leaderboard of all reports read.
//!
//! Units are sequences, with the counts of all runs summed; the number of a tracker is the mean over sequences of a
//! column in the table `sequences` of the first analysis that has one. Methods are compared on the same tracker and by
//! the same protocol, and frame by frame over all trackers together. Anchors and most points of a grid have intervals, but
//! no ranks and no tests: anchors are a reference, and a grid is a search for one method, which is ranked at its published
//! parameters. See [`trackfail_core::num::pooled`] and [`trackfail_core::num::ranks`] for the statistics.

mod answer;
mod fields;
mod frames;
mod tables;

pub use crate::results::frame_pairs::Difference as Estimate;
pub use answer::{dots, frames_verdict, verdict};
pub use fields::{frames_metric, of_frames};
pub use frames::{CHANCE, breakdown, differences, of_every_tracker, pair_of};

use super::figures::Captioned;
use super::pairs;
use crate::figure::{Dot, Dots};
use crate::results::Results;
use crate::sampling::{BySequence, MIN_SEQUENCES, SAMPLES, Sampling, Units, in_common, sum_of};
use crate::table::build::{cell, of_suite, suite};
use crate::table::layout::{Cell, TableLayout};
use crate::table::leaderboard::better_first;
use crate::table::number::Style;
use fields::{of_methods, of_trackers};
use rayon::prelude::*;
use serde_json::{Value, json};
use trackfail_core::direction::Direction;
use trackfail_core::num::pooled;
use trackfail_core::num::ranks::{Friedman, friedman, holm};
use trackfail_engine::spec::Experiment;
use trackfail_engine::spec::table::Side;
use trackfail_methods::score::metric::Source;
use trackfail_methods::score::{FrameMeasures, Metric, TrackerMetric};

impl Estimate {
    /// A measure of frames.
    pub fn of_frames(measures: &FrameMeasures, name: &str) -> Self {
        let bound = |end: &str| measures.get(&format!("{name}_{end}"));
        Self { value: measures.get(name), bounds: bound("low").zip(bound("high")) }
    }

    /// A statistic of summed counts, with its interval over sequences.
    pub fn of_counts(
        counts: &BySequence,
        of: impl Fn(&[i64; 4]) -> Option<f64>,
        sampling: &Sampling,
    ) -> Self {
        let units: Vec<[i64; 4]> = counts.values().copied().collect();
        Self { value: of(&sum_of(&units)), bounds: sampling.interval(&units, of) }
    }

    /// The number and its bounds, as a table has them.
    pub fn cells(self, shown: impl Fn(f64) -> String) -> [Cell; 3] {
        [self.value, self.bounds.map(|b| b.0), self.bounds.map(|b| b.1)].map(|v| cell(v, &shown))
    }

    /// The number in a figure.
    fn dot(self) -> Option<Dot> {
        Some(Dot { value: self.value?, bounds: self.bounds })
    }
}

/// What methods or trackers are compared by.
#[derive(Debug, Clone, PartialEq)]
pub struct Measured {
    /// Its name for people.
    pub title: String,
    /// Whether larger or smaller is better.
    pub direction: Direction,
    /// How its numbers are printed.
    pub style: Style,
    /// The metric of methods; `None` for a column of an analysis, of which a tracker has the mean over sequences.
    pub metric: Option<Metric>,
}

impl Measured {
    /// A metric of methods.
    pub fn metric(metric: Metric) -> Self {
        let style = Style::of_metric(metric);
        Self { title: metric.title(), direction: metric.direction(), style, metric: Some(metric) }
    }

    /// A column of an analysis.
    pub fn column(heading: &str) -> Self {
        let direction = TrackerMetric::of_heading(heading).map_or(Direction::HigherIsBetter, |m| m.direction);
        Self { title: heading.to_string(), direction, style: Style::DEFAULT, metric: None }
    }

    /// Itself in the templates of sentences.
    fn told(&self) -> Value {
        let is = |direction| self.direction == direction;
        json!({
            "title": self.title,
            "larger": is(Direction::HigherIsBetter),
            "smaller": is(Direction::LowerIsBetter),
            "of_methods": self.metric.is_some(),
        })
    }
}

/// A method at a point of its grid on a tracker, or a tracker: its number, and how sure its place is.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Standing {
    /// Method with its grid point, or tracker.
    pub label: String,
    /// The same without the grid point.
    pub name: String,
    /// Whether it is ranked and tested.
    pub competes: bool,
    /// What its number is made of; nothing for measures of frames.
    pub counts: BySequence,
    /// Its number.
    pub estimate: Estimate,
    /// Mean of its ranks on sequences, 1 the best.
    pub mean_rank: Option<f64>,
}

impl Standing {
    /// Its name as sentences and figures have it: `AVU (length 20)` of `AVU[length=20]`.
    pub fn spoken(&self) -> String {
        let point = self.label.strip_prefix(&self.name);
        match point.and_then(|rest| rest.strip_prefix('[')?.strip_suffix(']')) {
            Some(point) => format!("{} ({})", self.name, point.replace('=', " ").replace(';', ", ")),
            None => self.label.clone(),
        }
    }
}

/// How far two of a field are apart.
#[derive(Debug, Clone, PartialEq)]
pub struct Pair {
    /// Labels of the two.
    pub labels: [String; 2],
    /// The first less the second.
    pub difference: Estimate,
    /// The p of the permutation test.
    pub p: Option<f64>,
    /// The same after Holm's correction for all pairs of the field.
    pub corrected: Option<f64>,
    /// Sequences that both have a result on.
    pub sequences: usize,
}

/// Methods on one tracker, or trackers, that can be compared.
#[derive(Debug, Clone, PartialEq)]
pub struct Field {
    /// Tracker, and protocol where the tracker's methods have several; empty where trackers compete.
    pub label: String,
    /// The tracker; empty where trackers compete.
    pub tracker: String,
    /// All of them, in the order of the experiment.
    pub standings: Vec<Standing>,
    /// The test of the ranks of all that compete, on the sequences where all of them have a value.
    pub friedman: Option<Friedman>,
    /// The pairs that were tested.
    pub pairs: Vec<Pair>,
}

/// Standings by one measure.
#[derive(Debug, Clone, PartialEq)]
pub struct Standings {
    /// The measure.
    pub measured: Measured,
    /// Those that can be compared with each other.
    pub fields: Vec<Field>,
}

impl Standings {
    /// Those of a field that can be the best, the best first: they compete with a value, and with a result on every
    /// sequence that any of the field has one on. Equal ones stay in the order of the experiment.
    pub fn best_first<'f>(&self, field: &'f Field) -> Vec<(&'f Standing, f64)> {
        let most = field.standings.iter().map(|s| s.counts.len()).max();
        let whole = field.standings.iter().filter(|s| s.competes && Some(s.counts.len()) == most);
        let mut all: Vec<(&Standing, f64)> = whole.filter_map(|s| Some((s, s.estimate.value?))).collect();
        all.sort_by(|a, b| better_first(Some(a.1), Some(b.1), self.measured.direction));
        all
    }
}

impl Field {
    /// How far one is above another, where the two were compared.
    fn difference(&self, one: &Standing, other: &Standing) -> Option<Estimate> {
        let wanted = [&one.label, &other.label];
        self.pairs.iter().find_map(|Pair { labels: [a, b], difference, .. }| {
            if [a, b] == wanted {
                return Some(*difference);
            }
            ([b, a] == wanted).then(|| difference.turned())
        })
    }
}

/// Most competitors of which all pairs are tested: with more, the correction for their number leaves no test any power.
const MAX_COMPETITORS: usize = 12;

/// A field with the numbers of its standings by a statistic of summed counts, their tests and ranks.
fn field(
    (label, tracker): (String, String),
    mut standings: Vec<Standing>,
    of: impl Fn(&[i64; 4]) -> Option<f64> + Copy + Sync,
    direction: Direction,
    sampling: &Sampling,
) -> Field {
    standings.par_iter_mut().for_each(|s| s.estimate = Estimate::of_counts(&s.counts, of, sampling));
    let competing: Vec<&Standing> = standings.iter().filter(|s| s.competes).collect();
    let values = |sequence: &String| -> Option<Vec<f64>> {
        competing.iter().map(|s| of(s.counts.get(sequence)?)).collect()
    };
    let blocks: Vec<Vec<f64>> =
        competing.first().into_iter().flat_map(|s| s.counts.keys()).filter_map(values).collect();
    let enough = Some(&blocks).filter(|blocks| blocks.len() >= MIN_SEQUENCES);
    let friedman = enough.and_then(|blocks| friedman(blocks, direction != Direction::LowerIsBetter));
    let test = |(a, b): (&Standing, &Standing)| pair(a, b, of, sampling);
    let mut pairs: Vec<Pair> = tested(&competing, direction).into_par_iter().map(test).collect();
    let known: Vec<f64> = pairs.iter().filter_map(|pair| pair.p).collect();
    let with_p = pairs.iter_mut().filter(|pair| pair.p.is_some());
    with_p.zip(holm(&known)).for_each(|(pair, p)| pair.corrected = Some(p));
    let mean_ranks = friedman.iter().flat_map(|test| &test.mean_ranks);
    let ranked = standings.iter_mut().filter(|s| s.competes).zip(mean_ranks);
    ranked.for_each(|(s, rank)| s.mean_rank = Some(*rank));
    Field { label, tracker, standings, friedman, pairs }
}

/// The pairs that are tested: all of them or, of many competitors, the best one with each of the others.
fn tested<'s>(competing: &[&'s Standing], direction: Direction) -> Vec<(&'s Standing, &'s Standing)> {
    if competing.len() <= MAX_COMPETITORS {
        let with_later = |k: usize| competing[k + 1..].iter().map(move |other| (competing[k], *other));
        return (0..competing.len()).flat_map(with_later).collect();
    }
    let value = |s: &Standing| s.estimate.value;
    // The first of equal ones.
    let best = competing.iter().copied().min_by(|a, b| better_first(value(a), value(b), direction));
    let others = |best: &'s Standing| competing.iter().copied().filter(move |s| s.label != best.label);
    best.into_iter().flat_map(|best| others(best).map(move |other| (best, other))).collect()
}

fn pair(
    a: &Standing,
    b: &Standing,
    of: impl Fn(&[i64; 4]) -> Option<f64> + Copy,
    sampling: &Sampling,
) -> Pair {
    let both = in_common(&a.counts, &b.counts);
    let seed = sampling.seed_of(&[&a.label, &b.label]);
    let enough = Some(&both).filter(|both| both.len() >= MIN_SEQUENCES);
    let tested = enough.and_then(|both| pooled::permutation(both, of, SAMPLES, seed));
    let value = tested.map(|test| test.difference);
    let bounds = value.and_then(|_| sampling.difference(&both, of));
    let (labels, difference) = ([a.label.clone(), b.label.clone()], Estimate { value, bounds });
    Pair { labels, difference, p: tested.map(|test| test.p), corrected: None, sequences: both.len() }
}

/// The metric that a report is ordered by. Of the metrics in its tables of methods it is F, or else informedness, or else
/// the first that has a direction and comes from counts; F where there is none. (A ratio such as recall, which is 1 for
/// a method that always raises the alarm, orders nothing by itself.)
pub fn ordering_metric(experiment: &Experiment) -> Metric {
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

/// What a report makes of the standings from counts of sequences.
#[derive(Debug, Default)]
pub struct Uncertainty {
    /// The tables `uncertainty` and `pairs` of each measure.
    pub tables: Vec<TableLayout>,
    /// The figure `ranks` of each measure.
    pub ranks: Vec<Captioned>,
    /// Why tables or figures are missing.
    pub note: Option<String>,
    /// The best method or tracker in a sentence, with how sure that is.
    pub verdict: Option<String>,
    /// All of them with their intervals, as a figure with its caption.
    pub dots: Option<(Dots, String)>,
    /// The rows of the first table that are ranked.
    pub ranked: Option<TableLayout>,
    /// The best method of each tracker by the verdict.
    pub best: Vec<String>,
}

/// Intervals, tests and ranks of an experiment's methods, and of the trackers that an analysis scored.
pub fn uncertainty(results: &Results, units: &Units) -> Uncertainty {
    let experiment = &results.experiment;
    if experiment.methods.is_empty() && fields::first_by_sequence(results).is_none() {
        return Uncertainty::default();
    }
    let present = results.manifest.suite.present.len();
    if present < MIN_SEQUENCES {
        let note = format!(
            "No intervals, tests and ranks: they need {MIN_SEQUENCES} sequences of the suite, and {present} are here."
        );
        return Uncertainty { note: Some(note), ..Uncertainty::default() };
    }
    let of_methods = (!experiment.methods.is_empty()).then(|| of_methods(results, units));
    let all = of_methods.into_iter().chain(of_trackers(results, &units.sampling));
    let mut uncertainty = Uncertainty::default();
    for (k, of) in all.enumerate() {
        let (suffix, suite) = match of.measured.metric {
            Some(_) => (String::new(), suite(results)),
            None => {
                (format!("-{}", pairs::measure_name(&of.measured.title)), fields::suite_of_trackers(results))
            }
        };
        let (intervals, pairs) = (tables::intervals(&of), tables::pairs(&of));
        if k == 0 {
            uncertainty.verdict = verdict(&of);
            uncertainty.dots = dots(&of, experiment, &suite);
            uncertainty.best = answer::best_names(&of);
            uncertainty.ranked = Some(of_suite(tables::ranked(&of, intervals.clone()), results, &suite));
        }
        for mut table in [intervals].into_iter().chain(pairs) {
            table.name.push_str(&suffix);
            uncertainty.tables.push(of_suite(table, results, &suite));
        }
        match tables::diagram(&of, &suite) {
            Some(Ok((figure, caption))) => {
                uncertainty.ranks.push(Captioned::new(format!("ranks{suffix}"), figure, caption));
            }
            Some(Err(reason)) => uncertainty.note = uncertainty.note.or(Some(reason)),
            None => {}
        }
    }
    uncertainty
}

#[cfg(test)]
mod tests;
