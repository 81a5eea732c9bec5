//! Reverse runs: a track's tracker is brought to a frame again, and tracks backwards in time from there.
//!
//! A stored track holds the regions that the tracker gave, not its belief. So the tracker runs forward again, once at
//! most, leaving forks behind every few frames; it must give the same regions. From frame `from` a fork runs backwards,
//! with random numbers of its own from the track's seed and `from`. All methods on a track share these runs, so neither
//! their number nor their order changes a result.

use super::frame_loop::run_lane;
use super::frame_observer::FrameObserver;
use super::lane::{Lane, LaneStep};
use super::tracker_run::{TrackerRun, TrackingError};
use std::cell::RefCell;
use std::collections::BTreeMap;
use std::collections::btree_map::Entry;
use std::sync::{Mutex, MutexGuard, PoisonError};
use trackfail_core::num;
use trackfail_core::region::Region;
use trackfail_methods::detector::{Detector, DetectorOutput, Input, Reverse};
use trackfail_methods::score::overlap;
use trackfail_methods::tracker::TrackerError;

/// Frames between the forks of the forward run.
const STRIDE: usize = 32;

/// Bytes of decoded frames that a run keeps in memory for reverse runs.
pub const FRAMES_IN_MEMORY: usize = 512 << 20;

/// Seed of the reverse run from frame `from`; `track` is the seed of the track.
pub fn seed(track: u64, from: usize) -> u64 {
    num::seed::seed(track, &["reverse", &from.to_string()])
}

/// Reverse runs of one track's tracker.
pub struct Reversal {
    run: TrackerRun,
    regions: Vec<Region>,
    memory: Mutex<Memory>,
}

#[derive(Default)]
struct Memory {
    /// Forks of the forward run, by frame.
    forward: BTreeMap<usize, Lane>,
    /// By first frame of the reverse run: the errors of the frames before it, the last one first.
    backward: BTreeMap<usize, Vec<f64>>,
    /// The last reverse run: its first frame, the frame that it is in, and its tracker.
    latest: Option<(usize, usize, Lane)>,
}

/// A detector's handle to a [`Reversal`].
pub struct ReverseHandle<'a> {
    reversal: &'a Reversal,
    failure: RefCell<Option<TrackingError>>,
}

impl std::fmt::Debug for Reversal {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "Reversal of a track on {}", self.run.sequence.name)
    }
}

/// Checks a second forward run against the first one, and keeps forks of it.
struct ForwardRun<'a> {
    regions: &'a [Region],
    forks: RefCell<&'a mut BTreeMap<usize, Lane>>,
}

impl FrameObserver for ForwardRun<'_> {
    fn tracked(&self, _: usize, step: LaneStep<'_>) -> Result<(), TrackingError> {
        if Some(&step.state.region) != self.regions.get(step.t) {
            return Err(TrackingError::NotRepeatable(step.t));
        }
        if step.t.is_multiple_of(STRIDE) {
            self.forks.borrow_mut().insert(step.t, step.fork(None)?);
        }
        Ok(())
    }
}

/// Collects the errors of a reverse run.
struct BackwardRun<'a> {
    from: usize,
    regions: &'a [Region],
    errors: RefCell<&'a mut Vec<f64>>,
}

impl FrameObserver for BackwardRun<'_> {
    fn tracked(&self, _: usize, step: LaneStep<'_>) -> Result<(), TrackingError> {
        let mut errors = self.errors.borrow_mut();
        // A reverse run to an earlier frame passes through the later ones, whose errors are known already.
        if errors.len() == self.from - step.t - 1 {
            errors.push(overlap::error(&step.state.region, &self.regions[step.t]));
        }
        Ok(())
    }
}

impl Reversal {
    /// Reverse runs of a track with these regions, one a frame.
    pub fn new(run: TrackerRun, regions: Vec<Region>) -> Self {
        Self { run, regions, memory: Mutex::default() }
    }

    /// A handle for one call of a detector.
    pub fn handle(&self) -> ReverseHandle<'_> {
        ReverseHandle { reversal: self, failure: RefCell::new(None) }
    }

    /// Frees the trackers; the errors found so far are kept.
    pub fn free_trackers(&self) {
        let mut memory = self.memory();
        memory.forward.clear();
        memory.latest = None;
    }

    fn memory(&self) -> MutexGuard<'_, Memory> {
        self.memory.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// The tracker after frame `t` of the forward run.
    fn forward(&self, memory: &mut Memory, t: usize) -> Result<Lane, TrackingError> {
        let TrackerRun { sequence, frames, .. } = &self.run;
        let (at, lane) = match memory.forward.range(..=t).next_back() {
            Some((at, fork)) => (*at, fork.fork(None)?),
            None => {
                let (tracker, _) = self.run.start(&*self.run.frame(0)?)?;
                (0, Lane::of_tracker(tracker))
            }
        };
        if let Entry::Vacant(slot) = memory.forward.entry(at) {
            slot.insert(lane.fork(None)?);
        }
        let observer = ForwardRun { regions: &self.regions, forks: RefCell::new(&mut memory.forward) };
        run_lane(sequence, frames, at + 1..=t, lane, &observer)
    }

    /// Error of frame `to` in the reverse run from the later frame `from`.
    fn backward(&self, memory: &mut Memory, from: usize, to: usize) -> Result<f64, TrackingError> {
        let known = |memory: &Memory| memory.backward.get(&from).and_then(|e| e.get(from - to - 1)).copied();
        if let Some(error) = known(memory) {
            return Ok(error);
        }
        let (at, lane) = match memory.latest.take() {
            Some((start, at, lane)) if start == from => (at, lane),
            _ => (from, self.forward(memory, from)?.fork(Some(seed(self.run.seed, from)))?),
        };
        let errors = RefCell::new(memory.backward.entry(from).or_default());
        let observer = BackwardRun { from, regions: &self.regions, errors };
        let lane = run_lane(&self.run.sequence, &self.run.frames, (to..at).rev(), lane, &observer)?;
        memory.latest = Some((from, to.min(at), lane));
        known(memory).ok_or(TrackingError::NoWayBack { from, to })
    }
}

impl ReverseHandle<'_> {
    /// Why a reverse run failed, if one did.
    pub fn failure(self) -> Option<TrackingError> {
        self.failure.into_inner()
    }
}

impl Reverse for ReverseHandle<'_> {
    fn error(&self, from: usize, to: usize) -> Option<f64> {
        let error = if to < from && from < self.reversal.regions.len() {
            self.reversal.backward(&mut self.reversal.memory(), from, to)
        } else {
            Err(TrackingError::NoWayBack { from, to })
        };
        error.map_err(|e| self.failure.borrow_mut().get_or_insert(e).clone()).ok()
    }
}

/// Output of a detector, which gets a handle to the reverse runs if it needs them.
///
/// # Errors
/// When a reverse run or the detector's program failed.
pub fn detect(
    detector: &dyn Detector,
    input: Input<'_>,
    reversal: Option<&Reversal>,
) -> Result<DetectorOutput, TrackingError> {
    let handle = reversal.filter(|_| detector.needs_reverse()).map(Reversal::handle);
    let reverse = handle.as_ref().map(|handle| handle as &dyn Reverse);
    let mut output = detector.detect(&Input { reverse, ..input });
    if let Some(failure) = output.failure.take() {
        return Err(TrackerError::Broken(failure).into());
    }
    handle.and_then(ReverseHandle::failure).map_or(Ok(output), Err)
}

#[cfg(test)]
mod tests;
