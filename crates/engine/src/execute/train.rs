//! Training and learning: from the tracks of a suite to detectors with parameters and models.

mod choose;

use super::context::Context;
use super::judge::{ParameterSource, ReadyDetector};
use super::track::{Track, Tracks};
use crate::error::{CellError, RunError, StepError};
use crate::observe::tally::Work;
use crate::plan::{Place, SignalSet, recipes, variants};
use crate::spec::TEST;
use crate::spec::method::{Candidates, DetectorChoice, FixedDetector, Method, Training, Variant};
use crate::store::address::{Address, Recipe};
use crate::store::{self, Name};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use serde_json::Value;
use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;
use trackfail_methods::score::Counts;

/// A trained parameter or a learned model of one method on one tracker.
#[derive(Debug, Clone, Serialize)]
pub struct Model {
    /// Method.
    pub method: String,
    /// Grid point of the method, as in `scores.csv`.
    pub params: String,
    /// Tracker whose tracks were the training data.
    pub tracker: String,
    /// Repetitions of the tracker.
    pub runs: u32,
    /// Suite of the training data.
    pub suite: String,
    /// Whether that suite is the test suite.
    pub tuned_on_test: bool,
    /// Sequences used, with their digests.
    pub sequences: Vec<(String, String)>,
    /// The parameter or model.
    #[serde(flatten)]
    pub content: Content,
}

/// Result of training or learning.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[serde(untagged)]
pub enum Content {
    /// A parameter was chosen.
    Chosen {
        /// The parameter.
        parameter: String,
        /// The chosen value.
        value: f64,
        /// Measure that was maximized.
        maximise: String,
        /// Its value at the choice; `null` when no candidate had one.
        reached: Option<f64>,
        /// Every candidate with its value of the measure.
        candidates: Vec<(f64, Option<f64>)>,
    },
    /// A model was learned.
    Learned {
        /// The model.
        model: Value,
        /// The threshold that the detector derives from it, where it has one.
        threshold: Option<f64>,
    },
    /// One parameter or model for each fold of the test suite, made on the other folds and the other trackers.
    OnOthers {
        /// The folds.
        folds: Vec<FoldContent>,
    },
}

/// The parameter or model for one fold of the test suite.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct FoldContent {
    /// Sequences that it was not made on, and that it is used on.
    pub left_out: Vec<String>,
    /// The parameter or model.
    #[serde(flatten)]
    pub content: Content,
}

/// Result of training: which candidate was chosen.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
struct Chosen {
    index: u64,
    reached: Option<f64>,
    /// The candidates.
    values: Vec<f64>,
    /// The measure of each.
    measures: Vec<Option<f64>>,
}

/// Content of a model's record in the store.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
enum StoredModel {
    Chosen(Chosen),
    /// JSON text.
    Learned(String),
}

/// A detector for each variant, tracker and [part](crate::plan::ExperimentPlan::parts); an error where training was
/// impossible.
pub type ReadyDetectors = Vec<Vec<Vec<Result<ReadyDetector, CellError>>>>;

/// Training that a variant needs on a tracker, for one part of the test suite.
struct TrainingNeed<'a> {
    variant_index: usize,
    method: &'a Method,
    variant: &'a Variant,
    signals: &'a SignalSet,
    tracker: usize,
    part: usize,
    /// The tracks that it learns from.
    tracks: Vec<Place>,
    address: Address,
    recipe: Recipe,
}

