//! `trackfail list [experiments|suites|methods|trackers|signals|detectors|analyses|protocols]`

use super::output::{self, Format};
use super::{Failure, run};
use crate::analysis::ANALYSES;
use crate::dataset::suite::Suite;
use crate::detector::DETECTORS;
use crate::engine::Stop;
use crate::engine::plan::CellState;
use crate::engine::store::Store;
use crate::engine::{self, ExperimentPlan};
use crate::plugin::Entry;
use crate::report::finished;
use crate::score::{PROTOCOLS, longterm, success};
use crate::signal::SIGNALS;
use crate::spec::builtin;
use crate::tracker::TRACKERS;
use crate::tracker::process::{self, Programs, Role};
use crate::tracker::protocol::RunProtocol;
use clap::ValueEnum;
use std::path::PathBuf;

/// Arguments of `list`.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// The list to print; without it, the lists that there are
    what: Option<What>,
    /// Format of the list
    #[arg(long, value_enum, default_value_t)]
    format: Format,
    /// Folder that results are looked for in (experiments)
    #[arg(long, value_name = "DIR", default_value = "results")]
    results: PathBuf,
    #[command(flatten)]
    data_roots: super::DataRoots,
    /// File of programs (trackers, signals, detectors); TRACKFAIL_PLUGINS otherwise, else plugins.toml here
    #[arg(long, value_name = "FILE")]
    plugins: Option<PathBuf>,
}

/// Lists that can be shown.
#[derive(Debug, Clone, Copy, clap::ValueEnum)]
enum What {
    /// Experiments that come with the program, and how much of each is computed here
    Experiments,
    /// Suites of sequences to test and to train on
    Suites,
    /// Methods that have a name: a signal with a detector
    Methods,
    /// Kinds of trackers, with their parameters
    Trackers,
    /// Kinds of signals, with their parameters
    Signals,
    /// Kinds of detectors, with their parameters
    Detectors,
    /// Kinds of analyses, with their parameters
    Analyses,
    /// Rules by which alarms, boxes and confidences are scored, and trackers are run
    Protocols,
}

/// Runs the verb.
///
/// # Errors
/// See [`Failure`].
pub fn run(args: &Args) -> Result<(), Failure> {
    let plugin = ["kind", "version", "summary", "parameters"];
    let print = |headings: &[&str], rows: Vec<Vec<String>>| output::print(args.format, headings, &rows);
    let Some(what) = args.what else {
        let row = |what: &What| {
            let value = what.to_possible_value()?;
            Some(vec![value.get_name().to_string(), value.get_help()?.to_string()])
        };
        return print(&["list", "content"], What::value_variants().iter().filter_map(row).collect());
    };
    match what {
        What::Experiments => experiments(args),
        What::Suites => {
            let catalog = super::catalog(&args.data_roots.folders()?)?;
            let row =
                |s: Suite| vec![s.name().into(), s.sequence_names().len().to_string(), s.title().into()];
            print(&["suite", "targets", "title"], catalog.suites().map(row).collect())
        }
        What::Methods => print(&["method", "needs", "signal", "detector"], methods()?),
        What::Trackers => print(&plugin, with_programs(args, TRACKERS, Role::Tracker)?),
        What::Signals => print(&plugin, with_programs(args, SIGNALS, Role::Signal)?),
        What::Detectors => print(&plugin, with_programs(args, DETECTORS, Role::Detector)?),
        What::Analyses => print(&plugin, plugins(ANALYSES)),
        What::Protocols => {
            let row = |of: &str, name: &str, summary: &str| [of, name, summary].map(String::from).to_vec();
            let detectors = PROTOCOLS.iter().map(|p| row("labels of detectors", p.name, p.summary));
            let trackers = success::RULES.iter().map(|r| row("boxes of trackers", r.name, r.summary));
            let longterm = longterm::RULES.iter().map(|r| row("confidence of trackers", r.name, r.summary));
            let runs = RunProtocol::ALL.iter().map(|p| row("running trackers", p.name(), p.summary()));
            let all = detectors.chain(trackers).chain(longterm).chain(runs);
            print(&["of", "protocol", "summary"], all.collect())
        }
    }
}

