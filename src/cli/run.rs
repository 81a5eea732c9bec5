//! `trackfail run [SPEC...]`: parses, loads, plans, runs, writes and reports experiments.

mod beside;
mod dry_run;
pub(super) mod print;

use super::output::{self, Format};
use super::{Cause, Exit, Failure, export};
use crate::dataset::suite::{Catalog, Loaded, Missing, NO_DATA_ROOT};
use crate::dataset::{Sequence, guarded};
use crate::engine::store::{self, Store};
use crate::engine::{self, ExperimentPlan, Options, Outcome, RunError, RunLimits, Shard, Stop};
use crate::plugin;
use crate::report::{StagedReport, WrittenReport, stills};
use crate::results::beside::Kept;
use crate::results::{self, Detail, Results, RunRecord, manifest};
use crate::spec::{self, Experiment, builtin};
use crate::tracker::process::Programs;
use crate::tracker::{RunContext, replay};
use indicatif::ProgressBar;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::{Duration, Instant};

/// Arguments of `run`.
#[derive(Debug, Clone, clap::Args)]
pub struct Args {
    /// Experiment files, or names of built-in experiments (see `trackfail list experiments`)
    #[arg(value_name = "SPEC")]
    specs: Vec<String>,
    #[command(flatten)]
    data_roots: super::DataRoots,
    /// File of programs that may be run as trackers, signals or detectors; TRACKFAIL_PLUGINS otherwise, else plugins.toml here
    #[arg(long, value_name = "FILE")]
    plugins: Option<PathBuf>,
    /// Folder that results are written to
    #[arg(long, value_name = "DIR", default_value = "results")]
    results: PathBuf,
    /// Folder that reports are written to
    #[arg(long, value_name = "DIR", default_value = "reports")]
    reports: PathBuf,
    /// Worker threads (default: one for each core)
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    jobs: Option<u16>,
    /// Run without missing sequences; tables say how many there were
    #[arg(long)]
    allow_missing: bool,
    /// Only tell what would be computed and how long it may take; with --shard also which shares are done
    #[arg(long)]
    dry_run: bool,
    /// With --dry-run: list every cell, whether it is cached, stale, missing or absent, and why
    #[arg(long, short, requires = "dry_run")]
    verbose: bool,
    /// Compute everything again, in place of what is in the store
    #[arg(long)]
    force: bool,
    /// Compute share I of N into the store, without tables (see `trackfail merge`)
    #[arg(long, value_name = "I/N")]
    shard: Option<Shard>,
    /// Upper limit of repetitions of every tracker, also on training suites; tables say so
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    runs: Option<u32>,
    /// Also write every track as a result file: VOT's format for reset protocols, OTB's for one pass
    #[arg(long, value_name = "DIR", conflicts_with = "shard")]
    export_tracks: Option<PathBuf>,
    /// Time limit of a cell in seconds, looked at between its frames; a cell that takes longer has failed
    #[arg(long, value_name = "SECONDS", default_value_t = 3600.0, value_parser = positive)]
    timeout: f64,
    /// Largest size of the store in GiB; beyond it, what was used longest ago is removed
    #[arg(long, value_name = "GIB", default_value_t = 20.0, value_parser = positive)]
    store_limit: f64,
    /// Leave out what is known of single frames, learned models, and rows of missing sequences, so that results are small
    /// enough to be kept; their report has no frames
    #[arg(long)]
    compact: bool,
    /// Print neither the answer nor progress
    #[arg(long, short)]
    quiet: bool,
    /// Print the answer and the table behind it, or all pooled numbers as CSV or JSON
    #[arg(long, value_enum, default_value_t)]
    format: Format,
}

impl Args {
    /// Largest size of the store, in bytes.
    fn store_limit(&self) -> u64 {
        (self.store_limit * (1_u64 << 30) as f64) as u64
    }
}

/// Parses a positive number of at most a hundred million.
fn positive(text: &str) -> Result<f64, String> {
    let number = text.parse().ok().filter(|n: &f64| *n > 0.0 && *n <= 1e8);
    number.ok_or_else(|| format!("`{text}` is no number above 0 and up to 100000000"))
}

