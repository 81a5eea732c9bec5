//! Distribution fields (Sevilla-Lara and Learned-Miller, CVPR 2012) and the L1 distance between them.
//!
//! The field of an `h x w` plane of layers `p(i, j)` in `0..M` is
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
//! Only differences of two fields are needed and smoothing is linear, so the *difference* of the exploded
//! planes is smoothed. What both share cancels: a border of uniform distributions and a border of zeros
//! give the same distance. The sums are arranged for exactness and speed:
//!
//! - The field is computed a block of a row at a time. The vertical and the layer kernel are added together
//!   where the pixels are; their weights are multiples of 2^-45, so that these sums are exact in `f64` and
//!   equal planes cancel to 0 exactly.
//! - Layers lie contiguously, with slots below 0 and above `M - 1` that catch the lost mass.
//! - The two inner loops are also compiled for AVX2, which gives the same bits.
//! - The horizontal pass visits only the layers that occur near a pixel; the others hold exact zeros.

use multiversion::multiversion;

/// Layers that are processed together.
const LANES: usize = 8;
/// Columns that are processed together; their slots fit into a first-level cache.
const BLOCK: usize = 32;

/// Distributions beyond the border of a plane.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Border {
    /// The same distribution for every plane (uniform, zero): it cancels.
    Common,
    /// The plane's own border pixels, repeated.
    Replicate,
}

/// One spatial smoothing with the layer smoothing that goes with it.
#[derive(Debug, Clone)]
pub struct Smoothing {
    layers: usize,
    border: Border,
    /// Horizontal weights for offsets `0..=radius`.
    across: Vec<f64>,
    /// Vertical times layer weights: for each offset `0..=radius`, `width` weights.
    stamps: Vec<f64>,
    /// Weights of a stamp, padded with zeros to whole lanes.
    stamp_width: usize,
    layer_radius: usize,
}

/// A Gaussian cut to `2 * radius + 1` samples and normalized; weights for offsets `0..=radius`.
///
/// `sigma` is in samples and above 0.
pub fn gaussian(sigma: f64, radius: usize) -> Vec<f64> {
    let raw: Vec<f64> = (0..=radius).map(|r| (-0.5 * (r as f64 / sigma).powi(2)).exp()).collect();
    let sum = raw[0] + 2.0 * raw[1..].iter().sum::<f64>();
    raw.iter().map(|g| g / sum).collect()
}

impl Smoothing {
    /// Smoothing of planes with `layers` (1 to 256) layers by half kernels as [`gaussian`] gives them:
    /// horizontal, vertical and over the layers.
    pub fn new(layers: usize, across: Vec<f64>, down: &[f64], over_layers: &[f64], border: Border) -> Self {
        let layer_radius = over_layers.len() - 1;
        let stamp_width = (2 * layer_radius + 1).next_multiple_of(LANES);
        let unit = (1_u64 << 45) as f64;
        let mut stamps = vec![0.0; down.len() * stamp_width];
        for (stamp, g) in stamps.chunks_exact_mut(stamp_width).zip(down) {
            for (t, weight) in stamp[..=2 * layer_radius].iter_mut().enumerate() {
                *weight = (g * over_layers[t.abs_diff(layer_radius)] * unit).round() / unit;
            }
        }
        Self { layers, border, across, stamps, stamp_width, layer_radius }
    }

    /// Lanes of a pixel: the layers, `layer_radius` slots on either side, and room for a whole stamp.
    fn width(&self) -> usize {
        (self.layers - 1 + self.stamp_width).div_ceil(LANES)
    }

    /// Rows that the vertical kernel reaches up and down.
    fn reach(&self) -> usize {
        self.stamps.len() / self.stamp_width - 1
    }
}

