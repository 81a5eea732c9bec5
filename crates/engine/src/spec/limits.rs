//! Upper limits of an experiment file: far above what a person writes, but low enough that a hostile file is
//! refused at once and all accepted ones can be planned in memory.

use super::error::{At, SpecError};
use super::method::Method;
use std::path::Path;
use trackfail_dataset::text;

/// Largest experiment file, in bytes.
pub const MAX_BYTES: usize = 4 << 20;
/// Most trackers, most methods, most analyses, most tables and most figures. List lengths are in the schema,
/// so that too long lists are refused before anything is built.
pub(super) const MAX_ITEMS: usize = 256;
/// Most suites.
pub(super) const MAX_ROLES: usize = 16;
/// Most rows of a table, and most sequences and panels of a figure.
pub(super) const MAX_PARTS: usize = 64;
/// Most detectors of an experiment, including the candidates of training.
pub const MAX_DETECTORS: usize = 20_000;
/// Most cells per sequence: trackers, times repetitions, times methods with their grids.
const MAX_CELLS: u64 = 1_000_000;

/// Reads the text of an experiment file, at most [`MAX_BYTES`] of it.
///
/// # Errors
/// The file cannot be read, is too large, or is not UTF-8 text.
pub fn read_text(path: &Path) -> Result<String, SpecError> {
    read_at_most(path, MAX_BYTES, "an experiment file")
}

/// Reads a text of at most `most` bytes; `what` names the kind of file in messages.
pub(super) fn read_at_most(path: &Path, most: usize, what: &str) -> Result<String, SpecError> {
    let whole = |message: String| SpecError::of_file(path.display().to_string(), message);
    let bytes = text::read_at_most(path, most as u64).map_err(|e| match e {
        trackfail_dataset::DatasetError::Io { source, .. } => whole(source.to_string()),
        _ => whole(format!("{what} has at most {most} bytes")),
    })?;
    String::from_utf8(bytes).map_err(|e| {
        let line = text::line_of(e.as_bytes(), e.utf8_error().valid_up_to());
        SpecError { line, ..whole("bytes that are not UTF-8 text".into()) }
    })
}

/// Refuses more cells than can be planned; `runs` is the number of trackers times their repetitions.
pub(super) fn check_cells(at: At<'_>, runs: u64, methods: &[Method]) {
    let variants: usize = methods.iter().map(|m| m.variants.len()).sum();
    let cells = runs.saturating_mul(variants as u64);
    if cells > MAX_CELLS {
        at.tell(format!(
            "{runs} runs of trackers with {variants} methods make {cells} cells a sequence; at most {MAX_CELLS} \
             are planned"
        ));
    }
}

#[cfg(test)]
mod tests;
