//! KCF (Henriques, Caseiro, Martins and Batista, "High-speed tracking with kernelized correlation filters",
//! PAMI 37(3), 2015): a kernel ridge regression over all cyclic shifts of a window around the target.
//!
//! The filter and its equations are in `tracker/correlation.rs`. In every frame the filter responds to the window at
//! the last place, the target moves by the shift of the highest response times the side of a cell, and the filter
//! learns the window at the new place.
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
//! The response map of the scale that won, without `scale_weight`, is answered in numbers and, as a density, as the
//! posterior of the center `[x, y]` in pixels: see `tracker/correlation/response.rs`. That of the first frame is
//! the response to the window that the filter has just learned; that of a window without contrast is 0.

mod sampling;

use super::correlation::response::{MapOptions, ResponseMap};
use super::correlation::{FilterMemory, KernelFilter, Settings, Update, halvings, reduced};
use super::{RunContext, StartResult, Tracker, TrackerConfig, TrackerError, TrackerState};
use crate::image::hog::{CHANNELS, Hog};
use crate::image::patch::{Colors, Patch};
use crate::image::{Frame, MAX_SIDE, Window};
use crate::plugin::{Entry, ParamError, Plugin, Range, show_params};
use crate::region::{Rect, Region};
use crate::saved;
use sampling::Sampling;
use serde::{Deserialize, Serialize};

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

/// Parameters; the preset supplies those that are left out.
#[derive(Debug, Clone, Default, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Params {
    /// Source of the defaults.
    pub preset: Preset,
    /// Features of the filter; `hog`.
    pub features: Features,
    /// Side of a cell of `hog` in pixels, from 1 to 16; 4.
    pub cell: Option<usize>,
    /// Takes gradients of the strongest color instead of gray; `vot` does.
    pub color: Option<bool>,
    /// Side of the window in multiples of the target's, from 1 to 6; 2.5.
    pub window: Option<f64>,
    /// Longer side of the window in pixels, from 16 to 512, to which it is resized; 0 leaves it as it is. `tpami` 0,
    /// `vot` 96.
    pub template: Option<usize>,
    /// How a resized window is read from the frame; `whole-pixels`, or `exact` or `area`.
    pub sampling: Option<Sampling>,
    /// Deviation of the label in multiples of the target's mean side, from 0.01 to 1; `tpami` 0.1, `vot` 0.125.
    pub label_width: Option<f64>,
    /// Deviation `sigma` of the kernel, from 0.01 to 10; `tpami` 0.5 (`grey` 0.2), `vot` 0.6.
    pub kernel_width: Option<f64>,
    /// Regularization, from 1e-6 to 1; 1e-4.
    pub lambda: Option<f64>,
    /// Share of the newest look, 0 to 1; `tpami` 0.02 (`grey` 0.075), `vot` 0.012.
    pub rate: Option<f64>,
    /// How the newest look is blended in; `tpami` `linear`, `vot` `fraction`.
    pub update: Option<Update>,
    /// Ratio of two of the three scales, from 1 (no other scales) to 1.5; `tpami` 1, `vot` 1.05.
    pub scale_step: Option<f64>,
    /// Factor of the responses at the other two scales, from 0 to 1; 0.95.
    pub scale_weight: Option<f64>,
    /// Finds the peak between the cells; `vot` does.
    pub sub_cell: Option<bool>,
    /// How the response map is read.
    pub response: MapOptions,
}

/// Checked parameters with all defaults filled in.
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

#[derive(Debug, Clone)]
struct Kcf(Checked);

impl Checked {
    /// The parameters, with what the preset supplies.
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

impl Plugin for Kcf {
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
        let c = Checked::of(&p);
        if (1..16).contains(&c.template) {
            return Err(ParamError::out_of_range("template", "0 or from 16 to 512", c.template));
        }
        Ok(Self(c))
    }

    fn shown(p: &Params) -> serde_json::Value {
        show_params(&Checked::of(p))
    }
}

/// The list's line.
pub const ENTRY: Entry<dyn TrackerConfig> =
    Entry::of::<Kcf>("kcf", 4, "kernelized correlation filter on oriented gradients or gray values");

