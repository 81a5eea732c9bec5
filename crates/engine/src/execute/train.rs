//! Training and learning: from the tracks of a suite to detectors that are ready.

use super::context::Context;
use super::judge::{ReadyDetector, Source, detect};
use super::reverse::Reversal;
use super::supervise::{Watchdog, run_single, supervised};
use super::track::{self, Track, Tracks};
use crate::detector::{Detector, Example};
use crate::error::{CellError, RunError};
use crate::limits::RunLimits;
use crate::observe::tally::Work;
use crate::plan::{recipes, variants};
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

/// What was trained or learned, for one method on one tracker.
#[derive(Debug, Clone, Serialize)]
pub struct Model {
    /// Method.
    pub method: String,
    /// Grid point of the method, as in `scores.csv`.
    pub params: String,
    /// Tracker whose tracks it was learned from.
    pub tracker: String,
    /// Repetitions of the tracker.
    pub runs: u32,
    /// The suite it was learned on.
    pub suite: String,
    /// True when that suite is the one the results are about.
    pub tuned_on_test: bool,
    /// Sequences used, with their digests.
    pub sequences: Vec<(String, String)>,
    /// What came out.
    #[serde(flatten)]
    pub content: Content,
}

/// What came out of training or learning.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[serde(untagged)]
pub enum Content {
    /// A parameter was chosen.
    Chosen {
        /// The parameter.
        parameter: String,
        /// The chosen value.
        value: f64,
        /// What was made as large as possible.
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

/// Which candidate a training chose.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
struct Chosen {
    index: u64,
    reached: Option<f64>,
    /// The candidates.
    values: Vec<f64>,
    /// The measure of each.
    measures: Vec<Option<f64>>,
}

/// What is kept under a model's address.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
enum StoredModel {
    Chosen(Chosen),
    /// JSON text.
    Learned(String),
}

/// A detector for each variant and tracker; `Err` where training was impossible.
pub type ReadyDetectors = Vec<Vec<Result<ReadyDetector, CellError>>>;

/// A variant on a tracker that has something to learn, and what from.
struct Need<'a> {
    method: &'a Method,
    variant: &'a Variant,
    signal: Option<usize>,
    suite: usize,
    tracker: usize,
    address: Address,
    recipe: Recipe,
}

/// Makes every variant ready, training and learning where that is asked for; `tracks` has those of every
/// suite.
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
    // Variants that differ in what the model does not depend on share one; it is made once.
    let mut distinct: BTreeMap<Address, &Need<'_>> = BTreeMap::new();
    for need in needs.values().flatten() {
        distinct.entry(need.address).or_insert(need);
    }
    let distinct: Vec<&Need<'_>> = distinct.into_values().collect();
    let made =
        distinct.par_iter().with_max_len(1).map(|need| Ok((need.address, make(context, tracks, need)?)));
    let made: BTreeMap<Address, Result<StoredModel, CellError>> = made.collect::<Result<_, RunError>>()?;
    let mut ready: ReadyDetectors = Vec::with_capacity(variants.len());
    let mut models = Vec::new();
    for (v, (_, variant)) in variants.iter().enumerate() {
        let mut row = Vec::with_capacity(plan.experiment.trackers.len());
        for tracker in 0..plan.experiment.trackers.len() {
            let need = match (&variant.detector, needs.get(&(v, tracker))) {
                (DetectorChoice::Given(fixed), _) => {
                    row.push(Ok(ReadyDetector { fixed: fixed.clone(), source: Source::Given }));
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
            let kept = made.get(&need.address).cloned();
            let kept = kept.unwrap_or_else(|| Err(CellError::Failed("was not trained".to_string())));
            row.push(match kept.and_then(|kept| instantiate(need, kept)) {
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

type Needs<'a> = BTreeMap<(usize, usize), Result<Need<'a>, CellError>>;

/// What has to be learned, by variant and tracker.
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
                let address =
                    |suite: usize, s: usize, j: usize| tracks[suite][s][j].as_ref().ok().map(|t| t.address);
                let reads = plan.training_reads(role, signal, t, address);
                let recipe = recipes::of_model(method, variant, &reads).filter(|_| !reads.is_empty());
                let recipe = recipe.ok_or_else(missing)?;
                Ok(Need { method, variant, signal, suite, tracker: t, address: recipe.address(), recipe })
            };
            needs.insert((v, t), need());
        }
    }
    needs
}

/// What is kept under a need's address: from the store, or made.
fn make(
    context: &Context<'_>,
    tracks: &[Vec<Tracks>],
    need: &Need<'_>,
) -> Result<Result<StoredModel, CellError>, RunError> {
    if let Some(kept) = context.cached::<StoredModel>(&need.address, 1) {
        context.tally.add(Work::Models, true);
        return Ok(Ok(kept));
    }
    let plan = context.plan;
    let mine = track::learned_from(plan, tracks, need.suite, need.tracker);
    let mine: Vec<Arc<Track>> = mine.into_iter().map(|(track, ..)| track).collect();
    let limits = &context.options.limits;
    let made = match &need.variant.detector {
        DetectorChoice::Given(_) => return Ok(Err(CellError::Failed("nothing to learn".to_string()))),
        DetectorChoice::Trained(training) => {
            train(training, mine, need.signal, need.method.protocol, limits)?.map(StoredModel::Chosen)
        }
        DetectorChoice::Learned(fixed) => learn(fixed, mine, need.signal, limits)?.map(StoredModel::Learned),
    };
    if let Ok(kept) = &made {
        context.tally.add(Work::Models, false);
        let tracker = &plan.experiment.trackers[need.tracker].label;
        let suite = &plan.suites[need.suite].name;
        let cell = format!("{suite}/{tracker}/{}[{}]", need.method.name, need.variant.params());
        let name = Name { experiment: plan.experiment.name.clone(), cell };
        context.put(vec![store::record(name, need.recipe.clone(), 1, kept)?])?;
    }
    Ok(made)
}

/// The detector with what was trained or learned.
fn instantiate(need: &Need<'_>, kept: StoredModel) -> Result<(ReadyDetector, Content), CellError> {
    let failed = |reason: String| CellError::Failed(format!("method {}: {reason}", need.method.name));
    match (&need.variant.detector, kept) {
        (DetectorChoice::Trained(training), StoredModel::Chosen(chosen)) => {
            let value = chosen.values.get(chosen.index as usize).copied();
            let value = value.ok_or_else(|| failed("a record of its training is damaged".to_string()))?;
            let fixed = match &training.candidates {
                Candidates::Listed(list) => list.get(chosen.index as usize).map(|(_, fixed)| fixed.clone()),
                Candidates::Quantiles { make, .. } => Some(make(value).map_err(failed)?),
            };
            let fixed = fixed.ok_or_else(|| failed("a record of its training is damaged".to_string()))?;
            let content = Content::Chosen {
                parameter: training.key.clone(),
                value,
                maximise: training.maximise.name().to_string(),
                reached: chosen.reached,
                candidates: chosen.values.into_iter().zip(chosen.measures).collect(),
            };
            Ok((ReadyDetector { fixed, source: Source::Trained(need.address) }, content))
        }
        (DetectorChoice::Learned(fixed), StoredModel::Learned(text)) => {
            let model: Value = serde_json::from_str(&text).map_err(|e| failed(e.to_string()))?;
            let learner = fixed.detector.learner().ok_or_else(|| failed("does not learn".to_string()))?;
            let detector = Arc::from(learner.with_model(&model).map_err(|e| failed(e.to_string()))?);
            let fixed = FixedDetector { detector, ..fixed.clone() };
            let content = Content::Learned { model, threshold: fixed.detector.threshold() };
            Ok((ReadyDetector { fixed, source: Source::Learned(need.address) }, content))
        }
        _ => Err(failed("a record of its training is of another kind".to_string())),
    }
}

fn describe(context: &Context<'_>, need: &Need<'_>, content: Content) -> Model {
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

/// What a learner makes of tracks, as JSON text.
fn learn(
    fixed: &FixedDetector,
    tracks: Vec<Arc<Track>>,
    signal: Option<usize>,
    limits: &RunLimits,
) -> Result<Result<String, CellError>, RunError> {
    let (kind, detector) = (fixed.kind, fixed.detector.clone());
    let learn = move || {
        let examples: Vec<Example<'_>> = tracks.iter().map(|t| t.example(signal)).collect();
        detector.learner().ok_or("it does not learn")?.learn(&examples).map_err(|e| e.to_string())
    };
    let failed = |reason: String| CellError::Failed(format!("learning of {kind}: {reason}"));
    Ok(run_single(limits, learn)?.map(|model| model.to_string()).map_err(failed))
}

/// The candidate with the largest pooled measure; the first among equals.
fn train(
    training: &Training,
    tracks: Vec<Arc<Track>>,
    signal: Option<usize>,
    protocol: &'static Protocol,
    limits: &RunLimits,
) -> Result<Result<Chosen, CellError>, RunError> {
    let failed = |reason: String| CellError::Failed(format!("training `{}`: {reason}", training.key));
    let candidates = match candidates(training, &tracks, signal) {
        Ok(candidates) => candidates,
        Err(reason) => return Ok(Err(failed(reason))),
    };
    let values: Vec<f64> = candidates.iter().map(|(value, _)| *value).collect();
    let candidates: Vec<Arc<dyn Detector>> = candidates.into_iter().map(|(_, d)| d.detector).collect();
    let maximise = training.maximise;
    if training.example.detector.needs_reverse() {
        // What is run backwards here, on all cores, is not run again below; what breaks here breaks there too.
        let run = |track: &Arc<Track>| {
            let (track, candidates) = (track.clone(), candidates.clone());
            run_single(limits, move || {
                candidates.iter().try_for_each(|c| detect(&track, signal, &**c, 0).map(|_| ()))
            })
        };
        tracks.par_iter().with_max_len(1).try_for_each(|track| run(track).map(|_| ()))?;
    }
    let learned = tracks.clone();
    let measure = move |detector: &dyn Detector| -> Result<Option<f64>, String> {
        let count = |t: &Arc<Track>| {
            let verdict = detect(t, signal, detector, 0)?;
            Ok((protocol.score)(&t.error, &verdict.alarm, &verdict.changes()).counts)
        };
        let counts: Counts = tracks.iter().map(count).sum::<Result<_, String>>()?;
        Ok(maximise.value(&Pooled { counts, chance: Some(protocol.chance), ..Pooled::default() }))
    };
    let work = move |watch: &Watchdog, out: &[Option<String>]| {
        let mut measures = Vec::with_capacity(candidates.len());
        for candidate in &candidates {
            watch.check_interrupted()?;
            if let Some(Some(reason)) = out.first() {
                return Ok(Err(reason.clone()));
            }
            match watch.step(0, || measure(&**candidate)).flatten() {
                Ok(measure) => measures.push(measure),
                Err(reason) => return Ok(Err(reason)),
            }
        }
        Ok(Ok(measures))
    };
    let judged = supervised(1, limits, work)?;
    learned.iter().filter_map(|t| t.reversal.as_deref()).for_each(Reversal::rest);
    let measures = match judged {
        Ok(measures) => measures,
        Err(reason) => return Ok(Err(failed(reason))),
    };
    let mut best: Option<(f64, usize)> = None;
    for (i, reached) in measures.iter().enumerate() {
        if let Some(reached) = *reached
            && best.is_none_or(|(most, _)| reached > most)
        {
            best = Some((reached, i));
        }
    }
    if measures.is_empty() {
        return Ok(Err(failed("there is no value to try".to_string())));
    }
    Ok(Ok(Chosen {
        index: best.map_or(0, |(_, i)| i) as u64,
        reached: best.map(|(r, _)| r),
        values,
        measures,
    }))
}

/// Values to try with their detectors, ascending.
fn candidates(
    training: &Training,
    tracks: &[Arc<Track>],
    signal: Option<usize>,
) -> Result<Vec<(f64, FixedDetector)>, String> {
    let (count, make) = match &training.candidates {
        Candidates::Listed(list) => return Ok(list.clone()),
        Candidates::Quantiles { count, make } => (*count, make),
    };
    let mut values: Vec<f64> = tracks.iter().flat_map(|t| t.signal(signal).into_owned()).collect();
    values.sort_by(f64::total_cmp);
    let Some(last) = values.len().checked_sub(1) else { return Ok(Vec::new()) };
    // Values that were seen, so that nothing depends on how quantiles are interpolated.
    let mut tried: Vec<f64> = (0..count).map(|k| values[k * last / (count - 1)]).collect();
    tried.dedup();
    tried.into_iter().map(|value| Ok((value, make(value)?))).collect()
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
            address: Address([0; 32]),
            regions: vec![],
            status: vec![],
            error: step(0.2, 1.0),
            signals: vec![step(0.8, 0.1)],
            repeated: 0,
            reversal: None,
        };
        let protocol = crate::score::protocol("khalid2016/1").unwrap();
        let train = |tracks| train(&training, tracks, Some(0), protocol, &RunLimits::default()).unwrap();
        let chosen = train(vec![Arc::new(track)]).unwrap();
        let measures = vec![Some(0.0), Some(1.0), Some(1.0), Some(0.0)];
        let values = vec![0.01, 0.2, 0.5, 0.9];
        assert_eq!(
            (TRAINING, chosen),
            (2, Chosen { index: 1, reached: Some(1.0), values, measures }),
            "raise TRAINING"
        );
    }
}
