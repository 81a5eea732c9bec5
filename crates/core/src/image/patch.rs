//! Patches: parts of a frame as planes of `f32`, cut out, resized, or sampled at any place and scale.
//!
//! Places are continuous as in [`crate::region`] (the center of pixel `j` is at `j + 0.5`), values are
//! `0..=255`. Interpolation is bilinear, without smoothing before a patch is reduced.

use super::{Frame, Window, luma};
use multiversion::multiversion;

/// Number of samples that are interpolated together.
const BLOCK: usize = 8;

/// Color planes of a patch.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Colors {
    /// One plane, [`luma`].
    Gray,
    /// Three planes: red, green, blue.
    Rgb,
}

impl Colors {
    /// Number of planes.
    pub fn planes(self) -> usize {
        match self {
            Self::Gray => 1,
            Self::Rgb => 3,
        }
    }
}

/// Values that pixels beyond the border of a frame have.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Outside {
    /// Value of the nearest border pixel.
    Repeated,
    /// Zero, from the center of the outermost pixels on.
    Zero,
}

/// Sample positions along one axis: `start + i * step` for `i` in `0..count`, in pixels.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Axis {
    /// First position.
    pub start: f64,
    /// Distance between neighboring positions.
    pub step: f64,
    /// Number of positions.
    pub count: usize,
}

impl Axis {
    /// Divides `length` pixels around `center` into `count` equal parts, with a position in the middle of each.
    pub fn around(center: f64, length: f64, count: usize) -> Self {
        let step = length / count as f64;
        Self { start: center - 0.5 * length + 0.5 * step, step, count }
    }
}

/// One to three planes of equal size.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Patch {
    /// Columns.
    pub width: usize,
    /// Number of rows.
    pub height: usize,
    /// Plane after plane, each with its rows from the top.
    pub values: Vec<f32>,
}

/// Two pixels between which a sample lies, and their weights.
#[derive(Debug, Clone, Copy)]
struct Tap {
    pixels: [usize; 2],
    shares: [f32; 2],
}

/// Taps of [`BLOCK`] samples.
#[derive(Debug, Clone, Copy)]
struct Block {
    pixels: [[usize; BLOCK]; 2],
    shares: [[f32; BLOCK]; 2],
}

impl Block {
    /// Block of at most [`BLOCK`] taps. Missing ones repeat the last one.
    fn of(taps: &[Tap]) -> Self {
        let tap = |l: usize| taps[l.min(taps.len() - 1)];
        Self {
            pixels: [0, 1].map(|k| std::array::from_fn(|l| tap(l).pixels[k])),
            shares: [0, 1].map(|k| std::array::from_fn(|l| tap(l).shares[k])),
        }
    }
}

impl Patch {
    /// Cuts out a window. Beyond the frame its border is repeated.
    pub fn cut(frame: &Frame, window: &Window, colors: Colors) -> Self {
        Self::resized(frame, window, window.w, window.h, colors)
    }

    /// Cuts out a window as [`Self::cut`] does and resizes it to `width` columns and `height` rows.
    pub fn resized(frame: &Frame, window: &Window, width: usize, height: usize, colors: Colors) -> Self {
        let across = resizing(window.x, window.w, width, frame.width(), Outside::Repeated);
        let down = resizing(window.y, window.h, height, frame.height(), Outside::Repeated);
        Self::from_taps(frame, &across, &down, colors)
    }

    /// Red, green and blue of a window, resized to `width` columns and `height` rows. Pixels beyond the frame
    /// are `fill`.
    pub fn resized_over(frame: &Frame, window: &Window, width: usize, height: usize, fill: [f32; 3]) -> Self {
        let across = resizing(window.x, window.w, width, frame.width(), Outside::Zero);
        let down = resizing(window.y, window.h, height, frame.height(), Outside::Zero);
        let mut patch = Self::from_taps(frame, &across, &down, Colors::Rgb);
        let kept =
            |taps: &[Tap]| -> Vec<f32> { taps.iter().map(|tap| tap.shares[0] + tap.shares[1]).collect() };
        let (across, down) = (kept(&across), kept(&down));
        if across.iter().chain(&down).any(|kept| *kept < 1.0) {
            for (plane, color) in patch.values.chunks_exact_mut(width * height).zip(fill) {
                for (row, kept_down) in plane.chunks_exact_mut(width).zip(&down) {
                    for (v, kept) in row.iter_mut().zip(&across) {
                        *v += color * (1.0 - kept * kept_down);
                    }
                }
            }
        }
        patch
    }

