//! DSST (Danelljan, Häger, Khan and Felsberg, "Accurate scale estimation for robust visual tracking", BMVC 2014):
//! one correlation filter finds the target's place, a second one its scale.
//!
//! ```text
//! A_l <- (1 - r) A_l + r conj(Y) X_l        B <- (1 - r) B + r sum_l |X_l|^2                     eq. 4
//! f(z) = F^-1( sum_l conj(A_l) Z_l / (B + lambda) ),   its peak is the target                    eq. 5 and 6
//! ```
//!
//! `X_l` is the Fourier transform of channel `l` of a sample times a Hann window, `Y` that of a Gaussian label.
//!
//! - *Place*: samples are windows of twice the target's size, at the present scale, resized to that at scale 1; 28
//!   channels: gray `/ 255 - 0.5` and the first 27 of [`crate::image::hog`] with cells of one pixel (strongest color). The
//!   label has the deviation `label_width` times the root of the target's area. The place moves by the peak's shift
//!   times the scale, rounded to whole pixels.
//! - *Scale*: at the new place, 33 samples of the target itself at 1.02^16 ... 1.02^-16 times the present scale, all
//!   resized to at most 512 square pixels; channels are their 31 features of all cells of 4 pixels, and the filter runs over
//!   the 33 scales, with a label of deviation `scale_label_width * sqrt(33)` steps around the 17th.
//!
//! Afterwards both filters learn at the new place and scale. Sizes are whole pixels: the window begins at
//! `pixel + 1 - floor(w / 2)`; `pixel` is that of the center. From the source: everything above, all defaults, and
//! the limits of the scale (the window keeps 5 pixels, the target fits into the frame). A quadrilateral starts as an
//! upright rectangle with its center, the sides' ratio of its bounds and its own area, as in the VOT2014 entry.
//!
//! Deviations: the region is the first rectangle scaled and moved, without the release's rounding to whole pixels, which
//! moves boxes with odd sides by half a pixel. `start = "vot2014"` starts in the pixel in which the entry did, which
//! read coordinates of VOT as counted from 1, and with the pixel that it adds to each side of a quadrilateral. Patches
//! shrink bilinearly like the entry's; the release takes means of areas. For safety: windows are
//! at most 512 x 512 pixels in area (larger targets start at a scale above 1) and 4 x 4 pixels or more; the target stays
//! in touch with the frame; the lower limit does not enlarge a target that starts below it; a scale sample has at least
//! one cell.
//!
//! The response map of the place is reported in numbers and, as a density, as the posterior of the center
//! `[x, y]` in pixels: see `tracker/correlation/response.rs`. Its cells are the pixels of the window, times
//! the scale. That of the first frame is the response to the sample that the filter has just learned.
//!
//! Checked against a separate NumPy version of this description: on gymnastics of VOT2014 one pixel of the start decides.
//! From the annotated start and from one pixel right, left, below and above, this one fails 5, 2, 4, 5 and 5 times, that
//! one 1 (5 when it shrinks by means of areas, as OpenCV does), 2, 4, 5 and 5 times; on Couple of OTB both have a
//! precision of 0.107.

mod start;

use super::correlation::response::{MapOptions, ResponseMap};
use super::correlation::{Peak, label, peak};
use crate::image::Window;
use crate::image::hog::{CHANNELS, Hog};
use crate::image::patch::{Colors, Patch, is_gray};
use crate::num::fourier::{Complexes, Fourier, LANES, Lanes, ZEROS, hann, hann_plane};
use crate::tracker::prelude::*;
use start::{Start, upright};

/// Number of gradient channels in the samples of the place.
const GRADIENTS: usize = 27;
/// Side of a cell in the samples of the scale.
const CELL: usize = 4;
/// Largest area of the window, in square pixels.
const MAX_WINDOW_AREA: f64 = 262_144.0;

