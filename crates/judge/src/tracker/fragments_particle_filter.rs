//! A reconstruction of the fragments tracker (FT) that SanMiguel and Cavallaro (CVIU 131, 2015) judge
//! beside their particle filter: fragments with reliabilities in a particle filter, after Erdem, Dubuisson
//! and Bloch ("Fragments based tracking with adaptive cue integration", CVIU 116, 2012).
//!
//! That this is the tracker meant is likely, not certain; its settings and its code are not public.
//! Everything below is built from its abstract, from the paper's sentence ("fragments adaptively selected
//! over time which are embedded in the PF framework", with a slowly adapting model) and from FragTrack
//! (Adam, Rivlin and Shimshoni, CVPR 2006), whose fragments it uses. Results are those of this
//! reconstruction.
//!
//! ```text
//! x[t] = x[t-1] + n,  n ~ N(0, diag(d)^2)              state (x, y), N particles
//! d_k^2(x) = 1 - sum_u sqrt(p_ku(x) q_ku)              p_k, q_k: histograms of fragment k at x, at the start
//! L_k(x) = exp(-d_k^2 / (2 sigma^2))                   in (0, 1], high is good
//! L(x) = sum_k r_k L_k(x)                              a hidden fragment only loses its own vote
//! w = L(x) / sum L             m = sum w x             C = sum w (x - m)(x - m)'
//! r_k <- (1 - tau) r_k + tau L_k(m) / sum_j L_j(m)     reliabilities, sum 1, from 1/K
//! resampled in every frame, afterwards w = 1/N
//! ```
//!
//! `x`, `y` is the center in pixels, 0-based as in [`crate::region`]. Fragments keep their places in the
//! region and are rounded to whole pixels; pixels beyond the frame are not counted, and a fragment without
//! a pixel has `d_k = 1`. Histograms have 8 x 8 x 8 bins of red, green and blue and are never updated. Fragments
//! with `r_k < 0.2 / K` have no vote in `L` until they recover; the reliabilities of the others are then scaled to a sum
//! of 1. Frames go in the order propagate, weigh, estimate, judge the fragments at the estimate, resample
//! (systematically), so that mean, covariance and effective number are those before resampling. The posterior's
//! likelihood is `L(m)`. The region is the first one's upright rectangle, moved. All particles start on the
//! annotation.
//!
//! Choices, since nothing is published: N, the noise and the state are those of the paper's own particle
//! filter where it has them. Third-party code that cites the source has `sigma = 0.1`, with which thin
//! strips of colored targets are soon lost; the default is the paper's deviation for its color filter, 0.2.
//! `tau` is low, as the paper says of this tracker's adaptation. The size is fixed, as neither base has a
//! scale; a random walk of it tracked no better. That the least reliable fragments have no vote is ours. When
//! all likelihoods underflow, weights are left equal.

mod evidence;
mod layout;
#[cfg(test)]
mod tests;

use super::Moments;
use super::color_particle_filter::{likelihood, relative_likelihoods};
use crate::num::particles::{Cloud, Resampling};
use crate::num::seed;
use crate::tracker::prelude::*;
use evidence::Evidence;
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;

/// Fragments below this share of the mean reliability have no vote.
const DROP_BELOW: f64 = 0.2;

/// Parameters of the tracker.
#[derive(Debug, Clone, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Params {
    /// Number of particles N, from 2 to 10000.
    pub particles: usize,
    /// Rate `tau` at which reliabilities follow the fragments' likelihoods, from 0 (fixed) to 1.
    pub reliability_rate: f64,
    /// Deviation `sigma` of a fragment's likelihood, from 0.01 to 10.
    pub sigma_likelihood: f64,
    /// Standard deviation of the center's noise in x and in y, in pixels per frame, from 0 to 1000.
    pub sigma_position: f64,
}

impl Default for Params {
    fn default() -> Self {
        Self { particles: 400, reliability_rate: 0.02, sigma_likelihood: 0.2, sigma_position: 5.0 }
    }
}

impl PlainParams for Params {
    const RANGES: &'static [Range] = &[
        Range::within("reliability_rate", 0.0, 1.0),
        Range::within("sigma_likelihood", 0.01, 10.0),
        Range::within("sigma_position", 0.0, 1000.0),
        Range::within("particles", 2.0, 10_000.0),
    ];
}

/// The fragments particle filter in the list of trackers.
pub const ENTRY: Entry<dyn TrackerConfig> = Entry::of::<Params>(
    "fragments-particle-filter",
    1,
    "reconstruction of FT: particles weighed by the votes of fragments",
);

impl TrackerConfig for Params {
    fn facts(&self) -> Facts {
        Facts::SAMPLES
    }

