//! A laid-out table as CSV, Parquet and Markdown, and for the terminal.

use super::frame::{self, FrameError};
use super::layout::{Cell, Group, Layout, Row};
use crate::dataset::text::visible;
use crate::direction::Direction;
use polars::prelude::{Column, DataFrame};

/// `group,published_tracker,row,column,ours,published,difference,data`, one line a cell. `ours` has all its
/// digits, `published` is the text as printed, `data` what all of them rest on: a CSV file has no caption.
///
/// Fields are written as they are, for programs. That a spreadsheet finds no formula in them is seen to
/// where names come in: none begins with one of `=`, `+`, `-`, `@`, and published texts are numbers.
///
/// # Errors
/// When polars refuses.
pub fn csv(layout: &Layout) -> Result<Vec<u8>, FrameError> {
    frame::to_csv(&mut cells(layout)?)
}

/// The columns of [`csv`] as Parquet: `ours` is a number, all others are texts.
///
/// # Errors
/// When polars refuses.
pub fn parquet(layout: &Layout) -> Result<Vec<u8>, FrameError> {
    frame::to_parquet(&mut cells(layout)?)
}

fn cells(layout: &Layout) -> Result<DataFrame, FrameError> {
    let mut cells: Vec<Placed<'_>> = Vec::new();
    for group in &layout.groups {
        for row in &group.rows {
            for (cell, column) in row.cells.iter().zip(&layout.columns) {
                cells.push(Placed { group, row, column, cell });
            }
        }
    }
    let text = |f: fn(&Placed<'_>) -> Option<String>| cells.iter().map(f).collect::<Vec<_>>();
    frame::frame(vec![
        Column::new("group".into(), text(|c| filled(&c.group.label))),
        Column::new("published_tracker".into(), text(|c| c.group.published_tracker.clone())),
        Column::new("row".into(), text(|c| filled(&c.row.label))),
        Column::new("column".into(), text(|c| filled(c.column))),
        Column::new("ours".into(), cells.iter().map(|c| c.cell.value).collect::<Vec<_>>()),
        Column::new("published".into(), text(|c| c.cell.published.clone())),
        Column::new("difference".into(), text(|c| c.cell.difference.clone())),
        Column::new("data".into(), vec![layout.data.as_str(); cells.len()]),
    ])
}

/// A cell with what it belongs to.
struct Placed<'a> {
    group: &'a Group,
    row: &'a Row,
    column: &'a str,
    cell: &'a Cell,
}

fn filled(text: &str) -> Option<String> {
    (!text.is_empty()).then(|| text.to_string())
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
pub fn markdown(layout: &Layout) -> String {
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
pub fn plain(layout: &Layout) -> String {
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

    pub fn sample() -> Layout {
        let cell = |ours: &str, published: &str, best| Cell {
            value: ours.parse().ok(),
            ours: Some(ours.into()),
            published: Some(published.into()),
            difference: Some("+.010".into()),
            best,
            second: false,
            failed: usize::from(best),
        };
        Layout {
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
    #[test]
    fn parquet_has_the_columns_of_the_csv_file() {
        let bytes = parquet(&sample()).unwrap();
        assert_eq!(bytes, parquet(&sample()).unwrap());
        let columns =
            ["group", "published_tracker", "row", "column", "ours", "published", "difference", "data"];
        let table = frame::from_parquet(bytes, &columns).unwrap();
        assert_eq!(frame::floats(&table, "ours").unwrap(), [0.12, 0.1]);
        assert_eq!(frame::texts(&table, "published").unwrap(), [".110", ".090"]);
        let empty = Layout { groups: Vec::new(), ..sample() };
        assert!(frame::from_parquet(parquet(&empty).unwrap(), &columns).unwrap().height() == 0);
    }
}
