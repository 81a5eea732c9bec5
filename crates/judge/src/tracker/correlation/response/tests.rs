use super::*;
use crate::tracker::testing::{numbers, state_of_map_by, two_peaks};
use proptest::prelude::*;

fn describe(values: &[f32], width: usize, options: &MapOptions) -> (Response, Moments) {
    let state = state_of_map_by(options, values, width);
    (state.response.unwrap(), state.posterior.unwrap())
}

fn threshold(threshold: f64) -> MapOptions {
    MapOptions { threshold, ..MapOptions::default() }
}

fn close(ours: &[f64], theirs: &[f64], tolerance: f64) {
    assert_eq!(ours.len(), theirs.len());
    for (a, b) in ours.iter().zip(theirs) {
        assert!((a - b).abs() <= tolerance * b.abs().max(1.0), "{ours:?} {theirs:?}");
    }
}

fn density(m: &Moments) -> [f64; 7] {
    [m.mean[0], m.mean[1], m.covariance[0], m.covariance[1], m.covariance[3], m.effective_samples, m.entropy]
}

// python3: import numpy as np; w, h = 20, 16; x, y = np.meshgrid(np.arange(w), np.arange(h))           NumPy 2.4.6
// cyc = lambda d, n: (d + n // 2) % n - n // 2
// bump = lambda a, p, q: np.maximum(0, a - 6 * (cyc(x - p, w)**2 + cyc(y - q, h)**2))
// F = ((7 * x + 13 * y + x * y) % 11 + bump(60, 3, 14) + bump(40, 13, 6)) / 64;  F.argmax() is cell (3, 13)
// dx, dy = cyc(x - 3, w), cyc(y - 13, h); side = lambda a, b: F[(abs(dx) > a) | (abs(dy) > b)]
// F.max(), side(4, 4).max(), F.min(), F.mean(), F.std(), side(5, 5).mean(), side(5, 5).std(), side(1, 1).mean(), ...
// q = np.maximum(0, F - F.mean() - k * F.std()); p = q / q.sum(), for k in 0, 1
// e, f = np.where(2 * abs(dx) == w, 0, dx), np.where(2 * abs(dy) == h, 0, dy); m = (p * e).sum(), (p * f).sum()
// 30 + 2 * m[0], 50 + 2 * m[1], 4 * ((p * dx**2).sum() - m[0]**2), 4 * ((p * e * f).sum() - m[0] * m[1]),
// 4 * ((p * dy**2).sum() - m[1]**2), 1 / (p**2).sum(), -(p[p > 0] * np.log(p[p > 0])).sum() / np.log(w * h)
#[test]
fn numbers_and_moments_agree_with_numpy() {
    let values = two_peaks();
    for (k, want) in [(0.0, DENSITY_OVER_MEAN), (1.0, DENSITY_OVER_ONE_DEVIATION)] {
        let (response, moments) = describe(&values, 20, &threshold(k));
        close(&numbers(&response), &NUMBERS, 1e-14);
        close(&density(&moments), &want, 1e-13);
        assert_eq!(moments.covariance[1], moments.covariance[2]);
        assert_eq!((moments.samples, moments.likelihood), (320.0, response.peak));
    }
}
const NUMBERS: [f64; 9] = [
    0.984375,
    0.703125,
    0.0,
    0.148193359375,
    0.18674147080601225,
    0.11871859296482412,
    0.11778318657059575,
    0.12982315112540194,
    0.15172912762489993,
];
const DENSITY_OVER_MEAN: [f64; 7] = [
    29.957268413674107,
    49.237948883856355,
    105.08989190218034,
    1.1079518219808129,
    62.66946681632384,
    35.20684307613948,
    0.6443833731533144,
];
const DENSITY_OVER_ONE_DEVIATION: [f64; 7] = [
    29.88048049921939,
    49.60805508874474,
    78.41475914849835,
    1.1144094380200893,
    47.683408241117654,
    24.406740862549643,
    0.5739044107316387,
];

