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
//! The option `good` sets which values are good. Its default and reasons are those of
//! [`super::particle_entropy`]: both signals rank clouds almost equally, but this one depends mostly on the
//! largest weights.
//!
//! Source: Kong, Liu and Wong, "Sequential imputations and Bayesian missing data problems", JASA 89(425), 1994; a filter
//! resamples where this is low. Choice: the default of `good`.

use super::particle_entropy::Params;
use crate::signal::prelude::*;

pub(crate) const ENTRY: Entry<dyn Signal> = Entry::of::<EffectiveParticles>(
    "effective-particles",
    1,
    "effective number of the tracker's particles as a share of all",
)
.example("{ good = \"low\" }");

// Without a comment for its schema, which is that of the parameters.
#[derive(Clone, Serialize, Deserialize, JsonSchema)]
#[serde(transparent)]
pub struct EffectiveParticles(Params);

impl PlainParams for EffectiveParticles {}

impl Causal for EffectiveParticles {
    type Memory = ();

    fn facts(&self) -> Facts {
        self.0.good.facts()
    }

    fn push(&self, (): &mut (), observation: &Observation<'_>) -> f64 {
        observation.state.posterior.as_ref().map_or(f64::NAN, |m| m.effective_samples / m.samples)
    }
}
