//! Summaries of samples: the median, and the correlation of two samples.

/// Median of numbers; for an even number, the mean of the middle two. `None` without numbers. Reorders the
/// slice.
pub fn median(values: &mut [f64]) -> Option<f64> {
    let half = values.len() / 2;
    if values.is_empty() {
        return None;
    }
    let even = values.len().is_multiple_of(2);
    let (below, &mut upper, _) = values.select_nth_unstable_by(half, f64::total_cmp);
    // The largest of the lower half.
    let lower = below.iter().copied().max_by(f64::total_cmp).filter(|_| even);
    Some(lower.map_or(upper, |lower| (lower + upper) / 2.0))
}

/// Pearson's correlation of samples of equal length, from -1 to 1.
///
/// Samples of a variance up to `flat` count as constant. Two constant samples have the correlation 1; a
/// constant and a varying one have 0.
pub fn correlation(a: &[f64], b: &[f64], flat: f64) -> f64 {
    let count = a.len().max(1) as f64;
    let mean = |v: &[f64]| v.iter().sum::<f64>() / count;
    let (mean_a, mean_b) = (mean(a), mean(b));
    let (mut aa, mut bb, mut ab) = (0.0, 0.0, 0.0);
    for (a, b) in a.iter().zip(b) {
        let (a, b) = (a - mean_a, b - mean_b);
        aa += a * a;
        bb += b * b;
        ab += a * b;
    }
    match (aa <= flat * count, bb <= flat * count) {
        (true, true) => 1.0,
        (false, false) => (ab / (aa * bb).sqrt()).clamp(-1.0, 1.0),
        _ => 0.0,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn medians_by_hand() {
        let of_first = [0, 1, 2, 3, 4].map(|n| median(&mut [9.0, 2.0, 4.0, -1.0][..n]));
        assert_eq!(of_first, [None, Some(9.0), Some(5.5), Some(4.0), Some(3.0)]);
    }

    // numpy 2.4.6: np.corrcoef([1, 2, 4, 8], [3, 1, 4, 1])[0, 1]
    #[test]
    fn correlation_agrees_with_numpy() {
        let rho = correlation(&[1.0, 2.0, 4.0, 8.0], &[3.0, 1.0, 4.0, 1.0], 0.0);
        assert!((rho - NUMPY).abs() < 1e-15, "{rho}");
        assert_eq!(correlation(&[5.0; 4], &[7.0; 4], 0.0), 1.0);
        assert_eq!(correlation(&[5.0; 4], &[3.0, 1.0, 4.0, 1.0], 0.0), 0.0);
        assert_eq!(correlation(&[], &[], 0.0), 1.0);
    }
    const NUMPY: f64 = -0.34097520463683817;

    proptest! {
        #[test]
        fn gain_and_offset_change_nothing(
            pairs in proptest::collection::vec((-9.0..9.0_f64, -9.0..9.0_f64), 2..30),
            gain in 0.1..9.0_f64, offset in -9.0..9.0_f64,
        ) {
            let (a, b): (Vec<f64>, Vec<f64>) = pairs.into_iter().unzip();
            let turned = |v: &[f64]| -> Vec<f64> { v.iter().map(|v| gain * v + offset).collect() };
            let rho = correlation(&a, &b, 1e-6);
            let of_turned = correlation(&turned(&a), &turned(&b), 1e-6 * gain * gain);
            prop_assert!((of_turned - rho).abs() < 1e-6);
            prop_assert_eq!(correlation(&b, &a, 1e-6), rho);
            prop_assert!((correlation(&a, &a, 1e-6) - 1.0).abs() < 1e-12);
        }

        #[test]
        fn half_of_the_numbers_lie_on_either_side(mut values in proptest::collection::vec(-9.0..9.0_f64, 1..30)) {
            let middle = median(&mut values).unwrap();
            let below = values.iter().filter(|v| **v < middle).count();
            let above = values.iter().filter(|v| **v > middle).count();
            prop_assert!(2 * below <= values.len() && 2 * above <= values.len());
        }
    }
}
