//! What the store already has of a plan.

use super::experiment::{ExperimentPlan, PlannedCell, PlannedSequence};
use super::recipes;
use crate::error::CellError;
use crate::store::Store;
use crate::store::address::{Recipe, Stage};
use rayon::prelude::*;

/// What the store knows of a cell.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum CellState {
    /// It is there.
    Cached,
    /// It was made from something else; `why` says from what.
    Stale,
    /// It was never made.
    Missing,
    /// It cannot be made: the tracker's results are not there.
    Absent,
}

impl CellState {
    /// The word for it.
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
    /// Whether a wanted track with all its wanted signals is in the store.
    pub fn is_kept(&self, store: &Store, suite: usize, job: usize, track: &Recipe) -> bool {
        let address = track.address();
        let wanted = self.signals.iter().enumerate().filter(|(k, _)| self.wants_signal(suite, job, *k));
        let kept = |(_, choice)| store.contains(&recipes::signal(address, choice).address());
        store.contains(&address) && wanted.into_iter().all(kept)
    }

    /// Whether each track of the test suite with all its signals is in the store, sequences x jobs.
    pub fn kept_tracks(&self, store: &Store) -> Vec<Vec<bool>> {
        let of = |s: &PlannedSequence| -> Vec<bool> {
            let tracks = s.tracks.iter().enumerate();
            let kept = |(j, t): (usize, &Result<Recipe, CellError>)| {
                t.as_ref().is_ok_and(|track| self.is_kept(store, 0, j, track))
            };
            tracks.map(kept).collect()
        };
        self.test().sequences.par_iter().map(of).collect()
    }

    /// What the store knows of every cell, in the order of [`ExperimentPlan::cells`].
    pub fn states(&self, store: &Store) -> Vec<(String, CellState)> {
        let kept = self.kept_tracks(store);
        let state = |(cell, (name, recipe)): (PlannedCell, (String, Result<Recipe, CellError>))| {
            let kept = kept[cell.sequence][cell.job];
            let state = match recipe {
                Err(_) => CellState::Absent,
                Ok(recipe) if store.contains(&recipe.address()) && kept => CellState::Cached,
                Ok(recipe) if store.contains(&recipe.address()) => CellState::Missing,
                Ok(_) if store.knows(Stage::Labels, &self.stored_name(&name)) => CellState::Stale,
                Ok(_) => CellState::Missing,
            };
            (name, state)
        };
        self.cells().into_par_iter().zip(self.labels()).map(state).collect()
    }
}
