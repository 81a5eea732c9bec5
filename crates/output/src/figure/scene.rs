//! The scene of a figure: lines, shapes, texts and pictures, in units of 0.7 pt from the top left corner.

use super::font;
use super::style::{Dash, Style};
use trackfail_core::image::Frame;

pub type Point = (f64, f64);

/// Horizontal place of a text relative to its point; vertically its small letters are centered on the point.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Anchor {
    Start,
    Middle,
    End,
}

#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Stroke {
    pub rgb: [u8; 3],
    pub width: f64,
    pub dash: Dash,
}

impl Stroke {
    /// The stroke of a style; a width that could not be seen, or is absurd, is brought into a range.
    pub fn of(style: &Style) -> Self {
        let width = if style.width.is_finite() { style.width.clamp(0.3, 10.0) } else { 1.4 };
        Self { rgb: style.color.rgb(), width, dash: style.dash }
    }
}

#[derive(Debug, Clone)]
pub enum Item {
    Line {
        points: Vec<Point>,
        stroke: Stroke,
    },
    Rect {
        area: Area,
        rgb: [u8; 3],
    },
    Polygon {
        corners: Vec<Point>,
        rgb: [u8; 3],
    },
    Circle {
        center: Point,
        radius: f64,
        rgb: [u8; 3],
    },
    /// The area between two lines over the same places from left to right, see-through.
    Band {
        upper: Vec<Point>,
        lower: Vec<Point>,
        rgb: [u8; 3],
    },
    Text {
        text: String,
        at: Point,
        size: f64,
        anchor: Anchor,
        upwards: bool,
        rgb: [u8; 3],
    },
}

/// A rectangle of the page.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Area {
    pub x: f64,
    pub y: f64,
    pub w: f64,
    pub h: f64,
}

impl Area {
    pub fn right(&self) -> f64 {
        self.x + self.w
    }

    pub fn bottom(&self) -> f64 {
        self.y + self.h
    }

    /// The part of the segment inside the area (Liang and Barsky 1984), or `None`.
    pub fn clip(&self, a: Point, b: Point) -> Option<(Point, Point)> {
        let (dx, dy) = (b.0 - a.0, b.1 - a.1);
        let (mut t0, mut t1) = (0.0_f64, 1.0_f64);
        for (p, q) in
            [(-dx, a.0 - self.x), (dx, self.right() - a.0), (-dy, a.1 - self.y), (dy, self.bottom() - a.1)]
        {
            if p == 0.0 {
                if q < 0.0 {
                    return None;
                }
            } else if p < 0.0 {
                t0 = t0.max(q / p);
            } else {
                t1 = t1.min(q / p);
            }
        }
        (t0 <= t1).then_some(((a.0 + t0 * dx, a.1 + t0 * dy), (a.0 + t1 * dx, a.1 + t1 * dy)))
    }
}

/// Opacity of a [`Item::Band`].
pub const BAND: f64 = 0.18;

/// A frame and the area that it fills; pictures lie under everything else.
#[derive(Debug, Clone)]
pub struct Picture {
    pub area: Area,
    pub frame: Frame,
}

#[derive(Debug, Clone)]
pub struct Scene {
    pub title: String,
    pub width: f64,
    pub height: f64,
    pub pictures: Vec<Picture>,
    pub items: Vec<Item>,
}

impl Scene {
    pub fn new(title: &str, width: f64) -> Self {
        let title = font::clean(title);
        Self { title, width, height: 0.0, pictures: Vec::new(), items: Vec::new() }
    }

    pub fn line(&mut self, points: Vec<Point>, stroke: Stroke) {
        self.items.push(Item::Line { points, stroke });
    }

    pub fn text(&mut self, text: &str, at: Point, size: f64, anchor: Anchor, rgb: [u8; 3]) {
        if !text.trim().is_empty() {
            self.items.push(Item::Text { text: text.to_owned(), at, size, anchor, upwards: false, rgb });
        }
    }

    /// Adds text that reads from the bottom to the top, centered on its point.
    pub fn text_upwards(&mut self, text: &str, at: Point, size: f64, rgb: [u8; 3]) {
        let (text, anchor) = (text.to_owned(), Anchor::Middle);
        self.items.push(Item::Text { text, at, size, anchor, upwards: true, rgb });
    }

