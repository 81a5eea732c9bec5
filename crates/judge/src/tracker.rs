//! Trackers: from the frames of a sequence to a region per frame.
//!
//! A plugin is one file with parameters, a [`TrackerConfig`] that is a [`Plugin`](crate::plugin::Plugin), and
//! an `ENTRY` in [`TRACKERS`]. A configuration is shared by all sequences; [`TrackerConfig::start`] starts a
//! [`Tracker`] on one target. A restart is a new start with the same context, and so with the same random
//! numbers.

pub mod adaptive_local_sparse;
mod affine_candidates;
pub mod color_particle_filter;
mod correlation;
pub mod dsst;
pub mod fragments_particle_filter;
pub mod ivt;
pub mod kcf;
pub mod nanotrack;
pub mod ncc;
pub mod pixel_lut;
pub mod protocol;
pub mod samf;
pub mod scripted;
pub mod sparse_prototypes;
pub mod still;

#[cfg(test)]
mod conformance_tests;
#[cfg(test)]
pub(crate) mod testing;

use crate::image::Frame;
use crate::num::particles::{Posterior, effective_number, entropy};
use crate::plugin::{Entry, Role};
use crate::region::Region;
use crate::sequence::SequenceInfo;
use serde::{Deserialize, Serialize};
use std::any::Any;
use std::sync::Arc;

/// Names that most files of trackers import.
mod prelude {
    pub use super::{Facts, RunContext, StartResult, Tracker, TrackerConfig, TrackerError, TrackerState};
    pub use crate::image::Frame;
    pub use crate::plugin::{Entry, ParamError, PlainParams, Plugin, Range};
    pub use crate::region::{Rect, Region};
    pub use serde::{Deserialize, Serialize};
    pub use smart_default::SmartDefault;
}

/// Status of the tracker in a frame.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum Status {
    /// The tracker was (re)initialized with the ground truth.
    #[serde(rename = "Initialised")]
    Initialized,
    /// An ordinary frame.
    Tracked,
    /// A reset protocol found a failure in this frame. The region is the failed one; result files that lack
    /// it repeat the last one.
    Failed,
    /// A reset protocol skipped this frame, or the tracker was not run on it; the region repeats the last
    /// one.
    Skipped,
    /// The tracker has not started yet; the region is the one at which it will start.
    Waiting,
    /// The tracker reports the target as absent; the region repeats the last one.
    Absent,
    /// A result file has no box for this frame, and the parameters tolerate that. The region repeats the last
    /// one and counts as the tracker's answer.
    Repeated,
}

impl Status {
    /// True if the region is an answer to this frame, or counts as one. For other frames scoring rules
    /// differ, see [`Trajectory::counted`](crate::score::trajectory::Trajectory::counted).
    pub fn has_box(self) -> bool {
        matches!(self, Self::Initialized | Self::Tracked | Self::Repeated)
    }
}

/// First and second moments of a tracker's posterior, and the evenness of its weights. Samples are particles,
/// or cells of a response map read as a density.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Moments {
    /// Mean state, `d` values.
    pub mean: Vec<f64>,
    /// Covariance, `d x d`, row by row.
    pub covariance: Vec<f64>,
    /// Effective number of samples.
    pub effective_samples: f64,
    /// Number of samples: particles, or cells of a response map.
    pub samples: f64,
    /// Entropy of the weights, from 0 (one sample has all the weight) to 1 (all are equal).
    pub entropy: f64,
    /// Likelihood of the estimate.
    pub likelihood: f64,
    /// Always empty. The format of tracks in stores has a place for particles.
    pub particles: Vec<f64>,
}

impl Moments {
    /// Moments of particles with these weights (of sum 1), for the components `kept` of their states.
    fn of<const D: usize>(
        posterior: &Posterior<D>,
        weights: &[f64],
        kept: &[usize],
        likelihood: f64,
    ) -> Self {
        let Posterior { mean, covariance } = posterior;
        Self {
            mean: kept.iter().map(|&k| mean[k]).collect(),
            covariance: kept.iter().flat_map(|&i| kept.iter().map(move |&j| covariance[i][j])).collect(),
            effective_samples: effective_number(weights),
            samples: weights.len() as f64,
            entropy: entropy(weights),
            likelihood,
            particles: Vec::new(),
        }
    }
}

/// Index of the first of the largest numbers; 0 if there are none.
fn first_largest(numbers: impl Iterator<Item = f64>) -> usize {
    let mut best = (0, f64::NEG_INFINITY);
    for (i, number) in numbers.enumerate() {
        if number > best.1 {
            best = (i, number);
        }
    }
    best.0
}

