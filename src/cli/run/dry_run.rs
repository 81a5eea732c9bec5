//! `trackfail run --dry-run`: what a run would do, and how long it may take.

use super::{Args, print};
use crate::cli::output::{self, Format, repeated, repeated::Column};
use crate::cli::{Failure, times};
use crate::engine::execute::estimate::{Remaining, Standing};
use crate::engine::observe::costs::Costs;
use crate::engine::plan::{CellState, PlannedCell, variants};
use crate::engine::store::{FOLDER, Store};
use crate::engine::{ExperimentPlan, Shard};

/// Prints a summary of the work, and with `--verbose` the cells of a plan and their states in the store; for programs, the
/// cells alone. With `--shard`, the shares instead of the cells.
///
/// # Errors
/// When the store cannot be read, or stdout cannot be written to.
pub fn run(args: &Args, plan: &ExperimentPlan<'_>) -> Result<(), Failure> {
    let store = Store::open_read_only(&args.results).map_err(Failure::io)?;
    print::store_problems(&store);
    let standing = Standing::new(plan, &store, Costs::read(&store));
    if args.format == Format::Table {
        output::write(&summary(args, plan, &standing))?;
    }
    if let Some(shard) = args.shard {
        return shares(args, plan, &standing, shard.of);
    }
    if args.format != Format::Table || args.verbose {
        if args.format == Format::Table {
            output::write("\n")?;
        }
        cells(args, plan, &standing)?;
    }
    Ok(())
}

/// The work in a few lines.
fn summary(args: &Args, plan: &ExperimentPlan<'_>, standing: &Standing<'_>) -> String {
    let experiment = plan.experiment;
    let left = standing.remaining(args.shard);
    let mut lines = vec![match args.shard {
        None => format!("{}: {}", experiment.name, experiment.title),
        Some(Shard { number, of }) => {
            format!("{}: {} (share {number} of {of})", experiment.name, experiment.title)
        }
    }];
    let mut line = |name: &str, text: String| lines.push(format!("  {name:<10}{text}"));
    for suite in &plan.suites {
        let there = suite.sequences.len();
        let roles: Vec<&str> = experiment
            .suites
            .iter()
            .filter(|(_, s)| **s == suite.name)
            .map(|(role, _)| role.as_str())
            .collect();
        line(
            "data",
            format!("{there} of {} sequences of {} ({})", suite.wanted, suite.name, roles.join(", ")),
        );
    }
    let to_compute = left.tracks - left.tracks_at_hand;
    let of_frames = if to_compute > 0 { format!(" ({} frames)", left.frames) } else { String::new() };
    line(
        "tracks",
        format!("{}: {to_compute} to compute{of_frames}, {} at hand", left.tracks, left.tracks_at_hand),
    );
    let counts =
        CellState::ALL.iter().zip(left.cells).map(|(state, count)| format!("{count} {}", state.word()));
    line("cells", format!("{}: {}", left.all_cells(), counts.collect::<Vec<_>>().join(", ")));
    let analyses: usize = experiment
        .analyses
        .iter()
        .map(|a| experiment.trackers.iter().filter(|tracker| a.runs_on(&tracker.label)).count())
        .sum();
    match args.shard {
        None if analyses == 0 => line("analyses", "none".to_string()),
        None => line("analyses", format!("{analyses}, each analysis on each of its trackers counted")),
        Some(_) => {
            line("analyses", "none in a share; they are left to the run behind the shares".to_string())
        }
    }
    let time = if args.force {
        "all of it is computed again (--force)".to_string()
    } else {
        time_left(&left, threads(args))
    };
    line("time", time);
    lines.join("\n") + "\n"
}

/// Number of threads that a run would have.
fn threads(args: &Args) -> usize {
    let cores = || std::thread::available_parallelism().map_or(1, usize::from);
    args.jobs.map_or_else(cores, usize::from)
}

/// How long the work may take, and what that rests on.
fn time_left(left: &Remaining, threads: usize) -> String {
    match left.seconds {
        _ if left.is_done() => "nothing is left to compute".to_string(),
        Some(seconds) => format!(
            "about {} on {threads} threads for trackers and signals, as fast as they have been here; training and reverse runs come on top",
            times::span(seconds / threads as f64)
        ),
        None => "not known: not all of these trackers have been run here yet".to_string(),
    }
}

/// The state of every cell.
fn cells(args: &Args, plan: &ExperimentPlan<'_>, standing: &Standing<'_>) -> Result<(), Failure> {
    let variants: Vec<_> = variants(plan.experiment).collect();
    let trackers = &plan.experiment.trackers;
    let runs = plan.jobs.iter().map(|job| job.run + 1).max().unwrap_or(0);
    let columns = [
        ("sequence", plan.test().sequences.iter().map(|s| s.sequence.name.clone()).collect()),
        ("tracker", trackers.iter().map(|t| t.label.clone()).collect()),
        ("run", (0..runs).map(|run| run.to_string()).collect()),
        ("method", variants.iter().map(|(method, _)| method.name.clone()).collect()),
        ("params", variants.iter().map(|(_, variant)| variant.params()).collect()),
        ("state", CellState::ALL.iter().map(|state| state.word().to_string()).collect()),
    ]
    .map(|(heading, values)| Column { heading, values });
    let row = |(cell, state): (PlannedCell, &CellState)| {
        let job = plan.jobs[cell.job];
        [cell.sequence, job.tracker, job.run as usize, cell.variant, cell.variant, *state as usize]
    };
    repeated::print(args.format, &columns, plan.cells().zip(&standing.states).map(row))
}

/// Every share of the work: whether it is done, and how long the rest of it may take. A share with a results folder of its
/// own, as `slurm --separate` gives it, is looked for there.
fn shares(args: &Args, plan: &ExperimentPlan<'_>, standing: &Standing<'_>, of: u32) -> Result<(), Failure> {
    let threads = threads(args);
    let mut rows = Vec::new();
    let mut done = 0;
    for number in 1..=of {
        let shard = Shard { number, of };
        let own = args.results.join("shards").join(number.to_string());
        let mut left = standing.remaining(Some(shard));
        if !left.is_done() && own.join(FOLDER).is_dir() {
            let store = Store::open_read_only(&own).map_err(Failure::io)?;
            left = Standing::new(plan, &store, Costs::read(&store)).remaining(Some(shard));
        }
        let state = match left {
            left if left.is_done() => "done",
            Remaining { tracks_at_hand: 0, cells: [0, ..], .. } => "to do",
            _ => "begun",
        };
        done += usize::from(left.is_done());
        let time = match left.seconds {
            _ if left.is_done() => String::new(),
            Some(seconds) => times::span(seconds / threads as f64),
            None => "not known".to_string(),
        };
        let [cached, ..] = left.cells;
        let counts = [left.tracks, left.tracks_at_hand, left.all_cells(), cached].map(|n| n.to_string());
        rows.push([vec![format!("{number}/{of}"), state.to_string()], counts.to_vec(), vec![time]].concat());
    }
    if args.format == Format::Table {
        output::write(&format!("\n{done} of {of} shares are done\n"))?;
    }
    let headings = ["share", "state", "tracks", "at_hand", "cells", "cached", "time_left"];
    output::print(args.format, &headings, &rows)
}
