//! Observation of runs: their progress while they go on, the tally of computed and cached results, and what they cost.

pub mod costs;
pub mod progress;
pub mod tally;
