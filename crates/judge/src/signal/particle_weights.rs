//! `particle-entropy` and `effective-particles`: how evenly the weights of the tracker's particles are spread.
//!
//! ```text
//! H = -sum_n w(n) ln w(n) / ln N,      0 ln 0 = 0        particle-entropy
//! E = 1 / (N sum_n w(n)^2)                               effective-particles, the effective number as a share of all
//! ```
//!
//! `w` are the N weights before resampling, which sum to 1. Neither value has a unit. `H` lies between 0 (one particle has
//! everything) and 1 (all are equal, also in the first frame and for a single particle), `E` between 1 / N and 1 in the
//! same cases. Of a correlation tracker, `w` is its response map read as a density, and N the number of its cells.
//!
//! The option `good` sets which values are good, since that depends on how a tracker fails. If nothing
//! resembles the target, all particles have about the same likelihood, as in a flat response map; by default
//! low values are therefore good. If nearly all particles miss a target that is still in sight, one particle
//! has all the weight; for that failure high values are good. Both signals rank clouds almost equally, but `E` depends
//! mostly on the largest weights.
//!
//! Sources: `H` is the standard measure of the evenness of weights; `E` is from Kong, Liu and Wong, "Sequential imputations
//! and Bayesian missing data problems", JASA 89(425), 1994, and a filter resamples where it is low. None is for failures of
//! trackers. Choices: the base of the logarithm, so that trackers with different N can be compared; the default of `good`.

use crate::signal::prelude::*;

pub(crate) const ENTROPY: Entry<dyn Signal> = Entry::of::<Evenness<true>>(
    "particle-entropy",
    1,
    "entropy of the weights of the tracker's particles, relative to equal weights",
)
.example("{ good = \"low\" }");

pub(crate) const EFFECTIVE: Entry<dyn Signal> = Entry::of::<Evenness<false>>(
    "effective-particles",
    1,
    "effective number of the tracker's particles as a share of all",
)
.example("{ good = \"low\" }");

/// Values that speak for a tracker on target.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Good {
    /// Low values: few particles have the weight.
    #[default]
    Low,
    /// High values: weights are even.
    High,
}

/// A measure of the weights: their entropy, or the effective number of particles.
#[derive(Debug, Clone, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Evenness<const ENTROPY: bool> {
    /// Values that speak for a tracker on target.
    pub good: Good,
}

impl<const ENTROPY: bool> PlainParams for Evenness<ENTROPY> {}

impl<const ENTROPY: bool> Causal for Evenness<ENTROPY> {
    type Memory = ();

    fn facts(&self) -> Facts {
        let direction = match self.good {
            Good::Low => Direction::LowerIsBetter,
            Good::High => Direction::HigherIsBetter,
        };
        Facts { reads: Reads::Posterior, ..Facts::of(direction, (0.0, 1.0)) }
    }

    fn push(&self, (): &mut (), observation: &Observation<'_>) -> f64 {
        let Some(cloud) = &observation.state.posterior else { return f64::NAN };
        if ENTROPY { cloud.entropy } else { cloud.effective_samples / cloud.samples }
    }
}
