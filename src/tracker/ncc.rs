//! Normalised cross-correlation with a fixed grey template (Lewis 1995, "Fast normalized
//! cross-correlation", eq. 2): the simplest tracker that really looks at pixels.
//!
//! ```text
//!          n S_it - S_i S_t                        S_it = sum i(u) t(u), S_i = sum i(u), S_ii = sum i(u)^2
//! g = --------------------------------------------   over the n pixels u of the template
//!     sqrt((n S_ii - S_i^2) (n S_tt - S_t^2))
//! ```
//!
//! `t` is the target's window in the first frame, `i` the equally large window at a candidate place,
//! both in grey (`(77 R + 150 G + 29 B + 128) >> 8`, BT.601 in 1/256). `g` is in `[-1, 1]`, high is
//! good; a window without contrast has `g = 0`. The answer is the place of the highest `g` within
//! `search` of the last one; among equals the nearest, then the topmost, then the leftmost. Places are
//! whole pixels from the first window; those whose centre leaves the frame are not considered, and
//! pixels beyond the border repeat it. The region keeps its size and shape and is moved as a whole.
//!
//! `S_it` comes from a Fourier transform, the window sums from integral images. All sums are integers
//! and the transform's are rounded back to them (their error is below 1e-3), so that the answer does
//! not depend on the processor.
//!
//! With `update_rate` above 0 the template follows: `t <- (1 - r) t + r i` after every frame, rounded to
//! whole grey levels where it is used. Deviations from the source: none; search range and update are
//! choices of this benchmark, after the NCC baseline of the VOT challenges, which has neither scale
//! nor update.

use super::{Setup, Start, State, Tracker, TrackerError};
use crate::image::{Frame, Window};
use crate::plugin::{Entry, ParamError, RawParams, read_params, show_params};
use crate::region::Region;
use realfft::num_complex::Complex;
use realfft::{ComplexToReal, RealFftPlanner, RealToComplex};
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// Parameters.
#[derive(Debug, Clone, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Params {
    /// Side of the searched square, in multiples of the target's mean side (root of the area) and
    /// beyond the target itself: 1 searches half a side in every direction. Above 0, at most 8.
    pub search: f64,
    /// Share of the newest window in the template, 0 (fixed template) to 1.
    pub update_rate: f64,
}

impl Default for Params {
    fn default() -> Self {
        Self { search: 1.0, update_rate: 0.0 }
    }
}

/// A checked configuration.
#[derive(Debug, Clone)]
pub struct Ncc(Params);

impl Ncc {
    /// Checks the parameters.
    ///
    /// # Errors
    /// For parameters outside their range.
    pub fn new(p: Params) -> Result<Self, ParamError> {
        if !(p.search > 0.0 && p.search <= 8.0) {
            return Err(ParamError::out_of_range("search", "above 0 and at most 8", p.search));
        }
        if !(0.0..=1.0).contains(&p.update_rate) {
            return Err(ParamError::out_of_range("update_rate", "from 0 to 1", p.update_rate));
        }
        Ok(Self(p))
    }
}

/// The list's line.
pub const ENTRY: Entry<dyn Setup> = Entry {
    kind: "ncc",
    version: 1,
    summary: "normalised cross-correlation with a fixed grey template",
    example: "{}",
    build: |raw: RawParams<'_>| Ok(Box::new(Ncc::new(read_params(raw)?)?)),
    schema: || schemars::schema_for!(Params),
};

impl Setup for Ncc {
    fn params(&self) -> serde_json::Value {
        show_params(&self.0)
    }

    fn uses_seed(&self) -> bool {
        false
    }

    fn open(&self, _: &Start<'_>) -> Result<Box<dyn Tracker>, TrackerError> {
        Ok(Box::new(Tracking { params: self.0.clone(), target: None }))
    }
}

struct Tracking {
    params: Params,
    target: Option<Target>,
}

/// The target since the last initialisation.
struct Target {
    region: Region,
    /// Window of the template at the first frame and how far it has moved since.
    window: Window,
    moved: (i64, i64),
    /// How far is searched in every direction, in pixels.
    radius: i64,
    /// Template as a running mean.
    template: Vec<f64>,
    correlator: Correlator,
}

