//! The classifier against its definition, the tracker on scenes with a known answer.

use super::codes::octant;
use super::extent::otsu;
use super::*;
use crate::image::luma;
use crate::tracker::testing;
use proptest::prelude::*;
use trackfail_dataset::synthetic;

fn close(a: f64, b: f64, tolerance: f64) {
    assert!((a - b).abs() <= tolerance * (1.0 + b.abs()), "{a} is not {b}");
}

/// A textured block of `side` pixels around `(60 + dx, 48 + dy)` on a textured ground that is moved by
/// `(gx, gy)`.
fn scene((gx, gy): (i64, i64), (dx, dy): (i64, i64), side: f64) -> Frame {
    Frame::from_fn(120, 96, |x, y| {
        let (u, v) = ((x as i64 - gx - dx - 60) as f64 / side, (y as i64 - gy - dy - 48) as f64 / side);
        if (-0.5..0.5).contains(&u) && (-0.5..0.5).contains(&v) {
            let check = (((u + 0.5) * 6.0) as i64 + ((v + 0.5) * 6.0) as i64) % 2;
            [200, (120 * check) as u8, (150.0 * (u + 0.5)) as u8]
        } else {
            let (x, y) = (x as i64 - gx, y as i64 - gy);
            [((x * x + 3 * y).rem_euclid(97)) as u8, (60 + (x * y).rem_euclid(50)) as u8, 90]
        }
    })
}

fn track(text: &str, region: &Region, frames: &[Frame]) -> Vec<TrackerState> {
    let sequence = synthetic::suite("synthetic-otb").unwrap().swap_remove(0);
    let config = ENTRY.build_from_text(text).unwrap();
    testing::track(&*config, &sequence, 0, region, frames)
}

fn block(dx: f64, dy: f64) -> Region {
    Region::Rect(Rect::new(48.0 + dx, 36.0 + dy, 24.0, 24.0))
}

/// Numbers in `[-1, 1)` that look random.
fn noise(k: usize) -> f32 {
    (k as u32 * 7919 + 13).wrapping_mul(2_654_435_761) as f32 / 2_147_483_648.0 - 1.0
}

/// A model with weights everywhere.
fn random_model(cells: usize) -> Model {
    let mut model = Model::new(cells);
    model.colors.iter_mut().enumerate().for_each(|(k, w)| *w = noise(k));
    model.tones.iter_mut().enumerate().for_each(|(k, w)| *w = noise(k + 100_000));
    model
}

#[test]
fn codes_are_those_of_their_definition() {
    let frame = scene((0, 0), (0, 0), 24.0);
    let mut codes = Codes::default();
    // Beyond the border on all sides.
    let (left, top, width, height) = (-3, -2, 127, 101);
    codes.look(&frame, (left, top), (width, height), 16.0);
    let gray = |x: i64, y: i64| f64::from(luma(frame.pixel_clamped(x, y)));
    let mut sharp = 0;
    for j in 0..height {
        for i in 0..width {
            let (x, y) = (left + i as i64, top + j as i64);
            let (color, tone) = (codes.colors[j * width + i], codes.tones[j * width + i]);
            let [r, g, b] = frame.pixel_clamped(x, y).map(|v| u16::from(v) / 32);
            assert_eq!(color, 64 * r + 8 * g + b);
            assert_eq!(f64::from(tone / 16), (gray(x, y) / 16.0).floor());
            let (gx, gy) = (gray(x + 1, y) - gray(x - 1, y), gray(x, y + 1) - gray(x, y - 1));
            if gx.hypot(gy) < 16.0 {
                assert_eq!(tone % 16, 8);
            } else if gx * gy != 0.0 && gx.abs() != gy.abs() {
                let turn = gy.atan2(gx).rem_euclid(std::f64::consts::TAU);
                assert_eq!(f64::from(tone % 16), (turn / std::f64::consts::FRAC_PI_4).floor());
                sharp += 1;
            }
        }
    }
    assert!(sharp > 1000, "{sharp}");
}

#[test]
fn opposite_directions_are_four_eighths_apart() {
    for (gx, gy) in [(5, 1), (1, 5), (-1, 5), (-5, 1)] {
        assert_eq!((octant(gx, gy) + 4) % 8, octant(-gx, -gy));
    }
}

