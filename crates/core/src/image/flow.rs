//! Sparse optical flow: points followed from one image to another by the pyramidal method of Lucas and Kanade
//! (Bouguet, "Pyramidal implementation of the Lucas Kanade feature tracker", Intel, 2000).
//!
//! ```text
//! level l + 1   the image of level l smoothed by [1 4 6 4 1] / 16 in both directions, every second pixel of it
//! G             = sum over the window around the point of [Ix Ix, Ix Iy; Ix Iy, Iy Iy]     (of the first image)
//! d            <- d + G^-1 sum of (I(p) - J(p + d)) [Ix; Iy]                until d changes by less than `epsilon`
//! ```
//!
//! from the coarsest level, where `d` starts as 0, down to the image itself; a level starts with twice the `d` of the
//! one above. `I`, `J` are the gray values, `Ix`, `Iy` derivatives by Scharr's filter. Places are in pixels and count
//! from the center of the first pixel, unlike those of [`crate::region`], which count from its edge.
//!
//! Numbers and rounding are those of OpenCV's `calcOpticalFlowPyrLK`: values and derivatives are interpolated
//! with weights of 14 bits and kept to 1/32 of a gray value, a level ends early when two steps cancel, and
//! images are mirrored without repeating the border pixel (`BORDER_REFLECT_101`), while derivatives beyond
//! them are 0. All sums over pixels are sums of integers, so that every processor gives the same bits.
//! Deviation: computations per point use `f64` instead of OpenCV's `f32`; places differ by about 1e-4 pixels.

mod pyramid;

pub use pyramid::Pyramid;

use crate::num::integer;
use multiversion::multiversion;
use pyramid::Level;

/// Bits of an interpolation weight.
const WEIGHT_BITS: u32 = 14;
/// Fractional bits of an interpolated gray value.
const VALUE_BITS: u32 = 5;
/// Scale that brings sums of products of derivatives and values to the size of gray values.
const SCALE: f64 = 1.0 / (1 << 20) as f64;
/// Least eigenvalue of G per pixel of the window. Below it, the window has too little texture to be followed.
const MIN_EIGENVALUE: f64 = 1e-4;
/// Largest side of a window. A row sum then fits in 32 bits.
pub const MAX_WINDOW: usize = 63;

/// A place in the image: column and row.
pub type Point = (f64, f64);

/// Settings of the method.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LucasKanade {
    /// Side of the window in pixels, odd, 3 to [`MAX_WINDOW`].
    pub window: usize,
    /// Most steps per level.
    pub iterations: usize,
    /// Length of a step, in pixels of the level, at which the level ends.
    pub epsilon: f64,
}

/// Buffers for one window.
struct Window {
    side: usize,
    /// Pixels of a block of the image.
    block: Vec<i32>,
    /// Derivatives at whole pixels.
    slopes: Vec<[i32; 2]>,
    /// Values of the window in the first image, in 1/32, and its derivatives.
    values: Vec<i32>,
    gradients: Vec<[i32; 2]>,
}

/// Inverse of the matrix G of a window.
struct Inverse {
    xx: f64,
    xy: f64,
    yy: f64,
    determinant: f64,
}

impl LucasKanade {
    /// Place in `to` of each point of `from`; `None` if it left the image or its window has no texture.
    ///
    /// The pyramids should have the same size and number of levels; if not, the levels that both have are used.
    pub fn follow(&self, from: &Pyramid, to: &Pyramid, points: &[Point]) -> Vec<Option<Point>> {
        let levels: Vec<(&Level, &Level)> = from.levels.iter().zip(&to.levels).collect();
        let mut window = Window::new(self.window);
        let mut found = Vec::with_capacity(points.len());
        // The usual window has a size that the compiler knows.
        match window.side {
            3 => follow_points::<3>(self, &levels, points, &mut window, &mut found),
            _ => follow_points::<0>(self, &levels, points, &mut window, &mut found),
        }
        found
    }

    #[inline(always)]
    fn follow_point<const SIDE: usize>(
        &self,
        levels: &[(&Level, &Level)],
        point: Point,
        window: &mut Window,
    ) -> Option<Point> {
        if !(point.0.is_finite() && point.1.is_finite()) {
            return None;
        }
        let mut place = None;
        for (l, (first, second)) in levels.iter().enumerate().rev() {
            let scale = 1.0 / (1_u64 << l) as f64;
            let start = (point.0 * scale, point.1 * scale);
            let guess = place.map_or(start, |(x, y): Point| (2.0 * x, 2.0 * y));
            let found = window
                .load::<SIDE>(first, start)
                .map(|inverse| self.descend::<SIDE>(second, guess, &inverse, window));
            // Only the image itself decides whether a point is lost.
            place = match found {
                Some((end, inside)) => (l > 0 || inside).then_some(end),
                None => (l > 0).then_some(guess),
            };
        }
        place
    }

