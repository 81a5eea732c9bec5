//! The loop over the frames of a sequence: the one place where trackers and signals are given frames.
//!
//! A [`Lane`] is a tracker, or its stored states, with the signals read from it. [`run_frames`] decodes each frame once
//! and gives it to all lanes. A [`FrameObserver`] receives the results, and wraps what differs between passes, reverse
//! runs, timing and `detect`: supervision and the clock.

use super::tracker_run::{TrackerRun, TrackingError};
use crate::dataset::Sequence;
use crate::dataset::frame_cache::FrameCache;
use crate::image::Frame;
use crate::limits::Interrupted;
use crate::signal::{Reads, Session};
use crate::spec::method::SignalChoice;
use crate::tracker::{StartedTracker, Tracker, TrackerState};
use std::cell::RefCell;
use std::sync::Arc;

/// A tracker, or its stored states, with the signals read from it.
pub struct Lane {
    source: StateSource,
    signals: Vec<Option<LaneSignal>>,
}

/// Where a lane's states come from.
enum StateSource {
    /// A run that starts in the first frame that it is given.
    Run(TrackerRun),
    /// A started tracker; the state is that of the next frame, if it is known already.
    Tracker(Box<dyn Tracker>, Option<TrackerState>),
    /// States of an earlier run, one a frame.
    Stored(Arc<Vec<TrackerState>>),
}

/// A signal of a lane.
struct LaneSignal {
    kind: &'static str,
    reads: Reads,
    session: Box<dyn Session>,
}

/// Output of a lane in a frame.
pub struct LaneStep<'a> {
    /// Index of the frame, from 0.
    pub t: usize,
    /// The tracker's state.
    pub state: TrackerState,
    /// The value of each of the lane's signals; 0 in place of an absent one.
    pub values: Vec<f64>,
    tracker: Option<&'a dyn Tracker>,
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

/// Receives the results of [`run_frames`], and wraps its work. The defaults only do the work.
pub trait FrameObserver {
    /// Called before each frame.
    ///
    /// # Errors
    /// [`Interrupted`] ends the loop.
    fn check_interrupted(&self) -> Result<(), Interrupted> {
        Ok(())
    }

    /// Wraps all work of a lane in a frame. The decoding of frames is the work of one more lane than there are.
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

    /// Wraps the work of the tracker in a frame.
    fn time_tracker<T>(&self, work: impl FnOnce() -> T) -> T {
        work()
    }

    /// Wraps the work of a lane's signal in a frame.
    fn time_signal<T>(&self, _signal: usize, work: impl FnOnce() -> T) -> T {
        work()
    }

    /// Receives the output of a lane in a frame.
    ///
    /// # Errors
    /// An error ends the lane.
    fn lane_done(&self, lane: usize, step: LaneStep<'_>) -> Result<(), TrackingError>;

    /// Called after each frame.
    fn frame_done(&self) {}
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
        match &self.source {
            StateSource::Tracker(tracker, _) => fork(Some(&**tracker), seed),
            StateSource::Run(_) | StateSource::Stored(_) => fork(None, seed),
        }
    }

    /// Whether the lane looks at pixels; signals of the posterior on stored states do not.
    fn reads_pixels(&self) -> bool {
        !matches!(self.source, StateSource::Stored(_))
            || self.signals.iter().flatten().any(|s| s.reads == Reads::Pixels)
    }

    fn state(&mut self, t: usize, frame: &Frame) -> Result<TrackerState, TrackingError> {
        match &mut self.source {
            StateSource::Stored(states) => states.get(t).cloned().ok_or(TrackingError::NoState(t)),
            StateSource::Tracker(tracker, known) => match known.take() {
                Some(state) => Ok(state),
                None => Ok(tracker.update(frame)?),
            },
            StateSource::Run(run) => {
                let (tracker, state) = run.start(frame)?;
                self.source = StateSource::Tracker(tracker, None);
                Ok(state)
            }
        }
    }

