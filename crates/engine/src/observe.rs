//! Observation of runs: the tally of computed and cached results, and what they cost.

pub mod costs;
pub mod tally;
