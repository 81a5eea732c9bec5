//! A fixed number of affine windows around the last estimate, with weights and moments. Shared by trackers
//! with sparse appearance models.
//!
//! ```text
//! g_i = g + diag(d) n_i,  n_i ~ N(0, I),  i = 1..N          g: the last estimate, as in `image::warp`
//! w_i = L_i / sum L
//! m = sum w g_i,  C = sum w (g_i - m)(g_i - m)'              of the components with d > 0, in their order
//! ```
//!
//! Only the estimate is carried over from frame to frame: the covariance tells how sharp the
//! likelihood is around it, not how uncertainty has grown. Components without noise are left
//! out, since their variance of 0 would make every covariance singular.

use super::{Moments, first_largest};
use crate::image::Frame;
use crate::image::warp::{Geometry, Template};
use crate::num::particles::posterior;
use crate::plugin::{ParamError, Range};
use rand::{Rng, RngExt};
use rand_distr::StandardNormal;

/// Side of the square template, in pixels.
pub const SIDE: usize = 32;
/// Template of all candidates.
pub const TEMPLATE: Template = Template { width: SIDE, height: SIDE };
/// Number of pixels in the template.
pub const PIXELS: usize = SIDE * SIDE;

/// Bounds of the target's sides, in pixels.
#[derive(Debug, Clone, Copy)]
pub struct SideLimits {
    shortest: f64,
    longest: f64,
}

impl SideLimits {
    /// Limits from 1 pixel to four times the frame's longer side.
    pub fn of(frame: &Frame) -> Self {
        Self { shortest: 1.0, longest: 4.0 * frame.width().max(frame.height()) as f64 }
    }

    /// The limits with another least side, at most the largest one.
    pub fn at_least(self, side: f64) -> Self {
        Self { shortest: side.min(self.longest), ..self }
    }

    /// Geometry with its sides clamped to the limits.
    pub fn keep(&self, [x, y, s, theta, r, phi]: Geometry) -> Geometry {
        let width = (s * SIDE as f64).clamp(self.shortest, self.longest);
        // The aspect is exact where the height is within its limits.
        let aspect = r.clamp(self.shortest / width, self.longest / width);
        [x, y, width / SIDE as f64, theta, aspect, phi]
    }
}

/// Candidates, and the noise by which they are drawn.
#[derive(Debug, Clone)]
pub struct Candidates {
    /// Geometries of the N candidates.
    pub states: Vec<Geometry>,
    deviations: Geometry,
    /// Indices of the components with noise.
    moving: Vec<usize>,
}

impl Candidates {
    /// Creates `n` candidates, all 0 until they are drawn.
    pub fn new(n: usize, deviations: Geometry) -> Self {
        let moving = (0..6).filter(|&k| deviations[k] > 0.0).collect();
        Self { states: vec![[0.0; 6]; n], deviations, moving }
    }

    /// Draws all candidates around an estimate, in order, with six normal numbers each.
    pub fn draw(&mut self, around: &Geometry, limits: &SideLimits, rng: &mut impl Rng) {
        for state in &mut self.states {
            let noise: Geometry = std::array::from_fn(|_| rng.sample(StandardNormal));
            *state = limits.keep(std::array::from_fn(|k| around[k] + self.deviations[k] * noise[k]));
        }
    }

    /// Moments of the candidates with these weights, whose sum is 1.
    pub fn moments(&self, weights: &[f64], likelihood: f64) -> Moments {
        Moments::of(&posterior(&self.states, weights), weights, &self.moving, likelihood)
    }

    /// Moments in the first frame: all candidates at the annotation, with equal weights.
    pub fn certain(&self, at: &Geometry, likelihood: f64) -> Moments {
        let d = self.moving.len();
        let samples = self.states.len() as f64;
        Moments {
            mean: self.moving.iter().map(|&k| at[k]).collect(),
            covariance: vec![0.0; d * d],
            effective_samples: samples,
            samples,
            entropy: 1.0,
            likelihood,
            particles: Vec::new(),
        }
    }
}

