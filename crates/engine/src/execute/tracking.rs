//! Tracks and signals of one sequence, from the store or computed: in one pass, or in several if there are
//! many.

use super::context::Context;
use super::pass::{PassOutput, Task, pass};
use super::reverse::Reversal;
use super::track::{Track, Tracks};
use super::units::Unit;
use crate::error::{CellError, RunError, StepError};
use crate::plan::{ExperimentPlan, PlannedSequence, recipes};
use crate::spec::method::SignalChoice;
use crate::store::address::{Recipe, Stage};
use crate::store::{self, Record};
use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;
use trackfail_core::region::Region;
use trackfail_judge::reader::columns;
use trackfail_methods::score::overlap;
use trackfail_methods::signal::Reads;
use trackfail_methods::tracker::{Status, TrackerState};

/// Most tracks of a sequence that are computed at once. A tracker may be a program, with memory and files of
/// its own.
const MAX_AT_ONCE: usize = 64;

/// The parts of a track that are already known.
struct CachedTrack {
    job: usize,
    recipe: Recipe,
    states: Option<Vec<TrackerState>>,
    signals: Vec<Option<Vec<f64>>>,
    /// Signals that failed in this run.
    faults: BTreeMap<usize, CellError>,
}

impl CachedTrack {
    /// Indices of the signals that the track lacks. Without `all`, signals that read companions are left out.
    fn due(&self, plan: &ExperimentPlan<'_>, all: bool) -> Vec<usize> {
        let is_due = |k: &usize| {
            self.signals[*k].is_none()
                && !self.faults.contains_key(k)
                && (all || plan.signals[*k].signal.reads() != Reads::Companions)
        };
        (0..self.signals.len()).filter(is_due).collect()
    }

    /// True if a pass for these signals has work on the track.
    fn is_open(&self, due: &[usize]) -> bool {
        self.states.is_none() || !due.is_empty()
    }
}

/// Tracks of a unit, one place for each job of the plan. A failed track is an error in its place.
///
/// # Errors
/// When the run is interrupted or the store cannot be written to.
pub fn tracks(context: &Context<'_>, (suite, sequence, jobs): &Unit) -> Result<Tracks, RunError> {
    let plan = context.plan;
    let planned = &plan.suites[*suite].sequences[*sequence];
    let mut found: Vec<_> = jobs.iter().map(|job| look(context, planned, *job)).collect();
    for found in found.iter().flatten() {
        context.tally.add(Stage::Track, found.states.is_some());
        let wanted = |(k, _): &(usize, &Option<Vec<f64>>)| plan.wants_signal(planned, found.job, *k);
        let signals = found.signals.iter().enumerate().filter(wanted);
        signals.for_each(|(_, s)| context.tally.add(Stage::Signal, s.is_some()));
    }
    let is_open = |one: &&CachedTrack| one.is_open(&one.due(plan, false));
    if found.iter().flatten().filter(is_open).count() > MAX_AT_ONCE {
        for part in found.chunks_mut(MAX_AT_ONCE) {
            compute(context, planned, part, false)?;
        }
    }
    compute(context, planned, &mut found, true)?;
    let mut tracks = vec![Err(CellError::not_asked_for()); plan.jobs.len()];
    for (job, found) in jobs.iter().zip(found) {
        tracks[*job] = found.map(|found| Arc::new(track(context, planned, found)));
    }
    Ok(tracks)
}

/// Loads the parts of a job's track that are in the store.
fn look(context: &Context<'_>, planned: &PlannedSequence, job: usize) -> Result<CachedTrack, CellError> {
    let plan = context.plan;
    let rows = planned.sequence.len();
    let recipe = planned.tracks[job].clone()?;
    let signal = |k: usize| {
        if !plan.wants_signal(planned, job, k) {
            return Some(Vec::new());
        }
        let address = plan.signal_recipe(planned, job, k).ok()?.address();
        let series = context.cached::<Vec<f64>>(&address, rows);
        series.filter(|s| s.len() == rows * plan.signals[k].signal.width())
    };
    let states = context.cached::<Vec<TrackerState>>(&recipe.address(), rows);
    let states = states.filter(|s| s.len() == rows);
    let signals = (0..plan.signals.len()).map(signal).collect();
    Ok(CachedTrack { job, recipe, states, signals, faults: BTreeMap::new() })
}

