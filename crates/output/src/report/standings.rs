//! Standings: the best method or tracker, and the certainty of that. The tables `uncertainty`, `pairs`,
//! `differences` (with `breakdown`), the figure and sentence at the head of a page, and the leaderboard are
//! all made from this list.
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
pub use answer::{best_names, dots, frames_verdict, verdict};
pub use fields::{frames_metric, of_frames};
pub use frames::{CHANCE, breakdown, differences, of_every_tracker, pair_of};
pub use tables::ranked;

use super::{figures::Captioned, pairs, sentences::say};
use crate::figure::Dot;
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
    /// Estimate of a measure of frames.
    pub fn of_frames(measures: &FrameMeasures, name: &str) -> Self {
        Self { value: measures.get(name), bounds: measures.bounds(name) }
    }

    /// Statistic of summed counts, with its interval over sequences.
    pub fn of_counts(
        counts: &BySequence,
        of: impl Fn(&[i64; 4]) -> Option<f64>,
        sampling: &Sampling,
    ) -> Self {
        let units: Vec<[i64; 4]> = counts.values().copied().collect();
        Self { value: of(&sum_of(&units)), bounds: sampling.interval(&units, of) }
    }

    /// Cells of a table with the number and its bounds.
    pub fn cells(self, shown: impl Fn(f64) -> String) -> [Cell; 3] {
        [self.value, self.bounds.map(|b| b.0), self.bounds.map(|b| b.1)].map(|v| cell(v, &shown))
    }

    /// Dot of the number in a figure; `None` without a value.
    fn dot(self) -> Option<Dot> {
        Some(Dot { value: self.value?, bounds: self.bounds })
    }
}

/// Measure by which methods or trackers are compared.
#[derive(Debug, Clone, PartialEq)]
pub struct Measured {
    /// Name for people.
    pub title: String,
    /// Direction: larger or smaller is better.
    pub direction: Direction,
    /// Print style of the numbers.
    pub style: Style,
    /// Metric of methods; `None` for a column of an analysis, whose mean over sequences is the number of a
    /// tracker.
    pub metric: Option<Metric>,
}

impl Measured {
    /// Measure of methods by a metric.
    pub fn metric(metric: Metric) -> Self {
        let style = Style::of_metric(metric);
        Self { title: metric.title(), direction: metric.direction(), style, metric: Some(metric) }
    }

    /// Measure of trackers by a column of an analysis.
    pub fn column(heading: &str) -> Self {
        let direction = TrackerMetric::of_heading(heading).map_or(Direction::HigherIsBetter, |m| m.direction);
        Self { title: heading.to_string(), direction, style: Style::DEFAULT, metric: None }
    }

    /// Values for the templates of sentences.
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

/// A method at a point of its grid on a tracker, or a tracker: its number, and the certainty of its place.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Standing {
    /// Name of the method with its grid point, or of the tracker.
    pub label: String,
    /// Name without the grid point.
    pub name: String,
    /// True if the standing is ranked and tested.
    pub competes: bool,
    /// Counts behind the number; empty for measures of frames.
    pub counts: BySequence,
    /// The number with its bounds.
    pub estimate: Estimate,
    /// Mean of the ranks on the sequences; 1 is best.
    pub mean_rank: Option<f64>,
}

impl Standing {
    /// Name in sentences and figures: `AVU (length 20)` for `AVU[length=20]`.
    pub fn spoken(&self) -> String {
        let point = self.label.strip_prefix(&self.name);
        match point.and_then(|rest| rest.strip_prefix('[')?.strip_suffix(']')) {
            Some(point) => format!("{} ({})", self.name, point.replace('=', " ").replace(';', ", ")),
            None => self.label.clone(),
        }
    }
}

/// Difference between two standings of a field.
#[derive(Debug, Clone, PartialEq)]
pub struct Pair {
    /// Labels of the two standings.
    pub labels: [String; 2],
    /// First number minus the second.
    pub difference: Estimate,
    /// p-value of the permutation test.
    pub p: Option<f64>,
    /// p-value after Holm's correction for all pairs of the field.
    pub corrected: Option<f64>,
    /// Number of sequences on which both standings have a result.
    pub sequences: usize,
}

/// Standings that can be compared with each other: methods on one tracker, or trackers.
#[derive(Debug, Clone, PartialEq)]
pub struct Field {
    /// Label of the tracker, with the protocol if the tracker's methods have several; empty if trackers
    /// compete.
    pub label: String,
    /// Label of the tracker; empty if trackers compete.
    pub tracker: String,
    /// Standings in the order of the experiment.
    pub standings: Vec<Standing>,
    /// Friedman test of the ranks of all competitors, on the sequences where all have a value.
    pub friedman: Option<Friedman>,
    /// Pairs that were tested.
    pub pairs: Vec<Pair>,
}

/// Standings of methods or trackers by one measure, grouped into fields that are compared.
#[derive(Debug, Clone, PartialEq)]
pub struct Standings {
    /// Measure of the standings.
    pub measured: Measured,
    /// Fields; only standings of the same field are compared.
    pub fields: Vec<Field>,
}

impl Standings {
    /// Standings of a field that can be the best, the best first. These compete, have a value, and have a
    /// result on each sequence on which any of the field has one. Equal ones stay in the order of the
    /// experiment.
    pub fn best_first<'f>(&self, field: &'f Field) -> Vec<(&'f Standing, f64)> {
        let most = field.standings.iter().map(|s| s.counts.len()).max();
        let whole = field.standings.iter().filter(|s| s.competes && Some(s.counts.len()) == most);
        let mut all: Vec<(&Standing, f64)> = whole.filter_map(|s| Some((s, s.estimate.value?))).collect();
        all.sort_by(|a, b| better_first(Some(a.1), Some(b.1), self.measured.direction));
        all
    }
}

