//! Observation of runs: their progress while they go on, and the tally of computed and cached results.

pub mod progress;
pub mod tally;
