//! The work that is left of an experiment or a shard, and an estimate of its time.
//!
//! A track takes its frames times what a frame of its tracker with its signals has taken before, in earlier runs on the
//! store. Reverse runs, training and analyses come on top.

use super::units::units;
use crate::observe::costs::{self, Costs};
use crate::plan::{CellState, ExperimentPlan, Shard, variants};
use crate::spec::method::Variant;
use crate::store::Store;

/// Work that is left of a run or a shard.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Remaining {
    /// Number of tracks that can be computed.
    pub tracks: usize,
    /// Number of tracks that the store has, with all their signals.
    pub tracks_at_hand: usize,
    /// Number of cells in each state, in the order of [`CellState::ALL`].
    pub cells: [usize; 4],
    /// Number of frames in the tracks that are left to compute.
    pub frames: u64,
    /// Estimated seconds on one core, without reverse runs, training and analyses; `None` if the cost of a
    /// tracker is unknown.
    pub seconds: Option<f64>,
}

impl Remaining {
    /// True if the store has everything that can be computed.
    pub fn is_done(&self) -> bool {
        let [_, stale, missing, _] = self.cells;
        self.tracks == self.tracks_at_hand && stale + missing == 0
    }

    /// Number of all cells, in any state.
    pub fn all_cells(&self) -> usize {
        self.cells.iter().sum()
    }
}

/// A plan with the state of its cells in a store.
pub struct Standing<'p> {
    plan: &'p ExperimentPlan<'p>,
    store: &'p Store,
    /// State of each cell, by sequence of the test suite, in the order of [`ExperimentPlan::cells_on`].
    pub states: Vec<Vec<CellState>>,
    costs: Costs,
}

impl<'p> Standing<'p> {
    /// Looks up the cells of a plan in a store, and the costs of earlier runs on it for the estimates.
    pub fn new(plan: &'p ExperimentPlan<'p>, store: &'p Store) -> Self {
        let states = plan.map_cells(store, |state, _, _| state);
        Self { plan, store, states, costs: costs::read(store) }
    }

    /// Work left in the run, or in a shard. Shards leave out trained methods, which the final run computes.
    pub fn remaining(&self, shard: Option<Shard>) -> Remaining {
        let plan = self.plan;
        let is_given = |(_, variant): (_, &Variant)| variant.detector.role().is_none();
        let is_mine: Vec<bool> =
            variants(plan.experiment).map(|one| shard.is_none() || is_given(one)).collect();
        let mut left = Remaining { seconds: Some(0.0), ..Remaining::default() };
        for (suite, s, jobs) in units(plan, shard) {
            let planned = &plan.suites[suite].sequences[s];
            for &job in jobs.iter().filter(|job| planned.tracks[**job].is_ok()) {
                left.tracks += 1;
                if plan.is_cached(self.store, planned, job) {
                    left.tracks_at_hand += 1;
                    continue;
                }
                let frames = planned.sequence.len() as u64;
                left.frames += frames;
                let cost = self.costs.get(&costs::key(plan, suite, plan.jobs[job].tracker));
                left.seconds = left.seconds.zip(cost).map(|(sum, cost)| sum + cost * frames as f64);
            }
            if suite == 0 {
                let states = plan.cells_on(&planned.sequence.origin.source).into_iter().zip(&self.states[s]);
                for (_, state) in states.filter(|((job, v), _)| jobs.contains(job) && is_mine[*v]) {
                    left.cells[*state as usize] += 1;
                }
            }
        }
        left
    }
}

#[cfg(test)]
mod tests;