/// Computes the missing parts of tracks in one pass. Without `all`, signals that read companions are left to
/// a later pass.
fn compute(
    context: &Context<'_>,
    planned: &PlannedSequence,
    found: &mut [Result<CachedTrack, CellError>],
    all: bool,
) -> Result<(), RunError> {
    let plan = context.plan;
    // Complete tracks take part as companions.
    let there: Vec<&CachedTrack> = found.iter().flatten().collect();
    let due: Vec<Vec<usize>> = there.iter().map(|one| one.due(plan, all)).collect();
    let open: Vec<&CachedTrack> =
        there.iter().zip(&due).filter(|(one, due)| one.is_open(due)).map(|(one, _)| *one).collect();
    if open.is_empty() {
        return Ok(());
    }
    let companion = |job: usize| {
        let label = plan.experiment.trackers[plan.jobs[job].tracker].label.as_str();
        (label, there.iter().position(|other| other.job == job))
    };
    let tasks = there.iter().zip(&due).map(|(one, due)| Task {
        run: context.tracker_run(&planned.sequence, plan.jobs[one.job]),
        states: one.states.as_deref(),
        signals: due.iter().map(|k| &plan.signals[*k]).collect(),
        companions: plan.companions(planned, one.job).map(companion).collect(),
    });
    let tasks: Vec<Task<'_>> = tasks.collect();
    let outputs = pass(&tasks, &context.options.limits, &|| context.frame_done())?;
    let signals: BTreeSet<usize> = due.iter().flatten().copied().collect();
    let unchanged = unchanged(context, planned, &open, &signals);
    let mut records = Vec::new();
    let slots = found.iter_mut().filter(|found| found.is_ok());
    for ((slot, due), output) in slots.zip(due).zip(outputs) {
        if let Ok(one) = slot
            && one.is_open(&due)
        {
            let output = unchanged.clone().and(output).map_err(StepError::from);
            let done = output.and_then(|output| complete(context, planned, one, &due, output, &mut records));
            if let Err(e) = StepError::settled(done)? {
                *slot = Err(e);
            }
        }
    }
    Ok(context.store.put(&records)?)
}

/// Adds the output of a pass to a track, for the signals `due`, and collects new records for the store.
fn complete(
    context: &Context<'_>,
    planned: &PlannedSequence,
    found: &mut CachedTrack,
    due: &[usize],
    output: PassOutput,
    records: &mut Vec<Record>,
) -> Result<(), StepError> {
    let plan = context.plan;
    let job = plan.jobs[found.job];
    let rows = planned.sequence.len();
    let track = plan.track_name(planned.suite, &planned.sequence.name, job);
    if found.states.is_none() {
        context.costs.add(planned.suite, job.tracker, output.spent, rows);
        records.push(store::record(plan.name(track.clone()), found.recipe.clone(), rows, &output.states)?);
        found.states = Some(output.states);
    }
    for (&k, series) in due.iter().zip(output.signals) {
        let name = plan.name(format!("{track}/{}", plan.signals[k].kind));
        match series {
            Err(e) => drop(found.faults.insert(k, e)),
            Ok(series) => {
                if let Ok(recipe) = plan.signal_recipe(planned, found.job, k) {
                    records.push(store::record(name, recipe, rows, &series)?);
                }
                found.signals[k] = Some(series);
            }
        }
    }
    Ok(())
}

/// Checks that the files read for these tracks and signals still have the digests in the addresses.
fn unchanged(
    context: &Context<'_>,
    planned: &PlannedSequence,
    found: &[&CachedTrack],
    signals: &BTreeSet<usize>,
) -> Result<(), CellError> {
    let plan = context.plan;
    let name = &planned.sequence.name;
    let changed = || CellError::Failed(format!("{name}: files changed while they were read; run again"));
    let digest = planned.sequence.digest_anew().map_err(|e| CellError::Failed(e.to_string()))?;
    if digest != planned.digest {
        return Err(changed());
    }
    let common = recipes::sequence(&planned.sequence, &digest)?;
    let roots = &context.options.data_roots;
    for &k in signals {
        let now = recipes::signal_files(&planned.sequence, &plan.signals[k], roots);
        if now.is_err() || now != planned.signal_files[k] {
            return Err(changed());
        }
    }
    for found in found {
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
        1 => series.unwrap_or_default(),
        width => series.map_or_else(Vec::new, |series| columns([(&series[..], width)]).concat()),
    };
    let signals = found.signals.into_iter().zip(plan.signals.iter()).map(by_value);
    Track {
        regions,
        status: states.iter().map(|s| s.status).collect(),
        confidence: states.iter().filter(|_| confident).map(|s| s.confidence).collect(),
        error: overlap::errors(&states, &planned.sequence.truth),
        signals: signals.collect(),
        faults: found.faults,
        repeated,
        reversal,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::execute::Options;
    use crate::testing::{experiment, with_plan};

    const METHODS: &str = r#"tracker = [{ name = "still", runs = RUNS }, { name = "ncc" }]

[[method]]
name = "given"
signal = { kind = "companion-overlap" }
detector = { kind = "level", below = 0.1 }
"#;

    /// Tracks and signals of the first run of `still` and the only run of `ncc` on a sequence; `still` has
    /// `runs` runs.
    fn first_and_last(runs: usize) -> [(Vec<Region>, Vec<Vec<f64>>); 2] {
        let text = experiment("synthetic-d1", &METHODS.replace("RUNS", &runs.to_string()));
        with_plan(&text, |plan, store| {
            let (options, unit) = (Options::default(), (0, 0, (0..plan.jobs.len()).collect()));
            let context = Context::new(plan, store, &options, std::slice::from_ref(&unit));
            let made: Vec<Arc<Track>> =
                tracks(&context, &unit).unwrap().into_iter().map(Result::unwrap).collect();
            assert_eq!(made.len(), runs + 1);
            [&made[0], &made[runs]].map(|track| (track.regions.clone(), track.signals.clone()))
        })
    }

    #[test]
    fn tracks_that_are_too_many_for_one_pass_have_the_same_companions() {
        assert_eq!(first_and_last(MAX_AT_ONCE + 6), first_and_last(2));
    }
}
