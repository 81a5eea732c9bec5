//! Finds the number of a table that is to be explained.

use super::Explained;
use crate::report::finished::{self, FinishedError};
use crate::report::trace::Trace;
use crate::results::Results;
use crate::results::analyses::FILE as ANALYSES;
use crate::results::measures;
use crate::results::{CellScore, method_label};
use crate::table::layout::{self, CellRef};
use std::path::{Path, PathBuf};
use trackfail_core::plugin;
use trackfail_engine::spec::table::Table;
use trackfail_methods::score::{Counts, Metric};

/// A number that cannot be explained.
#[derive(Debug, thiserror::Error)]
pub enum SelectError {
    /// The experiment has no results, or they cannot be read.
    #[error(transparent)]
    Finished(#[from] FinishedError),
    /// A name that is not known where it is looked for.
    #[error("{place}: {message}")]
    Unknown {
        /// Where it is looked for: the results folder, an experiment, a table, or a method on a tracker.
        place: String,
        /// The nearest known name, or all of them.
        message: String,
    },
    /// Several experiments have a table of the name.
    #[error("{}: several experiments have a table `{table}`: write {}", results.display(), names.join(" or "))]
    Ambiguous {
        /// The results folder.
        results: PathBuf,
        /// Name of the table.
        table: String,
        /// The tables with their experiments.
        names: Vec<String>,
    },
    /// The table is made by an analysis.
    #[error(
        "{table} shows `{shows}`, which an analysis made without events and detections; what it found is in {}",
        file.display()
    )]
    OfAnalysis {
        /// The table with its experiment.
        table: String,
        /// The analysis and its part.
        shows: String,
        /// The file with the findings.
        file: PathBuf,
    },
    /// The run on the sequence failed.
    #[error("{sequence}: {method} on {tracker}, run {run}, has no result: {reason}")]
    Failed {
        /// The sequence.
        sequence: String,
        /// The method.
        method: String,
        /// The tracker.
        tracker: String,
        /// Number of the run, from 0.
        run: u32,
        /// Why it has no result.
        reason: String,
    },
    /// The files of the results do not belong together.
    #[error("{sequence}: frames.parquet gives {counted:?}, scores.csv has {stored:?}; run it again")]
    Counts {
        /// The sequence.
        sequence: String,
        /// The counts from the frames.
        counted: Counts,
        /// The counts in the table of scores.
        stored: Counts,
    },
}

/// A number of a table, by the words that name it.
pub struct Selection<'a> {
    /// Row of the table.
    pub row: &'a str,
    /// Column of the table.
    pub column: &'a str,
    /// Label of the tracker; all where it is left out.
    pub tracker: Option<&'a str>,
    /// Method, with or without its grid point; all where it is left out.
    pub method: Option<&'a str>,
}

/// Finds a table, named as `EXPERIMENT/TABLE` or by its name alone where one experiment has it: the results, and the
/// table's place among those of the experiment.
///
/// # Errors
/// When there is none, or there are several.
pub fn find_table(results: &Path, name: &str) -> Result<(Results, usize), SelectError> {
    let place =
        |results: &Results, table: &str| results.experiment.tables.iter().position(|t| t.name == table);
    if let Some((experiment, table)) = name.rsplit_once('/') {
        let results = finished::read(results, experiment)?;
        let Some(place) = place(&results, table) else {
            let known = results.experiment.tables.iter().map(|t| t.name.as_str());
            let message = plugin::unknown("table", table, known);
            return Err(SelectError::Unknown { place: experiment.to_string(), message });
        };
        return Ok((results, place));
    }
    let finished = finished::names(results);
    if finished.is_empty() {
        return Err(FinishedError::NothingRun { results: results.to_path_buf() }.into());
    }
    let mut known: Vec<String> = Vec::new();
    let mut found = Vec::new();
    for experiment in &finished {
        let results = finished::read(results, experiment)?;
        known.extend(results.experiment.tables.iter().map(|t| t.name.clone()));
        if let Some(place) = place(&results, name) {
            found.push((results, place));
        }
    }
    if found.len() > 1 {
        let names = found.iter().map(|(r, _)| format!("`{}/{name}`", r.experiment.name)).collect();
        return Err(SelectError::Ambiguous {
            results: results.to_path_buf(),
            table: name.to_string(),
            names,
        });
    }
    found.pop().ok_or_else(|| SelectError::Unknown {
        place: results.display().to_string(),
        message: plugin::unknown("table", name, known.iter().map(String::as_str)),
    })
}

