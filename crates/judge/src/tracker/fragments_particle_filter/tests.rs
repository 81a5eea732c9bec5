//! The filter against NumPy, against direct counting, and at its limits.

use super::evidence::Place;
use super::layout::Fragment;
use super::*;
use crate::image::luma;
use crate::tracker::testing;
use proptest::prelude::*;
use trackfail_dataset::synthetic;

fn close(a: f64, b: f64, tolerance: f64) {
    assert!((a - b).abs() <= tolerance * (1.0 + b.abs()), "{a} is not {b}");
}

/// A textured block on a textured ground, the block moved by `(dx, dy)`, the ground by `(gx, gy)`.
fn scene((gx, gy): (i64, i64), (dx, dy): (i64, i64)) -> Frame {
    Frame::from_fn(120, 90, |x, y| {
        let (x, y) = (x as i64 - gx, y as i64 - gy);
        let (u, v) = (x - dx, y - dy);
        if (40..64).contains(&u) && (30..60).contains(&v) {
            [200, (8 * (u - 40)) as u8, (8 * (v - 30)) as u8]
        } else {
            [((x * x + 3 * y).rem_euclid(97)) as u8, (60 + (x * y).rem_euclid(50)) as u8, 90]
        }
    })
}

fn track(text: &str, region: &Region, frames: &[Frame]) -> Vec<TrackerState> {
    let sequence = synthetic::suite("synthetic-otb").unwrap().swap_remove(0);
    let config = ENTRY.build_from_text(text).unwrap();
    testing::track(&*config, &sequence, 11, region, frames)
}

fn block(dx: i64, dy: i64) -> Region {
    Region::Rect(Rect::new(40.0 + dx as f64, 30.0 + dy as f64, 24.0, 30.0))
}

/// Every combination of options that changes the course of a frame.
const VARIANTS: [&str; 5] = [
    "{}",
    "{ histogram = \"grey\", layout = \"grid\" }",
    "{ fusion = \"product\", sigma_scale = 0.02 }",
    "{ layout = \"grid\", cells = 16, particles = 3, drop_below = 0.9, reliability_rate = 1 }",
    "{ histogram = \"grey\", sigma_likelihood = 0.01, sigma_scale = 1, fusion = \"product\" }",
];

// The half sizes of the source, worked by hand for 40 x 60: flat strips are 20 x 6 with centers 6 apart, upright
// ones 4 x 30 with centers 4 apart.
#[test]
fn strips_are_those_of_the_source() {
    let all = FragmentLayout::Strips.fragments(40.0, 60.0, 1);
    assert_eq!(all.len(), 2 * 10 + 2 * 10);
    assert_eq!(all[0], [-20.0, -30.0, 0.0, -24.0]);
    assert_eq!(all[1], [0.0, -30.0, 20.0, -24.0]);
    assert_eq!(all[19], [0.0, 24.0, 20.0, 30.0]);
    assert_eq!(all[20], [-20.0, -30.0, -16.0, 0.0]);
    assert_eq!(all[39], [16.0, 0.0, 20.0, 30.0]);
}

#[test]
fn the_grid_tiles_the_target() {
    let all = FragmentLayout::Grid.fragments(40.0, 60.0, 3);
    assert_eq!(all.len(), 9);
    close(all.iter().map(|f| (f[2] - f[0]) * (f[3] - f[1])).sum(), 2400.0, 1e-12);
    assert_eq!((all[0][0], all[0][1], all[8][2], all[8][3]), (-20.0, -30.0, 20.0, 30.0));
}

