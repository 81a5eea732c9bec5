//! Normalized cross-correlation with a fixed gray template (Lewis 1995, "Fast normalized
//! cross-correlation", eq. 2): the simplest tracker that really looks at pixels.
//!
//! ```text
//!          n S_it - S_i S_t                        S_it = sum i(u) t(u), S_i = sum i(u), S_ii = sum i(u)^2
//! g = --------------------------------------------   over the n pixels u of the template
//!     sqrt((n S_ii - S_i^2) (n S_tt - S_t^2))
//! ```
//!
//! The highest `g` is the tracker's confidence; the first frame has no confidence.
//!
//! `t` is the target's window in the first frame, `i` the equally large window at a candidate place,
//! both in gray (`(77 R + 150 G + 29 B + 128) >> 8`, BT.601 in 1/256). `g` is in `[-1, 1]`, high is
//! good; a window without contrast has `g = 0`. The answer is the place of the highest `g` within
//! `search` of the last one; among equals the nearest, then the topmost, then the leftmost. Places are
//! whole pixels from the first window; those whose center leaves the frame are not considered, and
//! pixels beyond the border repeat it. The region keeps its size and shape and is moved as a whole.
//!
//! `S_it` comes from a Fourier transform, the window sums from integral images. All sums are integers
//! and the transform's are rounded back to them (their error is below 1e-3), so that the answer does
//! not depend on the processor.
//!
//! Deviations from the source: none. The search range is a choice of this benchmark; that there is neither scale nor
//! update of the template is as in the NCC baseline of the VOT challenges.

use crate::image::Window;
use crate::num::fourier::{Complex64, LineFourier};
use crate::tracker::prelude::*;

/// Parameters of the tracker.
#[derive(Debug, Clone, SmartDefault, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Params {
    /// Extent of the search beyond the target, in multiples of the target's mean side (root of the area): 1
    /// searches half a side in each direction. Above 0, at most 8.
    #[default(1.0)]
    pub search: f64,
}

impl PlainParams for Params {
    const RANGES: &'static [Range] = &[Range::of("search").above(0.0).at_most(8.0)];
}

/// NCC in the list of trackers.
pub const ENTRY: Entry<dyn TrackerConfig> =
    Entry::of::<Params>("ncc", 3, "normalized cross-correlation with a fixed gray template");

impl TrackerConfig for Params {
    fn facts(&self) -> Facts {
        Facts::BOXES
    }

    fn gives_confidence(&self, _: &RunContext<'_>) -> bool {
        true
    }

    fn start(&self, _: &RunContext<'_>, frame: &Frame, region: &Region) -> StartResult {
        Ok((Box::new(Target::new(self, frame, region)), TrackerState::initialized(region.clone())))
    }
}

/// The target and its model.
struct Target {
    region: Region,
    /// Window of the template in the first frame. Its shift since then, in pixels, follows.
    window: Window,
    moved: (i64, i64),
    /// Search radius in every direction, in pixels.
    radius: i64,
    correlator: Correlator,
}

impl Target {
    fn new(p: &Params, frame: &Frame, region: &Region) -> Self {
        let rect = region.rect();
        let (cx, cy) = rect.center();
        let mut window = Window::from_rect(&rect);
        // A window larger than the frame would only match the repeated border.
        let cut = |start: i64, len: usize, center: f64, room: usize| {
            if len <= room {
                (start, len)
            } else {
                ((center.clamp(-1e6, 1e6) - room as f64 / 2.0).round() as i64, room)
            }
        };
        (window.x, window.w) = cut(window.x, window.w, cx, frame.width());
        (window.y, window.h) = cut(window.y, window.h, cy, frame.height());
        let side = ((window.w * window.h) as f64).sqrt();
        let longest = frame.width().max(frame.height()) as f64;
        let radius = (0.5 * p.search * side).min(longest).max(2.0).round() as i64;
        let correlator = Correlator::new(&gray(frame, &window), window.w, window.h, radius as usize);
        Self { region: region.clone(), window, moved: (0, 0), radius, correlator }
    }
}

impl Tracker for Target {
    fn update(&mut self, frame: &Frame) -> Result<TrackerState, TrackerError> {
        let r = self.radius;
        let last = Window { x: self.window.x + self.moved.0, y: self.window.y + self.moved.1, ..self.window };
        let around =
            Window { x: last.x - r, y: last.y - r, w: last.w + 2 * r as usize, h: last.h + 2 * r as usize };
        let scores = self.correlator.scores(&gray(frame, &around));
        // Twice the center, to stay in whole numbers.
        let center = |d: i64, start: i64, len: usize| 2 * (start + d) + len as i64;
        let (width, height) = (frame.width() as i64, frame.height() as i64);
        let mut best: Option<(f64, i64, (i64, i64))> = None;
        for (row, dy) in scores.chunks_exact(2 * r as usize + 1).zip(-r..) {
            if !(0..=2 * height).contains(&center(dy, last.y, last.h)) {
                continue;
            }
            for (&g, dx) in row.iter().zip(-r..) {
                if !(0..=2 * width).contains(&center(dx, last.x, last.w)) {
                    continue;
                }
                let far = dx * dx + dy * dy;
                if best.is_none_or(|(b, d, _)| g > b || (g == b && far < d)) {
                    best = Some((g, far, (dx, dy)));
                }
            }
        }
        // A target that starts outside the frame has no place to go: it stays.
        if let Some((_, _, (dx, dy))) = best {
            self.moved = (self.moved.0 + dx, self.moved.1 + dy);
        }
        let region = self.region.shifted(self.moved.0 as f64, self.moved.1 as f64);
        Ok(TrackerState { confidence: best.map(|(g, ..)| g), ..TrackerState::tracked(region) })
    }
}

