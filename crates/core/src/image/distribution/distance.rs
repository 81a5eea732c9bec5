//! Vertical smoothing of the difference of two columns, and the sum of its absolute values.

use super::chunk::{Chunk, LANES};
use super::strip::{LOSSY, ROWS, Strip, ones, together};
use super::{Border, Smoothing, UNITS, whole};
use multiversion::{multiversion, target::selected_target};
use std::iter::zip;

/// Vertical smoothing kernel.
#[derive(Debug, Clone)]
pub(super) struct Down {
    /// Weights for offsets `0..=reach`.
    weights: Vec<f32>,
    /// For each number of smoothed rows from 1 to `ROWS`, the weights of all rows in the sum of the smoothed
    /// ones.
    sums: Vec<Vec<f32>>,
}

impl Down {
    pub(super) fn new(down: &[f64]) -> Self {
        let weights: Vec<f32> = whole(down, UNITS).iter().map(|&units| units as f32 / UNITS as f32).collect();
        let reach = down.len() - 1;
        let weight = |row: usize, i: usize| weights.get((i + reach).abs_diff(row)).copied().unwrap_or(0.0);
        let sums = (1..=ROWS)
            .map(|count| (0..count + 2 * reach).map(|row| (0..count).map(|i| weight(row, i)).sum()).collect())
            .collect();
        Self { weights, sums }
    }

    fn reach(&self) -> usize {
        self.weights.len() - 1
    }

    /// Masks of the chunks that reach each group of rows, from the masks near each row.
    pub(super) fn groups(&self, near: &[u8], groups: &mut Vec<u8>) {
        let around = self.reach().div_ceil(ROWS);
        let count = near.len().div_ceil(ROWS);
        groups.clear();
        groups.resize(around, 0);
        let (whole, rest) = near.as_chunks();
        groups.extend(whole.iter().map(together));
        if !rest.is_empty() {
            groups.push(rest.iter().fold(0, |all, m| all | m));
        }
        groups.resize(count.next_multiple_of(8) + 2 * around, 0);
        for g in 0..count {
            groups[g] = groups[g..=g + 2 * around].iter().fold(0, |all, m| all | m);
        }
        groups.truncate(count.next_multiple_of(8));
        groups[count..].fill(0);
    }
}

/// A column of a window.
pub(super) struct Column<'a> {
    pub(super) strip: &'a Strip,
    pub(super) top: usize,
    /// Masks of the chunks that reach each group of `ROWS` rows.
    pub(super) groups: &'a [u8],
}

/// A word with the lowest bit of each byte set.
const EACH: u64 = 0x0101_0101_0101_0101;

/// Buffers for the distance of two windows.
#[derive(Debug, Default)]
pub(super) struct Distance {
    /// Differences of a chunk, extended above and below by the reach of the kernel.
    rows: Vec<Chunk>,
    /// Each layer's share of the lost mass, equal in all slots.
    even: Vec<[Chunk; ROWS]>,
}

impl Distance {
    pub(super) fn prepare(&mut self, down: &Down, h: usize) {
        self.rows.clear();
        self.rows.resize(h + 2 * down.reach(), Chunk::ZERO);
        self.even.resize(h.div_ceil(ROWS), [Chunk::ZERO; ROWS]);
    }
}

#[multiversion(targets("x86_64+avx512f+avx512vl+avx512bw+avx512dq+avx2+fma", "x86_64+avx2+fma"))]
pub(super) fn l1(buffers: &mut Distance, smoothing: &Smoothing, h: usize, a: &Column, b: &Column) -> f64 {
    if const { selected_target!().supports_feature_str("fma") || cfg!(target_arch = "aarch64") } {
        l1_of::<true>(buffers, smoothing, h, a, b)
    } else {
        l1_of::<false>(buffers, smoothing, h, a, b)
    }
}