    /// Samples the frame at the positions of two axes.
    pub fn sampled(frame: &Frame, across: &Axis, down: &Axis, outside: Outside, colors: Colors) -> Self {
        let taps = |axis: &Axis, room: usize| -> Vec<Tap> {
            let last = room as f64 - 1.0;
            (0..axis.count)
                .map(|i| {
                    let place = axis.start + i as f64 * axis.step - 0.5;
                    let mut tap = tap(place.clamp(0.0, last)).on(|j| j.min(room as i64 - 1));
                    if outside == Outside::Zero && !(0.0..=last).contains(&place) {
                        tap.shares = [0.0; 2];
                    }
                    tap
                })
                .collect()
        };
        Self::from_taps(frame, &taps(across, frame.width()), &taps(down, frame.height()), colors)
    }

    fn from_taps(frame: &Frame, across: &[Tap], down: &[Tap], colors: Colors) -> Self {
        let (width, height, planes) = (across.len(), down.len(), colors.planes());
        let blocks: Vec<Block> = across.chunks(BLOCK).map(Block::of).collect();
        let stride = BLOCK * blocks.len();
        let mut values = vec![0.0; planes * width * height];
        // Rows of the frame, interpolated sideways; the next row usually needs one of them again.
        let mut lines = [(); 2].map(|()| (usize::MAX, vec![0.0_f32; planes * stride]));
        for (y, tap) in down.iter().enumerate() {
            if lines[1].0 == tap.pixels[0] {
                lines.swap(0, 1);
            }
            for (line, row) in lines.iter_mut().zip(tap.pixels) {
                if line.0 != row {
                    interpolate(frame.row(row), &blocks, colors, &mut line.1);
                    line.0 = row;
                }
            }
            let [(_, above), (_, below)] = &lines;
            let [a, b] = tap.shares;
            for plane in 0..planes {
                let start = (plane * height + y) * width;
                let part = plane * stride..plane * stride + width;
                let sources = above[part.clone()].iter().zip(&below[part]);
                for (o, (u, v)) in values[start..start + width].iter_mut().zip(sources) {
                    *o = a * u + b * v;
                }
            }
        }
        Self { width, height, values }
    }

    /// Number of planes.
    pub fn planes(&self) -> usize {
        self.values.len() / (self.width * self.height).max(1)
    }

    /// Rounds all values to integers, halves up.
    pub fn round(&mut self) {
        // From 2^23 on, numbers have no fraction. A vector operation, which a cast is not on every processor.
        const WHOLE: f32 = 8_388_608.0;
        for v in &mut self.values {
            let raised = *v + 0.5;
            let nearest = (raised + WHOLE) - WHOLE;
            *v = nearest - if nearest > raised { 1.0 } else { 0.0 };
        }
    }

    /// Multiplies all values by `factor`.
    pub fn scale(&mut self, factor: f32) {
        self.values.iter_mut().for_each(|v| *v *= factor);
    }
}

/// Samples that resize `from` pixels to `to` pixels. The first is pixel `start` of `room` pixels.
fn resizing(start: i64, from: usize, to: usize, room: usize, outside: Outside) -> Vec<Tap> {
    let (from, last) = (from.max(1) as f64, room as i64 - 1);
    let ratio = from / to as f64;
    let on_frame = |mut tap: Tap| {
        for (share, j) in tap.shares.iter_mut().zip(tap.pixels) {
            if outside == Outside::Zero && !(0..=last).contains(&(start + j as i64)) {
                *share = 0.0;
            }
        }
        tap.on(|j| (start + j).clamp(0, last))
    };
    let place = |i: usize| ((i as f64 + 0.5) * ratio - 0.5).clamp(0.0, from - 1.0);
    (0..to).map(|i| on_frame(tap(place(i)))).collect()
}

/// Sample at `place`, which is at least 0 and counts from the center of the first pixel.
fn tap(place: f64) -> Tap {
    let first = place.floor();
    let share = (place - first) as f32;
    Tap { pixels: [first as usize, first as usize + 1], shares: [1.0 - share, share] }
}

impl Tap {
    fn on(self, pixel: impl Fn(i64) -> i64) -> Self {
        Self { pixels: self.pixels.map(|j| pixel(j as i64) as usize), ..self }
    }
}

