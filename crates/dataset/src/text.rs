//! Text files of numbers, as datasets and trackers write them.
//!
//! Numbers are separated by commas, semicolons, tabs or spaces, mixed at will; line ends may be LF or
//! CRLF, a byte-order mark and a missing last line end are tolerated, and so are empty lines at the end.
//! An empty line before that is an error, because lines are counted as frames.
//!
//! Such files come from anywhere, so their size and the length of their lines are limited. A larger file is
//! refused unread. Links are followed, since users may keep a dataset elsewhere and link to it.

use super::{DatasetError, Result};
use std::fs::File;
use std::io::{ErrorKind, Read};
use std::path::Path;

/// Largest text or JSON file that is read, in bytes. Real ones stay below one MiB.
pub const MAX_TEXT_BYTES: u64 = 16 << 20;
/// Longest line that is read, in bytes, enough for a polygon of hundreds of corners.
pub const MAX_LINE_BYTES: usize = 16 << 10;

/// True if there is nothing at `path`. A link that leads nowhere is there, and cannot be read.
pub fn is_absent(path: &Path) -> bool {
    std::fs::symlink_metadata(path).is_err_and(|e| e.kind() == ErrorKind::NotFound)
}

/// Reads a file of at most `limit` bytes.
///
/// # Errors
/// I/O errors and larger files, which are not read.
pub fn read_at_most(path: &Path, limit: u64) -> Result<Vec<u8>> {
    let (file, length) = open(path)?;
    if length > limit { Err(too_large(path, limit)) } else { read_stream(path, file, limit) }
}

/// Opens a file for reading and returns its length, too.
///
/// # Errors
/// I/O errors, and anything but a regular file: a pipe might block.
pub(crate) fn open(path: &Path) -> Result<(File, u64)> {
    let about = std::fs::metadata(path).map_err(|e| DatasetError::io(path, e))?;
    if !about.is_file() {
        return Err(DatasetError::content(path, "not a file"));
    }
    Ok((File::open(path).map_err(|e| DatasetError::io(path, e))?, about.len()))
}

/// Reads a stream of unknown length, up to `limit` bytes.
fn read_stream(path: &Path, stream: impl Read, limit: u64) -> Result<Vec<u8>> {
    let mut bytes = Vec::new();
    stream.take(limit.saturating_add(1)).read_to_end(&mut bytes).map_err(|e| DatasetError::io(path, e))?;
    if bytes.len() as u64 > limit { Err(too_large(path, limit)) } else { Ok(bytes) }
}

fn too_large(path: &Path, limit: u64) -> DatasetError {
    DatasetError::content(path, format!("larger than {} MiB, so no file of its kind", limit >> 20))
}

/// Reads a file of at most [`MAX_TEXT_BYTES`] bytes.
///
/// # Errors
/// I/O errors and larger files.
pub fn read_capped(path: &Path) -> Result<Vec<u8>> {
    read_at_most(path, MAX_TEXT_BYTES)
}

/// Reads a text that the user names: a file, a pipe, or `-` for stdin, of at most [`MAX_TEXT_BYTES`] bytes.
///
/// # Errors
/// I/O errors, folders, and larger texts.
pub fn read_named(path: &Path) -> Result<Vec<u8>> {
    if path == Path::new("-") {
        return read_stream(path, std::io::stdin().lock(), MAX_TEXT_BYTES);
    }
    read_stream(path, File::open(path).map_err(|e| DatasetError::io(path, e))?, MAX_TEXT_BYTES)
}

/// Reads a text file and removes a byte-order mark.
///
/// # Errors
/// I/O errors, files above [`MAX_TEXT_BYTES`], and bytes that are not UTF-8, with their line.
pub fn read(path: &Path) -> Result<String> {
    Ok(decode(path, &read_capped(path)?)?.to_owned())
}

/// Removes the byte-order mark of UTF-8 at the start.
pub fn without_mark(bytes: &[u8]) -> &[u8] {
    bytes.strip_prefix(b"\xEF\xBB\xBF").unwrap_or(bytes)
}

/// Decodes UTF-8 and removes a byte-order mark; `path` is for messages.
///
/// # Errors
/// Bytes that are not UTF-8, with their line.
pub fn decode<'b>(path: &Path, bytes: &'b [u8]) -> Result<&'b str> {
    let bytes = without_mark(bytes);
    std::str::from_utf8(bytes).map_err(|e| {
        let line = line_of(bytes, e.valid_up_to());
        DatasetError::line(path, line, "bytes that are not UTF-8 text; save the file as plain text")
    })
}

/// Line, from 1, of a byte position in a text.
pub fn line_of(text: &[u8], place: usize) -> usize {
    1 + text.iter().take(place).filter(|&&byte| byte == b'\n').count()
}

/// Reads one value per line.
///
/// # Errors
/// The errors of [`decode`], [`lines`] and `read_line`.
pub fn rows<T>(path: &Path, bytes: &[u8], read_line: impl Fn(&str) -> Result<T, String>) -> Result<Vec<T>> {
    let rows = lines(path, decode(path, bytes)?)?;
    rows.into_iter().map(|(n, row)| read_line(row).map_err(|m| DatasetError::line(path, n, m))).collect()
}

