//! Runs of whole experiments and of shards on all cores. The outcome depends neither on the number of cores
//! nor on what the store has: work is done in any order, but each result has a fixed place and each seed is
//! made from names.

use super::context::{Context, Options};
use super::judge::ReadyDetectors;
use super::outcome::{Cell, CellName, Outcome};
use super::track::Tracks;
use super::units::{Unit, for_units, units};
use super::{analyse, judge, timing, tracking, train};
use crate::error::{CellError, RunError};
use crate::observe::tally::Tally;
use crate::plan::{self, ExperimentPlan, PlannedSuite, Shard};
use crate::spec::Experiment;
use crate::store::Store;
use rayon::prelude::*;
use std::collections::{BTreeMap, BTreeSet};
use trackfail_dataset::DatasetError;
use trackfail_dataset::suite::Loaded;

/// Loads the suites of an experiment, by role.
///
/// # Errors
/// When a suite has files that cannot be read.
pub fn load(
    experiment: &Experiment,
    data_roots: &[std::path::PathBuf],
) -> Result<BTreeMap<String, Loaded>, DatasetError> {
    let load = |role: &str| {
        let suite = experiment.catalog.suite(&experiment.suites[role])?;
        Ok((role.to_string(), suite.load(data_roots)))
    };
    plan::needed_roles(experiment).into_iter().map(load).collect()
}

/// Runs a planned experiment on the threads of the current pool. A failed cell holds its error.
///
/// # Errors
/// When the run is interrupted or the store cannot be written to.
pub fn run<'s>(
    plan: &'s ExperimentPlan<'s>,
    store: &'s Store,
    options: &Options,
) -> Result<Outcome<'s>, RunError> {
    let mut units = units(plan, None);
    let context = Context::new(plan, store, options, &units);
    let none: Tracks = vec![Err(CellError::not_asked_for()); plan.jobs.len()];
    let mut tracks: Vec<Vec<Tracks>> =
        plan.suites.iter().map(|suite| vec![none.clone(); suite.sequences.len()]).collect();
    let done = for_units(&units, |unit| tracking::tracks(&context, unit))?;
    for ((suite, sequence, _), of_unit) in units.iter().zip(done) {
        tracks[*suite][*sequence] = of_unit;
    }
    let (ready, models) = train::make_ready(&context, &tracks)?;
    let mut found = analyse::analyse(&context, &tracks)?;
    units.sort();
    let of_unit = |unit: &Unit| judge(&context, unit, &tracks[unit.0][unit.1], &ready);
    let judged = units.par_iter().map(of_unit).collect::<Result<Vec<_>, RunError>>()?;
    let (cells, failed_tracks): (Vec<Vec<Cell>>, Vec<Failed>) = judged.into_iter().unzip();
    found.extend(timing::measure(&context, &tracks, &ready)?);
    let mut analyses = Vec::new();
    let not_analysed =
        found.into_iter().filter_map(|one| one.map(|made| analyses.push(made)).err()).collect();
    context.costs.keep(plan, store);
    let tracks = tracks.swap_remove(0);
    Ok(Outcome {
        plan,
        rules: count_rules(plan, &tracks),
        differing: differing(plan),
        tracks,
        cells: cells.into_iter().flatten().collect(),
        failed_tracks: failed_tracks.concat(),
        models,
        analyses,
        not_analysed,
        tally: context.tally,
        store,
    })
}

/// Outcome of the run of one shard.
pub struct ShardOutcome {
    /// Number of cells with a result.
    pub done: usize,
    /// Cells that were to be run and have no result, with the reason. Tracks are listed if no cell of the
    /// shard reports their failure.
    pub failed: Vec<(CellName, CellError)>,
    /// Numbers of computed and cached results.
    pub tally: Tally,
}