/// Likeness by counting pixels one by one, from the definition.
fn direct(rgb: bool, first: &Frame, now: &Frame, fragment: &Fragment, here: &Place, there: &Place) -> f64 {
    let histogram = |frame: &Frame, &[x, y, s]: &Place| {
        let mut counts = vec![0.0; 512];
        let edge = |c: f64, e: f64| (c + s.exp() * e + 0.5).floor();
        let (left, top) = (edge(x, fragment[0]), edge(y, fragment[1]));
        let (right, bottom) = (edge(x, fragment[2]).max(left + 1.0), edge(y, fragment[3]).max(top + 1.0));
        let mut pixels: f64 = 0.0;
        for j in 0..frame.height() {
            for i in 0..frame.width() {
                if (left..right).contains(&(i as f64)) && (top..bottom).contains(&(j as f64)) {
                    let p @ [r, g, b] = frame.pixel(i, j);
                    let [r, g, b] = [r, g, b].map(|v| usize::from(v) / 32);
                    counts[if rgb { 64 * r + 8 * g + b } else { usize::from(luma(p)) / 16 }] += 1.0;
                    pixels += 1.0;
                }
            }
        }
        counts.into_iter().map(move |c: f64| c / pixels.max(1.0))
    };
    histogram(first, here).zip(histogram(now, there)).map(|(q, p)| (p * q).sqrt()).sum()
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]
    #[test]
    fn likenesses_are_those_of_direct_counting(
        rgb: bool, grid: bool, many: bool, x in -10.0..130.0, y in -10.0..100.0, s in -0.7..0.7,
    ) {
        let (first, now) = (scene((0, 0), (0, 0)), scene((3, 1), (4, -2)));
        let layout = if grid { FragmentLayout::Grid } else { FragmentLayout::Strips };
        let fragments = layout.fragments(24.0, 30.0, 4);
        let (here, there) = ([52.0, 45.0, 0.0], [x, y, s]);
        let mut evidence = Evidence::new(rgb, fragments.clone(), &first, &here);
        // Many places make integral histograms worth while, one does not.
        evidence.look(&now, &vec![there; if many { 2000 } else { 1 }]);
        let mut rho = vec![];
        evidence.likeness(&there, &mut rho);
        prop_assert_eq!(rho.len(), fragments.len());
        for (r, f) in rho.iter().zip(&fragments) {
            let expected = direct(rgb, &first, &now, f, &here, &there);
            prop_assert!((r - expected).abs() < 1e-9, "{} {}", r, expected);
        }
    }

    #[test]
    fn reliabilities_sum_to_one(
        rho in prop::collection::vec(0.0..=1.0, 2..40), rate in 0.0..=1.0, sigma in 0.01..2.0, drop in 0.0..0.99,
    ) {
        let mut reliabilities = vec![1.0 / rho.len() as f64; rho.len()];
        for _ in 0..50 {
            follow(&mut reliabilities, &rho, rate, sigma);
            prop_assert!((reliabilities.iter().sum::<f64>() - 1.0).abs() < 1e-12);
            let votes = votes(&reliabilities, drop);
            prop_assert!((votes.iter().sum::<f64>() - 1.0).abs() < 1e-12);
        }
    }

    #[test]
    fn answers_move_with_the_pixels(dx in -12_i64..12, dy in -9_i64..9) {
        let run = |dx: i64, dy: i64| {
            let frames: Vec<Frame> = (0..4).map(|t| scene((dx, dy), (2 * t, t))).collect();
            track("{ particles = 50 }", &block(dx, dy), &frames)
        };
        for (here, there) in run(0, 0).iter().zip(run(dx, dy)) {
            let moved = here.region.shifted(dx as f64, dy as f64).rect();
            let there = there.region.rect();
            prop_assert!((there.x - moved.x).abs() < 1e-6 && (there.y - moved.y).abs() < 1e-6);
        }
    }
}

// python3: import numpy as np; rho = np.array([.9, .6, .99]); r = np.array([.5, .3, .2]); s = .1
//   L = np.exp(-(1-rho)/(2*s*s)); (r*L).sum(); np.prod(L**r); .9*r + .1*L/L.sum()
#[test]
fn fusion_and_reliabilities_agree_with_numpy() {
    let (rho, votes) = ([0.9, 0.6, 0.99], [0.5, 0.3, 0.2]);
    let with = |fusion| Params { fusion, sigma_likelihood: 0.1, ..Params::default() };
    close(fuse(&with(Fusion::Votes), &rho, &votes, 1.0), FUSED[0], 1e-12);
    close(fuse(&with(Fusion::Product), &rho, &votes, 1.0), FUSED[1], 1e-12);
    let mut reliabilities = votes;
    follow(&mut reliabilities, &rho, 0.1, 0.1);
    reliabilities.iter().zip(FOLLOWED).for_each(|(a, b)| close(*a, b, 1e-12));
}
const FUSED: [f64; 2] = [0.12467510606041547, 0.0001841057936675795];
const FOLLOWED: [f64; 3] = [0.4510986942593667, 0.2700000003360931, 0.2789013054045402];

