//! Parts that several formats share: files of boxes, label files, and sequences of numbered images.
//!
//! A label file has one small number per frame, as many as the ground truth has lines. A sequence without the
//! file lacks that label.

use super::GROUND_TRUTH;
use crate::files::{NumberedImages, folder_name};
use crate::lock::Entry;
use crate::{DatasetError, Frames, Numbering, Result, Sequence, sorted, text};
use std::path::{Path, PathBuf};
use trackfail_core::region::Region;

/// Converts the row of a box; `None` if it marks a frame without target. The error is the reason why it is neither.
type BoxOf = fn([f64; 4]) -> Result<Option<Region>, String>;

/// Name of an entry's sequence; the name of the folder if the entry has none.
pub(super) fn name_of(folder: &Path, entry: &Entry) -> String {
    if entry.name.is_empty() { folder_name(folder) } else { entry.name.clone() }
}

/// Checks that a word may be the name of an attribute.
///
/// # Errors
/// A word that may not stand in a table.
pub(super) fn attribute(word: &str) -> Result<String, String> {
    if text::is_name(word) {
        return Ok(word.to_owned());
    }
    Err(format!("`{}`: an attribute is {}", text::shorten(&text::visible(word)), text::NAME))
}

/// Entries of a label file of zeros and ones; `None` without the file.
///
/// # Errors
/// As [`labels`].
pub(super) fn flags(path: &Path, frames: usize) -> Result<Option<Vec<bool>>> {
    Ok(labels(path, frames, 1)?.map(|labels| labels.into_iter().map(|label| label == 1).collect()))
}

/// Entries of a label file, each `0..=largest`, separated by commas, blanks or line ends; `None` without the
/// file.
///
/// # Errors
/// An unreadable file, a malformed entry, or a number of entries other than `frames`.
pub(super) fn labels(path: &Path, frames: usize, largest: u8) -> Result<Option<Vec<u8>>> {
    if text::is_absent(path) {
        return Ok(None);
    }
    parse_labels(path, &text::read_capped(path)?, frames, largest).map(Some)
}

fn parse_labels(path: &Path, bytes: &[u8], frames: usize, largest: u8) -> Result<Vec<u8>> {
    let mut found = Vec::with_capacity(frames.min(bytes.len()));
    for (k, line) in text::decode(path, bytes)?.lines().enumerate() {
        let words = line.split(|c: char| c == ',' || c.is_whitespace()).filter(|word| !word.is_empty());
        for word in words {
            let value = word.parse().ok().filter(|v| *v <= largest);
            found.push(value.ok_or_else(|| {
                let message = format!("`{}`; a label here is 0 to {largest}", text::shorten(word));
                DatasetError::line(path, k + 1, message)
            })?);
        }
    }
    if found.len() != frames {
        let message = format!("{} labels for {frames} lines of truth; one a frame is needed", found.len());
        return Err(DatasetError::content(path, message));
    }
    Ok(found)
}

/// Path of the ground-truth file of a folder, and its rows of four numbers.
///
/// # Errors
/// As [`boxes`].
pub(super) fn read_rows(folder: &Path) -> Result<(PathBuf, Vec<[f64; 4]>)> {
    let path = folder.join(GROUND_TRUTH);
    let rows = rows(&path, &text::read_capped(&path)?)?;
    Ok((path, rows))
}

fn rows(path: &Path, bytes: &[u8]) -> Result<Vec<[f64; 4]>> {
    text::rows(path, bytes, |row| {
        let values: Vec<f64> = text::numbers(row)?;
        <[f64; 4]>::try_from(values).map_err(|v| format!("{} numbers; a box is x,y,w,h", v.len()))
    })
}

/// Regions of the rows, 0-based pixels. `None` for four zeros, four NaN, and every frame that `is_absent`
/// accepts, whatever its row.
///
/// # Errors
/// The first row that `box_of` refuses.
pub(super) fn regions(
    path: &Path,
    rows: Vec<[f64; 4]>,
    is_absent: impl Fn(usize) -> bool,
    box_of: BoxOf,
) -> Result<Vec<Option<Region>>> {
    let region = |(t, row): (usize, [f64; 4])| {
        let none = is_absent(t) || row == [0.0; 4] || row.iter().all(|v| v.is_nan());
        // There are no empty lines between rows, so the line is the row's.
        if none { Ok(None) } else { box_of(row).map_err(|message| DatasetError::line(path, t + 1, message)) }
    };
    rows.into_iter().enumerate().map(region).collect()
}

