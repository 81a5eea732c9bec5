//! Curves over a parameter: sweeps of a threshold, precision over recall, receiver operating curves.

use super::axes::{self, Axis, Range};
use super::draw::Plot;
use super::error::FigureError;
use super::font;
use super::heading::heading;
use super::legend::{Entry, Marker, Rows, Symbol};
use super::scene::{Anchor, Area, Item, Point, Scene, Stroke};
use super::style::{Color, Dash, INK, MARGIN, MEDIUM, Style, WIDTH};

/// One curve.
#[derive(Debug, Clone, PartialEq)]
pub struct Curve {
    /// Name in the legend.
    pub name: String,
    /// Points in drawing order; one with a NaN leaves a gap.
    pub points: Vec<(f64, f64)>,
    /// How it is drawn.
    pub style: Style,
}

/// Curves on common axes.
#[derive(Debug, Clone, PartialEq)]
pub struct Curves {
    /// Title; may be empty.
    pub title: String,
    /// Note under the title; may be empty.
    pub note: String,
    /// Name of the horizontal axis.
    pub x_label: String,
    /// Name of the vertical axis.
    pub y_label: String,
    /// Whether the horizontal axis is logarithmic; points at 0 and below are then gaps.
    pub x_log: bool,
    /// Whether the vertical axis is logarithmic; points at 0 and below are then gaps.
    pub y_log: bool,
    /// Horizontal axis.
    pub x_range: Range,
    /// Vertical axis.
    pub y_range: Range,
    /// Whether the plot is square, as for receiver operating curves.
    pub square: bool,
    /// The curves, the first at the back.
    pub series: Vec<Curve>,
    /// Upright lines at values of interest, such as a published threshold.
    pub marks: Vec<(String, f64)>,
}

/// Maximum number of points of a curve that is drawn with markers.
const MAX_MARKERS: usize = 30;

impl Plot for Curves {
    fn scene(&self) -> Result<Scene, FigureError> {
        let placed = |v: f64, log: bool| axes::usable(v) && (!log || v > 0.0);
        let shown = |p: &&(f64, f64)| placed(p.0, self.x_log) && placed(p.1, self.y_log);
        let points = || self.series.iter().flat_map(|s| &s.points).filter(shown);
        if points().next().is_none() {
            return Err(FigureError::Empty("no curve has a point"));
        }
        let marks = self.marks.iter().map(|m| m.1);
        let x_ends = self.x_range.resolve(points().map(|p| p.0).chain(marks), self.x_log)?;
        let y_ends = self.y_range.resolve(points().map(|p| p.1), self.y_log)?;

        let mut scene = Scene::new(&self.title, WIDTH * if self.square { 0.625 } else { 0.75 });
        let room = scene.width - 2.0 * MARGIN;
        let mut y = heading(&mut scene, &self.title, &self.note);
        let legend = Rows::new(&self.legend(), room);
        legend.draw(&mut scene, (MARGIN, y));
        y += legend.height() + 8.0;

        let mut height = 260.0;
        let y_axis_of = |height: f64| Axis::new(y_ends, (y + height, y), 5.0, self.y_log);
        let left = MARGIN + 25.0 + axes::label_width(&y_axis_of(height).ticks(axes::max_ticks_y(height)));
        let w = scene.width - MARGIN - 8.0 - left;
        if self.square {
            height = w;
        }
        let area = Area { x: left, y, w, h: height };
        let x_axis = Axis::new(x_ends, (area.x, area.right()), 6.0, self.x_log);
        let y_axis = y_axis_of(height);

        for (i, &(_, at)) in self.marks.iter().enumerate().filter(|(_, m)| axes::usable(m.1)) {
            let x = x_axis.place(at);
            scene.clipped(&[(x, area.y), (x, area.bottom())], &area, Stroke::of(&mark_style(i)));
        }
        for (i, curve) in self.series.iter().enumerate() {
            let marker = marker(i, curve);
            let rgb = curve.style.color.rgb();
            for run in curve.points.split(|p| !shown(&p)).filter(|r| !r.is_empty()) {
                let places: Vec<Point> = run.iter().map(|p| (x_axis.place(p.0), y_axis.place(p.1))).collect();
                scene.clipped(&places, &area, Stroke::of(&curve.style));
                for &at in places.iter().filter(|p| area.clip(**p, **p).is_some()) {
                    match marker {
                        Some(m) => m.draw(&mut scene, at, rgb),
                        None if run.len() == 1 => {
                            scene.items.push(Item::Circle { center: at, radius: curve.style.width, rgb });
                        }
                        None => {}
                    }
                }
            }
        }
        axes::frame(&mut scene, &area, &x_axis, &y_axis, true);
        let x_label = font::fit(&self.x_label, MEDIUM, area.w);
        scene.text(&x_label, (area.x + area.w / 2.0, area.bottom() + 29.0), MEDIUM, Anchor::Middle, INK);
        let y_label = font::fit(&self.y_label, MEDIUM, area.h);
        scene.text_upwards(&y_label, (MARGIN + 7.0, area.y + area.h / 2.0), MEDIUM, INK);
        scene.height = area.bottom() + 40.0 + MARGIN / 2.0;
        Ok(scene)
    }
}

impl Curves {
    fn legend(&self) -> Vec<Entry> {
        let curves = self
            .series
            .iter()
            .enumerate()
            .map(|(i, c)| Entry { symbol: Symbol::Line(c.style, marker(i, c)), name: c.name.clone() });
        let marks = self
            .marks
            .iter()
            .enumerate()
            .map(|(i, m)| Entry { symbol: Symbol::Upright(Stroke::of(&mark_style(i))), name: m.0.clone() });
        curves.chain(marks).filter(|e| !e.name.trim().is_empty()).collect()
    }
}

fn marker(i: usize, curve: &Curve) -> Option<Marker> {
    (curve.points.len() <= MAX_MARKERS).then(|| Marker::nth(i))
}

fn mark_style(i: usize) -> Style {
    let dash = [Dash::Dashed, Dash::Dotted, Dash::DashDot][i % 3];
    Style { width: 1.1, ..Style::new(Color::Gray, dash) }
}
