//! Radar charts: a spoke for each quantity, and a polygon with a corner on each spoke for each series.

use super::font;
use super::legend::Marker;
use super::page::{Area, LINE, Page, Point, share_before};
use super::style::{Color, INK, SMALL, Style};
use plotters::style::text_anchor::HPos;
use std::f64::consts::TAU;

/// A radar chart.
#[derive(Debug, Clone, PartialEq)]
pub struct Radar {
    /// Name of each spoke, and the second line of its label. The first spoke points up, the others follow
    /// clockwise.
    pub spokes: Vec<[String; 2]>,
    /// Polygons, the first one in front.
    pub polygons: Vec<Polygon>,
}

/// A polygon of a radar chart.
#[derive(Debug, Clone, PartialEq)]
pub struct Polygon {
    /// Corners, one per spoke: 0 is the center, 1 the end of the spoke. `None` omits both sides that meet
    /// there.
    pub corners: Vec<Option<f64>>,
    /// Line of the polygon.
    pub style: Style,
    /// Marker at the corners.
    pub marker: Marker,
}

/// Room for labels on each side, in units.
const ROOM: f64 = 82.0;
/// Distance from the end of a spoke to its label, and least distance between two labels, in units.
const APART: (f64, f64) = (10.0, 0.01);
/// Rings, as shares of a spoke; `WEB` is the line of spokes and rings.
const RINGS: [f64; 4] = [0.25, 0.5, 0.75, 1.0];
const WEB: Style = Style::solid(Color([0xDD; 3]), 0.7);

struct Label {
    lines: Vec<String>,
    anchor: HPos,
    area: Area,
}

/// Center, radius and labels, relative to the upper left corner of the chart.
struct Layout {
    center: Point,
    radius: f64,
    height: f64,
    labels: Vec<Label>,
}

impl Radar {
    /// Height of the chart at a width, in units.
    pub(super) fn height(&self, width: f64) -> f64 {
        self.layout(width).height
    }

    /// Draws the chart in an area, from the upper left corner on.
    pub(super) fn draw(&self, page: &mut Page, area: &Area) {
        let Layout { center, radius, labels, .. } = self.layout(area.w);
        let count = self.spokes.len();
        let place = |k: usize, share: f64| {
            let (x, y) = self.direction(k);
            (area.x + center.0 + share * radius * x, area.y + center.1 + share * radius * y)
        };
        for ring in RINGS {
            page.line((0..=count).map(|k| place(k, ring)).collect(), WEB);
        }
        for k in 0..count {
            page.line(vec![place(k, 0.0), place(k, 1.0)], WEB);
        }
        for Polygon { corners, style, marker } in self.polygons.iter().rev() {
            let corner = |(k, share): (usize, &Option<f64>)| share.map(|share| place(k, share));
            let corners: Vec<Option<Point>> = corners.iter().enumerate().map(corner).collect();
            let around: Vec<Option<Point>> = corners.iter().chain(corners.first()).copied().collect();
            for sides in around.split(Option::is_none).filter(|sides| sides.len() > 1) {
                page.line(sides.iter().flatten().copied().collect(), *style);
            }
            for at in corners.into_iter().flatten() {
                marker.draw(page, at, style.color);
            }
        }
        for Label { lines, anchor, area: label } in labels {
            let at = (area.x + label.x + label.w * share_before(anchor), area.y + label.y);
            page.lines(&lines, at, SMALL, anchor, INK);
        }
    }

    fn direction(&self, spoke: usize) -> Point {
        let angle = TAU * spoke as f64 / self.spokes.len() as f64;
        (angle.sin(), -angle.cos())
    }

    fn layout(&self, width: f64) -> Layout {
        let radius = width / 2.0 - ROOM - APART.0;
        let mut labels: Vec<Label> = (0..self.spokes.len()).map(|k| self.label(k, radius, width)).collect();
        // From the middle upwards and downwards, each label gives way to those before it.
        let height = |k: usize| self.direction(k).1;
        let mut order: Vec<usize> = (0..labels.len()).collect();
        order.sort_by(|a, b| height(*a).abs().total_cmp(&height(*b).abs()));
        let mut placed: Vec<Area> = Vec::new();
        for k in order {
            let mut area = labels[k].area;
            while let Some(other) = placed.iter().find(|other| !other.is_apart(&area)) {
                area.y = match height(k) < 0.0 {
                    true => other.y - area.h - APART.1,
                    false => other.bottom() + APART.1,
                };
            }
            placed.push(area);
            labels[k].area = area;
        }
        let top = placed.iter().map(|area| area.y).fold(-radius, f64::min);
        let bottom = placed.iter().map(Area::bottom).fold(radius, f64::max);
        let center = (width / 2.0, -top);
        for label in &mut labels {
            label.area.x += center.0;
            label.area.y += center.1;
        }
        Layout { center, radius, height: bottom - top, labels }
    }

