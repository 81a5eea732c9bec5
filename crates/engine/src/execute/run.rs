//! Runs of whole experiments and of shards on all cores. The outcome depends neither on the number of cores nor on what
//! the store has: work is done in any order, but every result has its place and every seed is made from names.

use super::context::{Context, Options};
use super::judge::ReadyDetectors;
use super::outcome::{Cell, CellName, Outcome};
use super::track::Tracks;
use super::units::{Unit, for_units, frames_to_do, units};
use super::{analyse, judge, timing, tracking, train};
use crate::error::{CellError, RunError};
use crate::observe::tally::Tally;
use crate::plan::{self, ExperimentPlan, Shard};
use crate::spec::Experiment;
use crate::store::Store;
use rayon::prelude::*;
use std::collections::{BTreeMap, BTreeSet};
use trackfail_dataset::DatasetError;
use trackfail_dataset::suite::{Catalog, Loaded};

/// Loads the suites of an experiment, by role.
///
/// # Errors
/// When a suite has files that cannot be read.
pub fn load(
    experiment: &Experiment,
    data_roots: &[std::path::PathBuf],
) -> Result<BTreeMap<String, Loaded>, DatasetError> {
    plan::needed_roles(experiment)
        .into_iter()
        .map(|role| {
            Ok((role.to_string(), experiment.catalog.suite(&experiment.suites[role])?.load(data_roots)))
        })
        .collect()
}

/// Runs a planned experiment on the threads of the current pool. A cell that fails holds its error.
///
/// # Errors
/// When the run is interrupted or the store cannot be written to.
pub fn run<'s>(
    plan: &ExperimentPlan<'_>,
    store: &'s Store,
    options: &Options,
) -> Result<Outcome<'s>, RunError> {
    let units = units(plan, None);
    let context = Context::new(plan, store, options, frames_to_do(plan, store, options, &units));
    let mut tracks = tracks(&context, &units)?;
    let (ready, models) = train::make_ready(&context, &tracks)?;
    let mut found = analyse::analyse(&context, &tracks)?;
    let (cells, failed_tracks) = judge(&context, units, &tracks, &ready)?;
    found.extend(timing::measure(&context, &tracks, &ready)?);
    let mut analyses = Vec::new();
    let not_analysed =
        found.into_iter().filter_map(|one| one.map(|made| analyses.push(made)).err()).collect();
    context.costs.keep(plan, store);
    let mut digests = BTreeMap::new();
    for suite in &plan.suites {
        let names = suite.sequences.iter().map(|s| (s.sequence.name.clone(), s.digest.clone()));
        digests.insert(suite.name.clone(), names.collect());
    }
    let (test, tracks) = (plan.test(), tracks.swap_remove(0));
    Ok(Outcome {
        suite: test.name.clone(),
        rules: count_rules(plan, &tracks),
        differing: differing(&plan.experiment.catalog, &digests)?,
        sequences: test.sequences.iter().map(|s| s.sequence.clone()).collect(),
        sources: test.sequences.iter().map(|s| s.origin.source.clone()).collect(),
        missing: test.missing.clone(),
        wanted: test.wanted,
        tracks,
        jobs: plan.jobs.clone(),
        cells,
        failed_tracks,
        models,
        analyses,
        not_analysed,
        digests,
        tally: context.tally,
        store,
    })
}

/// Outcome of the run of a shard.
pub struct ShardOutcome {
    /// Number of cells with a result.
    pub done: usize,
    /// Cells without a result that were to be run, and tracks of which no cell of the share says that they failed, with the
    /// reason.
    pub failed: Vec<(CellName, CellError)>,
    /// Numbers of computed and cached results.
    pub tally: Tally,
}

