//! Histograms of oriented gradients in the 31-channel form of Felzenszwalb et al. ("Object detection with
//! discriminatively trained part-based models", PAMI 32(9), 2010, section 6), as Dollar's toolbox computes
//! them ("FHOG"): the features of most correlation filter trackers.
//!
//! ```text
//! g(p)       = ((I(x + 1, y) - I(x - 1, y)) / 2, (I(x, y + 1) - I(x, y - 1)) / 2)       one-sided at the border
//! b(p)       = round(angle(g) 18 / (2 pi)) mod 18                                       halves up
//! R(c, b)    = sum over the pixels p of orientation b: |g(p)| / k^2, shared bilinearly among the four cells c
//!              whose centers are nearest (none when k = 1); cells of the border times 8/7, of a corner twice
//! E(c)       = sum_{b < 9} (R(c, b) + R(c, b + 9))^2
//! N_i(c)     = 1 / sqrt(E summed over a block of 2 x 2 cells with c + 1e-4 / (4 k^4)),  i = 1..4
//! f_b(c)     = 1/2 sum_i min(R(c, b) N_i, 0.2)                             channels  0..18: signed
//! f_18+b(c)  = 1/2 sum_i min((R(c, b) + R(c, b + 9)) N_i, 0.2)             channels 18..27: unsigned
//! f_26+i(c)  = 0.2357 sum_{b < 18} min(R(c, b) N_i, 0.2)                   channels 27..31: texture
//! ```
//!
//! `I` are the planes of a [`Patch`], of which the one with the largest gradient counts (the first among equals);
//! `k` is the side of a cell in pixels. There are `floor(w / k)` x `floor(h / k)` cells; pixels beyond the last whole
//! cell only serve the gradients of their neighbors. Blocks at the border are the nearest ones inside, of a
//! single row or column of cells that row or column twice. Blocks are in the order right below, right above, left
//! below, left above. Values are in `[0, 0.4]`, textures in `[0, 0.85]`; they do not depend on the contrast as long as
//! it is well above `1e-2`, so the unit of `I` matters little.
//!
//! Deviations from the toolbox: square roots are exact (its are good to 1e-3); the angle is found by comparing the two
//! sides of `g` with tangents instead of by a table; the 32nd channel, all zeros, is left out; a gradient of 0 is
//! 0 (its is 1e-10).

mod pixels;

use super::patch::Patch;
use multiversion::multiversion;

/// Channels, without the constant one.
pub const CHANNELS: usize = 31;
/// Number of signed orientations.
const SIGNED: usize = 18;
/// Tangents of the angles between the orientations of a quadrant: 10, 30, 50 and 70 degrees.
const TANGENTS: [f32; 4] = [0.176_326_98, 0.577_350_26, 1.191_753_6, 2.747_477_4];
/// Upper bound of a normalized value.
const CLIP: f32 = 0.2;
/// Weight of the texture channels.
const TEXTURE: f32 = 0.2357;

/// Buffers for [`Hog::compute`]. They grow to the largest patch so far and are reused.
#[derive(Debug, Clone, Default)]
pub struct Hog {
    /// Magnitudes of a row's gradients; the orientations follow in `bins`.
    magnitudes: Vec<f32>,
    bins: Vec<i32>,
    /// Cell to the left of the pixels of each column (-1 is stored as 0), and the weight of the next cell.
    columns: Vec<(usize, f32)>,
    /// For each row of cells, 18 lines of cells. There is one further cell on all sides.
    histogram: Vec<f32>,
    energy: Vec<f32>,
    /// `N` of the blocks, `(w + 1) * (h + 1)`: the block at `(x, y)` ends with cell `(x, y)`.
    norms: Vec<f32>,
    textures: Vec<f32>,
}

impl Hog {
    /// Computes the [`CHANNELS`] channels of a patch with cells of `cell` pixels into `features`: channel by
    /// channel, rows of cells from the top. Returns the columns and rows of cells.
    pub fn compute(&mut self, patch: &Patch, cell: usize, features: &mut Vec<f32>) -> (usize, usize) {
        let cell = cell.max(1);
        let (w, h) = (patch.width / cell, patch.height / cell);
        features.clear();
        features.resize(CHANNELS * w * h, 0.0);
        if w * h > 0 {
            self.sum_gradients(patch, cell, w, h);
            self.weigh_border(w, h);
            self.find_norms(cell, w, h);
            for y in 0..h {
                self.normalize(y, w, h, features);
            }
        }
        (w, h)
    }

