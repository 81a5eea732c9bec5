//! The loop over the frames of a sequence: the one place where trackers and signals are given frames.
//!
//! [`run_frames`] decodes each frame once and gives it to all [`Lane`]s. A [`FrameObserver`] receives the results, and
//! wraps what differs between passes, reverse runs, timing and `detect`: supervision and the clock. The order of the
//! work is that of `schedule`; on one thread a frame is decoded when all lanes have finished the one before.

use super::cores::Cores;
use super::frame_observer::FrameObserver;
use super::lane::{Lane, LaneStep};
use super::schedule::Schedule;
use super::tracker_run::TrackingError;
use crate::limits::Interrupted;
use std::sync::{Arc, Mutex, PoisonError};
use trackfail_dataset::Sequence;
use trackfail_dataset::frame_cache::FrameCache;
use trackfail_methods::tracker::TrackerState;

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
    let schedule = Schedule::new(sequence, frames, order.into_iter().collect(), lanes, observer);
    schedule.run_on_this_thread();
    schedule.finish(lanes)
}

/// As [`run_frames`], on this thread and on cores that have nothing else to do; the results are the same.
///
/// # Errors
/// [`Interrupted`], from the observer.
pub fn run_frames_on<O: FrameObserver + Sync>(
    cores: &Cores,
    sequence: &Arc<Sequence>,
    frames: &FrameCache,
    lanes: &mut [Result<Lane, TrackingError>],
    observer: &O,
) -> Result<(), Interrupted> {
    let schedule = Schedule::new(sequence, frames, (0..sequence.len()).collect(), lanes, observer);
    schedule.work_on(cores);
    schedule.finish(lanes)
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
pub struct Collector(Vec<CollectedLane>);

#[derive(Debug)]
struct CollectedLane {
    states: Mutex<Vec<Arc<TrackerState>>>,
    signals: Vec<Mutex<Vec<f64>>>,
}

/// States and signals of a lane.
#[derive(Debug, Default)]
pub struct Collected {
    /// One state a frame.
    pub states: Vec<TrackerState>,
    /// One series for each signal, with its values of one frame after the other.
    pub signals: Vec<Vec<f64>>,
}

fn extend<T>(series: Option<&Mutex<Vec<T>>>, values: impl IntoIterator<Item = T>) {
    if let Some(series) = series {
        series.lock().unwrap_or_else(PoisonError::into_inner).extend(values);
    }
}

fn series<T>(of: Mutex<Vec<T>>) -> Vec<T> {
    of.into_inner().unwrap_or_else(PoisonError::into_inner)
}

impl Collector {
    /// A collector for lanes with these numbers of signals.
    pub fn new(signals: impl IntoIterator<Item = usize>) -> Self {
        let empty = |n: usize| CollectedLane {
            states: Mutex::default(),
            signals: std::iter::repeat_with(Mutex::default).take(n).collect(),
        };
        Self(signals.into_iter().map(empty).collect())
    }

    /// The states and signals of each lane.
    pub fn into_collected(self) -> Vec<Collected> {
        let collected = |lane: CollectedLane| Collected {
            states: series(lane.states).into_iter().map(Arc::unwrap_or_clone).collect(),
            signals: lane.signals.into_iter().map(series).collect(),
        };
        self.0.into_iter().map(collected).collect()
    }
}

impl FrameObserver for Collector {
    fn tracked(&self, lane: usize, step: LaneStep<'_>) -> Result<(), TrackingError> {
        extend(self.0.get(lane).map(|lane| &lane.states), [step.state]);
        Ok(())
    }

    fn measured(&self, lane: usize, signal: usize, values: &[f64]) {
        extend(self.0.get(lane).and_then(|lane| lane.signals.get(signal)), values.iter().copied());
    }
}
