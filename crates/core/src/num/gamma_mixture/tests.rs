use super::*;
use crate::num::seed;
use crate::num::special::ln_gamma;
use crate::testing::{cases, count, drawn_mixture, mixture, number, numbers, oracle};
use proptest::prelude::*;

fn draw(mixture: &Mixture, n: usize, seed: u64) -> Vec<f64> {
    let mut rng = seed::rng(seed);
    (0..n).map(|_| mixture.sample(&mut rng)).collect()
}

fn binned(x: &[f64]) -> Binned {
    Binned::new(x.iter().copied()).unwrap()
}

/// Density at a value above 0.
fn density(mixture: &Mixture, v: f64) -> f64 {
    let of_component = |c: &Component| {
        let z = v / c.scale;
        ((c.shape - 1.0) * z.ln() - z - ln_gamma(c.shape)).exp() / c.scale
    };
    mixture.sum(of_component)
}

fn log_likelihood(mixture: &Mixture, x: &[f64]) -> f64 {
    x.iter().map(|&x| density(mixture, x.max(FLOOR)).ln()).sum()
}

fn relative(got: f64, want: f64) -> f64 {
    ((got - want) / want).abs()
}

// scipy.stats.gamma; see `functions` in avu.py.
#[test]
fn functions_agree_with_scipy() {
    let oracle = &oracle("avu")["functions"];
    let parts: Vec<(f64, f64, f64)> = serde_json::from_value(oracle["components"].clone()).unwrap();
    let m = mixture(&parts);
    for row in oracle["rows"].as_array().unwrap().iter().map(numbers) {
        for (got, want) in [density(&m, row[0]), m.cdf(row[0]), m.survival(row[0])].iter().zip(&row[1..]) {
            assert!(relative(*got, *want) < 1e-11, "{row:?}: {got}");
        }
    }
    let (mean, variance) = (number(&oracle["mean"]), number(&oracle["variance"]));
    assert!(relative(m.sum(Component::mean), mean) < 1e-14);
    let of_squares = m.sum(|c| c.variance() + c.mean() * c.mean());
    assert!(relative(of_squares - mean * mean, variance) < 1e-13);
}

// Section 13 of the method notes, and python3: scipy.stats.gamma.fit([.4, 1.3, .9, 2.2, .75, 3.1, .08], floc=0).
#[test]
fn one_component_is_the_gamma_of_greatest_likelihood() {
    let cases: [(&[f64], f64, f64); 2] = [
        (&[0.05, 0.12, 0.33, 0.07, 0.9, 0.21, 0.15, 0.48, 0.02, 0.26], 1.1521147, 0.2248040),
        (&[0.4, 1.3, 0.9, 2.2, 0.75, 3.1, 0.08], 1.2341680061241354, 1.0105130346551996),
    ];
    for (x, shape, scale) in cases {
        let fit = fit(&binned(x), 1, &FitOptions::default()).unwrap();
        let c = fit.mixture.components[0];
        assert!(relative(c.shape, shape) < 2e-7 && relative(c.scale, scale) < 2e-7, "{c:?}");
        // With one component the likelihood on cells is that of the samples.
        assert!(relative(fit.log_likelihood, log_likelihood(&fit.mixture, x)) < 1e-12);
    }
}

// scipy.optimize.minimize on all parameters and the samples themselves, 60 starts; see `fit` in avu.py.
#[test]
fn reaches_the_likelihood_of_scipy() {
    for case in cases("avu", "mixtures") {
        let x = numbers(&case["x"]);
        for want in case["fits"].as_array().unwrap() {
            let k = count(&want["k"]);
            let options = FitOptions { tolerance: 1e-12, ..FitOptions::default() };
            let fit = fit(&binned(&x), k, &options).unwrap();
            let ours = log_likelihood(&fit.mixture, &x);
            assert!((ours - number(&want["log_likelihood"])).abs() < 1e-4, "{k}: {ours} {want}");
            assert!((fit.log_likelihood - ours).abs() < 1e-3, "{k}: {} {ours}", fit.log_likelihood);
            for (got, want) in fit.mixture.components.iter().zip(want["components"].as_array().unwrap()) {
                for (got, want) in [got.weight, got.shape, got.scale].iter().zip(numbers(want)) {
                    assert!(relative(*got, want) < 0.01, "{k}: {got} is not {want}");
                }
            }
        }
    }
}

#[test]
fn finds_the_mixture_that_samples_come_from() {
    let truth = mixture(&[(0.6, 0.9, 0.1), (0.3, 6.0, 0.3), (0.1, 50.0, 0.2)]);
    let x = draw(&truth, 100_000, 1);
    let fit = fit(&binned(&x), 3, &FitOptions::default()).unwrap();
    assert!(fit.log_likelihood >= log_likelihood(&truth, &x));
    for (got, want) in fit.mixture.components.iter().zip(&truth.components) {
        assert!(relative(got.weight, want.weight) < 0.02, "{got:?}");
        assert!(relative(got.shape, want.shape) < 0.06 && relative(got.scale, want.scale) < 0.06, "{got:?}");
    }
}