    fn sum_gradients(&mut self, patch: &Patch, cell: usize, w: usize, h: usize) {
        let line = w + 2;
        self.histogram.clear();
        self.histogram.resize((h + 2) * SIGNED * line, 0.0);
        // The cell centers left (above) of a pixel, and how far the pixel is from there to the next.
        let between = |i: usize| -> (usize, f32) {
            if cell == 1 {
                return (i + 1, 0.0);
            }
            let place = (i as f64 + 0.5) / cell as f64 - 0.5;
            let first = place.floor();
            ((first + 1.0) as usize, (place - first) as f32)
        };
        self.columns.clear();
        self.columns.extend((0..w * cell).map(between));
        let unit = 1.0 / (cell * cell) as f32;
        for y in 0..h * cell {
            self.find_gradients(patch, y);
            let (above, share) = between(y);
            let stride = SIGNED * line;
            let (upper, lower) =
                self.histogram[above * stride..(above + 2).min(h + 2) * stride].split_at_mut(stride);
            let pixels = self.columns.iter().zip(self.magnitudes.iter().zip(&self.bins));
            if cell == 1 {
                for (&(x, _), (m, &bin)) in pixels {
                    upper[bin as usize * line + x] = *m;
                }
                continue;
            }
            for (&(x, part), (m, &bin)) in pixels {
                let at = bin as usize * line + x;
                let (below, above) = (m * unit * share, m * unit * (1.0 - share));
                let (Some(upper), Some(lower)) = (upper.get_mut(at..at + 2), lower.get_mut(at..at + 2))
                else {
                    continue;
                };
                upper[0] += above * (1.0 - part);
                upper[1] += above * part;
                lower[0] += below * (1.0 - part);
                lower[1] += below * part;
            }
        }
    }

    /// Magnitudes and orientations of a row, from the plane with the strongest gradient at each pixel.
    fn find_gradients(&mut self, patch: &Patch, y: usize) {
        let (w, h) = (patch.width, patch.height);
        self.magnitudes.resize(w, 0.0);
        self.bins.resize(w, 0);
        let (above, below) = (y.saturating_sub(1), (y + 1).min(h - 1));
        let factor = if below - above == 2 { 0.5 } else { 1.0 };
        let row = |c: usize, y: usize| &patch.values[(c * h + y) * w..][..w];
        for (x, left, right) in [(0, 0, 1.min(w - 1)), (w - 1, w.saturating_sub(2), w - 1)] {
            let mut strongest = Strongest::default();
            for c in 0..patch.planes() {
                let here = row(c, y);
                strongest.add(here[right] - here[left], (row(c, below)[x] - row(c, above)[x]) * factor);
            }
            (self.magnitudes[x], self.bins[x]) = strongest.polar();
        }
        if w < 3 {
            return;
        }
        let inner = 1..w - 1;
        let sides = |c: usize| {
            [
                &row(c, y)[..w - 2],
                &row(c, y)[2..],
                &row(c, above)[inner.clone()],
                &row(c, below)[inner.clone()],
            ]
        };
        let (magnitudes, bins) = (&mut self.magnitudes[inner.clone()], &mut self.bins[inner.clone()]);
        // A plane that is there twice changes nothing.
        match patch.planes() {
            1 => gradients(sides(0), factor, magnitudes, bins),
            n => strongest_gradients(sides(0), sides(1), sides(n - 1), factor, magnitudes, bins),
        }
    }

    /// Raises cells at the border, which lack an eighth of their gradients.
    fn weigh_border(&mut self, w: usize, h: usize) {
        let line = w + 2;
        for y in 0..h {
            let rows = &mut self.histogram[(y + 1) * SIGNED * line..(y + 2) * SIGNED * line];
            rows.chunks_exact_mut(line).for_each(|row| weigh_row(&mut row[1..=w], y, h));
        }
    }

