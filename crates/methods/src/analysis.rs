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
mod cut_values;
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
use serde::{Deserialize, Serialize};
use std::sync::Arc;
use trackfail_core::num::accumulation::AccumulationError;
use trackfail_core::plugin::{Entry, Role};

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

/// Result of an analysis.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Findings {
    /// Numbers by name, finite.
    pub numbers: Vec<(String, f64)>,
    /// Tables by name.
    pub tables: Vec<Grid>,
    /// Charts by name.
    pub charts: Vec<Chart>,
}

/// A table of numbers.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Grid {
    /// Name in the analysis.
    pub name: String,
    /// Heading of the first column, which holds the headings of the rows.
    pub corner: String,
    /// Column headings.
    pub columns: Vec<String>,
    /// Row headings with one value for each column, empty where there is none. The only row of a table may have no
    /// heading: such rows of several trackers are shown as the rows of one table.
    pub rows: Vec<(String, Vec<Option<f64>>)>,
}

/// Curves on common axes.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Chart {
    /// Name in the analysis.
    pub name: String,
    /// Name of the horizontal axis.
    pub x: String,
    /// Name of the vertical axis.
    pub y: String,
    /// Whether the vertical axis is logarithmic.
    pub y_log: bool,
    /// Curves by name: finite points from left to right. A curve without a name gets its tracker's. One named
    /// [`INTERVAL`] has the corners of the interval of the only point of the curve before it: left and lower, right and
    /// upper end.
    pub curves: Vec<(String, Vec<(f64, f64)>)>,
}

/// Name of a curve that has the corners of an interval.
pub const INTERVAL: &str = "95 % interval";

impl Findings {
    /// A number by name.
    pub fn number(&self, name: &str) -> Option<f64> {
        self.numbers.iter().find(|(known, _)| known == name).map(|(_, value)| *value)
    }
}

/// Names of the findings of an analysis.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Names {
    /// Numbers.
    pub numbers: Vec<String>,
    /// Tables.
    pub tables: Vec<String>,
    /// Charts.
    pub charts: Vec<String>,
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
    fn suites(&self) -> (usize, usize);

    /// Whether it takes the runs of a suite that methods are tested on, and not those that they learn from; suites are
    /// counted from 0.
    fn is_tested(&self, _suite: usize) -> bool {
        false
    }

    /// Names of its findings, given the number of suites.
    fn names(&self, suites: usize) -> Names;

    /// Computes the findings.
    ///
    /// # Errors
    /// When the tracks do not allow it.
    fn analyze(&self, populations: &[Population<'_>]) -> Result<Findings, AnalysisError>;
}

impl<P: Analysis + 'static> Role<P> for dyn Analysis {
    fn hold(plugin: P) -> Arc<Self> {
        Arc::new(plugin)
    }
}

/// Why an analysis has no findings.
#[derive(Debug, thiserror::Error)]
pub enum AnalysisError {
    /// There is no suite.
    #[error("no suite")]
    NoSuite,
    /// There is more than one suite, or none.
    #[error("one suite is analyzed")]
    OneSuite,
    /// There is another number of suites.
    #[error("two suites are analyzed")]
    TwoSuites,
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