/// Lines of `text` with their numbers from 1, without empty lines at the end.
///
/// # Errors
/// A text without any line, an empty line among the others, and a line above [`MAX_LINE_BYTES`].
pub fn lines<'t>(path: &Path, text: &'t str) -> Result<Vec<(usize, &'t str)>> {
    let lines = lines_or_empty(path, text.trim_end())?;
    if let Some(&(line, _)) = lines.iter().find(|(_, l)| l.is_empty()) {
        let message = "an empty line; lines are frames, so none may be empty";
        return Err(DatasetError::line(path, line, message));
    }
    Ok(lines)
}

/// All lines of `text` with their numbers from 1, including empty ones, for files in which an empty line is a
/// frame without a value.
///
/// # Errors
/// A text of blanks only, carriage returns as the only line ends, and a line above [`MAX_LINE_BYTES`].
pub fn lines_or_empty<'t>(path: &Path, text: &'t str) -> Result<Vec<(usize, &'t str)>> {
    if text.trim_end().is_empty() {
        return Err(DatasetError::content(path, "the file is empty; one line a frame was expected"));
    }
    if !text.contains('\n') && text.trim_end().contains('\r') {
        let message =
            "the line ends are carriage returns alone; save the file with line feeds (LF, or CR LF)";
        return Err(DatasetError::content(path, message));
    }
    let lines: Vec<_> = text.lines().enumerate().map(|(i, l)| (i + 1, l.trim())).collect();
    if let Some(&(line, long)) = lines.iter().find(|(_, l)| l.len() > MAX_LINE_BYTES) {
        let message = format!("{} bytes; a line has at most {MAX_LINE_BYTES}", long.len());
        return Err(DatasetError::line(path, line, message));
    }
    Ok(lines)
}

/// Parses a word as a number; `NaN` is allowed.
///
/// # Errors
/// A word that is not a number, infinity, and numbers too large for an `f64`.
pub fn number(word: &str) -> Result<f64, String> {
    match word.parse::<f64>() {
        Ok(value) if value.is_infinite() => {
            let word = shorten(word);
            Err(format!("`{word}` is not a finite number; where there is none, write nan"))
        }
        Ok(value) => Ok(value),
        Err(_) => Err(format!("`{}` is no number", shorten(word))),
    }
}

/// Parses the numbers of one line, separated by commas, semicolons or blanks.
///
/// # Errors
/// The first word that is not a [`number`], or an empty column.
pub fn numbers(line: &str) -> Result<Vec<f64>, String> {
    let mut values = Vec::with_capacity(8);
    for column in line.split([',', ';']) {
        let before = values.len();
        for word in column.split_whitespace() {
            values.push(number(word)?);
        }
        if values.len() == before {
            return Err("an empty column; write one number between two separators".into());
        }
    }
    Ok(values)
}

/// First 40 characters of a foreign text, for messages.
pub fn shorten(word: &str) -> String {
    shorten_to(word, 40)
}

/// First `most` characters of a text, for messages.
pub fn shorten_to(text: &str, most: usize) -> String {
    match text.char_indices().nth(most) {
        Some((end, _)) => format!("{}...", &text[..end]),
        None => text.to_owned(),
    }
}

/// True if a character is visible and has no other effect: it neither controls the terminal or the file nor
/// changes the reading direction.
pub fn is_plain(c: char) -> bool {
    let turns = matches!(c, '\u{202a}'..='\u{202e}' | '\u{2066}'..='\u{2069}');
    !c.is_control() && !turns && !matches!(c, '\u{2028}' | '\u{2029}' | '\u{feff}' | '\u{fffe}' | '\u{ffff}')
}

/// True if a name may stand in a table. Spreadsheets take a field that begins with one of `= + - @` for a
/// formula.
pub fn is_name(text: &str) -> bool {
    !text.is_empty() && text.chars().all(is_plain) && !text.trim_start().starts_with(['=', '+', '-', '@'])
}

/// The rule of [`is_name`] in words.
pub const NAME: &str = "plain text that does not begin with one of = + - @";

