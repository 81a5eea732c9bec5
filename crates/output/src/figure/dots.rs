//! Dot plots: a row for each method, tracker or reading, a panel for each tracker or statistic, a dot with its interval. A
//! published value is an upright line for all rows, or a diamond in its row.

use super::axis::{Axis, Range};
use super::layout::{Figure, Form};
use super::legend::Marker;
use super::panel::{Mark, Panel};
use super::style::{Color, Dash, Style};

/// A value with its bounds.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Dot {
    /// The value.
    pub value: f64,
    /// Lower and upper bound, where they are known.
    pub bounds: Option<(f64, f64)>,
}

/// A panel: one statistic of all rows.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct DotPanel {
    /// Name of the statistic.
    pub label: String,
    /// The published value of all rows, an upright line.
    pub mark: Option<f64>,
    /// Values of methods that know nothing, or all: lines through all rows.
    pub levels: Vec<(f64, Dash)>,
    /// The value that a paper prints for each row; may be empty.
    pub published: Vec<Option<f64>>,
    /// The dot of each row.
    pub values: Vec<Option<Dot>>,
}

/// Panels beside each other with common rows.
#[derive(Debug, Clone, PartialEq)]
pub struct Dots {
    /// Title; may be empty.
    pub title: String,
    /// Note under the title; may be empty.
    pub note: String,
    /// Names of the rows, from the top.
    pub rows: Vec<String>,
    /// The panels, from the left.
    pub panels: Vec<DotPanel>,
    /// Whether all panels have one axis, because they show one statistic.
    pub shared_axis: bool,
    /// The color of each row; blue where there is none.
    pub colors: Vec<Color>,
    /// The value that chance gives: a dashed line in every panel.
    pub chance: Option<f64>,
}

const GRID: Style = Style { color: Color::Mapped([0xDD; 3]), dash: Dash::Solid, width: 0.7 };
/// Black, because a method has each of the other colors.
const MARKED: Style = Style { color: Color::Black, dash: Dash::Solid, width: 1.4 };

impl Dots {
    /// The figure.
    pub fn figure(&self) -> Figure {
        let rows = if self.rows.is_empty() {
            Vec::new()
        } else {
            vec![self.panels.iter().map(|p| self.panel(p)).collect()]
        };
        let form = Form::Rows { shared: self.shared_axis };
        Figure { title: self.title.clone(), note: self.note.clone(), form, rows, ..Figure::default() }
    }

    fn panel(&self, panel: &DotPanel) -> Panel {
        let height = |k: usize| (self.rows.len() - 1 - k) as f64 + 0.5;
        let mut marks: Vec<Mark> = (0..self.rows.len()).map(|k| Mark::Level(height(k), GRID)).collect();
        let levels = self.chance.map(|chance| (chance, Dash::Dashed)).into_iter().chain(panel.levels.clone());
        marks.extend(
            levels.map(|(at, dash)| Mark::Upright(at, Style { width: 1.0, ..Style::new(Color::Gray, dash) })),
        );
        marks.extend(panel.mark.map(|at| Mark::Upright(at, MARKED)));
        for (k, dot) in panel.values.iter().enumerate() {
            let Some(Dot { value, bounds }) = dot else { continue };
            let color = self.colors.get(k).copied().unwrap_or(Color::Blue);
            let published = panel.published.get(k).copied().flatten();
            marks.extend(published.map(|at| Mark::Point((at, height(k)), Marker::Published, color)));
            let style = Style { width: 1.6, ..Style::new(color, Dash::Solid) };
            marks.extend(
                bounds.map(|(low, high)| Mark::line(vec![(low, height(k)), (high, height(k))], style)),
            );
            marks.push(Mark::Point((*value, height(k)), Marker::Circle, color));
        }
        let names = self.rows.iter().enumerate().map(|(k, name)| (height(k), name.clone())).collect();
        let y = Axis { names, ..Axis::new("", Range::Fixed(0.0, self.rows.len() as f64)) };
        Panel { title: panel.label.clone(), x: Axis::default(), y, marks, legend: Vec::new() }
    }
}
