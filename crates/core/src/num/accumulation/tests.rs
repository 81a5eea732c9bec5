use super::*;
use crate::num::special::gamma_cdf;
use crate::testing::{cases, count, drawn_mixture, mixture, number, numbers};
use proptest::prelude::*;
use trackfail_testing::assert_near;

/// Sum of `length` independent values with the distribution function `cdf`, which is 0 below 0.
fn of_cdf(cdf: impl Fn(f64) -> f64, length: usize) -> Result<Accumulated, AccumulationError> {
    check(length)?;
    let mut below = 0.0;
    let mass = |k: usize| {
        let next = cdf(k as f64 * STEP);
        next - std::mem::replace(&mut below, next)
    };
    let masses = (1..=cells(|v| 1.0 - cdf(v), length)).map(mass).collect();
    Accumulated::of_masses(masses, length)
}

/// Value at which the interpolated distribution function is `1 - alpha`.
fn interpolated(sum: &Accumulated, alpha: f64) -> f64 {
    let j = sum.reaches(alpha).unwrap();
    let below = if j == 0 { 0.0 } else { sum.cumulative[j - 1] };
    sum.point(j as f64 - 0.5 + ((1.0 - alpha - below) / (sum.cumulative[j] - below)).clamp(0.0, 1.0))
}

// scipy.stats.gamma.isf, see `sums` in tests/oracles/avu.py: the sum of Gamma variables of one scale is one.
#[test]
fn a_sum_of_gamma_variables_has_the_quantiles_of_scipy() {
    for case in cases("avu", "sums") {
        let (shape, scale, length) = (number(&case["shape"]), number(&case["scale"]), count(&case["length"]));
        let by_cdf = of_cdf(|v| gamma_cdf(v, shape, scale), length).unwrap();
        let by_density = Accumulated::of_mixture(&mixture(&[(1.0, shape, scale)]), length).unwrap();
        for pair in case["quantiles"].as_array().unwrap().iter().map(numbers) {
            let (alpha, want) = (pair[0], pair[1]);
            for sum in [&by_cdf, &by_density] {
                // L m_0 h / 2 is below 2e-3 here, the shift by a pole far less.
                let exact = interpolated(sum, alpha);
                assert!((exact - want).abs() < 2e-3, "{shape} {length} {alpha}: {exact} is not {want}");
                let beta = sum.upper_quantile(alpha).unwrap();
                assert!((beta - exact).abs() <= 0.5 * STEP + 1e-12);
                assert!((sum.cdf(exact) - (1.0 - alpha)).abs() < 1e-12);
            }
        }
    }
}

#[test]
fn masses_by_density_are_those_by_distribution_function() {
    // Narrower than the rule is good for, with a pole, and very wide.
    for parts in [vec![(0.5, 2000.0, 0.0005), (0.5, 0.3, 0.2)], vec![(0.3, 8.0, 0.9), (0.7, 1.0, 3.0)]] {
        let m = mixture(&parts);
        let a = Accumulated::of_mixture(&m, 1).unwrap();
        let b = of_cdf(|v| m.cdf(v), 1).unwrap();
        assert!(a.masses().count() > 500);
        // Either may end a cell before the other.
        for ((v, a), (_, b)) in a.masses().zip(b.masses()) {
            assert!((a - b).abs() < 1e-13, "{v}: {a} is not {b}");
        }
    }
}

// By hand, in cells: values 0.4, 0.4, 1.8 in cells 0, 0, 1; sums of two at 1, 2, 3 with 4/9, 4/9, 1/9.
#[test]
fn the_papers_variant_takes_the_masses_of_samples() {
    let two = Accumulated::from_samples(&[0.4, 0.4, 1.8].map(|cells| cells * STEP), 2).unwrap();
    let masses = two.masses().flat_map(|(v, mass)| [v / STEP, mass]);
    assert_near(masses, [1.0, 4.0 / 9.0, 2.0, 4.0 / 9.0, 3.0, 1.0 / 9.0], 1e-15, "");
    assert_eq!((two.upper_quantile(0.2), two.upper_quantile(0.05)), (Ok(2.0 * STEP), Ok(3.0 * STEP)));
}

