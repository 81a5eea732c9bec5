//! Inputs of all metrics, pooled over a suite for one method and tracker.

use super::chance::Chance;
use super::counts::Counts;
use super::frames::FrameMeasures;
use crate::detector::track_quality::Effort;
use crate::num::summary::median;

/// Inputs of all metrics, pooled over a suite for one method and tracker.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Pooled {
    /// Summed counts.
    pub counts: Counts,
    /// Mean and standard deviation of the normalized scores, see [`normalized_mean_std`].
    pub score: Option<(f64, f64)>,
    /// Amount of reverse runs; `None` if it is unknown.
    pub effort: Option<Effort>,
    /// Rule by which random detections match in the method's protocol; `None` if the protocol is unknown.
    pub chance: Option<Chance>,
    /// Median delay of matched detections, in frames, see [`median_delay`].
    pub delay: Option<f64>,
    /// Measures by frame; `None` if they were not computed.
    pub frames: Option<FrameMeasures>,
}

/// Median of delays in frames; for an even number, the mean of the middle two. `None` without delays.
///
/// The delay of a detection is its frame minus the frame of the event that it matches, negative if the
/// detection comes first.
pub fn median_delay(delays: Vec<i64>) -> Option<f64> {
    median(&mut delays.into_iter().map(|delay| delay as f64).collect::<Vec<_>>())
}

/// Mean and standard deviation of scores that are min-max normalized by sequence (Khalid et al. 2016,
/// Eq. 12): `z' = (z - min Z) / (max Z - min Z)`, where Z is the scores of one sequence.
///
/// The normalized values of all sequences are pooled; the deviation is the population's. Sequences of
/// constant score have no normalized values and are left out. `None` when nothing is left.
pub fn normalized_mean_std(sequences: impl IntoIterator<Item = impl AsRef<[f64]>>) -> Option<(f64, f64)> {
    let mut normalized = Vec::new();
    for scores in sequences {
        let scores = scores.as_ref();
        let (low, high) =
            scores.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), &z| (l.min(z), h.max(z)));
        if high > low {
            normalized.extend(scores.iter().map(|z| (z - low) / (high - low)));
        }
    }
    let n = normalized.len() as f64;
    let mean = normalized.iter().sum::<f64>() / n;
    let variance = normalized.iter().map(|z| (z - mean).powi(2)).sum::<f64>() / n;
    (!normalized.is_empty()).then(|| (mean, variance.sqrt()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn medians_of_delays_by_hand() {
        assert_eq!(median_delay(vec![5, -1, 2]), Some(2.0));
        assert_eq!(median_delay(vec![3, -4, 0, 1]), Some(0.5));
        assert_eq!(median_delay(vec![]), None);
    }

    // Worked by hand: [3, 4, 5] -> 0, .5, 1 and [4, 4] has no range; mean .5, variance 1/6.
    #[test]
    fn normalizes_each_sequence_by_itself() {
        let (mean, std) = normalized_mean_std([&[3.0, 4.0, 5.0][..], &[4.0, 4.0][..]]).unwrap();
        assert_eq!(mean, 0.5);
        assert!((std - (1.0_f64 / 6.0).sqrt()).abs() < 1e-15);
        assert_eq!(normalized_mean_std([&[1.0, 1.0][..]]), None);
    }
}
