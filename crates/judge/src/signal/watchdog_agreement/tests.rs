use super::*;
use crate::image::Frame;
use crate::region::Areas;
use crate::signal::testing;
use crate::tracker::{self, TrackerState};

const ALL: &str = "{ values = [\"overlap\", \"score\", \"disagreement\", \"apart\", \"distance\"] }";

/// 30 frames of a face, and the boxes and scores of a tracker that starts on it.
fn face() -> (Vec<Frame>, Vec<TrackerState>) {
    let (girl, frames) = tracker::testing::excerpt(30);
    let config = tracker::nanotrack::ENTRY.build_from_text("{}").unwrap();
    let states = tracker::testing::track(&*config, &girl, 1, girl.truth[0].as_ref().unwrap(), &frames);
    (frames, states)
}

fn values(frames: &[Frame], states: &[TrackerState]) -> Vec<Vec<f64>> {
    let signal = ENTRY.build_from_text(ALL).unwrap();
    let mut session = testing::start(&*signal);
    let of = |(frame, state): (&Frame, &TrackerState)| {
        let first = session.push(&Observation::new(frame, state));
        std::iter::once(first).chain(session.more().iter().copied()).collect()
    };
    frames.iter().zip(states).map(of).collect()
}

/// A tracker that is the watchdog itself for ten frames, then stays where it is, and is 200 pixels further on from frame 20.
#[test]
fn a_watchdog_sees_who_stays_behind() {
    let (frames, mut states) = face();
    let score: Vec<f64> = states.iter().map(|state| state.confidence.unwrap()).collect();
    let own: Vec<Rect> = states.iter().map(|state| state.region.bounds()).collect();
    for (t, state) in states.iter_mut().enumerate().skip(10) {
        let shift = if t < 20 { 0.0 } else { 200.0 };
        state.region = Region::Rect(Rect { x: own[10].x + shift, ..own[10] });
    }
    for (t, values) in values(&frames, &states).iter().enumerate() {
        let [overlap, sure, disagreement, apart, distance] = values[..] else { panic!("{values:?}") };
        let want = match t {
            0..=10 => 1.0,
            20.. => 0.0,
            _ => Areas::Exact.overlap(&Region::Rect(own[t]), &states[t].region, None),
        };
        assert!((overlap - want).abs() < 1e-12, "frame {t}: {overlap} {want}");
        assert_eq!(sure, if t == 0 { 1.0 } else { score[t] });
        assert!((disagreement - (1.0 - want) * sure).abs() < 1e-12);
        assert_eq!(apart, if want > 0.0 { 0.0 } else { sure });
        let centers = |t: usize| (own[t].center(), states[t].region.bounds());
        let ((x, y), seen) = centers(t);
        let sides = (x - seen.center().0).hypot(y - seen.center().1) / (seen.w * seen.h).sqrt();
        assert!((distance - sides.min(3.0)).abs() < 1e-9, "frame {t}: {distance} {sides}");
    }
}

#[test]
fn values_are_named_once() {
    for text in ["{ values = [] }", "{ values = [\"score\", \"score\"] }"] {
        assert_eq!(ENTRY.build_from_text(text).err().and_then(|e| e.key), Some("values"), "{text}");
    }
    let of = |text: &str| ENTRY.build_from_text(text).unwrap();
    assert_eq!((of("{}").width(), of(ALL).width()), (1, 5));
    assert_eq!(of("{ values = [\"overlap\", \"distance\"] }").facts().direction, Direction::HigherIsBetter);
    assert_eq!(of("{ values = [\"distance\"] }").facts().bounds, (0.0, 3.0));
}
