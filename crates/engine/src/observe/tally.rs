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

/// How many results of each stage were in the store, and how many were computed.
#[derive(Debug, Default)]
pub struct Tally([[AtomicUsize; 2]; 4]);

impl Tally {
    /// Counts one result.
    pub fn add(&self, work: Work, cached: bool) {
        self.0[work as usize][usize::from(cached)].fetch_add(1, Ordering::Relaxed);
    }

    /// Numbers of computed and of cached results of a stage.
    pub fn of(&self, work: Work) -> (usize, usize) {
        let [computed, cached] = &self.0[work as usize];
        (computed.load(Ordering::Relaxed), cached.load(Ordering::Relaxed))
    }
}

impl std::fmt::Display for Tally {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let words = [
            (Work::Tracks, "tracks"),
            (Work::Signals, "signals"),
            (Work::Models, "models"),
            (Work::Labels, "labels"),
        ];
        let parts = words.iter().map(|(work, word)| {
            let (computed, cached) = self.of(*work);
            format!("{word} {computed} computed, {cached} cached")
        });
        f.write_str(&parts.collect::<Vec<_>>().join("; "))
    }
}
