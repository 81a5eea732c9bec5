//! Markers at points, and legends: symbols with names, laid out in rows.

use super::font;
use super::page::{Area, LINE, Page, Point};
use super::style::{Color, INK, SHADE, SMALL, Style};
use plotters::style::text_anchor::HPos;

/// Distance between two rows, in units.
const APART: f64 = 2.0;
/// Width of a symbol, in units.
const SYMBOL: f64 = 22.0;
/// Width of a box's line on a still, and of the dark line under it, in units.
pub const BOX: f64 = 1.7;
pub const AROUND_BOX: f64 = 3.2;
/// Distance between symbol and name, and between entries, in units.
const GAPS: (f64, f64) = (5.0, 14.0);

/// Shape that marks a point.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Marker {
    /// A disk.
    Circle,
    /// An upright square.
    Square,
    /// A triangle that points up.
    Triangle,
    /// A square standing on a corner.
    Diamond,
    /// A ring: the operating point of a method.
    Operating,
    /// A hollow diamond: a value that a paper prints.
    Published,
    /// A triangle that points down to the point: an alarm begins.
    AlarmBegins,
    /// A hollow triangle that points down: an alarm ends.
    AlarmEnds,
}

impl Marker {
    /// Marker of the `i`-th of several series. Markers repeat after four.
    pub fn nth(i: usize) -> Self {
        [Self::Circle, Self::Square, Self::Triangle, Self::Diamond][i % 4]
    }

    pub(super) fn draw(self, page: &mut Page, at: Point, color: Color) {
        let white = Color([255; 3]);
        let around = |corners: &[Point]| corners.iter().map(|c| (at.0 + c.0, at.1 + c.1)).collect::<Vec<_>>();
        let diamond = |r: f64| around(&[(0.0, -r), (r, 0.0), (0.0, r), (-r, 0.0)]);
        let down = |half: f64, top: f64, tip: f64| around(&[(-half, top), (half, top), (0.0, tip)]);
        match self {
            Self::Circle => page.disc(at, 3.0, color),
            Self::Square => page.fill(Area::around(at, 2.75, 2.75).corners(), color),
            Self::Triangle => page.fill(around(&[(0.0, -3.75), (3.5, 2.5), (-3.5, 2.5)]), color),
            Self::Diamond => page.fill(diamond(4.0), color),
            Self::Operating => {
                let angles = (0..=24).map(|k| f64::from(k) / 24.0 * std::f64::consts::TAU);
                let ring: Vec<Point> = angles.map(|a| (6.0 * a.cos(), 6.0 * a.sin())).collect();
                page.line(around(&ring), Style::solid(white, 3.4));
                page.line(around(&ring), Style::solid(color, 1.8));
            }
            Self::Published => {
                for (r, color) in [(8.0, white), (6.5, color), (3.6, white)] {
                    page.fill(diamond(r), color);
                }
            }
            Self::AlarmBegins => page.fill(down(3.2, -5.5, 0.0), color),
            Self::AlarmEnds => {
                page.fill(down(3.2, -5.5, 0.0), color);
                page.fill(down(1.46, -4.5, -2.0), white);
            }
        }
    }
}

/// Symbol before a name in a legend.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Symbol {
    /// A line, with or without a marker.
    Line(Style, Option<Marker>),
    /// A marker alone.
    Mark(Color, Marker),
    /// A shaded area.
    Shade,
    /// A band around a line.
    Band(Color),
    /// An upright line.
    Upright(Style),
    /// Outline of a box on a still.
    Outline(Style),
}

/// An entry of a legend: symbol and name.
#[derive(Debug, Clone, PartialEq)]
pub struct Entry {
    /// Symbol shown before the name.
    pub symbol: Symbol,
    /// Text shown beside the symbol.
    pub name: String,
}

impl Entry {
    /// Creates an entry.
    pub fn new(symbol: Symbol, name: impl Into<String>) -> Self {
        Self { symbol, name: name.into() }
    }
}

/// Row of a legend: symbol, lines of the name, and width of each entry.
type Row = Vec<(Symbol, Vec<String>, f64)>;

/// A legend broken into rows for a given width.
#[derive(Default)]
pub struct Legend {
    pub rows: Vec<Row>,
}

impl Legend {
    /// Arranges entries in rows of at most `room`. Each entry has a row of its own if that needs at most
    /// `height`.
    pub fn new(entries: &[Entry], room: f64, height: f64) -> Self {
        let most = if entries.len() as f64 * (LINE + APART) <= height { 1 } else { entries.len() };
        let mut legend = Self::default();
        let mut used = f64::INFINITY;
        for entry in entries {
            let name = font::wrap(&entry.name, SMALL, room - SYMBOL - GAPS.0);
            let width = SYMBOL + GAPS.0 + font::widest(&name, SMALL);
            let is_full = legend.rows.last().is_some_and(|row| row.len() >= most);
            if is_full || used + GAPS.1 + width > room {
                legend.rows.push(Vec::new());
                used = -GAPS.1;
            }
            used += GAPS.1 + width;
            if let Some(row) = legend.rows.last_mut() {
                row.push((entry.symbol, name, width));
            }
        }
        legend
    }

    fn heights(&self) -> impl Iterator<Item = f64> {
        let lines = |row: &Row| row.iter().map(|e| e.1.len()).max().unwrap_or(0);
        self.rows.iter().map(move |row| LINE * lines(row).max(1) as f64 + APART)
    }

    pub fn height(&self) -> f64 {
        self.heights().sum()
    }

    /// Width of the widest row.
    pub fn width(&self) -> f64 {
        let row = |r: &Row| r.iter().map(|e| e.2 + GAPS.1).sum::<f64>() - GAPS.1;
        self.rows.iter().map(row).fold(0.0, f64::max)
    }

    /// Draws the rows from `(x, y)` downwards.
    pub fn draw(&self, page: &mut Page, (x, mut y): Point) {
        for (row, height) in self.rows.iter().zip(self.heights()) {
            let mut x = x;
            for (symbol, name, width) in row {
                symbol.draw(page, (x, y + (LINE + APART) / 2.0));
                page.lines(name, (x + SYMBOL + GAPS.0, y + APART / 2.0), SMALL, HPos::Left, INK);
                x += width + GAPS.1;
            }
            y += height;
        }
    }
}

impl Symbol {
    /// Draws the symbol to the right of a point, centered at the point's height.
    fn draw(self, page: &mut Page, (x, y): Point) {
        let at = (x + SYMBOL / 2.0, y);
        let area = |in_by: f64, half: f64| Area::around(at, SYMBOL / 2.0 - in_by, half);
        match self {
            Self::Line(style, marker) => {
                page.line(vec![(x, y), (x + SYMBOL, y)], Style { width: style.width.max(1.4), ..style });
                marker.into_iter().for_each(|marker| marker.draw(page, at, style.color));
            }
            Self::Mark(color, marker) => {
                let is_alarm = matches!(marker, Marker::AlarmBegins | Marker::AlarmEnds);
                marker.draw(page, (at.0, if is_alarm { y + 3.0 } else { y }), color);
            }
            Self::Band(color) => page.band(area(2.0, 5.0).corners(), color),
            Self::Shade => page.fill(area(3.0, 5.0).corners(), SHADE),
            Self::Upright(style) => page.line(vec![(at.0, y - 6.0), (at.0, y + 6.0)], style),
            Self::Outline(style) => {
                let area = area(2.0, 5.5);
                page.outline(area.corners(), &area, style, AROUND_BOX);
            }
        }
    }
}
