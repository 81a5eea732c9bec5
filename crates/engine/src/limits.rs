//! Limits of a run: how long a job may take, and the flag that interrupts everything.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

/// The run was interrupted.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error("interrupted")]
pub struct Interrupted;

/// A flag that interrupts a run; set by Ctrl-C. Clones share it.
#[derive(Debug, Clone, Default)]
pub struct Stop(Arc<AtomicBool>);

impl Stop {
    /// Requests the interruption.
    pub fn set(&self) {
        self.0.store(true, Ordering::Relaxed);
    }

    /// Whether the interruption was requested.
    pub fn is_set(&self) -> bool {
        self.0.load(Ordering::Relaxed)
    }
}

/// Limits of supervised work.
#[derive(Debug, Clone, Default)]
pub struct RunLimits {
    /// Longest time a job may use, all its steps together; `None` for no limit.
    pub timeout: Option<Duration>,
    /// Interrupts everything.
    pub stop: Stop,
}
