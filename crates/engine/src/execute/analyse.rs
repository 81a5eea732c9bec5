//! Analyses of an experiment, each on every tracker: from the store, or computed.

use super::context::Context;
use super::supervise::run_single;
use super::track::{Track, Tracks};
use crate::error::{CellError, RunError, StepError};
use crate::plan::{ExperimentPlan, PlannedSuite, signal_index};
use crate::spec::analysis::Analysis;
use crate::spec::{Experiment, Tracker};
use crate::store;
use crate::store::address::{Recipe, Stage};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};
use std::collections::BTreeSet;
use std::sync::Arc;
use trackfail_core::num::hexadecimal;
use trackfail_dataset::{DatasetError, Sequence};
use trackfail_methods::analysis::{Findings, Population, Reads};
use trackfail_methods::score::overlap::OVERLAP;
use trackfail_methods::score::trajectory::Trajectory;
use trackfail_methods::signal::confidence;

/// Result of an analysis on one tracker.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Analysed {
    /// Name of the analysis in the experiment.
    pub analysis: String,
    /// Label of the tracker.
    pub tracker: String,
    /// Repetitions of the tracker that were analyzed.
    pub runs: u32,
    /// Suites in the order of the analysis, each with the number of its sequences that were analyzed.
    pub suites: Vec<(String, usize)>,
    /// For each suite: the number of sequences that the tracker has tracks of, and of all present ones. Empty
    /// if all were analyzed.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub shares: Vec<(usize, usize)>,
    /// Tables, charts and numbers that the analysis computed.
    pub findings: Findings,
}

/// An analysis that could not be computed for a tracker.
#[derive(Debug)]
pub struct NotAnalysed {
    /// Name of the analysis in the experiment.
    pub analysis: String,
    /// Label of the tracker.
    pub tracker: String,
    /// Reason of the failure.
    pub error: CellError,
}

/// Results of analyses. A failed analysis is an error in its place.
pub type Analyses = Vec<Result<Analysed, NotAnalysed>>;

/// Findings of an analysis on one tracker, with its [suites](Analysed::suites) and
/// [shares](Analysed::shares).
pub(super) type Made = (Vec<(String, usize)>, Vec<(usize, usize)>, Findings);

/// Indices of analyses and their trackers, in the order of the experiment. With `of_clock` only analyses of
/// processing time, otherwise only the others.
pub(super) fn pairs(experiment: &Experiment, of_clock: bool) -> Vec<(usize, usize)> {
    let of_analysis = |(a, analysis): (usize, &Analysis)| {
        let trackers = experiment.trackers.iter().enumerate();
        let mine = trackers.filter(|(_, tracker)| analysis.runs_on(&tracker.label));
        mine.map(|(t, _)| (a, t)).collect::<Vec<_>>()
    };
    let analyses = experiment.analyses.iter().enumerate();
    analyses.filter(|(_, a)| (a.plugin.reads() == Reads::Clock) == of_clock).flat_map(of_analysis).collect()
}

/// Result of an analysis on a tracker as it is reported, with errors that end the run split off.
pub(super) fn analysed(
    experiment: &Experiment,
    (a, t): (usize, usize),
    made: Result<Made, StepError>,
) -> Result<Result<Analysed, NotAnalysed>, RunError> {
    let (analysis, tracker) = (&experiment.analyses[a], &experiment.trackers[t]);
    let (analysis, runs, tracker) = (analysis.name.clone(), analysis.runs(0, tracker), tracker.label.clone());
    Ok(match StepError::settled(made)? {
        Err(error) => Err(NotAnalysed { analysis, tracker, error }),
        Ok((suites, mut shares, findings)) => {
            if suites.iter().zip(&shares).all(|((_, made_on), (_, there))| made_on == there) {
                shares.clear();
            }
            Ok(Analysed { analysis, tracker, runs, suites, shares, findings })
        }
    })
}

