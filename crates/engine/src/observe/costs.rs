//! Costs: the time per frame of each tracker with its signals, measured in the runs of a store. They are kept
//! beside the records, serve estimates only, and are no part of results or addresses.

use crate::plan::ExperimentPlan;
use crate::store::{Store, write_derived};
use sha2::{Digest, Sha256};
use std::collections::BTreeMap;
use std::sync::{Mutex, PoisonError};
use std::time::Duration;
use trackfail_core::num::hexadecimal;
use trackfail_dataset::text;

/// Name of the file in the store's folder.
const FILE: &str = "costs.json";
/// Largest cost file that is read, in bytes. A larger one is replaced.
const MAX_FILE: u64 = 4 << 20;

/// Seconds and frames of a run, by indices of suite and tracker.
#[derive(Debug, Default)]
pub struct CostTally(Mutex<BTreeMap<(usize, usize), (f64, usize)>>);

impl CostTally {
    /// Adds the time of a track with its signals.
    pub fn add(&self, suite: usize, tracker: usize, time: Duration, frames: usize) {
        let mut spent = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let (seconds, all) = spent.entry((suite, tracker)).or_default();
        *seconds += time.as_secs_f64();
        *all += frames;
    }

    /// Saves the costs for later estimates. Errors of writing are ignored.
    pub fn keep(&self, plan: &ExperimentPlan<'_>, store: &Store) {
        let (mut costs, spent) = (read(store), self.0.lock().unwrap_or_else(PoisonError::into_inner));
        for (&(suite, tracker), &(seconds, frames)) in spent.iter() {
            costs.insert(key(plan, suite, tracker), seconds / frames.max(1) as f64);
        }
        if let Ok(bytes) = serde_json::to_vec(&costs) {
            let _ = write_derived(&store.folder().join(FILE), &bytes);
        }
    }
}

/// Known costs: seconds per frame on one core of a tracker with its signals on a suite, by their [`key`].
pub type Costs = BTreeMap<String, f64>;

/// Reads the costs that runs of a store have saved; empty if the file is absent or unreadable.
pub fn read(store: &Store) -> Costs {
    let bytes = text::read_at_most(&store.folder().join(FILE), MAX_FILE);
    bytes.ok().and_then(|bytes| serde_json::from_slice(&bytes).ok()).unwrap_or_default()
}

/// Key of the cost of a tracker on a suite: all that the cost depends on, except the machine.
pub fn key(plan: &ExperimentPlan<'_>, suite: usize, tracker: usize) -> String {
    let setup = &plan.experiment.trackers[tracker];
    let suite_name = &plan.suites[suite].name;
    let mut text = format!("{suite_name} {} {} {}", setup.kind, setup.version, setup.setup.params());
    for choice in plan.signals_on(suite, tracker).into_iter().map(|k| &plan.signals[k]) {
        text.push_str(&format!(" {} {} {}", choice.kind, choice.version, choice.signal.params()));
    }
    hexadecimal(&Sha256::digest(text)[..12])
}
