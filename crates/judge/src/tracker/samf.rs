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
//! touch with it. In a window of one color the gray values and color names still move it. The region keeps its offset
//! from the tracked pixel.
//!
//! The response map of the best scale is reported in numbers and, as a density, as the posterior of the
//! center `[x, y]` in pixels: see `tracker/correlation/response.rs`. That of the first frame is the response
//! to the window that the filter has just learned.
//!
//! Checked against a separate NumPy version of this description: on diving of VOT2014 both fail in frames 58, 98, 175 and
//! 194, that one also with the learned table and bicubic cells and without color names; on Couple of OTB responses are so
//! nearly equal that a gray level of noise moves its precision from 0.74 to 0.35 or 0.30.

use super::correlation::place::{Follower, Look, Place, Search};
use super::correlation::response::MapOptions;
use super::correlation::{KernelFilter, Settings, Update, block_means};
use crate::image::color_names::{ColorNames, NAMES};
use crate::image::hog::{CHANNELS, Hog};
use crate::image::patch::{Axis, Colors, Outside, Patch, is_gray};
use crate::tracker::prelude::*;

/// Side of a cell in pixels.
const CELL: usize = 4;

/// Parameters of the tracker.
#[derive(Debug, Clone, SmartDefault, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Params {
    /// Side of the window in multiples of the target's side, from 1 to 6.
    #[default(2.5)]
    pub window: f64,
    /// Regularization, from 1e-6 to 1.
    #[default(1e-4)]
    pub lambda: f64,
    /// Share of the newest look, 0 to 1.
    #[default(0.01)]
    pub rate: f64,
    /// Standard deviation of the label in multiples of the target's mean side, from 0.01 to 1.
    #[default(0.1)]
    pub label_width: f64,
    /// Standard deviation `sigma` of the kernel, from 0.01 to 10.
    #[default(0.5)]
    pub kernel_width: f64,
    /// Scales to try, 1 to 99 numbers from 0.5 to 2; among equal responses the first one wins.
    #[default(vec![1.0, 0.985, 0.99, 0.995, 1.005, 1.01, 1.015])]
    pub scales: Vec<f64>,
    /// How the response map is read.
    pub response: MapOptions,
}

impl PlainParams for Params {
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

    fn check(&self) -> Result<(), ParamError> {
        let count = self.scales.len();
        ParamError::unless((1..=99).contains(&count), "scales", "1 to 99 numbers", count)
    }
}

/// SAMF in the list of trackers.
pub const ENTRY: Entry<dyn TrackerConfig> =
    Entry::of::<Params>("samf", 3, "kernelized correlation filter on gradients and colors, at seven scales");

impl TrackerConfig for Params {
    fn facts(&self) -> Facts {
        Facts::RESPONSES
    }

    fn start(&self, _: &RunContext<'_>, frame: &Frame, region: &Region) -> StartResult {
        if !region.is_finite() {
            return Err(TrackerError::no_region("samf"));
        }
        self.follower(frame, region).start(frame, region)
    }
}

/// Number of channels of a cell: gradients, and the gray value with color names or, of a gray sequence, twice.
fn channels(is_gray: bool) -> usize {
    CHANNELS + if is_gray { 2 } else { 1 + NAMES }
}

impl Params {
    /// Target in its first frame, with an untrained filter.
    fn follower(&self, frame: &Frame, region: &Region) -> Follower<SamfLook> {
        let place = Place::new(region, (frame.width(), frame.height()), true);
        let pixels = |side: f64| ((self.window * side) as usize).max(3 * CELL);
        let size = (pixels(place.sides.0), pixels(place.sides.1));
        let &Self { kernel_width, lambda, rate, .. } = self;
        let label_width = self.label_width * (place.sides.0 * place.sides.1).sqrt() / CELL as f64;
        let settings = Settings { label_width, kernel_width, lambda, rate, update: Update::Linear };
        let is_gray = is_gray(frame);
        let filter = KernelFilter::new(size.0 / CELL, size.1 / CELL, channels(is_gray), settings);
        let search = Search {
            steps: self.scales.clone(),
            weight: 1.0,
            smaller_ends: false,
            sub_cell: false,
            tolerance: 0.0,
            response: self.response,
        };
        let look = SamfLook { window: self.window, size, is_gray, hog: Hog::default() };
        Follower::new(place, look, filter, search)
    }
}

/// Window of the tracker around the target.
#[derive(Clone)]
struct SamfLook {
    /// Side of the window in multiples of the target's side.
    window: f64,
    /// Number of columns and rows in cells.
    size: (usize, usize),
    /// True if the first frame has no color.
    is_gray: bool,
    hog: Hog,
}

impl SamfLook {
    /// Sides of the window in whole pixels of the halved frame.
    fn sides(&self, place: &Place, step: f64) -> (f64, f64) {
        let side = |side: f64| (self.window * side * place.scale * step).floor().max(1.0);
        (side(place.sides.0), side(place.sides.1))
    }
}

impl Look for SamfLook {
    fn look(&mut self, place: &Place, frame: &Frame, step: f64, features: &mut Vec<f32>) {
        let factor = place.factor();
        let (w, h) = self.sides(place, step);
        // From the middle of the tracked pixel.
        let axis = |center: f64, moved: f64, length: f64, count: usize, shift: f64| {
            let (center, step) = ((center / factor).floor() + 0.5, length / count as f64);
            Axis { start: center + moved / factor + step * (shift - 0.5 * count as f64), step, count }
        };
        let (cx, cy) = place.first.center();
        let across = axis(cx, place.moved.0, w, self.size.0, 1.5);
        let down = axis(cy, place.moved.1, h, self.size.1, 1.0);
        let colors = if self.is_gray { Colors::Gray } else { Colors::Rgb };
        let mut patch = Patch::sampled(frame, &across, &down, Outside::Zero, colors);
        patch.round();
        let means = block_means(&patch, CELL).values;
        patch.scale(1.0 / 255.0);
        let (columns, rows) = self.hog.compute(&patch, CELL, features);
        let n = columns * rows;
        features.resize(channels(self.is_gray) * n, 0.0);
        let (gray, others) = features[CHANNELS * n..].split_at_mut(n);
        if self.is_gray {
            gray.iter_mut().zip(&means).for_each(|(o, v)| *o = v / 255.0 - 0.5);
            others.copy_from_slice(gray);
            return;
        }
        let table = ColorNames::table();
        for (i, o) in gray.iter_mut().enumerate() {
            let [r, g, b] = [means[i], means[n + i], means[2 * n + i]];
            *o = (0.2989 * r + 0.5870 * g + 0.1140 * b) / 255.0 - 0.5;
            let names = table.of([r, g, b]);
            others[i..].iter_mut().step_by(n).zip(names).for_each(|(o, v)| *o = *v);
        }
    }

    fn cell_side(&self, place: &Place, step: f64) -> f64 {
        let ratio = self.sides(place, step).0 / self.size.0 as f64;
        ratio * (CELL << place.halvings) as f64
    }
}

#[cfg(test)]
mod tests;
