use super::*;
use crate::region::Rect;
use crate::tracker::testing::{follow, texture};
use proptest::prelude::*;

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    #[test]
    fn parts_of_cells_are_found_by_the_vot_preset(dx in -6.0..6.0, dy in -6.0..6.0) {
        let region = Region::Rect(Rect::new(64.0, 45.0, 32.0, 30.0));
        let params = "{ preset = \"vot\", scale_step = 1.0 }";
        let got = follow("kcf", params, &region, &[texture(0.0, 0.0, 1.0, false), texture(dx, dy, 1.0, false)]);
        let Region::Rect(r) = got else { panic!("{got:?}") };
        prop_assert!((r.x - 64.0 - dx).abs() < 0.6 && (r.y - 45.0 - dy).abs() < 0.6, "{:?} {} {}", r, dx, dy);
    }
}

// On halved frames; a polygon keeps its shape.
#[test]
fn large_targets_are_tracked_too() {
    let rect = Rect::new(30.0, 8.0, 101.0, 104.0);
    for region in [Region::Rect(rect), Region::Polygon(rect.corners().to_vec())] {
        let got =
            follow("kcf", "{}", &region, &[texture(0.0, 0.0, 1.0, false), texture(8.0, -8.0, 1.0, false)]);
        assert_eq!(got, region.shifted(8.0, -8.0));
    }
}

#[test]
fn a_target_stays_in_touch_with_the_frame() {
    let region = Region::Rect(Rect::new(1e9, -1e9, 20.0, 20.0));
    let frames = [texture(0.0, 0.0, 1.0, false), texture(0.0, 0.0, 1.0, false)];
    for params in ["{}", "{ preset = \"vot\" }"] {
        let got = follow("kcf", params, &region, &frames).rect();
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
