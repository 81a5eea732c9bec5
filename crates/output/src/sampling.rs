//! Counts of sequences, and bootstrap samples of them, the same for all numbers of an experiment that are made of counts.
//!
//! A sample draws as many sequences as there are, with replacement, and with all runs of a sequence together;
//! a number is computed from the summed counts. Numbers over the same number of sequences use the same
//! samples. So an interval is the same in all tables, and differences, ranks and claims compare numbers of
//! the same samples.
//!
//! The seed is made of the experiment's seed and name. Measures of frames and readings have their own
//! intervals, in the files of the results.

use crate::results::{CellScore, Measure, method_label};
use std::collections::{BTreeMap, BTreeSet};
use std::sync::{Arc, Mutex, PoisonError};
use trackfail_core::num::pooled::{Draws, percentiles};
pub use trackfail_core::num::pooled::{LEVEL, MIN_UNITS as MIN_SEQUENCES, SAMPLES};
use trackfail_core::num::seed;
use trackfail_engine::execute::analyse::Analysed;
use trackfail_engine::spec::Experiment;
use trackfail_methods::analysis::Grid;
use trackfail_methods::score::chance::Chance;
use trackfail_methods::score::{Counts, Metric, Pooled};

/// Bootstrap samples of an experiment, by number of sequences.
pub struct Sampling {
    seed: u64,
    drawn: Mutex<BTreeMap<usize, Arc<Draws>>>,
}

impl Sampling {
    /// Samples of an experiment, by its seed and name.
    pub fn new(experiment: &Experiment) -> Self {
        Self::with_seed(seed::seed(experiment.seed, &["samples", &experiment.name]))
    }

    /// Samples by a seed.
    pub fn with_seed(seed: u64) -> Self {
        Self { seed, drawn: Mutex::default() }
    }

    /// Seed for the random patterns of a test with these names.
    pub fn seed_of(&self, names: &[&str]) -> u64 {
        seed::seed(self.seed, names)
    }

    fn draws(&self, sequences: usize) -> Option<Arc<Draws>> {
        let mut drawn = self.drawn.lock().unwrap_or_else(PoisonError::into_inner);
        let new = || Arc::new(Draws::new(sequences, SAMPLES, self.seed));
        (sequences >= MIN_SEQUENCES).then(|| drawn.entry(sequences).or_insert_with(new).clone())
    }

    /// Statistic of the summed counts in each sample, NaN if it has no value; `None` for fewer sequences than
    /// [`MIN_SEQUENCES`].
    pub fn values(
        &self,
        counts: &[[i64; 4]],
        statistic: impl Fn(&[i64; 4]) -> Option<f64>,
    ) -> Option<Vec<f64>> {
        self.draws(counts.len())?.values(counts, statistic)
    }

    /// Interval of a statistic of summed counts; `None` if it has none, or for few sequences.
    pub fn interval<const N: usize>(
        &self,
        counts: &[[i64; N]],
        statistic: impl Fn(&[i64; N]) -> Option<f64>,
    ) -> Option<(f64, f64)> {
        self.draws(counts.len())?.interval(counts, statistic, LEVEL)
    }

    /// Interval of the difference of a statistic between two lists of counts on the same sequences.
    pub fn difference(
        &self,
        both: &[([i64; 4], [i64; 4])],
        statistic: impl Fn(&[i64; 4]) -> Option<f64>,
    ) -> Option<(f64, f64)> {
        let (first, second): (Vec<_>, Vec<_>) = both.iter().copied().unzip();
        let (first, second) = (self.values(&first, &statistic)?, self.values(&second, &statistic)?);
        percentiles(first.iter().zip(second).map(|(a, b)| a - b).collect(), SAMPLES, LEVEL)
    }
}

/// TP, FP, FN and TN of all runs by sequence, or the counts of [`counts_of_column`].
pub type BySequence = BTreeMap<String, [i64; 4]>;

/// Counts of an experiment by sequence, and samples of its sequences.
pub struct Units {
    /// Bootstrap samples.
    pub sampling: Sampling,
    /// Counts by tracker and method (with its grid point).
    counts: BTreeMap<(String, String), BySequence>,
}

impl Units {
    /// Counts of an experiment's cells, with its samples.
    pub fn new(experiment: &Experiment, scores: &[CellScore]) -> Self {
        let mut counts: BTreeMap<_, BySequence> = BTreeMap::new();
        for row in scores {
            let key = (row.tracker.clone(), method_label(&row.method, &row.params));
            add(counts.entry(key).or_default(), &row.sequence, numbers(row.counts));
        }
        Self { sampling: Sampling::new(experiment), counts }
    }

    /// Counts of a method (with its grid point) on a tracker.
    pub fn of(&self, tracker: &str, label: &str) -> Option<&BySequence> {
        self.counts.get(&(tracker.to_string(), label.to_string()))
    }

    /// Counts behind a measure.
    pub fn of_measure(&self, measure: &Measure) -> Option<&BySequence> {
        self.of(&measure.tracker, &method_label(&measure.method, &measure.params))
    }

