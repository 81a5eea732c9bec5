//! Observation of runs: numbers of computed and cached results, and costs.

pub mod costs;
pub mod tally;
