//! Mixtures of Gamma distributions: the model of the uncertainty change of a consistent filter
//! (SanMiguel and Cavallaro, CVIU 131, 2015, Eq. 12 and 13), its fit and the choice of its order.
//!
//! ```text
//! gm(v; xi) = sum_k gamma_k f(v; eta_k, theta_k),    k = 1..K,    sum_k gamma_k = 1
//! f(v; eta, theta) = v^(eta - 1) exp(-v / theta) / (theta^eta Gamma(eta)),    v >= 0
//! ```
//!
//! `gamma_k` is [`Component::weight`], `eta_k` [`Component::shape`] (both without a unit), `theta_k`
//! [`Component::scale`] in the unit of the samples. Components are sorted by their mean `eta theta`.
//!
//! * [`Binned`] keeps millions of samples as exact sums on about 20000 cells;
//! * [`fit`] and [`fit_all`] maximize the likelihood for one `K` and for `K = 1..=k_max`;
//! * [`select`] chooses `K` by dAIC and dBIC (Eq. 14 and 15).

mod binned;
mod em;
mod fit;
pub mod select;
mod start;

pub use binned::{Binned, Clipped, FLOOR, SampleError};
pub use fit::{Fit, FitError, FitOptions, fit, fit_all};

use super::special::{gamma_cdf, gamma_survival};
use rand::{Rng, RngExt};
use rand_distr::Distribution;
use serde::{Deserialize, Serialize};

/// Largest shape of a component, at which the standard deviation is 1 % of the mean. A narrower one would fit
/// a repeated value, with unbounded likelihood.
pub const MAX_SHAPE: f64 = 1e4;

/// Least weight of a component in a fit.
pub const MIN_WEIGHT: f64 = 1e-6;

/// Largest number of components of a mixture.
pub const MAX_COMPONENTS: usize = 50;

/// One Gamma distribution of a mixture.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Component {
    /// Share of the mixture, `gamma_k`, above 0; the weights of a mixture sum to 1.
    pub weight: f64,
    /// `eta_k`, above 0 and at most [`MAX_SHAPE`].
    pub shape: f64,
    /// `theta_k`, above 0, in the unit of the samples.
    pub scale: f64,
}

impl Component {
    /// Mean `eta theta`, in the unit of the samples.
    pub fn mean(&self) -> f64 {
        self.shape * self.scale
    }

    /// Variance `eta theta^2`, in the squared unit of the samples.
    pub fn variance(&self) -> f64 {
        self.shape * self.scale * self.scale
    }
}

/// A mixture. [`Mixture::new`] and deserialization check and sort the components.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(try_from = "Unchecked")]
pub struct Mixture {
    /// Components, sorted by mean.
    pub components: Vec<Component>,
}

#[derive(Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
struct Unchecked {
    components: Vec<Component>,
}

impl TryFrom<Unchecked> for Mixture {
    type Error = MixtureError;

    fn try_from(raw: Unchecked) -> Result<Self, MixtureError> {
        Self::new(raw.components)
    }
}

/// Reason why components do not make a mixture.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum MixtureError {
    /// No component, or more than [`MAX_COMPONENTS`].
    #[error("a mixture has 1 to {MAX_COMPONENTS} components, not {0}")]
    Count(usize),
    /// A parameter out of its range.
    #[error(
        "a component needs a weight in (0, 1], a shape in (0, {MAX_SHAPE:e}] and a scale above 0, all finite, not {0:?}"
    )]
    Component(Component),
    /// The weights do not sum to 1.
    #[error("the weights of a mixture sum to 1, not to {0}")]
    Weights(f64),
}

impl Mixture {
    /// Checks the components and sorts them by mean.
    ///
    /// # Errors
    /// An empty or too long list, parameters out of range, and weights whose sum differs from 1 by more than
    /// 1e-6. A smaller difference is kept, so that a mixture is the same after writing and reading.
    pub fn new(mut components: Vec<Component>) -> Result<Self, MixtureError> {
        if components.is_empty() || components.len() > MAX_COMPONENTS {
            return Err(MixtureError::Count(components.len()));
        }
        let fine = |v: f64| v.is_finite() && v > 0.0;
        for c in &components {
            let range =
                c.weight <= 1.0 + 1e-6 && c.shape <= MAX_SHAPE && fine(c.mean()) && fine(c.variance());
            if !(fine(c.weight) && fine(c.shape) && fine(c.scale) && range) {
                return Err(MixtureError::Component(*c));
            }
        }
        let total: f64 = components.iter().map(|c| c.weight).sum();
        if (total - 1.0).abs() > 1e-6 {
            return Err(MixtureError::Weights(total));
        }
        components.sort_by(|a, b| a.mean().total_cmp(&b.mean()).then(a.shape.total_cmp(&b.shape)));
        Ok(Self { components })
    }

    /// Probability of a value up to `v`.
    pub fn cdf(&self, v: f64) -> f64 {
        self.sum(|c| gamma_cdf(v, c.shape, c.scale)).min(1.0)
    }

    /// Probability of a value above `v`, accurate where it is small.
    pub fn survival(&self, v: f64) -> f64 {
        self.sum(|c| gamma_survival(v, c.shape, c.scale)).min(1.0)
    }

    /// Draws a random value.
    pub fn sample<R: Rng + ?Sized>(&self, rng: &mut R) -> f64 {
        let mut left: f64 = rng.random();
        let is_chosen = |c: &&Component| {
            left -= c.weight;
            left < 0.0
        };
        let chosen = self.components.iter().find(is_chosen).or(self.components.last());
        let gamma = chosen.and_then(|c| rand_distr::Gamma::new(c.shape, c.scale).ok());
        gamma.map_or(f64::NAN, |gamma| gamma.sample(rng))
    }

    fn sum(&self, term: impl Fn(&Component) -> f64) -> f64 {
        self.components.iter().map(|c| c.weight * term(c)).sum()
    }
}

#[cfg(test)]
mod tests;
