//! Output of `trackfail run`, and its exit code after the results are written.

use super::Args;
use crate::cli::output::{self, Format};
use crate::cli::{Exit, Failure};
use crate::engine::store::{self, Store};
use crate::engine::{Shard, ShardOutcome};
use crate::report::WrittenReport;
use crate::report::claims::{ClaimCounts, Finding};
use crate::results::manifest::FailedCell;
use crate::results::{self, Results, unfinished};
use crate::spec::Experiment;
use crate::table::render;
use std::path::Path;

/// Path of the leaderboard that comes with the repository, below its reports.
const LEADERBOARD: &str = "benchmark/leaderboard.html";

/// Most failed cells that are listed.
const MAX_LISTED: usize = 50;

/// Prints a line on stderr, unless the run is quiet.
pub fn note(args: &Args, line: &str) {
    if !args.quiet {
        output::note(line);
    }
}

/// Prints reports of damaged records in the store.
pub fn store_problems(store: &Store) {
    for problem in store.problems() {
        output::note(&format!("warning: {problem}"));
    }
}

/// Lines on cells without a result, grouped by reason; `rest` tells where to find those beyond the limit.
fn listed(failed: &[FailedCell], rest: &str) -> Vec<String> {
    let groups = unfinished::groups(failed);
    let word = |missing: bool| if missing { "not there" } else { "failed" };
    let line = groups.iter().take(MAX_LISTED).map(|group| format!("{}: {group}", word(group.missing)));
    let more = groups.len().saturating_sub(MAX_LISTED);
    let more = (more > 0).then(|| format!("without a result: {more} more{rest}"));
    line.chain(more).collect()
}

/// Number of results that are lacking, in words: `2 of 9 cells failed`, `1 track is not there`. `done` is the
/// number of cells with a result.
fn amount(failed: &[FailedCell], done: usize, missing: bool) -> String {
    let of = |kind: &str| failed.iter().filter(|cell| unfinished::what(cell) == kind).count();
    let (n, tracks, analyses) = (failed.len(), of("tracks"), of("analyses"));
    let of_tracks = if tracks == 1 { "1 track".to_string() } else { format!("{tracks} tracks") };
    let what = match n {
        n if tracks == n => of_tracks,
        1 if analyses == 1 => "1 analysis".to_string(),
        n if analyses == n => format!("{n} analyses"),
        _ if tracks > 0 => format!("{of_tracks} and what is made from them"),
        n => format!("{n} of {} cells", n + done),
    };
    match (missing, n == 1 && tracks + analyses == 1) {
        (false, _) => format!("{what} failed"),
        (true, true) => format!("{what} is not there"),
        (true, false) => format!("{what} are not there"),
    }
}

/// Message with the number of lacking results and their common reason, or the first one; `None` if none is
/// lacking.
fn message(failed: &[FailedCell], done: usize) -> Option<String> {
    let FailedCell { sequence, tracker, method, reason, missing, .. } = failed.first()?;
    let amount = amount(failed, done, *missing);
    Some(match unfinished::groups(failed).as_slice() {
        [same] if same.count > 1 && !same.missing => format!("{amount}: {} ({})", same.reason, same.cells),
        _ => {
            let mut place = vec![sequence.as_str(), tracker, method];
            place.retain(|part| !part.is_empty());
            format!("{amount}, the first: {}: {reason}", place.join(", "))
        }
    })
}

/// Ends a run or a share with `done` finished cells: success, or a failure that says why the results are
/// incomplete.
fn complete(args: &Args, name: &str, failed: &[FailedCell], done: usize) -> Result<(), Failure> {
    let (absent, broken): (Vec<FailedCell>, Vec<_>) = failed.iter().cloned().partition(|cell| cell.missing);
    let others = absent.iter().filter(|cell| unfinished::what(cell) == "cells").count();
    if let Some(broken) = message(&broken, done + others) {
        return Err(Failure::new(Exit::Cells, format!("{name}: {broken}")));
    }
    match message(&absent, done).filter(|_| !args.allow_missing) {
        Some(absent) => Err(Failure::data(format!("{name}: {absent}"))),
        None => Ok(()),
    }
}

