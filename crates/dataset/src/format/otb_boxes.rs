//! Ground truth of the Object Tracking Benchmark alone: a file of boxes for each target, without frames.
//!
//! ```text
//! otb-annotations/otb100/Jogging-1.txt  x,y,w,h a line, as in [`otb`]; line 1 is the first official frame
//! ```
//!
//! Its sequences serve methods that read boxes only. Methods that read pixels are not run on them.

use super::shared::name_of;
use super::{FormatEntry, otb};
use crate::lock::Entry;
use crate::{DatasetError, Numbering, Sequence, text};
use std::path::Path;

/// OTB without frames in the list of formats.
pub const FORMAT: FormatEntry = FormatEntry {
    word: "otb-boxes",
    summary: "`Jogging-1.txt`: boxes of OTB for each target, no frames",
    truth_file: "SEQUENCE.txt",
    load,
    parse_truth: otb::parse_truth,
    reads: |name| Path::new(name).extension().is_some_and(|e| e == "txt"),
    find_targets: None,
    ..FormatEntry::BASE
};

/// Loads the boxes of one file as a sequence without frames.
///
/// # Errors
/// A file that is absent, broken or does not cover the range.
pub fn load(root: &Path, entry: &Entry) -> Result<Sequence, DatasetError> {
    let file = entry.path(root);
    let rows = otb::parse_truth(&file, &text::read_capped(&file)?)?;
    let official = entry.official.unwrap_or((1, u32::try_from(rows.len()).unwrap_or(u32::MAX)));
    let range = otb::not_empty(&file, entry.range.unwrap_or(official))?;
    let truth = otb::cut(rows, &file, official, range)?;
    let name = name_of(&file.with_extension(""), entry);
    let numbering = Numbering { first: range.0, official };
    Ok(Sequence { name, numbering, truth, ..Sequence::default() })
}

#[cfg(test)]
mod tests {
    use super::*;
    use trackfail_core::region::{Rect, Region};
    use trackfail_testing::assert_says;

    #[test]
    fn boxes_are_read_without_frames() {
        let dir = tempfile::tempdir().unwrap();
        let file = dir.path().join("Tiger1.txt");
        // Six lines for the official frames 3 to 6: the file starts at frame 1.
        std::fs::write(&file, "1,1,5,5\n2,1,5,5\n3,1,5,5\n4,1,5,5\n0,0,0,0\n6,1,5,5\n").unwrap();
        let part = Entry { official: Some((3, 6)), range: Some((4, 6)), ..Entry::default() };
        let sequence = load(&file, &part).unwrap();
        let at = |x: f64| Some(Region::Rect(Rect::new(x, 0.0, 5.0, 5.0)));
        assert_eq!((sequence.name.as_str(), sequence.numbering.first), ("Tiger1", 4));
        assert_eq!(sequence.truth, [at(3.0), None, at(5.0)]);
        assert!(!sequence.has_frames());
        assert_says(sequence.frame(0).unwrap_err(), "has no frames");
        assert_eq!(sequence.digest().unwrap(), sequence.digest_anew().unwrap());
        let short = Entry { official: Some((1, 7)), ..Entry::default() };
        assert_says(load(&file, &short).unwrap_err(), "do not cover");
    }
}