// The tables against the sum of weights over one-hot codes, for every window.
#[test]
fn windows_are_scored_by_their_weights() {
    let rect = Rect::new(20.3, 30.7, 17.0, 23.5);
    let grid = Grid::new(&rect, (5, 7), 6);
    let mut codes = Codes::default();
    codes.look(&scene((0, 0), (-20, 0), 30.0), grid.origin, grid.size, 16.0);
    let mut model = random_model(35);
    let mut scores = vec![];
    model.tabulate(0.0);
    model.scan(&codes, &grid.columns, &grid.rows, 13, &mut scores);
    assert_eq!(scores.len(), 169);
    for (k, score) in scores.iter().enumerate() {
        let (dx, dy) = (k % 13, k / 13);
        let mut expected = 0.0;
        for v in 0..7 {
            for u in 0..5 {
                // The cell's center, in pixels of the block of codes.
                let x = rect.x + (f64::from(u) + 0.5) * 17.0 / 5.0 + dx as f64 - 6.0;
                let y = rect.y + (f64::from(v) + 0.5) * 23.5 / 7.0 + dy as f64 - 6.0;
                let at = (y.floor() as i64 - codes.top) as usize * codes.width
                    + (x.floor() as i64 - codes.left) as usize;
                let (cell, tone) = ((5 * v + u) as usize, usize::from(codes.tones[at]));
                expected += f64::from(model.colors[512 * cell + usize::from(codes.colors[at])])
                    + f64::from(model.tones[32 * cell + tone / 16])
                    + f64::from(model.tones[32 * cell + 16 + tone % 16]);
            }
        }
        close(f64::from(*score), expected, 1e-5);
        close(f64::from(model.score(&grid.pattern(&codes, (dx, dy)))), expected, 1e-5);
    }
}

fn patterns(cells: usize) -> impl Strategy<Value = Pattern> {
    let tone = (0_u8..16, 0_u8..9).prop_map(|(g, d)| 16 * g + d);
    (prop::collection::vec(0_u16..4, cells), prop::collection::vec(tone, cells))
        .prop_map(|(colors, tones)| Pattern { colors, tones })
}

/// `phi` times `sqrt(3 cells)`, as 544 numbers a cell.
fn features(p: &Pattern) -> Vec<f64> {
    let mut phi = vec![0.0; 544 * p.colors.len()];
    for (k, (color, tone)) in p.colors.iter().zip(&p.tones).enumerate() {
        phi[544 * k + usize::from(*color)] = 1.0;
        phi[544 * k + 512 + usize::from(tone / 16)] = 1.0;
        phi[544 * k + 528 + usize::from(tone % 16)] = 1.0;
    }
    phi
}

fn weights(m: &Model) -> Vec<f64> {
    let cells = m.colors.chunks_exact(512).zip(m.tones.chunks_exact(32));
    cells.flat_map(|(c, t)| c.iter().chain(t)).map(|w| f64::from(*w)).collect()
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]
    // The closed form of the smallest change: along M d, as long as the margin needs. In the tables the
    // features' length is part of the weights, which are sqrt(3 cells) times smaller than those of the doc.
    #[test]
    fn a_step_meets_the_margin_with_the_smallest_change(
        target in patterns(6), other in patterns(6), loss in 0.0_f32..1.0,
        mask in prop::collection::vec(0.05_f32..1.0, 6), most in prop_oneof![Just(1e9_f32), 0.01_f32..0.5],
    ) {
        let mut model = random_model(6);
        let before = weights(&model);
        let d: Vec<f64> = features(&target).iter().zip(features(&other)).map(|(a, b)| a - b).collect();
        let dot = |w: &[f64]| w.iter().zip(&d).map(|(w, d)| w * d).sum::<f64>();
        let short = f64::from(loss) - dot(&before);
        let metric = |k: usize| f64::from(mask[k / 544]);
        let length = d.iter().enumerate().map(|(k, d)| metric(k) * d * d).sum::<f64>() / 18.0;
        let step = model.step(&target, &(other, loss), &mask, most);
        let after = weights(&model);
        if short <= 0.0 || length == 0.0 {
            prop_assert_eq!(step, 0.0);
            prop_assert_eq!(before, after);
        } else {
            let expected = (short / length).min(f64::from(most));
            prop_assert!((f64::from(step) - expected).abs() < 1e-4 * (1.0 + expected));
            for (k, (a, b)) in after.iter().zip(&before).enumerate() {
                let change = expected * metric(k) * d[k] / 18.0;
                prop_assert!((a - b - change).abs() < 1e-4 * (1.0 + expected));
            }
            if most > 1e8 {
                prop_assert!((dot(&after) - f64::from(loss)).abs() < 1e-3);
            }
        }
    }

    #[test]
    fn otsu_leaves_the_least_variance_within(values in prop::collection::vec(-3_i32..9, 2..30)) {
        let values: Vec<f64> = values.into_iter().map(f64::from).collect();
        let within = |threshold: f64| {
            let spread = |class: Vec<f64>| {
                let mean = class.iter().sum::<f64>() / class.len() as f64;
                class.iter().map(|v| (v - mean).powi(2)).sum::<f64>()
            };
            let (low, high): (Vec<f64>, Vec<f64>) = values.iter().partition(|v| **v <= threshold);
            spread(low) + spread(high)
        };
        let top = values.iter().copied().fold(f64::MIN, f64::max);
        let least = values.iter().filter(|v| **v < top).map(|v| within(*v)).fold(f64::INFINITY, f64::min);
        match otsu(&values) {
            Some(threshold) => prop_assert!((within(threshold) - least).abs() < 1e-9),
            None => prop_assert!(least.is_infinite()),
        }
    }
}