// By hand: the places of 4 columns are -1, 0, 1 and half of -2 and 2, their mean square (1 + 0 + 1 + 4) / 4; that of
// three rows is 2 / 3; a cell has 2 x 2 pixels.
#[test]
fn a_map_without_contrast_is_a_uniform_density() {
    for level in [0.0, -3.5] {
        let (response, moments) = describe(&[level; 12], 4, &MapOptions::default());
        let level = f64::from(level);
        assert_eq!(numbers(&response), [level, level, level, level, 0.0, level, 0.0, level, 0.0]);
        close(&density(&moments), &[30.0, 50.0, 6.0, 0.0, 8.0 / 3.0, 12.0, 1.0], 1e-15);
    }
    // Nothing is 20 deviations above the mean of 12 cells.
    let (_, moments) = describe(&[0.0, 1.0, 0.5, 0.2].repeat(3), 4, &threshold(10.0));
    close(&[moments.effective_samples, moments.entropy], &[12.0, 1.0], 1e-15);
}

// By hand: mean a / n, deviation a sqrt(n - 1) / n; the windows take the only value away.
#[test]
fn a_single_spike_is_certain() {
    let mut values = vec![0.0; 400];
    values[399] = 2.0;
    let (response, moments) = describe(&values, 20, &MapOptions::default());
    let deviation = 2.0 * 399.0_f64.sqrt() / 400.0;
    close(&numbers(&response), &[2.0, 0.0, 0.0, 0.005, deviation, 0.0, 0.0, 0.0, 0.0], 1e-9);
    close(&density(&moments), &[30.0, 50.0, 0.0, 0.0, 0.0, 1.0, 0.0], 1e-15);
}

#[test]
fn windows_as_large_as_the_map_leave_the_whole_map() {
    let values: Vec<f32> = (0..99_i16).map(|i| f32::from(i * 37 % 101)).collect();
    let whole = MapOptions { neighborhood: 1.0, ..MapOptions::default() };
    let (response, _) = describe(&values, 11, &whole);
    assert_eq!(response.second_peak, response.lowest);
    assert_eq!(response.sidelobe_mean, response.mean);
    assert_eq!(response.sidelobe_deviation, response.deviation);
    assert_ne!(response.narrow_sidelobe_mean, response.mean);
    // A box of the peak alone.
    let (response, _) = describe(&values, 11, &MapOptions { neighborhood: 0.0, ..whole });
    assert_eq!((response.peak, response.second_peak), (100.0, 99.0));
}

/// Maps of quarters, for which sums are exact, with a unique highest value.
fn maps() -> impl Strategy<Value = (usize, Vec<f32>)> {
    (3..24_usize, 3..24_usize).prop_flat_map(|(w, h)| {
        let values = prop::collection::vec(-40..40_i16, w * h);
        (values, 0..w * h).prop_map(move |(values, top)| {
            let mut values: Vec<f32> = values.into_iter().map(|v| f32::from(v) / 4.0).collect();
            values[top] = 11.0;
            (w, values)
        })
    })
}

proptest! {
    // A cyclic shift moves nothing, gain and offset change values but not the density, and a mirror image mirrors it.
    #[test]
    fn symmetries_of_a_map_are_those_of_its_numbers(
        (w, values) in maps(), dx in 0..24_usize, dy in 0..24_usize,
        gain in 1..9_i16, offset in -50..50_i16, k in 0.0..2.0,
    ) {
        let h = values.len() / w;
        let of = |values: &[f32]| {
            let (response, moments) = describe(values, w, &threshold(k));
            (numbers(&response), density(&moments))
        };
        let (all, whole) = of(&values);
        let shifted: Vec<f32> =
            (0..w * h).map(|i| values[(i / w + dy) % h * w + (i % w + dx) % w]).collect();
        let (got, moved) = of(&shifted);
        close(&got, &all, 1e-12);
        close(&moved, &whole, 1e-9);

        let (gain, offset) = (f32::from(gain) / 2.0, f32::from(offset));
        let (got, other) = of(&values.iter().map(|v| gain * v + offset).collect::<Vec<_>>());
        let (gain, offset) = (f64::from(gain), f64::from(offset));
        let want: [f64; 9] =
            std::array::from_fn(|i| gain * all[i] + if [4, 6, 8].contains(&i) { 0.0 } else { offset });
        close(&got, &want, 1e-10);
        close(&other, &whole, 1e-9);

        let across: Vec<f32> = values.chunks(w).flat_map(|row| row.iter().rev().copied()).collect();
        let (got, mirrored) = of(&across);
        let [x, y, xx, xy, yy, n, entropy] = whole;
        close(&got, &all, 1e-12);
        close(&mirrored, &[60.0 - x, y, xx, -xy, yy, n, entropy], 1e-9);
        prop_assert!(xx * yy - xy * xy >= -1e-9 * xx * yy);
    }
}
