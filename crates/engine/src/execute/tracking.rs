//! Tracks and signals of one sequence: from the store, or computed in one pass.

use super::context::Context;
use super::lane::Companions;
use super::pass::{Pass, PassOutput, Task, pass};
use super::reverse::Reversal;
use super::track::{Track, Tracks};
use crate::error::{CellError, RunError};
use crate::observe::tally::Work;
use crate::plan::{PlannedSequence, recipes};
use crate::spec::method::SignalChoice;
use crate::store::address::Recipe;
use crate::store::{self, Name};
use std::collections::BTreeMap;
use std::sync::Arc;
use std::time::Duration;
use trackfail_core::region::Region;
use trackfail_judge::reader::columns;
use trackfail_methods::score::overlap;
use trackfail_methods::signal::Reads;
use trackfail_methods::tracker::{Status, TrackerState};

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
    /// Indices of the signals that are to be computed.
    fn missing(&self) -> impl Iterator<Item = usize> + '_ {
        (0..self.signals.len()).filter(|k| self.signals[*k].is_none())
    }

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
    let plan = context.plan;
    let mut found: Vec<_> = jobs.iter().map(|job| look(context, suite, planned, *job)).collect();
    for found in found.iter().flatten() {
        context.tally.add(Work::Tracks, found.states.is_some());
        let wanted = |(k, _): &(usize, &Option<Vec<f64>>)| plan.wants_signal(suite, planned, found.job, *k);
        let signals = found.signals.iter().enumerate().filter(wanted);
        signals.for_each(|(_, s)| context.tally.add(Work::Signals, s.is_some()));
    }
    // Signals that read companions come when the tracks of all of these are there.
    let after = |k: usize| plan.signals[k].signal.reads() == Reads::Companions;
    let lacks_track = |f: &CachedTrack| f.states.is_none() || f.missing().any(|k| !after(k));
    let first: Vec<usize> = positions(&found, lacks_track);
    for some in first.chunks(MAX_TASKS) {
        let task = |found: &CachedTrack| {
            Ok(Task {
                signals: found.missing().filter(|k| !after(*k)).collect(),
                ..bare_task(context, planned, found)
            })
        };
        compute(context, suite, planned, &mut found, some, task)?;
    }
    let second: Vec<usize> = positions(&found, |f| !f.is_complete());
    let states: BTreeMap<usize, Arc<Vec<TrackerState>>> =
        found.iter().flatten().filter_map(|f| Some((f.job, f.states.clone()?))).collect();
    for some in second.chunks(MAX_TASKS) {
        let task = |found: &CachedTrack| {
            let of = |job: usize| {
                let label = &plan.experiment.trackers[plan.jobs[job].tracker].label;
                let failed = || CellError::Failed(format!("there is no track of its companion {label}"));
                states.get(&job).cloned().ok_or_else(failed)
            };
            let companions = plan.companions(planned, found.job).map(of).collect::<Result<Vec<_>, _>>()?;
            let signals = found.missing().collect();
            Ok(Task { signals, companions: Arc::new(companions), ..bare_task(context, planned, found) })
        };
        compute(context, suite, planned, &mut found, some, task)?;
    }
    Ok(found.into_iter().map(|found| Ok(Arc::new(track(context, planned, found?)))).collect())
}

/// Indices of the tracks of which something is to be computed.
fn positions(
    found: &[Result<CachedTrack, CellError>],
    is_wanted: impl Fn(&CachedTrack) -> bool,
) -> Vec<usize> {
    (0..found.len()).filter(|k| found[*k].as_ref().is_ok_and(&is_wanted)).collect()
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
    let states = states.filter(|s| s.len() == rows).map(Arc::new);
    let signals = (0..plan.signals.len()).map(signal).collect();
    Ok(CachedTrack { job, recipe, states, signals })
}

