//! Tables that a report makes by itself, and their parts.

use super::experiment::data_note;
use super::layout::{Cell, Group, Label, Row, TableLayout};
use super::number::Style;
use crate::results::Results;
use trackfail_core::direction::Direction;
use trackfail_engine::spec::TEST;
use trackfail_engine::spec::table::Latex;

/// A number as it is shown; empty without one.
pub fn cell(value: Option<f64>, shown: impl Fn(f64) -> String) -> Cell {
    Cell { value, ours: value.map(shown), ..Cell::default() }
}

/// A number in a style; empty without one.
pub fn number(value: Option<f64>, style: Style) -> Cell {
    cell(value, |v| style.format(v))
}

/// Rows with a heading.
pub fn group<L: Into<Label>>(
    key: &str,
    label: String,
    rows: impl IntoIterator<Item = (L, Vec<Cell>)>,
) -> Group {
    let row = |(label, cells): (L, _)| Row { label: label.into(), direction: Direction::Neither, cells };
    let rows = rows.into_iter().map(row).collect();
    Group { key: key.to_string(), label, published_tracker: None, has_ours: true, rows }
}

/// A table without a note on its data.
pub fn table<L: Into<Label>>(
    name: &str,
    caption: String,
    corner: &str,
    columns: impl IntoIterator<Item = L>,
    groups: Vec<Group>,
) -> TableLayout {
    let (data, latex) = (String::new(), Latex::default());
    let columns = columns.into_iter().map(Into::into).collect();
    TableLayout { name: name.into(), caption, data, corner: corner.into(), columns, latex, groups }
}

/// The sentence that says what all numbers rest on.
pub fn suite(results: &Results) -> String {
    let experiment = &results.experiment;
    format!("Suite {}: {}.", experiment.suites[TEST], data_note(experiment, &results.manifest))
}

/// The table with what its numbers rest on, `suite` in a sentence, under a name that no table of the experiment has.
pub fn of_suite(mut table: TableLayout, results: &Results, suite: &str) -> TableLayout {
    table.caption = format!("{} {suite}", table.caption);
    table.data = data_note(&results.experiment, &results.manifest);
    while results.experiment.tables.iter().any(|t| t.name == table.name) {
        table.name.push('_');
    }
    table
}