    fn find_norms(&mut self, cell: usize, w: usize, h: usize) {
        let line = w + 2;
        self.energy.clear();
        self.energy.resize(w * h, 0.0);
        for (y, energy) in self.energy.chunks_exact_mut(w).enumerate() {
            let rows = &self.histogram[(y + 1) * SIGNED * line..(y + 2) * SIGNED * line];
            let (ahead, back) = rows.split_at(SIGNED / 2 * line);
            for (a, b) in ahead.chunks_exact(line).zip(back.chunks_exact(line)) {
                for ((e, a), b) in energy.iter_mut().zip(&a[1..]).zip(&b[1..]) {
                    *e += (a + b) * (a + b);
                }
            }
        }
        self.invert_blocks(cell, w, h);
    }

    /// Computes `norms` from `energy`.
    fn invert_blocks(&mut self, cell: usize, w: usize, h: usize) {
        let least = (1e-4 / 4.0 / (cell as f64).powi(4)) as f32;
        self.norms.clear();
        for y in 0..=h {
            let (above, below) = block(y, h);
            for x in 0..=w {
                let (left, right) = block(x, w);
                let at = |x: usize, y: usize| self.energy[y * w + x];
                let sum = at(left, above) + at(right, above) + at(left, below) + at(right, below);
                self.norms.push(1.0 / (sum + least).sqrt());
            }
        }
    }

    fn normalize(&mut self, y: usize, w: usize, h: usize, features: &mut [f32]) {
        let line = w + 2;
        let rows = &self.histogram[(y + 1) * SIGNED * line..(y + 2) * SIGNED * line];
        let norms = |x: usize, y: usize| &self.norms[y * (w + 1) + x..][..w];
        let norms = [norms(1, y + 1), norms(1, y), norms(0, y + 1), norms(0, y)];
        self.textures.clear();
        self.textures.resize(4 * w, 0.0);
        let mut channels = features.chunks_exact_mut(w * h).map(|c| &mut c[y * w..(y + 1) * w]);
        for (row, out) in rows.chunks_exact(line).zip(channels.by_ref()) {
            signed(&row[1..=w], norms, out, &mut self.textures);
        }
        let (ahead, back) = rows.split_at(SIGNED / 2 * line);
        let pairs = ahead.chunks_exact(line).zip(back.chunks_exact(line));
        for ((a, b), out) in pairs.zip(channels.by_ref()) {
            unsigned(&a[1..=w], &b[1..=w], norms, out);
        }
        for (texture, out) in self.textures.chunks_exact(w).zip(channels) {
            out.iter_mut().zip(texture).for_each(|(o, t)| *o = TEXTURE * t);
        }
    }
}

/// Raises the cells of row `y` of `h` that are at the border.
fn weigh_row(row: &mut [f32], y: usize, h: usize) {
    for at_border in [y == 0, y == h - 1] {
        if at_border {
            row.iter_mut().for_each(|v| *v *= 8.0 / 7.0);
        }
    }
    row[0] *= 8.0 / 7.0;
    row[row.len() - 1] *= 8.0 / 7.0;
}

/// First and last cell of block `i` in `0..=count` along a side.
fn block(i: usize, count: usize) -> (usize, usize) {
    if count == 1 {
        return (0, 0);
    }
    let last = i.clamp(1, count - 1);
    (last - 1, last)
}

/// Strongest of several gradients.
#[derive(Debug, Clone, Copy, Default)]
struct Strongest {
    across: f32,
    down: f32,
    square: f32,
}

impl Strongest {
    #[inline(always)]
    fn add(&mut self, across: f32, down: f32) {
        let square = across * across + down * down;
        let stronger = square > self.square;
        self.across = if stronger { across } else { self.across };
        self.down = if stronger { down } else { self.down };
        self.square = if stronger { square } else { self.square };
    }

    /// Magnitude and orientation of the gradient.
    #[inline(always)]
    fn polar(self) -> (f32, i32) {
        (self.square.sqrt(), orientation(self.across, self.down))
    }
}