impl Field {
    /// Difference of two standings, if they were compared.
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

/// Most competitors for tests of all pairs. With more, the correction for their number would leave the tests
/// without power.
const MAX_COMPETITORS: usize = 12;

/// Field of the standings, with numbers by a statistic of summed counts, tests and ranks.
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
    let test = |(a, b): (&Standing, &Standing)| {
        let both = in_common(&a.counts, &b.counts);
        let seed = sampling.seed_of(&[&a.label, &b.label]);
        let enough = Some(&both).filter(|both| both.len() >= MIN_SEQUENCES);
        let tested = enough.and_then(|both| pooled::permutation(both, of, SAMPLES, seed));
        let value = tested.map(|test| test.difference);
        let bounds = value.and_then(|_| sampling.difference(&both, of));
        let (labels, difference) = ([a.label.clone(), b.label.clone()], Estimate { value, bounds });
        Pair { labels, difference, p: tested.map(|test| test.p), corrected: None, sequences: both.len() }
    };
    let mut pairs: Vec<Pair> = tested(&competing, direction).into_par_iter().map(test).collect();
    let known: Vec<f64> = pairs.iter().filter_map(|pair| pair.p).collect();
    let with_p = pairs.iter_mut().filter(|pair| pair.p.is_some());
    with_p.zip(holm(&known)).for_each(|(pair, p)| pair.corrected = Some(p));
    let mean_ranks = friedman.iter().flat_map(|test| &test.mean_ranks);
    let ranked = standings.iter_mut().filter(|s| s.competes).zip(mean_ranks);
    ranked.for_each(|(s, rank)| s.mean_rank = Some(*rank));
    Field { label, tracker, standings, friedman, pairs }
}

/// Pairs to test: all of them or, with many competitors, the best one with each of the others.
fn tested<'s>(competing: &[&'s Standing], direction: Direction) -> Vec<(&'s Standing, &'s Standing)> {
    if competing.len() <= MAX_COMPETITORS {
        let with_later = |k: usize| competing[k + 1..].iter().map(move |other| (competing[k], *other));
        return (0..competing.len()).flat_map(with_later).collect();
    }
    let value = |s: &Standing| s.estimate.value;
    let most = competing.iter().map(|s| s.counts.len()).max();
    // The first of equal ones, among those that can be the best.
    let whole = competing.iter().copied().filter(|s| Some(s.counts.len()) == most);
    let best = whole.min_by(|a, b| better_first(value(a), value(b), direction));
    let others = |best: &'s Standing| competing.iter().copied().filter(move |s| s.label != best.label);
    best.into_iter().flat_map(|best| others(best).map(move |other| (best, other))).collect()
}

/// Metric by which a report orders methods. Among the metrics in its tables of methods it is F, else
/// informedness, else the first that has a direction and comes from counts; F if there is none. (A ratio such
/// as recall does not order methods, since it is 1 for a method that always alarms.)
pub fn ordering_metric(experiment: &Experiment) -> Metric {
    let of_methods = experiment.tables.iter().filter(|t| t.shows.is_none());
    let metrics: Vec<Metric> = of_methods
        .flat_map(|t| match &t.rows {
            Side::Metrics(metrics) => metrics.clone(),
            _ => t.metric.into_iter().collect(),
        })
        .collect();
    // The effort of reverse runs and measures of frames are not computed from counts of detections.
    let is_other = |m: &Metric| matches!(m.source, Source::Effort | Source::Frames);
    let fits = |m: &Metric| !is_other(m) && m.direction() != Direction::Neither;
    let whole = [Metric::F_SCORE, Metric::INFORMEDNESS].into_iter().find(|m| metrics.contains(m));
    whole.or_else(|| metrics.into_iter().find(fits)).unwrap_or(Metric::F_SCORE)
}

/// Tables, figures and sentences of a report that come from the standings.
#[derive(Debug, Default)]
pub struct Uncertainty {
    /// Tables `uncertainty` and `pairs` of each measure.
    pub tables: Vec<TableLayout>,
    /// Figure `ranks` of each measure.
    pub ranks: Vec<Captioned>,
    /// Reason why tables or figures are missing.
    pub note: Option<String>,
    /// Standings by the first measure, with the sentence that names their suite.
    pub first: Option<(Standings, String)>,
}

/// Intervals, tests and ranks of an experiment's methods, and of the trackers that an analysis scored.
pub fn uncertainty(results: &Results, units: &Units) -> Uncertainty {
    let experiment = &results.experiment;
    if experiment.methods.is_empty() && fields::first_by_sequence(results).is_none() {
        return Uncertainty::default();
    }
    let present = results.manifest.suite.present.len();
    if present < MIN_SEQUENCES {
        let note = say("few sequences", json!({ "needed": MIN_SEQUENCES, "present": present }));
        return Uncertainty { note: Some(note), ..Uncertainty::default() };
    }
    let of_methods = (!experiment.methods.is_empty()).then(|| of_methods(results, units));
    let all = of_methods.into_iter().chain(of_trackers(results, &units.sampling));
    let mut uncertainty = Uncertainty::default();
    for of in all {
        let (suffix, suite) = match of.measured.metric {
            Some(_) => (String::new(), suite(results)),
            None => {
                (format!("-{}", pairs::measure_name(&of.measured.title)), fields::suite_of_trackers(results))
            }
        };
        for mut table in [tables::intervals(&of)].into_iter().chain(tables::pairs(&of)) {
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
        uncertainty.first.get_or_insert((of, suite));
    }
    uncertainty
}

#[cfg(test)]
mod tests;
