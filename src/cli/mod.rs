//! The command line: one file per verb, arguments and calls only.
//!
//! Exit codes: 0 done; 1 a bug or an I/O error; 2 usage or experiment file; 3 data absent or not what
//! was pinned; 4 some cells failed; 5 an expectation is not met; 130 interrupted, with what was done kept.

pub mod compare;
pub mod data;
pub mod detect;
pub mod explain;
mod export;
pub mod fetch;
pub mod list;
mod live;
pub mod merge;
pub mod output;
pub mod render;
pub mod report;
pub mod run;
pub mod serve;
pub mod serve_trax;
pub mod slurm;
pub mod why;

use crate::dataset::suite::Catalog;
use crate::spec::programs;
use crate::tracker::process::Programs;
use clap::{Parser, Subcommand};
use std::path::{Path, PathBuf};

/// Tells when a visual tracker has lost its target: a benchmark of failure detectors.
#[derive(Debug, Parser)]
#[command(
    version,
    about,
    after_help = "Exit codes: 0 done, 1 a bug or an I/O error, 2 usage or experiment \
file, 3 data absent or not what was pinned, 4 some cells failed, 5 an expectation is not met, 130 interrupted \
(what was done is kept)."
)]
pub struct Cli {
    #[command(subcommand)]
    verb: Verb,
}

#[derive(Debug, Subcommand)]
enum Verb {
    /// Run experiments, print their tables, write results and report (without SPEC: the quickstart)
    Run(run::Args),
    /// Render tables, figures and HTML from results alone
    Report(report::Args),
    /// Show what there is: experiments, suites, trackers, signals, detectors, protocols
    List(list::Args),
    /// Look after datasets: what is here, and is it what was pinned
    Data(data::Args),
    /// Tell, frame by frame, whether your own tracker has failed
    Detect(detect::Args),
    /// Write a synthetic suite to disk in OTB or VOT layout
    Render(render::Args),
    /// Write, or submit, batch scripts that run experiments on a SLURM cluster
    Slurm(slurm::Args),
    /// Join the stores of runs with --shard into one
    Merge(merge::Args),
    /// Compare two trackers, methods or results folders, pair by pair, with intervals
    Compare(compare::Args),
    /// Show reports, and what runs are at, in a browser on this machine
    Serve(serve::Args),
    /// Let programs that speak TraX use a built-in tracker
    ServeTrax(serve_trax::Args),
    /// Tell why cells would or would not be computed again
    Why(why::Args),
    /// From a number of a table down to its sequences, events, detections and frames
    Explain(explain::Args),
}

impl Cli {
    /// Runs the verb.
    ///
    /// # Errors
    /// What the verb ends with.
    pub fn run(&self) -> Result<(), Failure> {
        match &self.verb {
            Verb::Run(args) => run::run(args),
            Verb::Report(args) => report::run(args),
            Verb::List(args) => list::run(args),
            Verb::Data(args) => data::run(args),
            Verb::Detect(args) => detect::run(args),
            Verb::Render(args) => render::run(args),
            Verb::Slurm(args) => slurm::run(args),
            Verb::Merge(args) => merge::run(args),
            Verb::Compare(args) => compare::run(args),
            Verb::Serve(args) => serve::run(args),
            Verb::ServeTrax(args) => serve_trax::run(args),
            Verb::Why(args) => why::run(args),
            Verb::Explain(args) => explain::run(args),
        }
    }
}

/// Does something on so many threads, or on one for each core.
///
/// # Errors
/// [`Failure::Io`] when they cannot be started.
fn with_threads<T: Send>(jobs: Option<u16>, work: impl FnOnce() -> T + Send) -> Result<T, Failure> {
    let threads = rayon::ThreadPoolBuilder::new().num_threads(jobs.map_or(0, usize::from)).build();
    let threads = threads.map_err(|e| Failure::Io(format!("cannot start worker threads: {e}")))?;
    Ok(threads.install(work))
}

/// The data root: what was given, else TRACKFAIL_DATA unless it is empty.
///
/// # Errors
/// [`Failure::Data`] when it is no folder.
fn data_root(given: Option<&Path>) -> Result<Option<PathBuf>, Failure> {
    let named = std::env::var_os("TRACKFAIL_DATA").filter(|name| !name.is_empty()).map(PathBuf::from);
    let root = given.map(Path::to_path_buf).or(named);
    if let Some(root) = root.as_ref().filter(|r| !r.is_dir()) {
        return Err(Failure::Data(format!("{}: the data root is no folder", root.display())));
    }
    Ok(root)
}

/// The built-in suites and the user suites of a data root.
///
/// # Errors
/// [`Failure::Data`] when the data root's own datasets.lock cannot be read or is wrong.
fn catalog(data_root: Option<&Path>) -> Result<Catalog, Failure> {
    let mut catalog = Catalog::default();
    if let Some(root) = data_root {
        catalog.add_root(root).map_err(|e| Failure::Data(e.to_string()))?;
    }
    Ok(catalog)
}

/// The file of programs: what was given, else TRACKFAIL_PLUGINS unless it is empty, else `plugins.toml` in
/// the current folder if it is there.
fn plugins_file(given: Option<&Path>) -> Option<PathBuf> {
    let named = std::env::var_os("TRACKFAIL_PLUGINS").filter(|name| !name.is_empty()).map(PathBuf::from);
    let here = || Some(PathBuf::from("plugins.toml")).filter(|path| path.is_file());
    given.map(Path::to_path_buf).or(named).or_else(here)
}

/// The programs of [`plugins_file`].
///
/// # Errors
/// [`Failure::Usage`] when it cannot be read or is wrong.
fn programs(given: Option<&Path>) -> Result<Programs, Failure> {
    let read = |path: PathBuf| programs::read(&path).map_err(|e| Failure::Usage(e.to_string()));
    plugins_file(given).map_or_else(|| Ok(Programs::default()), read)
}

/// Why a verb ends without success; the exit code is the kind's.
#[derive(Debug, thiserror::Error)]
pub enum Failure {
    /// A bug or an I/O error.
    #[error("{0}")]
    Io(String),
    /// Wrong arguments or a wrong experiment file.
    #[error("{0}")]
    Usage(String),
    /// Data that is absent or not what was pinned.
    #[error("{0}")]
    Data(String),
    /// Some cells failed; the rest is done.
    #[error("{0}")]
    Cells(String),
    /// A result is not the expected one.
    #[error("{0}")]
    Expectation(String),
    /// Ctrl-C, or the end of a batch job.
    #[error("{0}")]
    Interrupted(String),
}

impl Failure {
    /// The process's exit code.
    pub fn code(&self) -> u8 {
        match self {
            Self::Io(_) => 1,
            Self::Usage(_) => 2,
            Self::Data(_) => 3,
            Self::Cells(_) => 4,
            Self::Expectation(_) => 5,
            Self::Interrupted(_) => 130,
        }
    }
}
