//! Special functions around the Gamma distribution, defined for all real arguments.
//!
//! ```text
//! F(x; shape, scale) = P(shape, x / scale)        psi'(x) = sum_{j >= 0} 1 / (x + j)^2
//! ```
//!
//! `P` is the regularized lower incomplete gamma function of statrs, which has the digamma function and
//! `ln Gamma` as well but no trigamma function, and refuses arguments at the border that are usual here
//! (`x = 0`, `x` infinite). `x` and `scale` have one unit, the results have none.

use statrs::function::gamma::{checked_gamma_lr, checked_gamma_ur};
pub use statrs::function::gamma::{digamma, ln_gamma};

/// Argument from which on the asymptotic series is used. Its first neglected term is then below 1e-15 of the
/// sum.
const ASYMPTOTIC: f64 = 12.0;

/// Trigamma function, the derivative of [`digamma`], for `x > 0` (Abramowitz and Stegun 6.4.6 and 6.4.12);
/// NaN elsewhere.
pub fn trigamma(x: f64) -> f64 {
    if x.is_nan() || x <= 0.0 {
        return f64::NAN;
    }
    let (mut z, mut sum) = (x, 0.0);
    while z < ASYMPTOTIC {
        sum += 1.0 / (z * z);
        z += 1.0;
    }
    let r = 1.0 / z;
    let s = r * r;
    let tail = s
        * (1.0 / 6.0
            - s * (1.0 / 30.0 - s * (1.0 / 42.0 - s * (1.0 / 30.0 - s * (5.0 / 66.0 - s * 691.0 / 2730.0)))));
    sum + r * (1.0 + 0.5 * r + tail)
}

/// Distribution function of a Gamma distribution at `x`; NaN unless `shape` and `scale` are positive and finite.
pub fn gamma_cdf(x: f64, shape: f64, scale: f64) -> f64 {
    at(x, shape, scale, [0.0, 1.0], |z| checked_gamma_lr(shape, z).unwrap_or(f64::NAN))
}

/// Survival function `1 - gamma_cdf`, computed without cancellation: small tails keep their relative
/// accuracy.
pub fn gamma_survival(x: f64, shape: f64, scale: f64) -> f64 {
    at(x, shape, scale, [1.0, 0.0], |z| checked_gamma_ur(shape, z).unwrap_or(f64::NAN))
}

/// Shape of greatest likelihood of a Gamma distribution: the root `eta` of `ln eta - psi(eta) = s` for `s =
/// ln(mean x) - mean(ln x) > 0`; infinite for `s <= 0` (samples that are all equal), NaN for a NaN.
///
/// Newton's method from the closed form `(3 - s + sqrt((s - 3)^2 + 24 s)) / (12 s)`, which is within 1.5 %
/// (Minka 2002, "Estimating a Gamma distribution"); 3 to 5 steps.
pub fn gamma_shape(s: f64) -> f64 {
    if s.is_nan() {
        return f64::NAN;
    }
    // Beyond a shape of 1e12 the two terms of the equation agree in all digits that matter.
    if s <= 1e-12 {
        return f64::INFINITY;
    }
    let start = (3.0 - s + ((s - 3.0) * (s - 3.0) + 24.0 * s).sqrt()) / (12.0 * s);
    // The function is convex and falls, so only a step from the right can leave the positive axis.
    positive_root(start, 50, 1e-14, |shape| {
        let slope = 1.0 / shape - trigamma(shape);
        shape - (shape.ln() - digamma(shape) - s) / slope
    })
}

/// Root above 0 by Newton's method: a step leads from `x` to `newton(x)`, or to `x / 2` where that is not above 0. Ends
/// after `rounds` steps, or one of at most `tolerance * x`.
pub(super) fn positive_root(start: f64, rounds: usize, tolerance: f64, newton: impl Fn(f64) -> f64) -> f64 {
    let mut x = start;
    for _ in 0..rounds {
        let next = newton(x);
        let next = if next > 0.0 { next } else { x / 2.0 };
        let done = (next - x).abs() <= tolerance * x;
        x = next;
        if done {
            break;
        }
    }
    x
}

