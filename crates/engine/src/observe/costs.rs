//! Costs: how long each tracker with its signals takes for a frame, as the runs of a store have found it. They are kept
//! beside the records for estimates alone, and are no part of results or addresses.

use crate::plan::ExperimentPlan;
use crate::store::{Store, write_derived};
use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};
use std::collections::BTreeMap;
use std::path::Path;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Duration;
use trackfail_dataset::text;

/// Name of the file in the store's folder.
const FILE: &str = "costs.json";
/// Size of the largest file that is read, in bytes.
const MAX_FILE: u64 = 4 << 20;
/// Largest number of costs that are kept.
const MAX_COSTS: usize = 10_000;

/// Time that some frames took, on one core.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub struct Cost {
    /// Number of frames.
    pub frames: u64,
    /// Seconds for all of them.
    pub seconds: f64,
}

impl Cost {
    /// Seconds a frame; `None` where nothing is known.
    pub fn per_frame(&self) -> Option<f64> {
        let known = self.frames > 0 && self.seconds.is_finite() && self.seconds >= 0.0;
        known.then(|| self.seconds / self.frames as f64)
    }
}

/// Counts the time of a run, by suite and tracker.
#[derive(Debug)]
pub struct CostTally {
    trackers: usize,
    /// Nanoseconds and frames.
    spent: Vec<[AtomicU64; 2]>,
}

impl CostTally {
    /// A tally for a plan.
    pub fn new(plan: &ExperimentPlan<'_>) -> Self {
        let trackers = plan.experiment.trackers.len();
        let spent = (0..trackers * plan.suites.len()).map(|_| Default::default()).collect();
        Self { trackers, spent }
    }

    /// Adds time that a tracker or one of its signals took on a suite.
    pub fn add_time(&self, suite: usize, tracker: usize, time: Duration) {
        let nanoseconds = u64::try_from(time.as_nanos()).unwrap_or(u64::MAX);
        self.spent[suite * self.trackers + tracker][0].fetch_add(nanoseconds, Ordering::Relaxed);
    }

    /// Adds frames that a tracker and its signals are done with.
    pub fn add_frames(&self, suite: usize, tracker: usize, frames: usize) {
        self.spent[suite * self.trackers + tracker][1].fetch_add(frames as u64, Ordering::Relaxed);
    }

    /// Keeps what was found for later estimates. What cannot be written is forgotten.
    pub fn keep(&self, plan: &ExperimentPlan<'_>, store: &Store) {
        let mut costs = Costs::read(store);
        for (k, [nanoseconds, frames]) in self.spent.iter().enumerate() {
            let (frames, seconds) = (frames.load(Ordering::Relaxed), nanoseconds.load(Ordering::Relaxed));
            if frames > 0 {
                let cost = Cost { frames, seconds: seconds as f64 * 1e-9 };
                costs.0.insert(key(plan, k / self.trackers, k % self.trackers), cost);
            }
        }
        while costs.0.len() > MAX_COSTS {
            costs.0.pop_first();
        }
        if let Ok(bytes) = serde_json::to_vec(&costs.0) {
            let _ = write_derived(&store.folder().join(FILE), &bytes);
        }
    }
}

/// Known costs.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Costs(BTreeMap<String, Cost>);

impl Costs {
    /// Those that the runs of a store have found; none where the file is missing or cannot be read.
    pub fn read(store: &Store) -> Self {
        let bytes = text::read_at_most(&store.folder().join(Path::new(FILE)), MAX_FILE);
        Self(bytes.ok().and_then(|bytes| serde_json::from_slice(&bytes).ok()).unwrap_or_default())
    }

    /// Seconds that a tracker with its signals takes for a frame of a suite.
    pub fn per_frame(&self, plan: &ExperimentPlan<'_>, suite: usize, tracker: usize) -> Option<f64> {
        self.0.get(&key(plan, suite, tracker))?.per_frame()
    }
}

/// Everything that the cost of a tracker on a suite depends on, but the machine.
fn key(plan: &ExperimentPlan<'_>, suite: usize, tracker: usize) -> String {
    let setup = &plan.experiment.trackers[tracker];
    let suite_name = &plan.suites[suite].name;
    let mut text = format!("{suite_name} {} {} {}", setup.kind, setup.version, setup.setup.params());
    for choice in plan.signals_on(suite, tracker).into_iter().map(|k| &plan.signals[k]) {
        text.push_str(&format!(" {} {} {}", choice.kind, choice.version, choice.signal.params()));
    }
    Sha256::digest(text).iter().take(12).map(|byte| format!("{byte:02x}")).collect()
}
