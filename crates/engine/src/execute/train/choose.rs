//! The choice of a parameter among candidates, and the learning of a model, from tracks.

use super::Chosen;
use crate::error::{RunError, StepError};
use crate::execute::judge::detect;
use crate::execute::reverse::Reversal;
use crate::execute::supervise::{JobError, Watchdog, run_single, supervised};
use crate::execute::track::Track;
use crate::execute::tracker_run::TrackingError;
use crate::limits::RunLimits;
use crate::plan::SignalSet;
use crate::spec::method::{Candidates, FixedDetector, Training};
use rayon::prelude::*;
use serde_json::Value;
use std::sync::Arc;
use trackfail_core::plugin::ParamError;
use trackfail_dataset::suite::Origin;
use trackfail_methods::detector::Example;
use trackfail_methods::score::{Counts, Pooled, Protocol};

/// The model that a learner makes from tracks, each with its origin, as JSON text.
pub fn learn(
    fixed: &FixedDetector,
    tracks: Vec<(Origin, Arc<Track>)>,
    signals: &SignalSet,
    limits: &RunLimits,
) -> Result<String, StepError> {
    let (kind, detector, signals) = (fixed.kind, fixed.detector.clone(), signals.clone());
    let learn = move || -> Result<Value, StepError> {
        let examples = tracks.iter().map(|(origin, track)| track.example_of(&signals, origin));
        let examples: Vec<Example<'_>> = examples.collect();
        let learner = detector.learner().ok_or_else(|| StepError::failed("it does not learn"))?;
        learner.learn(&examples).map_err(StepError::failed)
    };
    let model = run_single(limits, learn).map_err(|e| e.within(&format!("learning of {kind}")))?;
    Ok(model.to_string())
}

/// The candidate with the largest pooled measure; the first among equals.
pub fn train(
    training: &Training,
    tracks: Vec<Arc<Track>>,
    signals: &SignalSet,
    protocol: &'static Protocol,
    limits: &RunLimits,
) -> Result<Chosen, StepError> {
    let within = |e: StepError| e.within(&format!("training `{}`", training.key));
    let candidates = candidates(training, &tracks, signals).map_err(|e| within(StepError::failed(e)))?;
    if candidates.is_empty() {
        return Err(within(StepError::failed("there is no value to try")));
    }
    let values: Vec<f64> = candidates.iter().map(|(value, _)| *value).collect();
    let candidates: Vec<FixedDetector> = candidates.into_iter().map(|(_, fixed)| fixed).collect();
    if training.example.detector.needs_reverse() {
        run_backwards(&tracks, &candidates, signals, limits)?;
    }
    let (learned, signals) = (tracks.clone(), signals.clone());
    let pooled = move |fixed: &FixedDetector| -> Result<Counts, TrackingError> {
        tracks.iter().map(|track| counts(track, &signals, fixed, protocol)).sum()
    };
    let work = move |watch: &Watchdog, left_out: &[Option<JobError>]| {
        let mut measures = Vec::with_capacity(candidates.len());
        for candidate in &candidates {
            watch.check_interrupted()?;
            if let Some(Some(reason)) = left_out.first() {
                return Err(StepError::from(reason.clone()));
            }
            measures.push(watch.step(0, || pooled(candidate))?);
        }
        Ok(measures)
    };
    let measures = supervised(1, limits, work);
    learned.iter().filter_map(|t| t.reversal.as_deref()).for_each(Reversal::free_trackers);
    Ok(best(training, protocol, values, &measures.map_err(within)?))
}

/// Counts of a detector on a track.
fn counts(
    track: &Track,
    signals: &SignalSet,
    fixed: &FixedDetector,
    protocol: &Protocol,
) -> Result<Counts, TrackingError> {
    Ok(track.judge(protocol, &detect(track, signals, fixed, 0)?).0.counts)
}

