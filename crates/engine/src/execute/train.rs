//! Training and learning: from the tracks of a suite to detectors with parameters and models.

use super::context::Context;
use super::judge::{ParameterSource, ReadyDetector, detect};
use super::reverse::Reversal;
use super::supervise::{JobError, Watchdog, run_single, supervised};
use super::track::{self, Track, Tracks};
use super::tracker_run::TrackingError;
use crate::detector::{Detector, Example};
use crate::error::{CellError, RunError, StepError};
use crate::limits::RunLimits;
use crate::observe::tally::Work;
use crate::plan::{recipes, variants};
use crate::plugin::ParamError;
use crate::score::Protocol;
use crate::score::{Counts, Pooled};
use crate::spec::TEST;
use crate::spec::method::{Candidates, DetectorChoice, FixedDetector, Method, Training, Variant};
use crate::store::address::{Address, Recipe};
use crate::store::{self, Name};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use serde_json::Value;
use std::collections::BTreeMap;
use std::sync::Arc;

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

/// A detector for each variant and tracker; an error where training was impossible.
pub type ReadyDetectors = Vec<Vec<Result<ReadyDetector, CellError>>>;

/// Training that a variant needs on a tracker.
struct TrainingNeed<'a> {
    method: &'a Method,
    variant: &'a Variant,
    signal: Option<usize>,
    suite: usize,
    tracker: usize,
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
    let model = |need: &&TrainingNeed<'_>| match make(context, tracks, need) {
        Ok(model) => Ok((need.address, Ok(model))),
        Err(e) => Ok((need.address, Err(e.cell()?))),
    };
    let made = distinct.par_iter().with_max_len(1).map(model);
    let made: BTreeMap<Address, Result<StoredModel, CellError>> = made.collect::<Result<_, RunError>>()?;
    let mut ready: ReadyDetectors = Vec::with_capacity(variants.len());
    let mut models = Vec::new();
    for (v, (_, variant)) in variants.iter().enumerate() {
        let mut row = Vec::with_capacity(plan.experiment.trackers.len());
        for tracker in 0..plan.experiment.trackers.len() {
            let need = match (&variant.detector, needs.get(&(v, tracker))) {
                (DetectorChoice::Given(fixed), _) => {
                    row.push(Ok(ReadyDetector { fixed: fixed.clone(), source: ParameterSource::Given }));
                    continue;
                }
                (_, Some(Ok(need))) => need,
                (_, Some(Err(e))) => {
                    row.push(Err(e.clone()));
                    continue;
                }
                (_, None) => {
                    row.push(Err(CellError::Missing("not run on this tracker".to_string())));
                    continue;
                }
            };
            let model = made.get(&need.address).cloned();
            let model = model.unwrap_or_else(|| Err(CellError::Failed("was not trained".to_string())));
            row.push(match model.and_then(|model| instantiate(need, model)) {
                Ok((ready_detector, content)) => {
                    models.push(describe(context, need, content));
                    Ok(ready_detector)
                }
                Err(e) => Err(e),
            });
        }
        ready.push(row);
    }
    Ok((ready, models))
}

type Needs<'a> = BTreeMap<(usize, usize), Result<TrainingNeed<'a>, CellError>>;

/// All needs for training, by variant and tracker.
fn needs<'a>(context: &'a Context<'_>, tracks: &[Vec<Tracks>]) -> Needs<'a> {
    let plan = context.plan;
    let mut needs = Needs::new();
    for (v, (method, variant)) in variants(plan.experiment).enumerate() {
        let Some(role) = variant.detector.role() else { continue };
        for (t, tracker) in plan.experiment.trackers.iter().enumerate() {
            if !method.runs_on(&tracker.label) {
                continue;
            }
            let need = || {
                let missing = || CellError::Missing(format!("no track in role `{role}` to learn from"));
                let suite = plan.suite(role).ok_or_else(missing)?;
                let signal = plan.signal(v);
                let is_there = |suite: usize, s: usize, j: usize| tracks[suite][s][j].is_ok();
                let reads = plan.training_reads(role, signal, t, is_there);
                let recipe = recipes::of_model(method, variant, &reads).filter(|_| !reads.is_empty());
                let recipe = recipe.ok_or_else(missing)?;
                Ok(TrainingNeed {
                    method,
                    variant,
                    signal,
                    suite,
                    tracker: t,
                    address: recipe.address(),
                    recipe,
                })
            };
            needs.insert((v, t), need());
        }
    }
    needs
}

