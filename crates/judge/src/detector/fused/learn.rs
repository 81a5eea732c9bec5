//! Learning of the fused detector: the logistic model, its probability, and the threshold for each budget of false alarms.
//!
//! ```text
//! examples   the first 16 frames of each loss, and of the other frames with ground truth each `stride`-th, which counts as
//!            `stride` frames
//! weight     frames that it counts as, x 3 in the first 16 of a loss, x .1 later in a loss, x .3 on good frames whose Dice
//!            overlap is below .1 (IoU .053), x 1 on all others;  x sqrt(m / n), n: frames of the video in all of its tracks, m:
//!            their mean over the videos
//! ```
//!
//! A frame is lost if the box does not overlap the target (error 1). The weights favor the beginning of a
//! loss, where an alarm is useful, and reduce the influence of videos with many tracks. Features are
//! standardized and clipped as in the model.
//!
//! Calibration and thresholds must hold on unseen videos. So the videos are dealt out to [`INNER_FOLDS`]
//! folds in the order of their names, and each fold is scored by a model of the others. These scores give the
//! calibration (Platt: a logistic model of the score alone, by frames) and the thresholds. False alarms are
//! counted in frames, since each has to be inspected: a budget of `n` gives the threshold that `n` of 1000
//! good frames reach on the worst source of videos. Sources with fewer than [`GOOD_FRAMES`] good frames are
//! ignored, unless all have fewer.

use super::features::InputHistory;
use super::logistic::{self, Rows};
use super::model::{FusedModel, News, Weight, probability, score};
use super::{Fused, Params};
use crate::detector::{Example, LearnError};
use std::collections::{BTreeMap, BTreeSet};

/// Number of folds of videos for calibration and thresholds.
const INNER_FOLDS: usize = 4;
/// Budgets of false alarms per 1000 good frames for which thresholds are learned.
pub const BUDGETS: [f64; 9] = [0.2, 0.5, 1.0, 2.0, 3.0, 5.0, 10.0, 20.0, 50.0];
/// Number of frames at the beginning of a loss, which get the full weight.
const ONSET: usize = 16;
/// Least slope of the calibration. A slope of 0 or less would turn the order of the scores around: they are worth nothing
/// then, and the probability is about the share of lost frames.
const LEAST_SLOPE: f64 = 1e-3;
/// Least number of good frames for a source of videos to set a threshold.
const GOOD_FRAMES: f64 = 5000.0;

/// A training example: one frame of a track.
struct Row {
    /// Features of all inputs.
    features: Vec<f64>,
    lost: bool,
    /// Number of frames that the example represents.
    frames: f64,
    /// Weight in learning, before the factor of its video.
    weight: f64,
    /// Factor of the probability before comparison with a threshold.
    news: f64,
}

/// Training examples of a track.
struct TrackRows<'e> {
    video: &'e str,
    source: &'e str,
    rows: Vec<Row>,
}

impl TrackRows<'_> {
    fn frames(&self) -> f64 {
        self.rows.iter().map(|row| row.frames).sum()
    }
}

fn rows_of<'e>(fused: &Fused, example: &'e Example<'_>) -> TrackRows<'e> {
    let Fused { inputs, params: Params { stride, window, .. }, .. } = fused;
    let signals: Vec<&[f64]> = std::iter::once(example.signal).chain(example.more.iter().copied()).collect();
    let mut histories = vec![InputHistory::default(); inputs.len()];
    let mut news = News::default();
    let mut track = TrackRows { video: &example.video, source: &example.source, rows: Vec::new() };
    // Frames of the loss that is on; those without ground truth do not end it.
    let mut since = 0;
    for (t, error) in example.error.iter().enumerate() {
        let values: Vec<f64> = signals.iter().map(|s| s.get(t).copied().unwrap_or(f64::NAN)).collect();
        let factor = news.push(inputs, &values, *window);
        let lost = *error >= 1.0;
        since = match error.is_finite() {
            true if lost => since + 1,
            true => 0,
            false => since,
        };
        let is_onset = lost && since <= ONSET;
        let read = inputs.iter().zip(&mut histories).zip(&values);
        if error.is_finite() && (is_onset || t % stride == 0) {
            let features =
                read.flat_map(|((input, history), value)| history.features(input, *value)).collect();
            let frames = if is_onset { 1.0 } else { *stride as f64 };
            let worth = match lost {
                true if is_onset => 3.0,
                true => 0.1,
                false if *error > 0.9 => 0.3,
                false => 1.0,
            };
            track.rows.push(Row { features, lost, frames, weight: worth * frames, news: factor });
        } else {
            read.for_each(|((input, history), value)| history.pass(input, *value));
        }
    }
    track
}

