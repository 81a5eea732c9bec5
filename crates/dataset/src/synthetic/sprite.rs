//! Sprites: small pictures with transparency that can be moved, scaled and turned.

use super::motion::sin_cos;
use super::noise::Color;

/// A picture at full, half, quarter ... resolution.
pub struct Sprite {
    levels: Vec<Level>,
}

/// Pixels of one resolution: premultiplied red, green, blue and opacity in 0..=255, with a transparent border
/// of one pixel.
struct Level {
    width: usize,
    height: usize,
    rgba: Vec<[f32; 4]>,
}

/// Placement of a sprite: center, size and turn, in pixels of the frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pose {
    /// Center column.
    pub x: f64,
    /// Center row.
    pub y: f64,
    /// Width before turning.
    pub w: f64,
    /// Height before turning.
    pub h: f64,
    /// Clockwise turn (on the screen) in degrees.
    pub turn: f64,
}

impl Pose {
    /// Corners of the turned box, clockwise from the sprite's left top.
    pub fn corners(&self) -> [(f64, f64); 4] {
        let (s, c) = sin_cos(self.turn / 360.0);
        [(-0.5, -0.5), (0.5, -0.5), (0.5, 0.5), (-0.5, 0.5)].map(|(a, b)| {
            let (u, v) = (a * self.w, b * self.h);
            (self.x + c * u - s * v, self.y + s * u + c * v)
        })
    }

    /// Half width and half height of the upright bounds: those of the ellipse inscribed in a turned box, or
    /// of the box itself without a turn.
    pub fn half_bounds(&self) -> (f64, f64) {
        if self.turn == 0.0 {
            return (self.w / 2.0, self.h / 2.0);
        }
        let (s, c) = sin_cos(self.turn / 360.0);
        let length = |a: f64, b: f64| (a * a + b * b).sqrt() / 2.0;
        (length(self.w * c, self.h * s), length(self.w * s, self.h * c))
    }

    /// Converts a point of the frame to the box: `(0, 0)` is the box's left top, `(1, 1)` its right bottom.
    pub fn place(&self, x: f64, y: f64) -> (f64, f64) {
        let (s, c) = sin_cos(self.turn / 360.0);
        let (dx, dy) = (x - self.x, y - self.y);
        ((c * dx + s * dy) / self.w + 0.5, (c * dy - s * dx) / self.h + 0.5)
    }
}

impl Sprite {
    /// Paints a sprite of `width` x `height` pixels. `paint` gives the color at `(u, v)` in the box, `None`
    /// for transparent. Four samples per pixel smooth the edges.
    pub fn paint(width: usize, height: usize, paint: impl Fn(f64, f64) -> Option<Color>) -> Self {
        let mut pixels = Vec::with_capacity(width * height);
        for j in 0..height {
            for i in 0..width {
                let mut sum = [0.0_f64; 4];
                for k in 0..4 {
                    let u = (i as f64 + (f64::from(k % 2) + 0.5) / 2.0) / width as f64;
                    let v = (j as f64 + (f64::from(k / 2) + 0.5) / 2.0) / height as f64;
                    if let Some(c) = paint(u, v) {
                        for (s, c) in sum.iter_mut().zip([c[0], c[1], c[2], 255.0]) {
                            *s += c.clamp(0.0, 255.0);
                        }
                    }
                }
                pixels.push(sum.map(|s| (s / 4.0) as f32));
            }
        }
        let mut levels = vec![];
        let (mut w, mut h) = (width, height);
        loop {
            let mut rgba = vec![[0.0; 4]; (w + 2) * (h + 2)];
            for j in 0..h {
                rgba[(j + 1) * (w + 2) + 1..][..w].copy_from_slice(&pixels[j * w..][..w]);
            }
            levels.push(Level { width: w + 2, height: h + 2, rgba });
            if w < 8 || h < 8 {
                return Self { levels };
            }
            pixels = halved(w, h, &pixels);
            (w, h) = (w / 2, h / 2);
        }
    }