/// Regions of the bytes of a file, one per line, 0-based pixels; `path` is for messages.
///
/// # Errors
/// The first line that is not four numbers, or neither a box nor a mark of a frame without annotation.
pub(super) fn boxes(path: &Path, bytes: &[u8], box_of: BoxOf) -> Result<Vec<Option<Region>>> {
    regions(path, rows(path, bytes)?, |_| false, box_of)
}

/// Converts a box that counts pixels from 1 to one that counts from 0.
///
/// # Errors
/// Infinite numbers and sizes of zero or below.
pub(super) fn one_based(row: [f64; 4]) -> Result<Option<Region>, String> {
    Region::from_numbers(&row).map(|r| Some(r.shifted(-1.0, -1.0))).map_err(|e| e.to_string())
}

/// Sequence of all images of a folder, numbered from 1, one per entry of `truth`. Frame attributes that hold
/// in some frame become attributes of the sequence, too.
///
/// # Errors
/// Missing frames, a number of images other than that of `truth`, and a word that may not be an attribute.
pub(super) fn sequence(
    images: NumberedImages,
    name: String,
    truth: Vec<Option<Region>>,
    mut frame_attributes: Vec<(String, Vec<bool>)>,
    attributes: Vec<String>,
) -> Result<Sequence> {
    let content = |message: String| DatasetError::content(&images.folder, message);
    let (found, lines) = (images.files.len(), truth.len());
    if found != lines {
        let hint = match lines {
            1 => "; one line is all that is published of a test set, whose sequences cannot be used here",
            _ => "",
        };
        return Err(content(format!("{found} images, but {lines} lines in {GROUND_TRUTH}{hint}")));
    }
    let last = lines as u32;
    let frames = Frames::Files(images.range((1, last))?);
    frame_attributes.sort();
    let ever =
        frame_attributes.iter().filter(|(_, flags)| flags.contains(&true)).map(|(name, _)| name.clone());
    let attributes = sorted(ever.chain(attributes));
    attributes.iter().try_for_each(|word| attribute(word).map(drop)).map_err(content)?;
    let numbering = Numbering { first: 1, official: (1, last) };
    Ok(Sequence { name, numbering, truth, attributes, frame_attributes, frames, ..Sequence::default() })
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn parse(text: &[u8], frames: usize) -> Result<Vec<u8>> {
        parse_labels(Path::new("a.label"), text, frames, 8)
    }

    #[test]
    fn one_a_line_or_all_on_one() {
        for text in ["0\n8\n1\n", "0,8,1", "\u{feff}0\r\n8\r\n1", "0 8\t1", "0, 8, 1,\n", "0,8\n1"] {
            assert_eq!(parse(text.as_bytes(), 3).unwrap(), [0, 8, 1], "{text:?}");
        }
        // 11397 frames, as the longest sequence of LaSOT has, are more than a line of numbers may have.
        let long = vec!["0"; 11_397].join(",");
        assert_eq!(parse(long.as_bytes(), 11_397).unwrap().len(), 11_397);
    }

    #[cfg(unix)]
    #[test]
    fn a_link_that_leads_nowhere_is_not_absent() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("full_occlusion.txt");
        assert_eq!(flags(&path, 3).unwrap(), None);
        std::os::unix::fs::symlink("nowhere", &path).unwrap();
        assert!(flags(&path, 3).is_err());
    }

    #[test]
    fn faults_are_named() {
        for (text, word) in [
            ("0\n9\n1", "line 2: `9`; a label here is 0 to 8"),
            ("0\n-1\n1", "line 2"),
            ("0\n1\n0.5", "line 3"),
            ("0,x,1", "line 1: `x`"),
            ("0\n1", "2 labels for 3 lines of truth"),
            ("0\n1\n1\n1", "4 labels for 3"),
            ("", "0 labels for 3"),
        ] {
            let error = parse(text.as_bytes(), 3).unwrap_err().to_string();
            assert!(error.starts_with("a.label") && error.contains(word), "{text:?}: {error}");
        }
        assert!(matches!(parse(b"1\n\xFF", 2), Err(DatasetError::Line { line: 2, .. })));
    }

    proptest! {
        #[test]
        fn written_labels_are_read_back(labels in prop::collection::vec(0..=8_u8, 0..60), s in 0..3_usize) {
            let words: Vec<String> = labels.iter().map(u8::to_string).collect();
            let text = words.join([",", "\n", "\r\n"][s]);
            prop_assert_eq!(parse(text.as_bytes(), labels.len()).unwrap(), labels);
        }
    }
}
