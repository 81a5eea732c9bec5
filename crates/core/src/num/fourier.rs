//! Discrete Fourier transforms of real planes in `f32` and of real lines in `f64`, and the Hann window that goes before them.
//!
//! ```text
//! X[k, l] = sum_{i, j} x[i, j] exp(-2 pi I (i k / w + j l / h))        i, k: columns, j, l: rows, from 0
//! x[i, j] = 1 / (w h) sum_{k, l} X[k, l] exp(+2 pi I (i k / w + j l / h))
//! ```
//!
//! The spectrum of a real plane is symmetric, `X[w - k, h - l] = conj X[k, l]`, so only the columns `0..=w / 2`
//! are kept. They are stored **column by column**: `X[k, l]` is at `k * h + l`. Products of spectra do not mind, and a
//! transform needs one transposition instead of two. With `h = 1` this is the transform of a line.
//!
//! Any size works, primes too (by Rader's or Bluestein's algorithm). The algorithms are `rustfft`'s, four lines at a
//! time (`lanes`), and give the same bits on every processor.

mod lanes;
mod line;

use lanes::{LANES, Lanes, ZEROS};
pub use line::{Complex64, LineFourier};
use realfft::{ComplexToReal, RealFftPlanner, RealToComplex};
use rustfft::{Fft, FftPlanner};
use std::sync::Arc;

/// A coefficient of a spectrum.
pub type Complex = realfft::num_complex::Complex<f32>;
/// A coefficient of each of four lines.
type Complexes = realfft::num_complex::Complex<Lanes>;

/// Plans and buffers for planes of one size.
pub struct Fourier {
    width: usize,
    height: usize,
    rows_forward: Arc<dyn RealToComplex<Lanes>>,
    rows_backward: Arc<dyn ComplexToReal<Lanes>>,
    columns_forward: Arc<dyn Fft<Lanes>>,
    columns_backward: Arc<dyn Fft<Lanes>>,
    /// Four rows side by side, and their coefficients.
    rows: Vec<Lanes>,
    spectra: Vec<Complexes>,
    /// All columns, four side by side: the coefficients of four columns in row `l` are at `group * height + l`.
    columns: Vec<Complexes>,
    scratch: Vec<Complexes>,
}

impl Fourier {
    /// Plans for planes of `width` columns and `height` rows, both at least 1.
    pub fn new(width: usize, height: usize) -> Self {
        let (width, height) = (width.max(1), height.max(1));
        let (mut real, mut complex) = (RealFftPlanner::new(), FftPlanner::new());
        let rows_forward = real.plan_fft_forward(width);
        let rows_backward = real.plan_fft_inverse(width);
        let columns_forward = complex.plan_fft_forward(height);
        let columns_backward = complex.plan_fft_inverse(height);
        let scratch = [
            rows_forward.get_scratch_len(),
            rows_backward.get_scratch_len(),
            columns_forward.get_inplace_scratch_len(),
            columns_backward.get_inplace_scratch_len(),
        ];
        let kept = width / 2 + 1;
        Self {
            rows: vec![Lanes::ZERO; width],
            spectra: vec![ZEROS; kept],
            columns: vec![ZEROS; if height > 1 { kept.div_ceil(LANES) * height } else { 0 }],
            scratch: vec![ZEROS; scratch.into_iter().fold(0, usize::max)],
            width,
            height,
            rows_forward,
            rows_backward,
            columns_forward,
            columns_backward,
        }
    }

    /// Columns of the plane.
    pub fn width(&self) -> usize {
        self.width
    }

    /// Rows of the plane.
    pub fn height(&self) -> usize {
        self.height
    }

    /// Values of a plane, `width * height`.
    pub fn plane_len(&self) -> usize {
        self.width * self.height
    }

    /// Coefficients of a spectrum, `(width / 2 + 1) * height`.
    pub fn spectrum_len(&self) -> usize {
        (self.width / 2 + 1) * self.height
    }