impl TrackerConfig for Kcf {
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
            return Err(TrackerError::no_region("kcf"));
        }
        let p = &self.0;
        let mut target = Target::new(p, (frame.width(), frame.height()), region);
        target.look(p, &reduced(frame, target.halvings), 1.0);
        target.filter.learn(&target.features);
        let cell = target.cell_side(p, 1.0);
        target.filter.fill(&mut target.map, &target.features, cell);
        let state = target.map.describe(&p.response, TrackerState::initialized(region.clone()));
        Ok((Box::new(Tracking { params: p.clone(), target }), state))
    }

    fn resume(&self, saved: &[u8]) -> Option<Box<dyn Tracker>> {
        let memory: Memory = saved::from_bytes(saved)?;
        // As far away as regions may be; false for NaN.
        let is_near = |(x, y): (f64, f64)| x.abs().max(y.abs()) <= 1e15 && !(x + y).is_nan();
        let is_place = memory.region.corners().into_iter().all(is_near) && is_near(memory.moved);
        let is_frame = |side: usize| (1..=MAX_SIDE as usize).contains(&side);
        let is_scale = memory.scale.is_finite() && memory.scale > 0.0;
        if !is_place || !is_scale || !is_frame(memory.frame.0) || !is_frame(memory.frame.1) {
            return None;
        }
        let mut target = Target::new(&self.0, memory.frame, &memory.region);
        (target.moved, target.scale) = (memory.moved, memory.scale);
        let fits = target.filter.remember(&memory.filter);
        fits.then(|| Box::new(Tracking { params: self.0.clone(), target }) as Box<dyn Tracker>)
    }
}

#[derive(Clone)]
struct Tracking {
    params: Checked,
    target: Target,
}

/// Memory of a tracker at work.
#[derive(Serialize, Deserialize)]
struct Memory {
    /// Sides of the first frame, and the region in it.
    frame: (usize, usize),
    region: Region,
    moved: (f64, f64),
    scale: f64,
    filter: FilterMemory,
}

/// The target and its model.
#[derive(Clone)]
struct Target {
    /// Sides of the first frame, and the region in it.
    frame: (usize, usize),
    region: Region,
    /// The region's upright rectangle and how far it has moved since, in pixels of the frame.
    first: Rect,
    moved: (f64, f64),
    scale: f64,
    /// Number of times that frames are halved.
    halvings: u32,
    /// Columns and rows of the window, and how many pixels of the halved frame one of them is at scale 1.
    size: (usize, usize),
    ratio: f64,
    filter: KernelFilter,
    /// The highest response of the newest frame.
    map: ResponseMap,
    hog: Hog,
    features: Vec<f32>,
    cells: Vec<f32>,
}

impl Target {
    fn new(p: &Checked, frame: (usize, usize), region: &Region) -> Self {
        let first = region.bounds();
        let (width, height) = (frame.0 as f64, frame.1 as f64);
        let (w, h) = (first.w.clamp(1.0, width), first.h.clamp(1.0, height));
        let cell = if p.features == Features::Hog { p.cell } else { 1 };
        let (mut times, mut ratio) = (0, 1.0);
        let (size, cells, mean);
        if p.template > 0 {
            ratio = p.window * w.max(h) / p.template as f64;
            // The ring of cells around the others is for the gradients.
            let ring = if p.features == Features::Hog { 2 } else { 0 };
            let even = |side: f64| 2 * ((p.window * side / ratio) as usize / (2 * cell)).max(2);
            cells = (even(w), even(h));
            size = ((cells.0 + ring) * cell, (cells.1 + ring) * cell);
            mean = ((cells.0 * cells.1) as f64).sqrt() / p.window;
        } else {
            times = halvings((w * h).sqrt());
            let factor = f64::from(1_u32 << times);
            let reduced = |side: f64| if times > 0 { (side / factor).floor().max(1.0) } else { side };
            let pixels = |side: f64| ((p.window * reduced(side)) as usize).max(3 * cell);
            size = (pixels(w), pixels(h));
            cells = (size.0 / cell, size.1 / cell);
            mean = (reduced(w) * reduced(h)).sqrt() / cell as f64;
        }
        let settings = Settings {
            label_width: p.label_width * mean,
            kernel_width: p.kernel_width,
            lambda: p.lambda,
            rate: p.rate,
            update: p.update,
        };
        let channels = if p.features == Features::Hog { CHANNELS } else { 1 };
        Self {
            frame,
            region: region.clone(),
            first,
            moved: (0.0, 0.0),
            scale: 1.0,
            halvings: times,
            size,
            ratio,
            filter: KernelFilter::new(cells.0, cells.1, channels, settings),
            map: ResponseMap::new(cells.0, cells.1),
            hog: Hog::default(),
            features: Vec::new(),
            cells: Vec::new(),
        }
    }

    /// Computes `features` of the window around the target at a scale.
    fn look(&mut self, p: &Checked, frame: &Frame, scale: f64) {
        let factor = f64::from(1_u32 << self.halvings);
        let (cx, cy) = self.first.center();
        let (cx, cy) = ((cx + self.moved.0) / factor, (cy + self.moved.1) / factor);
        let hog = p.features == Features::Hog;
        let colors = if p.color && hog { Colors::Rgb } else { Colors::Gray };
        let (w, h) = self.size;
        let mut patch = if self.ratio == 1.0 && scale == 1.0 {
            let start = |c: f64, n: usize| c.floor() as i64 + 1 - (n / 2) as i64;
            Patch::cut(frame, &Window { x: start(cx, w), y: start(cy, h), w, h }, colors)
        } else {
            p.sampling.patch(frame, (cx, cy), (w, h), self.ratio * scale, colors)
        };
        patch.scale(1.0 / 255.0);
        if !hog {
            let mean = patch.values.iter().map(|&v| f64::from(v)).sum::<f64>() / patch.values.len() as f64;
            self.features.clear();
            self.features.extend(patch.values.iter().map(|v| v - mean as f32));
            return;
        }
        let (columns, rows) = self.hog.compute(&patch, p.cell, CHANNELS, &mut self.cells);
        if p.template == 0 {
            std::mem::swap(&mut self.features, &mut self.cells);
            return;
        }
        self.features.clear();
        for channel in self.cells.chunks_exact(columns * rows) {
            for row in channel.chunks_exact(columns).skip(1).take(rows - 2) {
                self.features.extend_from_slice(&row[1..columns - 1]);
            }
        }
    }

