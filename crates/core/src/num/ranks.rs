//! Comparison of several methods on the same blocks (sequences): do their ranks differ, and which of them?
//!
//! ```text
//! r_ij       rank of method j = 1..k in block i = 1..n, 1 the best, ties share their mean rank
//! R_j        mean over i of r_ij
//! Friedman   chi2 = 12 n / (k (k + 1)) (sum_j R_j^2 - k (k + 1)^2 / 4) / c,   k - 1 degrees of freedom
//!            c = 1 - sum over groups of t ties of (t^3 - t) / (n (k^3 - k))
//! Nemenyi    two mean ranks differ when they are CD = q / sqrt(2) sqrt(k (k + 1) / (6 n)) or more apart, where q
//!            is the quantile of the studentized range of k normal variables at infinite degrees of freedom
//! Holm       p of rank i among m in ascending order becomes max over j <= i of min(1, (m - j + 1) p_(j))
//! ```
//!
//! The chi-squared distribution is accurate from about n = 10 or k = 5 on. Ranks ignore how large differences are.
//!
//! Sources: Demsar, Journal of Machine Learning Research 7, 2006, section 3.2 (Friedman, Nemenyi, Eq. of CD);
//! Holm, Scandinavian Journal of Statistics 6, 1979. Values are those of `scipy.stats.friedmanchisquare`,
//! `scipy.stats.studentized_range` and statsmodels' `multipletests(method="holm")`.

use statrs::distribution::{ChiSquared, Continuous, ContinuousCDF, Normal};

/// Ranks from 1 on, with the largest value first (the smallest unless `larger_is_better`). Ties share their
/// mean rank.
pub fn ranks(values: &[f64], larger_is_better: bool) -> Vec<f64> {
    let sign = if larger_is_better { -1.0 } else { 1.0 };
    let mut order: Vec<usize> = (0..values.len()).collect();
    order.sort_by(|a, b| (sign * values[*a]).total_cmp(&(sign * values[*b])));
    let mut ranks = vec![0.0; values.len()];
    let mut before = 0;
    for tied in order.chunk_by(|a, b| values[*a] == values[*b]) {
        tied.iter().for_each(|k| ranks[*k] = before as f64 + (tied.len() + 1) as f64 / 2.0);
        before += tied.len();
    }
    ranks
}

/// Sum of t^3 - t over groups of t ties, in sorted ranks.
pub(super) fn sum_of_ties(sorted: &[f64]) -> f64 {
    sorted.chunk_by(|a, b| a == b).map(|g| (g.len() as f64).powi(3) - g.len() as f64).sum()
}

/// Result of Friedman's test.
#[derive(Debug, Clone, PartialEq)]
pub struct Friedman {
    /// Mean rank of each method, 1 the best.
    pub mean_ranks: Vec<f64>,
    /// Number of blocks.
    pub blocks: usize,
    /// The statistic and its p-value; `None` if all values of every block are tied.
    pub test: Option<(f64, f64)>,
}

/// Ranks the methods in each block; `blocks[i][j]` is the value of method j in block i.
///
/// `None` without a block, with fewer than two methods, or if blocks differ in length.
pub fn friedman(blocks: &[Vec<f64>], larger_is_better: bool) -> Option<Friedman> {
    let (n, k) = (blocks.len(), blocks.first()?.len());
    if k < 2 || blocks.iter().any(|b| b.len() != k) {
        return None;
    }
    let mut sums = vec![0.0; k];
    let mut ties = 0.0;
    for block in blocks {
        let ranks = ranks(block, larger_is_better);
        sums.iter_mut().zip(&ranks).for_each(|(sum, rank)| *sum += rank);
        let mut sorted = ranks;
        sorted.sort_by(f64::total_cmp);
        ties += sum_of_ties(&sorted);
    }
    let mean_ranks: Vec<f64> = sums.iter().map(|sum| sum / n as f64).collect();
    let (methods, blocks) = (k as f64, n as f64);
    let correction = 1.0 - ties / (blocks * (methods.powi(3) - methods));
    let squares = mean_ranks.iter().map(|r| r * r).sum::<f64>();
    let spread = squares - methods * (methods + 1.0).powi(2) / 4.0;
    // Ranks are multiples of 1/2: unless all values are tied, this is much larger.
    let statistic = (correction > 1e-9)
        .then(|| (12.0 * blocks / (methods * (methods + 1.0)) * spread / correction).max(0.0));
    let test = statistic.zip(ChiSquared::new(methods - 1.0).ok()).map(|(s, chi)| (s, chi.sf(s)));
    Some(Friedman { mean_ranks, blocks: n, test })
}

