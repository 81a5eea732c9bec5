//! The transform of a real line in `f64`.
//!
//! The code of the planner is compiled into the crate that names its number type; only this file does so.

use realfft::{ComplexToReal, RealFftPlanner, RealToComplex};
use std::sync::Arc;

/// A coefficient in the spectrum of a line.
pub type Complex64 = realfft::num_complex::Complex<f64>;

/// Plans and buffers for lines of one length.
pub struct LineFourier {
    forward: Arc<dyn RealToComplex<f64>>,
    backward: Arc<dyn ComplexToReal<f64>>,
    scratch: Vec<Complex64>,
}

impl LineFourier {
    /// Plans for lines of `length` values, at least 1.
    pub fn new(length: usize) -> Self {
        let mut planner = RealFftPlanner::new();
        let (forward, backward) =
            (planner.plan_fft_forward(length.max(1)), planner.plan_fft_inverse(length.max(1)));
        let scratch = forward.get_scratch_len().max(backward.get_scratch_len());
        Self { scratch: vec![Complex64::default(); scratch], forward, backward }
    }

    /// Number of values in a line.
    #[allow(clippy::len_without_is_empty)] // A line of no values has no transform.
    pub fn len(&self) -> usize {
        self.forward.len()
    }

    /// Number of stored coefficients, `len() / 2 + 1`. The others mirror them.
    pub fn spectrum_len(&self) -> usize {
        self.len() / 2 + 1
    }

    /// Transforms `line` (`len()` values) into `spectrum` (`spectrum_len()` coefficients). The line is
    /// overwritten.
    pub fn forward(&mut self, line: &mut [f64], spectrum: &mut [Complex64]) {
        let done = self.forward.process_with_scratch(line, spectrum, &mut self.scratch);
        debug_assert!(done.is_ok(), "buffers of the stated lengths");
    }

    /// Transforms `spectrum` back into the line times `len()`. The spectrum is overwritten.
    pub fn backward(&mut self, spectrum: &mut [Complex64], line: &mut [f64]) {
        // A real line has real ends; products of spectra may leave a rounding error there.
        spectrum[0].im = 0.0;
        if self.len().is_multiple_of(2) {
            spectrum[self.len() / 2].im = 0.0;
        }
        let done = self.backward.process_with_scratch(spectrum, line, &mut self.scratch);
        debug_assert!(done.is_ok(), "buffers of the stated lengths");
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use trackfail_testing::assert_near;

    // python3: import numpy as np; np.fft.rfft([3, -1, 4, 1, 5.])
    #[test]
    fn agrees_with_numpy_and_inverts() {
        let line = [3.0, -1.0, 4.0, 1.0, 5.0];
        let mut fourier = LineFourier::new(5);
        let (mut work, mut spectrum) = (line.to_vec(), vec![Complex64::default(); fourier.spectrum_len()]);
        fourier.forward(&mut work, &mut spectrum);
        let want = [12.0, 0.0, 0.190983005625, 3.942983340894, 1.309016994375, 6.37988106264];
        assert_near(spectrum.iter().flat_map(|c| [c.re, c.im]), want, 1e-9, "");
        fourier.backward(&mut spectrum, &mut work);
        assert_near(work, line.map(|v| 5.0 * v), 5e-12, "");
    }
}
