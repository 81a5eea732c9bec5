//! `effective-particles`: effective number of the tracker's particles as a share of all.
//!
//! ```text
//! E = 1 / (N sum_n w(n)^2)
//! ```
//!
//! `w` are the N weights before resampling, which sum to 1. `E` has no unit and lies between 1 / N (one particle has
//! everything) and 1 (all are equal, also in the first frame). Of a correlation tracker, `w` is its response map
//! read as a density, and N the number of its cells.
//!
//! Which values are good is the option `good`, with the default and for the reasons of [`super::particle_entropy`]: the two
//! rank clouds almost alike, but this one is ruled by the largest weights.
//!
//! Source: Kong, Liu and Wong, "Sequential imputations and Bayesian missing data problems", JASA 89(425), 1994; a filter
//! resamples where this is low. Choice: the default of `good`.

use super::causal::Causal;
use super::particle_entropy::Params;
use super::{Facts, Observation, Signal};
use crate::plugin::{Entry, ParamError, Plugin};

pub(crate) const ENTRY: Entry<dyn Signal> = Entry::of::<EffectiveParticles>(
    "effective-particles",
    1,
    "effective number of the tracker's particles as a share of all",
)
.example("{ good = \"low\" }");

/// The share with checked parameters.
#[derive(Clone)]
pub struct EffectiveParticles(Params);

impl Plugin for EffectiveParticles {
    type Params = Params;

    fn make(params: Params) -> Result<Self, ParamError> {
        Ok(Self(params))
    }
}

impl Causal for EffectiveParticles {
    type Memory = ();

    fn facts(&self) -> Facts {
        self.0.good.facts()
    }

    fn push(&self, (): &mut (), observation: &Observation<'_>) -> f64 {
        observation.state.posterior.as_ref().map_or(f64::NAN, |m| m.effective_samples / m.samples)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::signal::testing::values_of_weights;

    // By hand: 1 / (4 * 1), 1 / (4 * 1/2), 1 / (4 * 3/8), 1 / (4 * 1/4).
    #[test]
    fn shares_by_hand() {
        let clouds = [[1.0, 0.0, 0.0, 0.0], [0.5, 0.0, 0.5, 0.0], [0.5, 0.25, 0.25, 0.0], [0.25; 4]];
        let got = values_of_weights(&ENTRY, &clouds);
        for (got, want) in got.iter().zip([0.25, 0.5, 2.0 / 3.0, 1.0]) {
            assert!((got - want).abs() < 1e-15, "{got} {want}");
        }
    }
}