    fn step<O: FrameObserver>(
        &mut self,
        lane: usize,
        sequence: &Sequence,
        (t, frame): (usize, &Frame),
        observer: &O,
    ) -> Result<(), TrackingError> {
        let state = observer.time_tracker(|| self.state(t, frame))?;
        let mut values = Vec::with_capacity(self.signals.len());
        for (k, signal) in self.signals.iter_mut().enumerate() {
            let Some(LaneSignal { kind, reads, session }) = signal else {
                values.push(0.0);
                continue;
            };
            if *reads == Reads::Posterior && state.posterior.is_none() {
                return Err(TrackingError::NoPosterior(kind));
            }
            let value = observer.time_signal(k, || session.push(frame, &state));
            if !value.is_finite() {
                return Err(TrackingError::NotFinite { kind, value, number: sequence.number(t) });
            }
            values.push(value);
        }
        let tracker = match &self.source {
            StateSource::Tracker(tracker, _) => Some(&**tracker),
            StateSource::Run(_) | StateSource::Stored(_) => None,
        };
        observer.lane_done(lane, LaneStep { t, state, values, tracker })
    }
}

/// Gives the frames of a sequence, in `order`, to all lanes. A lane that fails is replaced by its error; the others go
/// on. Each frame is decoded once, and not at all when no lane reads pixels.
///
/// # Errors
/// [`Interrupted`], from the observer.
pub fn run_frames<O: FrameObserver>(
    sequence: &Arc<Sequence>,
    frames: &FrameCache,
    order: impl IntoIterator<Item = usize>,
    lanes: &mut [Result<Lane, TrackingError>],
    observer: &O,
) -> Result<(), Interrupted> {
    let decoder = lanes.len();
    for t in order {
        observer.check_interrupted()?;
        if lanes.iter().all(Result::is_err) {
            break;
        }
        let frame = if lanes.iter().flatten().any(Lane::reads_pixels) {
            observer.supervise(decoder, || Ok(frames.frame(sequence, t).map_err(Arc::new)?))
        } else {
            Ok(Arc::new(Frame::from_fn(1, 1, |_, _| [0; 3])))
        };
        for (k, entry) in lanes.iter_mut().enumerate() {
            let Ok(lane) = entry else { continue };
            let done = match &frame {
                Ok(frame) => observer.supervise(k, || lane.step(k, sequence, (t, frame), observer)),
                Err(e) => Err(e.clone()),
            };
            if let Err(e) = done {
                *entry = Err(e);
            }
        }
        observer.frame_done();
    }
    Ok(())
}

/// Gives the frames of a sequence, in `order`, to one lane, and returns it.
///
/// # Errors
/// Those of the lane.
pub fn run_lane<O: FrameObserver>(
    sequence: &Arc<Sequence>,
    frames: &FrameCache,
    order: impl IntoIterator<Item = usize>,
    lane: Lane,
    observer: &O,
) -> Result<Lane, TrackingError> {
    let mut lanes = [Ok(lane)];
    run_frames(sequence, frames, order, &mut lanes, observer)?;
    let [lane] = lanes;
    lane
}

/// Collects the states and signals of lanes.
#[derive(Debug)]
pub struct Collector(Vec<RefCell<Collected>>);

/// States and signals of a lane.
#[derive(Debug, Default)]
pub struct Collected {
    /// One state a frame.
    pub states: Vec<TrackerState>,
    /// One series for each signal, with one value a frame.
    pub signals: Vec<Vec<f64>>,
}

impl Collector {
    /// A collector for lanes with these numbers of signals.
    pub fn new(signals: impl IntoIterator<Item = usize>) -> Self {
        let empty = |n: usize| RefCell::new(Collected { states: Vec::new(), signals: vec![Vec::new(); n] });
        Self(signals.into_iter().map(empty).collect())
    }

    /// The states and signals of each lane.
    pub fn into_collected(self) -> Vec<Collected> {
        self.0.into_iter().map(RefCell::into_inner).collect()
    }
}

impl FrameObserver for Collector {
    fn lane_done(&self, lane: usize, step: LaneStep<'_>) -> Result<(), TrackingError> {
        if let Some(collected) = self.0.get(lane) {
            let mut collected = collected.borrow_mut();
            collected.states.push(step.state);
            collected.signals.iter_mut().zip(step.values).for_each(|(series, value)| series.push(value));
        }
        Ok(())
    }
}