/// Computes the tracks, signals and labels of a shard into the store. Trained methods and analyses need all
/// tracks and are left to the final run.
///
/// # Errors
/// The errors of [`run`].
pub fn run_shard(
    plan: &ExperimentPlan<'_>,
    store: &Store,
    options: &Options,
    shard: Shard,
) -> Result<ShardOutcome, RunError> {
    let (units, ready) = (units(plan, Some(shard)), train::given(plan));
    let context = Context::new(plan, store, options, &units);
    let of_unit = |unit: &Unit| -> Result<(usize, Failed), RunError> {
        let tracks = tracking::tracks(&context, unit)?;
        let (cells, mut failed) = judge(&context, unit, &tracks, &ready)?;
        let errors = cells.iter().filter_map(|cell| Some((cell, cell.result.as_ref().err()?)));
        let errors = errors.filter(|(_, e)| e.is_failure());
        failed.extend(errors.map(|(cell, e)| (CellName::of_cell(plan, cell), e.clone())));
        Ok((cells.iter().filter(|cell| cell.result.is_ok()).count(), failed))
    };
    let done: Vec<(usize, Failed)> = for_units(&units, of_unit)?;
    context.costs.keep(plan, store);
    let (done, failed): (Vec<usize>, Vec<Failed>) = done.into_iter().unzip();
    let mut failed = failed.concat();
    failed.sort_by(|a, b| a.0.cmp(&b.0));
    Ok(ShardOutcome { done: done.iter().sum(), failed, tally: context.tally })
}

type Failed = Vec<(CellName, CellError)>;

/// Cells of a unit in the plan's order, and its tracks that failed or lack a needed signal. Tracks whose
/// failure a cell reports are left out.
fn judge(
    context: &Context<'_>,
    (suite, sequence, jobs): &Unit,
    tracks: &Tracks,
    ready: &ReadyDetectors,
) -> Result<(Vec<Cell>, Failed), RunError> {
    let (plan, suite, s) = (context.plan, *suite, *sequence);
    let cells = if suite == 0 { judge::cells(context, s, jobs, tracks, ready)? } else { Vec::new() };
    let told: BTreeSet<usize> = cells.iter().filter(|cell| cell.has_failed()).map(|cell| cell.job).collect();
    let planned = &plan.suites[suite].sequences[s];
    let mut failed = Failed::new();
    for &j in jobs.iter().filter(|j| !told.contains(j)) {
        let error = plan.failure(planned, j, tracks[j].as_ref().err());
        failed.extend(error.map(|error| (CellName::of_track(plan, (suite, s, j)), error)));
    }
    Ok((cells, failed))
}

/// Sequences whose digest differs from that in datasets.lock, as `suite/name`.
fn differing(plan: &ExperimentPlan<'_>) -> Vec<String> {
    let suites: BTreeMap<&str, &PlannedSuite> =
        plan.suites.iter().map(|suite| (suite.name.as_str(), suite)).collect();
    let mut all = Vec::new();
    for (suite, planned) in suites {
        let Ok(known) = plan.experiment.catalog.suite(suite) else { continue };
        for planned in &planned.sequences {
            let name = &planned.sequence.name;
            let entry = known.entries().iter().find(|entry| entry.name == *name);
            let pinned = entry.and_then(|entry| entry.digest.as_deref());
            if pinned.is_some_and(|pinned| pinned != planned.digest) {
                all.push(format!("{suite}/{name}"));
            }
        }
    }
    all
}

fn count_rules(plan: &ExperimentPlan<'_>, tracks: &[Tracks]) -> BTreeMap<String, u64> {
    let truths = plan.test().sequences.iter().flat_map(|planned| &planned.sequence.truth);
    let unknown = truths.filter(|region| region.is_none()).count() as u64;
    let rule = "frames without ground truth, which keep the state before them".to_string();
    let mut rules = BTreeMap::from([(rule, unknown)]);
    for (job, track) in tracks.iter().flat_map(|of_sequence| plan.jobs.iter().zip(of_sequence)) {
        let tracker = &plan.experiment.trackers[job.tracker];
        if let Ok(track) = track
            && job.run < tracker.runs
        {
            let rule = "frames marked failed or skipped, whose last region is repeated";
            *rules.entry(format!("{}: {rule}", tracker.label)).or_insert(0) += track.repeated as u64;
        }
    }
    rules.retain(|_, times| *times > 0);
    rules
}
