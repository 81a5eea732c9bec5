//! What the parts of a run share.

use super::detector_outputs::DetectorOutputCache;
use super::reverse::FRAMES_IN_MEMORY;
use crate::dataset::frame_cache::FrameCache;
use crate::error::RunError;
use crate::limits::RunLimits;
use crate::observe::progress::ProgressWatch;
use crate::observe::tally::Tally;
use crate::plan::ExperimentPlan;
use crate::store::address::Address;
use crate::store::{Record, Store};
use serde::de::DeserializeOwned;
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

/// How to run.
#[derive(Clone)]
pub struct Options {
    /// Folder of real data, if the user gave one.
    pub data_root: Option<PathBuf>,
    /// Compute everything anew, whatever the store has.
    pub force: bool,
    /// Time limit a cell, and the flag that ends the run.
    pub limits: RunLimits,
    /// Called as frames are done, with done and total numbers.
    pub progress: Arc<dyn Fn(u64, u64) + Send + Sync>,
    /// Counts what is done, for onlookers.
    pub watch: Arc<ProgressWatch>,
}

impl Default for Options {
    fn default() -> Self {
        let (limits, progress) = (RunLimits::default(), Arc::new(|_, _| {}));
        Self { data_root: None, force: false, limits, progress, watch: Arc::default() }
    }
}

/// What the parts of a run share.
pub struct Context<'a> {
    /// The plan.
    pub plan: &'a ExperimentPlan<'a>,
    /// The store.
    pub store: &'a Store,
    /// How to run.
    pub options: &'a Options,
    /// What was computed.
    pub tally: Tally,
    /// Called once a decoded frame.
    pub on_frame: Arc<dyn Fn() + Send + Sync>,
    /// Decoded frames, kept where trackers run backwards.
    pub frames: Arc<FrameCache>,
    /// Outputs of detectors in memory.
    pub outputs: DetectorOutputCache,
}

impl<'a> Context<'a> {
    /// A context in which `frames` frames are to be decoded.
    pub fn new(plan: &'a ExperimentPlan<'a>, store: &'a Store, options: &'a Options, frames: u64) -> Self {
        let (done, progress, watch) = (AtomicU64::new(0), options.progress.clone(), options.watch.clone());
        watch.frames(0, frames);
        let on_frame = move || {
            let done = (done.fetch_add(1, Ordering::Relaxed) + 1).min(frames);
            watch.frames(done, frames);
            progress(done, frames);
        };
        let tally = Tally::default();
        let frames = Arc::new(FrameCache::new(if plan.needs_reverse() { FRAMES_IN_MEMORY } else { 0 }));
        Self {
            plan,
            store,
            options,
            tally,
            on_frame: Arc::new(on_frame),
            frames,
            outputs: DetectorOutputCache::default(),
        }
    }

    /// The content of a record that may be used: none when everything is to be computed anew.
    pub fn cached<T: DeserializeOwned>(&self, address: &Address, rows: usize) -> Option<T> {
        if self.options.force { None } else { self.store.get(address, rows) }
    }

    /// Keeps records; those that are computed anew although they were there are compared with what was.
    ///
    /// # Errors
    /// When the store cannot be written to.
    pub fn put(&self, records: Vec<Record>) -> Result<(), RunError> {
        if self.options.force {
            let other = |r: &&Record| self.store.differs(r);
            let addresses: Vec<Address> =
                records.iter().filter(other).map(|r| r.head.recipe.address()).collect();
            self.store.forget(&addresses);
        }
        Ok(self.store.put(&records)?)
    }
}
