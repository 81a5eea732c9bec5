//! Two methods on the same sequences: how large is the difference, and can it be chance?
//!
//! ```text
//! d_i = a_i - b_i,  i = 1..n           one pair per sequence
//! interval: quantiles of mean(d*) over bootstrap samples d*, n draws of d with replacement (percentile method)
//! W+ = sum of the ranks of |d_i| over d_i > 0; zeros are left out, ties share their mean rank (Wilcoxon 1945)
//! p  = 2 min(P(W+ <= w), P(W+ >= w)), at most 1, when every sign is as likely as the other
//! ```
//!
//! Up to [`EXACT_UP_TO`] differences p is exact, ties included, by counting the sums of all 2^n sign patterns;
//! above, W+ is taken as normal with the variance corrected for ties. The test asks whether differences lie
//! symmetrically around 0; it does not tell how large they are.
//!
//! Sources: Efron, Tibshirani, An Introduction to the Bootstrap, 1993, section 13.3; Wilcoxon, Biometrics
//! Bulletin 1(6), 1945. Where there are no ties p is that of `scipy.stats.wilcoxon`.

use super::ranks::{ranks, sum_of_ties};
use super::seed;
use rand::RngExt;
use statrs::distribution::{ContinuousCDF, Normal};

/// Largest number of nonzero differences for which p is exact.
pub const EXACT_UP_TO: usize = 200;

/// Mean of the values; NaN without any.
fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}

/// Confidence interval of the mean at `level`, from `samples` bootstrap samples; `None` without values.
///
/// `level` is in (0, 1); the same seed gives the same bounds.
pub fn bootstrap_interval(differences: &[f64], level: f64, samples: usize, seed: u64) -> Option<(f64, f64)> {
    if differences.is_empty() || samples == 0 {
        return None;
    }
    let mut rng = seed::rng(seed::seed(seed, &["bootstrap"]));
    let n = differences.len();
    let draw = |_| (0..n).map(|_| differences[rng.random_range(0..n)]).sum::<f64>() / n as f64;
    let mut means: Vec<f64> = (0..samples).map(draw).collect();
    means.sort_by(f64::total_cmp);
    Some((quantile(&means, (1.0 - level) / 2.0), quantile(&means, (1.0 + level) / 2.0)))
}

/// The `q` quantile (in [0, 1]) of at least one ascending value, interpolated linearly.
pub fn quantile(sorted: &[f64], q: f64) -> f64 {
    let place = q * (sorted.len() - 1) as f64;
    let (low, part) = (place.floor() as usize, place.fract());
    sorted[low] + part * (sorted[(low + 1).min(sorted.len() - 1)] - sorted[low])
}

/// Ranks from 1 of the absolute nonzero differences, with ties sharing their mean rank, and true for a
/// positive difference.
fn signed_ranks(differences: &[f64]) -> Vec<(f64, bool)> {
    let mut sizes: Vec<(f64, bool)> =
        differences.iter().filter(|d| **d != 0.0).map(|d| (d.abs(), *d > 0.0)).collect();
    sizes.sort_by(|a, b| a.0.total_cmp(&b.0));
    let ranks = ranks(&sizes.iter().map(|s| s.0).collect::<Vec<_>>(), false);
    ranks.into_iter().zip(sizes).map(|(rank, (_, positive))| (rank, positive)).collect()
}

/// Two-sided p-value of Wilcoxon's signed-rank test; `None` if all differences are 0.
pub fn wilcoxon(differences: &[f64]) -> Option<f64> {
    let ranks = signed_ranks(differences);
    if ranks.is_empty() {
        return None;
    }
    let w: f64 = ranks.iter().filter(|r| r.1).map(|r| r.0).sum();
    let p = if ranks.len() <= EXACT_UP_TO { exact(&ranks, w) } else { normal(&ranks, w) };
    Some(p.min(1.0))
}

/// Exact p, by the share of sign patterns with each sum. Mean ranks are integers when doubled.
fn exact(ranks: &[(f64, bool)], w: f64) -> f64 {
    let doubled: Vec<usize> = ranks.iter().map(|r| (2.0 * r.0) as usize).collect();
    let mut share = vec![0.0; doubled.iter().sum::<usize>() + 1];
    share[0] = 1.0;
    let mut reach = 0;
    for rank in doubled {
        reach += rank;
        for sum in (0..=reach).rev() {
            let with = if sum >= rank { share[sum - rank] } else { 0.0 };
            share[sum] = (share[sum] + with) / 2.0;
        }
    }
    let at = (2.0 * w) as usize;
    2.0 * share[..=at].iter().sum::<f64>().min(share[at..].iter().sum())
}

