//! Costs: how long each tracker with its signals takes for a frame, as the runs of a store have found it. They are kept
//! beside the records for estimates alone, and are no part of results or addresses.

use crate::plan::ExperimentPlan;
use crate::store::{Store, write_derived};
use sha2::{Digest, Sha256};
use std::collections::BTreeMap;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Duration;
use trackfail_core::num::hexadecimal;
use trackfail_dataset::text;

/// Name of the file in the store's folder.
const FILE: &str = "costs.json";
/// Size of the largest file that is read, in bytes; a larger one is begun anew.
const MAX_FILE: u64 = 4 << 20;

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
        for (k, spent) in self.spent.iter().enumerate() {
            let [nanoseconds, frames] = [0, 1].map(|of| spent[of].load(Ordering::Relaxed) as f64);
            if frames > 0.0 {
                let key = key(plan, k / self.trackers, k % self.trackers);
                costs.0.insert(key, nanoseconds * 1e-9 / frames);
            }
        }
        if let Ok(bytes) = serde_json::to_vec(&costs.0) {
            let _ = write_derived(&store.folder().join(FILE), &bytes);
        }
    }
}

/// Known costs: seconds a frame on one core.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Costs(BTreeMap<String, f64>);

impl Costs {
    /// Those that the runs of a store have found; none where the file is missing or cannot be read.
    pub fn read(store: &Store) -> Self {
        let bytes = text::read_at_most(&store.folder().join(FILE), MAX_FILE);
        Self(bytes.ok().and_then(|bytes| serde_json::from_slice(&bytes).ok()).unwrap_or_default())
    }

    /// Seconds that a tracker with its signals takes for a frame of a suite.
    pub fn per_frame(&self, plan: &ExperimentPlan<'_>, suite: usize, tracker: usize) -> Option<f64> {
        self.0.get(&key(plan, suite, tracker)).copied()
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
    hexadecimal(&Sha256::digest(text)[..12])
}