/// Weights of sum 1 from finite log-likelihoods, and the index of the first best one.
pub fn weigh(logarithms: &[f64]) -> (Vec<f64>, usize) {
    let best = first_largest(logarithms.iter().copied());
    // Relative to the best, so that the sum cannot vanish.
    let weights: Vec<f64> = logarithms.iter().map(|l| (l - logarithms[best]).exp()).collect();
    let sum: f64 = weights.iter().sum();
    (weights.into_iter().map(|w| w / sum).collect(), best)
}

/// Range of the number of candidates.
pub const SAMPLES: Range = Range::within("samples", 2.0, 10_000.0);

/// Range of the deviations of the noise.
pub const NOISE: Range = Range::within("noise", 0.0, 1000.0);

/// Refuses noise in which all deviations are 0.
pub fn check_noise(noise: &Geometry) -> Result<(), ParamError> {
    let moves = noise.iter().any(|d| *d != 0.0);
    ParamError::unless(moves, "noise", "six deviations from 0 to 1000, not all 0", format!("{noise:?}"))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::num::seed;
    use trackfail_testing::assert_near;

    // python3: import numpy as np; g=np.array([[3,5,.9,.1],[4,2,1.1,-.2],[7,3,1.,.4]]); w=np.array([.5,.3,.2])
    // m=w@g; print(m); C=(w*(g-m).T)@(g-m); print(C[np.ix_([0,1,3],[0,1,3])]); print(1/(w@w)); print(-(w@np.log(w))/np.log(3))
    #[test]
    fn moments_agree_with_numpy() {
        let mut candidates = Candidates::new(3, [4.0, 4.0, 0.0, 0.02, 0.0, 0.0]);
        candidates.states = vec![
            [3.0, 5.0, 0.9, 0.1, 1.0, 0.0],
            [4.0, 2.0, 1.1, -0.2, 1.0, 0.0],
            [7.0, 3.0, 1.0, 0.4, 1.0, 0.0],
        ];
        let m = candidates.moments(&[0.5, 0.3, 0.2], 0.25);
        assert_near(m.mean, [4.1, 3.7, 0.07], 1e-12, "mean");
        assert_near(m.covariance, COVARIANCE.as_flattened(), 1e-12, "covariance");
        let others = [m.effective_samples, m.likelihood, m.samples, m.entropy];
        assert_near(others, [2.6315789473684212, 0.25, 3.0, 0.9372305632161295], 1e-12, "others");
    }
    const COVARIANCE: [[f64; 3]; 3] = [
        [2.29, -1.07, 0.18300000000000005],
        [-1.07, 1.81, 0.11099999999999999],
        [0.18300000000000002, 0.11099999999999999, 0.04410000000000001],
    ];

    #[test]
    fn weights_are_shares_of_the_likelihood() {
        let (weights, best) = weigh(&[-1000.0, -999.0, -5000.0, -999.0]);
        let e = 1.0_f64.exp();
        assert_near(weights, [1.0, e, 0.0, e].map(|l| l / (1.0 + 2.0 * e)), 1e-15, "");
        assert_eq!(best, 1);
    }

    // Standard errors of a deviation from N draws: 1 / sqrt(2 N).
    #[test]
    fn candidates_have_the_noise_asked_for() {
        let deviations = [4.0, 3.0, 0.02, 0.01, 0.005, 0.001];
        let mut candidates = Candidates::new(10_000, deviations);
        let limits = SideLimits::of(&Frame::new(320, 240, vec![0; 3 * 320 * 240]));
        let around = [100.0, 80.0, 1.5, 0.2, 0.8, 0.0];
        candidates.draw(&around, &limits, &mut seed::rng(3));
        let m = candidates.moments(&vec![1e-4; 10_000], 0.0);
        for (k, d) in deviations.into_iter().enumerate() {
            assert!((m.mean[k] - around[k]).abs() < 5.0 * d / 100.0, "{k}");
            assert!((m.covariance[7 * k].sqrt() / d - 1.0).abs() < 0.04, "{k}");
        }
        let least = limits.keep([0.0, 0.0, -3.0, 0.0, 1e9, 0.0]);
        assert_eq!((least[2] * 32.0, least[2] * least[4] * 32.0), (1.0, 1280.0));
        let least = limits.at_least(8.0).keep([0.0, 0.0, 0.1, 0.0, 0.5, 0.0]);
        assert_eq!((least[2] * 32.0, least[2] * least[4] * 32.0), (8.0, 8.0));
    }
}
