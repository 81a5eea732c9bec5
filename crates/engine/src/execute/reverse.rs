//! Reverse runs: the tracker of a track is brought to a frame again and runs backwards in time from there.
//!
//! A stored track holds the regions that the tracker gave, not its internal state. So the tracker runs
//! forward again, at most once, and is copied every few frames; it must give the same regions. From frame
//! `from` a copy (fork) runs backwards, with random numbers seeded by the track's seed and `from`. All
//! methods on a track share these runs, so neither their number nor their order changes a result. Times are
//! measured, but are not part of any result.

use super::tracker_run::TrackerRun;
use crate::error::{RunError, StepError};
use std::cell::{Cell, RefCell};
use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};
use trackfail_core::image::Frame;
use trackfail_core::num;
use trackfail_core::region::Region;
use trackfail_dataset::guarded;
use trackfail_methods::detector::{Detector, DetectorOutput, Input, Reverse};
use trackfail_methods::score::overlap;
use trackfail_methods::tracker::{Tracker, TrackerError};

/// Frames between two forks of the forward run.
const STRIDE: usize = 32;

/// Most bytes of decoded frames that a run keeps in memory for reverse runs.
pub const FRAMES_IN_MEMORY: usize = 512 << 20;

/// Reverse runs of the tracker of one track.
pub struct Reversal {
    run: TrackerRun,
    regions: Vec<Region>,
    /// True if a request continues the earlier reverse run that started in the same frame.
    shares_runs: bool,
    memory: Mutex<Memory>,
}

type Fork = Box<dyn Tracker>;

#[derive(Default)]
struct Memory {
    /// Forks of the forward run, by frame.
    forward: BTreeMap<usize, Fork>,
    /// Errors of each reverse run, by its first frame: those of the earlier frames, the latest one first.
    backward: BTreeMap<usize, Vec<f64>>,
    /// The last reverse run: first frame, current frame and tracker.
    latest: Option<(usize, usize, Fork)>,
    cost: ReverseCost,
}

/// Time and frames of reverse runs.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(super) struct ReverseCost {
    /// Time that the detector waited for reverse runs, all work included.
    pub waiting: Duration,
    /// Time of the tracker running backwards, without decoding and without the forward run to the first
    /// frame.
    pub tracking: Duration,
    /// Number of reverse runs.
    pub runs: u64,
    /// Number of frames in these runs.
    pub frames: u64,
}

/// Runs `work` and adds the time to `spent`.
pub(super) fn clocked<T>(spent: &Cell<Duration>, work: impl FnOnce() -> T) -> T {
    let start = Instant::now();
    let done = work();
    spent.set(spent.get() + start.elapsed());
    done
}

/// Copies a tracker with its internal state. The copy continues with the same random numbers, or with those
/// of `seed`.
///
/// # Errors
/// When the tracker cannot be copied.
pub(super) fn fork(tracker: &dyn Tracker, seed: Option<u64>) -> Result<Fork, StepError> {
    let no_copy = "this tracker cannot be copied, or its protocol restarts it by the ground truth, so it cannot run \
                   backwards";
    tracker.fork(seed).ok_or_else(|| StepError::Here(no_copy.to_string()))
}

/// Frame `t` of a run, unless the user has interrupted.
pub(super) fn frame(run: &TrackerRun, t: usize) -> Result<Arc<Frame>, StepError> {
    if guarded::is_interrupted() { Err(RunError::Interrupted.into()) } else { run.frame(t) }
}

impl Reversal {
    /// Reverse runs of a track; `regions` has one region per frame.
    pub fn new(run: TrackerRun, regions: Vec<Region>) -> Self {
        Self { run, regions, shares_runs: true, memory: Mutex::default() }
    }

    /// Reverse runs that share nothing, so that the cost of each can be measured. `forks` has the tracker in
    /// each frame.
    pub(super) fn apart(run: TrackerRun, regions: Vec<Region>, forks: Vec<Fork>) -> Self {
        let memory = Memory { forward: forks.into_iter().enumerate().collect(), ..Memory::default() };
        Self { run, regions, shares_runs: false, memory: Mutex::new(memory) }
    }

    /// Cost of the reverse runs since the last call.
    pub(super) fn take_cost(&self) -> ReverseCost {
        std::mem::take(&mut self.memory().cost)
    }

    /// Frees the trackers. The errors found so far are kept.
    pub fn free_trackers(&self) {
        let mut memory = self.memory();
        memory.forward.clear();
        memory.latest = None;
    }

