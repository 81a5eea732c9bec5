//! The command line: one file for each verb, with its arguments and its calls of the layers below.
//!
//! [`Exit`] lists the exit codes.

pub mod compare;
pub mod completions;
pub mod data;
pub mod detect;
pub mod explain;
mod export;
pub mod list;
mod live;
pub mod merge;
pub mod monitor;
pub mod new;
pub mod output;
pub mod pack;
pub mod report;
pub mod run;
pub mod schema;
pub mod serve_trax;
pub mod slurm;

use crate::dataset::suite::Catalog;
use crate::engine::limits::Interrupted;
use crate::plugin;
use crate::spec::programs;
use crate::tracker::process::Programs;
use clap::error::{ContextKind, ContextValue};
use clap::{CommandFactory, Parser, Subcommand};
use std::fmt::Display;
use std::path::{Path, PathBuf};

/// Tells when a visual tracker has lost its target: a benchmark of failure detectors.
#[derive(Debug, Parser)]
#[command(
    version,
    about,
    after_help = "Exit codes: 0 success, 1 a bug or an I/O error, 2 wrong arguments or experiment file, \
3 data missing or not as pinned in datasets.lock, or results not as their manifest says (`data verify`), \
4 some cells failed, 5 a required claim does not hold, 6 the target is lost (`detect --fail-on-loss`), \
130 interrupted (finished work is kept)."
)]
pub struct Cli {
    #[command(subcommand)]
    verb: Verb,
}

#[derive(Debug, Subcommand)]
enum Verb {
    /// Run experiments, print the answer and its table, write results and report (without SPEC: the quickstart)
    Run(run::Args),
    /// Render tables, figures and HTML pages again, from kept results alone
    Report(report::Args),
    /// List experiments, suites, trackers, signals, detectors, methods, analyses or protocols
    List(list::Args),
    /// List, verify, download, render, add and pin the sequences of suites; verify results that somebody sent
    Data(data::Args),
    /// Tell, frame by frame, whether your own tracker has lost its target
    Detect(detect::Args),
    /// Tell live whether a tracker has lost its target: a JSON line in and a JSON line out for each frame
    Monitor(monitor::Args),
    /// Write a batch script that runs experiments on a SLURM cluster, or submit it
    Slurm(slurm::Args),
    /// Write the results of an experiment as one file to be sent, which `data verify` checks and unpacks
    Pack(pack::Args),
    /// Merge the stores of several `run --shard` into one
    Merge(merge::Args),
    /// Compare two trackers, methods or results folders on the same sequences, with confidence intervals
    Compare(compare::Args),
    /// Run a built-in tracker for a program that speaks the TraX protocol
    ServeTrax(serve_trax::Args),
    /// Trace a number of a table down to its sequences, events, detections and frames
    Explain(explain::Args),
    /// Write a commented minimal experiment that runs
    New(new::Args),
    /// Print the JSON Schema of experiment files
    Schema,
    /// Print a script that lets a shell complete this program's words
    Completions(completions::Args),
}

impl Cli {
    /// Runs the verb.
    ///
    /// # Errors
    /// The errors of the verb.
    pub fn run(&self) -> Result<(), Failure> {
        match &self.verb {
            Verb::Run(args) => run::run(args),
            Verb::Report(args) => report::run(args),
            Verb::List(args) => list::run(args),
            Verb::Data(args) => data::run(args),
            Verb::Detect(args) => detect::run(args),
            Verb::Monitor(args) => monitor::run(args),
            Verb::Slurm(args) => slurm::run(args),
            Verb::Pack(args) => pack::run(args),
            Verb::Merge(args) => merge::run(args),
            Verb::Compare(args) => compare::run(args),
            Verb::ServeTrax(args) => serve_trax::run(args),
            Verb::Explain(args) => explain::run(args),
            Verb::New(args) => new::run(args),
            Verb::Schema => schema::run(),
            Verb::Completions(args) => completions::run(args),
        }
    }
}

/// Adds the nearest verb to the error of an unknown verb. Two swapped letters count as near, too.
pub fn with_nearest_verb(mut error: clap::Error) -> clap::Error {
    let word = match error.get(ContextKind::InvalidSubcommand) {
        Some(ContextValue::String(word)) => word.clone(),
        _ => return error,
    };
    let (cli, first) = (Cli::command(), std::env::args_os().nth(1).unwrap_or_default());
    let verbs = cli.find_subcommand(&first).unwrap_or(&cli).get_subcommands();
    let near = plugin::nearest(&word, verbs.map(clap::Command::get_name)).map(str::to_string);
    if let Some(near) = near.filter(|_| error.get(ContextKind::SuggestedSubcommand).is_none()) {
        error.insert(ContextKind::SuggestedSubcommand, ContextValue::Strings(vec![near]));
    }
    error
}

/// A method for boxes and frames, by the time that it takes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
enum Tier {
    /// One small deep tracker beside yours, nothing learned: `Agreement`
    Light,
    /// With a second look at your box: `Fused deep`
    Default,
    /// With a second deep tracker: `Fused deep full`
    Full,
    /// For boxes of NanoTrack v2, as OpenCV's TrackerNano gives them: `Fused deep v3`
    Nanotrack,
}

impl Tier {
    /// Name of the method that the tier stands for.
    fn method(self) -> &'static str {
        match self {
            Self::Light => "Agreement",
            Self::Default => "Fused deep",
            Self::Full => "Fused deep full",
            Self::Nanotrack => "Fused deep v3",
        }
    }
}

/// Parses a budget of false alarms.
fn budget(text: &str) -> Result<f64, String> {
    let number = text.parse().ok().filter(|n: &f64| n.is_finite() && *n > 0.0);
    number.ok_or_else(|| "it is a number above 0: false alarms per 1000 frames".to_string())
}

