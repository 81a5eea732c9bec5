//! Distribution fields (Sevilla-Lara and Learned-Miller, CVPR 2012) and the L1 distance between them.
//!
//! The field of an `h x w` window of layers `p(i, j)` in `0..M` is
//!
//! ```text
//! d(i, j, m)   = 1 when p(i, j) = m, else 0                                   (explode)
//! d'(i, j, m)  = sum_{k, r} g_v(k) g_u(r) d(i + k, j + r, m)                  (spatial smoothing)
//! d''(i, j, m) = sum_s g_l(s) d'(i, j, m + s) + (lost mass) / M               (layer smoothing)
//! ```
//!
//! with `g` Gaussians cut to an odd support and normalized. Layer smoothing loses the mass that leaves
//! `0..M`; it is spread evenly over the layers, so that every pixel keeps its mass.
//!
//! Only differences of two fields are needed. Common parts cancel: a border of uniform distributions and a
//! border of zeros give the same distance. The work is done column by column:
//!
//! - *Across and over layers* (`strip`): each pixel adds a stamp to the columns around it. Windows above
//!   each other share a strip, and with it this step.
//! - *Down* (`distance`): the difference of two columns is smoothed, and its absolute values are summed.
//!
//! Layers are stored in chunks of eight. For each group of eight rows, a mask lists the chunks that pixels
//! nearby can reach; the others are skipped. If only one of two fields reaches a chunk, all differences have
//! the same sign, and the absolute value of a single sum suffices.
//!
//! All numbers are `f32`. Weights are multiples of 2^-24, and their sums are exact. The remaining errors come
//! from the rounding of the weights (each sum of outer weights is within 2^-25) and of eight fused
//! multiplications per pixel. The distance differs by less than 1e-6 of its value from that in `f64`, in
//! practice by about 1e-8; a property in the tests compares the two. Windows that smoothing makes equal
//! almost everywhere are the exception: the error is below 1e-6 of `w * h` there.
//!
//! Each value is computed by the same operations whatever the processor has: the vector units of AVX2 and
//! AVX-512 only compute several at once, and a fused multiplication is exact in `f64` without its instruction.

use std::iter::zip;

mod chunk;
mod distance;
mod strip;

use distance::{Column, Distance, Down};
use strip::{Stamps, Strip};

/// Distributions assumed beyond the border of a window.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Border {
    /// A distribution common to all windows (uniform or zero), which cancels.
    Common,
    /// The border pixels of the window itself, repeated.
    Replicate,
}

/// A spatial smoothing, with its layer smoothing.
#[derive(Debug, Clone)]
pub struct Smoothing {
    border: Border,
    stamps: Stamps,
    down: Down,
}

/// Half of a Gaussian kernel of `2 * radius + 1` samples, normalized: weights for offsets `0..=radius`.
///
/// `sigma` is in samples and above 0.
pub fn gaussian(sigma: f64, radius: usize) -> Vec<f64> {
    let raw: Vec<f64> = (0..=radius).map(|r| (-0.5 * (r as f64 / sigma).powi(2)).exp()).collect();
    let sum = raw[0] + 2.0 * raw[1..].iter().sum::<f64>();
    raw.iter().map(|g| g / sum).collect()
}

/// Weights are multiples of `1 / UNITS`.
const UNITS: u32 = 1 << 24;

/// Converts a half kernel to integer weights with the sum `total`. Each sum of outer weights is within half a
/// unit.
fn whole(half: &[f64], total: u32) -> Vec<u32> {
    let mut units = vec![0; half.len()];
    let (mut beyond, mut taken) = (0.0, 0);
    for r in (1..half.len()).rev() {
        beyond += half[r];
        let all = (beyond * f64::from(total)).round() as u32;
        units[r] = all - taken;
        taken = all;
    }
    units[0] = total.saturating_sub(2 * taken);
    units
}

impl Smoothing {
    /// Smoothing of planes with `layers` (1 to 256) layers. The half kernels, as [`gaussian`] gives them, are
    /// horizontal, vertical and over layers.
    pub fn new(layers: usize, across: &[f64], down: &[f64], over_layers: &[f64], border: Border) -> Self {
        Self { border, stamps: Stamps::new(layers, across, over_layers), down: Down::new(down) }
    }
}

/// A window: rows of a strip, starting at `top`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Patch {
    /// Index of the strip.
    pub strip: usize,
    /// First row of the window within the strip.
    pub top: usize,
}

/// Buffers for [`FieldDistance::l1`]. They grow to the largest window so far and are reused.
#[derive(Debug, Default)]
pub struct FieldDistance {
    strips: Vec<Strip>,
    distance: Distance,
    /// Masks of the row groups of the target and of one other window.
    groups: [Vec<u8>; 2],
}

impl FieldDistance {
    /// Adds to `sums[a]` the L1 distance between the smoothed fields of the window `target` and of
    /// `others[a]`, summed over pixels and layers; between 0 and `2 * w * h`.
    ///
    /// Windows are `w` wide and `h` high. A strip is `w` wide and any number of rows high; its layers are
    /// stored column by column. Entries of `others` that are `None` leave their sum unchanged.
    pub fn l1(
        &mut self,
        smoothing: &Smoothing,
        (w, h): (usize, usize),
        strips: &[&[u8]],
        target: Patch,
        others: &[Option<Patch>],
        sums: &mut [f64],
    ) {
        let Smoothing { border, stamps, down } = smoothing;
        let Self { strips: buffers, distance, groups: [of_target, of_other] } = self;
        buffers.resize_with(strips.len().max(buffers.len()), Strip::default);
        for (strip, layers) in zip(&mut *buffers, strips) {
            strip.prepare(stamps, w, layers);
        }
        distance.prepare(down, h);
        for j in 0..w {
            for strip in &mut buffers[..strips.len()] {
                strip::smooth_column(strip, stamps, *border, j);
            }
            down.groups(&buffers[target.strip].near(j)[target.top..][..h], of_target);
            for (other, sum) in zip(others, &mut *sums) {
                let Some(other) = other else { continue };
                down.groups(&buffers[other.strip].near(j)[other.top..][..h], of_other);
                let a = Column { strip: &buffers[target.strip], top: target.top, groups: of_target };
                let b = Column { strip: &buffers[other.strip], top: other.top, groups: of_other };
                *sum += distance::l1(distance, smoothing, h, &a, &b);
            }
        }
    }
}

#[cfg(test)]
mod tests;
