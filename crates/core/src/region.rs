//! Regions of a target: rectangles and convex polygons, and how much two of them overlap.
//!
//! Coordinates are continuous pixels, 0-based: pixel column `j` covers `[j, j + 1)`, row `i` covers
//! `[i, i + 1)`, `x` grows to the right and `y` downwards. Formats that count from 1 (OTB) are shifted
//! when they are read.

mod overlap;

pub use overlap::Areas;

use serde::{Deserialize, Serialize};

/// Upright rectangle: left, top, width and height in pixels.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Rect {
    /// Left edge.
    pub x: f64,
    /// Top edge.
    pub y: f64,
    /// Width, at least 0.
    pub w: f64,
    /// Height, at least 0.
    pub h: f64,
}

impl Rect {
    /// Creates a rectangle from left, top, width and height.
    pub fn new(x: f64, y: f64, w: f64, h: f64) -> Self {
        Self { x, y, w, h }
    }

    /// Center, in pixels.
    pub fn center(&self) -> (f64, f64) {
        (self.x + self.w / 2.0, self.y + self.h / 2.0)
    }

    /// Area, in square pixels.
    pub fn area(&self) -> f64 {
        self.w * self.h
    }

    /// The rectangle moved by `(dx, dy)`.
    pub fn shifted(&self, dx: f64, dy: f64) -> Self {
        Self::new(self.x + dx, self.y + dy, self.w, self.h)
    }

    /// The four corners, clockwise from the top left.
    pub fn corners(&self) -> [(f64, f64); 4] {
        let (r, b) = (self.x + self.w, self.y + self.h);
        [(self.x, self.y), (r, self.y), (r, b), (self.x, b)]
    }
}

/// A target's region in one frame.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub enum Region {
    /// Upright rectangle.
    Rect(Rect),
    /// Convex polygon of at least 3 corners, in either orientation.
    Polygon(Vec<(f64, f64)>),
}

/// Largest absolute coordinate, in pixels.
const MAX_COORDINATE: f64 = 1e15;

/// Reason why numbers do not make a region.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum RegionError {
    /// NaN or infinity among the numbers.
    #[error("a coordinate is not a finite number")]
    NotFinite,
    /// A coordinate so large that areas overflow or neighboring pixels become equal.
    #[error("a coordinate is beyond {MAX_COORDINATE:e} pixels, where no image is")]
    TooFar,
    /// A width or height of 0 or less, or a polygon without area.
    #[error("the region has no area")]
    Empty,
    /// A count of numbers other than 4, 6, 8, 10 ...
    #[error("a region takes 4 numbers (x,y,w,h) or at least 3 corners (x1,y1,x2,y2,...), not {0} numbers")]
    Count(usize),
    /// A polygon that is not convex.
    #[error("the polygon is not convex; only convex polygons can be scored exactly")]
    NotConvex,
}

impl Region {
    /// Region from 4 numbers (`x,y,w,h`) or from the corners of a convex polygon.
    ///
    /// # Errors
    /// See [`RegionError`].
    pub fn from_numbers(v: &[f64]) -> Result<Self, RegionError> {
        if v.iter().any(|a| !a.is_finite()) {
            return Err(RegionError::NotFinite);
        }
        if v.iter().any(|a| a.abs() > MAX_COORDINATE) {
            return Err(RegionError::TooFar);
        }
        match v.len() {
            // The product of two tiny sizes is 0.
            4 if v[2] > 0.0 && v[3] > 0.0 && v[2] * v[3] > 0.0 => {
                Ok(Self::Rect(Rect::new(v[0], v[1], v[2], v[3])))
            }
            4 => Err(RegionError::Empty),
            n if n >= 6 && n % 2 == 0 => {
                let corners: Vec<_> = v.chunks_exact(2).map(|c| (c[0], c[1])).collect();
                if signed_area(&corners).abs() < 1e-9 {
                    return Err(RegionError::Empty);
                }
                if !is_convex(&corners) {
                    return Err(RegionError::NotConvex);
                }
                Ok(Self::Polygon(corners))
            }
            n => Err(RegionError::Count(n)),
        }
    }

    /// Numbers of which [`Region::from_numbers`] makes the region: `x,y,w,h`, or the corners.
    pub fn numbers(&self) -> Vec<f64> {
        match self {
            Self::Rect(r) => vec![r.x, r.y, r.w, r.h],
            Self::Polygon(corners) => corners.iter().flat_map(|c| [c.0, c.1]).collect(),
        }
    }

    /// Region that stands for "no region": all its numbers are NaN.
    pub fn nowhere() -> Self {
        Self::Rect(Rect::new(f64::NAN, f64::NAN, f64::NAN, f64::NAN))
    }

    /// True if all coordinates are finite.
    pub fn is_finite(&self) -> bool {
        self.corners().iter().all(|corner| corner.0.is_finite() && corner.1.is_finite())
    }

    /// The corners in order.
    pub fn corners(&self) -> Vec<(f64, f64)> {
        match self {
            Self::Rect(r) => r.corners().to_vec(),
            Self::Polygon(p) => p.clone(),
        }
    }

