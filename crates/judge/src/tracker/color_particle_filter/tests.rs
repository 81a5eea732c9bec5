//! The filter against NumPy and against the defining properties of its parts.

use super::*;
use crate::num::particles::{Posterior, effective_number, systematic};
use crate::tracker::testing::{Scene, excerpt, track};
use serde_json::Value;
use std::sync::LazyLock;

/// `tests/oracles/color_particle_filter.json`, written by `python3 tests/oracles/color_particle_filter.py`.
static ORACLE: LazyLock<Value> = LazyLock::new(|| {
    serde_json::from_str(include_str!("../../../../../tests/oracles/color_particle_filter.json")).unwrap()
});

fn read<T: serde::de::DeserializeOwned>(v: &Value) -> T {
    serde_json::from_value(v.clone()).unwrap()
}

/// Frames of the oracle, 72 x 56.
fn oracle_frame(t: i64) -> Frame {
    Frame::from_fn(72, 56, |x, y| {
        let (x, y) = (x as i64, y as i64);
        std::array::from_fn(|c| {
            let c = c as i64;
            let seed = x * 7919 + y * 104_729 + c * 1_299_709 + t * 15_485_863;
            let noise = (seed * 1_664_525 + 1_013_904_223).rem_euclid(1 << 32) >> 27;
            let block = (20 + 3 * t..40 + 3 * t).contains(&x) && (12 + 2 * t..42 + 2 * t).contains(&y);
            let value = (2 * x + 3 * y + 40 * c + t) % 160 + if block { 90 - 45 * c } else { 0 } + noise;
            value.clamp(0, 255) as u8
        })
    })
}

fn close(a: f64, b: f64, tolerance: f64) {
    assert!((a - b).abs() <= tolerance * (1.0 + b.abs()), "{a} is not {b}");
}

fn histogram(frame: &Frame, binning: &Binning, ellipse: &Ellipse) -> Histogram {
    let (mut grid, mut histogram) = (Grid::default(), Histogram::new(binning.len()));
    grid.look(frame, binning, [ellipse]);
    histogram.sum_inside(&grid, ellipse);
    histogram
}

#[test]
fn the_frames_are_those_of_the_oracle() {
    let sums: Vec<u64> = read(&ORACLE["byte_sums"]);
    for (t, sum) in (0..).zip(sums) {
        assert_eq!(oracle_frame(t).bytes().iter().map(|&b| u64::from(b)).sum::<u64>(), sum);
    }
}

#[test]
fn hsv_bins_agree_with_colorsys() {
    let colors: Vec<[u8; 3]> = read(&ORACLE["colors"]["rgb"]);
    let expected: Vec<u16> = read(&ORACLE["colors"]["hsv_bins"]);
    let binning = Binning::new(true, [8; 3]);
    for (c, bin) in colors.iter().zip(expected) {
        assert_eq!(binning.bin(*c), bin, "{c:?}");
    }
}

// Weights are rounded to 2^-36 and drift by less than n^2 of these along a row of n pixels.
#[test]
fn histograms_agree_with_numpy() {
    let frame = oracle_frame(0);
    for case in ORACLE["histograms"].as_array().unwrap() {
        let binning = Binning::new(case["space"] == "hsv", read(&case["bins"]));
        let ours = histogram(&frame, &binning, &read(&case["ellipse"])).shares();
        let theirs = case["shares"].as_object().unwrap();
        assert_eq!(ours.iter().filter(|s| **s > 0.0).count(), theirs.len(), "{case}");
        for (bin, share) in theirs {
            close(ours[bin.parse::<usize>().unwrap()], share.as_f64().unwrap(), 1e-8);
        }
    }
}

#[test]
fn two_steps_agree_with_numpy() {
    let filter = &ORACLE["filter"];
    let (first, offset): (Ellipse, f64) = (read(&filter["first"]), read(&filter["offset"]));
    let binning = Binning::new(false, [8; 3]);
    let model = Model::new(&histogram(&oracle_frame(0), &binning, &first).shares());
    let config = Params::default();
    let limits = EllipseLimits { shortest: 3.0, longest: 72.0 };
    let mut cloud = Cloud::new(first, 60);
    for (t, step) in (1..).zip(filter["steps"].as_array().unwrap()) {
        let noise: Vec<Ellipse> = read(&step["noise"]);
        let mut draws = noise.as_flattened().iter();
        cloud.diffuse(&config.deviations(), |e| limits.keep(e), || *draws.next().unwrap());
        let frame = oracle_frame(t);
        let likeness = |s: &Ellipse| histogram(&frame, &binning, s).likeness(&model);
        let rho: Vec<f64> = cloud.states.iter().map(likeness).collect();
        cloud.weigh(relative_likelihoods(&rho, 0.2));
        let Posterior { mean, covariance } = cloud.posterior();
        let of_mean = likelihood(likeness(&mean), 0.2);
        let all = |ours: &[f64], name: &str| {
            let theirs: Vec<f64> = read(&step[name]);
            assert_eq!(ours.len(), theirs.len());
            ours.iter().zip(theirs).for_each(|(a, b)| close(*a, b, 1e-7));
        };
        let theirs: Vec<Ellipse> = read(&step["states"]);
        cloud.states.as_flattened().iter().zip(theirs.as_flattened()).for_each(|(a, b)| close(*a, *b, 1e-12));
        all(&rho, "rho");
        all(&cloud.weights, "weights");
        all(&mean, "mean");
        all(covariance.as_flattened(), "covariance");
        close(effective_number(&cloud.weights), read(&step["effective"]), 1e-7);
        close(of_mean, read(&step["likelihood"]), 1e-7);
        let mut parents = vec![];
        systematic(&cloud.weights, offset, &mut parents);
        assert_eq!(parents, read::<Vec<usize>>(&step["parents"]));
    }
}