/// Computes a shard of an experiment's tracks, signals and labels into the store. Trained methods and analyses are left to
/// the run that has all tracks.
///
/// # Errors
/// As [`run`].
pub fn run_shard(
    plan: &ExperimentPlan<'_>,
    store: &Store,
    options: &Options,
    shard: Shard,
) -> Result<ShardOutcome, RunError> {
    let units = units(plan, Some(shard));
    let context = Context::new(plan, store, options, frames_to_do(plan, store, options, &units));
    let tracks = tracks(&context, &units)?;
    let (cells, mut failed) = judge(&context, units, &tracks, &train::given(plan))?;
    context.costs.keep(plan, store);
    let done = cells.iter().filter(|cell| cell.result.is_ok()).count();
    let errors = cells.iter().filter_map(|cell| Some((cell, cell.result.as_ref().err()?)));
    let errors = errors.filter(|(_, e)| e.is_failure());
    failed.extend(errors.map(|(cell, e)| (CellName::of_cell(plan, cell), e.clone())));
    failed.sort_by(|a, b| a.0.cmp(&b.0));
    Ok(ShardOutcome { done, failed, tally: context.tally })
}

/// The tracks of all suites, suites x sequences x jobs; those of no unit are errors.
fn tracks(context: &Context<'_>, units: &[Unit]) -> Result<Vec<Vec<Tracks>>, RunError> {
    let plan = context.plan;
    let of_unit = |(suite, sequence, jobs): &Unit| {
        tracking::tracks(context, *suite, &plan.suites[*suite].sequences[*sequence], jobs)
    };
    let done: Vec<Tracks> = for_units(units, of_unit)?;
    let none: Tracks = vec![Err(CellError::Missing("not asked for".to_string())); plan.jobs.len()];
    let mut all: Vec<Vec<Tracks>> =
        plan.suites.iter().map(|suite| vec![none.clone(); suite.sequences.len()]).collect();
    for ((suite, sequence, jobs), of_unit) in units.iter().zip(done) {
        for (job, track) in jobs.iter().zip(of_unit) {
            all[*suite][*sequence][*job] = track;
        }
    }
    Ok(all)
}

type Failed = Vec<(CellName, CellError)>;

/// The cells of the units that have detectors, sequence by sequence, in the plan's order; and the tracks that failed, or lack
/// a signal that is read from them, unless a cell says so.
fn judge(
    context: &Context<'_>,
    mut units: Vec<Unit>,
    tracks: &[Vec<Tracks>],
    ready: &ReadyDetectors,
) -> Result<(Vec<Cell>, Failed), RunError> {
    let plan = context.plan;
    units.sort();
    let of_unit = |(_, s, jobs): &Unit| judge::cells(context, *s, jobs, &tracks[0][*s], ready);
    let cells = units.par_iter().filter(|(suite, ..)| *suite == 0).map(of_unit);
    let cells: Vec<Vec<Cell>> = cells.collect::<Result<_, RunError>>()?;
    let cells: Vec<Cell> = cells.into_iter().flatten().collect();
    let told: BTreeSet<(usize, usize)> =
        cells.iter().filter(|cell| cell.has_failed()).map(|cell| (cell.sequence, cell.job)).collect();
    let mut failed = Failed::new();
    for (suite, s, jobs) in units {
        let planned = &plan.suites[suite].sequences[s];
        for j in jobs.into_iter().filter(|j| suite != 0 || !told.contains(&(s, *j))) {
            let error = plan.failure(suite, planned, j, tracks[suite][s][j].as_ref().err());
            failed.extend(error.map(|error| (CellName::of_track(plan, (suite, s, j)), error)));
        }
    }
    Ok((cells, failed))
}

/// Sequences whose digests differ from those in datasets.lock.
fn differing(
    catalog: &Catalog,
    digests: &BTreeMap<String, Vec<(String, String)>>,
) -> Result<Vec<String>, DatasetError> {
    let mut all = Vec::new();
    for (suite, sequences) in digests {
        let known = catalog.suite(suite)?;
        let entries = known.entries();
        let pinned = |name: &str| entries.iter().find(|e| e.name == name).and_then(|e| e.digest.as_deref());
        let differs = |(name, digest): &&(String, String)| pinned(name).is_some_and(|p| p != digest);
        all.extend(sequences.iter().filter(differs).map(|(name, _)| format!("{suite}/{name}")));
    }
    Ok(all)
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
