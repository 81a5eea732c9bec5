//! Panels of a figure, and the marks in them.

use super::axis::{Axis, Ends, Place, Scale, linear_ticks, thinned};
use super::diagram;
use super::font;
use super::legend::{Entry, Marker};
use super::page::{Area, Page, Point};
use super::radar::Radar;
use super::style::{Color, Dash, INK, SHADE, SMALL, SOFT, Style};
use plotters::style::text_anchor::HPos;
use std::ops::Range;

/// An element of a panel, in values of its axes.
#[derive(Debug, Clone, PartialEq)]
pub enum Mark {
    /// A polyline. A NaN leaves a gap; a point between two gaps is drawn as a dot.
    Line {
        /// Points in drawing order.
        points: Vec<(f64, f64)>,
        /// Color and line style.
        style: Style,
        /// Marker at each point.
        marker: Option<Marker>,
    },
    /// Area between two bounds: place, lower and upper bound of each point. A NaN leaves a gap.
    Band(Vec<(f64, f64, f64)>, Color),
    /// A shaded range of the horizontal axis.
    Shade(Range<f64>),
    /// An upright line at a place of the horizontal axis.
    Upright(f64, Style),
    /// A level line at a place of the vertical axis.
    Level(f64, Style),
    /// A single point.
    Point((f64, f64), Marker, Color),
    /// A marker at the upper edge of the panel.
    Top(f64, Marker, Color),
    /// A text beside a point.
    Name((f64, f64), String),
    /// Lines of equal F, in panels of precision over recall.
    IsoF,
    /// A named box of a diagram.
    Node((f64, f64), String),
    /// An arrow between two named boxes, or a loop from a box to itself.
    Arrow {
        /// Center and name of the box at which the arrow starts.
        from: ((f64, f64), String),
        /// Center and name of the box at which the arrow ends.
        to: ((f64, f64), String),
        /// Lines of the label.
        label: Vec<String>,
        /// True if there is an arrow in the other direction, too.
        is_pair: bool,
    },
    /// A radar chart, which fills the panel.
    Radar(Radar),
}

/// A panel: axes, and marks in their values.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Panel {
    /// Heading of the panel; may be empty.
    pub title: String,
    /// Horizontal axis.
    pub x: Axis,
    /// Vertical axis.
    pub y: Axis,
    /// Marks in drawing order, from the back to the front.
    pub marks: Vec<Mark>,
    /// Legend above the panel; empty if the panel needs none of its own.
    pub legend: Vec<Entry>,
}

impl Mark {
    /// A line without markers.
    pub fn line(points: Vec<(f64, f64)>, style: Style) -> Self {
        Self::Line { points, style, marker: None }
    }

    /// Points that the axes must include. A coordinate is NaN if only the other one matters.
    fn places(&self) -> Vec<(f64, f64)> {
        let none = f64::NAN;
        match self {
            Self::Line { points, .. } => points.clone(),
            Self::Band(points, _) => points.iter().flat_map(|p| [(none, p.1), (none, p.2)]).collect(),
            Self::Upright(x, _) | Self::Top(x, ..) => vec![(*x, none)],
            Self::Level(y, _) => vec![(none, *y)],
            Self::Point(at, ..) => vec![*at],
            Self::Shade(_) | Self::Name(..) | Self::IsoF => Vec::new(),
            Self::Node(..) | Self::Arrow { .. } | Self::Radar(_) => Vec::new(),
        }
    }
}

/// Height of the band of markers at the upper edge, in units.
const TOP: f64 = 8.0;
/// Style of the lines of equal F; `MAX_ISO` is the most of them.
const ISO: Style = Style { color: Color([0xDC; 3]), dash: Dash::DASHED, width: 0.8 };
const MAX_ISO: usize = 5;

impl Panel {
    fn shows(&self, p: &(f64, f64)) -> bool {
        self.x.shows(p.0) && self.y.shows(p.1)
    }

    /// True if the panel has a visible line or point.
    pub(super) fn has_point(&self) -> bool {
        self.marks.iter().any(|mark| match mark {
            Mark::Line { points, .. } => points.iter().any(|p| self.shows(p)),
            Mark::Point(at, ..) => self.shows(at),
            _ => false,
        })
    }

