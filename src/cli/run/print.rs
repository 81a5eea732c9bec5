//! Output of `trackfail run`, and the verb's exit after its results are written.

use super::Args;
use crate::cli::Failure;
use crate::cli::output::{self, Format};
use crate::engine::store::{self, Store};
use crate::engine::{CellError, Shard, ShardOutcome};
use crate::report::WrittenReport;
use crate::report::claims::{self, ClaimCounts, Finding};
use crate::results::manifest::FailedCell;
use crate::results::{self, Results, unfinished};
use crate::spec::Experiment;
use crate::table::render;
use std::path::Path;

/// Largest number of failed cells that are listed.
const MAX_LISTED: usize = 50;

/// Prints a line on stderr, unless the run is quiet.
pub fn note(args: &Args, line: &str) {
    if !args.quiet {
        output::note(line);
    }
}

/// Prints what is wrong with records of the store.
pub fn store_problems(store: &Store) {
    for problem in store.problems() {
        output::note(&format!("warning: {problem}"));
    }
}

/// Why a cell has no result, in one word or two.
fn without_result(missing: bool) -> &'static str {
    if missing { "not there" } else { "failed" }
}

/// A cell of a share without a result; its name is `sequence/tracker/run/method`, or that of a track.
fn of_share((cell, reason): &(String, CellError)) -> FailedCell {
    let mut parts = cell.rsplitn(4, '/').map(str::to_string);
    let (method, run, tracker) = (parts.next(), parts.next(), parts.next());
    FailedCell {
        sequence: parts.next().unwrap_or_default(),
        tracker: tracker.unwrap_or_default(),
        run: run.and_then(|run| run.parse().ok()).unwrap_or(0),
        method: method.unwrap_or_default(),
        missing: !matches!(reason, CellError::Failed(_)),
        reason: reason.to_string(),
    }
}

/// Prints what a share has computed.
///
/// # Errors
/// [`Failure::Cells`] if cells failed, [`Failure::Data`] if some have no data.
pub fn shard(args: &Args, experiment: &Experiment, shard: Shard, done: &ShardOutcome) -> Result<(), Failure> {
    let (name, Shard { number, of }) = (&experiment.name, shard);
    note(args, &format!("{name}: {}", done.tally));
    note(
        args,
        &format!(
            "{name}: share {number} of {of} is done: {} cells; run without --shard for the tables",
            done.done
        ),
    );
    let is_broken = |e: &CellError| matches!(e, CellError::Failed(_));
    let groups = unfinished::groups(&done.failed.iter().map(of_share).collect::<Vec<_>>());
    for group in groups.iter().take(MAX_LISTED) {
        note(args, &format!("{}: {group}", without_result(group.missing)));
    }
    let broken: Vec<&(String, CellError)> = done.failed.iter().filter(|(_, e)| is_broken(e)).collect();
    if let Some((cell, reason)) = broken.first() {
        let message = match groups.iter().find(|group| group.count == broken.len() && group.count > 1) {
            Some(all) => format!("{name}: {all}"),
            None => format!("{name}: {} cells failed, the first: {cell}: {reason}", broken.len()),
        };
        return Err(Failure::cells(message));
    }
    match done.failed.first().filter(|_| !args.allow_missing) {
        Some((cell, reason)) => {
            let cells = done.failed.len();
            Err(Failure::data(format!("{name}: {cells} cells are not there, the first: {cell}: {reason}")))
        }
        None => Ok(()),
    }
}

/// Prints the rows of `measures.csv`, each behind the name of the experiment.
pub fn measures(results: &Results, format: Format) -> Result<(), Failure> {
    let bytes = store::read(&results.folder.join(results::measures::FILE.name)).map_err(Failure::io)?;
    let (mut headings, mut rows) = results::texts_from_csv(bytes).map_err(Failure::io)?;
    headings.insert(0, "experiment".to_string());
    rows.iter_mut().for_each(|row| row.insert(0, results.experiment.name.clone()));
    let headings: Vec<&str> = headings.iter().map(String::as_str).collect();
    output::print(format, &headings, &rows)
}

/// Prints tables, claims and failed cells for reading, and where everything is.
pub fn summary(results: &Results, written: &WrittenReport, index: &Path) -> Result<(), Failure> {
    let mut text = format!("{}: {}\n\n", results.experiment.name, results.experiment.title);
    for layout in &written.tables {
        text.push_str(&render::plain(layout));
        text.push('\n');
    }
    for view in written.findings.iter().map(claims::view) {
        text.push_str(&format!("{}: {}\n", view.headline(), view.text));
    }
    for (what, checks) in [("claims", false), ("checks of the arithmetic", true)] {
        let mine = written.findings.iter().filter(|f| f.is_check == checks);
        let words = ClaimCounts::of(mine.map(Finding::overall)).words();
        if !words.is_empty() {
            text.push_str(&format!("{what}: {words}\n"));
        }
    }
    for line in unfinished::not_run(&results.manifest.not_run) {
        text.push_str(&line);
        text.push('\n');
    }
    let groups = unfinished::groups(&results.manifest.cells_failed);
    for group in groups.iter().take(MAX_LISTED) {
        text.push_str(&format!("{}: {group}\n", without_result(group.missing)));
    }
    if groups.len() > MAX_LISTED {
        text.push_str(&format!("without a result: {} more, see scores.csv\n", groups.len() - MAX_LISTED));
    }
    text.push_str(&format!("\nresults: {}\nreport:  {}\n", results.folder.display(), index.display()));
    output::write(&text)
}

/// Ends a run whose results are written: success, or why they are not complete.
///
/// # Errors
/// [`Failure::Cells`], [`Failure::Data`] or [`Failure::Expectation`].
pub fn judge(args: &Args, results: &Results, findings: &[Finding]) -> Result<(), Failure> {
    let name = &results.experiment.name;
    let (absent, broken): (Vec<&FailedCell>, Vec<_>) =
        results.manifest.cells_failed.iter().partition(|c| c.missing);
    let all = results.manifest.cells_done + absent.len() + broken.len();
    let message = |cells: &[&FailedCell], what: &str| {
        let first = cells.first()?;
        let FailedCell { sequence, tracker, method, reason, .. } = first;
        let owned: Vec<FailedCell> = cells.iter().map(|cell| (*cell).clone()).collect();
        Some(match unfinished::groups(&owned).as_slice() {
            [same] if same.count > 1 && !same.missing => {
                format!("{name}: {} of {all} cells {what}: {} ({})", cells.len(), same.reason, same.cells)
            }
            _ => {
                let place = format!("{sequence}, {tracker}, {method}: {reason}");
                format!("{name}: {} of {all} cells {what}, the first: {place}", cells.len())
            }
        })
    };
    if let Some(broken) = message(&broken, "failed") {
        return Err(Failure::cells(broken));
    }
    if let Some(absent) = message(&absent, "are not there").filter(|_| !args.allow_missing) {
        return Err(Failure::data(absent));
    }
    if !results.manifest.differing.is_empty() {
        let names = results.manifest.differing.join(", ");
        return Err(Failure::data(format!(
            "{}: not the data that datasets.lock pins: {names} (results are written and say so; see `trackfail data verify`)",
            results.experiment.name
        )));
    }
    if let Some(unmet) = findings.iter().find(|f| f.required && !f.is_met()) {
        let message = format!("{}: required but not met: {}", results.experiment.name, unmet.text);
        return Err(Failure::expectation(message));
    }
    Ok(())
}
