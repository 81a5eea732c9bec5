//! SAMF (Li and Zhu, "A scale adaptive kernel correlation filter tracker with feature integration", ECCV workshops
//! 2014): the filter of [`super::kcf`] on gradients, color names and gray values, at seven scales.
//!
//! The filter and its equations are in `tracker/correlation.rs` (Gaussian kernel, linear update). In every frame
//! windows of `floor(2.5 * size * s)` pixels around the last place, for the seven `s` from 0.985 to 1.015, are
//! resized to that of the first frame; the highest of all responses decides shift and scale. Place and size are real
//! numbers that accumulate. Channels of a cell of 4 pixels:
//!
//! | channels | what |
//! |---|---|
//! | 31 | [`crate::image::hog`], strongest color |
//! | 1 | gray (mean of the cell) `/ 255 - 0.5` |
//! | 10 | [`crate::image::color_names`] of the cell's mean color |
//!
//! When red, green and blue are equal in the whole first frame, 31 + 2 channels: gradients and the gray values twice.
//!
//! Samples of a window are at `p + a (i - n / 2 + 1/2)` in x and at `p + a (i - n / 2)` in y for `i = 1 ... n` (the
//! original's grid, not symmetric), where `p` is the tracked pixel's center and `a` the ratio of the two windows;
//! bilinear, 0 outside the frame, rounded to whole levels. For targets with a mean side of 100 pixels or
//! more, frames are halved.
//!
//! Deviations: **the color names are a substitute** for the learned table of the original, see
//! [`crate::image::color_names`]; cells have the mean of their pixels (the original: a bicubic resize); halving as
//! in [`super::kcf`], with its other safety rules: at least 3 cells each way, targets not larger than the frame and in
//! touch with it, no move without contrast. The region keeps its offset from the tracked pixel.
//!
//! The response map of the scale that won is answered in numbers and, as a density, as the posterior of the center
//! `[x, y]` in pixels: see `tracker/correlation/response.rs`. That of the first frame is the response to the window
//! that the filter has just learned; that of a window without contrast is 0.
//!
//! Checked against a separate NumPy version of this description: on diving of VOT2014 both fail in frames 58, 98, 175 and
//! 194, that one also with the learned table and bicubic cells and without color names; on Couple of OTB responses are so
//! nearly equal that a gray level of noise moves its precision from 0.74 to 0.35 or 0.30.

use super::correlation::response::{MapOptions, ResponseMap};
use super::correlation::{KernelFilter, Settings, Update, halvings, reduced};
use super::{RunContext, StartResult, Tracker, TrackerConfig, TrackerError, TrackerState};
use crate::image::Frame;
use crate::image::color_names::{ColorNames, NAMES};
use crate::image::hog::{CHANNELS, Hog};
use crate::image::patch::{Axis, Colors, Outside, Patch, is_gray};
use crate::plugin::{Entry, ParamError, Plugin, Range};
use crate::region::{Rect, Region};
use serde::{Deserialize, Serialize};

/// Side of a cell in pixels.
const CELL: usize = 4;
/// Maximum number of scales.
const MAX_SCALES: usize = 99;

/// Parameters.
#[derive(Debug, Clone, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Params {
    /// Side of the window in multiples of the target's, from 1 to 6.
    pub window: f64,
    /// Regularization, from 1e-6 to 1.
    pub lambda: f64,
    /// Share of the newest look, 0 to 1.
    pub rate: f64,
    /// Deviation of the label in multiples of the target's mean side, from 0.01 to 1.
    pub label_width: f64,
    /// Deviation `sigma` of the kernel, from 0.01 to 10.
    pub kernel_width: f64,
    /// Scales to try, 1 to 99 numbers from 0.5 to 2; among equal responses the first one wins.
    pub scales: Vec<f64>,
    /// Uses color names, unless the first frame is gray.
    pub color_names: bool,
    /// How the response map is read.
    pub response: MapOptions,
}

impl Default for Params {
    fn default() -> Self {
        Self {
            window: 2.5,
            lambda: 1e-4,
            rate: 0.01,
            label_width: 0.1,
            kernel_width: 0.5,
            scales: vec![1.0, 0.985, 0.99, 0.995, 1.005, 1.01, 1.015],
            color_names: true,
            response: MapOptions::default(),
        }
    }
}

#[derive(Debug, Clone)]
struct Samf(Params);

impl Plugin for Samf {
    type Params = Params;

    const RANGES: &'static [Range] = &[
        Range::within("window", 1.0, 6.0),
        Range::within("lambda", 1e-6, 1.0),
        Range::within("rate", 0.0, 1.0),
        Range::within("label_width", 0.01, 1.0),
        Range::within("kernel_width", 0.01, 10.0),
        Range::within("scales", 0.5, 2.0),
        MapOptions::NEIGHBORHOOD,
        MapOptions::THRESHOLD,
    ];

    fn make(p: Params) -> Result<Self, ParamError> {
        if !(1..=MAX_SCALES).contains(&p.scales.len()) {
            let rule = format!("1 to {MAX_SCALES} numbers");
            return Err(ParamError::out_of_range("scales", &rule, p.scales.len()));
        }
        Ok(Self(p))
    }
}

