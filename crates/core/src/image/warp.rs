//! Affine windows: a small template laid over a frame by six geometric parameters (Ross, Lim, Lin and Yang,
//! "Incremental learning for robust visual tracking", IJCV 77, 2008, section 3.3).
//!
//! ```text
//! g = (x, y, s, theta, r, phi)            center, scale, rotation, aspect, skew
//! A = R(theta) R(-phi) diag(s, s r) R(phi),       R(t) = [cos t, -sin t; sin t, cos t]
//! image place of template place (u, v):   (x, y)' + A (u, v)'
//! u = j + 1/2 - w/2,  v = i + 1/2 - h/2           of template column j and row i, from 0
//! ```
//!
//! `x`, `y` are in pixels, 0-based and continuous as in [`crate::region`]; the template is `w x h` and its corners
//! are `(+-w/2, +-h/2)`. `s` is the target's width as a multiple of the template's, `s r` its height; `theta` and
//! `phi` are in radians, from the x axis towards the y axis, which points down.
//!
//! Choices: the grid is centered. The grid of the authors' code runs from `1 - w/2` to `w/2` around a center
//! that is also half a pixel off, which shifts a track by a constant. Values between pixel centers are
//! bilinear; the outer half of a border pixel repeats it, and values beyond the image are 0.
//!
//! `A` has several geometric forms: `phi` may be turned by quarters if `s` and `s r` are swapped.
//! [`geometry`] returns the one with `phi` in `(-pi/4, pi/4]`, which is unique unless `r = 1`; the authors'
//! code may return any with `|phi| < pi/2`.

use super::{Gray, Window};
use crate::num::integer;
use crate::region::{Rect, Region};
use multiversion::multiversion;
use std::f64::consts::{FRAC_PI_2, FRAC_PI_4};

/// `(x, y, s, theta, r, phi)`; see the module.
pub type Geometry = [f64; 6];

/// Matrix `[a, b, c, d]` = `[a b; c d]` of a geometry.
pub fn matrix(&[_, _, s, theta, r, phi]: &Geometry) -> [f64; 4] {
    let (sin, cos) = phi.sin_cos();
    // R(-phi) diag(s, s r) R(phi) is symmetric.
    let (long, wide) = (s, s * r);
    let xx = long * cos * cos + wide * sin * sin;
    let xy = (wide - long) * sin * cos;
    let yy = long * sin * sin + wide * cos * cos;
    let (sin, cos) = theta.sin_cos();
    [cos * xx - sin * xy, cos * xy - sin * yy, sin * xx + cos * xy, sin * xy + cos * yy]
}

/// Geometry of a center and a matrix `[a, b, c, d]` with positive determinant, by its singular values.
///
/// `None` if the determinant is not above 0 or a number is not finite.
pub fn geometry(center: (f64, f64), [a, b, c, d]: [f64; 4]) -> Option<Geometry> {
    // A = R(theta - phi) diag(p, q) R(phi), with p and q from the parts of A that commute with rotations
    // and those that do not.
    let (e, f, g, h) = ((a + d) / 2.0, (a - d) / 2.0, (c + b) / 2.0, (c - b) / 2.0);
    let (turned, bent) = (e.hypot(h), f.hypot(g));
    let (mut p, mut q) = (turned + bent, turned - bent);
    let theta = h.atan2(e);
    let mut phi = if bent > 0.0 { (theta - g.atan2(f)) / 2.0 } else { 0.0 };
    while phi > FRAC_PI_4 {
        (phi, p, q) = (phi - FRAC_PI_2, q, p);
    }
    while phi <= -FRAC_PI_4 {
        (phi, p, q) = (phi + FRAC_PI_2, q, p);
    }
    let geometry = [center.0, center.1, p, theta, q / p, phi];
    (p > 0.0 && q > 0.0 && geometry.iter().all(|v| v.is_finite())).then_some(geometry)
}

/// Size of a template, in pixels.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Template {
    /// Columns, at least 1.
    pub width: usize,
    /// Rows, at least 1.
    pub height: usize,
}

impl Template {
    /// Number of pixels.
    pub fn pixels(&self) -> usize {
        self.width * self.height
    }

