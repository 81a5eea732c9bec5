//! `trackfail report [EXPERIMENT...]`: reports, and the page over all of them.

use super::{Failure, output};
use crate::engine::store::lock_exclusive;
use crate::engine::store::staging::{self, Staging};
use crate::plugin;
use crate::report::{self, Written, results::Results};
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
    // A run must not replace the results while they are read and their tables written.
    let _lock = lock_exclusive(&args.results);
    let done = names.iter().try_for_each(|name| {
        let results =
            Results::read(&args.results.join(name)).map_err(|e| Failure::Io(format!("{name}: {e}")))?;
        let (index, _) = render(&results, &args.reports)?.publish(&args.reports)?;
        output::write(&format!("{}\n", index.display()))
    });
    // Also of those before one that could not be made.
    let site = if args.reports.is_dir() { write_site(&args.reports) } else { Ok(()) };
    done.and(site)
}

/// A report that was rendered aside.
pub struct Rendered {
    name: String,
    aside: Staging,
    written: Written,
}

/// Renders a report aside, and its tables beside the results.
///
/// # Errors
/// [`Failure::Io`].
pub fn render(results: &Results, reports: &Path) -> Result<Rendered, Failure> {
    let name = results.experiment.name.clone();
    let io = |e: &dyn std::fmt::Display| Failure::Io(format!("{name}: {e}"));
    staging::sweep(reports);
    let aside = Staging::new(reports).map_err(|e| io(&e))?;
    let written = report::write(results, aside.path()).map_err(|e| io(&e))?;
    report::site::write_summary(results, &written.findings, aside.path()).map_err(|e| io(&e))?;
    Ok(Rendered { name, aside, written })
}

impl Rendered {
    /// Puts the report in its place below `reports`; its page, and what it says.
    ///
    /// # Errors
    /// [`Failure::Io`].
    pub fn publish(self, reports: &Path) -> Result<(PathBuf, Written), Failure> {
        let target = reports.join(&self.name);
        let placed = self.aside.publish(&target, report::INDEX, &report::OWNED);
        placed.map_err(|e| Failure::Io(format!("{}: {e}", self.name)))?;
        Ok((target.join(report::INDEX), self.written))
    }
}

/// Writes the page over all reports below a folder, and tells of those that it cannot list.
///
/// # Errors
/// [`Failure::Io`].
pub fn write_site(reports: &Path) -> Result<(), Failure> {
    let told = report::site::write_index(reports).map_err(|e| Failure::Io(e.to_string()))?;
    told.warnings.iter().for_each(|warning| output::note(&format!("warning: {warning}")));
    Ok(())
}

/// Experiments below a folder whose run is finished, by name.
pub fn finished(results: &Path) -> Vec<String> {
    walkdir::WalkDir::new(results)
        .sort_by_file_name()
        .into_iter()
        // The store and what is put together aside are hidden.
        .filter_entry(|e| e.depth() == 0 || !e.file_name().as_encoded_bytes().starts_with(b"."))
        .filter_map(Result::ok)
        .filter(|entry| entry.file_name() == "manifest.json")
        .filter_map(|entry| {
            let folder = entry.path().parent()?.strip_prefix(results).ok()?;
            Some(folder.to_str()?.replace('\\', "/")).filter(|name| check_experiment_name(name).is_ok())
        })
        .collect()
}
