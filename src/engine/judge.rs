//! Training, detection and scoring: from tracks with their signals to judged cells.

use super::pass::{CellError, Job, Track, signal_index};
use crate::detector::{Detector, Input, Verdict};
use crate::score::measures::Counts;
use crate::score::{Protocol, TrackScore};
use crate::spec::Experiment;
use crate::spec::method::{DetectorChoice, SignalChoice, Training, Variant};
use serde::Serialize;
use std::sync::Arc;

/// One method on one track, judged.
#[derive(Debug, Clone)]
pub struct Judged {
    /// What the detector said.
    pub verdict: Verdict,
    /// What the protocol makes of it.
    pub score: TrackScore,
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

/// A variant of a method, ready to detect: one detector for each tracker.
pub struct Ready<'a> {
    /// Name of the method.
    pub method: &'a str,
    /// The variant.
    pub variant: &'a Variant,
    /// Which of the distinct signals it reads.
    pub signal: Option<usize>,
    /// A detector for each tracker of the experiment; `Err` where training was impossible.
    pub detectors: Vec<Result<Arc<dyn Detector>, CellError>>,
}

/// The tracks of one suite: sequences x jobs.
#[derive(Clone)]
pub struct SuiteTracks {
    /// Name of the suite.
    pub suite: String,
    /// Name and digest of each sequence.
    pub sequences: Vec<(String, String)>,
    /// Results of each sequence, one a job.
    pub tracks: Vec<Vec<Result<Track, CellError>>>,
}

impl SuiteTracks {
    /// A suite without tracks.
    pub fn new(suite: &str) -> Self {
        Self { suite: suite.to_string(), sequences: Vec::new(), tracks: Vec::new() }
    }
}

/// Makes every variant ready, training where that is asked for; `suite` gives the tracks of a role.
pub fn make_ready<'a, 't>(
    experiment: &'a Experiment,
    signals: &[SignalChoice],
    jobs: &[Job<'_>],
    suite: &dyn Fn(&str) -> &'t SuiteTracks,
) -> (Vec<Ready<'a>>, Vec<Model>) {
    let mut models = Vec::new();
    let mut ready = Vec::new();
    for method in &experiment.methods {
        for variant in &method.variants {
            let signal = variant.signal.as_ref().and_then(|s| signal_index(signals, s));
            let mut detectors = Vec::new();
            for (k, tracker) in experiment.trackers.iter().enumerate() {
                detectors.push(match &variant.detector {
                    DetectorChoice::Given(fixed) => Ok(fixed.detector.clone()),
                    DetectorChoice::Trained(training) => {
                        let data = suite(&training.role);
                        let tracks: Vec<&Track> = data
                            .tracks
                            .iter()
                            .flat_map(|tracks| tracks.iter().zip(jobs).filter(|(_, job)| job.index == k))
                            .filter_map(|(track, _)| track.as_ref().ok())
                            .collect();
                        train(training, &tracks, signal, experiment.protocol).map(|chosen| {
                            models.push(Model {
                                method: method.name.clone(),
                                params: variant.params(),
                                tracker: tracker.label.clone(),
                                parameter: training.key.clone(),
                                value: chosen.value,
                                maximise: training.maximise.name().to_string(),
                                reached: chosen.reached,
                                suite: data.suite.clone(),
                                tuned_on_test: experiment.suites.get(crate::spec::TEST) == Some(&data.suite),
                                sequences: data.sequences.clone(),
                                candidates: chosen.candidates,
                            });
                            chosen.detector
                        })
                    }
                });
            }
            ready.push(Ready { method: &method.name, variant, signal, detectors });
        }
    }
    (ready, models)
}

struct Chosen {
    value: f64,
    reached: Option<f64>,
    detector: Arc<dyn Detector>,
    candidates: Vec<(f64, Option<f64>)>,
}

/// The candidate with the largest pooled measure; the first among equals.
fn train(
    training: &Training,
    tracks: &[&Track],
    signal: Option<usize>,
    protocol: &Protocol,
) -> Result<Chosen, CellError> {
    if tracks.is_empty() {
        let message =
            format!("no track of the suite in role `{}` to train `{}` on", training.role, training.key);
        return Err(CellError::Missing(message));
    }
    let mut best: Option<(f64, usize)> = None;
    let mut candidates = Vec::new();
    for (i, (value, fixed)) in training.candidates.iter().enumerate() {
        let counts: Counts =
            tracks.iter().map(|t| judge(t, signal, &*fixed.detector, 0, protocol).score.counts).sum();
        let pooled = crate::score::measures::Pooled { counts, score: None };
        let reached = pooled.value(training.maximise);
        candidates.push((*value, reached));
        if let Some(reached) = reached
            && best.is_none_or(|(most, _)| reached > most)
        {
            best = Some((reached, i));
        }
    }
    let index = best.map_or(0, |(_, i)| i);
    let Some((value, fixed)) = training.candidates.get(index) else {
        return Err(CellError::Failed(format!("there is no value to try for `{}`", training.key)));
    };
    let (reached, detector) = (best.map(|(r, _)| r), fixed.detector.clone());
    Ok(Chosen { value: *value, reached, detector, candidates })
}

/// Detects and scores on one track. `seed` is for detectors that draw random numbers.
pub fn judge(
    track: &Track,
    signal: Option<usize>,
    detector: &dyn Detector,
    seed: u64,
    protocol: &Protocol,
) -> Judged {
    let silent;
    let signal = match signal {
        Some(i) => &track.signals[i],
        None => {
            silent = vec![0.0; track.error.len()];
            &silent
        }
    };
    let verdict = detector.detect(&Input { signal, error: &track.error, seed });
    let score = (protocol.score)(&track.error, &verdict.alarm);
    Judged { verdict, score }
}