/// Magnitudes and orientations of gradients, from the pixels on the left, right, above and below.
#[multiversion(targets("x86_64+avx2"))]
fn gradients(sides: [&[f32]; 4], factor: f32, magnitudes: &mut [f32], bins: &mut [i32]) {
    let n = magnitudes.len();
    let [l, r, u, b] = sides;
    let (l, r, u, b, bins) = (&l[..n], &r[..n], &u[..n], &b[..n], &mut bins[..n]);
    for x in 0..n {
        let mut strongest = Strongest::default();
        strongest.add((r[x] - l[x]) * 0.5, (b[x] - u[x]) * factor);
        (magnitudes[x], bins[x]) = strongest.polar();
    }
}

/// Like [`gradients`], for the strongest of three planes.
#[multiversion(targets("x86_64+avx2"))]
fn strongest_gradients(
    first: [&[f32]; 4],
    second: [&[f32]; 4],
    third: [&[f32]; 4],
    factor: f32,
    magnitudes: &mut [f32],
    bins: &mut [i32],
) {
    let n = magnitudes.len();
    let ([l0, r0, u0, b0], [l1, r1, u1, b1], [l2, r2, u2, b2]) = (first, second, third);
    let (l0, r0, u0, b0) = (&l0[..n], &r0[..n], &u0[..n], &b0[..n]);
    let (l1, r1, u1, b1) = (&l1[..n], &r1[..n], &u1[..n], &b1[..n]);
    let (l2, r2, u2, b2) = (&l2[..n], &r2[..n], &u2[..n], &b2[..n]);
    let bins = &mut bins[..n];
    for x in 0..n {
        let mut strongest = Strongest::default();
        strongest.add((r0[x] - l0[x]) * 0.5, (b0[x] - u0[x]) * factor);
        strongest.add((r1[x] - l1[x]) * 0.5, (b1[x] - u1[x]) * factor);
        strongest.add((r2[x] - l2[x]) * 0.5, (b2[x] - u2[x]) * factor);
        (magnitudes[x], bins[x]) = strongest.polar();
    }
}

#[inline(always)]
fn orientation(gx: f32, gy: f32) -> i32 {
    let (u, v) = (gx.abs(), gy.abs());
    let mut steep = 0;
    for t in TANGENTS {
        steep += i32::from(v > t * u);
    }
    // A vertical gradient lies between two orientations and counts for the larger one.
    let left = (gx < 0.0) | ((gx == 0.0) & (gy > 0.0));
    let turned = if left { 9 } else { 0 };
    let turned = if (gy < 0.0) == left { turned + steep } else { turned - steep };
    if turned < 0 { turned + 18 } else { turned }
}

#[multiversion(targets("x86_64+avx2"))]
fn signed(row: &[f32], norms: [&[f32]; 4], out: &mut [f32], textures: &mut [f32]) {
    out.fill(0.0);
    for (n, texture) in norms.iter().zip(textures.chunks_exact_mut(row.len())) {
        for (((o, t), r), n) in out.iter_mut().zip(texture).zip(row).zip(n.iter()) {
            let v = cut(r * n);
            *o += v;
            *t += v;
        }
    }
    out.iter_mut().for_each(|o| *o *= 0.5);
}

#[multiversion(targets("x86_64+avx2"))]
fn unsigned(ahead: &[f32], back: &[f32], norms: [&[f32]; 4], out: &mut [f32]) {
    out.fill(0.0);
    for n in norms {
        for (((o, a), b), n) in out.iter_mut().zip(ahead).zip(back).zip(n) {
            *o += cut((a + b) * n);
        }
    }
    out.iter_mut().for_each(|o| *o *= 0.5);
}

