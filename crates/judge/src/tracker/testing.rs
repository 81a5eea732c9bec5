//! Helpers for tests of trackers.

use super::correlation::response::{MapOptions, ResponseMap};
use super::{Response, RunContext, TRACKERS, TrackerConfig, TrackerState, correlation};
use crate::image::Frame;
use crate::plugin::find;
use crate::region::{Rect, Region};
use trackfail_dataset::{Sequence, synthetic};

/// Context of run 0 that starts in the first frame, without a data root.
pub fn context(sequence: &Sequence, seed: u64) -> RunContext<'_> {
    RunContext { sequence, start_frame: 0, run: 0, seed, data_roots: &[] }
}

/// A small sequence that ends after `n` frames, the target's region in the first one, and the frames.
pub fn excerpt(n: usize) -> (Sequence, Region, Vec<Frame>) {
    let mut q = synthetic::suite("synthetic-otb").unwrap().into_iter().find(|q| q.name == "Girl").unwrap();
    q.truth.truncate(n);
    let frames = (0..n).map(|t| q.frame(t).unwrap()).collect();
    let first = q.truth[0].clone().unwrap();
    (q, first, frames)
}

/// States of a tracker that starts with `region` in the first of these frames.
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

/// The states of a tracker of this kind, on frames without a ground truth.
pub fn run(kind: &str, params: &str, seed: u64, region: &Region, frames: &[Frame]) -> Vec<TrackerState> {
    let mut sequence = synthetic::suite("synthetic-otb").unwrap().swap_remove(0);
    sequence.attributes.clear();
    let config = find(TRACKERS, kind).unwrap().build_from_text(params).unwrap();
    track(&*config, &sequence, seed, region, frames)
}

/// The last region of a tracker that starts with `region` in the first frame.
pub fn follow(kind: &str, params: &str, region: &Region, frames: &[Frame]) -> Region {
    run(kind, params, 1, region, frames).pop().unwrap().region
}

/// A target that moves by whole pixels over a ground that stands still, so that its place in every frame is known; a
/// look-alike, and what hides the target from below.
#[derive(Clone, Copy)]
pub struct Scene {
    /// Color of the target's pixels, by their distances from its left and its top.
    pub target: fn(f64, f64) -> [u8; 3],
    /// Sides of the target.
    pub sides: (f64, f64),
    /// Color of what stands still.
    pub ground: fn(i64, i64) -> [u8; 3],
    /// Color of what hides the target.
    pub occluder: fn(i64, i64) -> [u8; 3],
    /// Width and height of the frames.
    pub size: (usize, usize),
    /// Left and top of the target in the first frame.
    pub start: (i64, i64),
    /// Pixels per frame that the target moves by.
    pub step: (i64, i64),
    /// Pixels that everything is moved by in all frames.
    pub camera: (i64, i64),
    /// Left and top of a second target, which stands still.
    pub look_alike: Option<(i64, i64)>,
}

impl Scene {
    /// A checkerboard with a slope of blue, on noise.
    pub const CHECKED: Self = Self {
        target: |u, v| [200, (120 * ((u / 4.0) as i64 + (v / 4.0) as i64) % 240) as u8, (6.25 * u) as u8],
        sides: (24.0, 24.0),
        ground: noise,
        occluder: |x, y| noise(x - 900, y),
        size: (120, 96),
        start: (48, 36),
        step: (2, 1),
        camera: (0, 0),
        look_alike: None,
    };
    /// Slopes of green and blue, on noise.
    pub const SLOPES: Self = Self {
        target: |u, v| [200, (8.0 * u) as u8, (8.0 * v) as u8],
        sides: (24.0, 30.0),
        start: (40, 30),
        ..Self::CHECKED
    };
    /// Gray waves on a smooth ground, hidden by something bright.
    pub const WAVES: Self = Self {
        target: |u, v| [waves(u, v) as u8; 3],
        sides: (40.0, 40.0),
        ground: |x, y| [(70.0 + 20.0 * (0.05 * x as f64).sin() + 0.2 * y as f64) as u8; 3],
        occluder: |_, _| [250; 3],
        size: (160, 120),
        start: (30, 20),
        ..Self::CHECKED
    };
    /// The same with a wave that differs in every part.
    pub const CHIRP: Self =
        Self { target: |u, v| [(waves(u, v) + 20.0 * (0.02 * u * v).sin()) as u8; 3], ..Self::WAVES };

