//! Running an experiment: sequences in, judged cells out. Knows traits, no method by name, and does no
//! I/O of its own beyond asking sequences for their frames.
//!
//! [`pass`] goes once over the frames of one sequence and feeds every tracker and signal; [`judge`]
//! trains what is to be trained, detects and scores; [`run`](mod@run) does it for all sequences on all
//! cores; [`store`] writes files.

pub mod judge;
pub mod pass;
pub mod run;
pub mod store;

pub use run::{Options, Outcome, run};