    /// Adds a line through the points as far as it lies inside `area`.
    pub fn clipped(&mut self, points: &[Point], area: &Area, stroke: Stroke) {
        let mut run: Vec<Point> = Vec::new();
        for pair in points.windows(2) {
            let Some((a, b)) = area.clip(pair[0], pair[1]) else {
                self.flush(&mut run, stroke);
                continue;
            };
            if run.last() != Some(&a) {
                self.flush(&mut run, stroke);
                run.push(a);
            }
            run.push(b);
        }
        self.flush(&mut run, stroke);
    }

    fn flush(&mut self, run: &mut Vec<Point>, stroke: Stroke) {
        if run.len() > 1 {
            self.line(std::mem::take(run), stroke);
        }
        run.clear();
    }
}

/// The strokes of a dashed line, each a line of its own.
pub fn dashes(points: &[Point], pattern: &[f64]) -> Vec<Vec<Point>> {
    if pattern.is_empty() {
        return vec![points.to_vec()];
    }
    let mut out = Vec::new();
    let mut run: Vec<Point> = points.first().copied().into_iter().collect();
    let (mut turn, mut left) = (0, pattern[0]);
    for pair in points.windows(2) {
        let (mut a, b) = (pair[0], pair[1]);
        loop {
            let length = (b.0 - a.0).hypot(b.1 - a.1);
            if length <= left {
                left -= length;
                if turn % 2 == 0 {
                    run.push(b);
                }
                break;
            }
            let t = left / length;
            a = (a.0 + t * (b.0 - a.0), a.1 + t * (b.1 - a.1));
            if turn % 2 == 0 {
                run.push(a);
                out.push(std::mem::take(&mut run));
            } else {
                run = vec![a];
            }
            turn = (turn + 1) % pattern.len();
            left = pattern[turn];
        }
    }
    if turn % 2 == 0 && run.len() > 1 {
        out.push(run);
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const UNIT: Area = Area { x: 0.0, y: 0.0, w: 1.0, h: 1.0 };

    #[test]
    fn clips_by_hand() {
        assert_eq!(UNIT.clip((-1.0, 0.5), (2.0, 0.5)), Some(((0.0, 0.5), (1.0, 0.5))));
        assert_eq!(UNIT.clip((-1.0, 2.0), (2.0, 2.0)), None);
        assert_eq!(UNIT.clip((-1.0, 0.5), (0.5, 2.0)), None);
    }

    #[test]
    fn dashes_by_hand() {
        let d = dashes(&[(0.0, 0.0), (6.0, 0.0), (6.0, 6.0)], &[4.0, 3.0]);
        let expected = vec![vec![(0.0, 0.0), (4.0, 0.0)], vec![(6.0, 1.0), (6.0, 5.0)]];
        assert_eq!(d, expected);
    }

    fn length(line: &[Point]) -> f64 {
        line.windows(2).map(|p| (p[1].0 - p[0].0).hypot(p[1].1 - p[0].1)).sum()
    }

    proptest! {
        #[test]
        fn clipped_ends_lie_inside(a in (-3.0..3.0_f64, -3.0..3.0_f64), b in (-3.0..3.0_f64, -3.0..3.0_f64)) {
            if let Some((p, q)) = UNIT.clip(a, b) {
                for (x, y) in [p, q] {
                    prop_assert!((-1e-9..=1.0 + 1e-9).contains(&x) && (-1e-9..=1.0 + 1e-9).contains(&y));
                }
            } else {
                // The middle of a segment that misses the area is outside, whichever point is taken.
                for k in 0..=100 {
                    let t = f64::from(k) / 100.0;
                    let (x, y) = (a.0 + t * (b.0 - a.0), a.1 + t * (b.1 - a.1));
                    prop_assert!(!((1e-9..1.0 - 1e-9).contains(&x) && (1e-9..1.0 - 1e-9).contains(&y)));
                }
            }
        }

        #[test]
        fn strokes_take_their_share(points in prop::collection::vec((0.0..40.0_f64, 0.0..40.0_f64), 2..20)) {
            let strokes: f64 = dashes(&points, &[4.0, 3.0]).iter().map(|l| length(l)).sum();
            let total = length(&points);
            let whole = (total / 7.0).floor();
            let expected = 4.0 * whole + (total - 7.0 * whole).min(4.0);
            prop_assert!((strokes - expected).abs() < 1e-6, "{strokes} {expected}");
        }
    }
}
