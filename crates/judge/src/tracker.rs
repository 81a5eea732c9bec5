//! Trackers: from the frames of a sequence to a region a frame.
//!
//! A plugin is one file with parameters, a [`TrackerConfig`] that is a [`Plugin`](crate::plugin::Plugin), and an `ENTRY` in
//! [`TRACKERS`]. A configuration is shared by all sequences; [`TrackerConfig::start`] starts a [`Tracker`] on one target. A
//! restart is a new start with the same context, so that it draws the same stream of random numbers.

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
mod conformance;
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

/// Event of a frame.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum Status {
    /// The tracker was (re)initialized with the ground truth.
    #[serde(rename = "Initialised")]
    Initialized,
    /// An ordinary frame.
    Tracked,
    /// A reset protocol found a failure in this frame. The region is the one that failed; for result files without it,
    /// the last one again.
    Failed,
    /// A reset protocol skipped this frame, or the tracker was not asked for it; the region repeats the last one.
    Skipped,
    /// The tracker has not started yet; the region is the one that it will start with.
    Waiting,
    /// The tracker says that the target is absent; the region repeats the last one that it gave.
    Absent,
    /// A result file has no box for this frame, and its reader was told to pass that over: the region repeats the last one
    /// and counts as the tracker's answer.
    Repeated,
}

impl Status {
    /// Whether the region is an answer to this frame or counts as one. Where it is not, rules of scoring differ, see
    /// [`Trajectory::counted`](crate::score::trajectory::Trajectory::counted).
    pub fn has_box(self) -> bool {
        matches!(self, Self::Initialized | Self::Tracked | Self::Repeated)
    }
}

/// First and second moments of a tracker's posterior, and the evenness of its weights: of particles, or of a response
/// map read as a density.
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
    /// Entropy of the weights, from 0 (one sample has everything) to 1 (all are equal).
    pub entropy: f64,
    /// Likelihood of the estimate.
    pub likelihood: f64,
    /// The particles, each a row of `d` state values and the weight; empty unless the parameters ask for them.
    pub particles: Vec<f64>,
}

impl Moments {
    /// The moments of particles with these weights, which sum to 1, in the components `kept` of their states.
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

/// Response map of a correlation tracker in numbers: its peaks and the spread of what is around them.
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

/// A tracker's answer for one frame.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct TrackerState {
    /// Region of the target.
    pub region: Region,
    /// Event of the frame.
    pub status: Status,
    /// Posterior moments, from trackers that have them.
    pub posterior: Option<Moments>,
    /// Response map in numbers, from trackers that have one.
    pub response: Option<Response>,
    /// The tracker's own confidence, from trackers that give one: high values are sure, the scale is the tracker's.
    pub confidence: Option<f64>,
}

/// Version of the form in which states are stored; part of the address of every track.
/// - 2: with response and confidence.
/// - 3: with the number of samples and the entropy of a posterior.
pub const STATE_FORM: u32 = 3;

impl TrackerState {
    /// A region and an event, without anything else.
    pub fn new(region: Region, status: Status) -> Self {
        Self { region, status, posterior: None, response: None, confidence: None }
    }

    /// An ordinary answer.
    pub fn tracked(region: Region) -> Self {
        Self::new(region, Status::Tracked)
    }

    /// The answer to an initialization.
    pub fn initialized(region: Region) -> Self {
        Self::new(region, Status::Initialized)
    }

    /// The tracker's own confidence or, where it gives none, the likelihood of its estimate: the peak of a response map,
    /// how well the estimate of a particle filter fits the target.
    pub fn confidence_or_likelihood(&self) -> Option<f64> {
        self.confidence.or(self.posterior.as_ref().map(|posterior| posterior.likelihood))
    }
}

/// Why a tracker gives no track.
#[derive(Debug, thiserror::Error)]
pub enum TrackerError {
    /// Its result files or its program are absent.
    #[error("{0}")]
    Missing(String),
    /// A file that it reads has faults.
    #[error(transparent)]
    File(Box<dyn std::error::Error + Send + Sync>),
    /// Its program did not answer in a frame.
    #[error("{program}: frame {frame} of {sequence}: {source}")]
    Program {
        /// Name of the program in `plugins.toml`.
        program: String,
        /// Number of the frame, as the dataset counts.
        frame: u64,
        /// Name of the sequence.
        sequence: String,
        /// The fault.
        source: Box<dyn std::error::Error + Send + Sync>,
    },
    /// The tracker itself broke.
    #[error("{0}")]
    Broken(String),
}

impl TrackerError {
    /// The error of a tracker or a signal that reads a file with this fault.
    pub fn file(fault: impl std::error::Error + Send + Sync + 'static) -> Self {
        Self::File(Box::new(fault))
    }