/// Buffers for [`FieldDistance::l1`]; they grow to the largest plane seen and are then reused.
#[derive(Debug, Default)]
pub struct FieldDistance {
    /// A block of a vertically smoothed row of the first plane.
    first: Vec<[f64; LANES]>,
    /// Buffers of the other planes.
    others: Vec<Other>,
    /// Lowest and highest layer of each column of the first plane near the row.
    low: Vec<u8>,
    high: Vec<u8>,
    /// The same for both planes, padded sideways.
    near_low: Vec<u8>,
    near_high: Vec<u8>,
    slots: Vec<[f64; LANES]>,
}

/// Buffers for one of the other planes while a row is computed.
#[derive(Debug, Default)]
struct Other {
    /// The difference to the first plane: the columns that the next block still needs, then a block.
    difference: Vec<[f64; LANES]>,
    /// Lowest and highest layer near each pixel of the row: as far as the kernels reach.
    low: Vec<u8>,
    high: Vec<u8>,
}

impl FieldDistance {
    /// Adds to `sums[a]` the L1 distance between the smoothed fields of `plane` and `others[a]`, summed
    /// over pixels and layers; between 0 and `2 * w * h`. Planes are `w` wide, row by row, of one size,
    /// and hold layers below `smoothing.layers`. Entries of `others` that are `None` are left alone.
    pub fn l1(
        &mut self,
        smoothing: &Smoothing,
        w: usize,
        plane: &[u8],
        others: &[Option<&[u8]>],
        sums: &mut [f64],
    ) {
        let side = smoothing.across.len() - 1;
        let width = smoothing.width();
        self.first.resize(BLOCK * width, [0.0; LANES]);
        self.slots.resize(width, [0.0; LANES]);
        self.others.resize_with(others.len().max(self.others.len()), Other::default);
        for i in 0..plane.len() / w {
            self.find_layers(smoothing, w, plane, others, i);
            for (other, kept) in others.iter().zip(&mut self.others) {
                if other.is_some() {
                    kept.difference.resize((BLOCK + 2 * side) * width, [0.0; LANES]);
                    kept.difference[..2 * side * width].fill([0.0; LANES]);
                }
            }
            // Columns beyond the last one are needed to smooth up to it.
            for start in (0..w + side).step_by(BLOCK) {
                let end = (start + BLOCK).min(w + side);
                let (count, real) = (end - start, w.min(end).saturating_sub(start));
                self.first.fill([0.0; LANES]);
                let block = Block { w, i, start, count: real };
                stamp_rows::<false>(smoothing, plane, block, self.first.as_flattened_mut());
                for ((other, kept), sum) in others.iter().zip(&mut self.others).zip(sums.iter_mut()) {
                    let Some(other) = other else { continue };
                    let fresh = &mut kept.difference[2 * side * width..];
                    fresh.copy_from_slice(&self.first);
                    stamp_rows::<true>(smoothing, other, block, fresh.as_flattened_mut());
                    if smoothing.border == Border::Replicate {
                        kept.repeat_sides(width, side, block, end);
                    }
                    let centers = start.saturating_sub(side)..end.saturating_sub(side);
                    let skipped = side.saturating_sub(start).min(count) * width;
                    *sum += row_l1(
                        smoothing,
                        &kept.difference[skipped..],
                        &kept.low[centers.clone()],
                        &kept.high[centers],
                        &mut self.slots,
                    );
                    kept.difference.copy_within(count * width..(count + 2 * side) * width, 0);
                }
            }
        }
    }

