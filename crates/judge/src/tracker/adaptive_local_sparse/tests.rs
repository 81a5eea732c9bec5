//! The course of a track against its description, and a target that moves.

use super::*;
use crate::region::Rect;
use crate::tracker::testing;
use proptest::prelude::*;
use trackfail_dataset::synthetic;

/// A textured block of 40 x 40 at `(x, y)`, on a background of another texture.
fn scene(x: i64, y: i64) -> Frame {
    Frame::from_fn(160, 120, |j, i| {
        let (u, v) = (j as i64 - x, i as i64 - y);
        let (a, b) = (u as f64, v as f64);
        let gray = if (0..40).contains(&u) && (0..40).contains(&v) {
            120.0 + 60.0 * (0.3 * a).sin() * (0.4 * b).cos() + a + 20.0 * (0.02 * a * b).sin()
        } else {
            70.0 + 20.0 * (0.05 * j as f64).sin() + 0.2 * i as f64
        };
        [gray as u8; 3]
    })
}

fn block(x: f64, y: f64) -> Region {
    Region::Rect(Rect::new(x, y, 40.0, 40.0))
}

fn track(text: &str, frames: &[Frame], seed: u64) -> Vec<TrackerState> {
    let config = ENTRY.build_from_text(text).unwrap();
    let sequence = synthetic::suite("synthetic-otb").unwrap().swap_remove(0);
    testing::track(&*config, &sequence, seed, &block(30.0, 20.0), frames)
}

// Past the collection of templates and two updates.
#[test]
fn a_target_that_moves_by_whole_pixels_is_followed() {
    let frames: Vec<Frame> = (0..22).map(|t| scene(30 + 2 * t, 20 + t)).collect();
    let others = ["update_sign = \"non-negative\"", "grid = \"centered\""];
    for text in ["{ samples = 100 }".to_string()]
        .into_iter()
        .chain(others.map(|o| format!("{{ samples = 100, {o} }}")))
    {
        let text = text.as_str();
        let states = track(text, &frames, 5);
        for (t, state) in (0..).map(f64::from).zip(&states) {
            let (x, y) = state.region.rect().center();
            let error = (x - 50.0 - 2.0 * t, y - 40.0 - t);
            assert!(error.0.abs() < 2.0 && error.1.abs() < 2.0, "{text} frame {t}: {error:?}");
        }
        let later = states[21].posterior.as_ref().unwrap();
        assert!(later.likelihood > 4.0 && later.likelihood <= 9.0, "{}", later.likelihood);
    }
}

#[test]
fn the_posterior_is_of_the_components_with_noise() {
    let frames: Vec<Frame> = (0..3).map(|t| scene(30 + t, 20)).collect();
    let states = track("{ samples = 60 }", &frames, 3);
    let first = states[0].posterior.as_ref().unwrap();
    assert_eq!((&first.mean[..], first.likelihood), (&[50.0, 40.0, 1.25, 1.0][..], 9.0));
    assert_eq!((&first.covariance[..], first.effective_samples), (&[0.0; 16][..], 60.0));
    // A higher exponent trusts fewer candidates, which are the same otherwise.
    let spread = |exponent: u32| {
        let states = track(&format!("{{ samples = 60, weight_exponent = {exponent} }}"), &frames, 3);
        states[1].posterior.as_ref().map_or(f64::NAN, |m| m.effective_samples)
    };
    let spreads = [1, 10, 100].map(spread);
    assert!(spreads.is_sorted_by(|a, b| a > b) && spreads[0] < 60.0, "{spreads:?}");
}

// The first template stays, the number is ten, and the last is made of what was seen.
#[test]
fn every_fifth_window_replaces_a_template() {
    let window = |t: usize| -> Vec<f32> {
        (0..PIXELS).map(|n| 0.5 + 0.3 * (0.01 * (n * (t % 13 + 1)) as f32).sin()).collect()
    };
    let mut target = Target::new([0.0; 6], window(0));
    let config = Params::default();
    let coder = Lasso { lambda: 1e-4, sign: Sign::NonNegative, tolerance: 1e-6, rounds: 10_000 };
    for t in 1..10 {
        target.learn(window(t), &config, &coder, || panic!("no template is replaced yet"));
    }
    let before = target.templates.clone();
    for t in 10..14 {
        target.learn(window(t), &config, &coder, || panic!("no template is replaced yet"));
    }
    assert_eq!(target.templates, before);
    target.learn(window(5), &config, &coder, || 0.0);
    assert_eq!(target.templates[0], before[0]);
    assert_eq!(target.templates[1..9], before[2..]);
    // Nearly all of the window lies in the space of the components.
    let mut seen = window(5);
    normalize(&mut seen);
    let off = distance(&target.templates[9], &seen).sqrt();
    assert!(off > 0.0 && off < 0.1, "{off}");
}

// By hand: a box of 48 x 96 is 1.5 and 3 pixels a template pixel.
#[test]
fn the_programs_window_is_half_a_template_pixel_off() {
    let target = [50.0, 60.0, 1.5, 0.0, 2.0, 0.0];
    assert_eq!(Grid::Program.window(&target), [51.25, 62.0, 1.5, 0.0, 2.0, 0.0]);
    assert_eq!(Grid::Centered.window(&target), target);
}

// By hand: cumulated 2, 6, 14, ... 510, 1022 of 1022.
#[test]
fn newer_templates_go_sooner() {
    for (upto, template) in [(2, 1), (6, 2), (14, 3), (254, 7), (510, 8), (1022, 9)] {
        let at = |n: f64| replaced(n / 1022.0);
        assert_eq!(at(f64::from(upto) - 0.5), template);
        assert_eq!(at(f64::from(upto) + 0.5), (template + 1).min(9));
    }
}

#[test]
fn candidates_without_noise_are_refused() {
    let refused = ENTRY.build_from_text("{ noise = [0, 0, 0, 0, 0, 0] }").err();
    assert_eq!(refused.and_then(|e| e.key), Some("noise"));
}

proptest! {
    #[test]
    fn confidences_are_within_bounds_and_ignore_brightness(
        gray in prop::collection::vec(0.0..1.0_f32, 64),
        gain in 0.1..4.0_f32,
    ) {
        // Blocks of 4 x 4 pixels.
        let window = |gain: f32| {
            let mut w: Vec<f32> = (0..PIXELS).map(|n| gain * gray[n / 128 * 8 + n % 32 / 4]).collect();
            normalize(&mut w);
            w
        };
        let mut shifted = window(1.0);
        shifted.rotate_right(8);
        let dictionary = Dictionary::of(&[window(1.0), shifted]);
        let coder = Lasso { lambda: 0.01, sign: Sign::NonNegative, tolerance: 1e-5, rounds: 10_000 };
        let confidence = |w: &[f32]| dictionary.confidence(w, &coder, &mut Coding::default());
        let f = confidence(&window(1.0));
        prop_assert!((0.0..=9.0 + 1e-6).contains(&f), "{f}");
        prop_assert!((f - confidence(&window(gain))).abs() < 0.02);
    }
}