/// A track in the form that tracking protocols read. Confidence is included only if the analysis reads it.
///
/// # Errors
/// When the size of the frames cannot be read.
fn trajectory<'t>(
    (track, sequence, run): &'t (Arc<Track>, &Sequence, u32),
    over_confidence: bool,
) -> Result<Trajectory<'t>, DatasetError> {
    Ok(Trajectory {
        sequence: &sequence.name,
        run: *run,
        regions: &track.regions,
        status: &track.status,
        truth: &sequence.truth,
        confidence: if over_confidence { track.confidence.as_slice() } else { &[] },
        frame: sequence.has_frames().then(|| sequence.size()).transpose()?,
        attributes: &sequence.attributes,
        frame_attributes: &sequence.frame_attributes,
    })
}

/// Digest of a sequence's attributes, which the addresses of its tracks do not cover.
fn attributes_digest(sequence: &Sequence) -> String {
    let text = serde_json::to_vec(&(&sequence.attributes, &sequence.frame_attributes)).unwrap_or_default();
    hexadecimal(&Sha256::digest(text)[..8])
}

/// The suites of an analysis with the sequences that a tracker can be analyzed on.
type Usable = Result<Vec<(usize, BTreeSet<usize>)>, CellError>;

/// The suite of a role with the sequences on which a tracker has the tracks of all runs that an analysis reads.
///
/// # Errors
/// Reason why there is no such sequence: an unmet need, else the first failure.
fn usable(
    plan: &ExperimentPlan<'_>,
    tracks: &[Vec<Tracks>],
    role: &str,
    (tracker, runs): (usize, u32),
    signal: Option<usize>,
) -> Result<(usize, BTreeSet<usize>), CellError> {
    let no_suite = || CellError::Missing(format!("no suite in role `{role}`"));
    let suite = plan.suite(role).ok_or_else(no_suite)?;
    let (mut usable, mut lacks) = (BTreeSet::new(), Vec::new());
    for (s, planned) in plan.suites[suite].sequences.iter().enumerate() {
        let lack = |j: usize| {
            let track = tracks[suite][s][j].as_ref().map_err(CellError::clone);
            let checked = track.and_then(|track| track.check(signal.as_slice()));
            checked.err().or_else(|| plan.unmet(planned, j, signal))
        };
        let before = lacks.len();
        lacks.extend(plan.jobs_of(tracker, runs).filter_map(lack));
        if lacks.len() == before {
            usable.insert(s);
        }
    }
    let lack = lacks.into_iter().min_by_key(|e| match e {
        CellError::Unmet(_) => 0,
        CellError::Failed(_) => 1,
        CellError::Missing(_) => 2,
        CellError::Absent(_) => 3,
    });
    let nothing = || CellError::Missing(format!("{} has no sequence", plan.suites[suite].name));
    if usable.is_empty() { Err(lack.unwrap_or_else(nothing)) } else { Ok((suite, usable)) }
}

/// Computes all analyses on all trackers, except those of processing time. `tracks` has the tracks of every
/// suite. A failed analysis is an error in its place.
///
/// # Errors
/// When the run is interrupted or the store cannot be written to.
pub fn analyse(context: &Context<'_>, tracks: &[Vec<Tracks>]) -> Result<Analyses, RunError> {
    let (plan, experiment) = (context.plan, context.plan.experiment);
    let of_analysis = |analysis: &Analysis| -> Vec<Usable> {
        let signal = analysis.signal.as_ref().and_then(|s| signal_index(&plan.signals, s));
        let of_tracker = |(t, tracker): (usize, &Tracker)| -> Usable {
            if !analysis.runs_on(&tracker.label) {
                return Err(CellError::not_asked_for());
            }
            let roles = analysis.roles.iter().enumerate();
            roles
                .map(|(k, role)| usable(plan, tracks, role, (t, analysis.runs(k, tracker)), signal))
                .collect()
        };
        experiment.trackers.iter().enumerate().map(of_tracker).collect()
    };
    let usable: Vec<Vec<Usable>> = experiment.analyses.iter().map(of_analysis).collect();
    let one = |(a, t): (usize, usize)| {
        let made = make(context, tracks, &experiment.analyses[a], &usable[a], t);
        analysed(experiment, (a, t), made)
    };
    pairs(experiment, false).into_par_iter().with_max_len(1).map(one).collect()
}