    /// Lowest and highest layer near each pixel of row `i`, for every other plane.
    fn find_layers(
        &mut self,
        smoothing: &Smoothing,
        w: usize,
        plane: &[u8],
        others: &[Option<&[u8]>],
        i: usize,
    ) {
        let side = smoothing.across.len() - 1;
        let reach = smoothing.reach();
        let rows = i.saturating_sub(reach) * w..(i + reach + 1).min(plane.len() / w) * w;
        for bytes in [&mut self.low, &mut self.high] {
            bytes.resize(w, 0);
        }
        for (bytes, neutral) in [(&mut self.near_low, u8::MAX), (&mut self.near_high, 0)] {
            bytes.clear();
            bytes.resize(w + 2 * side, neutral);
        }
        self.low.fill(u8::MAX);
        self.high.fill(0);
        fold_rows(&plane[rows.clone()], &mut self.low, &mut self.high);
        for (other, kept) in others.iter().zip(&mut self.others) {
            let Some(other) = other else { continue };
            let (low, high) = (&mut self.near_low[side..side + w], &mut self.near_high[side..side + w]);
            low.copy_from_slice(&self.low);
            high.copy_from_slice(&self.high);
            fold_rows(&other[rows.clone()], low, high);
            kept.low.resize(w, 0);
            kept.high.resize(w, 0);
            kept.low.fill(u8::MAX);
            kept.high.fill(0);
            for r in 0..=2 * side {
                kept.low.iter_mut().zip(&self.near_low[r..]).for_each(|(l, &v)| *l = (*l).min(v));
                kept.high.iter_mut().zip(&self.near_high[r..]).for_each(|(h, &v)| *h = (*h).max(v));
            }
        }
    }
}

/// Takes the lowest and highest value of each column into `low` and `high`.
fn fold_rows(rows: &[u8], low: &mut [u8], high: &mut [u8]) {
    for row in rows.chunks_exact(low.len()) {
        low.iter_mut().zip(row).for_each(|(l, &v)| *l = (*l).min(v));
        high.iter_mut().zip(row).for_each(|(h, &v)| *h = (*h).max(v));
    }
}

impl Other {
    /// Gives the columns beside the plane the values of its first and last column.
    fn repeat_sides(&mut self, width: usize, side: usize, block: Block, end: usize) {
        let column = |j: usize| (j + 2 * side - block.start) * width;
        if block.start == 0 {
            for r in 1..=side {
                let at = column(0);
                self.difference.copy_within(at..at + width, at - r * width);
            }
        }
        let last = column(block.w) - width;
        for j in block.start.max(block.w)..end {
            self.difference.copy_within(last..last + width, column(j));
        }
    }
}

/// Columns `start .. start + count` of row `i` of a plane that is `w` wide.
#[derive(Debug, Clone, Copy)]
struct Block {
    w: usize,
    i: usize,
    start: usize,
    count: usize,
}

/// Adds (or takes away) the pixels of all rows that reach a block, smoothed vertically and over layers.
///
/// `row` holds `stride` slots a pixel; slot `s` is layer `s - layer_radius`.
#[multiversion(targets("x86_64+avx2"))]
fn stamp_rows<const MINUS: bool>(smoothing: &Smoothing, plane: &[u8], block: Block, row: &mut [f64]) {
    let Block { w, i, start, count } = block;
    if count == 0 {
        return;
    }
    let (stride, width) = (smoothing.width() * LANES, smoothing.stamp_width);
    let h = plane.len() / w;
    let reach = smoothing.reach();
    for k in 0..=2 * reach {
        // Row i + k - reach, where it exists or is repeated.
        let source = match ((i + k).checked_sub(reach), smoothing.border) {
            (Some(r), _) if r < h => r,
            (_, Border::Common) => continue,
            (None, Border::Replicate) => 0,
            (Some(_), Border::Replicate) => h - 1,
        };
        let offset = k.abs_diff(reach);
        let stamp = &smoothing.stamps[offset * width..(offset + 1) * width];
        let layers = &plane[source * w + start..source * w + start + count];
        for (stamp, shift) in stamp.chunks_exact(LANES).zip((0..).step_by(LANES)) {
            let Some(stamp) = stamp.first_chunk::<LANES>() else { continue };
            for (slots, &layer) in row.chunks_exact_mut(stride).zip(layers) {
                let at = usize::from(layer) + shift;
                for (s, g) in slots[at..at + LANES].iter_mut().zip(stamp) {
                    if MINUS {
                        *s -= g;
                    } else {
                        *s += g;
                    }
                }
            }
        }
    }
}

