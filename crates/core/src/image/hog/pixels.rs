//! Features of single pixels.
//!
//! A cell of one pixel has a single orientation `b`. So only two of its first 27 channels are nonzero, `b`
//! and `18 + b mod 9`, and both have the same value.

use super::{Hog, cut, weigh_row};
use crate::image::patch::Patch;
use multiversion::multiversion;

impl Hog {
    /// Orientations `0..18` and features of all pixels of a patch, rows from the top: the first 27 channels of
    /// [`Hog::compute`] with cells of one pixel, in short form.
    pub fn pixels(&mut self, patch: &Patch, orientations: &mut Vec<i32>, features: &mut Vec<f32>) {
        let (w, h) = (patch.width, patch.height);
        orientations.clear();
        features.clear();
        if w * h == 0 {
            return;
        }
        for y in 0..h {
            self.find_gradients(patch, y);
            let row = &mut self.magnitudes;
            weigh_row(row, y, h);
            features.extend_from_slice(row);
            orientations.extend_from_slice(&self.bins);
        }
        self.energy.clear();
        self.energy.extend(features.iter().map(|v| v * v));
        self.invert_blocks(1, w, h);
        for (y, row) in features.chunks_exact_mut(w).enumerate() {
            let (above, below) = self.norms[y * (w + 1)..(y + 2) * (w + 1)].split_at(w + 1);
            normalize(row, [&below[1..], &above[1..], &below[..w], &above[..w]]);
        }
    }
}

#[multiversion(targets("x86_64+avx2"))]
fn normalize(row: &mut [f32], norms: [&[f32]; 4]) {
    let [a, b, c, d] = norms;
    for ((((v, a), b), c), d) in row.iter_mut().zip(a).zip(b).zip(c).zip(d) {
        *v = 0.5 * (cut(*v * a) + cut(*v * b) + cut(*v * c) + cut(*v * d));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn are_cells_of_one_pixel(
            w in 1_usize..20, h in 1_usize..12, planes in 1_usize..4,
            values in prop::collection::vec(0_u8..9, 720),
        ) {
            let values = values[..planes * w * h].iter().map(|&v| f32::from(v)).collect();
            let patch = Patch { width: w, height: h, values };
            let (mut want, mut orientations, mut got) = (Vec::new(), Vec::new(), Vec::new());
            Hog::default().compute(&patch, 1, &mut want);
            Hog::default().pixels(&patch, &mut orientations, &mut got);
            for (channel, want) in want.chunks_exact(w * h).take(27).enumerate() {
                for ((&b, v), want) in orientations.iter().zip(&got).zip(want) {
                    let b = b as usize;
                    let has = channel == b || channel == 18 + b % 9;
                    prop_assert_eq!(if has { v.to_bits() } else { 0 }, want.to_bits());
                }
            }
        }
    }
}
