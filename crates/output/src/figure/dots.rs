//! Dot plots: rows for methods, trackers or readings, a panel for each tracker or statistic, and a dot with
//! its interval in each. A published value is an upright line through all rows, or a diamond in its row.

use super::axis::{Axis, Range};
use super::layout::{Figure, Form};
use super::legend::Marker;
use super::panel::{Mark, Panel};
use super::style::{Color, Dash, Style};

/// A value with its bounds.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Dot {
    /// Value of the dot.
    pub value: f64,
    /// Lower and upper bound; `None` if unknown.
    pub bounds: Option<(f64, f64)>,
}

/// A panel: one statistic of all rows.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct DotPanel {
    /// Name of the statistic.
    pub label: String,
    /// Published value that holds for all rows, drawn as an upright line.
    pub mark: Option<f64>,
    /// Values of anchors, drawn as lines through all rows.
    pub levels: Vec<(f64, Dash)>,
    /// Published value of each row; may be empty.
    pub published: Vec<Option<f64>>,
    /// Dot of each row.
    pub values: Vec<Option<Dot>>,
}

/// Panels side by side with common rows.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Dots {
    /// Title of the figure; may be empty.
    pub title: String,
    /// Note under the title; may be empty.
    pub note: String,
    /// Names of the rows, from the top.
    pub rows: Vec<String>,
    /// The panels, from the left.
    pub panels: Vec<DotPanel>,
    /// True if all panels show the same statistic and therefore have the same axis.
    pub shared_axis: bool,
    /// Color of each row; blue for rows without one.
    pub colors: Vec<Color>,
    /// Value that chance gives, drawn as a dashed line in all panels.
    pub chance: Option<f64>,
}

const GRID: Style = Style { color: Color([0xDD; 3]), dash: Dash::SOLID, width: 0.7 };
/// Style of published values: black, since methods use the other colors.
const MARKED: Style = Style { color: Color::BLACK, dash: Dash::SOLID, width: 1.4 };

impl Dots {
    /// Converts the dot plot to a figure.
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
        let levels = self.chance.map(|chance| (chance, Dash::DASHED)).into_iter().chain(panel.levels.clone());
        marks.extend(
            levels.map(|(at, dash)| Mark::Upright(at, Style { width: 1.0, ..Style::new(Color::GRAY, dash) })),
        );
        marks.extend(panel.mark.map(|at| Mark::Upright(at, MARKED)));
        for (k, dot) in panel.values.iter().enumerate() {
            let Some(Dot { value, bounds }) = dot else { continue };
            let color = self.colors.get(k).copied().unwrap_or(Color::BLUE);
            let published = panel.published.get(k).copied().flatten();
            marks.extend(published.map(|at| Mark::Point((at, height(k)), Marker::Published, color)));
            let style = Style { width: 1.6, ..Style::new(color, Dash::SOLID) };
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