/// Probability that k standard normal variables lie within `q` of each other (the studentized range at
/// infinite degrees of freedom): k times the integral of phi(z) (Phi(z + q) - Phi(z))^(k - 1) over z, where z
/// is the smallest of them.
fn range_cdf(q: f64, k: usize) -> f64 {
    // The integrand is analytic and vanishes at both ends, where the trapezium rule converges geometrically.
    const STEP: f64 = 0.05;
    const ENDS: i32 = 200;
    let normal = Normal::standard();
    let at = |z: f64| normal.pdf(z) * (normal.cdf(z + q) - normal.cdf(z)).powi(k as i32 - 1);
    k as f64 * STEP * (-ENDS..=ENDS).map(|i| at(f64::from(i) * STEP)).sum::<f64>()
}

/// The `level` quantile of the studentized range of `k` means at infinite degrees of freedom; `None` unless 2
/// <= k <= 1000 and 0 < level < 1.
pub fn studentized_range(level: f64, k: usize) -> Option<f64> {
    let is_level = level > 0.0 && level < 1.0;
    if !(2..=1000).contains(&k) || !is_level {
        return None;
    }
    let (mut low, mut high) = (0.0, 20.0);
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if range_cdf(middle, k) < level { low = middle } else { high = middle }
    }
    Some(0.5 * (low + high))
}

/// Nemenyi's critical difference of the mean ranks of `k` methods over `n` blocks, at significance 1 - `level`.
pub fn critical_difference(level: f64, k: usize, n: usize) -> Option<f64> {
    let q = studentized_range(level, k).filter(|_| n > 0)?;
    let (k, n) = (k as f64, n as f64);
    Some(q / std::f64::consts::SQRT_2 * (k * (k + 1.0) / (6.0 * n)).sqrt())
}

