//! The classifier against its definition.

use super::*;
use crate::image::luma;
use crate::tracker::testing::Scene;
use proptest::prelude::*;
use trackfail_testing::assert_near;

/// Numbers in `[-1, 1)` that look random.
fn noise(k: usize) -> f32 {
    (k as u32 * 7919 + 13).wrapping_mul(2_654_435_761) as f32 / 2_147_483_648.0 - 1.0
}

/// Model with nonzero weights for all codes.
fn random_model(cells: usize) -> Model {
    let mut model = Model::new(cells);
    model.colors.iter_mut().enumerate().for_each(|(k, w)| *w = noise(k));
    model.tones.iter_mut().enumerate().for_each(|(k, w)| *w = noise(k + 100_000));
    model
}

#[test]
fn codes_are_those_of_their_definition() {
    let frame = Scene::CHECKED.frame(0, 0.0);
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

// The tables against the sum of weights over one-hot codes, for every window.
#[test]
fn windows_are_scored_by_their_weights() {
    let rect = Rect::new(20.3, 30.7, 17.0, 23.5);
    let grid = Grid::new(&rect, (5, 7), 6);
    let mut codes = Codes::default();
    codes.look(&Scene { start: (28, 36), ..Scene::CHECKED }.frame(0, 0.0), grid.origin, grid.size, 16.0);
    let mut model = random_model(35);
    let mut scores = vec![];
    model.tabulate();
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
        let ours = [*score, model.score(&grid.pattern(&codes, (dx, dy)))].map(f64::from);
        assert_near(ours, [expected; 2], 1e-5 * (1.0 + expected.abs()), k);
    }
}

fn patterns(cells: usize) -> impl Strategy<Value = Pattern> {
    let tone = (0_u8..16, 0_u8..9).prop_map(|(g, d)| 16 * g + d);
    (prop::collection::vec(0_u16..4, cells), prop::collection::vec(tone, cells))
        .prop_map(|(colors, tones)| Pattern { colors, tones })
}

/// `phi` times `sqrt(3 cells)`, as 544 numbers per cell.
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
}

#[test]
fn colors_of_the_target_are_separated_from_the_others() {
    let frame = Scene::CHECKED.frame(0, 0.0);
    let (mut codes, mut colors) = (Codes::default(), Colors::new());
    codes.look(&frame, (20, 10), (80, 76), 16.0);
    assert_near([colors.probability(&frame, 60, 48)], [0.5], 1e-12, "");
    colors.follow(&frame, &codes, &Scene::CHECKED.rect(0), 1.0);
    assert!(colors.probability(&frame, 60, 48) > 0.98);
    assert!(colors.probability(&frame, 30, 20) < 0.1);
}
