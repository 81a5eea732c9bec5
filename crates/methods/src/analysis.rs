//! Analyses: what the tracks of one or more suites say of a signal itself, before any detector reads it, or
//! of the trackers themselves. Numbers for claims, tables and charts come out.
//!
//! A plugin is one file with parameters, an [`Analysis`] and an `ENTRY` in [`ANALYSES`].

#[cfg(test)]
mod conformance;
pub mod cut_values;
pub mod processing_time;
pub mod resets;
pub mod success;
pub mod uncertainty_model;

use crate::detector::Example;
use crate::plugin::Entry;
use crate::score::trajectory::Trajectory;
use serde::{Deserialize, Serialize};

/// The tracks of one suite.
pub struct Population<'a> {
    /// Name of the suite.
    pub suite: &'a str,
    /// Its tracks with the analysed signal: sequence by sequence, run by run.
    pub tracks: Vec<Example<'a>>,
    /// The same tracks as regions, for an analysis that [reads](Analysis::reads) them; empty for others.
    pub trajectories: Vec<Trajectory<'a>>,
    /// What methods took on them, for an analysis that reads the clock; empty for others.
    pub timings: Vec<processing_time::Timing>,
}

/// What an analysis looks at.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Reads {
    /// One signal on all tracks.
    Signal,
    /// The regions of all tracks.
    Regions,
    /// The clock; what it finds out differs from run to run and is not kept.
    Clock,
}

/// What an analysis found out.
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
    /// What the first column holds.
    pub corner: String,
    /// Column headings.
    pub columns: Vec<String>,
    /// Row headings with one value a column, empty where there is none. The only row of a table may be without
    /// heading: those of several trackers are then shown as the rows of one table.
    pub rows: Vec<(String, Vec<Option<f64>>)>,
}

/// Curves on common axes.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Chart {
    /// Name in the analysis.
    pub name: String,
    /// Name of the horizontal axis.
    pub x: String,
    /// Name of the vertical axis.
    pub y: String,
    /// Whether the vertical axis is logarithmic.
    pub y_log: bool,
    /// Curves by name: finite points from left to right. Curves without a name go by their tracker's.
    pub curves: Vec<(String, Vec<(f64, f64)>)>,
}

impl Findings {
    /// A number by name.
    pub fn number(&self, name: &str) -> Option<f64> {
        self.numbers.iter().find(|(known, _)| known == name).map(|(_, value)| *value)
    }
}

/// Names of what an analysis finds out.
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
    /// Checked parameters, defaults filled in.
    fn params(&self) -> serde_json::Value;

    /// What it looks at.
    fn reads(&self) -> Reads {
        Reads::Signal
    }

    /// Methods whose work is timed for it, and how often.
    fn timed(&self) -> (&[String], usize) {
        (&[], 0)
    }

    /// Fewest and most suites it takes.
    fn suites(&self) -> (usize, usize);

    /// What it finds out with so many suites.
    fn names(&self, suites: usize) -> Names;

    /// Finds it out.
    ///
    /// # Errors
    /// In words, when the tracks do not allow it.
    fn analyse(&self, populations: &[Population<'_>]) -> Result<Findings, String>;
}

/// Every analysis, by kind.
pub static ANALYSES: &[Entry<dyn Analysis>] =
    &[uncertainty_model::ENTRY, cut_values::ENTRY, success::ENTRY, resets::ENTRY, processing_time::ENTRY];