    fn memory(&self) -> MutexGuard<'_, Memory> {
        self.memory.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Tracker of the forward run after frame `t`.
    fn forward(&self, memory: &mut Memory, t: usize) -> Result<Fork, StepError> {
        let forks = &mut memory.forward;
        if forks.is_empty() {
            let (tracker, _) = self.run.start(&*frame(&self.run, 0)?)?;
            forks.insert(0, tracker);
        }
        let none = || StepError::Here(format!("there is no tracker before frame {t} (from 0)"));
        let (at, nearest) = forks.range(..=t).next_back().ok_or_else(none)?;
        let (at, mut tracker) = (*at, fork(&**nearest, None)?);
        for t in at + 1..=t {
            let state = tracker.update(&*frame(&self.run, t)?)?;
            if Some(&state.region) != self.regions.get(t) {
                return Err(StepError::Here(format!(
                    "the tracker is not deterministic: a second run gave another region in frame {t} (from 0)"
                )));
            }
            if t.is_multiple_of(STRIDE) {
                forks.insert(t, fork(&*tracker, None)?);
            }
        }
        Ok(tracker)
    }

    /// Error of frame `to` in the reverse run that starts in the later frame `from`.
    fn backward(&self, memory: &mut Memory, from: usize, to: usize) -> Result<f64, StepError> {
        let no_way =
            || StepError::Here(format!("there is no way back from frame {from} to frame {to} (from 0)"));
        if to >= from || from >= self.regions.len() {
            return Err(no_way());
        }
        if !self.shares_runs {
            memory.backward.clear();
            memory.latest = None;
        }
        let known = |memory: &Memory| memory.backward.get(&from).and_then(|e| e.get(from - to - 1)).copied();
        if let Some(error) = known(memory) {
            return Ok(error);
        }
        let tracking = Cell::default();
        let (at, mut tracker) = match memory.latest.take() {
            Some((start, at, tracker)) if start == from => (at, tracker),
            _ => {
                let forward = self.forward(memory, from)?;
                let seed = num::seed::seed(self.run.seed, &["reverse", &from.to_string()]);
                (from, clocked(&tracking, || fork(&*forward, Some(seed)))?)
            }
        };
        let errors = memory.backward.entry(from).or_default();
        for t in (to..at).rev() {
            let frame = frame(&self.run, t)?;
            let state = clocked(&tracking, || tracker.update(&frame))?;
            // A reverse run to an earlier frame passes through the later ones, whose errors are known already.
            if errors.len() == from - t - 1 {
                errors.push(overlap::error(&state.region, &self.regions[t]));
            }
        }
        memory.latest = Some((from, to.min(at), tracker));
        memory.cost.tracking += tracking.get();
        memory.cost.runs += 1;
        memory.cost.frames += at.saturating_sub(to) as u64;
        known(memory).ok_or_else(no_way)
    }
}

/// Access of a detector to a [`Reversal`] during one call.
struct Handle<'a> {
    reversal: &'a Reversal,
    /// First error of a reverse run in this call.
    failure: RefCell<Option<StepError>>,
}

impl Reverse for Handle<'_> {
    fn error(&self, from: usize, to: usize) -> Option<f64> {
        let start = Instant::now();
        let mut memory = self.reversal.memory();
        let error = self.reversal.backward(&mut memory, from, to);
        memory.cost.waiting += start.elapsed();
        error.map_err(|e| self.failure.borrow_mut().get_or_insert(e).clone()).ok()
    }
}

/// Output of a detector, which may run the tracker backwards.
///
/// # Errors
/// When a reverse run or the program of the detector failed.
pub fn detect(
    detector: &dyn Detector,
    input: Input<'_>,
    reversal: Option<&Reversal>,
) -> Result<DetectorOutput, StepError> {
    let reversal = reversal.filter(|_| detector.facts().needs_reverse);
    let handle = reversal.map(|reversal| Handle { reversal, failure: RefCell::default() });
    let reverse = handle.as_ref().map(|handle| handle as &dyn Reverse);
    let mut output = detector.detect(&Input { reverse, ..input });
    if let Some(failure) = output.failure.take() {
        return Err(TrackerError::Broken(failure).into());
    }
    handle.and_then(|handle| handle.failure.into_inner()).map_or(Ok(output), Err)
}

#[cfg(test)]
mod tests;
