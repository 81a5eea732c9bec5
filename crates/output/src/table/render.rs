//! Tables as CSV, Parquet, Markdown and plain text.

use super::layout::{Cell, Group, LabelKind, Row, TableLayout};
use crate::results::rows::Rows;
use crate::results::{TableError, TableRow};
use trackfail_dataset::text::visible;

/// CSV of the table, one row for each cell. Fields are written unchanged, for programs. Names that a
/// spreadsheet would take for a formula (with `=`, `+`, `-` or `@` first) are refused when experiments are
/// read.
///
/// # Errors
/// An error of polars.
pub fn csv(layout: &TableLayout) -> Result<Vec<u8>, TableError> {
    TableRow::csv(&layout.data, rows(layout))
}

/// Parquet of the table, with the columns of [`csv`].
///
/// # Errors
/// An error of polars.
pub fn parquet(layout: &TableLayout) -> Result<Vec<u8>, TableError> {
    TableRow::parquet(&layout.data, rows(layout))
}

fn rows(layout: &TableLayout) -> impl Iterator<Item = TableRow<'_>> {
    layout.cells().map(|(group, row, column, cell)| TableRow {
        group: &group.key,
        published_tracker: group.published_tracker.as_deref(),
        row: &row.label.name,
        column: &column.name,
        ours: cell.value,
        published: cell.published.as_deref(),
        difference: cell.difference.as_deref(),
    })
}

/// Mark of the best number in its row or column. `TIED` marks one that others equal.
const BEST: &str = "*";
const TIED: &str = "=";

/// Lines of one row: ours, published and difference, as far as present. Each has a heading, and text and mark
/// for each cell; the mark is empty unless the cell is the best.
pub(super) fn lines(group: &Group, row: &Row) -> Vec<(String, Vec<(String, &'static str)>)> {
    let ours = |cell: &Cell| {
        let mark = if cell.tied { TIED } else { BEST };
        let failed = if cell.failed > 0 { "†" } else { "" };
        let text = cell.ours.as_ref().map_or_else(String::new, |text| format!("{text}{failed}"));
        (text, if cell.best { mark } else { "" })
    };
    let plain = |of: fn(&Cell) -> &Option<String>| -> Vec<(String, &'static str)> {
        row.cells.iter().map(|cell| (of(cell).clone().unwrap_or_default(), "")).collect()
    };
    let name = row.label.shown.trim_end_matches(['↑', '↓', ' ']);
    let mut lines = Vec::new();
    if group.has_ours {
        lines.push((row.label.shown.clone(), row.cells.iter().map(ours).collect()));
    }
    if row.cells.iter().any(|c| c.published.is_some()) {
        // With trackers as columns there is no one name.
        let who = group.published_tracker.as_deref().map_or_else(String::new, |who| format!(" ({who})"));
        lines.push((format!("{name} published{who}"), plain(|c| &c.published)));
        if row.cells.iter().any(|c| c.difference.is_some()) {
            lines.push((format!("{name} difference"), plain(|c| &c.difference)));
        }
    }
    lines
}

/// Escapes text so that Markdown shows it unchanged, on one line.
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

/// Markdown table for GitHub.
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
                        BEST => format!(" **{cell}** |"),
                        TIED => format!(" **{cell}** = |"),
                        _ => format!(" {cell} |"),
                    });
                }
                text.push('\n');
            }
        }
    }
    text
}

/// Aligned text for a terminal of this width and height: as many columns of results as fit, and a note on
/// what is left out.
pub fn plain(layout: &TableLayout, width: usize, height: usize) -> String {
    let all = 0..layout.columns.len();
    let mut shown: Vec<usize> =
        all.clone().filter(|k| layout.columns[*k].kind == LabelKind::Result).collect();
    if shown.is_empty() {
        shown = all.collect();
    }
    let mut lines = aligned(layout, &shown);
    while shown.len() > 1 && lines.iter().any(|line| line.chars().count() > width) {
        shown.pop();
        lines = aligned(layout, &shown);
    }
    let rows = lines.len().min(height);
    let mut text = format!("{}\n{}\n", wrapped(&told(&layout.caption), width), lines[..rows].join("\n"));
    let left_out = [(lines.len() - rows, "row"), (layout.columns.len() - shown.len(), "column")];
    let left_out = left_out.into_iter().filter(|(n, _)| *n > 0);
    let left_out = left_out.map(|(n, what)| format!("{n} more {what}{}", if n == 1 { "" } else { "s" }));
    let left_out: Vec<String> = left_out.collect();
    if !left_out.is_empty() {
        text.push_str(&format!(" ({} on the page)\n", left_out.join(" and ")));
    }
    text
}

/// Wraps a text into lines of at most `width` columns.
pub fn wrapped(text: &str, width: usize) -> String {
    let mut table = comfy_table::Table::new();
    table.load_preset(comfy_table::presets::NOTHING);
    table.set_content_arrangement(comfy_table::ContentArrangement::Dynamic);
    table.set_width(u16::try_from(width + 2).unwrap_or(u16::MAX)).add_row([text]);
    table.to_string().lines().map(str::trim).collect::<Vec<_>>().join("\n")
}

/// First sentence of a caption, and the sentence that explains its mark.
fn told(caption: &str) -> String {
    let mark = caption.find('†').map_or("", |mark| &caption[mark..]);
    let first = caption.find(". ").map_or(caption, |end| &caption[..=end]);
    if first.contains('†') { caption.to_string() } else { format!("{first} {mark}") }
}

fn aligned(layout: &TableLayout, shown: &[usize]) -> Vec<String> {
    let mut table = comfy_table::Table::new();
    table.load_preset(comfy_table::presets::NOTHING);
    let columns = shown.iter().map(|k| layout.columns[*k].shown.clone());
    table.set_header(std::iter::once(layout.corner.clone()).chain(columns));
    for group in &layout.groups {
        if !group.label.is_empty() {
            let name = if group.key.is_empty() { &group.label } else { &group.key };
            table.add_row(vec![name.clone()]);
        }
        for row in &group.rows {
            for (heading, cells) in lines(group, row) {
                let cell = |k: &usize| match cells.get(*k) {
                    Some((text, "")) => text.clone(),
                    Some((text, mark)) => format!("{text} {mark}"),
                    None => String::new(),
                };
                table.add_row(std::iter::once(heading).chain(shown.iter().map(cell)));
            }
        }
    }
    for column in table.column_iter_mut().skip(1) {
        column.set_cell_alignment(comfy_table::CellAlignment::Right);
    }
    table.to_string().lines().map(|line| line.trim_end().to_string()).collect()
}

#[cfg(test)]
pub(super) mod tests;
