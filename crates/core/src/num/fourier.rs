//! Discrete Fourier transforms of real planes in `f32` and real lines in `f64`, and the Hann window applied
//! before them.
//!
//! ```text
//! X[k, l] = sum_{i, j} x[i, j] exp(-2 pi I (i k / w + j l / h))        i, k: columns, j, l: rows, from 0
//! x[i, j] = 1 / (w h) sum_{k, l} X[k, l] exp(+2 pi I (i k / w + j l / h))
//! ```
//!
//! The spectrum of a real plane is symmetric, `X[w - k, h - l] = conj X[k, l]`, so only the columns `0..=w /
//! 2` are kept, **four columns side by side**: `X[k, l]` is lane `k % 4` of the coefficient group at `k / 4 *
//! h + l`; lanes beyond the last column are 0. Products of spectra can be taken group by group. With `h = 1`
//! this is the transform of a line. A final group of zeros makes the number of groups even, for loops that
//! process two at a time.
//!
//! Any size works, primes too (by Rader's or Bluestein's algorithm). The algorithms are `rustfft`'s, four lines at a
//! time (`lanes`), and give the same bits on every processor.

mod lanes;
mod line;

pub use lanes::{LANES, Lanes, ZEROS};
pub use line::{Complex64, LineFourier};
use realfft::{ComplexToReal, RealFftPlanner, RealToComplex};
use rustfft::{Fft, FftPlanner};
use std::sync::Arc;

/// A coefficient of each of four columns, or of four lines.
pub type Complexes = realfft::num_complex::Complex<Lanes>;

