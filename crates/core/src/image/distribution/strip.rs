//! A strip smoothed horizontally and over layers, one column at a time.

use super::chunk::{Chunk, LANES};
use super::{Border, UNITS, whole};
use multiversion::multiversion;
use std::iter::zip;
use std::ops::Range;

/// Number of rows that are processed together.
pub(super) const ROWS: usize = 8;
/// Bit of a mask that marks lost mass. All other bits stand for chunks of layers.
pub(super) const LOSSY: u8 = 0x80;
/// Number of possible values of a layer.
const VALUES: usize = 256;

/// Weights that a pixel adds to the columns around it, for each layer.
#[derive(Debug, Clone)]
pub(super) struct Stamps {
    pub(super) layers: usize,
    side: usize,
    /// Number of chunks of layers: index of the further chunk that holds the lost mass in each slot.
    pub(super) lost: usize,
    /// For each chunk and layer, weights for offsets `0..=side`, padded with zeros to `stride`.
    table: Vec<Chunk>,
    stride: usize,
    /// Bit `g` of a mask stands for the chunks `g << shift .. (g + 1) << shift`.
    shift: usize,
    mask_of: Vec<u8>,
    /// Set of chunks for each mask.
    chunks_of: Vec<u64>,
}

impl Stamps {
    pub(super) fn new(layers: usize, across: &[f64], over_layers: &[f64]) -> Self {
        let (side, radius) = (across.len() - 1, over_layers.len() - 1);
        let chunks = layers.div_ceil(LANES);
        let stride = (side + 2).next_power_of_two();
        let shift = if chunks <= 7 { 0 } else { (chunks.div_ceil(7) - 1).ilog2() as usize + 1 };
        let mut table = vec![Chunk::ZERO; (chunks + 1) * VALUES * stride];
        let mut mask_of = vec![0_u8; VALUES];
        let units = whole(over_layers, UNITS);
        let of_offset: Vec<Vec<u32>> = units.iter().map(|&units| whole(across, units)).collect();
        let mut add = |chunk: usize, layer: usize, slots: Range<usize>, t: usize| {
            let pixel = &mut table[(chunk * VALUES + layer) * stride..];
            for (weights, &units) in zip(pixel, &of_offset[t.abs_diff(radius)]) {
                weights.0[slots.clone()].iter_mut().for_each(|w| *w += units as f32 / UNITS as f32);
            }
        };
        for (layer, mask) in mask_of.iter_mut().enumerate().take(layers) {
            for t in 0..=2 * radius {
                match (layer + t).checked_sub(radius) {
                    Some(slot) if slot < layers => {
                        *mask |= 1 << ((slot / LANES) >> shift);
                        add(slot / LANES, layer, slot % LANES..slot % LANES + 1, t);
                    }
                    _ => {
                        *mask |= LOSSY;
                        add(chunks, layer, 0..LANES, t);
                    }
                }
            }
        }
        let chunks_of = (0..=u8::MAX)
            .map(|mask| {
                let of_layers = (0..chunks).filter(|c| mask & !LOSSY & 1 << (c >> shift) != 0);
                of_layers.chain((mask & LOSSY != 0).then_some(chunks)).fold(0, |set, c| set | 1 << c)
            })
            .collect();
        Self { layers, side, lost: chunks, table, stride, shift, mask_of, chunks_of }
    }

    /// Bit of a chunk of layers in a mask.
    #[inline(always)]
    pub(super) fn bit(&self, chunk: usize) -> u8 {
        1 << (chunk >> self.shift)
    }

    /// Chunks of a mask as a set of bits.
    #[inline(always)]
    pub(super) fn chunks(&self, mask: u8) -> u64 {
        self.chunks_of[usize::from(mask)]
    }
}

/// Indices of the bits of a set.
#[inline(always)]
pub(super) fn ones(mut set: u64) -> impl Iterator<Item = usize> {
    std::iter::from_fn(move || {
        let at = set.trailing_zeros() as usize;
        (set != 0).then(|| {
            set &= set - 1;
            at
        })
    })
}

