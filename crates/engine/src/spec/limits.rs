//! How large an experiment may be: far above any that a person writes, and small enough that a hostile
//! file is refused within a moment and a run of an accepted one can be planned in memory.

use super::error::{Source, SpecError};
use super::method::Method;
use super::wire;
use crate::dataset::text;
use std::ops::Range;
use std::path::Path;

/// Longest experiment file that is read, in bytes.
pub const LONGEST: usize = 4 << 20;
/// Most trackers, and most methods.
const MOST_PLUGINS: usize = 256;
/// Most tables, and most figures.
const MOST_OBJECTS: usize = 256;
/// Most rows of published numbers.
const MOST_PUBLISHED: usize = 4096;
/// Most conclusions.
const MOST_CLAIMS: usize = 1024;
/// Most roles of suites.
const MOST_ROLES: usize = 16;
/// Most rows of a table, sequences of a figure and panels of a figure.
const MOST_PARTS: usize = 64;
/// Most detectors of an experiment, those counted that are tried in training.
pub const MOST_DETECTORS: usize = 20_000;
/// Most cells a sequence: trackers, their repetitions, methods and their grids multiplied.
const MOST_CELLS: usize = 1_000_000;

/// The text of an experiment file; of a file above [`LONGEST`], no more than that is read.
///
/// # Errors
/// A file that cannot be read, is too long or no UTF-8 text.
pub fn read_text(path: &Path) -> Result<String, SpecError> {
    let whole = |message: String| SpecError { file: path.display().to_string(), line: 1, message };
    let bytes = text::read_at_most(path, LONGEST as u64).map_err(|e| match e {
        crate::dataset::DatasetError::Io { source, .. } => whole(source.to_string()),
        _ => whole(format!("an experiment file has at most {LONGEST} bytes")),
    })?;
    String::from_utf8(bytes).map_err(|e| {
        let good = e.as_bytes().iter().take(e.utf8_error().valid_up_to());
        let line = 1 + good.filter(|b| **b == b'\n').count();
        SpecError { line, ..whole("bytes that are not UTF-8 text".into()) }
    })
}

/// Refuses lists that are too long, before anything is built from them.
pub(super) fn check_lists(source: Source<'_>, wire: &wire::Experiment) -> Result<(), SpecError> {
    let check = |what: &str, count: usize, most: usize, span: Range<usize>| {
        if count <= most {
            return Ok(());
        }
        Err(source.error(span, format!("{count} {what}; an experiment has at most {most}")))
    };
    let first = |list: &[toml::Spanned<String>]| list.first().map_or(0..0, toml::Spanned::span);
    check("suites", wire.suites.get_ref().len(), MOST_ROLES, wire.suites.span())?;
    check("trackers", wire.tracker.get_ref().len(), MOST_PLUGINS, wire.tracker.span())?;
    check("methods", wire.method.get_ref().len(), MOST_PLUGINS, wire.method.span())?;
    for a in &wire.analysis {
        check("analyses", wire.analysis.len(), MOST_PLUGINS, a.name.span())?;
        check("suites of an analysis", a.suites.get_ref().len(), MOST_ROLES, a.suites.span())?;
    }
    for t in &wire.table {
        check("tables", wire.table.len(), MOST_OBJECTS, t.name.span())?;
        if let Some(rows) = &t.rows {
            check("rows of a table", rows.get_ref().len(), MOST_PARTS, rows.span())?;
        }
        let methods = t.methods.as_deref().unwrap_or_default();
        check("methods of a table", methods.len(), MOST_PLUGINS, first(methods))?;
    }
    for f in &wire.figure {
        check("figures", wire.figure.len(), MOST_OBJECTS, f.name.span())?;
        let panels = f.panels.iter().map(|row| row.len().max(1)).sum();
        check("panels of a figure", panels, MOST_PARTS, f.name.span())?;
        check("sequences of a figure", f.sequences.len(), MOST_PARTS, first(&f.sequences))?;
        let methods = f.methods.as_deref().unwrap_or_default();
        check("methods of a figure", methods.len(), MOST_PLUGINS, first(methods))?;
    }
    for p in &wire.published {
        check("rows of published numbers", wire.published.len(), MOST_PUBLISHED, p.row.span())?;
        check("published numbers of a row", p.values.len(), MOST_DETECTORS, p.row.span())?;
    }
    match wire.claim.first() {
        Some(c) => check("claims", wire.claim.len(), MOST_CLAIMS, c.holds.span()),
        None => Ok(()),
    }
}

/// Refuses more work than can be planned; `runs` counts every tracker with its repetitions.
pub(super) fn check_work(
    source: Source<'_>,
    span: Range<usize>,
    runs: u64,
    methods: &[Method],
) -> Result<(), SpecError> {
    let variants: usize = methods.iter().map(|m| m.variants.len()).sum();
    let cells = runs.saturating_mul(variants as u64);
    if cells <= MOST_CELLS as u64 {
        return Ok(());
    }
    let message = format!(
        "{runs} runs of trackers with {variants} methods make {cells} cells a sequence; at most {MOST_CELLS} \
         are planned"
    );
    Err(source.error(span, message))
}

#[cfg(test)]
mod tests;
