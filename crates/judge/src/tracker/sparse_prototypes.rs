//! Tracking with sparse prototypes (Wang, Lu and Yang, "Online object tracking with sparse prototypes", IEEE
//! TIP 22(1), 2013, sections III and IV): principal components of the target's recent looks, and an L1 term
//! for what hides it. The tracker SP of Khalid, Cavallaro and Rinner (BMVC 2016).
//!
//! ```text
//! y_i: the 32 x 32 window of candidate i, gray / 256;   d = mu - y_i;   U: basis of k vectors, 1024 x k
//! k = 0        E = |d|^2
//! k < K        E = |d - U U'd|^2
//! k = K        min over z, e of |d - U z - e|^2 + lambda |e|_1, by turns, from e = 0:
//!                  z = U'(d - e),   e = S(d - U z, lambda)              S: soft threshold
//!              E = sum_{|e_j| < lambda} (d - U z - e)_j^2 + lambda #{j: |e_j| >= lambda}
//! L_i = exp(-E / c)                     likelihood, in (0, 1], high is good; the estimate has the highest
//! o = #{j: |e_j| > lambda} / 1024       of the estimate: the occluded share, for k = K
//! o < low: keep y;  o > high: keep nothing;  else keep y with occluded pixels replaced by those of mu
//! ```
//!
//! Candidates, weights and the posterior's moments are as in `affine_candidates`; the posterior's likelihood is
//! that of the estimate. `mu` and `U` take in kept windows, `batch` at a time
//! ([`crate::num::incremental_pca`]), up to `K = max_basis` vectors. The state is `(x, y, s, theta, r, phi)`:
//! center in pixels, width as a multiple of 32 pixels, rotation, height over width and skew, the angles in
//! radians ([`crate::image::warp`]). The region is a rectangle while both angles are 0, else four corners.
//!
//! The alternation is that of the authors' program (2012), not of the paper where the two differ: the
//! objective it watches has no 1/2 before the square, although the threshold is the one for an objective
//! with it. It stops when the objective changes by less than `tolerance`, and the solution is then the one
//! *before* that last iteration. The objective of the first iteration is not computed and counts as 0, so that the
//! third iteration is the first to stop, but for a nearly perfect window. A state's six noise deviations are
//! taken in the order above, as the program does; its comments say another one. Its default of `c` is 0.01, but
//! nearly all of its settings for sequences are 0.25, which is the default here. With 0.01 the likelihoods of all candidates
//! are 0 in double precision where the best E is above 7.45; the program then takes the first candidate (`underflow`).
//!
//! On MountainBike (OTB) about a third of the window counts as occluded once the basis is full, and the target is
//! lost, where IVT is not. An independent NumPy version of this description, with the program's own first frame,
//! geometry and grid, loses it as well: mean overlap .26 to .35 for three seeds, .73 without the L1 term, and
//! .32 and .38 with it in the update or in the likelihood alone.
//!
//! Choices and deviations:
//! - The first frame is learned from the annotation itself, which is also the answer. The program already
//!   searches it, and its first answer is not exactly the annotation.
//! - The geometric state is carried on as it is. The program turns it into a matrix and back, which may exchange
//!   width and height together with a quarter turn of the skew.
//! - The first batch gives at most `batch - 1` vectors; see [`crate::num::incremental_pca`].
//! - A share equal to one of the two bounds belongs to the middle. The program then repeats the last window.
//! - The grid of the template is centered; see [`crate::image::warp`]. Sides stay between `smallest_side` (1 pixel) and
//!   four times the frame's longer side.
//! - The paper that compares detectors does not say which noise it ran; with that of `preset` "program" the box shrinks to
//!   a few pixels on some targets, with "upright" it seldom does.

mod likelihood;
#[cfg(test)]
mod tests;

