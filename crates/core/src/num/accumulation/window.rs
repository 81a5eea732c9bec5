//! Sliding sums, and quantiles computed without a convolution.

use statrs::function::erf::erfc_inv;
use std::f64::consts::SQRT_2;

/// `s[t]`, the sum of the `length` values up to and including `t` (Eq. 8 with weights 1); the first `length - 1`
/// sums are over fewer values. A `length` of 0 counts as 1.
///
/// No value is ever subtracted: a window is the end of one block of `length` values plus the beginning of the
/// next. So rounding errors, huge values and NaN affect only windows that contain them.
pub fn sums(series: &[f64], length: usize) -> Vec<f64> {
    let length = length.max(1);
    let mut out = Vec::with_capacity(series.len());
    // ends[j]: sum from j to the end of the block before.
    let mut ends: Vec<f64> = Vec::new();
    for block in series.chunks(length) {
        let mut begin = 0.0;
        for (j, value) in block.iter().enumerate() {
            begin += value;
            out.push(ends.get(j + 1).map_or(begin, |end| end + begin));
        }
        ends = block.to_vec();
        for j in (0..ends.len().saturating_sub(1)).rev() {
            ends[j] += ends[j + 1];
        }
    }
    out
}

/// Upper quantile of `N(L mean, L variance)`, the central limit's approximation of the sum (section 5.2 of
/// the paper): `L mean + z_(1 - alpha) sqrt(L variance)`. NaN for an `alpha` outside (0, 1).
pub fn clt_quantile(mean: f64, variance: f64, length: usize, alpha: f64) -> f64 {
    if !(alpha > 0.0 && alpha < 1.0) {
        return f64::NAN;
    }
    let z = SQRT_2 * erfc_inv(2.0 * alpha);
    length as f64 * mean + z * (length as f64 * variance).sqrt()
}

/// The `p` quantile of samples in ascending order, without interpolation: `numpy.quantile(sorted, p,
/// method="inverted_cdf")`. At most a share `1 - p` of the samples exceeds it, as a test of level `1 - p`
/// requires; interpolation could violate that. `None` without samples, or for a `p` outside `[0, 1]`.
pub fn empirical_quantile(sorted: &[f64], p: f64) -> Option<f64> {
    if !(0.0..=1.0).contains(&p) {
        return None;
    }
    let rank = (sorted.len() as f64 * p - 1.0).ceil().max(0.0) as usize;
    sorted.get(rank.min(sorted.len().saturating_sub(1))).copied()
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use trackfail_testing::assert_near;

    #[test]
    fn a_value_is_gone_when_its_windows_are() {
        let got = sums(&[0.1, 1e300, 0.1, 0.1, 0.25, f64::NAN, 0.5, 0.5, 0.5], 2);
        assert_eq!(got[3..5], [0.2, 0.35]);
        assert!(got[5].is_nan() && got[6].is_nan());
        assert_eq!(got[7..], [1.0, 1.0]);
    }

    // python3: [scipy.stats.norm.isf(a, 5 * .3, (5 * .2) ** .5) for a in (.5, .05, .005, 1e-6, .9)]
    #[test]
    fn the_central_limit_agrees_with_scipy() {
        assert_near(CLT.map(|(alpha, _)| clt_quantile(0.3, 0.2, 5, alpha)), CLT.map(|c| c.1), 1e-10, "");
        assert!(clt_quantile(0.3, 0.2, 5, 0.0).is_nan() && clt_quantile(0.3, 0.2, 5, 1.0).is_nan());
    }
    const CLT: [(f64, f64); 5] = [
        (0.5, 1.5),
        (0.05, 3.144853626951473),
        (0.005, 4.0758293035489),
        (1e-06, 6.253424308822899),
        (0.9, 0.21844843445539963),
    ];

    // python3: [numpy.quantile(x, p, method="inverted_cdf") for p in (0, .001, .2, .2000001, .5, .995, 1)], x below
    #[test]
    fn empirical_quantiles_agree_with_numpy() {
        let x = [0.5, 1.0, 1.0, 2.5, 7.0];
        let found = [0.0, 0.001, 0.2, 0.2000001, 0.5, 0.995, 1.0].map(|p| empirical_quantile(&x, p));
        assert_eq!(found, [0.5, 0.5, 0.5, 1.0, 1.0, 7.0, 7.0].map(Some));
        assert_eq!(empirical_quantile(&[], 0.5), None);
        assert_eq!((empirical_quantile(&x, 1.1), empirical_quantile(&x, f64::NAN)), (None, None));
    }

    proptest! {
        #[test]
        fn sums_are_those_of_the_windows(x in prop::collection::vec(0..1000_i32, 0..60), length in 0..20_usize) {
            let x: Vec<f64> = x.into_iter().map(f64::from).collect();
            let want: Vec<f64> = (0..x.len()).map(|t| x[(t + 1).saturating_sub(length.max(1))..=t].iter().sum()).collect();
            prop_assert_eq!(sums(&x, length), want);
        }

        #[test]
        fn no_more_than_the_rest_exceeds_a_quantile(
            mut x in prop::collection::vec(0.0..1.0_f64, 1..200), per_mille in 0..=1000_usize
        ) {
            x.sort_by(f64::total_cmp);
            let q = empirical_quantile(&x, per_mille as f64 / 1000.0).unwrap();
            let above = x.iter().filter(|&&v| v > q).count();
            prop_assert!(above * 1000 <= x.len() * (1000 - per_mille));
        }
    }
}
