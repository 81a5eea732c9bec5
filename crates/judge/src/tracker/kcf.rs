//! KCF (Henriques, Caseiro, Martins and Batista, "High-speed tracking with kernelized correlation filters",
//! PAMI 37(3), 2015): a kernel ridge regression over all cyclic shifts of a window around the target.
//!
//! The filter and its equations are in `tracker/correlation.rs`. In each frame the filter responds to the
//! window at the last place. The target moves by the shift of the highest response, times the side of a cell.
//! Then the filter learns the window at the new place.
//!
//! Two presets; every parameter can be set on its own as well:
//!
//! - `tpami` (default), the authors' MATLAB release. The window is 2.5 times the target, in whole cells, whose channels
//!   are the 31 of [`crate::image::hog`] on gray values (or `features = "grey"`: the gray values minus their mean). The size
//!   is fixed and shifts are whole cells. For targets with a mean side of 100 pixels or more, frames are
//!   halved.
//! - `vot`, after the entry of the VOT2014 challenge, whose report names three scales, peaks between the cells and
//!   an update of numerator and denominator, but no numbers; those are of the authors' later C++ release. The window is
//!   resized so that its longer side has 96 pixels, in an even number of cells, plus a ring of cells that only serves
//!   the gradients; gradients are of the strongest color. It is a window of whole pixels, and the larger scale is only
//!   tried where the smaller one is not better, both as in that release; `sampling` has other ways to read it.
//!
//! Windows that keep their size begin at the whole pixel `floor(center) + 1 - floor(w / 2)`. The region keeps its size
//! (times the scale) and its offset from the tracked pixel, while the release moves boxes with odd sides by half a pixel.
//!
//! Choices that the sources leave open, or made for safety: halved pixels are means of four (the release: a
//! bicubic filter), and frames are halved again while the target has 400 pixels or more; the window has at least 3
//! cells each way; targets larger than the frame are tracked as one of its size; a target stays in touch
//! with the frame and, if scaled, between 4 pixels and the frame's size; a window without contrast leaves it where it was.
//!
//! The response map of the best scale, without `scale_weight`, is reported in numbers and, as a density, as
//! the posterior of the center `[x, y]` in pixels: see `tracker/correlation/response.rs`. That of the first
//! frame is the response to the window that the filter has just learned; that of a window without contrast is
//! 0.

mod sampling;

use super::correlation::place::{Follower, Look, Place, Search};
use super::correlation::response::MapOptions;
use super::correlation::{FilterMemory, KernelFilter, Settings, Update};
use crate::image::hog::{CHANNELS, Hog};
use crate::image::patch::{Colors, Patch};
use crate::image::{MAX_SIDE, Window};
use crate::plugin::show_params;
use crate::saved;
use crate::tracker::prelude::*;
use sampling::Sampling;

/// Source of the defaults.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Preset {
    /// The authors' MATLAB release.
    #[default]
    Tpami,
    /// The VOT2014 entry.
    Vot,
}

/// Features of the filter.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Features {
    /// Histograms of oriented gradients.
    #[default]
    Hog,
    /// Gray values minus their mean.
    #[serde(rename = "grey")]
    Gray,
}

/// Parameters. The preset supplies the omitted ones.
#[derive(Debug, Clone, Default, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Params {
    /// Source of the defaults.
    pub preset: Preset,
    /// Features of the filter; by default `hog`.
    pub features: Features,
    /// Side of a cell of `hog` in pixels, from 1 to 16; by default 4.
    pub cell: Option<usize>,
    /// True to take gradients of the strongest color instead of gray; `tpami` false, `vot` true.
    pub color: Option<bool>,
    /// Side of the window in multiples of the target's side, from 1 to 6; by default 2.5.
    pub window: Option<f64>,
    /// Longer side of the resized window in pixels, from 16 to 512; 0 for no resizing. `tpami` 0, `vot` 96.
    pub template: Option<usize>,
    /// Rule for reading a resized window from the frame: `whole-pixels` (the default), `exact` or `area`.
    pub sampling: Option<Sampling>,
    /// Standard deviation of the label in multiples of the target's mean side, from 0.01 to 1; `tpami` 0.1,
    /// `vot` 0.125.
    pub label_width: Option<f64>,
    /// Standard deviation `sigma` of the kernel, from 0.01 to 10; `tpami` 0.5 (`grey` 0.2), `vot` 0.6.
    pub kernel_width: Option<f64>,
    /// Regularization, from 1e-6 to 1; by default 1e-4.
    pub lambda: Option<f64>,
    /// Share of the newest look, 0 to 1; `tpami` 0.02 (`grey` 0.075), `vot` 0.012.
    pub rate: Option<f64>,
    /// Rule by which the newest look is blended in; `tpami` `linear`, `vot` `fraction`.
    pub update: Option<Update>,
    /// Ratio between the three scales, from 1 (no other scales) to 1.5; `tpami` 1, `vot` 1.05.
    pub scale_step: Option<f64>,
    /// Factor of the responses at the other two scales, from 0 to 1; by default 0.95.
    pub scale_weight: Option<f64>,
    /// True to locate the peak between cells; `tpami` false, `vot` true.
    pub sub_cell: Option<bool>,
    /// Options for reading the response map.
    pub response: MapOptions,
}

