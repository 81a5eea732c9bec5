//! Comparison of the flow with OpenCV, and its properties.

use super::*;
use crate::testing::{cases, count, number};
use serde_json::Value;

/// Image made by `image` in `tests/oracles/flow.py`.
fn image(width: usize, height: usize, [dx, dy, zoom]: [f64; 3]) -> Vec<u8> {
    let pixel = |k: usize| {
        let (u, v) = (((k % width) as f64 - dx) / zoom, ((k / width) as f64 - dy) / zoom);
        let value = 128.0
            + 30.0 * (0.21 * u + 0.13 * v).sin()
            + 25.0 * (0.47 * v - 0.32 * u).sin()
            + 20.0 * (0.83 * u + 0.2).sin()
            + 15.0 * (0.71 * v + 0.9 * u).sin();
        (value + 0.5).floor() as u8
    };
    (0..width * height).map(pixel).collect()
}

fn points(case: &Value, key: &str) -> Vec<Point> {
    let pair = |v: &Value| (number(&v[0]), number(&v[1]));
    case[key].as_array().unwrap().iter().map(pair).collect()
}

// `tests/oracles/flow.json`, written by `python3 tests/oracles/flow.py`.
#[test]
fn places_are_those_of_opencv() {
    let (mut compared, mut far) = (0, Vec::new());
    for case in &cases("flow", "cases") {
        let [width, height, levels, window, iterations] =
            ["width", "height", "levels", "window", "iterations"].map(|key| count(&case[key]));
        let motion: [f64; 3] = serde_json::from_value(case["motion"].clone()).unwrap();
        let pixels = [image(width, height, [0.0, 0.0, 1.0]), image(width, height, motion)];
        for (pixels, sum) in pixels.iter().zip(case["byte_sums"].as_array().unwrap()) {
            let own: u64 = pixels.iter().map(|v| u64::from(*v)).sum();
            assert_eq!(Some(own), sum.as_u64(), "not the oracle's image");
        }
        let [first, second] = pixels.map(|pixels| Pyramid::new(width, height, pixels, levels, window));
        let method = LucasKanade { window, iterations, epsilon: number(&case["epsilon"]) };
        let starts = [points(case, "points"), points(case, "found")];
        let ends = [method.follow(&first, &second, &starts[0]), method.follow(&second, &first, &starts[1])];
        for ((ours, key), status) in ends.iter().zip(["found", "back"]).zip(["status", "status_back"]) {
            let theirs = points(case, key);
            for (k, (ours, theirs)) in ours.iter().zip(theirs).enumerate() {
                assert_eq!(ours.is_some(), case[status][k] == 1, "{} {key} {k}", case["name"]);
                let Some(ours) = ours else { continue };
                compared += 1;
                let apart = (ours.0 - theirs.0).hypot(ours.1 - theirs.1);
                if apart > 0.005 {
                    far.push((key, k, apart));
                }
            }
        }
    }
    // Steps in a window of 5 x 5 pixels that lost its way on a coarse level: the last bits of `f32` decide.
    assert!(compared > 400 && far.len() == 1, "{compared} {far:?}");
}

#[test]
fn levels_are_smoothed_and_halved() {
    let (width, height) = (23, 8);
    let pixels = image(width, height, [0.0, 0.0, 1.0]);
    let pyramid = Pyramid::new(width, height, pixels.clone(), 4, 3);
    let sizes: Vec<_> = pyramid.levels.iter().map(|level| (level.width, level.height)).collect();
    assert_eq!(sizes, [(23, 8), (12, 4)]);
    let mirror = |at: i64, length: i64| {
        let at = at.abs();
        (if at < length { at } else { 2 * (length - 1) - at }) as usize
    };
    for (y, x) in (0..4).flat_map(|y| (0..12).map(move |x| (y, x))) {
        let mut sum = 0;
        for (i, j) in (0..5).flat_map(|i| (0..5).map(move |j| (i, j))) {
            let weight = [1, 4, 6, 4, 1][i] * [1, 4, 6, 4, 1][j];
            let row = mirror(2 * y + i as i64 - 2, height as i64);
            let column = mirror(2 * x + j as i64 - 2, width as i64);
            sum += weight * u32::from(pixels[row * width + column]);
        }
        let mut block = Vec::new();
        pyramid.levels[1].block(x, y, 1, &mut block);
        assert_eq!(block, [((sum + 128) / 256) as i32], "{x} {y}");
    }
}

#[test]
fn what_has_no_texture_or_no_image_is_lost() {
    let flat = Pyramid::new(40, 30, vec![90; 1200], 3, 5);
    let method = LucasKanade { window: 5, iterations: 20, epsilon: 0.03 };
    assert_eq!(method.follow(&flat, &flat, &[(20.0, 15.0)]), [None]);
    let image = Pyramid::new(96, 80, image(96, 80, [0.0, 0.0, 1.0]), 3, 5);
    let beyond = [(-400.0, 15.0), (1e300, 3.0), (f64::NAN, 3.0)];
    assert_eq!(method.follow(&image, &image, &beyond), [None; 3]);
    let dot = Pyramid::new(1, 1, vec![7], 3, 5);
    assert_eq!(method.follow(&dot, &dot, &[(0.0, 0.0)]), [None]);
}

#[test]
fn patches_lie_between_pixels() {
    let ramp = Pyramid::new(9, 9, (0..81).map(|k| (k % 9 * 10 + k / 9) as u8).collect(), 0, 3);
    assert_eq!(ramp.patch(4.0, 4.5, 2), [39.0, 49.0, 40.0, 50.0]);
    assert_eq!(ramp.patch(-3.0, 20.0, 2), [8.0; 4]);
}
