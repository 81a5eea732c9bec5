//! Selection of the number in a table that is to be explained.

use super::Explained;
use super::listing::in_words;
use crate::report::figures::lines::distinct;
use crate::report::finished::{self, LookupError};
use crate::report::trace::{self, Trace};
use crate::results::beside::plain;
use crate::results::{ANALYSES, CellScore, Results};
use crate::table;
use crate::table::layout::{self, Origin};
use std::fmt::Display;
use std::path::Path;
use trackfail_core::plugin;
use trackfail_engine::spec::table::Table;
use trackfail_methods::score::{Counts, Metric};

/// Error for a name that is not among the known ones of a place.
fn unknown<'k>(place: &str, what: &str, name: &str, known: impl Iterator<Item = &'k String>) -> LookupError {
    let message = plugin::unknown(what, name, known.map(String::as_str));
    LookupError::unknown(format!("{place}: {message}"))
}

/// Row, column, tracker, and method with or without its grid point, which name a number; `None` for all.
pub type Selection<'a> = [Option<&'a str>; 4];

/// Finds a table by `EXPERIMENT/TABLE`, or by its name alone if only one experiment has it. Returns the
/// results, and the table's index in the experiment.
///
/// # Errors
/// When there is no such table, or there are several.
pub fn find_table(results: &Path, name: &str) -> Result<(Results, usize), LookupError> {
    let (place, experiments, table) = match name.rsplit_once('/') {
        Some((experiment, table)) => (experiment.to_string(), vec![experiment.to_string()], table),
        None => (results.display().to_string(), finished::names(results), name),
    };
    if experiments.is_empty() {
        return Err(LookupError::nothing_run(results));
    }
    let mut known: Vec<String> = Vec::new();
    let mut found = Vec::new();
    for experiment in &experiments {
        let results = finished::read(results, experiment)?;
        known.extend(results.experiment.tables.iter().map(|t| t.name.clone()));
        if let Some(place) = results.experiment.tables.iter().position(|t| t.name == table) {
            found.push((results, place));
        }
    }
    if found.len() > 1 {
        let name = |(results, _): &(Results, usize)| format!("`{}/{table}`", results.experiment.name);
        let names = found.iter().map(name).collect::<Vec<_>>().join(" or ");
        let message = format!("{place}: several experiments have a table `{table}`: write {names}");
        return Err(LookupError::unknown(message));
    }
    found.pop().ok_or_else(|| unknown(&place, "table", table, known.iter()))
}

/// Function that reads one of the names of a number.
type NameOf = fn(&Origin) -> String;

/// Numbers of the table that `wanted` selects; `scores` come from [`Results::scores`].
///
/// # Errors
/// When nothing is selected; the error has the nearest known name.
pub fn find_cells(
    results: &Results,
    scores: &[CellScore],
    table: &Table,
    wanted: Selection<'_>,
) -> Result<Vec<Origin>, LookupError> {
    let name = format!("{}/{}", results.experiment.name, table.name);
    if let Some(shows) = &table.shows {
        let file = results.folder.join(ANALYSES).display().to_string();
        let shown = "which an analysis made without events and detections; what it found is in";
        return Err(LookupError::unknown(format!("{name} shows `{shows}`, {shown} {file}")));
    }
    let pooled = table::pooled(results, scores, [table]);
    let mut cells = layout::origins(&results.experiment, table, &pooled);
    let names: [(&str, NameOf); 4] = [
        ("row", |of| of.row.clone()),
        ("column", |of| of.column.clone()),
        ("tracker", |of| of.tracker.clone()),
        ("method", Origin::label),
    ];
    for ((what, name_of), wanted) in names.into_iter().zip(wanted) {
        let Some(wanted) = wanted else { continue };
        let known = distinct(cells.iter().map(name_of));
        // A method may also be named without its grid point, and a metric as tables show it.
        let title = |name: &str| Metric::from_name(name).map(Metric::title);
        cells.retain(|of| {
            let name = name_of(of);
            name == wanted
                || (what == "method" && of.method == wanted)
                || (["row", "column"].contains(&what) && title(&name).is_some_and(|title| title == wanted))
        });
        if cells.is_empty() {
            return Err(unknown(&name, what, wanted, known.iter()));
        }
    }
    Ok(cells)
}

/// The file of single frames.
const FRAMES: &str = "frames.parquet";

/// True for a row of kept results, of which only counts are there.
fn is_kept(of: &Origin) -> bool {
    plain(&of.tracker) != of.tracker || plain(&of.method) != of.method
}

/// True if the results have the single frames behind a number.
pub fn has_frames(results: &Results, of: &Origin) -> bool {
    results.manifest.files.contains_key(FRAMES) && !is_kept(of)
}

/// Tracks of a sequence behind a number, frame by frame.
///
/// # Errors
/// When the run on the sequence failed, the sequence is unknown, the results have no single frames, or these
/// do not give the same counts as the table of scores. One run writes both.
pub fn traces(results: &Results, explained: &Explained, wanted: &str) -> Result<Vec<Trace>, LookupError> {
    let (of, experiment) = (&explained.of, &results.experiment.name);
    let Origin { tracker, method, .. } = of;
    let Some(part) = explained.parts.iter().find(|p| p.sequence == wanted) else {
        if let Some((sequence, run, reason)) = explained.failed.iter().find(|f| f.0 == wanted) {
            let message = format!("{sequence}: {method} on {tracker}, run {run}, has no result: {reason}");
            return Err(LookupError::unknown(message));
        }
        let known = explained.parts.iter().map(|p| &p.sequence);
        return Err(unknown(&format!("{method} on {tracker}"), "sequence", wanted, known));
    };
    if !has_frames(results, of) {
        let why = match is_kept(of) {
            true => "rows marked (kept) have no single frames; explain them in the results they are from",
            false => "these results are compact and have no single frames; run it again without --compact",
        };
        return Err(LookupError::unknown(format!("{experiment}: {why}")));
    }
    let broken = |e: &dyn Display| LookupError { is_unknown: false, message: format!("{experiment}: {e}") };
    let traces = trace::read(results, tracker, &of.label(), Some(wanted)).map_err(|e| broken(&e))?;
    if let Some(protocol) = explained.protocol {
        let counted = traces.iter().map(|t| t.judge(protocol).counts).sum();
        compare(wanted, counted, part.counts).map_err(|e| broken(&e))?;
    }
    Ok(traces)
}

fn compare(sequence: &str, counted: Counts, stored: Counts) -> Result<(), String> {
    if counted == stored {
        return Ok(());
    }
    let [counted, stored] = [counted, stored].map(in_words);
    Err(format!("{sequence}: {FRAMES} gives {counted}; scores.csv has {stored}; run it again"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn counts_that_differ_are_told_in_words() {
        let stored = Counts { tp: 7, fp: 18, fn_: 2, tn: 173 };
        let told = "frames.parquet gives TP 0, FP 0, FN 0, TN 0; scores.csv has TP 7, FP 18, FN 2, TN 173";
        let told = Err(format!("Girl: {told}; run it again"));
        assert_eq!(compare("Girl", Counts::default(), stored), told);
        assert_eq!(compare("Girl", stored, stored), Ok(()));
    }
}
