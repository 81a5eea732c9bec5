//! `reports/index.html`: one offline page over all experiments that have a report.
//!
//! Every report has a `summary.json` beside its page, made of results alone. The site is made of all of these, by a
//! walk over the folder in the order of names: it does not depend on which report was written when, and a report that
//! is removed by hand is gone from the next site. Reports without a summary that can be read are listed as such.
//!
//! The same page with the runs that go on above is what `trackfail serve` shows. A page over nothing but reports has
//! no script.

mod view;

pub use view::{render, render_live};

use super::claims::Finding;
use super::results::Results;
use super::{ClaimOutcome, INDEX, OWNED, ReportError, uncertainty};
use crate::dataset::{synthetic, text};
use crate::direction::Direction;
use crate::engine::store::staging::Staging;
use crate::engine::store::{self, StoreError};
use crate::spec::read::check_experiment_name;
use crate::table::folder::{self, FolderError};
use crate::table::layout;
use crate::table::measures::Measure;
use crate::table::number::Style;
use serde::{Deserialize, Serialize};
use std::fs::File;
use std::path::Path;

/// What an experiment's report is in short, beside its page.
pub const SUMMARY: &str = "summary.json";
/// The experiment's report as Markdown, beside its page.
pub const MARKDOWN: &str = "report.md";
/// Version of the summary's format.
/// - 1: first version.
pub const FORMAT: u32 = 1;
/// Largest summary that is read, in bytes.
const LARGEST: u64 = 1 << 20;
/// What a page of ours has in its head; another one is not replaced.
const OURS: &str = "<meta name=\"generator\" content=\"trackfail\">";

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
    /// What of the paper; may be empty.
    pub object: String,
    /// What became of its claims.
    pub claims: ClaimCounts,
    /// The suite that the numbers are about.
    pub suite: String,
    /// How much of it there was, in words: `12 of 21 targets, 10 runs`.
    pub data: String,
    /// Targets that were there.
    pub present: u64,
    /// Targets of the whole suite.
    pub wanted: u64,
    /// Whether the program has rendered the suite itself.
    pub synthetic: bool,
    /// Units of work without a result.
    pub failed: u64,
    /// The best method on each tracker, in the experiment's order.
    pub best: Vec<Best>,
}

/// Numbers of claims.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ClaimCounts {
    /// Those that hold on every tracker.
    pub hold: u64,
    /// Those that do not hold on one.
    pub do_not_hold: u64,
    /// Others.
    pub cannot_be_tested: u64,
}

/// The best method on a tracker by the metric that its report is ordered by, as printed.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Best {
    /// Label of the tracker.
    pub tracker: String,
    /// The metric.
    pub metric: String,
    /// The method; several that are equal one after the other.
    pub method: String,
    /// Its value.
    pub value: String,
}

/// All reports below a folder.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Site {
    /// Folder, as `sanmiguel2015/table4`, and what its report is, by folder.
    pub reports: Vec<(String, Summary)>,
    /// Folders with a page whose summary cannot be read, with the reason.
    pub unreadable: Vec<(String, String)>,
}