/// Interpolates a row of the frame horizontally: plane after plane, each in whole blocks.
#[multiversion(targets("x86_64+avx2"))]
fn interpolate(row: &[u8], blocks: &[Block], colors: Colors, line: &mut [f32]) {
    let stride = BLOCK * blocks.len();
    for (at, block) in blocks.iter().enumerate() {
        let (mut first, mut second) = ([0; BLOCK], [0; BLOCK]);
        for l in 0..BLOCK {
            first[l] = pixel(row, block.pixels[0][l]);
            second[l] = pixel(row, block.pixels[1][l]);
        }
        for plane in 0..colors.planes() {
            let mut mixed = [0.0; BLOCK];
            for l in 0..BLOCK {
                // Numbers of a byte: their conversion from i32 is a single instruction.
                let (a, b) = match colors {
                    Colors::Gray => (gray(first[l]), gray(second[l])),
                    Colors::Rgb => (first[l] >> (8 * plane) & 255, second[l] >> (8 * plane) & 255),
                };
                mixed[l] = block.shares[0][l] * a as i32 as f32 + block.shares[1][l] * b as i32 as f32;
            }
            line[plane * stride + at * BLOCK..][..BLOCK].copy_from_slice(&mixed);
        }
    }
}

/// Pixel `j` of a row: red in the lowest byte, then green and blue.
#[inline(always)]
fn pixel(row: &[u8], j: usize) -> u32 {
    let from = &row[3 * j..];
    // The last pixel has no fourth byte behind it.
    match from.first_chunk() {
        Some(bytes) => u32::from_le_bytes(*bytes),
        None => u32::from_le_bytes([from[0], from[1], from[2], 0]),
    }
}

#[inline(always)]
fn gray(pixel: u32) -> u32 {
    let [r, g, b, _] = pixel.to_le_bytes();
    u32::from(luma([r, g, b]))
}

/// Frame of half the width and height, rounded up. Each pixel is the mean of 2 x 2 pixels, rounded half up.
/// The last column and row of an odd frame count twice.
pub fn halved(frame: &Frame) -> Frame {
    let (width, height) = (frame.width().div_ceil(2), frame.height().div_ceil(2));
    let mut rgb = Vec::with_capacity(3 * width * height);
    for y in 0..height {
        let rows = [frame.row(2 * y), frame.row((2 * y + 1).min(frame.height() - 1))];
        for x in 0..width {
            let columns = [2 * x, (2 * x + 1).min(frame.width() - 1)];
            for c in 0..3 {
                let sum: u16 = rows.iter().flat_map(|r| columns.map(|j| u16::from(r[3 * j + c]))).sum();
                rgb.push(((sum + 2) / 4) as u8);
            }
        }
    }
    Frame::new(width, height, rgb)
}

