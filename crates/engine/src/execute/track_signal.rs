//! A signal on the track of a run, with restarts.

use super::tracker_run::{TrackerRun, TrackingError};
use crate::spec::method::SignalChoice;
use trackfail_core::image::Frame;
use trackfail_core::region::Region;
use trackfail_judge::reader::{SignalFault, SignalReader};
use trackfail_methods::score::Restarts;
use trackfail_methods::signal::Reads;
use trackfail_methods::tracker::{Status, TrackerState};

/// A signal on a track, given one frame after the other.
pub struct TrackSignal {
    reader: SignalReader,
    /// For a signal that begins again with each restart of the tracker.
    restarts: Option<Box<RestartedSignal>>,
}

/// A signal that begins again with each restart of its tracker.
struct RestartedSignal {
    choice: SignalChoice,
    run: TrackerRun,
    /// Whether the tracker was started.
    started: bool,
    /// The last values, which skipped frames repeat.
    last: Vec<f64>,
}

impl TrackSignal {
    /// A signal on the track of a run.
    ///
    /// # Errors
    /// When it cannot start, e.g. a file that it reads is absent.
    pub fn start(choice: &SignalChoice, run: &TrackerRun) -> Result<Self, TrackingError> {
        let reader = SignalReader::start(choice, &run.context())?;
        let restarted = || {
            let (choice, run) = (choice.clone(), run.clone());
            Box::new(RestartedSignal { choice, run, started: false, last: Vec::new() })
        };
        Ok(Self { reader, restarts: (choice.restarts == Restarts::NewTrack).then(restarted) })
    }

    /// Its input.
    pub fn reads(&self) -> Reads {
        self.reader.reads()
    }

    /// The signal's values in the next frame, which has this number in its file name; `companions` are the regions of
    /// other trackers, for a signal that reads them.
    ///
    /// # Errors
    /// When it has none.
    pub fn values(
        &mut self,
        frame: &Frame,
        state: &TrackerState,
        companions: &[&Region],
        number: u32,
    ) -> Result<Vec<f64>, TrackingError> {
        if let Some(restarts) = &mut self.restarts {
            match state.status {
                Status::Skipped if restarts.started => return Ok(restarts.last.clone()),
                Status::Initialized if restarts.started => {
                    self.reader = SignalReader::start(&restarts.choice, &restarts.run.context())?;
                }
                Status::Initialized => restarts.started = true,
                _ => {}
            }
        }
        let values = self.reader.push(Some(frame), state, companions).map_err(|fault| match fault {
            SignalFault::Broke(fault) => fault.into(),
            SignalFault::NotFinite { kind, value } => TrackingError::NotFinite { kind, value, number },
            SignalFault::Lacks { kind, need } => TrackingError::Lacks { kind, need },
            SignalFault::NoFrame(kind) => TrackingError::Lacks { kind, need: "needs frames" },
        })?;
        if let Some(restarts) = &mut self.restarts {
            restarts.last.clone_from(&values);
        }
        Ok(values)
    }
}
