//! `trackfail run [SPEC...]`

use super::output::{self, Format};
use super::{Failure, export};
use crate::dataset::suite::{Catalog, Loaded, NO_DATA_ROOT};
use crate::engine::CellError;
use crate::engine::Shard;
use crate::engine::observe::progress::{self, ProgressWatch};
use crate::engine::plan::{CellState, PlannedCell, variants};
use crate::engine::store::{self, Store};
use crate::engine::{self, ExperimentPlan, Options, Outcome};
use crate::engine::{RunError, ShardOutcome};
use crate::engine::{RunLimits, Stop};
use crate::plugin;
use crate::report::claims::Finding;
use crate::report::{self, WrittenReport, stills};
use crate::results::manifest::FailedCell;
use crate::results::{self, Results, RunRecord, manifest};
use crate::spec::{self, Experiment, builtin};
use crate::table::render;
use crate::tracker::process::Programs;
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
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
    /// Folder of real sequences and result files; TRACKFAIL_DATA otherwise
    #[arg(long, value_name = "DIR")]
    data_root: Option<PathBuf>,
    /// File of programs that may be run as trackers; TRACKFAIL_PLUGINS otherwise, else plugins.toml here
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
    /// Go on without sequences that are not there; tables say how many were
    #[arg(long)]
    allow_missing: bool,
    /// Print the cells and whether they are cached, stale or missing, and stop
    #[arg(long)]
    dry_run: bool,
    /// Compute everything anew, and say where it is not what was kept
    #[arg(long)]
    force: bool,
    /// Compute one share of so many into the store, and no tables (see `trackfail merge`)
    #[arg(long, value_name = "I/N")]
    shard: Option<Shard>,
    /// At most so many repetitions of every tracker, also on suites that are learned from; tables say so
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    runs: Option<u32>,
    /// Also write every track as a result file: VOT's format for reset protocols, OTB's for one pass
    #[arg(long, value_name = "DIR")]
    export_tracks: Option<PathBuf>,
    /// Seconds after which a cell has failed
    #[arg(long, value_name = "SECONDS", default_value_t = 3600.0, value_parser = positive)]
    timeout: f64,
    /// Size in GiB above which the store loses what was used longest ago
    #[arg(long, value_name = "GIB", default_value_t = 20.0, value_parser = positive)]
    store_limit: f64,
    /// No tables and no progress
    #[arg(long, short)]
    quiet: bool,
    /// Print the tables for people, or all pooled numbers as CSV or JSON
    #[arg(long, value_enum, default_value_t)]
    format: Format,
}

impl Args {
    /// Largest size of the store, in bytes.
    fn store_limit(&self) -> u64 {
        (self.store_limit * (1_u64 << 30) as f64) as u64
    }
}

/// A positive number of at most a hundred million.
fn positive(text: &str) -> Result<f64, String> {
    let number = text.parse().ok().filter(|n: &f64| *n > 0.0 && *n <= 1e8);
    number.ok_or_else(|| format!("`{text}` is no number above 0 and up to 100000000"))
}

/// At most so many failed cells are listed.
const MOST_TOLD: usize = 50;

/// Reads an experiment from a file, or a built-in one by name; it may run `programs`.
///
/// # Errors
/// When there is no such file, or it is wrong.
pub fn read_spec(name: &str, catalog: &Catalog, programs: &Programs) -> Result<Experiment, Failure> {
    let path = Path::new(name);
    let experiment = if path.is_file() {
        spec::read_file(path, catalog, Some(programs))
    } else if let Some((_, text)) = builtin::EXPERIMENTS.iter().find(|(known, _)| *known == name) {
        spec::parse_with(name, text, catalog, Some(programs))
    } else {
        let known = builtin::EXPERIMENTS.iter().map(|(known, _)| *known);
        return Err(Failure::Usage(format!(
            "{name}: no such file, and {}",
            plugin::unknown("built-in experiment", name, known)
        )));
    };
    experiment.map_err(|e| Failure::Usage(e.to_string()))
}

