//! Overlap of two regions, `|A ∩ B| / |A ∪ B|` in `[0, 1]`, by the rules that evaluation programs use.
//!
//! | rule | area | source |
//! |---|---|---|
//! | `exact` | of the polygons themselves | clipping ([`Region::intersection`]) |
//! | `raster-2014` | pixels whose row a scan line crosses, each row from the first to before the last crossing, counted from the upper left corner of both regions together; the last row falls away unless the tracker reaches further down than the truth; where it reaches further, the mask is as large as its last coordinate, which cuts regions left of or above 0 | the toolkit of VOT2014 (`lib/region.c` of trax in June 2014, as it was compiled) |
//! | `vot-toolkit` | pixels of the polygon with corners rounded to whole pixels, borders included; rectangles of `w x h` pixels | vot-toolkit 0.5 to 0.7 |
//!
//! On targets of a few pixels the three rules differ by several percent, on others in the third digit. Both
//! raster rules count whole pixels, so that regions with a narrow intersection may have overlap 0.
//!
//! If a frame is given, only the parts that lie on it count.

use super::{Rect, Region};
use serde::{Deserialize, Serialize};

/// Rule by which areas are counted.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Areas {
    /// Exact areas of the polygons.
    #[default]
    Exact,
    /// Counted in pixels, as the toolkit of VOT2014 did.
    #[serde(rename = "raster-2014")]
    Raster2014,
    /// Counted in pixels, as the later Python toolkit does.
    VotToolkit,
}

/// Pixels of a row, as a half-open range of columns.
type Span = (i64, i64);

/// Largest absolute coordinate that is rasterized. Areas of regions beyond it are exact.
const MAX_RASTER_SIDE: f64 = 1e5;

impl Areas {
    /// Overlap of a tracker's region `a` and the truth `b`, from 0 to 1. If a frame of `(width, height)` pixels is
    /// given, only the parts on it count.
    pub fn overlap(self, a: &Region, b: &Region, frame: Option<(usize, usize)>) -> f64 {
        let far = |r: &Region| r.corners().iter().any(|c| c.0.abs().max(c.1.abs()) > MAX_RASTER_SIDE);
        match self {
            Self::Exact => exact(a, b, frame),
            _ if far(a) || far(b) => exact(a, b, frame),
            Self::Raster2014 => raster_2014(a, b, frame),
            Self::VotToolkit => toolkit(a, b, frame),
        }
    }
}

fn exact(a: &Region, b: &Region, frame: Option<(usize, usize)>) -> f64 {
    if let Some((w, h)) = frame {
        let window = Region::Rect(Rect::new(0.0, 0.0, w as f64, h as f64));
        let parts = a.clipped(&window).zip(b.clipped(&window));
        return parts.map_or(0.0, |(a, b)| exact(&a, &b, None));
    }
    let inside = a.intersection(b);
    let all = a.area() + b.area() - inside;
    if all > 0.0 { (inside / all).clamp(0.0, 1.0) } else { 0.0 }
}

/// Block of pixels from `x0, y0` to `x1, y1`, both included.
#[derive(Clone, Copy)]
struct Pixels {
    x0: i64,
    y0: i64,
    x1: i64,
    y1: i64,
}

fn on_frame(all: Pixels, frame: Option<(usize, usize)>) -> Pixels {
    let Some((w, h)) = frame else { return all };
    let (x1, y1) = (all.x1.min(w as i64 - 1), all.y1.min(h as i64 - 1));
    Pixels { x0: all.x0.max(0), y0: all.y0.max(0), x1, y1 }
}

/// Number of common pixels of two rasters divided by the number of all their pixels.
fn ratio([a, b]: [Vec<Span>; 2]) -> f64 {
    let (mut inside, mut all) = (0, 0);
    for (a, b) in a.iter().zip(&b) {
        let common = (a.1.min(b.1) - a.0.max(b.0)).max(0);
        inside += common;
        all += (a.1 - a.0) + (b.1 - b.0) - common;
    }
    if all > 0 { inside as f64 / all as f64 } else { 0.0 }
}

