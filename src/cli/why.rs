//! `trackfail why EXPERIMENT [CELL]`

use super::output::{self, Format};
use super::{Failure, run};
use crate::engine::ExperimentPlan;
use crate::engine::Stop;
use crate::engine::plan::CellState;
use crate::engine::plan::why;
use crate::engine::store::Store;
use crate::plugin;
use std::path::PathBuf;

/// Arguments of `why`.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Experiment file, or name of a built-in experiment
    #[arg(value_name = "EXPERIMENT")]
    experiment: String,
    /// A cell, `sequence/tracker/run/method` or the beginning of it; without one, all that are not cached
    #[arg(value_name = "CELL")]
    cell: Option<String>,
    #[command(flatten)]
    data_roots: super::DataRoots,
    /// File of programs that may be run as trackers, signals or detectors; TRACKFAIL_PLUGINS otherwise, else plugins.toml here
    #[arg(long, value_name = "FILE")]
    plugins: Option<PathBuf>,
    /// Folder of the results whose store is asked
    #[arg(long, value_name = "DIR", default_value = "results")]
    results: PathBuf,
    /// How to print it
    #[arg(long, value_enum, default_value_t)]
    format: Format,
}

/// Runs the verb.
///
/// # Errors
/// See [`Failure`].
pub fn run(args: &Args) -> Result<(), Failure> {
    let roots = args.data_roots.folders()?;
    let (catalog, programs) = (super::catalog(&roots)?, super::programs(args.plugins.as_deref())?);
    let experiment = run::read_spec(&args.experiment, &catalog, &programs)?;
    let suites = crate::engine::execute::load(&experiment, &roots).map_err(Failure::data)?;
    for (role, suite) in &suites {
        let (name, wanted) = (&experiment.suites[role], suite.wanted);
        let absent = suite.missing.len() + suite.broken.len();
        if suite.sequences.is_empty() {
            let message =
                format!("no sequence of suite {name} can be read here; see `trackfail data list {name}`");
            return Err(Failure::data(message));
        }
        if absent > 0 {
            output::note(&format!(
                "{absent} of {wanted} sequences of suite {name} cannot be read here; nothing is said of them"
            ));
        }
    }
    let plan = ExperimentPlan::new(&experiment, suites, &roots, &Stop::default()).map_err(Failure::io)?;
    let store = Store::open_read_only(&args.results).map_err(Failure::io)?;
    let wanted = |cell: &str| args.cell.as_ref().is_none_or(|wanted| cell.starts_with(wanted.as_str()));
    let mut reasons = why(&plan, &store, wanted);
    if let Some(cell) = &args.cell
        && reasons.is_empty()
    {
        let known: Vec<String> = plan.map_labels(|labels| labels.name());
        let what = match plugin::nearest(cell, known.iter().map(String::as_str)) {
            Some(near) => format!("did you mean `{near}`?"),
            None => "see `trackfail run --dry-run` for the cells there are".to_string(),
        };
        return Err(Failure::usage(format!("{}: no cell `{cell}`; {what}", experiment.name)));
    }
    if args.cell.is_none() {
        reasons.retain(|r| r.state != CellState::Cached);
    }
    let rows: Vec<_> =
        reasons.into_iter().map(|r| vec![r.cell, r.state.word().to_string(), r.because]).collect();
    output::print(args.format, &["cell", "state", "because"], &rows)
}