    /// Label at the end of a spoke; its area is relative to the center of the chart.
    fn label(&self, spoke: usize, radius: f64, width: f64) -> Label {
        let (x, y) = self.direction(spoke);
        let (left, height) = ((radius + APART.0) * x, (radius + APART.0) * y);
        let (anchor, room) = match left {
            left if left > 1.0 => (HPos::Left, width / 2.0 - left),
            left if left < -1.0 => (HPos::Right, width / 2.0 + left),
            _ => (HPos::Center, width),
        };
        let lines: Vec<String> =
            self.spokes[spoke].iter().flat_map(|part| font::wrap(part, SMALL, room)).collect();
        let (w, h) = (font::widest(&lines, SMALL), LINE * lines.len() as f64);
        let area = Area { x: left - w * share_before(anchor), y: height + (y - 1.0) * h / 2.0, w, h };
        Label { lines, anchor, area }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::figure::Dash;
    use crate::figure::page::Shape;
    use trackfail_testing::assert_near;

    fn radar(spokes: &[&str], corners: Vec<Option<f64>>) -> Radar {
        let style = Style::new(Color::VERMILION, Dash::SOLID);
        let spokes = spokes.iter().map(|name| [name.to_string(), "0.1–0.9".to_string()]).collect();
        Radar { spokes, polygons: vec![Polygon { corners, style, marker: Marker::Square }] }
    }

    /// Lines of the polygon, and the number of its markers.
    fn drawn(corners: Vec<Option<f64>>) -> (Vec<Vec<Point>>, usize) {
        let mut page = Page::new("", 320.0);
        let radar = radar(&["a", "b", "c", "d"], corners);
        let area = Area { x: 10.0, y: 20.0, w: 300.0, h: radar.height(300.0) };
        // The spokes and, above and below them, the distance to a label and its two lines.
        assert!((area.h - 2.0 * (58.0 + 10.0 + 28.0)).abs() < 1e-9);
        radar.draw(&mut page, &area);
        let line = |shape: &Shape| match shape {
            Shape::Line { points, style } if style.color == Color::VERMILION => Some(points.clone()),
            _ => None,
        };
        let is_mark = |shape: &&Shape| matches!(shape, Shape::Fill { color: Color::VERMILION, .. });
        (page.shapes.iter().filter_map(line).collect(), page.shapes.iter().filter(is_mark).count())
    }

    // By hand: of half the width, 150, the labels take 92, so that a spoke has 58; the middle is at (10 + 150, 20 + 96).
    #[test]
    fn polygons_by_hand() {
        let [top, right, left] = [(160.0, 58.0), (189.0, 116.0), (131.0, 116.0)];
        let closed = vec![top, right, (160.0, 130.5), (160.0, 116.0), top];
        for (corners, lines, marks) in [
            ([Some(1.0), Some(0.5), Some(0.25), Some(0.0)], vec![closed], 4),
            // A spoke without a value breaks the polygon.
            ([Some(1.0), Some(0.5), None, Some(0.5)], vec![vec![top, right], vec![left, top]], 3),
            // The only corner between two without one has no side, and is a mark.
            ([None, Some(0.5), None, Some(0.5)], vec![], 2),
        ] {
            let (found, count) = drawn(corners.into());
            let flat = |lines: &[Vec<Point>]| {
                lines.concat().into_iter().flat_map(|p| [p.0, p.1]).collect::<Vec<_>>()
            };
            assert_eq!(
                (found.iter().map(Vec::len).collect::<Vec<_>>(), count),
                (lines.iter().map(Vec::len).collect(), marks)
            );
            assert_near(flat(&found), flat(&lines), 1e-9, "corners");
        }
    }

    #[test]
    fn labels_stand_apart_and_within_the_width() {
        for count in [3, 7, 15, 24] {
            let radar = radar(&vec!["Out of plane rotation (9)"; count], Vec::new());
            for width in [300.0, 470.0] {
                let Layout { labels, height, .. } = radar.layout(width);
                for (k, Label { area, .. }) in labels.iter().enumerate() {
                    assert!(labels[..k].iter().all(|other| other.area.is_apart(area)), "{count} {width} {k}");
                    assert!(area.x >= -1e-3 && area.right() <= width + 1e-3);
                    assert!(area.y >= -1e-9 && area.bottom() <= height + 1e-9);
                }
            }
        }
    }
}