    /// Geometry that places the template on a region; `None` for a region without area or with a number that
    /// is not finite.
    ///
    /// Four corners are replaced by the nearest parallelogram, whose side nearer to the x axis is the width.
    /// Other polygons are replaced by their [`Region::rect`].
    pub fn geometry(&self, region: &Region) -> Option<Geometry> {
        let (width, height) = (self.width as f64, self.height as f64);
        if let Region::Polygon(p) = region
            && p.len() == 4
        {
            let center = (p.iter().map(|c| c.0).sum::<f64>() / 4.0, p.iter().map(|c| c.1).sum::<f64>() / 4.0);
            // The mean of a side and the one across.
            let along = |k: usize| {
                let (a, b, c, d) = (p[k], p[k + 1], p[(k + 2) % 4], p[(k + 3) % 4]);
                ((b.0 - a.0 + c.0 - d.0) / 2.0, (b.1 - a.1 + c.1 - d.1) / 2.0)
            };
            let (one, other) = (along(0), along(1));
            let flat = one.0.abs() >= one.1.abs();
            let (mut u, mut v) = if flat { (one, other) } else { (other, one) };
            // A side and its opposite are the same; the width goes right and the height down.
            if u.0 < 0.0 {
                u = (-u.0, -u.1);
            }
            if u.0 * v.1 - u.1 * v.0 < 0.0 {
                v = (-v.0, -v.1);
            }
            return geometry(center, [u.0 / width, v.0 / height, u.1 / width, v.1 / height]);
        }
        let rect = region.rect();
        let (x, y) = rect.center();
        geometry((x, y), [rect.w / width, 0.0, 0.0, rect.h / height])
    }

    /// Region that the template covers: an upright rectangle if rotation and skew are exactly 0, else four
    /// corners, clockwise from the template's top left.
    pub fn region(&self, geometry: &Geometry) -> Region {
        let [x, y, s, theta, r, phi] = *geometry;
        let (width, height) = (self.width as f64, self.height as f64);
        if theta == 0.0 && phi == 0.0 {
            let (w, h) = (s * width, s * r * height);
            return Region::Rect(Rect::new(x - w / 2.0, y - h / 2.0, w, h));
        }
        let [a, b, c, d] = matrix(geometry);
        let corner = |u: f64, v: f64| (x + a * u + b * v, y + c * u + d * v);
        let (u, v) = (width / 2.0, height / 2.0);
        Region::Polygon(vec![corner(-u, -v), corner(u, -v), corner(u, v), corner(-u, v)])
    }

    /// Smallest window that contains all pixels that [`Template::sample`] reads for these geometries.
    pub fn window<'g>(&self, geometries: impl IntoIterator<Item = &'g Geometry>) -> Window {
        let mut bounds = [f64::INFINITY, f64::INFINITY, f64::NEG_INFINITY, f64::NEG_INFINITY];
        for g in geometries {
            let (x, y) = self.reach(&matrix(g));
            let at = [g[0] - x, g[1] - y, g[0] + x, g[1] + y];
            for k in 0..2 {
                bounds[k] = bounds[k].min(at[k]);
                bounds[k + 2] = bounds[k + 2].max(at[k + 2]);
            }
        }
        // Values lie between pixel centers; one pixel more for rounding.
        let [left, top, right, bottom] = bounds.map(|v| v.clamp(-MAX_COORDINATE, MAX_COORDINATE));
        let (left, top) = ((left - 2.0).floor(), (top - 2.0).floor());
        let size = |from: f64, to: f64| (to + 3.0 - from).max(1.0) as usize;
        Window { x: left as i64, y: top as i64, w: size(left, right), h: size(top, bottom) }
    }

    /// Largest distance in x and in y from the center to a place of the template.
    fn reach(&self, [a, b, c, d]: &[f64; 4]) -> (f64, f64) {
        let (u, v) = (self.width as f64 / 2.0, self.height as f64 / 2.0);
        (a.abs() * u + b.abs() * v, c.abs() * u + d.abs() * v)
    }

    /// Writes the `width * height` gray values under the template, times `unit`, into `out`, row by row.
    ///
    /// # Panics
    /// When `out` has another length, or the image lacks a part of [`Template::window`] that the frame has: a
    /// mistake in the caller.
    pub fn sample(&self, image: &Gray, geometry: &Geometry, unit: f32, out: &mut [f32]) {
        assert_eq!(out.len(), self.pixels(), "values of a template");
        let matrix = matrix(geometry);
        let (reach, part) = (self.reach(&matrix), &image.part);
        let fits = |center: f64, reach: f64, start: i64, size: usize| {
            center - reach - 2.0 >= start as f64 && center + reach + 2.0 <= start as f64 + size as f64
        };
        if fits(geometry[0], reach.0, part.x, part.w) && fits(geometry[1], reach.1, part.y, part.h) {
            sample_inside(*self, image, geometry, &matrix, unit, out);
        } else {
            self.sample_anywhere(image, geometry, &matrix, unit, out);
        }
    }

    /// Place of the first value of row `i`, in units of pixel centers.
    #[inline(always)]
    fn row_start(&self, i: usize, geometry: &Geometry, &[a, b, c, d]: &[f64; 4]) -> (f64, f64) {
        let u = 0.5 - self.width as f64 / 2.0;
        let v = i as f64 + 0.5 - self.height as f64 / 2.0;
        (geometry[0] + a * u + b * v - 0.5, geometry[1] + c * u + d * v - 0.5)
    }

    fn sample_anywhere(
        &self,
        image: &Gray,
        geometry: &Geometry,
        matrix: &[f64; 4],
        unit: f32,
        out: &mut [f32],
    ) {
        let (right, bottom) = ((image.width - 1) as f64, (image.height - 1) as f64);
        for (i, row) in out.chunks_exact_mut(self.width).enumerate() {
            let (x, y) = self.row_start(i, geometry, matrix);
            for (j, out) in row.iter_mut().enumerate() {
                let (x, y) = (x + matrix[0] * j as f64, y + matrix[2] * j as f64);
                let inside = x >= -0.5 && x <= right + 0.5 && y >= -0.5 && y <= bottom + 0.5;
                *out = if inside {
                    unit * bilinear(image, x.clamp(0.0, right), y.clamp(0.0, bottom))
                } else {
                    0.0
                };
            }
        }
    }
}

