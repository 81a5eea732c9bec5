//! The header of a file of boxes, and the numbers of lines with known columns.

use super::columns::{self, Columns};
use super::{BoxFormat, rows};
use rows::{Line, cells};
use std::path::Path;
use trackfail_dataset::{DatasetError, text};

/// A header line after reading.
pub(super) struct Header {
    /// Format that the header names.
    pub format: BoxFormat,
    /// True if the header calls the place of the box `x` and `y`.
    pub is_bare: bool,
}

impl Header {
    /// Reads a line as a header.
    pub fn read(path: &Path, (number, line): Line<'_>) -> Result<Self, DatasetError> {
        let words = cells(rows::without_sign(line));
        let columns = Columns::of_words(&words, line);
        let columns = columns.map_err(|e| DatasetError::line(path, number, e.to_string()))?;
        let format = columns.map_or(BoxFormat::Vot, BoxFormat::Columns);
        Ok(Self { format, is_bare: columns::is_bare(&words) })
    }
}

/// The numbers of a line. If the columns are known, columns that are not read may hold words, and those of
/// the box may all be empty.
pub(super) fn values(line: &str, columns: Option<&Columns>) -> Result<Vec<f64>, String> {
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

/// A table with names of columns between tabs, with commas in their place: two tabs have an empty column between
/// them, as two commas have. `None` for another text.
pub(super) fn with_commas(bytes: &[u8]) -> Option<Vec<u8>> {
    let text = std::str::from_utf8(bytes).ok()?;
    let header = text.trim_start_matches('\u{feff}').lines().next()?.trim_end();
    let is_name = |word: &str| word.is_empty() || word.parse::<f64>().is_err();
    let tabs = header.matches('\t').count();
    let has_names = header.contains(char::is_alphabetic) && header.split('\t').map(str::trim).all(is_name);
    if tabs == 0 || !has_names || text.contains([',', ';']) {
        return None;
    }
    let line = |line: &str| {
        // More tabs than the header has are no columns.
        let line = line.trim_end_matches([' ', '\r']);
        let more = line.matches('\t').count().saturating_sub(tabs);
        let at_end = line.len() - line.trim_end_matches('\t').len();
        line[..line.len() - more.min(at_end)].replace('\t', ",")
    };
    Some(text.lines().map(line).collect::<Vec<_>>().join("\n").into_bytes())
}
