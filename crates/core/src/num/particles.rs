//! Weighted particles with any kind of state: diffusion, weights, moments and resampling.
//!
//! A cloud is N states of D numbers with weights that sum to 1. A frame of a bootstrap filter is
//! [`Cloud::diffuse`], [`Cloud::weigh`], [`Cloud::posterior`], [`Cloud::resample`].

use rand::{Rng, RngExt};
use serde::{Deserialize, Serialize};

/// Scheme by which the next generation is drawn.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Resampling {
    /// One random offset and N equal steps: a particle gets `N w` children, rounded up or down.
    Systematic,
    /// N independent draws.
    Multinomial,
}

/// N weighted particles; weights sum to 1.
#[derive(Debug, Clone)]
pub struct Cloud<const D: usize> {
    /// State of each particle.
    pub states: Vec<[f64; D]>,
    /// Weight of each particle; the sum is 1.
    pub weights: Vec<f64>,
    next: Vec<[f64; D]>,
    parents: Vec<usize>,
}

/// Mean and covariance of a cloud.
#[derive(Debug, Clone, PartialEq)]
pub struct Posterior<const D: usize> {
    /// Mean `m = sum w x`.
    pub mean: [f64; D],
    /// Covariance `sum w (x - m)(x - m)'`, by row.
    pub covariance: [[f64; D]; D],
}

impl<const D: usize> Cloud<D> {
    /// Creates a cloud of `n` (at least 1) equal particles of equal weight.
    pub fn new(state: [f64; D], n: usize) -> Self {
        let n = n.max(1);
        Self {
            states: vec![state; n],
            weights: vec![1.0 / n as f64; n],
            next: Vec::with_capacity(n),
            parents: Vec::with_capacity(n),
        }
    }

    /// Adds noise with the given standard deviations, using D draws of `normal` (standard normal) per
    /// particle. Each state is then passed through `keep`, which clamps it.
    pub fn diffuse(
        &mut self,
        deviations: &[f64; D],
        keep: impl Fn([f64; D]) -> [f64; D],
        mut normal: impl FnMut() -> f64,
    ) {
        for state in &mut self.states {
            for (s, d) in state.iter_mut().zip(deviations) {
                *s += d * normal();
            }
            *state = keep(*state);
        }
    }

