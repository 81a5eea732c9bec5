//! Training and learning: from the tracks of a suite to detectors with parameters and models.

mod choose;

use super::context::Context;
use super::judge::{ReadyDetector, ReadyDetectors};
use super::track::{Track, Tracks};
use crate::error::{CellError, RunError, StepError};
use crate::plan::recipes::DetectorKey;
use crate::plan::{ExperimentPlan, Key, Place, TrainingNeed};
use crate::spec::TEST;
use crate::spec::method::{Candidates, DetectorChoice, Training};
use crate::store::address::{Address, Stage};
use crate::store::{self, Name};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use serde_json::Value;
use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;
use trackfail_methods::detector::Example;
use trackfail_methods::score::Counts;

/// A trained parameter or a learned model of one method on one tracker.
#[derive(Debug, Clone, Serialize)]
pub struct Model {
    /// Name of the method.
    pub method: String,
    /// Grid point of the method, as in `scores.csv`.
    pub params: String,
    /// Label of the tracker that the training data are from.
    pub tracker: String,
    /// Repetitions of the tracker that were used.
    pub runs: u32,
    /// Name of the training suite.
    pub suite: String,
    /// True if the training suite is the test suite.
    pub tuned_on_test: bool,
    /// Names and digests of the sequences used.
    pub sequences: Vec<(String, String)>,
    /// The chosen parameter or the model.
    #[serde(flatten)]
    pub content: Content,
}

/// Result of training or learning.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[serde(untagged)]
pub enum Content {
    /// A chosen parameter.
    Chosen {
        /// Name of the parameter.
        parameter: String,
        /// The chosen value.
        value: f64,
        /// Name of the measure that was maximized.
        maximise: String,
        /// Value of the measure for the choice; `null` if no candidate had one.
        reached: Option<f64>,
        /// All candidates, each with its value of the measure.
        candidates: Vec<(f64, Option<f64>)>,
    },
    /// A learned model.
    Learned {
        /// The model as JSON.
        model: Value,
        /// Threshold that the detector derives from the model, if it has one.
        threshold: Option<f64>,
    },
    /// One parameter or model for each fold of the test suite, trained on the other folds and the other
    /// trackers.
    OnOthers {
        /// Contents by fold.
        folds: Vec<FoldContent>,
    },
}

/// The parameter or model for one fold of the test suite.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct FoldContent {
    /// Sequences of the fold: not trained on, and tested with this content.
    pub left_out: Vec<String>,
    /// The parameter or model.
    #[serde(flatten)]
    pub content: Content,
}

/// Result of training: the index of the chosen candidate, with the data of all.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
struct Chosen {
    index: u64,
    reached: Option<f64>,
    /// Values of the candidates.
    values: Vec<f64>,
    /// Measure of each candidate.
    measures: Vec<Option<f64>>,
}

/// Content of a model's record in the store.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
enum StoredModel {
    Chosen(Chosen),
    /// Model as JSON text.
    Learned(String),
}

/// Detectors of the variants that need no training.
pub fn given(plan: &ExperimentPlan<'_>) -> ReadyDetectors {
    let ready = |(key, detector): (Key, &DetectorChoice)| {
        let fixed = detector.example.clone();
        (key, Ok(Arc::new(ReadyDetector { fixed, key: DetectorKey::new(detector, None) })))
    };
    plan.given().map(ready).collect()
}

/// Detectors of all variants, trained where needed, and the models. `tracks` has the tracks of every suite.
///
/// # Errors
/// When the run is interrupted or the store cannot be written to.
pub fn make_ready(
    context: &Context<'_>,
    tracks: &[Vec<Tracks>],
) -> Result<(ReadyDetectors, Vec<Model>), RunError> {
    let is_there = |place: &Place, signals: &[usize]| {
        track_at(tracks, place).as_ref().is_ok_and(|track| track.check(signals).is_ok())
    };
    let needs = context.plan.needs(is_there);
    let made = make_all(context, tracks, &needs)?;
    let (mut ready, mut models) = (given(context.plan), Vec::new());
    for parts in needs.chunk_by(|(a, _), (b, _)| (a.0, a.1) == (b.0, b.1)) {
        let mut contents = Vec::new();
        for (key, need) in parts {
            let mut detector = || -> Result<Arc<ReadyDetector>, CellError> {
                let need = need.as_ref().map_err(Clone::clone)?;
                let model = made[&need.address].as_ref().map_err(Clone::clone)?;
                let (detector, content) = instantiate(need, model)?;
                contents.push((need, content));
                Ok(Arc::new(detector))
            };
            ready.insert(*key, detector());
        }
        models.extend(describe(context, contents));
    }
    Ok((ready, models))
}

