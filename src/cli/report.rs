//! `trackfail report [EXPERIMENT...]`

use super::{Failure, output};
use crate::plugin;
use crate::report::{self, results::Results};
use crate::spec::read::check_experiment_name;
use std::path::{Path, PathBuf};

/// Arguments of `report`.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Experiments (default: all that have results)
    #[arg(value_name = "EXPERIMENT")]
    experiments: Vec<String>,
    /// Folder that results are read from
    #[arg(long, value_name = "DIR", default_value = "results")]
    results: PathBuf,
    /// Folder that reports are written to
    #[arg(long, value_name = "DIR", default_value = "reports")]
    reports: PathBuf,
}

/// Runs the verb.
///
/// # Errors
/// See [`Failure`].
pub fn run(args: &Args) -> Result<(), Failure> {
    let names = if args.experiments.is_empty() { finished(&args.results) } else { args.experiments.clone() };
    if names.is_empty() {
        return Err(Failure::Usage(format!(
            "{}: no results; run an experiment first",
            args.results.display()
        )));
    }
    for name in &args.experiments {
        check_experiment_name(name).map_err(|message| Failure::Usage(format!("{name}: {message}")))?;
        if !args.results.join(name).join("manifest.json").exists() {
            let known = finished(&args.results);
            let what = plugin::unknown("finished experiment", name, known.iter().map(String::as_str));
            return Err(Failure::Usage(format!("{}: {what}", args.results.display())));
        }
    }
    for name in names {
        let results =
            Results::read(&args.results.join(&name)).map_err(|e| Failure::Io(format!("{name}: {e}")))?;
        let rendered = report::write(&results, &args.reports.join(&name))
            .map_err(|e| Failure::Io(format!("{name}: {e}")))?;
        output::write(&format!("{}\n", rendered.index.display()))?;
    }
    Ok(())
}

/// Experiments below a folder whose run is finished, by name.
pub fn finished(results: &Path) -> Vec<String> {
    walkdir::WalkDir::new(results)
        .sort_by_file_name()
        .into_iter()
        .filter_map(Result::ok)
        .filter(|entry| entry.file_name() == "manifest.json")
        .filter_map(|entry| {
            let folder = entry.path().parent()?.strip_prefix(results).ok()?;
            Some(folder.to_str()?.replace('\\', "/")).filter(|name| check_experiment_name(name).is_ok())
        })
        .collect()
}
