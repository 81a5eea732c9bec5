//! Cells of a run as rows: their order, their names, and the columns that say which cell and frame a row is about.

use super::column::{FRAME, RUN, SEQUENCE, SUITE, TRACKER};
use polars::prelude::Column as Series;
use std::collections::HashMap;
use std::hash::Hash;
use trackfail_engine::{Cell, Outcome};

/// A method's name in `frames.parquet`: with its grid point, where it has one.
pub fn method_label(method: &str, params: &str) -> String {
    if params.is_empty() { method.to_string() } else { format!("{method}[{params}]") }
}

/// Reads a grid point, `horizon=5;window=20`: axis and value.
pub fn parse_point(params: &str) -> Vec<(String, f64)> {
    params
        .split(';')
        .filter_map(|part| {
            let (axis, value) = part.split_once('=')?;
            Some((axis.to_string(), value.parse().ok()?))
        })
        .collect()
}

/// An empty text as a missing value, so that the CSV field is empty and not `""`.
pub(super) fn some_text(text: &str) -> Option<&str> {
    (!text.is_empty()).then_some(text)
}

/// The cells by their names, whatever the order in which they were done.
pub(super) fn sorted_cells<'a>(outcome: &'a Outcome<'_>) -> Vec<&'a Cell> {
    let mut cells: Vec<&Cell> = outcome.cells.iter().collect();
    fn key<'c>(outcome: &'c Outcome<'_>, c: &'c Cell) -> (&'c str, &'c str, u32, &'c str, &'c str) {
        (&outcome.sequences[c.sequence].name, &c.tracker, c.run, &c.method, &c.params)
    }
    cells.sort_by(|a, b| key(outcome, a).cmp(&key(outcome, b)));
    cells
}

/// About how many rows of a file with a row for each frame are in memory at once; a row group has as many.
const ROWS_AT_ONCE: usize = 1 << 17;

/// Parts of about [`ROWS_AT_ONCE`] frames, at least one, of a list whose items have a row for each frame of their cell.
pub(super) fn in_parts<'c, T>(
    outcome: &Outcome<'_>,
    cells: &'c [T],
    cell: impl Fn(&T) -> &Cell,
) -> Vec<&'c [T]> {
    let mut parts = Vec::new();
    let mut rest = cells;
    while !rest.is_empty() {
        let mut rows = 0;
        let fits = |one: &&T| {
            rows += outcome.sequences[cell(one).sequence].len();
            rows <= ROWS_AT_ONCE
        };
        let (part, later) = rest.split_at(rest.iter().take_while(fits).count().max(1));
        parts.push(part);
        rest = later;
    }
    if parts.is_empty() {
        parts.push(rest);
    }
    parts
}

/// Cells with the same key together; groups and their cells in the order in which they come.
pub(super) fn grouped<'a, K: Eq + Hash>(
    cells: impl IntoIterator<Item = &'a Cell>,
    key: impl Fn(&'a Cell) -> K,
) -> Vec<Vec<&'a Cell>> {
    let mut places = HashMap::new();
    let mut groups: Vec<Vec<&Cell>> = Vec::new();
    for cell in cells {
        // The map only finds a group's place, its own order plays no part.
        let place = *places.entry(key(cell)).or_insert_with(|| {
            groups.push(Vec::new());
            groups.len() - 1
        });
        groups[place].push(cell);
    }
    groups
}

/// The leading columns of files with a row for each frame: suite, sequence, tracker, run and frame.
#[derive(Default)]
pub(super) struct FrameKeys<'a> {
    sequence: Vec<&'a str>,
    tracker: Vec<&'a str>,
    run: Vec<i64>,
    frame: Vec<i64>,
}

impl<'a> FrameKeys<'a> {
    /// Adds the frames of a cell.
    pub fn push(&mut self, outcome: &'a Outcome<'_>, cell: &'a Cell, length: usize) {
        let sequence = &outcome.sequences[cell.sequence];
        self.sequence.extend(std::iter::repeat_n(sequence.name.as_str(), length));
        self.tracker.extend(std::iter::repeat_n(cell.tracker.as_str(), length));
        self.run.extend(std::iter::repeat_n(i64::from(cell.run), length));
        self.frame.extend((0..length).map(|t| i64::from(sequence.number(t))));
    }

    pub fn columns(self, suite: &str) -> Vec<Series> {
        vec![
            SUITE.of(vec![suite; self.frame.len()]),
            SEQUENCE.of(self.sequence),
            TRACKER.of(self.tracker),
            RUN.of(self.run),
            FRAME.of(self.frame),
        ]
    }
}
