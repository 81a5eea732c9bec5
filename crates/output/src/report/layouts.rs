//! Tables that a report makes by itself, beside those of its experiment.

use crate::results::Results;
use crate::table::data_note;
use crate::table::layout::{Cell, Group, Row, TableLayout};
use trackfail_core::direction::Direction;
use trackfail_engine::spec::TEST;
use trackfail_engine::spec::table::Latex;

/// A number as it is shown; empty without one.
pub fn cell(value: Option<f64>, shown: impl Fn(f64) -> String) -> Cell {
    Cell { value, ours: value.map(shown), ..Cell::default() }
}

/// A table without a note on its data.
pub fn table(name: &str, caption: String, corner: &str, columns: &[&str], groups: Vec<Group>) -> TableLayout {
    TableLayout {
        name: name.into(),
        caption,
        data: String::new(),
        corner: corner.into(),
        columns: columns.iter().map(|c| (*c).into()).collect(),
        latex: Latex::default(),
        groups,
    }
}

/// Rows with a heading.
pub fn group(key: &str, label: String, rows: Vec<(String, Vec<Cell>)>) -> Group {
    let row = |(label, cells): (String, Vec<Cell>)| Row {
        label: label.into(),
        direction: Direction::Neither,
        cells,
    };
    Group {
        key: key.to_string(),
        label,
        published_tracker: None,
        has_ours: true,
        rows: rows.into_iter().map(row).collect(),
    }
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
