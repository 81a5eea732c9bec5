//! Average overlap and success rates, as GOT-10k's toolkit computes them (Huang, Zhao, Huang: GOT-10k, PAMI 2021).
//!
//! ```text
//! AO = mean overlap_t        SR.5 = #{t: overlap_t > .5} / n        SR.75 = #{t: overlap_t > .75} / n
//! ```
//!
//! `overlap_t` is intersection over union of the two rectangles in frame t, in `[0, 1]`. High is good. The frames that count
//! are those with a ground truth after the one in which the tracker starts; n is their number, over all runs and sequences
//! together, so that long sequences weigh more. A frame in which the tracker has no box has overlap 0. A frame without ground
//! truth is one whose target is not visible, which the program leaves out.
//!
//! The program first clamps both boxes to the image: in 1-based pixels, x and y to `0 ..= width` and `0 ..=
//! height`, then w and h to the remaining size. A box that crosses the left or upper border is thereby moved,
//! not clipped. Without images, boxes are not changed.
//!
//! Source: got10k-toolkit 0.1.3, `ExperimentGOT10k.report`, `rect_iou`, read for their rules only; it has SR.5, the
//! benchmark's server SR.75 as well.

use super::success::iou;
use super::trajectory::{Missing, Trajectory, mean};
use crate::region::Rect;

/// The box clamped to an image of `(width, height)` pixels as the program does it; 0-based.
fn on_image(rect: Rect, frame: Option<(usize, usize)>) -> Rect {
    let Some((width, height)) = frame else { return rect };
    let side = |from: f64, length: f64, all: f64| {
        let from = (from + 1.0).max(0.0).min(all);
        (from - 1.0, length.max(0.0).min(all - from))
    };
    let ((x, w), (y, h)) = (side(rect.x, rect.w, width as f64), side(rect.y, rect.h, height as f64));
    Rect::new(x, y, w, h)
}

/// Overlaps in the frames of a run that count.
pub fn overlaps(trajectory: &Trajectory<'_>) -> Vec<f64> {
    let frames = trajectory.counted(Missing::Miss).into_iter().zip(trajectory.truth);
    let known = frames.skip(trajectory.start() + 1).filter_map(|(r, truth)| Some((r, truth.as_ref()?)));
    let bounded = |rect| on_image(rect, trajectory.frame);
    known
        .map(|(region, truth)| region.map_or(0.0, |r| iou(&bounded(r.rect()), &bounded(truth.rect()))))
        .collect()
}

/// AO, SR.5 and SR.75 over the frames that count; `None` without such a frame.
pub fn rates(overlaps: &[f64]) -> [Option<f64>; 3] {
    let share = |above: f64| mean(overlaps.iter().map(|o| f64::from(u8::from(*o > above))));
    [mean(overlaps.iter().copied()), share(0.5), share(0.75)]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::region::Region;
    use crate::score::testing::{rect, trajectory};
    use crate::tracker::Status;
    use trackfail_testing::assert_near;

    fn of(
        boxes: &[[f64; 4]],
        truth: &[Option<[f64; 4]>],
        status: &[Status],
        frame: Option<(usize, usize)>,
    ) -> Vec<f64> {
        // 1-based, as in the files.
        let region = |r: &[f64; 4]| rect(r[0] - 1.0, r[1] - 1.0, r[2], r[3]);
        let regions: Vec<Region> = boxes.iter().map(region).collect();
        let truth: Vec<Option<Region>> = truth.iter().map(|t| t.as_ref().map(region)).collect();
        overlaps(&Trajectory { frame, ..trajectory(&regions, status, &truth) })
    }

    // python3 with got10k 0.1.3: from got10k.utils.metrics import rect_iou; rect_iou(b[1:], g[1:], bound=(160, 120)) of the
    // numbers below, the last box 0,0,0,0; and without a bound.
    #[test]
    fn agrees_with_got10k() {
        use Status::{Absent, Initialized, Tracked};
        let boxes = [
            [10.0, 20.0, 30.0, 40.0],
            [14.0, 21.0, 28.0, 44.0],
            [-10.0, 20.0, 30.0, 40.0],
            [150.0, 100.0, 30.0, 40.0],
            [150.0, 100.0, 30.0, 40.0],
        ];
        let truth = [
            [10.0, 20.0, 30.0, 40.0],
            [10.0, 22.0, 30.0, 40.0],
            [10.0, 25.0, 20.0, 60.0],
            [140.0, 95.0, 40.0, 40.0],
            [50.0, 50.0, 20.0, 20.0],
        ];
        let status = [Initialized, Tracked, Tracked, Tracked, Absent];
        for (frame, expected) in [
            (Some((160, 120)), [0.747_126_436_781_609_2, 0.411_764_705_882_353, 0.4, 0.0]),
            (None, [0.747_126_436_781_609_2, 0.170_731_707_317_073_2, 0.6, 0.0]),
        ] {
            assert_near(of(&boxes, &truth.map(Some), &status, frame), expected, 1e-12, format!("{frame:?}"));
        }
    }

    // By hand: the start and the frames before it do not count, nor do those without truth; a repeated box does.
    #[test]
    fn frames_that_count() {
        use Status::{Initialized, Repeated, Skipped, Tracked, Waiting};
        let (square, half) = ([5.0, 5.0, 10.0, 10.0], [5.0, 5.0, 10.0, 5.0]);
        let truth = [Some(square), Some(square), None, Some(square), Some(square), Some(square)];
        let status = [Waiting, Initialized, Tracked, Tracked, Repeated, Skipped];
        let found = of(&[square, square, square, half, square, square], &truth, &status, None);
        assert_eq!(found, [0.5, 1.0, 0.0]);
        assert_eq!(rates(&found), [Some(0.5), Some(1.0 / 3.0), Some(1.0 / 3.0)]);
        assert_eq!(rates(&[]), [None; 3]);
    }
}
