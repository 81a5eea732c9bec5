//! Maximum-likelihood fits of the well-known distributions that the paper compares with a Gamma
//! distribution (SanMiguel and Cavallaro, CVIU 131, 2015, Fig. 10).
//!
//! ```text
//! normal       exp(-(x - m)^2 / (2 s^2)) / (s sqrt(2 pi))        m = mean x,        s^2 = mean (x - m)^2
//! exponential  exp(-x / s) / s                                   s = mean x
//! Rayleigh     x / s^2 exp(-x^2 / (2 s^2))                       s^2 = mean x^2 / 2
//! log-normal   the normal density of ln x, divided by x          m = mean ln x,     s^2 = mean (ln x - m)^2
//! Weibull      (k / s) (x / s)^(k - 1) exp(-(x / s)^k)           1 / k = mean_w ln x - mean ln x, w = x^k;
//!                                                                s^k = mean x^k
//! Gamma        x^(k - 1) exp(-x / s) / (s^k Gamma(k))            ln k - psi(k) = ln mean x - mean ln x;
//!                                                                s = mean x / k
//! ```
//!
//! `x >= 0` in any unit, which `s` shares (and `m` of the normal distribution); `k` and the log-normal's
//! parameters, which are of `ln x`, have none. The location of all but the normal distribution is 0, as with
//! `floc=0` in scipy.stats. The paper names neither its list nor its estimator beyond "well-known
//! distributions"; these are six usual ones.
//!
//! The fits read the samples themselves, once or, for Weibull, once an iteration; sums are over blocks, in
//! the order of the samples. A sample below 1e-6 counts as 1e-6, as in the fit of a mixture: `ln 0` has no
//! value.

use super::gamma_mixture::FLOOR;
use super::special::{gamma_cdf, gamma_shape, positive_root};
use statrs::function::erf::erfc;
use std::f64::consts::{PI, SQRT_2};

/// Samples whose standard deviation is below this share of their mean count as equal.
const EQUAL: f64 = 1e-7;

/// Families of distributions that can be fitted to samples.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Family {
    /// Normal distribution with mean `m` and deviation `s`.
    Normal,
    /// Exponential distribution with mean `s`.
    Exponential,
    /// Rayleigh distribution with scale `s`.
    Rayleigh,
    /// Log-normal distribution: `ln x` is normal with `m` and `s`.
    LogNormal,
    /// Weibull distribution with shape `k` and scale `s`.
    Weibull,
    /// Gamma distribution with shape `k` and scale `s`.
    Gamma,
}

impl Family {
    /// All families, in the order of the table above.
    pub const ALL: [Self; 6] =
        [Self::Normal, Self::Exponential, Self::Rayleigh, Self::LogNormal, Self::Weibull, Self::Gamma];

    /// Name of the family in tables and charts.
    pub fn name(self) -> &'static str {
        match self {
            Self::Normal => "normal",
            Self::Exponential => "exponential",
            Self::Rayleigh => "rayleigh",
            Self::LogNormal => "log-normal",
            Self::Weibull => "weibull",
            Self::Gamma => "gamma",
        }
    }
}

/// A distribution of a family, with its parameters.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Fitted {
    /// Family of the distribution.
    pub family: Family,
    /// `m` of the normal and log-normal distributions, `k` of Weibull and Gamma; 0 for the others.
    pub first: f64,
    /// `s`, the scale; of the log-normal distribution the deviation of `ln x`.
    pub scale: f64,
}

