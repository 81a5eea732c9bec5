//! Formats of datasets on disk: one file each, and one list of them.
//!
//! A new format is a file here, its `mod` line, and its line in [`FORMATS`]; suites, `trackfail data add`, help
//! texts and the fuzz target of ground truth take it from the list.

pub mod cvml;
pub mod got10k;
pub mod lasot;
pub mod otb;
pub mod otb_boxes;
mod shared;
pub mod vot;

use crate::lock::Entry;
use crate::{DatasetError, Sequence};
use serde::{Deserialize, Deserializer, Serialize, Serializer};
use std::path::Path;
use trackfail_core::region::Region;

const GROUND_TRUTH: &str = "groundtruth.txt";

/// The region of each frame, 0-based; `None` where the target is absent.
type Truth = Vec<Option<Region>>;

/// Lists the targets of a folder.
type FindTargets = fn(&Path) -> Result<Vec<Option<u32>>, DatasetError>;

/// A format of sequences on disk: how their folders are recognized and read.
pub struct FormatEntry {
    /// Word for it in files of suites and for `trackfail data add --format`.
    pub word: &'static str,
    /// Files of a sequence in one line, for help texts.
    pub summary: &'static str,
    /// Name of the ground-truth file of a folder with one target.
    pub truth_file: &'static str,
    /// Loads the sequence of an entry under a data root; that of the default entry is the root as a whole. Reads lists
    /// of files and text, no image and no video.
    pub load: fn(&Path, &Entry) -> Result<Sequence, DatasetError>,
    /// Reads the bytes of a ground-truth file, one entry a frame, 0-based; the path names it in messages.
    pub parse_truth: fn(&Path, &[u8]) -> Result<Truth, DatasetError>,
    /// Names that the folder of images may have in that of the sequence; without one of them, the images are beside the
    /// ground truth.
    pub image_folders: &'static [&'static str],
    /// Whether a file of this name beside the images is read.
    pub reads: fn(&str) -> bool,
    /// Whether a file of its folder is part of an entry's sequence: its name, and its number if it is an image.
    pub belongs: fn(&Entry, &str, Option<u32>) -> bool,
    /// Whether the file of this name is a label file, which the files digest of a sequence does not cover.
    pub is_label: fn(&str) -> bool,
    /// Whether a range of the folder's images can be a sequence, so that images after it may be absent.
    pub takes_ranges: fn(&Path) -> Result<bool, DatasetError>,
    /// The part of a sequence that its folder lacks, where parts are downloaded apart.
    pub absent_part: fn(&Path) -> Result<Option<&'static str>, DatasetError>,
    /// The targets of a folder, `None` for the only one, and nothing if the folder is no sequence; absent if
    /// suites of the format cannot be found that way and are written by hand.
    pub find_targets: Option<FindTargets>,
}

impl FormatEntry {
    /// A format of one target a folder in `groundtruth.txt`, with the images beside it; entries replace what
    /// differs. It reads nothing.
    const BASE: Self = Self {
        word: "",
        summary: "",
        truth_file: GROUND_TRUTH,
        load: |folder, _| Err(DatasetError::content(folder, "this format has no reader")),
        parse_truth: |path, _| Err(DatasetError::content(path, "this format has no reader")),
        image_folders: &[],
        reads: |name| name == GROUND_TRUTH,
        belongs: |_, _, _| true,
        is_label: |_| false,
        takes_ranges: |_| Ok(false),
        absent_part: |_| Ok(None),
        find_targets: Some(|folder| {
            Ok(if folder.join(GROUND_TRUTH).is_file() { vec![None] } else { Vec::new() })
        }),
    };
}

impl PartialEq for FormatEntry {
    fn eq(&self, other: &Self) -> bool {
        self.word == other.word
    }
}

impl std::fmt::Debug for FormatEntry {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "FormatEntry({})", self.word)
    }
}

/// Every format.
pub static FORMATS: &[FormatEntry] =
    &[otb::FORMAT, otb_boxes::FORMAT, vot::FORMAT, got10k::FORMAT, lasot::FORMAT, cvml::FORMAT];

/// The format of a word.
pub fn find(word: &str) -> Option<&'static FormatEntry> {
    FORMATS.iter().find(|f| f.word == word)
}

impl Serialize for FormatEntry {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_str(self.word)
    }
}

impl<'de> Deserialize<'de> for &'static FormatEntry {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let word = String::deserialize(deserializer)?;
        find(&word).ok_or_else(|| {
            let known = FORMATS.iter().map(|f| f.word);
            serde::de::Error::custom(trackfail_core::plugin::unknown("format", &word, known))
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use trackfail_testing::damaged;

    #[test]
    fn words_are_unique_and_help_texts_are_there() {
        for format in FORMATS {
            assert_eq!(FORMATS.iter().filter(|f| f.word == format.word).count(), 1, "{format:?}");
            assert!(!format.summary.is_empty() && (format.reads)(format.truth_file), "{format:?}");
            assert_eq!(find(format.word), Some(format));
        }
        assert_eq!(find("xml"), None);
    }

    // What is no ground truth is an error everywhere, and boxes have an area.
    #[test]
    fn empty_files_are_no_ground_truth() {
        for format in FORMATS {
            assert!((format.parse_truth)(Path::new("a"), b"").is_err(), "{format:?}");
        }
    }

    const BOXES: &[u8] =
        b"\xEF\xBB\xBF1,1,10,20\r\n-4\t7\t1.5\t2\r\n0,0,0,0\nNaN NaN NaN NaN\n3 4, 5 6\n367,101,41,16";
    const REGIONS: &[u8] = b"1,2,3,4\r\n0,0,0,5,6,5,6,0\n1.5,2.5,9e1,-7.25,11,12\nnan,nan,nan,nan\n";
    const WITHOUT_AREA: &[u8] =
        b"367,101,41,16\n366,103,45,16\r\n1,1,-1,-1\n0,0,0,0\nnan,nan,nan,nan\n3.5\t4\t5\t6";

    proptest! {
        #[test]
        fn damaged_truth_is_read_or_refused(
            bytes in prop_oneof![damaged(BOXES), damaged(REGIONS), damaged(WITHOUT_AREA)],
        ) {
            for format in FORMATS {
                if let Ok(truth) = (format.parse_truth)(Path::new("a.txt"), &bytes) {
                    prop_assert!(truth.iter().flatten().all(|r| r.area() > 0.0), "{format:?}");
                }
            }
        }
    }
}