    /// Draws the sprite over `rgb`, `width` pixels per row, as far as it lies inside. `mirrored` swaps left
    /// and right before turning.
    pub fn draw(&self, pose: &Pose, mirrored: bool, rgb: &mut [u8], width: usize) {
        let height = rgb.len() / (3 * width);
        // The coarsest level that is still at least as fine as the screen.
        let is_fine = |level: &&Level| (level.width - 2) as f64 >= pose.w * 0.9;
        let level = self.levels[1..].iter().rfind(is_fine).unwrap_or(&self.levels[0]);
        let corners = pose.corners();
        let low = |f: fn(&(f64, f64)) -> f64| corners.iter().map(f).fold(f64::INFINITY, f64::min);
        let high = |f: fn(&(f64, f64)) -> f64| corners.iter().map(f).fold(f64::NEG_INFINITY, f64::max);
        let from = |v: f64, end: usize| (v - 1.0).floor().clamp(0.0, end as f64) as usize;
        let (x0, x1) = (from(low(|c| c.0), width), from(high(|c| c.0) + 3.0, width));
        let (y0, y1) = (from(low(|c| c.1), height), from(high(|c| c.1) + 3.0, height));
        let (tw, th) = ((level.width - 2) as f64, (level.height - 2) as f64);
        let cells = |x: usize, y: usize| {
            let (u, v) = pose_place_fast(pose, x as f64 + 0.5, y as f64 + 0.5, &corners);
            let u = if mirrored { 1.0 - u } else { u };
            (Cell::at(u * tw, level.width), Cell::at(v * th, level.height))
        };
        let mut places: Vec<(Cell, Cell)> = (x0..x1).map(|x| cells(x, y0)).collect();
        for (y, line) in rgb.chunks_exact_mut(3 * width).enumerate().take(y1).skip(y0) {
            if pose.turn == 0.0 {
                // Its rows and columns are the screen's.
                let row = cells(x0, y).1;
                places.iter_mut().for_each(|place| place.1 = row);
            } else {
                places.iter_mut().zip(x0..x1).for_each(|(place, x)| *place = cells(x, y));
            }
            for (pixel, (column, row)) in line[3 * x0..3 * x1].chunks_exact_mut(3).zip(&places) {
                if column.inside && row.inside {
                    let start = row.index * level.width;
                    let (above, below) = level.rgba[start..start + 2 * level.width].split_at(level.width);
                    blend(pixel, mean(above, below, column.index, column.part, row.part));
                }
            }
        }
    }
}

/// Like [`Pose::place`], but takes the axes from the corners, which avoids a sine per pixel.
fn pose_place_fast(pose: &Pose, x: f64, y: f64, c: &[(f64, f64); 4]) -> (f64, f64) {
    let (ax, ay) = (c[1].0 - c[0].0, c[1].1 - c[0].1);
    let (bx, by) = (c[3].0 - c[0].0, c[3].1 - c[0].1);
    let (dx, dy) = (x - c[0].0, y - c[0].1);
    ((ax * dx + ay * dy) / (pose.w * pose.w), (bx * dx + by * dy) / (pose.h * pose.h))
}

fn halved(w: usize, h: usize, pixels: &[[f32; 4]]) -> Vec<[f32; 4]> {
    let mut out = Vec::with_capacity((w / 2) * (h / 2));
    // Odd sizes lose nothing: the samples are spread over the whole picture.
    for j in 0..h / 2 {
        for i in 0..w / 2 {
            let (x, y) = (i * w / (w / 2), j * h / (h / 2));
            let four = [y * w + x, y * w + x + 1, (y + 1) * w + x, (y + 1) * w + x + 1];
            let mut sum = [0.0; 4];
            for k in four {
                for (s, p) in sum.iter_mut().zip(pixels[k]) {
                    *s += p / 4.0;
                }
            }
            out.push(sum);
        }
    }
    out
}

/// Position between two pixels of a bordered row or column: the first pixel, and the distance from it.
#[derive(Clone, Copy)]
struct Cell {
    inside: bool,
    index: usize,
    part: f32,
}