#[test]
fn shrinking_leaves_the_largest_weights() {
    let mut model = random_model(3);
    model.tabulate(0.75);
    let mut sizes: Vec<f32> = model.colors.iter().chain(&model.tones).map(|w| w.abs()).collect();
    sizes.sort_by(f32::total_cmp);
    let limit = sizes[sizes.len() * 3 / 4];
    let kept = |w: f32| if w.abs() >= limit { w } else { 0.0 };
    for cell in 0..3 {
        for color in 0..512_u16 {
            let expected = kept(model.colors[512 * cell + usize::from(color)])
                + (kept(model.tones[32 * cell + 5]) + kept(model.tones[32 * cell + 16 + 2]));
            assert_eq!(model.share(cell, color, 5 * 16 + 2), expected);
        }
    }
}

#[test]
fn colors_of_the_target_are_separated_from_the_others() {
    let frame = scene((0, 0), (0, 0), 24.0);
    let (mut codes, mut colors) = (Codes::default(), Colors::new());
    codes.look(&frame, (20, 10), (80, 76), 16.0);
    close(colors.probability(&frame, 60, 48), 0.5, 1e-12);
    colors.follow(&frame, &codes, &block(0.0, 0.0).rect(), 1.0);
    assert!(colors.probability(&frame, 60, 48) > 0.98);
    assert!(colors.probability(&frame, 30, 20) < 0.1);
}

// Whole steps are answered exactly: no half pixel is lost anywhere.
#[test]
fn whole_pixel_motion_is_followed_exactly() {
    let steps = [(0, 0), (3, 1), (7, -2), (-10, 4), (-25, -9), (0, 0)];
    let frames: Vec<Frame> = steps.iter().map(|d| scene((0, 0), *d, 24.0)).collect();
    for text in ["{}", "{ cells = 12 }", "{ shrink = 0.5 }", "{ learn_above = 0, mask_floor = 1 }"] {
        for (s, (dx, dy)) in track(text, &block(0.0, 0.0), &frames).iter().zip(steps) {
            assert_eq!(s.region, block(dx as f64, dy as f64), "{text}");
        }
    }
}

#[test]
fn answers_move_with_the_pixels() {
    let run = |gx: i64, gy: i64| {
        let frames: Vec<Frame> = (0..5).map(|t| scene((gx, gy), (2 * t, t), 24.0)).collect();
        // An uneven box; the search stays inside the frame, whose border does not move along.
        let region = block(gx as f64 + 0.3, gy as f64 - 0.6);
        track("{ search_radius = 8 }", &region, &frames)
    };
    for (gx, gy) in [(5, -3), (-8, 6)] {
        for (here, there) in run(0, 0).iter().zip(run(gx, gy)) {
            let (a, b) = (here.region.shifted(gx as f64, gy as f64).rect(), there.region.rect());
            for (a, b) in [(a.x, b.x), (a.y, b.y), (a.w, b.w), (a.h, b.h)] {
                close(a, b, 1e-9);
            }
        }
    }
}

#[test]
fn the_size_follows_only_when_asked() {
    let frames: Vec<Frame> = (0..40).map(|t| scene((0, 0), (0, 0), 24.0 + 0.3 * f64::from(t))).collect();
    let last = |text: &str| track(text, &block(0.0, 0.0), &frames).pop().unwrap().region.rect().w;
    assert_eq!(last("{ size_rate = 0 }"), 24.0);
    assert!(last("{ size_rate = 0.3 }") > 27.0, "{}", last("{ size_rate = 0.3 }"));
}

#[test]
fn odd_starts_are_survived() {
    let frames: Vec<Frame> = (0..4).map(|t| scene((t, t), (0, 0), 24.0)).collect();
    let tiny = [Frame::new(1, 1, vec![9; 3]), Frame::new(2, 1, vec![7; 6]), frames[0].clone()];
    let boxes = [
        (40.0, 30.0, 1.0, 1.0),
        (40.0, 30.0, 0.2, 50.0),
        (-50.0, -50.0, 400.0, 300.0),
        (-500.0, 20.0, 10.0, 10.0),
        (1e15, -1e15, 10.0, 10.0),
        (0.0, 0.0, 1e15, 1e-9),
    ];
    for text in ["{}", "{ size_rate = 1, shrink = 0.9, cells = 2 }", "{ search_radius = 1, memory = 2 }"] {
        for (x, y, w, h) in boxes {
            let region = Region::Rect(Rect::new(x, y, w, h));
            for frames in [&frames[..], &tiny[..]] {
                for s in track(text, &region, frames) {
                    let r = s.region.rect();
                    assert!([r.x, r.y, r.w, r.h].iter().all(|v| v.is_finite()), "{text} {x} {y} {w} {h}");
                    assert!(r.w > 0.0 && r.h > 0.0);
                }
            }
        }
    }
}
