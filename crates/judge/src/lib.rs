//! Tells when a visual object tracker has lost its target.
//!
//! | module | from | to |
//! |---|---|---|
//! | [`tracker`] | a sequence | a region for each frame |
//! | [`signal`] | frames and regions | one number for each frame |
//! | [`detector`] | a signal | a label for each frame |
//! | [`score`] | labels and ground truth | counts and measures, by versioned protocols |
//! | [`method`] | a name, or plugins with parameters | signals and a detector |
//! | [`reader`] | the frames of a track | the values of its signals |
//! | [`judged`] | the output of a detector | the state of the target in each frame |
//! | [`mod@judge`], [`monitor`] | frames and boxes of a tracker | a judgment of each frame: whole tracks, or live |

#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;

pub mod detector;
pub mod judge;
pub mod judged;
pub mod method;
pub mod monitor;
mod network;
#[cfg(test)]
mod range_tests;
pub mod reader;
mod saved;
pub mod score;
pub mod signal;
pub mod tracker;

pub use judge::{Track, judge};
pub use method::Method;
pub use trackfail_core::{direction, image, num, plugin, region, sequence};