/// True if red, green and blue are equal in all pixels.
pub fn is_gray(frame: &Frame) -> bool {
    frame.bytes().chunks_exact(3).all(|p| p[0] == p[1] && p[1] == p[2])
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use trackfail_testing::assert_near;

    /// A ramp in each color: `x + 2 y`, `3 x`, `200 - 2 y`.
    fn ramp() -> Frame {
        Frame::from_fn(40, 30, |x, y| [(x + 2 * y) as u8, (3 * x) as u8, (200 - 2 * y) as u8])
    }

    /// The result equals that of a larger frame with a border of the color.
    #[test]
    fn a_color_fills_what_is_beyond_the_frame() {
        let (frame, fill) = (ramp(), [9, 200, 31]);
        let wide = Frame::from_fn(140, 130, |x, y| {
            let inside = (50..90).contains(&x) && (50..80).contains(&y);
            if inside { frame.pixel(x - 50, y - 50) } else { fill }
        });
        for (x, y, w, h) in
            [(-20, -10, 30, 25), (30, 20, 31, 33), (5, 5, 20, 20), (-40, 3, 100, 11), (45, 5, 20, 9)]
        {
            let got = Patch::resized_over(&frame, &Window { x, y, w, h }, 23, 17, fill.map(f32::from));
            let window = Window { x: x + 50, y: y + 50, w, h };
            let want = Patch::resized(&wide, &window, 23, 17, Colors::Rgb);
            let differences = got.values.iter().zip(&want.values).map(|(a, b)| (a - b).abs());
            assert!(differences.fold(0.0, f32::max) < 1e-3, "{x} {y} {w} {h}");
        }
    }

    #[test]
    fn a_cut_repeats_the_border() {
        let frame = ramp();
        let window = Window { x: -3, y: 27, w: 6, h: 5 };
        let patch = Patch::cut(&frame, &window, Colors::Rgb);
        assert_eq!((patch.width, patch.height, patch.planes()), (6, 5, 3));
        let gray = Patch::cut(&frame, &window, Colors::Gray);
        for k in 0..30 {
            let want = frame.pixel_clamped(k as i64 % 6 - 3, k as i64 / 6 + 27);
            assert_eq!([0, 1, 2].map(|c| patch.values[c * 30 + k]), want.map(f32::from));
            assert_eq!(gray.values[k], f32::from(luma(want)));
        }
    }

    #[test]
    fn halves_are_means_of_four() {
        let frame = Frame::from_fn(3, 3, |x, y| [(10 * x + y) as u8, 7, (x * y) as u8]);
        let half = halved(&frame);
        assert_eq!((half.width(), half.height()), (2, 2));
        // (0 + 10 + 1 + 11) / 4 = 5.5; (0 + 0 + 0 + 1) / 4 = 0.25; beyond the border 20, 20, 21, 21; 2, 2, 4, 4.
        let pixels = [(0, 0), (1, 0), (1, 1)].map(|(x, y)| half.pixel(x, y));
        assert_eq!(pixels, [[6, 7, 0], [21, 7, 1], [22, 7, 4]]);
        assert!(!is_gray(&frame) && is_gray(&Frame::new(2, 1, vec![4, 4, 4, 9, 9, 9])));
    }

    #[test]
    fn zeros_begin_at_the_outermost_centers() {
        let frame = Frame::new(4, 1, vec![100; 12]);
        let across = Axis { start: 0.25, step: 0.25, count: 16 };
        let down = Axis { start: 0.5, step: 1.0, count: 1 };
        let sampled = |outside| Patch::sampled(&frame, &across, &down, outside, Colors::Gray).values;
        assert_eq!(sampled(Outside::Repeated), [100.0; 16]);
        let zeros = sampled(Outside::Zero);
        for (i, v) in zeros.iter().enumerate() {
            let place = 0.25 + 0.25 * i as f64;
            assert_eq!(*v, if (0.5..=3.5).contains(&place) { 100.0 } else { 0.0 }, "{place}");
        }
    }

    #[test]
    fn rounds_halves_up() {
        let mut patch = Patch { width: 4, height: 1, values: vec![0.5, 1.49, 254.5, 0.0] };
        patch.round();
        assert_eq!(patch.values, [1.0, 1.0, 255.0, 0.0]);
        patch.scale(0.5);
        assert_eq!(patch.values, [0.5, 0.5, 127.5, 0.0]);
    }

    proptest! {
        // Bilinear interpolation is exact on linear functions.
        #[test]
        fn a_ramp_stays_a_ramp(
            w in 2_usize..20, h in 2_usize..15, width in 1_usize..40, height in 1_usize..40,
            start in 1.0..20.0, step in 0.05..0.9,
        ) {
            let frame = ramp();
            let window = Window { x: 9, y: 8, w, h };
            let patch = Patch::resized(&frame, &window, width, height, Colors::Rgb);
            let place = |i: usize, from: usize, to: usize| {
                ((i as f64 + 0.5) * from as f64 / to as f64 - 0.5).clamp(0.0, from as f64 - 1.0)
            };
            let n = width * height;
            for k in 0..n {
                let (u, v) = (9.0 + place(k % width, w, width), 8.0 + place(k / width, h, height));
                let got = [0, 1, 2].map(|c| f64::from(patch.values[c * n + k]));
                assert_near(got, [u + 2.0 * v, 3.0 * u, 200.0 - 2.0 * v], 1e-3, k);
            }
            let across = Axis { start, step, count: 20 };
            let down = Axis { start: 12.5, step: 0.5, count: 9 };
            for outside in [Outside::Repeated, Outside::Zero] {
                let patch = Patch::sampled(&frame, &across, &down, outside, Colors::Rgb);
                for k in 0..180 {
                    let (u, v) = (start + (k % 20) as f64 * step - 0.5, 12.0 + (k / 20) as f64 * 0.5);
                    let got = [0, 1].map(|c| f64::from(patch.values[c * 180 + k]));
                    assert_near(got, [u + 2.0 * v, 3.0 * u], 1e-3, k);
                }
            }
        }

        #[test]
        fn an_axis_around_a_centre_is_symmetric(center in -9.0..9.0, length in 0.1..9.0, count in 1_usize..9) {
            let axis = Axis::around(center, length, count);
            let last = axis.start + axis.step * (count as f64 - 1.0);
            prop_assert!((0.5 * (axis.start + last) - center).abs() < 1e-9);
            prop_assert!((axis.step * count as f64 - length).abs() < 1e-9);
        }
    }
}
