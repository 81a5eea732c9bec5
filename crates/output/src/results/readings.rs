//! `readings.csv`: differences between each reading of a paper and its published numbers, see
//! [`trackfail_methods::readings`].
//!
//! Readings are methods and trackers that are `like` another one in the experiment, and these others.

pub use super::files::Row;

use super::cells::{Done, done, grouped};
use std::collections::BTreeMap;
use trackfail_core::num::seed;
use trackfail_engine::spec::Experiment;
use trackfail_engine::store::StoreError;
use trackfail_engine::{Cell, Outcome};
use trackfail_methods::readings::{Part, Reading, Statistic, shares};
use trackfail_methods::score::frames::bootstrap::interval;
use trackfail_methods::score::{Metric, restarts};

/// Name of the statistic that summarizes a reading.
pub const DISCREPANCY: &str = "discrepancy";

/// Published numbers of a method on a tracker, each metric once.
fn statistics(experiment: &Experiment, tracker: &str, method: &str) -> Vec<Statistic> {
    let mut all: Vec<Statistic> = Vec::new();
    for published in experiment.published.iter().filter(|p| p.tracker == tracker) {
        let text = published.values.iter().find(|(name, _)| name == method).map(|(_, text)| text);
        let (Some(metric), Some(text)) = (Metric::from_name(&published.row), text) else { continue };
        for statistic in Statistic::of_text(metric, text) {
            if all.iter().all(|s| s.metric != statistic.metric) {
                all.push(statistic);
            }
        }
    }
    all
}

/// A reading from the cells of a method without a grid on a tracker, with the names of its rows; `None` if there are no
/// published numbers.
fn named(
    experiment: &Experiment,
    outcome: &Outcome<'_>,
    (tracker, method): (&str, &str),
    cells: &[&Cell],
) -> Result<Option<(Row, Reading)>, StoreError> {
    let statistics = statistics(experiment, tracker, method);
    if statistics.is_empty() {
        return Ok(None);
    }
    let like_tracker =
        experiment.trackers.iter().find(|t| t.label == tracker).and_then(|t| t.like.as_deref());
    let like_method = experiment.methods.iter().find(|m| m.name == method).and_then(|m| m.like.as_deref());
    let mut parts: BTreeMap<usize, Part> = BTreeMap::new();
    for Done { cell, judged, output, .. } in done(outcome, cells.iter().copied())? {
        let scores = restarts::counted(&judged.pieces, &output.score);
        parts.entry(cell.sequence).or_default().add(&Part::new(judged.score.counts, &scores), 1);
    }
    let names = [tracker, method, like_tracker.unwrap_or(tracker), like_method.unwrap_or(method)];
    let [tracker, method, of_tracker, of_method] = names.map(str::to_string);
    let row = Row { tracker, method, of_tracker, of_method, ..Row::default() };
    Ok(Some((row, Reading::new(statistics, parts, seed::seed(experiment.seed, &["readings"])))))
}

/// True if an experiment has readings.
pub fn has_readings(experiment: &Experiment) -> bool {
    experiment.methods.iter().any(|m| m.like.is_some())
        || experiment.trackers.iter().any(|t| t.like.is_some())
}

/// Rows of an outcome. Readings of the same method on the same tracker are together, in the experiment's
/// order.
///
/// # Errors
/// When a detector output can no longer be read from the store.
pub(super) fn rows(experiment: &Experiment, outcome: &Outcome<'_>) -> Result<Vec<Row>, StoreError> {
    let single = outcome.cells.iter().filter(|cell| cell.params.is_empty());
    let groups = grouped(single, |cell| (cell.tracker.as_str(), cell.method.as_str()));
    let readings = groups.iter().map(|(name, cells)| named(experiment, outcome, *name, cells));
    let readings: Vec<(Row, Reading)> =
        readings.collect::<Result<Vec<_>, StoreError>>()?.into_iter().flatten().collect();
    let of_same = grouped(&readings, |(row, _)| (&row.of_tracker, &row.of_method)).into_iter();
    let mut rows = Vec::new();
    for (of, mine) in of_same.filter(|(_, all)| all.len() > 1) {
        let (_, first) = mine.iter().find(|(r, _)| (&r.tracker, &r.method) == of).unwrap_or(&mine[0]);
        let scales = first.scales();
        let shares = shares(&mine.iter().map(|(_, reading)| reading).collect::<Vec<_>>(), &scales);
        for (k, (row, reading)) in mine.iter().enumerate() {
            let row = |statistic: &str| Row { statistic: statistic.to_string(), ..row.clone() };
            let Reading { statistics, ours, samples, .. } = reading;
            for (s, Statistic { metric, published, .. }) in statistics.iter().enumerate() {
                rows.push(Row {
                    published: Some(*published),
                    ours: ours[s],
                    difference: ours[s].map(|ours| ours - published),
                    bounds: ours[s].and(interval(samples[s].clone())).map(<[f64; 2]>::from),
                    scale: scales.get(metric.name()).copied(),
                    ..row(metric.name())
                });
            }
            let first = shares.as_ref().and_then(|shares| shares.get(k).copied());
            let ours = reading.discrepancy(&scales, None);
            rows.push(Row { ours, first, ..row(DISCREPANCY) });
        }
    }
    Ok(rows)
}