    /// Multiplies weights by likelihoods (one per particle, at least 0) and normalizes them.
    ///
    /// A common factor of all likelihoods has no effect; the caller chooses it so that they do not underflow.
    /// If the sum is 0 nevertheless, all weights become equal.
    pub fn weigh(&mut self, likelihoods: impl IntoIterator<Item = f64>) {
        for (w, likelihood) in self.weights.iter_mut().zip(likelihoods) {
            *w *= likelihood;
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

    /// Weighted mean and covariance, without correction for the number of particles.
    pub fn posterior(&self) -> Posterior<D> {
        posterior(&self.states, &self.weights)
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

/// Weighted mean and covariance of at least one state, without correction for their number. Weights must sum
/// to 1.
pub fn posterior<const D: usize>(states: &[[f64; D]], weights: &[f64]) -> Posterior<D> {
    // Relative to the first particle, so that equal particles have that mean and covariance 0 exactly.
    let first = states[0];
    let mut mean = first;
    for (state, w) in states.iter().zip(weights) {
        for (k, m) in mean.iter_mut().enumerate() {
            *m += w * (state[k] - first[k]);
        }
    }
    let mut covariance = [[0.0; D]; D];
    for (state, w) in states.iter().zip(weights) {
        let d: [f64; D] = std::array::from_fn(|k| state[k] - mean[k]);
        for i in 0..D {
            for j in i..D {
                covariance[i][j] += w * d[i] * d[j];
            }
        }
    }
    for i in 1..D {
        let (above, row) = covariance.split_at_mut(i);
        for (lower, upper) in row[0].iter_mut().zip(above) {
            *lower = upper[i];
        }
    }
    Posterior { mean, covariance }
}

/// Effective number `1 / sum w^2` of N weights that sum to 1, from 1 to N.
pub fn effective_number(weights: &[f64]) -> f64 {
    let squares: f64 = weights.iter().map(|w| w * w).sum();
    squares.recip().clamp(1.0, weights.len().max(1) as f64)
}

/// Entropy `-sum w ln w / ln N` of N weights that sum to 1: 0 if one has all the weight, 1 if all are equal.
/// For a single one it is 1.
pub fn entropy(weights: &[f64]) -> f64 {
    if weights.len() < 2 {
        return 1.0;
    }
    let sum: f64 = weights.iter().filter(|w| **w > 0.0).map(|w| w * w.ln()).sum();
    (-sum / (weights.len() as f64).ln()).clamp(0.0, 1.0)
}

/// Parents at `(k + offset) / N` of the cumulated weights, for k from 0, with `offset` in `[0, 1)`.
pub fn systematic(weights: &[f64], offset: f64, parents: &mut Vec<usize>) {
    let n = weights.len();
    pick(weights, (0..n).map(|k| (k as f64 + offset) / n as f64), parents);
}

/// Parents at N sorted uniform numbers, made of N + 1 draws of `exponential` (standard exponential).
pub fn multinomial(weights: &[f64], mut exponential: impl FnMut() -> f64, parents: &mut Vec<usize>) {
    let mut sum = 0.0;
    let next = |_| {
        sum += exponential();
        sum
    };
    let spacings: Vec<f64> = (0..=weights.len()).map(next).collect();
    // The last sum ends the interval; it is above 0 but for draws that are all 0.
    let end = sum.max(f64::MIN_POSITIVE);
    pick(weights, spacings[..weights.len()].iter().map(|s| s / end), parents);
}

/// Index of the particle into whose share of the cumulated weights each of the ascending `places` falls.
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::num::seed;
    use proptest::prelude::*;

    // Worked by hand: the cumulated weights are 1/8, 1/8, 5/8, 1 and the places 1/8, 3/8, 5/8, 7/8.
    #[test]
    fn a_place_on_an_edge_belongs_to_the_next_particle_with_a_weight() {
        let mut parents = vec![];
        systematic(&[0.125, 0.0, 0.5, 0.375], 0.5, &mut parents);
        assert_eq!(parents, [2, 2, 3, 3]);
        // Weights whose sum was rounded down, here by far: the places are 0.3, 0.63 and 0.97.
        systematic(&[0.5, 0.25, 0.0], 0.9, &mut parents);
        assert_eq!(parents, [0, 1, 1]);
    }

    #[test]
    fn multinomial_draws_have_the_weights_as_frequencies() {
        let weights = [0.05, 0.0, 0.4, 0.25, 0.3];
        let mut rng = seed::rng(4);
        let (mut counts, mut parents) = ([0.0; 5], vec![]);
        let draws = 40_000;
        let mut squares = 0.0;
        for _ in 0..draws {
            multinomial(&weights, || -(1.0 - rng.random::<f64>()).ln(), &mut parents);
            assert!(parents.is_sorted() && parents.len() == 5);
            parents.iter().for_each(|&p| counts[p] += 1.0);
            squares += (parents.iter().filter(|&&p| p == 2).count() as f64 - 2.0).powi(2);
        }
        let n = 5.0 * f64::from(draws);
        for (count, w) in counts.iter().zip(weights) {
            // Five standard errors of a frequency.
            assert!((count / n - w).abs() <= 5.0 * (w * (1.0 - w) / n).sqrt(), "{count} {w}");
        }
        // Binomial variance N w (1 - w) = 1.2; systematic draws would have 0 here. The fourth moment of the
        // binomial makes the standard error of the mean square less than 0.01.
        assert!((squares / f64::from(draws) - 1.2).abs() < 0.05);
    }

    #[test]
    fn degenerate_weights_are_defined() {
        let state = [1e9, -7.5, 3.0, 4.0, 0.1];
        let mut cloud = Cloud::new(state, 3);
        assert_eq!(cloud.posterior(), Posterior { mean: state, covariance: [[0.0; 5]; 5] });
        assert!((effective_number(&cloud.weights) - 3.0).abs() < 1e-12);
        // The only likelihood above 0 meets weight 0: all become equal.
        cloud.weights = vec![0.0, 1.0, 0.0];
        cloud.weigh([1.0, 0.0, 0.2]);
        assert_eq!(cloud.weights, [1.0 / 3.0; 3]);
        // Without underflow there is no reset, however small all likelihoods are.
        cloud.weigh([1e-300, 3e-300, 1e-300]);
        assert!((cloud.weights[1] - 0.6).abs() < 1e-12);
        // One particle has everything.
        cloud.weights = vec![0.0, 0.0, 1.0];
        assert_eq!(effective_number(&cloud.weights), 1.0);
        cloud.states[2][0] = 5.0;
        let posterior = cloud.posterior();
        assert_eq!((posterior.mean, posterior.covariance), (cloud.states[2], [[0.0; 5]; 5]));
        cloud.resample(Resampling::Systematic, &mut seed::rng(1));
        assert_eq!(cloud.states, [cloud.states[0]; 3]);
        assert_eq!(cloud.states[0][0], 5.0);
    }

    // python3: import numpy as np; from scipy.stats import entropy; w = np.array([.5, .25, 0, .125, .125])
    // entropy(w) / np.log(5), 1 / (w @ w)                                                          SciPy 1.17.1
    #[test]
    fn entropy_agrees_with_scipy() {
        let weights = [0.5, 0.25, 0.0, 0.125, 0.125];
        assert!((entropy(&weights) - ENTROPY).abs() < 1e-15);
        assert!((effective_number(&weights) - 2.909_090_909_090_909).abs() < 1e-15);
        assert_eq!([entropy(&[1.0]), entropy(&[0.0, 1.0, 0.0]), entropy(&[0.25; 4])], [1.0, 0.0, 1.0]);
    }
    const ENTROPY: f64 = 0.753_683_976_628_437_9;

    fn clouds() -> impl Strategy<Value = Cloud<5>> {
        let particle = (prop::array::uniform5(-50.0..50.0), prop_oneof![Just(0.0), 1e-12..1.0, Just(1.0)]);
        prop::collection::vec(particle, 1..40).prop_map(|particles| {
            let mut cloud = Cloud::new([0.0; 5], particles.len());
            (cloud.states, cloud.weights) = particles.into_iter().unzip();
            cloud.weigh([1.0; 40]);
            cloud
        })
    }

    proptest! {
        #[test]
        fn weights_sum_to_one_and_the_covariance_is_semidefinite(
            mut cloud in clouds(),
            likelihoods in prop::collection::vec(0.0..=1.0, 40),
            direction in prop::array::uniform5(-1.0..1.0_f64),
        ) {
            cloud.weigh(likelihoods);
            prop_assert!((cloud.weights.iter().sum::<f64>() - 1.0).abs() < 1e-12);
            let c = cloud.posterior().covariance;
            let pairs = || (0..25).map(|k| (k / 5, k % 5));
            prop_assert!(pairs().all(|(i, j)| c[i][j] == c[j][i]));
            let form: f64 = pairs().map(|(i, j)| direction[i] * c[i][j] * direction[j]).sum();
            prop_assert!(form >= -1e-9, "{}", form);
            let n = effective_number(&cloud.weights);
            prop_assert!(n >= 1.0 && n <= cloud.states.len() as f64);
            // Jensen: the logarithm of the effective number is at most the entropy.
            let entropy = entropy(&cloud.weights);
            prop_assert!(entropy <= 1.0 && n.ln() <= entropy * (cloud.states.len() as f64).ln() + 1e-9);
        }

        #[test]
        fn systematic_resampling_gives_a_particle_its_share_rounded(cloud in clouds(), offset in 0.0..1.0) {
            let (mut parents, n) = (vec![], cloud.weights.len());
            systematic(&cloud.weights, offset, &mut parents);
            prop_assert!(parents.len() == n && parents.is_sorted());
            for (k, w) in cloud.weights.iter().enumerate() {
                let children = parents.iter().filter(|&&p| p == k).count() as f64;
                prop_assert!((children - w * n as f64).abs() < 1.0 + 1e-9);
                prop_assert!(*w > 0.0 || children == 0.0);
            }
        }
    }
}