    /// Values that both axes must include. A coordinate is NaN if only the other one matters.
    pub(super) fn values(&self) -> Vec<(f64, f64)> {
        // Half a point is drawn nowhere, but bounds and levels are.
        let said = |p: &(f64, f64)| self.shows(p) || p.0.is_nan() != p.1.is_nan();
        self.marks.iter().flat_map(Mark::places).filter(said).collect()
    }

    /// Scales of the axes in an area.
    pub(super) fn place(&self, area: Area, ends: &(Ends, Ends)) -> Place {
        let has_top = self.marks.iter().any(|m| matches!(m, Mark::Top(..)));
        let top = area.y + if has_top { TOP } else { 0.0 };
        let x = Scale::new(&self.x, ends.0, (area.x, area.right()));
        Place { area, x, y: Scale::new(&self.y, ends.1, (area.bottom(), top)) }
    }

    /// Draws the marks. The frame is drawn elsewhere.
    pub(super) fn draw(&self, page: &mut Page, place: &Place) {
        let area = &place.area;
        let sign = |page: &mut Page, at: Point, marker: Marker, color: Color| {
            if area.contains(at) {
                marker.draw(page, at, color);
            }
        };
        for mark in &self.marks {
            match mark {
                Mark::Line { points, style, marker } => self.line(page, place, points, style, *marker),
                Mark::Band(points, color) => self.band(page, place, points, *color),
                Mark::Shade(range) => {
                    let ends = [range.start, range.end].map(|x| place.x.place(x).clamp(area.x, area.right()));
                    let shade = Area { x: ends[0], w: (ends[1] - ends[0]).max(0.5), ..*area };
                    page.fill(shade.corners(), SHADE);
                }
                Mark::Upright(at, style) if self.x.shows(*at) => {
                    let x = place.x.place(*at);
                    page.clipped(&[(x, area.y), (x, area.bottom())], area, *style);
                }
                Mark::Level(at, style) if self.y.shows(*at) => {
                    let y = place.y.place(*at);
                    page.clipped(&[(area.x, y), (area.right(), y)], area, *style);
                }
                Mark::Point(at, marker, color) if self.shows(at) => {
                    sign(page, place.of(*at), *marker, *color);
                }
                Mark::Top(at, marker, color) if self.x.shows(*at) => {
                    sign(page, (place.x.place(*at), area.y + TOP - 1.0), *marker, *color);
                }
                Mark::IsoF => iso_f(page, place),
                Mark::Node(at, name) => diagram::node(page, place.of(*at), name),
                Mark::Arrow { from, to, label, is_pair } => {
                    let ends = [from, to].map(|(at, name)| (place.of(*at), name.as_str()));
                    diagram::arrow(page, area, ends, label, *is_pair);
                }
                Mark::Radar(radar) => radar.draw(page, area),
                Mark::Upright(..) | Mark::Level(..) | Mark::Point(..) | Mark::Top(..) | Mark::Name(..) => {}
            }
        }
        let is_line = |m: &Mark| matches!(m, Mark::Line { .. });
        if self.marks.iter().any(is_line) && !self.has_point() {
            page.text("no values", area.middle(), SMALL, HPos::Center, SOFT);
        }
        self.names(page, place);
    }

    fn line(
        &self,
        page: &mut Page,
        place: &Place,
        points: &[(f64, f64)],
        style: &Style,
        marker: Option<Marker>,
    ) {
        for run in points.split(|p| !self.shows(p)).filter(|run| !run.is_empty()) {
            let places: Vec<Point> = run.iter().map(|p| place.of(*p)).collect();
            page.clipped(&thinned(&places), &place.area, *style);
            for &at in places.iter().filter(|p| place.area.contains(**p)) {
                match marker {
                    Some(marker) => marker.draw(page, at, style.color),
                    None if run.len() == 1 => page.disc(at, style.width, style.color),
                    None => {}
                }
            }
        }
    }