/// Runs the verb.
///
/// # Errors
/// See [`Failure`].
pub fn run(args: &Args) -> Result<(), Failure> {
    let args = &Args { data_root: super::data_root(args.data_root.as_deref())?, ..args.clone() };
    let names =
        if args.specs.is_empty() { vec![builtin::QUICKSTART.to_string()] } else { args.specs.clone() };
    let programs = super::programs(args.plugins.as_deref())?;
    let catalog = super::catalog(args.data_root.as_deref())?;
    // All files are checked before the first is run.
    let mut experiments =
        names.iter().map(|name| read_spec(name, &catalog, &programs)).collect::<Result<Vec<_>, _>>()?;
    if let Some(runs) = args.runs {
        experiments.iter_mut().for_each(|e| e.limit_runs(runs));
    }
    let limits = RunLimits { timeout: Some(Duration::from_secs_f64(args.timeout)), stop: stop_on_signals() };
    let mut worst: Option<Failure> = None;
    for experiment in &experiments {
        let outcome =
            super::with_threads(args.jobs, || run_one(args, experiment, &limits)).and_then(|done| done);
        if let Err(failure) = outcome {
            if !matches!(failure, Failure::Data(_) | Failure::Cells(_) | Failure::Expectation(_)) {
                return Err(failure);
            }
            if worst.as_ref().is_none_or(|w| failure.code() < w.code()) {
                worst = Some(failure);
            }
        }
    }
    worst.map_or(Ok(()), Err)
}

/// A flag that Ctrl-C and the signals of batch systems set; a second one ends the program at once.
fn stop_on_signals() -> Stop {
    static STOP: std::sync::OnceLock<Stop> = std::sync::OnceLock::new();
    let stop = STOP.get_or_init(|| {
        let stop = Stop::default();
        let flag = stop.clone();
        let handler = move || {
            if flag.is_set() {
                std::process::exit(130);
            }
            flag.set();
        };
        // Without a handler the signals end the program, and the store is as whole as after any kill.
        let _ = ctrlc::set_handler(handler);
        stop
    });
    stop.clone()
}

fn run_one(args: &Args, experiment: &Experiment, limits: &RunLimits) -> Result<(), Failure> {
    let start = Instant::now();
    let failure = |e: RunError| match e {
        RunError::Interrupted => Failure::Interrupted(format!("{}: {e}", experiment.name)),
        RunError::Dataset(e) => Failure::Data(format!("{}: {e}", experiment.name)),
        e => Failure::Io(format!("{}: {e}", experiment.name)),
    };
    let suites = load(args, experiment)?;
    let plan =
        ExperimentPlan::new(experiment, suites, args.data_root.as_deref(), &limits.stop).map_err(failure)?;
    if args.dry_run {
        return dry_run(args, &plan);
    }
    let store = Store::open(&args.results).map_err(|e| failure(e.into()))?;
    let bar = progress_bar(args, &experiment.name);
    let drawn = bar.clone();
    let progress = move |done: u64, total: u64| {
        drawn.set_length(total);
        drawn.set_position(done);
    };
    let options = Options {
        data_root: args.data_root.clone(),
        force: args.force,
        limits: limits.clone(),
        progress: Arc::new(progress),
        watch: Arc::new(ProgressWatch::default()),
    };
    if args.shard.is_none() {
        options.watch.all_cells(plan.cells().len());
    }
    // Whoever ends before it is finished is told to have stopped.
    let telling = progress::publish(&args.results, experiment, args.shard, &options.watch);
    let finish = move || telling.into_iter().for_each(progress::ProgressPublisher::finish);
    if let Some(shard) = args.shard {
        let done = engine::run_shard(&plan, &store, &options, shard);
        bar.finish_and_clear();
        tell_problems(&store);
        let done = done.map_err(failure)?;
        finish();
        store.evict(args.store_limit());
        return tell_shard(args, experiment, shard, &done);
    }
    let outcome = engine::run(&plan, &store, &options);
    bar.finish_and_clear();
    tell_problems(&store);
    let outcome = outcome.map_err(failure)?;
    if limits.stop.is_set() {
        return Err(failure(RunError::Interrupted));
    }
    tell(args, &format!("{}: {}", experiment.name, outcome.tally));
    if let Some(folder) = &args.export_tracks {
        export::write(folder, experiment, &outcome)?;
    }
    options.watch.stage("writing tables and report");
    let (results, written, index) = write(args, experiment, &store, &outcome, start)?;
    finish();
    drop(outcome);
    tell_problems(&store);
    store.evict(args.store_limit());
    if !args.quiet {
        match args.format {
            Format::Table => print_summary(&results, &written, &index)?,
            format => print_measures(&results, format)?,
        }
    }
    verdict(args, &results, &written.findings)
}

