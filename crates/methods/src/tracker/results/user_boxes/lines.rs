//! The lines of a file of boxes: a header, and rows of numbers.

use super::columns::{self, Columns};
use super::{BoxFormat, Row};
use std::path::Path;
use trackfail_dataset::text::NumbersError;
use trackfail_dataset::{DatasetError, text};

/// A header line.
pub(super) struct Header {
    /// The format that it names.
    pub format: BoxFormat,
    /// Whether it calls the corner of the box `x` and `y`.
    pub is_bare: bool,
}

/// Takes the header away, if there is one, and reads it if that is wanted.
pub(super) fn take_header(
    path: &Path,
    lines: &mut Vec<(usize, &str)>,
    is_wanted: bool,
) -> Result<Option<Header>, DatasetError> {
    let Some(&(number, line)) = lines.first().filter(|(_, line)| is_header(line)) else { return Ok(None) };
    lines.remove(0);
    if lines.iter().all(|(_, line)| line.is_empty()) {
        return Err(DatasetError::content(path, "a header and no box; one box a frame was expected"));
    }
    if !is_wanted {
        return Ok(None);
    }
    let words = cells(without_sign(line));
    let columns = Columns::of_words(&words, line);
    let columns = columns.map_err(|e| DatasetError::line(path, number, e.to_string()))?;
    let format = columns.map_or(BoxFormat::Vot, BoxFormat::Columns);
    Ok(Some(Header { format, is_bare: columns::is_bare(&words) }))
}

/// The numbers of lines.
pub(super) fn numbers(
    path: &Path,
    lines: Vec<(usize, &str)>,
    columns: Option<&Columns>,
) -> Result<Vec<Row>, DatasetError> {
    let row = |(number, line): (usize, &str)| {
        let values = if line.is_empty() { Ok(Vec::new()) } else { values(line, columns) };
        Ok((number, values.map_err(|e| DatasetError::line(path, number, e))?))
    };
    lines.into_iter().map(row).collect()
}

/// The numbers of a line. Where the columns are known, those that are not read may hold words, and those of a box may all be
/// empty.
fn values(line: &str, columns: Option<&Columns>) -> Result<Vec<f64>, NumbersError> {
    let (fault, columns) = match (text::numbers(line), columns) {
        (Err(fault), Some(columns)) if columns.fits(cells(line).len()) => (fault, columns),
        (found, _) => return found,
    };
    let value = |(k, cell): (usize, &str)| match text::number(cell) {
        Err(_) if cell.is_empty() || !columns.reads(k) => Ok(f64::NAN),
        value => value,
    };
    let values: Vec<f64> = cells(line).into_iter().enumerate().map(value).collect::<Result<_, _>>()?;
    let of_box = columns.of_box(&values);
    let empty = of_box.iter().filter(|v| v.is_nan()).count();
    if empty > 0 && empty < of_box.len() { Err(fault) } else { Ok(values) }
}

/// The columns of a line of words: between commas, semicolons or tabs if it has any, else between blanks.
fn cells(line: &str) -> Vec<&str> {
    match line.contains([',', ';', '\t']) {
        true => line.split([',', ';', '\t']).map(str::trim).collect(),
        false => line.split_whitespace().collect(),
    }
}

/// A line without the sign of a comment before it.
fn without_sign(line: &str) -> &str {
    line.trim_start_matches(['#', '%']).trim_start()
}

/// Whether a line is words.
fn is_header(line: &str) -> bool {
    let is_word = |w: &&str| w.parse::<f64>().is_err() && w.contains(char::is_alphabetic);
    let words: Vec<&str> = cells(without_sign(line)).into_iter().filter(|w| !w.is_empty()).collect();
    words.len() > 1 && words.iter().all(is_word)
}
