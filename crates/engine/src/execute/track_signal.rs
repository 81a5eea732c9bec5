//! A signal on the track of a run, with restarts.

use super::tracker_run::TrackerRun;
use crate::error::StepError;
use crate::spec::method::SignalChoice;
use trackfail_core::image::Frame;
use trackfail_core::region::Region;
use trackfail_judge::reader::{SignalFault, SignalReader};
use trackfail_methods::score::Restarts;
use trackfail_methods::tracker::{Status, TrackerState};

/// A signal that is computed frame by frame on a track. Depending on its choice it begins again at each
/// restart of the tracker.
pub struct TrackSignal<'a> {
    choice: &'a SignalChoice,
    run: &'a TrackerRun,
    reader: SignalReader,
    /// Values of the last frame since the tracker was started. Skipped frames repeat them if restarts begin
    /// new tracks.
    last: Option<Vec<f64>>,
}

impl<'a> TrackSignal<'a> {
    /// Starts a signal on the track of a run.
    ///
    /// # Errors
    /// When the signal cannot start, for example because a file that it reads is absent.
    pub fn start(choice: &'a SignalChoice, run: &'a TrackerRun) -> Result<Self, StepError> {
        Ok(Self { choice, run, reader: SignalReader::start(choice, &run.context())?, last: None })
    }

    /// Values of the signal in the next frame, whose file name has this number. `companions` are the regions
    /// of other trackers, for signals that read them.
    ///
    /// # Errors
    /// When the signal has no value in the frame.
    pub fn values(
        &mut self,
        frame: &Frame,
        state: &TrackerState,
        companions: &[&Region],
        number: u32,
    ) -> Result<Vec<f64>, StepError> {
        match (state.status, &self.last) {
            (Status::Skipped, Some(last)) => return Ok(last.clone()),
            (Status::Initialized, Some(_)) => *self = Self::start(self.choice, self.run)?,
            _ => {}
        }
        let values = self.reader.push(Some(frame), state, companions).map_err(|fault| match fault {
            SignalFault::Broke(fault) => fault.into(),
            fault => StepError::Here(fault.in_frame(number)),
        })?;
        if self.choice.restarts == Restarts::NewTrack
            && (self.last.is_some() || state.status == Status::Initialized)
        {
            self.last = Some(values.clone());
        }
        Ok(values)
    }
}
