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
//! Which values are good depends on how a tracker fails, so it is an option (`good`). A particle filter that sees nothing like
//! its target gives all particles about the same likelihood, as does a flat response map: the default is that low
//! values are good. A filter whose particles nearly all miss a target that is still in sight has one particle
//! with everything; for that failure high values are good.
//!
//! Source: the standard measure of the evenness of weights; none for failures of trackers. Choices: the base, so that trackers
//! with different N can be compared; the default of `good`.

use super::causal::Causal;
use super::{Direction, Facts, Observation, Reads, Signal};
use crate::plugin::{Entry, PlainParams};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

pub(crate) const ENTRY: Entry<dyn Signal> = Entry::of::<Params>(
    "particle-entropy",
    1,
    "entropy of the weights of the tracker's particles, relative to equal weights",
)
.example("{ good = \"low\" }");

/// Values that speak for a tracker at its target.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Good {
    /// Low ones: few particles have the weight.
    #[default]
    Low,
    /// High ones: weights are even.
    High,
}

impl Good {
    /// Properties of the values of a measure of the weights.
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
    /// Values that speak for a tracker at its target.
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::signal::testing::values_of_weights;

    // By hand: two of four particles share the weight, ln 2 / ln 4; weights 1/2, 1/4, 1/4, 0 have 1.5 ln 2 / ln 4.
    #[test]
    fn entropies_by_hand() {
        let clouds = [[1.0, 0.0, 0.0, 0.0], [0.5, 0.0, 0.5, 0.0], [0.5, 0.25, 0.25, 0.0], [0.25; 4]];
        let got = values_of_weights(&ENTRY, &clouds);
        for (got, want) in got.iter().zip([0.0, 0.5, 0.75, 1.0]) {
            assert!((got - want).abs() < 1e-15, "{got} {want}");
        }
    }

    #[test]
    fn the_option_turns_the_direction() {
        let direction = |text: &str| ENTRY.build_from_text(text).unwrap().facts().direction;
        assert_eq!(direction("{}"), Direction::LowerIsBetter);
        assert_eq!(direction("{ good = \"high\" }"), Direction::HigherIsBetter);
    }
}
