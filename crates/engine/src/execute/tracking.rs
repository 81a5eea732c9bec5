//! Tracks and signals of one sequence: from the store, or computed in one pass.

use super::context::Context;
use super::pass::{PassOutput, Task, pass};
use super::reverse::Reversal;
use super::track::{Track, Tracks};
use crate::error::{CellError, RunError, StepError};
use crate::observe::tally::Work;
use crate::plan::{PlannedSequence, recipes};
use crate::spec::method::SignalChoice;
use crate::store::address::Recipe;
use crate::store::{self, Name, Record};
use std::sync::Arc;
use trackfail_core::region::Region;
use trackfail_judge::reader::columns;
use trackfail_methods::score::overlap;
use trackfail_methods::tracker::{Status, TrackerState};

/// Parts of a track that are known already.
struct CachedTrack {
    job: usize,
    recipe: Recipe,
    states: Option<Vec<TrackerState>>,
    signals: Vec<Option<Vec<f64>>>,
}

impl CachedTrack {
    /// Indices of the signals that are to be computed.
    fn missing(&self) -> impl Iterator<Item = usize> + '_ {
        (0..self.signals.len()).filter(|k| self.signals[*k].is_none())
    }

    fn is_complete(&self) -> bool {
        self.states.is_some() && self.missing().next().is_none()
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
    let mut found: Vec<_> = jobs.iter().map(|job| look(context, suite, planned, *job)).collect();
    for found in found.iter().flatten() {
        context.tally.add(Work::Tracks, found.states.is_some());
        let wanted =
            |(k, _): &(usize, &Option<Vec<f64>>)| context.plan.wants_signal(suite, planned, found.job, *k);
        let signals = found.signals.iter().enumerate().filter(wanted);
        signals.for_each(|(_, s)| context.tally.add(Work::Signals, s.is_some()));
    }
    if found.iter().flatten().any(|found| !found.is_complete()) {
        compute(context, suite, planned, &mut found)?;
    }
    Ok(found.into_iter().map(|found| Ok(Arc::new(track(context, planned, found?)))).collect())
}

/// The parts of a job's track that are in the store.
fn look(
    context: &Context<'_>,
    suite: usize,
    planned: &PlannedSequence,
    job: usize,
) -> Result<CachedTrack, CellError> {
    let plan = context.plan;
    let rows = planned.sequence.len();
    let recipe = planned.tracks[job].clone()?;
    let signal = |k: usize| {
        if !plan.wants_signal(suite, planned, job, k) {
            return Some(Vec::new());
        }
        let address = plan.signal_recipe(planned, job, k).ok()?.address();
        context
            .cached::<Vec<f64>>(&address, rows)
            .filter(|s| s.len() == rows * plan.signals[k].signal.width())
    };
    let states = context.cached::<Vec<TrackerState>>(&recipe.address(), rows);
    let states = states.filter(|s| s.len() == rows);
    let signals = (0..plan.signals.len()).map(signal).collect();
    Ok(CachedTrack { job, recipe, states, signals })
}

/// Completes the tracks in one pass.
fn compute(
    context: &Context<'_>,
    suite: usize,
    planned: &PlannedSequence,
    found: &mut [Result<CachedTrack, CellError>],
) -> Result<(), RunError> {
    let plan = context.plan;
    // Complete tracks take part as companions.
    let there: Vec<&CachedTrack> = found.iter().flatten().collect();
    let companion = |job: usize| {
        let label = plan.experiment.trackers[plan.jobs[job].tracker].label.as_str();
        (label, there.iter().position(|other| other.job == job))
    };
    let tasks = there.iter().map(|one| Task {
        run: context.tracker_run(&planned.sequence, plan.jobs[one.job]),
        states: one.states.as_deref(),
        signals: one.missing().map(|k| &plan.signals[k]).collect(),
        companions: plan.companions(planned, one.job).map(companion).collect(),
    });
    let tasks: Vec<Task<'_>> = tasks.collect();
    let outputs = pass(&tasks, &context.options.limits, &|| context.frame_done())?;
    let unchanged = unchanged(context, planned, &there);
    let mut records = Vec::new();
    for (slot, output) in found.iter_mut().filter(|found| found.is_ok()).zip(outputs) {
        if let Ok(one) = slot
            && !one.is_complete()
        {
            let output = unchanged.clone().and(output).map_err(StepError::from);
            let done = output.and_then(|output| complete(context, suite, planned, one, output, &mut records));
            if let Err(e) = StepError::settled(done)? {
                *slot = Err(e);
            }
        }
    }
    context.put(records)
}

/// Completes a track with the output of the pass, and adds new records for the store.
fn complete(
    context: &Context<'_>,
    suite: usize,
    planned: &PlannedSequence,
    found: &mut CachedTrack,
    output: PassOutput,
    records: &mut Vec<Record>,
) -> Result<(), StepError> {
    let plan = context.plan;
    let job = plan.jobs[found.job];
    let rows = planned.sequence.len();
    let name = Name {
        experiment: plan.experiment.name.clone(),
        cell: plan.track_name(suite, &planned.sequence.name, job),
    };
    if found.states.is_none() {
        context.costs.add_time(suite, job.tracker, output.spent);
        context.costs.add_frames(suite, job.tracker, rows);
        records.push(store::record(name.clone(), found.recipe.clone(), rows, &output.states)?);
        found.states = Some(output.states);
    }
    let missing: Vec<usize> = found.missing().collect();
    let mut failure = None;
    for (k, series) in missing.into_iter().zip(output.signals) {
        let name = Name { cell: format!("{}/{}", name.cell, plan.signals[k].kind), ..name.clone() };
        match series {
            Err(e) => failure = failure.or(Some(e)),
            Ok(series) => {
                if let Ok(recipe) = plan.signal_recipe(planned, found.job, k) {
                    records.push(store::record(name, recipe, rows, &series)?);
                }
                found.signals[k] = Some(series);
            }
        }
    }
    failure.map_or(Ok(()), |e| Err(e.into()))
}

/// Checks that the files which the pass has read still have the digests in the addresses.
fn unchanged(
    context: &Context<'_>,
    planned: &PlannedSequence,
    found: &[&CachedTrack],
) -> Result<(), CellError> {
    let plan = context.plan;
    let name = &planned.sequence.name;
    let changed = || CellError::Failed(format!("{name}: files changed while they were read; run again"));
    let digest = planned.sequence.digest_anew().map_err(|e| CellError::Failed(e.to_string()))?;
    if digest != planned.digest {
        return Err(changed());
    }
    let common = recipes::sequence(&planned.sequence, &digest)?;
    for found in found.iter().filter(|found| !found.is_complete()) {
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
    let repeats = |status| matches!(status, Status::Failed | Status::Skipped | Status::Repeated);
    let repeated = states.iter().filter(|s| repeats(s.status)).count();
    let confident = states.iter().any(|s| s.confidence.is_some());
    let by_value = |(series, choice): (Option<Vec<f64>>, &SignalChoice)| match choice.signal.width() {
        1 => series,
        width => series.map(|series| columns([(&series[..], width)]).concat()),
    };
    let signals = found.signals.into_iter().zip(plan.signals.iter()).filter_map(by_value);
    Track {
        regions,
        status: states.iter().map(|s| s.status).collect(),
        confidence: states.iter().filter(|_| confident).map(|s| s.confidence).collect(),
        error: overlap::errors(&states, &planned.sequence.truth),
        signals: signals.collect(),
        repeated,
        reversal,
    }
}