/// Distribution of a family with the greatest likelihood.
///
/// `None` for fewer than two samples, and for samples that are negative, not finite, so large that their squares
/// overflow, or all equal: equal ones for all families, even those with one parameter, so that the families can
/// be compared.
pub fn fit(family: Family, samples: &[f64]) -> Option<Fitted> {
    if samples.len() < 2 || !samples.iter().all(|x| x.is_finite() && *x >= 0.0) {
        return None;
    }
    let mean_of = |f: &dyn Fn(f64) -> f64| mean(samples, |x| f(x.max(FLOOR)));
    let mean = mean_of(&|x| x);
    let deviation = mean_of(&|x| (x - mean) * (x - mean)).sqrt();
    let square = mean_of(&|x| x * x);
    if !square.is_finite() || deviation <= EQUAL * mean {
        return None;
    }
    let mean_ln = mean_of(&f64::ln);
    let (first, scale) = match family {
        Family::Normal => (mean, deviation),
        Family::Exponential => (0.0, mean),
        Family::Rayleigh => (0.0, (square / 2.0).sqrt()),
        Family::LogNormal => (mean_ln, mean_of(&|x| (x.ln() - mean_ln).powi(2)).sqrt()),
        Family::Weibull => weibull(samples, mean_ln, mean_of(&|x| (x.ln() - mean_ln).powi(2)).sqrt()),
        Family::Gamma => {
            let shape = gamma_shape(mean.ln() - mean_ln);
            (shape, mean / shape)
        }
    };
    (first.is_finite() && scale.is_finite() && scale > 0.0).then_some(Fitted { family, first, scale })
}

/// Shape and scale of a Weibull distribution, by Newton's method on `1 / k = mean_w ln x - mean ln x`. On the
/// scale `y = (ln x - mean) / deviation`, powers cannot all overflow or underflow.
fn weibull(samples: &[f64], mean_ln: f64, deviation: f64) -> (f64, f64) {
    let y: Vec<f64> = samples.iter().map(|x| (x.max(FLOOR).ln() - mean_ln) / deviation).collect();
    let top = y.iter().fold(f64::NEG_INFINITY, |top, y| top.max(*y));
    let moments = |k: f64| {
        let weight = |y: f64| (k * (y - top)).exp();
        [mean(&y, weight), mean(&y, |y| weight(y) * y), mean(&y, |y| weight(y) * y * y)]
    };
    // ln of a Weibull variable has the standard deviation pi / sqrt(6) / k.
    let k = positive_root(PI / 6.0_f64.sqrt(), 100, 1e-13, |k| {
        let [w, wy, wyy] = moments(k);
        let value = wy / w - 1.0 / k;
        let slope = wyy / w - (wy / w) * (wy / w) + 1.0 / (k * k);
        k - value / slope
    });
    let ln_scale = top + moments(k)[0].ln() / k;
    (k / deviation, (mean_ln + deviation * ln_scale).exp())
}

/// Mean of a function of the samples. Sums over blocks keep rounding errors small.
fn mean(samples: &[f64], f: impl Fn(f64) -> f64) -> f64 {
    let block = |block: &[f64]| block.iter().map(|&x| f(x)).sum::<f64>();
    samples.chunks(1024).map(block).sum::<f64>() / samples.len() as f64
}