/// Writes results and report aside and puts them in their place.
fn write(
    args: &Args,
    experiment: &Experiment,
    store: &Store,
    outcome: &Outcome<'_>,
    start: Instant,
) -> Result<(Results, WrittenReport, PathBuf), Failure> {
    let io = |e: &dyn std::fmt::Display| Failure::Io(format!("{}: {e}", experiment.name));
    let aside = store.staging().map_err(|e| io(&e))?;
    // This package's build script knows the revision; the crates below do not.
    let record = RunRecord::here(option_env!("TRACKFAIL_REVISION"), start.elapsed().as_secs_f64());
    results::write(aside.path(), experiment, outcome, &record).map_err(|e| io(&e))?;
    let mut results = Results::read(aside.path()).map_err(|e| io(&e))?;
    for request in stills::requests(&results).map_err(|e| io(&e))? {
        let Some(sequence) = outcome.sequences.iter().find(|s| s.name == request.sequence) else { continue };
        for &t in &request.frames {
            let frame = sequence.frame(t).map_err(|e| io(&e))?;
            results.write_still(&request.figure, t, &frame).map_err(|e| io(&e))?;
        }
    }
    // The report is rendered before anything takes its place, and takes its own last: it can be made again.
    let rendered = super::report::render(&results, &args.reports)?;
    let _lock = store::lock_exclusive(&args.results);
    results.folder = args.results.join(&experiment.name);
    aside.publish(&results.folder, manifest::FILE, &results::OWNED).map_err(|e| io(&e))?;
    let (index, written) = rendered.publish(&args.reports).map_err(|e| io(&e))?;
    super::report::write_site(&args.reports)?;
    Ok((results, written, index))
}

/// One line on stderr.
fn tell(args: &Args, line: &str) {
    if !args.quiet {
        output::note(line);
    }
}

fn tell_problems(store: &Store) {
    for problem in store.problems() {
        output::note(&format!("warning: {problem}"));
    }
}

fn tell_shard(
    args: &Args,
    experiment: &Experiment,
    shard: Shard,
    done: &ShardOutcome,
) -> Result<(), Failure> {
    let (name, Shard { number, of }) = (&experiment.name, shard);
    tell(args, &format!("{name}: {}", done.tally));
    tell(
        args,
        &format!(
            "{name}: share {number} of {of} is done: {} cells; run without --shard for the tables",
            done.done
        ),
    );
    for (cell, reason) in done.failed.iter().take(MOST_TOLD) {
        tell(args, &format!("failed: {cell}: {reason}"));
    }
    let tell = |(cell, reason): &(String, CellError)| {
        format!("{name}: {} cells have no result, the first: {cell}: {reason}", done.failed.len())
    };
    if let Some(broken) = done.failed.iter().find(|(_, e)| matches!(e, CellError::Failed(_))) {
        return Err(Failure::Cells(tell(broken)));
    }
    match done.failed.first().filter(|_| !args.allow_missing) {
        Some(absent) => Err(Failure::Data(tell(absent))),
        None => Ok(()),
    }
}

fn load(args: &Args, experiment: &Experiment) -> Result<BTreeMap<String, Loaded>, Failure> {
    let suites = engine::execute::load(experiment, args.data_root.as_deref())
        .map_err(|e| Failure::Data(format!("{}: {e}", experiment.name)))?;
    for (role, suite) in &suites {
        let name = &experiment.suites[role];
        if let Some(broken) = suite.broken.first() {
            return Err(Failure::Data(format!("{name}/{}: {}", broken.name, broken.error)));
        }
        if let Some(first) = suite.missing.first()
            && (!args.allow_missing || suite.sequences.is_empty())
        {
            let names: Vec<&str> = suite.missing.iter().map(|m| m.name.as_str()).collect();
            let names = names.join(", ");
            let reason = match &args.data_root {
                Some(root) => format!("are missing under {}: {names}", root.display()),
                None => format!("are missing: {NO_DATA_ROOT}.\nThey are {names}"),
            };
            let how = first.how_to_get.trim_start_matches(NO_DATA_ROOT).trim_start_matches("; ");
            let hint = if suite.sequences.is_empty() {
                ""
            } else {
                "\nOr run on what is there with --allow-missing."
            };
            return Err(Failure::Data(format!(
                "{} of {} sequences of suite {name} {reason}\nFor {}: {how}.{hint}",
                suite.missing.len(),
                suite.wanted,
                first.folder,
            )));
        }
    }
    Ok(suites)
}

