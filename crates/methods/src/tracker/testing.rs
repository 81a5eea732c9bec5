//! Helpers of the trackers' tests.

use super::{RunContext, TrackerConfig, TrackerState};
use crate::dataset::{Sequence, synthetic};
use crate::image::Frame;
use crate::plugin::Entry;
use crate::region::Region;

/// A context of run 0 that starts in the first frame and has no data root.
pub fn context(sequence: &Sequence, seed: u64) -> RunContext<'_> {
    RunContext { sequence, start_frame: 0, run: 0, seed, data_roots: &[] }
}

/// The states of a tracker that starts with `region` in the first of these frames.
pub fn track(
    config: &dyn TrackerConfig,
    sequence: &Sequence,
    seed: u64,
    region: &Region,
    frames: &[Frame],
) -> Vec<TrackerState> {
    let (mut tracker, first) = config.start(&context(sequence, seed), &frames[0], region).unwrap();
    std::iter::once(first).chain(frames[1..].iter().map(|f| tracker.update(f).unwrap())).collect()
}

/// The last region of a tracker that starts with `region` in the first frame.
pub fn follow(entry: &Entry<dyn TrackerConfig>, params: &str, region: &Region, frames: &[Frame]) -> Region {
    let sequence = synthetic::suite("synthetic-otb").unwrap().swap_remove(0);
    let config = entry.build_from_text(params).unwrap();
    track(&*config, &sequence, 1, region, frames).pop().unwrap().region
}

/// Noise of 5-pixel grain, linear in between, 160 x 120; moved by `(dx, dy)` and magnified by `zoom` around (80, 60).
pub fn texture(dx: f64, dy: f64, zoom: f64, gray: bool) -> Frame {
    let grain = |i: f64, j: f64, c: usize| {
        let seed = ((i + 500.0) as u64 * 7919 + (j + 500.0) as u64 * 104_729 + c as u64 * 1_299_709)
            .wrapping_mul(6_364_136_223_846_793_005);
        ((seed ^ (seed >> 29)).wrapping_mul(2_654_435_761) >> 24) as u8
    };
    Frame::from_fn(160, 120, |x, y| {
        let (u, v) = ((x as f64 + 0.5 - 80.0 - dx) / zoom / 5.0, (y as f64 + 0.5 - 60.0 - dy) / zoom / 5.0);
        let ((i, j), (a, b)) = ((u.floor(), v.floor()), (u - u.floor(), v - v.floor()));
        std::array::from_fn(|c| {
            let at = |di: f64, dj: f64| f64::from(grain(i + di, j + dj, if gray { 0 } else { c }));
            let (above, below) =
                ((1.0 - a) * at(0.0, 0.0) + a * at(1.0, 0.0), (1.0 - a) * at(0.0, 1.0) + a * at(1.0, 1.0));
            ((1.0 - b) * above + b * below) as u8
        })
    })
}
