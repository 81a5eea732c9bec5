use super::*;
use crate::signal::testing;
use crate::tracker::TrackerState;

fn region(x: f64, y: f64, w: f64, h: f64) -> Region {
    Region::Rect(Rect::new(x, y, w, h))
}

/// The value on one frame with given companions.
fn value(text: &str, companions: &[Region]) -> f64 {
    let state = TrackerState::tracked(region(0.0, 0.0, 10.0, 10.0));
    let companions: Vec<&Region> = companions.iter().collect();
    let frame = Frame::new(1, 1, vec![0; 3]);
    let mut session = testing::start(&*testing::build("companion-overlap", text));
    session.push(&Observation { frame: &frame, state: &state, companions: &companions }).unwrap()[0]
}

// By hand: overlaps 50 / 150, 1, 0 and 0 (beside, and without numbers).
#[test]
fn statistics_by_hand() {
    let companions = [
        region(5.0, 0.0, 10.0, 10.0),
        region(0.0, 0.0, 10.0, 10.0),
        region(10.0, 0.0, 10.0, 10.0),
        region(f64::NAN, 0.0, 10.0, 10.0),
    ];
    for (text, want) in [
        ("{}", 1.0 / 6.0),
        ("{ statistic = \"minimum\" }", 0.0),
        ("{ statistic = \"share\" }", 0.5),
        ("{ at_most = 1 }", 1.0 / 3.0),
        ("{ at_most = 2 }", 2.0 / 3.0),
        ("{ at_most = 3 }", 1.0 / 3.0),
    ] {
        assert_eq!(value(text, &companions), want, "{text}");
    }
    assert!(value("{}", &[]).is_nan());
    assert_eq!(value("{ statistic = \"share\", at_most = 3 }", &companions), 2.0 / 3.0);
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

const KCF: &str = "{ companions = [{ tracker = \"kcf\" }] }";

fn values(text: &str, frames: &[Frame], boxes: &[Rect]) -> Vec<f64> {
    testing::run("companion-overlap", text, frames, boxes)
}

#[test]
fn a_watchdog_agrees_with_a_tracker_on_the_target_and_leaves_one_that_stays_behind() {
    let (frames, boxes) = moving(40, 2.0);
    let good = values(KCF, &frames, &boxes);
    assert!(good.iter().all(|o| *o > 0.6), "{good:?}");
    let lost = values(KCF, &frames, &[boxes[0]; 40]);
    assert_eq!(lost[0], 1.0);
    // The target has left the box of the first frame after eight frames. The watchdog is not started again on the
    // background.
    assert!(lost[12..].iter().all(|o| *o == 0.0), "{lost:?}");
    // Nor on something that has half of the target's colors.
    let painted = |(t, frame): (usize, &Frame)| {
        let is_like = |x: usize, y: usize| t >= 12 && (20..36).contains(&x) && (40..56).contains(&y);
        Frame::from_fn(160, 96, |x, y| if is_like(x, y) { [120, 240, 7] } else { frame.pixel(x, y) })
    };
    let painted: Vec<Frame> = frames.iter().enumerate().map(painted).collect();
    let like = values(KCF, &painted, &[boxes[0]; 40]);
    assert!(like[12..].iter().all(|o| *o == 0.0), "{like:?}");
}

#[test]
fn a_watchdog_that_cannot_start_is_a_fault() {
    let mut session = testing::start(&*testing::build("companion-overlap", KCF));
    let (frame, state) = (Frame::new(1, 1, vec![0; 3]), TrackerState::tracked(Region::nowhere()));
    assert!(session.push(&Observation::new(&frame, &state)).is_err());
}

#[test]
fn the_state_of_another_watchdog_is_refused() {
    const NEVER: &str = "{ companions = [{ tracker = \"kcf\", restart_after = 0 }] }";
    let (frames, boxes) = moving(2, 1.0);
    let saved = |text: &str| {
        let mut session = testing::start(&*testing::build("companion-overlap", text));
        for (frame, r) in frames.iter().zip(&boxes) {
            session.push(&Observation::new(frame, &TrackerState::tracked(Region::Rect(*r)))).unwrap();
        }
        session.save().unwrap()
    };
    let takes =
        |text: &str, saved: &[u8]| testing::start(&*testing::build("companion-overlap", text)).restore(saved);
    for (text, other) in [(KCF, NEVER), (NEVER, KCF)] {
        assert!(takes(text, &saved(text)) && !takes(text, &saved(other)), "{text}");
    }
    let without_tracker = vec![(Some(vec![7_u8]), None::<[Vec<u8>; 2]>, 0_usize)];
    assert!(!testing::takes("companion-overlap", NEVER, &without_tracker));
}

// The target jumps to another place in frame 5, out of the watchdog's reach, and the tracker with it.
#[test]
fn a_watchdog_that_is_lost_is_started_again() {
    let (mut frames, mut boxes) = moving(30, 1.0);
    for (frame, r) in frames[5..].iter_mut().zip(&mut boxes[5..]) {
        *frame = Frame::from_fn(160, 96, |x, y| frame.pixel((x + 80) % 160, y));
        *r = r.shifted(80.0, 0.0);
    }
    let again = values(KCF, &frames, &boxes);
    assert!(again[..5].iter().all(|o| *o > 0.6) && again[5..15].iter().all(|o| *o == 0.0), "{again:?}");
    assert!(again[15..].iter().all(|o| *o > 0.6), "{again:?}");
    let never = values("{ companions = [{ tracker = \"kcf\", restart_after = 0 }] }", &frames, &boxes);
    assert!(never[5..].iter().all(|o| *o == 0.0), "{never:?}");
}