/// The smaller of `v` and [`CLIP`]. Compiles to one instruction, unlike `min`, which handles NaN.
fn cut(v: f32) -> f32 {
    if v < CLIP { v } else { CLIP }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::oracle;
    use proptest::prelude::*;
    use serde::Deserialize;
    use trackfail_testing::assert_near;

    #[derive(Deserialize)]
    struct Case {
        width: usize,
        height: usize,
        planes: usize,
        cell: usize,
        features: Vec<f64>,
    }

    /// Patch made by `pixels` in `hog.py`.
    fn pixels(width: usize, height: usize, planes: usize) -> Patch {
        let value = |i: usize| {
            let (x, y, c) = (i % width, i / width % height, i / width / height);
            let seed = x * 7919 + y * 104_729 + c * 1_299_709;
            let noise = ((seed * 1_664_525 + 1_013_904_223) % (1 << 32)) >> 26;
            ((3 * x + x * y * (c + 1) / 2 + 40 * c) % 150 + noise) as f32
        };
        Patch { width, height, values: (0..planes * height * width).map(value).collect() }
    }

    fn hog(patch: &Patch, cell: usize) -> Vec<f32> {
        let mut out = Vec::new();
        Hog::default().compute(patch, cell, &mut out);
        out
    }

    #[test]
    fn agrees_with_a_transcription_in_numpy() {
        let cases: Vec<Case> = serde_json::from_value(oracle("hog")).unwrap();
        assert!(cases.len() >= 5);
        for case in cases {
            let patch = pixels(case.width, case.height, case.planes);
            let mut got = vec![7.0; 3];
            let size = Hog::default().compute(&patch, case.cell, &mut got);
            assert_eq!(size, (case.width / case.cell, case.height / case.cell));
            assert_near(got.into_iter().map(f64::from), case.features, 2e-5, case.cell);
        }
    }

    #[test]
    fn a_patch_without_contrast_has_no_features() {
        let flat = Patch { width: 17, height: 12, values: vec![200.0; 17 * 12 * 3] };
        assert!([1, 4].iter().all(|cell| hog(&flat, *cell).iter().all(|v| *v == 0.0)));
        assert!(hog(&Patch { width: 3, height: 9, values: vec![0.0; 27] }, 4).is_empty());
    }

    // A ramp in direction `angle` has this one orientation; compared with the rounded angle itself.
    #[test]
    fn orientations_are_rounded_angles() {
        for degrees in 0..360 {
            let angle = (f64::from(degrees) + 0.25).to_radians();
            let (c, s) = (angle.cos() as f32, angle.sin() as f32);
            let values = (0..81).map(|k| c * (k % 9) as f32 + s * (k / 9) as f32).collect();
            let out = hog(&Patch { width: 9, height: 9, values }, 9);
            let want = ((f64::from(degrees) + 0.25) / 20.0).round() as usize % 18;
            let strongest = (0..18).max_by(|&a, &b| out[a].total_cmp(&out[b])).unwrap();
            assert_eq!(strongest, want, "{degrees}");
        }
    }

    // 90 degrees are between orientations 4 and 5, 270 between 13 and 14: halves go up.
    #[test]
    fn vertical_gradients_go_to_the_next_orientation() {
        for (sign, want) in [(1.0, 5), (-1.0, 14)] {
            let values = (0..64).map(|k| 100.0 + sign * (k / 8) as f32).collect();
            let out = hog(&Patch { width: 8, height: 8, values }, 4);
            for (channel, values) in out[..18 * 4].chunks_exact(4).enumerate() {
                assert_eq!(values.iter().any(|&v| v > 0.0), channel == want, "{channel}");
            }
        }
    }

    proptest! {
        #[test]
        fn features_do_not_depend_on_contrast_and_keep_their_range(
            cell in 1_usize..6, width in 1_usize..30, height in 1_usize..30, doublings in 1..5,
        ) {
            // Powers of two, so that gradients between two orientations stay on their side.
            let patch = pixels(width, height, 3);
            let values: Vec<f32> = patch.values.iter().map(|v| v * f32::powi(2.0, doublings)).collect();
            let (one, other) = (hog(&patch, cell), hog(&Patch { values, ..patch }, cell));
            let n = (width / cell) * (height / cell);
            for (k, (a, b)) in one.iter().zip(&other).enumerate() {
                prop_assert!((a - b).abs() < 2e-3, "{} {}", a, b);
                let most = if k < 27 * n { 0.4 } else { 0.85 };
                prop_assert!((0.0..=most + 1e-3).contains(a), "{}", a);
            }
        }
    }
}
