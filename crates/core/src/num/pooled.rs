//! Statistics of summed counts over several units, such as F over sequences: how far can they be trusted, and
//! do two of them differ by more than chance?
//!
//! ```text
//! c_i        the counts of unit i = 1..n          theta = s(sum_i c_i), the pooled statistic
//! interval   quantiles of s(sum_i c*_i), where c*_1..n are n draws of units with replacement (percentile method)
//! test       T = s(sum_i a_i) - s(sum_i b_i) of two paired lists; under the hypothesis that it does not matter
//!            which of the two made a_i, every exchange of a_i and b_i is as likely as none
//! p          share of the 2^n patterns of exchanges with |T*| >= |T|, or (k + 1) / (draws + 1), where k of so
//!            many random patterns reach |T|
//! ```
//!
//! Units are what is drawn independently: sequences, with all their frames and runs. The statistic is computed
//! again from summed counts every time; a mean of the units' own ratios would be another quantity. A statistic
//! without a value for some draw (0 / 0) is left out of the interval, which has no bounds when that happens to
//! more than half of the draws, and counts as a reached |T| in the test, which can only raise p.
//!
//! With few units the percentile interval is too narrow; nothing corrects this.
//!
//! Sources: Efron, Tibshirani, An Introduction to the Bootstrap, 1993, sections 13.3 and 15.2; Phipson, Smyth,
//! Statistical Applications in Genetics and Molecular Biology 9(1), 2010, for (k + 1) / (draws + 1).

mod draws;

use super::seed;
pub use draws::{Draws, percentiles};
use rand::Rng;
use statrs::distribution::{ContinuousCDF, Normal};

/// Number of draws in tables and figures, and of random patterns in tests with too many patterns to try all.
/// Shares then have a standard error of at most 0.0071.
pub const SAMPLES: usize = 5000;
/// Fewest units for which an interval is computed.
pub const MIN_UNITS: usize = 3;
/// Level of the intervals.
pub const LEVEL: f64 = 0.95;

/// Largest number of differing pairs for which all patterns are counted (half of them, since the others
/// mirror them).
pub const EXACT_UP_TO: usize = 16;

/// Differences of statistics up to this size count as equal, being the same ratio of different counts.
const EQUAL: f64 = 1e-12;

/// Bounds at another level of a value whose bounds at [`LEVEL`] are known, as if it were normal on each side.
pub fn at_level(value: f64, (low, high): (f64, f64), level: f64) -> (f64, f64) {
    let quantile = |level: f64| Normal::standard().inverse_cdf((1.0 + level) / 2.0);
    let wider = quantile(level) / quantile(LEVEL);
    (value - wider * (value - low), value + wider * (high - value))
}

fn sum<const N: usize>(units: &[[i64; N]]) -> [i64; N] {
    let mut total = [0; N];
    units.iter().for_each(|unit| add(&mut total, unit));
    total
}

fn add<const N: usize>(total: &mut [i64; N], unit: &[i64; N]) {
    total.iter_mut().zip(unit).for_each(|(t, u)| *t += u);
}

/// Result of a permutation test.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Permuted {
    /// Difference of the pooled statistics, first minus second.
    pub difference: f64,
    /// Two-sided p-value.
    pub p: f64,
    /// True if all patterns were counted.
    pub is_exact: bool,
}