/// Reads an experiment from a file, or a built-in one by name. It may run `programs`.
///
/// # Errors
/// `Usage` if there is no such file or experiment, or if it is wrong.
pub fn read_spec(name: &str, catalog: &Catalog, programs: &Programs) -> Result<Experiment, Failure> {
    let path = Path::new(name);
    let built_in = builtin::EXPERIMENTS.iter().find(|(known, _)| *known == name);
    match built_in {
        _ if path.is_file() => spec::read_file(path, catalog, Some(programs)).map_err(Failure::usage),
        Some((_, text)) => spec::parse_with(name, text, catalog, Some(programs)).map_err(Failure::usage),
        None if path.is_dir() => Err(Failure::usage(format!(
            "{name}: a folder; name an experiment file in it, such as {name}/NAME.toml"
        ))),
        None => {
            let known = builtin::EXPERIMENTS.iter().map(|(known, _)| *known);
            let unknown = plugin::unknown("built-in experiment", name, known);
            Err(Failure::usage(format!("{name}: no such file, and {unknown}")))
        }
    }
}

/// Reads several experiments as [`read_spec`] does.
///
/// # Errors
/// `Usage` with the errors of all wrong experiments.
pub fn read_specs(
    names: &[String],
    catalog: &Catalog,
    programs: &Programs,
) -> Result<Vec<Experiment>, Failure> {
    let (mut experiments, mut wrong) = (Vec::new(), Vec::new());
    for name in names {
        match read_spec(name, catalog, programs) {
            Ok(experiment) => experiments.push(experiment),
            Err(failure) => wrong.push(failure.to_string()),
        }
    }
    if wrong.is_empty() { Ok(experiments) } else { Err(Failure::usage(wrong.join("\n"))) }
}

/// Runs the verb: all experiments, one after the other. After missing data or failed cells the next
/// experiment runs all the same; the exit code is then the lowest of all failures.
///
/// # Errors
/// See [`Failure`].
pub fn run(args: &Args) -> Result<(), Failure> {
    let args = &Args { data_roots: args.data_roots.resolved()?, ..args.clone() };
    let experiments = parse(args)?;
    if let Some(folder) = &args.export_tracks {
        output::replace::check_outputs(&[("--export-tracks", folder.clone())])?;
        experiments
            .iter()
            .try_for_each(|experiment| export::check(folder, experiment, &args.data_roots.given))?;
    }
    let limits = RunLimits { timeout: Some(Duration::from_secs_f64(args.timeout)), stop: stop_on_signals() };
    let mut failures = Vec::new();
    for experiment in &experiments {
        match super::with_threads(args.jobs, || run_one(args, experiment, &limits))? {
            Err(e) if !matches!(e.exit, Exit::Data | Exit::Cells | Exit::Expectation) => return Err(e),
            done => failures.extend(done.err()),
        }
    }
    failures.into_iter().min_by_key(Failure::code).map_or(Ok(()), Err)
}

/// Reads all experiments first, so that a wrong one is found before any runs.
fn parse(args: &Args) -> Result<Vec<Experiment>, Failure> {
    let programs = super::programs(args.plugins.as_deref())?;
    let catalog = super::catalog(&args.data_roots.given)?;
    let quickstart = [builtin::QUICKSTART.to_string()];
    let names = if args.specs.is_empty() { &quickstart } else { args.specs.as_slice() };
    let mut experiments = read_specs(names, &catalog, &programs)?;
    if let Some(runs) = args.runs {
        experiments.iter_mut().for_each(|e| e.limit_runs(runs));
    }
    Ok(experiments)
}