// Worked by hand: half of the mean of four reliabilities is 1/8.
#[test]
fn weak_fragments_have_no_vote() {
    assert_eq!(votes(&[0.5, 0.25, 0.125, 0.125], 0.5), [0.5, 0.25, 0.125, 0.125]);
    let left = votes(&[0.5, 0.3, 0.1, 0.1], 0.5);
    left.iter().zip([0.625, 0.375, 0.0, 0.0]).for_each(|(a, b)| close(*a, b, 1e-12));
}

#[test]
fn a_moving_block_is_followed() {
    let frames: Vec<Frame> = (0..20).map(|t| scene((0, 0), (2 * t, t))).collect();
    for text in ["{}", "{ histogram = \"grey\" }", "{ fusion = \"product\" }", "{ layout = \"grid\" }"] {
        for (t, s) in track(text, &block(0, 0), &frames).iter().enumerate() {
            let ((x, y), (cx, cy)) =
                (s.region.rect().center(), block(2 * t as i64, t as i64).rect().center());
            assert!((x - cx).hypot(y - cy) < 3.0, "{text} frame {t}");
        }
    }
}

// The lower half of the block disappears behind the ground for good.
#[test]
fn a_half_hidden_block_is_followed_and_its_hidden_fragments_lose_their_votes() {
    let frames: Vec<Frame> =
        (0..60)
            .map(|t| {
                let (visible, hidden) = (scene((0, 0), (t / 2, 0)), scene((0, 0), (900, 0)));
                Frame::from_fn(120, 90, |x, y| {
                    if y < 45 || t < 3 { visible.pixel(x, y) } else { hidden.pixel(x, y) }
                })
            })
            .collect();
    let states = track("{ reliability_rate = 0.1 }", &block(0, 0), &frames);
    let ((x, y), (cx, cy)) = (states[59].region.rect().center(), block(29, 0).rect().center());
    assert!((x - cx).hypot(y - cy) < 4.0, "{x} {y}");
    let fixed = track("{ reliability_rate = 0, drop_below = 0 }", &block(0, 0), &frames);
    let likelihood = |s: &TrackerState| s.posterior.as_ref().unwrap().likelihood;
    assert!(likelihood(&states[59]) > 1.3 * likelihood(&fixed[59]));
}

#[test]
fn the_start_is_certain() {
    let states = track("{ keep_particles = true }", &block(0, 0), &[scene((0, 0), (0, 0))]);
    let posterior = states[0].posterior.as_ref().unwrap();
    assert_eq!(posterior.mean, [52.0, 45.0]);
    assert_eq!(posterior.covariance, [0.0; 4]);
    close(posterior.effective_samples, 400.0, 1e-12);
    close(posterior.likelihood, 1.0, 1e-9);
    assert_eq!(posterior.particles.len(), 1200);
    assert_eq!(posterior.particles[1197..], [52.0, 45.0, 0.0025]);
    let scaled = track("{ sigma_scale = 0.02 }", &block(0, 0), &[scene((0, 0), (0, 0))]);
    assert_eq!(scaled[0].posterior.as_ref().unwrap().mean, [52.0, 45.0, 0.0]);
}

#[test]
fn odd_starts_are_survived() {
    let frames: Vec<Frame> = (0..4).map(|t| scene((t, t), (0, 0))).collect();
    let tiny = [Frame::new(1, 1, vec![9; 3]), Frame::new(2, 1, vec![7; 6]), frames[0].clone()];
    let boxes = [
        (40.0, 30.0, 1.0, 1.0),
        (40.0, 30.0, 0.2, 50.0),
        (-50.0, -50.0, 400.0, 300.0),
        (-500.0, 20.0, 10.0, 10.0),
        (1e15, -1e15, 10.0, 10.0),
        (0.0, 0.0, 1e15, 1e-9),
    ];
    for text in VARIANTS {
        for (x, y, w, h) in boxes {
            let region = Region::Rect(Rect::new(x, y, w, h));
            for frames in [&frames[..], &tiny[..]] {
                for s in track(text, &region, frames) {
                    let m = s.posterior.unwrap();
                    let numbers = m.mean.iter().chain(&m.covariance);
                    assert!(numbers.copied().all(f64::is_finite), "{text} {x} {y} {w} {h}");
                    assert!((1.0..=400.0).contains(&m.effective_samples));
                    assert!((0.0..=1.0 + 1e-9).contains(&m.likelihood), "{text} {}", m.likelihood);
                }
            }
        }
    }
}
