//! Formats of datasets on disk: one file each, and one list of them.
//!
//! A new format is a file here, its `mod` line, and its line in [`FORMATS`]; suites, `trackfail data add`, help
//! texts and the fuzz target of ground truth take it from the list.

pub mod cvml;
mod entry;
pub mod got10k;
mod labels;
pub mod lasot;
pub mod otb;
pub mod otb_boxes;
pub mod vot;

pub use entry::{FormatEntry, SequenceOptions};

use serde::{Deserialize, Deserializer, Serialize, Serializer};

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
    use std::path::Path;

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
}