/// Overlap by the toolkit of 2014, `a` the tracker's region. It knew no frame; on one, only the pixels that lie on it as a
/// whole count.
fn raster_2014(a: &Region, b: &Region, frame: Option<(usize, usize)>) -> f64 {
    let [mut a, mut b] = [single(a), single(b)];
    let last = |of: &[(f32, f32)]| of.iter().fold((f32::MIN, f32::MIN), |m, c| (m.0.max(c.0), m.1.max(c.1)));
    let (of_a, of_b) = (last(&a), last(&b));
    let first = a.iter().chain(&b).fold((f32::MAX, f32::MAX), |m, c| (m.0.min(c.0), m.1.min(c.1)));
    a.iter_mut().chain(&mut b).for_each(|c| *c = (c.0 - first.0, c.1 - first.1));
    // `MAX(a, b) - first` in C, where MAX is `(a > b) ? a : b` without brackets around it.
    let size = |a: f32, b: f32, first: f32| if a > b { a } else { b - first } as i64;
    let (width, height) = (size(of_a.0, of_b.0, first.0), size(of_a.1, of_b.1, first.1));
    let on_frame = |first: f32, room: Option<usize>| match room {
        Some(room) => (-first).ceil().max(0.0) as i64..(room as f32 - first).floor() as i64,
        None => 0..i64::MAX,
    };
    let (columns, rows) =
        (on_frame(first.0, frame.map(|frame| frame.0)), on_frame(first.1, frame.map(|frame| frame.1)));
    let span = |corners: &[(f32, f32)], row: i64| {
        let (from, to) = span_2014(corners, row as f32, width);
        let from = from.max(columns.start);
        (from, to.min(columns.end).max(from))
    };
    let rows = rows.start..rows.end.min(height);
    ratio([a, b].map(|corners| rows.clone().map(|row| span(&corners, row)).collect()))
}

/// Corners in single precision, in which the sides of rectangles are added to their places, too.
fn single(region: &Region) -> Vec<(f32, f32)> {
    match region {
        Region::Rect(r) => {
            let (x, y, w, h) = (r.x as f32, r.y as f32, r.w as f32, r.h as f32);
            vec![(x, y), (x + w, y), (x + w, y + h), (x, y + h)]
        }
        Region::Polygon(corners) => corners.iter().map(|c| (c.0 as f32, c.1 as f32)).collect(),
    }
}

/// Pixels of a convex polygon in row `y` of a mask of this width: from the first crossing of its sides with the scan line
/// to before the last. Crossings are truncated to integers, in single precision as in the toolkit.
fn span_2014(corners: &[(f32, f32)], y: f32, width: i64) -> Span {
    let mut span: Option<Span> = None;
    for (i, &p) in corners.iter().enumerate() {
        let q = corners[(i + corners.len() - 1) % corners.len()];
        if (p.1 < y && q.1 >= y) || (q.1 < y && p.1 >= y) {
            let x = (p.0 + (y - p.1) / (q.1 - p.1) * (q.0 - p.0)) as i64;
            span = Some(span.map_or((x, x), |s| (s.0.min(x), s.1.max(x))));
        }
    }
    match span {
        Some((from, to)) if from < width => (from, if to > width { width - 1 } else { to }),
        _ => (0, 0),
    }
}

/// Rounds halves to even, as NumPy does.
fn rounded(v: f64) -> i64 {
    v.round_ties_even() as i64
}

