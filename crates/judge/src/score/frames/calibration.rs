//! Expected calibration error of a score that is a probability.
//!
//! ```text
//! ECE = sum over bins b of n_b / n |good_b / n_b - mean of p in b|          ten bins of equal width: p in [b/10, (b+1)/10)
//! ```
//!
//! `p` is the probability that the tracker is on target, `good_b` the number of good frames among the `n_b` frames whose
//! `p` is in bin b; a `p` of 1 is in the last bin. In `[0, 1]`, low is good. Source: Guo et al., ICML 2017, eq. 3, with
//! bins closed on the left instead of the right.

/// Number of bins of equal width from 0 to 1.
pub const BINS: usize = 10;

/// ECE of frames, given by the probability of being on target and true if they are good; `None` without
/// frames, or if a probability is outside `[0, 1]`.
pub fn expected_calibration_error(frames: impl IntoIterator<Item = (f64, bool)>) -> Option<f64> {
    // Frames, good frames and sum of p of each bin.
    let mut bins = [(0_u64, 0_u64, 0.0_f64); BINS];
    for (p, good) in frames {
        if !(0.0..=1.0).contains(&p) {
            return None;
        }
        let bin = &mut bins[((p * BINS as f64) as usize).min(BINS - 1)];
        *bin = (bin.0 + 1, bin.1 + u64::from(good), bin.2 + p);
    }
    let frames: u64 = bins.iter().map(|b| b.0).sum();
    let error = |(_, good, sum): &(u64, u64, f64)| (*good as f64 - sum).abs();
    (frames > 0).then(|| bins.iter().map(error).sum::<f64>() / frames as f64)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::score::testing::{oracle, value};
    use serde_json::Value;
    use trackfail_testing::assert_near;

    // By hand: bin 0 has a mean of .05 and no good frame, bin 9 a mean of .95 and 2 of 4 good.
    #[test]
    fn two_bins_by_hand() {
        let frames = [(0.02, false), (0.08, false), (0.92, true), (0.9, false), (1.0, true), (0.98, false)];
        let ece = expected_calibration_error(frames).unwrap();
        assert!((ece - (2.0 * 0.05 + 4.0 * 0.45) / 6.0).abs() < 1e-15, "{ece}");
        assert_eq!(expected_calibration_error([]), None);
        assert_eq!(expected_calibration_error([(1.5, true)]), None);
    }

    // tests/oracles/frames.py: numpy.digitize and means, NumPy 1.26.4.
    #[test]
    fn agrees_with_numpy() {
        for case in &oracle::<Vec<Value>>("calibration") {
            let (p, good): (Vec<f64>, Vec<u8>) = (value(case, "p"), value(case, "good"));
            let ece = expected_calibration_error(p.into_iter().zip(good.iter().map(|g| *g == 1)));
            assert_near(ece, [value::<f64>(case, "ece")], 1e-14, "");
        }
    }
}
