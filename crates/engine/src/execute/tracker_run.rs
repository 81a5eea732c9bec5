//! One run of a tracker on a sequence: everything needed to start it, and what can go wrong.

use super::supervise::JobError;
use crate::error::{CellError, StepError};
use crate::limits::Interrupted;
use std::path::PathBuf;
use std::sync::Arc;
use trackfail_core::image::Frame;
use trackfail_dataset::frame_cache::FrameCache;
use trackfail_dataset::{DatasetError, Sequence};
use trackfail_methods::tracker::{RunContext, StartedTracker, TrackerConfig, TrackerError};

/// A run of a tracker on a sequence; it can be started any number of times, with the same result.
#[derive(Clone)]
pub struct TrackerRun {
    /// The sequence.
    pub sequence: Arc<Sequence>,
    /// Cache of its decoded frames.
    pub frames: Arc<FrameCache>,
    /// The tracker.
    pub config: Arc<dyn TrackerConfig>,
    /// Repetition, from 0.
    pub run: u32,
    /// Seed of the tracker.
    pub seed: u64,
    /// Folders of result files; the first that has a file wins.
    pub data_roots: Vec<PathBuf>,
}

/// Why a tracker with its signals, or a reverse run of it, has no result.
#[derive(Debug, Clone, thiserror::Error)]
pub enum TrackingError {
    /// A frame cannot be decoded.
    #[error(transparent)]
    Frame(#[from] Arc<DatasetError>),
    /// The tracker has no results, or broke.
    #[error(transparent)]
    Tracker(Arc<TrackerError>),
    /// The tracker or a signal panicked or took too long.
    #[error(transparent)]
    Job(#[from] JobError),
    /// The run was interrupted.
    #[error(transparent)]
    Interrupted(#[from] Interrupted),
    /// The target is not annotated in the first frame.
    #[error("the first frame has no ground truth to start from")]
    NoStart,
    /// A tracker whose regions a signal reads failed; this is its label.
    #[error("there is no track of its companion {0}")]
    NoCompanion(String),
    /// A tracker does not give what a signal reads.
    #[error("signal {kind} {need}")]
    Lacks {
        /// Kind of the signal.
        kind: &'static str,
        /// The need that is not met.
        need: &'static str,
    },
    /// A signal is not a finite number.
    #[error("signal {kind} is {value} in frame {number}")]
    NotFinite {
        /// Kind of the signal.
        kind: &'static str,
        /// Its value.
        value: f64,
        /// Number of the frame, as in its file name.
        number: u32,
    },
    /// The tracker cannot be copied.
    #[error("this tracker has no copy that could start again from its posterior, so it cannot run backwards")]
    NoFork,
    /// A second run of the tracker differs from the first, in this frame, from 0.
    #[error("the tracker is not deterministic: a second run gave another region in frame {0} (from 0)")]
    NotRepeatable(usize),
    /// A reverse run that does not go back to an earlier frame.
    #[error("there is no way back from frame {from} to frame {to} (from 0)")]
    NoWayBack {
        /// Index of the first frame of the reverse run.
        from: usize,
        /// Index of its last frame.
        to: usize,
    },
}

impl From<TrackerError> for TrackingError {
    fn from(error: TrackerError) -> Self {
        Self::Tracker(Arc::new(error))
    }
}

impl TrackingError {
    /// The error of a cell on the sequence `name`.
    pub fn in_sequence(self, name: &str) -> CellError {
        match self {
            Self::Frame(e) => CellError::Failed(e.to_string()),
            Self::Tracker(e) => e.as_ref().into(),
            Self::NoCompanion(_) => CellError::Failed(self.to_string()),
            other => CellError::Failed(format!("{name}: {other}")),
        }
    }
}

impl From<TrackingError> for StepError {
    fn from(e: TrackingError) -> Self {
        match e {
            TrackingError::Interrupted(e) => e.into(),
            other => Self::failed(other),
        }
    }
}

impl TrackerRun {
    /// Frame `t` of the sequence, from 0.
    ///
    /// # Errors
    /// When it cannot be decoded.
    pub fn frame(&self, t: usize) -> Result<Arc<Frame>, TrackingError> {
        Ok(self.frames.frame(&self.sequence, t).map_err(Arc::new)?)
    }

    /// The context of a start in the first frame.
    pub fn context(&self) -> RunContext<'_> {
        let Self { sequence, run, seed, data_roots, .. } = self;
        RunContext { sequence: &**sequence, start_frame: 0, run: *run, seed: *seed, data_roots }
    }

    /// Starts the tracker on the ground truth of the first frame, which is `frame`.
    ///
    /// # Errors
    /// When the first frame has no ground truth, or the tracker cannot start.
    pub fn start(&self, frame: &Frame) -> Result<StartedTracker, TrackingError> {
        let truth = self.sequence.truth.first().and_then(Option::as_ref);
        let region = truth.ok_or(TrackingError::NoStart)?;
        Ok(self.config.start(&self.context(), frame, region)?)
    }
}
