//! Lanes: a tracker, or its stored states, with the signals read from it.

use super::tracker_run::{TrackerRun, TrackingError};
use crate::spec::method::SignalChoice;
use std::sync::Arc;
use trackfail_core::image::Frame;
use trackfail_core::region::Region;
use trackfail_judge::reader::{SignalFault, SignalReader};
use trackfail_methods::score::Restarts;
use trackfail_methods::signal::Reads;
use trackfail_methods::tracker::{RunContext, StartedTracker, Status, Tracker, TrackerError, TrackerState};

/// A tracker, or its stored states, with the signals read from it.
pub struct Lane {
    pub(super) source: StateSource,
    pub(super) signals: Vec<Option<LaneSignal>>,
}

/// Where a lane's states come from.
pub(super) enum StateSource {
    /// A run that starts in the first frame that it is given.
    Run(TrackerRun),
    /// A started tracker; the state is that of the next frame, if it is known already.
    Tracker(Box<dyn Tracker>, Option<Box<TrackerState>>),
    /// States of an earlier run, one a frame.
    Stored(Arc<Vec<TrackerState>>),
}

/// A signal of a lane.
pub(super) struct LaneSignal {
    reader: SignalReader,
    /// For a signal that reads companions.
    companions: Companions,
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

/// States of other trackers on the same sequence, one for each of its frames.
pub type Companions = Arc<Vec<Arc<Vec<TrackerState>>>>;

/// The state of a lane in a frame.
pub struct LaneStep<'a> {
    /// Index of the frame, from 0.
    pub t: usize,
    /// The tracker's state.
    pub state: Arc<TrackerState>,
    pub(super) tracker: Option<&'a dyn Tracker>,
}

/// A lane without signals that continues from the tracker's belief; see [`Tracker::fork`].
fn fork(tracker: Option<&dyn Tracker>, seed: Option<u64>) -> Result<Lane, TrackingError> {
    let tracker = tracker.and_then(|tracker| tracker.fork(seed)).ok_or(TrackingError::NoFork)?;
    Ok(Lane::of_tracker(tracker))
}

impl LaneStep<'_> {
    /// A lane without signals that continues from the tracker's belief after this frame, with the same random numbers
    /// or with those of `seed`.
    ///
    /// # Errors
    /// When the tracker cannot be copied.
    pub fn fork(&self, seed: Option<u64>) -> Result<Lane, TrackingError> {
        fork(self.tracker, seed)
    }
}

impl Lane {
    /// A lane that starts the run's tracker in the first frame it is given.
    pub fn of_run(run: TrackerRun) -> Self {
        Self { source: StateSource::Run(run), signals: Vec::new() }
    }

    /// A lane of a tracker that was started in the first frame that the lane will be given.
    pub fn of_started((tracker, state): StartedTracker) -> Self {
        Self { source: StateSource::Tracker(tracker, Some(Box::new(state))), signals: Vec::new() }
    }

    /// The lane with signals, which start in the `context` of its tracker; those that read companions are given the
    /// regions of `companions`.
    ///
    /// # Errors
    /// When a signal cannot start, e.g. a file that it reads is absent.
    pub fn with_signals<'s>(
        self,
        context: &RunContext<'_>,
        companions: &Companions,
        signals: impl IntoIterator<Item = Option<&'s SignalChoice>>,
    ) -> Result<Self, TrackingError> {
        let signal = |choice: &SignalChoice| -> Result<LaneSignal, TrackerError> {
            let reader = SignalReader::start(choice, context)?;
            let reads_them = reader.reads() == Reads::Companions;
            let companions = if reads_them { companions.clone() } else { Companions::default() };
            Ok(LaneSignal { reader, companions, restarts: None })
        };
        let signals = signals.into_iter().map(|choice| choice.map(signal).transpose());
        Ok(Self { signals: signals.collect::<Result<_, _>>()?, ..self })
    }

    /// The lane, whose signals of these choices begin again with each restart of the tracker, where the choice says so.
    pub fn with_restarts<'s>(
        mut self,
        run: &TrackerRun,
        choices: impl IntoIterator<Item = &'s SignalChoice>,
    ) -> Self {
        for (signal, choice) in self.signals.iter_mut().flatten().zip(choices) {
            if choice.restarts == Restarts::NewTrack {
                let (choice, run) = (choice.clone(), run.clone());
                signal.restarts =
                    Some(Box::new(RestartedSignal { choice, run, started: false, last: Vec::new() }));
            }
        }
        self
    }

    /// A lane without signals of a started tracker; the first frame that it will be given is the tracker's next one.
    pub fn of_tracker(tracker: Box<dyn Tracker>) -> Self {
        Self { source: StateSource::Tracker(tracker, None), signals: Vec::new() }
    }

    /// A lane of stored states, one for each frame of the sequence.
    pub fn of_states(states: Arc<Vec<TrackerState>>) -> Self {
        Self { source: StateSource::Stored(states), signals: Vec::new() }
    }

    /// A lane without signals that continues from the tracker's belief, with the same random numbers or with those of
    /// `seed`.
    ///
    /// # Errors
    /// When the tracker cannot be copied, or has not been started.
    pub fn fork(&self, seed: Option<u64>) -> Result<Self, TrackingError> {
        fork(self.source.tracker(), seed)
    }

    /// Whether the lane looks at pixels. Stored states and trackers that answer without them do not, nor do signals of
    /// the posterior or of regions.
    pub(super) fn reads_pixels(&self) -> bool {
        let tracks = match &self.source {
            StateSource::Run(run) => run.config.reads_pixels(),
            StateSource::Tracker(..) => true,
            StateSource::Stored(_) => false,
        };
        tracks || self.signals.iter().flatten().any(|s| s.reader.reads() == Reads::Pixels)
    }
}

impl StateSource {
    /// The state of frame `t`, which comes next.
    pub(super) fn state(&mut self, t: usize, frame: &Frame) -> Result<TrackerState, TrackingError> {
        match self {
            Self::Stored(states) => states.get(t).cloned().ok_or(TrackingError::NoState(t)),
            Self::Tracker(tracker, known) => match known.take() {
                Some(state) => Ok(*state),
                None => Ok(tracker.update(frame)?),
            },
            Self::Run(run) => {
                let (tracker, state) = run.start(frame)?;
                *self = Self::Tracker(tracker, None);
                Ok(state)
            }
        }
    }

    /// The tracker at work, if there is one.
    pub(super) fn tracker(&self) -> Option<&dyn Tracker> {
        match self {
            Self::Tracker(tracker, _) => Some(&**tracker),
            Self::Run(_) | Self::Stored(_) => None,
        }
    }
}

impl LaneSignal {
    /// The signal's values in frame `t`, which comes next and has this number in its file name.
    pub(super) fn values(
        &mut self,
        frame: &Frame,
        state: &TrackerState,
        t: usize,
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
        let states = self.companions.iter().filter_map(|states| states.get(t));
        let companions: Vec<&Region> = states.map(|state| &state.region).collect();
        let values = self.reader.push(Some(frame), state, &companions).map_err(|fault| match fault {
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
