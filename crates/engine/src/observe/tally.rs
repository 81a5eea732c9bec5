//! Tally of a run: how many results were computed, how many were in the store.

use crate::store::address::Stage;
use std::sync::atomic::{AtomicUsize, Ordering};

/// Numbers of computed and of cached results, by stage.
#[derive(Debug, Default)]
pub struct Tally([[AtomicUsize; 2]; 4]);

impl Tally {
    /// Counts one result.
    pub fn add(&self, stage: Stage, cached: bool) {
        self.0[stage as usize][usize::from(cached)].fetch_add(1, Ordering::Relaxed);
    }
}

impl std::fmt::Display for Tally {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        for (word, [computed, cached]) in ["tracks", "; signals", "; models", "; labels"].iter().zip(&self.0)
        {
            let [computed, cached] = [computed, cached].map(|n| n.load(Ordering::Relaxed));
            write!(f, "{word} {computed} computed, {cached} cached")?;
        }
        Ok(())
    }
}