    /// All sequences on which some method has counts.
    pub fn sequences(&self) -> BTreeSet<&String> {
        self.counts.values().flat_map(BTreeMap::keys).collect()
    }

    /// Counts of a method (with its grid point) on all trackers that are taken, together.
    pub fn pooled(&self, label: &str, is_taken: impl Fn(&str) -> bool) -> BySequence {
        let mut pooled = BySequence::new();
        let is_it = |(tracker, l): &(String, String)| l == label && is_taken(tracker);
        for (sequence, counts) in self.counts.iter().filter(|(key, _)| is_it(key)).flat_map(|(_, c)| c) {
            add(&mut pooled, sequence, *counts);
        }
        pooled
    }
}

/// Adds counts to those of a sequence.
pub(crate) fn add(sums: &mut BySequence, sequence: &str, counts: [i64; 4]) {
    let sum = sums.entry(sequence.to_string()).or_default();
    sum.iter_mut().zip(counts).for_each(|(s, c)| *s = (*s + c).min(MOST));
}

/// Largest count. Larger ones are clamped, so that sums of forged counts cannot overflow.
const MOST: i64 = 1 << 40;

/// TP, FP, FN and TN.
pub(crate) fn numbers(counts: Counts) -> [i64; 4] {
    let Counts { tp, fp, fn_, tn } = counts;
    [tp, fp, fn_, tn].map(|c| i64::try_from(c).unwrap_or(MOST).min(MOST))
}

/// Counts on each of these sequences, zeros if there are none.
pub fn along<'s>(counts: &BySequence, sequences: impl IntoIterator<Item = &'s String>) -> Vec<[i64; 4]> {
    sequences.into_iter().map(|s| counts.get(s).copied().unwrap_or_default()).collect()
}

/// Value of a metric, from counts summed over sequences; `None` if it has no value.
pub fn metric_of_sum(metric: Metric, chance: Option<Chance>, sum: &[i64; 4]) -> Option<f64> {
    let [tp, fp, fn_, tn] = sum.map(|c| u64::try_from(c).unwrap_or(0));
    metric.value(&Pooled { counts: Counts { tp, fp, fn_, tn }, chance, ..Pooled::default() })
}

/// Table of an analysis with one row per sequence.
pub fn by_sequence(analysed: &Analysed) -> Option<&Grid> {
    analysed.findings.tables.iter().find(|table| table.name == "sequences")
}

/// Factor by which values of a column are scaled to integers.
const BILLION: f64 = 1e9;

/// Converts a column of a table by sequence to counts: the value in billionths, an integer so that sums are
/// the same in any order, and 1. Sequences without a value are left out.
pub fn counts_of_column(table: &Grid, column: usize) -> BySequence {
    let unit = |(sequence, cells): &(String, Vec<Option<f64>>)| {
        // Measures of a sequence are far below a million.
        let value = cells.get(column).copied().flatten()?.clamp(-1e6, 1e6);
        Some((sequence.clone(), [(value * BILLION).round() as i64, 1, 0, 0]))
    };
    table.rows.iter().filter_map(unit).collect()
}

/// Mean of a column, from the sum of [`counts_of_column`]; `None` without values.
pub fn mean_of_sum(sum: &[i64; 4]) -> Option<f64> {
    Some(total_of_sum(sum)? / sum[1] as f64)
}

/// Total of a column, from the sum of [`counts_of_column`]; `None` without values.
pub fn total_of_sum(sum: &[i64; 4]) -> Option<f64> {
    (sum[1] > 0).then(|| sum[0] as f64 / BILLION)
}

/// Sum of counts.
pub fn sum_of<'c>(counts: impl IntoIterator<Item = &'c [i64; 4]>) -> [i64; 4] {
    counts.into_iter().fold([0; 4], |total, unit| std::array::from_fn(|k| total[k] + unit[k]))
}

/// Pairs of values on the common sequences.
pub fn in_common<T: Copy>(first: &BTreeMap<String, T>, second: &BTreeMap<String, T>) -> Vec<(T, T)> {
    first.iter().filter_map(|(sequence, one)| Some((*one, *second.get(sequence)?))).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    // Two numbers of the same counts have one interval, wherever they are asked for, whatever was drawn before.
    #[test]
    fn an_interval_depends_on_the_counts_alone() {
        let counts: [[i64; 4]; 9] =
            std::array::from_fn(|k| [1 + k as i64 * 7 % 5, k as i64 % 4, 11 - k as i64, 9]);
        let f = |sum: &[i64; 4]| metric_of_sum(Metric::F_SCORE, None, sum);
        let here = Sampling::with_seed(3);
        let first = here.interval(&counts, f).unwrap();
        let value = f(&sum_of(&counts)).unwrap();
        assert!(first.0 < value && value < first.1);
        let elsewhere = Sampling::with_seed(3);
        let of_few = [3, 2].map(|n| elsewhere.interval(&counts[..n], f).is_some());
        assert_eq!(of_few, [true, false]);
        assert_eq!(elsewhere.interval(&counts, f), Some(first));
        assert_ne!(Sampling::with_seed(4).interval(&counts, f), Some(first));
    }
}