/// Reads one of a cell's names.
type NameOf<'f> = &'f dyn Fn(&CellRef) -> String;

/// The numbers of the table that are meant; `scores` are those of [`Results::scores`].
///
/// # Errors
/// When there are none, with the nearest known name.
pub fn find_cells(
    results: &Results,
    scores: &[CellScore],
    table: &Table,
    wanted: &Selection<'_>,
) -> Result<Vec<CellRef>, SelectError> {
    let name = format!("{}/{}", results.experiment.name, table.name);
    if let Some(shows) = &table.shows {
        let (shows, file) = (shows.to_string(), results.folder.join(ANALYSES));
        return Err(SelectError::OfAnalysis { table: name, shows, file });
    }
    let parts =
        measures::by_attribute(scores, &results.manifest.cells_failed, &results.manifest.suite.attributes);
    let mut cells =
        layout::cell_refs(&results.experiment, table, &[results.measures.as_slice(), &parts].concat());
    let label = |c: &CellRef| method_label(&c.method, &c.params);
    let names: [(&str, Option<&str>, NameOf<'_>); 4] = [
        ("row", Some(wanted.row), &|c| c.row.clone()),
        ("column", Some(wanted.column), &|c| c.column.clone()),
        ("tracker", wanted.tracker, &|c| c.tracker.clone()),
        ("method", wanted.method, &label),
    ];
    for (what, wanted, of) in names {
        let Some(wanted) = wanted else { continue };
        let mut known: Vec<String> = Vec::new();
        for cell in &cells {
            if !known.contains(&of(cell)) {
                known.push(of(cell));
            }
        }
        // A method may also be named without its grid point, and a metric as tables show it.
        let shown = |name: &str| Metric::from_name(name).map(Metric::title);
        cells.retain(|c| {
            let name = of(c);
            name == wanted
                || (what == "method" && c.method == wanted)
                || (["row", "column"].contains(&what) && shown(&name).is_some_and(|title| title == wanted))
        });
        if cells.is_empty() {
            let message = plugin::unknown(what, wanted, known.iter().map(String::as_str));
            return Err(SelectError::Unknown { place: name, message });
        }
    }
    Ok(cells)
}

/// Checks that a number rests on a sequence.
///
/// # Errors
/// When its run failed, or the sequence is not known.
pub fn check_sequence(explained: &Explained, wanted: &str) -> Result<(), SelectError> {
    if explained.parts.iter().any(|p| p.sequence == wanted) {
        return Ok(());
    }
    let (tracker, method) = (&explained.spot.tracker, &explained.spot.method);
    if let Some((sequence, run, reason)) = explained.failed.iter().find(|f| f.0 == wanted) {
        return Err(SelectError::Failed {
            sequence: sequence.clone(),
            method: method.clone(),
            tracker: tracker.clone(),
            run: *run,
            reason: reason.clone(),
        });
    }
    let known = explained.parts.iter().map(|p| p.sequence.as_str());
    let message = plugin::unknown("sequence", wanted, known);
    Err(SelectError::Unknown { place: format!("{method} on {tracker}"), message })
}

/// Checks that the frames of a sequence give the counts that the table of scores has: one run writes both.
///
/// # Errors
/// When they do not.
pub fn check_counts(explained: &Explained, sequence: &str, traces: &[Trace]) -> Result<(), SelectError> {
    let part = explained.parts.iter().find(|p| p.sequence == sequence);
    let (Some(part), Some(protocol)) = (part, explained.protocol) else { return Ok(()) };
    let counted: Counts = traces.iter().map(|t| t.judge(protocol).counts).sum();
    if counted == part.counts {
        return Ok(());
    }
    Err(SelectError::Counts { sequence: sequence.to_string(), counted, stored: part.counts })
}
