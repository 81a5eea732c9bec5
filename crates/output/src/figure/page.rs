//! A figure after layout: lines, filled shapes and texts, in units of 0.7 pt from the top left corner.

use super::font;
use super::style::{CASING, Color, Dash, Style};
use plotters::style::text_anchor::HPos;
use trackfail_core::image::Frame;

pub type Point = (f64, f64);

/// An element of a page.
#[derive(Clone)]
pub enum Shape {
    /// A line with round ends, so that a line from a point to itself is a disk.
    Line {
        points: Vec<Point>,
        style: Style,
    },
    Fill {
        corners: Vec<Point>,
        color: Color,
        opacity: f64,
    },
    /// A text; the middle of its lower-case letters is at the height of the point.
    Text {
        text: String,
        at: Point,
        size: f64,
        anchor: HPos,
        upwards: bool,
        color: Color,
    },
}

/// Opacity of bands.
pub const BAND: f64 = 0.18;
/// Distance between two lines of text, in units.
pub const LINE: f64 = 14.0;

/// An upright rectangle on the page, in units.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Area {
    pub x: f64,
    pub y: f64,
    pub w: f64,
    pub h: f64,
}

impl Area {
    /// Rectangle around a center, which extends by `w` to both sides, and by `h` up and down.
    pub fn around((x, y): Point, w: f64, h: f64) -> Self {
        Self { x: x - w, y: y - h, w: 2.0 * w, h: 2.0 * h }
    }

    pub fn middle(&self) -> Point {
        (self.x + self.w / 2.0, self.y + self.h / 2.0)
    }

    pub fn right(&self) -> f64 {
        self.x + self.w
    }

    pub fn bottom(&self) -> f64 {
        self.y + self.h
    }

    pub fn corners(&self) -> Vec<Point> {
        let (l, t, r, b) = (self.x, self.y, self.right(), self.bottom());
        vec![(l, t), (r, t), (r, b), (l, b)]
    }

    pub fn contains(&self, p: Point) -> bool {
        (self.x..=self.right()).contains(&p.0) && (self.y..=self.bottom()).contains(&p.1)
    }

    /// True if the two areas have at most edges in common.
    pub fn is_apart(&self, other: &Self) -> bool {
        let beside = self.right() <= other.x || other.right() <= self.x;
        beside || self.bottom() <= other.y || other.bottom() <= self.y
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
        let at = |t: f64| if t == 1.0 { b } else { (a.0 + t * dx, a.1 + t * dy) };
        (t0 <= t1).then_some((at(t0), at(t1)))
    }
}

/// A figure after layout. Its video frames lie under its shapes.
pub struct Page {
    pub title: String,
    pub width: f64,
    pub height: f64,
    pub frames: Vec<(Area, Frame)>,
    pub shapes: Vec<Shape>,
}

impl Page {
    pub fn new(title: &str, width: f64) -> Self {
        Self { title: font::clean(title), width, height: 0.0, frames: Vec::new(), shapes: Vec::new() }
    }

    pub fn line(&mut self, points: Vec<Point>, style: Style) {
        self.shapes.push(Shape::Line { points, style });
    }

    pub fn fill(&mut self, corners: Vec<Point>, color: Color) {
        self.shapes.push(Shape::Fill { corners, color, opacity: 1.0 });
    }

    pub fn band(&mut self, corners: Vec<Point>, color: Color) {
        self.shapes.push(Shape::Fill { corners, color, opacity: BAND });
    }

    pub fn disc(&mut self, center: Point, radius: f64, color: Color) {
        self.line(vec![center, center], Style::solid(color, 2.0 * radius));
    }

    pub fn text(&mut self, text: &str, at: Point, size: f64, anchor: HPos, color: Color) {
        if !text.trim().is_empty() {
            let text = font::clean(text);
            self.shapes.push(Shape::Text { text, at, size, anchor, upwards: false, color });
        }
    }