/// Prints the result of a share.
///
/// # Errors
/// `Cells` if cells failed, `Data` if some lack data.
pub fn shard(args: &Args, experiment: &Experiment, shard: Shard, done: &ShardOutcome) -> Result<(), Failure> {
    let (name, Shard { number, of }) = (&experiment.name, shard);
    let told = format!("{} cells; run without --shard for the tables", done.done);
    note(args, &format!("{name}: {}\n{name}: share {number} of {of} is done: {told}", done.tally));
    let failed: Vec<FailedCell> = done.failed.iter().map(|(cell, e)| FailedCell::new(cell, e)).collect();
    listed(&failed, "").iter().for_each(|line| note(args, line));
    complete(args, name, &failed, done.done)
}

/// Prints the rows of `measures.csv`, with the name of the experiment as the first column.
pub fn measures(results: &Results, format: Format) -> Result<(), Failure> {
    let bytes = store::read(&results.folder.join(results::measures::FILE)).map_err(Failure::io)?;
    let (mut headings, mut rows) = results::texts_from_csv(bytes).map_err(Failure::io)?;
    headings.insert(0, "experiment".to_string());
    rows.iter_mut().for_each(|row| row.insert(0, results.experiment.name.clone()));
    let headings: Vec<&str> = headings.iter().map(String::as_str).collect();
    output::print(format, &headings, &rows)
}

/// Columns of a terminal that a summary fills, and most rows of its table.
const SCREEN: (usize, usize) = (100, 30);

/// Prints the verdict, the table behind it, the outcomes of claims, failed cells, and the paths of all
/// outputs.
pub fn summary(results: &Results, written: &WrittenReport, index: &Path) -> Result<(), Failure> {
    let ((width, height), failed) = (SCREEN, &results.manifest.cells_failed);
    let head = format!("{}: {}", results.experiment.name, results.experiment.title);
    let mut text = render::wrapped(&head, width) + "\n\n";
    if !written.verdict.is_empty() {
        text.push_str(&format!("{}\n\n", render::wrapped(&written.verdict, width)));
    }
    if let Some(table) = &written.answer {
        text.push_str(&format!("{}\n", render::plain(table, width, height)));
    }
    for (what, checks) in [("claims", false), ("checks of the arithmetic", true)] {
        let mine = written.findings.iter().filter(|f| f.is_check == checks);
        let words = ClaimCounts::of(mine.map(|f| f.outcome)).words();
        if !words.is_empty() {
            text.push_str(&format!("{what}: {words}\n"));
        }
    }
    let failed = listed(failed, ", see manifest.json");
    for line in unfinished::not_run(&results.manifest.not_run).into_iter().chain(failed) {
        text.push_str(&format!("{line}\n"));
    }
    text.push_str(&format!("\nresults: {}\nreport:  {}\n", results.folder.display(), index.display()));
    let leaderboard = index.ancestors().map(|folder| folder.join(LEADERBOARD)).find(|path| path.is_file());
    if let Some(path) = leaderboard {
        text.push_str(&format!("on real videos: {}\n", path.display()));
    }
    output::write(&text)
}

/// Ends a run whose results are written: success, or a failure that says why they are incomplete.
///
/// # Errors
/// `Cells`, `Data` or `Expectation`, by the first problem.
pub fn judge(args: &Args, results: &Results, findings: &[Finding]) -> Result<(), Failure> {
    let (name, manifest) = (&results.experiment.name, &results.manifest);
    complete(args, name, &manifest.cells_failed, manifest.cells_done)?;
    if !manifest.differing.is_empty() {
        let names = manifest.differing.join(", ");
        return Err(Failure::data(format!(
            "{name}: not the data that datasets.lock pins: {names} (results are written and say so; see `trackfail data verify`)"
        )));
    }
    match findings.iter().find(|f| f.required && !f.is_met) {
        Some(unmet) => {
            Err(Failure::new(Exit::Expectation, format!("{name}: required but not met: {}", unmet.text)))
        }
        None => Ok(()),
    }
}