fn normal(ranks: &[(f64, bool)], w: f64) -> f64 {
    let n = ranks.len() as f64;
    let ties = sum_of_ties(&ranks.iter().map(|r| r.0).collect::<Vec<_>>());
    let variance = n * (n + 1.0) * (2.0 * n + 1.0) / 24.0 - ties / 48.0;
    let z = (w - n * (n + 1.0) / 4.0) / variance.sqrt();
    2.0 * Normal::standard().cdf(-z.abs())
}

/// Comparison of two paired lists.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Compared {
    /// Number of pairs.
    pub pairs: usize,
    /// Mean of each list.
    pub means: (f64, f64),
    /// Mean difference, first minus second.
    pub difference: f64,
    /// Bootstrap interval of the mean difference.
    pub interval: (f64, f64),
    /// Numbers of pairs with a positive, a zero and a negative difference.
    pub signs: (usize, usize, usize),
    /// p-value of Wilcoxon's test; `None` if all differences are 0.
    pub p: Option<f64>,
}

/// The differences with ties that rounding hides: of .6 - .4 and .4 - .2, computed, the first is smaller. Those that lie
/// within 1e-12 of the largest value `size` become equal, or 0.
fn with_ties(differences: &[f64], size: f64) -> Vec<f64> {
    let mut order: Vec<usize> = (0..differences.len()).collect();
    order.sort_by(|a, b| differences[*a].abs().total_cmp(&differences[*b].abs()));
    let (mut tied, mut last) = (differences.to_vec(), 0.0);
    for k in order {
        let own = differences[k].abs();
        last = if own - last <= 1e-12 * size { last } else { own };
        tied[k] = f64::copysign(last, differences[k]);
    }
    tied
}

