//! Curves over a parameter: sweeps of a threshold, precision over recall, receiver operating curves; in one panel, or in
//! several with common axes.
//!
//! The legend stands below the panels, or beside a square one that leaves room there, so that a panel is where it is
//! whatever the legend says.

mod panel;

use super::axes::{self, Axis, Range};
use super::draw::Plot;
use super::error::FigureError;
use super::font;
use super::heading::heading;
use super::legend::{self, Entry, Marker, Rows};
use super::scene::{Anchor, Area, Scene};
use super::sign::Sign;
use super::style::{Color, INK, MARGIN, MEDIUM, Style, WIDTH};

/// One curve.
#[derive(Debug, Clone, PartialEq)]
pub struct Curve {
    /// Points in drawing order; one with a NaN leaves a gap.
    pub points: Vec<(f64, f64)>,
    /// Lower and upper bound of each point's value; empty without any. One with a NaN leaves a gap.
    pub band: Vec<(f64, f64)>,
    /// How it is drawn.
    pub style: Style,
    /// The mark of its points.
    pub marker: Option<Marker>,
}

impl Curve {
    /// A curve without a band, with marks where it has few points.
    pub fn new(points: Vec<(f64, f64)>, style: Style, marker: Marker) -> Self {
        let marker = (points.len() <= MAX_MARKERS).then_some(marker);
        Self { points, band: Vec::new(), style, marker }
    }
}

/// Maximum number of points of a curve that is drawn with marks.
const MAX_MARKERS: usize = 30;

/// One of several panels with common axes.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Facet {
    /// Heading of the panel; may be empty.
    pub label: String,
    /// The curves, the first at the back.
    pub series: Vec<Curve>,
    /// Curves of other panels, in gray behind those of this one.
    pub behind: Vec<Vec<(f64, f64)>>,
    /// Signs at points.
    pub signs: Vec<(Sign, (f64, f64), Color)>,
    /// Names beside points.
    pub names: Vec<(String, (f64, f64))>,
    /// Upright lines at values of interest, such as a published threshold.
    pub uprights: Vec<(f64, Style)>,
}

/// One of the axes.
#[derive(Debug, Clone, PartialEq)]
pub struct CurveAxis {
    /// Its name.
    pub label: String,
    /// Whether it is logarithmic; points at 0 and below are then gaps.
    pub log: bool,
    /// What it shows.
    pub range: Range,
}

impl CurveAxis {
    /// A linear axis of all values.
    pub fn new(label: &str) -> Self {
        Self { label: label.to_string(), log: false, range: Range::Auto }
    }

    fn shows(&self, value: f64) -> bool {
        axes::usable(value) && (!self.log || value > 0.0)
    }
}

/// Curves on common axes.
#[derive(Debug, Clone, PartialEq)]
pub struct Curves {
    /// Title; may be empty.
    pub title: String,
    /// Note under the title; may be empty.
    pub note: String,
    /// Horizontal axis.
    pub x: CurveAxis,
    /// Vertical axis.
    pub y: CurveAxis,
    /// Whether a panel is square, as for receiver operating curves.
    pub square: bool,
    /// Whether lines of equal F are drawn, for precision over recall.
    pub iso_f: bool,
    /// The panels.
    pub facets: Vec<Facet>,
    /// The legend.
    pub legend: Vec<Entry>,
}

/// Height of a single panel that is not square, and the least and largest of several, in units.
const HEIGHT: (f64, f64, f64) = (300.0, 110.0, 200.0);
/// Side of a square panel with the legend beside it, in units.
const SIDE: f64 = 390.0;
/// Least room between panels, in units.
const GAP: f64 = 14.0;
/// Room between the labels of two panels, in units.
const APART: f64 = 8.0;
/// Room for the name of the horizontal axis and its ticks, in units.
const FOOT: f64 = 40.0;
/// Room for the name of the vertical axis, in units.
const NAME: f64 = 18.0;

/// Where the panels of a figure are.
struct Grid {
    columns: usize,
    rows: usize,
    first: Area,
    head: f64,
    gap: f64,
}

impl Grid {
    fn area(&self, k: usize) -> Area {
        let (column, row) = ((k % self.columns) as f64, (k / self.columns) as f64);
        let Area { x, y, w, h } = self.first;
        Area { x: x + column * (w + self.gap), y: y + row * (h + self.head + GAP), w, h }
    }

    fn bottom(&self) -> f64 {
        self.area((self.rows - 1) * self.columns).bottom()
    }

    fn right(&self) -> f64 {
        self.area(self.columns - 1).right()
    }
}

/// Number of panels beside each other: as few rows as `most` allows, equally filled.
fn columns(panels: usize, most: usize) -> usize {
    panels.div_ceil(panels.div_ceil(most))
}

