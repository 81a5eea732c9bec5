//! Bootstrap bands: intervals over sequences of the values that a curve is made of.

use crate::results::{CellScore, Measure, Results, method_label};
use crate::sampling::{MIN_SEQUENCES, Sampling, UnitCounts, counts_of_sequences, metric_of_sum};
use trackfail_methods::score::Metric;
use trackfail_methods::score::metric::Source;

/// The counts of every cell, by sequence.
pub struct Bands<'r> {
    results: &'r Results,
    counts: UnitCounts,
    sampling: Sampling,
}

impl<'r> Bands<'r> {
    /// Counts that intervals are drawn from.
    pub fn new(results: &'r Results, scores: &[CellScore]) -> Self {
        Self { results, counts: counts_of_sequences(scores), sampling: Sampling::new(&results.experiment) }
    }

    /// Bounds of a metric's value; NaN where there are none: for metrics that are not of counts, and with few sequences.
    pub fn bounds(&self, measure: &Measure, metric: Metric) -> (f64, f64) {
        let key = (measure.tracker.clone(), method_label(&measure.method, &measure.params));
        let units = self.counts.get(&key).filter(|u| u.len() >= MIN_SEQUENCES);
        let Some(units) = units.filter(|_| metric.source() == Source::Counts) else {
            return (f64::NAN, f64::NAN);
        };
        let chance = self.results.experiment.chance_of(&measure.method);
        let value = |sum: &[i64; 4]| metric_of_sum(metric, chance, sum);
        let units: Vec<[i64; 4]> = units.values().copied().collect();
        self.sampling.interval(&units, value).unwrap_or((f64::NAN, f64::NAN))
    }
}

/// Bounds of the ratio of two counts, summed over units; NaN where there are none.
pub fn ratio(units: &[[i64; 2]], sampling: &Sampling) -> (f64, f64) {
    let of = |c: &[i64; 2]| (c[1] > 0).then(|| c[0] as f64 / c[1] as f64);
    sampling.interval(units, of).unwrap_or((f64::NAN, f64::NAN))
}

#[cfg(test)]
mod tests {
    use super::*;

    // The share of each unit is the same, so that every sample has it; two units are too few.
    #[test]
    fn bounds_of_a_ratio_need_three_units() {
        let sampling = Sampling::with_seed(7);
        assert_eq!(ratio(&[[1, 2]; 3], &sampling), (0.5, 0.5));
        assert!(ratio(&[[1, 2]; 2], &sampling).0.is_nan());
        let (low, high) = ratio(&[[0, 4], [2, 4], [4, 4], [1, 4]], &sampling);
        assert!((0.0..0.4375).contains(&low) && (0.4375..=1.0).contains(&high), "{low} {high}");
    }
}
