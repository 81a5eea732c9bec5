//! Lanes: a tracker, or its stored states, with the signals read from it.

use super::tracker_run::{TrackerRun, TrackingError};
use crate::image::Frame;
use crate::signal::{Reads, Session};
use crate::spec::method::SignalChoice;
use crate::tracker::{StartedTracker, Tracker, TrackerState};
use std::sync::Arc;

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
    Tracker(Box<dyn Tracker>, Option<TrackerState>),
    /// States of an earlier run, one a frame.
    Stored(Arc<Vec<TrackerState>>),
}

/// A signal of a lane.
pub(super) struct LaneSignal {
    kind: &'static str,
    reads: Reads,
    session: Box<dyn Session>,
}

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
    fn new<'s>(source: StateSource, signals: impl IntoIterator<Item = Option<&'s SignalChoice>>) -> Self {
        let signal = |choice: &SignalChoice| LaneSignal {
            kind: choice.kind,
            reads: choice.signal.reads(),
            session: choice.signal.start(),
        };
        Self { source, signals: signals.into_iter().map(|choice| choice.map(signal)).collect() }
    }

    /// A lane that starts a tracker in the first frame it is given.
    pub fn of_run<'s>(run: TrackerRun, signals: impl IntoIterator<Item = Option<&'s SignalChoice>>) -> Self {
        Self::new(StateSource::Run(run), signals)
    }

    /// A lane of a tracker that was started in the first frame that the lane will be given.
    pub fn of_started<'s>(
        (tracker, state): StartedTracker,
        signals: impl IntoIterator<Item = Option<&'s SignalChoice>>,
    ) -> Self {
        Self::new(StateSource::Tracker(tracker, Some(state)), signals)
    }

    /// A lane without signals of a started tracker; the first frame that it will be given is the tracker's next one.
    pub fn of_tracker(tracker: Box<dyn Tracker>) -> Self {
        Self { source: StateSource::Tracker(tracker, None), signals: Vec::new() }
    }

    /// A lane of stored states, one for each frame of the sequence.
    pub fn of_states<'s>(
        states: Arc<Vec<TrackerState>>,
        signals: impl IntoIterator<Item = Option<&'s SignalChoice>>,
    ) -> Self {
        Self::new(StateSource::Stored(states), signals)
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
        tracks || self.signals.iter().flatten().any(|s| s.reads == Reads::Pixels)
    }
}

impl StateSource {
    /// The state of frame `t`, which comes next.
    pub(super) fn state(&mut self, t: usize, frame: &Frame) -> Result<TrackerState, TrackingError> {
        match self {
            Self::Stored(states) => states.get(t).cloned().ok_or(TrackingError::NoState(t)),
            Self::Tracker(tracker, known) => match known.take() {
                Some(state) => Ok(state),
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
    /// The signal's value in the frame that comes next, which has this number in its file name.
    pub(super) fn value(
        &mut self,
        frame: &Frame,
        state: &TrackerState,
        number: u32,
    ) -> Result<f64, TrackingError> {
        let Self { kind, reads, session } = self;
        if *reads == Reads::Posterior && state.posterior.is_none() {
            return Err(TrackingError::NoPosterior(kind));
        }
        let value = session.push(frame, state);
        if value.is_finite() { Ok(value) } else { Err(TrackingError::NotFinite { kind, value, number }) }
    }
}