/// The list's line.
pub const ENTRY: Entry<dyn TrackerConfig> =
    Entry::of::<Samf>("samf", 3, "kernelized correlation filter on gradients and colors, at seven scales");

impl TrackerConfig for Samf {
    fn uses_seed(&self) -> bool {
        false
    }

    fn gives_posterior(&self) -> bool {
        true
    }

    fn gives_response(&self) -> bool {
        true
    }

    fn start(&self, _: &RunContext<'_>, frame: &Frame, region: &Region) -> StartResult {
        if !region.is_finite() {
            return Err(TrackerError::no_region("samf"));
        }
        let p = &self.0;
        let mut target = Target::new(p, frame, region);
        target.look(p, &reduced(frame, target.halvings), 1.0);
        target.filter.learn(&target.features);
        let cell = target.cell_side(p, 1.0);
        target.filter.fill(&mut target.map, &target.features, cell);
        let state = target.map.describe(&p.response, TrackerState::initialized(region.clone()));
        Ok((Box::new(Tracking { params: p.clone(), target }), state))
    }
}

#[derive(Clone)]
struct Tracking {
    params: Params,
    target: Target,
}

/// Channels of a cell besides gradients.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Extra {
    /// Gray value and color names.
    Names,
    /// Gray value.
    Gray,
    /// Gray value twice, for gray sequences.
    GrayTwice,
}

impl Extra {
    fn channels(self) -> usize {
        match self {
            Self::Names => 1 + NAMES,
            Self::Gray => 1,
            Self::GrayTwice => 2,
        }
    }
}

/// The target and its model.
#[derive(Clone)]
struct Target {
    first: Rect,
    /// How far it has moved, in pixels of the frame, and its size relative to the first.
    moved: (f64, f64),
    scale: f64,
    halvings: u32,
    /// Center of the tracked pixel and size, at the start, in pixels of the halved frame.
    center: (f64, f64),
    target: (f64, f64),
    /// Columns and rows of the window.
    size: (usize, usize),
    extra: Extra,
    filter: KernelFilter,
    /// The highest response of the newest frame.
    map: ResponseMap,
    hog: Hog,
    features: Vec<f32>,
}

impl Target {
    fn new(p: &Params, frame: &Frame, region: &Region) -> Self {
        let first = region.bounds();
        let (width, height) = (frame.width() as f64, frame.height() as f64);
        let (w, h) = (first.w.clamp(1.0, width), first.h.clamp(1.0, height));
        let times = halvings((w * h).sqrt());
        let factor = f64::from(1_u32 << times);
        let small = |side: f64| if times > 0 { (side / factor).floor().max(1.0) } else { side };
        let target = (small(w), small(h));
        let pixels = |side: f64| ((p.window * side) as usize).max(3 * CELL);
        let size = (pixels(target.0), pixels(target.1));
        let (cx, cy) = first.center();
        let settings = Settings {
            label_width: p.label_width * (target.0 * target.1).sqrt() / CELL as f64,
            kernel_width: p.kernel_width,
            lambda: p.lambda,
            rate: p.rate,
            update: Update::Linear,
        };
        let extra = match (is_gray(frame), p.color_names) {
            (true, _) => Extra::GrayTwice,
            (_, true) => Extra::Names,
            _ => Extra::Gray,
        };
        let channels = CHANNELS + extra.channels();
        Self {
            first,
            moved: (0.0, 0.0),
            scale: 1.0,
            halvings: times,
            center: ((cx / factor).floor() + 0.5, (cy / factor).floor() + 0.5),
            target,
            size,
            extra,
            filter: KernelFilter::new(size.0 / CELL, size.1 / CELL, channels, settings),
            map: ResponseMap::new(size.0 / CELL, size.1 / CELL),
            hog: Hog::default(),
            features: Vec::new(),
        }
    }

    /// Sides of the window at a scale, in whole pixels of the halved frame.
    fn window(&self, p: &Params, scale: f64) -> (f64, f64) {
        let side = |side: f64| (p.window * side * self.scale * scale).floor().max(1.0);
        (side(self.target.0), side(self.target.1))
    }

