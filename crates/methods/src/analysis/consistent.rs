//! Helpers of the analyses of c_t in consistent frames.

use super::Population;
use crate::detector::consistency::consistent_changes;
use trackfail_core::num::kolmogorov;
use trackfail_core::plugin::{ParamError, Range};

/// Range of `tau`, the error below which a frame is consistent.
pub const TAU: Range = Range::of("tau").above(0.0).at_most(1.0);
/// Range of `lengths`, the numbers of frames of the sums of c_t.
pub const LENGTHS: Range = Range::within("lengths", 1.0, 10_000.0);
/// Range of `alpha`, the rate of false alarms of a cut value.
pub const ALPHA: Range = Range::of("alpha").above(0.0).below(0.5);
/// Range of `max_components`, the largest number of components of the mixture that is tried.
pub const MAX_COMPONENTS: Range = Range::within("max_components", 2.0, 20.0);

/// Significance level of the two-sample test.
const LEVEL: f64 = 0.05;

/// Refuses lists that are empty, not ascending, or longer than 64.
pub fn check_ascending<T: PartialOrd + std::fmt::Debug>(
    key: &'static str,
    list: &[T],
) -> Result<(), ParamError> {
    let is_fine = (1..=64).contains(&list.len()) && list.windows(2).all(|w| w[0] < w[1]);
    ParamError::unless(is_fine, key, "ascending numbers, at most 64", format!("{list:?}"))
}

/// Values in ascending order.
pub fn ascending(values: impl Iterator<Item = f64>) -> Vec<f64> {
    let mut values: Vec<f64> = values.collect();
    values.sort_by(f64::total_cmp);
    values
}

/// Values of c_t in the consistent frames of a suite, ascending.
pub fn changes(population: &Population<'_>, tau: f64) -> Vec<f64> {
    ascending(population.tracks.iter().flat_map(|t| consistent_changes(t, tau)))
}

/// Names of the first columns of [`two_sample_test`]. The columns of the two sample sizes follow.
pub const TEST: [&str; 3] = ["distance", "critical at 5 %", "p"];

/// Two-sample Kolmogorov-Smirnov test of ascending samples: distance, critical value, p, and the sizes of
/// both samples.
pub fn two_sample_test(a: &[f64], b: &[f64]) -> [Option<f64>; 5] {
    if a.is_empty() || b.is_empty() {
        return [None; 5];
    }
    let distance = kolmogorov::two_samples(a, b);
    let size = kolmogorov::effective_size(a.len(), b.len());
    let (critical, p) = (kolmogorov::critical(LEVEL, size), kolmogorov::p_value(distance, size));
    [distance, critical, p, a.len() as f64, b.len() as f64].map(Some)
}
