//! Options of a run, and the context that its parts share.

use super::detector_outputs::DetectorOutputCache;
use super::reverse::FRAMES_IN_MEMORY;
use super::tracker_run::TrackerRun;
use super::units::{Unit, frames_to_do};
use crate::limits::RunLimits;
use crate::observe::costs::CostTally;
use crate::observe::tally::Tally;
use crate::plan::{ExperimentPlan, Job, recipes};
use crate::store::Store;
use crate::store::address::Address;
use serde::de::DeserializeOwned;
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use trackfail_dataset::Sequence;
use trackfail_dataset::frame_cache::FrameCache;

/// Options of a run, given by the user.
#[derive(Clone)]
pub struct Options {
    /// Folders of real data. The first one that has a file is used.
    pub data_roots: Vec<PathBuf>,
    /// True to compute everything again, even what the store has.
    pub force: bool,
    /// Time limit of a job, and the flag that interrupts the run.
    pub limits: RunLimits,
    /// Called after each frame with the number of frames done and of all frames.
    pub progress: Arc<dyn Fn(u64, u64) + Send + Sync>,
}

impl Default for Options {
    fn default() -> Self {
        let (limits, progress) = (RunLimits::default(), Arc::new(|_, _| {}));
        Self { data_roots: Vec::new(), force: false, limits, progress }
    }
}

/// Plan, store and options of a run, with the caches and counters that its parts share.
pub struct Context<'a> {
    /// Plan of the experiment that is run.
    pub plan: &'a ExperimentPlan<'a>,
    /// Store of results, which the run reads and fills.
    pub store: &'a Store,
    /// Options of a run.
    pub options: &'a Options,
    /// Counts computed and cached results.
    pub tally: Tally,
    /// Number of frames done, and of all frames to do.
    frames_done: AtomicU64,
    frames_to_do: u64,
    /// Cache of decoded frames, for experiments with reverse runs.
    pub frames: Arc<FrameCache>,
    /// Outputs of detectors in memory.
    pub outputs: DetectorOutputCache,
    /// Counts the time that trackers with their signals take.
    pub costs: CostTally,
}

impl<'a> Context<'a> {
    /// Creates the context for work on these units.
    pub fn new(plan: &'a ExperimentPlan<'a>, store: &'a Store, options: &'a Options, units: &[Unit]) -> Self {
        Self {
            plan,
            store,
            options,
            tally: Tally::default(),
            frames_done: AtomicU64::new(0),
            frames_to_do: frames_to_do(plan, store, options.force, units),
            frames: Arc::new(FrameCache::new(if plan.needs_reverse() { FRAMES_IN_MEMORY } else { 0 })),
            outputs: DetectorOutputCache::default(),
            costs: CostTally::default(),
        }
    }

    /// Reports that a pass has finished a frame.
    pub fn frame_done(&self) {
        let done = self.frames_done.fetch_add(1, Ordering::Relaxed) + 1;
        (self.options.progress)(done.min(self.frames_to_do), self.frames_to_do);
    }

    /// Run of a job's tracker on a sequence, ready to start.
    pub fn tracker_run(&self, sequence: &Arc<Sequence>, job: Job) -> TrackerRun {
        let tracker = &self.plan.experiment.trackers[job.tracker];
        TrackerRun {
            sequence: sequence.clone(),
            frames: self.frames.clone(),
            config: tracker.setup.plugin.clone(),
            run: job.run,
            seed: recipes::track_seed(self.plan.experiment, sequence, tracker, job.run),
            data_roots: self.options.data_roots.clone(),
        }
    }

    /// Content of a record of the store; `None` if it is absent or everything is computed again. `rows` is
    /// the number of rows that it must have.
    pub fn cached<T: DeserializeOwned>(&self, address: &Address, rows: usize) -> Option<T> {
        if self.options.force { None } else { self.store.get(address, rows) }
    }
}