    /// The target's place in frame `t`.
    pub fn rect(&self, t: i64) -> Rect {
        let x = self.start.0 + self.step.0 * t + self.camera.0;
        let y = self.start.1 + self.step.1 * t + self.camera.1;
        Rect::new(x as f64, y as f64, self.sides.0, self.sides.1)
    }

    /// Frame `t`, in which so many rows of the target are hidden from below.
    pub fn frame(&self, t: i64, hidden: f64) -> Frame {
        let rect = self.rect(t);
        Frame::from_fn(self.size.0, self.size.1, |i, j| {
            let inside = |r: &Rect| {
                let (u, v) = (i as f64 - r.x, j as f64 - r.y);
                ((0.0..r.w).contains(&u) && (0.0..r.h).contains(&v)).then_some((u, v))
            };
            let other = self.look_alike.map(|(x, y)| Rect { x: x as f64, y: y as f64, ..rect });
            let (x, y) = (i as i64 - self.camera.0, j as i64 - self.camera.1);
            match (inside(&rect), other.and_then(|other| inside(&other))) {
                (Some((_, v)), _) if v >= rect.h - hidden => (self.occluder)(x, y),
                (Some((u, v)), _) | (None, Some((u, v))) => (self.target)(u, v),
                (None, None) => (self.ground)(x, y),
            }
        })
    }

    /// The first `n` frames, in which nothing is hidden.
    pub fn frames(&self, n: i64) -> Vec<Frame> {
        (0..n).map(|t| self.frame(t, 0.0)).collect()
    }

    /// The states of a tracker of this kind that starts on the target.
    pub fn run(&self, kind: &str, params: &str, seed: u64, frames: &[Frame]) -> Vec<TrackerState> {
        run(kind, params, seed, &Region::Rect(self.rect(0)), frames)
    }
}

fn noise(x: i64, y: i64) -> [u8; 3] {
    [(x * x + 3 * y).rem_euclid(97) as u8, (60 + (x * y).rem_euclid(50)) as u8, 90]
}

fn waves(u: f64, v: f64) -> f64 {
    120.0 + 60.0 * (0.3 * u).sin() * (0.4 * v).cos() + u
}

/// Texture of 160 x 120 pixels: noise with a grain of 5 pixels and linear interpolation, moved by `(dx, dy)`
/// and magnified by `zoom` around (80, 60).
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

/// State of a tracker at (30, 50) with this response map (cells of 2 pixels), read with these options.
pub fn state_of_map_by(options: &MapOptions, values: &[f32], width: usize) -> TrackerState {
    let height = values.len() / width;
    let mut map = ResponseMap::new(width, height);
    map.take(&mut values.to_vec(), correlation::peak(values, width, height), 2.0);
    let region = Region::Rect(Rect::new(25.0, 40.0, 10.0, 20.0));
    map.describe(options, TrackerState::tracked(region))
}

/// Like [`state_of_map_by`], with the default options.
pub fn state_of_map(values: &[f32], width: usize) -> TrackerState {
    state_of_map_by(&MapOptions::default(), values, width)
}

/// The numbers of a response map.
pub fn numbers(r: &Response) -> [f64; 9] {
    [
        r.peak,
        r.second_peak,
        r.lowest,
        r.mean,
        r.deviation,
        r.sidelobe_mean,
        r.sidelobe_deviation,
        r.narrow_sidelobe_mean,
        r.narrow_sidelobe_deviation,
    ]
}

/// Response map of 20 x 16 cells with two peaks over a pattern. All values are exact.
pub fn two_peaks() -> Vec<f32> {
    let wrapped = |d: i64, n: i64| (d + n / 2).rem_euclid(n) - n / 2;
    let bump = |height: i64, dx: i64, dy: i64| {
        (height - 6 * (wrapped(dx, 20).pow(2) + wrapped(dy, 16).pow(2))).max(0)
    };
    let pattern = |x: i64, y: i64| (7 * x + 13 * y + x * y) % 11;
    let value = |x: i64, y: i64| pattern(x, y) + bump(60, x - 3, y - 14) + bump(40, x - 13, y - 6);
    (0..320).map(|i| value(i % 20, i / 20) as f32 / 64.0).collect()
}
