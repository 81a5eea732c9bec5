//! Precision and recall of ranges of alarms against ranges of lost frames (Tatbul, Lee, Zdonik, Alam and Gottschlich,
//! "Precision and recall for time series", NeurIPS 2018, eq. 1 to 6).
//!
//! ```text
//! recall of a lost range R    = gamma(R) sum over alarm ranges P of omega(R, P)
//! precision of a range P      = gamma(P) sum over lost ranges R of omega(P, R)
//! omega(A, B)                 = share of the frames of A that are in B
//! gamma(A)                    = 1 / number of ranges of the other kind that A meets, 1 where it meets none or one
//! ```
//!
//! Recall is the mean over all lost ranges of all tracks, precision over all alarm ranges, and F their harmonic mean;
//! all in `[0, 1]`, high is good. Without a lost range there is no recall, without an alarm no precision. An alarm in
//! one frame of a long loss has found that frame and nothing else.
//!
//! `range/1` has alpha 0 and flat bias, the defaults of the authors' package. `gamma` is the reciprocal one, so that
//! one loss that is found in pieces counts less than one that is found once. Lost frames are those of `frames/1`; ranges go
//! on over frames without annotation. Values are those of `prts` 1.0.0.3.

use super::truth::{Rule, ScoredTrack, runs};
use std::ops::Range;

/// Precision and recall of ranges.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct RangeScore {
    /// Mean over the alarm ranges; `None` without one.
    pub precision: Option<f64>,
    /// Mean over the lost ranges; `None` without one.
    pub recall: Option<f64>,
}

impl RangeScore {
    /// Harmonic mean of precision and recall, 0 if nothing is found; `None` if one of the two has no value.
    pub fn f_score(&self) -> Option<f64> {
        let (p, r) = (self.precision?, self.recall?);
        Some(if p + r > 0.0 { 2.0 * p * r / (p + r) } else { 0.0 })
    }
}

/// Reward of a range for the ranges of the other kind, which are ascending.
fn reward(range: &Range<usize>, others: &[Range<usize>]) -> f64 {
    let first = others.partition_point(|o| o.end <= range.start);
    let met = others[first..].iter().take_while(|o| o.start < range.end);
    let (mut count, mut sum) = (0, 0.0);
    for other in met {
        sum += (other.end.min(range.end) - other.start.max(range.start)) as f64;
        count += 1;
    }
    sum / range.len() as f64 / f64::from(count.max(1))
}

/// Precision and recall over all ranges of the tracks.
pub fn score(tracks: &[ScoredTrack<'_>]) -> RangeScore {
    let (mut precision, mut alarms, mut recall, mut losses) = (0.0, 0_u64, 0.0, 0_u64);
    for track in tracks {
        let (lost, alarm) = (runs(&Rule::NoOverlap.lost(track.error)), runs(track.alarm));
        precision += alarm.iter().map(|a| reward(a, &lost)).sum::<f64>();
        recall += lost.iter().map(|l| reward(l, &alarm)).sum::<f64>();
        alarms += alarm.len() as u64;
        losses += lost.len() as u64;
    }
    let mean = |sum: f64, n: u64| (n > 0).then(|| sum / n as f64);
    RangeScore { precision: mean(precision, alarms), recall: mean(recall, losses) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::score::testing::{oracle, value};
    use proptest::prelude::*;
    use serde_json::Value;
    use trackfail_testing::assert_near;

    fn of(lost: &[u8], alarm: &[u8]) -> RangeScore {
        let error: Vec<f64> = lost.iter().map(|l| f64::from(*l)).collect();
        let alarm: Vec<bool> = alarm.iter().map(|a| *a == 1).collect();
        score(&[ScoredTrack { sequence: 0, error: &error, score: &[], alarm: &alarm }])
    }

    // tests/oracles/frames.py: prts 1.0.0.3, TimeSeriesPrecision(0, "reciprocal", bias).score(lost, alarm) and
    // TimeSeriesRecall(alpha, "reciprocal", bias).score(lost, alarm).
    #[test]
    fn agrees_with_prts() {
        let is_flat = |case: &Value| case["bias"] == "flat" && case["alpha"] == 0.0;
        let flat: Vec<Value> = oracle::<Vec<Value>>("range").into_iter().filter(is_flat).collect();
        assert!(!flat.is_empty());
        for case in flat {
            let [lost, alarm] = ["lost", "alarm"].map(|name| value::<Vec<u8>>(&case, name));
            let (found, want) =
                (of(&lost, &alarm), ["precision", "recall"].map(|name| value::<f64>(&case, name)));
            assert_near(found.precision.into_iter().chain(found.recall), want, 1e-12, "");
        }
    }

    #[test]
    fn what_is_not_there_has_no_value() {
        let silent = of(&[0, 1, 1], &[0, 0, 0]);
        assert_eq!((silent.precision, silent.recall, silent.f_score()), (None, Some(0.0), None));
        let wrong = of(&[0, 1, 1], &[1, 0, 0]);
        assert_eq!((wrong.precision, wrong.f_score()), (Some(0.0), Some(0.0)));
        assert_eq!(of(&[0, 0], &[1, 0]).recall, None);
        let range = RangeScore { precision: Some(0.25), recall: Some(0.75) };
        assert_eq!(range.f_score(), Some(0.375));
    }

    // By hand: one of three frames is found; ranges that end where the loss starts, or start where it ends, do not meet it.
    #[test]
    fn neighbors_are_not_met() {
        let found = of(&[0, 1, 1, 1, 0], &[1, 0, 1, 0, 1]);
        assert_eq!((found.precision, found.recall), (Some(1.0 / 3.0), Some(1.0 / 3.0)));
    }

    proptest! {
        // With ranges exchanged, precision and recall are.
        #[test]
        fn precision_and_recall_are_each_others_mirror(
            frames in prop::collection::vec((0..2_u8, 0..2_u8), 1..80),
        ) {
            let (lost, alarm): (Vec<u8>, Vec<u8>) = frames.into_iter().unzip();
            let (one, other) = (of(&lost, &alarm), of(&alarm, &lost));
            prop_assert_eq!((one.precision, one.recall), (other.recall, other.precision));
            let own = of(&lost, &lost);
            prop_assert!(own.recall.is_none_or(|r| (r - 1.0).abs() < 1e-12));
        }
    }
}
