//! A laid-out table as CSV, Parquet and Markdown, and for the terminal.

use super::layout::{Cell, Group, Row, TableLayout};
use crate::dataset::text::visible;
use crate::direction::Direction;
use crate::results::TableError;
use crate::results::tables::{self, TableRow};

/// The table as CSV, one row for each cell; see [`tables`].
///
/// # Errors
/// When polars refuses.
pub fn csv(layout: &TableLayout) -> Result<Vec<u8>, TableError> {
    tables::csv(&cells(layout), &layout.data)
}

/// The table as Parquet, with the columns of [`csv`].
///
/// # Errors
/// When polars refuses.
pub fn parquet(layout: &TableLayout) -> Result<Vec<u8>, TableError> {
    tables::parquet(&cells(layout), &layout.data)
}

fn cells(layout: &TableLayout) -> Vec<TableRow<'_>> {
    let mut cells = Vec::new();
    for group in &layout.groups {
        for row in &group.rows {
            for (cell, column) in row.cells.iter().zip(&layout.columns) {
                cells.push(TableRow {
                    group: &group.label,
                    published_tracker: group.published_tracker.as_deref(),
                    row: &row.label,
                    column,
                    ours: cell.value,
                    published: cell.published.as_deref(),
                    difference: cell.difference.as_deref(),
                });
            }
        }
    }
    cells
}

/// A row's heading with its direction.
pub fn row_heading(row: &Row) -> String {
    match row.direction {
        Direction::HigherIsBetter => format!("{} ↑", row.label),
        Direction::LowerIsBetter => format!("{} ↓", row.label),
        Direction::Neither => row.label.clone(),
    }
}

fn ours(cell: &Cell) -> String {
    let mark = if cell.failed > 0 { "†" } else { "" };
    cell.ours.as_ref().map_or(String::new(), |text| format!("{text}{mark}"))
}

/// The lines of one row: ours, published, difference, each with its heading, where there is any.
pub(super) fn lines<'a>(group: &'a Group, row: &'a Row) -> Vec<(String, Vec<(String, bool)>)> {
    let mut lines = Vec::new();
    if group.has_ours {
        lines.push((row_heading(row), row.cells.iter().map(|c| (ours(c), c.best)).collect()));
    }
    if row.cells.iter().any(|c| c.published.is_some()) {
        let who = group.published_tracker.as_deref().unwrap_or_default();
        let plain = |f: &dyn Fn(&Cell) -> Option<String>| {
            row.cells.iter().map(|c| (f(c).unwrap_or_default(), false)).collect::<Vec<_>>()
        };
        lines.push((format!("{} published ({who})", row.label), plain(&|c| c.published.clone())));
        if row.cells.iter().any(|c| c.difference.is_some()) {
            lines.push((format!("{} difference", row.label), plain(&|c| c.difference.clone())));
        }
    }
    lines
}

/// Text that Markdown shows as it is, on one line.
pub fn markdown_escape(raw: &str) -> String {
    let mut out = String::with_capacity(raw.len());
    for c in visible(raw).chars() {
        match c {
            '&' => out.push_str("&amp;"),
            '<' => out.push_str("&lt;"),
            '>' => out.push_str("&gt;"),
            // GitHub splits table cells before it reads code spans or backslashes of other
            // characters, so a bar is written as a reference.
            '|' => out.push_str("&#124;"),
            '\\' | '`' | '*' | '_' | '[' | ']' | '#' | '~' | '$' | '!' => {
                out.push('\\');
                out.push(c);
            }
            c => out.push(c),
        }
    }
    out.trim().to_owned()
}

/// A GitHub table.
pub fn markdown(layout: &TableLayout) -> String {
    let escape = markdown_escape;
    let mut text = format!("**{}**\n\n| {} |", escape(&layout.caption), escape(&layout.corner));
    for column in &layout.columns {
        text.push_str(&format!(" {} |", escape(column)));
    }
    text.push_str("\n|:--|");
    text.push_str(&"--:|".repeat(layout.columns.len()));
    text.push('\n');
    for group in &layout.groups {
        if !group.label.is_empty() {
            let empty = " |".repeat(layout.columns.len());
            text.push_str(&format!("| **{}** |{empty}\n", escape(&group.label)));
        }
        for row in &group.rows {
            for (heading, cells) in lines(group, row) {
                text.push_str(&format!("| {} |", escape(&heading)));
                for (cell, best) in cells {
                    let cell = escape(&cell);
                    text.push_str(&if best { format!(" **{cell}** |") } else { format!(" {cell} |") });
                }
                text.push('\n');
            }
        }
    }
    text
}

/// Aligned text for the terminal.
pub fn plain(layout: &TableLayout) -> String {
    let mut table = comfy_table::Table::new();
    table.load_preset(comfy_table::presets::NOTHING);
    table.set_header(std::iter::once(layout.corner.clone()).chain(layout.columns.iter().cloned()));
    for group in &layout.groups {
        if !group.label.is_empty() {
            table.add_row(vec![group.label.clone()]);
        }
        for row in &group.rows {
            for (heading, cells) in lines(group, row) {
                let cells =
                    cells.into_iter().map(|(text, best)| if best { format!("{text} *") } else { text });
                table.add_row(std::iter::once(heading).chain(cells));
            }
        }
    }
    for column in table.column_iter_mut().skip(1) {
        column.set_cell_alignment(comfy_table::CellAlignment::Right);
    }
    let text = table.to_string();
    let lines: Vec<&str> = text.lines().map(str::trim_end).collect();
    format!("{}\n{}\n", layout.caption, lines.join("\n"))
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;

    pub fn sample() -> TableLayout {
        let cell = |ours: &str, published: &str, best| Cell {
            value: ours.parse().ok(),
            ours: Some(ours.into()),
            published: Some(published.into()),
            difference: Some("+.010".into()),
            best,
            second: false,
            failed: usize::from(best),
        };
        TableLayout {
            name: "table1".into(),
            caption: "A & B_1. 12 of 21 targets.".into(),
            data: "12 of 21 targets".into(),
            corner: "metric".into(),
            columns: vec!["DT|EF".into(), "ARTE*".into()],
            groups: vec![Group {
                label: "Struck (3 events)".into(),
                key: "Struck".into(),
                published_tracker: Some("SP".into()),
                has_ours: true,
                rows: vec![Row {
                    label: "precision".into(),
                    direction: Direction::HigherIsBetter,
                    cells: vec![cell(".120", ".110", true), cell(".100", ".090", false)],
                }],
            }],
        }
    }

    #[test]
    fn markdown_shows_ours_published_and_difference() {
        let expected = "\
**A &amp; B\\_1. 12 of 21 targets.**

| metric | DT&#124;EF | ARTE\\* |
|:--|--:|--:|
| **Struck (3 events)** | | |
| precision ↑ | **.120†** | .100 |
| precision published (SP) | .110 | .090 |
| precision difference | +.010 | +.010 |
";
        assert_eq!(markdown(&sample()), expected);
    }

    #[test]
    fn csv_has_a_line_a_cell() {
        let text = String::from_utf8(csv(&sample()).unwrap()).unwrap();
        assert_eq!(
            text,
            "group,published_tracker,row,column,ours,published,difference,data\n\
             Struck (3 events),SP,precision,DT|EF,0.12,.110,+.010,12 of 21 targets\n\
             Struck (3 events),SP,precision,ARTE*,0.1,.090,+.010,12 of 21 targets\n"
        );
    }
}
