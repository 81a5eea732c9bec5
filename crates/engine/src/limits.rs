//! Limits of a run: how long a job may take, and the flag that interrupts everything.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

/// Error of a run that the user interrupted.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error("interrupted")]
pub struct Interrupted;

/// A flag that interrupts a run, set by Ctrl-C. Clones share the flag.
#[derive(Debug, Clone, Default)]
pub struct Stop(Arc<AtomicBool>);

impl Stop {
    /// Interrupts the run.
    pub fn set(&self) {
        self.0.store(true, Ordering::Relaxed);
    }

    /// True once the run is interrupted.
    pub fn is_set(&self) -> bool {
        self.0.load(Ordering::Relaxed)
    }
}

/// Time limit and interruption of supervised jobs.
#[derive(Debug, Clone, Default)]
pub struct RunLimits {
    /// Longest time of a job, all steps together; `None` for no limit.
    pub timeout: Option<Duration>,
    /// Flag that interrupts all jobs.
    pub stop: Stop,
}