fn toolkit(a: &Region, b: &Region, frame: Option<(usize, usize)>) -> f64 {
    let bounds = |region: &Region| match region {
        Region::Rect(r) => {
            let (x, y) = (rounded(r.x), rounded(r.y));
            Pixels { x0: x, y0: y, x1: x + rounded(r.w) - 1, y1: y + rounded(r.h) - 1 }
        }
        Region::Polygon(corners) => {
            let (x, y) = (|c: &(f64, f64)| rounded(c.0), |c: &(f64, f64)| rounded(c.1));
            Pixels {
                x0: corners.iter().map(x).min().unwrap_or(0),
                y0: corners.iter().map(y).min().unwrap_or(0),
                x1: corners.iter().map(x).max().unwrap_or(0),
                y1: corners.iter().map(y).max().unwrap_or(0),
            }
        }
    };
    let (of_a, of_b) = (bounds(a), bounds(b));
    let all = Pixels {
        x0: of_a.x0.min(of_b.x0),
        y0: of_a.y0.min(of_b.y0),
        x1: of_a.x1.max(of_b.x1),
        y1: of_a.y1.max(of_b.y1),
    };
    // Regions of a single row or column are the same to the toolkit, whatever they are.
    if all.x0 >= all.x1 || all.y0 >= all.y1 {
        return 1.0;
    }
    let window = on_frame(all, frame);
    if window.x0 >= window.x1 || window.y0 >= window.y1 {
        return 0.0;
    }
    let rows = |region: &Region, of: Pixels| match region {
        Region::Rect(_) => (window.y0..=window.y1)
            .map(|row| {
                let from = of.x0.max(window.x0);
                let to = if (of.y0..=of.y1).contains(&row) { of.x1.min(window.x1) + 1 } else { from };
                (from, to.max(from))
            })
            .collect(),
        Region::Polygon(corners) => rows_toolkit(corners, window),
    };
    ratio([rows(a, of_a), rows(b, of_b)])
}

