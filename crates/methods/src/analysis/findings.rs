//! Findings of an analysis: numbers, tables and charts. A [`Layout`] names all of them; [`Values`] has the
//! values in the same order.

use crate::score::TrackerMetric;
use serde::{Deserialize, Serialize};

/// Result of an analysis.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Findings {
    /// Numbers by name; all are finite.
    pub numbers: Vec<(String, f64)>,
    /// Tables by name.
    pub tables: Vec<Grid>,
    /// Charts by name.
    pub charts: Vec<Chart>,
}

/// A table of numbers.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Grid {
    /// Name of the table, unique in the analysis.
    pub name: String,
    /// Heading of the first column, in which the headings of the rows stand.
    pub corner: String,
    /// Column headings.
    pub columns: Vec<String>,
    /// Rows. The only row of a table may have an empty heading: such rows of several trackers are shown as
    /// one table.
    pub rows: Vec<Row>,
}

/// A row of a table: the heading, and one value per column (`None`: an empty cell).
pub type Row = (String, Vec<Option<f64>>);

/// A chart: curves on common axes.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Chart {
    /// Name of the chart, unique in the analysis.
    pub name: String,
    /// Label of the horizontal axis.
    pub x: String,
    /// Label of the vertical axis.
    pub y: String,
    /// True if the vertical axis is logarithmic.
    pub y_log: bool,
    /// Curves. A curve with an empty name is shown under the name of its tracker. A curve named [`INTERVAL`]
    /// belongs to the curve before it, which is a single point: its two points are the lower left and the
    /// upper right corner of the point's interval.
    pub curves: Vec<Curve>,
}

/// A curve: its name, and finite points in order of x.
pub type Curve = (String, Vec<(f64, f64)>);

/// Name of a curve that holds the corners of an interval; see [`Chart::curves`].
pub const INTERVAL: &str = "95 % interval";

impl Findings {
    /// The number of this name.
    pub fn number(&self, name: &str) -> Option<f64> {
        self.numbers.iter().find(|(known, _)| known == name).map(|(_, value)| *value)
    }
}

/// Names of the findings of an analysis.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Names {
    /// Names of the numbers.
    pub numbers: Vec<String>,
    /// Names of the tables.
    pub tables: Vec<String>,
    /// Names of the charts.
    pub charts: Vec<String>,
}

/// Names, headings and axes of all findings of an analysis, without values.
#[derive(Debug, Clone, Default)]
pub struct Layout {
    /// Names of the numbers.
    pub numbers: Vec<String>,
    tables: Vec<Grid>,
    charts: Vec<Chart>,
}

/// Values of all findings, in the order of the [`Layout`].
#[derive(Debug, Clone, Default)]
pub struct Values {
    /// Values of the numbers; `None` leaves a number out.
    pub numbers: Vec<Option<f64>>,
    /// Rows of each table.
    pub tables: Vec<Vec<Row>>,
    /// Curves of each chart.
    pub charts: Vec<Vec<Curve>>,
}

impl Layout {
    /// A layout with these numbers.
    pub fn of<'n>(numbers: impl IntoIterator<Item = &'n str>) -> Self {
        Self { numbers: numbers.into_iter().map(String::from).collect(), ..Self::default() }
    }

    /// A layout with numbers of trackers and a table `overall` with the same numbers; [`Values::of_tracker`]
    /// gives the values of both.
    pub fn of_trackers(metrics: &[TrackerMetric]) -> Self {
        Self::of(metrics.iter().map(|m| m.name)).measures("overall", "tracker", metrics)
    }

    /// Adds a table with these column headings.
    pub fn table(
        mut self,
        name: &str,
        corner: &str,
        columns: impl IntoIterator<Item = impl Into<String>>,
    ) -> Self {
        let columns = columns.into_iter().map(Into::into).collect();
        self.tables.push(Grid { name: name.into(), corner: corner.into(), columns, rows: Vec::new() });
        self
    }

    /// Adds a table with one column per metric.
    pub fn measures(self, name: &str, corner: &str, metrics: &[TrackerMetric]) -> Self {
        self.table(name, corner, metrics.iter().map(|m| m.heading))
    }

    /// Adds a chart with these axes.
    pub fn chart(mut self, name: &str, x: &str, y: &str) -> Self {
        self.charts.push(Chart { name: name.into(), x: x.into(), y: y.into(), ..Chart::default() });
        self
    }

    /// Makes the vertical axis of the last chart logarithmic.
    pub fn logarithmic(mut self) -> Self {
        if let Some(chart) = self.charts.last_mut() {
            chart.y_log = true;
        }
        self
    }

    /// The names of all findings.
    pub fn names(self) -> Names {
        Names {
            numbers: self.numbers,
            tables: self.tables.into_iter().map(|table| table.name).collect(),
            charts: self.charts.into_iter().map(|chart| chart.name).collect(),
        }
    }

    /// The findings with these values.
    pub fn with(self, values: Values) -> Findings {
        let numbers = self.numbers.into_iter().zip(values.numbers);
        let tables = self.tables.into_iter().zip(values.tables);
        let charts = self.charts.into_iter().zip(values.charts);
        Findings {
            numbers: numbers.filter_map(|(name, value)| Some((name, value?))).collect(),
            tables: tables.map(|(table, rows)| Grid { rows, ..table }).collect(),
            charts: charts.map(|(chart, curves)| Chart { curves, ..chart }).collect(),
        }
    }
}

impl Values {
    /// Values of a tracker: the numbers, which are also the only row of the first table.
    pub fn of_tracker(numbers: &[Option<f64>]) -> Self {
        let overall = vec![(String::new(), numbers.to_vec())];
        Self { numbers: numbers.to_vec(), tables: vec![overall], charts: Vec::new() }
    }
}
