//! Cells of a plan (which method on which track), and their states in a store.

use super::demand::variants;
use super::experiment::{ExperimentPlan, PlannedSequence};
use super::recipes::{self, DetectorKey};
use super::training::Key;
use crate::error::CellError;
use crate::spec::method::Method;
use crate::store::Store;
use crate::store::address::{Recipe, Stage};
use rayon::prelude::*;
use std::collections::BTreeMap;

/// State of a cell in a store.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum CellState {
    /// The store has the result.
    Cached,
    /// The store has a result of another recipe; `why` shows the difference.
    Stale,
    /// The result was never computed, or has been removed.
    Missing,
    /// The result cannot be computed, because data or results of the tracker are absent.
    Absent,
}

impl CellState {
    /// All states, in the order of their declaration.
    pub const ALL: [Self; 4] = [Self::Cached, Self::Stale, Self::Missing, Self::Absent];

    /// Name of the state in tables and messages.
    pub fn word(self) -> &'static str {
        match self {
            Self::Cached => "cached",
            Self::Stale => "stale",
            Self::Missing => "missing",
            Self::Absent => "absent",
        }
    }
}

/// Parts that the recipe of a cell's labels is made of: its beginning, the addition of the detector, and the
/// seed; or the reason why there is none. Whole recipes are made only for display, since those of a million
/// cells need more than a gigabyte.
pub(crate) type LabelsFrom<'p> = Result<(&'p Recipe, &'p DetectorKey, u64), &'p CellError>;

impl ExperimentPlan<'_> {
    /// Jobs and variants of the cells of a sequence, in the experiment's order; `source` is that of the
    /// sequence's video.
    pub fn cells_on(&self, source: &str) -> Vec<(usize, usize)> {
        let methods: Vec<&Method> = variants(self.experiment).map(|(method, _)| method).collect();
        let pairs = (0..self.jobs.len()).flat_map(|j| (0..methods.len()).map(move |v| (j, v)));
        let has_cell = |(j, v): &(usize, usize)| {
            let tracker = &self.experiment.trackers[self.jobs[*j].tracker];
            self.jobs[*j].run < tracker.runs && methods[*v].runs_on(&tracker.label) && tracker.runs_on(source)
        };
        pairs.filter(has_cell).collect()
    }

    /// True if the store has a job's track with all needed signals.
    pub fn is_cached(&self, store: &Store, planned: &PlannedSequence, job: usize) -> bool {
        let mut wanted = (0..self.signals.len()).filter(|k| self.wants_signal(planned, job, *k));
        let is_cached = |k| self.signal_recipe(planned, job, k).is_ok_and(|r| store.contains(&r.address()));
        planned.addresses[job].as_ref().is_ok_and(|track| store.contains(track)) && wanted.all(is_cached)
    }

    /// State of each cell, in the order of [`ExperimentPlan::cells_on`].
    pub fn states(&self, store: &Store) -> Vec<CellState> {
        self.map_cells(store, |state, _, _| state).into_iter().flatten().collect()
    }

    /// Calls `of` with the state of each cell, its name in the store and the origin of its labels. Results
    /// are by sequence, in the order of [`ExperimentPlan::cells_on`].
    pub(crate) fn map_cells<T: Send>(
        &self,
        store: &Store,
        of: impl Fn(CellState, &dyn Fn() -> String, LabelsFrom<'_>) -> T + Sync,
    ) -> Vec<Vec<T>> {
        let variants: Vec<_> = variants(self.experiment).collect();
        let params: Vec<String> = variants.iter().map(|(_, v)| v.params()).collect();
        let keys = self.detector_keys();
        let on_one_input = |a: &(usize, usize), b: &(usize, usize)| {
            a.0 == b.0 && self.signals_of(a.1) == self.signals_of(b.1)
        };
        let of_sequence = |(s, planned): (usize, &PlannedSequence)| {
            let sequence = planned.sequence.name.as_str();
            let is_cached = |j: usize| self.is_cached(store, planned, j);
            let has_track: Vec<bool> = (0..self.jobs.len()).map(is_cached).collect();
            let cells = self.cells_on(&planned.sequence.origin.source);
            let mut all = Vec::with_capacity(cells.len());
            for cells in cells.chunk_by(on_one_input) {
                let on = self.input(planned, cells[0].0, cells[0].1).map(recipes::labels_on);
                for &(j, v) in cells {
                    let (job, (method, variant), params) = (self.jobs[j], variants[v], &params[v]);
                    let name = || self.cell_name(sequence, job, &method.name, params);
                    let seed = || self.seed(&method.name, params, sequence, job);
                    let from = match (&on, &keys[&(v, job.tracker, self.part(variant, s))]) {
                        (Err(e), _) | (Ok(_), Err(e)) => Err(e),
                        (Ok(on), Ok(key)) => Ok((on, key, if key.uses_seed { seed() } else { 0 })),
                    };
                    all.push(of(state_of(store, has_track[j], &name, from), &name, from));
                }
            }
            all
        };
        self.test().sequences.par_iter().enumerate().map(of_sequence).collect()
    }

    /// Contribution of each detector to recipes.
    fn detector_keys(&self) -> BTreeMap<Key, Result<DetectorKey, CellError>> {
        let given =
            self.given().map(|(key, detector)| (key, Ok::<_, CellError>(DetectorKey::new(detector, None))));
        let trained = self.needs(|_, _| true).into_iter().map(|(key, need)| {
            (key, need.map(|need| DetectorKey::new(&need.variant.detector, Some(need.address))))
        });
        given.chain(trained).collect()
    }
}

/// State of a cell. `has_track` is true if the store has the cell's track with all signals.
fn state_of(store: &Store, has_track: bool, name: &dyn Fn() -> String, from: LabelsFrom<'_>) -> CellState {
    match from {
        Err(_) => CellState::Absent,
        Ok((on, key, seed)) if store.contains(&key.address(on, seed)) => match has_track {
            true => CellState::Cached,
            false => CellState::Missing,
        },
        // Of an empty store the names need not be made.
        Ok(_) if !store.is_empty() && store.knows(Stage::Labels, &name()) => CellState::Stale,
        Ok(_) => CellState::Missing,
    }
}
