use super::*;
use crate::region::Areas;
use crate::signal::testing;
use crate::tracker;

const ALL: &str = "{ values = [\"overlap\", \"score\", \"disagreement\", \"apart\", \"distance\"] }";

/// A tracker that is the watchdog itself for ten frames, then stays where it is, and is 200 pixels further on from frame 20.
#[test]
fn a_watchdog_sees_who_stays_behind() {
    let (_, start, frames) = tracker::testing::excerpt(30);
    let mut states = tracker::testing::run("nanotrack", "{}", 1, &start, &frames);
    let score: Vec<f64> = states.iter().map(|state| state.confidence.unwrap()).collect();
    let own: Vec<Rect> = states.iter().map(|state| state.region.bounds()).collect();
    for (t, state) in states.iter_mut().enumerate().skip(10) {
        let shift = if t < 20 { 0.0 } else { 200.0 };
        state.region = Region::Rect(Rect { x: own[10].x + shift, ..own[10] });
    }
    let rows = testing::rows(&*testing::build("watchdog-agreement", ALL), &frames, &states);
    for (t, values) in rows.iter().enumerate() {
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
        let ((x, y), seen) = (own[t].center(), states[t].region.bounds());
        let sides = (x - seen.center().0).hypot(y - seen.center().1) / (seen.w * seen.h).sqrt();
        assert!((distance - sides.min(3.0)).abs() < 1e-9, "frame {t}: {distance} {sides}");
    }
}
