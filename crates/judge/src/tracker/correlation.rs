//! The common part of correlation filter trackers: labels, peaks, and the kernelized filter of Henriques et al.
//! ("High-speed tracking with kernelized correlation filters", PAMI 37(3), 2015).
//!
//! ```text
//! y(i, j)    = exp(-(i^2 + j^2) / (2 s^2))                                label; i, j wrap, so the peak is at (0, 0)
//! k^{xz}     = exp(-max(0, |x|^2 + |z|^2 - 2 F^-1(sum_c conj(X_c) Z_c)) / (sigma^2 n))           eq. 30 and 31
//! A          = Y / (K^{xx} + lambda)                                                             eq. 17
//! f(z)       = F^-1(K^{xz} A),   its peak is the shift from x to z                               eq. 22
//! ```
//!
//! `x` is the model, `z` a new sample ("look"), both `c` channels of `w x h` cells times a Hann window; capitals are Fourier
//! transforms; `n` is the number of values, `w h c`. After a look both `A` and `X` are blended with what
//! it gives, at the rate `r`: `A <- (1 - r) A + r A'` (`linear`), or, as the VOT2014 entry is said to do,
//! numerator and denominator on their own (`fraction`; Danelljan et al., CVPR 2014, eq. 5 and 6):
//!
//! ```text
//! A_N <- (1 - r) A_N + r Y K^{xx}      A_D <- (1 - r) A_D + r K^{xx} (K^{xx} + lambda)      A = A_N / A_D
//! ```
//!
//! A look without contrast (no feature differs from 0) neither moves nor trains the filter, since its response would
//! consist of rounding errors.

pub mod place;
pub mod response;

use super::first_largest;
use crate::image::Frame;
use crate::image::patch::{Patch, halved};
use crate::num::fourier::{Complexes, Fourier, LANES, Lanes, ZEROS, hann_plane};
use serde::{Deserialize, Serialize};
use std::borrow::Cow;

/// Rule by which a filter follows the target's appearance.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Update {
    /// The filter itself is blended.
    Linear,
    /// The numerator and the denominator of the filter are blended separately.
    Fraction,
}

/// Highest response of a map.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Peak {
    /// Value of the response.
    pub value: f32,
    /// Column of the peak as a shift, from `-w / 2` to below `w / 2`.
    pub x: i64,
    /// Row of the peak as a shift.
    pub y: i64,
}

/// Gaussian of standard deviation `sigma` (in cells) around cell (0, 0) of a plane that wraps around.
pub fn label(width: usize, height: usize, sigma: f64) -> Vec<f32> {
    let squares = |n: usize| (0..n).map(move |i| (signed(i, n) as f64).powi(2));
    let across: Vec<f64> = squares(width).collect();
    squares(height)
        .flat_map(|v| across.iter().map(move |u| (-0.5 * (u + v) / (sigma * sigma)).exp() as f32))
        .collect()
}

/// Index `i` of `n` as a shift. The upper half is negative.
fn signed(i: usize, n: usize) -> i64 {
    if 2 * i >= n.max(2) { i as i64 - n as i64 } else { i as i64 }
}

/// Peak of a response; among equal values the first, by row.
pub fn peak(response: &[f32], width: usize, height: usize) -> Peak {
    let at = first_largest(response.iter().map(|v| f64::from(*v)));
    Peak { value: response[at], x: signed(at % width, width), y: signed(at / width, height) }
}

/// Position of the vertex of a parabola through a peak `c` and its neighbors, in `[-0.5, 0.5]`.
pub fn parabola(left: f32, c: f32, right: f32) -> f64 {
    let bend = 2.0 * f64::from(c) - f64::from(left) - f64::from(right);
    if bend > 0.0 { (0.5 * (f64::from(right) - f64::from(left)) / bend).clamp(-0.5, 0.5) } else { 0.0 }
}

/// Number of times that a frame is halved for a target with a mean side of `side` pixels (root of its area):
/// once from 100 on, like the published trackers, and again as long as 400 or more are left, to bound the
/// time per frame.
pub fn halvings(side: f64) -> u32 {
    let mut times = u32::from(side >= 100.0);
    while times < 16 && side / f64::from(1_u32 << times) >= 400.0 {
        times += 1;
    }
    times
}

/// Frame halved `times` times.
pub fn reduced(frame: &Frame, times: u32) -> Cow<'_, Frame> {
    (0..times).fold(Cow::Borrowed(frame), |f, _| Cow::Owned(halved(&f)))
}