/// Instantiates the detector of every variant, after training and learning where it needs that; `tracks` has the tracks
/// of every suite.
///
/// # Errors
/// When the run is interrupted or the store cannot be written to.
pub fn make_ready(
    context: &Context<'_>,
    tracks: &[Vec<Tracks>],
) -> Result<(ReadyDetectors, Vec<Model>), RunError> {
    let plan = context.plan;
    let variants: Vec<_> = variants(plan.experiment).collect();
    let needs = needs(context, tracks);
    // Variants with the same model share it; it is made once.
    let mut distinct: BTreeMap<Address, &TrainingNeed<'_>> = BTreeMap::new();
    for need in needs.values().flatten() {
        distinct.entry(need.address).or_insert(need);
    }
    let distinct: Vec<&TrainingNeed<'_>> = distinct.into_values().collect();
    let made = make_all(context, tracks, &distinct)?;
    let mut ready: ReadyDetectors = Vec::with_capacity(variants.len());
    let mut models = Vec::new();
    for (v, (_, variant)) in variants.iter().enumerate() {
        let mut row = Vec::with_capacity(plan.experiment.trackers.len());
        for tracker in 0..plan.experiment.trackers.len() {
            let mut contents = Vec::new();
            let mut part = |part: usize| {
                let need = match (&variant.detector, needs.get(&(v, tracker, part))) {
                    (DetectorChoice::Given(fixed), _) => {
                        let source = ParameterSource::Given;
                        return Ok(ReadyDetector { fixed: fixed.clone(), source });
                    }
                    (_, Some(need)) => need.as_ref().map_err(Clone::clone)?,
                    (_, None) => return Err(CellError::Missing("not run on this tracker".to_string())),
                };
                let model = made.get(&need.address).cloned();
                let model = model.unwrap_or_else(|| Err(CellError::Failed("was not trained".to_string())));
                let (ready_detector, content) = instantiate(need, model?)?;
                contents.push((need, content));
                Ok(ready_detector)
            };
            row.push((0..plan.parts(variant)).map(&mut part).collect());
            models.extend(describe(context, contents));
        }
        ready.push(row);
    }
    Ok((ready, models))
}

type Needs<'a> = BTreeMap<(usize, usize, usize), Result<TrainingNeed<'a>, CellError>>;

/// All needs for training, by variant, tracker and part.
fn needs<'a>(context: &'a Context<'_>, tracks: &[Vec<Tracks>]) -> Needs<'a> {
    let plan = context.plan;
    let mut needs = Needs::new();
    for (v, (method, variant)) in variants(plan.experiment).enumerate() {
        let Some(role) = variant.detector.role() else { continue };
        let reads = plan.training_reads(v, variant);
        let trackers = plan.experiment.trackers.iter().enumerate();
        for (t, _) in trackers.filter(|(_, tracker)| method.runs_on(&tracker.label)) {
            for part in 0..plan.parts(variant) {
                let mut mine = plan.training_tracks((v, method, variant), t, part);
                mine.retain(|place| tracks[place.0][place.1][place.2].is_ok() && reads.contains_key(place));
                let of: Vec<_> = mine.iter().filter_map(|track| reads.get(track).copied()).collect();
                let recipe = recipes::of_model(method, variant, &of).filter(|_| !of.is_empty());
                let missing = || CellError::Missing(format!("no track in role `{role}` to learn from"));
                let need = recipe.ok_or_else(missing).map(|recipe| TrainingNeed {
                    variant_index: v,
                    method,
                    variant,
                    signals: plan.signals_of(v),
                    tracker: t,
                    part,
                    tracks: mine,
                    address: recipe.address(),
                    recipe,
                });
                needs.insert((v, t, part), need);
            }
        }
    }
    needs
}

type StoredModels = BTreeMap<Address, Result<StoredModel, CellError>>;

/// Trained parameters and learned models by their address: from the store, or made.
fn make_all(
    context: &Context<'_>,
    tracks: &[Vec<Tracks>],
    needs: &[&TrainingNeed<'_>],
) -> Result<StoredModels, RunError> {
    let cached = |need: &&TrainingNeed<'_>| context.cached::<StoredModel>(&need.address, 1);
    let mut made = StoredModels::new();
    let mut pending = Vec::new();
    for (need, model) in needs.iter().zip(needs.par_iter().map(cached).collect::<Vec<_>>()) {
        context.tally.add(Work::Models, model.is_some());
        match model {
            Some(model) => drop(made.insert(need.address, Ok(model))),
            None => pending.push(*need),
        }
    }
    let counted = counts_on_others(context, tracks, &pending)?;
    let make = |need: &&TrainingNeed<'_>| {
        let model = match make(context, tracks, need, counted.get(&need.variant_index)) {
            Ok(model) => Ok(model),
            Err(e) => Err(e.cell()?),
        };
        Ok((need.address, model))
    };
    let new = pending.par_iter().with_max_len(1).map(make).collect::<Result<Vec<_>, RunError>>()?;
    let mut records = Vec::new();
    for (need, (address, model)) in pending.iter().zip(new) {
        if let Ok(model) = &model {
            records.push(store::record(stored_name(context, need), need.recipe.clone(), 1, model)?);
        }
        made.insert(address, model);
    }
    context.put(records)?;
    Ok(made)
}

