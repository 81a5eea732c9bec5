//! Lists on stdout: a table for people, or CSV or JSON for programs.

pub mod replace;

use super::Failure;
use crate::dataset::text::is_plain;
use crate::results;
use comfy_table::{CellAlignment, ContentArrangement, Table, presets};
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use serde_json::{Map, Value};
use std::io::Write;

/// How a list is printed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, clap::ValueEnum)]
pub enum Format {
    /// Aligned columns.
    #[default]
    Table,
    /// Comma-separated values with a header.
    Csv,
    /// An array of objects.
    Json,
}

/// Prints rows under headings. A closed pipe is not an error. On a terminal, a table has the terminal's
/// width, with long fields on several lines.
///
/// # Errors
/// When stdout cannot be written to.
pub fn print(format: Format, headings: &[&str], rows: &[Vec<String>]) -> Result<(), Failure> {
    match (format, terminal_size::terminal_size_of(std::io::stdout())) {
        (Format::Table, Some((width, _))) => write(&table(headings, rows, &[], Some(width.0))),
        _ => write(&text(format, headings, rows)?),
    }
}

/// Table of rows under headings, at most `width` columns wide. The columns `numbers` are right-aligned.
pub fn table(headings: &[&str], rows: &[Vec<String>], numbers: &[usize], width: Option<u16>) -> String {
    let mut table = Table::new();
    table.load_preset(presets::NOTHING).set_header(headings.iter().copied()).add_rows(rows);
    if let Some(width) = width {
        table.set_content_arrangement(ContentArrangement::Dynamic).set_width(width);
    }
    for column in numbers {
        if let Some(column) = table.column_mut(*column) {
            column.set_cell_alignment(CellAlignment::Right);
        }
    }
    table.trim_fmt() + "\n"
}

/// Text of rows under headings, in a format.
///
/// # Errors
/// When the rows do not fit the headings.
pub fn text(format: Format, headings: &[&str], rows: &[Vec<String>]) -> Result<String, Failure> {
    Ok(match format {
        Format::Table => table(headings, rows, &[], None),
        Format::Csv => {
            let bytes = results::texts_to_csv(headings, rows);
            String::from_utf8_lossy(&bytes.map_err(Failure::io)?).into_owned()
        }
        Format::Json => {
            let fields = |row: &Vec<String>| {
                headings.iter().zip(row).map(|(h, v)| (h.to_string(), json(h, v))).collect()
            };
            let objects: Vec<Map<String, Value>> = rows.iter().map(fields).collect();
            serde_json::to_string_pretty(&objects).map_err(Failure::io)? + "\n"
        }
    })
}

/// Headings of columns whose values are names, even if a name looks like a number.
const NAMES: [&str; 8] = ["experiment", "suite", "sequence", "tracker", "method", "params", "kind", "title"];

/// A field as JSON: null for a missing value, else a number or a text. Names are always texts.
fn json(heading: &str, field: &str) -> Value {
    if field.is_empty() {
        return Value::Null;
    }
    if NAMES.contains(&heading) {
        return field.into();
    }
    match (field.parse::<i64>(), field.parse::<f64>()) {
        (Ok(n), _) => n.into(),
        (_, Ok(v)) if v.is_finite() => v.into(),
        _ => field.into(),
    }
}

/// Quotes a word for a shell.
pub fn quoted(word: &str) -> String {
    format!("'{}'", word.replace('\'', r"'\''"))
}

/// Makes text safe for a terminal: lines stay, but characters that move the cursor, change colors or turn the
/// reading direction are replaced. Names and messages come from files that anybody may have written.
pub fn for_terminal(text: &str) -> String {
    text.chars().map(|c| if c == '\n' || c == '\t' || is_plain(c) { c } else { '\u{fffd}' }).collect()
}

/// Writes text to stdout, made safe by [`for_terminal`] even if stdout is not a terminal, so that a pipe gets
/// what a user would see. A closed pipe ends quietly.
///
/// # Errors
/// When stdout cannot be written to.
pub fn write(text: &str) -> Result<(), Failure> {
    let mut out = std::io::stdout().lock();
    written(out.write_all(for_terminal(text).as_bytes()).and_then(|()| out.flush()))
}

/// Result of writing to stdout, in which a closed pipe is not an error.
///
/// # Errors
/// When stdout cannot be written to.
pub fn written(result: std::io::Result<()>) -> Result<(), Failure> {
    match result {
        Err(e) if e.kind() == std::io::ErrorKind::BrokenPipe => Ok(()),
        done => done.map_err(|e| Failure::io(format!("stdout: {e}"))),
    }
}

/// Prints a line on stderr, made safe by [`for_terminal`].
pub fn note(line: &str) {
    // Nobody is left to tell when stderr is closed.
    let _ = writeln!(std::io::stderr(), "{}", for_terminal(line));
}

/// Progress bar on stderr, if that is a terminal; `more` is an indicatif template for the text after the bar.
pub fn progress_bar(name: &str, more: &str) -> ProgressBar {
    let bar = ProgressBar::with_draw_target(None, ProgressDrawTarget::stderr()).with_prefix(name.to_string());
    match ProgressStyle::with_template(&format!("{{prefix}} {{wide_bar}} {more}")) {
        Ok(style) => bar.with_style(style),
        Err(_) => bar,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_table_fits_the_terminal_and_keeps_every_word() {
        let summary =
            "forecasts the signal with an ARMA model; alarm when the forecast is off by the threshold";
        let rows = [["arma-forecast", "1", summary, "horizon, order, scheme, start, threshold, window"]];
        let rows = rows.map(|row| row.map(str::to_string).to_vec());
        let headings = ["kind", "version", "summary", "parameters"];
        for width in [60, 80, 132] {
            let shown = table(&headings, &rows, &[], Some(width));
            assert!(shown.lines().all(|line| line.chars().count() <= usize::from(width)), "{shown}");
            assert!(shown.contains("arma-forecast") && shown.lines().count() > 2, "{shown}");
            summary.split(' ').for_each(|word| assert!(shown.contains(word), "{word}\n{shown}"));
        }
        assert_eq!(table(&headings, &rows, &[], None).lines().count(), 2);
    }

    #[test]
    fn no_escape_sequence_reaches_the_terminal() {
        let name = "a\u{1b}[2J\u{1b}]0;title\u{7}\r\u{9b}31m\u{202e}\tb\n";
        let shown = "a\u{fffd}[2J\u{fffd}]0;title\u{fffd}\u{fffd}\u{fffd}31m\u{fffd}\tb\n";
        assert_eq!(for_terminal(name), shown);
        for format in [Format::Table, Format::Csv, Format::Json] {
            let shown = for_terminal(&text(format, &["title"], &[vec![name.to_string()]]).unwrap());
            assert!(!shown.contains(|c: char| c != '\n' && c != '\t' && !is_plain(c)), "{shown:?}");
            assert!(shown.contains("title"));
        }
    }
}
