//! Counts of sequences, the units that intervals and tests draw, and metrics of their sums.

use crate::results::{CellScore, method_label};
use std::collections::BTreeMap;
use trackfail_methods::analysis::Grid;
use trackfail_methods::score::chance::Chance;
use trackfail_methods::score::{Counts, Metric, Pooled};

/// Tracker and method, with its grid point -> sequence -> TP, FP, FN and TN of all runs.
pub type UnitCounts = BTreeMap<(String, String), BTreeMap<String, [i64; 4]>>;

/// The counts of every method on every tracker, by sequence.
pub fn counts_of_sequences(scores: &[CellScore]) -> UnitCounts {
    let mut counts = UnitCounts::new();
    for row in scores {
        let key = (row.tracker.clone(), method_label(&row.method, &row.params));
        let sum = counts.entry(key).or_default().entry(row.sequence.clone()).or_default();
        let Counts { tp, fp, fn_, tn } = row.counts;
        // More than any sequence has; the limit keeps sums of forged counts from overflowing.
        let new = [tp, fp, fn_, tn].map(|c| c.min(1 << 40) as i64);
        sum.iter_mut().zip(new).for_each(|(s, c)| *s = (*s + c).min(1 << 40));
    }
    counts
}

/// A metric of counts of the sum over units; `None` where it has no value.
pub fn metric_of_sum(metric: Metric, chance: Option<Chance>, sum: &[i64; 4]) -> Option<f64> {
    let [tp, fp, fn_, tn] = sum.map(|c| u64::try_from(c).unwrap_or(0));
    metric.value(&Pooled { counts: Counts { tp, fp, fn_, tn }, chance, ..Pooled::default() })
}

/// Factor of the values of a column.
const BILLION: f64 = 1e9;

/// A column of a table of sequences as counts: sequence -> its value in billionths, an integer, so that the sum is the same
/// in any order, and 1. Sequences without a value are left out.
pub fn counts_of_column(table: &Grid, column: usize) -> BTreeMap<String, [i64; 4]> {
    let unit = |(sequence, cells): &(String, Vec<Option<f64>>)| {
        // Measures of a sequence are far below a million.
        let value = cells.get(column).copied().flatten()?.clamp(-1e6, 1e6);
        Some((sequence.clone(), [(value * BILLION).round() as i64, 1, 0, 0]))
    };
    table.rows.iter().filter_map(unit).collect()
}

/// The mean of a column from the sum of [`counts_of_column`]; `None` without values.
pub fn mean_of_sum(sum: &[i64; 4]) -> Option<f64> {
    Some(total_of_sum(sum)? / sum[1] as f64)
}

/// The total of a column from the sum of [`counts_of_column`]; `None` without values.
pub fn total_of_sum(sum: &[i64; 4]) -> Option<f64> {
    (sum[1] > 0).then(|| sum[0] as f64 / BILLION)
}

/// The sum of the counts of all units.
pub fn sum_of(counts: &BTreeMap<String, [i64; 4]>) -> [i64; 4] {
    counts.values().fold([0; 4], |total, unit| std::array::from_fn(|k| total[k] + unit[k]))
}
