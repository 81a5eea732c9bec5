//! Tables that show what an analysis found.

use super::{Cell, Group, Label, Row, TableLayout, mark_best, printed_for, published_for};
use crate::table::number::{Style, four_digits, printed_value, style_of_column};
use crate::table::suites::{suites_note, tracker_note};
use trackfail_core::direction::Direction;
use trackfail_engine::execute::analyse::Analysed;
use trackfail_engine::spec::Experiment;
use trackfail_engine::spec::table::{FindingName, Published, Table};
use trackfail_methods::analysis::Grid;
use trackfail_methods::score::TrackerMetric;

/// Makes a table of an analysis, with a group for each tracker.
pub fn analysed(
    experiment: &Experiment,
    table: &Table,
    shows: &FindingName,
    analyses: &[Analysed],
    data_note: &str,
) -> TableLayout {
    let published: Vec<&Published> = experiment.published.iter().filter(|p| p.table == table.name).collect();
    let found: Vec<(&Analysed, &Grid)> = analyses
        .iter()
        .filter(|a| a.analysis == shows.analysis)
        .filter_map(|a| Some((a, a.findings.tables.iter().find(|t| t.name == shows.part)?)))
        .collect();
    let single = found.len() == 1;
    // A column has one rounding for all trackers.
    let of_column = |k: usize| {
        let rows = found.iter().flat_map(|(_, grid)| &grid.rows);
        style_of_column(rows.filter_map(move |(_, values)| values.get(k).copied().flatten()))
    };
    let widest = found.iter().map(|(_, grid)| grid.columns.len()).max().unwrap_or(0);
    let of_columns: Vec<Option<Style>> = (0..widest).map(of_column).collect();
    let group = |(analysed, grid): &(&Analysed, &Grid)| {
        let source = published_for(&published, Some(&analysed.tracker), experiment);
        let row = |(label, values): &(String, Vec<Option<f64>>)| {
            let printed = |column: &str| {
                let mine = published.iter().filter(|p| Some(p.tracker.as_str()) == source && p.row == *label);
                let mut values = mine.flat_map(|p| &p.values);
                values.find(|(c, _)| c == column).map(|(_, text)| text.clone())
            };
            let style = grid.columns.iter().find_map(|c| printed(c)).map(|text| Style::of(&text));
            let cell = |(k, (column, value)): (usize, (&String, &Option<f64>))| {
                let style = style.or(of_columns[k]);
                let published = printed(column);
                let number = published.as_deref().and_then(printed_value);
                let shown = |v: f64| style.map_or_else(|| four_digits(v), |s| s.format(v));
                let difference =
                    value.zip(number).zip(style).map(|((v, p), s)| s.format_signed(s.round(v) - p));
                Cell { value: *value, ours: value.map(shown), published, difference, ..Cell::default() }
            };
            let cells = grid.columns.iter().zip(values).enumerate().map(cell).collect();
            Row { label: label.as_str().into(), direction: Direction::Neither, cells }
        };
        Group {
            key: analysed.tracker.clone(),
            label: if single { String::new() } else { tracker_note(analysed) },
            published_tracker: source.map(|label| printed_for(experiment, label)),
            has_ours: true,
            rows: grid.rows.iter().map(row).collect(),
        }
    };
    let mut groups: Vec<Group> = found.iter().map(group).collect();
    let columns = found.first().map_or_else(Vec::new, |(_, grid)| grid.columns.clone());
    let mut headings: Vec<Label> = columns.iter().map(|c| heading(c)).collect();
    let mut caption = table.caption.clone().unwrap_or_else(|| experiment.title.clone());
    if let Some(column) = &table.column {
        let place = columns.iter().position(|known| known == column);
        let mut rows = place.map_or_else(Vec::new, |k| side_by_side(&groups, k));
        let style = place.and_then(|k| of_columns[k]).unwrap_or(Style::DEFAULT);
        rows.iter_mut().for_each(|row| mark_best(&mut row.cells, direction(column), style, |_| false));
        caption.push_str(&match place {
            Some(_) => format!(": {column}"),
            None => format!(" (there is no column `{column}`, only {})", columns.join(", ")),
        });
        headings = found.iter().map(|(analysed, _)| tracker_heading(analysed)).collect();
        groups = vec![Group { rows, ..ungrouped() }];
    } else if found.iter().all(|(_, grid)| matches!(grid.rows.as_slice(), [(label, _)] if label.is_empty())) {
        let named = |(mut group, (analysed, _)): (Group, &(&Analysed, &Grid))| {
            group.rows.iter_mut().for_each(|row| row.label = tracker_heading(analysed));
            group.rows
        };
        let mut rows: Vec<Row> = groups.into_iter().zip(&found).flat_map(named).collect();
        for (k, column) in columns.iter().enumerate() {
            mark_best_of_column(&mut rows, k, direction(column), of_columns[k].unwrap_or(Style::DEFAULT));
        }
        groups = vec![Group { rows, ..ungrouped() }];
    }
    let suites = found.first().map_or_else(String::new, |(a, _)| suites_note(a));
    let is_whole = found.iter().all(|(a, _)| a.shares.is_empty());
    if !caption.ends_with('.') {
        caption.push('.');
    }
    TableLayout {
        name: table.name.clone(),
        caption: format!("{caption} Suites: {suites}; {data_note}."),
        data: if is_whole { data_note.to_string() } else { format!("{suites}; {data_note}") },
        corner: found.first().map_or_else(String::new, |(_, grid)| grid.corner.clone()),
        columns: headings,
        latex: table.latex.clone(),
        groups,
    }
}

