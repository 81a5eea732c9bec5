//! Pyramids of gray images, each level of half the size of the one before.

use multiversion::multiversion;

/// A gray image and smaller copies of it.
#[derive(Debug, Clone)]
pub struct Pyramid {
    pub(super) levels: Vec<Level>,
}

/// An image of a pyramid.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Level {
    /// Number of columns.
    pub width: usize,
    /// Number of rows.
    pub height: usize,
    /// Gray values, rows from the top.
    values: Vec<u8>,
}

impl Pyramid {
    /// A pyramid of the gray values of an image, rows from the top, with up to `levels` smaller copies. There are
    /// fewer if a side of the next one would be `window` pixels or less.
    ///
    /// # Panics
    /// When there are not `width * height` values, at least one: a mistake in the caller.
    pub fn new(width: usize, height: usize, values: Vec<u8>, levels: usize, window: usize) -> Self {
        assert!(!values.is_empty() && values.len() == width * height, "image size");
        let mut image = Level { width, height, values };
        let mut all = Vec::new();
        while all.len() < levels {
            let (width, height) = (image.width.div_ceil(2), image.height.div_ceil(2));
            if width <= window || height <= window {
                break;
            }
            let mut values = vec![0; width * height];
            halve(&image, &mut values);
            all.push(std::mem::replace(&mut image, Level { width, height, values }));
        }
        all.push(image);
        Self { levels: all }
    }

    /// Gray values of the image itself, rows from the top.
    pub fn values(&self) -> &[u8] {
        &self.levels[0].values
    }

    /// The values of a square of `side` pixels around a place, rows from the top.
    pub fn patch(&self, x: f64, y: f64, side: usize) -> Vec<f64> {
        let half = (side as f64 - 1.0) / 2.0;
        let place = |k: usize| (x - half + (k % side) as f64, y - half + (k / side) as f64);
        (0..side * side).map(place).map(|(x, y)| self.value(x, y)).collect()
    }

    /// Bilinear value at a place. Beyond the image the border is repeated.
    fn value(&self, x: f64, y: f64) -> f64 {
        let image = &self.levels[0];
        let (x, y) = (x.clamp(0.0, (image.width - 1) as f64), y.clamp(0.0, (image.height - 1) as f64));
        let (left, top) = (x as usize, y as usize);
        let (right, bottom) = ((left + 1).min(image.width - 1), (top + 1).min(image.height - 1));
        let at = |x: usize, y: usize| f64::from(image.values[y * image.width + x]);
        let (a, b) = (x - left as f64, y - top as f64);
        let upper = at(left, top) + a * (at(right, top) - at(left, top));
        let lower = at(left, bottom) + a * (at(right, bottom) - at(left, bottom));
        upper + b * (lower - upper)
    }
}

impl Level {
    /// True if the pixel lies in the image.
    #[inline(always)]
    pub fn contains(&self, x: i64, y: i64) -> bool {
        (0..self.width as i64).contains(&x) && (0..self.height as i64).contains(&y)
    }

    /// Pixels of a square with `side` columns. The image is mirrored beyond its border.
    #[inline(always)]
    pub fn block(&self, x: i64, y: i64, side: usize, block: &mut Vec<i32>) {
        block.clear();
        let last = side as i64 - 1;
        if self.contains(x, y) && self.contains(x + last, y + last) {
            let (left, top) = (x as usize, y as usize);
            for row in self.values[top * self.width..].chunks(self.width).take(side) {
                for value in &row[left..left + side] {
                    block.push(i32::from(*value));
                }
            }
            return;
        }
        for i in 0..side as i64 {
            let row = &self.values[mirrored(y + i, self.height) * self.width..][..self.width];
            block.extend((0..side as i64).map(|j| i32::from(row[mirrored(x + j, self.width)])));
        }
    }
}

/// Pixel that replaces pixel `at` on a side of `length` pixels: `c b | a b c d | c b`.
fn mirrored(at: i64, length: usize) -> usize {
    let last = length as i64 - 1;
    if last == 0 {
        return 0;
    }
    let at = at.rem_euclid(2 * last);
    at.min(2 * last - at) as usize
}

/// Computes the next level of a pyramid.
#[multiversion(targets("x86_64+avx2"))]
fn halve(image: &Level, values: &mut [u8]) {
    let (columns, width) = (image.width, image.width.div_ceil(2));
    let row = |y: i64| &image.values[mirrored(y, image.height) * columns..][..columns];
    // Two sums to the left and at least two to the right of those of the image.
    let mut sums = vec![0_u16; columns + 5];
    for (out, y) in values.chunks_exact_mut(width).zip((0_i64..).step_by(2)) {
        let [a, b, c, d, e] = [-2, -1, 0, 1, 2].map(|k| row(y + k));
        for (j, sum) in sums[2..2 + columns].iter_mut().enumerate() {
            let [a, b, c, d, e] = [a, b, c, d, e].map(|row| u16::from(row[j]));
            *sum = a + e + 4 * (b + d) + 6 * c;
        }
        for k in [-2, -1] {
            sums[(2 + k) as usize] = sums[2 + mirrored(k, columns)];
        }
        for k in columns..columns + 2 {
            sums[2 + k] = sums[2 + mirrored(k as i64, columns)];
        }
        for (j, out) in out.iter_mut().enumerate() {
            let [a, b, c, d, e] = *sums[2 * j..].first_chunk().unwrap_or(&[0; 5]);
            *out = ((a + e + 4 * (b + d) + 6 * c + 128) >> 8) as u8;
        }
    }
}