/// Largest absolute coordinate of a window, in pixels, beyond any frame.
const MAX_COORDINATE: f64 = 1e6;
/// Number of template places that are processed together.
const LANES: usize = 16;

/// Like [`Template::sample_anywhere`], for places more than a pixel away from the image's border. The
/// operations are the same, on whole vectors except for the look-up of pixels.
#[multiversion(targets("x86_64+avx512f+avx512vl+avx512dq", "x86_64+avx2"))]
fn sample_inside(
    template: Template,
    image: &Gray,
    geometry: &Geometry,
    matrix: &[f64; 4],
    unit: f32,
    out: &mut [f32],
) {
    let (left, top, stride) = (image.part.x as i32, image.part.y as i32, image.part.w as i32);
    for (i, row) in out.chunks_exact_mut(template.width).enumerate() {
        let (x, y) = template.row_start(i, geometry, matrix);
        for (block, out) in row.chunks_mut(LANES).enumerate() {
            let (mut at, mut fx, mut fy) = ([0_i32; LANES], [0.0_f32; LANES], [0.0_f32; LANES]);
            for l in 0..LANES {
                let j = (LANES * block + l) as f64;
                let (x, y) = (x + matrix[0] * j, y + matrix[2] * j);
                let whole = [x.floor(), y.floor()];
                let [column, row] = whole.map(|v| integer(v) as i32);
                fx[l] = (x - whole[0]) as f32;
                fy[l] = (y - whole[1]) as f32;
                at[l] = (row - top).wrapping_mul(stride).wrapping_add(column - left);
            }
            // Places beyond a row's end may lie anywhere, and are dropped.
            let corners = at.map(|at| image.corners.get(at as usize).copied().unwrap_or_default());
            let mut values = [0.0_f32; LANES];
            for l in 0..LANES {
                // Numbers of a byte: their conversion from i32 is a single instruction.
                let corner = |k: u32| (corners[l] >> (8 * k) & 255) as i32 as f32;
                let upper = corner(0) + fx[l] * (corner(1) - corner(0));
                let lower = corner(2) + fx[l] * (corner(3) - corner(2));
                values[l] = unit * (upper + fy[l] * (lower - upper));
            }
            out.copy_from_slice(&values[..out.len()]);
        }
    }
}

