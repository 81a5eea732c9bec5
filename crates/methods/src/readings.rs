//! Distance of the readings of a paper from the numbers that the paper prints.
//!
//! A reading is one way to understand a paper where its text leaves a choice open: a method or tracker with
//! `like` in the experiment, or the method or tracker that `like` names. For each reading and each published
//! statistic:
//!
//! ```text
//! d_s  = ours - published
//! e_s  = standard deviation of ours over bootstrap samples of sequences, for the reading that the others are like;
//!        at least sqrt(p (1 - p) / n) for a published share p of n events, detections or frames of ours (few sequences can
//!        agree by chance), and at least half a unit of the last digit that the paper prints
//! D    = sqrt( mean over s of (d_s / e_s)^2 )              the discrepancy of a reading
//! ```
//!
//! D is about 1 if another choice of sequences would explain the differences. The definition was fixed before
//! any D was computed. All published statistics have equal weights, with two exceptions: statistics made of F
//! are shown, but do not count in D; plain counts are left out, since they depend on the number of sequences
//! (their rates per 1000 frames are used instead). All readings of one method on one tracker use the same
//! e_s, so that no reading wins because its numbers vary more. `first` is the share of bootstrap samples in
//! which a reading has the smallest D; the samples are the same for all readings. A low D is good.

use crate::score::frames::bootstrap::Samples;
use crate::score::metric::Kind;
use crate::score::{Counts, Metric, Pooled};
use std::collections::BTreeMap;

/// A published number of a method on a tracker.
#[derive(Debug, Clone, PartialEq)]
pub struct Statistic {
    /// Metric of the number.
    pub metric: Metric,
    /// The published number.
    pub published: f64,
    /// Half a unit of the last digit of the published number.
    half_unit: f64,
}

impl Statistic {
    /// Statistics in a published text: two if it is a mean with a standard deviation, none if the metric is a
    /// plain count.
    pub fn of_text(metric: Metric, text: &str) -> Vec<Self> {
        let metrics = match metric.kind {
            Kind::MeanAndDeviation => vec![Metric::SCORE_MEAN, Metric::SCORE_STD],
            Kind::Count => Vec::new(),
            _ => vec![metric],
        };
        let statistic = |(metric, part): (Metric, &str)| {
            let digits = part.trim().split_once('.').map_or(0, |(_, digits)| digits.len());
            let half_unit = 0.5 * 10.0_f64.powi(-i32::try_from(digits).unwrap_or(i32::MAX));
            Some(Self { metric, published: part.trim().parse().ok()?, half_unit })
        };
        metrics.into_iter().zip(text.split('±')).filter_map(statistic).collect()
    }

    /// True if the statistic counts in the discrepancy.
    fn counts(&self) -> bool {
        !self.metric.name().starts_with("f_")
    }
}

/// Standard error of a published share that was measured on as many events, detections or frames as `counts`
/// has; 0 if the metric is not a share.
fn share_error(metric: Metric, published: f64, counts: &Counts) -> f64 {
    let Counts { tp, fp, fn_, tn } = *counts;
    let (unit, of) = match metric.name() {
        "precision" => (1.0, tp + fp),
        "recall" => (1.0, tp + fn_),
        "fpr" => (1.0, fp + tn),
        "detections_per_1000" | "events_per_1000" | "false_alarms_per_1000" => (1000.0, tp + fp + fn_ + tn),
        _ => return 0.0,
    };
    let share = (published / unit).clamp(0.0, 1.0);
    unit * (share * (1.0 - share) / of.max(1) as f64).sqrt()
}

/// Contribution of one sequence to the numbers of a reading, over all runs.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Part {
    counts: Counts,
    /// Number, sum, and sum of squares of the normalized scores.
    moments: [f64; 3],
}

impl Part {
    /// The part of one run.
    pub fn new(counts: Counts, scores: &[f64]) -> Self {
        Self { counts, moments: moments(scores) }
    }

