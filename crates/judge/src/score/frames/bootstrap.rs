//! Uncertainty of ranking measures that comes from the choice of sequences: bootstrap over sequences.
//!
//! ```text
//! w_a        number of times that sequence a is drawn: as many draws with replacement as there are sequences
//! U_ab       pairs of a lost frame of a and a good frame of b in which the lost one has the higher score, ties half
//! AUROC*   = sum_ab w_a w_b U_ab / (sum_a w_a lost_a  sum_b w_b good_b)
//! interval   quantiles of the measure over the samples (percentile method)
//! ```
//!
//! All frames and runs of a sequence are drawn together. The form in `U` is exact: it is the AUROC of the sample's
//! frames. Average precision is computed from each sample's frames in the order of their scores. A sample without a
//! lost or a good frame has no value and is left out; there is no interval when that happens to more than half of them.

use super::sweep::Sweep;
pub use crate::num::pooled::MIN_UNITS as MIN_SEQUENCES;
use crate::num::pooled::{LEVEL, percentiles};
use crate::num::seed;
use rand::RngExt;

/// Largest number of samples.
pub const SAMPLES: usize = 1000;
/// Least number of samples, also used for average precision.
pub const FEW_SAMPLES: usize = 200;

/// Largest number of sequences for which there are [`SAMPLES`] samples. The work grows with its square.
const MANY_SEQUENCES: usize = 256;
/// Number of samples that are computed side by side.
const LANES: usize = 8;

/// Bootstrap samples of sequences: the number of times that each sample contains each sequence.
#[derive(Debug, Clone)]
pub struct Samples {
    sequences: usize,
    /// One row for each block of [`LANES`] samples, with one entry per sequence.
    blocks: Vec<Vec<[f64; LANES]>>,
}

impl Samples {
    /// Draws samples; none if there are fewer than [`MIN_SEQUENCES`] sequences.
    pub fn new(sequences: usize, seed: u64) -> Self {
        let mut rng = seed::rng(seed);
        let fits = SAMPLES * MANY_SEQUENCES.pow(2) / sequences.pow(2).max(1);
        let samples = if sequences < MIN_SEQUENCES { 0 } else { fits.clamp(FEW_SAMPLES, SAMPLES) };
        let mut block = || {
            let mut weights = vec![[0.0; LANES]; sequences];
            for draw in 0..LANES * sequences {
                weights[rng.random_range(0..sequences)][draw / sequences] += 1.0;
            }
            weights
        };
        Self { sequences, blocks: (0..samples / LANES).map(|_| block()).collect() }
    }

    /// Weights of the sequences in each sample.
    pub fn each(&self) -> impl Iterator<Item = Vec<u64>> + '_ {
        let sample = |block: &Vec<[f64; LANES]>, lane: usize| block.iter().map(|w| w[lane] as u64).collect();
        self.blocks.iter().flat_map(move |block| (0..LANES).map(move |lane| sample(block, lane)))
    }

    /// AUROC in each sample; NaN in samples without a lost or a good frame. Empty without samples.
    pub fn auroc(&self, sweep: &Sweep) -> Vec<f64> {
        if self.blocks.is_empty() || sweep.lost.len() != self.sequences {
            return Vec::new();
        }
        let pairs = pairs(sweep);
        let mut values = Vec::with_capacity(self.blocks.len() * LANES);
        for block in &self.blocks {
            let (mut wins, mut lost, mut good) = ([0.0; LANES], [0.0; LANES], [0.0; LANES]);
            for (a, row) in pairs.chunks_exact(self.sequences).enumerate() {
                let mut sum = [0.0; LANES];
                for (u, w) in row.iter().zip(block) {
                    sum.iter_mut().zip(w).for_each(|(s, w)| *s += u * w);
                }
                for lane in 0..LANES {
                    let w = block[a][lane];
                    wins[lane] += w * sum[lane];
                    lost[lane] += w * sweep.lost[a] as f64;
                    good[lane] += w * sweep.good[a] as f64;
                }
            }
            values.extend((0..LANES).map(|lane| wins[lane] / (lost[lane] * good[lane])));
        }
        values
    }

    /// Interval of the average precision, from the first [`FEW_SAMPLES`] samples.
    pub fn average_precision(&self, sweep: &Sweep) -> Option<(f64, f64)> {
        if self.blocks.is_empty() || sweep.lost.len() != self.sequences {
            return None;
        }
        let few = &self.blocks[..self.blocks.len().min(FEW_SAMPLES / LANES)];
        interval(few.iter().flat_map(|block| weighted_precision(sweep, block)).collect())
    }
}

/// Average precision of [`LANES`] samples with these weights of sequences; NaN without a lost frame.
fn weighted_precision(sweep: &Sweep, weights: &[[f64; LANES]]) -> [f64; LANES] {
    let (mut above, mut frames, mut sum) = ([0.0; LANES], [0.0; LANES], [0.0; LANES]);
    for tie in sweep.ties() {
        let mut here = [0.0; LANES];
        for frame in tie {
            let w = &weights[frame.sequence as usize];
            frames.iter_mut().zip(w).for_each(|(f, w)| *f += w);
            if frame.lost {
                here.iter_mut().zip(w).for_each(|(h, w)| *h += w);
            }
        }
        if tie.iter().any(|frame| frame.lost) {
            for lane in 0..LANES {
                above[lane] += here[lane];
                // Where no frame was drawn yet, `here` is 0.
                sum[lane] += here[lane] * above[lane] / f64::max(frames[lane], 1.0);
            }
        }
    }
    std::array::from_fn(|lane| sum[lane] / above[lane])
}

