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
//! Any size works, primes too (by Rader's or Bluestein's algorithm). The transforms are `rustfft`'s; their last
//! bits depend on the processor's instruction set, so whole-number decisions must not hang on them.

mod line;

pub use line::{Complex64, LineFourier};
use realfft::{ComplexToReal, RealFftPlanner, RealToComplex};
use rustfft::{Fft, FftPlanner};
use std::sync::Arc;

/// A coefficient of a spectrum.
pub type Complex = realfft::num_complex::Complex<f32>;

/// Rows that are transposed together: eight coefficients fill a cache line.
const ROWS: usize = 8;

/// Plans and buffers for planes of one size.
pub struct Fourier {
    width: usize,
    height: usize,
    rows_forward: Arc<dyn RealToComplex<f32>>,
    rows_backward: Arc<dyn ComplexToReal<f32>>,
    columns_forward: Arc<dyn Fft<f32>>,
    columns_backward: Arc<dyn Fft<f32>>,
    row: Vec<f32>,
    spectra: Vec<Complex>,
    scratch: Vec<Complex>,
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
        Self {
            row: vec![0.0; width],
            spectra: vec![Complex::default(); ROWS * (width / 2 + 1)],
            scratch: vec![Complex::default(); scratch.into_iter().fold(0, usize::max)],
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

    /// Transforms `plane` (rows from the top) times `window` (the same layout) into `spectrum`.
    pub fn forward_windowed(&mut self, plane: &[f32], window: &[f32], spectrum: &mut [Complex]) {
        self.rows_to_columns(spectrum, |row, out| {
            let range = row * out.len()..(row + 1) * out.len();
            for ((o, v), w) in out.iter_mut().zip(&plane[range.clone()]).zip(&window[range]) {
                *o = v * w;
            }
        });
    }

    /// Transforms `plane` (rows from the top) into `spectrum`, without a factor.
    pub fn forward(&mut self, plane: &[f32], spectrum: &mut [Complex]) {
        self.rows_to_columns(spectrum, |row, out| {
            out.copy_from_slice(&plane[row * out.len()..(row + 1) * out.len()]);
        });
    }

    fn rows_to_columns(&mut self, spectrum: &mut [Complex], fill: impl Fn(usize, &mut [f32])) {
        let (kept, height) = (self.width / 2 + 1, self.height);
        for start in (0..height).step_by(ROWS) {
            let count = ROWS.min(height - start);
            for (i, line) in self.spectra.chunks_exact_mut(kept).take(count).enumerate() {
                fill(start + i, &mut self.row);
                // It only refuses buffers of other lengths than those that it was asked for.
                let done = self.rows_forward.process_with_scratch(&mut self.row, line, &mut self.scratch);
                debug_assert!(done.is_ok());
            }
            for (k, column) in spectrum.chunks_exact_mut(height).enumerate() {
                for (i, o) in column[start..start + count].iter_mut().enumerate() {
                    *o = self.spectra[i * kept + k];
                }
            }
        }
        if height > 1 {
            self.columns_forward.process_with_scratch(spectrum, &mut self.scratch);
        }
    }

    /// Transforms `spectrum` back into `plane`, with the factor `1 / (w h)`; the spectrum is overwritten.
    pub fn backward(&mut self, spectrum: &mut [Complex], plane: &mut [f32]) {
        let (kept, height) = (self.width / 2 + 1, self.height);
        if height > 1 {
            self.columns_backward.process_with_scratch(spectrum, &mut self.scratch);
        }
        let factor = 1.0 / self.plane_len() as f32;
        for start in (0..height).step_by(ROWS) {
            let count = ROWS.min(height - start);
            for (k, column) in spectrum.chunks_exact(height).enumerate() {
                for (i, v) in column[start..start + count].iter().enumerate() {
                    self.spectra[i * kept + k] = *v;
                }
            }
            for (i, line) in self.spectra.chunks_exact_mut(kept).take(count).enumerate() {
                // Real rows have real ends; products of spectra may leave a rounding error there.
                line[0].im = 0.0;
                if self.width.is_multiple_of(2) {
                    line[kept - 1].im = 0.0;
                }
                let out = &mut plane[(start + i) * self.width..(start + i + 1) * self.width];
                let done = self.rows_backward.process_with_scratch(line, out, &mut self.scratch);
                debug_assert!(done.is_ok());
                out.iter_mut().for_each(|v| *v *= factor);
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
            fourier.backward(&mut spectrum, &mut back);
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
            fourier.backward(&mut product, &mut got);
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
