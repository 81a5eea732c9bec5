//! Tracking error from overlap (Khalid et al. 2016, Eq. 10; the same in SanMiguel and Cavallaro 2015).
//!
//! ```text
//! O_t = 1 - 2 |A_t ∩ G_t| / (|A_t| + |G_t|)        in [0, 1], low is good
//! ```
//!
//! `A_t` is the tracker's region and `G_t` the ground truth in frame t; `|.|` is the area. Deviation:
//! the papers count pixels, here areas are exact (polygon clipping), which differs by less than a pixel
//! along the border.

use crate::region::Region;
use crate::tracker::{Status, TrackerState};

/// Version of the tracking error; part of the address of every result that uses it.
/// - 1: first version.
pub const OVERLAP: u32 = 1;

/// Distance from 1 below which errors are rounded to 1. Clipping leaves tiny areas for polygons that only
/// touch, and events need an error of exactly 1.
const ROUNDING: f64 = 1e-12;

/// O_t of one frame.
pub fn error(tracked: &Region, truth: &Region) -> f64 {
    let total = tracked.area() + truth.area();
    let error = 1.0 - 2.0 * tracked.intersection(truth) / total;
    if error > 1.0 - ROUNDING { 1.0 } else { error.clamp(0.0, 1.0) }
}

/// O_t of each frame; NaN where the target is not annotated, and in frames before the tracker starts. It is 1
/// in frames that a reset protocol marked as failed or skipped, because their files lack the region that
/// failed, and where the tracker reports an annotated target as absent.
pub fn errors(states: &[TrackerState], truth: &[Option<Region>]) -> Vec<f64> {
    states
        .iter()
        .zip(truth)
        .map(|(state, truth)| match (state.status, truth) {
            (Status::Waiting, _) => f64::NAN,
            (Status::Failed | Status::Skipped, _) => 1.0,
            (_, None) => f64::NAN,
            (status, Some(truth)) if status.has_box() => error(&state.region, truth),
            (_, Some(_)) => 1.0,
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::score::testing::{rect, square};
    use proptest::prelude::*;

    // Worked by hand: 10x10 boxes, 5 columns shared: 1 - 2*50/200.
    #[test]
    fn half_shifted_boxes() {
        assert_eq!([0.0, 5.0, 10.0].map(|x| error(&square(0.0), &square(x))), [0.0, 0.5, 1.0]);
    }

    // Turned boxes side by side, the common edge a part of each: without the margin about one in nine
    // has an error of 1 - 1e-16 or so.
    #[test]
    fn boxes_that_only_touch_are_lost() {
        for k in 0..1000 {
            let k = f64::from(k);
            let (sin, cos) = (0.37 * k).sin_cos();
            let turned = |u: f64, v: f64| (309.1 + cos * u - sin * v, 259.9 + sin * u + cos * v);
            let at = |u: f64, v: f64, w: f64, h: f64| {
                Region::Polygon(vec![turned(u, v), turned(u + w, v), turned(u + w, v + h), turned(u, v + h)])
            };
            assert_eq!(error(&at(0.0, 0.0, 56.2, 60.3), &at(56.2, 2.4, 47.5, 63.4)), 1.0, "{k}");
        }
    }

    #[test]
    fn errors_of_every_status_with_and_without_truth() {
        use Status::{Absent, Failed, Initialized, Repeated, Skipped, Tracked, Waiting};
        const N: f64 = f64::NAN;
        let region = rect(0.0, 0.0, 4.0, 4.0);
        for (status, expected) in [
            (Initialized, [0.0, N]),
            (Tracked, [0.0, N]),
            (Repeated, [0.0, N]),
            (Absent, [1.0, N]),
            (Failed, [1.0, 1.0]),
            (Skipped, [1.0, 1.0]),
            (Waiting, [N, N]),
        ] {
            let state = TrackerState::new(region.clone(), status);
            let found = errors(&[state.clone(), state], &[Some(region.clone()), None]);
            let same = found.iter().zip(expected).all(|(a, b)| *a == b || a.is_nan() && b.is_nan());
            assert!(same && found.len() == 2, "{status:?}: {found:?}");
        }
    }

    proptest! {
        #[test]
        fn is_symmetric_bounded_and_scale_free(
            a in (0.0..50.0, 0.0..50.0, 1.0..40.0, 1.0..40.0),
            b in (0.0..50.0, 0.0..50.0, 1.0..40.0, 1.0..40.0),
        ) {
            let at = |k: f64, r: (f64, f64, f64, f64)| rect(k * r.0, k * r.1, k * r.2, k * r.3);
            let e = error(&at(1.0, a), &at(1.0, b));
            prop_assert!((0.0..=1.0).contains(&e));
            prop_assert_eq!(e, error(&at(1.0, b), &at(1.0, a)));
            // A power of two keeps the floats exact.
            prop_assert_eq!(e, error(&at(4.0, a), &at(4.0, b)));
        }
    }
}
