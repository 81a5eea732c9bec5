//! Bootstrap samples, drawn once for all lists of counts over the same units.

use crate::num::seed;
use rand::RngExt;
use std::ops::AddAssign;

/// Bootstrap samples of a number of units.
pub struct Draws {
    units: usize,
    /// Units of each sample, one sample after the other.
    picks: Vec<u32>,
    samples: usize,
}

impl Draws {
    /// Draws `samples` samples, each of as many units as there are.
    pub fn new(units: usize, samples: usize, seed: u64) -> Self {
        let mut rng = seed::rng(seed::seed(seed, &["pooled bootstrap"]));
        let all = units * samples;
        Self { units, picks: (0..all).map(|_| rng.random_range(0..units) as u32).collect(), samples }
    }

    /// Confidence interval at `level` in (0, 1) of a statistic of summed counts; `None` without units or
    /// samples, or if the statistic lacks a value for more than half of them.
    pub fn interval<const N: usize>(
        &self,
        counts: &[[i64; N]],
        statistic: impl Fn(&[i64; N]) -> Option<f64>,
        level: f64,
    ) -> Option<(f64, f64)> {
        percentiles(self.values(counts, statistic)?, self.samples, level)
    }

    /// Statistic of the summed counts of each sample, NaN if it has no value; `None` without units or
    /// samples.
    pub fn values<const N: usize>(
        &self,
        counts: &[[i64; N]],
        statistic: impl Fn(&[i64; N]) -> Option<f64>,
    ) -> Option<Vec<f64>> {
        if self.picks.is_empty() || counts.len() != self.units {
            return None;
        }
        // Half as wide where the sums of all samples fit.
        let most = i32::MAX as u64 / self.units as u64;
        let fits = counts.iter().flatten().all(|c| c.unsigned_abs() <= most);
        let mut values = Vec::with_capacity(self.samples);
        let mut take = |sum: &[i64; N]| values.push(statistic(sum).unwrap_or(f64::NAN));
        if fits {
            let narrow: Vec<[i32; N]> = counts.iter().map(|unit| unit.map(|c| c as i32)).collect();
            self.sums(&narrow, |sum| take(&sum.map(i64::from)));
        } else {
            self.sums(counts, take);
        }
        Some(values)
    }

    /// Passes the sum of each sample to `take`.
    fn sums<T: Copy + Default + AddAssign, const N: usize>(
        &self,
        counts: &[[T; N]],
        mut take: impl FnMut(&[T; N]),
    ) {
        for sample in self.picks.chunks_exact(self.units) {
            let mut sum = [T::default(); N];
            for unit in sample {
                sum.iter_mut().zip(&counts[*unit as usize]).for_each(|(s, c)| *s += *c);
            }
            take(&sum);
        }
    }
}

/// Percentile interval at `level` of the values of `samples` samples; NaN is a sample without a value. `None`
/// if fewer than half have one.
pub fn percentiles(mut values: Vec<f64>, samples: usize, level: f64) -> Option<(f64, f64)> {
    values.retain(|v| !v.is_nan());
    if values.is_empty() || 2 * values.len() < samples {
        return None;
    }
    Some((quantile(&mut values, (1.0 - level) / 2.0), quantile(&mut values, (1.0 + level) / 2.0)))
}

/// The `q` quantile (in [0, 1]) of at least one value, in any order, interpolated linearly.
fn quantile(values: &mut [f64], q: f64) -> f64 {
    let place = q * (values.len() - 1) as f64;
    let (low, part) = (place.floor() as usize, place.fract());
    let (_, &mut below, above) = values.select_nth_unstable_by(low, f64::total_cmp);
    let above = above.iter().copied().min_by(f64::total_cmp).unwrap_or(below);
    below + part * (above - below)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn ratio(c: &[i64; 3]) -> Option<f64> {
        (c[1] + c[2] != 0).then(|| c[0] as f64 / (c[1] + c[2]) as f64)
    }

    /// Interval by its definition: sums in `i64` of units drawn one by one, sorted values.
    fn by_definition(counts: &[[i64; 3]], samples: usize, seed: u64) -> Option<(f64, f64)> {
        let mut rng = seed::rng(seed::seed(seed, &["pooled bootstrap"]));
        let value = |_| {
            let drawn: Vec<_> =
                (0..counts.len()).map(|_| counts[rng.random_range(0..counts.len())]).collect();
            ratio(&std::array::from_fn(|k| drawn.iter().map(|c| c[k]).sum()))
        };
        let mut values: Vec<f64> = (0..samples).filter_map(value).collect();
        values.sort_by(f64::total_cmp);
        let at = |q| crate::num::paired::quantile(&values, q);
        (samples > 0 && 2 * values.len() >= samples).then(|| (at((1.0 - 0.9) / 2.0), at((1.0 + 0.9) / 2.0)))
    }

    proptest! {
        #[test]
        fn intervals_are_those_of_drawing_for_each_list(
            counts in prop::collection::vec([0..9_i64, 0..4_i64, 0..3_i64], 1..40),
            factor in prop::sample::select(vec![1_i64, 1 << 20, 1 << 40]),
            samples in 0..400_usize, seed in any::<u64>(),
        ) {
            let counts: Vec<[i64; 3]> = counts.iter().map(|c| c.map(|c| c * factor)).collect();
            let shared = Draws::new(counts.len(), samples, seed).interval(&counts, ratio, 0.9);
            let bits = |bounds: Option<(f64, f64)>| bounds.map(|(a, b)| (a.to_bits(), b.to_bits()));
            prop_assert_eq!(bits(shared), bits(by_definition(&counts, samples, seed)));
        }
    }
}