    fn start(&self, context: &RunContext<'_>, frame: &Frame, region: &Region) -> StartResult {
        let rect = region.rect();
        if ![rect.x, rect.y, rect.w, rect.h].iter().all(|v| v.is_finite()) {
            return Err(TrackerError::no_region("fragments-particle-filter"));
        }
        let (x, y) = rect.center();
        let place = [x, y];
        let mut evidence = Evidence::new(layout::fragments(rect.w, rect.h), frame, &place);
        let reliabilities = vec![1.0 / evidence.len() as f64; evidence.len()];
        let cloud = Cloud::new(place, self.particles);
        evidence.look(frame, &[place]);
        let mut rho = Vec::new();
        evidence.likeness(&place, &mut rho);
        let likelihood = fuse(&rho, &votes(&reliabilities), 1.0, self.sigma_likelihood);
        let posterior = Moments::of(&cloud.posterior(), &cloud.weights, &[0, 1], likelihood);
        let state = TrackerState { posterior: Some(posterior), ..TrackerState::initialized(region.clone()) };
        let tracker = Tracking {
            params: self.clone(),
            rng: seed::rng(context.seed),
            size: (rect.w, rect.h),
            cloud,
            evidence,
            reliabilities,
        };
        Ok((Box::new(tracker), state))
    }
}

#[derive(Clone)]
struct Tracking {
    params: Params,
    rng: ChaCha8Rng,
    /// Sides of the target in pixels.
    size: (f64, f64),
    cloud: Cloud<2>,
    evidence: Evidence,
    /// Reliability `r_k` of each fragment, with sum 1.
    reliabilities: Vec<f64>,
}

impl Tracker for Tracking {
    fn update(&mut self, frame: &Frame) -> Result<TrackerState, TrackerError> {
        let Self { params: p, rng, size, cloud, evidence, reliabilities } = self;
        propagate(cloud, p.sigma_position, rng);
        evidence.look(frame, &cloud.states);
        let votes = votes(reliabilities);
        let k = votes.len();
        let (mut rho, mut all) = (Vec::with_capacity(k), Vec::with_capacity(k * cloud.states.len()));
        for state in &cloud.states {
            evidence.likeness(state, &mut rho);
            all.extend_from_slice(&rho);
        }
        // Relative to the best likeness of the fragments that vote.
        let voting = |row: &[f64]| {
            row.iter().zip(&votes).filter(|(_, v)| **v > 0.0).fold(0.0, |a: f64, (r, _)| a.max(*r))
        };
        let best = all.chunks_exact(k).map(voting).fold(0.0, f64::max);
        let sigma = p.sigma_likelihood;
        cloud.weigh(all.chunks_exact(k).map(|row| fuse(row, &votes, best, sigma)));
        let posterior = cloud.posterior();
        let [x, y] = posterior.mean;
        evidence.likeness(&posterior.mean, &mut rho);
        let likelihood = fuse(&rho, &votes, 1.0, sigma);
        let posterior = Moments::of(&posterior, &cloud.weights, &[0, 1], likelihood);
        follow(reliabilities, &rho, p.reliability_rate, sigma);
        cloud.resample(Resampling::Systematic, rng);
        let (w, h) = *size;
        let region = Region::Rect(Rect::new(x - w / 2.0, y - h / 2.0, w, h));
        Ok(TrackerState { posterior: Some(posterior), ..TrackerState::tracked(region) })
    }

    fn fork(&self, seed: Option<u64>) -> Option<Box<dyn Tracker>> {
        Some(Box::new(Self { rng: seed::fork(&self.rng, seed), ..self.clone() }))
    }
}

/// Moves the particles by noise of deviation `sigma` in x and in y.
fn propagate(cloud: &mut Cloud<2>, sigma: f64, rng: &mut ChaCha8Rng) {
    let mut draws = 0_usize;
    let normal = || {
        let draw: f64 = rng.sample(StandardNormal);
        draws += 1;
        if draws.is_multiple_of(2) {
            // Each particle takes three draws. The third was for a size, and keeps tracks what they were with it.
            let _: f64 = rng.sample(StandardNormal);
        }
        draw
    };
    cloud.diffuse(&[sigma; 2], |place| place, normal);
}

/// Shares of the fragments that vote, sum 1.
fn votes(reliabilities: &[f64]) -> Vec<f64> {
    let limit = DROP_BELOW / reliabilities.len() as f64;
    let sum: f64 = reliabilities.iter().filter(|r| **r >= limit).sum();
    reliabilities.iter().map(|r| if *r >= limit { r / sum } else { 0.0 }).collect()
}

/// Likelihood of a place from its fragments' likenesses, divided by that of a likeness `best` in all of
/// them.
fn fuse(rho: &[f64], votes: &[f64], best: f64, sigma: f64) -> f64 {
    let heard = rho.iter().zip(votes).filter(|(_, v)| **v > 0.0);
    heard.map(|(r, v)| v * likelihood(1.0 + r - best, sigma)).sum()
}

/// Moves reliabilities towards the shares of the fragments' likelihoods.
fn follow(reliabilities: &mut [f64], rho: &[f64], rate: f64, sigma: f64) {
    let likelihoods: Vec<f64> = relative_likelihoods(rho, sigma).collect();
    let sum: f64 = likelihoods.iter().sum();
    for (r, likelihood) in reliabilities.iter_mut().zip(likelihoods) {
        *r = (1.0 - rate) * *r + rate * likelihood / sum;
    }
    // Without this, thousands of frames of rounding would add up.
    let sum: f64 = reliabilities.iter().sum();
    reliabilities.iter_mut().for_each(|r| *r /= sum);
}