#[inline(always)]
fn l1_of<const FMA: bool>(
    buffers: &mut Distance,
    smoothing: &Smoothing,
    h: usize,
    a: &Column,
    b: &Column,
) -> f64 {
    let Smoothing { border, stamps, down } = smoothing;
    let reach = down.reach();
    let Distance { rows, even } = buffers;
    let mut lanes = [0.0; LANES];
    let mut add = |chunk: Chunk, scale: f64| {
        zip(&mut lanes, chunk.0).for_each(|(sum, value)| *sum += scale * f64::from(value));
    };
    let words = zip(a.groups.as_chunks().0, b.groups.as_chunks().0)
        .map(|(a, b)| (u64::from_le_bytes(*a), u64::from_le_bytes(*b)));
    let all = together(&words.clone().fold(0, |all, (a, b)| all | a | b).to_le_bytes());
    let group = |word: usize, g: usize| word * 8 + g / 8;
    let span = |g: usize| (g * ROWS, ROWS.min(h - g * ROWS));
    if all & LOSSY != 0 {
        subtract(rows, stamps.lost, *border, reach, h, a, b);
        for (word, (of_a, of_b)) in words.clone().enumerate() {
            for g in ones((of_a | of_b) >> 7 & EACH) {
                let g = group(word, g);
                let (start, count) = span(g);
                let mut sum = Chunk::ZERO;
                let share = 1.0 / stamps.layers as f32;
                for (i, even) in even[g][..count].iter_mut().enumerate() {
                    let row = smooth::<FMA>(&down.weights, &rows[start + i..start + i + 2 * reach + 1]);
                    *even = row.map(|v| v * share);
                    sum = sum.plus(even.map(f32::abs));
                }
                // Layers outside the chunks; below 0 when the slots of the last chunk are not all layers.
                let chunks = stamps.chunks((a.groups[g] | b.groups[g]) & !LOSSY).count_ones() as usize;
                add(sum, (stamps.layers as f64 - (LANES * chunks) as f64) / LANES as f64);
            }
        }
    }
    for chunk in ones(stamps.chunks(all & !LOSSY)) {
        let bit = stamps.bit(chunk).trailing_zeros();
        subtract(rows, chunk, *border, reach, h, a, b);
        for (word, (of_a, of_b)) in words.clone().enumerate() {
            let any = (of_a | of_b) >> bit & EACH;
            let lossy = (of_a | of_b) >> 7;
            let both = (of_a & of_b) >> bit;
            for g in ones(any & !lossy & both) {
                let g = group(word, g);
                let (start, count) = span(g);
                let rows = &rows[start..start + count + 2 * reach];
                add(absolute::<FMA, false>(&down.weights, rows, &even[g]), 1.0);
            }
            for g in ones(any & !lossy & !both) {
                let (start, count) = span(group(word, g));
                add(one_sign::<FMA>(&down.sums[count - 1], &rows[start..start + count + 2 * reach]), 1.0);
            }
            for g in ones(any & lossy) {
                let g = group(word, g);
                let (start, count) = span(g);
                let rows = &rows[start..start + count + 2 * reach];
                add(absolute::<FMA, true>(&down.weights, rows, &even[g]), 1.0);
            }
        }
    }
    lanes.iter().sum()
}

/// Fills `rows` with the difference of two columns in a chunk.
#[inline(always)]
fn subtract(
    rows: &mut [Chunk],
    chunk: usize,
    border: Border,
    reach: usize,
    h: usize,
    a: &Column,
    b: &Column,
) {
    let of_a = &a.strip.chunk(chunk)[a.top..][..h];
    let of_b = &b.strip.chunk(chunk)[b.top..][..h];
    for (row, (a, b)) in zip(&mut rows[reach..], zip(of_a, of_b)) {
        *row = a.minus(*b);
    }
    if border == Border::Replicate {
        let (first, last) = (rows[reach], rows[reach + h - 1]);
        rows[..reach].fill(first);
        rows[reach + h..].fill(last);
    }
}

/// Smoothed value of the middle row of `rows`.
#[inline(always)]
fn smooth<const FMA: bool>(down: &[f32], rows: &[Chunk]) -> Chunk {
    match (down.as_array::<8>(), rows.as_array::<15>()) {
        (Some(down), Some(rows)) => smooth_of::<FMA>(down, rows),
        _ => smooth_of::<FMA>(down, rows),
    }
}

#[inline(always)]
fn smooth_of<const FMA: bool>(down: &[f32], rows: &[Chunk]) -> Chunk {
    let reach = down.len() - 1;
    let mut sum = rows[reach].map(|v| down[0] * v);
    for k in 1..=reach {
        sum = rows[reach - k].plus(rows[reach + k]).fused::<FMA>(down[k], sum);
    }
    sum
}

/// Sum of the absolute values of a group of rows after smoothing; with `EVEN`, the shares `even` are added
/// first.
#[inline(always)]
fn absolute<const FMA: bool, const EVEN: bool>(down: &[f32], rows: &[Chunk], even: &[Chunk; ROWS]) -> Chunk {
    if let (Some(down), Some(rows)) = (down.as_array::<8>(), rows.as_array::<22>()) {
        let down = *down;
        let mut sum = Chunk::ZERO;
        for i in [0, 4] {
            let Some(rows) = rows[i..].first_chunk::<18>() else { continue };
            let rows = *rows;
            for q in 0..4 {
                let mut row = smooth_of::<FMA>(&down, &rows[q..q + 15]);
                if EVEN {
                    row = row.plus(even[i + q]);
                }
                sum = sum.plus(row.map(f32::abs));
            }
        }
        return sum;
    }
    let mut sum = Chunk::ZERO;
    for (rows, even) in zip(rows.windows(2 * down.len() - 1), even) {
        let mut row = smooth_of::<FMA>(down, rows);
        if EVEN {
            row = row.plus(*even);
        }
        sum = sum.plus(row.map(f32::abs));
    }
    sum
}

/// The same sum if only one of two fields is nonzero: the absolute value of the sum.
#[inline(always)]
fn one_sign<const FMA: bool>(weights: &[f32], rows: &[Chunk]) -> Chunk {
    match (weights.as_array::<22>(), rows.as_array::<22>()) {
        (Some(weights), Some(rows)) => one_sign_of::<FMA>(weights, rows),
        _ => one_sign_of::<FMA>(weights, rows),
    }
}

#[inline(always)]
fn one_sign_of<const FMA: bool>(weights: &[f32], rows: &[Chunk]) -> Chunk {
    let mut sums = [Chunk::ZERO; 4];
    for (i, (w, row)) in zip(weights, rows).enumerate() {
        sums[i % 4] = row.fused::<FMA>(*w, sums[i % 4]);
    }
    sums[0].plus(sums[1]).plus(sums[2].plus(sums[3])).map(f32::abs)
}