/// Means of the blocks of `times` columns and rows, plane by plane. What is left beside and below them is not counted.
pub fn block_means(patch: &Patch, times: usize) -> Patch {
    let (width, height) = (patch.width / times, patch.height / times);
    let mut values = Vec::with_capacity(patch.planes() * width * height);
    let planes = patch.values.chunks_exact(patch.width * patch.height);
    for band in planes.flat_map(|plane| plane.chunks_exact(patch.width * times)) {
        values.extend((0..width).map(|column| {
            let rows = band.chunks_exact(patch.width).map(|row| &row[times * column..][..times]);
            rows.flatten().sum::<f32>() / (times * times) as f32
        }));
    }
    Patch { width, height, values }
}

/// Parameters of a filter.
#[derive(Debug, Clone, Copy)]
pub struct Settings {
    /// Standard deviation `s` of the label, in cells, above 0.
    pub label_width: f64,
    /// Standard deviation `sigma` of the kernel, above 0.
    pub kernel_width: f64,
    /// Regularization, above 0.
    pub lambda: f64,
    /// Share `r` of the newest look.
    pub rate: f64,
    /// Rule by which the newest look is blended in.
    pub update: Update,
}

/// A filter for looks of one size, with its model and buffers.
#[derive(Clone)]
pub struct KernelFilter {
    settings: Settings,
    channels: usize,
    fourier: Fourier,
    window: Vec<f32>,
    label: Vec<Complexes>,
    /// Spectra of the model and of the newest look, channel by channel.
    model: Vec<Complexes>,
    look: Vec<Complexes>,
    /// `A` of the linear update, or `A_N` of the other update, whose `A_D` follows.
    numerator: Vec<Complexes>,
    denominator: Vec<Complexes>,
    taught: bool,
    /// Energy `|x|^2` of the model.
    energy: f64,
    product: Vec<Complexes>,
    plane: Vec<f32>,
}

/// Learned part of a filter: real and imaginary parts of its spectra in turn, four columns each.
#[derive(Serialize, Deserialize)]
pub struct FilterMemory {
    /// Those of the model, the numerator and the denominator.
    spectra: [Vec<[f32; LANES]>; 3],
    taught: bool,
}

impl KernelFilter {
    /// Creates an untrained filter for looks of `channels` channels with `width` x `height` cells.
    pub fn new(width: usize, height: usize, channels: usize, settings: Settings) -> Self {
        let mut fourier = Fourier::new(width, height);
        let empty = vec![ZEROS; fourier.spectrum_len()];
        let label = fourier.forward(&label(width, height, settings.label_width)).to_vec();
        Self {
            settings,
            channels,
            window: hann_plane(width, height),
            label,
            model: vec![ZEROS; channels * fourier.spectrum_len()],
            look: vec![ZEROS; channels * fourier.spectrum_len()],
            numerator: empty.clone(),
            denominator: empty.clone(),
            taught: false,
            energy: 0.0,
            product: empty,
            plane: vec![0.0; fourier.plane_len()],
            fourier,
        }
    }

    /// Saves the learned part, without buffers and plans.
    pub fn memory(&self) -> FilterMemory {
        let flat = |spectra: &Vec<Complexes>| spectra.iter().flat_map(|c| [c.re.0, c.im.0]).collect();
        let spectra = [&self.model, &self.numerator, &self.denominator].map(flat);
        FilterMemory { spectra, taught: self.taught }
    }

    /// Restores the learned part. Returns `false` if it is of another size.
    pub fn remember(&mut self, memory: &FilterMemory) -> bool {
        let fill = |spectra: &mut [Complexes], values: &[[f32; LANES]]| {
            let pairs = values.as_chunks::<2>().0;
            let fits = values.len() == 2 * spectra.len();
            for (c, [re, im]) in spectra.iter_mut().zip(pairs) {
                *c = Complexes::new(Lanes(*re), Lanes(*im));
            }
            fits
        };
        let own = [&mut self.model, &mut self.numerator, &mut self.denominator];
        let fits = own.into_iter().zip(&memory.spectra).all(|(spectra, values)| fill(spectra, values));
        self.taught = memory.taught;
        self.energy = energy(&self.fourier, &self.model);
        fits
    }

