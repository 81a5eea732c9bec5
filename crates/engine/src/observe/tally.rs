//! Tally of a run: how many results were computed, how many were in the store.

use std::sync::atomic::{AtomicUsize, Ordering};

/// Stage of a counted result.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Work {
    /// Tracks.
    Tracks,
    /// Signals on tracks.
    Signals,
    /// Trained parameters, learned models and analyses.
    Models,
    /// Outputs of detectors.
    Labels,
}

/// Numbers of computed and of cached results, by stage.
#[derive(Debug, Default)]
pub struct Tally([[AtomicUsize; 2]; 4]);

impl Tally {
    /// Counts one result.
    pub fn add(&self, work: Work, cached: bool) {
        self.0[work as usize][usize::from(cached)].fetch_add(1, Ordering::Relaxed);
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
