//! The plan of an experiment, made before anything is computed: its sequences with their digests, its jobs, and the
//! recipes of its tracks, signals, models and cells.

pub mod cached;
pub mod cells;
mod confidence;
mod demand;
pub mod experiment;
pub mod folds;
pub mod job;
pub mod labels;
pub mod recipes;
pub mod shard;
#[cfg(test)]
mod tests;
pub mod why;

pub use cached::CellState;
pub use cells::PlannedCell;
pub use demand::{SignalSet, distinct_signals, needed_roles, signal_index, variants};
pub use experiment::{ExperimentPlan, Place, PlannedSequence, PlannedSuite};
pub use job::Job;
pub use labels::PlannedLabels;
pub use shard::Shard;
pub use why::why;
