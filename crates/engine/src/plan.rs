//! Plan of an experiment, made before anything is computed: sequences with their digests, jobs, and the
//! recipes of tracks, signals, models and cells.

pub mod cells;
mod demand;
pub mod experiment;
pub mod folds;
mod inputs;
pub mod recipes;
pub mod shard;
#[cfg(test)]
mod tests;
mod training;
mod why;

pub use cells::CellState;
pub use demand::{distinct_signals, needed_roles, signal_index, variants};
pub use experiment::{ExperimentPlan, PlannedSequence, PlannedSuite};
pub use shard::Shard;
pub use training::{Key, Place, TrainingNeed};
pub use why::why;

/// One repetition of a tracker, to be run on each sequence.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Job {
    /// Index of the tracker in the experiment.
    pub tracker: usize,
    /// Repetition, from 0.
    pub run: u32,
}