// 1 / (1 + v)^2 of Pareto's tail: one value has no variance, and nearly every large sum is one large value.
#[test]
fn a_heavy_tail_ends_somewhere() {
    let cdf = |v: f64| 1.0 - (1.0 + v).powi(-2);
    let sum = of_cdf(cdf, 5).unwrap();
    let beta = sum.upper_quantile(0.001).unwrap();
    // One value alone: 5 (1 + v)^-2 = 0.001 at v = 69.7; the other four add about their mean, 1 each.
    assert!((70.0..77.0).contains(&beta), "{beta}");
    assert_eq!(sum.upper_quantile(1e-9), Err(AccumulationError::Quantile(1e-9)));
}

#[test]
fn invalid_distributions_are_refused() {
    let uniform = |v: f64| v.clamp(0.0, 1.0);
    assert!([0, MAX_LENGTH + 1].iter().all(|n| of_cdf(uniform, *n).is_err()));
    assert!(of_cdf(|_| f64::NAN, 2).is_err());
    let falling = |v: f64| if v > 0.5 { 1.0 } else { v.sin().abs() * (40.0 * v).cos() };
    assert!(of_cdf(falling, 2).is_err());
    for bad in [&[] as &[f64], &[1.0, -1.0], &[f64::INFINITY], &[1e9]] {
        assert!(Accumulated::from_samples(bad, 2).is_err());
    }
    let sum = of_cdf(uniform, 2).unwrap();
    for alpha in [0.0, 1.0, -1.0, f64::NAN] {
        assert!(sum.upper_quantile(alpha).is_err());
    }
}

// Ten thousand values of which one needs 20 cells: full padding would be 200 000.
#[test]
fn a_long_window_is_as_long_as_its_sums() {
    let sum = of_cdf(|v| (v / 0.1).clamp(0.0, 1.0), 10_000).unwrap();
    assert!(sum.masses().count() < 110_000);
    let median = interpolated(&sum, 0.5);
    assert!((median - 500.0).abs() < 1e-6, "{median}");
    // python3: 500 + scipy.stats.norm.isf(.005) * (10000 * .1 ** 2 / 12) ** .5; the sum is normal to 1e-5.
    let beta = interpolated(&sum, 0.005);
    assert!((beta - 507.43570).abs() < 1e-2, "{beta}");
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]
    #[test]
    fn beta_grows_with_the_window_and_with_certainty(
        parts in prop::collection::vec((0.1..1.0_f64, -0.5..1.5_f64, -1.5..0.3_f64), 1..4), length in 1..40_usize
    ) {
        let m = drawn_mixture(&parts);
        let sum = Accumulated::of_mixture(&m, length).unwrap();
        let longer = Accumulated::of_mixture(&m, length + 1).unwrap();
        let mut before = 0.0;
        for alpha in [0.5, 0.1, 0.05, 0.01, 0.005, 0.001] {
            let beta = sum.upper_quantile(alpha).unwrap();
            prop_assert!(beta >= before && longer.upper_quantile(alpha).unwrap() > beta);
            before = beta;
        }
        prop_assert!(sum.masses().all(|(_, mass)| mass >= 0.0));
        let total: f64 = sum.masses().map(|(_, mass)| mass).sum();
        prop_assert!((total - 1.0).abs() < 1e-9, "{total}");
        // The masses have the mean of the sum, but for half a cell a value.
        let mean: f64 = sum.masses().map(|(v, mass)| v * mass).sum();
        let one: f64 = m.components.iter().map(|c| c.weight * c.mean()).sum();
        prop_assert!((mean - length as f64 * one).abs() < length as f64 * 0.0025 + 1e-6);
    }
}