fn stored_name(context: &Context<'_>, need: &TrainingNeed<'_>) -> Name {
    let plan = context.plan;
    let tracker = &plan.experiment.trackers[need.tracker].label;
    let suite = need.tracks.first().map_or("", |(suite, ..)| plan.suites[*suite].name.as_str());
    let cell = format!("{suite}/{tracker}/{}[{}]", need.method.name, need.variant.params());
    let part =
        if need.variant.detector.trains_on_others() { format!(" fold {}", need.part) } else { String::new() };
    Name { experiment: plan.experiment.name.clone(), cell: cell + &part }
}

/// Counts of every candidate, by track.
type CountsOnTracks = BTreeMap<Place, Result<Vec<Counts>, CellError>>;

/// Counts of the candidates of variants that are trained on others, by variant: a track is training data of many parts,
/// and is judged once.
fn counts_on_others(
    context: &Context<'_>,
    tracks: &[Vec<Tracks>],
    pending: &[&TrainingNeed<'_>],
) -> Result<BTreeMap<usize, CountsOnTracks>, RunError> {
    let mut by_variant: BTreeMap<usize, Vec<&TrainingNeed<'_>>> = BTreeMap::new();
    for need in pending.iter().filter(|need| listed(need).is_some()) {
        by_variant.entry(need.variant_index).or_default().push(need);
    }
    let of_variant = |(v, needs): (usize, Vec<&TrainingNeed<'_>>)| {
        let places: BTreeSet<Place> = needs.iter().flat_map(|need| need.tracks.iter().copied()).collect();
        let Some((need, candidates)) = needs.first().and_then(|need| Some((need, listed(need)?))) else {
            return Ok((v, CountsOnTracks::new()));
        };
        let count = |place: &Place| {
            let (limits, protocol) = (&context.options.limits, need.method.protocol);
            let counts = match &tracks[place.0][place.1][place.2] {
                Ok(track) => choose::counts_of_candidates(candidates, track, need.signals, protocol, limits),
                Err(e) => Err(e.clone().into()),
            };
            Ok((*place, counts.map_or_else(|e| e.cell().map(Err), |counts| Ok(Ok(counts)))?))
        };
        let places: Vec<Place> = places.into_iter().collect();
        Ok((v, places.par_iter().map(count).collect::<Result<CountsOnTracks, RunError>>()?))
    };
    by_variant.into_iter().map(of_variant).collect()
}

/// The listed candidates of a parameter that is chosen on others without runs backwards.
fn listed<'n>(need: &'n TrainingNeed<'_>) -> Option<&'n [(f64, FixedDetector)]> {
    match &need.variant.detector {
        DetectorChoice::Trained(Training { candidates: Candidates::Listed(list), .. })
            if need.variant.detector.trains_on_others() && !need.variant.detector.needs_reverse() =>
        {
            Some(list)
        }
        _ => None,
    }
}

/// Makes a trained parameter or learned model.
fn make(
    context: &Context<'_>,
    tracks: &[Vec<Tracks>],
    need: &TrainingNeed<'_>,
    counted: Option<&CountsOnTracks>,
) -> Result<StoredModel, StepError> {
    let limits = &context.options.limits;
    let track = |(suite, s, j): &Place| tracks[*suite][*s][*j].clone();
    let mine = || need.tracks.iter().map(track).collect::<Result<Vec<Arc<Track>>, CellError>>();
    Ok(match &need.variant.detector {
        DetectorChoice::Given(_) => return Err(StepError::failed("nothing to learn")),
        DetectorChoice::Trained(training) => {
            let protocol = need.method.protocol;
            StoredModel::Chosen(match (counted, listed(need)) {
                (Some(counted), Some(candidates)) => {
                    let not_judged = || CellError::Failed("a training track was not judged".to_string());
                    let of = |place: &Place| match counted.get(place) {
                        Some(counts) => counts.as_ref().map_err(Clone::clone),
                        None => Err(not_judged()),
                    };
                    let counts = need.tracks.iter().map(of).collect::<Result<Vec<_>, CellError>>()?;
                    choose::choose(training, candidates, &counts, protocol)
                }
                _ => choose::train(training, mine()?, need.signals, protocol, limits)?,
            })
        }
        DetectorChoice::Learned(fixed) => {
            let origin = |(suite, s, _): &Place| context.plan.suites[*suite].sequences[*s].origin.clone();
            let tracks = need.tracks.iter().map(origin).zip(mine()?).collect();
            StoredModel::Learned(choose::learn(fixed, tracks, need.signals, limits)?)
        }
    })
}

/// The detector with its trained parameter or learned model.
fn instantiate(need: &TrainingNeed<'_>, model: StoredModel) -> Result<(ReadyDetector, Content), CellError> {
    let failed = |reason: String| CellError::Failed(format!("method {}: {reason}", need.method.name));
    match (&need.variant.detector, model) {
        (DetectorChoice::Trained(training), StoredModel::Chosen(chosen)) => {
            let value = chosen.values.get(chosen.index as usize).copied();
            let value = value.ok_or_else(|| failed("a record of its training is damaged".to_string()))?;
            let fixed = match &training.candidates {
                Candidates::Listed(list) => list.get(chosen.index as usize).map(|(_, fixed)| fixed.clone()),
                Candidates::Quantiles { build, .. } => Some(build(value).map_err(|e| failed(e.to_string()))?),
            };
            let fixed = fixed.ok_or_else(|| failed("a record of its training is damaged".to_string()))?;
            let content = Content::Chosen {
                parameter: training.key.clone(),
                value,
                maximise: training.maximise.name().to_string(),
                reached: chosen.reached,
                candidates: chosen.values.into_iter().zip(chosen.measures).collect(),
            };
            Ok((ReadyDetector { fixed, source: ParameterSource::Trained(need.address) }, content))
        }
        (DetectorChoice::Learned(fixed), StoredModel::Learned(text)) => {
            let model: Value = serde_json::from_str(&text).map_err(|e| failed(e.to_string()))?;
            let learner = fixed.detector.learner().ok_or_else(|| failed("does not learn".to_string()))?;
            let detector = Arc::from(learner.with_model(&model).map_err(|e| failed(e.to_string()))?);
            let fixed = FixedDetector { detector, ..fixed.clone() };
            let content = Content::Learned { model, threshold: fixed.detector.threshold() };
            Ok((ReadyDetector { fixed, source: ParameterSource::Learned(need.address) }, content))
        }
        _ => Err(failed("a record of its training is of another kind".to_string())),
    }
}

/// The model of a variant on a tracker, from its parts; `None` without any.
fn describe(context: &Context<'_>, contents: Vec<(&TrainingNeed<'_>, Content)>) -> Option<Model> {
    let plan = context.plan;
    let need = contents.first()?.0;
    let suite = &plan.suites[need.tracks.first()?.0];
    let on_others = need.variant.detector.trains_on_others();
    let model = |content: Content| Model {
        method: need.method.name.clone(),
        params: need.variant.params(),
        tracker: plan.experiment.trackers[need.tracker].label.clone(),
        runs: plan.experiment.trackers[need.tracker].training_runs,
        suite: suite.name.clone(),
        tuned_on_test: !on_others && plan.experiment.suites.get(TEST) == Some(&suite.name),
        sequences: suite.sequences.iter().map(|s| (s.sequence.name.clone(), s.digest.clone())).collect(),
        content,
    };
    let fold = |(need, content): (&TrainingNeed<'_>, Content)| {
        let names = suite.sequences.iter().enumerate();
        let left_out = names.filter(|(s, _)| plan.part(need.variant, *s) == need.part);
        let left_out = left_out.map(|(_, planned)| planned.sequence.name.clone()).collect();
        FoldContent { left_out, content }
    };
    Some(match on_others {
        true => model(Content::OnOthers { folds: contents.into_iter().map(fold).collect() }),
        false => model(contents.into_iter().next()?.1),
    })
}