    /// Draws the band between two bounds, clipped at the panel's upper and lower edge.
    fn band(&self, page: &mut Page, place: &Place, points: &[(f64, f64, f64)], color: Color) {
        // From left to right, although a curve in the order of what is along y may turn back.
        let mut points = points.to_vec();
        points.sort_by(|a, b| a.0.total_cmp(&b.0));
        let known = |p: &(f64, f64, f64)| self.shows(&(p.0, p.1)) && self.y.shows(p.2);
        let at = |x: f64, y: f64| {
            let (x, y) = place.of((x, y));
            (x.clamp(place.area.x, place.area.right()), y.clamp(place.area.y, place.area.bottom()))
        };
        for run in points.split(|p| !known(p)).filter(|run| run.len() > 1) {
            let upper = run.iter().map(|p| at(p.0, p.2));
            page.band(upper.chain(run.iter().rev().map(|p| at(p.0, p.1))).collect(), color);
        }
    }

    /// Draws names beside points. Each is placed at the first of several sides that is free, and always
    /// inside the page.
    fn names(&self, page: &mut Page, place: &Place) {
        let name = |mark: &Mark| match mark {
            Mark::Name(at, name) if self.shows(at) => Some((place.of(*at), font::clean(name))),
            _ => None,
        };
        let named: Vec<(Point, String)> = self.marks.iter().filter_map(name).collect();
        let point = |&((x, y), _): &(Point, String)| Area { x: x - 4.0, y: y - 4.0, w: 8.0, h: 8.0 };
        let mut taken: Vec<Area> = named.iter().map(point).collect();
        for ((x, y), name) in &named {
            let lines = font::wrap(name, SMALL, page.width / 2.0);
            let (w, h) = (font::widest(&lines, SMALL), 12.0 * lines.len() as f64);
            // Beside bars through the point, not on them, as long as there is room.
            let places = [
                (5.0, -h - 1.0),
                (-5.0 - w, -h - 1.0),
                (5.0, 1.0),
                (-5.0 - w, 1.0),
                (6.0, -h / 2.0),
                (-6.0 - w, -h / 2.0),
                (-w / 2.0, -h - 5.0),
                (-w / 2.0, 6.0),
                (5.0, -2.0 * h - 1.0),
                (-5.0 - w, -2.0 * h - 1.0),
                (5.0, h + 1.0),
                (-5.0 - w, h + 1.0),
            ];
            let room = places.map(|(dx, dy)| Area { x: x + dx, y: y + dy, w, h });
            let fits = |a: &&Area| {
                let within = a.x >= place.area.x && a.right() <= place.area.right() + 4.0;
                within && a.bottom() <= place.area.bottom() && taken.iter().all(|t| a.is_apart(t))
            };
            let mut room = *room.iter().find(fits).unwrap_or(&room[0]);
            room.x = room.x.min(page.width - w - 1.0).max(1.0);
            for (k, line) in lines.iter().enumerate() {
                page.text(line, (room.x, room.y + 6.0 + 12.0 * k as f64), SMALL, HPos::Left, INK);
            }
            taken.push(room);
        }
    }
}

/// Draws lines of equal F = 2 P R / (P + R), P precision, R recall: P = F R / (2 R - F). Each line is labeled
/// at its end.
fn iso_f(page: &mut Page, place: &Place) {
    let (recall, precision) = (place.x.ends.1.min(1.0), place.y.ends.1.min(1.0));
    if recall <= 0.0 || precision <= 0.0 {
        return;
    }
    let highest = 2.0 * recall * precision / (recall + precision);
    for (f, name) in
        linear_ticks(0.0, highest, MAX_ISO).into_iter().filter(|t| t.0 > 0.0 && t.0 < highest * 0.97)
    {
        // From the recall at which it meets the panel's upper edge.
        let first = f * precision / (2.0 * precision - f);
        let at = |k: usize| {
            let r = first + (recall - first) * (k as f64 / 100.0).powi(2);
            (r, if k == 0 { precision } else { f * r / (2.0 * r - f) })
        };
        let line: Vec<Point> = (0..=100).map(|k| place.of(at(k))).collect();
        page.clipped(&line, &place.area, ISO);
        let end = line[line.len() - 1];
        if place.area.contains(end) {
            let name = format!("F {}", name.trim_start_matches('0'));
            let w = font::width(&name, SMALL) + 4.0;
            page.fill(Area { x: end.0 - w, y: end.1 - 6.0, w, h: 12.0 }.corners(), Color([255; 3]));
            page.text(&name, (end.0 - 2.0, end.1), SMALL, HPos::Right, SOFT);
        }
    }
}
