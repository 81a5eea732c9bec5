//! Samples stored as sums in fixed cells.
//!
//! ```text
//! cell i:  e^(i/W) <= x / 1e-6 < e^((i+1)/W),   W = 20000 / ln 1e12,   i = 0..19999
//! kept per cell:  count,   sum of x,   sum of ln x
//! ```
//!
//! A cell spans 0.14 %. `x` is in the samples' unit, which should be such that the samples lie within
//! 1e-6 .. 1e6 (ratios do). The sums are kept as integers: `x` as a multiple of a power of two that suits
//! the cell and makes the conversion exact, `ln x` rounded to multiples of 2^-56. Integers add without
//! rounding, so neither the order of the samples nor a merge of parts changes a bit.

use serde::{Deserialize, Serialize};
use std::f64::consts::LN_2;
use std::sync::LazyLock;

/// Least sample. Smaller ones, mostly zeros, count as this value, since `ln 0` is undefined.
pub const FLOOR: f64 = 1e-6;

/// Samples from this value on share the last cell.
const CEILING: f64 = 1e6;

/// Number of cells.
const CELLS: usize = 20_000;

/// Fractional bits of a stored `ln x`.
const LN_BITS: i32 = 56;

/// Bits of a stored `x`: the 53 bits of a float, and more for the octave that a cell may straddle.
const X_BITS: i32 = 56;

/// Largest sample. Larger ones could overflow the sums of the last cell.
const MAX_SAMPLE: f64 = 1e12;

/// Error for a sample that cannot be binned.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error("a sample must be a number from 0 to {MAX_SAMPLE:e}, not {0}")]
pub struct SampleError(pub f64);

#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
struct Cell {
    count: u64,
    /// Sum of `x`, in units of `UNITS[i]`.
    x: u128,
    /// Sum of `ln x`, in units of 2^-LN_BITS.
    ln: i128,
}

/// Samples in fixed cells.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Binned {
    cells: Vec<Cell>,
    count: u64,
    clipped: Clipped,
}

/// Nonempty cells in ascending order, as the fit uses them.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Cells {
    /// Number of samples in each cell.
    pub count: Vec<f64>,
    /// Mean of `x` in each cell.
    pub x: Vec<f64>,
    /// Mean of `ln x` in each cell.
    pub ln: Vec<f64>,
    /// Number of all samples.
    pub total: f64,
}

/// Numbers of samples outside the range of the cells.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Clipped {
    /// Samples below [`FLOOR`], which count as [`FLOOR`].
    pub floored: u64,
    /// Samples from 1e6 on. They keep their value, but share one cell.
    pub above: u64,
}

impl Default for Binned {
    fn default() -> Self {
        Self { cells: vec![Cell::default(); CELLS], count: 0, clipped: Clipped::default() }
    }
}

impl Binned {
    /// Bins samples in one pass.
    ///
    /// # Errors
    /// See [`Binned::add`].
    pub fn new(samples: impl IntoIterator<Item = f64>) -> Result<Self, SampleError> {
        let mut binned = Self::default();
        samples.into_iter().try_for_each(|x| binned.add(x))?;
        Ok(binned)
    }

    /// Adds one sample.
    ///
    /// # Errors
    /// A sample that is negative, not finite, or above 1e12. It is not added.
    pub fn add(&mut self, x: f64) -> Result<(), SampleError> {
        if !(0.0..=MAX_SAMPLE).contains(&x) {
            return Err(SampleError(x));
        }
        self.count += 1;
        self.clipped.floored += u64::from(x < FLOOR);
        self.clipped.above += u64::from(x >= CEILING);
        let x = x.max(FLOOR);
        let ln = x.ln();
        let i = index(ln);
        let cell = &mut self.cells[i];
        cell.count += 1;
        cell.x += (x / UNITS[i]) as u128;
        cell.ln += (ln * 2.0_f64.powi(LN_BITS)).round_ties_even() as i128;
        Ok(())
    }

    /// Number of samples.
    pub fn count(&self) -> u64 {
        self.count
    }