/// Checked parameters, with all defaults filled in.
#[derive(Debug, Clone, Serialize)]
struct Checked {
    preset: Preset,
    features: Features,
    cell: usize,
    color: bool,
    window: f64,
    template: usize,
    sampling: Sampling,
    label_width: f64,
    kernel_width: f64,
    lambda: f64,
    rate: f64,
    update: Update,
    scale_step: f64,
    scale_weight: f64,
    sub_cell: bool,
    response: MapOptions,
}

impl Checked {
    /// Fills in the omitted parameters from the preset.
    fn of(p: &Params) -> Self {
        let vot = p.preset == Preset::Vot;
        let hog = p.features == Features::Hog;
        let by_preset = |tpami: f64, gray: f64, of_vot: f64| match (vot, hog) {
            (true, _) => of_vot,
            (_, true) => tpami,
            _ => gray,
        };
        Self {
            preset: p.preset,
            features: p.features,
            cell: p.cell.unwrap_or(4),
            color: p.color.unwrap_or(vot),
            window: p.window.unwrap_or(2.5),
            template: p.template.unwrap_or(if vot { 96 } else { 0 }),
            sampling: p.sampling.unwrap_or(Sampling::WholePixels),
            label_width: p.label_width.unwrap_or(by_preset(0.1, 0.1, 0.125)),
            kernel_width: p.kernel_width.unwrap_or(by_preset(0.5, 0.2, 0.6)),
            lambda: p.lambda.unwrap_or(1e-4),
            rate: p.rate.unwrap_or(by_preset(0.02, 0.075, 0.012)),
            update: p.update.unwrap_or(if vot { Update::Fraction } else { Update::Linear }),
            scale_step: p.scale_step.unwrap_or(by_preset(1.0, 1.0, 1.05)),
            scale_weight: p.scale_weight.unwrap_or(0.95),
            sub_cell: p.sub_cell.unwrap_or(vot),
            response: p.response,
        }
    }
}

impl Plugin for Checked {
    type Params = Params;

    const RANGES: &'static [Range] = &[
        MapOptions::NEIGHBORHOOD,
        MapOptions::THRESHOLD,
        Range::within("window", 1.0, 6.0),
        Range::within("label_width", 0.01, 1.0),
        Range::within("kernel_width", 0.01, 10.0),
        Range::within("lambda", 1e-6, 1.0),
        Range::within("rate", 0.0, 1.0),
        Range::within("scale_step", 1.0, 1.5),
        Range::within("scale_weight", 0.0, 1.0),
        Range::within("cell", 1.0, 16.0),
        Range::within("template", 0.0, 512.0),
    ];

    fn make(p: Params) -> Result<Self, ParamError> {
        let c = Self::of(&p);
        let is_size = !(1..16).contains(&c.template);
        ParamError::unless(is_size, "template", "0 or from 16 to 512", c.template)?;
        Ok(c)
    }

    fn shown(p: &Params) -> serde_json::Value {
        show_params(&Self::of(p))
    }
}

/// KCF in the list of trackers.
pub const ENTRY: Entry<dyn TrackerConfig> =
    Entry::of::<Checked>("kcf", 4, "kernelized correlation filter on oriented gradients or gray values");

impl TrackerConfig for Checked {
    fn facts(&self) -> Facts {
        Facts::RESPONSES
    }

    fn start(&self, _: &RunContext<'_>, frame: &Frame, region: &Region) -> StartResult {
        if !region.is_finite() {
            return Err(TrackerError::no_region("kcf"));
        }
        self.follower((frame.width(), frame.height()), region).start(frame, region)
    }

    fn resume(&self, saved: &[u8]) -> Option<Box<dyn Tracker>> {
        let memory: Memory = saved::from_bytes(saved)?;
        // As far away as regions may be; false for NaN.
        let is_near = |(x, y): (f64, f64)| x.abs().max(y.abs()) <= 1e15 && !(x + y).is_nan();
        let is_place = memory.region.corners().into_iter().all(is_near) && is_near(memory.moved);
        let is_frame = |side: usize| (1..=MAX_SIDE as usize).contains(&side);
        let is_scale = memory.scale.is_finite() && memory.scale > 0.0;
        let Rect { w, h, .. } = memory.region.bounds();
        let has_area = w > 0.0 && h > 0.0;
        if !is_place || !has_area || !is_scale || !is_frame(memory.frame.0) || !is_frame(memory.frame.1) {
            return None;
        }
        let mut follower = self.follower(memory.frame, &memory.region);
        (follower.place.moved, follower.place.scale) = (memory.moved, memory.scale);
        let fits = follower.filter.remember(&memory.filter);
        fits.then(|| Box::new(follower) as Box<dyn Tracker>)
    }
}