impl Tracker for Tracking {
    fn init(&mut self, frame: &Frame, region: &Region) -> Result<State, TrackerError> {
        let rect = region.rect();
        let (cx, cy) = rect.centre();
        let mut window = Window::from_rect(&rect);
        // A window larger than the frame would only match the repeated border.
        let cut = |start: i64, len: usize, centre: f64, room: usize| {
            if len <= room {
                (start, len)
            } else {
                ((centre.clamp(-1e6, 1e6) - room as f64 / 2.0).round() as i64, room)
            }
        };
        (window.x, window.w) = cut(window.x, window.w, cx, frame.width());
        (window.y, window.h) = cut(window.y, window.h, cy, frame.height());
        let side = ((window.w * window.h) as f64).sqrt();
        let longest = frame.width().max(frame.height()) as f64;
        let radius = (0.5 * self.params.search * side).clamp(2.0, longest).round() as i64;
        let template = grey(frame, &window).into_iter().map(f64::from).collect();
        let correlator = Correlator::new(window.w, window.h, radius as usize);
        let mut target =
            Target { region: region.clone(), window, moved: (0, 0), radius, template, correlator };
        target.correlator.set_template(&target.template);
        self.target = Some(target);
        Ok(State::initialised(region.clone()))
    }

    fn update(&mut self, frame: &Frame) -> Result<State, TrackerError> {
        let Some(t) = &mut self.target else {
            return Err(TrackerError::Broken("ncc: a frame before the initialisation".into()));
        };
        let r = t.radius;
        let last = Window { x: t.window.x + t.moved.0, y: t.window.y + t.moved.1, ..t.window };
        let around = Window {
            x: last.x - r,
            y: last.y - r,
            w: t.window.w + 2 * r as usize,
            h: t.window.h + 2 * r as usize,
        };
        let scores = t.correlator.scores(&grey(frame, &around));
        // Twice the centre, to stay in whole numbers.
        let centre = |d: i64, start: i64, len: usize| 2 * (start + d) + len as i64;
        let (width, height) = (frame.width() as i64, frame.height() as i64);
        let mut best: Option<(f64, i64, (i64, i64))> = None;
        for (row, dy) in scores.chunks_exact(2 * r as usize + 1).zip(-r..) {
            if !(0..=2 * height).contains(&centre(dy, last.y, last.h)) {
                continue;
            }
            for (&g, dx) in row.iter().zip(-r..) {
                if !(0..=2 * width).contains(&centre(dx, last.x, last.w)) {
                    continue;
                }
                let far = dx * dx + dy * dy;
                if best.is_none_or(|(b, d, _)| g > b || (g == b && far < d)) {
                    best = Some((g, far, (dx, dy)));
                }
            }
        }
        // No place is left when the target was put outside the frame: it stays there.
        if let Some((_, _, (dx, dy))) = best {
            t.moved = (t.moved.0 + dx, t.moved.1 + dy);
        }
        if self.params.update_rate > 0.0 {
            let now = Window { x: t.window.x + t.moved.0, y: t.window.y + t.moved.1, ..t.window };
            let rate = self.params.update_rate;
            for (t, i) in t.template.iter_mut().zip(grey(frame, &now)) {
                *t = (1.0 - rate) * *t + rate * f64::from(i);
            }
            t.correlator.set_template(&t.template);
        }
        Ok(State::tracked(t.region.shifted(t.moved.0 as f64, t.moved.1 as f64)))
    }

    fn reset(&mut self) {
        self.target = None;
    }
}

/// Grey values of a window; beyond the frame its border is repeated.
fn grey(frame: &Frame, w: &Window) -> Vec<u8> {
    let columns: Vec<usize> =
        (0..w.w as i64).map(|i| (w.x + i).clamp(0, frame.width() as i64 - 1) as usize).collect();
    let mut out = Vec::with_capacity(w.w * w.h);
    for j in 0..w.h as i64 {
        let row = frame.row((w.y + j).clamp(0, frame.height() as i64 - 1) as usize);
        out.extend(columns.iter().map(|&i| {
            let [r, g, b] = [row[3 * i], row[3 * i + 1], row[3 * i + 2]].map(u32::from);
            ((77 * r + 150 * g + 29 * b + 128) >> 8) as u8
        }));
    }
    out
}