/// Creates a flag that Ctrl-C and the signals of batch systems set. A second signal ends the program at once.
pub(super) fn stop_on_signals() -> Stop {
    static STOP: std::sync::OnceLock<Stop> = std::sync::OnceLock::new();
    let stop = STOP.get_or_init(|| {
        let stop = Stop::default();
        let flag = stop.clone();
        let handler = move || {
            if flag.is_set() {
                std::process::exit(130);
            }
            flag.set();
            guarded::interrupt();
        };
        // Without a handler the signals end the program, which the store survives like any kill.
        let _ = ctrlc::set_handler(handler);
        stop
    });
    stop.clone()
}

/// Runs one experiment: load, plan, run, write, report.
fn run_one(args: &Args, experiment: &Experiment, limits: &RunLimits) -> Result<(), Failure> {
    let start = Instant::now();
    let kept = beside::kept(args, experiment)?;
    let mut suites = load(experiment, &args.data_roots.given, args.allow_missing)?;
    if let Some(kept) = &kept {
        beside::keep_common(kept, experiment, &mut suites)?;
    }
    let plan = ExperimentPlan::new(experiment, suites, &args.data_roots.given, &limits.stop)
        .map_err(|e| run_failure(experiment, e))?;
    if let Some(kept) = &kept {
        results::beside::check(experiment, None, &plan.digests(), &kept.results)?;
    }
    if args.runs.is_none() {
        tell_of_further_runs(&plan, &args.data_roots.given);
    }
    if args.dry_run {
        return dry_run::run(args, &plan);
    }
    let store = Store::open(&args.results).map_err(|e| run_failure(experiment, e.into()))?;
    let bar = match args.quiet {
        true => ProgressBar::hidden(),
        false => output::progress_bar(&experiment.name, "{pos}/{len} frames, {per_sec}, {eta} left"),
    };
    let shown = bar.clone();
    let draw = move |done: u64, total: u64| {
        shown.set_length(total);
        shown.set_position(done);
    };
    let data_roots = args.data_roots.given.clone();
    let options = Options { data_roots, force: args.force, limits: limits.clone(), progress: Arc::new(draw) };
    // Takes the bar off the terminal, too.
    let tell = || {
        bar.finish_and_clear();
        print::store_problems(&store);
    };
    if let Some(shard) = args.shard {
        let done = engine::run_shard(&plan, &store, &options, shard);
        tell();
        let done = done.map_err(|e| run_failure(experiment, e))?;
        store.evict(args.store_limit());
        return print::shard(args, experiment, shard, &done);
    }
    let outcome = engine::run(&plan, &store, &options);
    tell();
    let outcome = outcome.map_err(|e| run_failure(experiment, e))?;
    if limits.stop.is_set() {
        return Err(run_failure(experiment, RunError::Interrupted));
    }
    print::note(args, &format!("{}: {}", experiment.name, outcome.tally));
    if let Some(folder) = &args.export_tracks {
        export::write(folder, experiment, &outcome)?;
    }
    let (results, written, index) = write(args, (experiment, kept.as_ref()), &store, &outcome, start)
        .map_err(|e| Failure::io(format!("{}: {e}", experiment.name)))?;
    drop(outcome);
    print::store_problems(&store);
    store.evict(args.store_limit());
    if !args.quiet {
        match args.format {
            Format::Table => print::summary(&results, &written, &index)?,
            format => print::measures(&results, format)?,
        }
    }
    print::judge(args, &results, &written.findings)
}

/// Warns about result files of runs beyond the last one of the experiment, which are not read.
fn tell_of_further_runs(plan: &ExperimentPlan<'_>, data_roots: &[PathBuf]) {
    for tracker in plan.experiment.trackers.iter().filter(|tracker| tracker.kind == replay::ENTRY.kind) {
        let mut sequences = plan.test().sequences.iter().map(|planned| planned.sequence.as_ref());
        let has_more = |sequence: &&Sequence| {
            let context =
                RunContext { sequence: *sequence, start_frame: 0, run: tracker.runs, seed: 0, data_roots };
            tracker.setup.inputs(&context).is_ok()
        };
        if let Some(sequence) = sequences.find(has_more) {
            let (label, name, runs) = (&tracker.label, &sequence.name, tracker.runs);
            let told =
                format!("warning: {label}: {name} has a result of run {}, but `runs` is {runs}", runs + 1);
            output::note(&format!("{told}; what is beyond that is not read"));
        }
    }
}