    /// Computes `features` of the window around the target at a scale.
    fn look(&mut self, p: &Params, frame: &Frame, scale: f64) {
        let factor = f64::from(1_u32 << self.halvings);
        let (w, h) = self.window(p, scale);
        let axis = |center: f64, moved: f64, length: f64, count: usize, shift: f64| {
            let step = length / count as f64;
            Axis { start: center + moved / factor + step * (shift - 0.5 * count as f64), step, count }
        };
        let across = axis(self.center.0, self.moved.0, w, self.size.0, 1.5);
        let down = axis(self.center.1, self.moved.1, h, self.size.1, 1.0);
        let colors = if self.extra == Extra::GrayTwice { Colors::Gray } else { Colors::Rgb };
        let mut patch = Patch::sampled(frame, &across, &down, Outside::Zero, colors);
        patch.round();
        let means = cell_means(&patch);
        patch.scale(1.0 / 255.0);
        let (columns, rows) = self.hog.compute(&patch, CELL, CHANNELS, &mut self.features);
        let n = columns * rows;
        self.features.resize((CHANNELS + self.extra.channels()) * n, 0.0);
        let (gray, others) = self.features[CHANNELS * n..].split_at_mut(n);
        match means.len() / n {
            1 => gray.iter_mut().zip(&means).for_each(|(o, v)| *o = v / 255.0 - 0.5),
            _ => {
                for (i, o) in gray.iter_mut().enumerate() {
                    let mixed = 0.2989 * means[i] + 0.5870 * means[n + i] + 0.1140 * means[2 * n + i];
                    *o = mixed / 255.0 - 0.5;
                }
            }
        }
        match self.extra {
            Extra::Gray => {}
            Extra::GrayTwice => others.copy_from_slice(gray),
            Extra::Names => {
                let table = ColorNames::table();
                for i in 0..n {
                    let names = table.of([means[i], means[n + i], means[2 * n + i]]);
                    others[i..].iter_mut().step_by(n).zip(names).for_each(|(o, v)| *o = *v);
                }
            }
        }
    }

    /// Side of a cell of a window at a scale, in pixels of the frame.
    fn cell_side(&self, p: &Params, scale: f64) -> f64 {
        let ratio = self.window(p, scale).0 / self.size.0 as f64;
        ratio * (CELL << self.halvings) as f64
    }

    /// Moves and scales by the highest response.
    fn follow(&mut self, p: &Params, frame: &Frame) {
        let mut best: Option<(f32, f64, f64, (i64, i64))> = None;
        for &scale in &p.scales {
            self.look(p, frame, scale);
            let Some(peak) = self.filter.respond(&self.features) else { continue };
            if best.is_none_or(|(value, ..)| peak.value > value) {
                let pixels = self.cell_side(p, scale);
                best = Some((peak.value, scale, pixels, (peak.x, peak.y)));
                self.filter.hand_over(peak, pixels, &mut self.map);
            }
        }
        let Some((_, scale, pixels, (dx, dy))) = best else {
            self.map.clear(self.cell_side(p, 1.0));
            return;
        };
        self.moved = (self.moved.0 + pixels * dx as f64, self.moved.1 + pixels * dy as f64);
        self.scale *= scale;
    }

    /// Keeps the target in touch with a frame of `width` x `height` pixels and not larger than it.
    fn keep_inside(&mut self, width: f64, height: f64) {
        let Rect { w, h, .. } = self.first;
        let most = (width / w).min(height / h).max(1e-9);
        let least = (4.0 / w.min(h)).min(1.0).min(most);
        if self.scale != 1.0 {
            self.scale = self.scale.clamp(least, most);
        }
        let (cx, cy) = self.first.center();
        let touch = |c: f64, moved: f64, side: f64, room: f64| {
            let reach = 0.5 * (side * self.scale).min(room);
            let inside = (c + moved).clamp(-reach, room + reach);
            if inside == c + moved { moved } else { inside - c }
        };
        self.moved = (touch(cx, self.moved.0, w, width), touch(cy, self.moved.1, h, height));
    }

    fn rect(&self) -> Rect {
        let (cx, cy) = self.first.center();
        let (w, h) = (self.first.w * self.scale, self.first.h * self.scale);
        Rect::new(cx + self.moved.0 - 0.5 * w, cy + self.moved.1 - 0.5 * h, w, h)
    }
}

/// Means of the cells, plane after plane. Values are whole numbers, so that sums are exact in any order.
fn cell_means(patch: &Patch) -> Vec<f32> {
    let (columns, rows) = (patch.width / CELL, patch.height / CELL);
    let mut means = Vec::with_capacity(patch.planes() * columns * rows);
    let mut sums = vec![0.0; patch.width];
    for plane in patch.values.chunks_exact(patch.width * patch.height) {
        for band in plane.chunks_exact(CELL * patch.width) {
            sums.fill(0.0);
            for row in band.chunks_exact(patch.width) {
                sums.iter_mut().zip(row).for_each(|(sum, v)| *sum += v);
            }
            let cells = sums.chunks_exact(CELL);
            means.extend(cells.map(|cell| cell.iter().sum::<f32>() / (CELL * CELL) as f32));
        }
    }
    means
}

impl Tracker for Tracking {
    fn update(&mut self, frame: &Frame) -> Result<TrackerState, TrackerError> {
        let target = &mut self.target;
        let p = &self.params;
        let small = reduced(frame, target.halvings);
        target.follow(p, &small);
        target.keep_inside(frame.width() as f64, frame.height() as f64);
        target.look(p, &small, 1.0);
        target.filter.learn(&target.features);
        Ok(target.map.describe(&p.response, TrackerState::tracked(Region::Rect(target.rect()))))
    }

    fn fork(&self, _seed: Option<u64>) -> Option<Box<dyn Tracker>> {
        Some(Box::new(self.clone()))
    }
}

#[cfg(test)]
mod tests;
