//! Incremental visual tracking (Ross, Lim, Lin and Yang, "Incremental learning for robust visual tracking",
//! IJCV 77, 2008, sections 3.2 to 3.4): [`super::sparse_prototypes`] without its model of occlusion.
//!
//! ```text
//! L_i = exp(-|d - U U'd|^2 / c)         d = mu - y_i, high is good; the estimate has the highest
//! ```
//!
//! Everything else, from candidates and posterior to units, is as there; all estimates are learned unchanged.
//! Choices: the defaults are those of SP, so that both trackers differ only in the L1 term; Ross et al.
//! recommend `forgetting = 0.95`. Their prior of the next state is the same Gaussian, from the last estimate
//! instead of from weighted particles, as in their program's default, and the likelihood has no factor for
//! the distance within the subspace.

use super::affine_candidates::{self, check_noise};
use super::sparse_prototypes::{self, Tracking};
use crate::tracker::prelude::*;

/// Parameters of the tracker.
#[derive(Debug, Clone, SmartDefault, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Params {
    /// Number of candidates per frame, from 2 to 10000.
    #[default(600)]
    pub samples: usize,
    /// Standard deviations of the candidates' noise in x, y, s, theta, r and phi, each from 0 to 1000.
    #[default([4.0, 4.0, 0.02, 0.02, 0.005, 0.001])]
    pub noise: [f64; 6],
    /// Scale `c` of the likelihood, from 0.0001 to 1000.
    #[default(0.25)]
    pub likelihood_scale: f64,
    /// Maximum number of basis vectors, from 1 to 256.
    #[default(16)]
    pub max_basis: usize,
    /// Number of windows that are learned together, from 1 to 1000.
    #[default(5)]
    pub batch: usize,
    /// Weight of old windows when new ones are learned, above 0 and at most 1.
    #[default(1.0)]
    pub forgetting: f64,
}

impl PlainParams for Params {
    const RANGES: &'static [Range] = &[
        affine_candidates::SAMPLES,
        affine_candidates::NOISE,
        sparse_prototypes::LIKELIHOOD_SCALE,
        sparse_prototypes::MAX_BASIS,
        sparse_prototypes::BATCH,
        sparse_prototypes::FORGETTING,
    ];

    fn check(&self) -> Result<(), ParamError> {
        check_noise(&self.noise)
    }
}

/// IVT in the list of trackers.
pub const ENTRY: Entry<dyn TrackerConfig> =
    Entry::of::<Params>("ivt", 1, "principal components of the target, learned as it goes");

impl TrackerConfig for Params {
    fn facts(&self) -> Facts {
        Facts::SAMPLES
    }

    fn start(&self, context: &RunContext<'_>, frame: &Frame, region: &Region) -> StartResult {
        let params = sparse_prototypes::Params {
            samples: self.samples,
            noise: Some(self.noise),
            likelihood_scale: self.likelihood_scale,
            max_basis: self.max_basis,
            batch: self.batch,
            forgetting: self.forgetting,
            ..sparse_prototypes::Params::default()
        };
        Tracking::start(ENTRY.kind, params, false, context.seed, frame, region)
    }
}
