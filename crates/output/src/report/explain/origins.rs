//! The origin of every cell of a report's tables: its formula, and the command that takes it apart.

use super::formula;
use crate::report::sequences::Tallies;
use crate::results::Results;
use crate::results::measures::{self, Measure};
use crate::results::{CellScore, method_label, parse_point};
use crate::table::layout::{self, CellRef, Group, TableLayout};
use serde::Serialize;
use std::collections::BTreeMap;
use trackfail_engine::spec::table::Table;

/// The origin of a cell of a table, as the page shows it.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize)]
pub struct CellOrigin {
    /// The number: `f_score of DTEF on NCC is 0.242`.
    pub number: String,
    /// How it comes about, with the counts filled in.
    pub formula: String,
    /// The command that takes it apart.
    pub command: String,
    /// Index of its tracker among those shown sequence by sequence.
    pub tracker: Option<usize>,
    /// Index of its method with its grid point among those.
    pub method: Option<usize>,
    /// Index of the attribute of the sequences it is about; all sequences when `None`.
    pub attribute: Option<usize>,
}

/// The origins of a table's cells: groups, rows, cells.
pub type TableOrigins = Vec<Vec<Vec<Option<CellOrigin>>>>;

/// The origins of the cells of the experiment's own tables, whose layouts come first among `layouts`. `trackers` and
/// `shown` are what the page shows sequence by sequence;
/// `scores` are those of [`Results::scores`].
pub fn origins(
    results: &Results,
    scores: &[CellScore],
    layouts: &[TableLayout],
    trackers: &[String],
    shown: &Tallies,
) -> Vec<TableOrigins> {
    let place = |of: &[String], name: &str| of.iter().position(|known| known == name);
    let parts =
        measures::by_attribute(scores, &results.manifest.cells_failed, &results.manifest.suite.attributes);
    let all = [results.measures.as_slice(), &parts].concat();
    let mut counted: BTreeMap<_, &Measure> = BTreeMap::new();
    for m in &all {
        counted.entry((&m.tracker, &m.method, &m.params, &m.attribute)).or_insert(m);
    }
    let experiment = &results.experiment;
    let of_table = |(table, layout): (&Table, &TableLayout)| {
        // Tables of an analysis are made without events and detections.
        let spots = match table.shows {
            Some(_) => Vec::new(),
            None => layout::cell_refs(experiment, table, &all),
        };
        let mut places: BTreeMap<(&str, &str), Vec<&CellRef>> = BTreeMap::new();
        for spot in &spots {
            places.entry((&spot.row, &spot.column)).or_default().push(spot);
        }
        let name = format!("{}/{}", experiment.name, layout.name);
        let of_cell = |group: &Group, row: &str, column: &str, ours: Option<&str>| {
            let alike = places.get(&(row, column))?;
            let spot = *alike.iter().find(|s| group.has_ours && heads(&group.key, s))?;
            let measure = counted.get(&(&spot.tracker, &spot.method, &spot.params, &spot.attribute))?;
            let protocol = experiment.protocol_of(&spot.method);
            let method = method_label(&spot.method, &spot.params);
            let only = spot.attribute.as_ref().map_or_else(String::new, |a| format!(", only {a},"));
            Some(CellOrigin {
                number: format!(
                    "{} of {method} on {}{only} is {}",
                    spot.metric.title(),
                    spot.tracker,
                    ours.unwrap_or("without a value")
                ),
                formula: formula(spot.metric, measure.pooled.counts, protocol),
                command: command(&name, spot, alike),
                tracker: place(trackers, &spot.tracker),
                method: place(&shown.methods, &method),
                attribute: spot.attribute.as_ref().and_then(|a| place(&shown.attributes, a)),
            })
        };
        let of_group = |group: &Group| {
            let of_row = |row: &layout::Row| {
                let cells = row.cells.iter().zip(&layout.columns);
                cells
                    .map(|(cell, column)| of_cell(group, &row.label.name, &column.name, cell.ours.as_deref()))
                    .collect()
            };
            group.rows.iter().map(of_row).collect()
        };
        layout.groups.iter().map(of_group).collect()
    };
    experiment.tables.iter().zip(layouts).map(of_table).collect()
}

