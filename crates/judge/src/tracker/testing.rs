//! Helpers of the trackers' tests.

use super::correlation::response::{MapOptions, ResponseMap};
use super::{RunContext, TrackerConfig, TrackerState, correlation};
use crate::image::Frame;
use crate::plugin::Entry;
use crate::region::{Rect, Region};
use trackfail_dataset::{Sequence, synthetic};

/// A context of run 0 that starts in the first frame and has no data root.
pub fn context(sequence: &Sequence, seed: u64) -> RunContext<'_> {
    RunContext { sequence, start_frame: 0, run: 0, seed, data_roots: &[] }
}

/// The first `n` frames of a small sequence.
pub fn excerpt(n: usize) -> (Sequence, Vec<Frame>) {
    let mut q = synthetic::suite("synthetic-otb").unwrap().into_iter().find(|q| q.name == "Girl").unwrap();
    q.truth.truncate(n);
    let frames = (0..n).map(|t| q.frame(t).unwrap()).collect();
    (q, frames)
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

/// The state of a tracker at (30, 50) with this response map, whose cells have 2 pixels, read in this way.
pub fn state_of_map_by(options: &MapOptions, values: &[f32], width: usize) -> TrackerState {
    let height = values.len() / width;
    let mut map = ResponseMap::new(width, height);
    map.take(&mut values.to_vec(), correlation::peak(values, width, height), 2.0);
    let region = Region::Rect(Rect::new(25.0, 40.0, 10.0, 20.0));
    map.describe(options, TrackerState::tracked(region))
}

/// As [`state_of_map_by`], with the default options.
pub fn state_of_map(values: &[f32], width: usize) -> TrackerState {
    state_of_map_by(&MapOptions::default(), values, width)
}

/// A response map of 20 x 16 cells with two peaks over a pattern; every value is exact.
pub fn two_peaks() -> Vec<f32> {
    let wrapped = |d: i64, n: i64| (d + n / 2).rem_euclid(n) - n / 2;
    let bump = |height: i64, dx: i64, dy: i64| {
        (height - 6 * (wrapped(dx, 20).pow(2) + wrapped(dy, 16).pow(2))).max(0)
    };
    let pattern = |x: i64, y: i64| (7 * x + 13 * y + x * y) % 11;
    let value = |x: i64, y: i64| pattern(x, y) + bump(60, x - 3, y - 14) + bump(40, x - 13, y - 6);
    (0..320).map(|i| value(i % 20, i / 20) as f32 / 64.0).collect()
}