/// Matrix of the U_ab, row by row.
fn pairs(sweep: &Sweep) -> Vec<f64> {
    let n = sweep.lost.len();
    let mut pairs = vec![0.0; n * n];
    // Good frames with lower scores, and lost and good frames of the tie, by sequence.
    let (mut below, mut lost, mut good) = (vec![0.0; n], vec![0_u32; n], vec![0.0; n]);
    for tie in sweep.ties().rev() {
        if let [one] = tie {
            let a = one.sequence as usize;
            if one.lost {
                pairs[a * n..(a + 1) * n].iter_mut().zip(&below).for_each(|(u, b)| *u += b);
            } else {
                below[a] += 1.0;
            }
            continue;
        }
        for frame in tie {
            let a = frame.sequence as usize;
            if frame.lost { lost[a] += 1 } else { good[a] += 1.0 }
        }
        for frame in tie.iter().filter(|f| f.lost) {
            let a = frame.sequence as usize;
            let count = f64::from(std::mem::take(&mut lost[a]));
            if count > 0.0 {
                let row = pairs[a * n..(a + 1) * n].iter_mut();
                row.zip(below.iter().zip(&good)).for_each(|(u, (b, g))| *u += count * (b + g / 2.0));
            }
        }
        for frame in tie {
            let a = frame.sequence as usize;
            below[a] += std::mem::take(&mut good[a]);
        }
    }
    pairs
}

/// Interval at [`LEVEL`] of values; NaN stands for a missing value.
pub fn interval(values: Vec<f64>) -> Option<(f64, f64)> {
    let samples = values.len();
    percentiles(values, samples, LEVEL)
}

#[cfg(test)]
mod tests {
    use super::super::ranking::{auroc, average_precision};
    use super::super::sweep::tests::{frames, sweep_of};
    use super::*;
    use proptest::prelude::*;

    /// Frames of the sequences, each repeated by its weight.
    fn repeated(sequences: &[Vec<(f64, bool)>], weights: &[u64]) -> Vec<Vec<(f64, bool)>> {
        let repeat = |(frames, w): (&Vec<(f64, bool)>, &u64)| frames.repeat(*w as usize);
        sequences.iter().zip(weights).map(repeat).collect()
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(64))]

        // The second way: measures of the sample's frames themselves.
        #[test]
        fn samples_have_the_measures_of_their_frames(sequences in prop::collection::vec(frames(), 3..6), seed in 0..9_u64) {
            let swept = sweep_of(&sequences);
            let samples = Samples::new(sequences.len(), seed);
            let drawn = samples.each().map(|w| sweep_of(&repeated(&sequences, &w)));
            let precision = samples.blocks[..FEW_SAMPLES / LANES].iter().flat_map(|b| weighted_precision(&swept, b));
            for ((sample, area), precision) in drawn.zip(samples.auroc(&swept)).zip(precision) {
                for (found, expected) in [(area, auroc(&sample)), (precision, average_precision(&sample))] {
                    match expected {
                        Some(expected) => prop_assert!((found - expected).abs() < 1e-12),
                        None => prop_assert!(found.is_nan()),
                    }
                }
            }
        }
    }

    #[test]
    fn intervals_hold_the_value_and_need_sequences() {
        let sequence =
            |k: u32| (0..40).map(|t| (f64::from((t * 7 + k) % 13), (t + k).is_multiple_of(3))).collect();
        let sequences: Vec<Vec<(f64, bool)>> = (0..12).map(sequence).collect();
        let swept = sweep_of(&sequences);
        let samples = Samples::new(12, 5);
        let areas = samples.auroc(&swept);
        assert_eq!(areas.len(), SAMPLES);
        let bounds = interval(areas).unwrap();
        let precision = samples.average_precision(&swept).unwrap();
        let few = samples.each().take(FEW_SAMPLES);
        let few = few.map(|w| average_precision(&sweep_of(&repeated(&sequences, &w))).unwrap());
        let expected = interval(few.collect()).unwrap();
        trackfail_testing::assert_near(<[f64; 2]>::from(precision), <[f64; 2]>::from(expected), 1e-12, "");
        for ((low, high), value) in [(bounds, auroc(&swept)), (precision, average_precision(&swept))] {
            assert!(low < value.unwrap() && value.unwrap() < high, "{low} {value:?} {high}");
        }
        for (samples, sequences) in [(Samples::new(2, 5), &sequences[..2]), (samples, &sequences[..11])] {
            let swept = sweep_of(sequences);
            assert!(samples.auroc(&swept).is_empty() && samples.average_precision(&swept).is_none());
        }
        assert_eq!(interval(vec![f64::NAN, f64::NAN, 1.0]), None);
        assert_eq!(interval(vec![f64::NAN, f64::NAN, 1.0, 3.0]), Some((1.05, 2.95)));
    }

    #[test]
    fn many_sequences_have_fewer_samples() {
        let samples = |sequences| Samples::new(sequences, 1).blocks.len() * LANES;
        assert_eq!((samples(256), samples(362), samples(2000)), (1000, 496, 200));
    }
}