    /// Transforms planes that stand one behind the other (rows from the top), each times `window` (the same layout),
    /// into as many spectra.
    pub fn forward_windowed(&mut self, planes: &[f32], window: &[f32], spectra: &mut [Complex]) {
        if self.height == 1 {
            self.lines(planes, spectra, |line, x| planes[line * window.len() + x] * window[x]);
            return;
        }
        let (n, m) = (self.plane_len(), self.spectrum_len());
        for (plane, spectrum) in planes.chunks_exact(n).zip(spectra.chunks_exact_mut(m)) {
            self.plane(spectrum, |i| plane[i] * window[i]);
        }
    }

    /// Transforms `plane` (rows from the top) into `spectrum`, without a factor.
    pub fn forward(&mut self, plane: &[f32], spectrum: &mut [Complex]) {
        if self.height == 1 {
            self.lines(plane, spectrum, |_, x| plane[x]);
        } else {
            self.plane(spectrum, |i| plane[i]);
        }
    }

    /// Transforms lines one behind the other; `value(line, x)` is what is transformed.
    fn lines(&mut self, lines: &[f32], spectra: &mut [Complex], value: impl Fn(usize, usize) -> f32) {
        let (count, kept) = (lines.len() / self.width, self.width / 2 + 1);
        for start in (0..count).step_by(LANES) {
            // Beyond the last line the last one is transformed again.
            for (x, values) in self.rows.iter_mut().enumerate() {
                values.0 = std::array::from_fn(|lane| value((start + lane).min(count - 1), x));
            }
            self.transform_rows();
            for (lane, spectrum) in spectra[start * kept..].chunks_exact_mut(kept).take(LANES).enumerate() {
                pick(&self.spectra, lane, spectrum);
            }
        }
    }

    /// Transforms the plane whose values, rows from the top, are `value(i)`.
    fn plane(&mut self, spectrum: &mut [Complex], value: impl Fn(usize) -> f32) {
        let (width, height) = (self.width, self.height);
        for start in (0..height).step_by(LANES) {
            let first: [usize; LANES] = std::array::from_fn(|lane| (start + lane).min(height - 1) * width);
            for (x, values) in self.rows.iter_mut().enumerate() {
                values.0 = first.map(|row| value(row + x));
            }
            self.transform_rows();
            for (group, four) in self.columns.chunks_exact_mut(height).zip(self.spectra.chunks(LANES)) {
                transpose(four, &mut group[start..height.min(start + LANES)]);
            }
        }
        for (group, columns) in self.columns.chunks_exact_mut(height).zip(spectrum.chunks_mut(LANES * height))
        {
            self.columns_forward.process_with_scratch(group, &mut self.scratch);
            for (lane, column) in columns.chunks_exact_mut(height).enumerate() {
                pick(group, lane, column);
            }
        }
    }

    fn transform_rows(&mut self) {
        // It only refuses buffers of other lengths than those that it was asked for.
        let done =
            self.rows_forward.process_with_scratch(&mut self.rows, &mut self.spectra, &mut self.scratch);
        debug_assert!(done.is_ok());
    }

    /// Transforms `spectrum` back into `plane`, with the factor `1 / (w h)`.
    pub fn backward(&mut self, spectrum: &[Complex], plane: &mut [f32]) {
        let (width, height) = (self.width, self.height);
        let factor = Lanes([1.0 / self.plane_len() as f32; LANES]);
        for (group, columns) in self.columns.chunks_exact_mut(height).zip(spectrum.chunks(LANES * height)) {
            if columns.len() < LANES * height {
                group.fill(ZEROS);
            }
            for (lane, column) in columns.chunks_exact(height).enumerate() {
                for (values, v) in group.iter_mut().zip(column) {
                    values.re.0[lane] = v.re;
                    values.im.0[lane] = v.im;
                }
            }
            self.columns_backward.process_with_scratch(group, &mut self.scratch);
        }
        for start in (0..height).step_by(LANES) {
            if height == 1 {
                for (values, v) in self.spectra.iter_mut().zip(spectrum) {
                    *values = Complexes::new(Lanes([v.re; LANES]), Lanes([v.im; LANES]));
                }
            }
            for (group, four) in self.columns.chunks_exact(height).zip(self.spectra.chunks_mut(LANES)) {
                transpose(&group[start..height.min(start + LANES)], four);
            }
            // Real rows have real ends; products of spectra may leave a rounding error there.
            self.spectra[0].im = Lanes::ZERO;
            if width.is_multiple_of(2) {
                self.spectra[width / 2].im = Lanes::ZERO;
            }
            let done =
                self.rows_backward.process_with_scratch(&mut self.spectra, &mut self.rows, &mut self.scratch);
            debug_assert!(done.is_ok());
            for (lane, row) in plane[start * width..].chunks_exact_mut(width).take(LANES).enumerate() {
                for (o, values) in row.iter_mut().zip(&self.rows) {
                    *o = (*values * factor).0[lane];
                }
            }
        }
    }

