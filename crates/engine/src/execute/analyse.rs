//! Analyses of an experiment, each on every tracker: from the store, or computed.

use super::context::Context;
use super::supervise::run_single;
use super::track::{self, Track, Tracks};
use crate::error::{CellError, RunError, StepError};
use crate::observe::tally::Work;
use crate::plan::recipes::Read;
use crate::plan::{PlannedSuite, signal_index};
use crate::spec::analysis::Analysis;
use crate::store::address::{Recipe, Stage};
use crate::store::{self, Name};
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

/// One analysis on one tracker.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Analysed {
    /// Name of the analysis in the experiment.
    pub analysis: String,
    /// Label of the tracker.
    pub tracker: String,
    /// Repetitions of the tracker.
    pub runs: u32,
    /// Suites in the order of the analysis, with the number of sequences of each that it was made on.
    pub suites: Vec<(String, usize)>,
    /// For each suite the numbers of sequences that the tracker has tracks of, and that are there; empty where the analysis was
    /// made on all of them.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub shares: Vec<(usize, usize)>,
    /// The findings.
    pub findings: Findings,
}

/// A track with its sequence.
struct TrackView {
    track: Arc<Track>,
    /// Input of the analysis: a signal on the track, or the track itself.
    read: Read,
    sequence: Arc<Sequence>,
    run: u32,
}

impl TrackView {
    /// The track as tracking protocols read it, with the tracker's confidence where that is what the analysis takes.
    ///
    /// # Errors
    /// When the size of the frames cannot be read.
    fn trajectory(&self, over_confidence: bool) -> Result<Trajectory<'_>, DatasetError> {
        let Sequence { name, truth, attributes, frame_attributes, .. } = &*self.sequence;
        Ok(Trajectory {
            sequence: name,
            run: self.run,
            regions: &self.track.regions,
            status: &self.track.status,
            truth,
            confidence: if over_confidence { self.track.confidence.as_slice() } else { &[] },
            frame: self.sequence.has_frames().then(|| self.sequence.size()).transpose()?,
            attributes,
            frame_attributes,
        })
    }

    /// Digest of the attributes, which are not part of the track's address.
    fn attributes(&self) -> String {
        let Sequence { attributes, frame_attributes, .. } = &*self.sequence;
        let text = serde_json::to_vec(&(attributes, frame_attributes)).unwrap_or_default();
        hexadecimal(&Sha256::digest(text)[..8])
    }
}

/// An analysis that could not be made.
#[derive(Debug)]
pub struct NotAnalysed {
    /// Its name.
    pub analysis: String,
    /// Label of the tracker.
    pub tracker: String,
    /// The reason.
    pub error: CellError,
}

/// Sequences of the suites of an analysis: trackers are compared on those that all of them have.
struct Compared {
    /// For each tracker and each suite, the sequences of which it has the tracks of all runs.
    own: Vec<Vec<BTreeSet<usize>>>,
    /// For each suite, the sequences that are among those of every tracker with some in each suite.
    common: Vec<BTreeSet<usize>>,
}

impl Compared {
    fn new(context: &Context<'_>, tracks: &[Vec<Tracks>], analysis: &Analysis) -> Self {
        let plan = context.plan;
        let signal = analysis.signal.as_ref().and_then(|s| signal_index(&plan.signals, s));
        let trackers = &plan.experiment.trackers;
        let of_tracker = |tracker: usize| -> Vec<BTreeSet<usize>> {
            let of_role = |(place, role): (usize, &String)| {
                let runs = analysis.runs(place, &trackers[tracker]);
                let is_used = analysis.runs_on(&trackers[tracker].label);
                let suite = plan.suite(role).filter(|_| is_used);
                suite.map_or_else(BTreeSet::new, |suite| {
                    let mut mine: BTreeSet<usize> = (0..plan.suites[suite].sequences.len()).collect();
                    mine.retain(|s| lacks(context, tracks, (suite, *s), (tracker, runs), signal).is_empty());
                    mine
                })
            };
            analysis.roles.iter().enumerate().map(of_role).collect()
        };
        let own: Vec<Vec<BTreeSet<usize>>> = (0..trackers.len()).map(of_tracker).collect();
        let compared = || own.iter().filter(|own| own.iter().all(|of_suite| !of_suite.is_empty()));
        let of_place = |place: usize| {
            let of_suite = compared().map(|own| own[place].clone());
            of_suite.reduce(|common, own| &common & &own).unwrap_or_default()
        };
        let common = (0..analysis.roles.len()).map(of_place).collect();
        Self { own, common }
    }
}

