//! Values of known motions.

use super::*;
use crate::signal::testing::{run, takes};
use proptest::prelude::*;

/// Waves shifted by `(dx, dy)`; `other` changes them to those of another scene.
fn scene(dx: f64, dy: f64, other: f64) -> Frame {
    Frame::from_fn(160, 120, |x, y| {
        let (u, v) = (x as f64 - dx, y as f64 - dy);
        let value = 128.0
            + 40.0 * (0.05 * u + (0.03 + other) * v).sin()
            + 35.0 * ((0.07 + other) * v - 0.04 * u).sin()
            + 25.0 * ((0.31 + other) * v - 0.22 * u).sin()
            + 20.0 * (0.63 * u + 0.41 * v + 9.0 * other).sin();
        [value as u8; 3]
    })
}

fn values(params: &str, frames: &[Frame], boxes: &[Rect]) -> Vec<f64> {
    run("forward-backward", params, frames, boxes)
}

const BOXES: [Rect; 2] = [Rect { x: 50.0, y: 60.0, w: 48.0, h: 36.0 }; 2];

#[test]
fn the_grid_lies_inside_the_box() {
    let at = |start, length, margin, count| places(start, length, margin, count).collect::<Vec<f64>>();
    // Pixels 3 to 22 have their edges at 2.5 and 22.5 when pixel centers are whole.
    assert_eq!(at(3, 20, 5.0, 3), [7.5, 12.5, 17.5]);
    assert_eq!(at(3, 8, 5.0, 2), [4.5, 8.5]);
    assert_eq!(at(0, 9, 5.0, 1), [4.0]);
}

#[test]
fn the_median_return_is_measured() {
    let point = |x: f64, error: f64| Followed { from: (x, 0.0), to: (2.0 * x, 1.0), error };
    let followed = [point(0.0, 3.0), point(1.0, 0.5), point(2.0, 0.25), point(5.0, 0.5)];
    // Kept: 1, 2 and 5, whose motions are (1, 1), (2, 1) and (5, 1).
    assert_eq!(residual(&followed, &[0.0, 0.9, 0.9, 0.9]), Some(1.0));
    // By their correlation, the first and the last; only the last returns well.
    assert_eq!(residual(&followed, &[0.9, 0.1, 0.1, 0.9]), Some(0.0));
    assert_eq!(residual(&followed[..2], &[0.9, 0.1]), None);
    assert_eq!(residual(&[], &[]), None);
}

/// Values of the three measures, with further parameters.
fn measures(more: &str, frames: &[Frame]) -> [Vec<f64>; 3] {
    ["error", "inliers", "residual"]
        .map(|measure| values(&format!("{{ measure = \"{measure}\"{more} }}"), frames, &[BOXES[0]; 3]))
}

#[test]
fn another_scene_does_not_return() {
    let first = scene(0.0, 0.0, 0.0);
    let [error, inliers, residual] = measures("", &[first.clone(), scene(0.0, 0.0, 0.3)]).map(|v| v[1]);
    assert!(error > 0.02 && inliers < 0.3 && residual > 0.02, "{error} {inliers} {residual}");
    // In a scene that stands still points return to where they were.
    let strict = "{ measure = \"inliers\", max_error = 0.0, min_correlation = -1.0 }";
    assert!((0.9..=1.0).contains(&values(strict, &[first.clone(), first.clone()], &BOXES)[1]));
    assert!(values(strict, &[first.clone(), scene(1.3, 0.7, 0.0)], &BOXES)[1] < 0.5);
    // Nothing to follow.
    let flat = Frame::new(160, 120, vec![9; 57_600]);
    assert_eq!(measures("", &[first, flat.clone(), flat]).map(|v| v[2]), [1.0, 0.0, 1.0]);
}

#[test]
fn the_part_of_the_frame_that_is_searched_bounds_the_motion() {
    let frames = [scene(0.0, 0.0, 0.0), scene(3.0, 2.0, 0.0)];
    let [near, none] = ["", ", reach = 0.0, margin = 0.0, levels = 0"]
        .map(|more| values(&format!("{{ window = 9{more} }}"), &frames, &BOXES)[1]);
    assert!(near < none, "{near} {none}");
}

// A frame of 40 x 30 pixels, with a target of 8 x 6 in a search region of 16 x 12.
#[test]
fn a_state_that_does_not_fit_its_frame_is_refused() {
    let takes = |target: [i64; 4], search: [i64; 4], pixels: usize| {
        let window = |[x, y, w, h]: [i64; 4]| Window { x, y, w: w as usize, h: h as usize };
        let part = Some(((40_usize, 30_usize), window(target), window(search), vec![9_u8; pixels]));
        takes("forward-backward", "{}", &part)
    };
    let (target, search) = ([10, 10, 8, 6], [6, 7, 16, 12]);
    assert!(takes(target, search, 192) && takes([32, 24, 8, 6], [24, 18, 16, 12], 192));
    assert!(!takes(target, search, 191));
    for bad in
        [[33, 24, 8, 6], [32, 25, 8, 6], [-1, 10, 8, 6], [10, -1, 8, 6], [10, 10, 0, 6], [10, 10, 8, 0]]
    {
        assert!(!takes(bad, search, 192), "{bad:?}");
    }
    assert!(!takes(target, [25, 7, 16, 12], 192) && !takes(target, [6, 19, 16, 12], 192));
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    #[test]
    fn points_of_a_moving_scene_return(dx in -4.0..4.0_f64, dy in -4.0..4.0_f64) {
        let frames = [scene(0.0, 0.0, 0.0), scene(dx, dy, 0.0)];
        let found = measures(", window = 11", &frames);
        prop_assert_eq!(found.each_ref().map(|v| v[0]), [0.0, 1.0, 0.0]);
        let [error, inliers, residual] = found.map(|v| v[1]);
        prop_assert!(error < 0.003 && inliers > 0.9 && residual < 0.003, "{error} {inliers} {residual}");
    }
}