/// Union of all masks of a tile.
#[inline(always)]
pub(super) fn together(masks: &[u8; ROWS]) -> u8 {
    let m = u64::from_le_bytes(*masks);
    let m = m | m >> 32;
    let m = m | m >> 16;
    (m | m >> 8) as u8
}

/// Windows with the same left border, one above the other: a smoothed column, and the masks near each pixel.
/// Rows are padded to whole tiles of `ROWS`.
#[derive(Debug, Default)]
pub(super) struct Strip {
    rows: usize,
    /// Layers of the strip, column by column.
    layers: Vec<[u8; ROWS]>,
    masks: Vec<[u8; ROWS]>,
    /// Masks of the pixels in the same row, within the reach of the kernel.
    near: Vec<[u8; ROWS]>,
    /// Slots of the current column, chunk by chunk.
    slots: Vec<[Chunk; ROWS]>,
    /// Masks of the nonzero chunks in each tile.
    filled: Vec<u8>,
}

impl Strip {
    /// Prepares a strip of width `w`.
    pub(super) fn prepare(&mut self, stamps: &Stamps, w: usize, layers: &[u8]) {
        self.rows = layers.len() / w;
        let tiles = self.rows.div_ceil(ROWS);
        for bytes in [&mut self.layers, &mut self.masks, &mut self.near] {
            bytes.clear();
            bytes.resize(w * tiles, [0; ROWS]);
        }
        let columns = zip(self.layers.chunks_exact_mut(tiles), self.masks.chunks_exact_mut(tiles));
        for (layers, (kept, masks)) in zip(layers.chunks_exact(self.rows), columns) {
            kept.as_flattened_mut()[..self.rows].copy_from_slice(layers);
            zip(masks.as_flattened_mut(), layers).for_each(|(m, &l)| *m = stamps.mask_of[usize::from(l)]);
        }
        gather(self.masks.as_flattened(), tiles * ROWS, stamps.side, self.near.as_flattened_mut());
        self.slots.clear();
        self.slots.resize(tiles * (stamps.lost + 1), [Chunk::ZERO; ROWS]);
        self.filled.clear();
        self.filled.resize(tiles, 0);
    }

    /// Masks of the chunks that reach the pixels of column `j`.
    pub(super) fn near(&self, j: usize) -> &[u8] {
        let tiles = self.filled.len();
        &self.near[j * tiles..][..tiles].as_flattened()[..self.rows]
    }

    /// Slots of a chunk in all rows of the current column.
    #[inline(always)]
    pub(super) fn chunk(&self, chunk: usize) -> &[Chunk] {
        let tiles = self.filled.len();
        self.slots[chunk * tiles..][..tiles].as_flattened()
    }
}

/// Combines the masks of all columns within the distance `side`.
#[multiversion(targets("x86_64+avx512f+avx512vl+avx512bw+avx2", "x86_64+avx2"))]
fn gather(masks: &[u8], rows: usize, side: usize, near: &mut [u8]) {
    let w = masks.len() / rows;
    for (j, near) in near.chunks_exact_mut(rows).enumerate() {
        let columns = j.saturating_sub(side) * rows..(j + side + 1).min(w) * rows;
        for masks in masks[columns].chunks_exact(rows) {
            zip(&mut *near, masks).for_each(|(n, m)| *n |= m);
        }
    }
}

/// A column of layers, with the offset of its weights; or the offset of zero weights.
type Tap<'a> = (&'a [[u8; ROWS]], usize);