#[test]
fn likelihoods_relative_to_the_best_do_not_underflow() {
    // exp(0.001 / (2 * 0.01^2)) = exp(5) between the two.
    let relative: Vec<f64> = relative_likelihoods(&[0.0, 0.001], 0.01).collect();
    close(relative[1], 1.0, 1e-9);
    close(relative[0], (-5.0_f64).exp(), 1e-9);
}

#[test]
fn boxes_become_ellipses_and_back() {
    let e = ellipse(&Region::Rect(Rect::new(10.0, 20.0, 30.0, 8.0)));
    assert_eq!(e, [25.0, 24.0, 15.0, 4.0, 0.0]);
    assert_eq!(region(&e).corners(), [(10.0, 20.0), (40.0, 20.0), (40.0, 28.0), (10.0, 28.0)]);
    let turned = [25.0, 24.0, 15.0, 4.0, 0.5];
    let polygon = region(&turned);
    close(polygon.area(), 240.0, 1e-12);
    for start in 0..4 {
        let mut corners = polygon.corners();
        corners.rotate_left(start);
        for _ in 0..2 {
            corners.reverse();
            let again = ellipse(&Region::Polygon(corners.clone()));
            again.iter().zip(turned).for_each(|(a, b)| close(*a, b, 1e-12));
        }
    }
}

/// The states on a target that stands still.
fn still(params: &str, frames: &[Frame]) -> Vec<TrackerState> {
    Scene::SLOPES.run("color-particle-filter", params, 11, frames)
}

#[test]
fn faces_are_binned_in_hsv() {
    let (mut girl, start, frames) = excerpt(4);
    let mut run = |color_space: &str, is_face: bool| {
        girl.attributes = if is_face { vec![FACE.into()] } else { vec![] };
        let config = ENTRY.build_from_text(&format!("{{ color_space = \"{color_space}\" }}")).unwrap();
        track(&*config, &girl, 11, &start, &frames)
    };
    let (rgb, hsv) = (run("rgb", true), run("hsv", false));
    assert_eq!((run("auto", false), run("auto", true)), (rgb.clone(), hsv.clone()));
    assert_ne!(rgb, hsv);
}

// The covariance of the noise itself: with sigma_color = 10 the weights are nearly equal.
#[test]
fn noise_has_the_deviations_or_variances_asked_for() {
    let frames = [Scene::SLOPES.frame(0, 0.0), Scene::SLOPES.frame(0, 0.0)];
    let flat = "particles = 10000, sigma_color = 10, resample_below = 0";
    for (text, deviations) in [
        (format!("{{ {flat} }}"), [5.0, 5.0, 0.75, 0.75, 4.0]),
        (format!("{{ {flat}, noise_is_variance = true }}"), [5.0, 5.0, 0.75, 0.75, 4.0].map(f64::sqrt)),
    ] {
        let posterior = still(&text, &frames).pop().unwrap().posterior.unwrap();
        for (k, expected) in deviations.into_iter().enumerate() {
            let scale = if k == 4 { 180.0 / std::f64::consts::PI } else { 1.0 };
            let deviation = posterior.covariance[6 * k].sqrt() * scale;
            // Five standard errors 1 / sqrt(2 N) are 3.5 %; the weights add at most 0.5 %.
            assert!((deviation / expected - 1.0).abs() < 0.04, "{text} {k}: {deviation}");
        }
    }
}

#[test]
fn an_invisible_target_is_a_random_walk_of_equals() {
    let away = Scene { start: (-900, 10), step: (0, 0), ..Scene::SLOPES };
    for s in away.run("color-particle-filter", "{}", 11, &away.frames(4)) {
        let m = s.posterior.unwrap();
        close(m.effective_samples, 400.0, 1e-9);
        // exp(-1 / (2 * 0.2^2)) = exp(-12.5)
        close(m.likelihood, 3.726_653_172_078_671e-6, 1e-12);
    }
}

// Without noise all particles stay on the block, so that likelihoods are those of its colors alone.
#[test]
fn the_model_follows_only_when_asked_and_slow_changes_alone() {
    // The columns from the left on have another color.
    let first = Scene { target: |_, _| [200, 80, 40], ..Scene::SLOPES }.frame(0, 0.0);
    let changed = |columns: usize| {
        Frame::from_fn(first.width(), first.height(), |x, y| match first.pixel(x, y) {
            [200, green, _] if x < 40 + columns => [90, green, 140],
            pixel => pixel,
        })
    };
    let slowly: Vec<Frame> = (0..36).map(|t| changed(t.min(24))).collect();
    let at_once: Vec<Frame> = (0..36).map(|t| changed(if t < 3 { 0 } else { 24 })).collect();
    let last = |update: f64, frames: &[Frame]| {
        let no_noise = "sigma_position = 0, sigma_axes = 0, sigma_orientation = 0";
        let params = format!("{{ {no_noise}, model_update = {update:?} }}");
        still(&params, frames).pop().unwrap().posterior.unwrap().likelihood
    };
    // None of the first colors is left: exp(-1 / (2 * 0.2^2)) = exp(-12.5).
    close(last(0.0, &slowly), 3.726_653_172_078_671e-6, 1e-12);
    assert!(last(0.5, &slowly) > 0.9, "{}", last(0.5, &slowly));
    assert_eq!(last(0.5, &at_once), last(0.0, &at_once));
}