/// A site that could not be written.
#[derive(Debug, thiserror::Error)]
pub enum SiteError {
    /// A file.
    #[error(transparent)]
    Store(#[from] StoreError),
    /// A summary cannot be JSON.
    #[error(transparent)]
    Folder(#[from] FolderError),
    /// The page cannot be rendered.
    #[error(transparent)]
    Report(#[from] ReportError),
}

/// What a report is in short; `findings` are what its numbers say of its claims.
pub fn summary(results: &Results, findings: &[Finding]) -> Summary {
    let (experiment, manifest) = (&results.experiment, &results.manifest);
    let suite = &manifest.suite;
    let mut claims = ClaimCounts::default();
    for finding in findings {
        *(match finding.overall() {
            ClaimOutcome::Holds => &mut claims.hold,
            ClaimOutcome::DoesNotHold => &mut claims.do_not_hold,
            ClaimOutcome::CannotBeTested => &mut claims.cannot_be_tested,
        }) += 1;
    }
    Summary {
        format: FORMAT,
        experiment: experiment.name.clone(),
        title: experiment.title.clone(),
        paper: experiment.paper.clone().unwrap_or_default(),
        object: experiment.object.clone().unwrap_or_default(),
        claims,
        suite: suite.name.clone(),
        data: folder::data_note(experiment, manifest),
        present: suite.present.len() as u64,
        wanted: suite.wanted as u64,
        synthetic: synthetic::SUITES.iter().any(|s| s.name == suite.name),
        failed: manifest.cells_failed.len() as u64,
        best: best(results),
    }
}

/// The best methods. Anchors do not compete, nor do the points of a grid, whose best one is chosen by the very data that
/// are reported; methods of one tracker that are scored by different protocols are not compared.
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
        // The best of one says nothing.
        let top = top.filter(|_| protocols.len() == 1 && mine.len() > 1)?;
        let first: Vec<&str> = mine.iter().filter(|(v, _)| *v == top).map(|(_, m)| m.as_str()).collect();
        let (tracker, metric) = (tracker.to_string(), metric.name().to_string());
        // Of many that are equal none is the best.
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
pub fn write_summary(results: &Results, findings: &[Finding], report: &Path) -> Result<(), SiteError> {
    let path = report.join(SUMMARY);
    Ok(store::write(&path, &folder::to_json(&path, &summary(results, findings))?)?)
}

fn read_summary(path: &Path, name: &str) -> Result<Summary, String> {
    if !path.exists() {
        return Err(format!("it has no {SUMMARY}; `trackfail report {name}` writes it"));
    }
    let bytes = text::read_at_most(path, LARGEST).map_err(|_| format!("{SUMMARY} cannot be read"))?;
    let foreign = |why: &dyn std::fmt::Display| format!("{SUMMARY} is none of this program: {why}");
    let value: serde_json::Value = serde_json::from_slice(&bytes).map_err(|e| foreign(&e))?;
    if let Some(format) = value.get("format").and_then(serde_json::Value::as_u64)
        && format > u64::from(FORMAT)
    {
        return Err(format!("{SUMMARY} has format {format}; this program reads up to {FORMAT}"));
    }
    serde_json::from_value(value).map_err(|e| foreign(&e))
}

/// All reports below a folder, by name; folders that are hidden, and those that are links, are none of them.
pub fn collect(reports: &Path) -> Site {
    let mut site = Site::default();
    let hidden = |e: &walkdir::DirEntry| e.file_name().as_encoded_bytes().starts_with(b".");
    // What lies in a report is no other report.
    let inside = |e: &walkdir::DirEntry| {
        e.depth() > 1
            && OWNED.iter().any(|owned| e.file_name() == *owned)
            && e.path().parent().is_some_and(|parent| parent.join(INDEX).is_file())
            && !e.path().join(INDEX).exists()
            && !e.path().join(SUMMARY).exists()
    };
    let entries = walkdir::WalkDir::new(reports).sort_by_file_name().into_iter();
    // A folder that goes away meanwhile is as one that was never there.
    for entry in entries.filter_entry(|e| e.depth() == 0 || !(hidden(e) || inside(e))).filter_map(Result::ok)
    {
        if entry.depth() < 2 || entry.file_name() != INDEX || !entry.file_type().is_file() {
            continue;
        }
        let Some(folder) = entry.path().parent() else { continue };
        let name = folder.strip_prefix(reports).ok().and_then(Path::to_str).map(|n| n.replace('\\', "/"));
        let Some(name) = name.filter(|name| check_experiment_name(name).is_ok()) else { continue };
        match read_summary(&folder.join(SUMMARY), &name) {
            Ok(summary) => site.reports.push((name, summary)),
            Err(why) => site.unreadable.push((name, why)),
        }
    }
    site.reports.sort_by(|a, b| a.0.cmp(&b.0));
    site.unreadable.sort();
    site
}

/// What [`write_index`] has to tell.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Told {
    /// What is not in the site as it should be, in sentences.
    pub warnings: Vec<String>,
}

/// Writes `index.html` over all reports below a folder. Whoever calls it after a report has taken its place has it in
/// the site, whatever other processes do: of two that write at once the later one looks when the earlier is done.
///
/// # Errors
/// When the page cannot be written.
pub fn write_index(reports: &Path) -> Result<Told, SiteError> {
    // A folder can be locked where the system lets it be opened; elsewhere the lock of the results has to do.
    let lock = File::open(reports).ok();
    if let Some(lock) = &lock {
        let _ = lock.lock();
    }
    let path = reports.join(INDEX);
    let mut told = Told::default();
    if is_foreign(&path) {
        told.warnings.push(format!(
            "{}: left as it is, because it is no page of this program; use another --reports for a page over all reports",
            path.display()
        ));
        return Ok(told);
    }
    let site = collect(reports);
    for (name, why) in &site.unreadable {
        told.warnings.push(format!("{}: {why}", reports.join(name).display()));
    }
    // Put together aside: temporary files beside reports are swept by other runs.
    let aside = Staging::new(reports)?;
    let made = aside.path().join(INDEX);
    store::write(&made, render(&site)?.as_bytes())?;
    std::fs::rename(made, &path).map_err(|e| StoreError::new(&path, e))?;
    Ok(told)
}

/// Whether a file is there that somebody else has written.
fn is_foreign(path: &Path) -> bool {
    if path.is_symlink() || !path.is_file() {
        // A link is replaced, not what it leads to; a folder cannot be.
        return false;
    }
    text::read_capped(path).is_ok_and(|bytes| {
        let head = String::from_utf8_lossy(&bytes[..bytes.len().min(4096)]);
        !bytes.is_empty() && !head.contains(OURS)
    })
}

#[cfg(test)]
mod tests;
