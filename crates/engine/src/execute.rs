//! Execution of a plan. The files in order; each uses only those above it:
//!
//! | file | contents |
//! |---|---|
//! | [`supervise`] | jobs that may panic, take too long or be interrupted |
//! | [`tracker_run`] | one run of a tracker on a sequence |
//! | [`pass`](mod@pass) | one pass over the frames of a sequence, for all its trackers and signals |
//! | [`reverse`] | trackers run backwards in time |
//! | [`track`] | a track with its signals |
//! | [`detector_outputs`] | outputs of detectors, in memory or in the store |
//! | `units` | the sequences with their jobs, and the threads that take them |
//! | [`context`] | what the parts of a run share, with its options |
//! | [`tracking`] | tracks and signals, from the store or computed |
//! | [`judge`](mod@judge) | the cells of a sequence: outputs of detectors, from the store or computed, and their scores |
//! | [`train`] | trained parameters and learned models |
//! | [`analyse`](mod@analyse) | analyses of signals and tracks |
//! | [`timing`] | processing times |
//! | [`estimate`] | what is left to be done, and how long it may take |
//! | [`run`](mod@run) | a whole experiment, or a shard of it |

pub mod analyse;
pub mod context;
pub mod detector_outputs;
pub mod estimate;
pub mod judge;
pub mod outcome;
pub mod pass;
pub mod reverse;
pub mod run;
pub mod supervise;
pub mod timing;
pub mod track;
pub mod tracker_run;
pub mod tracking;
pub mod train;
mod units;

pub use context::Options;
pub use outcome::{Cell, CellName, Outcome};
pub use run::{ShardOutcome, load, run, run_shard};
