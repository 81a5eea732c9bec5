//! Precision and recall of ranges of alarms against ranges of lost frames (Tatbul, Lee, Zdonik, Alam and Gottschlich,
//! "Precision and recall for time series", NeurIPS 2018, eq. 1 to 6).
//!
//! ```text
//! recall of a lost range R    = alpha [R meets an alarm] + (1 - alpha) gamma(R) sum over alarm ranges P of omega(R, P)
//! precision of a range P      = gamma(P) sum over lost ranges R of omega(P, R)
//! omega(A, B)                 = sum of delta(i) over the frames of A that are in B / sum of delta(i) over all of A
//! gamma(A)                    = 1 / number of ranges of the other kind that A meets, 1 where it meets none or one
//! delta(i), i = 1..n          = 1 (flat)   or   n - i + 1 (front)
//! ```
//!
//! Recall is the mean over all lost ranges of all tracks, precision over all alarm ranges, and F their harmonic mean;
//! all in `[0, 1]`, high is good. Without a lost range there is no recall, without an alarm no precision. An alarm in
//! one frame of a long loss has found that frame and nothing else.
//!
//! `range/1` is alpha 0 and flat for both, the defaults of the authors' package. `gamma` is the reciprocal one, so that
//! one loss that is found in pieces counts less than one that is found once. Lost frames are those of `frames/1`; ranges go
//! on over frames without annotation. Values are those of `prts` 1.0.0.3.

use super::truth::{Rule, ScoredTrack, runs};
use std::ops::Range;

/// Weights of the frames of a range.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Bias {
    /// All the same.
    Flat,
    /// The first one most.
    Front,
}

/// The rules of a range-based measure.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Rules {
    /// Weight in recall of a range's being found at all, in `[0, 1]`.
    pub alpha: f64,
    /// Weights of the frames of an alarm range, in precision.
    pub precision_bias: Bias,
    /// Weights of the frames of a lost range, in recall.
    pub recall_bias: Bias,
}

/// The rules of `range/1`.
pub const RANGE_1: Rules = Rules { alpha: 0.0, precision_bias: Bias::Flat, recall_bias: Bias::Flat };

/// Precision and recall of ranges.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct RangeScore {
    /// Mean over the alarm ranges; `None` without one.
    pub precision: Option<f64>,
    /// Mean over the lost ranges; `None` without one.
    pub recall: Option<f64>,
}

impl RangeScore {
    /// Harmonic mean of precision and recall, 0 where nothing is found; `None` where one of the two has no value.
    pub fn f_score(&self) -> Option<f64> {
        let (p, r) = (self.precision?, self.recall?);
        Some(if p + r > 0.0 { 2.0 * p * r / (p + r) } else { 0.0 })
    }
}

/// Sum of delta over a part of `0..n`, where `from` and `to` are in it.
fn weight(bias: Bias, n: usize, from: usize, to: usize) -> f64 {
    let frames = (to - from) as f64;
    match bias {
        Bias::Flat => frames,
        // n - from, ..., n - to + 1
        Bias::Front => frames * (2 * n - from - to + 1) as f64 / 2.0,
    }
}

/// The reward of a range for the ranges of the other kind, ascending.
fn reward(range: &Range<usize>, others: &[Range<usize>], alpha: f64, bias: Bias) -> f64 {
    let first = others.partition_point(|o| o.end <= range.start);
    let met = others[first..].iter().take_while(|o| o.start < range.end);
    let (mut count, mut sum) = (0, 0.0);
    for other in met {
        let (from, to) = (other.start.max(range.start), other.end.min(range.end));
        sum += weight(bias, range.len(), from - range.start, to - range.start);
        count += 1;
    }
    let overlap = sum / weight(bias, range.len(), 0, range.len()) / f64::from(count.max(1));
    alpha * f64::from(count.min(1)) + (1.0 - alpha) * overlap
}