    /// Steps of a level from `guess` on. Returns the final place, and true if the window still touches the
    /// image.
    #[inline(always)]
    fn descend<const SIDE: usize>(
        &self,
        image: &Level,
        guess: Point,
        g: &Inverse,
        window: &mut Window,
    ) -> (Point, bool) {
        let side = window.known_side::<SIDE>();
        let half = (side - 1) as f64 * 0.5;
        let (mut x, mut y) = (guess.0 - half, guess.1 - half);
        let mut last = (0.0, 0.0);
        let mut loaded = None;
        for n in 0..self.iterations {
            let corner = Corner::of(x, y);
            if !corner.touches(image, side) {
                return ((x + half, y + half), false);
            }
            if loaded != Some((corner.x, corner.y)) {
                image.block(corner.x, corner.y, side + 1, &mut window.block);
                loaded = Some((corner.x, corner.y));
            }
            let (bx, by) = window.mismatch::<SIDE>(&corner.weights);
            let step = ((g.xy * by - g.yy * bx) * g.determinant, (g.xy * bx - g.xx * by) * g.determinant);
            (x, y) = (x + step.0, y + step.1);
            if step.0 * step.0 + step.1 * step.1 <= self.epsilon * self.epsilon {
                break;
            }
            // Steps that cancel go on for ever.
            if n > 0 && (step.0 + last.0).abs() < 0.01 && (step.1 + last.1).abs() < 0.01 {
                (x, y) = (x - 0.5 * step.0, y - 0.5 * step.1);
                break;
            }
            last = step;
        }
        ((x + half, y + half), Corner::of(x, y).touches(image, side))
    }
}

/// Follows points through the levels, with integers and single operations only, so that all processors give
/// the same bits.
#[multiversion(targets("x86_64+avx2"))]
fn follow_points<const SIDE: usize>(
    method: &LucasKanade,
    levels: &[(&Level, &Level)],
    points: &[Point],
    window: &mut Window,
    found: &mut Vec<Option<Point>>,
) {
    // Closures would not be compiled for the processor at hand.
    for point in points {
        found.push(method.follow_point::<SIDE>(levels, *point, window));
    }
}

/// Left top corner of a window: whole pixel, and weights of the four pixels around a place.
struct Corner {
    x: i64,
    y: i64,
    weights: [i32; 4],
}

impl Corner {
    #[inline(always)]
    fn of(x: f64, y: f64) -> Self {
        // Far away from any image; the cast would otherwise depend on how it saturates.
        let (x, y) = (x.clamp(-1e6, 1e6), y.clamp(-1e6, 1e6));
        let (left, top) = (floor(x), floor(y));
        let (a, b) = (x - left as f64, y - top as f64);
        let one = f64::from(1 << WEIGHT_BITS);
        let weight = |share: f64| integer(share * one) as i32;
        let (w0, w1, w2) = (weight((1.0 - a) * (1.0 - b)), weight(a * (1.0 - b)), weight((1.0 - a) * b));
        let weights = [w0, w1, w2, (1 << WEIGHT_BITS) - w0 - w1 - w2];
        Self { x: left, y: top, weights }
    }

    #[inline(always)]
    fn touches(&self, image: &Level, side: usize) -> bool {
        let within = |at: i64, length: usize| (-(side as i64)..length as i64).contains(&at);
        within(self.x, image.width) && within(self.y, image.height)
    }
}

/// The largest integer that is not above `value`.
#[inline(always)]
fn floor(value: f64) -> i64 {
    let near = integer(value);
    near - i64::from(near as f64 > value)
}

/// Drops the last bits of a fixed-point sum, rounding halves up.
#[inline(always)]
fn rounded(sum: i32, bits: u32) -> i32 {
    (sum + (1 << (bits - 1))) >> bits
}

/// Interpolated value between four pixels.
#[inline(always)]
fn between(weights: &[i32; 4], pixels: [i32; 4], bits: u32) -> i32 {
    let [a, b, c, d] = weights;
    rounded(pixels[0] * a + pixels[1] * b + pixels[2] * c + pixels[3] * d, bits)
}

impl Window {
    fn new(side: usize) -> Self {
        let side = side.clamp(1, MAX_WINDOW);
        Self {
            side,
            block: Vec::new(),
            slopes: vec![[0; 2]; (side + 1) * (side + 1)],
            values: vec![0; side * side],
            gradients: vec![[0; 2]; side * side],
        }
    }

    /// Side of the window: `SIDE`, or the stored one if `SIDE` is 0.
    #[inline(always)]
    fn known_side<const SIDE: usize>(&self) -> usize {
        if SIDE > 0 { SIDE } else { self.side }
    }

