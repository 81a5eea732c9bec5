//! Training, detection and scoring: from tracks with their signals to judged cells.

use super::address::Address;
use super::pass::CellError;
use super::plan::variants;
use super::recipes::{self, By};
use super::run::{Context, RunError, Work};
use super::store::{self, Name, Record};
use super::supervise::{Limits, Watch, supervised};
use super::tracks::{Track, Tracks};
use crate::detector::{Detector, Input, Verdict};
use crate::score::measures::{Counts, Pooled};
use crate::score::{Protocol, TrackScore};
use crate::spec::TEST;
use crate::spec::method::{DetectorChoice, FixedDetector, Training};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// One method on one track, judged.
#[derive(Debug, Clone)]
pub struct Judged {
    /// What the detector said.
    pub verdict: Kept,
    /// What the protocol makes of it.
    pub score: TrackScore,
}

/// A verdict in memory, or where to find it.
#[derive(Debug, Clone)]
pub enum Kept {
    /// In memory.
    Here(Arc<Verdict>),
    /// In the store.
    Stored(Address),
}

/// A verdict as it is stored: without the score where that is the signal itself.
#[derive(Serialize, Deserialize)]
pub struct StoredVerdict {
    score: Option<Vec<f64>>,
    alarm: Vec<bool>,
    forecast: Option<Vec<f64>>,
    changes: Option<Vec<i32>>,
}

impl StoredVerdict {
    fn new(verdict: &Verdict, signal: &[f64]) -> Self {
        let bits = |v: &[f64]| v.iter().map(|v| v.to_bits()).collect::<Vec<_>>();
        let score = (bits(&verdict.score) != bits(signal)).then(|| verdict.score.clone());
        let Verdict { alarm, forecast, changes, .. } = verdict.clone();
        Self { score, alarm, forecast, changes }
    }

    /// The verdict on a signal, if it is one of its length.
    pub fn on(self, signal: &[f64]) -> Option<Verdict> {
        let score = self.score.unwrap_or_else(|| signal.to_vec());
        let whole = score.len() == signal.len()
            && self.alarm.len() == signal.len()
            && self.forecast.as_ref().is_none_or(|f| f.len() == signal.len())
            && self.changes.as_ref().is_none_or(|c| c.len() == signal.len());
        let Self { alarm, forecast, changes, .. } = self;
        whole.then_some(Verdict { score, alarm, forecast, changes })
    }
}

/// A threshold that was trained.
#[derive(Debug, Clone, Serialize)]
pub struct Model {
    /// Method.
    pub method: String,
    /// Grid point of the method, as in `scores.csv`.
    pub params: String,
    /// Tracker whose tracks it was trained on.
    pub tracker: String,
    /// The parameter.
    pub parameter: String,
    /// The chosen value.
    pub value: f64,
    /// What was made as large as possible.
    pub maximise: String,
    /// Its value at the choice; `null` when no candidate had one.
    pub reached: Option<f64>,
    /// The suite it was chosen on.
    pub suite: String,
    /// True when that suite is the one the results are about.
    pub tuned_on_test: bool,
    /// Sequences used, with their digests.
    pub sequences: Vec<(String, String)>,
    /// Every candidate with its value of the measure.
    pub candidates: Vec<(f64, Option<f64>)>,
}

/// Which candidate a training chose.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
struct Chosen {
    index: u64,
    reached: Option<f64>,
    /// The measure of every candidate.
    measures: Vec<Option<f64>>,
}

/// A detector that is ready, and where its parameters come from.
#[derive(Clone)]
pub struct Armed {
    /// The detector.
    pub fixed: FixedDetector,
    /// Address of the model, where it was trained.
    pub model: Option<Address>,
}

/// A detector for each variant and tracker; `Err` where training was impossible.
pub type Ready = Vec<Vec<Result<Armed, CellError>>>;

/// The signal of a track that a method reads; zeros for methods without one.
pub fn signal_of(track: &Track, signal: Option<usize>) -> std::borrow::Cow<'_, [f64]> {
    match signal.and_then(|k| track.signals.get(k)) {
        Some(series) => series.into(),
        None => vec![0.0; track.error.len()].into(),
    }
}