/// Runs `work` in a pool of `jobs` worker threads, by default one for each core.
///
/// # Errors
/// [`Exit::Io`] if the threads cannot be started.
fn with_threads<T: Send>(jobs: Option<u16>, work: impl FnOnce() -> T + Send) -> Result<T, Failure> {
    let threads = rayon::ThreadPoolBuilder::new().num_threads(jobs.map_or(0, usize::from)).build();
    let threads = threads.map_err(|e| Failure::io(format!("cannot start worker threads: {e}")))?;
    Ok(threads.install(work))
}

/// Arguments that name the folders of data.
#[derive(Debug, Clone, Default, clap::Args)]
struct DataRoots {
    /// Folder of real sequences and result files (`otb/David`, `results/Struck` ...); may be given more than once, and
    /// the first folder that has a file wins; TRACKFAIL_DATA otherwise, a list of folders as in PATH
    #[arg(long = "data-root", global = true, value_name = "DIR")]
    given: Vec<PathBuf>,
}

impl DataRoots {
    /// Folders of data: those of `--data-root`, else those of TRACKFAIL_DATA.
    ///
    /// # Errors
    /// [`Exit::Data`] if one of them is not a folder.
    fn folders(&self) -> Result<Vec<PathBuf>, Failure> {
        let named = std::env::var_os("TRACKFAIL_DATA").unwrap_or_default();
        let named = std::env::split_paths(&named).filter(|root| !root.as_os_str().is_empty());
        let roots = if self.given.is_empty() { named.collect() } else { self.given.clone() };
        match roots.iter().find(|root| !root.is_dir()) {
            Some(root) => Err(Failure::data(format!("{}: the data root is no folder", root.display()))),
            None => Ok(roots),
        }
    }

    /// The same folders as explicit arguments, so that the environment is not needed later.
    fn resolved(&self) -> Result<Self, Failure> {
        Ok(Self { given: self.folders()? })
    }
}

/// Catalog of the built-in suites and of the user suites in the data roots.
///
/// # Errors
/// [`Exit::Data`] if the datasets.lock of a data root cannot be read or is wrong, or if two of them define a
/// suite differently.
fn catalog(data_roots: &[PathBuf]) -> Result<Catalog, Failure> {
    let mut catalog = Catalog::default();
    data_roots.iter().try_for_each(|root| catalog.add_root(root)).map_err(Failure::data)?;
    Ok(catalog)
}

/// Path of the file of programs: `--plugins`, else TRACKFAIL_PLUGINS unless it is empty, else `plugins.toml` in the
/// current folder if there is one.
fn plugins_file(given: Option<&Path>) -> Option<PathBuf> {
    let named = std::env::var_os("TRACKFAIL_PLUGINS").filter(|name| !name.is_empty()).map(PathBuf::from);
    let here = || Some(PathBuf::from("plugins.toml")).filter(|path| path.is_file());
    given.map(Path::to_path_buf).or(named).or_else(here)
}

/// Reads the programs of [`plugins_file`]; no programs without such a file.
///
/// # Errors
/// [`Exit::Usage`] if the file cannot be read or is wrong.
fn programs(given: Option<&Path>) -> Result<Programs, Failure> {
    let read = |path: PathBuf| programs::read(&path).map_err(Failure::usage);
    plugins_file(given).map_or_else(|| Ok(Programs::default()), read)
}

/// Error of a layer below, or a message.
pub type Cause = Box<dyn std::error::Error + Send + Sync>;

/// Exit codes of a verb that ends without success.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
#[repr(u8)]
pub enum Exit {
    /// A bug or an I/O error.
    Io = 1,
    /// Wrong arguments, or a wrong experiment file.
    Usage = 2,
    /// Data are missing or not as pinned.
    Data = 3,
    /// Some cells failed; all others were computed.
    Cells = 4,
    /// A required claim does not hold.
    Expectation = 5,
    /// A method detects a loss, and the user requested a failure in that case.
    Loss = 6,
    /// Interrupted by Ctrl-C or the end of a batch job; finished work is kept.
    Interrupted = 130,
}

/// Error of a verb, with the exit code of the process.
#[derive(Debug, thiserror::Error)]
#[error("{cause}")]
pub struct Failure {
    /// Exit code of the process.
    pub exit: Exit,
    cause: Cause,
}

impl Failure {
    /// Failure with an exit code; the cause is an error or a message.
    pub fn new(exit: Exit, cause: impl Into<Cause>) -> Self {
        Self { exit, cause: cause.into() }
    }

    /// Failure with [`Exit::Io`]; the cause is an error or a message.
    pub fn io(cause: impl Into<Cause>) -> Self {
        Self::new(Exit::Io, cause)
    }

    /// Failure with [`Exit::Usage`]; the cause is an error or a message.
    pub fn usage(cause: impl Into<Cause>) -> Self {
        Self::new(Exit::Usage, cause)
    }

    /// Failure with [`Exit::Data`]; the cause is an error or a message.
    pub fn data(cause: impl Into<Cause>) -> Self {
        Self::new(Exit::Data, cause)
    }

    /// Failure with [`Exit::Interrupted`].
    pub fn interrupted() -> Self {
        Self::new(Exit::Interrupted, Interrupted)
    }

    /// Exit code as a number.
    pub fn code(&self) -> u8 {
        self.exit as u8
    }

    /// Prints the failure on stderr and returns the exit code.
    pub fn tell(&self) -> u8 {
        output::note(&format!("error: {self}"));
        self.code()
    }
}

/// Converts an error of the file system at a path to a failure with [`Exit::Io`].
fn io_at<E: Display>(path: &Path) -> impl FnOnce(E) -> Failure {
    move |e| Failure::io(format!("{}: {e}", path.display()))
}
