//! `trackfail run --dry-run`: shows what a run would do, and how long it may take.

use super::{Args, print};
use crate::cli::Failure;
use crate::cli::output::{self, Format};
use crate::engine::execute::estimate::{Remaining, Standing};
use crate::engine::plan::{CellState, variants, why};
use crate::engine::store::Store;
use crate::engine::{ExperimentPlan, Shard};
use indicatif::HumanDuration;
use std::time::Duration;

/// Prints a summary of the work. With `--verbose`, also each cell with its state in the store and the reason.
/// CSV and JSON have the cells without the summary; with `--shard`, shares replace cells.
///
/// # Errors
/// When the store cannot be read, or stdout cannot be written to.
pub fn run(args: &Args, plan: &ExperimentPlan<'_>) -> Result<(), Failure> {
    let store = Store::open_read_only(&args.results).map_err(Failure::io)?;
    print::store_problems(&store);
    let standing = Standing::new(plan, &store);
    let is_table = args.format == Format::Table;
    if is_table {
        output::write(&summary(args, plan, &standing))?;
    }
    match args.shard {
        Some(shard) => shares(args, &standing, shard.of),
        None if is_table && !args.verbose => Ok(()),
        None => {
            output::write(if is_table { "\n" } else { "" })?;
            cells(args, plan, &standing, args.verbose.then(|| why(plan, &store)))
        }
    }
}

/// Summary of the work, in a few lines.
fn summary(args: &Args, plan: &ExperimentPlan<'_>, standing: &Standing<'_>) -> String {
    let experiment = plan.experiment;
    let left = standing.remaining(args.shard);
    let share = args.shard.map_or_else(String::new, |s| format!(" (share {} of {})", s.number, s.of));
    let mut lines = vec![format!("{}: {}{share}", experiment.name, experiment.title)];
    let mut line = |name: &str, text: String| lines.push(format!("  {name:<10}{text}"));
    for suite in &plan.suites {
        let roles = experiment.suites.iter().filter(|(_, name)| **name == suite.name);
        let roles: Vec<&str> = roles.map(|(role, _)| role.as_str()).collect();
        let (there, roles) = (suite.sequences.len(), roles.join(", "));
        line("data", format!("{there} of {} sequences of {} ({roles})", suite.wanted, suite.name));
    }
    let (all, at_hand) = (left.tracks, left.tracks_at_hand);
    let of_frames = if all > at_hand { format!(" ({} frames)", left.frames) } else { String::new() };
    line("tracks", format!("{all}: {} to compute{of_frames}, {at_hand} at hand", all - at_hand));
    let counts = CellState::ALL.iter().zip(left.cells);
    let counts: Vec<String> = counts.map(|(state, count)| format!("{count} {}", state.word())).collect();
    line("cells", format!("{}: {}", left.all_cells(), counts.join(", ")));
    let runs_on = |tracker: &str| experiment.analyses.iter().filter(|a| a.runs_on(tracker)).count();
    let analyses = match experiment.trackers.iter().map(|tracker| runs_on(&tracker.label)).sum::<usize>() {
        _ if args.shard.is_some() => {
            "none in a share; they are left to the run behind the shares".to_string()
        }
        0 => "none".to_string(),
        n => format!("{n}, each analysis on each of its trackers counted"),
    };
    line("analyses", analyses);
    let time = match left.seconds {
        _ if args.force => "all of it is computed again (--force)".to_string(),
        _ if left.is_done() && args.shard.is_none() && !plan.experiment.analyses.is_empty() => {
            "no track and no cell is left to compute; analyses that the store lacks come on top".to_string()
        }
        _ if left.is_done() => "nothing is left to compute".to_string(),
        Some(seconds) => format!(
            "about {} on {} threads for trackers and signals, as fast as they have been here; training and reverse runs \
             come on top",
            span(args, seconds),
            threads(args)
        ),
        None => "not known: not all of these trackers have been run here yet".to_string(),
    };
    line("time", time);
    lines.join("\n") + "\n"
}

/// Number of threads that a run would use.
fn threads(args: &Args) -> usize {
    let cores = || std::thread::available_parallelism().map_or(1, usize::from);
    args.jobs.map_or_else(cores, usize::from)
}

/// Time for work that takes `seconds` on one core, in words.
fn span(args: &Args, seconds: f64) -> String {
    let time = Duration::try_from_secs_f64(seconds / threads(args) as f64);
    time.map_or_else(|_| "an unknown time".to_string(), |time| HumanDuration(time).to_string())
}

/// Prints the state of each cell, and the reasons if they are given.
fn cells(
    args: &Args,
    plan: &ExperimentPlan<'_>,
    standing: &Standing<'_>,
    reasons: Option<Vec<String>>,
) -> Result<(), Failure> {
    let variants = variants(plan.experiment).map(|(method, variant)| (&method.name, variant.params()));
    let variants: Vec<(&String, String)> = variants.collect();
    let mut headings = vec!["sequence", "tracker", "run", "method", "params", "state"];
    headings.extend(reasons.as_ref().map(|_| "because"));
    let mut reasons = reasons.into_iter().flatten();
    let sequences = plan.test().sequences.iter().zip(&standing.states);
    let cells = sequences.flat_map(|(planned, states)| {
        let of_sequence = plan.cells_on(&planned.sequence.origin.source).into_iter().zip(states);
        of_sequence.map(|((job, variant), state)| (&planned.sequence.name, job, variant, state))
    });
    let rows = cells.map(|(sequence, job, variant, state)| {
        let (job, (method, params)) = (plan.jobs[job], &variants[variant]);
        let (tracker, run) = (&plan.experiment.trackers[job.tracker].label, job.run.to_string());
        let texts = [sequence, tracker, &run, *method, params].map(String::clone);
        texts.into_iter().chain([state.word().to_string()]).chain(reasons.next()).collect()
    });
    output::print(args.format, &headings, &rows.collect::<Vec<Vec<String>>>())
}

/// Prints each share of the work: if it is done, and how long the rest may take.
fn shares(args: &Args, standing: &Standing<'_>, of: u32) -> Result<(), Failure> {
    let all: Vec<Remaining> = (1..=of).map(|number| standing.remaining(Some(Shard { number, of }))).collect();
    let row = |(number, left): (u32, &Remaining)| {
        let state = match left {
            left if left.is_done() => "done",
            Remaining { tracks_at_hand: 0, cells: [0, ..], .. } => "to do",
            _ => "begun",
        };
        let time = match left.seconds {
            _ if left.is_done() => String::new(),
            Some(seconds) => span(args, seconds),
            None => "not known".to_string(),
        };
        let counts = [left.tracks, left.tracks_at_hand, left.all_cells(), left.cells[0]];
        let [tracks, at_hand, cells, cached] = counts.map(|n| n.to_string());
        vec![format!("{number}/{of}"), state.to_string(), tracks, at_hand, cells, cached, time]
    };
    let rows: Vec<Vec<String>> = (1..).zip(&all).map(row).collect();
    if args.format == Format::Table {
        let done = all.iter().filter(|left| left.is_done()).count();
        output::write(&format!("\n{done} of {of} shares are done\n"))?;
    }
    let headings = ["share", "state", "tracks", "at_hand", "cells", "cached", "time_left"];
    output::print(args.format, &headings, &rows)
}