/// Tests if the pooled statistics of two paired lists differ; `None` if one of them has no value.
pub fn permutation<const N: usize>(
    pairs: &[([i64; N], [i64; N])],
    statistic: impl Fn(&[i64; N]) -> Option<f64>,
    draws: usize,
    seed: u64,
) -> Option<Permuted> {
    let (firsts, seconds): (Vec<_>, Vec<_>) = pairs.iter().copied().unzip();
    let (first, second) = (sum(&firsts), sum(&seconds));
    let of = |a: &[i64; N], b: &[i64; N]| Some(statistic(a)? - statistic(b)?);
    let difference = of(&first, &second).filter(|d| !d.is_nan())?;
    let reaches = |moved: &[i64; N]| {
        let (mut a, mut b) = (first, second);
        for ((a, b), m) in a.iter_mut().zip(&mut b).zip(moved) {
            *a -= m;
            *b += m;
        }
        of(&a, &b).is_none_or(|d| d.is_nan() || d.abs() >= difference.abs() - EQUAL)
    };
    // Exchanging equal counts changes nothing.
    let steps: Vec<[i64; N]> =
        pairs.iter().filter(|(a, b)| a != b).map(|(a, b)| std::array::from_fn(|k| a[k] - b[k])).collect();
    if steps.len() <= EXACT_UP_TO {
        return Some(Permuted { difference, p: share_of_all(&steps, reaches), is_exact: true });
    }
    let mut rng = seed::rng(seed::seed(seed, &["permutation"]));
    let mut reached = 0;
    for _ in 0..draws {
        let mut moved = [0; N];
        for steps in steps.chunks(64) {
            let bits = rng.next_u64();
            for (k, step) in steps.iter().enumerate() {
                // All ones where this pair is exchanged.
                let mask = -((bits >> k & 1) as i64);
                moved.iter_mut().zip(step).for_each(|(m, s)| *m += s & mask);
            }
        }
        reached += usize::from(reaches(&moved));
    }
    Some(Permuted { difference, p: (reached + 1) as f64 / (draws + 1) as f64, is_exact: false })
}