/// Parameters of the tracker.
#[derive(Debug, Clone, SmartDefault, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Params {
    /// Side of the window in multiples of the target's side, from 1 to 6.
    #[default(2.0)]
    pub window: f64,
    /// Regularization of both filters, from 1e-6 to 100.
    #[default(0.01)]
    pub lambda: f64,
    /// Share of the newest sample, 0 to 1.
    #[default(0.025)]
    pub rate: f64,
    /// Standard deviation of the place's label in multiples of the target's mean side, from 0.01 to 1.
    #[default(1.0 / 16.0)]
    pub label_width: f64,
    /// Number of scales, odd, from 1 (fixed size) to 99.
    #[default(33)]
    pub scales: usize,
    /// Ratio of two neighboring scales, from 1.001 to 1.2.
    #[default(1.02)]
    pub scale_step: f64,
    /// Standard deviation of the scale's label in multiples of the root of `scales`, from 0.01 to 2.
    #[default(0.25)]
    pub scale_label_width: f64,
    /// Largest area of a scale's sample, in square pixels, from 16 to 10000.
    #[default(512.0)]
    pub scale_area: f64,
    /// Rule that rounds the first region to whole pixels: `release` or `vot2014`.
    #[default(Start::Release)]
    pub start: Start,
    /// Options for reading the place's response map.
    pub response: MapOptions,
}

impl PlainParams for Params {
    const RANGES: &'static [Range] = &[
        Range::within("window", 1.0, 6.0),
        Range::within("lambda", 1e-6, 100.0),
        Range::within("rate", 0.0, 1.0),
        Range::within("label_width", 0.01, 1.0),
        Range::within("scale_step", 1.001, 1.2),
        Range::within("scale_label_width", 0.01, 2.0),
        Range::within("scale_area", 16.0, 10_000.0),
        Range::within("scales", 1.0, 99.0),
        MapOptions::NEIGHBORHOOD,
        MapOptions::THRESHOLD,
    ];

    fn check(&self) -> Result<(), ParamError> {
        ParamError::unless(self.scales % 2 == 1, "scales", "odd and from 1 to 99", self.scales)
    }
}

/// DSST in the list of trackers.
pub const ENTRY: Entry<dyn TrackerConfig> =
    Entry::of::<Params>("dsst", 4, "correlation filters for the place and for the scale");

impl TrackerConfig for Params {
    fn facts(&self) -> Facts {
        Facts::RESPONSES
    }

    fn start(&self, _: &RunContext<'_>, frame: &Frame, region: &Region) -> StartResult {
        let first = upright(region);
        if ![first.x, first.y, first.w, first.h].iter().all(|v| v.is_finite()) {
            return Err(TrackerError::no_region("dsst"));
        }
        let mut target = Target::new(self, frame, region);
        target.learn(self, frame);
        target.respond(self);
        let state = target.map.describe(&self.response, TrackerState::initialized(region.clone()));
        Ok((Box::new(Tracking { params: self.clone(), target }), state))
    }
}

#[derive(Clone)]
struct Tracking {
    params: Params,
    target: Target,
}

/// Target with its model.
#[derive(Clone)]
struct Target {
    /// Rectangle of the first region.
    first: Rect,
    first_scale: f64,
    scale: f64,
    /// Pixel of the center, and the offset of the center from the pixel's left top corner.
    pixel: (i64, i64),
    offset: (f64, f64),
    colors: Colors,
    /// Size of the target at scale 1 in whole pixels; sizes of the window and of the scale's samples follow.
    base: (usize, usize),
    size: (usize, usize),
    sample: (usize, usize),
    place: Filter,
    /// Response of the place in the newest frame.
    map: ResponseMap,
    scales: Filter,
    hog: Hog,
    look: Look,
    /// Scale's sample times the window, four lines side by side: value `s` of group `g` is at `g * scales +
    /// s`.
    lines: Vec<Lanes>,
    cells: Vec<f32>,
}

/// Sample of the place times the window: gray values, and the single gradient of each pixel. Rows are four
/// side by side.
#[derive(Clone, Default)]
struct Look {
    window: Vec<Lanes>,
    gray: Vec<Lanes>,
    gradients: Vec<Lanes>,
    orientations: Vec<[i32; LANES]>,
}

impl Look {
    /// Four values of a channel.
    #[inline(always)]
    fn value(&self, channel: usize, at: usize) -> Lanes {
        let Some(channel) = channel.checked_sub(1) else { return self.gray[at] };
        // Unsigned orientations stand for two signed ones.
        let channel = channel as i32;
        let (one, other) = if channel < 18 { (channel, channel) } else { (channel - 18, channel - 9) };
        let (v, b) = (self.gradients[at].0, self.orientations[at]);
        Lanes(std::array::from_fn(|l| {
            let has = u32::from((b[l] == one) | (b[l] == other));
            f32::from_bits(v[l].to_bits() & has.wrapping_neg())
        }))
    }
}

