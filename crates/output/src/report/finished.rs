//! Experiments in a results folder whose run is finished.

use crate::results::manifest::FILE as MANIFEST;
use crate::results::{Results, ResultsError};
use std::path::{Path, PathBuf};
use trackfail_core::plugin;
use trackfail_engine::spec::check_experiment_name;

/// Reason why something that a user asks for in a results folder cannot be given.
#[derive(Debug, thiserror::Error)]
#[error("{message}")]
pub struct LookupError {
    /// True if there is nothing of that name, or nothing was run; false if the results cannot be read.
    pub is_unknown: bool,
    pub(super) message: String,
}

impl LookupError {
    /// Error for what is not there.
    pub fn unknown(message: String) -> Self {
        Self { is_unknown: true, message }
    }

    /// Error for a results folder that has no finished experiment at all.
    pub fn nothing_run(results: &Path) -> Self {
        let what_to_do = "run `trackfail run` first, or name the folder with --results";
        let folder = results.display();
        Self::unknown(format!(
            "no finished experiment in {folder}: nothing has been run there yet ({what_to_do})"
        ))
    }
}

impl From<ResultsError> for LookupError {
    fn from(e: ResultsError) -> Self {
        Self { is_unknown: matches!(e, ResultsError::Unfinished(_)), message: e.to_string() }
    }
}

/// Names of the finished experiments below a results folder, sorted.
pub fn names(results: &Path) -> Vec<String> {
    named(results, MANIFEST)
}

/// Folders below another one that have a file of this name and are named as experiments are, sorted. Links to
/// folders are not followed.
pub(super) fn named(root: &Path, file: &str) -> Vec<String> {
    // The store, and results and reports that are not complete yet, are hidden.
    let is_shown =
        |e: &walkdir::DirEntry| e.depth() == 0 || !e.file_name().as_encoded_bytes().starts_with(b".");
    let entries = walkdir::WalkDir::new(root).sort_by_file_name().into_iter().filter_entry(is_shown);
    let name = |entry: walkdir::DirEntry| {
        let folder = entry.path().parent()?.strip_prefix(root).ok()?;
        Some(folder.to_str()?.replace('\\', "/")).filter(|name| check_experiment_name(name).is_ok())
    };
    // A folder that disappears during the walk is skipped.
    entries.filter_map(Result::ok).filter(|entry| entry.file_name() == file).filter_map(name).collect()
}

/// Folder of a finished experiment.
///
/// # Errors
/// When there is no such experiment.
pub fn folder(results: &Path, name: &str) -> Result<PathBuf, LookupError> {
    let known = names(results);
    if known.is_empty() {
        return Err(LookupError::nothing_run(results));
    }
    if known.iter().any(|k| k == name) {
        return Ok(results.join(name));
    }
    let message = plugin::unknown("finished experiment", name, known.iter().map(String::as_str));
    Err(LookupError::unknown(format!("{}: {message}", results.display())))
}

/// Reads the results of a finished experiment.
///
/// # Errors
/// When there is no such experiment, or its results cannot be read.
pub fn read(results: &Path, name: &str) -> Result<Results, LookupError> {
    let named = |e: ResultsError| LookupError { message: format!("{name}: {e}"), ..e.into() };
    Results::read(&folder(results, name)?).map_err(named)
}
