//! False alarms and delay at the threshold that finds half of the losses, and losses found within a budget of
//! false alarms. The detector's own threshold has no influence.
//!
//! ```text
//! peak of a loss = max of s over its first frames: start, ..., start + 15, up to its last
//! h              = largest threshold that half of the peaks or more reach
//! false alarms   = 1000 * (good frames with s >= h) / (good frames)
//! delay          = mean over the losses found (peak >= h) of their first frame with s >= h, less start
//! ARL0           = good frames / runs of frames with s >= h that begin in a good frame
//! found(b)       = share of the losses whose peak at most b of 1000 good frames reach
//! ```
//!
//! `s` is the score, high is suspicious; losses and good frames are those of `frames/1` ([`super::truth`]); `start` is
//! 0-based. Few false alarms, short delays, long runs without a false alarm (ARL0, in frames) and many losses found are
//! good. There is no value without a loss, and no ARL0 without a false alarm.
//!
//! Choices: a loss must be found within 15 frames (half a second of video) and while it lasts, since an alarm
//! after the target is back is false. False alarms are counted in frames, since each has to be inspected.
//! ARL0 counts runs of them, so that it is a different number.

use super::bootstrap::{Samples, interval};
use super::sweep::Sweep;
use super::truth::{Rule, ScoredTrack};
use std::ops::Range;

/// Number of frames after the start of a loss within which it must be found.
pub const WITHIN: usize = 15;

/// First frames of a range, in which the loss must be found.
pub fn first_frames(range: &Range<usize>) -> Range<usize> {
    range.start..range.end.min(range.start + WITHIN + 1)
}

/// Measures at the threshold that finds half of the losses.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AtHalf {
    /// Threshold that at least half of the peaks reach.
    pub threshold: f64,
    /// Good frames with a score at or above the threshold, per 1000 good frames; `None` without good frames.
    pub false_alarms: Option<f64>,
    /// Mean delay of the losses found, in frames.
    pub delay: f64,
    /// Number of good frames per false alarm; `None` without false alarms.
    pub arl0: Option<f64>,
}

/// A loss: its sequence, the scores of its first frames, the highest of these, and the numbers of good frames at or
/// above it, by sequence.
struct Loss<'a> {
    sequence: usize,
    peak: f64,
    scores: &'a [f64],
    reached: Vec<u64>,
}

/// Losses of all tracks.
pub struct Losses<'a> {
    tracks: &'a [ScoredTrack<'a>],
    /// Losses by descending peak.
    losses: Vec<Loss<'a>>,
    /// Number of good frames of each sequence.
    good: Vec<u64>,
}