/// Computes an analysis on a tracker. To be comparable, trackers that have some sequences in each suite are
/// analyzed on those that they have in common. `usable` has the sequences of each tracker.
fn make(
    context: &Context<'_>,
    tracks: &[Vec<Tracks>],
    analysis: &Analysis,
    usable: &[Usable],
    tracker: usize,
) -> Result<Made, StepError> {
    let plan = context.plan;
    let signal = analysis.signal.as_ref().and_then(|s| signal_index(&plan.signals, s));
    let over_confidence = analysis.signal.as_ref().is_some_and(|s| s.kind == confidence::ENTRY.kind);
    let reads_regions = analysis.plugin.reads().has_regions();
    let plugin = &analysis.plugin;
    let mut recipe = Recipe::new(Stage::Model).with("overlap", OVERLAP);
    recipe = recipe.with_plugin("analysis", analysis.kind, analysis.version, &plugin.params());
    let (mut suites, mut shares, mut populations) = (Vec::new(), Vec::new(), Vec::new());
    let own = usable[tracker].as_ref().map_err(CellError::clone)?;
    for (place, (suite, own)) in own.iter().enumerate() {
        let PlannedSuite { name, sequences, .. } = &plan.suites[*suite];
        let all = usable.iter().flatten().map(|own| own[place].1.clone());
        let common = all.reduce(|common, own| &common & &own).unwrap_or_default();
        if common.is_empty() {
            let message = format!("there is no sequence of {name} that every tracker has a track of");
            return Err(CellError::Missing(message).into());
        }
        let runs = analysis.runs(place, &plan.experiment.trackers[tracker]);
        recipe = recipe.with("suite", name);
        let mut mine = Vec::new();
        let all = plan.of_runs(*suite, tracker, runs, signal).into_iter();
        for (s, j) in all.filter(|(s, _)| common.contains(s)) {
            let track = tracks[*suite][s][j].clone()?;
            let (read, address) = plan.read(&sequences[s], j, signal)?;
            let sequence = &*sequences[s].sequence;
            recipe = recipe.with(read, address);
            if reads_regions {
                recipe = recipe.with("attributes", attributes_digest(sequence));
            }
            mine.push((track, sequence, plan.jobs[j].run));
        }
        suites.push((name.clone(), common.len()));
        shares.push((own.len(), sequences.len()));
        populations.push((name, mine));
    }
    if let Some(findings) = context.cached::<Findings>(&recipe.address(), 1) {
        context.tally.add(Stage::Model, true);
        return Ok((suites, shares, findings));
    }
    let compute = || -> Result<Findings, StepError> {
        let mut views = Vec::new();
        for (suite, tracks) in &populations {
            let with_regions = tracks.iter().filter(|_| reads_regions);
            let trajectories = with_regions.map(|one| trajectory(one, over_confidence));
            let trajectories = trajectories.collect::<Result<Vec<_>, DatasetError>>();
            let trajectories = trajectories.map_err(StepError::failed)?;
            let tracks = tracks.iter().map(|(track, ..)| track.example(signal)).collect();
            views.push(Population { suite, tracks, trajectories, timings: Vec::new() });
        }
        plugin.analyze(&views).map_err(StepError::failed)
    };
    let findings = run_single(&context.options.limits, compute)?;
    context.tally.add(Stage::Model, false);
    let cell = format!("{}/{}", analysis.name, plan.experiment.trackers[tracker].label);
    context.store.put(&[store::record(plan.name(cell), recipe, 1, &findings)?])?;
    Ok((suites, shares, findings))
}
