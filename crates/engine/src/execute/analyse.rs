//! Analyses of an experiment, each on every tracker: from the store where they are, made where not.

use super::context::Context;
use super::supervise::run_single;
use super::track::{self, Track, Tracks};
use crate::analysis::{Findings, Population, Reads};
use crate::dataset::Sequence;
use crate::error::{CellError, RunError};
use crate::num::hexadecimal;
use crate::observe::tally::Work;
use crate::plan::{PlannedSuite, signal_index};
use crate::score::overlap::OVERLAP;
use crate::score::trajectory::Trajectory;
use crate::spec::analysis::Analysis;
use crate::store::address::{Recipe, Stage};
use crate::store::{self, Name};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};
use std::sync::Arc;

/// One analysis on one tracker.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Analysed {
    /// Name of the analysis in the experiment.
    pub analysis: String,
    /// Label of the tracker.
    pub tracker: String,
    /// Repetitions of the tracker.
    pub runs: u32,
    /// Suites in the order in which they were taken, with the number of sequences of each.
    pub suites: Vec<(String, usize)>,
    /// What came out.
    pub findings: Findings,
}

impl Analysed {
    /// What it rests on: `synthetic-d1 (18 targets), synthetic-d2 (51 targets)`.
    pub fn suites_note(&self) -> String {
        let one = |(name, targets): &(String, usize)| format!("{name} ({targets} targets)");
        self.suites.iter().map(one).collect::<Vec<_>>().join(", ")
    }
}

/// A track with what it is a track of.
struct TrackView {
    track: Arc<Track>,
    sequence: Arc<Sequence>,
    run: u32,
}

impl TrackView {
    /// As tracking protocols look at it.
    ///
    /// # Errors
    /// In words, when the size of the frames cannot be read.
    fn trajectory(&self) -> Result<Trajectory<'_>, String> {
        let Sequence { name, truth, attributes, frame_attributes, .. } = &*self.sequence;
        Ok(Trajectory {
            sequence: name,
            run: self.run,
            regions: &self.track.regions,
            status: &self.track.status,
            truth,
            frame: self.sequence.size().map_err(|e| e.to_string())?,
            attributes,
            frame_attributes,
        })
    }

    /// Digest of the attributes, which are part of no track.
    fn attributes(&self) -> String {
        let Sequence { attributes, frame_attributes, .. } = &*self.sequence;
        let text = serde_json::to_vec(&(attributes, frame_attributes)).unwrap_or_default();
        hexadecimal(&Sha256::digest(text)[..8])
    }
}

/// Name of an analysis that could not be made, and why not.
pub type NotAnalysed = (String, CellError);

/// Makes every analysis on every tracker; `tracks` has those of every suite.
///
/// # Errors
/// When the run is interrupted or the store cannot be written to; what goes wrong in an analysis is in its
/// place, with its name.
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
    let one = |(a, tracker): (usize, usize)| {
        let analysis = &experiment.analyses[a];
        let label = &experiment.trackers[tracker].label;
        let made = make(context, tracks, analysis, tracker)?;
        Ok(made.map_err(|e| (format!("{} of {label}", analysis.name), e)))
    };
    places.into_par_iter().with_max_len(1).map(one).collect()
}

fn make(
    context: &Context<'_>,
    tracks: &[Vec<Tracks>],
    analysis: &Analysis,
    tracker: usize,
) -> Result<Result<Analysed, CellError>, RunError> {
    let plan = context.plan;
    let signal = analysis.signal.as_ref().and_then(|s| signal_index(&plan.signals, s));
    let reads_regions = analysis.plugin.reads() == Reads::Regions;
    let (plugin, params) = (analysis.plugin.clone(), analysis.plugin.params());
    let mut recipe = Recipe::new(Stage::Model).with("overlap", OVERLAP);
    recipe = recipe.with_plugin("analysis", analysis.kind, analysis.version, &params);
    let mut suites = Vec::new();
    let mut populations: Vec<(String, Vec<TrackView>)> = Vec::new();
    for role in &analysis.roles {
        let Some(suite) = plan.suite(role) else {
            return Ok(Err(CellError::Missing(format!("no suite in role `{role}`"))));
        };
        let PlannedSuite { name, sequences, .. } = &plan.suites[suite];
        let seen = |(track, s, j): (Arc<Track>, usize, usize)| TrackView {
            track,
            sequence: sequences[s].sequence.clone(),
            run: plan.jobs[j].run,
        };
        let mine: Vec<TrackView> =
            track::learned_from(plan, tracks, suite, tracker).into_iter().map(seen).collect();
        if mine.is_empty() {
            return Ok(Err(CellError::Missing(format!("no track in role `{role}` to analyse"))));
        }
        recipe = recipe.with("suite", name);
        recipe = mine.iter().fold(recipe, |recipe, seen| {
            let recipe = plan.read(seen.track.address, signal).add_to(recipe);
            if reads_regions { recipe.with("attributes", seen.attributes()) } else { recipe }
        });
        suites.push((name.clone(), sequences.len()));
        populations.push((name.clone(), mine));
    }
    let t = &plan.experiment.trackers[tracker];
    let (name, runs) = (analysis.name.clone(), t.training_runs);
    let analysed = |findings| Analysed { analysis: name, tracker: t.label.clone(), runs, suites, findings };
    if let Some(findings) = context.cached::<Findings>(&recipe.address(), 1) {
        context.tally.add(Work::Models, true);
        return Ok(Ok(analysed(findings)));
    }
    let compute = move || {
        let mut views = Vec::new();
        for (suite, seen) in &populations {
            let trajectories =
                if reads_regions { seen.iter().map(TrackView::trajectory).collect() } else { Ok(Vec::new()) };
            let tracks = seen.iter().map(|s| s.track.example(signal)).collect();
            views.push(Population { suite, tracks, trajectories: trajectories?, timings: Vec::new() });
        }
        plugin.analyze(&views).map_err(|e| e.to_string())
    };
    let findings = match run_single(&context.options.limits, compute)? {
        Ok(findings) => findings,
        Err(reason) => return Ok(Err(CellError::Failed(reason))),
    };
    context.tally.add(Work::Models, false);
    let cell = format!("{}/{}", analysis.name, t.label);
    let name = Name { experiment: plan.experiment.name.clone(), cell };
    context.put(vec![store::record(name, recipe, 1, &findings)?])?;
    Ok(Ok(analysed(findings)))
}