/// The text on one line. Characters that are not plain become a blank if they separate words, else U+FFFD.
pub fn visible(text: &str) -> String {
    let shown = |c| match c {
        '\n' | '\r' | '\t' => ' ',
        c if is_plain(c) => c,
        _ => '\u{fffd}',
    };
    text.chars().map(shown).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use trackfail_testing::assert_says;

    fn file(bytes: &[u8]) -> tempfile::NamedTempFile {
        let f = tempfile::NamedTempFile::new().unwrap();
        std::fs::write(f.path(), bytes).unwrap();
        f
    }

    #[test]
    fn carriage_returns_alone_are_no_line_ends() {
        let path = Path::new("a.txt");
        for text in ["1,2,3,4\r5,6,7,8\r", "1,2,3,4\r5,6,7,8"] {
            assert_says(lines(path, text).unwrap_err(), "a.txt: the line ends are carriage returns alone");
        }
        assert_eq!(lines(path, "1\r").unwrap(), [(1, "1")]);
        assert_eq!(lines(path, "1\r\n2\r\n").unwrap(), [(1, "1"), (2, "2")]);
    }

    #[test]
    fn separators_may_be_mixed() {
        for line in ["1,2,-3.5,4e1", "1\t2\t-3.5\t40", "1 2  -3.5 , 40", "1;2;-3.5;40", "1, 2,\t-3.5 40"] {
            assert_eq!(numbers(line).unwrap(), [1.0, 2.0, -3.5, 40.0], "{line}");
        }
        assert!(numbers("NaN,1").unwrap()[0].is_nan());
        for line in ["1,,2", "1,2,", ",1", "", "1,x", "1 2,3O"] {
            assert!(numbers(line).is_err(), "{line}");
        }
        // What Python, NumPy and C write for infinity, and what is as large.
        for word in ["inf", "-inf", "Infinity", "-INFINITY", "1e999", "-1e400"] {
            let told = numbers(&format!("1,{word}")).unwrap_err();
            assert_says(told, format!("`{word}` is not a finite number"));
        }
    }

    #[test]
    fn byte_order_mark_line_ends_and_missing_last_end() {
        let path = Path::new("a.txt");
        let text = read(file(b"\xEF\xBB\xBF1,2\r\n3,4\r\n\r\n").path()).unwrap();
        assert_eq!(lines(path, &text).unwrap(), [(1, "1,2"), (2, "3,4")]);
        assert_eq!(lines(path, "a\nb").unwrap(), [(1, "a"), (2, "b")]);
        assert_eq!(lines_or_empty(path, "\na\r\n \n").unwrap(), [(1, ""), (2, "a"), (3, "")]);
        assert!(lines_or_empty(path, " \n\n").is_err());
        // Faults name their line.
        let of_bytes = read(file(b"1,2\n3,\xFF\n").path());
        assert!(matches!(of_bytes, Err(DatasetError::Line { line: 2, .. })));
        assert!(matches!(lines(path, "1\n\n2\n"), Err(DatasetError::Line { line: 2, .. })));
        assert!(matches!(lines(path, "\r\n \n"), Err(DatasetError::Content { .. })));
        assert!(matches!(read(Path::new("/no/such/file")), Err(DatasetError::Io { .. })));
    }

    #[test]
    fn huge_files_are_refused() {
        let f = tempfile::NamedTempFile::new().unwrap();
        f.as_file().set_len(MAX_TEXT_BYTES + 1).unwrap();
        assert!(matches!(read(f.path()), Err(DatasetError::Content { .. })));
        assert!(read_at_most(f.path(), MAX_TEXT_BYTES + 1).is_ok());
        assert_says(read_at_most(f.path(), MAX_TEXT_BYTES).unwrap_err(), "16 MiB");
    }

    // A device has no length that could be looked at beforehand.
    #[cfg(unix)]
    #[test]
    fn endless_files_are_refused() {
        assert!(matches!(read(Path::new("/dev/zero")), Err(DatasetError::Content { .. })));
        assert!(matches!(read_named(Path::new("/dev/zero")), Err(DatasetError::Content { .. })));
        assert!(read_named(Path::new("/dev/null")).unwrap().is_empty());
    }

    #[test]
    fn long_lines_are_refused() {
        let path = Path::new("a.txt");
        let line = "1,".repeat(MAX_LINE_BYTES / 2 - 1) + "12";
        assert_eq!(line.len(), MAX_LINE_BYTES);
        assert!(lines(path, &format!("1\n{line}\n")).is_ok());
        assert!(matches!(lines(path, &format!("1\n{line}3\n")), Err(DatasetError::Line { line: 2, .. })));
    }

    #[test]
    fn nothing_invisible_is_shown() {
        assert_eq!(visible("a\tb\r\nc \u{e9} \u{5d0}"), "a b  c \u{e9} \u{5d0}");
        let bad = "\u{feff}\0\u{1b}\u{7f}\u{9b}\u{202e}\u{2066}\u{2028}\u{ffff}";
        assert_eq!(visible(bad), "\u{fffd}".repeat(9));
    }

    #[test]
    fn messages_are_short() {
        assert_eq!(shorten(&"\u{e9}".repeat(40)), "\u{e9}".repeat(40));
        assert_eq!(shorten(&"\u{e9}".repeat(41)), "\u{e9}".repeat(40) + "...");
        assert_eq!(shorten(""), "");
    }

    proptest! {
        #[test]
        fn written_numbers_are_read_back(values in prop::collection::vec(-1e9..1e9_f64, 1..9), s in 0..4_usize) {
            let separator = [",", "\t", " ", " ; "][s];
            let line = values.iter().map(f64::to_string).collect::<Vec<_>>().join(separator);
            prop_assert_eq!(numbers(&line).unwrap(), values);
        }
    }
}