use super::affine_candidates::{self, Candidates, PIXELS, SideLimits, TEMPLATE, check_noise, weigh};
use crate::image::Gray;
use crate::image::warp::Geometry;
use crate::num::incremental_pca::IncrementalPca;
use crate::num::seed;
use crate::plugin::show_params;
use crate::tracker::prelude::*;
use likelihood::{Alternation, Comparisons, Subspace, error};
use rand_chacha::ChaCha8Rng;

/// One gray level.
const LEVEL: f32 = 1.0 / 256.0;
/// Numbers below have an exponential that is 0 in double precision: half of the smallest number above 0 rounds to 0.
const VANISHING: f64 = -1075.0 * std::f64::consts::LN_2;

/// Preset of the candidates' noise.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Preset {
    /// 4, 4, .02, .02, .005, .001: the defaults of the authors' program; all six components vary.
    Program,
    /// 4, 4, .01, 0, .005, 0: no rotation, no skew, and half of the change in size.
    Upright,
}

impl Preset {
    fn noise(self) -> Geometry {
        match self {
            Self::Program => [4.0, 4.0, 0.02, 0.02, 0.005, 0.001],
            Self::Upright => [4.0, 4.0, 0.01, 0.0, 0.005, 0.0],
        }
    }
}

/// The estimate where `exp(-E / c)` is 0 in double precision for all candidates.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Underflow {
    /// The candidate of the smallest E as ever: likelihoods are compared by their logarithms.
    #[default]
    Best,
    /// The first candidate, with equal weights: the authors' program divides 0 by 0, and the largest of its quotients is the
    /// first.
    First,
}

/// Form of the reported region.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Form {
    /// The rotated and skewed window, as four corners.
    Turned,
    /// The upright rectangle with the same center, width and height, as in result files of the program.
    Upright,
}

/// Parameters of the tracker.
#[derive(Debug, Clone, SmartDefault, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Params {
    /// Preset for the noise, used if `noise` is left out.
    #[default(Preset::Program)]
    pub preset: Preset,
    /// Number of candidates per frame, from 2 to 10000.
    #[default(600)]
    pub samples: usize,
    /// Standard deviations of the candidates' noise in x, y, s, theta, r and phi, each from 0 to 1000; by
    /// default those of the preset.
    pub noise: Option<[f64; 6]>,
    /// Scale `c` of the likelihood, from 0.0001 to 1000.
    #[default(0.25)]
    pub likelihood_scale: f64,
    /// Maximum number K of basis vectors, from 1 to 256.
    #[default(16)]
    pub max_basis: usize,
    /// Number of windows that are learned together, from 1 to 1000.
    #[default(5)]
    pub batch: usize,
    /// Weight of old windows when new ones are learned, above 0 and at most 1.
    #[default(1.0)]
    pub forgetting: f64,
    /// Threshold and cost `lambda` of an occluded pixel, in gray levels scaled to 1, above 0 and at most 1.
    #[default(0.05)]
    pub lambda: f64,
    /// Maximum number of iterations of the alternation, from 1 to 1000.
    #[default(20)]
    pub iterations: usize,
    /// Change of the objective at which the alternation stops, from 0 to 1.
    #[default(1e-3)]
    pub tolerance: f64,
    /// Occluded share below which a window is learned unchanged, from 0 to 1.
    #[default(0.1)]
    pub low: f64,
    /// Occluded share above which a window is not learned, from `low` to 1.
    #[default(0.6)]
    pub high: f64,
    /// Least side of the target, in pixels, from 1 to 1000.
    #[default(1.0)]
    pub smallest_side: f64,
    /// Form of the reported region.
    #[default(Form::Turned)]
    pub region: Form,
    /// The estimate where the likelihoods of all candidates are too small for a number.
    #[serde(skip_serializing_if = "is_default")]
    #[default(Underflow::Best)]
    pub underflow: Underflow,
}

fn is_default(underflow: &Underflow) -> bool {
    *underflow == Underflow::default()
}

