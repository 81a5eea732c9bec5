//! Tables that reports add to those of the experiment, and their parts.

use super::experiment::data_note;
use super::layout::{Cell, Group, Label, Row, TableLayout};
use super::number::Style;
use crate::results::Results;
use trackfail_core::direction::Direction;
use trackfail_engine::spec::TEST;
use trackfail_engine::spec::table::Latex;

/// Cell with a number; empty for `None`.
pub fn cell(value: Option<f64>, shown: impl Fn(f64) -> String) -> Cell {
    Cell { value, ours: value.map(shown), ..Cell::default() }
}

/// Cell with a number in a style; empty for `None`.
pub fn number(value: Option<f64>, style: Style) -> Cell {
    cell(value, |v| style.format(v))
}

/// Group of rows with a heading.
pub fn group<L: Into<Label>>(
    key: &str,
    label: String,
    rows: impl IntoIterator<Item = (L, Vec<Cell>)>,
) -> Group {
    let row = |(label, cells): (L, _)| Row { label: label.into(), direction: Direction::Neither, cells };
    let rows = rows.into_iter().map(row).collect();
    Group { key: key.to_string(), label, published_tracker: None, has_ours: true, rows }
}

/// Table without a note on its data.
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

/// Sentence that names the suite behind all numbers.
pub fn suite(results: &Results) -> String {
    let experiment = &results.experiment;
    format!("Suite {}: {}.", experiment.suites[TEST], data_note(experiment, &results.manifest))
}

/// Adds the sentence `suite` to the caption of a table, and renames it if a table of the experiment has its
/// name.
pub fn of_suite(mut table: TableLayout, results: &Results, suite: &str) -> TableLayout {
    table.caption = format!("{} {suite}", table.caption);
    table.data = data_note(&results.experiment, &results.manifest);
    while results.experiment.tables.iter().any(|t| t.name == table.name) {
        table.name.push('_');
    }
    table
}
