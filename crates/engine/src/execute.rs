//! Execution of a plan. The files in order; each uses only those above it:
//!
//! | file | contents |
//! |---|---|
//! | [`supervise`] | jobs that may panic, hang or be interrupted |
//! | [`tracker_run`] | one run of a tracker on a sequence |
//! | [`cores`] | cores that have nothing to do |
//! | [`lane`] | a tracker with the signals read from it |
//! | [`frame_loop`], `schedule` | the loop over frames, shared by all below and by `detect` |
//! | [`pass`](mod@pass) | one pass over the frames of a sequence, for all its trackers and signals |
//! | [`reverse`] | trackers run backwards in time |
//! | [`track`] | a track with its signals |
//! | [`detector_outputs`] | outputs of detectors, in memory or in the store |
//! | [`context`] | what the parts of a run share, with its options |
//! | [`tracking`] | tracks and signals, from the store or computed |
//! | [`judge`](mod@judge) | labels and scores, from the store or computed |
//! | [`train`] | trained parameters and learned models |
//! | [`analyse`](mod@analyse) | analyses of signals and tracks |
//! | [`timing`] | processing times |
//! | [`estimate`] | what is left to be done, and how long it may take |
//! | [`run`](mod@run), [`run_shard`](mod@run_shard) | a whole experiment, or a shard of it |

pub mod analyse;
pub mod context;
pub mod cores;
pub mod detector_outputs;
pub mod estimate;
pub mod frame_loop;
pub mod frame_observer;
pub mod judge;
pub mod lane;
pub mod outcome;
pub mod pass;
pub mod reverse;
pub mod run;
pub mod run_shard;
mod schedule;
pub mod supervise;
pub mod timing;
pub mod track;
pub mod tracker_run;
pub mod tracking;
pub mod train;
mod units;

pub use context::Options;
pub use outcome::{Cell, CellName, Outcome};
pub use run::{load, run};
pub use run_shard::{ShardOutcome, run_shard};
