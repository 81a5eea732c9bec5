//! Upper limits of an experiment file: far above what a person writes, small enough that a hostile file is refused
//! at once and every accepted one can be planned in memory.

use super::error::{Source, SpecError};
use super::wire;
use std::ops::Range;
use std::path::Path;
use trackfail_dataset::text;

/// Largest experiment file, in bytes.
pub const MAX_BYTES: usize = 4 << 20;
/// Largest number of trackers, of methods and of analyses.
const MAX_PLUGINS: usize = 256;
/// Largest number of tables and of figures.
const MAX_OBJECTS: usize = 256;
/// Largest number of rows of published numbers.
const MAX_PUBLISHED: usize = 4096;
/// Largest number of claims.
const MAX_CLAIMS: usize = 1024;
/// Largest number of suites.
const MAX_ROLES: usize = 16;
/// Largest number of rows of a table, and of sequences and panels of a figure.
const MAX_PARTS: usize = 64;
/// Largest number of detectors of an experiment, including the candidates of training.
pub const MAX_DETECTORS: usize = 20_000;
/// Largest number of cells per sequence: trackers, times repetitions, times methods with their grids.
pub(super) const MAX_CELLS: usize = 1_000_000;

/// Reads the text of an experiment file, at most [`MAX_BYTES`] of it.
///
/// # Errors
/// The file cannot be read, is larger, or is not UTF-8 text.
pub fn read_text(path: &Path) -> Result<String, SpecError> {
    let whole = |message: String| SpecError::of_file(path.display().to_string(), message);
    let bytes = text::read_at_most(path, MAX_BYTES as u64).map_err(|e| match e {
        trackfail_dataset::DatasetError::Io { source, .. } => whole(source.to_string()),
        _ => whole(format!("an experiment file has at most {MAX_BYTES} bytes")),
    })?;
    String::from_utf8(bytes).map_err(|e| {
        let good = e.as_bytes().iter().take(e.utf8_error().valid_up_to());
        let line = 1 + good.filter(|b| **b == b'\n').count();
        SpecError { line, ..whole("bytes that are not UTF-8 text".into()) }
    })
}

/// Refuses lists that are too long, before anything is built from them.
pub(super) fn check_lists(source: Source<'_>, wire: &wire::Experiment) -> Result<(), SpecError> {
    let check = |what: &str, count: usize, max: usize, span: Range<usize>| {
        if count <= max {
            return Ok(());
        }
        Err(source.error(span, format!("{count} {what}; an experiment has at most {max}")))
    };
    let first = |list: &[toml::Spanned<String>]| list.first().map_or(0..0, toml::Spanned::span);
    check("suites", wire.suites.get_ref().len(), MAX_ROLES, wire.suites.span())?;
    check("trackers", wire.tracker.get_ref().len(), MAX_PLUGINS, wire.tracker.span())?;
    check("methods", wire.method.get_ref().len(), MAX_PLUGINS, wire.method.span())?;
    for a in &wire.analysis {
        check("analyses", wire.analysis.len(), MAX_PLUGINS, a.name.span())?;
        check("suites of an analysis", a.suites.get_ref().len(), MAX_ROLES, a.suites.span())?;
    }
    for t in &wire.table {
        check("tables", wire.table.len(), MAX_OBJECTS, t.name.span())?;
        if let Some(rows) = &t.rows {
            check("rows of a table", rows.get_ref().len(), MAX_PARTS, rows.span())?;
        }
        let methods = t.methods.as_deref().unwrap_or_default();
        check("methods of a table", methods.len(), MAX_PLUGINS, first(methods))?;
    }
    for f in &wire.figure {
        check("figures", wire.figure.len(), MAX_OBJECTS, f.name.span())?;
        let panels = f.panels.iter().map(|row| row.len().max(1)).sum();
        check("panels of a figure", panels, MAX_PARTS, f.name.span())?;
        check("sequences of a figure", f.sequences.len(), MAX_PARTS, first(&f.sequences))?;
        let methods = f.methods.as_deref().unwrap_or_default();
        check("methods of a figure", methods.len(), MAX_PLUGINS, first(methods))?;
    }
    for p in &wire.published {
        check("rows of published numbers", wire.published.len(), MAX_PUBLISHED, p.row.span())?;
        check("published numbers of a row", p.values.len(), MAX_DETECTORS, p.row.span())?;
    }
    match wire.claim.first() {
        Some(c) => check("claims", wire.claim.len(), MAX_CLAIMS, c.holds.span()),
        None => Ok(()),
    }
}

#[cfg(test)]
mod tests;