impl Target {
    fn new(p: &Params, frame: &Frame, region: &Region) -> Self {
        let first = upright(region);
        let (width, height) = (frame.width() as f64, frame.height() as f64);
        let (pixel, more) = p.start.pixel(region, &first);
        let (w, h) = ((first.w + more).clamp(1.0, width), (first.h + more).clamp(1.0, height));
        let first_scale = (p.window * (w * h / MAX_WINDOW_AREA).sqrt()).max(1.0);
        let whole = |side: f64| (side / first_scale).round().max(1.0);
        let base = (whole(w), whole(h));
        let size = ((p.window * base.0) as usize, (p.window * base.1) as usize);
        let size = (size.0.max(4), size.1.max(4));
        let shrink = (p.scale_area / (base.0 * base.1)).sqrt().min(1.0);
        let sample = ((base.0 * shrink) as usize, (base.1 * shrink) as usize);
        let sample = (sample.0.max(CELL), sample.1.max(CELL));
        let (cx, cy) = first.center();
        let sigma = p.label_width * (base.0 * base.1).sqrt();
        let place = label(size.0, size.1, sigma);
        let deviation = p.scale_label_width * (p.scales as f64).sqrt();
        let scales = (0..p.scales).map(|s| (s as f64 - (p.scales / 2) as f64) / deviation);
        let scales: Vec<f32> = scales.map(|d| (-0.5 * d * d).exp() as f32).collect();
        let lines = CHANNELS * (sample.0 / CELL) * (sample.1 / CELL);
        let fourier = Fourier::new(size.0, size.1);
        let window = fourier.side_by_side(&hann_plane(size.0, size.1)).into_iter().map(Lanes).collect();
        Self {
            first,
            first_scale,
            scale: first_scale,
            pixel: (pixel.0 as i64, pixel.1 as i64),
            offset: (cx - pixel.0, cy - pixel.1),
            colors: if is_gray(frame) { Colors::Gray } else { Colors::Rgb },
            base: (base.0 as usize, base.1 as usize),
            size,
            sample,
            place: Filter::new(fourier, &place, 1 + GRADIENTS),
            map: ResponseMap::new(size.0, size.1),
            scales: Filter::new(Fourier::new(p.scales, 1), &scales, lines),
            hog: Hog::default(),
            look: Look { window, ..Look::default() },
            lines: vec![Lanes::ZERO; lines.div_ceil(LANES) * p.scales],
            cells: Vec::new(),
        }
    }

    /// Window of this size around the target. The frame's border is repeated.
    fn window(&self, size: (usize, usize), scale: f64) -> Window {
        let side = |n: usize| ((n as f64 * scale) as usize).max(1);
        let (w, h) = (side(size.0), side(size.1));
        Window { x: self.pixel.0 + 1 - (w / 2) as i64, y: self.pixel.1 + 1 - (h / 2) as i64, w, h }
    }

    /// Computes `look`, the sample of the place.
    fn look(&mut self, frame: &Frame) {
        let window = self.window(self.size, self.scale);
        let mut patch = Patch::resized(frame, &window, self.size.0, self.size.1, self.colors);
        patch.round();
        let n = self.size.0 * self.size.1;
        let planes: Vec<&[f32]> = patch.values.chunks_exact(n).collect();
        let gray: Vec<f32> = match planes[..] {
            [r, g, b] => {
                let mixed = r.iter().zip(g).zip(b).map(|((r, g), b)| 0.2989 * r + 0.5870 * g + 0.1140 * b);
                mixed.map(|v| (v + 0.5).floor() / 255.0 - 0.5).collect()
            }
            _ => patch.values.iter().map(|v| v / 255.0 - 0.5).collect(),
        };
        let (mut orientations, mut gradients) = (Vec::new(), Vec::new());
        self.hog.pixels(&patch, &mut orientations, &mut gradients);
        let Self { look, place, .. } = self;
        let window = &look.window;
        let windowed = |plane: &[f32]| -> Vec<Lanes> {
            place.fourier.side_by_side(plane).into_iter().zip(window).map(|(v, w)| Lanes(v) * *w).collect()
        };
        (look.gray, look.gradients) = (windowed(&gray), windowed(&gradients));
        look.orientations = place.fourier.side_by_side(&orientations);
    }

