//! `trackfail run [SPEC...]`

use super::Failure;
use super::output::{self, Format};
use crate::dataset::lock::Loaded;
use crate::engine::{self, Options};
use crate::plugin;
use crate::report::claims::Finding;
use crate::report::results::Results;
use crate::report::{self, stills};
use crate::spec::{self, Experiment, builtin};
use crate::table::manifest::FailedCell;
use crate::table::{folder, frame, render};
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::time::Instant;

/// Arguments of `run`.
#[derive(Debug, Clone, clap::Args)]
pub struct Args {
    /// Experiment files, or names of built-in experiments (see `trackfail list experiments`)
    #[arg(value_name = "SPEC")]
    specs: Vec<String>,
    /// Folder of real sequences and result files; TRACKFAIL_DATA otherwise
    #[arg(long, value_name = "DIR")]
    data_root: Option<PathBuf>,
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
    /// Print the cells that would be run, and stop
    #[arg(long)]
    dry_run: bool,
    /// No tables and no progress
    #[arg(long, short)]
    quiet: bool,
    /// Print the tables for people, or all pooled numbers as CSV or JSON
    #[arg(long, value_enum, default_value_t)]
    format: Format,
}

/// Reads an experiment from a file, or a built-in one by name.
///
/// # Errors
/// When there is no such file, or it is wrong.
pub fn read_spec(name: &str) -> Result<Experiment, Failure> {
    let path = Path::new(name);
    let text = if path.is_file() {
        engine::store::read_text(path).map_err(|e| Failure::Usage(e.to_string()))?
    } else if let Some((_, text)) = builtin::EXPERIMENTS.iter().find(|(known, _)| *known == name) {
        (*text).to_string()
    } else {
        let known = builtin::EXPERIMENTS.iter().map(|(known, _)| *known);
        return Err(Failure::Usage(format!(
            "{name}: no such file, and {}",
            plugin::unknown("built-in experiment", name, known)
        )));
    };
    spec::parse(name, &text).map_err(|e| Failure::Usage(e.to_string()))
}

