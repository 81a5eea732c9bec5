//! Kolmogorov-Smirnov statistics, their asymptotic p-values and critical values.
//!
//! ```text
//! D = sup_x |F_n(x) - F(x)|             one sample of n against a distribution,    e = n
//! D = sup_x |F_n(x) - G_m(x)|           two samples,                               e = n m / (n + m)
//! p = 2 sum_{j >= 1} (-1)^(j-1) exp(-2 j^2 z^2),   z = (sqrt(e) + 0.12 + 0.11 / sqrt(e)) D
//! critical D(alpha) = sqrt(-ln(alpha / 2) / 2) / sqrt(e)
//! ```
//!
//! `D` is in `[0, 1]` and small for distributions that are alike. The statistics are those of the book cited
//! by SanMiguel and Cavallaro (CVIU 131, 2015, reference 30), who rank by `D`: with their 1.9 million
//! samples the test rejects whatever is not exact. The `z` with its correction for small `e` is Stephens'
//! (1970), which MATLAB's `kstest2` uses; the critical value is the first term of the series solved for `D`.

/// `D` of samples in ascending order against a distribution function; NaN without samples.
pub fn one_sample(sorted: &[f64], cdf: impl Fn(f64) -> f64) -> f64 {
    let n = sorted.len() as f64;
    let largest = |largest: f64, (i, &x): (usize, &f64)| {
        let f = cdf(x);
        largest.max(f - i as f64 / n).max((i + 1) as f64 / n - f)
    };
    if sorted.is_empty() { f64::NAN } else { sorted.iter().enumerate().fold(0.0, largest) }
}

/// `D` of two samples, each in ascending order; NaN if one is empty. Samples that are equal step together.
pub fn two_samples(a: &[f64], b: &[f64]) -> f64 {
    if a.is_empty() || b.is_empty() {
        return f64::NAN;
    }
    let (mut i, mut j, mut largest) = (0, 0, 0.0_f64);
    while i < a.len() && j < b.len() {
        // `total_cmp`, so that the loop also advances past NaN.
        let x = if a[i].total_cmp(&b[j]).is_le() { a[i] } else { b[j] };
        while i < a.len() && a[i].total_cmp(&x).is_le() {
            i += 1;
        }
        while j < b.len() && b[j].total_cmp(&x).is_le() {
            j += 1;
        }
        largest = largest.max((i as f64 / a.len() as f64 - j as f64 / b.len() as f64).abs());
    }
    largest
}

/// Effective size `e` of two samples.
pub fn effective_size(n: usize, m: usize) -> f64 {
    let (n, m) = (n as f64, m as f64);
    n * m / (n + m)
}

/// Asymptotic probability that the statistic of two equal distributions is `d` or more; `size` is the
/// effective size `e` of the module's formulas.
pub fn p_value(d: f64, size: f64) -> f64 {
    let root = size.sqrt();
    survival((root + 0.12 + 0.11 / root) * d)
}

/// The statistic that is exceeded with probability `alpha` between equal distributions, for `alpha` in (0, 1)
/// and not near 1; `size` is the effective size `e`.
pub fn critical(alpha: f64, size: f64) -> f64 {
    (-(alpha / 2.0).ln() / 2.0).sqrt() / size.sqrt()
}