/// Whether larger or smaller is better in a column, where it is a metric of trackers.
fn direction(column: &str) -> Direction {
    TrackerMetric::of_heading(column).map_or(Direction::Neither, |m| m.direction)
}

/// Marks the best cells and the second best one of column `k`, where rows are trackers.
fn mark_best_of_column(rows: &mut [Row], k: usize, direction: Direction, style: Style) {
    let mut cells: Vec<Cell> = rows.iter().filter_map(|row| row.cells.get(k).cloned()).collect();
    if cells.len() == rows.len() {
        mark_best(&mut cells, direction, style, |_| false);
        rows.iter_mut().zip(cells).for_each(|(row, cell)| row.cells[k] = cell);
    }
}

/// The heading of a column, with an arrow where it is a metric of trackers that has a direction.
fn heading(column: &str) -> Label {
    let arrow = match direction(column) {
        Direction::HigherIsBetter => " ↑",
        Direction::LowerIsBetter => " ↓",
        Direction::Neither => "",
    };
    Label { shown: format!("{column}{arrow}"), ..column.into() }
}

/// The heading of a tracker's row or column.
fn tracker_heading(analysed: &Analysed) -> Label {
    Label { shown: tracker_note(analysed), ..analysed.tracker.as_str().into() }
}

/// A group without heading and rows, for all trackers together.
fn ungrouped() -> Group {
    Group {
        label: String::new(),
        key: String::new(),
        published_tracker: None,
        has_ours: true,
        rows: Vec::new(),
    }
}

/// Puts column `k` of every group side by side; rows in the order in which they first occur.
fn side_by_side(groups: &[Group], k: usize) -> Vec<Row> {
    let mut rows: Vec<Row> = Vec::new();
    for row in groups.iter().flat_map(|g| &g.rows) {
        if rows.iter().all(|known| known.label != row.label) {
            let of_group = |g: &Group| {
                let mine = g.rows.iter().find(|r| r.label == row.label);
                mine.and_then(|r| r.cells.get(k).cloned()).unwrap_or_default()
            };
            rows.push(Row { cells: groups.iter().map(of_group).collect(), ..row.clone() });
        }
    }
    rows
}

#[cfg(test)]
mod tests {
    use super::*;

    // As printed with one decimal .52 and .48 are equal; fewer failures are better.
    #[test]
    fn the_best_tracker_of_a_column_is_marked_as_it_is_printed() {
        let cell = |value: f64| Cell { value: Some(value), ..Cell::default() };
        let row = |values: [f64; 2]| Row {
            label: "tracker".into(),
            direction: Direction::Neither,
            cells: values.map(cell).to_vec(),
        };
        let mut rows = vec![row([0.52, 3.0]), row([0.48, 1.0]), row([0.3, 2.0])];
        let style = Style { decimals: 1, ..Style::DEFAULT };
        mark_best_of_column(&mut rows, 0, direction("success AUC"), style);
        mark_best_of_column(&mut rows, 1, direction("failures"), Style::COUNT);
        let marks =
            |k: usize| rows.iter().map(move |r| (r.cells[k].best, r.cells[k].tied, r.cells[k].second));
        let tie = (true, true, false);
        assert!(marks(0).eq([tie, tie, (false, false, false)]), "{rows:?}");
        assert!(marks(1).eq([(false, false, false), (true, false, false), (false, false, true)]), "{rows:?}");
        assert_eq!(direction("frames"), Direction::Neither);
    }
}
