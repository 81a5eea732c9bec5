//! State of a plan's cells in the store.

use super::experiment::{ExperimentPlan, PlannedSequence};
use crate::store::Store;
use crate::store::address::Stage;
use rayon::prelude::*;

/// State of a cell in the store.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum CellState {
    /// Its result is in the store.
    Cached,
    /// The store has a result of another recipe; `why` shows the difference.
    Stale,
    /// It was never computed, or has been removed.
    Missing,
    /// It cannot be computed, because data or the tracker's results are absent.
    Absent,
}

impl CellState {
    /// All states, in the order of their declaration.
    pub const ALL: [Self; 4] = [Self::Cached, Self::Stale, Self::Missing, Self::Absent];

    /// Its word in tables and messages.
    pub fn word(self) -> &'static str {
        match self {
            Self::Cached => "cached",
            Self::Stale => "stale",
            Self::Missing => "missing",
            Self::Absent => "absent",
        }
    }
}

impl ExperimentPlan<'_> {
    /// Whether a job's track with all its needed signals is in the store.
    pub fn is_cached(&self, store: &Store, suite: usize, planned: &PlannedSequence, job: usize) -> bool {
        let Ok(track) = &planned.tracks[job] else { return false };
        let mut wanted = (0..self.signals.len()).filter(|k| self.wants_signal(suite, planned, job, *k));
        let is_cached = |k| self.signal_recipe(planned, job, k).is_ok_and(|r| store.contains(&r.address()));
        store.contains(&track.address()) && wanted.all(is_cached)
    }

    /// Whether each track of the test suite with all its signals is in the store, sequences x jobs.
    pub fn cached_tracks(&self, store: &Store) -> Vec<Vec<bool>> {
        let of = |s: &PlannedSequence| -> Vec<bool> {
            (0..s.tracks.len()).map(|j| self.is_cached(store, 0, s, j)).collect()
        };
        self.test().sequences.par_iter().map(of).collect()
    }

    /// State of every cell, in the order of [`ExperimentPlan::cells`].
    pub fn states(&self, store: &Store) -> Vec<CellState> {
        let cached = self.cached_tracks(store);
        self.map_labels(|labels| match labels.address().map(|address| store.contains(&address)) {
            None => CellState::Absent,
            Some(true) if cached[labels.cell.sequence][labels.cell.job] => CellState::Cached,
            Some(true) => CellState::Missing,
            Some(false) if store.is_empty() => CellState::Missing,
            Some(false) if store.knows(Stage::Labels, &self.stored_name(&labels.name())) => CellState::Stale,
            Some(false) => CellState::Missing,
        })
    }
}
