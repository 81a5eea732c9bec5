//! Learning of the fused detector: the logistic model, its probability, and the threshold for each budget of false alarms.
//!
//! Every `stride`-th frame of the tracks with ground truth is a row, lost where the box does not overlap the target
//! (error 1). Rows of one video together have the weight of one video, so that long ones and those with many trackers
//! do not outvote the others. Features are standardized, and cut as the model cuts them.
//!
//! The worth of a model's scores on videos that it has not seen is learned from such videos: the videos are dealt
//! out to [`INNER_FOLDS`] folds in the order of their names, each is scored by a model of the others, and these scores
//! give the calibration (Platt: a logistic model of the score alone) and the thresholds. False alarms are counted by frames, as
//! they have to be looked at: a budget of `n` allows the threshold that `n` of 1000 good frames reach.

use super::features::{FEATURES, InputHistory};
use super::inputs::FusedInput;
use super::logistic::{self, Fit, Rows};
use super::model::{FusedModel, Weight, probability, score};
use crate::detector::{Example, LearnError};
use std::collections::{BTreeMap, BTreeSet};

/// Folds of videos that calibration and thresholds are learned on.
const INNER_FOLDS: usize = 4;
/// Budgets of false alarms per 1000 good frames that a threshold is learned for.
pub const BUDGETS: [f64; 9] = [0.2, 0.5, 1.0, 2.0, 3.0, 5.0, 10.0, 20.0, 50.0];

/// Parameters of the learning.
#[derive(Debug, Clone, Copy)]
pub struct Learning {
    /// Weight of the squared weights, relative to that of the rows.
    pub lambda: f64,
    /// Frames from one row to the next.
    pub stride: usize,
}

/// A track's rows: the features of every `stride`-th frame that has ground truth, and whether it is lost.
struct TrackRows<'e> {
    video: &'e str,
    /// The features of the inputs, one list for each row.
    features: Vec<Vec<[f64; FEATURES.len()]>>,
    lost: Vec<bool>,
}

fn rows_of<'e>(example: &'e Example<'_>, inputs: &[&'static FusedInput], stride: usize) -> TrackRows<'e> {
    let signals: Vec<&[f64]> = std::iter::once(example.signal).chain(example.more.iter().copied()).collect();
    let mut histories = vec![InputHistory::default(); inputs.len()];
    let mut rows = TrackRows { video: &example.video, features: Vec::new(), lost: Vec::new() };
    for (t, error) in example.error.iter().enumerate() {
        let read = inputs.iter().zip(&mut histories).zip(&signals);
        let read = read
            .map(|((input, history), signal)| (*input, history, signal.get(t).copied().unwrap_or(f64::NAN)));
        if t % stride == 0 && error.is_finite() {
            rows.features.push(read.map(|(input, history, value)| history.push(input, value)).collect());
            rows.lost.push(*error >= 1.0);
        } else {
            read.for_each(|(input, history, value)| history.pass(input, value));
        }
    }
    rows
}