    /// The error of a tracker of this kind whose first region has coordinates that are not finite.
    fn no_region(kind: &str) -> Self {
        Self::Broken(format!("{kind}: the first region is no region"))
    }
}

/// Knowledge of a tracker at its start.
#[derive(Clone, Copy)]
pub struct RunContext<'a> {
    /// The sequence; online trackers may use its size and length, only replays and oracles its truth.
    pub sequence: &'a dyn SequenceInfo,
    /// Index of the frame that the tracker starts in, from 0.
    pub start_frame: usize,
    /// Repetition, from 0.
    pub run: u32,
    /// Seed made from the names of experiment, sequence, tracker and run.
    pub seed: u64,
    /// Folders that relative result paths start from; the first that has a file wins.
    pub data_roots: &'a [std::path::PathBuf],
}

/// A tracker at work, and its state in the frame that it was started in.
pub type StartedTracker = (Box<dyn Tracker>, TrackerState);

/// A started tracker, or why it cannot start.
pub type StartResult = Result<StartedTracker, TrackerError>;

/// Properties of a tracker's tracks that do not depend on the sequence.
#[derive(Debug, Clone, Copy)]
pub struct Facts {
    /// True if tracks depend on the seed. Otherwise another seed recomputes nothing.
    pub uses_seed: bool,
    /// True if tracks depend on the number of the run other than by the seed.
    pub uses_run: bool,
    /// True if tracks come from the ground truth or from results of a known sequence. New frames cannot be tracked then.
    pub needs_truth: bool,
    /// True if the tracker looks at pixels. Otherwise frames may have any size.
    pub reads_pixels: bool,
    /// Whether states have the moments of a posterior.
    pub gives_posterior: bool,
    /// Whether states have a response map in numbers.
    pub gives_response: bool,
}

impl Facts {
    /// Boxes that are found in the pixels, without chance.
    pub const BOXES: Self = Self {
        uses_seed: false,
        uses_run: false,
        needs_truth: false,
        reads_pixels: true,
        gives_posterior: false,
        gives_response: false,
    };
    /// Boxes without chance, with response maps that are read as posteriors.
    pub const RESPONSES: Self = Self { gives_posterior: true, gives_response: true, ..Self::BOXES };
    /// The same with the posterior of random samples.
    pub const SAMPLES: Self = Self { uses_seed: true, gives_posterior: true, ..Self::BOXES };
}

/// A checked configuration of a tracker.
pub trait TrackerConfig: Any + Send + Sync {
    /// Properties of its tracks. There is no default: a forgotten seed would give all runs one address.
    fn facts(&self) -> Facts;

    /// Whether its states have a confidence on the context's sequence, or a posterior whose likelihood stands for it; one
    /// of result files has it where the files do.
    fn gives_confidence(&self, _context: &RunContext<'_>) -> bool {
        self.facts().gives_posterior
    }

    /// The files that it reads besides the frames; their digests are part of a track's address.
    ///
    /// # Errors
    /// When there is none for this sequence and run.
    fn inputs(&self, _context: &RunContext<'_>) -> Result<Vec<std::path::PathBuf>, TrackerError> {
        Ok(Vec::new())
    }

    /// Starts a tracker with the target at `region` in `frame`, the frame of index [`RunContext::start_frame`].
    ///
    /// # Errors
    /// When it cannot start, e.g. a result file is absent or broken.
    fn start(&self, context: &RunContext<'_>, frame: &Frame, region: &Region) -> StartResult;

    /// A tracker as it was when [`Tracker::save`] was called; `None` if the bytes are not those of this configuration.
    fn resume(&self, _saved: &[u8]) -> Option<Box<dyn Tracker>> {
        None
    }
}

impl<P: TrackerConfig> Role<P> for dyn TrackerConfig {
    fn hold(plugin: P) -> Arc<Self> {
        Arc::new(plugin)
    }
}

/// A tracker that has been started on a target and gets the frames that follow, each once and in order.
pub trait Tracker: Send {
    /// Finds the target in the next frame.
    ///
    /// # Errors
    /// When the tracker breaks; a lost target is no error. A tracker that broke is of no more use.
    fn update(&mut self, frame: &Frame) -> Result<TrackerState, TrackerError>;

    /// Copies the tracker, its model of the target included; the copy and the original do not affect each other.
    /// Given the frames before this one in reverse order, the copy tracks backwards in time. It draws the same
    /// random numbers as the original would or, with `seed`, those of a track of that seed.
    ///
    /// `None` from trackers that cannot be copied; all trackers with [`Moments`] can.
    fn fork(&self, _seed: Option<u64>) -> Option<Box<dyn Tracker>> {
        None
    }

    /// Everything that it remembers, for [`TrackerConfig::resume`]; `None` from trackers that cannot be interrupted.
    fn save(&self) -> Option<Vec<u8>> {
        None
    }
}

/// Every tracker, by kind.
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
