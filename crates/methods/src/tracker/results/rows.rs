//! Rows of numbers: the lines of a text, and the frames and targets of rows.

use std::collections::BTreeMap;
use std::path::Path;
use trackfail_dataset::{DatasetError, text};

/// A line of a text: its number from 1, and its text without blanks around it.
pub type Line<'t> = (usize, &'t str);

/// A row: number of the line from 1, and its numbers (empty for an empty line).
pub type Row = (usize, Vec<f64>);

/// The lines of a text; `path` is for messages.
///
/// # Errors
/// When the bytes are not text, or there is no line.
pub fn lines<'t>(path: &Path, bytes: &'t [u8]) -> Result<Vec<Line<'t>>, DatasetError> {
    text::lines_or_empty(path, text::decode(path, bytes)?)
}

/// Removes the first line if it is a header, that is, has words.
///
/// # Errors
/// When no row follows the header.
pub fn take_header<'t>(path: &Path, lines: &mut Vec<Line<'t>>) -> Result<Option<Line<'t>>, DatasetError> {
    let is_word = |w: &&str| w.parse::<f64>().is_err() && w.contains(char::is_alphabetic);
    let is_header = |line: &str| {
        let words: Vec<&str> = cells(without_sign(line)).into_iter().filter(|w| !w.is_empty()).collect();
        // Names of columns differ; `None` in all of them is a box that is not there.
        words.iter().any(|word| *word != words[0]) && words.iter().all(is_word)
    };
    if !lines.first().is_some_and(|(_, line)| is_header(line)) {
        return Ok(None);
    }
    let header = lines.remove(0);
    if lines.iter().all(|(_, line)| line.is_empty()) {
        return Err(DatasetError::content(path, "a header and no box; one box a frame was expected"));
    }
    Ok(Some(header))
}

/// The numbers of each line, found by `read`.
///
/// # Errors
/// The first line whose numbers cannot be read.
pub fn numbers(
    path: &Path,
    lines: Vec<Line<'_>>,
    read: impl Fn(&str) -> Result<Vec<f64>, String>,
) -> Result<Vec<Row>, DatasetError> {
    let row = |(number, line): Line<'_>| {
        let values = if line.is_empty() { Ok(Vec::new()) } else { read(line) };
        Ok((number, values.map_err(|e| DatasetError::line(path, number, e))?))
    };
    lines.into_iter().map(row).collect()
}

/// The rows of a text without a header; `path` is for messages.
///
/// # Errors
/// As [`lines`] and [`numbers`].
pub fn read(path: &Path, bytes: &[u8]) -> Result<Vec<Row>, DatasetError> {
    numbers(path, lines(path, bytes)?, text::numbers)
}

/// The rows of a text, without the header if there is one; `path` is for messages.
///
/// # Errors
/// As [`lines`], [`take_header`] and [`numbers`].
pub fn read_after_header(path: &Path, bytes: &[u8]) -> Result<Vec<Row>, DatasetError> {
    let mut lines = lines(path, bytes)?;
    take_header(path, &mut lines)?;
    numbers(path, lines, text::numbers)
}

/// The columns of a line: separated by commas, semicolons or tabs if it has any, else by blanks.
pub fn cells(line: &str) -> Vec<&str> {
    match line.contains([',', ';', '\t']) {
        true => line.split([',', ';', '\t']).map(str::trim).collect(),
        false => line.split_whitespace().collect(),
    }
}

/// A line without the comment sign at its start.
pub fn without_sign(line: &str) -> &str {
    line.trim_start_matches(['#', '%']).trim_start()
}

/// Drops empty rows at the end: as many as possible so that `fits` is true for the number of rows, or all if
/// it never is.
pub fn drop_empty_end(rows: &mut Vec<Row>, fits: impl Fn(usize) -> bool) {
    let full = rows.iter().rposition(|(_, row)| !row.is_empty()).map_or(0, |last| last + 1);
    rows.truncate((full..=rows.len()).find(|n| fits(*n)).unwrap_or(full));
}

/// Rows by target and by index of the frame.
pub type Targets<'r> = BTreeMap<Option<i64>, BTreeMap<usize, &'r Row>>;

/// The rows of each target by frame, and the number of the first frame: `first`, or 0 if the text has a frame 0,
/// else 1. `frame` and `target` are indices of columns; `frames` is the number of frames, if it is known.
///
/// # Errors
/// When a number is not whole, a frame does not exist, or a target has two rows in a frame.
pub fn by_target<'r>(
    path: &Path,
    rows: &'r [Row],
    (frame, target): (usize, Option<usize>),
    frames: Option<usize>,
    first: Option<usize>,
) -> Result<(usize, Targets<'r>), DatasetError> {
    let least = || usize::from(rows.iter().all(|(_, values)| values.get(frame) != Some(&0.0)));
    let first = first.unwrap_or_else(least);
    let mut targets = Targets::new();
    for row in rows {
        let (line, values) = row;
        let fault = |message: String| DatasetError::line(path, *line, message);
        let whole = |k: usize| values.get(k).filter(|v| v.fract() == 0.0 && v.abs() < 1e9).map(|v| *v as i64);
        let index = whole(frame).and_then(|number| usize::try_from(number).ok()?.checked_sub(first));
        let (Some(index), None | Some(Some(_))) = (index, target.map(whole)) else {
            return Err(fault("frame (from 0 or 1 on) and id are whole numbers".into()));
        };
        let number = index + first;
        if let Some(frames) = frames.filter(|frames| index >= *frames) {
            let message = format!("frame {number}, but there are {frames} frames, counted from {first}");
            return Err(fault(message));
        }
        let id = target.and_then(whole);
        if targets.entry(id).or_default().insert(index, row).is_some() {
            let target = id.map_or_else(|| "the target".to_string(), |id| format!("target {id}"));
            return Err(fault(format!("a second row of {target} in frame {number}")));
        }
    }
    Ok((first, targets))
}