/// Numbers that describe the response map of a correlation tracker: its peaks, and the spread around them.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub struct Response {
    /// Largest value.
    pub peak: f64,
    /// Largest value outside a box around the peak.
    pub second_peak: f64,
    /// Smallest value.
    pub lowest: f64,
    /// Mean over the whole map.
    pub mean: f64,
    /// Standard deviation over the whole map.
    pub deviation: f64,
    /// Mean without the 11 x 11 cells around the peak.
    pub sidelobe_mean: f64,
    /// Standard deviation without the 11 x 11 cells around the peak.
    pub sidelobe_deviation: f64,
    /// Mean without the cells within 5 % of the map's sides from the peak.
    pub narrow_sidelobe_mean: f64,
    /// Standard deviation without the cells within 5 % of the map's sides from the peak.
    pub narrow_sidelobe_deviation: f64,
}

/// Answer of a tracker for one frame.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct TrackerState {
    /// Region of the target.
    pub region: Region,
    /// Status of the tracker in the frame.
    pub status: Status,
    /// Posterior moments, from trackers that have them.
    pub posterior: Option<Moments>,
    /// Numbers of the response map, from trackers that have one.
    pub response: Option<Response>,
    /// Confidence, from trackers that give one, in the tracker's scale; high values are sure.
    pub confidence: Option<f64>,
}

/// Version of the form in which states are stored; part of the address of every track.
/// - 2: with response and confidence.
/// - 3: with the number of samples and the entropy of a posterior.
pub const STATE_FORM: u32 = 3;

impl TrackerState {
    /// State with a region and a status alone.
    pub fn new(region: Region, status: Status) -> Self {
        Self { region, status, posterior: None, response: None, confidence: None }
    }

    /// State with a region that was tracked.
    pub fn tracked(region: Region) -> Self {
        Self::new(region, Status::Tracked)
    }

    /// State of a frame in which the tracker was initialized.
    pub fn initialized(region: Region) -> Self {
        Self::new(region, Status::Initialized)
    }

    /// Confidence of the tracker or, if it gives none, the likelihood of its estimate: the peak of a response
    /// map, or how well a particle filter's estimate matches the target.
    pub fn confidence_or_likelihood(&self) -> Option<f64> {
        self.confidence.or(self.posterior.as_ref().map(|posterior| posterior.likelihood))
    }
}

/// Reason why a tracker gives no track.
#[derive(Debug, thiserror::Error)]
pub enum TrackerError {
    /// The result files or the program are absent.
    #[error("{0}")]
    Missing(String),
    /// A file that is read has faults.
    #[error(transparent)]
    File(Box<dyn std::error::Error + Send + Sync>),
    /// A program did not answer in a frame.
    #[error("{program}: frame {frame} of {sequence}: {source}")]
    Program {
        /// Name of the program in `plugins.toml`.
        program: String,
        /// Number of the frame, as the dataset counts.
        frame: u64,
        /// Name of the sequence.
        sequence: String,
        /// Fault of the program.
        source: Box<dyn std::error::Error + Send + Sync>,
    },
    /// The tracker itself failed.
    #[error("{0}")]
    Broken(String),
}

impl TrackerError {
    /// Error of a tracker or a signal that reads a file with this fault.
    pub fn file(fault: impl std::error::Error + Send + Sync + 'static) -> Self {
        Self::File(Box::new(fault))
    }

    /// Error of a tracker of this kind whose first region has coordinates that are not finite.
    fn no_region(kind: &str) -> Self {
        Self::Broken(format!("{kind}: the first region is no region"))
    }
}

/// Facts that a tracker knows at its start.
#[derive(Clone, Copy)]
pub struct RunContext<'a> {
    /// Sequence. Online trackers may use its size and length; only replays and oracles may use its truth.
    pub sequence: &'a dyn SequenceInfo,
    /// Index of the frame in which the tracker starts, from 0.
    pub start_frame: usize,
    /// Repetition, from 0.
    pub run: u32,
    /// Seed made from the names of experiment, sequence, tracker and run.
    pub seed: u64,
    /// Folders to which relative result paths refer. The first one that has a file is used.
    pub data_roots: &'a [std::path::PathBuf],
}

/// A running tracker, and its state in the frame in which it started.
pub type StartedTracker = (Box<dyn Tracker>, TrackerState);

