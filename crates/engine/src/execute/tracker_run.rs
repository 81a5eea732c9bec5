//! One run of a tracker on a sequence: all that is needed to start it.

use crate::error::StepError;
use std::path::PathBuf;
use std::sync::Arc;
use trackfail_core::image::Frame;
use trackfail_dataset::Sequence;
use trackfail_dataset::frame_cache::FrameCache;
use trackfail_methods::tracker::{RunContext, StartedTracker, TrackerConfig};

/// A run of a tracker on a sequence. It can be started any number of times, with the same result.
#[derive(Clone)]
pub struct TrackerRun {
    /// Sequence on which the tracker runs.
    pub sequence: Arc<Sequence>,
    /// Cache of decoded frames.
    pub frames: Arc<FrameCache>,
    /// Tracker with its parameters.
    pub config: Arc<dyn TrackerConfig>,
    /// Repetition, from 0.
    pub run: u32,
    /// Seed of the tracker's random numbers.
    pub seed: u64,
    /// Folders of result files. The first one that has a file is used.
    pub data_roots: Vec<PathBuf>,
}

impl TrackerRun {
    /// Frame `t` of the sequence, 0-based.
    ///
    /// # Errors
    /// When the frame cannot be decoded.
    pub fn frame(&self, t: usize) -> Result<Arc<Frame>, StepError> {
        self.frames.frame(&self.sequence, t).map_err(StepError::failed)
    }

    /// Context for a start in the first frame.
    pub fn context(&self) -> RunContext<'_> {
        let Self { sequence, run, seed, data_roots, .. } = self;
        RunContext { sequence: &**sequence, start_frame: 0, run: *run, seed: *seed, data_roots }
    }

    /// Starts the tracker with the ground truth of the first frame, whose pixels are `frame`.
    ///
    /// # Errors
    /// When the first frame has no ground truth, or the tracker cannot start.
    pub fn start(&self, frame: &Frame) -> Result<StartedTracker, StepError> {
        let truth = self.sequence.truth.first().and_then(Option::as_ref);
        let no_truth = || StepError::Here("the first frame has no ground truth to start from".to_string());
        let region = truth.ok_or_else(no_truth)?;
        Ok(self.config.start(&self.context(), frame, region)?)
    }
}
