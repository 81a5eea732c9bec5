//! Choice of a parameter among candidates, and learning of a model, from tracks.

use super::Chosen;
use crate::error::StepError;
use crate::execute::judge::detect;
use crate::execute::supervise::{Job, run_single};
use crate::execute::track::Track;
use crate::limits::RunLimits;
use crate::spec::method::{Candidates, FixedDetector, Training};
use serde_json::Value;
use std::borrow::Cow;
use std::sync::Arc;
use trackfail_methods::detector::Example;
use trackfail_methods::score::{Counts, Pooled, Protocol};

/// Learns a model from examples and returns it as JSON text.
pub fn learn(
    fixed: &FixedDetector,
    examples: &[Example<'_>],
    limits: &RunLimits,
) -> Result<String, StepError> {
    let learn = || -> Result<Value, StepError> {
        let learner = fixed.detector.learner().ok_or_else(|| StepError::failed("it does not learn"))?;
        learner.learn(examples).map_err(StepError::failed)
    };
    let model = run_single(limits, learn).map_err(|e| e.within(&format!("learning of {}", fixed.kind)))?;
    Ok(model.to_string())
}

/// Candidate values with their detectors, ascending.
///
/// # Errors
/// When there is no candidate, or the detector refuses one.
pub fn candidates<'t>(
    training: &'t Training,
    tracks: &[Arc<Track>],
    signals: &[usize],
) -> Result<Cow<'t, [(f64, FixedDetector)]>, StepError> {
    let (count, build) = match &training.candidates {
        Candidates::Listed(list) => return Ok(list.as_slice().into()),
        Candidates::Quantiles { count, build } => (*count, build),
    };
    let signal = signals.first().copied();
    let mut values: Vec<f64> = tracks.iter().flat_map(|t| t.signal(signal).into_owned()).collect();
    values.sort_by(f64::total_cmp);
    let last = values.len().checked_sub(1).ok_or_else(|| StepError::failed("there is no value to try"))?;
    // Values that were seen, so that nothing depends on how quantiles are interpolated.
    let mut tried: Vec<f64> = (0..count).map(|k| values[k * last / (count - 1)]).collect();
    tried.dedup();
    let built = tried.into_iter().map(|value| Ok((value, build(value).map_err(StepError::failed)?)));
    built.collect::<Result<Vec<_>, StepError>>().map(Cow::from)
}

/// Counts of each candidate on one track.
///
/// # Errors
/// When a detector panics, takes too long or fails.
pub fn counts(
    candidates: &[(f64, FixedDetector)],
    track: &Track,
    signals: &[usize],
    protocol: &Protocol,
    limits: &RunLimits,
) -> Result<Vec<Counts>, StepError> {
    let of = |(_, fixed): &(f64, FixedDetector)| -> Result<Counts, StepError> {
        Ok(track.judge(protocol, &detect(track, signals, fixed, 0)?).0.counts)
    };
    let counts = run_single(limits, || {
        // Time and interruptions are looked at after each candidate.
        let job = Job::new(limits);
        candidates.iter().map(|one| job.step(|| of(one))).collect()
    });
    if let Some(reversal) = &track.reversal {
        reversal.free_trackers();
    }
    counts
}

/// Candidate with the largest measure, from its counts on all tracks together; the first among equals.
/// `counts` has one list per track.
pub fn best(training: &Training, protocol: &Protocol, values: Vec<f64>, counts: &[Vec<Counts>]) -> Chosen {
    let measure = |k: usize| {
        let counts = counts.iter().map(|of_track| of_track[k]).sum();
        training.maximise.value(&Pooled { counts, chance: Some(protocol.chance), ..Pooled::default() })
    };
    let measures: Vec<Option<f64>> = (0..values.len()).map(measure).collect();
    let reached = measures.iter().enumerate().filter_map(|(k, measure)| Some((k, (*measure)?)));
    let best = reached.reduce(|best, next| if next.1 > best.1 { next } else { best });
    Chosen { index: best.map_or(0, |(k, _)| k) as u64, reached: best.map(|(_, most)| most), values, measures }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plan::recipes::TRAINING;
    use trackfail_methods::detector::DETECTORS;
    use trackfail_methods::score::Metric;

    #[test]
    fn training_takes_the_first_of_the_best_in_the_way_of_its_version() {
        let candidate = |below: f64| {
            let entry = trackfail_core::plugin::find(DETECTORS, "level").unwrap();
            let detector = entry.build_from_text(&format!("{{ below = {below} }}")).unwrap();
            (below, FixedDetector::new(entry, detector))
        };
        let training = Training {
            key: "below".into(),
            role: "train".into(),
            maximise: Metric::F_SCORE,
            candidates: Candidates::Listed([0.01, 0.2, 0.5, 0.9].map(candidate).to_vec()),
        };
        // One loss, at frame 20; below .2 and .5 find it, .01 never alarms, .9 does from the start.
        let step =
            |low: f64, high: f64| (0..30).map(|t| if t < 20 { low } else { high }).collect::<Vec<f64>>();
        let track = Track { error: step(0.2, 1.0), signals: vec![step(0.8, 0.1)], ..Track::default() };
        let protocol = trackfail_methods::score::protocol("khalid2016/1").unwrap();
        let tracks = [Arc::new(track)];
        let list = candidates(&training, &tracks, &[0]).unwrap();
        let counts = counts(&list, &tracks[0], &[0], protocol, &RunLimits::default()).unwrap();
        let chosen = best(&training, protocol, list.iter().map(|(value, _)| *value).collect(), &[counts]);
        let measures = vec![Some(0.0), Some(1.0), Some(1.0), Some(0.0)];
        let values = vec![0.01, 0.2, 0.5, 0.9];
        assert_eq!(
            (TRAINING, chosen),
            (2, Chosen { index: 1, reached: Some(1.0), values, measures }),
            "raise TRAINING"
        );
    }
}