/// Pixels of a convex polygon, one range per row of `window`. Includes the border, rounded to pixels.
fn rows_toolkit(corners: &[(f64, f64)], window: Pixels) -> Vec<Span> {
    let place = |c: &(f64, f64)| ((rounded(c.0) - window.x0) as f64, (rounded(c.1) - window.y0) as f64);
    let corners: Vec<(f64, f64)> = corners.iter().map(place).collect();
    let last = window.x1 - window.x0;
    let mut rows = Vec::new();
    for row in 0..=(window.y1 - window.y0) {
        let y = row as f64;
        let mut span: Option<Span> = None;
        for (i, &p) in corners.iter().enumerate() {
            let q = corners[(i + corners.len() - 1) % corners.len()];
            if p.1.min(q.1) <= y && y <= p.1.max(q.1) {
                let rise = q.1 - p.1;
                // Cut towards 0, which is the window's border.
                let x = if rise == 0.0 { p.0 } else { p.0 + (y - p.1) / rise * (q.0 - p.0) } as i64;
                span = Some(span.map_or((x, x), |s| (s.0.min(x), s.1.max(x))));
            }
        }
        rows.push(match span {
            Some((from, to)) if from <= last && to >= 0 => {
                (window.x0 + from.max(0), window.x0 + to.min(last) + 1)
            }
            _ => (0, 0),
        });
    }
    rows
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn rect(x: f64, y: f64, w: f64, h: f64) -> Region {
        Region::Rect(Rect::new(x, y, w, h))
    }

    const RULES: [Areas; 3] = [Areas::Exact, Areas::Raster2014, Areas::VotToolkit];

    // Whole pixels, so that all rules agree: 10x10 boxes, 5 columns shared, 50 of 150.
    #[test]
    fn whole_boxes_have_one_overlap() {
        for rule in RULES {
            let overlap =
                |x, frame| rule.overlap(&rect(3.0, 2.0, 10.0, 10.0), &rect(3.0 + x, 2.0, 10.0, 10.0), frame);
            assert_eq!(overlap(0.0, None), 1.0);
            assert_eq!(overlap(5.0, None), 50.0 / 150.0, "{rule:?}");
            assert_eq!(overlap(10.0, None), 0.0);
            // The frame ends at column 10: 7 columns of one, 2 of the other.
            assert_eq!(overlap(5.0, Some((10, 40))), 20.0 / 70.0, "{rule:?}");
            assert_eq!(overlap(5.0, Some((3, 40))), 0.0);
        }
    }

    // python3 with vot-toolkit 0.7.4: from vot.region.shapes import Polygon, Rectangle
    //   from vot.region.raster import calculate_overlap
    //   calculate_overlap(A, B), calculate_overlap(A, B, (40, 30))
    #[test]
    fn agrees_with_the_python_toolkit() {
        for (a, b, free, bounded) in TOOLKIT {
            let (a, b) = (Region::from_numbers(a).unwrap(), Region::from_numbers(b).unwrap());
            let ours = [None, Some((40, 30))].map(|frame| Areas::VotToolkit.overlap(&a, &b, frame));
            // Without a frame the toolkit cuts rectangles at the wrong column where one begins left of 0.
            let inside = [&a, &b].iter().all(|r| r.corners().iter().all(|c| c.0 >= 0.0 && c.1 >= 0.0));
            assert!(!inside || (ours[0] - free).abs() < 1e-12, "{a:?} {b:?}: {ours:?} {free}");
            assert!((ours[1] - bounded).abs() < 1e-12, "{a:?} {b:?}: {ours:?} {bounded}");
        }
    }
    include!("overlap/toolkit.rs");

    // Worked by hand: of the triangle (0,0) (4,0) (0,4) the scan lines of rows 1 to 4 cross x = 0 and
    // 4 - y, so that the rows have 3, 2, 1 and 0 pixels; the square from (0,1) has 4 rows of 4 from row 2 on, of
    // which row 5 is the last of both and falls away.
    #[test]
    fn scan_lines_of_2014_worked_by_hand() {
        let triangle = Region::Polygon(vec![(0.0, 0.0), (4.0, 0.0), (0.0, 4.0)]);
        let square = rect(0.0, 1.0, 4.0, 4.0);
        let overlap = Areas::Raster2014.overlap(&triangle, &square, None);
        assert_eq!(overlap, 3.0 / (6.0 + 12.0 - 3.0));
    }

    // C: region_compute_overlap of lib/region.c, trax at 6d9298c (June 2014)
    #[test]
    fn agrees_with_the_toolkit_of_2014() {
        for (a, b, want) in TOOLKIT_2014 {
            let [one, other] = [a, b].map(|numbers| Region::from_numbers(numbers).unwrap());
            let overlap = Areas::Raster2014.overlap(&one, &other, None);
            assert!((overlap - want).abs() < 1e-7, "{a:?} {b:?}: {overlap} {want}");
        }
    }

    fn boxes() -> impl Strategy<Value = Region> {
        (-20.0..60.0, -20.0..60.0, 6.0..40.0, 6.0..40.0, -1.6..1.6_f64).prop_map(
            |(x, y, w, h, angle): (f64, f64, f64, f64, f64)| {
                let (sin, cos) = angle.sin_cos();
                let turned = |u: f64, v: f64| (x + cos * u - sin * v, y + sin * u + cos * v);
                Region::Polygon(vec![turned(0.0, 0.0), turned(w, 0.0), turned(w, h), turned(0.0, h)])
            },
        )
    }

    proptest! {
        #[test]
        fn rules_are_symmetric_bounded_and_alike(a in boxes(), b in boxes()) {
            let exact = Areas::Exact.overlap(&a, &b, None);
            for rule in RULES {
                for frame in [None, Some((50, 40))] {
                    let o = rule.overlap(&a, &b, frame);
                    prop_assert!((0.0..=1.0).contains(&o));
                    // In 2014 the mask was of another size for the other order.
                    let is_even = rule != Areas::Raster2014;
                    prop_assert!(!is_even || (o - rule.overlap(&b, &a, frame)).abs() < 1e-12);
                }
                // Right of and below 0, borders of 6 to 40 pixels long sides hold at most so much of the area.
                let (a, b) = (a.shifted(100.0, 100.0), b.shifted(100.0, 100.0));
                prop_assert!((rule.overlap(&a, &b, None) - exact).abs() < 0.35, "{:?}", rule);
                prop_assert!((rule.overlap(&a, &a, None) - 1.0).abs() < 1e-9);
            }
        }
    }
}
