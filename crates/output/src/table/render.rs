//! Tables as CSV, Parquet, Markdown and plain text.

use super::layout::{Cell, Group, Row, TableLayout};
use crate::results::TableError;
use crate::results::tables::{self, TableRow};
use trackfail_dataset::text::visible;

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
                    group: &group.key,
                    published_tracker: group.published_tracker.as_deref(),
                    row: &row.label.name,
                    column: &column.name,
                    ours: cell.value,
                    published: cell.published.as_deref(),
                    difference: cell.difference.as_deref(),
                });
            }
        }
    }
    cells
}

fn ours(cell: &Cell) -> String {
    let mark = if cell.failed > 0 { "†" } else { "" };
    cell.ours.as_ref().map_or(String::new(), |text| format!("{text}{mark}"))
}

/// How a number stands among those of its row.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Mark {
    Plain,
    Best,
    Tied,
}

impl Mark {
    fn of(cell: &Cell) -> Self {
        match (cell.best, cell.tied) {
            (true, true) => Self::Tied,
            (true, false) => Self::Best,
            (false, _) => Self::Plain,
        }
    }
}

/// The lines of one row: ours, published and difference, as far as there are any. Each has its heading, and for every
/// cell its text and whether it is the best.
pub(super) fn lines<'a>(group: &'a Group, row: &'a Row) -> Vec<(String, Vec<(String, Mark)>)> {
    let mut lines = Vec::new();
    if group.has_ours {
        let cells = row.cells.iter().map(|c| (ours(c), Mark::of(c)));
        lines.push((row.label.shown.clone(), cells.collect()));
    }
    if row.cells.iter().any(|c| c.published.is_some()) {
        // With trackers as columns there is no one name.
        let who = group.published_tracker.as_deref().map_or_else(String::new, |who| format!(" ({who})"));
        let plain = |f: &dyn Fn(&Cell) -> Option<String>| {
            row.cells.iter().map(|c| (f(c).unwrap_or_default(), Mark::Plain)).collect::<Vec<_>>()
        };
        let name = row.label.shown.trim_end_matches(['↑', '↓', ' ']);
        lines.push((format!("{name} published{who}"), plain(&|c| c.published.clone())));
        if row.cells.iter().any(|c| c.difference.is_some()) {
            lines.push((format!("{name} difference"), plain(&|c| c.difference.clone())));
        }
    }
    lines
}

/// Escapes text so that Markdown shows it as it is, on one line.
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
        text.push_str(&format!(" {} |", escape(&column.shown)));
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
                for (cell, mark) in cells {
                    let cell = escape(&cell);
                    text.push_str(&match mark {
                        Mark::Plain => format!(" {cell} |"),
                        Mark::Best => format!(" **{cell}** |"),
                        Mark::Tied => format!(" **{cell}** = |"),
                    });
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
    let columns = layout.columns.iter().map(|c| c.shown.clone());
    table.set_header(std::iter::once(layout.corner.clone()).chain(columns));
    for group in &layout.groups {
        if !group.label.is_empty() {
            table.add_row(vec![group.label.clone()]);
        }
        for row in &group.rows {
            for (heading, cells) in lines(group, row) {
                let cells = cells.into_iter().map(|(text, mark)| match mark {
                    Mark::Plain => text,
                    Mark::Best => format!("{text} *"),
                    Mark::Tied => format!("{text} ="),
                });
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
pub(super) mod tests;