    /// Adds `other`, multiplied by `times`.
    pub fn add(&mut self, other: &Self, times: u64) {
        let Counts { tp, fp, fn_, tn } = other.counts;
        let more = Counts { tp: tp * times, fp: fp * times, fn_: fn_ * times, tn: tn * times };
        self.counts = [self.counts, more].into_iter().sum();
        self.moments.iter_mut().zip(other.moments).for_each(|(sum, m)| *sum += times as f64 * m);
    }

    fn value(&self, metric: Metric) -> Option<f64> {
        let [count, sum, squares] = self.moments;
        let score = (count > 0.0).then(|| {
            let mean = sum / count;
            (mean, (squares / count - mean * mean).max(0.0).sqrt())
        });
        metric.value(&Pooled { counts: self.counts, score, ..Pooled::default() })
    }
}

/// Number, sum, and sum of squares of the scores after min-max normalization, as in [`crate::score::pooled`].
fn moments(scores: &[f64]) -> [f64; 3] {
    let low = scores.iter().copied().fold(f64::INFINITY, f64::min);
    let high = scores.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    if high <= low {
        return [0.0; 3];
    }
    scores.iter().map(|z| (z - low) / (high - low)).fold([0.0; 3], |[n, s, q], z| [n + 1.0, s + z, q + z * z])
}

/// The numbers of a reading and of its bootstrap samples.
#[derive(Debug)]
pub struct Reading {
    /// The published statistics.
    pub statistics: Vec<Statistic>,
    /// Our value of each statistic.
    pub ours: Vec<Option<f64>>,
    /// Our values of the statistics in each bootstrap sample; NaN where a sample has none.
    pub samples: Vec<Vec<f64>>,
    /// Parts by index of the sequence.
    parts: BTreeMap<usize, Part>,
    counts: Counts,
}

/// Root mean square of differences in units of e_s; `None` if there are none.
fn discrepancy(scaled: impl Iterator<Item = Option<f64>>) -> Option<f64> {
    let squares: Vec<f64> = scaled.flatten().map(|z| z * z).collect();
    (!squares.is_empty()).then(|| (squares.iter().sum::<f64>() / squares.len() as f64).sqrt())
}

/// Standard deviation of the finite values.
fn deviation(values: &[f64]) -> f64 {
    let known: Vec<f64> = values.iter().copied().filter(|v| v.is_finite()).collect();
    let count = known.len().max(1) as f64;
    let mean = known.iter().sum::<f64>() / count;
    (known.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / count).sqrt()
}

impl Reading {
    /// Computes the numbers of a reading from the parts of the sequences.
    pub fn new(statistics: Vec<Statistic>, parts: BTreeMap<usize, Part>, seed: u64) -> Self {
        let all: Vec<Part> = parts.values().copied().collect();
        let samples = Samples::new(all.len(), seed);
        let sum = |weights: &[u64]| {
            let mut sum = Part::default();
            all.iter().zip(weights).for_each(|(part, times)| sum.add(part, *times));
            sum
        };
        let whole = sum(&vec![1; all.len()]);
        let drawn: Vec<Part> = samples.each().map(|weights| sum(&weights)).collect();
        let in_samples =
            |s: &Statistic| drawn.iter().map(|p| p.value(s.metric).unwrap_or(f64::NAN)).collect();
        Self {
            ours: statistics.iter().map(|s| whole.value(s.metric)).collect(),
            samples: statistics.iter().map(in_samples).collect(),
            counts: whole.counts,
            statistics,
            parts,
        }
    }

    /// The unit e_s of each statistic, by name of the metric.
    pub fn scales(&self) -> BTreeMap<&'static str, f64> {
        let scale = |(s, samples): (&Statistic, &Vec<f64>)| {
            let least = share_error(s.metric, s.published, &self.counts).max(s.half_unit);
            (s.metric.name(), deviation(samples).max(least))
        };
        self.statistics.iter().zip(&self.samples).map(scale).collect()
    }

    /// Discrepancy D of our numbers, or of the numbers of a bootstrap sample.
    pub fn discrepancy(&self, scales: &BTreeMap<&str, f64>, sample: Option<usize>) -> Option<f64> {
        let scaled = |(k, s): (usize, &Statistic)| {
            let ours = match sample {
                None => self.ours[k]?,
                Some(draw) => *self.samples[k].get(draw).filter(|v| v.is_finite())?,
            };
            Some((ours - s.published) / scales.get(s.metric.name())?)
        };
        discrepancy(self.statistics.iter().enumerate().filter(|(_, s)| s.counts()).map(scaled))
    }
}

