//! Cores that have nothing to do, which the passes still at work may use.
//!
//! Sequences are passed over side by side, one on each thread. When fewer are left than there are cores, a pass takes
//! [`Share`]s and lets more threads work on its sequence (`schedule`). No result depends on their number.

use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};

/// The cores that a run may use. Clones share them.
#[derive(Debug, Clone)]
pub struct Cores {
    total: usize,
    busy: Arc<AtomicUsize>,
}

/// A core in use; dropping it gives the core back.
#[derive(Debug)]
pub struct Share(Cores);

impl Cores {
    /// So many cores, none of them in use.
    pub fn new(total: usize) -> Self {
        Self { total, busy: Arc::default() }
    }

    /// Their number.
    pub fn total(&self) -> usize {
        self.total
    }

    /// Takes the core of a thread that works in any case, even when all are in use.
    pub fn enter(&self) -> Share {
        self.busy.fetch_add(1, Ordering::Relaxed);
        Share(self.clone())
    }

    /// Takes a core if one is not in use.
    pub fn take(&self) -> Option<Share> {
        let more = |busy: usize| (busy < self.total).then_some(busy + 1);
        let taken = self.busy.fetch_update(Ordering::Relaxed, Ordering::Relaxed, more);
        taken.is_ok().then(|| Share(self.clone()))
    }

    /// Whether more cores are in use than there are.
    pub fn are_crowded(&self) -> bool {
        self.busy.load(Ordering::Relaxed) > self.total
    }
}

impl Drop for Share {
    fn drop(&mut self) {
        self.0.busy.fetch_sub(1, Ordering::Relaxed);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shares_are_taken_while_there_are_any_and_given_back() {
        let cores = Cores::new(2);
        let own = cores.enter();
        let other = cores.take().unwrap();
        assert!(cores.take().is_none() && !cores.are_crowded());
        let third = cores.clone().enter();
        assert!(cores.are_crowded());
        drop((third, other));
        assert!(!cores.are_crowded() && cores.take().is_some());
        drop(own);
        assert!(Cores::new(0).take().is_none());
    }
}