    /// Computes `lines`, the samples of the scale: a line over the scales for each feature.
    fn look_at_scales(&mut self, p: &Params, frame: &Frame) {
        for (s, weight) in hann(p.scales).into_iter().enumerate() {
            let factor = p.scale_step.powi((p.scales / 2) as i32 - s as i32);
            let window = self.window(self.base, self.scale * factor);
            let mut patch = Patch::resized(frame, &window, self.sample.0, self.sample.1, self.colors);
            patch.round();
            self.hog.compute(&patch, CELL, &mut self.cells);
            let lines = self.lines[s..].iter_mut().step_by(p.scales);
            for (line, four) in lines.zip(self.cells.chunks(LANES)) {
                line.0[..four.len()].copy_from_slice(four);
                *line *= Lanes::splat(weight);
            }
        }
    }

    /// Sets `map` to the response to `look` and returns its peak.
    fn respond(&mut self, p: &Params) -> Peak {
        let (look, width) = (&self.look, self.size.0);
        let value = |channel, group, x| look.value(channel, group * width + x);
        let shift = peak(self.place.respond(value, p.lambda), self.size.0, self.size.1);
        self.map.take(&mut self.place.plane, shift, self.scale);
        shift
    }

    /// Finds the place, then the scale.
    fn follow(&mut self, p: &Params, frame: &Frame) {
        self.look(frame);
        let shift = self.respond(p);
        let step = |d: i64| (d as f64 * self.scale).round() as i64;
        self.pixel = (self.pixel.0 + step(shift.x), self.pixel.1 + step(shift.y));
        self.keep_inside(frame);
        if p.scales == 1 {
            return;
        }
        self.look_at_scales(p, frame);
        let lines = &self.lines;
        let response = self.scales.respond(|pass, _, x| lines[pass * p.scales + x], p.lambda);
        let best = peak(response, p.scales, 1).x.rem_euclid(p.scales as i64) as i32;
        self.scale *= p.scale_step.powi((p.scales / 2) as i32 - best);
        let steps = |ratio: f64| ratio.ln() / p.scale_step.ln();
        let least = (5.0 / self.size.0 as f64).max(5.0 / self.size.1 as f64);
        let most =
            (frame.width() as f64 / self.base.0 as f64).min(frame.height() as f64 / self.base.1 as f64);
        let least = p.scale_step.powf(steps(least).ceil()).min(self.first_scale);
        self.scale = self.scale.max(least).min(p.scale_step.powf(steps(most).floor()));
    }

    /// Clamps the target so that it overlaps the frame.
    fn keep_inside(&mut self, frame: &Frame) {
        let touch = |pixel: i64, side: usize, room: usize| {
            let reach = (0.5 * (side as f64 * self.scale).min(room as f64)) as i64;
            pixel.clamp(-reach, room as i64 + reach)
        };
        self.pixel = (
            touch(self.pixel.0, self.base.0, frame.width()),
            touch(self.pixel.1, self.base.1, frame.height()),
        );
    }

    fn learn(&mut self, p: &Params, frame: &Frame) {
        self.look(frame);
        let (look, width) = (&self.look, self.size.0);
        self.place.learn(|channel, group, x| look.value(channel, group * width + x), p.rate);
        if p.scales > 1 {
            self.look_at_scales(p, frame);
            let lines = &self.lines;
            self.scales.learn(|pass, _, x| lines[pass * p.scales + x], p.rate);
        }
    }

    fn rect(&self) -> Rect {
        let ratio = self.scale / self.first_scale;
        let (w, h) = (self.first.w * ratio, self.first.h * ratio);
        let (cx, cy) = (self.pixel.0 as f64 + self.offset.0, self.pixel.1 as f64 + self.offset.1);
        Rect::new(cx - 0.5 * w, cy - 0.5 * h, w, h)
    }
}