    /// Adds lines of text below each other. The first line begins at the height of `at`. Returns the height
    /// at which a further line would begin.
    pub fn lines(&mut self, lines: &[String], at: Point, size: f64, anchor: HPos, color: Color) -> f64 {
        for (k, line) in lines.iter().enumerate() {
            self.text(line, (at.0, at.1 + LINE * (k as f64 + 0.5)), size, anchor, color);
        }
        at.1 + LINE * lines.len() as f64
    }

    /// Adds lines of text that read from bottom to top, centered on a point.
    pub fn lines_upwards(&mut self, lines: Vec<String>, at: Point, size: f64, color: Color) {
        for (k, text) in lines.into_iter().enumerate() {
            let at = (at.0 + LINE * k as f64, at.1);
            self.shapes.push(Shape::Text { text, at, size, anchor: HPos::Center, upwards: true, color });
        }
    }

    /// Adds the part of a polyline that lies inside `area`.
    pub fn clipped(&mut self, points: &[Point], area: &Area, style: Style) {
        let mut runs: Vec<Vec<Point>> = Vec::new();
        for pair in points.windows(2) {
            match (area.clip(pair[0], pair[1]), runs.last_mut()) {
                (Some((a, b)), Some(run)) if run.last() == Some(&a) => run.push(b),
                (Some((a, b)), _) => runs.push(vec![a, b]),
                (None, _) => runs.push(Vec::new()),
            }
        }
        for run in runs.into_iter().filter(|run| !run.is_empty()) {
            self.line(run, style);
        }
    }

    /// Adds the outline of a box on a frame that lies in `area`, over a dark outline. Returns true if all
    /// corners could be placed.
    pub fn outline(&mut self, mut corners: Vec<Point>, area: &Area, style: Style, casing: f64) -> bool {
        let has_place = corners.iter().all(|c| c.0.is_finite() && c.1.is_finite());
        if has_place {
            corners.extend(corners.first().copied());
            self.clipped(&corners, area, Style::solid(CASING, casing));
            self.clipped(&corners, area, style);
        }
        has_place
    }
}

/// Points in integer coordinates, `scale` per unit.
pub fn whole(points: &[Point], scale: f64) -> Vec<(i32, i32)> {
    points.iter().map(|p| ((p.0 * scale).round() as i32, (p.1 * scale).round() as i32)).collect()
}

/// Strokes of a dashed or solid line in integer coordinates. First and last point of a stroke may be equal.
pub fn strokes(points: &[Point], dash: Dash, scale: f64) -> Vec<Vec<(i32, i32)>> {
    let stroke = |run: Vec<Point>| {
        let mut run = whole(&run, scale);
        run.dedup();
        if run.len() == 1 {
            run.push(run[0]);
        }
        run
    };
    dashes(points, dash.0).into_iter().map(stroke).collect()
}

/// Width of a line in integer coordinates.
pub fn whole_width(style: &Style, scale: f64) -> u32 {
    (style.width * scale).round().max(1.0) as u32
}

/// Share of a text that stands before its anchor point.
pub fn share_before(anchor: HPos) -> f64 {
    match anchor {
        HPos::Left => 0.0,
        HPos::Center => 0.5,
        HPos::Right => 1.0,
    }
}

/// Splits a polyline into the strokes of a dash pattern.
fn dashes(points: &[Point], pattern: &[f64]) -> Vec<Vec<Point>> {
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
            // A place that is no number ends it, too.
            if length.is_nan() || length <= left {
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

    // Out at the top, back in further right: two lines.
    #[test]
    fn a_line_that_leaves_the_area_is_two() {
        let mut page = Page::new("", 1.0);
        let points = [(0.0, 0.5), (0.2, -0.5), (0.6, -0.5), (0.8, 0.5), (1.0, 0.5)];
        page.clipped(&points, &UNIT, Style::solid(Color::BLACK, 1.0));
        let line =
            |shape: &Shape| if let Shape::Line { points, .. } = shape { points.clone() } else { vec![] };
        let lines: Vec<Vec<Point>> = page.shapes.iter().map(line).collect();
        assert_eq!(lines.iter().map(Vec::len).collect::<Vec<_>>(), [2, 3]);
        assert!(lines[0][1].1.abs() < 1e-12 && lines[1][0].1.abs() < 1e-12);
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
