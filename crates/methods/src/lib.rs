//! Trackers, signals and detectors, and everything that is counted and computed from their output.
//!
//! | module | from | to |
//! |---|---|---|
//! | [`tracker`] | a sequence | a region for each frame |
//! | [`signal`] | frames and regions | one number for each frame |
//! | [`detector`] | a signal | a label for each frame |
//! | [`score`] | labels and ground truth | counts and measures, by versioned protocols |
//! | [`readings`] | counts and scores | the distance of readings of a paper from the numbers that it prints |
//! | [`analysis`] | signals or regions of whole suites | numbers, tables and charts |

pub mod analysis;
pub mod detector;
#[cfg(test)]
mod outside_tests;
#[cfg(test)]
#[path = "../../judge/src/range_tests.rs"]
mod range_tests;
pub mod readings;
pub mod signal;
pub mod tracker;

pub use trackfail_judge::score;