/// Makes every analysis on every tracker, except those of the clock; `tracks` has the tracks of every suite. An analysis
/// that fails is an error in its place.
///
/// # Errors
/// When the run is interrupted or the store cannot be written to.
pub fn analyse(
    context: &Context<'_>,
    tracks: &[Vec<Tracks>],
) -> Result<Vec<Result<Analysed, NotAnalysed>>, RunError> {
    let experiment = context.plan.experiment;
    let places: Vec<(usize, usize)> = (0..experiment.analyses.len())
        .flat_map(|a| (0..experiment.trackers.len()).map(move |tracker| (a, tracker)))
        .filter(|(a, _)| experiment.analyses[*a].plugin.reads() != Reads::Clock)
        .filter(|(a, tracker)| experiment.analyses[*a].runs_on(&experiment.trackers[*tracker].label))
        .collect();
    let compared: Vec<Compared> =
        experiment.analyses.iter().map(|analysis| Compared::new(context, tracks, analysis)).collect();
    let one = |(a, tracker): (usize, usize)| {
        let analysis = &experiment.analyses[a];
        let label = &experiment.trackers[tracker].label;
        match make(context, tracks, (analysis, &compared[a]), tracker) {
            Ok(analysed) => Ok(Ok(analysed)),
            Err(e) => {
                let (analysis, tracker) = (analysis.name.clone(), label.clone());
                Ok(Err(NotAnalysed { analysis, tracker, error: e.cell()? }))
            }
        }
    };
    places.into_par_iter().with_max_len(1).map(one).collect()
}

/// Why tracks of a tracker's first runs over a sequence cannot be analysed.
fn lacks(
    context: &Context<'_>,
    tracks: &[Vec<Tracks>],
    (suite, sequence): (usize, usize),
    (tracker, runs): (usize, u32),
    signal: Option<usize>,
) -> Vec<CellError> {
    let plan = context.plan;
    let planned = &plan.suites[suite].sequences[sequence];
    let is_mine = |j: &usize| plan.jobs[*j].tracker == tracker && plan.jobs[*j].run < runs;
    let reason = |j: usize| match &tracks[suite][sequence][j] {
        Err(e) => Some(e.clone()),
        Ok(_) => plan.unmet(planned, j, signal),
    };
    (0..plan.jobs.len()).filter(is_mine).filter_map(reason).collect()
}

/// Why none of a tracker's sequences of a suite can be analysed: a need that is not met, else the first failure.
fn no_sequence(
    context: &Context<'_>,
    tracks: &[Vec<Tracks>],
    suite: usize,
    mine: (usize, u32),
    signal: Option<usize>,
) -> CellError {
    let PlannedSuite { name, sequences, .. } = &context.plan.suites[suite];
    let reasons = (0..sequences.len()).flat_map(|s| lacks(context, tracks, (suite, s), mine, signal));
    let rank = |e: &CellError| match e {
        CellError::Unmet(_) => 0,
        CellError::Failed(_) => 1,
        CellError::Missing(_) => 2,
        CellError::Absent(_) => 3,
    };
    let nothing = || CellError::Missing(format!("{name} has no sequence"));
    reasons.min_by_key(rank).unwrap_or_else(nothing)
}

