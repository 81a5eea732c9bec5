//! The particle filter without pictures: particles, their weights, moments and resampling.

use super::histogram::Ellipse;
use rand::{Rng, RngExt};
use serde::{Deserialize, Serialize};

/// How the next generation is drawn.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Resampling {
    /// One random offset and N equal steps: a particle gets `N w` children, rounded up or down.
    Systematic,
    /// N independent draws.
    Multinomial,
}

/// What keeps ellipses within bounds.
#[derive(Debug, Clone, Copy)]
pub struct Limits {
    /// Shortest half axis in pixels.
    pub shortest: f64,
    /// Longest half axis in pixels, not below `shortest`.
    pub longest: f64,
    /// Whether the orientation is brought to `(-pi/2, pi/2]`.
    pub wrap: bool,
}

impl Limits {
    /// The ellipse within the bounds.
    pub fn keep(&self, [x, y, hx, hy, theta]: Ellipse) -> Ellipse {
        let axis = |h: f64| h.min(self.longest).max(self.shortest);
        let half = std::f64::consts::PI;
        let turned = if self.wrap { theta - half * (theta / half - 0.5).ceil() } else { theta };
        [x, y, axis(hx), axis(hy), turned]
    }
}

/// N weighted particles; weights sum to 1.
#[derive(Debug, Clone)]
pub struct Cloud {
    /// States.
    pub states: Vec<Ellipse>,
    /// Weights.
    pub weights: Vec<f64>,
    next: Vec<Ellipse>,
    parents: Vec<usize>,
}

/// Mean and covariance of a cloud.
#[derive(Debug, Clone, PartialEq)]
pub struct Posterior {
    /// `m = sum w x`.
    pub mean: Ellipse,
    /// `sum w (x - m)(x - m)'`, row by row.
    pub covariance: [f64; 25],
}

impl Cloud {
    /// `n` equal particles of equal weight.
    pub fn new(state: Ellipse, n: usize) -> Self {
        let n = n.max(1);
        Self {
            states: vec![state; n],
            weights: vec![1.0 / n as f64; n],
            next: Vec::with_capacity(n),
            parents: Vec::with_capacity(n),
        }
    }

    /// Adds noise of the given standard deviations, five draws of `normal` (standard normal) a particle.
    pub fn diffuse(&mut self, deviations: &Ellipse, limits: &Limits, mut normal: impl FnMut() -> f64) {
        for state in &mut self.states {
            for (s, d) in state.iter_mut().zip(deviations) {
                *s += d * normal();
            }
            *state = limits.keep(*state);
        }
    }

    /// Multiplies weights by the likelihoods `exp((rho - 1) / (2 sigma^2))` and normalises them.
    ///
    /// The likelihoods are taken relative to the best one, which changes nothing but keeps small `sigma`
    /// from underflow. When the sum is still 0 all weights become equal.
    pub fn weigh(&mut self, rho: &[f64], sigma: f64) {
        let best = rho.iter().fold(0.0, |a: f64, &b| a.max(b));
        for (w, r) in self.weights.iter_mut().zip(rho) {
            *w *= likelihood(1.0 + r - best, sigma);
        }
        let sum: f64 = self.weights.iter().sum();
        if sum > 0.0 {
            // A subnormal sum has no finite reciprocal.
            self.weights.iter_mut().for_each(|w| *w /= sum);
        } else {
            self.level();
        }
    }

    fn level(&mut self) {
        let share = 1.0 / self.weights.len() as f64;
        self.weights.fill(share);
    }

    /// Effective number of particles `1 / sum w^2`, from 1 to N.
    pub fn effective(&self) -> f64 {
        let squares: f64 = self.weights.iter().map(|w| w * w).sum();
        squares.recip().clamp(1.0, self.weights.len() as f64)
    }

    /// Weighted mean and covariance, without correction for the number of particles.
    pub fn posterior(&self) -> Posterior {
        // Relative to the first particle, so that equal particles have that mean and covariance 0 exactly.
        let first = self.states[0];
        let mut mean = first;
        for (state, w) in self.states.iter().zip(&self.weights) {
            for (k, m) in mean.iter_mut().enumerate() {
                *m += w * (state[k] - first[k]);
            }
        }
        let mut covariance = [0.0; 25];
        for (state, w) in self.states.iter().zip(&self.weights) {
            let d: Ellipse = std::array::from_fn(|k| state[k] - mean[k]);
            for i in 0..5 {
                for j in i..5 {
                    covariance[5 * i + j] += w * d[i] * d[j];
                }
            }
        }
        for i in 0..5 {
            for j in 0..i {
                covariance[5 * i + j] = covariance[5 * j + i];
            }
        }
        Posterior { mean, covariance }
    }

    /// Draws the next generation; afterwards all weights are equal.
    pub fn resample(&mut self, scheme: Resampling, rng: &mut impl Rng) {
        match scheme {
            Resampling::Systematic => systematic(&self.weights, rng.random(), &mut self.parents),
            Resampling::Multinomial => {
                // 1 - U is in (0, 1], whose logarithm is finite.
                multinomial(&self.weights, || -(1.0 - rng.random::<f64>()).ln(), &mut self.parents);
            }
        }
        self.next.clear();
        self.next.extend(self.parents.iter().map(|&p| self.states[p]));
        std::mem::swap(&mut self.states, &mut self.next);
        self.level();
    }
}

/// Likelihood `exp((rho - 1) / (2 sigma^2))` of a histogram with Bhattacharyya coefficient `rho`.
pub fn likelihood(rho: f64, sigma: f64) -> f64 {
    ((rho - 1.0) / (2.0 * sigma * sigma)).exp()
}

/// Parents at `(k + offset) / N` of the cumulated weights, for k from 0; `offset` in `[0, 1)`.
pub fn systematic(weights: &[f64], offset: f64, parents: &mut Vec<usize>) {
    let n = weights.len();
    pick(weights, (0..n).map(|k| (k as f64 + offset) / n as f64), parents);
}

/// Parents at N sorted uniform numbers, made of N + 1 draws of `exponential` (standard exponential).
pub fn multinomial(weights: &[f64], mut exponential: impl FnMut() -> f64, parents: &mut Vec<usize>) {
    let mut sum = 0.0;
    let spacings: Vec<f64> = (0..=weights.len())
        .map(|_| {
            sum += exponential();
            sum
        })
        .collect();
    // The last sum ends the interval; it is above 0 but for draws that are all 0.
    let end = sum.max(f64::MIN_POSITIVE);
    pick(weights, spacings[..weights.len()].iter().map(|s| s / end), parents);
}

/// The particle into whose share of the cumulated weights each of the ascending `places` falls.
fn pick(weights: &[f64], places: impl Iterator<Item = f64>, parents: &mut Vec<usize>) {
    // Rounding may leave the sum just below the last place, which then is the last particle with a weight.
    let last = weights.iter().rposition(|w| *w > 0.0).unwrap_or(0);
    let (mut at, mut upto) = (0, weights[0]);
    parents.clear();
    parents.extend(places.map(|place| {
        while place >= upto && at < last {
            at += 1;
            upto += weights[at];
        }
        at
    }));
}