impl PlainParams for Params {
    const RANGES: &'static [Range] = &[
        affine_candidates::SAMPLES,
        affine_candidates::NOISE,
        LIKELIHOOD_SCALE,
        MAX_BASIS,
        BATCH,
        FORGETTING,
        Range::of("lambda").above(0.0).at_most(1.0),
        Range::within("iterations", 1.0, 1000.0),
        Range::within("tolerance", 0.0, 1.0),
        Range::within("low", 0.0, 1.0),
        Range::within("high", 0.0, 1.0),
        Range::within("smallest_side", 1.0, 1000.0),
    ];

    fn check(&self) -> Result<(), ParamError> {
        check_noise(&self.deviations())?;
        ParamError::unless(self.high >= self.low, "high", "from `low` to 1", self.high)
    }

    fn shown(&self) -> serde_json::Value {
        show_params(&Params { noise: Some(self.deviations()), ..self.clone() })
    }
}

impl Params {
    /// Deviations of the noise: those given, or else those of the preset.
    fn deviations(&self) -> Geometry {
        self.noise.unwrap_or_else(|| self.preset.noise())
    }
}

/// SP in the list of trackers.
pub const ENTRY: Entry<dyn TrackerConfig> = Entry::of::<Params>(
    "sparse-prototypes",
    2,
    "principal components of the target and an L1 term for occlusion (SP)",
);

impl TrackerConfig for Params {
    fn facts(&self) -> Facts {
        Facts::SAMPLES
    }

    fn start(&self, context: &RunContext<'_>, frame: &Frame, region: &Region) -> StartResult {
        Tracking::start(ENTRY.kind, self.clone(), true, context.seed, frame, region)
    }
}

/// Range of `likelihood_scale`; the ranges of other parameters of both trackers follow.
pub(super) const LIKELIHOOD_SCALE: Range = Range::within("likelihood_scale", 1e-4, 1000.0);
pub(super) const MAX_BASIS: Range = Range::within("max_basis", 1.0, 256.0);
pub(super) const BATCH: Range = Range::within("batch", 1.0, 1000.0);
pub(super) const FORGETTING: Range = Range::of("forgetting").above(0.0).at_most(1.0);

/// A running subspace tracker.
#[derive(Clone)]
pub(super) struct Tracking {
    params: Params,
    /// True if there is a model of occlusion, used once the basis is full. Without it, this is the IVT tracker.
    has_occlusion: bool,
    rng: ChaCha8Rng,
    candidates: Candidates,
    work: Comparisons,
    estimate: Geometry,
    pca: IncrementalPca,
    subspace: Subspace,
    /// Windows that are not yet in the principal components.
    kept: Vec<Vec<f64>>,
}

impl Tracking {
    /// Starts a tracker of this kind and returns it with its first state.
    pub(super) fn start(
        kind: &str,
        params: Params,
        has_occlusion: bool,
        seed: u64,
        frame: &Frame,
        region: &Region,
    ) -> StartResult {
        let tracker = Self::new(params, has_occlusion, seed, frame, region);
        let tracker = tracker.ok_or_else(|| TrackerError::no_region(kind))?;
        let posterior = Some(tracker.candidates.certain(&tracker.estimate, 1.0));
        let state = TrackerState { posterior, ..TrackerState::initialized(region.clone()) };
        Ok((Box::new(tracker), state))
    }

    /// Creates the tracker; `None` if the region is none. The window of the first region is learned first.
    fn new(params: Params, has_occlusion: bool, seed: u64, frame: &Frame, region: &Region) -> Option<Self> {
        let geometry = TEMPLATE.geometry(region)?;
        let estimate = SideLimits::of(frame).at_least(params.smallest_side).keep(geometry);
        let mut window = vec![0.0; PIXELS];
        let gray = Gray::of_part(frame, &TEMPLATE.window([&estimate]));
        TEMPLATE.sample(&gray, &estimate, LEVEL, &mut window);
        let mut tracker = Self {
            rng: seed::rng(seed),
            candidates: Candidates::new(params.samples, params.deviations()),
            work: Comparisons::default(),
            estimate,
            pca: IncrementalPca::new(PIXELS),
            subspace: Subspace::mean_only(&window),
            kept: Vec::new(),
            params,
            has_occlusion,
        };
        tracker.learn(&window);
        Some(tracker)
    }