/// Smooths one row of a difference horizontally and sums its absolute values over pixels and layers.
#[multiversion(targets("x86_64+avx2"))]
fn row_l1(
    smoothing: &Smoothing,
    difference: &[[f64; LANES]],
    low: &[u8],
    high: &[u8],
    slots: &mut [[f64; LANES]],
) -> f64 {
    match smoothing.across.as_slice() {
        &[a, b, c, d, e] => row_l1_of(smoothing, &[a, b, c, d, e], difference, low, high, slots),
        across => row_l1_of(smoothing, across, difference, low, high, slots),
    }
}

/// [`row_l1`] for half kernels of a known or unknown length.
#[inline(always)]
fn row_l1_of(
    smoothing: &Smoothing,
    across: &[f64],
    difference: &[[f64; LANES]],
    low: &[u8],
    high: &[u8],
    slots: &mut [[f64; LANES]],
) -> f64 {
    let (width, radius, layers) = (smoothing.width(), smoothing.layer_radius, smoothing.layers);
    let side = across.len() - 1;
    let mut lanes = [0.0; LANES];
    let mut spread = 0.0;
    for (j, (&low, &high)) in low.iter().zip(high).enumerate() {
        let (low, high) = (usize::from(low), usize::from(high));
        // Slots `low ..= high + 2 * radius` may differ from 0.
        let (first, last) = (low / LANES, (high + 2 * radius) / LANES);
        let columns = &difference[j * width..(j + 2 * side + 1) * width];
        if low >= radius && high + radius < layers {
            // No mass is lost near this pixel.
            for at in first..=last {
                let sum = smooth(columns, width, across, at);
                for l in 0..LANES {
                    lanes[l] += sum[l].abs();
                }
            }
            continue;
        }
        for (slots, at) in slots[first..=last].iter_mut().zip(first..) {
            *slots = smooth(columns, width, across, at);
        }
        let (from, to) = (first * LANES, (last + 1) * LANES);
        let inner = from.max(radius)..to.min(layers + radius);
        let flat = slots.as_flattened_mut();
        let lost: f64 = flat[from..inner.start].iter().sum::<f64>() + flat[inner.end..to].iter().sum::<f64>();
        let even = lost / layers as f64;
        // These slots are not layers: with `-even` they add nothing below.
        flat[from..inner.start].fill(-even);
        flat[inner.end..to].fill(-even);
        for chunk in &slots[first..=last] {
            for l in 0..LANES {
                lanes[l] += (chunk[l] + even).abs();
            }
        }
        spread += (layers - inner.len()) as f64 * even.abs();
    }
    lanes.iter().sum::<f64>() + spread
}