/// Scores of templates of one size over search areas of one size.
///
/// Both are written row by row with the search area's width as stride, which makes the plane's
/// correlation that of two lines: the template at `(dx, dy)` is the template at lag `dy * width + dx`.
struct Correlator {
    w: usize,
    h: usize,
    radius: usize,
    forward: Arc<dyn RealToComplex<f64>>,
    backward: Arc<dyn ComplexToReal<f64>>,
    line: Vec<f64>,
    spectrum: Vec<Complex<f64>>,
    scratch: Vec<Complex<f64>>,
    /// Conjugate spectrum of the template, divided by the transform's length.
    template: Vec<Complex<f64>>,
    sum: i64,
    energy: i64,
}

impl Correlator {
    fn new(w: usize, h: usize, radius: usize) -> Self {
        let length = smooth((w + 2 * radius) * (h + 2 * radius));
        let mut planner = RealFftPlanner::new();
        let (forward, backward) = (planner.plan_fft_forward(length), planner.plan_fft_inverse(length));
        let scratch = vec![Complex::default(); forward.get_scratch_len().max(backward.get_scratch_len())];
        let (line, spectrum) = (forward.make_input_vec(), forward.make_output_vec());
        let template = spectrum.clone();
        Self { w, h, radius, forward, backward, line, spectrum, scratch, template, sum: 0, energy: 0 }
    }

    fn width(&self) -> usize {
        self.w + 2 * self.radius
    }

    fn set_template(&mut self, template: &[f64]) {
        let width = self.width();
        let n = self.line.len() as f64;
        self.line.fill(0.0);
        (self.sum, self.energy) = (0, 0);
        for (row, line) in template.chunks_exact(self.w).zip(self.line.chunks_mut(width)) {
            for (&t, o) in row.iter().zip(line) {
                *o = centred(t.round() as u8);
                let t = *o as i64;
                self.sum += t;
                self.energy += t * t;
            }
        }
        transform(&*self.forward, &mut self.line, &mut self.spectrum, &mut self.scratch);
        for (t, s) in self.template.iter_mut().zip(&self.spectrum) {
            *t = s.conj() / n;
        }
    }