    /// Area in square pixels.
    pub fn area(&self) -> f64 {
        match self {
            Self::Rect(r) => r.area(),
            Self::Polygon(p) => signed_area(p).abs(),
        }
    }

    /// Upright rectangle that replaces the region in methods that need one.
    ///
    /// A quadrilateral becomes the rectangle with its center and its mean side lengths, as the OTB
    /// code treats the affine boxes of IVT; other polygons become their bounds. An axis-aligned
    /// quadrilateral is kept exactly either way.
    pub fn rect(&self) -> Rect {
        let p = match self {
            Self::Rect(r) => return *r,
            Self::Polygon(p) => p,
        };
        let (x0, y0, x1, y1) = bounds(p);
        if p.len() != 4 || p.iter().all(|c| (c.0 == x0 || c.0 == x1) && (c.1 == y0 || c.1 == y1)) {
            return self.bounds();
        }
        let side = |a: (f64, f64), b: (f64, f64)| (b.0 - a.0).hypot(b.1 - a.1);
        let (s0, s1) =
            ((side(p[0], p[1]) + side(p[2], p[3])) / 2.0, (side(p[1], p[2]) + side(p[3], p[0])) / 2.0);
        // The side whose direction is nearer to the x axis is the width.
        let flat = (p[1].0 - p[0].0).abs() >= (p[1].1 - p[0].1).abs();
        let (w, h) = if flat { (s0, s1) } else { (s1, s0) };
        let cx = p.iter().map(|c| c.0).sum::<f64>() / 4.0;
        let cy = p.iter().map(|c| c.1).sum::<f64>() / 4.0;
        Rect::new(cx - w / 2.0, cy - h / 2.0, w, h)
    }

    /// Smallest upright rectangle around the region.
    pub fn bounds(&self) -> Rect {
        match self {
            Self::Rect(r) => *r,
            Self::Polygon(p) => {
                let (x0, y0, x1, y1) = bounds(p);
                Rect::new(x0, y0, x1 - x0, y1 - y0)
            }
        }
    }

    /// The region moved by `(dx, dy)`.
    pub fn shifted(&self, dx: f64, dy: f64) -> Self {
        match self {
            Self::Rect(r) => Self::Rect(r.shifted(dx, dy)),
            Self::Polygon(p) => Self::Polygon(p.iter().map(|c| (c.0 + dx, c.1 + dy)).collect()),
        }
    }

    /// Area of the intersection with `other` in square pixels, by exact clipping.
    pub fn intersection(&self, other: &Self) -> f64 {
        self.clipped(other).map_or(0.0, |part| part.area())
    }

    /// Part of the region that lies in `window`; `None` if it has no area.
    pub fn clipped(&self, window: &Self) -> Option<Self> {
        if let (Self::Rect(a), Self::Rect(b)) = (self, window) {
            let (x, y) = (a.x.max(b.x), a.y.max(b.y));
            let (w, h) = ((a.x + a.w).min(b.x + b.w) - x, (a.y + a.h).min(b.y + b.h) - y);
            return (w > 0.0 && h > 0.0).then(|| Self::Rect(Rect::new(x, y, w, h)));
        }
        let part = clip(&self.corners(), &window.corners());
        (signed_area(&part).abs() > 0.0).then_some(Self::Polygon(part))
    }
}

fn bounds(p: &[(f64, f64)]) -> (f64, f64, f64, f64) {
    p.iter().fold((f64::INFINITY, f64::INFINITY, f64::NEG_INFINITY, f64::NEG_INFINITY), |b, c| {
        (b.0.min(c.0), b.1.min(c.1), b.2.max(c.0), b.3.max(c.1))
    })
}

fn cross(o: (f64, f64), a: (f64, f64), b: (f64, f64)) -> f64 {
    (a.0 - o.0) * (b.1 - o.1) - (a.1 - o.1) * (b.0 - o.0)
}

fn signed_area(p: &[(f64, f64)]) -> f64 {
    // Relative to the first corner, so that polygons far from the origin lose no digits.
    (1..p.len().saturating_sub(1)).map(|i| cross(p[0], p[i], p[i + 1])).sum::<f64>() / 2.0
}

fn is_convex(p: &[(f64, f64)]) -> bool {
    let n = p.len();
    let orientation = signed_area(p).signum();
    let (x0, y0, x1, y1) = bounds(p);
    let slack = 1e-6 * (x1 - x0) * (y1 - y0) + 1e-9;
    let turns = (0..n).all(|i| cross(p[i], p[(i + 1) % n], p[(i + 2) % n]) * orientation >= -slack);
    // A star can also turn the same way at all corners; its fan of triangles then changes sign.
    let fan = (1..n - 1).all(|i| cross(p[0], p[i], p[i + 1]) * orientation >= -slack);
    turns && fan
}