/// Compares the two values of each pair; `None` without pairs. Differences that are equal but for rounding are
/// ties. `level` and `samples` are those of [`bootstrap_interval`].
pub fn compare(pairs: &[(f64, f64)], level: f64, samples: usize, seed: u64) -> Option<Compared> {
    let differences: Vec<f64> = pairs.iter().map(|(a, b)| a - b).collect();
    let interval = bootstrap_interval(&differences, level, samples, seed)?;
    let sizes = pairs.iter().flat_map(|(a, b)| [a.abs(), b.abs()]).filter(|size| size.is_finite());
    let tied = with_ties(&differences, sizes.fold(0.0, f64::max));
    let mean_of = |of: fn(&(f64, f64)) -> f64| mean(&pairs.iter().map(of).collect::<Vec<_>>());
    let count = |of: fn(&f64) -> bool| tied.iter().filter(|d| of(d)).count();
    Some(Compared {
        pairs: pairs.len(),
        means: (mean_of(|pair| pair.0), mean_of(|pair| pair.1)),
        difference: mean(&differences),
        interval,
        signs: (count(|d| *d > 0.0), count(|d| *d == 0.0), count(|d| *d < 0.0)),
        p: wilcoxon(&tied),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    // SciPy 1.17.1: scipy.stats.wilcoxon(d, method="exact").pvalue; without ties.
    #[test]
    fn agrees_with_scipy_without_ties() {
        let d = [0.12, -0.30, 0.45, 0.07, 0.51, -0.02, 0.33, 0.21];
        assert_eq!(wilcoxon(&d), Some(0.109375));
        let p = wilcoxon(&SIXTY).unwrap();
        assert!((p - 0.4061290646945823).abs() < 1e-12, "{p}");
        // method="approx", correction=False
        let ranks = signed_ranks(&SIXTY);
        let w = ranks.iter().filter(|r| r.1).map(|r| r.0).sum();
        assert!((normal(&ranks, w) - 0.4013443276092331).abs() < 1e-9);
    }
    const SIXTY: [f64; 60] = [
        2.141, -2.456, 0.518, -0.468, -0.353, -0.116, -1.92, -0.132, -0.765, 3.423, 0.326, -0.253, -0.181,
        -0.568, -0.955, -0.291, 0.582, -0.139, 1.058, -0.1, 0.124, 1.646, 0.645, -0.405, -0.083, 0.641,
        2.035, -0.17, -0.144, 1.102, -0.786, -0.192, 0.983, 0.68, 0.193, 0.77, -2.728, 1.121, -0.86, -1.569,
        0.376, 0.801, -0.345, -0.976, 0.126, 0.047, 1.506, 0.847, 0.294, 1.212, -0.106, -0.826, 0.684, 0.683,
        -0.115, -0.681, 0.329, -2.394, 0.79, 0.591,
    ];

    #[test]
    fn empty_lists_and_zero_differences() {
        assert_eq!(wilcoxon(&[0.0, 0.0]), None);
        assert_eq!(compare(&[], 0.95, 100, 1), None);
        let same = compare(&[(0.5, 0.5), (0.2, 0.2)], 0.95, 100, 1).unwrap();
        assert_eq!((same.difference, same.interval, same.signs, same.p), (0.0, (0.0, 0.0), (0, 2, 0), None));
    }

    // In thirds and tenths equal differences are not the same number; the p is that of whole numbers.
    #[test]
    fn differences_that_rounding_parts_are_ties() {
        let whole = [(4, 5), (4, 7), (0, 2), (0, 6), (1, 8), (0, 4), (7, 5), (3, 3)];
        let compared = |unit: f64| {
            let pairs = whole.map(|(a, b)| (f64::from(a) / unit, f64::from(b) / unit));
            compare(&pairs, 0.95, 10, 1).unwrap()
        };
        // python3: itertools.product over the signs of the seven differences; W+ of mean ranks is 2.5 or less in 4 of 128.
        assert_eq!((compared(1.0).p, compared(1.0).signs), (Some(0.0625), (1, 1, 6)));
        for unit in [3.0, 10.0, 7.0, 0.3] {
            assert_eq!((compared(unit).p, compared(unit).signs), (Some(0.0625), (1, 1, 6)), "{unit}");
        }
    }

    // The mean of 400 values of variance 1 has a deviation of .05; 95 % lie within 1.96 of it.
    #[test]
    fn the_interval_is_as_wide_as_the_normal_one() {
        let d: Vec<f64> = (0..400).map(|i| if i % 2 == 0 { 1.3 } else { -0.7 }).collect();
        let (low, high) = bootstrap_interval(&d, 0.95, 20_000, 7).unwrap();
        assert!((low - (0.3 - 0.098)).abs() < 0.004 && (high - (0.3 + 0.098)).abs() < 0.004, "{low} {high}");
        assert_eq!(bootstrap_interval(&d, 0.95, 20_000, 7), Some((low, high)));
    }

    proptest! {
        #[test]
        fn the_exact_test_counts_sign_patterns(
            d in prop::collection::vec((-4..5_i32).prop_map(f64::from), 1..11),
        ) {
            let ranks = signed_ranks(&d);
            let n = ranks.len();
            let sum = |signs: u32| (0..n).filter(|k| signs >> k & 1 == 1).map(|k| ranks[k].0).sum::<f64>();
            let w: f64 = ranks.iter().filter(|r| r.1).map(|r| r.0).sum();
            let share = |of: &dyn Fn(f64) -> bool| {
                (0..1_u32 << n).filter(|s| of(sum(*s))).count() as f64 / f64::from(1_u32 << n)
            };
            let expected = (2.0 * share(&|s| s <= w).min(share(&|s| s >= w))).min(1.0);
            match wilcoxon(&d) {
                None => prop_assert_eq!(n, 0),
                Some(p) => prop_assert!((p - expected).abs() < 1e-12, "{} {}", p, expected),
            }
        }

        #[test]
        fn exchanging_the_two_mirrors_everything(
            pairs in prop::collection::vec((0.0..1.0, 0.0..1.0), 1..40),
        ) {
            let other: Vec<(f64, f64)> = pairs.iter().map(|(a, b)| (*b, *a)).collect();
            let (one, other) = (compare(&pairs, 0.9, 50, 3).unwrap(), compare(&other, 0.9, 50, 3).unwrap());
            prop_assert!((one.difference + other.difference).abs() < 1e-12);
            prop_assert!((one.interval.0 + other.interval.1).abs() < 1e-12);
            prop_assert!((one.p.unwrap_or(1.0) - other.p.unwrap_or(1.0)).abs() < 1e-12);
            prop_assert_eq!((one.signs.0, one.signs.2), (other.signs.2, other.signs.0));
        }
    }
}