/// Share of patterns that reach the difference. The last pair is never exchanged, since exchanging all pairs
/// only changes the sign. Patterns are in Gray code order, so that neighbors differ in one pair.
fn share_of_all<const N: usize>(steps: &[[i64; N]], reaches: impl Fn(&[i64; N]) -> bool) -> f64 {
    let free = steps.len().saturating_sub(1);
    let (mut moved, mut is_moved) = ([0; N], vec![false; free]);
    let mut reached = usize::from(reaches(&moved));
    for pattern in 1..1_usize << free {
        let k = pattern.trailing_zeros() as usize;
        let sign = if is_moved[k] { -1 } else { 1 };
        is_moved[k] = !is_moved[k];
        moved.iter_mut().zip(&steps[k]).for_each(|(m, s)| *m += sign * s);
        reached += usize::from(reaches(&moved));
    }
    reached as f64 / (1_usize << free) as f64
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// F from true positives, false positives and false negatives.
    fn f(c: &[i64; 3]) -> Option<f64> {
        let below = 2 * c[0] + c[1] + c[2];
        (below > 0).then(|| (2 * c[0]) as f64 / below as f64)
    }

    const A: [[i64; 3]; 8] =
        [[3, 1, 0], [0, 4, 2], [5, 2, 1], [1, 1, 3], [2, 0, 0], [4, 3, 1], [1, 5, 2], [2, 2, 2]];
    const B: [[i64; 3]; 8] =
        [[2, 2, 1], [0, 0, 2], [4, 4, 2], [1, 1, 3], [1, 3, 1], [2, 1, 3], [0, 6, 3], [1, 0, 3]];

    fn pairs() -> Vec<([i64; 3], [i64; 3])> {
        A.into_iter().zip(B).collect()
    }

    fn interval(units: &[[i64; 3]], level: f64, samples: usize, seed: u64) -> Option<(f64, f64)> {
        Draws::new(units.len(), samples, seed).interval(units, f, level)
    }

    // SciPy 1.17.1, AB = numpy.array(A + B): f = lambda x: 2*s[0]/(2*s[0]+s[1]+s[2]) with s = AB[x].sum(0);
    // scipy.stats.permutation_test((arange(8), arange(8, 16)), lambda x, y: f(x) - f(y),
    //     permutation_type="samples", n_resamples=inf, vectorized=False)
    #[test]
    fn the_exact_test_agrees_with_scipy() {
        let tested = permutation(&pairs(), f, 0, 1).unwrap();
        assert!((tested.difference - 0.16788124156545214).abs() < 1e-15);
        assert_eq!((tested.p, tested.is_exact), (0.046875, true));
    }

    // Three copies of the units are 21 pairs that differ, too many to look at all patterns. The exact share by
    // Python: the sum over c in itertools.product(range(4), repeat=7) of prod(math.comb(3, x) for x in c), where
    // c tells how many copies of each pair are exchanged, over those that reach |T|; divided by 2**21.
    #[test]
    fn random_patterns_estimate_the_share() {
        let many: Vec<_> = (0..3).flat_map(|_| pairs()).collect();
        let tested = permutation(&many, f, 100_000, 5).unwrap();
        assert!(!tested.is_exact);
        let error = (TRIPLED * (1.0 - TRIPLED) / 100_000.0_f64).sqrt();
        assert!((tested.p - TRIPLED).abs() < 4.0 * error, "{}", tested.p);
        assert_eq!(permutation(&many, f, 100_000, 5), Some(tested));
    }
    const TRIPLED: f64 = 0.0009784698486328125;

    // scipy.stats.bootstrap((arange(8),), f, method="percentile", n_resamples=200000, rng=1): .34483 to .72727.
    #[test]
    fn the_interval_agrees_with_scipy() {
        let (low, high) = interval(&A, 0.95, 30_000, 3).unwrap();
        assert!((low - 0.3448).abs() < 0.006 && (high - 0.7273).abs() < 0.006, "{low} {high}");
        assert_eq!(interval(&A, 0.95, 30_000, 3), Some((low, high)));
    }

    // By hand: of two units, F is 1 with the first twice, 2/3 with both and 0 with the second twice, at 1 : 2 : 1.
    // The mean of the units' F would be 1/2 in the middle case.
    #[test]
    fn counts_are_pooled_before_the_ratio() {
        let units = [[2, 0, 0], [0, 1, 1]];
        assert_eq!(interval(&units, 0.4, 1000, 1), Some((2.0 / 3.0, 2.0 / 3.0)));
        assert_eq!(interval(&units, 0.6, 1000, 1), Some((0.0, 1.0)));
    }

    #[test]
    fn without_units_there_is_no_interval_and_no_test() {
        assert_eq!(interval(&[], 0.95, 10, 1), None);
        assert_eq!(interval(&[[0, 0, 0]; 5], 0.95, 10, 1), None);
        assert_eq!(permutation(&[([0, 0, 0], [1, 0, 0])], f, 10, 1), None);
        let of_none = permutation::<3>(&[], |_| Some(0.5), 10, 1).unwrap();
        assert_eq!((of_none.difference, of_none.p), (0.0, 1.0));
    }

    fn counts() -> impl Strategy<Value = [i64; 3]> {
        [0..6_i64, 0..6_i64, 0..6_i64]
    }

    proptest! {
        #[test]
        fn all_patterns_are_counted(pairs in prop::collection::vec((counts(), counts()), 1..9)) {
            let Some(tested) = permutation(&pairs, f, 0, 1) else { return Ok(()) };
            let reached = (0..1_u32 << pairs.len()).filter(|pattern| {
                let (mut a, mut b) = ([0; 3], [0; 3]);
                for (k, (x, y)) in pairs.iter().enumerate() {
                    let (x, y) = if pattern >> k & 1 == 1 { (y, x) } else { (x, y) };
                    add(&mut a, x);
                    add(&mut b, y);
                }
                f(&a).zip(f(&b)).is_none_or(|(a, b)| (a - b).abs() >= tested.difference.abs() - EQUAL)
            });
            prop_assert_eq!(tested.p, reached.count() as f64 / f64::from(1_u32 << pairs.len()));
        }

        #[test]
        fn exchanging_the_two_turns_the_sign(
            pairs in prop::collection::vec((counts(), counts()), 1..30), seed in any::<u64>(),
        ) {
            let turned: Vec<_> = pairs.iter().map(|(a, b)| (*b, *a)).collect();
            let (one, other) = (permutation(&pairs, f, 50, seed), permutation(&turned, f, 50, seed));
            prop_assert_eq!(one.map(|t| t.p), other.map(|t| t.p));
            prop_assert_eq!(one.map(|t| t.difference), other.map(|t| -t.difference));
        }
    }
}