/// Whether the group of this name contains the cell: its name is some of the cell's tracker, method and grid point, in
/// this order, and possibly axes that the method does not have.
fn heads(key: &str, spot: &CellRef) -> bool {
    let axes: Vec<(String, f64)> = parse_point(&spot.params);
    let mut parts = vec![spot.tracker.clone(), spot.method.clone()];
    parts.extend(axes.iter().map(|(axis, value)| format!("{axis} = {value}")));
    let foreign = |part: &str| {
        part.split_once(" = ").is_some_and(|(axis, _)| axes.iter().all(|(known, _)| known != axis))
    };
    fn is_made_of(key: &str, parts: &[String], foreign: &dyn Fn(&str) -> bool) -> bool {
        let rest = |taken: usize| match key.get(taken..) {
            Some("") => Some(""),
            rest => rest?.strip_prefix(", "),
        };
        key.is_empty()
            || parts.iter().enumerate().any(|(k, part)| {
                key.starts_with(part.as_str())
                    && rest(part.len()).is_some_and(|rest| is_made_of(rest, &parts[k + 1..], foreign))
            })
            || {
                let first = key.split(", ").next().unwrap_or_default();
                foreign(first) && rest(first.len()).is_some_and(|rest| is_made_of(rest, parts, foreign))
            }
    }
    is_made_of(key, &parts, &foreign)
}

/// The command line that explains a cell; `alike` are all cells of the table in the same row and column.
fn command(table: &str, spot: &CellRef, alike: &[&CellRef]) -> String {
    let label = |s: &CellRef| method_label(&s.method, &s.params);
    let mut words = vec!["trackfail".to_string(), "explain".to_string(), quoted(table)];
    words.extend([quoted(&spot.row), quoted(&spot.column)]);
    if alike.iter().any(|s| s.tracker != spot.tracker) {
        words.extend(["--tracker".to_string(), quoted(&spot.tracker)]);
    }
    if alike.iter().any(|s| label(s) != label(spot)) {
        words.extend(["--method".to_string(), quoted(&label(spot))]);
    }
    words.join(" ")
}

/// A word quoted for a shell where it needs to be.
fn quoted(word: &str) -> String {
    let plain = |c: char| c.is_ascii_alphanumeric() || "_./@%+=:,-".contains(c);
    if !word.is_empty() && word.chars().all(plain) {
        return word.to_string();
    }
    format!("'{}'", word.replace('\'', "'\\''"))
}

#[cfg(test)]
mod tests {
    use super::*;
    use trackfail_methods::score::Metric;

    fn spot(tracker: &str, method: &str, params: &str) -> CellRef {
        let [row, column, tracker, method, params] =
            ["f_score", "M", tracker, method, params].map(String::from);
        CellRef { row, column, tracker, method, params, attribute: None, metric: Metric::F_SCORE }
    }

    #[test]
    fn a_group_is_known_by_its_name() {
        let s = spot("A, B", "M", "horizon=5;window=20");
        for key in ["", "A, B", "M", "A, B, M", "A, B, horizon = 5", "window = 20", "A, B, length = 3"] {
            assert!(heads(key, &s), "{key}");
        }
        for key in ["A", "A, BM", "M, A, B", "A, B, horizon = 50", "A, B, length", "A, B, M, M"] {
            assert!(!heads(key, &s), "{key}");
        }
    }

    #[test]
    fn commands_name_what_they_must_and_can_be_typed() {
        let (a, b, c) = (spot("A", "M", "x=1"), spot("B's", "M", "x=1"), spot("B's", "M", "x=2"));
        assert_eq!(command("q/t", &a, &[&a]), "trackfail explain q/t f_score M");
        assert_eq!(command("q/t", &a, &[&a, &b]), "trackfail explain q/t f_score M --tracker A");
        assert_eq!(
            command("q t", &c, &[&a, &b, &c]),
            r"trackfail explain 'q t' f_score M --tracker 'B'\''s' --method 'M[x=2]'"
        );
        assert_eq!(quoted(""), "''");
    }
}