/// Lists experiments. The computed share is a sentence for people, and numbers for programs.
fn experiments(args: &Args) -> Result<(), Failure> {
    let finished = finished::names(&args.results);
    let roots = args.data_roots.folders()?;
    let catalog = super::catalog(&roots)?;
    let store = Store::open_read_only(&args.results).map_err(Failure::io)?;
    let is_table = args.format == Format::Table;
    let mut rows = Vec::new();
    for (name, _) in builtin::EXPERIMENTS {
        let e = run::read_spec(name, &catalog, &Programs::default())?;
        let suite = &e.suites[crate::spec::TEST];
        let suites = engine::execute::load(&e, &roots).map_err(Failure::data)?;
        let plan = ExperimentPlan::new(&e, suites, &roots, &Stop::default()).map_err(Failure::io)?;
        let sources = catalog.suite(suite).map_err(Failure::data)?.sources();
        let cells: usize = sources.iter().map(|source| plan.cells_on(source).len()).sum();
        let states = plan.states(&store);
        let count = |wanted: CellState| states.iter().filter(|state| **state == wanted).count();
        let (cached, stale) = (count(CellState::Cached), count(CellState::Stale));
        let is_finished = finished.iter().any(|finished| finished == name);
        let mut row = vec![e.name.clone(), e.title.clone(), suite.clone()];
        if is_table {
            let stale = if stale == 0 { String::new() } else { format!(", {stale} stale") };
            let finished = if is_finished { "finished, " } else { "" };
            row.push(format!("{finished}{cached} of {cells} cells cached{stale}"));
        } else {
            row.insert(2, e.object.clone().unwrap_or_default());
            // Those without data or result files here are missing, too.
            row.extend([cells, cached, stale, cells - cached - stale].map(|n| n.to_string()));
            row.push(if is_finished { "finished" } else { "none" }.to_string());
        }
        rows.push(row);
    }
    let headings: &[&str] = match is_table {
        true => &["experiment", "title", "suite", "state"],
        false => {
            &["experiment", "title", "object", "suite", "cells", "cached", "stale", "missing", "results"]
        }
    };
    output::print(args.format, headings, &rows)
}

/// Named methods, with their inputs beside the tracker's boxes.
fn methods() -> Result<Vec<Vec<String>>, Failure> {
    let mut rows = Vec::new();
    for name in trackfail_judge::method::names() {
        let Some(method) = builtin::published_method(name).transpose().map_err(Failure::io)? else {
            continue;
        };
        let Some(variant) = method.variants.first() else { continue };
        let signals: Vec<&str> = variant.signals.iter().map(|s| s.kind).collect();
        let detector = variant.detector.example.kind.to_string();
        rows.push(vec![method.name.clone(), variant.needs().join(", "), signals.join(", "), detector]);
    }
    Ok(rows)
}

/// Built-in plugins of a kind, followed by the user's programs.
fn with_programs<T: ?Sized>(
    args: &Args,
    list: &'static [Entry<T>],
    role: Role,
) -> Result<Vec<Vec<String>>, Failure> {
    let programs = super::programs(args.plugins.as_deref())?;
    let mut rows = plugins(list);
    rows.extend(programs.of(role).map(|p| {
        let summary = format!("speaks {}, from {}", p.protocol.word(), programs.file);
        let parameters = format!("program = \"{}\"", p.name);
        vec![process::ENTRY.kind.to_string(), p.version.clone(), summary, parameters]
    }));
    Ok(rows)
}

fn plugins<T: ?Sized>(list: &'static [Entry<T>]) -> Vec<Vec<String>> {
    let row = |e: &Entry<T>| {
        let schema = (e.schema)();
        let keys = schema.get("properties").and_then(serde_json::Value::as_object);
        let keys: Vec<&str> = keys.into_iter().flat_map(|keys| keys.keys()).map(String::as_str).collect();
        vec![e.kind.to_string(), e.version.to_string(), e.summary.to_string(), keys.join(", ")]
    };
    list.iter().map(row).collect()
}