    /// Peak of the response to `features` (channel by channel, without the window); `None` without contrast.
    pub fn respond(&mut self, features: &[f32]) -> Option<Peak> {
        let z = self.transform(features);
        let x = self.energy;
        if !self.taught || z <= 0.0 || x <= 0.0 {
            return None;
        }
        let Self { model, look, product, .. } = self;
        product.fill(ZEROS);
        for (xs, zs) in model.chunks_exact(product.len()).zip(look.chunks_exact(product.len())) {
            let pairs = xs.chunks_exact(2).zip(zs.chunks_exact(2));
            for (p, (x, z)) in product.chunks_exact_mut(2).zip(pairs) {
                for i in [0, 1] {
                    p[i].re += x[i].re * z[i].re + x[i].im * z[i].im;
                    p[i].im += x[i].re * z[i].im - x[i].im * z[i].re;
                }
            }
        }
        self.kernel(x + z);
        match self.settings.update {
            Update::Linear => self.product.iter_mut().zip(&self.numerator).for_each(|(p, a)| *p = *p * a),
            Update::Fraction => {
                let filter = self.numerator.iter().zip(&self.denominator);
                self.product.iter_mut().zip(filter).for_each(|(p, (n, d))| *p = *p * (n / d));
            }
        }
        self.fourier.backward(&self.product, &mut self.plane);
        Some(peak(&self.plane, self.fourier.width(), self.fourier.height()))
    }

    /// Position of the newest response's peak between cells, by parabolas, in cells.
    pub fn refine(&self, peak: &Peak) -> (f64, f64) {
        let (w, h) = (self.fourier.width() as i64, self.fourier.height() as i64);
        let at = |dx: i64, dy: i64| {
            let (x, y) = ((peak.x + dx).rem_euclid(w), (peak.y + dy).rem_euclid(h));
            self.plane[(y * w + x) as usize]
        };
        let dx = parabola(at(-1, 0), peak.value, at(1, 0));
        let dy = parabola(at(0, -1), peak.value, at(0, 1));
        (peak.x as f64 + dx, peak.y as f64 + dy)
    }

    /// Blends in the look at the target's place. The first look sets the filter.
    pub fn learn(&mut self, features: &[f32]) {
        let x = self.transform(features);
        if x <= 0.0 {
            return;
        }
        let Self { look, product, .. } = self;
        product.fill(ZEROS);
        for spectrum in look.chunks_exact(product.len()) {
            product.iter_mut().zip(spectrum).for_each(|(p, x)| p.re += x.norm_sqr());
        }
        self.kernel(2.0 * x);
        let rate = Lanes::splat(if self.taught { self.settings.rate as f32 } else { 1.0 });
        self.taught = true;
        let lambda = Lanes::splat(self.settings.lambda as f32);
        let filter = self.numerator.iter_mut().zip(&mut self.denominator);
        for ((n, d), (k, y)) in filter.zip(self.product.iter().zip(&self.label)) {
            let (numerator, denominator) = match self.settings.update {
                Update::Linear => (y / (k + lambda), Complexes::new(Lanes::splat(1.0), Lanes::ZERO)),
                Update::Fraction => (y * k, k * (k + lambda)),
            };
            *n = *n + (numerator - *n) * rate;
            *d = *d + (denominator - *d) * rate;
        }
        self.model.iter_mut().zip(&self.look).for_each(|(m, x)| *m = *m + (x - *m) * rate);
        self.energy = energy(&self.fourier, &self.model);
    }

    /// Transforms a look and returns its energy.
    fn transform(&mut self, features: &[f32]) -> f64 {
        debug_assert!(features.len() == self.channels * self.fourier.plane_len());
        let planes = features.chunks_exact(self.window.len());
        for (plane, look) in planes.zip(self.look.chunks_exact_mut(self.product.len())) {
            look.copy_from_slice(self.fourier.forward_by(|i| plane[i] * self.window[i]));
        }
        energy(&self.fourier, &self.look)
    }

    /// Converts `product` from the spectrum of the correlation to that of the kernel; `energies` is
    /// `|x|^2 + |z|^2`.
    fn kernel(&mut self, energies: f64) {
        let n = (self.plane.len() * self.channels) as f64;
        self.fourier.backward(&self.product, &mut self.plane);
        let factor = -1.0 / (self.settings.kernel_width.powi(2) * n);
        for v in &mut self.plane {
            *v = (factor * (energies - 2.0 * f64::from(*v)).max(0.0)) as f32;
        }
        self.plane.iter_mut().for_each(|v| *v = v.exp());
        self.product.copy_from_slice(self.fourier.forward(&self.plane));
    }
}