/// Makes every variant ready, training where that is asked for; `tracks` has those of every suite.
///
/// # Errors
/// When the run is interrupted or the store cannot be written to.
pub fn make_ready(context: &Context<'_>, tracks: &[Vec<Tracks>]) -> Result<(Ready, Vec<Model>), RunError> {
    let plan = context.plan;
    let trackers = plan.experiment.trackers.len();
    let variants: Vec<_> = variants(plan.experiment).collect();
    let places: Vec<(usize, usize)> =
        (0..variants.len()).flat_map(|v| (0..trackers).map(move |t| (v, t))).collect();
    type One = (Result<Armed, CellError>, Option<Model>);
    let one = |(v, t): (usize, usize)| -> Result<One, RunError> {
        let (method, variant) = variants[v];
        let training: &Training = match &variant.detector {
            DetectorChoice::Given(fixed) => {
                return Ok((Ok(Armed { fixed: fixed.clone(), model: None }), None));
            }
            DetectorChoice::Trained(training) => training,
        };
        let signal = plan.signal(v);
        let Some(suite) = plan.suite(&training.role) else {
            return Ok((Err(CellError::Missing(format!("no suite in role `{}`", training.role))), None));
        };
        let jobs = (0..plan.jobs.len()).filter(|j| plan.jobs[*j].tracker == t);
        let jobs: Vec<usize> = jobs.collect();
        let mine: Vec<Arc<Track>> = tracks[suite]
            .iter()
            .flat_map(|row| jobs.iter().filter_map(|j| row[*j].as_ref().ok().cloned()))
            .collect();
        let address = |suite: usize, s: usize, j: usize| tracks[suite][s][j].as_ref().ok().map(|t| t.address);
        let reads = plan.training_reads(training, signal, t, address);
        let recipe = recipes::model(plan.experiment, training, &reads);
        let address = recipe.address();
        let known = context.kept::<Chosen>(&address, 1);
        let known = known.filter(|c| (c.index as usize) < training.candidates.len());
        let chosen = match known {
            Some(chosen) => {
                context.tally.add(Work::Models, true);
                chosen
            }
            None => match train(training, mine, signal, plan.experiment.protocol, &context.options.limits)? {
                Err(e) => return Ok((Err(e), None)),
                Ok(chosen) => {
                    context.tally.add(Work::Models, false);
                    let tracker = &plan.experiment.trackers[t].label;
                    let cell = format!(
                        "{}/{tracker}/{}[{}]",
                        plan.suites[suite].name,
                        method.name,
                        variant.params()
                    );
                    let name = Name { experiment: plan.experiment.name.clone(), cell };
                    context.put(vec![store::record(name, recipe, 1, &chosen)?])?;
                    chosen
                }
            },
        };
        let (value, fixed) = &training.candidates[chosen.index as usize];
        let model = Model {
            method: method.name.clone(),
            params: variant.params(),
            tracker: plan.experiment.trackers[t].label.clone(),
            parameter: training.key.clone(),
            value: *value,
            maximise: training.maximise.name().to_string(),
            reached: chosen.reached,
            suite: plan.suites[suite].name.clone(),
            tuned_on_test: plan.experiment.suites.get(TEST) == Some(&plan.suites[suite].name),
            sequences: plan.suites[suite]
                .sequences
                .iter()
                .map(|s| (s.sequence.name.clone(), s.digest.clone()))
                .collect(),
            candidates: training.candidates.iter().map(|(v, _)| *v).zip(chosen.measures).collect(),
        };
        Ok((Ok(Armed { fixed: fixed.clone(), model: Some(address) }), Some(model)))
    };
    let done = places.into_par_iter().map(one).collect::<Result<Vec<_>, RunError>>()?;
    let mut ready: Ready = vec![Vec::with_capacity(trackers); variants.len()];
    let mut models = Vec::new();
    for (k, (armed, model)) in done.into_iter().enumerate() {
        ready[k / trackers.max(1)].push(armed);
        models.extend(model);
    }
    Ok((ready, models))
}

/// The candidate with the largest pooled measure; the first among equals.
fn train(
    training: &Training,
    tracks: Vec<Arc<Track>>,
    signal: Option<usize>,
    protocol: &'static Protocol,
    limits: &Limits,
) -> Result<Result<Chosen, CellError>, RunError> {
    if tracks.is_empty() {
        let message =
            format!("no track of the suite in role `{}` to train `{}` on", training.role, training.key);
        return Ok(Err(CellError::Missing(message)));
    }
    let candidates: Vec<Arc<dyn Detector>> =
        training.candidates.iter().map(|(_, d)| d.detector.clone()).collect();
    let maximise = training.maximise;
    let measure = move |detector: &dyn Detector| {
        let counts: Counts = tracks.iter().map(|t| detect(t, signal, detector, 0, protocol).1.counts).sum();
        Pooled { counts, score: None }.value(maximise)
    };
    let work = move |watch: &Watch, out: &[Option<String>]| {
        let mut measures = Vec::with_capacity(candidates.len());
        for candidate in &candidates {
            watch.go_on()?;
            if let Some(Some(reason)) = out.first() {
                return Ok(Err(reason.clone()));
            }
            match watch.step(0, || measure(&**candidate)) {
                Ok(measure) => measures.push(measure),
                Err(reason) => return Ok(Err(reason)),
            }
        }
        Ok(Ok(measures))
    };
    let measures = match supervised(1, limits, work)? {
        Ok(measures) => measures,
        Err(reason) => return Ok(Err(CellError::Failed(format!("training `{}`: {reason}", training.key)))),
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
        return Ok(Err(CellError::Failed(format!("there is no value to try for `{}`", training.key))));
    }
    Ok(Ok(Chosen { index: best.map_or(0, |(_, i)| i) as u64, reached: best.map(|(r, _)| r), measures }))
}

/// Detects and scores on one track. `seed` is for detectors that draw random numbers.
fn detect(
    track: &Track,
    signal: Option<usize>,
    detector: &dyn Detector,
    seed: u64,
    protocol: &Protocol,
) -> (Verdict, TrackScore) {
    let signal = signal_of(track, signal);
    let verdict = detector.detect(&Input { signal: &signal, error: &track.error, seed });
    let score = (protocol.score)(&track.error, &verdict.alarm, &verdict.changes());
    (verdict, score)
}