    /// NCC at every place, rows from the top, `2 radius + 1` each way. `area` is the search area's
    /// grey values, row by row.
    fn scores(&mut self, area: &[u8]) -> Vec<f64> {
        let width = self.width();
        self.line.fill(0.0);
        for (o, &v) in self.line.iter_mut().zip(area) {
            *o = centred(v);
        }
        let (sums, squares) = integrals(area, width);
        transform(&*self.forward, &mut self.line, &mut self.spectrum, &mut self.scratch);
        for (s, t) in self.spectrum.iter_mut().zip(&self.template) {
            *s *= t;
        }
        // A real line's spectrum is real at both ends; products may leave a rounding error there.
        let last = self.spectrum.len() - 1;
        for k in [0, last] {
            self.spectrum[k].im = 0.0;
        }
        let done = self.backward.process_with_scratch(&mut self.spectrum, &mut self.line, &mut self.scratch);
        debug_assert!(done.is_ok());

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

/// Grey levels around 0, which keeps the sums small; the score does not change.
fn centred(v: u8) -> f64 {
    f64::from(v) - 128.0
}

fn transform(
    fft: &dyn RealToComplex<f64>,
    line: &mut [f64],
    spectrum: &mut [Complex<f64>],
    scratch: &mut [Complex<f64>],
) {
    // It only refuses buffers of other lengths than its own, and these are made for it.
    let done = fft.process_with_scratch(line, spectrum, scratch);
    debug_assert!(done.is_ok());
}

/// Integral images of the centred grey values and of their squares, with a row and a column of zeros
/// before the first.
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

/// The smallest even number from `n` on without prime factors above 5, on which transforms are fast.
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
mod tests {
    use super::*;
    use crate::region::Rect;
    use proptest::prelude::*;

    fn tracker(params: &str) -> Box<dyn Setup> {
        ENTRY.build_from_text(params).unwrap()
    }

    fn start(setup: &dyn Setup) -> Box<dyn Tracker> {
        let sequence = crate::dataset::synthetic::suite("synthetic-otb").unwrap().swap_remove(0);
        setup.open(&Start { sequence: &sequence, run: 0, seed: 1, data_root: None }).unwrap()
    }

    /// A textured frame, shifted by whole pixels.
    fn texture(dx: i64, dy: i64) -> Frame {
        Frame::from_fn(90, 70, |x, y| {
            let (u, v) = ((x as i64 - dx) as u32, (y as i64 - dy) as u32);
            let h = u.wrapping_mul(2_654_435_761) ^ v.wrapping_mul(40_503_001);
            let h = (h ^ (h >> 15)).wrapping_mul(2_246_822_519);
            [(h >> 8) as u8, (h >> 16) as u8, (h >> 24) as u8]
        })
    }

    // Pearson's correlation coefficient over the overlapping pixels, straight from its definition.
    fn pearson(a: &[u8], b: &[u8]) -> f64 {
        let n = a.len() as f64;
        let mean = |v: &[u8]| v.iter().map(|&x| f64::from(x)).sum::<f64>() / n;
        let (ma, mb) = (mean(a), mean(b));
        let dot = |p: &[u8], mp: f64, q: &[u8], mq: f64| -> f64 {
            p.iter().zip(q).map(|(&x, &y)| (f64::from(x) - mp) * (f64::from(y) - mq)).sum()
        };
        dot(a, ma, b, mb) / (dot(a, ma, a, ma) * dot(b, mb, b, mb)).sqrt()
    }

    proptest! {
        #[test]
        fn scores_agree_with_the_definition(
            w in 2_usize..9, h in 2_usize..9, r in 2_usize..6,
            bytes in proptest::collection::vec(any::<u8>(), 400..401),
        ) {
            let (width, height) = (w + 2 * r, h + 2 * r);
            let area: Vec<u8> = (0..width * height).map(|k| bytes[k % 397]).collect();
            let template: Vec<u8> = (0..w * h).map(|k| bytes[(k * 7 + 3) % 399]).collect();
            let mut c = Correlator::new(w, h, r);
            c.set_template(&template.iter().map(|&v| f64::from(v)).collect::<Vec<_>>());
            let scores = c.scores(&area);
            for dy in 0..=2 * r {
                for dx in 0..=2 * r {
                    let window: Vec<u8> =
                        (0..w * h).map(|k| area[(dy + k / w) * width + dx + k % w]).collect();
                    let (want, got) = (pearson(&window, &template), scores[dy * (2 * r + 1) + dx]);
                    if want.is_finite() {
                        prop_assert!((want - got).abs() < 1e-9, "{want} {got}");
                    } else {
                        prop_assert_eq!(got, 0.0);
                    }
                }
            }
        }

        #[test]
        fn follows_a_shift_exactly(dx in -7_i64..8, dy in -7_i64..8) {
            let mut t = start(&*tracker("{}"));
            let region = Region::Rect(Rect::new(30.25, 25.5, 20.0, 16.0));
            t.init(&texture(0, 0), &region).unwrap();
            let answer = t.update(&texture(dx, dy)).unwrap();
            prop_assert_eq!(answer.region, region.shifted(dx as f64, dy as f64));
        }
    }

    // python3: import numpy as np; t=np.array([10,20,30,60.]); i=np.array([1,2,4,5.]);
    // np.corrcoef(t,i)[0,1]
    #[test]
    fn one_score_agrees_with_numpy() {
        let mut c = Correlator::new(2, 2, 2);
        c.set_template(&[10.0, 20.0, 30.0, 60.0]);
        let mut area = vec![9; 36];
        for (k, v) in [(14, 1), (15, 2), (20, 4), (21, 5)] {
            area[k] = v;
        }
        assert!((c.scores(&area)[2 * 5 + 2] - NUMPY).abs() < 1e-12);
    }
    const NUMPY: f64 = 0.9296696802013683;

    // What the module's text promises about rounding, at the size of a large target and at extremes.
    #[test]
    fn transformed_sums_are_nearly_whole_numbers() {
        for seed in [1_u32, 2] {
            let bytes = |n: usize, k: u32| -> Vec<u8> {
                (0..n as u32)
                    .map(|i| {
                        if (i.wrapping_mul(2_654_435_761) ^ k).count_ones().is_multiple_of(2) {
                            0
                        } else {
                            255
                        }
                    })
                    .collect()
            };
            let mut c = Correlator::new(260, 220, 110);
            c.set_template(&bytes(260 * 220, seed).into_iter().map(f64::from).collect::<Vec<_>>());
            c.scores(&bytes(480 * 440, seed ^ 77));
            let worst = (0..=220)
                .flat_map(|dy| c.line[dy * 480..dy * 480 + 221].iter())
                .map(|v| (v - v.round()).abs())
                .fold(0.0, f64::max);
            assert!(worst < 1e-3, "{worst}");
        }
    }

    #[test]
    fn gain_and_offset_of_the_light_change_nothing() {
        let dim = |f: &Frame| Frame::from_fn(90, 70, |x, y| f.pixel(x, y).map(|v| v / 2 + 20));
        let mut t = start(&*tracker("{}"));
        let region = Region::Rect(Rect::new(30.0, 25.0, 20.0, 16.0));
        t.init(&texture(0, 0), &region).unwrap();
        assert_eq!(t.update(&dim(&texture(4, -3))).unwrap().region, region.shifted(4.0, -3.0));
    }

    #[test]
    fn without_contrast_it_stays() {
        let flat = Frame::new(40, 30, vec![77; 3600]);
        let mut t = start(&*tracker("{ search = 2.0 }"));
        let region = Region::Rect(Rect::new(10.0, 10.0, 8.0, 8.0));
        t.init(&flat, &region).unwrap();
        assert_eq!(t.update(&flat).unwrap().region, region);
    }

    #[test]
    fn the_template_follows_at_its_rate() {
        let (old, new) = (texture(0, 0), texture(31, 17));
        // A fifth of the new look leaves the old place the best one.
        let mixed = Frame::from_fn(90, 70, |x, y| {
            let (a, b) = (old.pixel(x, y), new.pixel(x, y));
            [0, 1, 2].map(|k| ((u32::from(a[k]) * 4 + u32::from(b[k])) / 5) as u8)
        });
        let window = Window { x: 30, y: 25, w: 20, h: 16 };
        let region = Region::Rect(Rect::new(30.0, 25.0, 20.0, 16.0));
        for rate in [0.0, 0.25, 1.0] {
            let mut t = Tracking { params: Params { search: 1.0, update_rate: rate }, target: None };
            t.init(&old, &region).unwrap();
            assert_eq!(t.update(&mixed).unwrap().region, region);
            let got = t.target.unwrap().template;
            for ((&a, &b), t) in grey(&old, &window).iter().zip(&grey(&mixed, &window)).zip(got) {
                let want = f64::from(a) + rate * (f64::from(b) - f64::from(a));
                assert!((t - want).abs() < 1e-12);
            }
        }
    }

    #[test]
    fn refuses_parameters_out_of_range() {
        for bad in [
            "{ search = 0 }",
            "{ search = 9 }",
            "{ update_rate = -0.1 }",
            "{ update_rate = nan }",
            "{ x = 1 }",
        ] {
            assert!(ENTRY.build_from_text(bad).is_err(), "{bad}");
        }
    }

    #[test]
    fn lengths_are_smooth() {
        assert_eq!([1, 7, 12, 13, 121, 12_000, 12_001].map(smooth), [2, 8, 12, 16, 128, 12_000, 12_150]);
    }
}
