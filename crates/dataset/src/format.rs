//! Formats of datasets on disk: a file each, with that of boxes alone in [`otb`], and one list of them.
//!
//! A new format is a file here, its `mod` line, and its line in [`FORMATS`]; suites, `trackfail data add`, help
//! texts and the fuzz target of ground truth take it from the list.

pub mod cvml;
pub mod got10k;
pub mod lasot;
pub mod otb;
mod shared;
pub mod vot;

use crate::files::{NumberedImages, entries, is_image};
use crate::frame_order::{file_name, numbered};
use crate::lock::Entry;
use crate::{DatasetError, Sequence};
use serde::{Deserialize, Deserializer, Serialize, Serializer};
use std::path::{Path, PathBuf};
use trackfail_core::region::Region;

const GROUND_TRUTH: &str = "groundtruth.txt";

/// Regions of the frames, 0-based pixels; `None` where the target is absent.
type Truth = Vec<Option<Region>>;

/// Lists the targets of a folder.
pub type FindTargets = fn(&Path) -> Result<Vec<Option<u32>>, DatasetError>;

/// A format of sequences on disk, with the functions that recognize and read its folders.
#[derive(Debug)]
pub struct FormatEntry {
    /// Name of the format in suite files and in `trackfail data add --format`.
    pub word: &'static str,
    /// Files of a sequence in one line, for help texts.
    pub summary: &'static str,
    /// Name of the ground-truth file in a folder with one target.
    pub truth_file: &'static str,
    /// Loads the sequence of an entry under a data root; the default entry stands for the root folder itself.
    /// Reads lists of files and text, no image and no video.
    pub load: fn(&Path, &Entry) -> Result<Sequence, DatasetError>,
    /// Reads the bytes of a ground-truth file: one entry per frame, 0-based pixels. The path is for messages.
    pub parse_truth: fn(&Path, &[u8]) -> Result<Truth, DatasetError>,
    /// Names that the image folder may have. If none exists, the images are beside the ground truth.
    pub image_folders: &'static [&'static str],
    /// True if a file of this name, beside the images, is read.
    pub reads: fn(&str) -> bool,
    /// True if a file of the folder is part of an entry's sequence, given its name and, for an image, its
    /// number.
    pub belongs: fn(&Entry, &str, Option<u32>) -> bool,
    /// True if a file of this name holds labels. The files digest of a sequence does not cover those.
    pub is_label: fn(&str) -> bool,
    /// Tells what of an entry's sequence is not in the folder: a part that is downloaded apart (annotation or
    /// frames), or the last frames where a sequence may be only a range of the folder's images.
    pub absent: fn(&Self, &Path, &Entry) -> Result<Option<String>, DatasetError>,
    /// Targets of a folder: `[None]` for a single unnumbered one, empty if the folder holds no sequence.
    /// `None` for formats whose suites are written by hand.
    pub find_targets: Option<FindTargets>,
}

impl FormatEntry {
    /// Default format: one target per folder in `groundtruth.txt`, images beside it, nothing loaded. Each
    /// format replaces what differs.
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
        absent: |_, _, _| Ok(None),
        find_targets: Some(|folder| {
            Ok(if folder.join(GROUND_TRUTH).is_file() { vec![None] } else { Vec::new() })
        }),
    };
}

impl FormatEntry {
    /// The folder with the images of a sequence's folder, which may be the same.
    pub(crate) fn image_folder(&self, folder: &Path) -> PathBuf {
        let inside = self.image_folders.iter().map(|name| folder.join(name)).find(|path| path.is_dir());
        inside.unwrap_or_else(|| folder.to_path_buf())
    }

    /// The JPEG and PNG files of a sequence by frame number, as [`numbered`] reads it from their names.
    ///
    /// # Errors
    /// A folder without images, and the errors of [`numbered`].
    pub(crate) fn images(&self, folder: &Path) -> Result<NumberedImages, DatasetError> {
        let folder = self.image_folder(folder);
        let mut paths = entries(&folder)?;
        paths.retain(|path| !file_name(path).starts_with('.') && is_image(path));
        if paths.is_empty() {
            return Err(DatasetError::content(&folder, "no .jpg or .png file in this folder"));
        }
        Ok(NumberedImages { folder, files: numbered(paths)? })
    }

    /// The frames of an entry from the first without image on, if all to its end have none.
    fn cut_off(&self, folder: &Path, entry: &Entry) -> Result<Option<String>, DatasetError> {
        let Some((first, last)) = entry.range else { return Ok(None) };
        let images = self.images(folder)?.files;
        let absent = (first..=last).find(|n| !images.contains_key(n));
        let absent = absent.filter(|&n| images.range(n..=last).next().is_none());
        Ok(absent.map(|n| format!("frames {n} to {last} are not")))
    }
}

impl PartialEq for FormatEntry {
    fn eq(&self, other: &Self) -> bool {
        self.word == other.word
    }
}

/// All formats.
pub static FORMATS: &[FormatEntry] =
    &[otb::FORMAT, otb::BOXES, vot::FORMAT, got10k::FORMAT, lasot::FORMAT, cvml::FORMAT];

/// Returns the format called `word`.
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