/// Runs the verb.
///
/// # Errors
/// See [`Failure`].
pub fn run(args: &Args) -> Result<(), Failure> {
    let args = &Args { data_root: super::data_root(args.data_root.as_deref())?, ..args.clone() };
    let names =
        if args.specs.is_empty() { vec![builtin::QUICKSTART.to_string()] } else { args.specs.clone() };
    // All files are checked before the first is run.
    let experiments = names.iter().map(|name| read_spec(name)).collect::<Result<Vec<_>, _>>()?;
    let mut worst: Option<Failure> = None;
    for experiment in &experiments {
        if let Err(failure) = run_one(args, experiment) {
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

fn run_one(args: &Args, experiment: &Experiment) -> Result<(), Failure> {
    let start = Instant::now();
    let suites = load(args, experiment)?;
    if args.dry_run {
        return dry_run(args, experiment, &suites);
    }
    let bar = progress_bar(args, &experiment.name);
    let progress = |done: u64, total: u64| {
        bar.set_length(total);
        bar.set_position(done);
    };
    let options =
        Options { data_root: args.data_root.clone(), jobs: args.jobs.map(usize::from), progress: &progress };
    let outcome = engine::run(experiment, suites, &options)
        .map_err(|e| Failure::Io(format!("{}: {e}", experiment.name)))?;
    bar.finish_and_clear();

    let folder = args.results.join(&experiment.name);
    let io = |e: &dyn std::fmt::Display| Failure::Io(e.to_string());
    folder::write(&folder, experiment, &outcome, start.elapsed().as_secs_f64()).map_err(|e| io(&e))?;
    let results = Results::read(&folder).map_err(|e| io(&e))?;
    for request in stills::requests(&results).map_err(|e| io(&e))? {
        let Some(sequence) = outcome.sequences.iter().find(|s| s.name == request.sequence) else { continue };
        for &t in &request.frames {
            let frame = sequence.frame(t).map_err(|e| io(&e))?;
            stills::keep(&results, &request, t, &frame).map_err(|e| io(&e))?;
        }
    }
    let rendered = report::write(&results, &args.reports.join(&experiment.name)).map_err(|e| io(&e))?;
    if !args.quiet {
        match args.format {
            Format::Table => print_summary(&results, &rendered.findings, &rendered.index)?,
            format => print_measures(&results, format)?,
        }
    }
    verdict(args, &results, &rendered.findings)
}

fn load(args: &Args, experiment: &Experiment) -> Result<BTreeMap<String, Loaded>, Failure> {
    let suites = engine::run::load(experiment, args.data_root.as_deref())
        .map_err(|e| Failure::Data(format!("{}: {e}", experiment.name)))?;
    for (role, suite) in &suites {
        let name = &experiment.suites[role];
        if let Some(broken) = suite.broken.first() {
            return Err(Failure::Data(format!("{name}/{}: {}", broken.name, broken.error)));
        }
        if let Some(first) = suite.missing.first()
            && (!args.allow_missing || suite.sequences.is_empty())
        {
            let root = match &args.data_root {
                Some(root) => format!("under {}", root.display()),
                None => "(no --data-root was given, and TRACKFAIL_DATA is not set)".to_string(),
            };
            let names: Vec<&str> = suite.missing.iter().map(|m| m.name.as_str()).collect();
            let hint = if suite.sequences.is_empty() {
                ""
            } else {
                "\nOr run on what is there with --allow-missing."
            };
            return Err(Failure::Data(format!(
                "{} of {} sequences of suite {name} are not {root}: {}\nFor {}: {}.{hint}",
                suite.missing.len(),
                suite.wanted,
                names.join(", "),
                first.folder,
                first.how_to_get,
            )));
        }
    }
    Ok(suites)
}

fn dry_run(args: &Args, experiment: &Experiment, suites: &BTreeMap<String, Loaded>) -> Result<(), Failure> {
    let mut rows = Vec::new();
    for sequence in suites.get(spec::TEST).iter().flat_map(|s| &s.sequences) {
        for job in engine::pass::jobs(experiment) {
            for method in &experiment.methods {
                for variant in &method.variants {
                    rows.push(vec![
                        sequence.name.clone(),
                        job.tracker.label.clone(),
                        job.run.to_string(),
                        method.name.clone(),
                        variant.params(),
                    ]);
                }
            }
        }
    }
    output::print(args.format, &["sequence", "tracker", "run", "method", "params"], &rows)
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
    let bytes = engine::store::read(&results.folder.join("measures.csv")).map_err(|e| io(&e))?;
    let (mut headings, mut rows) = frame::all_texts(bytes).map_err(|e| io(&e))?;
    headings.insert(0, "experiment".to_string());
    rows.iter_mut().for_each(|row| row.insert(0, results.experiment.name.clone()));
    let headings: Vec<&str> = headings.iter().map(String::as_str).collect();
    output::print(format, &headings, &rows)
}

fn print_summary(results: &Results, findings: &[Finding], index: &Path) -> Result<(), Failure> {
    let mut text = format!("{}: {}\n\n", results.experiment.name, results.experiment.title);
    for layout in folder::layouts(&results.experiment, &results.measures, &results.manifest) {
        text.push_str(&render::plain(&layout));
        text.push('\n');
    }
    for finding in findings {
        for tested in &finding.tested {
            let who =
                if tested.tracker.is_empty() { String::new() } else { format!(" [{}]", tested.tracker) };
            text.push_str(&format!("{}{who}: {}\n", report::verdict_words(&tested.verdict), finding.text));
        }
    }
    for cell in results.manifest.cells_failed.iter().take(10) {
        let (sequence, tracker, method) = (&cell.sequence, &cell.tracker, &cell.method);
        text.push_str(&format!("failed: {sequence}, {tracker}, {method}: {}\n", cell.reason));
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
