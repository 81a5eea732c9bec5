//! Experiments in a results folder whose run is finished.

use crate::results::manifest::FILE as MANIFEST;
use crate::results::{Results, ResultsError};
use std::path::{Path, PathBuf};
use trackfail_core::plugin;
use trackfail_engine::spec::check_experiment_name;

/// Reason why results of an experiment cannot be read.
#[derive(Debug, thiserror::Error)]
pub enum FinishedError {
    /// The folder has no finished experiment at all.
    #[error(
        "no finished experiment in {}: nothing has been run there yet (run `trackfail run` first, or name the folder \
         with --results)",
        results.display()
    )]
    NothingRun {
        /// Path of the results folder.
        results: PathBuf,
    },
    /// The folder has only other experiments.
    #[error("{}: {message}", results.display())]
    Unknown {
        /// Path of the results folder.
        results: PathBuf,
        /// The nearest known name, or all of them.
        message: String,
    },
    /// The results cannot be read.
    #[error("{name}: {source}")]
    Results {
        /// Name of the experiment.
        name: String,
        /// First error while reading the results.
        source: ResultsError,
    },
}

/// Names of the finished experiments below a results folder, sorted.
pub fn names(results: &Path) -> Vec<String> {
    // The store and results that are not complete yet are hidden.
    let is_shown =
        |e: &walkdir::DirEntry| e.depth() == 0 || !e.file_name().as_encoded_bytes().starts_with(b".");
    let entries = walkdir::WalkDir::new(results).sort_by_file_name().into_iter().filter_entry(is_shown);
    let name = |entry: walkdir::DirEntry| {
        let folder = entry.path().parent()?.strip_prefix(results).ok()?;
        Some(folder.to_str()?.replace('\\', "/")).filter(|name| check_experiment_name(name).is_ok())
    };
    entries.filter_map(Result::ok).filter(|entry| entry.file_name() == MANIFEST).filter_map(name).collect()
}

/// Folder of a finished experiment.
///
/// # Errors
/// When there is no such experiment.
pub fn folder(results: &Path, name: &str) -> Result<PathBuf, FinishedError> {
    let known = names(results);
    if known.is_empty() {
        return Err(FinishedError::NothingRun { results: results.to_path_buf() });
    }
    if known.iter().any(|k| k == name) {
        return Ok(results.join(name));
    }
    let message = plugin::unknown("finished experiment", name, known.iter().map(String::as_str));
    Err(FinishedError::Unknown { results: results.to_path_buf(), message })
}

/// Reads the results of a finished experiment.
///
/// # Errors
/// When there is no such experiment, or its results cannot be read.
pub fn read(results: &Path, name: &str) -> Result<Results, FinishedError> {
    Results::read(&folder(results, name)?)
        .map_err(|source| FinishedError::Results { name: name.to_string(), source })
}