/// A cell that is to be judged.
#[derive(Clone)]
pub struct Case {
    /// Name in the store.
    pub name: Name,
    /// The track, if there is one.
    pub track: Arc<Track>,
    /// Which of its signals is read.
    pub signal: Option<usize>,
    /// The detector.
    pub armed: Armed,
    /// Its seed.
    pub seed: u64,
}

/// Judges cells, a result for each in order: with verdicts from the store where they are there.
///
/// # Errors
/// When the run is interrupted or the store cannot be written to.
pub fn judge(context: &Context<'_>, cases: Vec<Case>) -> Result<Vec<Result<Judged, CellError>>, RunError> {
    let plan = context.plan;
    let protocol = plan.experiment.protocol;
    let recipe = |case: &Case| {
        let read = plan.read(case.track.address, case.signal);
        let Armed { fixed, model } = &case.armed;
        let by = model.map_or_else(|| By::given(fixed), |address| By::model(address, fixed));
        recipes::labels(read, &by, case.seed)
    };
    let recipes: Vec<_> = cases.iter().map(recipe).collect();
    let kept = |(case, recipe): (&Case, &super::address::Recipe)| {
        let rows = case.track.error.len();
        let stored = context.kept::<StoredVerdict>(&recipe.address(), rows);
        stored.and_then(|v| v.on(&signal_of(&case.track, case.signal)))
    };
    let mut verdicts: Vec<Option<Result<Verdict, CellError>>> =
        cases.iter().zip(&recipes).map(|pair| kept(pair).map(Ok)).collect();
    verdicts.iter().for_each(|v| context.tally.add(Work::Labels, v.is_some()));
    let wanted: Vec<usize> = (0..cases.len()).filter(|k| verdicts[*k].is_none()).collect();
    if !wanted.is_empty() {
        let todo: Vec<Case> = wanted.iter().map(|k| cases[*k].clone()).collect();
        let work = move |watch: &Watch, out: &[Option<String>]| {
            let mut done = Vec::with_capacity(todo.len());
            for (k, (case, out)) in todo.iter().zip(out).enumerate() {
                watch.go_on()?;
                done.push(match out {
                    Some(reason) => Err(reason.clone()),
                    None => watch.step(k, || {
                        let signal = signal_of(&case.track, case.signal);
                        let input = Input { signal: &signal, error: &case.track.error, seed: case.seed };
                        case.armed.fixed.detector.detect(&input)
                    }),
                });
            }
            Ok(done)
        };
        let made = supervised(wanted.len(), &context.options.limits, work)?;
        let mut records: Vec<Record> = Vec::new();
        for (k, made) in wanted.into_iter().zip(made) {
            let case = &cases[k];
            let made = made.map_err(|reason| CellError::Failed(format!("{}: {reason}", case.name.cell)));
            if let Ok(verdict) = &made {
                let signal = signal_of(&case.track, case.signal);
                let content = StoredVerdict::new(verdict, &signal);
                records.push(store::record(case.name.clone(), recipes[k].clone(), signal.len(), &content)?);
            }
            verdicts[k] = Some(made);
        }
        context.put(records)?;
    }
    let judged = |((case, recipe), verdict): ((&Case, _), Option<Result<Verdict, CellError>>)| {
        let verdict = verdict.unwrap_or_else(|| Err(CellError::Failed("was not judged".to_string())))?;
        let score = (protocol.score)(&case.track.error, &verdict.alarm, &verdict.changes());
        Ok(Judged { verdict: context.hold(recipe, verdict), score })
    };
    Ok(cases.iter().zip(&recipes).zip(verdicts).map(judged).collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::detector::DETECTORS;
    use crate::engine::recipes::TRAINING;
    use crate::score::measures::Metric;

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
            maximise: Metric::FScore,
            candidates: [0.01, 0.2, 0.5, 0.9].map(candidate).to_vec(),
        };
        // One loss, at frame 20; below .2 and .5 find it, .01 never alarms, .9 does from the start.
        let step =
            |low: f64, high: f64| (0..30).map(|t| if t < 20 { low } else { high }).collect::<Vec<f64>>();
        let track = Track {
            address: Address([0; 32]),
            rects: vec![],
            error: step(0.2, 1.0),
            signals: vec![step(0.8, 0.1)],
            repeated: 0,
        };
        let protocol = crate::score::protocol("khalid2016/1").unwrap();
        let train = |tracks| train(&training, tracks, Some(0), protocol, &Limits::default()).unwrap();
        let chosen = train(vec![Arc::new(track)]).unwrap();
        let measures = vec![Some(0.0), Some(1.0), Some(1.0), Some(0.0)];
        assert_eq!(
            (TRAINING, chosen),
            (1, Chosen { index: 1, reached: Some(1.0), measures }),
            "raise TRAINING"
        );
        assert!(matches!(train(vec![]), Err(CellError::Missing(_))));
    }
}