/// A started tracker, or the reason why it cannot start.
pub type StartResult = Result<StartedTracker, TrackerError>;

/// Properties of a tracker's tracks that are independent of the sequence.
#[derive(Debug, Clone, Copy)]
pub struct Facts {
    /// True if tracks depend on the seed. Otherwise another seed recomputes nothing.
    pub uses_seed: bool,
    /// True if tracks depend on the number of the run, apart from the seed.
    pub uses_run: bool,
    /// True if tracks come from the ground truth or from results for a known sequence, so that new frames
    /// cannot be tracked.
    pub needs_truth: bool,
    /// True if the tracker reads pixels. Otherwise frames may have any size.
    pub reads_pixels: bool,
    /// True if states have the moments of a posterior.
    pub gives_posterior: bool,
    /// True if states have the numbers of a response map.
    pub gives_response: bool,
}

impl Facts {
    /// Facts of trackers that find boxes in pixels, without random numbers.
    pub const BOXES: Self = Self {
        uses_seed: false,
        uses_run: false,
        needs_truth: false,
        reads_pixels: true,
        gives_posterior: false,
        gives_response: false,
    };
    /// Facts of such trackers whose response maps are read as posteriors.
    pub const RESPONSES: Self = Self { gives_posterior: true, gives_response: true, ..Self::BOXES };
    /// Facts of such trackers whose posterior is made of random samples.
    pub const SAMPLES: Self = Self { uses_seed: true, gives_posterior: true, ..Self::BOXES };
}

/// A tracker with checked parameters.
pub trait TrackerConfig: Any + Send + Sync {
    /// Properties of the tracks. There is no default: with a forgotten seed, all runs would have one address.
    fn facts(&self) -> Facts;

    /// True if states have a confidence on the context's sequence, or a posterior whose likelihood replaces
    /// it. For result files, it depends on the files.
    fn gives_confidence(&self, _context: &RunContext<'_>) -> bool {
        self.facts().gives_posterior
    }

    /// Files that the tracker reads besides the frames. Their digests are part of a track's address.
    ///
    /// # Errors
    /// When there are none for this sequence and run.
    fn inputs(&self, _context: &RunContext<'_>) -> Result<Vec<std::path::PathBuf>, TrackerError> {
        Ok(Vec::new())
    }

    /// Starts a tracker with the target at `region` in `frame`, the frame of index [`RunContext::start_frame`].
    ///
    /// # Errors
    /// When the tracker cannot start, for example because a result file is absent or broken.
    fn start(&self, context: &RunContext<'_>, frame: &Frame, region: &Region) -> StartResult;

    /// Tracker in the state saved by [`Tracker::save`]; `None` if the bytes are not from this configuration.
    fn resume(&self, _saved: &[u8]) -> Option<Box<dyn Tracker>> {
        None
    }
}

impl<P: TrackerConfig> Role<P> for dyn TrackerConfig {
    fn hold(plugin: P) -> Arc<Self> {
        Arc::new(plugin)
    }
}

/// A tracker that was started on a target. It receives the following frames, each once and in order.
pub trait Tracker: Send {
    /// Finds the target in the next frame.
    ///
    /// # Errors
    /// When the tracker fails. A lost target is not an error. A failed tracker can no longer be used.
    fn update(&mut self, frame: &Frame) -> Result<TrackerState, TrackerError>;

    /// Copies the tracker with its model of the target; copy and original are then independent. Given earlier
    /// frames in reverse order, the copy tracks backwards in time. It draws the same random numbers as the
    /// original would or, with `seed`, those of a track with that seed.
    ///
    /// `None` from trackers that cannot be copied; all trackers with [`Moments`] can, unless a protocol restarts them.
    fn fork(&self, _seed: Option<u64>) -> Option<Box<dyn Tracker>> {
        None
    }

    /// Saves the state for [`TrackerConfig::resume`]; `None` from trackers that cannot be interrupted.
    fn save(&self) -> Option<Vec<u8>> {
        None
    }
}

/// All trackers, by kind.
pub static TRACKERS: &[Entry<dyn TrackerConfig>] = &[
    ncc::ENTRY,
    still::ENTRY,
    scripted::ENTRY,
    color_particle_filter::ENTRY,
    fragments_particle_filter::ENTRY,
    pixel_lut::ENTRY,
    kcf::ENTRY,
    dsst::ENTRY,
    samf::ENTRY,
    nanotrack::ENTRY,
    sparse_prototypes::ENTRY,
    ivt::ENTRY,
    adaptive_local_sparse::ENTRY,
];