    /// Side of a cell of a window at a scale, in pixels of the frame.
    fn cell_side(&self, p: &Checked, scale: f64) -> f64 {
        let cell = if p.features == Features::Hog { p.cell as f64 } else { 1.0 };
        cell * self.ratio * scale * f64::from(1_u32 << self.halvings)
    }

    /// Moves and scales by the highest response.
    fn follow(&mut self, p: &Checked, frame: &Frame) {
        let mut best: Option<(f32, f64, (f64, f64))> = None;
        let scales = if p.scale_step > 1.0 { vec![1.0, 1.0 / p.scale_step, p.scale_step] } else { vec![1.0] };
        for step in scales {
            self.look(p, frame, self.scale * step);
            let Some(peak) = self.filter.respond(&self.features) else { continue };
            let weight = if step == 1.0 { 1.0 } else { p.scale_weight as f32 };
            if best.is_none_or(|(value, ..)| weight * peak.value > value) {
                let shift =
                    if p.sub_cell { self.filter.refine(&peak) } else { (peak.x as f64, peak.y as f64) };
                best = Some((weight * peak.value, step, shift));
                let cell = self.cell_side(p, self.scale * step);
                self.filter.hand_over(peak, cell, &mut self.map);
                if step < 1.0 {
                    break;
                }
            }
        }
        let Some((_, step, (dx, dy))) = best else {
            self.map.clear(self.cell_side(p, self.scale));
            return;
        };
        self.scale *= step;
        let pixels = self.cell_side(p, self.scale);
        self.moved = (self.moved.0 + dx * pixels, self.moved.1 + dy * pixels);
    }

    /// Keeps the target in touch with a frame of `width` x `height` pixels.
    fn keep_inside(&mut self, width: f64, height: f64) {
        let Rect { w, h, .. } = self.first;
        if self.scale != 1.0 {
            let most = (width / w).min(height / h).max(1e-9);
            let least = (4.0 / w.min(h)).min(1.0).min(most);
            self.scale = self.scale.clamp(least, most);
        }
        let center = self.first.center();
        let touch = |c: f64, moved: f64, side: f64, room: f64| {
            let reach = 0.5 * side.min(room);
            (c + moved).clamp(-reach, room + reach) - c
        };
        let (x, y) = (self.moved.0, self.moved.1);
        let inside = (touch(center.0, x, w * self.scale, width), touch(center.1, y, h * self.scale, height));
        // Only coordinates that were outside change, so that moves by whole pixels stay exact.
        let keep =
            |old: f64, new: f64, c: f64| if (old - new).abs() > 1e-9 * c.abs().max(1.0) { new } else { old };
        self.moved = (keep(x, inside.0, center.0), keep(y, inside.1, center.1));
    }

    fn region(&self, p: &Checked) -> Region {
        if p.scale_step <= 1.0 {
            return self.region.shifted(self.moved.0, self.moved.1);
        }
        let (cx, cy) = self.first.center();
        let (w, h) = (self.first.w * self.scale, self.first.h * self.scale);
        Region::Rect(Rect::new(cx + self.moved.0 - 0.5 * w, cy + self.moved.1 - 0.5 * h, w, h))
    }
}

impl Tracker for Tracking {
    fn update(&mut self, frame: &Frame) -> Result<TrackerState, TrackerError> {
        let target = &mut self.target;
        let p = &self.params;
        let small = reduced(frame, target.halvings);
        target.follow(p, &small);
        target.keep_inside(frame.width() as f64, frame.height() as f64);
        target.look(p, &small, target.scale);
        target.filter.learn(&target.features);
        Ok(target.map.describe(&p.response, TrackerState::tracked(target.region(p))))
    }

    fn fork(&self, _seed: Option<u64>) -> Option<Box<dyn Tracker>> {
        Some(Box::new(self.clone()))
    }

    fn save(&self) -> Option<Vec<u8>> {
        let Target { frame, moved, scale, .. } = self.target;
        let (region, filter) = (self.target.region.clone(), self.target.filter.memory());
        saved::to_bytes(&Memory { frame, region, moved, scale, filter })
    }
}

#[cfg(test)]
mod tests;