impl Cell {
    /// Cell of `place`, which is 0 at the outer edge of the first pixel inside the border. `length` counts
    /// the pixels with the border.
    fn at(place: f64, length: usize) -> Self {
        let place = (place + 0.5) as f32;
        let index = place as usize;
        Self { inside: place >= 0.0 && place < (length - 1) as f32, index, part: place - index as f32 }
    }
}

/// Bilinear mean of four neighbors in two rows.
fn mean(above: &[[f32; 4]], below: &[[f32; 4]], i: usize, fx: f32, fy: f32) -> [f32; 4] {
    let (a, b, c, d) = (&above[i], &above[i + 1], &below[i], &below[i + 1]);
    let mut out = [0.0; 4];
    for n in 0..4 {
        let top = a[n] + (b[n] - a[n]) * fx;
        let bottom = c[n] + (d[n] - c[n]) * fx;
        out[n] = top + (bottom - top) * fy;
    }
    out
}

/// Draws a premultiplied color over a pixel.
fn blend(pixel: &mut [u8], [r, g, b, a]: [f32; 4]) {
    if a > 0.5 {
        let keep = 1.0 - a / 255.0;
        for (o, s) in pixel.iter_mut().zip([r, g, b]) {
            *o = (f32::from(*o) * keep + s + 0.5) as u8;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The colors of 40 x 40 gray pixels on which a sprite is drawn whose left half is red.
    fn drawn(x: f64, turn: f64, mirrored: bool) -> impl Fn(usize, usize) -> [u8; 3] {
        let mut rgb = vec![10; 3 * 40 * 40];
        let sprite = Sprite::paint(20, 10, |u, _| (u < 0.5).then_some([200.0, 0.0, 0.0]));
        sprite.draw(&Pose { x, y: 20.0, w: 20.0, h: 10.0, turn }, mirrored, &mut rgb, 40);
        move |x, y| std::array::from_fn(|c| rgb[3 * (40 * y + x) + c])
    }

    const RED: [u8; 3] = [200, 0, 0];
    const GRAY: [u8; 3] = [10; 3];

    #[test]
    fn is_drawn_where_its_box_is_and_turned_and_mirrored() {
        let plain = drawn(20.0, 0.0, false);
        assert_eq!([(11, 16), (18, 23)].map(|(x, y)| plain(x, y)), [RED; 2]);
        assert_eq!([(9, 20), (21, 20), (12, 13), (12, 26)].map(|(x, y)| plain(x, y)), [GRAY; 4]);
        // A quarter turn moves left to top.
        let turned = drawn(20.0, 90.0, false);
        assert_eq!([turned(20, 12), turned(20, 28), turned(12, 20)], [RED, GRAY, GRAY]);
        let c = Pose { x: 20.0, y: 20.0, w: 20.0, h: 10.0, turn: 90.0 }.corners();
        assert!((c[0].0 - 25.0).abs() < 1e-6 && (c[0].1 - 10.0).abs() < 1e-6);
        let mirrored = drawn(20.0, 0.0, true);
        assert_eq!([mirrored(12, 20), mirrored(28, 20)], [GRAY, RED]);
        // Far outside nothing is drawn.
        for far in [-1e7, -60.0, 80.0, 1e7].map(|x| drawn(x, 45.0, false)) {
            assert!((0..1600).all(|k| far(k % 40, k / 40) == GRAY));
        }
    }

    #[test]
    fn place_and_corners_agree() {
        let p = Pose { x: 33.0, y: 12.0, w: 20.0, h: 14.0, turn: 33.0 };
        for ((x, y), (u, v)) in p.corners().into_iter().zip([(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)])
        {
            let (a, b) = p.place(x, y);
            assert!((a - u).abs() < 1e-8 && (b - v).abs() < 1e-8);
            let (a, b) = pose_place_fast(&p, x, y, &p.corners());
            assert!((a - u).abs() < 1e-8 && (b - v).abs() < 1e-8);
        }
    }
}
