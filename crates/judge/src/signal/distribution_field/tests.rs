use super::*;
use crate::signal::testing::values_on_boxes;

#[test]
fn layers_by_hand() {
    let paper = layer_table(32);
    assert_eq!((paper[0], paper[1], paper[7], paper[8], paper[255]), (0, 0, 0, 1, 31));
    // Two layers: ceil(127 / 127.5) = 1, ceil(128 / 127.5) = 2.
    let two = layer_table(2);
    assert_eq!((two[127], two[128]), (0, 1));
    // Three layers of 85 values: 85 closes the first.
    assert_eq!((layer_table(3)[85], layer_table(3)[86]), (0, 1));
    for layers in 2..=256 {
        let table = layer_table(layers);
        assert!(table.is_sorted() && table[0] == 0 && usize::from(table[255]) == layers - 1);
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
fn channels_weigh_by_their_difference_of_means() {
    assert_eq!(channel_weights(&[10, 20, 30], &[13, 20, 29]), [0.75, 0.0, 0.25]);
    assert_eq!(channel_weights(&[10, 20, 30], &[10, 20, 30]), [1.0 / 3.0; 3]);
}

#[test]
fn zeros_around_a_patch_are_the_default() {
    // Zeros and uniform distributions around a patch give the same values: one setting.
    let zero = ENTRY.build_from_text("{ border = \"zero\" }").unwrap();
    assert_eq!(zero.params(), ENTRY.build_from_text("{}").unwrap().params());
}
