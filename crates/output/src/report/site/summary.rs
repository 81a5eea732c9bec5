//! A report in short: the file `summary.json` beside its page.

use super::error::SiteError;
use super::standing::{Standing, standings};
use crate::report::claims::{ClaimCounts, Finding};
use crate::report::files::SUMMARY;
use crate::report::uncertainty;
use crate::report::written::WrittenReport;
use crate::results::Measure;
use crate::results::{self, Results};
use crate::table;
use crate::table::layout;
use crate::table::number::Style;
use serde::{Deserialize, Serialize};
use std::path::Path;
use trackfail_core::direction::Direction;
use trackfail_dataset::{DatasetError, synthetic, text};
use trackfail_engine::store;

/// Version of the summary's format.
/// - 1: first version;
/// - 2: undecided claims, and checks beside claims;
/// - 3: the verdict.
pub const FORMAT: u32 = 3;
/// Maximum size of a summary that is read, in bytes.
pub(super) const MAX_SUMMARY: u64 = 1 << 20;

/// An experiment's report in short.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Summary {
    /// [`FORMAT`] of the writer.
    pub format: u32,
    /// Name of the experiment.
    pub experiment: String,
    /// Title of the experiment.
    pub title: String,
    /// The paper that is replicated; may be empty.
    pub paper: String,
    /// The table or figure of the paper; may be empty.
    pub object: String,
    /// Numbers of its claims by outcome.
    pub claims: ClaimCounts,
    /// Numbers of its checks of the arithmetic by outcome.
    #[serde(default)]
    pub checks: ClaimCounts,
    /// The suite that the numbers are about.
    pub suite: String,
    /// How much of it was present, in words: `12 of 21 targets, 10 runs`.
    pub data: String,
    /// Number of targets that were present.
    pub present: u64,
    /// Number of targets of the whole suite.
    pub wanted: u64,
    /// Whether the suite is synthetic.
    pub synthetic: bool,
    /// Number of cells without a result.
    pub failed: u64,
    /// The answer of its page in a sentence; may be empty.
    #[serde(default)]
    pub verdict: String,
    /// The best method on each tracker, in the experiment's order.
    pub best: Vec<Best>,
    /// Its methods on the leaderboard, for an experiment that asks for it.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub standings: Vec<Standing>,
}

/// The best method on a tracker by the metric that its report is ordered by, as printed.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Best {
    /// Label of the tracker.
    pub tracker: String,
    /// The metric.
    pub metric: String,
    /// The method; several that are equal, separated by commas.
    pub method: String,
    /// Its value.
    pub value: String,
}

/// The summary of a written report.
pub fn summary(results: &Results, written: &WrittenReport) -> Summary {
    let (experiment, manifest) = (&results.experiment, &results.manifest);
    let suite = &manifest.suite;
    let counts = |checks: bool| {
        ClaimCounts::of(written.findings.iter().filter(|f| f.is_check == checks).map(Finding::overall))
    };
    Summary {
        format: FORMAT,
        experiment: experiment.name.clone(),
        title: experiment.title.clone(),
        paper: experiment.paper.clone().unwrap_or_default(),
        object: experiment.object.clone().unwrap_or_default(),
        claims: counts(false),
        checks: counts(true),
        suite: suite.name.clone(),
        data: table::data_note(experiment, manifest),
        present: suite.present.len() as u64,
        wanted: suite.wanted as u64,
        synthetic: synthetic::is_rendered(&suite.name),
        failed: manifest.cells_failed.len() as u64,
        verdict: written.verdict.clone(),
        best: best(results),
        standings: standings(results, &written.scores),
    }
}

/// The best method on each tracker. Anchors do not compete, nor do the points of a grid, because the best point would be
/// chosen on the data that are reported; methods of one tracker with different protocols are not compared.
fn best(results: &Results) -> Vec<Best> {
    let experiment = &results.experiment;
    let metric = uncertainty::headline(experiment);
    let style = Style::of_metric(metric);
    let of_tracker = |tracker: &str| {
        let competes = |m: &Measure| m.params.is_empty() && !layout::is_anchor(experiment, &m.method);
        let mut mine: Vec<(f64, String)> = Vec::new();
        let mut protocols: Vec<&str> = Vec::new();
        for m in results.measures.iter().filter(|m| m.tracker == tracker && m.attribute.is_none()) {
            let Some(value) = m.value(metric).filter(|v| v.is_finite() && competes(m)) else {
                continue;
            };
            protocols.extend(experiment.protocol_of(&m.method).map(|p| p.name));
            mine.push((style.round(value), m.method.clone()));
        }
        protocols.dedup();
        let values = mine.iter().map(|(value, _)| *value);
        let top = match metric.direction() {
            Direction::HigherIsBetter => values.reduce(f64::max),
            Direction::LowerIsBetter => values.reduce(f64::min),
            Direction::Neither => None,
        };
        // A best method needs another one to be better than.
        let top = top.filter(|_| protocols.len() == 1 && mine.len() > 1)?;
        let first: Vec<&str> = mine.iter().filter(|(v, _)| *v == top).map(|(_, m)| m.as_str()).collect();
        let (tracker, metric) = (tracker.to_string(), metric.title());
        // More than three equal methods are not called best.
        (first.len() <= 3).then(|| Best {
            tracker,
            metric,
            method: first.join(", "),
            value: style.format(top),
        })
    };
    experiment.trackers.iter().filter_map(|t| of_tracker(&t.label)).collect()
}

/// Writes the summary beside the page of a report.
///
/// # Errors
/// When the file cannot be written.
pub fn write_summary(results: &Results, written: &WrittenReport, report: &Path) -> Result<(), SiteError> {
    let path = report.join(SUMMARY);
    let summary = summary(results, written);
    Ok(store::write_derived(&path, &results::to_json(&path, &summary)?)?)
}

/// A summary that cannot be shown.
#[derive(Debug, thiserror::Error)]
pub enum SummaryError {
    /// The report has none.
    #[error("it has no {SUMMARY}; `trackfail report {name}` writes it")]
    Absent {
        /// Name of the experiment.
        name: String,
    },
    /// The file is not readable or too large.
    #[error("{SUMMARY} cannot be read")]
    Unreadable(#[source] DatasetError),
    /// The file is not a summary.
    #[error("{SUMMARY} is none of this program: {0}")]
    Foreign(#[from] serde_json::Error),
    /// Written by a later program.
    #[error("{SUMMARY} has format {0}; this program reads up to {FORMAT}")]
    Format(u64),
}

/// Reads the summary at `path`, of the report of the experiment `name`.
///
/// # Errors
/// See [`SummaryError`].
pub fn read_summary(path: &Path, name: &str) -> Result<Summary, SummaryError> {
    if !path.exists() {
        return Err(SummaryError::Absent { name: name.to_string() });
    }
    let bytes = text::read_at_most(path, MAX_SUMMARY).map_err(SummaryError::Unreadable)?;
    let value: serde_json::Value = serde_json::from_slice(&bytes)?;
    if let Some(format) = value.get("format").and_then(serde_json::Value::as_u64)
        && format > u64::from(FORMAT)
    {
        return Err(SummaryError::Format(format));
    }
    Ok(serde_json::from_value(value)?)
}
