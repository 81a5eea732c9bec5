//! Bootstrap bands: intervals over sequences of the values that a curve is made of.

use crate::results::{Measure, Results};
use crate::sampling::{Sampling, Units, metric_of_sum};
use trackfail_methods::score::Metric;
use trackfail_methods::score::metric::Source;

/// The counts of every cell, by sequence.
pub struct Bands<'r> {
    results: &'r Results,
    units: &'r Units,
}

impl<'r> Bands<'r> {
    /// Counts that intervals are drawn from.
    pub fn new(results: &'r Results, units: &'r Units) -> Self {
        Self { results, units }
    }

    /// Bounds of a metric's value; NaN where there are none: for metrics that are not of counts, and with few sequences.
    pub fn bounds(&self, measure: &Measure, metric: Metric) -> (f64, f64) {
        let counts = self.units.of_measure(measure).filter(|_| metric.source() == Source::Counts);
        let chance = self.results.experiment.chance_of(&measure.method);
        let bounds = counts.and_then(|counts| {
            let counts: Vec<[i64; 4]> = counts.values().copied().collect();
            self.units.sampling.interval(&counts, |sum| metric_of_sum(metric, chance, sum))
        });
        bounds.unwrap_or((f64::NAN, f64::NAN))
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
