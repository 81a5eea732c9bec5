//! Cells of a run as rows: their names, their order, and what is written at once.

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

/// What has the same key together, behind the key; groups and their members in the order in which they come.
pub(super) fn grouped<T: Copy, K: Copy + Eq + Hash>(
    all: impl IntoIterator<Item = T>,
    key: impl Fn(T) -> K,
) -> Vec<(K, Vec<T>)> {
    let mut places = HashMap::new();
    let mut groups: Vec<(K, Vec<T>)> = Vec::new();
    for one in all {
        let key = key(one);
        // The map only finds a group's place, its own order plays no part.
        let place = *places.entry(key).or_insert(groups.len());
        if place == groups.len() {
            groups.push((key, Vec::new()));
        }
        groups[place].1.push(one);
    }
    groups
}