impl Plot for Curves {
    fn scene(&self, width: f64) -> Result<Scene, FigureError> {
        let series = || self.facets.iter().flat_map(|f| &f.series);
        let shown = |p: &&(f64, f64)| self.x.shows(p.0) && self.y.shows(p.1);
        if series().flat_map(|c| &c.points).find(shown).is_none() {
            return Err(FigureError::Empty("no curve has a point"));
        }
        let mut scene = Scene::new(&self.title, width);
        let top = heading(&mut scene, &self.title, &self.note);
        let is_wide = width >= WIDTH;
        let columns = self.columns(width);
        let is_single = self.facets.len() == 1;
        let beside = is_single && self.square && is_wide;

        // The ends of the vertical axis depend on its ticks, these on its length, and that on the room of their labels,
        // which is guessed first.
        let height_of = |w: f64| match self.square {
            true => w,
            false if is_single && is_wide => HEIGHT.0,
            false => (0.75 * w).clamp(HEIGHT.1, HEIGHT.2),
        };
        let width_of = |left: f64, gap: f64| match beside {
            true => SIDE,
            false => (width - left - MARGIN - 8.0 - gap * (columns - 1) as f64) / columns as f64,
        };
        let guess = height_of(width_of(MARGIN + NAME + 40.0, 2.0 * GAP));
        let y_ends = self.y_ends(axes::max_ticks_y(guess))?;
        let y_axis = |top: f64, h: f64| Axis::new(y_ends, (top + h, top), 5.0, self.y.log);
        let labels = axes::label_width(&y_axis(0.0, guess).ticks(axes::max_ticks_y(guess)));
        let left = MARGIN + NAME + 7.0 + labels;
        let max = axes::max_ticks_x(width_of(left, 2.0 * GAP));
        let x_ends = self.x_ends(max)?;
        // The label at the end of an axis stands beside the one at the beginning of the next.
        let x_labels = axes::label_width(&Axis::new(x_ends, (0.0, 1.0), 0.0, self.x.log).ticks(max));
        let gap = GAP.max(x_labels + APART);
        let w = width_of(left, gap);
        let head = if self.facets.iter().any(|f| !f.label.trim().is_empty()) { legend::ROW } else { 0.0 };
        let first = Area { x: left, y: top + head, w, h: height_of(w) };
        let grid = Grid { columns, rows: self.facets.len().div_ceil(columns), first, head, gap };

        for (k, facet) in self.facets.iter().enumerate() {
            let area = grid.area(k);
            let heading = font::fit(&facet.label, MEDIUM, area.w);
            scene.text(&heading, (area.x, area.y - head / 2.0 - 2.0), MEDIUM, Anchor::Start, INK);
            let x_axis = Axis::new(x_ends, (area.x, area.right()), 5.0, self.x.log);
            let place = panel::Place { area, x: x_axis, y: y_axis(area.y, area.h) };
            place.draw(&mut scene, self, facet);
            // Labels stand at the left of each row and below each column.
            let labels = axes::Labelled { x: k + columns >= self.facets.len(), y: k % columns == 0 };
            axes::frame(&mut scene, &area, &place.x, &place.y, labels);
        }
        let (right, bottom) = (grid.right(), grid.bottom());
        let x_label = font::fit(&self.x.label, MEDIUM, right - left);
        scene.text(&x_label, ((left + right) / 2.0, bottom + 29.0), MEDIUM, Anchor::Middle, INK);
        let middle = (first.y + bottom) / 2.0;
        let room = 2.0 * (middle - MARGIN).min(bottom + FOOT - 4.0 - middle);
        let y_label = font::fit(&self.y.label, MEDIUM, room);
        scene.text_upwards(&y_label, (MARGIN + 7.0, middle), MEDIUM, INK);

        let (x, y) = if beside { (right + 22.0, first.y) } else { (MARGIN, bottom + FOOT) };
        let legend = Rows::new(&self.legend, width - x - MARGIN);
        legend.draw(&mut scene, (x, y));
        scene.height = (y + legend.height()).max(bottom + FOOT) + MARGIN / 2.0;
        Ok(scene)
    }
}

impl Curves {
    /// Number of panels beside each other: four or, in a column, two, and less where their headings would not fit.
    fn columns(&self, width: f64) -> usize {
        let heading = self.facets.iter().map(|f| font::width(&f.label, MEDIUM)).fold(0.0, f64::max);
        let most = if width >= WIDTH { 4 } else { 2 };
        let fits = |most: &usize| heading < (width - 60.0) / *most as f64 - 2.0 * GAP;
        columns(self.facets.len(), (1..=most).rev().find(fits).unwrap_or(1))
    }

    /// All that is drawn of a curve: its points, those of curves behind, and signs.
    fn places(&self) -> impl Iterator<Item = (f64, f64)> {
        let of = |f: &Facet| {
            let series = f.series.iter().flat_map(|c| c.points.clone());
            let signs = f.signs.iter().map(|s| s.1);
            series.chain(signs).chain(f.behind.iter().flatten().copied()).collect::<Vec<_>>()
        };
        let shown = |p: &(f64, f64)| self.x.shows(p.0) && self.y.shows(p.1);
        self.facets.iter().flat_map(of).filter(shown)
    }

    fn x_ends(&self, max: usize) -> Result<(f64, f64), FigureError> {
        let uprights = self.facets.iter().flat_map(|f| &f.uprights).map(|u| u.0);
        self.x.range.resolve(self.places().map(|p| p.0).chain(uprights), self.x.log, max)
    }

    fn y_ends(&self, max: usize) -> Result<(f64, f64), FigureError> {
        let series = self.facets.iter().flat_map(|f| &f.series);
        let bands = series.flat_map(|c| &c.band).flat_map(|(low, high)| [*low, *high]);
        self.y.range.resolve(self.places().map(|p| p.1).chain(bands), self.y.log, max)
    }
}
