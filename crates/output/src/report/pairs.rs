//! Measures of a method or tracker, sequence by sequence, from a results folder: the numbers that are compared.

use super::differences::pair_of;
use crate::results::frame_measures::EVERY_TRACKER;
use crate::results::{Results, ResultsError, method_label};
use crate::sampling::{Sampling, metric_of_sum, numbers};
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

/// A method, or a tracker that an analysis scored, sequence by sequence.
pub struct Side {
    /// Its measures.
    pub values: Values,
    /// Counts of a method; none of a tracker.
    counts: BTreeMap<String, Counts>,
}

/// The measures of a method, or of a tracker that an analysis scored. The counts of a method are pooled within each
/// sequence, over its runs and, unless one is given, over all trackers.
///
/// # Errors
/// See [`PairsError`].
pub fn side(results: &Results, name: &str, tracker: Option<&str>) -> Result<Side, PairsError> {
    let of_tracker = of_tracker(results, name);
    if !of_tracker.is_empty() {
        return Ok(Side { values: of_tracker, counts: BTreeMap::new() });
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
    Ok(Side { values: METRICS.map(of_metric).into(), counts: pooled })
}

/// Measures of two methods of an experiment over all sequences together, as tables have them, and how far they are apart.
#[derive(Debug, Clone, PartialEq)]
pub struct Apart {
    /// The measure: `pooled f_score`, `auroc`.
    pub measure: String,
    /// Number of sequences that both rest on, where it is known.
    pub sequences: Option<usize>,
    /// The measure of each method.
    pub values: [Option<f64>; 2],
    /// Bounds of the difference, 95 %.
    pub bounds: Option<(f64, f64)>,
}

/// Metrics of the pooled counts of two methods on the sequences that both have and, over all trackers, the differences of
/// `frame_pairs.csv`; nothing for what are no methods.
///
/// # Errors
/// When the differences cannot be read.
pub fn apart(
    results: &Results,
    [(first, a), (second, b)]: [(&str, &Side); 2],
    tracker: Option<&str>,
) -> Result<Vec<Apart>, ResultsError> {
    let both: Vec<(Counts, Counts)> =
        a.counts.iter().filter_map(|(sequence, a)| Some((*a, *b.counts.get(sequence)?))).collect();
    if both.is_empty() {
        return Ok(Vec::new());
    }
    let units: Vec<([i64; 4], [i64; 4])> = both.iter().map(|(a, b)| (numbers(*a), numbers(*b))).collect();
    let sums = [both.iter().map(|(a, _)| *a).sum(), both.iter().map(|(_, b)| *b).sum()];
    let sampling = Sampling::new(&results.experiment);
    let of_metric = |metric: Metric| Apart {
        measure: format!("pooled {}", metric.name()),
        sequences: Some(both.len()),
        values: sums.map(|counts| metric.value(&Pooled { counts, ..Pooled::default() })),
        bounds: sampling.difference(&units, |sum| metric_of_sum(metric, None, sum)),
    };
    let mut all: Vec<Apart> = METRICS.map(of_metric).into();
    let pairs = results.frame_pairs()?;
    if let Some(pair) = pair_of(&pairs, first, second).filter(|_| tracker.is_none()) {
        for (name, difference) in [("auroc", pair.auroc), ("found_at_5", pair.found_at_5)] {
            let value = |method: &str| {
                let key = [EVERY_TRACKER, method, ""].map(str::to_string);
                results.frame_measures.get(&key)?.get(name)
            };
            let (values, bounds) = ([first, second].map(value), difference.bounds);
            all.push(Apart { measure: name.to_string(), sequences: None, values, bounds });
        }
    }
    Ok(all)
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
