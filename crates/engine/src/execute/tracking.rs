//! Tracks and signals of one sequence: from the store, or computed in one pass.

use super::context::Context;
use super::pass::{Pass, PassOutput, Task, pass};
use super::reverse::Reversal;
use super::track::{Track, Tracks};
use crate::error::{CellError, RunError};
use crate::observe::tally::Work;
use crate::plan::{PlannedSequence, recipes};
use crate::region::Region;
use crate::score::overlap;
use crate::store::address::Recipe;
use crate::store::{self, Name};
use crate::tracker::{Status, TrackerState};
use std::sync::Arc;

/// Largest number of tracks in one pass, to limit memory.
const MAX_TASKS: usize = 64;

/// Parts of a track that the store already has.
struct CachedTrack {
    job: usize,
    recipe: Recipe,
    states: Option<Arc<Vec<TrackerState>>>,
    signals: Vec<Option<Vec<f64>>>,
}

impl CachedTrack {
    fn is_complete(&self) -> bool {
        self.states.is_some() && self.signals.iter().all(Option::is_some)
    }
}

/// Tracks of `jobs` on a sequence of a suite, in their order. A track that cannot be made is an error in its place.
///
/// # Errors
/// When the run is interrupted or the store cannot be written to.
pub fn tracks(
    context: &Context<'_>,
    suite: usize,
    planned: &PlannedSequence,
    jobs: &[usize],
) -> Result<Tracks, RunError> {
    let mut done = Vec::with_capacity(jobs.len());
    for jobs in jobs.chunks(MAX_TASKS) {
        done.extend(some_tracks(context, suite, planned, jobs)?);
    }
    Ok(done)
}

fn some_tracks(
    context: &Context<'_>,
    suite: usize,
    planned: &PlannedSequence,
    jobs: &[usize],
) -> Result<Tracks, RunError> {
    let plan = context.plan;
    let rows = planned.sequence.len();
    let look = |job: &usize| {
        let recipe = planned.tracks[*job].clone()?;
        let address = recipe.address();
        let signal = |(k, choice)| {
            if !plan.wants_signal(suite, planned, *job, k) {
                return Some(Vec::new());
            }
            let address = recipes::signal(address, choice).address();
            context.cached::<Vec<f64>>(&address, rows).filter(|s| s.len() == rows)
        };
        let states = context.cached::<Vec<TrackerState>>(&address, rows);
        let states = states.filter(|s| s.len() == rows).map(Arc::new);
        let signals = plan.signals.iter().enumerate().map(signal).collect();
        Ok(CachedTrack { job: *job, recipe, states, signals })
    };
    let mut found: Vec<Result<CachedTrack, CellError>> = jobs.iter().map(look).collect();
    let wanted: Vec<usize> =
        (0..found.len()).filter(|k| found[*k].as_ref().is_ok_and(|f| !f.is_complete())).collect();
    for found in found.iter().flatten() {
        context.tally.add(Work::Tracks, found.states.is_some());
        let wanted = |(k, _): &(usize, &Option<Vec<f64>>)| plan.wants_signal(suite, planned, found.job, *k);
        let signals = found.signals.iter().enumerate().filter(wanted);
        signals.for_each(|(_, s)| context.tally.add(Work::Signals, s.is_some()));
    }
    if !wanted.is_empty() {
        let task = |k: &usize| {
            let found = found[*k].as_ref().ok()?;
            Some(Task {
                run: context.tracker_run(&planned.sequence, plan.jobs[found.job]),
                states: found.states.clone(),
                signals: (0..found.signals.len()).filter(|s| found.signals[*s].is_none()).collect(),
            })
        };
        let one = Pass {
            sequence: planned.sequence.clone(),
            frames: context.frames.clone(),
            signals: plan.signals.clone(),
            tasks: wanted.iter().filter_map(task).collect(),
            on_frame: context.on_frame.clone(),
            cores: context.cores.clone(),
        };
        let mut outputs = pass(one, &context.options.limits)?;
        if let Err(e) = unchanged(context, planned, &wanted, &found) {
            outputs = outputs.into_iter().map(|_| Err(e.clone())).collect();
        }
        let mut records = Vec::new();
        for (k, output) in wanted.into_iter().zip(outputs) {
            let Ok(mut one) = std::mem::replace(&mut found[k], Err(CellError::Failed(String::new()))) else {
                continue;
            };
            found[k] = match output {
                Err(e) => Err(e),
                Ok(output) => {
                    complete(context, suite, planned, &mut one, output, &mut records)?;
                    Ok(one)
                }
            };
        }
        context.put(records)?;
    }
    Ok(found.into_iter().map(|found| Ok(Arc::new(track(context, planned, found?)))).collect())
}

/// Completes a cached track with the output of the pass, and adds new records for the store.
fn complete(
    context: &Context<'_>,
    suite: usize,
    planned: &PlannedSequence,
    found: &mut CachedTrack,
    output: PassOutput,
    records: &mut Vec<store::Record>,
) -> Result<(), RunError> {
    let plan = context.plan;
    let rows = planned.sequence.len();
    let name = Name {
        experiment: plan.experiment.name.clone(),
        cell: plan.track_name(suite, &planned.sequence.name, plan.jobs[found.job]),
    };
    if found.states.is_none() {
        records.push(store::record(name.clone(), found.recipe.clone(), rows, &*output.states)?);
        found.states = Some(output.states);
    }
    let address = found.recipe.address();
    let empty = found.signals.iter_mut().enumerate().filter(|(_, s)| s.is_none());
    for ((k, place), series) in empty.zip(output.signals) {
        let choice = &plan.signals[k];
        let name = Name { cell: format!("{}/{}", name.cell, choice.kind), ..name.clone() };
        records.push(store::record(name, recipes::signal(address, choice), rows, &series)?);
        *place = Some(series);
    }
    Ok(())
}

/// Checks that the files which the pass has read still have the digests in the addresses.
fn unchanged(
    context: &Context<'_>,
    planned: &PlannedSequence,
    wanted: &[usize],
    found: &[Result<CachedTrack, CellError>],
) -> Result<(), CellError> {
    let plan = context.plan;
    let name = &planned.sequence.name;
    let changed = || CellError::Failed(format!("{name}: files changed while they were read; run again"));
    let digest = planned.sequence.digest_anew().map_err(|e| CellError::Failed(e.to_string()))?;
    if digest != planned.digest {
        return Err(changed());
    }
    let common = recipes::sequence(&planned.sequence, &digest)?;
    for found in wanted.iter().filter_map(|k| found[*k].as_ref().ok()) {
        let roots = &context.options.data_roots;
        let now = recipes::track(plan.experiment, &planned.sequence, &common, plan.jobs[found.job], roots)?;
        if now != found.recipe {
            return Err(changed());
        }
    }
    Ok(())
}

fn track(context: &Context<'_>, planned: &PlannedSequence, found: CachedTrack) -> Track {
    let plan = context.plan;
    let states = found.states.unwrap_or_default();
    let regions: Vec<Region> = states.iter().map(|s| s.region.clone()).collect();
    let reversal = plan.needs_reverse().then(|| {
        let run = context.tracker_run(&planned.sequence, plan.jobs[found.job]);
        Arc::new(Reversal::new(run, regions.clone()))
    });
    let repeated = states.iter().filter(|s| matches!(s.status, Status::Failed | Status::Skipped)).count();
    Track {
        address: found.recipe.address(),
        regions,
        status: states.iter().map(|s| s.status).collect(),
        error: overlap::errors(&states, &planned.sequence.truth),
        signals: found.signals.into_iter().flatten().collect(),
        repeated,
        reversal,
    }
}