/// Gray values of a window. Beyond the frame its border is repeated.
fn gray(frame: &Frame, w: &Window) -> Vec<u8> {
    let places = (0..w.h as i64).flat_map(|j| (0..w.w as i64).map(move |i| (w.x + i, w.y + j)));
    let gray = |(x, y): (i64, i64)| {
        let [r, g, b] = frame.pixel_clamped(x, y).map(u32::from);
        ((77 * r + 150 * g + 29 * b + 128) >> 8) as u8
    };
    places.map(gray).collect()
}

/// Scores of a template over search areas of one size.
///
/// Both are stored by row with the width of the search area as stride. The correlation of planes then becomes
/// that of two lines: the template at `(dx, dy)` is the template at lag `dy * width + dx`.
struct Correlator {
    w: usize,
    h: usize,
    radius: usize,
    fourier: LineFourier,
    line: Vec<f64>,
    spectrum: Vec<Complex64>,
    /// Conjugate spectrum of the template, divided by the transform's length.
    template: Vec<Complex64>,
    sum: i64,
    energy: i64,
}

impl Correlator {
    /// Correlator with a template of `w` x `h` gray values, by row.
    fn new(template: &[u8], w: usize, h: usize, radius: usize) -> Self {
        let width = w + 2 * radius;
        let length = smooth(width * (h + 2 * radius));
        let mut fourier = LineFourier::new(length);
        let mut line = vec![0.0; length];
        let mut spectrum = vec![Complex64::default(); fourier.spectrum_len()];
        let (mut sum, mut energy) = (0, 0);
        for (row, line) in template.chunks_exact(w).zip(line.chunks_mut(width)) {
            for (&t, o) in row.iter().zip(line) {
                *o = centered(t);
                let t = *o as i64;
                sum += t;
                energy += t * t;
            }
        }
        fourier.forward(&mut line, &mut spectrum);
        let template = spectrum.iter().map(|s| s.conj() / length as f64).collect();
        Self { w, h, radius, fourier, line, spectrum, template, sum, energy }
    }

    /// NCC at each place, rows from the top, `2 radius + 1` in each direction. `area` has the gray values of
    /// the search area, by row.
    fn scores(&mut self, area: &[u8]) -> Vec<f64> {
        let width = self.w + 2 * self.radius;
        self.line.fill(0.0);
        for (o, &v) in self.line.iter_mut().zip(area) {
            *o = centered(v);
        }
        let (sums, squares) = integrals(area, width);
        self.fourier.forward(&mut self.line, &mut self.spectrum);
        for (s, t) in self.spectrum.iter_mut().zip(&self.template) {
            *s *= t;
        }
        self.fourier.backward(&mut self.spectrum, &mut self.line);

        let n = (self.w * self.h) as i64;
        let spread_t = n * self.energy - self.sum * self.sum;
        let side = 2 * self.radius + 1;
        let mut scores = Vec::with_capacity(side * side);
        for dy in 0..side {
            for dx in 0..side {
                let corner = |i: usize, j: usize| (dy + j) * (width + 1) + dx + i;
                let block = |v: &[i64]| {
                    v[corner(self.w, self.h)] + v[corner(0, 0)] - v[corner(self.w, 0)] - v[corner(0, self.h)]
                };
                let (sum, square) = (block(&sums), block(&squares));
                let spread_i = n * square - sum * sum;
                let product = self.line[dy * width + dx].round() as i64;
                let above = n * product - sum * self.sum;
                scores.push(if spread_i > 0 && spread_t > 0 {
                    above as f64 / ((spread_i as f64) * (spread_t as f64)).sqrt()
                } else {
                    0.0
                });
            }
        }
        scores
    }
}

/// Gray value centered around 0, which keeps sums small without changing the score.
fn centered(v: u8) -> f64 {
    f64::from(v) - 128.0
}

/// Integral images of the centered gray values and of their squares, with a leading row and column of zeros.
fn integrals(area: &[u8], width: usize) -> (Vec<i64>, Vec<i64>) {
    let height = area.len() / width;
    let mut sums = vec![0; (width + 1) * (height + 1)];
    let mut squares = sums.clone();
    for (j, row) in area.chunks_exact(width).enumerate() {
        let (mut sum, mut square) = (0_i64, 0_i64);
        for (i, &v) in row.iter().enumerate() {
            let v = i64::from(v) - 128;
            sum += v;
            square += v * v;
            let k = (j + 1) * (width + 1) + i + 1;
            sums[k] = sums[k - width - 1] + sum;
            squares[k] = squares[k - width - 1] + square;
        }
    }
    (sums, squares)
}

/// Least even number from `n` on without prime factors above 5, for which transforms are fast.
fn smooth(n: usize) -> usize {
    let is_smooth = |mut m: usize| {
        for p in [2, 3, 5] {
            while m.is_multiple_of(p) {
                m /= p;
            }
        }
        m == 1
    };
    let mut m = n + n % 2;
    while !is_smooth(m) {
        m += 2;
    }
    m
}

#[cfg(test)]
mod tests;
