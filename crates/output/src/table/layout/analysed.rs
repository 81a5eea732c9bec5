//! Tables of the findings of an analysis.

use super::printed::Printed;
use super::{Cell, Group, Label, TableLayout, arrow, mark_best, sentence};
use crate::table::build;
use crate::table::number::{Style, style_of_column};
use crate::table::suites::{suites_note, tracker_note};
use trackfail_core::direction::Direction;
use trackfail_engine::execute::analyse::Analysed;
use trackfail_engine::spec::Experiment;
use trackfail_engine::spec::table::{FindingName, Table};
use trackfail_methods::analysis::Grid;
use trackfail_methods::score::TrackerMetric;

/// Heading and cells of a row.
type Row = (Label, Vec<Cell>);

/// Makes a table of an analysis, with one group for each tracker.
pub fn analysed(
    experiment: &Experiment,
    table: &Table,
    shows: &FindingName,
    analyses: &[Analysed],
    data_note: &str,
) -> TableLayout {
    let printed = Printed::of(experiment, table);
    let found = analyses.iter().filter(|a| a.analysis == shows.analysis);
    let found = found.filter_map(|a| Some((a, a.findings.tables.iter().find(|t| t.name == shows.part)?)));
    let found: Vec<(&Analysed, &Grid)> = found.collect();
    // A column has one rounding for all trackers.
    let style = |k: usize| {
        let rows = found.iter().flat_map(|(_, grid)| &grid.rows);
        style_of_column(rows.filter_map(move |(_, values)| values.get(k).copied().flatten()))
    };
    let widest = found.iter().map(|(_, grid)| grid.columns.len()).max().unwrap_or(0);
    let styles: Vec<Option<Style>> = (0..widest).map(style).collect();
    let rows = |(analysed, grid): &(&Analysed, &Grid)| -> Vec<Row> {
        let source = printed.beside(Some(&analysed.tracker));
        let row = |(label, values): &(String, Vec<Option<f64>>)| -> Row {
            let texts: Vec<Option<&str>> =
                grid.columns.iter().map(|column| printed.text(source, label, column)).collect();
            let of_row = texts.iter().flatten().next().map(|text| Style::of(text));
            let cells = values.iter().zip(&texts).zip(&styles);
            let cells = cells.map(|((value, text), style)| printed.cell(*value, of_row.or(*style), *text));
            (label.as_str().into(), cells.collect())
        };
        grid.rows.iter().map(row).collect()
    };
    let columns = found.first().map_or_else(Vec::new, |(_, grid)| grid.columns.clone());
    let mut headings: Vec<Label> = columns.iter().map(|c| heading(c)).collect();
    let mut caption = table.caption.as_ref().unwrap_or(&experiment.title).clone();
    let is_one_row =
        |(_, grid): &(&Analysed, &Grid)| matches!(grid.rows.as_slice(), [(label, _)] if label.is_empty());
    let groups = if let Some(column) = &table.column {
        headings = found.iter().map(|(analysed, _)| tracker_heading(analysed)).collect();
        let place = columns.iter().position(|known| known == column);
        caption.push_str(&match place {
            Some(_) => format!(": {column}"),
            None => format!(" (there is no column `{column}`, only {})", columns.join(", ")),
        });
        let of_trackers: Vec<Vec<Row>> = found.iter().map(rows).collect();
        let mut rows = place.map_or_else(Vec::new, |k| side_by_side(&of_trackers, k));
        rows.iter_mut().for_each(|(_, cells)| mark_best(cells.iter_mut(), direction(column), |_, _| true));
        vec![build::group("", String::new(), rows)]
    } else if found.iter().all(is_one_row) {
        let named = |one: &(&Analysed, &Grid)| -> Vec<Row> {
            rows(one).into_iter().map(|(_, cells)| (tracker_heading(one.0), cells)).collect()
        };
        let mut rows: Vec<Row> = found.iter().flat_map(named).collect();
        for (k, column) in columns.iter().enumerate() {
            let cells = rows.iter_mut().filter_map(|(_, cells)| cells.get_mut(k));
            mark_best(cells, direction(column), |_, _| true);
        }
        vec![build::group("", String::new(), rows)]
    } else {
        let group = |one: &(&Analysed, &Grid)| {
            let label = if found.len() == 1 { String::new() } else { tracker_note(one.0) };
            let published_tracker = printed.beside(Some(&one.0.tracker)).map(|label| printed.name(label));
            Group { published_tracker, ..build::group(&one.0.tracker, label, rows(one)) }
        };
        found.iter().map(group).collect()
    };
    let suites = found.first().map_or_else(String::new, |(a, _)| suites_note(a));
    let is_whole = found.iter().all(|(a, _)| a.shares.is_empty());
    let caption = format!("{} Suites: {suites}; {data_note}.", sentence(caption));
    let corner = found.first().map_or("", |(_, grid)| grid.corner.as_str());
    TableLayout {
        data: if is_whole { data_note.to_string() } else { format!("{suites}; {data_note}") },
        latex: table.latex.clone(),
        ..build::table(&table.name, caption, corner, headings, groups)
    }
}

/// Direction in which values of a column are better; only for metrics of trackers.
fn direction(column: &str) -> Direction {
    TrackerMetric::of_heading(column).map_or(Direction::Neither, |m| m.direction)
}

/// Heading of a column, with an arrow if it is a metric of trackers with a direction.
fn heading(column: &str) -> Label {
    Label { shown: format!("{column}{}", arrow(direction(column))), ..column.into() }
}

/// Heading of a tracker's row or column.
fn tracker_heading(analysed: &Analysed) -> Label {
    Label { shown: tracker_note(analysed), ..analysed.tracker.as_str().into() }
}

/// Column `k` of all trackers side by side. Rows are in order of first occurrence.
fn side_by_side(of_trackers: &[Vec<Row>], k: usize) -> Vec<Row> {
    let mut rows: Vec<Row> = Vec::new();
    for (label, _) in of_trackers.iter().flatten() {
        if rows.iter().all(|(known, _)| known != label) {
            let cell = |of_tracker: &Vec<Row>| -> Cell {
                let mine = of_tracker.iter().find(|(known, _)| known == label);
                mine.and_then(|(_, cells)| cells.get(k).cloned()).unwrap_or_default()
            };
            rows.push((label.clone(), of_trackers.iter().map(cell).collect()));
        }
    }
    rows
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn columns_have_the_direction_of_their_metric() {
        let directions = ["success AUC", "failures", "frames"].map(direction);
        assert_eq!(directions, [Direction::HigherIsBetter, Direction::LowerIsBetter, Direction::Neither]);
    }
}