/// Plans and buffers for planes of one size; clones share the plans.
#[derive(Clone)]
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
    /// Spectrum of the plane, or of each of four lines.
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
        let mut fourier = Self {
            rows: vec![Lanes::ZERO; width],
            spectra: vec![ZEROS; width / 2 + 1],
            columns: Vec::new(),
            scratch: vec![ZEROS; scratch.into_iter().fold(0, usize::max)],
            width,
            height,
            rows_forward,
            rows_backward,
            columns_forward,
            columns_backward,
        };
        fourier.columns = vec![ZEROS; fourier.spectrum_len() * if height > 1 { 1 } else { LANES }];
        fourier
    }

    /// Number of columns of the plane.
    pub fn width(&self) -> usize {
        self.width
    }

    /// Number of rows of the plane.
    pub fn height(&self) -> usize {
        self.height
    }

    /// Number of values of a plane, `width * height`.
    pub fn plane_len(&self) -> usize {
        self.width * self.height
    }

    /// Number of groups of four coefficients in a spectrum, an even number: `ceil((width / 2 + 1) / 4) *
    /// height` or one more.
    pub fn spectrum_len(&self) -> usize {
        ((self.width / 2 + 1).div_ceil(LANES) * self.height).next_multiple_of(2)
    }

    /// Number of groups of four rows in a plane. The last group may have fewer rows.
    pub fn row_groups(&self) -> usize {
        self.height.div_ceil(LANES)
    }

    /// Arranges the rows of a plane four side by side: column `x` of group `g` at `g * width + x`, with zeros
    /// for missing rows.
    pub fn side_by_side<T: Copy + Default>(&self, plane: &[T]) -> Vec<[T; LANES]> {
        let mut groups = vec![[T::default(); LANES]; self.row_groups() * self.width];
        for (group, rows) in groups.chunks_exact_mut(self.width).zip(plane.chunks(LANES * self.width)) {
            for (lane, row) in rows.chunks_exact(self.width).enumerate() {
                group.iter_mut().zip(row).for_each(|(o, v)| o[lane] = *v);
            }
        }
        groups
    }

    /// Transforms `plane` (rows from the top), without a factor.
    pub fn forward(&mut self, plane: &[f32]) -> &[Complexes] {
        self.forward_by(|i| plane[i])
    }

    /// Transforms the plane whose values, rows from the top, are `value(i)`.
    pub fn forward_by(&mut self, value: impl Fn(usize) -> f32) -> &[Complexes] {
        let (width, last, len) = (self.width, self.height - 1, self.spectrum_len());
        let spectra = self.forward_groups(|group, x| {
            Lanes(std::array::from_fn(|lane| value((LANES * group + lane).min(last) * width + x)))
        });
        &spectra[..len]
    }

    /// Transforms the plane whose rows `4 g ... 4 g + 3` have the values `value(g, x)`. With `h = 1` these
    /// are four lines, whose four spectra follow each other.
    pub fn forward_groups(&mut self, value: impl Fn(usize, usize) -> Lanes) -> &[Complexes] {
        let height = self.height;
        for group in 0..self.row_groups() {
            for (x, values) in self.rows.iter_mut().enumerate() {
                *values = value(group, x);
            }
            // It only refuses buffers of other lengths than those that it was asked for.
            let done =
                self.rows_forward.process_with_scratch(&mut self.rows, &mut self.spectra, &mut self.scratch);
            debug_assert!(done.is_ok());
            if height == 1 {
                let len = self.spectrum_len();
                for (place, four) in self.spectra.chunks(LANES).enumerate() {
                    let mut lines = [ZEROS; LANES];
                    transpose(four, &mut lines);
                    (0..LANES).for_each(|line| self.columns[line * len + place] = lines[line]);
                }
                return &self.columns;
            }
            let start = group * LANES;
            for (columns, four) in self.columns.chunks_exact_mut(height).zip(self.spectra.chunks(LANES)) {
                transpose(four, &mut columns[start..height.min(start + LANES)]);
            }
        }
        for group in self.columns.chunks_exact_mut(height) {
            self.columns_forward.process_with_scratch(group, &mut self.scratch);
        }
        &self.columns
    }

    /// Transforms `spectrum` back into `plane`, with the factor `1 / (w h)`.
    pub fn backward(&mut self, spectrum: &[Complexes], plane: &mut [f32]) {
        let (width, height) = (self.width, self.height);
        let factor = Lanes([1.0 / self.plane_len() as f32; LANES]);
        for (group, four) in self.columns.chunks_exact_mut(height).zip(spectrum.chunks_exact(height)) {
            group.copy_from_slice(four);
            self.columns_backward.process_with_scratch(group, &mut self.scratch);
        }
        for start in (0..height).step_by(LANES) {
            // A line's coefficients come out in the first lane, as those of a plane's last row may.
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

    /// Sum of squares of the plane with this `spectrum`, by Parseval's theorem.
    pub fn energy(&self, spectrum: &[Complexes]) -> f64 {
        let mut sum = 0.0;
        for (group, columns) in spectrum.chunks_exact(self.height).enumerate() {
            let mut parts = [0.0; LANES];
            for c in columns {
                let squares = c.norm_sqr().0;
                (0..LANES).for_each(|lane| parts[lane] += f64::from(squares[lane]));
            }
            for (lane, part) in parts.into_iter().enumerate() {
                let k = LANES * group + lane;
                let twin = k > 0 && 2 * k < self.width;
                sum += if twin { 2.0 * part } else { part };
            }
        }
        sum / self.plane_len() as f64
    }
}

/// Transposes lanes and places, at most four of each. Lanes without a place become 0.
#[inline(always)]
fn transpose(from: &[Complexes], to: &mut [Complexes]) {
    if let (Some(from), Some(to)) = (from.first_chunk(), to.first_chunk_mut()) {
        transpose_four(from, to);
    } else {
        let mut four = [ZEROS; LANES];
        from.iter().zip(&mut four).for_each(|(v, o)| *o = *v);
        let mut turned = [ZEROS; LANES];
        transpose_four(&four, &mut turned);
        to.iter_mut().zip(turned).for_each(|(o, v)| *o = v);
    }
}

#[inline(always)]
fn transpose_four([a, b, c, d]: &[Complexes; LANES], to: &mut [Complexes; LANES]) {
    for (place, o) in to.iter_mut().enumerate() {
        o.re = Lanes([a.re.0[place], b.re.0[place], c.re.0[place], d.re.0[place]]);
        o.im = Lanes([a.im.0[place], b.im.0[place], c.im.0[place], d.im.0[place]]);
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
    use trackfail_testing::assert_near;

    // python3: import numpy as np; x = np.array([[3, -1, 4, 1, 5], [9, 2, -6, 5, 3], [5, 8, 9, 7, -9.]])
    // np.fft.rfft2(x).T.round(6).tolist()
    const PLANE: [f32; 15] = [3.0, -1.0, 4.0, 1.0, 5.0, 9.0, 2.0, -6.0, 5.0, 3.0, 5.0, 8.0, 9.0, 7.0, -9.0];
    const SPECTRUM: [f64; 18] = [
        45.0, 0.0, -4.5, 6.062178, -4.5, -6.062178, 3.291796, -5.983854, 20.083561, -8.074097, -22.802408,
        25.8869, 16.708204, -11.584192, -7.93522, 20.651073, -4.845933, 10.072762,
    ];

    type Complex = realfft::num_complex::Complex<f32>;

    /// Coefficients of a spectrum, column by column.
    fn by_column(width: usize, height: usize, spectrum: &[Complexes]) -> Vec<Complex> {
        let at = |k: usize, l: usize| {
            let four = spectrum[k / LANES * height + l];
            Complex::new(four.re.0[k % LANES], four.im.0[k % LANES])
        };
        (0..=width / 2).flat_map(|k| (0..height).map(move |l| at(k, l))).collect()
    }

    #[test]
    fn agrees_with_numpy() {
        let spectrum = by_column(5, 3, Fourier::new(5, 3).forward(&PLANE));
        let got = spectrum.iter().flat_map(|c| [c.re, c.im]).map(f64::from);
        assert_near(got, SPECTRUM, 1e-5, "");
    }

    /// Values that are exact in `f32` on all processors.
    fn texture(n: usize) -> Vec<f32> {
        (0..n).map(|i| (i * 7919 % 1021) as f32 - 510.0).collect()
    }

    #[test]
    fn lines_do_not_see_their_neighbors() {
        for width in [7, 8, 1] {
            let lines = texture(4 * width);
            let mut fourier = Fourier::new(width, 1);
            let m = fourier.spectrum_len();
            let value = |_, x: usize| Lanes(std::array::from_fn(|lane| lines[lane * width + x]));
            let together = fourier.forward_groups(value).to_vec();
            for (line, spectrum) in lines.chunks_exact(width).zip(together.chunks_exact(m)) {
                assert_eq!(Fourier::new(width, 1).forward(line), spectrum, "{width}");
            }
        }
    }

    #[test]
    fn rows_may_stand_side_by_side_before() {
        for (width, height) in [(6, 5), (5, 6), (13, 4)] {
            let plane = texture(width * height);
            let mut fourier = Fourier::new(width, height);
            let rows = fourier.side_by_side(&plane);
            let got = fourier.forward_groups(|group, x| Lanes(rows[group * width + x])).to_vec();
            assert_eq!(Fourier::new(width, height).forward(&plane), got, "{width} x {height}");
        }
    }

    #[test]
    fn bits_are_the_same_on_every_processor() {
        // Of this code on x86-64; another processor that adds or multiplies differently has other sums.
        let sizes = [(40, 36), (37, 29), (33, 1)];
        let got = sizes.map(|(width, height)| {
            let mut fourier = Fourier::new(width, height);
            let spectrum = by_column(width, height, fourier.forward(&texture(width * height)));
            let bits = spectrum.iter().flat_map(|c| [c.re.to_bits(), c.im.to_bits()]);
            bits.fold(0, |sum: u32, v| sum.rotate_left(5).wrapping_mul(0x9e37_79b1) ^ v)
        });
        assert_eq!(got, [1_726_952_598, 1_815_944_531, 3_698_792_439]);
    }

    // python3: np.hanning(6)
    #[test]
    fn window_agrees_with_numpy() {
        let want = [0.0, 0.3454915, 0.9045085, 0.9045085, 0.3454915, 0.0];
        assert_near(hann(6).into_iter().map(f64::from), want, 1e-6, "");
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
            let spectrum = fourier.forward(plane).to_vec();
            let energy: f64 = plane.iter().map(|&v| f64::from(v).powi(2)).sum();
            prop_assert!((fourier.energy(&spectrum) - energy).abs() <= 1e-5 * energy + 1e-6);
            let mut back = vec![0.0; plane.len()];
            fourier.backward(&spectrum, &mut back);
            let [plane, back] = [plane, &back].map(|values| values.iter().map(|v| f64::from(*v)));
            assert_near(plane, back, 1e-3, "");
        }

        #[test]
        fn a_product_of_spectra_is_a_cyclic_convolution(
            width in 1_usize..9, height in 1_usize..9,
            values in prop::collection::vec(-1.0_f32..1.0, 128),
        ) {
            let n = width * height;
            let (a, b) = (&values[..n], &values[64..64 + n]);
            let mut fourier = Fourier::new(width, height);
            let mut product = fourier.forward(a).to_vec();
            let other = fourier.forward_by(|i| 2.0 * b[i]);
            product.iter_mut().zip(other).for_each(|(p, o)| *p = *p * o);
            let mut got = vec![0.0; n];
            fourier.backward(&product, &mut got);
            for (k, got) in got.iter().enumerate() {
                let term = |i: usize| {
                    let (s, t) = ((k % width + width - i % width) % width, (k / width + height - i / width) % height);
                    a[i] * 2.0 * b[t * width + s]
                };
                prop_assert!((got - (0..n).map(term).sum::<f32>()).abs() < 1e-4);
            }
        }
    }
}
