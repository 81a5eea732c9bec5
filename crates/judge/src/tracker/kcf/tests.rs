use super::*;
use crate::tracker::testing::{follow, texture};
use proptest::prelude::*;
use serde_json::json;

/// A texture that moves once.
fn frames(dx: f64, dy: f64) -> [Frame; 2] {
    [texture(0.0, 0.0, 1.0, false), texture(dx, dy, 1.0, false)]
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    #[test]
    fn parts_of_cells_are_found_by_the_vot_preset(dx in -6.0..6.0, dy in -6.0..6.0) {
        let region = Region::Rect(Rect::new(64.0, 45.0, 32.0, 30.0));
        let params = "{ preset = \"vot\", scale_step = 1.0 }";
        let r = follow("kcf", params, &region, &frames(dx, dy)).rect();
        prop_assert!((r.x - 64.0 - dx).abs() < 0.6 && (r.y - 45.0 - dy).abs() < 0.6, "{:?} {} {}", r, dx, dy);
    }
}

// On halved frames; a polygon keeps its shape.
#[test]
fn large_targets_are_tracked_too() {
    let rect = Rect::new(30.0, 8.0, 101.0, 104.0);
    for region in [Region::Rect(rect), Region::Polygon(rect.corners().to_vec())] {
        assert_eq!(follow("kcf", "{}", &region, &frames(8.0, -8.0)), region.shifted(8.0, -8.0));
    }
}

#[test]
fn a_state_of_a_box_without_area_is_refused() {
    let (sequence, ..) = crate::tracker::testing::excerpt(1);
    let kcf = ENTRY.build_from_text("{}").unwrap();
    let region = Region::Rect(Rect::new(64.0, 45.0, 1.0, 1.0));
    let context = crate::tracker::testing::context(&sequence, 0);
    let (tracker, _) = kcf.start(&context, &frames(0.0, 0.0)[0], &region).unwrap();
    let saved = tracker.save().unwrap();
    let takes = |region: Region| {
        let memory = Memory { region, ..saved::from_bytes(&saved).unwrap() };
        kcf.resume(&saved::to_bytes(&memory).unwrap()).is_some()
    };
    assert!(takes(region));
    let bad = [Region::Rect(Rect::new(64.0, 45.0, -1e6, 10.0)), Region::Polygon(Vec::new())];
    assert_eq!(bad.map(takes), [false; 2]);
}

#[test]
fn a_target_stays_in_touch_with_the_frame() {
    let region = Region::Rect(Rect::new(1e9, -1e9, 20.0, 20.0));
    for params in ["{}", "{ preset = \"vot\" }"] {
        let got = follow("kcf", params, &region, &frames(0.0, 0.0)).rect();
        assert!((got.x - 160.0).abs() < 1e-6 && (got.y + 20.0).abs() < 1e-6, "{got:?}");
    }
}

#[test]
fn presets_fill_in_missing_parameters() {
    for (text, want) in [
        ("{}", json!({ "rate": 0.02, "kernel_width": 0.5, "template": 0 })),
        ("{ features = \"grey\" }", json!({ "rate": 0.075, "kernel_width": 0.2 })),
        (
            "{ preset = \"vot\", rate = 0.5 }",
            json!({ "rate": 0.5, "kernel_width": 0.6, "scale_step": 1.05, "update": "fraction", "sub_cell": true,
                    "color": true }),
        ),
    ] {
        let shown = ENTRY.build_from_text(text).unwrap().params();
        for (key, value) in want.as_object().unwrap() {
            assert_eq!(&shown[key], value, "{text} {key}");
        }
    }
}