/// Holm's adjusted p-values, in the order given.
pub fn holm(p: &[f64]) -> Vec<f64> {
    let mut order: Vec<usize> = (0..p.len()).collect();
    order.sort_by(|a, b| p[*a].total_cmp(&p[*b]));
    let mut adjusted = vec![0.0; p.len()];
    let mut largest = 0.0_f64;
    for (before, k) in order.into_iter().enumerate() {
        largest = largest.max(((p.len() - before) as f64 * p[k]).min(1.0));
        adjusted[k] = largest;
    }
    adjusted
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use trackfail_testing::assert_near;

    // SciPy 1.17.1: r = numpy.array(BLOCKS); scipy.stats.friedmanchisquare(*r.T);
    // numpy.mean([scipy.stats.rankdata(-x) for x in r], axis=0)
    #[test]
    fn friedman_is_scipys_with_ties() {
        let blocks: Vec<Vec<f64>> = BLOCKS.iter().map(|b| b.to_vec()).collect();
        let found = friedman(&blocks, true).unwrap();
        let expected = [1.4166666666666667, 2.0, 2.5833333333333335];
        assert_near(&found.mean_ranks, expected, 1e-9, "");
        let (statistic, p) = found.test.unwrap();
        assert_near([statistic, p], [5.444444444444438, 0.06572852861653068], 1e-9, "");
        let turned = friedman(&blocks, false).unwrap();
        assert_near(turned.mean_ranks, expected.map(|rank| 4.0 - rank), 1e-9, "");
    }
    const BLOCKS: [[f64; 3]; 6] =
        [[0.9, 0.5, 0.4], [0.7, 0.7, 0.2], [0.8, 0.6, 0.6], [0.3, 0.4, 0.1], [0.9; 3], [0.6, 0.2, 0.5]];

    // scipy.stats.studentized_range.ppf(level, k, numpy.inf)
    #[test]
    fn quantiles_are_scipys() {
        for (level, k, expected) in [
            (0.95, 2, 2.771807648699355),
            (0.95, 3, 3.314493155398122),
            (0.95, 5, 3.857655510378623),
            (0.95, 10, 4.474124221725907),
            (0.95, 20, 5.0116887941184425),
            (0.90, 3, 2.9023802134282515),
            (0.90, 10, 4.129346398236873),
        ] {
            assert_near([studentized_range(level, k).unwrap()], [expected], 1e-7, k);
        }
        // scipy.stats.studentized_range.cdf(3, 4, numpy.inf)
        assert!((range_cdf(3.0, 4) - 0.8537285189523403).abs() < 1e-7);
    }

    // Closed form for two: the difference of two normals has variance 2, so q = sqrt(2) z. Demsar 2006, section
    // 3.2.2: four classifiers on 14 data sets, critical value 2.569 = q / sqrt(2), CD = 1.25.
    #[test]
    fn critical_differences_by_hand() {
        let z = Normal::standard().inverse_cdf(0.975);
        assert_near([studentized_range(0.95, 2).unwrap()], [2.0_f64.sqrt() * z], 1e-9, "");
        assert!((studentized_range(0.95, 4).unwrap() / 2.0_f64.sqrt() - 2.569).abs() < 5e-4);
        assert!((critical_difference(0.95, 4, 14).unwrap() - 1.25).abs() < 5e-3);
        assert_eq!((critical_difference(0.95, 1, 14), critical_difference(0.95, 4, 0)), (None, None));
    }

    // statsmodels.stats.multitest.multipletests([.01, .04, .03, .005, .5], method="holm")[1]
    #[test]
    fn holm_is_statsmodels() {
        assert_near(holm(&[0.01, 0.04, 0.03, 0.005, 0.5]), [0.04, 0.09, 0.09, 0.025, 0.5], 1e-9, "");
        assert!(holm(&[]).is_empty());
    }

    #[test]
    fn blocks_that_cannot_be_ranked_have_no_result() {
        assert_eq!(friedman(&[], true), None);
        assert_eq!(friedman(&[vec![1.0]], true), None);
        assert_eq!(friedman(&[vec![1.0, 2.0], vec![1.0]], true), None);
        let tied = friedman(&[vec![0.5, 0.5], vec![0.1, 0.1]], true).unwrap();
        assert_eq!((tied.mean_ranks, tied.test), (vec![1.5, 1.5], None));
    }

    proptest! {
        #[test]
        fn ranks_add_up(values in prop::collection::vec((0..6_i32).prop_map(f64::from), 1..20)) {
            let n = values.len() as f64;
            let found = ranks(&values, true);
            prop_assert!((found.iter().sum::<f64>() - n * (n + 1.0) / 2.0).abs() < 1e-9);
            for (i, a) in values.iter().enumerate() {
                for (j, b) in values.iter().enumerate() {
                    prop_assert_eq!(a > b, found[i] < found[j]);
                }
            }
        }

        #[test]
        fn holm_keeps_the_order_and_never_lowers(p in prop::collection::vec(0.0..1.0_f64, 1..12)) {
            let found = holm(&p);
            for (i, a) in p.iter().enumerate() {
                // Between the value itself and Bonferroni's.
                prop_assert!(*a <= found[i] && found[i] <= (a * p.len() as f64).min(1.0));
                prop_assert!(p.iter().zip(&found).all(|(b, q)| a > b || found[i] <= *q));
            }
        }
    }
}
