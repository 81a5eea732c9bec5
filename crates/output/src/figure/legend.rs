//! Legends: symbols with names, laid out in rows.

use super::font;
use super::scene::{Anchor, Area, Item, Point, Scene, Stroke};
use super::sign::{Sign, draw_sign};
use super::style::Edge;
use super::style::{CASING, Color, Dash, INK, SMALL, Style};

/// Height of one row, in units.
pub const ROW: f64 = 16.0;
/// Width of a symbol, in units.
const SYMBOL: f64 = 22.0;
/// Between symbol and name, and between entries, in units.
const GAPS: (f64, f64) = (5.0, 14.0);

/// The shape of a marker.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Marker {
    /// A disk.
    Circle,
    /// A square on its side.
    Square,
    /// A triangle, its tip up.
    Triangle,
    /// A square on its corner.
    Diamond,
}

impl Marker {
    /// The marker of the `i`-th of several series; they repeat after four.
    pub fn nth(i: usize) -> Self {
        [Self::Circle, Self::Square, Self::Triangle, Self::Diamond][i % 4]
    }

    pub(super) fn draw(self, scene: &mut Scene, (x, y): Point, rgb: [u8; 3]) {
        let item = match self {
            Self::Circle => Item::Circle { center: (x, y), radius: 3.0, rgb },
            Self::Square => Item::Rect { area: Area { x: x - 2.75, y: y - 2.75, w: 5.5, h: 5.5 }, rgb },
            Self::Triangle => {
                Item::Polygon { corners: vec![(x, y - 3.75), (x + 3.5, y + 2.5), (x - 3.5, y + 2.5)], rgb }
            }
            Self::Diamond => {
                let corners = vec![(x, y - 4.0), (x + 4.0, y), (x, y + 4.0), (x - 4.0, y)];
                Item::Polygon { corners, rgb }
            }
        };
        scene.items.push(item);
    }
}

/// The symbol before a name.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Symbol {
    /// A line, perhaps with a mark.
    Line(Style, Option<Marker>),
    /// A mark alone.
    Mark(Color, Marker),
    /// A filled area.
    Patch([u8; 3]),
    /// A band around a line.
    Band(Color),
    /// An upright line.
    Upright(Style),
    /// The triangle of an alarm.
    Alarm(Color, Edge),
    /// The line around a box.
    Outline {
        /// Its color.
        rgb: [u8; 3],
        /// Its line style.
        dash: Dash,
    },
    /// The sign of a point.
    Sign(Sign, Color),
}

/// A symbol and its name.
#[derive(Debug, Clone, PartialEq)]
pub struct Entry {
    /// The symbol.
    pub symbol: Symbol,
    /// Meaning of its mark.
    pub name: String,
}

impl Entry {
    /// A symbol with its name.
    pub fn new(symbol: Symbol, name: impl Into<String>) -> Self {
        Self { symbol, name: name.into() }
    }
}

/// The triangle that marks an alarm, its tip down at `(x, y)`: filled where the alarm begins, hollow where it ends.
pub fn alarm(scene: &mut Scene, (x, y): Point, (color, edge): (Color, Edge)) {
    let triangle = |in_by: f64| {
        let half = 3.2 - 0.87 * in_by;
        vec![(x - half, y - 5.5 + 0.5 * in_by), (x + half, y - 5.5 + 0.5 * in_by), (x, y - in_by)]
    };
    scene.items.push(Item::Polygon { corners: triangle(0.0), rgb: color.rgb() });
    if edge == Edge::Ends {
        scene.items.push(Item::Polygon { corners: triangle(2.0), rgb: [255; 3] });
    }
}

/// A legend broken into rows for a given width.
pub struct Rows {
    rows: Vec<Vec<(Symbol, String, f64)>>,
}

impl Rows {
    pub fn new(entries: &[Entry], room: f64) -> Self {
        let mut rows: Vec<Vec<(Symbol, String, f64)>> = Vec::new();
        let mut used = f64::INFINITY;
        for entry in entries {
            let name = font::fit(&entry.name, SMALL, room - SYMBOL - GAPS.0);
            let width = SYMBOL + GAPS.0 + font::width(&name, SMALL);
            if used + GAPS.1 + width > room {
                rows.push(Vec::new());
                used = -GAPS.1;
            }
            used += GAPS.1 + width;
            if let Some(row) = rows.last_mut() {
                row.push((entry.symbol, name, width));
            }
        }
        Self { rows }
    }

    pub fn height(&self) -> f64 {
        ROW * self.rows.len() as f64
    }

    /// Width of the widest row.
    pub fn width(&self) -> f64 {
        let row = |r: &Vec<(Symbol, String, f64)>| r.iter().map(|e| e.2 + GAPS.1).sum::<f64>() - GAPS.1;
        self.rows.iter().map(row).fold(0.0, f64::max)
    }

    /// Draws the rows from `(x, y)` downwards.
    pub fn draw(&self, scene: &mut Scene, (x, y): Point) {
        for (i, row) in self.rows.iter().enumerate() {
            let (mut x, y) = (x, y + ROW * (i as f64 + 0.5));
            for (symbol, name, width) in row {
                symbol.draw(scene, (x, y));
                scene.text(name, (x + SYMBOL + GAPS.0, y), SMALL, Anchor::Start, INK);
                x += width + GAPS.1;
            }
        }
    }
}

impl Symbol {
    fn draw(&self, scene: &mut Scene, (x, y): Point) {
        let middle = x + SYMBOL / 2.0;
        match *self {
            Self::Line(style, marker) => {
                let stroke = Stroke { rgb: style.color.rgb(), width: style.width.max(1.4), dash: style.dash };
                scene.line(vec![(x, y), (x + SYMBOL, y)], stroke);
                if let Some(marker) = marker {
                    marker.draw(scene, (middle, y), style.color.rgb());
                }
            }
            Self::Mark(color, marker) => marker.draw(scene, (middle, y), color.rgb()),
            Self::Sign(sign, color) => draw_sign(scene, sign, (middle, y), color),
            Self::Band(color) => {
                let edge = |dy: f64| vec![(x + 2.0, y + dy), (x + SYMBOL - 2.0, y + dy)];
                scene.items.push(Item::Band { upper: edge(-5.0), lower: edge(5.0), rgb: color.rgb() });
            }
            Self::Patch(rgb) => {
                scene.items.push(Item::Rect {
                    area: Area { x: x + 3.0, y: y - 5.0, w: SYMBOL - 6.0, h: 10.0 },
                    rgb,
                });
            }
            Self::Upright(style) => {
                scene.line(vec![(middle, y - 6.0), (middle, y + 6.0)], Stroke::of(&style));
            }
            Self::Alarm(color, edge) => alarm(scene, (middle, y + 3.0), (color, edge)),
            Self::Outline { rgb, dash } => {
                let (l, r, t, b) = (x + 2.0, x + SYMBOL - 2.0, y - 5.5, y + 5.5);
                let corners = vec![(l, t), (r, t), (r, b), (l, b), (l, t)];
                scene.line(corners.clone(), Stroke { rgb: CASING, width: 3.2, dash: Dash::Solid });
                scene.line(corners, Stroke { rgb, width: 1.7, dash });
            }
        }
    }
}
