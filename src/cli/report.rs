//! `trackfail report [EXPERIMENT...]`: reports, and the page over all of them.

use super::{Exit, Failure, output};
use crate::engine::store::lock_exclusive;
use crate::plugin::unknown;
use crate::report::finished::{self, LookupError};
use crate::report::paper::{self, Rendered};
use crate::report::{self, ReportError, StagedReport};
use crate::results::ResultsError;
use crate::spec::presentation::name_of;
use std::path::{Path, PathBuf};

/// Arguments of `report`.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Experiments, by name or by a file whose captions, titles, order and selection are to be shown (default: all that
    /// have results)
    #[arg(value_name = "EXPERIMENT")]
    experiments: Vec<String>,
    /// Folder that results are read from
    #[arg(long, value_name = "DIR", default_value = "results")]
    results: PathBuf,
    /// Folder that reports are written to
    #[arg(long, value_name = "DIR", default_value = "reports")]
    reports: PathBuf,
    /// Also write tables (LaTeX) and figures (PDF) into this folder, for a paper, with paper.tex, which shows them
    #[arg(long, value_name = "DIR")]
    paper: Option<PathBuf>,
    /// With --paper: only the tables and figures of this name, such as `table1`; may be repeated
    #[arg(long, value_name = "NAME", requires = "paper")]
    only: Vec<String>,
}

/// Runs the verb.
///
/// # Errors
/// See [`Failure`].
pub fn run(args: &Args) -> Result<(), Failure> {
    let (results, all) = (&args.results, args.experiments.is_empty());
    let asked = if all { finished::names(results) } else { args.experiments.clone() };
    if asked.is_empty() {
        return Err(LookupError::nothing_run(results).into());
    }
    let named = asked.iter().map(|asked| name_and_file(asked)).collect::<Result<Vec<_>, Failure>>()?;
    for (name, _) in &named {
        finished::folder(results, name)?;
    }
    // A run must not replace the results while they are read and their tables written.
    let _lock = lock_exclusive(results);
    let mut rendered = Vec::new();
    let done = named.iter().try_for_each(|(name, file)| {
        let mut results = finished::read(results, name)?;
        file.map_or(Ok(()), |file| results.present(file))?;
        let io = |e: ReportError| Failure::io(format!("{name}: {e}"));
        let rendered_aside = StagedReport::render(&results, &args.reports).map_err(io)?;
        file.map_or(Ok(()), |_| results.keep())?;
        let (index, written) = rendered_aside.publish(&args.reports).map_err(io)?;
        rendered.push((name.as_str(), args.reports.join(name), written.items));
        output::write(&format!("{}\n", index.display()))
    });
    // The page over all reports also lists those written before one that failed.
    let site = if args.reports.is_dir() { write_site(&args.reports) } else { Ok(()) };
    done.and(site)?;
    args.paper.as_ref().map_or(Ok(()), |folder| write_paper(folder, &args.only, &rendered))
}

/// Writes selected tables and figures of reports for a paper; all if `only` is empty.
fn write_paper(folder: &Path, only: &[String], rendered: &[Rendered<'_>]) -> Result<(), Failure> {
    let known = || rendered.iter().flat_map(|(.., items)| items).map(|item| item.name.as_str());
    if let Some(name) = only.iter().find(|name| !known().any(|known| known == *name)) {
        return Err(Failure::usage(format!("--only: {}", unknown("table or figure", name, known()))));
    }
    paper::write(rendered, only, folder).map_err(Failure::io)?;
    output::write(&format!("{}\n", folder.join(paper::DOCUMENT).display()))
}

/// Name of a requested experiment, and the file if it was requested by file.
fn name_and_file(asked: &str) -> Result<(String, Option<&Path>), Failure> {
    let path = Path::new(asked);
    if !path.is_file() && path.extension().is_none_or(|end| end != "toml") {
        return Ok((asked.to_string(), None));
    }
    Ok((name_of(path).map_err(Failure::usage)?, Some(path)))
}

/// Absent results count as a wrong argument, damaged ones as an I/O error, in all verbs.
impl From<ResultsError> for Failure {
    fn from(e: ResultsError) -> Self {
        let is_usage =
            matches!(e, ResultsError::Unfinished(_) | ResultsError::Unfit(_) | ResultsError::Spec(_));
        Self::new(if is_usage { Exit::Usage } else { Exit::Io }, e)
    }
}

impl From<LookupError> for Failure {
    fn from(e: LookupError) -> Self {
        Self::new(if e.is_unknown { Exit::Usage } else { Exit::Io }, e)
    }
}

/// Writes the page over all reports below a folder, and warns about each report that cannot be listed.
///
/// # Errors
/// `Io` when the page cannot be written.
pub fn write_site(reports: &Path) -> Result<(), Failure> {
    let warnings = report::site::write_index(reports).map_err(Failure::io)?;
    warnings.iter().for_each(|warning| output::note(&format!("warning: {warning}")));
    Ok(())
}