fn track_at<'t>(tracks: &'t [Vec<Tracks>], place: &Place) -> &'t Result<Arc<Track>, CellError> {
    &tracks[place.0][place.1][place.2]
}

type StoredModels = BTreeMap<Address, Result<StoredModel, CellError>>;

/// Trained parameters and learned models by address, from the store or computed. Variants with the same model
/// share it.
fn make_all(
    context: &Context<'_>,
    tracks: &[Vec<Tracks>],
    needs: &[(Key, Result<TrainingNeed<'_>, CellError>)],
) -> Result<StoredModels, RunError> {
    let distinct: BTreeMap<Address, &TrainingNeed<'_>> =
        needs.iter().rev().flat_map(|(_, need)| need).map(|need| (need.address, need)).collect();
    let distinct: Vec<&TrainingNeed<'_>> = distinct.into_values().collect();
    let cached = |need: &&TrainingNeed<'_>| context.cached::<StoredModel>(&need.address, 1);
    let cached: Vec<Option<StoredModel>> = distinct.par_iter().map(cached).collect();
    let (mut made, mut pending) = (StoredModels::new(), Vec::new());
    for (need, model) in distinct.into_iter().zip(cached) {
        context.tally.add(Stage::Model, model.is_some());
        match model {
            Some(model) => drop(made.insert(need.address, Ok(model))),
            None => pending.push(need),
        }
    }
    let counted = counts_of_listed(context, tracks, &pending);
    let make = |need: &&TrainingNeed<'_>| StepError::settled(make(context, tracks, need, &counted));
    let new: Vec<_> = pending.par_iter().with_max_len(1).map(make).collect::<Result<_, RunError>>()?;
    let mut records = Vec::new();
    for (need, model) in pending.into_iter().zip(new) {
        if let Ok(model) = &model {
            records.push(store::record(stored_name(context, need), need.recipe.clone(), 1, model)?);
        }
        made.insert(need.address, model);
    }
    context.store.put(&records)?;
    Ok(made)
}

fn stored_name(context: &Context<'_>, need: &TrainingNeed<'_>) -> Name {
    let plan = context.plan;
    let tracker = &plan.experiment.trackers[need.key.1].label;
    let suite = need.tracks.first().map_or("", |(suite, ..)| plan.suites[*suite].name.as_str());
    let cell = format!("{suite}/{tracker}/{}[{}]", need.method.name, need.variant.params());
    let is_of_fold = need.variant.detector.trains_on_others();
    let cell = if is_of_fold { format!("{cell} fold {}", need.key.2) } else { cell };
    plan.name(cell)
}

/// Counts of each listed candidate, by variant and track.
type Counted = BTreeMap<(usize, Place), Result<Vec<Counts>, StepError>>;

/// Counts of the listed candidates on each track. A track may be training data of many parts; it is judged
/// once here.
fn counts_of_listed(context: &Context<'_>, tracks: &[Vec<Tracks>], pending: &[&TrainingNeed<'_>]) -> Counted {
    let mut asked = BTreeMap::new();
    for need in pending {
        if let Some(Training { candidates: Candidates::Listed(list), .. }) = &need.variant.detector.training {
            asked.extend(need.tracks.iter().map(|place| ((need.key.0, *place), (need.method, list))));
        }
    }
    let asked: Vec<_> = asked.into_iter().collect();
    let counts = asked.into_par_iter().with_max_len(1).map(|((v, place), (method, list))| {
        let (signals, limits) = (context.plan.signals_of(v), &context.options.limits);
        let track = track_at(tracks, &place).as_ref().map_err(|e| e.clone().into());
        let counts = track.and_then(|track| choose::counts(list, track, signals, method.protocol, limits));
        ((v, place), counts)
    });
    counts.collect()
}

/// Computes a trained parameter or learned model.
fn make(
    context: &Context<'_>,
    tracks: &[Vec<Tracks>],
    need: &TrainingNeed<'_>,
    counted: &Counted,
) -> Result<StoredModel, StepError> {
    let (plan, limits, v) = (context.plan, &context.options.limits, need.key.0);
    let (protocol, signals) = (need.method.protocol, plan.signals_of(v));
    let mine = need.tracks.iter().map(|place| track_at(tracks, place).clone());
    let mine: Vec<Arc<Track>> = mine.collect::<Result<_, CellError>>()?;
    let DetectorChoice { example, training } = &need.variant.detector;
    match training {
        Some(training) => {
            let chosen = || -> Result<Chosen, StepError> {
                let candidates = choose::candidates(training, &mine, signals)?;
                let count = |(place, track): (&Place, &Arc<Track>)| match counted.get(&(v, *place)) {
                    Some(counts) => counts.clone(),
                    None => choose::counts(&candidates, track, signals, protocol, limits),
                };
                let counts = need.tracks.par_iter().zip(&mine).with_max_len(1).map(count);
                // The first error in order, whichever came first.
                let counts = counts.collect::<Vec<_>>().into_iter().collect::<Result<Vec<_>, StepError>>()?;
                let values = candidates.iter().map(|(value, _)| *value).collect();
                Ok(choose::best(training, protocol, values, &counts))
            };
            let within = |e: StepError| e.within(&format!("training `{}`", training.key));
            chosen().map(StoredModel::Chosen).map_err(within)
        }
        None => {
            let origins =
                need.tracks.iter().map(|(suite, s, _)| &plan.suites[*suite].sequences[*s].sequence.origin);
            let examples = mine.iter().zip(origins).map(|(track, origin)| track.example_of(signals, origin));
            let examples: Vec<Example<'_>> = examples.collect();
            choose::learn(example, &examples, limits).map(StoredModel::Learned)
        }
    }
}

/// Detector with its trained parameter or learned model.
fn instantiate(need: &TrainingNeed<'_>, model: &StoredModel) -> Result<(ReadyDetector, Content), CellError> {
    let failed = |reason: String| CellError::Failed(format!("method {}: {reason}", need.method.name));
    let key = DetectorKey::new(&need.variant.detector, Some(need.address));
    let DetectorChoice { example, training } = &need.variant.detector;
    match (training, model) {
        (Some(training), StoredModel::Chosen(chosen)) => {
            let damaged = || failed("a record of its training is damaged".to_string());
            let index = chosen.index as usize;
            let value = *chosen.values.get(index).ok_or_else(damaged)?;
            let fixed = match &training.candidates {
                Candidates::Listed(list) => list.get(index).ok_or_else(damaged)?.1.clone(),
                Candidates::Quantiles { build, .. } => build(value).map_err(|e| failed(e.to_string()))?,
            };
            let content = Content::Chosen {
                parameter: training.key.clone(),
                value,
                maximise: training.maximise.name().to_string(),
                reached: chosen.reached,
                candidates: chosen.values.iter().copied().zip(chosen.measures.iter().copied()).collect(),
            };
            Ok((ReadyDetector { fixed, key }, content))
        }
        (None, StoredModel::Learned(text)) => {
            let model: Value = serde_json::from_str(text).map_err(|e| failed(e.to_string()))?;
            let learner = example.detector.learner().ok_or_else(|| failed("does not learn".to_string()))?;
            let detector = learner.with_model(&model).map_err(|e| failed(e.to_string()))?;
            let mut fixed = example.clone();
            fixed.detector.plugin = detector;
            let content = Content::Learned { model, threshold: fixed.detector.facts().threshold };
            Ok((ReadyDetector { fixed, key }, content))
        }
        _ => Err(failed("a record of its training is of another kind".to_string())),
    }
}

/// Reported model of a variant on a tracker, put together from its parts; `None` without any part.
fn describe(context: &Context<'_>, mut contents: Vec<(&TrainingNeed<'_>, Content)>) -> Option<Model> {
    let plan = context.plan;
    let need = contents.first()?.0;
    let suite = &plan.suites[need.tracks.first()?.0];
    let on_others = need.variant.detector.trains_on_others();
    let used: BTreeSet<usize> =
        contents.iter().flat_map(|(need, _)| &need.tracks).map(|(_, sequence, _)| *sequence).collect();
    let sequences = suite.digests().into_iter().enumerate().filter(|(s, _)| used.contains(s));
    let fold = |(need, content): (&TrainingNeed<'_>, Content)| {
        let names = suite.sequences.iter().enumerate();
        let left_out = names.filter(|(s, _)| plan.part(need.variant, *s) == need.key.2);
        let left_out = left_out.map(|(_, planned)| planned.sequence.name.clone()).collect();
        FoldContent { left_out, content }
    };
    let content = match on_others {
        true => Content::OnOthers { folds: contents.into_iter().map(fold).collect() },
        false => contents.swap_remove(0).1,
    };
    let tracker = &plan.experiment.trackers[need.key.1];
    Some(Model {
        method: need.method.name.clone(),
        params: need.variant.params(),
        tracker: tracker.label.clone(),
        runs: tracker.training_runs,
        suite: suite.name.clone(),
        tuned_on_test: !on_others && plan.experiment.suites.get(TEST) == Some(&suite.name),
        sequences: sequences.map(|(_, digest)| digest).collect(),
        content,
    })
}
