//! Runs of whole experiments on all cores. The outcome depends neither on the number of cores nor on what the store
//! has: work is done in any order, but every result has its place and every seed is made from names.

use super::analyse;
use super::context::{Context, Options};
use super::judge::{self, PendingCell};
use super::outcome::{Cell, CellName, Outcome};
use super::timing;
use super::track::Tracks;
use super::tracking;
use super::train::{self, ReadyDetectors};
use super::units::{Unit, frames_to_do, units};
use crate::error::{CellError, RunError};
use crate::plan::{self, ExperimentPlan, Job, variants};
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
    let of_unit = |(suite, sequence, jobs): &Unit| {
        let planned = &plan.suites[*suite].sequences[*sequence];
        let not_wanted = || Err(CellError::Missing("not asked for".to_string()));
        let mut row: Tracks = plan.jobs.iter().map(|_| not_wanted()).collect();
        for (j, track) in jobs.iter().zip(tracking::tracks(&context, *suite, planned, jobs)?) {
            row[*j] = track;
        }
        Ok((*suite, *sequence, row))
    };
    let mut done: Vec<_> = units.par_iter().with_max_len(1).map(of_unit).collect::<Result<_, RunError>>()?;
    done.sort_by_key(|(suite, sequence, _)| (*suite, *sequence));
    let mut tracks: Vec<Vec<Tracks>> = plan.suites.iter().map(|_| Vec::new()).collect();
    for (suite, _, of_sequence) in done {
        tracks[suite].push(of_sequence);
    }
    let (ready, models) = train::make_ready(&context, &tracks)?;
    let mut found = analyse::analyse(&context, &tracks)?;
    let test = plan.test();
    let judged =
        (0..test.sequences.len()).into_par_iter().map(|s| judge_sequence(&context, s, &tracks[0][s], &ready));
    let cells: Vec<Cell> = judged.collect::<Result<Vec<_>, RunError>>()?.into_iter().flatten().collect();
    let failed_tracks = failed_tracks(plan, &tracks, &cells);
    found.extend(timing::measure(&context, &tracks, &ready)?);
    let (mut analyses, mut not_analysed) = (Vec::new(), Vec::new());
    for analysed in found {
        match analysed {
            Ok(analysed) => analyses.push(analysed),
            Err(failed) => not_analysed.push(failed),
        }
    }
    let tracks = tracks.swap_remove(0);
    context.costs.keep(plan, store);
    let mut digests = BTreeMap::new();
    for suite in &plan.suites {
        let names = suite.sequences.iter().map(|s| (s.sequence.name.clone(), s.digest.clone()));
        digests.insert(suite.name.clone(), names.collect());
    }
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

/// The tracks of all suites that failed, or lack a signal that is read from them, unless a cell says so.
fn failed_tracks(
    plan: &ExperimentPlan<'_>,
    tracks: &[Vec<Tracks>],
    cells: &[Cell],
) -> Vec<(CellName, CellError)> {
    let told: BTreeSet<(usize, usize)> =
        cells.iter().filter(|cell| cell.has_failed()).map(|cell| (cell.sequence, cell.job)).collect();
    let mut failed = Vec::new();
    for (suite, planned_suite) in plan.suites.iter().enumerate() {
        for (s, planned) in planned_suite.sequences.iter().enumerate() {
            for j in (0..plan.jobs.len()).filter(|j| plan.wants(suite, *j)) {
                let is_told = suite == 0 && told.contains(&(s, j));
                let error = plan.failure(suite, planned, j, tracks[suite][s][j].as_ref().err());
                let named = |error| (CellName::of_track(plan, suite, planned, j), error);
                failed.extend(error.filter(|_| !is_told).map(named));
            }
        }
    }
    failed
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
    let mut rules = BTreeMap::new();
    let mut count = |rule: String, times: usize| {
        if times > 0 {
            *rules.entry(rule).or_insert(0) += times as u64;
        }
    };
    for planned in &plan.test().sequences {
        let unknown = planned.sequence.truth.iter().filter(|r| r.is_none()).count();
        count("frames without ground truth, which keep the state before them".into(), unknown);
    }
    let shown = |job: &Job| job.run < plan.experiment.trackers[job.tracker].runs;
    let tracks = tracks.iter().flat_map(|t| plan.jobs.iter().zip(t));
    for (job, track) in tracks.filter(|(job, _)| shown(job)) {
        let repeated = track.as_ref().map_or(0, |t| t.repeated);
        let label = &plan.experiment.trackers[job.tracker].label;
        count(format!("{label}: frames marked failed or skipped, whose last region is repeated"), repeated);
    }
    rules
}

fn judge_sequence(
    context: &Context<'_>,
    index: usize,
    tracks: &Tracks,
    ready: &ReadyDetectors,
) -> Result<Vec<Cell>, RunError> {
    let plan = context.plan;
    let planned = &plan.test().sequences[index];
    let sequence = &planned.sequence;
    let mut cells: Vec<Cell> = Vec::new();
    let mut pending: Vec<(usize, PendingCell)> = Vec::new();
    let variants: Vec<_> = variants(plan.experiment).collect();
    for (j, v) in plan.cells_on(&planned.origin.source) {
        let (job, (method, variant)) = (plan.jobs[j], variants[v]);
        let params = variant.params();
        let ready_detector = &ready[v][job.tracker][plan.part(variant, index)];
        let result = match (plan.input(planned, j, v), &tracks[j], ready_detector) {
            (Err(e), ..) => Err(e),
            (Ok(_), Err(e), _) | (Ok(_), _, Err(e)) => Err(e.clone()),
            (Ok(read), Ok(track), Ok(ready_detector)) => {
                let name = plan.cell_name(&sequence.name, job, &method.name, &params);
                let seed = plan.seed(&method.name, &params, &sequence.name, job);
                pending.push((
                    cells.len(),
                    PendingCell::new(
                        context,
                        &name,
                        (track, read),
                        (v, method),
                        ready_detector.clone(),
                        seed,
                    ),
                ));
                // Replaced below.
                Err(CellError::Missing(String::new()))
            }
        };
        cells.push(Cell {
            sequence: index,
            tracker: plan.experiment.trackers[job.tracker].label.clone(),
            run: job.run,
            method: method.name.clone(),
            params,
            job: j,
            signal: plan.signal(v),
            threshold: ready_detector.as_ref().ok().and_then(|a| a.fixed.detector.threshold()),
            result,
        });
    }
    let (places, pending): (Vec<_>, Vec<_>) = pending.into_iter().unzip();
    for (place, judged) in places.into_iter().zip(judge::judge(context, pending)?) {
        cells[place].result = judged;
    }
    Ok(cells)
}
