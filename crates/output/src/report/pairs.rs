//! Measures of a method or tracker, sequence by sequence, from a results folder: the numbers that are compared.

use crate::results::method_label;
use crate::results::{Results, ResultsError};
use std::collections::{BTreeMap, BTreeSet};
use trackfail_core::plugin::unknown;
use trackfail_methods::score::{Counts, Metric, Pooled, TrackerMetric};

/// Measure -> sequence -> value; sequences without a value are left out.
pub type Values = Vec<(String, BTreeMap<String, f64>)>;

/// Measures that cannot be compared.
#[derive(Debug, thiserror::Error)]
pub enum PairsError {
    /// The results cannot be read.
    #[error(transparent)]
    Results(#[from] ResultsError),
    /// The results have no such tracker or method.
    #[error("{0}")]
    Unknown(String),
}

/// Measures of methods that are compared.
const METRICS: [Metric; 4] = [Metric::F_SCORE, Metric::PRECISION, Metric::RECALL, Metric::FPR];

/// Names that can be compared: methods with their grid points, then trackers that an analysis scored.
pub fn names(results: &Results) -> Vec<String> {
    let mut names: Vec<String> = Vec::new();
    let methods = results.measures.iter().map(|m| method_label(&m.method, &m.params));
    for name in methods.chain(results.analyses.iter().map(|a| a.tracker.clone())) {
        if !names.contains(&name) {
            names.push(name);
        }
    }
    names
}

/// The measures of a method, or of a tracker that an analysis scored. The counts of a method are pooled within each
/// sequence, over its runs and, unless one is given, over all trackers.
///
/// # Errors
/// See [`PairsError`].
pub fn values(results: &Results, name: &str, tracker: Option<&str>) -> Result<Values, PairsError> {
    let of_tracker = of_tracker(results, name);
    if !of_tracker.is_empty() {
        return Ok(of_tracker);
    }
    if !results.measures.iter().any(|m| method_label(&m.method, &m.params) == name) {
        let known = names(results);
        return Err(PairsError::Unknown(unknown(
            "tracker or method",
            name,
            known.iter().map(String::as_str),
        )));
    }
    if let Some(wanted) = tracker
        && !results.measures.iter().any(|m| m.tracker == wanted)
    {
        let known: BTreeSet<&str> = results.measures.iter().map(|m| m.tracker.as_str()).collect();
        return Err(PairsError::Unknown(unknown("tracker", wanted, known)));
    }
    let mut pooled: BTreeMap<String, Counts> = BTreeMap::new();
    for row in results.scores()? {
        if method_label(&row.method, &row.params) == name && tracker.is_none_or(|t| t == row.tracker) {
            let sum = pooled.entry(row.sequence).or_default();
            *sum = [*sum, row.counts].into_iter().sum();
        }
    }
    let of_metric = |metric: Metric| {
        let value = |counts: &Counts| metric.value(&Pooled { counts: *counts, ..Pooled::default() });
        let all = pooled.iter().filter_map(|(sequence, counts)| Some((sequence.clone(), value(counts)?)));
        (metric.name().to_string(), all.collect())
    };
    Ok(METRICS.map(of_metric).into())
}

/// For each measure that both sides have, the pairs of values on the sequences that both have.
pub fn common(first: &Values, second: &Values) -> Vec<(String, Vec<(f64, f64)>)> {
    let of_measure = |(measure, a): &(String, BTreeMap<String, f64>)| {
        let (_, b) = second.iter().find(|(other, _)| other == measure)?;
        let pairs = a.iter().filter_map(|(sequence, a)| Some((*a, *b.get(sequence)?)));
        Some((measure.clone(), pairs.collect()))
    };
    first.iter().filter_map(of_measure).collect()
}

/// The columns of the tables `sequences` that analyses made for a tracker.
fn of_tracker(results: &Results, name: &str) -> Values {
    let mut values = Values::new();
    for analysed in results.analyses.iter().filter(|a| a.tracker == name) {
        for table in analysed.findings.tables.iter().filter(|t| t.name == "sequences") {
            for (k, column) in table.columns.iter().enumerate() {
                let measure = measure_name(column);
                if values.iter().all(|(known, _)| *known != measure) {
                    let value = |(row, cells): &(String, Vec<Option<f64>>)| {
                        Some((row.clone(), cells.get(k).copied().flatten()?))
                    };
                    values.push((measure, table.rows.iter().filter_map(value).collect()));
                }
            }
        }
    }
    values
}

/// A column's heading as one word: `success AUC` becomes `success_auc`.
pub(super) fn measure_name(column: &str) -> String {
    if let Some(metric) = TrackerMetric::of_heading(column) {
        return metric.name.to_string();
    }
    column.chars().map(|c| if c.is_ascii_alphanumeric() { c.to_ascii_lowercase() } else { '_' }).collect()
}
