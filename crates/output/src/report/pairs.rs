//! Measures of a method or tracker by sequence, read from a results folder for comparisons.

use super::figures::lines::distinct;
use super::finished::LookupError;
use super::standings::{of_every_tracker, pair_of};
use crate::results::{CellScore, Results, ResultsError, method_label};
use crate::sampling::{BySequence, Sampling, add, by_sequence, in_common, metric_of_sum, numbers, sum_of};
use std::collections::{BTreeMap, BTreeSet};
use trackfail_core::plugin::unknown;
use trackfail_methods::score::{Metric, TrackerMetric};

/// Measures by name, each with its values by sequence. Sequences without a value are left out.
pub type Values = Vec<(String, BTreeMap<String, f64>)>;

/// Metrics by which methods are compared.
const METRICS: [Metric; 4] = [Metric::F_SCORE, Metric::PRECISION, Metric::RECALL, Metric::FPR];

/// Names that can be compared: methods with their grid points, then trackers that an analysis scored.
pub fn names(results: &Results) -> Vec<String> {
    let methods = results.measures.iter().map(|m| method_label(&m.method, &m.params));
    distinct(methods.chain(results.analyses.iter().map(|a| a.tracker.clone())))
}

/// Measures by sequence of a method, or of a tracker that an analysis scored.
#[derive(Debug, Default)]
pub struct Side {
    /// Measures with their values by sequence.
    pub values: Values,
    /// Counts of a method; empty for a tracker.
    counts: BySequence,
    /// Number of the method's tracks that the other method lacks, which are left out.
    pub left_out: usize,
}

impl Side {
    /// True if the method has tracks, none of which the other one has.
    pub fn is_apart(&self) -> bool {
        self.left_out > 0 && self.counts.is_empty()
    }
}

/// Counts of a method by sequence, tracker and run.
type ByTrack = BTreeMap<(String, String, i64), [i64; 4]>;

/// Two sides of a comparison, each of its results. Counts of methods are pooled within each sequence, over the
/// runs and trackers that both methods have, or only over `tracker`.
///
/// # Errors
/// When the results have no such tracker or method, or cannot be read.
pub fn sides(of: [(&Results, &str); 2], tracker: Option<&str>) -> Result<[Side; 2], LookupError> {
    // A tracker has values, a method has tracks.
    let read = |(results, name): (&Results, &str)| -> Result<(Values, Option<ByTrack>), LookupError> {
        let values = of_tracker(results, name);
        let tracks = values.is_empty().then(|| of_method(results, name, tracker)).transpose()?;
        Ok((values, tracks))
    };
    let [(a, of_a), (b, of_b)] = [read(of[0])?, read(of[1])?];
    let side = |values: Values, mine: &Option<ByTrack>, other: &Option<ByTrack>| {
        let Some(mine) = mine else { return Side { values, ..Side::default() } };
        let (mut counts, mut left_out) = (BySequence::new(), 0);
        for (track, numbers) in mine {
            match other.as_ref().is_none_or(|other| other.contains_key(track)) {
                true => add(&mut counts, &track.0, *numbers),
                false => left_out += 1,
            }
        }
        let of_metric = |metric: Metric| {
            let value = |(sequence, sum): (&String, &[i64; 4])| {
                Some((sequence.clone(), metric_of_sum(metric, None, sum)?))
            };
            (metric.name().to_string(), counts.iter().filter_map(value).collect())
        };
        Side { values: METRICS.map(of_metric).into(), counts, left_out }
    };
    Ok([side(a, &of_a, &of_b), side(b, &of_b, &of_a)])
}

