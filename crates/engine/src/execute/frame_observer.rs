//! Observers of the work on frames, which receive its results while it goes on.

use super::lane::LaneStep;
use super::tracker_run::TrackingError;
use crate::limits::Interrupted;
use std::sync::Arc;
use trackfail_core::image::Frame;

/// Receives the results of [`run_frames`](super::frame_loop::run_frames), and wraps its work. The defaults only do the work.
pub trait FrameObserver {
    /// Called before each step.
    ///
    /// # Errors
    /// [`Interrupted`] ends the loop.
    fn check_interrupted(&self) -> Result<(), Interrupted> {
        Ok(())
    }

    /// Wraps the work of a lane's tracker or of one of its signals in a frame. The decoding of frames is the work of
    /// one more lane than there are.
    ///
    /// # Errors
    /// Those of the work, or of its supervision.
    fn supervise<T>(
        &self,
        _lane: usize,
        work: impl FnOnce() -> Result<T, TrackingError>,
    ) -> Result<T, TrackingError> {
        work()
    }

    /// The frame that a step is given.
    fn frame(&self, frame: Arc<Frame>) -> Arc<Frame> {
        frame
    }

    /// Wraps the work of the tracker in a frame.
    fn time_tracker<T>(&self, work: impl FnOnce() -> T) -> T {
        work()
    }

    /// Wraps the work of a lane's signal in a frame.
    fn time_signal<T>(&self, _signal: usize, work: impl FnOnce() -> T) -> T {
        work()
    }

    /// Receives the state of a lane in a frame; frames come in order.
    ///
    /// # Errors
    /// An error ends the lane.
    fn tracked(&self, lane: usize, step: LaneStep<'_>) -> Result<(), TrackingError>;

    /// Receives the values of a lane's signal in a frame, a 0 in place of an absent signal; frames come in order.
    fn measured(&self, _lane: usize, _signal: usize, _values: &[f64]) {}

    /// Called after each frame.
    fn frame_done(&self) {}
}
