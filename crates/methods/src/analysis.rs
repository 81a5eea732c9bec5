//! Analyses: they compute numbers for claims, tables and charts from the tracks of one or more suites. An
//! analysis describes either a signal, before any detector reads it, or the trackers themselves.
//!
//! A plugin is one file with parameters, an [`Analysis`] that is a [`Plugin`](trackfail_core::plugin::Plugin), and an `ENTRY`
//! in [`ANALYSES`].

mod average_overlap;
mod collapsed_boxes;
mod confident;
#[cfg(test)]
mod conformance_tests;
mod consistent;
mod cut_values;
mod findings;
mod longterm;
mod oxuva;
pub mod processing_time;
mod resets;
mod success;
mod uncertainty_model;
mod window_lengths;

use crate::detector::Example;
use crate::detector::consistency::ConsistencyError;
use crate::score::trajectory::Trajectory;
use std::sync::Arc;
use trackfail_core::num::accumulation::AccumulationError;
use trackfail_core::plugin::{Entry, ParamError, Role, unknown};

pub use findings::{Chart, Curve, Findings, Grid, INTERVAL, Layout, Names, Row, Values};

/// Names that most files of analyses import.
mod prelude {
    pub(super) use super::unknown_rules;
    pub(super) use super::{Analysis, AnalysisError, Curve, Layout, Population, Reads, Row, Values};
    pub(super) use crate::score::TrackerMetric;
    pub(super) use crate::score::trajectory::Trajectory;
    pub(super) use crate::tracker::Status;
    pub(super) use schemars::JsonSchema;
    pub(super) use serde::{Deserialize, Serialize};
    pub(super) use smart_default::SmartDefault;
    pub(super) use trackfail_core::plugin::{Entry, ParamError, PlainParams, Plugin, Range};
    pub(super) use trackfail_core::region::{Areas, Region};
}

/// The tracks of one suite.
pub struct Population<'a> {
    /// Name of the suite.
    pub suite: &'a str,
    /// Tracks of the suite with the analyzed signal, sequence by sequence and run by run.
    pub tracks: Vec<Example<'a>>,
    /// Regions of the same tracks; empty unless the analysis [reads](Analysis::reads) them.
    pub trajectories: Vec<Trajectory<'a>>,
    /// Time that the methods took on the tracks; empty unless the analysis reads the clock.
    pub timings: Vec<processing_time::Timing>,
}

/// Input of an analysis.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Reads {
    /// One signal on all tracks.
    Signal,
    /// The regions of all tracks.
    Regions,
    /// One signal on all tracks, and their regions.
    SignalAndRegions,
    /// The clock. The findings differ from run to run and are not stored.
    Clock,
}

/// A checked configuration of an analysis.
pub trait Analysis: Send + Sync {
    /// Input of the analysis.
    fn reads(&self) -> Reads {
        Reads::Signal
    }

    /// Names of the methods to time, and the number of repeats.
    fn timed(&self) -> (&[String], usize) {
        (&[], 0)
    }

    /// Smallest and largest number of suites.
    fn suites(&self) -> (usize, usize) {
        (1, 1)
    }

    /// True if the analysis takes the runs of this suite (0-based) that methods are tested on, and not those
    /// that they learn from. Trackers are scored and timed on the former.
    fn is_tested(&self, _suite: usize) -> bool {
        self.reads() != Reads::Signal
    }

    /// Names of the numbers, tables and charts for this number of suites.
    fn layout(&self, suites: usize) -> Layout;

    /// Computes the values of the [layout](Self::layout).
    ///
    /// # Errors
    /// When the tracks do not allow it, such as a suite without tracks.
    fn values(&self, populations: &[Population<'_>]) -> Result<Values, AnalysisError>;

    /// Computes the findings.
    ///
    /// # Errors
    /// When the number of suites is outside of [`Analysis::suites`], and when the tracks do not allow it.
    fn analyze(&self, populations: &[Population<'_>]) -> Result<Findings, AnalysisError> {
        let ((least, most), got) = (self.suites(), populations.len());
        if !(least..=most).contains(&got) {
            return Err(AnalysisError::Suites { least, most, got });
        }
        Ok(self.layout(got).with(self.values(populations)?))
    }
}

impl<P: Analysis + 'static> Role<P> for dyn Analysis {
    fn hold(plugin: P) -> Arc<Self> {
        Arc::new(plugin)
    }
}

/// The number of suites that an analysis takes, in words.
fn suites(least: &usize, most: &usize) -> String {
    if least == most {
        format!("exactly {least} to analyze")
    } else {
        format!("{least} to {most} to analyze")
    }
}

/// Reason why an analysis has no findings.
#[derive(Debug, thiserror::Error)]
pub enum AnalysisError {
    /// The number of suites is wrong.
    #[error("suites: {}, not {got}", suites(.least, .most))]
    Suites {
        /// Least number of suites.
        least: usize,
        /// Largest number of suites.
        most: usize,
        /// Number of suites that were given.
        got: usize,
    },
    /// The suite has no track.
    #[error("there is no track to score")]
    NoTrack,
    /// No frame, or every frame, is without a target.
    #[error("no frame is without target, or none has one")]
    NoAbsence,
    /// The suite has no timed track.
    #[error("no track was timed")]
    NotTimed,
    /// No model can be fitted to the consistent frames.
    #[error(transparent)]
    Consistency(#[from] ConsistencyError),
    /// The distribution of a sum cannot be computed.
    #[error(transparent)]
    Accumulation(#[from] AccumulationError),
    /// The distributions of two suites cannot be compared.
    #[error("sums of the two suites: {0}")]
    Compared(#[source] AccumulationError),
}

/// Error for a parameter `rules` that is not one of `known`.
fn unknown_rules<'k>(rules: &str, known: impl IntoIterator<Item = &'k str>) -> ParamError {
    ParamError { message: unknown("set of rules", rules, known), key: Some("rules"), span: None }
}

/// All analyses, by kind.
pub static ANALYSES: &[Entry<dyn Analysis>] = &[
    uncertainty_model::ENTRY,
    cut_values::ENTRY,
    window_lengths::ENTRY,
    success::ENTRY,
    average_overlap::ENTRY,
    resets::ENTRY,
    collapsed_boxes::ENTRY,
    longterm::ENTRY,
    oxuva::ENTRY,
    processing_time::ENTRY,
];

impl Reads {
    /// True if the analysis reads regions.
    pub fn has_regions(self) -> bool {
        matches!(self, Self::Regions | Self::SignalAndRegions)
    }

    /// True if the analysis reads a signal.
    pub fn has_signal(self) -> bool {
        matches!(self, Self::Signal | Self::SignalAndRegions)
    }
}