/// Counts of a method, of all trackers or of one.
fn of_method(results: &Results, name: &str, tracker: Option<&str>) -> Result<ByTrack, LookupError> {
    let is_it = |method: &str, params: &str| method_label(method, params) == name;
    if !results.measures.iter().any(|m| is_it(&m.method, &m.params)) {
        let known = names(results);
        let known = known.iter().map(String::as_str);
        return Err(LookupError::unknown(unknown("tracker or method", name, known)));
    }
    let trackers: BTreeSet<&str> = results.measures.iter().map(|m| m.tracker.as_str()).collect();
    if let Some(wanted) = tracker.filter(|wanted| !trackers.contains(wanted)) {
        return Err(LookupError::unknown(unknown("tracker", wanted, trackers)));
    }
    let mine = |cell: &CellScore| {
        is_it(&cell.method, &cell.params) && tracker.is_none_or(|wanted| wanted == cell.tracker)
    };
    let cells = results.scores()?.into_iter().filter(mine);
    Ok(cells.map(|cell| ((cell.sequence, cell.tracker, cell.run), numbers(cell.counts))).collect())
}

/// A measure of two methods over all sequences together, with their difference.
#[derive(Debug, Clone, PartialEq)]
pub struct Apart {
    /// Name of the measure: `pooled f_score`, `auroc`.
    pub measure: String,
    /// Number of common sequences; `None` if unknown.
    pub sequences: Option<usize>,
    /// Value of each method.
    pub values: [Option<f64>; 2],
    /// Bounds of the difference, at 95 %.
    pub bounds: Option<(f64, f64)>,
}

/// Metrics of the pooled counts of two methods on their common sequences. Over all trackers, the differences
/// of `frame_pairs.csv` are added. Empty for sides that are not methods.
///
/// # Errors
/// When the differences cannot be read.
pub fn apart(
    results: &Results,
    [(first, a), (second, b)]: [(&str, &Side); 2],
    tracker: Option<&str>,
) -> Result<Vec<Apart>, ResultsError> {
    let both = in_common(&a.counts, &b.counts);
    if both.is_empty() {
        return Ok(Vec::new());
    }
    let sampling = Sampling::new(&results.experiment);
    let sums = [sum_of(both.iter().map(|(a, _)| a)), sum_of(both.iter().map(|(_, b)| b))];
    let of_metric = |metric: Metric| Apart {
        measure: format!("pooled {}", metric.name()),
        sequences: Some(both.len()),
        values: sums.map(|sum| metric_of_sum(metric, None, &sum)),
        bounds: sampling.difference(&both, |sum| metric_of_sum(metric, None, sum)),
    };
    let mut all: Vec<Apart> = METRICS.map(of_metric).into();
    let pairs = results.frame_pairs()?;
    if let Some(pair) = pair_of(&pairs, first, second).filter(|_| tracker.is_none()) {
        for (name, difference) in [("auroc", pair.auroc), ("found_at_5", pair.found_at_5)] {
            let values = [first, second].map(|method| of_every_tracker(results, method)?.get(name));
            all.push(Apart { measure: name.to_string(), sequences: None, values, bounds: difference.bounds });
        }
    }
    Ok(all)
}

/// For each common measure, the pairs of values on the common sequences.
pub fn common(first: &Values, second: &Values) -> Vec<(String, Vec<(f64, f64)>)> {
    let of_measure = |(measure, a): &(String, BTreeMap<String, f64>)| {
        let (_, b) = second.iter().find(|(other, _)| other == measure)?;
        Some((measure.clone(), in_common(a, b)))
    };
    first.iter().filter_map(of_measure).collect()
}

/// Columns of the tables by sequence that analyses made for a tracker.
fn of_tracker(results: &Results, name: &str) -> Values {
    let mut values = Values::new();
    for table in results.analyses.iter().filter(|a| a.tracker == name).filter_map(by_sequence) {
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
    values
}

/// Heading of a column as one word: `success AUC` becomes `success_auc`.
pub(super) fn measure_name(column: &str) -> String {
    if let Some(metric) = TrackerMetric::of_heading(column) {
        return metric.name.to_string();
    }
    column.chars().map(|c| if c.is_ascii_alphanumeric() { c.to_ascii_lowercase() } else { '_' }).collect()
}