/// The trained parameter or learned model: from the store, or made.
fn make(
    context: &Context<'_>,
    tracks: &[Vec<Tracks>],
    need: &TrainingNeed<'_>,
) -> Result<StoredModel, StepError> {
    if let Some(model) = context.cached::<StoredModel>(&need.address, 1) {
        context.tally.add(Work::Models, true);
        return Ok(model);
    }
    let plan = context.plan;
    let mine = track::learned_from(plan, tracks, need.suite, need.tracker, need.signal);
    let mine: Vec<Arc<Track>> = mine.into_iter().map(|(track, ..)| track).collect();
    let limits = &context.options.limits;
    let model = match &need.variant.detector {
        DetectorChoice::Given(_) => return Err(StepError::failed("nothing to learn")),
        DetectorChoice::Trained(training) => {
            StoredModel::Chosen(train(training, mine, need.signal, need.method.protocol, limits)?)
        }
        DetectorChoice::Learned(fixed) => StoredModel::Learned(learn(fixed, mine, need.signal, limits)?),
    };
    context.tally.add(Work::Models, false);
    let tracker = &plan.experiment.trackers[need.tracker].label;
    let suite = &plan.suites[need.suite].name;
    let cell = format!("{suite}/{tracker}/{}[{}]", need.method.name, need.variant.params());
    let name = Name { experiment: plan.experiment.name.clone(), cell };
    context.put(vec![store::record(name, need.recipe.clone(), 1, &model)?])?;
    Ok(model)
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

fn describe(context: &Context<'_>, need: &TrainingNeed<'_>, content: Content) -> Model {
    let plan = context.plan;
    let (suite, tracker) = (&plan.suites[need.suite], &plan.experiment.trackers[need.tracker]);
    Model {
        method: need.method.name.clone(),
        params: need.variant.params(),
        tracker: tracker.label.clone(),
        runs: tracker.training_runs,
        suite: suite.name.clone(),
        tuned_on_test: plan.experiment.suites.get(TEST) == Some(&suite.name),
        sequences: suite.sequences.iter().map(|s| (s.sequence.name.clone(), s.digest.clone())).collect(),
        content,
    }
}

/// The model that a learner makes from tracks, as JSON text.
fn learn(
    fixed: &FixedDetector,
    tracks: Vec<Arc<Track>>,
    signal: Option<usize>,
    limits: &RunLimits,
) -> Result<String, StepError> {
    let (kind, detector) = (fixed.kind, fixed.detector.clone());
    let learn = move || -> Result<Value, StepError> {
        let examples: Vec<Example<'_>> = tracks.iter().map(|t| t.example(signal)).collect();
        let learner = detector.learner().ok_or_else(|| StepError::failed("it does not learn"))?;
        learner.learn(&examples).map_err(StepError::failed)
    };
    let model = run_single(limits, learn).map_err(|e| e.within(&format!("learning of {kind}")))?;
    Ok(model.to_string())
}

/// The candidate with the largest pooled measure; the first among equals.
fn train(
    training: &Training,
    tracks: Vec<Arc<Track>>,
    signal: Option<usize>,
    protocol: &'static Protocol,
    limits: &RunLimits,
) -> Result<Chosen, StepError> {
    let within = |e: StepError| e.within(&format!("training `{}`", training.key));
    let candidates = candidates(training, &tracks, signal).map_err(|e| within(StepError::failed(e)))?;
    if candidates.is_empty() {
        return Err(within(StepError::failed("there is no value to try")));
    }
    let values: Vec<f64> = candidates.iter().map(|(value, _)| *value).collect();
    let candidates: Vec<Arc<dyn Detector>> = candidates.into_iter().map(|(_, d)| d.detector).collect();
    if training.example.detector.needs_reverse() {
        run_backwards(&tracks, &candidates, signal, limits)?;
    }
    let (maximise, learned) = (training.maximise, tracks.clone());
    let measure = move |detector: &dyn Detector| -> Result<Option<f64>, TrackingError> {
        let count = |t: &Arc<Track>| {
            let output = detect(t, signal, detector, 0)?;
            Ok((protocol.score)(&t.error, &output.alarm, &output.changes()).counts)
        };
        let counts: Counts = tracks.iter().map(count).sum::<Result<_, TrackingError>>()?;
        Ok(maximise.value(&Pooled { counts, chance: Some(protocol.chance), ..Pooled::default() }))
    };
    let work = move |watch: &Watchdog, left_out: &[Option<JobError>]| {
        let mut measures = Vec::with_capacity(candidates.len());
        for candidate in &candidates {
            watch.check_interrupted()?;
            if let Some(Some(reason)) = left_out.first() {
                return Err(StepError::from(reason.clone()));
            }
            measures.push(watch.step(0, || measure(&**candidate))?);
        }
        Ok(measures)
    };
    let measures = supervised(1, limits, work);
    learned.iter().filter_map(|t| t.reversal.as_deref()).for_each(Reversal::free_trackers);
    let measures = measures.map_err(within)?;
    let mut best: Option<(f64, usize)> = None;
    for (i, reached) in measures.iter().enumerate() {
        if let Some(reached) = *reached
            && best.is_none_or(|(most, _)| reached > most)
        {
            best = Some((reached, i));
        }
    }
    Ok(Chosen { index: best.map_or(0, |(_, i)| i) as u64, reached: best.map(|(r, _)| r), values, measures })
}

/// Makes the reverse runs of all candidates on all cores; training, which has one thread, then reuses their errors. A
/// run that fails here fails again in training, where the failure is reported.
fn run_backwards(
    tracks: &[Arc<Track>],
    candidates: &[Arc<dyn Detector>],
    signal: Option<usize>,
    limits: &RunLimits,
) -> Result<(), RunError> {
    let run = |track: &Arc<Track>| {
        let (track, candidates) = (track.clone(), candidates.to_vec());
        let detect_all = move || -> Result<(), StepError> {
            candidates
                .iter()
                .try_for_each(|c| detect(&track, signal, &**c, 0).map(|_| ()).map_err(StepError::from))
        };
        match run_single(limits, detect_all) {
            Ok(()) => Ok(()),
            Err(e) => e.cell().map(|_| ()),
        }
    };
    tracks.par_iter().with_max_len(1).try_for_each(run)
}

/// Values to try with their detectors, ascending.
fn candidates(
    training: &Training,
    tracks: &[Arc<Track>],
    signal: Option<usize>,
) -> Result<Vec<(f64, FixedDetector)>, ParamError> {
    let (count, build) = match &training.candidates {
        Candidates::Listed(list) => return Ok(list.clone()),
        Candidates::Quantiles { count, build } => (*count, build),
    };
    let mut values: Vec<f64> = tracks.iter().flat_map(|t| t.signal(signal).into_owned()).collect();
    values.sort_by(f64::total_cmp);
    let Some(last) = values.len().checked_sub(1) else { return Ok(Vec::new()) };
    // Values that were seen, so that nothing depends on how quantiles are interpolated.
    let mut tried: Vec<f64> = (0..count).map(|k| values[k * last / (count - 1)]).collect();
    tried.dedup();
    tried.into_iter().map(|value| Ok((value, build(value)?))).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::detector::DETECTORS;
    use crate::plan::recipes::TRAINING;
    use crate::score::Metric;

    #[test]
    fn training_takes_the_first_of_the_best_in_the_way_of_its_version() {
        let candidate = |below: f64| {
            let entry = crate::plugin::find(DETECTORS, "level").unwrap();
            let detector = Arc::from(entry.build_from_text(&format!("{{ below = {below} }}")).unwrap());
            (below, FixedDetector { kind: entry.kind, version: entry.version, detector })
        };
        let training = Training {
            key: "below".into(),
            role: "train".into(),
            maximise: Metric::F_SCORE,
            candidates: Candidates::Listed([0.01, 0.2, 0.5, 0.9].map(candidate).to_vec()),
            example: candidate(0.01).1,
        };
        // One loss, at frame 20; below .2 and .5 find it, .01 never alarms, .9 does from the start.
        let step =
            |low: f64, high: f64| (0..30).map(|t| if t < 20 { low } else { high }).collect::<Vec<f64>>();
        let track = Track {
            regions: vec![],
            status: vec![],
            error: step(0.2, 1.0),
            signals: vec![step(0.8, 0.1)],
            repeated: 0,
            reversal: None,
        };
        let protocol = crate::score::protocol("khalid2016/1").unwrap();
        let train = |tracks| train(&training, tracks, Some(0), protocol, &RunLimits::default()).unwrap();
        let chosen = train(vec![Arc::new(track)]);
        let measures = vec![Some(0.0), Some(1.0), Some(1.0), Some(0.0)];
        let values = vec![0.01, 0.2, 0.5, 0.9];
        assert_eq!(
            (TRAINING, chosen),
            (2, Chosen { index: 1, reached: Some(1.0), values, measures }),
            "raise TRAINING"
        );
    }
}
