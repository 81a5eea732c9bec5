//! Analyses of an experiment, each on every tracker: from the store where they are, made where not.

use super::address::{Recipe, Stage};
use super::pass::CellError;
use super::plan::{PlannedSuite, signal_index};
use super::run::{Context, RunError, Work};
use super::store::{self, Name};
use super::supervise::alone;
use super::tracks::{self, Track, Tracks};
use crate::analysis::{Findings, Population};
use crate::score::overlap::OVERLAP;
use crate::spec::analysis::Analysis;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
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
    let signal = signal_index(&plan.signals, &analysis.signal);
    let (plugin, params) = (analysis.plugin.clone(), analysis.plugin.params());
    let mut recipe = Recipe::new(Stage::Model).with("overlap", OVERLAP);
    recipe = recipe.with_plugin("analysis", analysis.kind, analysis.version, &params);
    let mut suites = Vec::new();
    let mut populations: Vec<(String, Vec<Arc<Track>>)> = Vec::new();
    for role in &analysis.roles {
        let Some(suite) = plan.suite(role) else {
            return Ok(Err(CellError::Missing(format!("no suite in role `{role}`"))));
        };
        let mine = tracks::learned_from(plan, tracks, suite, tracker);
        if mine.is_empty() {
            return Ok(Err(CellError::Missing(format!("no track in role `{role}` to analyse"))));
        }
        let PlannedSuite { name, sequences, .. } = &plan.suites[suite];
        recipe = recipe.with("suite", name);
        recipe = mine.iter().fold(recipe, |recipe, t| plan.read(t.address, signal).enter(recipe));
        suites.push((name.clone(), sequences.len()));
        populations.push((name.clone(), mine));
    }
    let t = &plan.experiment.trackers[tracker];
    let (name, runs) = (analysis.name.clone(), t.training_runs);
    let analysed = |findings| Analysed { analysis: name, tracker: t.label.clone(), runs, suites, findings };
    if let Some(findings) = context.kept::<Findings>(&recipe.address(), 1) {
        context.tally.add(Work::Models, true);
        return Ok(Ok(analysed(findings)));
    }
    let compute = move || {
        let mut views = Vec::new();
        for (suite, tracks) in &populations {
            views.push(Population { suite, tracks: tracks.iter().map(|t| t.example(signal)).collect() });
        }
        plugin.analyse(&views)
    };
    let findings = match alone(&context.options.limits, compute)? {
        Ok(findings) => findings,
        Err(reason) => return Ok(Err(CellError::Failed(reason))),
    };
    context.tally.add(Work::Models, false);
    let cell = format!("{}/{}", analysis.name, t.label);
    let name = Name { experiment: plan.experiment.name.clone(), cell };
    context.put(vec![store::record(name, recipe, 1, &findings)?])?;
    Ok(Ok(analysed(findings)))
}
