//! Experiments: their files, their plan, their execution, and the store of their results. The engine works
//! with traits and knows no method by name. It reads frames of sequences and records of the store, no other
//! files.
//!
//! The folders in order; each uses only those above it:
//!
//! | module | contents |
//! |---|---|
//! | [`spec`] | experiment files, checked |
//! | [`limits`] | time limits and interruption of a run |
//! | [`store`] | records under content [addresses](store::address), packs, staging folders |
//! | [`error`] | why a cell has no result, why a run did not finish |
//! | [`plan`] | sequences, jobs, tracks and cells of an experiment with their recipes; shards; `why` |
//! | [`observe`] | tally of computed and cached results, costs |
//! | [`execute`] | the pass over frames, reverse runs, training, judging, analyses, clock; whole runs and shards |

pub mod error;
pub mod execute;
pub mod limits;
pub mod observe;
pub mod plan;
pub mod spec;
pub mod store;
#[cfg(test)]
mod testing;

pub use error::{CellError, RunError};
pub use execute::{Cell, CellName, Options, Outcome, ShardOutcome, run, run_shard};
pub use limits::{Interrupted, RunLimits, Stop};
pub use plan::{ExperimentPlan, Shard, why};
