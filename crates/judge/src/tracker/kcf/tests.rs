use super::*;
use crate::region::Rect;
use crate::tracker::testing::{self, texture};
use proptest::prelude::*;

fn follow(params: &str, region: &Region, frames: &[Frame]) -> Region {
    testing::follow(&ENTRY, params, region, frames)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    // Odd and broken sizes and places included: nothing is rounded on the way.
    #[test]
    fn whole_cells_are_followed_exactly(
        dx in -3_i32..4, dy in -3_i32..4, gray in any::<bool>(),
        x in 60.0..64.0, y in 40.0..44.0, w in 24.0..33.0, h in 24.0..33.0,
    ) {
        let (params, cell) = if gray { ("{ features = \"grey\" }", 1.0) } else { ("{}", 4.0) };
        let (dx, dy) = (cell * f64::from(dx), cell * f64::from(dy));
        let region = Region::Rect(Rect::new(x, y, w, h));
        let got = follow(params, &region, &[texture(0.0, 0.0, 1.0, false), texture(dx, dy, 1.0, false)]);
        prop_assert_eq!(got, region.shifted(dx, dy));
    }

    #[test]
    fn parts_of_cells_are_found_by_the_vot_preset(dx in -6.0..6.0, dy in -6.0..6.0) {
        let region = Region::Rect(Rect::new(64.0, 45.0, 32.0, 30.0));
        let params = "{ preset = \"vot\", scale_step = 1.0 }";
        let got = follow(params, &region, &[texture(0.0, 0.0, 1.0, false), texture(dx, dy, 1.0, false)]);
        let Region::Rect(r) = got else { panic!("{got:?}") };
        prop_assert!((r.x - 64.0 - dx).abs() < 0.6 && (r.y - 45.0 - dy).abs() < 0.6, "{:?} {} {}", r, dx, dy);
    }
}

#[test]
fn the_vot_preset_grows_with_its_target() {
    let frames: Vec<Frame> = (0..12).map(|t| texture(0.0, 0.0, 1.03_f64.powi(t), false)).collect();
    let region = Region::Polygon(vec![(60.0, 40.0), (100.0, 40.0), (100.0, 80.0), (60.0, 80.0)]);
    let fixed = follow("{}", &region, &frames);
    assert_eq!(fixed, region, "the other keeps its size and its shape");
    let Region::Rect(r) = follow("{ preset = \"vot\" }", &region, &frames) else { panic!() };
    // It lags behind, as its two other scales count for less: 55 would be right.
    assert!((44.0..58.0).contains(&r.w) && (r.w - r.h).abs() < 1e-9, "{r:?}");
    assert!((r.center().0 - 80.0).abs() < 1.5 && (r.center().1 - 60.0).abs() < 1.5, "{r:?}");
}

#[test]
fn large_targets_are_tracked_on_halved_frames() {
    let region = Region::Rect(Rect::new(30.0, 8.0, 101.0, 104.0));
    let got = follow("{}", &region, &[texture(0.0, 0.0, 1.0, false), texture(8.0, -8.0, 1.0, false)]);
    assert_eq!(got, region.shifted(8.0, -8.0));
}

#[test]
fn a_target_stays_in_touch_with_the_frame() {
    let region = Region::Rect(Rect::new(1e9, -1e9, 20.0, 20.0));
    for params in ["{}", "{ preset = \"vot\" }"] {
        let got =
            follow(params, &region, &[texture(0.0, 0.0, 1.0, false), texture(0.0, 0.0, 1.0, false)]).rect();
        assert!((got.x - 160.0).abs() < 1e-6 && (got.y + 20.0).abs() < 1e-6, "{got:?}");
    }
}

#[test]
fn presets_fill_in_missing_parameters() {
    let shown = |text: &str| ENTRY.build_from_text(text).unwrap().params();
    let tpami = shown("{}");
    assert_eq!(
        (&tpami["rate"], &tpami["kernel_width"], &tpami["template"]),
        (&0.02.into(), &0.5.into(), &0.into())
    );
    let gray = shown("{ features = \"grey\" }");
    assert_eq!((&gray["rate"], &gray["kernel_width"]), (&0.075.into(), &0.2.into()));
    let vot = shown("{ preset = \"vot\", rate = 0.5 }");
    assert_eq!(
        (&vot["rate"], &vot["kernel_width"], &vot["scale_step"]),
        (&0.5.into(), &0.6.into(), &1.05.into())
    );
    assert_eq!(
        (&vot["update"], &vot["sub_cell"], &vot["color"]),
        (&"fraction".into(), &true.into(), &true.into())
    );
}

#[test]
fn a_template_has_no_side_or_a_long_one() {
    let key = |text: &str| ENTRY.build_from_text(text).err().and_then(|e| e.key);
    assert_eq!((key("{ template = 15 }"), key("{ template = 1 }")), (Some("template"), Some("template")));
    assert_eq!((key("{ template = 0 }"), key("{ template = 16 }")), (None, None));
}