/// Smooths column `j`.
#[multiversion(targets("x86_64+avx512f+avx512vl+avx512bw+avx2", "x86_64+avx2"))]
pub(super) fn smooth_column(strip: &mut Strip, stamps: &Stamps, border: Border, j: usize) {
    let (tiles, side) = (strip.filled.len(), stamps.side);
    let w = strip.layers.len() / tiles;
    let tap = |r: usize| -> Tap {
        let column = (j + r).saturating_sub(side).min(w - 1);
        let beyond = column + side != j + r && border == Border::Common;
        (&strip.layers[column * tiles..][..tiles], if beyond { side + 1 } else { r.abs_diff(side) })
    };
    let near = &strip.near[j * tiles..][..tiles];
    let (slots, filled) = (&mut strip.slots, &mut strip.filled);
    let inside = j >= side && j + side < w;
    match side {
        4 if inside => stamp::<9, true>(stamps, &std::array::from_fn::<_, 9, _>(tap), near, slots, filled),
        4 => stamp::<9, false>(stamps, &std::array::from_fn::<_, 9, _>(tap), near, slots, filled),
        _ => stamp::<0, false>(stamps, &(0..=2 * side).map(tap).collect::<Vec<_>>(), near, slots, filled),
    }
}

/// Sets the slots of a column. `T` is the number of taps, or 0 for any number. With `INSIDE` all of them lie
/// inside the strip.
#[inline(always)]
fn stamp<const T: usize, const INSIDE: bool>(
    stamps: &Stamps,
    taps: &[Tap],
    near: &[[u8; ROWS]],
    slots: &mut [[Chunk; ROWS]],
    filled: &mut [u8],
) {
    let tiles = near.len();
    for (tile, (near, filled)) in zip(near, filled).enumerate() {
        let mask = together(near);
        let old = std::mem::replace(filled, mask);
        let mut set = stamps.chunks(mask);
        for chunk in ones(stamps.chunks(old) & !set) {
            slots[chunk * tiles + tile] = [Chunk::ZERO; ROWS];
        }
        while set != 0 {
            let chunk = set.trailing_zeros() as usize;
            set &= set - 1;
            if set & 2 << chunk != 0 {
                set &= set - 1;
                let (a, b) = slots.split_at_mut((chunk + 1) * tiles);
                let out = [&mut a[chunk * tiles + tile], &mut b[tile]];
                stamp_tile::<2, T, INSIDE>(stamps, taps, tile, chunk, out);
            } else {
                let out = [&mut slots[chunk * tiles + tile]];
                stamp_tile::<1, T, INSIDE>(stamps, taps, tile, chunk, out);
            }
        }
    }
}

/// Sets `N` chunks of a tile.
#[inline(always)]
fn stamp_tile<const N: usize, const T: usize, const INSIDE: bool>(
    stamps: &Stamps,
    taps: &[Tap],
    tile: usize,
    chunk: usize,
    mut out: [&mut [Chunk; ROWS]; N],
) {
    if T == 9 {
        let (tables, _) = stamps.table.as_chunks::<8>();
        let Some(first) = tables[chunk * VALUES..].first_chunk::<VALUES>() else { return };
        let tables: [_; N] =
            std::array::from_fn(|n| tables[(chunk + n) * VALUES..].first_chunk::<VALUES>().unwrap_or(first));
        let layers: [[u8; ROWS]; T] = std::array::from_fn(|r| taps[r].0[tile]);
        for i in 0..ROWS {
            let mut sums = [Chunk::ZERO; N];
            for (r, layers) in layers.iter().enumerate() {
                let offset = if INSIDE { r.abs_diff(T / 2) } else { taps[r].1 & 7 };
                for (sum, table) in zip(&mut sums, tables) {
                    *sum = sum.plus(table[usize::from(layers[i])][offset]);
                }
            }
            zip(&mut out, sums).for_each(|(out, sum)| out[i] = sum);
        }
        return;
    }
    let table = &stamps.table[chunk * VALUES * stamps.stride..];
    out.iter_mut().for_each(|out| **out = [Chunk::ZERO; ROWS]);
    for (layers, offset) in taps {
        for (i, &layer) in layers[tile].iter().enumerate() {
            for (n, out) in out.iter_mut().enumerate() {
                let at = (n * VALUES + usize::from(layer)) * stamps.stride + offset;
                out[i] = out[i].plus(table[at]);
            }
        }
    }
}