fn energy(fourier: &Fourier, spectra: &[Complexes]) -> f64 {
    spectra.chunks_exact(fourier.spectrum_len()).map(|s| fourier.energy(s)).sum()
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const SETTINGS: Settings =
        Settings { label_width: 1.2, kernel_width: 0.6, lambda: 1e-3, rate: 0.1, update: Update::Linear };

    fn texture(n: usize, k: usize) -> Vec<f32> {
        (0..n).map(|i| (((i * 7919 + k * 104_729) * 1_664_525 % (1 << 20)) >> 10) as f32 / 1024.0).collect()
    }

    // python3: import numpy as np; w, h, c = 7, 6, 2; F, G = np.fft.fft2, np.fft.ifft2
    // def look(k): i = np.arange(w * h * c); return (((i * 7919 + k * 104729) * 1664525 % 2**20 >> 10) / 1024
    //   ).reshape(c, h, w) * np.outer(np.hanning(h), np.hanning(w))
    // s = lambda n: np.array([i - n if 2 * i >= n else i for i in range(n)])
    // y = np.exp(-.5 * (s(h)[:, None]**2 + s(w)**2) / 1.2**2)
    // def K(x, z): return F(np.exp(-np.maximum(0, (x**2).sum() + (z**2).sum() - 2 * G((F(x).conj() * F(z)).sum(0)).real)
    //   / (.6**2 * w * h * c)))
    // a, b, z = look(1), look(2), look(3); k = [K(a, a), K(b, b)]; m = .9 * a + .1 * b
    // A = [.9 * F(y) / (k[0] + 1e-3) + .1 * F(y) / (k[1] + 1e-3), F(y) * (.9 * k[0] + .1 * k[1])
    //   / (.9 * k[0] * (k[0] + 1e-3) + .1 * k[1] * (k[1] + 1e-3))]
    // for q in A: r = G(K(m, z) * q).real; i = r.argmax(); print(r.max(), i % w, i // w, r[0, :3])
    #[test]
    fn responses_agree_with_numpy() {
        for (update, want) in [(Update::Linear, LINEAR), (Update::Fraction, FRACTION)] {
            let mut filter = KernelFilter::new(7, 6, 2, Settings { update, ..SETTINGS });
            filter.learn(&texture(84, 1));
            filter.learn(&texture(84, 2));
            let peak = filter.respond(&texture(84, 3)).unwrap();
            let got = [peak.value, filter.plane[0], filter.plane[1], filter.plane[2]];
            for (a, b) in got.iter().zip(want.0) {
                assert!((a - b).abs() < 2e-3, "{got:?} {want:?}");
            }
            assert_eq!((peak.x, peak.y), want.1);
        }
    }
    const LINEAR: ([f32; 4], (i64, i64)) = ([0.961989, 0.961989, 0.553923, 0.172643], (0, 0));
    const FRACTION: ([f32; 4], (i64, i64)) = ([0.897018, 0.897018, 0.540386, 0.209704], (0, 0));

    #[test]
    fn without_contrast_there_is_no_response() {
        let mut filter = KernelFilter::new(8, 8, 1, SETTINGS);
        assert_eq!(filter.respond(&texture(64, 1)), None, "untaught");
        filter.learn(&[0.0; 64]);
        assert_eq!(filter.respond(&texture(64, 1)), None, "taught nothing");
        filter.learn(&texture(64, 1));
        assert_eq!(filter.respond(&[0.0; 64]), None);
        let peak = filter.respond(&texture(64, 1)).unwrap();
        assert_eq!((peak.x, peak.y), (0, 0));
        assert!(peak.value > 0.9 && peak.value < 1.05, "{peak:?}");
    }

    #[test]
    fn halves_from_a_hundred_pixels_on() {
        assert_eq!([1.0, 99.9, 100.0, 799.0, 800.0, 1600.0].map(halvings), [0, 0, 1, 1, 2, 3]);
        let frame = Frame::new(9, 5, vec![50; 135]);
        let small = reduced(&frame, 2);
        assert_eq!((small.width(), small.height(), small.pixel(2, 1)), (3, 2, [50; 3]));
    }

    proptest! {
        #[test]
        fn the_first_highest_value_is_the_peak(w in 1_usize..9, h in 1_usize..9, at in any::<prop::sample::Index>()) {
            let at = at.index(w * h);
            let values: Vec<f32> = (0..w * h).map(|i| if i >= at { 2.0 } else { 1.0 }).collect();
            let p = peak(&values, w, h);
            prop_assert_eq!(p.x.rem_euclid(w as i64) as usize, at % w);
            prop_assert_eq!(p.y.rem_euclid(h as i64) as usize, at / w);
            prop_assert!(2 * p.x.unsigned_abs() as usize <= w && 2 * p.y.unsigned_abs() as usize <= h);
            prop_assert_eq!(p.value, 2.0);
        }

        #[test]
        fn a_parabola_has_its_top_where_it_is(top in -0.5_f64..0.5, bend in 0.1_f64..9.0) {
            let f = |x: f64| (3.0 - bend * (x - top).powi(2)) as f32;
            prop_assert!((parabola(f(-1.0), f(0.0), f(1.0)) - top).abs() < 1e-4);
        }
    }
}