/// For each reading the share of samples in which its discrepancy is the smallest; a tie is divided equally.
pub fn shares(readings: &[&Reading], scales: &BTreeMap<&str, f64>) -> Option<Vec<f64>> {
    let same = readings.windows(2).all(|pair| pair[0].parts.keys().eq(pair[1].parts.keys()));
    let draws = readings.first()?.samples.first()?.len();
    if !same || draws == 0 || readings.iter().any(|r| r.discrepancy(scales, None).is_none()) {
        return None;
    }
    let mut shares = vec![0.0; readings.len()];
    for draw in 0..draws {
        let all: Vec<f64> =
            readings.iter().map(|r| r.discrepancy(scales, Some(draw)).unwrap_or(f64::INFINITY)).collect();
        let least = all.iter().copied().fold(f64::INFINITY, f64::min);
        let ties = all.iter().filter(|d| **d <= least).count() as f64;
        all.iter().zip(&mut shares).filter(|(d, _)| **d <= least).for_each(|(_, share)| *share += 1.0 / ties);
    }
    Some(shares.into_iter().map(|share| share / draws as f64).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn discrepancies_by_hand() {
        // Differences of 3 and 4 units, one statistic without a value.
        assert_eq!(discrepancy([Some(3.0), None, Some(-4.0)].into_iter()), Some(12.5_f64.sqrt()));
        assert_eq!(discrepancy([None].into_iter()), None);
        assert_eq!(deviation(&[1.0, f64::NAN, 3.0]), 1.0);
        // A half of 16 events: .5 / 4.
        let counts = Counts { tp: 16, fp: 9, fn_: 0, tn: 975 };
        assert_eq!(share_error(Metric::RECALL, 0.5, &counts), 0.125);
        assert_eq!(share_error(Metric::SCORE_MEAN, 0.5, &counts), 0.0);
    }

    // numpy: z = [0, .5, 1, .25]; mean .4375, std .3698 (population).
    #[test]
    fn moments_are_those_of_the_metric() {
        let scores = [2.0, 4.0, 6.0, 3.0];
        let part = Part { moments: moments(&scores), ..Part::default() };
        let (mean, std) = crate::score::pooled::normalized_mean_std([&scores]).unwrap();
        assert!((part.value(Metric::SCORE_MEAN).unwrap() - mean).abs() < 1e-15);
        assert!((part.value(Metric::SCORE_STD).unwrap() - std).abs() < 1e-15);
        assert!((mean - 0.4375).abs() < 1e-15 && (std - 0.369_754_986_443_726).abs() < 1e-14);
        assert_eq!(moments(&[7.0, 7.0]), [0.0; 3]);
    }

    #[test]
    fn the_reading_that_is_nearest_in_every_sample_has_all_of_them() {
        let statistic = Statistic { metric: Metric::RECALL, published: 0.5, half_unit: 0.0005 };
        let reading = |ours: f64| Reading {
            statistics: vec![statistic.clone()],
            parts: BTreeMap::from([(0, Part::default())]),
            counts: Counts::default(),
            ours: vec![Some(ours)],
            samples: vec![vec![ours - 0.01, ours, ours + 0.01]],
        };
        let (far, near, same) = (reading(0.9), reading(0.52), reading(0.52));
        let scales = BTreeMap::from([("recall", 0.1)]);
        assert_eq!(shares(&[&far, &near], &scales), Some(vec![0.0, 1.0]));
        assert_eq!(shares(&[&near, &far, &same], &scales), Some(vec![0.5, 0.0, 0.5]));
        assert!((far.discrepancy(&scales, None).unwrap() - 4.0).abs() < 1e-12);
    }
}