/// Learns the model.
///
/// # Errors
/// When there are no lost frames, or no good ones, or fewer than two videos.
pub fn learn(
    examples: &[Example<'_>],
    inputs: &[&'static FusedInput],
    how: &Learning,
) -> Result<FusedModel, LearnError> {
    let tracks: Vec<TrackRows<'_>> = examples.iter().map(|e| rows_of(e, inputs, how.stride)).collect();
    let videos: BTreeSet<&str> = tracks.iter().map(|t| t.video).collect();
    let fold = |video: &str| videos.iter().position(|v| *v == video).unwrap_or_default() % INNER_FOLDS;
    let (features, bias) = fit(&tracks, |_| true, inputs.len(), how)?;
    let mut unseen: Vec<Vec<f64>> = vec![Vec::new(); tracks.len()];
    for left_out in 0..INNER_FOLDS.min(videos.len()) {
        let (weights, bias) = fit(&tracks, |track| fold(track.video) != left_out, inputs.len(), how)?;
        for (scores, track) in unseen.iter_mut().zip(&tracks).filter(|(_, t)| fold(t.video) == left_out) {
            *scores = track.features.iter().map(|features| score(bias, &weights, features)).collect();
        }
    }
    let calibration = calibrate(&tracks, &unseen)?;
    unseen.iter_mut().flatten().for_each(|score| *score = probability(calibration, *score));
    let thresholds = thresholds(&tracks, &unseen);
    let inputs = inputs.iter().map(|input| input.name.to_string()).collect();
    Ok(FusedModel { inputs, features, bias, calibration, thresholds })
}

/// Rows, each with whether it is lost and its video; every video has the same weight, and the weights are 1 on average.
fn rows<'r>(columns: usize, each: impl Iterator<Item = (&'r [f64], bool, &'r str)>) -> Rows {
    let (mut rows, mut videos) = (Rows { columns, ..Rows::default() }, Vec::new());
    for (values, lost, video) in each {
        rows.values.extend_from_slice(values);
        rows.lost.push(lost);
        videos.push(video);
    }
    let mut counts = BTreeMap::<&str, f64>::new();
    videos.iter().for_each(|video| *counts.entry(video).or_default() += 1.0);
    let share = videos.len() as f64 / counts.len() as f64;
    rows.weight = videos.iter().map(|video| share / counts[video]).collect();
    rows
}

/// The weights of the features and the bias, of the tracks that are taken.
fn fit(
    tracks: &[TrackRows<'_>],
    takes: impl Fn(&TrackRows<'_>) -> bool,
    inputs: usize,
    how: &Learning,
) -> Result<(Vec<Weight>, f64), LearnError> {
    let each = tracks.iter().filter(|track| takes(track)).flat_map(|track| {
        let rows = track.features.iter().zip(&track.lost);
        rows.map(|(features, lost)| (features.as_flattened(), *lost, track.video))
    });
    let mut rows = rows(inputs * FEATURES.len(), each);
    let features = standardize(&mut rows);
    let Fit { weights, bias } =
        logistic::fit(&rows, how.lambda * rows.lost.len() as f64).ok_or(LearnError::OneKind)?;
    Ok((features.into_iter().zip(weights).map(|(f, weight)| Weight { weight, ..f }).collect(), bias))
}

/// Brings the columns to mean 0 and deviation 1 by the weights of the rows, cuts them, and puts 0 where there is no
/// value. A column that is constant becomes 0.
fn standardize(rows: &mut Rows) -> Vec<Weight> {
    let of_column = |column: usize| {
        let (mut sum, mut squares, mut weights) = (0.0, 0.0, 0.0);
        let values =
            || rows.iter().map(|(row, _, weight)| (row[column], weight)).filter(|(x, _)| x.is_finite());
        values().for_each(|(x, weight)| (sum, weights) = (sum + weight * x, weights + weight));
        let center = if weights > 0.0 { sum / weights } else { 0.0 };
        values().for_each(|(x, weight)| squares += weight * (x - center).powi(2));
        let deviation = if weights > 0.0 { (squares / weights).sqrt() } else { 0.0 };
        Weight { center, scale: if deviation > 1e-12 { deviation } else { 1.0 }, weight: 0.0 }
    };
    let features: Vec<Weight> = (0..rows.columns).map(of_column).collect();
    for row in rows.values.chunks_exact_mut(rows.columns.max(1)) {
        row.iter_mut().zip(&features).for_each(|(x, feature)| *x = feature.deviation(*x));
    }
    features
}

/// a and c of the probability.
fn calibrate(tracks: &[TrackRows<'_>], scores: &[Vec<f64>]) -> Result<(f64, f64), LearnError> {
    let each = tracks.iter().zip(scores).flat_map(|(track, scores)| {
        let rows = scores.iter().zip(&track.lost);
        rows.map(|(score, lost)| (std::slice::from_ref(score), *lost, track.video))
    });
    let rows = rows(1, each);
    // A little shrinking, so that scores which separate the training frames do not get an infinite slope.
    let fit = logistic::fit(&rows, 1e-6 * rows.lost.len() as f64).ok_or(LearnError::OneKind)?;
    // A slope of 0 or less would turn the order of the scores around: they are worth nothing then.
    Ok((fit.weights.first().copied().unwrap_or_default().max(1e-3), fit.bias))
}

/// Each budget with the lowest probability that no more good frames reach than it allows.
fn thresholds(tracks: &[TrackRows<'_>], probabilities: &[Vec<f64>]) -> Vec<(f64, f64)> {
    let frames = tracks.iter().zip(probabilities).flat_map(|(track, all)| all.iter().zip(&track.lost));
    let mut good: Vec<f64> =
        frames.filter(|(_, lost)| !**lost).map(|(probability, _)| *probability).collect();
    good.sort_by(|a, b| b.total_cmp(a));
    let of_budget = |budget: f64| {
        let allowed = (good.len() as f64 * budget / 1000.0) as usize;
        // Just above the first frame that is one too many.
        (budget, good.get(allowed).map_or(0.0, |probability| probability.next_up()))
    };
    BUDGETS.map(of_budget).to_vec()
}