    /// Sum of the squares of the plane that `spectrum` is of, by Parseval's theorem.
    pub fn energy(&self, spectrum: &[Complex]) -> f64 {
        let mut sum = 0.0;
        for (k, column) in spectrum.chunks_exact(self.height).enumerate() {
            let twin = k > 0 && 2 * k < self.width;
            let part: f64 = column.iter().map(|c| f64::from(c.norm_sqr())).sum();
            sum += if twin { 2.0 * part } else { part };
        }
        sum / self.plane_len() as f64
    }
}

/// Copies the coefficients of one lane.
fn pick(from: &[Complexes], lane: usize, to: &mut [Complex]) {
    for (o, v) in to.iter_mut().zip(from) {
        *o = Complex::new(v.re.0[lane], v.im.0[lane]);
    }
}

/// Turns lanes into places and places into lanes, at most four of each; lanes without a place become 0.
fn transpose(from: &[Complexes], to: &mut [Complexes]) {
    let from: [Complexes; LANES] = std::array::from_fn(|lane| from.get(lane).copied().unwrap_or(ZEROS));
    for (place, o) in (0..LANES).zip(to) {
        o.re.0 = from.map(|v| v.re.0[place]);
        o.im.0 = from.map(|v| v.im.0[place]);
    }
}

/// The symmetric Hann window of `n` samples, `(1 - cos(2 pi i / (n - 1))) / 2`: zero at both ends; `[1]` for one
/// sample.
pub fn hann(n: usize) -> Vec<f32> {
    if n == 1 {
        return vec![1.0];
    }
    let step = std::f64::consts::TAU / (n as f64 - 1.0);
    (0..n).map(|i| (0.5 - 0.5 * (step * i as f64).cos()) as f32).collect()
}

