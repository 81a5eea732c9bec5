//! Masses of a single value, and their power under convolution.

use super::{AccumulationError, MAX_SUM_CELLS, STEP, TAIL};
use crate::num::fourier::{Complex64, LineFourier};
use crate::num::gamma_mixture::{Component, Mixture};
use crate::num::special::{gamma_cdf, gamma_survival, ln_gamma};

/// Nodes in `(0, 1)` and weights of the Gauss-Legendre rule of four points.
const NODES: [f64; 4] =
    [0.069_431_844_202_973_71, 0.330_009_478_207_571_87, 0.669_990_521_792_428_1, 0.930_568_155_797_026_3];
const WEIGHTS: [f64; 4] =
    [0.173_927_422_568_726_93, 0.326_072_577_431_273_07, 0.326_072_577_431_273_07, 0.173_927_422_568_726_93];

/// Number of cells near a possible pole at 0 whose masses always come from the distribution function.
const NEAR: usize = 64;

/// Least standard deviation, in cells, of components for which the rule is used. Its relative error is then
/// below 1e-14.
const WIDE: f64 = 8.0;

/// Survival function below which a component is cut off.
const NOTHING: f64 = 1e-18;

/// Masses of the first `cells` cells. Beyond the first ones, densities are integrated by a rule of four
/// points, whose logarithms all components share. This is several times faster than distribution functions.
pub(super) fn mixture_masses(mixture: &Mixture, cells: usize) -> Vec<f64> {
    let mut masses = vec![0.0; cells];
    let near = NEAR.min(cells);
    let (wide, narrow): (Vec<Component>, Vec<Component>) =
        mixture.components.iter().partition(|c| c.variance().sqrt() >= WIDE * STEP);
    for c in &narrow {
        differences(c, &mut masses);
    }
    for c in &wide {
        differences(c, &mut masses[..near]);
    }
    // Constant, power and rate of each density, and the cell at which it is cut off.
    let density = |c: &Component| {
        let constant = (c.weight * STEP).ln() - c.shape * c.scale.ln() - ln_gamma(c.shape);
        ([constant, c.shape - 1.0, 1.0 / c.scale], reach(c, cells))
    };
    let wide: Vec<([f64; 3], usize)> = wide.iter().map(density).collect();
    let end = wide.iter().map(|w| w.1).max().unwrap_or(0);
    for (k, mass) in masses.iter_mut().enumerate().take(end).skip(near) {
        for (node, weight) in NODES.iter().zip(WEIGHTS) {
            let v = (k as f64 + node) * STEP;
            let ln = v.ln();
            for ([constant, power, rate], end) in &wide {
                if k < *end {
                    *mass += weight * (constant + power * ln - rate * v).exp();
                }
            }
        }
    }
    masses
}

/// Adds the masses of a component: differences of its distribution function below the mean, and of its
/// survival function above.
fn differences(c: &Component, masses: &mut [f64]) {
    let middle = c.mean();
    let (mut cdf, mut survival) = (0.0, 1.0);
    for (k, mass) in masses.iter_mut().enumerate() {
        let v = (k + 1) as f64 * STEP;
        let before = (cdf, survival);
        cdf = gamma_cdf(v, c.shape, c.scale);
        survival = gamma_survival(v, c.shape, c.scale);
        *mass += c.weight * if v < middle { cdf - before.0 } else { before.1 - survival };
        if survival < NOTHING {
            break;
        }
    }
}

/// Cell above which the mass of a component is negligible.
fn reach(c: &Component, cells: usize) -> usize {
    let mut end = 1;
    while end < cells && gamma_survival(end as f64 * STEP, c.shape, c.scale) > NOTHING {
        end *= 2;
    }
    end.min(cells)
}