/// Precision and recall over all ranges of tracks.
pub fn score(tracks: &[ScoredTrack<'_>], rules: &Rules) -> RangeScore {
    let (mut precision, mut alarms, mut recall, mut losses) = (0.0, 0_u64, 0.0, 0_u64);
    for track in tracks {
        let (lost, alarm) = (runs(&Rule::NoOverlap.lost(track.error)), runs(track.alarm));
        precision += alarm.iter().map(|a| reward(a, &lost, 0.0, rules.precision_bias)).sum::<f64>();
        recall += lost.iter().map(|l| reward(l, &alarm, rules.alpha, rules.recall_bias)).sum::<f64>();
        alarms += alarm.len() as u64;
        losses += lost.len() as u64;
    }
    let mean = |sum: f64, n: u64| (n > 0).then(|| sum / n as f64);
    RangeScore { precision: mean(precision, alarms), recall: mean(recall, losses) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn of(lost: &[u8], alarm: &[u8], rules: &Rules) -> RangeScore {
        let error: Vec<f64> = lost.iter().map(|l| f64::from(*l)).collect();
        let alarm: Vec<bool> = alarm.iter().map(|a| *a == 1).collect();
        score(&[ScoredTrack { sequence: 0, error: &error, score: &[], alarm: &alarm }], rules)
    }

    // tests/oracles/frames.py: prts 1.0.0.3, TimeSeriesPrecision(0, "reciprocal", bias).score(lost, alarm) and
    // TimeSeriesRecall(alpha, "reciprocal", bias).score(lost, alarm).
    #[test]
    fn agrees_with_prts() {
        for case in crate::score::frames::measures::tests::oracle().range {
            let bias = if case.bias == "front" { Bias::Front } else { Bias::Flat };
            let rules = Rules { alpha: case.alpha, precision_bias: bias, recall_bias: bias };
            let found = of(&case.lost, &case.alarm, &rules);
            assert!(
                (found.precision.unwrap() - case.precision).abs() < 1e-12,
                "{found:?} {}",
                case.precision
            );
            assert!((found.recall.unwrap() - case.recall).abs() < 1e-12, "{found:?} {}", case.recall);
        }
    }

    // One alarm in a loss of 50 frames has found one frame of it; with point adjustment its recall would be 1.
    #[test]
    fn one_alarm_does_not_stand_for_a_whole_loss() {
        let mut alarm = [0; 100];
        let lost: Vec<u8> = (0..100).map(|t| u8::from((30..80).contains(&t))).collect();
        alarm[60] = 1;
        let found = of(&lost, &alarm, &RANGE_1);
        assert_eq!((found.precision, found.recall), (Some(1.0), Some(0.02)));
        assert!((found.f_score().unwrap() - 0.04 / 1.02).abs() < 1e-15);
    }

    #[test]
    fn what_is_not_there_has_no_value() {
        let silent = of(&[0, 1, 1], &[0, 0, 0], &RANGE_1);
        assert_eq!((silent.precision, silent.recall, silent.f_score()), (None, Some(0.0), None));
        let wrong = of(&[0, 1, 1], &[1, 0, 0], &RANGE_1);
        assert_eq!((wrong.precision, wrong.f_score()), (Some(0.0), Some(0.0)));
        assert_eq!(of(&[0, 0], &[1, 0], &RANGE_1).recall, None);
    }

    proptest! {
        // With ranges exchanged, precision and recall are.
        #[test]
        fn precision_and_recall_are_each_others_mirror(
            frames in prop::collection::vec((0..2_u8, 0..2_u8), 1..80),
        ) {
            let (lost, alarm): (Vec<u8>, Vec<u8>) = frames.into_iter().unzip();
            let (one, other) = (of(&lost, &alarm, &RANGE_1), of(&alarm, &lost, &RANGE_1));
            prop_assert_eq!((one.precision, one.recall), (other.recall, other.precision));
            let own = of(&lost, &lost, &RANGE_1);
            prop_assert!(own.recall.is_none_or(|r| (r - 1.0).abs() < 1e-12));
        }
    }
}