/// Failure of an experiment whose run ended with an error.
fn run_failure(experiment: &Experiment, error: RunError) -> Failure {
    let exit = match error {
        RunError::Interrupted => Exit::Interrupted,
        RunError::Store(_) => Exit::Io,
    };
    Failure::new(exit, format!("{}: {error}", experiment.name))
}

/// Writes results and report aside, with the kept results beside them, and puts them in their place.
fn write(
    args: &Args,
    (experiment, kept): (&Experiment, Option<&Kept>),
    store: &Store,
    outcome: &Outcome<'_>,
    start: Instant,
) -> Result<(Results, WrittenReport, PathBuf), Cause> {
    let aside = store.staging()?;
    // This package's build script knows the revision; the crates below do not.
    let record = RunRecord::here(option_env!("TRACKFAIL_REVISION"), start.elapsed().as_secs_f64());
    let detail = if args.compact { Detail::Sequences } else { Detail::Frames };
    results::write(aside.path(), experiment, outcome, &record, detail)?;
    if let Some(kept) = kept {
        results::beside::keep(kept, aside.path())?;
    }
    let mut results = Results::read(aside.path())?;
    for request in stills::requests(&results)? {
        let Some(sequence) = outcome.sequences().find(|s| s.name == request.sequence) else { continue };
        for &t in &request.frames {
            results.write_still(&request.figure, t, &sequence.frame(t)?)?;
        }
    }
    // The report takes its place last: it can be made again from the results.
    let rendered = StagedReport::render(&results, &args.reports)?;
    let _lock = store::lock_exclusive(&args.results);
    results.folder = args.results.join(&experiment.name);
    aside.publish(&results.folder, manifest::FILE, &results::OWNED)?;
    results::remove_others(&results)?;
    let (index, written) = rendered.publish(&args.reports)?;
    super::report::write_site(&args.reports)?;
    Ok((results, written, index))
}

/// Loads the suites of an experiment.
///
/// # Errors
/// `Data` for sequences that cannot be read, and for missing ones unless `allow_missing`.
pub(super) fn load(
    experiment: &Experiment,
    data_roots: &[PathBuf],
    allow_missing: bool,
) -> Result<BTreeMap<String, Loaded>, Failure> {
    let suites = engine::execute::load(experiment, data_roots)
        .map_err(|e| Failure::data(format!("{}: {e}", experiment.name)))?;
    for (role, suite) in &suites {
        let name = &experiment.suites[role];
        if let Some((sequence, error)) = suite.broken.first() {
            return Err(Failure::data(format!("{name}/{sequence}: {error}")));
        }
        if let Some(first) = suite.missing.first()
            && (!allow_missing || suite.sequences.is_empty())
        {
            return Err(Failure::data(missing_message(data_roots, name, suite, first)));
        }
    }
    Ok(suites)
}

/// Message on the missing sequences of a suite: which, why, and how to get them.
fn missing_message(data_roots: &[PathBuf], suite: &str, loaded: &Loaded, first: &Missing) -> String {
    let names: Vec<&str> = loaded.missing.iter().map(|m| m.name.as_str()).collect();
    let names = names.join(", ");
    let roots: Vec<String> = data_roots.iter().map(|root| root.display().to_string()).collect();
    let reason = match roots.as_slice() {
        [] => format!("are missing: {NO_DATA_ROOT}.\nThey are {names}"),
        roots => format!("are missing under {}: {names}", roots.join(" and ")),
    };
    let how = first.how_to_get.trim_start_matches(NO_DATA_ROOT).trim_start_matches("; ");
    let hint =
        if loaded.sequences.is_empty() { "" } else { "\nOr run on what is there with --allow-missing." };
    let (missing, wanted) = (loaded.missing.len(), loaded.wanted);
    format!("{missing} of {wanted} sequences of suite {suite} {reason}\nFor {}: {how}.{hint}", first.folder)
}