/// The task of a track, without signals.
fn bare_task(context: &Context<'_>, planned: &PlannedSequence, found: &CachedTrack) -> Task {
    Task {
        run: context.tracker_run(&planned.sequence, context.plan.jobs[found.job]),
        states: found.states.clone(),
        signals: Vec::new(),
        companions: Companions::default(),
    }
}

/// Completes the tracks at the positions `wanted` in one pass, each by its task.
fn compute(
    context: &Context<'_>,
    suite: usize,
    planned: &PlannedSequence,
    found: &mut [Result<CachedTrack, CellError>],
    wanted: &[usize],
    task: impl Fn(&CachedTrack) -> Result<Task, CellError>,
) -> Result<(), RunError> {
    let mut tasks = Vec::new();
    let mut places = Vec::new();
    for &k in wanted {
        match found[k].as_ref().map_err(Clone::clone).and_then(&task) {
            Ok(task) => {
                tasks.push((task.signals.clone(), task));
                places.push(k);
            }
            Err(e) => found[k] = Err(e),
        }
    }
    let (signals, tasks): (Vec<Vec<usize>>, Vec<Task>) = tasks.into_iter().unzip();
    let tracker = |(k, task): (&usize, &Task)| {
        let job = found[*k].as_ref().ok().map(|found| found.job);
        job.filter(|_| task.states.is_none()).map(|job| context.plan.jobs[job].tracker)
    };
    let tracked: Vec<Option<usize>> = places.iter().zip(&tasks).map(tracker).collect();
    let one = Pass {
        sequence: planned.sequence.clone(),
        frames: context.frames.clone(),
        signals: context.plan.signals.clone(),
        tasks,
        on_frame: context.on_frame.clone(),
        spent: spent(context, suite, tracked.clone()),
        cores: context.cores.clone(),
    };
    let mut outputs = pass(one, &context.options.limits)?;
    for (tracker, _) in tracked.iter().zip(&outputs).filter(|(_, output)| output.is_ok()) {
        tracker.iter().for_each(|t| context.costs.add_frames(suite, *t, planned.sequence.len()));
    }
    if let Err(e) = unchanged(context, planned, &places, found) {
        outputs = outputs.into_iter().map(|_| Err(e.clone())).collect();
    }
    let mut records = Vec::new();
    for ((k, signals), output) in places.into_iter().zip(signals).zip(outputs) {
        let output = output.and_then(|output| {
            Ok((output, std::mem::replace(&mut found[k], Err(CellError::Failed(String::new())))?))
        });
        found[k] = match output {
            Err(e) => Err(e),
            Ok((output, mut one)) => {
                complete(context, suite, planned, &mut one, &signals, output, &mut records)?;
                Ok(one)
            }
        };
    }
    context.put(records)
}

/// Counts the time of each task whose tracker is run, and for each of them its part of the decoding.
fn spent(
    context: &Context<'_>,
    suite: usize,
    trackers: Vec<Option<usize>>,
) -> Arc<dyn Fn(usize, Duration) + Send + Sync> {
    let costs = context.costs.clone();
    Arc::new(move |lane, time| match trackers.get(lane) {
        Some(tracker) => tracker.iter().for_each(|t| costs.add_time(suite, *t, time)),
        None => {
            let part = time / u32::try_from(trackers.len().max(1)).unwrap_or(u32::MAX);
            trackers.iter().flatten().for_each(|t| costs.add_time(suite, *t, part));
        }
    })
}

/// Completes a cached track with the output of the pass, and adds new records for the store.
fn complete(
    context: &Context<'_>,
    suite: usize,
    planned: &PlannedSequence,
    found: &mut CachedTrack,
    signals: &[usize],
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
    for (&k, series) in signals.iter().zip(output.signals) {
        let name = Name { cell: format!("{}/{}", name.cell, plan.signals[k].kind), ..name.clone() };
        if let Ok(recipe) = plan.signal_recipe(planned, found.job, k) {
            records.push(store::record(name, recipe, rows, &series)?);
        }
        found.signals[k] = Some(series);
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