/// Masses of the sum of `length` values.
pub(super) fn power(one: &[f64], length: usize) -> Result<Vec<f64>, AccumulationError> {
    let full = (one.len() - 1).saturating_mul(length) + 1;
    let cells = full.min(needed(one, length));
    if cells > MAX_SUM_CELLS {
        return Err(AccumulationError::TooWide);
    }
    let size = transform_size(cells.max(one.len()));
    let exponent = u32::try_from(length).map_err(|_| AccumulationError::Length(length))?;
    let mut fourier = LineFourier::new(size);
    let mut masses = vec![0.0; size];
    masses[..one.len()].copy_from_slice(one);
    let mut spectrum = vec![Complex64::default(); fourier.spectrum_len()];
    fourier.forward(&mut masses, &mut spectrum);
    for value in &mut spectrum {
        *value = value.powu(exponent);
    }
    fourier.backward(&mut spectrum, &mut masses);
    masses.truncate(full);
    for mass in &mut masses {
        *mass = (*mass / size as f64).max(0.0);
    }
    Ok(masses)
}

/// Least `2^a 3^b >= cells` with `a >= 1`, a size with fast transforms.
fn transform_size(cells: usize) -> usize {
    let mut best = cells.next_power_of_two().max(2);
    let mut threes = 3;
    while threes < best {
        best = best.min(threes * cells.div_ceil(threes).next_power_of_two().max(2));
        threes *= 3;
    }
    best
}

/// Number of cells `n` with `P(S > n) <= TAIL`, by Chernoff's bound: `ln P(S >= n) <= L ln E e^(t X) - t n`
/// for all `t > 0`. Any `t` gives a valid `n`, so the search for the best one need not be exact.
fn needed(one: &[f64], length: usize) -> usize {
    let length = length as f64;
    let bound = |log_t: f64| {
        let t = log_t.exp();
        // Horner from above, with the largest exponent taken out: one e^(t k) may overflow.
        let decay = (-t).exp();
        let sum = one.iter().fold(0.0, |sum, m| sum * decay + m);
        let log_moment = sum.ln() + t * (one.len() - 1) as f64;
        (length * log_moment - TAIL.ln()) / t
    };
    // Golden section; the bound falls and then rises. From a scale longer than any sum to a single cell.
    let golden = 0.618_033_988_749_895;
    let (mut low, mut high) = (-(length * one.len() as f64).ln() - 1.0, 0.0_f64);
    let (mut a, mut b) = (high - golden * (high - low), low + golden * (high - low));
    let (mut at_a, mut at_b) = (bound(a), bound(b));
    for _ in 0..14 {
        if at_a <= at_b {
            (high, b, at_b) = (b, a, at_a);
            a = high - golden * (high - low);
            at_a = bound(a);
        } else {
            (low, a, at_a) = (a, b, at_b);
            b = low + golden * (high - low);
            at_b = bound(b);
        }
    }
    // One cell more for the sum that is exactly there. A bound that is no number becomes the largest.
    let least = at_a.min(at_b) + 2.0;
    if least.is_finite() { least.max(1.0) as usize } else { usize::MAX }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn transforms_are_little_longer_than_needed() {
        assert_eq!([1, 5, 6, 7, 97, 1000, 34_658].map(transform_size), [2, 6, 6, 8, 108, 1024, 34_992]);
    }

    proptest! {
        // Term by term, Eq. 17.
        #[test]
        fn a_power_is_repeated_convolution(raw in prop::collection::vec(0.0..1.0_f64, 1..12), length in 2..7_usize) {
            let all: f64 = raw.iter().sum::<f64>() + 1e-3;
            let one: Vec<f64> = raw.iter().map(|m| m / all).collect();
            let mut want = one.clone();
            for _ in 1..length {
                let mut next = vec![0.0; want.len() + one.len() - 1];
                for (i, a) in want.iter().enumerate() {
                    for (j, b) in one.iter().enumerate() {
                        next[i + j] += a * b;
                    }
                }
                want = next;
            }
            let got = power(&one, length).unwrap();
            prop_assert!(got.len() <= want.len());
            for (j, want) in want.iter().enumerate() {
                let got = got.get(j).copied().unwrap_or(0.0);
                prop_assert!((got - want).abs() < 2e-10, "{} {} {}", j, got, want);
            }
        }
    }
}
