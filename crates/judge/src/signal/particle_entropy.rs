//! `particle-entropy`: entropy of the weights of the tracker's particles, how evenly they are spread.
//!
//! ```text
//! H = -sum_n w(n) ln w(n) / ln N,      0 ln 0 = 0
//! ```
//!
//! `w` are the N weights before resampling, which sum to 1. `H` has no unit and lies between 0 (one particle has
//! everything) and 1 (all are equal, also in the first frame and for a single particle). Of a correlation tracker, `w` is
//! its response map read as a density, and N the number of its cells.
//!
//! The option `good` sets which values are good, since that depends on how a tracker fails. If nothing
//! resembles the target, all particles have about the same likelihood, as in a flat response map; by default
//! low values are therefore good. If nearly all particles miss a target that is still in sight, one particle
//! has all the weight; for that failure high values are good.
//!
//! Source: the standard measure of the evenness of weights; none for failures of trackers. Choices: the base, so that trackers
//! with different N can be compared; the default of `good`.

use crate::signal::prelude::*;

pub(crate) const ENTRY: Entry<dyn Signal> = Entry::of::<Params>(
    "particle-entropy",
    1,
    "entropy of the weights of the tracker's particles, relative to equal weights",
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

impl Good {
    /// Facts of a measure of the weights.
    pub fn facts(self) -> Facts {
        let direction = match self {
            Self::Low => Direction::LowerIsBetter,
            Self::High => Direction::HigherIsBetter,
        };
        Facts { reads: Reads::Posterior, ..Facts::of(direction, (0.0, 1.0)) }
    }
}

/// Parameters of a measure of the weights.
#[derive(Debug, Clone, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Params {
    /// Values that speak for a tracker on target.
    pub good: Good,
}

impl PlainParams for Params {}

impl Causal for Params {
    type Memory = ();

    fn facts(&self) -> Facts {
        self.good.facts()
    }

    fn push(&self, (): &mut (), observation: &Observation<'_>) -> f64 {
        observation.state.posterior.as_ref().map_or(f64::NAN, |moments| moments.entropy)
    }
}