    /// Alternation of the occlusion model; `None` without one, and until the basis is full.
    fn alternation(&self) -> Option<Alternation> {
        let Params { lambda, tolerance, iterations, max_basis, .. } = self.params;
        let is_used = self.has_occlusion && self.subspace.dimension() == max_basis;
        is_used.then_some(Alternation { lambda: lambda as f32, tolerance: tolerance as f32, iterations })
    }

    /// Replaces occluded pixels by those of the mean. Returns true if the window should be learned.
    fn clean(&mut self, window: &mut [f32]) -> bool {
        let Some(alternation) = self.alternation() else { return true };
        let Params { low, high, .. } = self.params;
        self.subspace.costs(1, Some(&alternation), |_, out| out.copy_from_slice(window), &mut self.work);
        let residuals = self.work.residuals();
        let lambda = alternation.lambda;
        let occluded = |r: &f32| error(*r, lambda).abs() > lambda;
        let share = residuals.iter().filter(|r| occluded(r)).count() as f64 / PIXELS as f64;
        if share >= low && share <= high {
            for ((y, mean), r) in window.iter_mut().zip(self.subspace.mean()).zip(residuals) {
                if occluded(r) {
                    *y = *mean;
                }
            }
        }
        share <= high
    }

    /// Keeps a window. When a batch is complete, the principal components are updated.
    fn learn(&mut self, window: &[f32]) {
        self.kept.push(window.iter().map(|v| f64::from(*v)).collect());
        if self.kept.len() >= self.params.batch {
            self.pca.update(&self.kept, self.params.forgetting, self.params.max_basis);
            self.kept.clear();
            self.subspace = Subspace::of(&self.pca);
        }
    }
}

impl Tracker for Tracking {
    fn update(&mut self, frame: &Frame) -> Result<TrackerState, TrackerError> {
        let limits = SideLimits::of(frame).at_least(self.params.smallest_side);
        self.candidates.draw(&self.estimate, &limits, &mut self.rng);
        let gray = Gray::of_part(frame, &TEMPLATE.window(&self.candidates.states));
        let alternation = self.alternation();
        let states = &self.candidates.states;
        let sample = |k: usize, window: &mut [f32]| TEMPLATE.sample(&gray, &states[k], LEVEL, window);
        let costs = self.subspace.costs(states.len(), alternation.as_ref(), sample, &mut self.work);
        let logarithms: Vec<f64> =
            costs.iter().map(|cost| -f64::from(*cost) / self.params.likelihood_scale).collect();
        let (mut weights, mut best) = weigh(&logarithms);
        if self.params.underflow == Underflow::First && logarithms[best] < VANISHING {
            best = 0;
            let equal = 1.0 / weights.len() as f64;
            weights.fill(equal);
        }
        let posterior = self.candidates.moments(&weights, logarithms[best].exp());
        self.estimate = self.candidates.states[best];
        let mut window = vec![0.0; PIXELS];
        TEMPLATE.sample(&gray, &self.estimate, LEVEL, &mut window);
        if self.clean(&mut window) {
            self.learn(&window);
        }
        let [x, y, s, theta, r, phi] = self.estimate;
        let is_upright = self.params.region == Form::Upright;
        let shown = if is_upright { [x, y, s, 0.0, r, 0.0] } else { [x, y, s, theta, r, phi] };
        let region = TEMPLATE.region(&shown);
        Ok(TrackerState { posterior: Some(posterior), ..TrackerState::tracked(region) })
    }

    fn fork(&self, seed: Option<u64>) -> Option<Box<dyn Tracker>> {
        Some(Box::new(Self { rng: seed::fork(&self.rng, seed), ..self.clone() }))
    }
}