impl<'a> Losses<'a> {
    /// Finds the losses in tracks, whose frames are those of the sweep.
    pub fn new(tracks: &'a [ScoredTrack<'a>], sweep: &Sweep) -> Self {
        let of_track = |track: &'a ScoredTrack<'a>| {
            let loss = |range: Range<usize>| {
                let scores = track.score.get(first_frames(&range)).unwrap_or_default();
                let peak = scores.iter().copied().fold(f64::NEG_INFINITY, f64::max);
                Loss { sequence: track.sequence, peak, scores, reached: Vec::new() }
            };
            Rule::NoOverlap.losses(track.error).into_iter().map(loss)
        };
        let mut losses: Vec<Loss<'_>> = tracks.iter().flat_map(of_track).collect();
        losses.sort_by(|a, b| b.peak.total_cmp(&a.peak));
        let mut sum = vec![0_u64; sweep.good.len()];
        let mut frames = sweep.frames.iter().peekable();
        for loss in &mut losses {
            while let Some(frame) = frames.next_if(|f| f.score >= loss.peak) {
                sum[frame.sequence as usize] += u64::from(!frame.lost);
            }
            loss.reached = sum.clone();
        }
        Self { tracks, losses, good: sweep.good.clone() }
    }

    /// Number of losses.
    pub fn count(&self) -> usize {
        self.losses.len()
    }

    /// Measures at the threshold that finds half of the losses; `None` without a loss.
    pub fn at_half(&self) -> Option<AtHalf> {
        let half = self.losses.get(self.losses.len().div_ceil(2).checked_sub(1)?)?;
        let threshold = half.peak;
        let (reached, good) = (half.reached.iter().sum::<u64>(), self.good.iter().sum::<u64>());
        let delays: Vec<usize> =
            self.losses.iter().filter_map(|loss| loss.scores.iter().position(|s| *s >= threshold)).collect();
        let runs = self.tracks.iter().map(|t| false_runs(t, threshold)).sum::<usize>();
        Some(AtHalf {
            threshold,
            false_alarms: (good > 0).then(|| 1000.0 * reached as f64 / good as f64),
            delay: delays.iter().sum::<usize>() as f64 / delays.len() as f64,
            arl0: (runs > 0).then(|| good as f64 / runs as f64),
        })
    }

    /// Share of the losses found with a budget of false alarms per 1000 good frames, with each sequence
    /// weighted; NaN without a loss.
    fn found_of(&self, budget: f64, weights: &[u64]) -> f64 {
        let allowed = budget / 1000.0 * sum(weights, &self.good) as f64;
        let found = self.losses.partition_point(|loss| sum(weights, &loss.reached) as f64 <= allowed);
        let drawn = |losses: &[Loss<'_>]| {
            losses.iter().map(|loss| weights.get(loss.sequence).copied().unwrap_or(0)).sum::<u64>() as f64
        };
        drawn(&self.losses[..found]) / drawn(&self.losses)
    }

    /// Share of the losses found with a budget of false alarms per 1000 good frames; `None` without a loss.
    pub fn found(&self, budget: f64) -> Option<f64> {
        Some(self.found_of(budget, &vec![1; self.good.len()])).filter(|share| share.is_finite())
    }

    /// Share of the losses found in each bootstrap sample; NaN in samples without a loss.
    pub fn found_in(&self, budget: f64, samples: &Samples) -> Vec<f64> {
        samples.each().map(|weights| self.found_of(budget, &weights)).collect()
    }

    /// Bootstrap interval of the false alarms. Each sample has its own threshold, from its own losses.
    pub fn interval(&self, samples: &Samples) -> Option<(f64, f64)> {
        let of_sample = |weights: Vec<u64>| {
            let drawn = |loss: &Loss<'_>| weights.get(loss.sequence).copied().unwrap_or(0);
            let half = self.losses.iter().map(drawn).sum::<u64>().div_ceil(2);
            let mut found = 0;
            let median = self.losses.iter().find(|loss| {
                found += drawn(loss);
                half > 0 && found >= half
            });
            median.map_or(f64::NAN, |loss| {
                1000.0 * sum(&weights, &loss.reached) as f64 / sum(&weights, &self.good) as f64
            })
        };
        interval(samples.each().map(of_sample).collect())
    }
}

/// Weighted sum of counts by sequence.
fn sum(weights: &[u64], counts: &[u64]) -> u64 {
    weights.iter().zip(counts).map(|(w, c)| w * c).sum()
}

/// Number of runs of frames at or above a threshold that begin in a good frame.
fn false_runs(track: &ScoredTrack<'_>, threshold: f64) -> usize {
    let reaches: Vec<bool> = track.score.iter().map(|s| *s >= threshold).collect();
    let good = |t: &usize| track.error.get(*t).is_some_and(|e| Rule::NoOverlap.judge(*e) == Some(false));
    crate::detector::run_starts(&reaches).into_iter().filter(good).count()
}

#[cfg(test)]
mod tests {
    use super::super::sweep::Sorted;
    use super::*;
    use crate::score::testing::error;
    use proptest::prelude::*;