/// `1 - K(z)`, with `K` Kolmogorov's distribution. The series at the head of this file converges fast for
/// large `z`, its theta transform, `K = sqrt(2 pi) / z sum exp(-(2 j - 1)^2 pi^2 / (8 z^2))`, for small ones.
fn survival(z: f64) -> f64 {
    if z.is_nan() {
        return f64::NAN;
    }
    if z <= 0.0 {
        return 1.0;
    }
    let p = if z < 1.0 {
        let term =
            |j: u32| (-f64::from(2 * j - 1).powi(2) * std::f64::consts::PI.powi(2) / (8.0 * z * z)).exp();
        1.0 - (2.0 * std::f64::consts::PI).sqrt() / z * (1..=5).map(term).sum::<f64>()
    } else {
        let term = |j: u32| (-2.0 * f64::from(j * j) * z * z).exp();
        2.0 * (1..=6).map(|j| if j % 2 == 1 { term(j) } else { -term(j) }).sum::<f64>()
    };
    p.clamp(0.0, 1.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::{cases, number, numbers};
    use proptest::prelude::*;
    use trackfail_testing::assert_near;

    // scipy.stats.ks_2samp, see `two_samples` in tests/oracles/avu.py; one case has many ties.
    #[test]
    fn two_samples_agree_with_scipy() {
        for case in cases("avu", "two_samples") {
            let [mut a, mut b] = ["a", "b"].map(|key| numbers(&case[key]));
            a.sort_by(f64::total_cmp);
            b.sort_by(f64::total_cmp);
            assert_near([two_samples(&a, &b)], [number(&case["statistic"])], 1e-14, "");
        }
    }

    // python3: scipy.stats.ks_1samp([.1, .15, .4, .8, .85, .86], scipy.stats.uniform.cdf).statistic
    #[test]
    fn one_sample_agrees_with_scipy() {
        let got = one_sample(&[0.1, 0.15, 0.4, 0.8, 0.85, 0.86], |x| x.clamp(0.0, 1.0));
        assert!((got - 0.30000000000000004).abs() < 1e-15, "{got}");
        assert!(one_sample(&[], |x| x).is_nan() && two_samples(&[], &[1.0]).is_nan());
    }

    // python3: from scipy.special import kolmogorov; z = lambda d, e: (e**.5 + .12 + .11 / e**.5) * d
    // [float(kolmogorov(z(d, e))) for d, e in ((.02, 100), (.05, 100), (.0946, 100), (.1, 100), (.3, 40), (.9, 2))]
    #[test]
    fn p_values_agree_with_scipy() {
        assert_near(P.map(|(d, size, _)| p_value(d, size)), P.map(|p| p.2), 1e-12, "");
        assert_eq!((p_value(0.0, 10.0), p_value(1.0, 1e6)), (1.0, 0.0));
    }
    const P: [(f64, f64, f64); 6] = [
        (0.02, 100.0, 0.9999999999988989),
        (0.05, 100.0, 0.9596004458626864),
        (0.0946, 100.0, 0.3172912965365042),
        (0.1, 100.0, 0.25622118507010405),
        (0.3, 40.0, 0.0010883729366646373),
        (0.9, 2.0, 0.029704020515730185),
    ];

    // The table of section 9 of the method notes; python3: [(-numpy.log(a / 2) / 2) ** .5 for a in ...]
    #[test]
    fn critical_values_are_the_usual_ones() {
        for (alpha, want) in
            [(0.1, 1.2239), (0.05, 1.3581), (0.025, 1.4802), (0.01, 1.6276), (0.005, 1.7308), (0.001, 1.9495)]
        {
            assert!((critical(alpha, 1.0) - want).abs() < 5e-5);
            assert!((critical(alpha, effective_size(30, 60)) - want / 20.0_f64.sqrt()).abs() < 2e-5);
            assert!((survival(critical(alpha, 1.0)) - alpha).abs() < 1e-4);
        }
    }

    proptest! {
        #[test]
        fn a_statistic_is_symmetric_and_sees_only_ranks(
            mut a in prop::collection::vec(0..30_i32, 1..40), mut b in prop::collection::vec(0..30_i32, 1..40)
        ) {
            a.sort_unstable();
            b.sort_unstable();
            let with = |f: fn(f64) -> f64| [&a, &b].map(|x| x.iter().map(|v| f(f64::from(*v))).collect::<Vec<_>>());
            let [x, y] = with(|v| v);
            let d = two_samples(&x, &y);
            prop_assert!((0.0..=1.0).contains(&d));
            prop_assert_eq!(d, two_samples(&y, &x));
            prop_assert_eq!(two_samples(&x, &x), 0.0);
            let [u, v] = with(f64::exp);
            prop_assert_eq!(d, two_samples(&u, &v));
            // Against the step function of the other sample, at the points of both.
            let step = |s: &[f64], at: f64| s.iter().filter(|&&v| v <= at).count() as f64 / s.len() as f64;
            let apart = x.iter().chain(&y).map(|at| (step(&x, *at) - step(&y, *at)).abs());
            prop_assert_eq!(d, apart.fold(0.0, f64::max));
        }

        #[test]
        fn the_two_series_meet(z in 0.9..1.1_f64) {
            prop_assert!(survival(z) > survival(z + 1e-3));
            prop_assert!((survival(1.0 - 1e-15) - survival(1.0)).abs() < 1e-13);
        }
    }
}
