//! Runs of one shard of an experiment, for several processes or machines.

use super::context::{Context, Options};
use super::judge::{self, ParameterSource, PendingCell, ReadyDetector};
use super::outcome::CellName;
use super::tracking;
use super::units::{Unit, frames_to_do, units};
use crate::error::{CellError, RunError};
use crate::observe::tally::Tally;
use crate::plan::{ExperimentPlan, Shard, variants};
use crate::spec::method::{DetectorChoice, Variant};
use crate::store::Store;
use rayon::prelude::*;

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

/// The detector of a variant that needs no training.
fn given(variant: &Variant) -> Option<ReadyDetector> {
    match &variant.detector {
        DetectorChoice::Given(fixed) => {
            Some(ReadyDetector { fixed: fixed.clone(), source: ParameterSource::Given })
        }
        DetectorChoice::Trained(_) | DetectorChoice::Learned(_) => None,
    }
}

/// Computes a shard of an experiment's tracks, signals and labels into the store. Trained methods are left to the run
/// that has all tracks.
///
/// # Errors
/// As [`run`](super::run::run).
pub fn run_shard(
    plan: &ExperimentPlan<'_>,
    store: &Store,
    options: &Options,
    shard: Shard,
) -> Result<ShardOutcome, RunError> {
    let units = units(plan, Some(shard));
    let context = Context::new(plan, store, options, frames_to_do(plan, store, options, &units));
    type Done = Vec<(CellName, Result<(), CellError>)>;
    let of_unit = |(suite, sequence, jobs): &Unit| -> Result<Done, RunError> {
        let planned = &plan.suites[*suite].sequences[*sequence];
        let tracks = tracking::tracks(&context, *suite, planned, jobs)?;
        let mut cells: Done = Vec::new();
        let mut pending = Vec::new();
        for (j, track) in jobs.iter().zip(&tracks) {
            let job = plan.jobs[*j];
            let before = cells.len();
            let of_track = || CellName::of_track(plan, *suite, planned, *j);
            for (v, (method, variant)) in variants(plan.experiment).enumerate().filter(|_| *suite == 0) {
                let Some(ready_detector) =
                    given(variant).filter(|_| plan.has_cells(job, method, &planned.origin.source))
                else {
                    continue;
                };
                let params = variant.params();
                let stored = plan.cell_name(&planned.sequence.name, job, &method.name, &params);
                let seed = plan.seed(&method.name, &params, &planned.sequence.name, job);
                let name = CellName { method: method.name.clone(), params, ..of_track() };
                match (plan.input(planned, *j, v), track) {
                    (Err(e), _) => cells.push((name, Err(e))),
                    (Ok(_), Err(e)) => cells.push((name, Err(e.clone()))),
                    (Ok(read), Ok(track)) => {
                        let of_method = (v, method);
                        let cell = PendingCell::new(
                            &context,
                            &stored,
                            (track, read),
                            of_method,
                            ready_detector,
                            seed,
                        );
                        pending.push((name, cell));
                    }
                }
            }
            let has_failed = |(_, result): &(CellName, Result<(), CellError>)| {
                result.as_ref().is_err_and(CellError::is_failure)
            };
            if !cells[before..].iter().any(has_failed) {
                let error = plan.failure(*suite, planned, *j, track.as_ref().err());
                cells.extend(error.map(|e| (of_track(), Err(e))));
            }
        }
        let (names, pending): (Vec<CellName>, Vec<PendingCell>) = pending.into_iter().unzip();
        let judged = judge::judge(&context, pending)?;
        cells.extend(names.into_iter().zip(judged.into_iter().map(|j| j.map(|_| ()))));
        Ok(cells)
    };
    let mut done: Vec<_> =
        units.par_iter().with_max_len(1).map(of_unit).collect::<Result<Vec<_>, RunError>>()?;
    let mut cells: Vec<_> = done.drain(..).flatten().collect();
    cells.sort_by(|a, b| a.0.cmp(&b.0));
    let done = cells.iter().filter(|(_, result)| result.is_ok()).count();
    let failed = cells.into_iter().filter_map(|(name, result)| Some((name, result.err()?)));
    let failed = failed.filter(|(_, e)| e.is_failure()).collect();
    context.costs.keep(plan, store);
    Ok(ShardOutcome { done, failed, tally: context.tally })
}