/// Value of `inside` at `x / scale`, or `below` or `above` outside of the support.
fn at(x: f64, shape: f64, scale: f64, [below, above]: [f64; 2], inside: impl Fn(f64) -> f64) -> f64 {
    let z = x / scale;
    let fine = |v: f64| v.is_finite() && v > 0.0;
    if !fine(shape) || !fine(scale) || z.is_nan() {
        f64::NAN
    } else if z <= 0.0 {
        below
    } else if z.is_infinite() {
        above
    } else {
        inside(z).clamp(0.0, 1.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use trackfail_testing::assert_near;

    // python3: from scipy.special import polygamma; [float(polygamma(1, x)) for x in (1e-3, .1, .5, 1, 2.5, 11.9, 12, 100, 1e4)]
    #[test]
    fn trigamma_agrees_with_scipy() {
        assert_near(TRIGAMMA.map(|(x, want)| trigamma(x) / want), [1.0; 9], 2e-14, "");
        assert!(trigamma(0.0).is_nan() && trigamma(-1.5).is_nan() && trigamma(f64::NAN).is_nan());
    }
    const TRIGAMMA: [(f64, f64); 9] = [
        (0.001, 1000001.6425331959),
        (0.1, 101.43329915079275),
        (0.5, 4.93480220054468),
        (1.0, 1.6449340668482266),
        (2.5, 0.4903577561002349),
        (11.9, 0.08766320119000418),
        (12.0, 0.0869018728717684),
        (100.0, 0.010050166663333573),
        (10000.0, 0.00010000500016666666),
    ];

    // At a shape of 1e4 the rounding of ln Gamma (about 8e4) leaves eleven digits.
    // python3: from scipy.stats import gamma; [(x, a, s, gamma.cdf(x, a, scale=s), gamma.sf(x, a, scale=s)) for ...]
    #[test]
    fn gamma_agrees_with_scipy() {
        for (x, shape, scale, cdf, survival) in GAMMA {
            let got = [gamma_cdf(x, shape, scale) / cdf, gamma_survival(x, shape, scale) / survival];
            assert_near(got, [1.0; 2], 3e-11, format!("{x} {shape}"));
        }
    }
    const GAMMA: [(f64, f64, f64, f64, f64); 6] = [
        (0.01, 0.3, 1.0, 0.27924099635901484, 0.7207590036409852),
        (2.0, 0.7, 0.5, 0.9912376516408635, 0.008762348359136434),
        (3.0, 4.0, 0.25, 0.9977082087922086, 0.002291791207791423),
        (9.9, 10000.0, 0.001, 0.15865119219356463, 0.8413488078064354),
        (10.2, 10000.0, 0.001, 0.9767126778664003, 0.023287322133599797),
        (60.0, 2.5, 1.5, 0.9999999999999991, 8.391825114831597e-16),
    ];

    // python3: from scipy.special import digamma; from scipy.optimize import brentq; import numpy as np
    // [brentq(lambda a: np.log(a) - digamma(a) - s, 1e-4, 1e7, xtol=1e-13, rtol=1e-14) for s in (40., 3., .4930840, .01, 1e-4)]
    #[test]
    fn shapes_agree_with_scipy() {
        assert_near(SHAPES.map(|(s, want)| gamma_shape(s) / want), [1.0; 5], 1e-10, "");
        assert!([0.0, -1.0].iter().all(|s| gamma_shape(*s).is_infinite()) && gamma_shape(f64::NAN).is_nan());
    }
    const SHAPES: [(f64, f64); 5] = [
        (40.0, 0.023133868671093186),
        (3.0, 0.23855463469170107),
        (0.493084, 1.1521147825717992),
        (0.01, 50.16610820660193),
        (0.0001, 5000.166661100495),
    ];

    #[test]
    fn the_ends_of_the_support_have_values() {
        for shape in [0.3, 1.0, 9e3] {
            assert_eq!((gamma_cdf(0.0, shape, 2.0), gamma_survival(-3.0, shape, 2.0)), (0.0, 1.0));
            let far = (gamma_cdf(f64::INFINITY, shape, 2.0), gamma_survival(1e308, shape, 1e-300));
            assert_eq!(far, (1.0, 0.0));
        }
        assert!(gamma_cdf(1.0, f64::NAN, 1.0).is_nan() && gamma_cdf(1.0, 1.0, 0.0).is_nan());
    }

    proptest! {
        #[test]
        fn trigamma_obeys_its_recurrence(x in 1e-3..50.0_f64) {
            let want = trigamma(x + 1.0) + 1.0 / (x * x);
            prop_assert!((trigamma(x) - want).abs() <= 1e-13 * want);
        }
    }
}
