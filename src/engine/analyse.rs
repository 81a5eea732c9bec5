//! Analyses of an experiment, each on every tracker: from the store where they are, made where not.

use super::address::{Recipe, Stage};
use super::judge::signal_of;
use super::pass::CellError;
use super::plan::signal_index;
use super::run::{Context, RunError, Work};
use super::store::{self, Name};
use super::supervise::{Watch, supervised};
use super::tracks::{Track, Tracks};
use crate::analysis::{Findings, Population};
use crate::detector::Example;
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
    let mut populations: Vec<(String, Vec<Arc<Track>>)> = Vec::new();
    for role in &analysis.roles {
        let Some(suite) = plan.suite(role) else {
            return Ok(Err(CellError::Missing(format!("no suite in role `{role}`"))));
        };
        let pairs = plan.learned_from(suite, tracker).into_iter();
        let mine: Vec<Arc<Track>> =
            pairs.filter_map(|(s, j)| tracks[suite][s][j].as_ref().ok().cloned()).collect();
        if mine.is_empty() {
            return Ok(Err(CellError::Missing(format!("no track in role `{role}` to analyse"))));
        }
        let name = plan.suites[suite].name.clone();
        recipe = recipe.with("suite", &name);
        recipe = mine.iter().fold(recipe, |recipe, t| plan.read(t.address, signal).enter(recipe));
        populations.push((name, mine));
    }
    let t = &plan.experiment.trackers[tracker];
    let analysed = |findings: Findings| {
        let present = |role: &String| {
            let suite = &plan.suites[plan.suite(role)?];
            Some((suite.name.clone(), suite.sequences.len()))
        };
        Analysed {
            analysis: analysis.name.clone(),
            tracker: t.label.clone(),
            runs: t.training_runs,
            suites: analysis.roles.iter().filter_map(present).collect(),
            findings,
        }
    };
    if let Some(findings) = context.kept::<Findings>(&recipe.address(), 1) {
        context.tally.add(Work::Models, true);
        return Ok(Ok(analysed(findings)));
    }
    let work = move |watch: &Watch, out: &[Option<String>]| {
        if let Some(Some(reason)) = out.first() {
            return Ok(Err(reason.clone()));
        }
        watch.go_on()?;
        let signals: Vec<Vec<_>> = populations
            .iter()
            .map(|(_, tracks)| tracks.iter().map(|track| signal_of(track, signal)).collect())
            .collect();
        let views: Vec<Population<'_>> = populations
            .iter()
            .zip(&signals)
            .map(|((suite, tracks), signals)| {
                let pairs = signals.iter().zip(tracks);
                let tracks = pairs.map(|(signal, t)| Example { signal, error: &t.error }).collect();
                Population { suite, tracks }
            })
            .collect();
        Ok(watch.step(0, || plugin.analyse(&views)).flatten())
    };
    let findings = match supervised(1, &context.options.limits, work)? {
        Ok(findings) => findings,
        Err(reason) => return Ok(Err(CellError::Failed(reason))),
    };
    context.tally.add(Work::Models, false);
    let cell = format!("{}/{}", analysis.name, t.label);
    let name = Name { experiment: plan.experiment.name.clone(), cell };
    context.put(vec![store::record(name, recipe, 1, &findings)?])?;
    Ok(Ok(analysed(findings)))
}
