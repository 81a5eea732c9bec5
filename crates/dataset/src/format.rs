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
mod tests;