/// The product of the Hann windows of both sides, rows from the top.
pub fn hann_plane(width: usize, height: usize) -> Vec<f32> {
    let across = hann(width);
    hann(height).into_iter().flat_map(|v| across.iter().map(move |u| u * v)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    // python3: import numpy as np; x = np.array([[3, -1, 4, 1, 5], [9, 2, -6, 5, 3], [5, 8, 9, 7, -9.]])
    // np.fft.rfft2(x).T.round(6).tolist()
    const PLANE: [f32; 15] = [3.0, -1.0, 4.0, 1.0, 5.0, 9.0, 2.0, -6.0, 5.0, 3.0, 5.0, 8.0, 9.0, 7.0, -9.0];
    const SPECTRUM: [(f64, f64); 9] = [
        (45.0, 0.0),
        (-4.5, 6.062178),
        (-4.5, -6.062178),
        (3.291796, -5.983854),
        (20.083561, -8.074097),
        (-22.802408, 25.8869),
        (16.708204, -11.584192),
        (-7.93522, 20.651073),
        (-4.845933, 10.072762),
    ];

    #[test]
    fn agrees_with_numpy() {
        let mut fourier = Fourier::new(5, 3);
        let mut spectrum = vec![Complex::default(); fourier.spectrum_len()];
        fourier.forward(&PLANE, &mut spectrum);
        for (got, want) in spectrum.iter().zip(SPECTRUM) {
            let (re, im) = (f64::from(got.re), f64::from(got.im));
            assert!((re - want.0).abs() < 1e-5 && (im - want.1).abs() < 1e-5, "{got} {want:?}");
        }
    }

    /// Values that are exact in `f32`, the same everywhere.
    fn texture(n: usize) -> Vec<f32> {
        (0..n).map(|i| (i * 7919 % 1021) as f32 - 510.0).collect()
    }

    #[test]
    fn planes_do_not_see_their_neighbors() {
        for (width, height) in [(7, 1), (8, 1), (6, 5), (5, 6), (13, 4)] {
            let mut fourier = Fourier::new(width, height);
            let (n, m) = (fourier.plane_len(), fourier.spectrum_len());
            let (planes, window) = (texture(5 * n), texture(n));
            let mut together = vec![Complex::default(); 5 * m];
            fourier.forward_windowed(&planes, &window, &mut together);
            for (plane, spectrum) in planes.chunks_exact(n).zip(together.chunks_exact(m)) {
                let mut alone = vec![Complex::default(); m];
                Fourier::new(width, height).forward_windowed(plane, &window, &mut alone);
                assert_eq!(alone, spectrum, "{width} x {height}");
            }
        }
    }

    #[test]
    fn bits_are_the_same_on_every_processor() {
        // Of this code on x86-64; another processor that adds or multiplies differently has other sums.
        let sizes = [(40, 36), (37, 29), (33, 1)];
        let got = sizes.map(|(width, height)| {
            let mut fourier = Fourier::new(width, height);
            let mut spectrum = vec![Complex::default(); fourier.spectrum_len()];
            fourier.forward(&texture(width * height), &mut spectrum);
            let bits = spectrum.iter().flat_map(|c| [c.re.to_bits(), c.im.to_bits()]);
            bits.fold(0, |sum: u32, v| sum.rotate_left(5).wrapping_mul(0x9e37_79b1) ^ v)
        });
        assert_eq!(got, [1_726_952_598, 1_815_944_531, 3_698_792_439]);
    }

    // python3: np.hanning(6)
    #[test]
    fn window_agrees_with_numpy() {
        let want = [0.0, 0.3454915, 0.9045085, 0.9045085, 0.3454915, 0.0];
        assert!(hann(6).iter().zip(want).all(|(a, b)| (a - b).abs() < 1e-6));
        assert_eq!((hann(1), hann(2)), (vec![1.0], vec![0.0, 0.0]));
        let plane = hann_plane(3, 5);
        assert_eq!(plane.len(), 15);
        assert!((plane[2 * 3 + 1] - 1.0).abs() < 1e-6 && (plane[3 + 1] - 0.5).abs() < 1e-6);
    }

    proptest! {
        #[test]
        fn backward_inverts_forward(
            width in 1_usize..40, height in 1_usize..40,
            values in prop::collection::vec(-100.0_f32..100.0, 1600),
        ) {
            let plane = &values[..width * height];
            let mut fourier = Fourier::new(width, height);
            let mut spectrum = vec![Complex::default(); fourier.spectrum_len()];
            fourier.forward(plane, &mut spectrum);
            let energy: f64 = plane.iter().map(|&v| f64::from(v).powi(2)).sum();
            prop_assert!((fourier.energy(&spectrum) - energy).abs() <= 1e-5 * energy + 1e-6);
            let mut back = vec![0.0; plane.len()];
            fourier.backward(&spectrum, &mut back);
            for (a, b) in plane.iter().zip(&back) {
                prop_assert!((a - b).abs() < 1e-3, "{} {}", a, b);
            }
        }

        #[test]
        fn a_product_of_spectra_is_a_cyclic_convolution(
            width in 1_usize..9, height in 1_usize..9,
            values in prop::collection::vec(-1.0_f32..1.0, 128),
        ) {
            let n = width * height;
            let (a, b) = (&values[..n], &values[64..64 + n]);
            let mut fourier = Fourier::new(width, height);
            let mut spectra = [(); 2].map(|()| vec![Complex::default(); fourier.spectrum_len()]);
            fourier.forward(a, &mut spectra[0]);
            fourier.forward_windowed(b, &vec![2.0; n], &mut spectra[1]);
            let [mut product, other] = spectra;
            product.iter_mut().zip(&other).for_each(|(p, o)| *p *= o);
            let mut got = vec![0.0; n];
            fourier.backward(&product, &mut got);
            for y in 0..height {
                for x in 0..width {
                    let mut want = 0.0;
                    for v in 0..height {
                        for u in 0..width {
                            let (s, t) = ((x + width - u) % width, (y + height - v) % height);
                            want += a[v * width + u] * 2.0 * b[t * width + s];
                        }
                    }
                    prop_assert!((got[y * width + x] - want).abs() < 1e-4);
                }
            }
        }
    }
}