    /// Numbers of samples outside the range of the cells.
    pub fn clipped(&self) -> Clipped {
        self.clipped
    }

    /// Nonempty cells, with each `group` neighbors merged. Sums stay exact until the division.
    pub(super) fn cells(&self, group: usize) -> Cells {
        let mut out = Cells { count: Vec::new(), x: Vec::new(), ln: Vec::new(), total: self.count as f64 };
        for (g, cells) in self.cells.chunks(group.max(1)).enumerate() {
            let (mut count, mut ln, mut x) = (0_u64, 0_i128, 0.0);
            for (j, cell) in cells.iter().enumerate().filter(|(_, cell)| cell.count > 0) {
                count += cell.count;
                ln += cell.ln;
                x += cell.x as f64 * UNITS[g * group + j];
            }
            if count > 0 {
                out.count.push(count as f64);
                out.x.push(x / count as f64);
                out.ln.push(ln as f64 * 2.0_f64.powi(-LN_BITS) / count as f64);
            }
        }
        out
    }
}

/// Index of the cell of a sample with this logarithm.
fn index(ln: f64) -> usize {
    let width = CELLS as f64 / (CEILING / FLOOR).ln();
    (((ln - FLOOR.ln()) * width).max(0.0) as usize).min(CELLS - 1)
}

/// Unit in which the `x` of a cell are counted: 2^-X_BITS of the octave in which the previous cell begins. So
/// a sample is an exact multiple even if `ln` is rounded into the wrong cell.
static UNITS: LazyLock<Vec<f64>> = LazyLock::new(|| {
    let width = CELLS as f64 / (CEILING / FLOOR).ln();
    let octave = |i: usize| ((FLOOR.ln() + (i as f64 - 1.0) / width) / LN_2).floor() as i32;
    (0..CELLS).map(|i| 2.0_f64.powi(octave(i) - X_BITS)).collect()
});

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn a_kept_sum_of_one_sample_is_the_sample() {
        for k in 0..4000 {
            let x = FLOOR * (27.6 * f64::from(k) / 3999.0).exp();
            let cells = Binned::new([x]).unwrap().cells(1);
            assert_eq!(cells.x, [x]);
            assert!((cells.ln[0] - x.ln()).abs() <= 2.0_f64.powi(-56));
        }
    }

    #[test]
    fn samples_out_of_range_are_counted_or_refused() {
        let binned = Binned::new([0.0, 1e-9, 1e-6, 3.0, 1e6, 1e12]).unwrap();
        assert_eq!((binned.count(), binned.clipped()), (6, Clipped { floored: 2, above: 2 }));
        let cells = binned.cells(1);
        assert_eq!(cells.count, [3.0, 1.0, 2.0]);
        assert_eq!(cells.x[2], (1e6 + 1e12) / 2.0);
        for bad in [-1e-300, f64::NAN, f64::INFINITY, 2e12] {
            assert!(Binned::new([1.0, bad]).is_err());
        }
    }

    #[test]
    fn a_cell_is_about_a_seventh_of_a_percent_wide() {
        let x: Vec<f64> = (0..=1_000_000).map(|k| 1.0 + f64::from(k) * 1e-6).collect();
        let cells = Binned::new(x).unwrap().cells(1);
        // ln 2 of ln 1e12 = 27.63 is 501.7 of 20000 cells.
        assert!((501..=503).contains(&cells.count.len()), "{}", cells.count.len());
    }

    proptest! {
        #[test]
        fn order_does_not_matter(x in prop::collection::vec(0.0..20.0_f64, 0..300)) {
            let whole = Binned::new(x.iter().copied()).unwrap();
            let backwards = Binned::new(x.iter().rev().copied()).unwrap();
            prop_assert_eq!(&whole, &backwards);
            let kept: f64 = { let c = whole.cells(16); c.count.iter().zip(&c.x).map(|(n, x)| n * x).sum() };
            let want: f64 = x.iter().map(|v| v.max(FLOOR)).sum();
            prop_assert!((kept - want).abs() <= 1e-12 * want);
        }
    }
}
