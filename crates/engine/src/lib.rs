//! Running an experiment: sequences in, judged cells out. Knows traits, no method by name, and does no
//! I/O of its own beyond asking sequences for their frames and the store for what is there.
//!
//! [`plan`] lays an experiment out and gives every result its [`address`], made from [`recipes`]; [`pass`]
//! goes once over the frames of one sequence and feeds every tracker and signal, [`reverse`] runs a tracker
//! backwards, [`timing`] with a clock beside it, [`supervise`] looks after those that panic or hang; [`tracks`] and [`judge`] take from the
//! [`store`] what is there and compute what is not; [`run`](mod@run) does it for all sequences on all cores, or for a share of them;
//! [`progress`] tells onlookers what a run is at, [`why`] tells what a result would be made from now and was made from before.

pub mod address;
pub mod analyse;
pub mod judge;
pub mod pass;
pub mod plan;
pub mod progress;
pub mod recipes;
pub mod reverse;
pub mod run;
pub mod shard;
pub mod spec;
pub mod store;
pub mod supervise;
pub mod tally;
pub mod timing;
pub mod tracks;
pub mod train;
pub mod why;

use trackfail_core::{direction, image, num, plugin, region};
use trackfail_dataset as dataset;
use trackfail_methods::{analysis, detector, score, signal, tracker};

pub use plan::ExperimentPlan;
pub use run::{Options, Outcome, run};
