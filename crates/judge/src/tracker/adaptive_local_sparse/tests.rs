//! The course of a track against its description.

use super::*;
use crate::tracker::Moments;
use crate::tracker::testing::Scene;

/// The posterior in frame `t` of a block that moves.
fn posterior(params: &str, seed: u64, t: usize) -> Moments {
    let states = Scene::CHIRP.run("adaptive-local-sparse", params, seed, &Scene::CHIRP.frames(t as i64 + 1));
    states[t].posterior.clone().unwrap()
}

// Past the collection of templates and two updates; a higher exponent trusts fewer candidates, which are the same otherwise.
#[test]
fn confidence_stays_high_and_the_exponent_narrows() {
    for option in ["", ", grid = \"centered\""] {
        let later = posterior(&format!("{{ samples = 100{option} }}"), 5, 21).likelihood;
        assert!(later > 4.0 && later <= 9.0, "{option} {later}");
    }
    let spread = |exponent: u32| {
        posterior(&format!("{{ samples = 60, weight_exponent = {exponent} }}"), 3, 1).effective_samples
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