/// Value at a place between `(0, 0)` and `(width - 1, height - 1)`.
#[inline(always)]
fn bilinear(image: &Gray, x: f64, y: f64) -> f32 {
    let (column, row) = (x as usize, y as usize);
    let (fx, fy) = ((x - column as f64) as f32, (y - row as f64) as f32);
    let part = &image.part;
    let at = (row - part.y as usize) * part.w + (column - part.x as usize);
    let [value, right, below, both] = image.corners[at].to_le_bytes().map(f32::from);
    let upper = value + fx * (right - value);
    let lower = below + fx * (both - below);
    upper + fy * (lower - upper)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::image::Frame;
    use proptest::prelude::*;
    use trackfail_testing::assert_near;

    const TEMPLATE: Template = Template { width: 8, height: 8 };

    fn image(width: usize, height: usize, f: impl Fn(usize, usize) -> u8) -> Gray {
        let part = Window { x: 0, y: 0, w: width, h: height };
        let values: Vec<u8> = (0..width * height).map(|k| f(k % width, k / width)).collect();
        Gray::of_values(width, height, part, &values)
    }

    fn sampled(template: Template, image: &Gray, geometry: &Geometry) -> Vec<f32> {
        let mut out = vec![0.0; template.pixels()];
        template.sample(image, geometry, 1.0, &mut out);
        out
    }

    // python3: import numpy as np; from scipy.ndimage import map_coordinates
    // img=np.fromfunction(lambda i,j:(7*j+13*i+i*j)%251,(20,24))
    // R=lambda t:np.array([[np.cos(t),-np.sin(t)],[np.sin(t),np.cos(t)]])
    // A=R(.3)@R(-.2)@np.diag([1.5,.9])@R(.2); v,u=np.mgrid[:8,:8]-3.5
    // p=np.array([[11.7],[9.4]])+A@np.array([u.ravel(),v.ravel()])
    // map_coordinates(img,[p[1]-.5,p[0]-.5],order=1)[[0,9,27,36,55,63]]
    #[test]
    fn samples_agree_with_scipy() {
        let image = image(24, 20, |j, i| ((7 * j + 13 * i + i * j) % 251) as u8);
        let out = sampled(TEMPLATE, &image, &[11.7, 9.4, 1.5, 0.3, 0.6, 0.2]);
        assert_near([0, 9, 27, 36, 55, 63].map(|at| f64::from(out[at])), SCIPY, 1e-4, "");
    }
    const SCIPY: [f64; 6] = [150.686002, 188.461703, 20.473021, 65.708638, 200.036327, 216.335319];

    #[test]
    fn whole_pixels_are_copied_exactly() {
        let image = image(20, 16, |j, i| (3 * j + 11 * i) as u8);
        for (x, y) in [(0, 0), (3, 5), (12, 8)] {
            let region = Region::Rect(Rect::new(x as f64, y as f64, 8.0, 8.0));
            let out = sampled(TEMPLATE, &image, &TEMPLATE.geometry(&region).unwrap());
            for (k, v) in out.iter().enumerate() {
                assert_eq!(*v, (3 * (x + k % 8) + 11 * (y + k / 8)) as f32);
            }
        }
    }

    // By hand: a template of twice the image's pixels has the outer half of the border pixels around it, and
    // one of four times its size nothing beyond.
    #[test]
    fn borders_repeat_for_half_a_pixel_and_then_are_0() {
        let image = image(2, 1, |j, _| [10, 30][j]);
        let at = |w: f64| {
            let region = Region::Rect(Rect::new(1.0 - w / 2.0, 0.0, w, 1.0));
            let template = Template { width: 4, height: 1 };
            sampled(template, &image, &template.geometry(&region).unwrap())
        };
        assert_eq!(at(2.0), [10.0, 15.0, 25.0, 30.0]);
        assert_eq!(at(8.0), [0.0, 10.0, 30.0, 0.0]);
    }

    #[test]
    fn regions_of_any_four_corners_in_any_order_come_back() {
        let turned = [25.0, 24.0, 1.5, 0.5, 0.4, 0.0];
        let corners = TEMPLATE.region(&turned).corners();
        for start in 0..4 {
            let mut corners = corners.clone();
            corners.rotate_left(start);
            for _ in 0..2 {
                corners.reverse();
                let again = TEMPLATE.geometry(&Region::Polygon(corners.clone())).unwrap();
                assert_near(again, turned, 1e-12, start);
            }
        }
        let rect = Region::Rect(Rect::new(3.25, 4.5, 12.0, 30.0));
        assert_eq!(TEMPLATE.region(&TEMPLATE.geometry(&rect).unwrap()), rect);
        assert_eq!(TEMPLATE.geometry(&rect), Some([9.25, 19.5, 1.5, 0.0, 2.5, 0.0]));
        let line = Region::Polygon(vec![(0.0, 0.0), (1.0, 1.0), (2.0, 2.0), (1.0, 1.0)]);
        assert_eq!(TEMPLATE.geometry(&line), None);
        assert_eq!(TEMPLATE.geometry(&Region::Rect(Rect::new(0.0, f64::NAN, 1.0, 1.0))), None);
    }

    fn geometries() -> impl Strategy<Value = Geometry> {
        let aspect = prop_oneof![0.05..0.95, 1.05..9.0];
        (-99.0..99.0, -99.0..99.0, 0.05..9.0, -3.1..3.1, aspect, -0.78..0.78)
            .prop_map(|(x, y, s, theta, r, phi)| [x, y, s, theta, r, phi])
    }

    proptest! {
        #[test]
        fn geometry_and_matrix_are_inverse(g in geometries()) {
            assert_near(geometry((g[0], g[1]), matrix(&g)).unwrap(), g, 1e-9, "");
        }

        // Every matrix that does not mirror, also those whose geometry is not unique.
        #[test]
        fn matrix_and_geometry_are_inverse(m in prop::array::uniform4(-3.0..3.0_f64), r in 0.1..3.0_f64, t in -3.0..3.0_f64) {
            let round = [r * t.cos(), -r * t.sin(), r * t.sin(), r * t.cos()];
            for m in [m, round] {
                let determinant = m[0] * m[3] - m[1] * m[2];
                prop_assume!(determinant.abs() > 1e-6);
                let found = geometry((0.0, 0.0), m);
                prop_assert_eq!(found.is_some(), determinant > 0.0);
                if let Some(g) = found {
                    prop_assert!(g[5] > -FRAC_PI_4 && g[5] <= FRAC_PI_4);
                    assert_near(matrix(&g), m, 1e-9, "");
                }
            }
        }

        #[test]
        fn vectors_and_parts_of_a_frame_change_no_bit(g in geometries(), right in any::<bool>()) {
            let g = [g[0] + if right { 150.0 } else { 0.0 }, g[1] + 60.0, 0.3 + 0.4 * g[2], g[3], g[4].min(3.0), g[5]];
            let frame = Frame::from_fn(230, 120, |x, y| [(x * 31 + y * 17) as u8, (x * y) as u8, (x ^ y) as u8]);
            for template in [TEMPLATE, Template { width: 19, height: 5 }] {
                let mut plain = vec![0.0; template.pixels()];
                let whole = Gray::of_part(&frame, &Window { x: 0, y: 0, w: 230, h: 120 });
                template.sample_anywhere(&whole, &g, &matrix(&g), 0.01, &mut plain);
                let part = Gray::of_part(&frame, &template.window([&g]));
                for image in [whole, part] {
                    let mut out = vec![0.0; template.pixels()];
                    template.sample(&image, &g, 0.01, &mut out);
                    prop_assert_eq!(&out, &plain);
                }
            }
        }

        // A target that moves by whole pixels looks the same.
        #[test]
        fn samples_move_with_the_picture(g in geometries(), dx in 0_usize..9, dy in 0_usize..9) {
            let g = [60.0 + g[0] / 99.0, 60.0 + g[1] / 99.0, 0.3 + 0.1 * g[2], g[3], g[4].min(3.0), g[5]];
            let texture = |j: usize, i: usize| ((j * 7919 + i * 104_729) % 256) as u8;
            let still = image(128, 128, texture);
            let moved = image(128, 128, |j, i| texture(j.wrapping_sub(dx).min(127), i.wrapping_sub(dy).min(127)));
            let there = [g[0] + dx as f64, g[1] + dy as f64, g[2], g[3], g[4], g[5]];
            let [a, b] = [(&still, &g), (&moved, &there)].map(|(image, g)| sampled(TEMPLATE, image, g));
            assert_near(a.into_iter().map(f64::from), b.into_iter().map(f64::from), 1e-3, "");
        }
    }
}