/// The candidate whose counts have the largest measure; the first among equals.
fn best(training: &Training, protocol: &Protocol, values: Vec<f64>, counts: &[Counts]) -> Chosen {
    let measure = |counts: &Counts| {
        let pooled = Pooled { counts: *counts, chance: Some(protocol.chance), ..Pooled::default() };
        training.maximise.value(&pooled)
    };
    let measures: Vec<Option<f64>> = counts.iter().map(measure).collect();
    let mut best: Option<(f64, usize)> = None;
    for (i, reached) in measures.iter().enumerate() {
        if let Some(reached) = *reached
            && best.is_none_or(|(most, _)| reached > most)
        {
            best = Some((reached, i));
        }
    }
    Chosen { index: best.map_or(0, |(_, i)| i) as u64, reached: best.map(|(r, _)| r), values, measures }
}

/// Counts of every candidate on one track, for parameters that are chosen on many parts of the same tracks.
///
/// # Errors
/// When a detector panics, hangs or fails.
pub fn counts_of_candidates(
    candidates: &[(f64, FixedDetector)],
    track: &Arc<Track>,
    signals: &SignalSet,
    protocol: &'static Protocol,
    limits: &RunLimits,
) -> Result<Vec<Counts>, StepError> {
    let (candidates, track, signals) = (candidates.to_vec(), track.clone(), signals.clone());
    let count = move || -> Result<Vec<Counts>, StepError> {
        let of = |(_, fixed): &(f64, FixedDetector)| counts(&track, &signals, fixed, protocol);
        Ok(candidates.iter().map(of).collect::<Result<_, TrackingError>>()?)
    };
    run_single(limits, count)
}

/// The choice among listed candidates from their counts on the training tracks, one list for each track.
pub fn choose(
    training: &Training,
    candidates: &[(f64, FixedDetector)],
    tracks: &[&Vec<Counts>],
    protocol: &Protocol,
) -> Chosen {
    let mut sums = vec![Counts::default(); candidates.len()];
    for counts in tracks {
        sums.iter_mut().zip(*counts).for_each(|(sum, counts)| *sum = [*sum, *counts].into_iter().sum());
    }
    best(training, protocol, candidates.iter().map(|(value, _)| *value).collect(), &sums)
}

/// Makes the reverse runs of all candidates on all cores; training, which has one thread, then reuses their errors. A
/// run that fails here fails again in training, where the failure is reported.
fn run_backwards(
    tracks: &[Arc<Track>],
    candidates: &[FixedDetector],
    signals: &SignalSet,
    limits: &RunLimits,
) -> Result<(), RunError> {
    let run = |track: &Arc<Track>| {
        let (track, candidates, signals) = (track.clone(), candidates.to_vec(), signals.clone());
        let detect_all = move || -> Result<(), StepError> {
            candidates
                .iter()
                .try_for_each(|c| detect(&track, &signals, c, 0).map(|_| ()).map_err(StepError::from))
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
    signals: &SignalSet,
) -> Result<Vec<(f64, FixedDetector)>, ParamError> {
    let (count, build) = match &training.candidates {
        Candidates::Listed(list) => return Ok(list.clone()),
        Candidates::Quantiles { count, build } => (*count, build),
    };
    let mut values: Vec<f64> = tracks.iter().flat_map(|t| t.signal(signals.first).into_owned()).collect();
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
    use crate::plan::recipes::TRAINING;
    use trackfail_methods::detector::DETECTORS;
    use trackfail_methods::score::{Metric, Restarts};

    #[test]
    fn training_takes_the_first_of_the_best_in_the_way_of_its_version() {
        let candidate = |below: f64| {
            let entry = trackfail_core::plugin::find(DETECTORS, "level").unwrap();
            let detector = Arc::from(entry.build_from_text(&format!("{{ below = {below} }}")).unwrap());
            let (kind, version, restarts) = (entry.kind, entry.version, Restarts::default());
            (below, FixedDetector { kind, version, detector, restarts })
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
            confidence: vec![],
            error: step(0.2, 1.0),
            signals: vec![step(0.8, 0.1)],
            repeated: 0,
            reversal: None,
        };
        let protocol = trackfail_methods::score::protocol("khalid2016/1").unwrap();
        let signals = SignalSet { first: Some(0), more: Vec::new() };
        let train = |tracks| train(&training, tracks, &signals, protocol, &RunLimits::default()).unwrap();
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