    fn losses<'a>(tracks: &'a [ScoredTrack<'a>]) -> Losses<'a> {
        Losses::new(tracks, &Sorted::new(tracks).sweep(Rule::NoOverlap))
    }

    fn at_half(tracks: &[ScoredTrack<'_>]) -> Option<AtHalf> {
        losses(tracks).at_half()
    }

    fn track<'a>(error: &'a [f64], score: &'a [f64]) -> ScoredTrack<'a> {
        ScoredTrack { sequence: 0, error, score, alarm: &[] }
    }

    // By hand: losses at 20 (peak 5 at 23, then 9 after the window and after its end), 50 (peak 3 at 50) and 70
    // (peak 1). Two of three are half or more: h = 3, delays 3 and 0. Good frames with s >= 3: 36 (9) and 45, 46 (4).
    #[test]
    fn the_hand_worked_track() {
        let (error, mut score) = (error(100, &[[20, 36], [50, 69], [70, 90]]), vec![0.0; 100]);
        (score[23], score[36], score[50]) = (5.0, 9.0, 3.0);
        (score[45], score[46], score[71], score[86]) = (4.0, 4.0, 1.0, 8.0);
        let found = at_half(&[track(&error, &score)]).unwrap();
        let good = 100.0 - 16.0 - 39.0;
        let expected =
            AtHalf { threshold: 3.0, false_alarms: Some(3000.0 / good), delay: 1.5, arl0: Some(good / 2.0) };
        assert_eq!(found, expected);
        // One good frame reaches the peak 5, three reach 3, and the same three reach 1.
        let (tracks, at) = ([track(&error, &score)], |budget| 1000.0 * budget / good);
        let losses = losses(&tracks);
        let found = [0.0, 0.99, 1.01, 2.99, 3.01, 45.0].map(|frames| losses.found(at(frames)).unwrap());
        assert_eq!(found, [0.0, 0.0, 1.0 / 3.0, 1.0 / 3.0, 1.0, 1.0]);
    }

    // By hand: 1 of 8 good frames reaches the loss, which are 125 of 1000.
    #[test]
    fn a_budget_that_is_used_up_is_kept() {
        let (error, score) = (error(9, &[[8, 9]]), [9., 0., 0., 0., 0., 0., 0., 0., 5.]);
        let tracks = [track(&error, &score)];
        let found = [125.0, 124.0].map(|budget| losses(&tracks).found(budget));
        assert_eq!(found, [Some(1.0), Some(0.0)]);
    }

    // The window ends with the sixteenth frame of a loss.
    #[test]
    fn a_score_counts_up_to_the_fifteenth_frame_after_the_start() {
        let error = error(60, &[[20, 60]]);
        let at = |t: usize| (0..60).map(|k| f64::from(k == t)).collect::<Vec<_>>();
        assert_eq!(at_half(&[track(&error, &at(35))]).unwrap().delay, 15.0);
        // The peak is that of a quiet frame, which all frames reach.
        let late = at_half(&[track(&error, &at(36))]).unwrap();
        assert_eq!((late.threshold, late.false_alarms, late.delay), (0.0, Some(1000.0), 0.0));
    }

    #[test]
    fn a_constant_score_alarms_everywhere_and_no_loss_has_no_value() {
        let error = [0.0, 0.2, 1.0, 1.0, 0.2];
        let all = at_half(&[track(&error, &[0.0; 5])]).unwrap();
        assert_eq!((all.false_alarms, all.delay, all.arl0), (Some(1000.0), 0.0, Some(3.0)));
        assert_eq!(at_half(&[track(&error[..2], &[0.0; 2])]), None);
        assert_eq!(losses(&[track(&error[..2], &[0.0; 2])]).found(5.0), None);
        let silent = at_half(&[track(&error, &[0.0, 0.0, 1.0, 0.0, 0.0])]).unwrap();
        assert_eq!((silent.false_alarms, silent.arl0), (Some(0.0), None));
        let nothing = Sorted::new(&[]).sweep(Rule::NoOverlap);
        let of_none = Losses::new(&[track(&error, &[0.0; 5])], &nothing).at_half();
        assert_eq!(of_none.unwrap().false_alarms, None);
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(48))]

        // The second way: the measure of tracks that are there as often as a sample draws their sequence.
        #[test]
        fn samples_are_those_of_repeated_tracks(
            tracks in prop::collection::vec(
                prop::collection::vec((prop::sample::select(vec![0.2, 1.0]), -3..4_i32), 0..30), 3..6),
            seed in 0..9_u64,
        ) {
            let split: Vec<(Vec<f64>, Vec<f64>)> =
                tracks.iter().map(|t| t.iter().map(|(e, s)| (*e, f64::from(*s))).unzip()).collect();
            let all: Vec<ScoredTrack<'_>> =
                split.iter().enumerate().map(|(k, (e, s))| ScoredTrack { sequence: k, ..track(e, s) }).collect();
            let samples = Samples::new(all.len(), seed);
            let drawn = |weights: Vec<u64>| -> Vec<ScoredTrack<'_>> {
                all.iter().flat_map(|t| vec![*t; weights[t.sequence] as usize]).collect()
            };
            let of = |weights| at_half(&drawn(weights)).and_then(|a| a.false_alarms).unwrap_or(f64::NAN);
            let expected = interval(samples.each().map(of).collect());
            let of_all = losses(&all);
            prop_assert_eq!(of_all.interval(&samples), expected);
            for (weights, found) in samples.each().zip(of_all.found_in(200.0, &samples)) {
                let expected = losses(&drawn(weights)).found(200.0);
                prop_assert_eq!(Some(found).filter(|f| f.is_finite()), expected);
            }
        }
    }
}
