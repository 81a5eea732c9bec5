//! Results of GOT-10k experiments (Huang, Zhao, Huang; PAMI 2021): one file per repetition with `x,y,w,h` in each
//! line; the first line is the box that the tracker was started with.
//!
//! ```text
//! <Seq>/<Seq>_001.txt             three of them, or one of a deterministic tracker
//! <Seq>/<Seq>_time.txt            seconds a frame; not read
//! ```
//!
//! Coordinates are those of the annotation, which counts pixels from 1 (the authors, got-10k/toolkit#6).
//!
//! The [VOT](super::vot) toolkits write under the same names. Their first line is always the mark `1`, and
//! GOT-10k's is always a box, so the first line tells; a file that begins with anything else is refused. So
//! is one that begins with a box and has a mark further down, by its number of columns.

use std::path::Path;
use trackfail_dataset::{DatasetError, text};

/// Kind of a file `<Seq>/<Seq>_001.txt`, by its first line.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// Marks and regions of the VOT reset protocol.
    Vot,
    /// One box per line.
    Boxes,
}

/// Tells the two apart by the first line; `path` names the file in messages.
///
/// # Errors
/// A first line that is neither the mark `1` nor four numbers; a file that is empty or not text.
pub fn kind(path: &Path, bytes: &[u8]) -> Result<Kind, DatasetError> {
    let lines = text::lines_or_empty(path, text::decode(path, bytes)?)?;
    let first = lines.first().map_or("", |(_, line)| line);
    let values = match first {
        "" => Vec::new(),
        first => text::numbers(first).map_err(|m| DatasetError::line(path, 1, m))?,
    };
    match values[..] {
        [1.0] => Ok(Kind::Vot),
        [_, _, _, _] => Ok(Kind::Boxes),
        _ => Err(DatasetError::line(
            path,
            1,
            "neither VOT's mark `1`, with which a run begins (an initialization), nor the four numbers \
             x,y,w,h of a GOT-10k result",
        )),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn of(bytes: &[u8]) -> Result<Kind, DatasetError> {
        kind(Path::new("S_001.txt"), bytes)
    }

    #[test]
    fn the_first_line_tells() {
        for vot in ["1", "1\n9,9,1,1", "\u{feff}1\r\n2\r\n", "1.0000\n0"] {
            assert_eq!(of(vot.as_bytes()).unwrap(), Kind::Vot, "{vot}");
        }
        for boxes in ["1,1,1,1", "1.000,2.000,3.000,4.000\r\n1,1,1,1", "1\t1\t1\t1\n1", "nan,1,1,1"] {
            assert_eq!(of(boxes.as_bytes()).unwrap(), Kind::Boxes, "{boxes}");
        }
        for neither in ["0\n1", "2", "1.5", "1,1\n1", "1,2,3", "1,2,3,4,5,6,7,8\n1", "x,y,w,h\n1,1,1,1"] {
            let error = of(neither.as_bytes()).unwrap_err();
            assert!(matches!(error, DatasetError::Line { line: 1, .. }), "{neither}: {error}");
        }
        assert!(of(b"").is_err());
        assert!(of(b"\n1").is_err());
    }

    proptest! {
        // No file of one kind is read by the reader of the other.
        #[test]
        fn no_file_is_both(text in "[0-3.,\t\r\n ]{0,40}") {
            let path = Path::new("S_001.txt");
            let frames = text.trim_end().lines().count();
            let truth = trackfail_core::region::Region::from_numbers(&[1.0, 1.0, 1.0, 1.0]).unwrap();
            let vot = crate::tracker::results::vot::parse(path, text.as_bytes(), &vec![Some(truth); frames]);
            let boxes = crate::tracker::results::otb_text::parse_rows(path, text.as_bytes());
            prop_assert!(vot.is_err() || boxes.is_err());
            if vot.is_ok() {
                prop_assert_eq!(of(text.as_bytes()).unwrap(), Kind::Vot);
            }
            // A frame without a box is lawful, but not the first one.
            if boxes.is_ok_and(|rows| rows.first().is_some_and(|(_, row)| row.is_ok())) {
                prop_assert_eq!(of(text.as_bytes()).unwrap(), Kind::Boxes);
            }
        }

        #[test]
        fn any_bytes_are_read_or_refused(bytes in prop::collection::vec(any::<u8>(), 0..300)) {
            let _ = of(&bytes);
        }
    }
}