fn make(
    context: &Context<'_>,
    tracks: &[Vec<Tracks>],
    (analysis, compared): (&Analysis, &Compared),
    tracker: usize,
) -> Result<Analysed, StepError> {
    let plan = context.plan;
    let signal = analysis.signal.as_ref().and_then(|s| signal_index(&plan.signals, s));
    let over_confidence = analysis.signal.as_ref().is_some_and(|s| s.kind == confidence::ENTRY.kind);
    let reads_regions = analysis.plugin.reads().has_regions();
    let (plugin, params) = (analysis.plugin.clone(), analysis.plugin.params());
    let mut recipe = Recipe::new(Stage::Model).with("overlap", OVERLAP);
    recipe = recipe.with_plugin("analysis", analysis.kind, analysis.version, &params);
    let (mut suites, mut shares) = (Vec::new(), Vec::new());
    // Without, it is not among those that are compared.
    let has_all = compared.own[tracker].iter().all(|of_suite| !of_suite.is_empty());
    let mut populations: Vec<(String, Vec<TrackView>)> = Vec::new();
    for (place, role) in analysis.roles.iter().enumerate() {
        let Some(suite) = plan.suite(role) else {
            return Err(CellError::Missing(format!("no suite in role `{role}`")).into());
        };
        let PlannedSuite { name, sequences, .. } = &plan.suites[suite];
        let view = |(track, s, j): (Arc<Track>, usize, usize)| -> Result<TrackView, CellError> {
            let read = plan.read(&sequences[s], j, signal)?;
            Ok(TrackView { track, read, sequence: sequences[s].sequence.clone(), run: plan.jobs[j].run })
        };
        let runs = analysis.runs(place, &plan.experiment.trackers[tracker]);
        let (own, common) = (&compared.own[tracker][place], &compared.common[place]);
        if own.is_empty() {
            return Err(no_sequence(context, tracks, suite, (tracker, runs), signal).into());
        }
        if common.is_empty() && has_all {
            let message = format!("there is no sequence of {name} that every tracker has a track of");
            return Err(CellError::Missing(message).into());
        }
        let of_runs = track::of_runs(plan, tracks, suite, tracker, runs, signal).into_iter();
        let of_runs = of_runs.filter(|(_, s, _)| common.contains(s));
        let mine: Vec<TrackView> = of_runs.map(view).collect::<Result<_, CellError>>()?;
        recipe = recipe.with("suite", name);
        recipe = mine.iter().fold(recipe, |recipe, view| {
            let recipe = view.read.add_to(recipe);
            if reads_regions { recipe.with("attributes", view.attributes()) } else { recipe }
        });
        suites.push((name.clone(), common.len()));
        shares.push((own.len(), sequences.len()));
        populations.push((name.clone(), mine));
    }
    let t = &plan.experiment.trackers[tracker];
    let (name, runs) = (analysis.name.clone(), t.training_runs);
    if suites.iter().zip(&shares).all(|((_, made_on), (_, there))| made_on == there) {
        shares.clear();
    }
    let tracker = t.label.clone();
    let analysed = |findings| Analysed { analysis: name, tracker, runs, suites, shares, findings };
    if let Some(findings) = context.cached::<Findings>(&recipe.address(), 1) {
        context.tally.add(Work::Models, true);
        return Ok(analysed(findings));
    }
    let compute = move || -> Result<Findings, StepError> {
        let mut views = Vec::new();
        for (suite, tracks) in &populations {
            let with_regions = tracks.iter().filter(|_| reads_regions);
            let trajectories: Result<_, DatasetError> =
                with_regions.map(|view| view.trajectory(over_confidence)).collect();
            let trajectories = trajectories.map_err(StepError::failed)?;
            let tracks = tracks.iter().map(|view| view.track.example(signal)).collect();
            views.push(Population { suite, tracks, trajectories, timings: Vec::new() });
        }
        plugin.analyze(&views).map_err(StepError::failed)
    };
    let findings = run_single(&context.options.limits, compute)?;
    context.tally.add(Work::Models, false);
    let cell = format!("{}/{}", analysis.name, t.label);
    let name = Name { experiment: plan.experiment.name.clone(), cell };
    context.put(vec![store::record(name, recipe, 1, &findings)?])?;
    Ok(analysed(findings))
}
