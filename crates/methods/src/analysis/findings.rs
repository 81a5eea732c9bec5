//! The findings of an analysis: numbers, tables and charts. A [`Layout`] names all of them once; [`Values`] fill it in
//! the same order.

use crate::score::TrackerMetric;
use serde::{Deserialize, Serialize};

/// Result of an analysis.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Findings {
    /// Numbers by name, finite.
    pub numbers: Vec<(String, f64)>,
    /// Tables by name.
    pub tables: Vec<Grid>,
    /// Charts by name.
    pub charts: Vec<Chart>,
}

/// A table of numbers.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Grid {
    /// Name in the analysis.
    pub name: String,
    /// Heading of the first column, which holds the headings of the rows.
    pub corner: String,
    /// Column headings.
    pub columns: Vec<String>,
    /// Rows. The only row of a table may have no heading: such rows of several trackers are shown as the rows of one
    /// table.
    pub rows: Vec<Row>,
}

/// A row of a table: its heading, and one value for each column, empty where there is none.
pub type Row = (String, Vec<Option<f64>>);

/// Curves on common axes.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Chart {
    /// Name in the analysis.
    pub name: String,
    /// Name of the horizontal axis.
    pub x: String,
    /// Name of the vertical axis.
    pub y: String,
    /// Whether the vertical axis is logarithmic.
    pub y_log: bool,
    /// Curves. A curve without a name gets its tracker's. One named [`INTERVAL`] has the corners of the interval of the
    /// only point of the curve before it: left and lower, right and upper end.
    pub curves: Vec<Curve>,
}

/// A curve: its name, and finite points from left to right.
pub type Curve = (String, Vec<(f64, f64)>);

/// Name of a curve that has the corners of an interval.
pub const INTERVAL: &str = "95 % interval";

impl Findings {
    /// A number by name.
    pub fn number(&self, name: &str) -> Option<f64> {
        self.numbers.iter().find(|(known, _)| known == name).map(|(_, value)| *value)
    }
}

/// Names of the findings of an analysis.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Names {
    /// Numbers.
    pub numbers: Vec<String>,
    /// Tables.
    pub tables: Vec<String>,
    /// Charts.
    pub charts: Vec<String>,
}

/// Numbers, tables and charts without values: no table has a row, no chart a curve.
#[derive(Debug, Clone, Default)]
pub struct Layout {
    /// Names of the numbers.
    pub numbers: Vec<String>,
    tables: Vec<Grid>,
    charts: Vec<Chart>,
}

/// Values of the findings, in the order of the [`Layout`].
#[derive(Debug, Clone, Default)]
pub struct Values {
    /// Numbers; those that are empty are left out.
    pub numbers: Vec<Option<f64>>,
    /// Rows of each table.
    pub tables: Vec<Vec<Row>>,
    /// Curves of each chart.
    pub charts: Vec<Vec<Curve>>,
}

impl Layout {
    /// Numbers by name.
    pub fn of<'n>(numbers: impl IntoIterator<Item = &'n str>) -> Self {
        Self { numbers: numbers.into_iter().map(String::from).collect(), ..Self::default() }
    }

    /// Numbers of trackers, and the table `overall` that holds them; [`Values::of_tracker`] fills both.
    pub fn of_trackers(metrics: &[TrackerMetric]) -> Self {
        Self::of(metrics.iter().map(|m| m.name)).measures("overall", "tracker", metrics)
    }

    /// Adds a table.
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

    /// Adds a table with a column for each metric.
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

    /// Names of all findings.
    pub fn names(self) -> Names {
        Names {
            numbers: self.numbers,
            tables: self.tables.into_iter().map(|table| table.name).collect(),
            charts: self.charts.into_iter().map(|chart| chart.name).collect(),
        }
    }

    /// The findings of these values.
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
    /// Numbers of a tracker, which are also the only row of the first table.
    pub fn of_tracker(numbers: &[Option<f64>]) -> Self {
        let overall = vec![(String::new(), numbers.to_vec())];
        Self { numbers: numbers.to_vec(), tables: vec![overall], charts: Vec::new() }
    }
}