/// Saved state of a running tracker.
#[derive(Serialize, Deserialize)]
struct Memory {
    /// Size of the first frame, and the region in it.
    frame: (usize, usize),
    region: Region,
    moved: (f64, f64),
    scale: f64,
    filter: FilterMemory,
}

impl Checked {
    /// Target in a first frame of this size, with an untrained filter.
    fn follower(&self, frame: (usize, usize), region: &Region) -> Follower<KcfLook> {
        let place = Place::new(region, frame, self.template == 0);
        let (w, h) = place.sides;
        let (cell, channels, ring) = match self.features {
            // The ring of cells around the others is for the gradients.
            Features::Hog => (self.cell, CHANNELS, 2),
            Features::Gray => (1, 1, 0),
        };
        let mut ratio = 1.0;
        let (size, cells, mean);
        if self.template > 0 {
            ratio = self.window * w.max(h) / self.template as f64;
            let even = |side: f64| 2 * ((self.window * side / ratio) as usize / (2 * cell)).max(2);
            cells = (even(w), even(h));
            size = ((cells.0 + ring) * cell, (cells.1 + ring) * cell);
            mean = ((cells.0 * cells.1) as f64).sqrt() / self.window;
        } else {
            let pixels = |side: f64| ((self.window * side) as usize).max(3 * cell);
            size = (pixels(w), pixels(h));
            cells = (size.0 / cell, size.1 / cell);
            mean = (w * h).sqrt() / cell as f64;
        }
        let &Self { kernel_width, lambda, rate, update, .. } = self;
        let settings = Settings { label_width: self.label_width * mean, kernel_width, lambda, rate, update };
        let step = self.scale_step;
        let search = Search {
            steps: if step > 1.0 { vec![1.0, 1.0 / step, step] } else { vec![1.0] },
            weight: self.scale_weight as f32,
            smaller_ends: true,
            sub_cell: self.sub_cell,
            tolerance: 1e-9,
            response: self.response,
        };
        let look = KcfLook {
            params: self.clone(),
            frame,
            region: region.clone(),
            size,
            ratio,
            hog: Hog::default(),
            cells: Vec::new(),
        };
        Follower::new(place, look, KernelFilter::new(cells.0, cells.1, channels, settings), search)
    }
}

/// Window of the tracker around the target.
#[derive(Clone)]
struct KcfLook {
    params: Checked,
    /// Size of the first frame, and the region in it.
    frame: (usize, usize),
    region: Region,
    /// Columns and rows of the window. The side of one of them, in pixels of the halved frame at scale 1,
    /// follows.
    size: (usize, usize),
    ratio: f64,
    hog: Hog,
    cells: Vec<f32>,
}

impl Look for KcfLook {
    fn look(&mut self, place: &Place, frame: &Frame, step: f64, features: &mut Vec<f32>) {
        let (p, scale, factor) = (&self.params, place.scale * step, place.factor());
        let (cx, cy) = place.first.center();
        let (cx, cy) = ((cx + place.moved.0) / factor, (cy + place.moved.1) / factor);
        let hog = p.features == Features::Hog;
        let colors = if p.color && hog { Colors::Rgb } else { Colors::Gray };
        let (w, h) = self.size;
        let mut patch = if p.template == 0 && p.scale_step <= 1.0 {
            let start = |c: f64, n: usize| c.floor() as i64 + 1 - (n / 2) as i64;
            Patch::cut(frame, &Window { x: start(cx, w), y: start(cy, h), w, h }, colors)
        } else {
            p.sampling.patch(frame, (cx, cy), (w, h), self.ratio * scale, colors)
        };
        patch.scale(1.0 / 255.0);
        features.clear();
        if !hog {
            let mean = patch.values.iter().map(|&v| f64::from(v)).sum::<f64>() / patch.values.len() as f64;
            features.extend(patch.values.iter().map(|v| v - mean as f32));
            return;
        }
        if p.template == 0 {
            self.hog.compute(&patch, p.cell, features);
            return;
        }
        let (columns, rows) = self.hog.compute(&patch, p.cell, &mut self.cells);
        for channel in self.cells.chunks_exact(columns * rows) {
            for row in channel.chunks_exact(columns).skip(1).take(rows - 2) {
                features.extend_from_slice(&row[1..columns - 1]);
            }
        }
    }

    fn cell_side(&self, place: &Place, step: f64) -> f64 {
        let cell = if self.params.features == Features::Hog { self.params.cell as f64 } else { 1.0 };
        cell * self.ratio * (place.scale * step) * place.factor()
    }

    fn region(&self, place: &Place) -> Region {
        if self.params.scale_step <= 1.0 {
            return self.region.shifted(place.moved.0, place.moved.1);
        }
        Region::Rect(place.rect())
    }

    fn save(&self, place: &Place, filter: &KernelFilter) -> Option<Vec<u8>> {
        let (frame, region) = (self.frame, self.region.clone());
        let (moved, scale, filter) = (place.moved, place.scale, filter.memory());
        saved::to_bytes(&Memory { frame, region, moved, scale, filter })
    }
}

#[cfg(test)]
mod tests;
