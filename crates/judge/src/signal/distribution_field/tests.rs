use super::*;
use crate::signal::testing::values_on_boxes;

#[test]
fn layers_of_both_rules() {
    let paper = layer_table(32, LayerRule::Paper);
    assert_eq!((paper[0], paper[1], paper[7], paper[8], paper[255]), (0, 0, 0, 1, 31));
    assert_eq!(paper, layer_table(32, LayerRule::Dft));
    // Two layers: ceil(127 / 127.5) = 1, ceil(128 / 127.5) = 2; four: 64 / 63.75 passes the edge.
    let two = layer_table(2, LayerRule::Paper);
    assert_eq!((two[127], two[128]), (0, 1));
    // Three layers of 85 values: 85 closes the first by the paper, 84 by DFT (85 * 3 / 256 < 1 < 86 * 3 / 256).
    assert_eq!(layer_table(3, LayerRule::Paper)[85], 0);
    assert_eq!(layer_table(3, LayerRule::Dft)[84], 0);
    assert_eq!(layer_table(3, LayerRule::Dft)[85], 1);
    for layers in 2..=256 {
        for rule in [LayerRule::Paper, LayerRule::Dft] {
            let table = layer_table(layers, rule);
            assert!(table.is_sorted() && table[0] == 0 && usize::from(table[255]) == layers - 1);
        }
    }
}

#[test]
fn background_by_hand() {
    let at = |x: f64, y: f64, w: f64, h: f64| Rect::new(x, y, w, h);
    let now = at(50.0, 50.0, 10.0, 20.0);
    // First frame: margin ceil(30 / 4) = 8 around the box itself.
    assert_eq!(background_region(&[], &now, 10, Displacement::Past), at(46.0, 46.0, 18.0, 28.0));
    // One box before: no displacement is known yet, and the size is that of the box before.
    let one = [at(0.0, 0.0, 8.0, 8.0)];
    assert_eq!(background_region(&one, &now, 10, Displacement::Past), at(-2.0, -2.0, 12.0, 12.0));
    // Steps 1, 2, 6: the mean of the last two is 4, of all three 3.
    let past = [0.0, 1.0, 3.0, 9.0].map(|x| at(x, 0.0, 8.0, 8.0));
    assert_eq!(background_region(&past, &now, 2, Displacement::Past).x, 9.0 + 4.0 - 2.0);
    assert_eq!(background_region(&past, &now, 10, Displacement::Past).x, 9.0 + 3.0 - 2.0);
    // As printed: the center of the last two steps ends at the current box, (55 - 7) / 2 = 24.
    assert_eq!(background_region(&past, &now, 2, Displacement::Printed).x, 9.0 + 24.0 - 2.0);
}

#[test]
fn windows_by_hand() {
    let background = Rect::new(0.0, 0.0, 18.0, 28.0);
    let state = Rect::new(100.0, 100.0, 10.0, 20.0);
    let places = |regions| background_windows(&background, &state, regions).map(|r| (r.x, r.y));
    assert_eq!(places(Regions::Corners), [(0.0, 0.0), (8.0, 0.0), (0.0, 8.0), (8.0, 8.0)]);
    assert_eq!(places(Regions::Sides), [(0.0, 4.0), (8.0, 4.0), (4.0, 0.0), (4.0, 8.0)]);
    let wide = Rect::new(0.0, 0.0, 30.0, 20.0);
    let places = background_windows(&background, &wide, Regions::Corners).map(|r| (r.x, r.y));
    assert_eq!(places, [(-6.0, 0.0), (-6.0, 0.0), (-6.0, 8.0), (-6.0, 8.0)]);
}

#[test]
fn one_pixel_reaches_the_bound() {
    // A 1 x 1 target on a frame of two layers far apart: each L1 distance is 2, so y_t = 2 / M.
    let frame = Frame::from_fn(9, 9, |x, y| if (x, y) == (4, 4) { [200; 3] } else { [50; 3] });
    let one = "{ support_u = 1, support_v = 1, support_layer = 1, layers = 16 }";
    let signal = ENTRY.build_from_text(one).unwrap();
    // B_t is 2 x 2 from (3.5, 3.5) on: three of its windows miss the target, rounding half away.
    let y = values_on_boxes(signal.as_ref(), &[frame], &[Rect::new(4.0, 4.0, 1.0, 1.0)])[0];
    assert!((y - 0.75 * 2.0 / 16.0).abs() < 1e-15, "{y}");
}

#[test]
fn equal_means_fall_back() {
    // Rows of 3 pixels: mean 60 everywhere, but not the same layers.
    let frame = Frame::from_fn(5, 5, |x, _| [[60; 3], [0; 3], [120; 3], [60; 3], [60; 3]][x]);
    let value = |rule: &str| {
        let signal = ENTRY.build_from_text(&format!("{{ equal_means = \"{rule}\" }}")).unwrap();
        values_on_boxes(signal.as_ref(), std::slice::from_ref(&frame), &[Rect::new(1.0, 1.0, 3.0, 3.0)])[0]
    };
    // B_t is 5 x 5; the left windows hold 60, 0, 120 and the right ones 120, 60, 60.
    assert!(value("thirds") > value("zero") && value("zero") > 0.0);
}

#[test]
fn zeros_around_a_patch_are_the_default() {
    // Zeros and uniform distributions around a patch give the same values: one setting.
    let zero = ENTRY.build_from_text("{ border = \"zero\" }").unwrap();
    assert_eq!(zero.params(), ENTRY.build_from_text("{}").unwrap().params());
}
