//! The filter against NumPy, against the defining properties of its parts, and at its limits.

use super::*;
use crate::num::particles::{Posterior, effective_number, systematic};
use crate::tracker::testing;
use proptest::prelude::*;
use serde_json::Value;
use std::sync::LazyLock;
use trackfail_dataset::{Sequence, synthetic};

/// `tests/oracles/color_particle_filter.json`, written by `python3 tests/oracles/color_particle_filter.py`.
static ORACLE: LazyLock<Value> = LazyLock::new(|| {
    serde_json::from_str(include_str!("../../../../../tests/oracles/color_particle_filter.json")).unwrap()
});

fn read<T: serde::de::DeserializeOwned>(v: &Value) -> T {
    serde_json::from_value(v.clone()).unwrap()
}

/// The frames of the oracle, 72 x 56.
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

fn histogram(frame: &Frame, binning: &Binning, ellipse: &Ellipse, flat: bool) -> Histogram {
    let (mut grid, mut histogram) = (Grid::default(), Histogram::new(binning.len()));
    grid.look(frame, binning, [ellipse]);
    histogram.sum_inside(&grid, ellipse, flat);
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

#[test]
fn eight_rgb_bins_are_the_upper_three_bits() {
    let binning = Binning::new(false, [8; 3]);
    for v in 0..=255_u8 {
        let c = [v, 255 - v, v.rotate_left(3)];
        let [r, g, b] = c.map(|v| u16::from(v >> 5));
        assert_eq!(binning.bin(c), 64 * r + 8 * g + b, "{c:?}");
    }
}

// Weights are rounded to 2^-36 and drift by less than n^2 of these along a row of n pixels.
#[test]
fn histograms_agree_with_numpy() {
    let frame = oracle_frame(0);
    for case in ORACLE["histograms"].as_array().unwrap() {
        let binning = Binning::new(case["space"] == "hsv", read(&case["bins"]));
        let ours = histogram(&frame, &binning, &read(&case["ellipse"]), case["kernel"] == "uniform").shares();
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
    let model = Model::new(&histogram(&oracle_frame(0), &binning, &first, false).shares());
    let config = Params::default();
    let limits = EllipseLimits { shortest: 3.0, longest: 72.0, wrap: false };
    let mut cloud = Cloud::new(first, 60);
    for (t, step) in (1..).zip(filter["steps"].as_array().unwrap()) {
        let noise: Vec<Ellipse> = read(&step["noise"]);
        let mut draws = noise.as_flattened().iter();
        cloud.diffuse(&config.deviations(), |e| limits.keep(e), || *draws.next().unwrap());
        let frame = oracle_frame(t);
        let likeness = |s: &Ellipse| histogram(&frame, &binning, s, false).likeness(&model);
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
fn orientations_wrap_at_the_upper_end() {
    use std::f64::consts::{FRAC_PI_2, PI};
    let wrapped =
        |theta| EllipseLimits { shortest: 1.0, longest: 9.0, wrap: true }.keep([0.0, 0.0, 0.5, 10.0, theta]);
    assert_eq!(wrapped(0.25), [0.0, 0.0, 1.0, 9.0, 0.25]);
    assert_eq!(wrapped(FRAC_PI_2)[4], FRAC_PI_2);
    assert_eq!(wrapped(-FRAC_PI_2)[4], FRAC_PI_2);
    close(wrapped(1.0 + 7.0 * PI)[4], 1.0, 1e-12);
    close(wrapped(-1.0 - 7.0 * PI)[4], -1.0, 1e-12);
}

#[test]
fn boxes_become_ellipses_and_back() {
    let e = ellipse(&Region::Rect(Rect::new(10.0, 20.0, 30.0, 8.0)));
    assert_eq!(e, [25.0, 24.0, 15.0, 4.0, 0.0]);
    assert_eq!(region(&e, Output::AxisAligned), Region::Rect(Rect::new(10.0, 20.0, 30.0, 8.0)));
    let turned = [25.0, 24.0, 15.0, 4.0, 0.5];
    let polygon = region(&turned, Output::Rotated);
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
    // The closed form of an ellipse's upright bounds, against its points.
    let Region::Rect(bounds) = region(&turned, Output::AxisAligned) else { panic!("no rectangle") };
    let (sin, cos) = 0.5_f64.sin_cos();
    let far = (0..100_000)
        .map(|k| (f64::from(k) * std::f64::consts::TAU / 1e5).sin_cos())
        .map(|(s, c)| (cos * 15.0 * c - sin * 4.0 * s, sin * 15.0 * c + cos * 4.0 * s))
        .fold((0.0_f64, 0.0_f64), |m, p| (m.0.max(p.0), m.1.max(p.1)));
    close(bounds.w, 2.0 * far.0, 1e-8);
    close(bounds.h, 2.0 * far.1, 1e-8);
}

fn sequence(face: bool) -> Sequence {
    let mut sequence = synthetic::suite("synthetic-otb").unwrap().swap_remove(0);
    sequence.attributes = if face { vec![FACE.into()] } else { vec![] };
    sequence
}

/// A block on a gradient whose period is beyond the frame; both move by `(dx, dy)`.
fn scene(dx: i64, dy: i64) -> Frame {
    Frame::from_fn(120, 90, |x, y| {
        let (x, y) = (x as i64 - dx, y as i64 - dy);
        let block = (40..60).contains(&x) && (30..56).contains(&y);
        if block {
            [200, (60 + 2 * (x - 40)) as u8, 40]
        } else {
            [(x + 20).clamp(0, 255) as u8, (y + 60).clamp(0, 255) as u8, 150]
        }
    })
}

fn track(text: &str, sequence: &Sequence, region: &Region, frames: &[Frame]) -> Vec<TrackerState> {
    let config = ENTRY.build_from_text(text).unwrap();
    testing::track(&*config, sequence, 11, region, frames)
}

fn block(dx: f64, dy: f64) -> Region {
    Region::Rect(Rect::new(40.0 + dx, 30.0 + dy, 20.0, 26.0))
}

/// Every combination of options that changes the course of a frame.
const VARIANTS: [&str; 7] = [
    "{}",
    "{ color_space = \"hsv\" }",
    "{ kernel = \"uniform\", resampling = \"multinomial\" }",
    "{ kernel = \"points\" }",
    "{ model_update = 0.2, initial_spread = 1, resample_below = 1 }",
    "{ resample_below = 0, sigma_color = 0.01, wrap_orientation = true }",
    "{ output = \"axis-aligned\", bins = [1, 1, 1], particles = 2 }",
];

#[test]
fn a_moving_block_is_followed() {
    let frames: Vec<Frame> = (0..20).map(|t| scene(2 * t, t)).collect();
    for text in ["{}", "{ color_space = \"hsv\" }", "{ kernel = \"uniform\" }", "{ kernel = \"points\" }"] {
        let states = track(text, &sequence(false), &block(0.0, 0.0), &frames);
        let mut overlaps = 0.0;
        for (t, s) in states.iter().enumerate() {
            let truth = block(2.0 * t as f64, t as f64);
            let both = s.region.intersection(&truth);
            overlaps += both / (s.region.area() + truth.area() - both);
        }
        assert!(overlaps / 20.0 > 0.5, "{text}: {}", overlaps / 20.0);
    }
}

#[test]
fn the_start_is_certain() {
    let states = track("{ keep_particles = true }", &sequence(false), &block(0.0, 0.0), &[scene(0, 0)]);
    let posterior = states[0].posterior.as_ref().unwrap();
    assert_eq!(posterior.mean, [50.0, 43.0, 10.0, 13.0, 0.0]);
    assert_eq!(posterior.covariance, [0.0; 25]);
    close(posterior.effective_samples, 400.0, 1e-12);
    close(posterior.likelihood, 1.0, 1e-12);
    assert_eq!(posterior.particles.len(), 2400);
    assert_eq!(posterior.particles[2394..], [50.0, 43.0, 10.0, 13.0, 0.0, 0.0025]);
}

#[test]
fn faces_are_binned_in_hsv() {
    let frames: Vec<Frame> = (0..4).map(|t| scene(t, 0)).collect();
    let run = |text: &str, face| track(text, &sequence(face), &block(0.0, 0.0), &frames);
    let (rgb, hsv) = ("{ color_space = \"rgb\" }", "{ color_space = \"hsv\" }");
    assert_eq!(run("{}", false), run(rgb, true));
    assert_eq!(run("{}", true), run(hsv, false));
    assert_ne!(run(rgb, false), run(hsv, false));
}

// The covariance of the noise itself: with sigma_color = 10 the weights are nearly equal.
#[test]
fn noise_has_the_deviations_or_variances_asked_for() {
    let frames = [scene(0, 0), scene(0, 0)];
    let flat = "particles = 10000, sigma_color = 10, resample_below = 0";
    for (text, deviations) in [
        (format!("{{ {flat} }}"), [5.0, 5.0, 0.75, 0.75, 4.0]),
        (format!("{{ {flat}, noise_is_variance = true }}"), [5.0, 5.0, 0.75, 0.75, 4.0].map(f64::sqrt)),
    ] {
        let states = track(&text, &sequence(false), &block(0.0, 0.0), &frames);
        let posterior = states[1].posterior.clone().unwrap();
        for (k, expected) in deviations.into_iter().enumerate() {
            let scale = if k == 4 { 180.0 / std::f64::consts::PI } else { 1.0 };
            let deviation = posterior.covariance[6 * k].sqrt() * scale;
            // Five standard errors 1 / sqrt(2 N) are 3.5 %; the weights add at most 0.5 %.
            assert!((deviation / expected - 1.0).abs() < 0.04, "{text} {k}: {deviation}");
        }
    }
}

#[test]
fn odd_starts_are_survived() {
    let frames: Vec<Frame> = (0..6).map(|t| scene(t, t)).collect();
    let tiny = [Frame::new(1, 1, vec![9; 3]), Frame::new(2, 1, vec![7; 6]), Frame::new(1, 3, vec![5; 9])];
    let boxes = [
        (40.0, 30.0, 1.0, 1.0),
        (-50.0, -50.0, 400.0, 300.0),
        (-500.0, 20.0, 10.0, 10.0),
        (1e15, -1e15, 10.0, 10.0),
        (0.0, 0.0, 1e15, 1e-9),
        (119.5, 89.5, 40.0, 40.0),
    ];
    for text in VARIANTS {
        for (x, y, w, h) in boxes {
            let region = Region::Rect(Rect::new(x, y, w, h));
            for frames in [&frames[..], &frames[..1], &tiny[..]] {
                for s in track(text, &sequence(false), &region, frames) {
                    let m = s.posterior.unwrap();
                    let numbers = m.mean.iter().chain(&m.covariance);
                    assert!(numbers.copied().all(f64::is_finite), "{text} {x} {y} {w} {h}");
                    assert!((1.0..=400.0).contains(&m.effective_samples));
                    assert!((0.0..=1.0).contains(&m.likelihood));
                }
            }
        }
    }
    let nan = Region::Rect(Rect::new(f64::NAN, 0.0, 1.0, 1.0));
    let config = ENTRY.build_from_text("{}").unwrap();
    let s = sequence(false);
    assert!(config.start(&testing::context(&s, 1), &frames[0], &nan).is_err());
}

#[test]
fn an_invisible_target_is_a_random_walk_of_equals() {
    let frames = vec![scene(0, 0); 4];
    let away = Region::Rect(Rect::new(-900.0, 10.0, 20.0, 20.0));
    for s in track("{}", &sequence(false), &away, &frames) {
        let m = s.posterior.unwrap();
        close(m.effective_samples, 400.0, 1e-9);
        // exp(-1 / (2 * 0.2^2)) = exp(-12.5)
        close(m.likelihood, 3.726_653_172_078_671e-6, 1e-12);
    }
}

#[test]
fn the_model_follows_only_when_asked() {
    // The block changes its color for good.
    let mut frames = vec![scene(0, 0); 3];
    frames.extend((0..30).map(|t| {
        let (a, b) = (scene(0, 0), 4 * t.min(20));
        Frame::from_fn(120, 90, |x, y| {
            let [r, g, c] = a.pixel(x, y);
            if r == 200 { [200 - b, g, 40 + b] } else { [r, g, c] }
        })
    }));
    let last = |text: &str| {
        let s = track(text, &sequence(false), &block(0.0, 0.0), &frames).pop().unwrap();
        s.posterior.unwrap().likelihood
    };
    assert!(last("{ model_update = 0.5, update_above = 0 }") > 4.0 * last("{}"));
    assert_eq!(last("{ model_update = 0.5, update_above = 1 }"), last("{}"));
}

proptest! {
    #[test]
    fn histograms_move_with_the_pixels(
        hx in 3.0..25.0, hy in 3.0..25.0, theta in -4.0..4.0, dx in -20_i64..20, dy in -10_i64..10, flat: bool,
    ) {
        let binning = Binning::new(false, [8; 3]);
        // Far enough from the border that no pixel is lost; a power of two keeps sums of places exact.
        let at = |dx: i64, dy: i64| [50.25 + dx as f64, 42.5 + dy as f64, hx, hy, theta];
        let here = histogram(&scene(0, 0), &binning, &at(0, 0), flat);
        let there = histogram(&scene(dx, dy), &binning, &at(dx, dy), flat);
        let similar = there.likeness(&Model::new(&here.shares()));
        prop_assert!((similar - 1.0).abs() < 1e-6, "{}", similar);
    }

    // Rounding differs by less than 1e-12 in a frame, which no threshold of these few frames meets.
    #[test]
    fn answers_move_with_the_pixels(dx in -8_i64..8, dy in -6_i64..6) {
        let run = |dx: i64, dy: i64| {
            let frames: Vec<Frame> = (0..4).map(|t| scene(dx + t, dy)).collect();
            track("{ particles = 50 }", &sequence(false), &block(dx as f64, dy as f64), &frames)
        };
        for (here, there) in run(0, 0).iter().zip(run(dx, dy)) {
            let moved = here.region.shifted(dx as f64, dy as f64).corners();
            for (a, b) in there.region.corners().iter().zip(moved) {
                prop_assert!((a.0 - b.0).abs() < 1e-6 && (a.1 - b.1).abs() < 1e-6);
            }
        }
    }
}
