//! One pass over one sequence: each frame is decoded once and given to every tracker and, with the tracker's state, to
//! every signal.

use super::cores::Cores;
use super::frame_loop::{Collected, Collector, run_frames_on};
use super::frame_observer::FrameObserver;
use super::lane::{Companions, Lane, LaneStep};
use super::supervise::{JobError, Watchdog, supervised};
use super::tracker_run::{TrackerRun, TrackingError};
use crate::error::CellError;
use crate::limits::{Interrupted, RunLimits};
use crate::spec::method::SignalChoice;
use std::sync::Arc;
use std::time::{Duration, Instant};
use trackfail_dataset::Sequence;
use trackfail_dataset::frame_cache::FrameCache;
use trackfail_methods::tracker::TrackerState;

/// One task of a pass: a track, signals on it, or both.
#[derive(Clone)]
pub struct Task {
    /// The tracker's run.
    pub run: TrackerRun,
    /// Its states, where they are known and only signals are needed.
    pub states: Option<Arc<Vec<TrackerState>>>,
    /// The needed signals, as indices into [`Pass::signals`].
    pub signals: Vec<usize>,
    /// States of other trackers, for signals that read them.
    pub companions: Companions,
}

/// A pass over a sequence.
pub struct Pass {
    /// The sequence.
    pub sequence: Arc<Sequence>,
    /// Cache of its decoded frames.
    pub frames: Arc<FrameCache>,
    /// All signals that tasks may need.
    pub signals: Arc<Vec<SignalChoice>>,
    /// The tasks.
    pub tasks: Vec<Task>,
    /// Called once a frame, for progress.
    pub on_frame: Arc<dyn Fn() + Send + Sync>,
    /// Called with the time of each step of a task; the number of tasks stands for the decoding of frames.
    pub spent: Arc<dyn Fn(usize, Duration) + Send + Sync>,
    /// The cores of the run.
    pub cores: Cores,
}

/// Result of a task.
#[derive(Debug, Clone, PartialEq)]
pub struct PassOutput {
    /// One state a frame.
    pub states: Arc<Vec<TrackerState>>,
    /// One series for each of the task's signals, in their order.
    pub signals: Vec<Vec<f64>>,
}

/// Makes a pass and returns a result for each task, in order; see [`supervised`] for tasks that panic or hang.
///
/// # Errors
/// [`Interrupted`].
pub fn pass(pass: Pass, limits: &RunLimits) -> Result<Vec<Result<PassOutput, CellError>>, Interrupted> {
    // One job more: decoding the frames.
    let jobs = pass.tasks.len() + 1;
    let _share = pass.cores.enter();
    supervised(jobs, limits, move |watch, left_out| pass.run(watch, left_out))
}

/// Supervises the tasks of a pass and collects their results.
struct PassObserver<'a> {
    watch: &'a Watchdog,
    on_frame: &'a (dyn Fn() + Send + Sync),
    spent: &'a (dyn Fn(usize, Duration) + Send + Sync),
    collector: Collector,
}

impl FrameObserver for PassObserver<'_> {
    fn check_interrupted(&self) -> Result<(), Interrupted> {
        self.watch.check_interrupted()
    }

    fn supervise<T>(
        &self,
        lane: usize,
        work: impl FnOnce() -> Result<T, TrackingError>,
    ) -> Result<T, TrackingError> {
        let start = Instant::now();
        let done = self.watch.step(lane, work);
        (self.spent)(lane, start.elapsed());
        done
    }

    fn tracked(&self, lane: usize, step: LaneStep<'_>) -> Result<(), TrackingError> {
        self.collector.tracked(lane, step)
    }

    fn measured(&self, lane: usize, signal: usize, values: &[f64]) {
        self.collector.measured(lane, signal, values);
    }

    fn frame_done(&self) {
        (self.on_frame)();
    }
}

impl Pass {
    fn run(
        &self,
        watch: &Watchdog,
        left_out: &[Option<JobError>],
    ) -> Result<Vec<Result<PassOutput, CellError>>, Interrupted> {
        let decoder = left_out.get(self.tasks.len());
        let lane = |(k, task): (usize, &Task)| -> Result<Lane, TrackingError> {
            match [left_out.get(k), decoder].into_iter().flatten().flatten().next() {
                Some(reason) => Err(reason.clone().into()),
                None => watch.step(k, || self.lane(task)),
            }
        };
        let mut lanes: Vec<_> = self.tasks.iter().enumerate().map(lane).collect();
        let collector = Collector::new(self.tasks.iter().map(|task| task.signals.len()));
        let observer = PassObserver { watch, on_frame: &*self.on_frame, spent: &*self.spent, collector };
        run_frames_on(&self.cores, &self.sequence, &self.frames, &mut lanes, &observer)?;
        let collected = observer.collector.into_collected();
        let output = |((lane, collected), task): ((Result<Lane, TrackingError>, _), &Task)| {
            lane.map_err(|e| e.in_sequence(&self.sequence.name))?;
            let Collected { states, signals } = collected;
            Ok(PassOutput { states: task.states.clone().unwrap_or_else(|| Arc::new(states)), signals })
        };
        Ok(lanes.into_iter().zip(collected).zip(&self.tasks).map(output).collect())
    }

    fn lane(&self, task: &Task) -> Result<Lane, TrackingError> {
        let signals = || task.signals.iter().filter_map(|k| self.signals.get(*k));
        let lane = match &task.states {
            Some(states) => Lane::of_states(states.clone()),
            None => Lane::of_run(task.run.clone()),
        };
        let lane = lane.with_signals(&task.run.context(), &task.companions, signals().map(Some))?;
        Ok(lane.with_restarts(&task.run, signals()))
    }
}

#[cfg(test)]
mod tests;