fn dry_run(args: &Args, plan: &ExperimentPlan<'_>) -> Result<(), Failure> {
    let store = Store::open_read_only(&args.results).map_err(|e| Failure::Io(e.to_string()))?;
    tell_problems(&store);
    let states = plan.states(&store);
    let variants: Vec<_> = variants(plan.experiment).collect();
    let row = |(cell, (_, state)): (PlannedCell, &(String, CellState))| {
        let job = plan.jobs[cell.job];
        let (method, variant) = variants[cell.variant];
        vec![
            plan.test().sequences[cell.sequence].sequence.name.clone(),
            plan.experiment.trackers[job.tracker].label.clone(),
            job.run.to_string(),
            method.name.clone(),
            variant.params(),
            state.word().to_string(),
        ]
    };
    let rows: Vec<_> = plan.cells().into_iter().zip(&states).map(row).collect();
    output::print(args.format, &["sequence", "tracker", "run", "method", "params", "state"], &rows)?;
    let count = |wanted: CellState| states.iter().filter(|(_, s)| *s == wanted).count();
    let counts = [CellState::Cached, CellState::Stale, CellState::Missing, CellState::Absent]
        .map(|s| format!("{} {}", count(s), s.word()));
    tell(args, &format!("{}: {}", plan.experiment.name, counts.join(", ")));
    Ok(())
}

fn progress_bar(args: &Args, name: &str) -> ProgressBar {
    // indicatif draws nothing when stderr is no terminal.
    let target = if args.quiet { ProgressDrawTarget::hidden() } else { ProgressDrawTarget::stderr() };
    let style = ProgressStyle::with_template("{prefix} {wide_bar} {pos}/{len} frames, {per_sec}, {eta} left");
    let bar = ProgressBar::with_draw_target(None, target).with_prefix(name.to_string());
    match style {
        Ok(style) => bar.with_style(style),
        Err(_) => bar,
    }
}

/// The rows of `measures.csv`, behind the name of the experiment.
fn print_measures(results: &Results, format: Format) -> Result<(), Failure> {
    let io = |e: &dyn std::fmt::Display| Failure::Io(e.to_string());
    let bytes =
        engine::store::read(&results.folder.join(results::measures::FILE.name)).map_err(|e| io(&e))?;
    let (mut headings, mut rows) = results::texts_from_csv(bytes).map_err(|e| io(&e))?;
    headings.insert(0, "experiment".to_string());
    rows.iter_mut().for_each(|row| row.insert(0, results.experiment.name.clone()));
    let headings: Vec<&str> = headings.iter().map(String::as_str).collect();
    output::print(format, &headings, &rows)
}

fn print_summary(results: &Results, written: &WrittenReport, index: &Path) -> Result<(), Failure> {
    let mut text = format!("{}: {}\n\n", results.experiment.name, results.experiment.title);
    for layout in &written.tables {
        text.push_str(&render::plain(layout));
        text.push('\n');
    }
    for finding in &written.findings {
        for tested in &finding.tested {
            let who =
                if tested.tracker.is_empty() { String::new() } else { format!(" [{}]", tested.tracker) };
            text.push_str(&format!("{}{who}: {}\n", report::verdict_words(&tested.verdict), finding.text));
        }
    }
    let failed = &results.manifest.cells_failed;
    for cell in failed.iter().take(MOST_TOLD) {
        let (sequence, tracker, method) = (&cell.sequence, &cell.tracker, &cell.method);
        text.push_str(&format!("failed: {sequence}, {tracker}, {method}: {}\n", cell.reason));
    }
    if failed.len() > MOST_TOLD {
        text.push_str(&format!("failed: {} more, see scores.csv\n", failed.len() - MOST_TOLD));
    }
    text.push_str(&format!("\nresults: {}\nreport:  {}\n", results.folder.display(), index.display()));
    output::write(&text)
}

fn verdict(args: &Args, results: &Results, findings: &[Finding]) -> Result<(), Failure> {
    let failed = &results.manifest.cells_failed;
    let tell = |cell: &FailedCell| {
        format!(
            "{}: {} of {} cells have no result, the first: {}, {}, {}: {}",
            results.experiment.name,
            failed.len(),
            failed.len() + results.manifest.cells_done,
            cell.sequence,
            cell.tracker,
            cell.method,
            cell.reason
        )
    };
    if let Some(broken) = failed.iter().find(|c| !c.missing) {
        return Err(Failure::Cells(tell(broken)));
    }
    if let Some(absent) = failed.first().filter(|_| !args.allow_missing) {
        return Err(Failure::Data(tell(absent)));
    }
    if !results.manifest.differing.is_empty() {
        let names = results.manifest.differing.join(", ");
        return Err(Failure::Data(format!(
            "{}: not the data that datasets.lock pins: {names} (results are written and say so; see `trackfail data verify`)",
            results.experiment.name
        )));
    }
    if let Some(unmet) = findings.iter().find(|f| f.required && !f.holds()) {
        let message = format!("{}: required but not met: {}", results.experiment.name, unmet.text);
        return Err(Failure::Expectation(message));
    }
    Ok(())
}