/// Sutherland-Hodgman clipping of a convex polygon by another.
fn clip(subject: &[(f64, f64)], window: &[(f64, f64)]) -> Vec<(f64, f64)> {
    let orientation = signed_area(window).signum();
    let mut out = subject.to_vec();
    for i in 0..window.len() {
        let (a, b) = (window[i], window[(i + 1) % window.len()]);
        let input = std::mem::take(&mut out);
        let side = |p: (f64, f64)| cross(a, b, p) * orientation;
        for k in 0..input.len() {
            let (p, q) = (input[k], input[(k + 1) % input.len()]);
            let (sp, sq) = (side(p), side(q));
            if sp >= 0.0 {
                out.push(p);
            }
            if (sp > 0.0 && sq < 0.0) || (sp < 0.0 && sq > 0.0) {
                let t = sp / (sp - sq);
                out.push((p.0 + t * (q.0 - p.0), p.1 + t * (q.1 - p.1)));
            }
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use trackfail_testing::assert_near;

    #[test]
    fn octagon_of_two_unit_squares() {
        // Unit square and the same turned by 45 degrees: the regular octagon of area 2 (sqrt 2 - 1).
        let a = Region::Rect(Rect::new(-0.5, -0.5, 1.0, 1.0));
        let r = 0.5_f64.sqrt();
        let b = Region::Polygon(vec![(r, 0.0), (0.0, r), (-r, 0.0), (0.0, -r)]);
        assert!((a.intersection(&b) - 2.0 * (2.0_f64.sqrt() - 1.0)).abs() < 1e-12);
    }

    #[test]
    fn rejects_numbers_that_are_not_a_region() {
        // Pentagram: every turn has the same sign, yet it is not convex.
        let angles = (0..5).map(|k| f64::from(k) * 4.0 * std::f64::consts::PI / 5.0);
        let star: Vec<f64> = angles.flat_map(|a| [a.cos(), a.sin()]).collect();
        for (numbers, error) in [
            (&[0.0, f64::NAN, 1.0, 1.0][..], RegionError::NotFinite),
            (&[0.0, 0.0, 0.0, 1.0], RegionError::Empty),
            (&[0.0, 0.0, 1e-200, 1e-200], RegionError::Empty),
            (&[0.0, -1e16, 1.0, 1.0], RegionError::TooFar),
            (&[0.0, 0.0, 1e308, 1e308], RegionError::TooFar),
            (&[0.0; 5], RegionError::Count(5)),
            (&[0.0, 0.0, 2.0, 1.0, 0.0, 2.0, 0.5, 1.0], RegionError::NotConvex),
            (&star, RegionError::NotConvex),
        ] {
            assert_eq!(Region::from_numbers(numbers), Err(error), "{numbers:?}");
        }
    }

    #[test]
    fn a_turned_box_keeps_centre_and_sides() {
        let (s, c) = 0.3_f64.sin_cos();
        let p = [(-20.0, -10.0), (20.0, -10.0), (20.0, 10.0), (-20.0, 10.0)]
            .map(|(u, v)| (100.0 + c * u - s * v, 50.0 + s * u + c * v));
        let r = Region::Polygon(p.to_vec()).rect();
        assert_near([r.x, r.y, r.w, r.h], [80.0, 40.0, 40.0, 20.0], 1e-9, "");
    }

    fn rects() -> impl Strategy<Value = Rect> {
        (-50.0..50.0, -50.0..50.0, 0.5..60.0, 0.5..60.0).prop_map(|(x, y, w, h)| Rect::new(x, y, w, h))
    }

    proptest! {
        #[test]
        fn any_numbers_are_a_region_or_refused(
            v in prop::collection::vec(prop_oneof![any::<f64>(), -9.0..9.0, Just(1e15), Just(1e-160)], 0..10),
            other in rects(),
        ) {
            if let Ok(region) = Region::from_numbers(&v) {
                prop_assert!(region.area() > 0.0 && region.area().is_finite());
                let rect = region.rect();
                prop_assert!([rect.x, rect.y, rect.w, rect.h].iter().all(|a| a.is_finite()));
                prop_assert!(region.intersection(&Region::Rect(other)) >= 0.0);
            }
        }

        #[test]
        fn clipping_agrees_with_the_closed_form(a in rects(), b in rects()) {
            let exact = Region::Rect(a).intersection(&Region::Rect(b));
            let (pa, pb) = (Region::Polygon(a.corners().to_vec()), Region::Polygon(b.corners().to_vec()));
            prop_assert!((exact - pa.intersection(&pb)).abs() < 1e-9);
            prop_assert!((pb.intersection(&pa) - exact).abs() < 1e-9);
            prop_assert!(exact <= a.area().min(b.area()) + 1e-9);
        }

        #[test]
        fn moving_both_changes_nothing(a in rects(), b in rects(), dx in -9.0..9.0, dy in -9.0..9.0) {
            let (ra, rb) = (Region::Polygon(a.corners().to_vec()), Region::Rect(b));
            let moved = ra.shifted(dx, dy).intersection(&rb.shifted(dx, dy));
            prop_assert!((ra.intersection(&rb) - moved).abs() < 1e-8);
        }
    }
}
