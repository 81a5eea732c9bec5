//! Curves over time, and sine and cosine.
//!
//! Everything here uses only additions, multiplications, divisions and square roots, which IEEE 754
//! rounds the same way everywhere. A library's `sin` or `exp` may differ in the last bit between
//! machines, and then so would the frames.

/// Quantity over time: `(frame, value)` pairs with rising frames. Empty stands for a default value.
pub type Curve = Vec<(f64, f64)>;

/// Value of the curve at frame `t`; `default` for a curve without points.
///
/// Between the points the curve is a monotone cubic (Fritsch and Carlson 1980, with harmonic-mean slopes): it
/// has a continuous velocity and never overshoots. Before the first and after the last point it is constant.
pub fn at(curve: &[(f64, f64)], t: f64, default: f64) -> f64 {
    let Some((first, last)) = curve.first().zip(curve.last()) else { return default };
    if t <= first.0 {
        return first.1;
    }
    if t >= last.0 {
        return last.1;
    }
    let k = curve.partition_point(|p| p.0 <= t) - 1;
    let (a, b) = (curve[k], curve[k + 1]);
    let step = b.0 - a.0;
    let s = (t - a.0) / step;
    let (s2, s3) = (s * s, s * s * s);
    (2.0 * s3 - 3.0 * s2 + 1.0) * a.1
        + (s3 - 2.0 * s2 + s) * step * slope(curve, k)
        + (3.0 * s2 - 2.0 * s3) * b.1
        + (s3 - s2) * step * slope(curve, k + 1)
}

/// Slope at point `k`: 0 at both ends and at turning points.
fn slope(curve: &[(f64, f64)], k: usize) -> f64 {
    if k == 0 || k + 1 == curve.len() {
        return 0.0;
    }
    let secant = |a: (f64, f64), b: (f64, f64)| (b.1 - a.1) / (b.0 - a.0);
    let (l, r) = (secant(curve[k - 1], curve[k]), secant(curve[k], curve[k + 1]));
    if l * r <= 0.0 { 0.0 } else { 2.0 * l * r / (l + r) }
}

/// Sine and cosine of an angle in turns (1 is the full circle), with an error of about 1e-9.
pub fn sin_cos(turns: f64) -> (f64, f64) {
    (sine(turns), sine(turns + 0.25))
}

fn sine(turns: f64) -> f64 {
    // Folded into -1/4..1/4 turns, where the Taylor series is short.
    let r = turns - (turns + 0.5).floor();
    let r = if r.abs() > 0.25 { 0.5_f64.copysign(r) - r } else { r };
    let x = r * std::f64::consts::TAU;
    let x2 = x * x;
    let mut term = x;
    let mut sum = x;
    for k in 1..8 {
        let n = f64::from(2 * k);
        term *= -x2 / (n * (n + 1.0));
        sum += term;
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn sine_agrees_with_the_library(turns in -20.0..20.0_f64) {
            let (s, c) = sin_cos(turns);
            let (ls, lc) = (turns * std::f64::consts::TAU).sin_cos();
            prop_assert!((s - ls).abs() < 1e-9 && (c - lc).abs() < 1e-9);
        }

        #[test]
        fn stays_between_its_neighbours(t in -5.0..25.0_f64) {
            const C: &[(f64, f64)] = &[(0.0, 1.0), (4.0, 3.0), (5.0, 9.0), (15.0, 9.5), (20.0, -2.0)];
            let v = at(C, t, 0.0);
            let k = C.partition_point(|p| p.0 <= t);
            let a = C[k.saturating_sub(1)].1;
            let b = C[k.min(C.len() - 1)].1;
            prop_assert!(v >= a.min(b) - 1e-12 && v <= a.max(b) + 1e-12);
        }
    }

    // python3: scipy.interpolate.PchipInterpolator([0,4,8,12],[1,3,9,10])([5,6.5,7.9]); equal spacing,
    // so that its weights are 1/2 too and both interior slopes agree.
    #[test]
    fn agrees_with_scipy_inside() {
        const C: &[(f64, f64)] = &[(0.0, 1.0), (4.0, 3.0), (8.0, 9.0), (12.0, 10.0)];
        let scipy = [4.279017857142857, 7.114118303571428, 8.950024553571428];
        trackfail_testing::assert_near([5.0, 6.5, 7.9].map(|t| at(C, t, 0.0)), scipy, 1e-12, "");
        assert_eq!(at(&[], 3.0, 7.5), 7.5);
    }
}