/// Learns the model.
///
/// # Errors
/// When there are no lost frames, no good ones, or fewer than two videos.
pub fn learn(fused: &Fused, examples: &[Example<'_>]) -> Result<FusedModel, LearnError> {
    let Fused { inputs, params: Params { lambda, .. }, .. } = fused;
    let tracks: Vec<TrackRows<'_>> = examples.iter().map(|example| rows_of(fused, example)).collect();
    let videos: BTreeSet<&str> = tracks.iter().map(|t| t.video).collect();
    let fold = |video: &str| videos.iter().position(|v| *v == video).unwrap_or_default() % INNER_FOLDS;
    let columns: usize = inputs.iter().map(|input| input.features).sum();
    let (features, bias) = fit(&tracks, |_| true, columns, *lambda)?;
    let mut unseen: Vec<Vec<f64>> = vec![Vec::new(); tracks.len()];
    for left_out in 0..INNER_FOLDS.min(videos.len()) {
        let (weights, bias) = fit(&tracks, |track| fold(track.video) != left_out, columns, *lambda)?;
        for (scores, track) in unseen.iter_mut().zip(&tracks).filter(|(_, t)| fold(t.video) == left_out) {
            *scores = track.rows.iter().map(|row| score(bias, &weights, &row.features)).collect();
        }
    }
    let calibration = calibrate(&tracks, &unseen)?;
    let thresholds = thresholds(&tracks, &unseen, calibration);
    let inputs = inputs.iter().map(|input| input.name.to_string()).collect();
    Ok(FusedModel { inputs, features, bias, calibration, thresholds })
}

/// Fits weights and bias on the tracks that `takes` accepts.
fn fit(
    tracks: &[TrackRows<'_>],
    takes: impl Fn(&TrackRows<'_>) -> bool,
    columns: usize,
    lambda: f64,
) -> Result<(Vec<Weight>, f64), LearnError> {
    let taken: Vec<&TrackRows<'_>> = tracks.iter().filter(|track| takes(track)).collect();
    let mut frames = BTreeMap::<&str, f64>::new();
    taken.iter().for_each(|track| *frames.entry(track.video).or_default() += track.frames());
    let mean = frames.values().sum::<f64>() / frames.len() as f64;
    let mut rows = Rows { columns, ..Rows::default() };
    for track in taken {
        let share = (mean / frames[track.video]).sqrt();
        for row in &track.rows {
            rows.values.extend_from_slice(&row.features);
            rows.lost.push(row.lost);
            rows.weight.push(row.weight * share);
        }
    }
    let scale = rows.weight.len() as f64 / rows.weight.iter().sum::<f64>();
    rows.weight.iter_mut().for_each(|weight| *weight *= scale);
    let features = standardize(&mut rows);
    let (weights, bias) = logistic::fit(&rows, lambda * rows.lost.len() as f64).ok_or(LearnError::OneKind)?;
    Ok((features.into_iter().zip(weights).map(|(f, weight)| Weight { weight, ..f }).collect(), bias))
}

/// Standardizes the columns to mean 0 and deviation 1, clips them, and replaces missing values by 0. A
/// constant column becomes 0.
fn standardize(rows: &mut Rows) -> Vec<Weight> {
    let of_column = |column: usize| {
        let values = || rows.iter().map(|(row, ..)| row[column]).filter(|x| x.is_finite());
        let count = values().count().max(1) as f64;
        let center = values().sum::<f64>() / count;
        let deviation = (values().map(|x| (x - center).powi(2)).sum::<f64>() / count).sqrt();
        Weight { center, scale: if deviation > 1e-12 { deviation } else { 1.0 }, weight: 0.0 }
    };
    let features: Vec<Weight> = (0..rows.columns).map(of_column).collect();
    for row in rows.values.chunks_exact_mut(rows.columns.max(1)) {
        row.iter_mut().zip(&features).for_each(|(x, feature)| *x = feature.deviation(*x));
    }
    features
}

/// Fits the calibration, a and c of the probability.
fn calibrate(tracks: &[TrackRows<'_>], scores: &[Vec<f64>]) -> Result<(f64, f64), LearnError> {
    let mut rows = Rows { columns: 1, values: scores.concat(), ..Rows::default() };
    for row in tracks.iter().flat_map(|track| &track.rows) {
        rows.lost.push(row.lost);
        rows.weight.push(row.frames);
    }
    // A little shrinking, so that scores which separate the training frames do not get an infinite slope.
    let (slopes, bias) = logistic::fit(&rows, 1e-6 * rows.lost.len() as f64).ok_or(LearnError::OneKind)?;
    if slopes[0] >= LEAST_SLOPE {
        return Ok((slopes[0], bias));
    }
    let total =
        |of: &dyn Fn(&[f64], bool) -> f64| rows.iter().map(|(x, lost, w)| w * of(x, lost)).sum::<f64>();
    let (all, lost) = (total(&|_, _| 1.0), total(&|_, lost| f64::from(lost)));
    let middle = total(&|x, _| x[0]) / all;
    Ok((LEAST_SLOPE, (lost / (all - lost)).ln() - LEAST_SLOPE * middle))
}

/// For each budget, the lowest threshold that at most this number of good frames reach, on every source.
fn thresholds(tracks: &[TrackRows<'_>], scores: &[Vec<f64>], calibration: (f64, f64)) -> Vec<(f64, f64)> {
    let mut by_source = BTreeMap::<&str, Vec<(f64, f64)>>::new();
    for (track, scores) in tracks.iter().zip(scores) {
        let good = track.rows.iter().zip(scores).filter(|(row, _)| !row.lost);
        let compared = good.map(|(row, score)| (probability(calibration, *score) * row.news, row.frames));
        by_source.entry(track.source).or_default().extend(compared);
    }
    let frames = |good: &Vec<(f64, f64)>| good.iter().map(|(_, frames)| frames).sum::<f64>();
    if by_source.values().any(|good| frames(good) >= GOOD_FRAMES) {
        by_source.retain(|_, good| frames(good) >= GOOD_FRAMES);
    }
    by_source.values_mut().for_each(|good| good.sort_by(|a, b| b.0.total_cmp(&a.0)));
    let of_source = |good: &Vec<(f64, f64)>, budget: f64| {
        let mut left = frames(good) * budget / 1000.0;
        let one_too_many = good.iter().find(|(_, frames)| {
            left -= frames;
            left < 0.0
        });
        // Just above it.
        one_too_many.map_or(0.0, |(compared, _)| compared.next_up())
    };
    let of_budget =
        |budget: f64| (budget, by_source.values().map(|good| of_source(good, budget)).fold(0.0, f64::max));
    BUDGETS.map(of_budget).to_vec()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::detector::testing;

    /// A track in which each frame represents itself.
    fn track(lost: &[bool]) -> TrackRows<'static> {
        let row =
            |lost: &bool| Row { features: Vec::new(), lost: *lost, frames: 1.0, weight: 1.0, news: 1.0 };
        TrackRows { video: "", source: "", rows: lost.iter().map(row).collect() }
    }

    // By hand: of 200 good frames the budgets from 5 of 1000 on allow 1, 2, 4 and 10.
    #[test]
    fn a_budget_is_used_up_and_not_exceeded() {
        let scores: Vec<f64> = (0..200).map(f64::from).collect();
        let calibration = (0.1, -10.0);
        let found = thresholds(&[track(&[false; 200])], std::slice::from_ref(&scores), calibration);
        let reaching =
            |threshold: f64| scores.iter().filter(|s| probability(calibration, **s) >= threshold).count();
        let reached: Vec<usize> = found.iter().map(|(_, threshold)| reaching(*threshold)).collect();
        assert_eq!(reached, [0, 0, 0, 0, 0, 1, 2, 4, 10]);
    }

    // By hand, a stride of 10 and a loss from frame 12 to 32: frames 0 and 40 are good (40 has a Dice overlap of exactly .1), 10 overlaps
    // by less; 12 to 28 are the beginning of the loss without frame 20, which has no ground truth, and 30 is later in it.
    #[test]
    fn frames_that_are_learned_from_and_their_weights() {
        let mut error = vec![0.2; 41];
        error[12..33].fill(1.0);
        (error[10], error[20], error[40]) = (0.95, f64::NAN, 0.9);
        let fused = testing::plugin("{ inputs = [\"share\"], train = \"train\", stride = 10 }");
        let example = Example::new(&[0.5; 41], &error);
        let track = rows_of(&fused, &example);
        let rows: Vec<_> = track.rows.iter().map(|row| (row.lost, row.frames, row.weight)).collect();
        let good = [(false, 10.0, 10.0), (false, 10.0, 3.0)];
        assert_eq!(
            rows,
            [&good[..], &[(true, 1.0, 3.0); 16], &[(true, 10.0, 1.0), (false, 10.0, 10.0)]].concat()
        );
        assert_eq!(track.frames(), 56.0);
    }

    // By the equations: two videos of 2 and 4 frames, whose mean is 3; weights are scaled to the number of rows, and so is
    // the penalty.
    #[test]
    fn a_video_counts_by_the_root_of_its_frames() {
        let values = [0.0, 1.0, 0.5, 0.25, 1.5, 2.0];
        let lost = [false, true, false, false, true, true];
        let of = |video: &'static str, frames: std::ops::Range<usize>| {
            let rows = &mut track(&lost[frames.clone()]).rows;
            rows.iter_mut().zip(&values[frames]).for_each(|(row, value)| row.features = vec![*value]);
            TrackRows { video, source: "", rows: std::mem::take(rows) }
        };
        let (found, bias) = fit(&[of("a", 0..2), of("b", 2..6)], |_| true, 1, 0.5).unwrap();
        let shares = [[1.5_f64.sqrt(); 2].as_slice(), &[0.75_f64.sqrt(); 4]].concat();
        let center = values.iter().sum::<f64>() / 6.0;
        let scale = (values.iter().map(|v| (v - center).powi(2)).sum::<f64>() / 6.0).sqrt();
        let total: f64 = shares.iter().sum();
        let rows = Rows {
            columns: 1,
            values: values.iter().map(|v| (v - center) / scale).collect(),
            lost: lost.to_vec(),
            weight: shares.iter().map(|share| share * 6.0 / total).collect(),
        };
        let (weights, expected) = logistic::fit(&rows, 3.0).unwrap();
        let found = [found[0].center, found[0].scale, found[0].weight, bias];
        trackfail_testing::assert_near(found, [center, scale, weights[0], expected], 1e-9, "");
    }

    // By hand: a source of 5000 good frames sets the threshold, one of 4999 does not, unless no source has more.
    #[test]
    fn small_sources_set_no_threshold_and_old_news_a_low_one() {
        let calibration = (1.0, 0.0);
        let of = |source: &'static str, frames: f64, news: f64| {
            let mut track = TrackRows { source, ..track(&[false]) };
            (track.rows[0].frames, track.rows[0].news) = (frames, news);
            track
        };
        let found = |tracks: &[TrackRows<'_>]| {
            let scores: Vec<Vec<f64>> = (0..tracks.len()).map(|k| vec![k as f64]).collect();
            thresholds(tracks, &scores, calibration)[0].1
        };
        let at = |score: f64, news: f64| (probability(calibration, score) * news).next_up();
        assert_eq!(found(&[of("a", 5000.0, 1.0), of("b", 4999.0, 1.0)]), at(0.0, 1.0));
        assert_eq!(found(&[of("a", 4000.0, 1.0), of("b", 4999.0, 1.0)]), at(1.0, 1.0));
        assert_eq!(found(&[of("a", 5000.0, 0.5)]), at(0.0, 0.5));
    }

    // sklearn 1.9.1: LogisticRegression(C=1 / 6e-6, tol=1e-14, solver="newton-cholesky").fit([[0], [1], [2], [3], [4], [5]],
    // [0, 0, 0, 1, 1, 1])
    #[test]
    fn the_penalty_of_a_calibration_is_small() {
        let scores = [vec![0.0, 1.0, 2.0, 3.0, 4.0, 5.0]];
        let found = calibrate(&[track(&[false, false, false, true, true, true])], &scores).unwrap();
        trackfail_testing::assert_near(<[f64; 2]>::from(found), [18.24004451, -45.60011127], 1e-6, "");
    }

    #[test]
    fn scores_that_are_low_in_losses_are_worth_nothing() {
        let scores = [vec![0.0, 1.0, 2.0, 3.0, 4.0, 5.0]];
        let fit = |lost: [bool; 6]| calibrate(&[track(&lost)], &scores).unwrap();
        assert!(fit([false, false, true, false, true, true]).0 > 0.1);
        // Half of the frames are lost, or two of six.
        for (lost, share) in [
            ([true, true, false, true, false, false], 0.5),
            ([true, true, false, false, false, false], 1.0 / 3.0),
        ] {
            let found = fit(lost);
            assert_eq!(found.0, LEAST_SLOPE);
            assert!(scores[0].iter().all(|score| (probability(found, *score) - share).abs() < 1e-3));
        }
    }
}