impl Fitted {
    /// Probability of a value up to `x`.
    pub fn cdf(&self, x: f64) -> f64 {
        let Self { family, first, scale } = *self;
        if family != Family::Normal && x <= 0.0 {
            return 0.0;
        }
        let gauss = |z: f64| 0.5 * erfc(-z / SQRT_2);
        let z = x / scale;
        match family {
            Family::Normal => gauss((x - first) / scale),
            Family::Exponential => -(-z).exp_m1(),
            Family::Rayleigh => -(-0.5 * z * z).exp_m1(),
            Family::LogNormal => gauss((x.ln() - first) / scale),
            Family::Weibull => -(-z.powf(first)).exp_m1(),
            Family::Gamma => gamma_cdf(x, first, scale),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::num::kolmogorov::one_sample;
    use crate::num::special::ln_gamma;
    use crate::testing::{cases, number, numbers};
    use proptest::prelude::*;
    use trackfail_testing::assert_near;

    /// Natural logarithm of the density at `x`, minus infinity outside the support.
    fn ln_pdf(law: &Fitted, x: f64) -> f64 {
        let Fitted { family, first, scale } = *law;
        if family != Family::Normal && x < 0.0 {
            return f64::NEG_INFINITY;
        }
        let gauss = |z: f64| -0.5 * z * z - scale.ln() - 0.5 * (2.0 * PI).ln();
        let z = x / scale;
        // k = 1 has a density at 0, where 0 * ln 0 would have none.
        let power = |k: f64| if k == 1.0 { 0.0 } else { (k - 1.0) * z.ln() };
        match family {
            Family::Normal => gauss((x - first) / scale),
            Family::Exponential => -z - scale.ln(),
            Family::Rayleigh => z.ln() - 0.5 * z * z - scale.ln(),
            Family::LogNormal if x == 0.0 => f64::NEG_INFINITY,
            Family::LogNormal => gauss((x.ln() - first) / scale) - x.ln(),
            Family::Weibull => first.ln() - scale.ln() + power(first) - z.powf(first),
            Family::Gamma => power(first) - z - scale.ln() - ln_gamma(first),
        }
    }

    // scipy.stats.<family>.fit(x, floc=0), see `families` in tests/oracles/avu.py. SciPy's
    // optimisers stop up to 1e-6 off the maximum.
    #[test]
    fn fits_agree_with_scipy() {
        for case in cases("avu", "families") {
            let (mut x, points) = (numbers(&case["x"]), numbers(&case["points"]));
            x.sort_by(f64::total_cmp);
            for family in Family::ALL {
                let (law, want) = (fit(family, &x).unwrap(), &case["families"][family.name()]);
                for ((v, pdf), cdf) in points.iter().zip(numbers(&want["pdf"])).zip(numbers(&want["cdf"])) {
                    let got = [ln_pdf(&law, *v).exp() / pdf, law.cdf(*v) / cdf];
                    assert_near(got, [1.0; 2], 2e-6, format!("{} {v}", family.name()));
                }
                let likelihood: f64 = x.iter().map(|&v| ln_pdf(&law, v)).sum();
                let best = number(&want["log_likelihood"]);
                assert!(likelihood >= best - 1e-9 && likelihood < best + 1e-6, "{law:?} {likelihood} {best}");
                let d = one_sample(&x, |v| law.cdf(v));
                assert_near([d], [number(&want["ks"])], 1e-6, family.name());
            }
        }
    }

    #[test]
    fn samples_without_a_maximum_are_refused() {
        for family in Family::ALL {
            assert_eq!(fit(family, &[1.0]), None);
            assert_eq!(fit(family, &[0.5; 9]), None);
            assert_eq!(fit(family, &[0.0; 9]), None);
            for bad in [-1.0, f64::NAN, f64::INFINITY, 1e200] {
                assert_eq!(fit(family, &[1.0, bad]), None);
            }
            assert!(fit(family, &[0.0, 1.0, 1e6]).is_some());
        }
    }

    proptest! {
        #[test]
        fn a_factor_moves_the_scale(x in prop::collection::vec(0.01..5.0_f64, 3..60), factor in 0.1..10.0_f64) {
            let scaled: Vec<f64> = x.iter().map(|x| x * factor).collect();
            for family in Family::ALL {
                let (Some(a), Some(b)) = (fit(family, &x), fit(family, &scaled)) else { continue };
                for v in [0.05, 0.5, 3.0] {
                    prop_assert!((a.cdf(v) - b.cdf(v * factor)).abs() < 1e-8, "{:?} {:?}", a, b);
                }
            }
        }

        #[test]
        fn a_density_is_the_slope_of_its_distribution_function(first in 0.3..4.0_f64, scale in 0.3..3.0_f64, x in 0.2..4.0_f64) {
            for family in Family::ALL {
                let law = Fitted { family, first, scale };
                let slope = (law.cdf(x + 1e-5) - law.cdf(x - 1e-5)) / 2e-5;
                prop_assert!((slope - ln_pdf(&law, x).exp()).abs() < 1e-6, "{:?} {} {}", law, slope, ln_pdf(&law, x).exp());
            }
        }
    }
}
