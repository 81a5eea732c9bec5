//! Tables as CSV, Parquet, Markdown and plain text.

use super::layout::{Cell, Group, LabelKind, Row, TableLayout};
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

/// Aligned text for a terminal of so many columns and rows: columns of results, from the first on, and what is left out.
pub fn plain(layout: &TableLayout, width: usize, height: usize) -> String {
    let is_result = |k: &usize| layout.columns[*k].kind == LabelKind::Result;
    let mut shown: Vec<usize> = (0..layout.columns.len()).filter(is_result).collect();
    if shown.is_empty() {
        shown = (0..layout.columns.len()).collect();
    }
    let mut all = aligned(layout, &shown);
    while shown.len() > 1 && all.iter().any(|line| line.chars().count() > width) {
        shown.pop();
        all = aligned(layout, &shown);
    }
    let rows = all.len().min(height);
    let mut text = format!("{}\n{}\n", wrapped(&told(&layout.caption), width), all[..rows].join("\n"));
    let left_out = [(all.len() - rows, "row"), (layout.columns.len() - shown.len(), "column")];
    let left_out = left_out
        .iter()
        .filter(|(n, _)| *n > 0)
        .map(|(n, what)| format!("{n} more {what}{}", if *n == 1 { "" } else { "s" }));
    let left_out: Vec<String> = left_out.collect();
    if !left_out.is_empty() {
        text.push_str(&format!(" ({} on the page)\n", left_out.join(" and ")));
    }
    text
}

/// A text in lines of so many columns.
pub fn wrapped(text: &str, width: usize) -> String {
    let mut table = comfy_table::Table::new();
    table.load_preset(comfy_table::presets::NOTHING);
    table.set_content_arrangement(comfy_table::ContentArrangement::Dynamic);
    table.set_width(u16::try_from(width + 2).unwrap_or(u16::MAX)).add_row([text]);
    table.to_string().lines().map(str::trim).collect::<Vec<_>>().join("\n")
}

/// The first sentence of a caption, and that of its mark.
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
                    Some((text, Mark::Plain)) => text.clone(),
                    Some((text, Mark::Best)) => format!("{text} *"),
                    Some((text, Mark::Tied)) => format!("{text} ="),
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