/// A multi-channel correlation filter over a plane or, with one row, a line.
///
/// Samples are given as `value(pass, group, x)`, already times the window: four values at a time, in column
/// `x`. A pass is a channel of a plane with its rows `4 group ... 4 group + 3`, or four channels of lines.
#[derive(Clone)]
struct Filter {
    fourier: Fourier,
    label: Vec<Complexes>,
    /// Numerator `conj(A_l)`, channel by channel; the denominator `B` follows.
    numerator: Vec<Complexes>,
    denominator: Vec<Lanes>,
    taught: bool,
    sum: Vec<Complexes>,
    squares: Vec<Lanes>,
    plane: Vec<f32>,
}

impl Filter {
    fn new(mut fourier: Fourier, label: &[f32], channels: usize) -> Self {
        let n = fourier.spectrum_len();
        Self {
            label: fourier.forward(label).to_vec(),
            numerator: vec![ZEROS; channels * n],
            denominator: vec![Lanes::ZERO; n],
            taught: false,
            sum: vec![ZEROS; n],
            squares: vec![Lanes::ZERO; n],
            plane: vec![0.0; fourier.plane_len()],
            fourier,
        }
    }

    /// Number of coefficients of the channels in a pass.
    fn pass_len(&self) -> usize {
        self.sum.len() * if self.fourier.height() == 1 { LANES } else { 1 }
    }

    /// Response to a sample.
    fn respond(&mut self, value: impl Fn(usize, usize, usize) -> Lanes, lambda: f64) -> &[f32] {
        let (m, pass_len) = (self.sum.len(), self.pass_len());
        self.sum.fill(ZEROS);
        for (pass, numerators) in self.numerator.chunks(pass_len).enumerate() {
            let spectra = self.fourier.forward_groups(|group, x| value(pass, group, x));
            for (numerator, spectrum) in numerators.chunks_exact(m).zip(spectra.chunks_exact(m)) {
                let filter = numerator.chunks_exact(2).zip(spectrum.chunks_exact(2));
                for (s, (a, z)) in self.sum.chunks_exact_mut(2).zip(filter) {
                    for i in [0, 1] {
                        s[i] = s[i] + a[i] * z[i];
                    }
                }
            }
        }
        let lambda = Lanes::splat(lambda as f32);
        self.sum.iter_mut().zip(&self.denominator).for_each(|(s, b)| *s = *s / (*b + lambda));
        self.fourier.backward(&self.sum, &mut self.plane);
        &self.plane
    }

    /// Blends in a sample. The first one sets the filter.
    fn learn(&mut self, value: impl Fn(usize, usize, usize) -> Lanes, rate: f64) {
        let (m, pass_len) = (self.sum.len(), self.pass_len());
        let rate = Lanes::splat(if self.taught { rate as f32 } else { 1.0 });
        self.taught = true;
        self.squares.fill(Lanes::ZERO);
        for (pass, numerators) in self.numerator.chunks_mut(pass_len).enumerate() {
            let spectra = self.fourier.forward_groups(|group, x| value(pass, group, x));
            for (numerator, spectrum) in numerators.chunks_exact_mut(m).zip(spectra.chunks_exact(m)) {
                let sample = spectrum.chunks_exact(2).zip(self.label.chunks_exact(2));
                let filter = numerator.chunks_exact_mut(2).zip(self.squares.chunks_exact_mut(2));
                for ((a, s), (x, y)) in filter.zip(sample) {
                    for i in [0, 1] {
                        a[i] = a[i] + (y[i] * x[i].conj() - a[i]) * rate;
                        s[i] += x[i].norm_sqr();
                    }
                }
            }
        }
        self.denominator.iter_mut().zip(&self.squares).for_each(|(b, s)| *b += (*s - *b) * rate);
    }
}

impl Tracker for Tracking {
    fn update(&mut self, frame: &Frame) -> Result<TrackerState, TrackerError> {
        let target = &mut self.target;
        target.follow(&self.params, frame);
        target.learn(&self.params, frame);
        let state = TrackerState::tracked(Region::Rect(target.rect()));
        Ok(target.map.describe(&self.params.response, state))
    }

    fn fork(&self, _seed: Option<u64>) -> Option<Box<dyn Tracker>> {
        Some(Box::new(self.clone()))
    }
}

#[cfg(test)]
mod tests;