/// Horizontal smoothing of the middle one of `columns` for the lanes `at`; a column has `width` lanes.
#[inline(always)]
fn smooth(columns: &[[f64; LANES]], width: usize, across: &[f64], at: usize) -> [f64; LANES] {
    let side = across.len() - 1;
    let mut sum = columns[side * width + at].map(|v| across[0] * v);
    // Columns to the left, from the middle outwards, beside those to the right.
    let left = columns[..side * width].chunks_exact(width).rev();
    let right = columns[(side + 1) * width..].chunks_exact(width);
    for ((g, a), b) in across[1..].iter().zip(left).zip(right) {
        let (a, b) = (&a[at], &b[at]);
        for l in 0..LANES {
            sum[l] += g * (a[l] + b[l]);
        }
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    // scipy.signal.windows.gaussian(5, 0.625) / its sum, from the middle on (SciPy 1.17.1).
    #[test]
    fn gaussian_agrees_with_scipy() {
        let expected = [0.6377442641723289, 0.177316693589983, 0.0038111743238525555];
        for (a, b) in gaussian(0.625, 2).iter().zip(expected) {
            assert!((a - b).abs() < 1e-15, "{a} {b}");
        }
    }

    fn smoothing(layers: usize, radii: (usize, usize, usize), border: Border) -> Smoothing {
        let (u, v, l) = radii;
        Smoothing::new(layers, gaussian(1.0, u), &gaussian(2.0, v), &gaussian(0.625, l), border)
    }

    fn l1(smoothing: &Smoothing, w: usize, a: &[u8], b: &[u8]) -> f64 {
        let mut sums = [0.0];
        FieldDistance::default().l1(smoothing, w, a, &[Some(b)], &mut sums);
        sums[0]
    }

    #[test]
    fn one_pixel_by_hand() {
        // Without neighbors the spatial kernel only scales by its middle weight.
        let s = smoothing(8, (1, 1, 0), Border::Common);
        let middle = gaussian(1.0, 1)[0] * gaussian(2.0, 1)[0];
        assert!((l1(&s, 1, &[3], &[5]) - 2.0 * middle).abs() < 1e-13);
        // Repeated pixels complete it to 1.
        let s = smoothing(8, (1, 1, 0), Border::Replicate);
        assert!((l1(&s, 1, &[3], &[5]) - 2.0).abs() < 1e-13);
    }

    #[test]
    fn lost_mass_is_spread_evenly() {
        // Layers 0 and 3 of 4, no spatial smoothing, g = (a, b, a): both lose `a`, the even parts cancel
        // and the difference is (b, a, -a, -b).
        let s = Smoothing::new(4, vec![1.0], &[1.0], &gaussian(0.625, 1), Border::Common);
        let [b, a] = gaussian(0.625, 1)[..] else { unreachable!() };
        assert!((l1(&s, 1, &[0], &[3]) - 2.0 * (a + b)).abs() < 1e-13);
        // Against layer 1 (a, b, a, 0) the first has (b, a, 0, 0) + a / 4.
        let expected = (b - a + a / 4.0).abs() + (a - b + a / 4.0).abs() + (a / 4.0 - a).abs() + a / 4.0;
        assert!((l1(&s, 1, &[0], &[1]) - expected).abs() < 1e-13);
    }

    fn planes() -> impl Strategy<Value = (usize, Vec<u8>, Vec<u8>)> {
        (1..40_usize, 1..12_usize).prop_flat_map(|(w, h)| {
            let plane = || proptest::collection::vec(0..20_u8, w * h);
            (Just(w), plane(), plane())
        })
    }

    proptest! {
        #[test]
        fn is_a_bounded_distance((w, a, b) in planes(), u in 0..12_usize, v in 0..9_usize, l in 0..6_usize) {
            for border in [Border::Common, Border::Replicate] {
                let s = smoothing(20, (u, v, l), border);
                prop_assert_eq!(l1(&s, w, &a, &a), 0.0);
                let d = l1(&s, w, &a, &b);
                prop_assert!((d - l1(&s, w, &b, &a)).abs() < 1e-10);
                prop_assert!(d >= 0.0 && d <= 2.0 * a.len() as f64 + 1e-9);
                // A second plane beside the first changes nothing, nor do buffers used before.
                let (mut sums, mut buffers) = ([0.0; 3], FieldDistance::default());
                buffers.l1(&s, w, &b, &[Some(&a), None, Some(&b)], &mut sums);
                sums = [0.0; 3];
                buffers.l1(&s, w, &a, &[None, Some(&b), Some(&a)], &mut sums);
                prop_assert_eq!(sums, [0.0, d, 0.0]);
            }
        }

        #[test]
        fn variants_for_processors_agree_bit_for_bit(
            lanes in proptest::collection::vec(proptest::array::uniform8(-1.0..1.0_f64), 5 * 20),
            low in 0..20_u8,
        ) {
            let s = smoothing(32, (4, 7, 2), Border::Common);
            let mut slots = vec![[0.0; LANES]; s.width()];
            let (low, high) = ([low; 12], [low + 9; 12]);
            let chosen = row_l1(&s, &lanes, &low, &high, &mut slots);
            let plain = row_l1_of(&s, &s.across, &lanes, &low, &high, &mut slots);
            prop_assert_eq!(chosen.to_bits(), plain.to_bits());
        }
    }
}