    /// Loads values and derivatives around a place and returns the inverse of G; `None` without texture or
    /// outside of the image.
    #[inline(always)]
    fn load<const SIDE: usize>(&mut self, image: &Level, (x, y): Point) -> Option<Inverse> {
        let side = self.known_side::<SIDE>();
        let half = (side - 1) as f64 * 0.5;
        let corner = Corner::of(x - half, y - half);
        if !corner.touches(image, side) {
            return None;
        }
        let wide = side + 3;
        image.block(corner.x - 1, corner.y - 1, wide, &mut self.block);
        scharr(&self.block, wide, &mut self.slopes);
        let last = side as i64;
        if !(image.contains(corner.x, corner.y) && image.contains(corner.x + last, corner.y + last)) {
            for (k, slope) in self.slopes.iter_mut().enumerate() {
                let (i, j) = ((k / (side + 1)) as i64, (k % (side + 1)) as i64);
                if !image.contains(corner.x + j, corner.y + i) {
                    *slope = [0; 2];
                }
            }
        }
        let (mut xx, mut xy, mut yy) = (0_i64, 0_i64, 0_i64);
        for i in 0..side {
            let (upper, lower) = (row(&self.block, i + 1, wide), row(&self.block, i + 2, wide));
            let (upper, lower) = (&upper[1..][..=side], &lower[1..][..=side]);
            let (above, below) = (row(&self.slopes, i, side + 1), row(&self.slopes, i + 1, side + 1));
            let values = &mut self.values[i * side..][..side];
            let gradients = &mut self.gradients[i * side..][..side];
            let mut sums = [0_i32; 3];
            for j in 0..side {
                let around = [upper[j], upper[j + 1], lower[j], lower[j + 1]];
                values[j] = between(&corner.weights, around, WEIGHT_BITS - VALUE_BITS);
                let ([ax, ay], [bx, by]) = (above[j], above[j + 1]);
                let ([cx, cy], [dx, dy]) = (below[j], below[j + 1]);
                let gx = between(&corner.weights, [ax, bx, cx, dx], WEIGHT_BITS);
                let gy = between(&corner.weights, [ay, by, cy, dy], WEIGHT_BITS);
                gradients[j] = [gx, gy];
                sums = [sums[0] + gx * gx, sums[1] + gx * gy, sums[2] + gy * gy];
            }
            xx += i64::from(sums[0]);
            xy += i64::from(sums[1]);
            yy += i64::from(sums[2]);
        }
        let [xx, xy, yy] = [xx, xy, yy].map(|sum| sum as f64 * SCALE);
        let determinant = xx * yy - xy * xy;
        let root = ((xx - yy) * (xx - yy) + 4.0 * xy * xy).sqrt();
        let eigenvalue = (yy + xx - root) / (2 * side * side) as f64;
        let followed = eigenvalue >= MIN_EIGENVALUE && determinant >= f64::from(f32::EPSILON);
        followed.then(|| Inverse { xx, xy, yy, determinant: 1.0 / determinant })
    }

    /// Sums of difference times derivative over the window, against the block of the second image.
    #[inline(always)]
    fn mismatch<const SIDE: usize>(&self, weights: &[i32; 4]) -> (f64, f64) {
        let side = self.known_side::<SIDE>();
        let (mut bx, mut by) = (0_i64, 0_i64);
        for i in 0..side {
            let (upper, lower) = (row(&self.block, i, side + 1), row(&self.block, i + 1, side + 1));
            let values = &self.values[i * side..][..side];
            let gradients = &self.gradients[i * side..][..side];
            let mut sums = [0_i32; 2];
            for j in 0..side {
                let around = [upper[j], upper[j + 1], lower[j], lower[j + 1]];
                let difference = between(weights, around, WEIGHT_BITS - VALUE_BITS) - values[j];
                let [gx, gy] = gradients[j];
                sums = [sums[0] + difference * gx, sums[1] + difference * gy];
            }
            bx += i64::from(sums[0]);
            by += i64::from(sums[1]);
        }
        (bx as f64 * SCALE, by as f64 * SCALE)
    }
}

/// Row `i` of a square with `side` columns.
#[inline(always)]
fn row<T>(square: &[T], i: usize, side: usize) -> &[T] {
    &square[i * side..][..side]
}

/// Derivatives (Scharr's filter) at the inner pixels of a square block with `side` columns.
#[inline(always)]
fn scharr(block: &[i32], side: usize, slopes: &mut [[i32; 2]]) {
    for (i, out) in slopes.chunks_exact_mut(side - 2).enumerate() {
        let (above, middle, below) = (row(block, i, side), row(block, i + 1, side), row(block, i + 2, side));
        for (j, out) in out.iter_mut().enumerate() {
            let smooth = |k: usize| 3 * (above[k] + below[k]) + 10 * middle[k];
            let rise = |k: usize| below[k] - above[k];
            *out = [smooth(j + 2) - smooth(j), 3 * (rise(j) + rise(j + 2)) + 10 * rise(j + 1)];
        }
    }
}

#[cfg(test)]
mod tests;