#[test]
fn likelihoods_do_not_fall_with_the_order_and_choose_it() {
    let truth = mixture(&[(0.7, 1.5, 0.1), (0.3, 8.0, 0.2)]);
    let samples = binned(&draw(&truth, 50_000, 2));
    let fits = fit_all(&samples, 7, &FitOptions::default()).unwrap();
    assert_eq!(fits.iter().map(|f| f.mixture.components.len()).collect::<Vec<_>>(), [1, 2, 3, 4, 5, 6, 7]);
    for pair in fits.windows(2) {
        assert!(pair[1].log_likelihood >= pair[0].log_likelihood);
    }
    let terms = select::terms(&fits, samples.count());
    for criterion in [select::Criterion::Aic, select::Criterion::Bic] {
        assert_eq!(select::choose(&terms, criterion, 600).order, Some(2));
    }
    assert_eq!(fit(&samples, 4, &FitOptions::default()).unwrap(), fits[3]);
}

#[test]
fn threads_do_not_change_a_bit() {
    let truth = mixture(&[(0.5, 0.7, 0.2), (0.5, 3.0, 1.0)]);
    let samples = binned(&draw(&truth, 30_000, 3));
    let with = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| fit_all(&samples, 4, &FitOptions::default())).unwrap()
    };
    let one = with(1);
    assert_eq!(one, with(2));
    assert_eq!(one, with(5));
}

#[test]
fn samples_without_a_fit_are_refused() {
    let options = FitOptions::default();
    let refused = |x: &[f64], k| fit(&binned(x), k, &options).is_err();
    assert!(refused(&[], 1) && refused(&[1.0], 1) && refused(&[0.3; 1000], 1) && refused(&[0.0; 50], 2));
    assert!(refused(&[1.0, 2.0, 3.0, 4.0], 2) && refused(&[1.0, 2.0, 1.0, 2.0, 1.0, 2.0, 1.0, 2.0], 3));
    assert!(refused(&[1.0, 2.0], 0) && refused(&[1.0, 2.0], MAX_COMPONENTS + 1));
    let options = FitOptions { tolerance: f64::NAN, ..options };
    assert_eq!(fit(&binned(&[1.0, 2.0]), 1, &options).unwrap_err().to_string(), NAN_TOLERANCE);
}
const NAN_TOLERANCE: &str = "the tolerance must be above 0 and finite, not NaN";

// Half of the samples are one value: a likelihood without a bound but for the limit of the shape.
#[test]
fn a_value_that_repeats_meets_the_limit_of_the_shape() {
    let mut x = draw(&mixture(&[(1.0, 2.0, 0.5)]), 2000, 4);
    x.extend([0.0; 2000]);
    let binned = binned(&x);
    let fit = fit(&binned, 2, &FitOptions::default()).unwrap();
    let [spike, rest] = fit.mixture.components[..] else { panic!("{fit:?}") };
    assert_eq!((spike.shape, binned.clipped().floored), (MAX_SHAPE, 2000));
    assert!((spike.mean() / FLOOR - 1.0).abs() < 1e-6 && (spike.weight - 0.5).abs() < 1e-3, "{spike:?}");
    assert!(relative(rest.shape, 2.0) < 0.1, "{rest:?}");
}

#[test]
fn a_mixture_survives_a_file_and_a_wrong_one_does_not() {
    let m = mixture(&[(0.3, 7.0, 0.2), (0.7, 0.4, 0.1)]);
    assert!(m.components[0].shape == 0.4);
    let text = serde_json::to_string(&m).unwrap();
    assert_eq!(serde_json::from_str::<Mixture>(&text).unwrap(), m);
    let weights = [(0.6, 1.0, 1.0), (f64::NAN, 1.0, 1.0)];
    let others = [(1.0, 0.0, 1.0), (1.0, 2e4, 1.0), (1.0, 1.0, -1.0), (1.0, 9.0, 1e200)];
    for (weight, shape, scale) in weights.into_iter().chain(others) {
        assert!(Mixture::new(vec![Component { weight, shape, scale }]).is_err());
    }
    assert!(Mixture::new(vec![]).is_err());
    let wrong = text.replace("0.7", "0.8");
    assert!(serde_json::from_str::<Mixture>(&wrong).is_err());
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(12))]
    // A factor moves samples against the borders of the cells, which is what the tolerances are for.
    #[test]
    fn a_factor_moves_the_scales_alone(seed in 0..1000_u64, log_factor in -2.0..2.0_f64) {
        let truth = mixture(&[(0.5, 2.0, 0.05), (0.5, 30.0, 0.1)]);
        let x = draw(&truth, 3000, seed);
        let factor = log_factor.exp();
        let scaled: Vec<f64> = x.iter().map(|x| x * factor).collect();
        let options = FitOptions { tolerance: 1e-11, ..FitOptions::default() };
        let a = fit(&binned(&x), 2, &options).unwrap();
        let b = fit(&binned(&scaled), 2, &options).unwrap();
        prop_assert!((a.log_likelihood - b.log_likelihood - x.len() as f64 * log_factor).abs() < 1e-2);
        for (a, b) in a.mixture.components.iter().zip(&b.mixture.components) {
            prop_assert!(relative(b.weight, a.weight) < 1e-3 && relative(b.shape, a.shape) < 1e-3, "{a:?} {b:?}");
            prop_assert!(relative(b.scale, a.scale * factor) < 1e-3, "{a:?} {b:?}");
        }
    }

    #[test]
    fn distribution_functions_rise_from_0_to_1(
        parts in prop::collection::vec((0.1..1.0_f64, -1.0..2.0_f64, -2.0..1.0_f64), 1..5), v in 0.0..20.0_f64
    ) {
        let m = drawn_mixture(&parts);
        prop_assert!((m.cdf(v) + m.survival(v) - 1.0).abs() < 1e-12);
        prop_assert!(m.cdf(v) <= m.cdf(v + 0.1) + 1e-14 && m.cdf(0.0) == 0.0);
    }
}
