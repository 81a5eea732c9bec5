//! Text files of numbers, as datasets and trackers write them.
//!
//! Numbers are separated by commas, semicolons, tabs or spaces, mixed at will; line ends may be LF or
//! CRLF, a byte-order mark and a missing last line end are tolerated, and so are empty lines at the end.
//! An empty line before that is an error, because lines are counted as frames.

use super::DatasetError;
use std::fs::File;
use std::io::Read;
use std::path::Path;

/// Largest text or JSON file that is read, in bytes.
pub const LARGEST_TEXT: u64 = 64 << 20;

/// The bytes of a file of at most [`LARGEST_TEXT`] bytes.
///
/// # Errors
/// I/O errors and larger files.
pub fn read_capped(path: &Path) -> Result<Vec<u8>, DatasetError> {
    let file = File::open(path).map_err(|e| DatasetError::io(path, e))?;
    let mut bytes = Vec::new();
    file.take(LARGEST_TEXT + 1).read_to_end(&mut bytes).map_err(|e| DatasetError::io(path, e))?;
    if bytes.len() as u64 > LARGEST_TEXT {
        let limit = LARGEST_TEXT >> 20;
        return Err(DatasetError::content(path, format!("larger than {limit} MiB, so no such text file")));
    }
    Ok(bytes)
}

/// Reads a text file and takes off a byte-order mark.
///
/// # Errors
/// I/O errors, files above [`LARGEST_TEXT`], and bytes that are not UTF-8, with their line.
pub fn read(path: &Path) -> Result<String, DatasetError> {
    let mut bytes = read_capped(path)?;
    if bytes.starts_with(b"\xEF\xBB\xBF") {
        bytes.drain(..3);
    }
    String::from_utf8(bytes).map_err(|e| {
        let good = &e.as_bytes()[..e.utf8_error().valid_up_to()];
        let line = 1 + good.iter().filter(|&&b| b == b'\n').count();
        DatasetError::line(path, line, "bytes that are not UTF-8 text; save the file as plain text")
    })
}

/// The lines of `text` with their numbers from 1, without empty lines at the end.
///
/// # Errors
/// A text without any line, and an empty line among the others.
pub fn lines<'t>(path: &Path, text: &'t str) -> Result<Vec<(usize, &'t str)>, DatasetError> {
    let body = text.trim_end();
    if body.is_empty() {
        return Err(DatasetError::content(path, "the file is empty; one line a frame was expected"));
    }
    let lines: Vec<_> = body.lines().enumerate().map(|(i, l)| (i + 1, l.trim())).collect();
    match lines.iter().find(|(_, l)| l.is_empty()) {
        Some(&(line, _)) => {
            Err(DatasetError::line(path, line, "an empty line; lines are frames, so none may be empty"))
        }
        None => Ok(lines),
    }
}

/// The numbers of one line; `NaN` and `inf` are numbers here.
///
/// # Errors
/// A message about the first word that is no number, or about an empty column.
pub fn numbers(line: &str) -> Result<Vec<f64>, String> {
    let mut values = Vec::with_capacity(8);
    for column in line.split([',', ';']) {
        let mut words = column.split_whitespace().peekable();
        if words.peek().is_none() {
            return Err("an empty column; write one number between two separators".into());
        }
        for word in words {
            values.push(word.parse().map_err(|_| format!("`{}` is no number", shorten(word)))?);
        }
    }
    Ok(values)
}

/// At most 40 characters of what was found, for messages.
pub fn shorten(word: &str) -> String {
    let mut short: String = word.chars().take(40).collect();
    if short.len() < word.len() {
        short.push_str("...");
    }
    short
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn file(bytes: &[u8]) -> tempfile::NamedTempFile {
        let f = tempfile::NamedTempFile::new().unwrap();
        std::fs::write(f.path(), bytes).unwrap();
        f
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
    }

    #[test]
    fn byte_order_mark_line_ends_and_missing_last_end() {
        let f = file(b"\xEF\xBB\xBF1,2\r\n3,4\r\n\r\n");
        let text = read(f.path()).unwrap();
        assert_eq!(lines(f.path(), &text).unwrap(), [(1, "1,2"), (2, "3,4")]);
        assert_eq!(lines(f.path(), "a\nb").unwrap(), [(1, "a"), (2, "b")]);
    }

    #[test]
    fn faults_name_their_line() {
        let f = file(b"1,2\n3,\xFF\n");
        assert!(matches!(read(f.path()), Err(DatasetError::Line { line: 2, .. })));
        assert!(matches!(lines(f.path(), "1\n\n2\n"), Err(DatasetError::Line { line: 2, .. })));
        assert!(matches!(lines(f.path(), "\r\n \n"), Err(DatasetError::Content { .. })));
        assert!(matches!(read(Path::new("/no/such/file")), Err(DatasetError::Io { .. })));
    }

    #[test]
    fn huge_files_are_refused() {
        let f = tempfile::NamedTempFile::new().unwrap();
        f.as_file().set_len(LARGEST_TEXT + 1).unwrap();
        assert!(matches!(read(f.path()), Err(DatasetError::Content { .. })));
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
