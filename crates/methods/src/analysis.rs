//! Analyses: from the tracks of one or more suites to numbers for claims, tables and charts. They describe a signal
//! itself, before any detector reads it, or the trackers themselves.
//!
//! A plugin is one file with parameters, an [`Analysis`] that is a [`Plugin`](trackfail_core::plugin::Plugin), and an `ENTRY`
//! in [`ANALYSES`].

mod average_overlap;
mod collapsed_boxes;
mod confident;
#[cfg(test)]
mod conformance;
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

/// The tracks of one suite.
pub struct Population<'a> {
    /// Name of the suite.
    pub suite: &'a str,
    /// Its tracks with the analyzed signal: sequence by sequence, run by run.
    pub tracks: Vec<Example<'a>>,
    /// The same tracks as regions; empty unless the analysis [reads](Analysis::reads) them.
    pub trajectories: Vec<Trajectory<'a>>,
    /// The time that methods took on them; empty unless the analysis reads the clock.
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
    /// The clock; the findings differ from run to run and are not stored.
    Clock,
}

/// A checked configuration of an analysis.
pub trait Analysis: Send + Sync {
    /// Its input.
    fn reads(&self) -> Reads {
        Reads::Signal
    }

    /// Methods that are timed for it, and the number of repeats.
    fn timed(&self) -> (&[String], usize) {
        (&[], 0)
    }

    /// Smallest and largest number of suites that it takes.
    fn suites(&self) -> (usize, usize) {
        (1, 1)
    }

    /// Whether it takes the runs of a suite that methods are tested on, and not those that they learn from; suites are
    /// counted from 0.
    fn is_tested(&self, _suite: usize) -> bool {
        false
    }

    /// Numbers, tables and charts that it finds, given the number of suites.
    fn layout(&self, suites: usize) -> Layout;

    /// Computes the values of its [layout](Self::layout) from as many suites as it takes.
    ///
    /// # Errors
    /// When the tracks do not allow it.
    fn values(&self, populations: &[Population<'_>]) -> Result<Values, AnalysisError>;

    /// Names of its findings, given the number of suites.
    fn names(&self, suites: usize) -> Names {
        self.layout(suites).names()
    }

    /// Computes the findings.
    ///
    /// # Errors
    /// For another number of suites than it takes, and when the tracks do not allow it.
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

/// How many suites an analysis takes, in words.
fn suites(least: &usize, most: &usize) -> String {
    if least == most {
        format!("exactly {least} to analyze")
    } else {
        format!("{least} to {most} to analyze")
    }
}

/// Why an analysis has no findings.
#[derive(Debug, thiserror::Error)]
pub enum AnalysisError {
    /// There is another number of suites.
    #[error("suites: {}, not {got}", suites(.least, .most))]
    Suites {
        /// Least number of suites.
        least: usize,
        /// Largest number of suites.
        most: usize,
        /// Number of suites that there are.
        got: usize,
    },
    /// The suite has no track.
    #[error("there is no track to score")]
    NoTrack,
    /// No frame is without target, or none has one.
    #[error("no frame is without target, or none has one")]
    NoAbsence,
    /// The suite has no timed track.
    #[error("no track was timed")]
    NotTimed,
    /// The consistent frames give no model.
    #[error(transparent)]
    Consistency(#[from] ConsistencyError),
    /// The distribution of a sum cannot be computed.
    #[error(transparent)]
    Accumulation(#[from] AccumulationError),
    /// The distributions of two suites cannot be compared.
    #[error("sums of the two suites: {0}")]
    Compared(#[source] AccumulationError),
}

/// The error for a parameter `rules` that names none of those known.
fn unknown_rules<'k>(rules: &str, known: impl IntoIterator<Item = &'k str>) -> ParamError {
    ParamError { message: unknown("set of rules", rules, known), key: Some("rules"), span: None }
}

/// Every analysis, by kind.
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
    /// Whether regions are among it.
    pub fn has_regions(self) -> bool {
        matches!(self, Self::Regions | Self::SignalAndRegions)
    }

    /// Whether a signal is.
    pub fn has_signal(self) -> bool {
        matches!(self, Self::Signal | Self::SignalAndRegions)
    }
}
