use super::*;
use crate::image::Frame;
use crate::region::Rect;
use crate::signal::testing;
use crate::tracker::TrackerState;
use proptest::prelude::*;

fn region(x: f64, y: f64, w: f64, h: f64) -> Region {
    Region::Rect(Rect::new(x, y, w, h))
}

/// The value on one frame with given companions.
fn value(text: &str, companions: &[Region]) -> f64 {
    let signal = ENTRY.build_from_text(text).unwrap();
    let state = TrackerState::tracked(region(0.0, 0.0, 10.0, 10.0));
    let companions: Vec<&Region> = companions.iter().collect();
    let frame = Frame::new(1, 1, vec![0; 3]);
    testing::start(signal.as_ref()).push(&Observation {
        frame: &frame,
        state: &state,
        companions: &companions,
    })
}

// By hand: overlaps 1, 50 / 150, 0 and 0 (beside, and without numbers).
#[test]
fn statistics_by_hand() {
    let companions = [
        region(0.0, 0.0, 10.0, 10.0),
        region(5.0, 0.0, 10.0, 10.0),
        region(10.0, 0.0, 10.0, 10.0),
        region(f64::NAN, 0.0, 10.0, 10.0),
    ];
    assert_eq!(value("{}", &companions), 1.0 / 6.0);
    assert_eq!(value("{ statistic = \"minimum\" }", &companions), 0.0);
    assert_eq!(value("{ statistic = \"share\" }", &companions), 0.5);
    assert_eq!(value("{ at_most = 1 }", &companions), 1.0);
    assert_eq!(value("{ at_most = 3 }", &companions), 1.0 / 3.0);
    assert!(value("{}", &[]).is_nan());
}

/// A target of 16 x 16 bright checks on dark noise that moves by `step` a frame, and its boxes.
fn moving(frames: usize, step: f64) -> (Vec<Frame>, Vec<Rect>) {
    let boxes: Vec<Rect> = (0..frames).map(|t| Rect::new(20.0 + step * t as f64, 40.0, 16.0, 16.0)).collect();
    let draw = |r: &Rect| {
        Frame::from_fn(160, 96, |x, y| {
            let (u, v) = (x as f64 - r.x, y as f64 - r.y);
            let inside = (0.0..16.0).contains(&u) && (0.0..16.0).contains(&v);
            let noise = ((x * 7919 + y * 104_729) % 61) as u8;
            match (inside, (u as i64 / 4 + v as i64 / 4) % 2 == 0) {
                (true, true) => [250, 200, noise],
                (true, false) => [120, 240, noise],
                (false, _) => [noise, noise / 2, 40],
            }
        })
    };
    (boxes.iter().map(draw).collect(), boxes)
}

#[test]
fn a_watchdog_agrees_with_a_tracker_on_the_target_and_leaves_one_that_stays_behind() {
    let signal = ENTRY.build_from_text("{ companions = [{ tracker = \"kcf\" }] }").unwrap();
    let (frames, boxes) = moving(40, 2.0);
    let good = testing::values_on_boxes(signal.as_ref(), &frames, &boxes);
    assert!(good.iter().all(|o| *o > 0.6), "{good:?}");
    let lost = testing::values_on_boxes(signal.as_ref(), &frames, &[boxes[0]; 40]);
    assert_eq!(lost[0], 1.0);
    // The target has left the box of the first frame after eight frames. The watchdog is not started again on the
    // background.
    assert!(lost[12..].iter().all(|o| *o == 0.0), "{lost:?}");
}

// The target jumps to another place in frame 5, out of the watchdog's reach, and the tracker with it.
#[test]
fn a_watchdog_that_is_lost_is_started_again() {
    let (near, near_boxes) = moving(30, 1.0);
    let (far, far_boxes) = shifted(&near, &near_boxes, 80);
    let frames: Vec<Frame> = near[..5].iter().chain(&far[5..]).cloned().collect();
    let boxes: Vec<Rect> = near_boxes[..5].iter().chain(&far_boxes[5..]).copied().collect();
    let values =
        |text: &str| testing::values_on_boxes(ENTRY.build_from_text(text).unwrap().as_ref(), &frames, &boxes);
    let again = values("{ companions = [{ tracker = \"kcf\" }] }");
    assert!(again[..5].iter().all(|o| *o > 0.6) && again[5..15].iter().all(|o| *o == 0.0), "{again:?}");
    assert!(again[15..].iter().all(|o| *o > 0.6), "{again:?}");
    let never = values("{ companions = [{ tracker = \"kcf\", restart_after = 0 }] }");
    assert!(never[5..].iter().all(|o| *o == 0.0), "{never:?}");
}

/// Frames and boxes moved cyclically to the right.
fn shifted(frames: &[Frame], boxes: &[Rect], by: usize) -> (Vec<Frame>, Vec<Rect>) {
    let turn = |frame: &Frame| {
        Frame::from_fn(frame.width(), frame.height(), |x, y| {
            frame.pixel((x + frame.width() - by) % frame.width(), y)
        })
    };
    (frames.iter().map(turn).collect(), boxes.iter().map(|r| r.shifted(by as f64, 0.0)).collect())
}

proptest! {
    // The median and the minimum do not depend on the order of companions, and all move with the scene.
    #[test]
    fn the_order_and_the_place_do_not_matter(
        boxes in proptest::collection::vec((0.0..20.0, 0.0..20.0, 1.0..20.0, 1.0..20.0), 1..6),
        turn in 0..6_usize,
    ) {
        let companions: Vec<Region> = boxes.iter().map(|b| region(b.0, b.1, b.2, b.3)).collect();
        let mut turned = companions.clone();
        turned.rotate_left(turn % companions.len());
        for text in ["{}", "{ statistic = \"minimum\" }", "{ statistic = \"share\" }"] {
            prop_assert_eq!(value(text, &companions), value(text, &turned));
            prop_assert!((0.0..=1.0).contains(&value(text, &companions)));
        }
    }
}
