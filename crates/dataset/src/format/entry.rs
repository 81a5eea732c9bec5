//! An entry of the list of formats.

use crate::{DatasetError, Sequence};
use std::path::{Path, PathBuf};
use trackfail_core::region::Region;

/// How one sequence of a folder is read; the default takes the whole folder.
#[derive(Debug, Clone, Default)]
pub struct SequenceOptions {
    /// Name of the sequence; without one, the folder's name.
    pub name: Option<String>,
    /// Which of several targets: OTB counts from 1, CVML uses the object's id.
    pub target: Option<u32>,
    /// First and last frame used, in the dataset's numbers; without it, all frames that the format knows.
    pub range: Option<(u32, u32)>,
    /// First and last frame of the dataset's own range; without it, the frames that the ground truth covers.
    pub official: Option<(u32, u32)>,
    /// Folder that the frames of videos are decoded into.
    pub decoded: PathBuf,
}

/// The region of each frame, 0-based; `None` where the target is absent.
pub type Truth = Vec<Option<Region>>;

/// The targets of a folder, `None` for the only one.
pub type Targets = Vec<Option<u32>>;

/// Lists the targets of a folder; nothing if the folder is no sequence.
pub type FindTargets = fn(&Path) -> Result<Targets, DatasetError>;

/// A format of sequences on disk: how their folders are recognized and read.
pub struct FormatEntry {
    /// Word for it in files of suites and for `trackfail data add --format`.
    pub word: &'static str,
    /// Files of a sequence in one line, for help texts.
    pub summary: &'static str,
    /// Name of the ground-truth file of a folder with one target.
    pub truth_file: &'static str,
    /// Loads one sequence of a folder. Reads lists of files and text, no image and no video.
    pub load: fn(&Path, &SequenceOptions) -> Result<Sequence, DatasetError>,
    /// Reads the bytes of a ground-truth file, one entry a frame, 0-based; the path names it in messages.
    pub parse_truth: fn(&Path, &[u8]) -> Result<Truth, DatasetError>,
    /// The folder of the images, given the sequence's folder.
    pub image_folder: fn(&Path) -> PathBuf,
    /// Whether a file of this name beside the images is read.
    pub reads: fn(&str) -> bool,
    /// Whether a file is part of one sequence of a folder: its name, and its number if it is an image.
    pub belongs: fn(&SequenceOptions, &str, Option<u32>) -> bool,
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
    pub(super) const BASE: Self = Self {
        word: "",
        summary: "",
        truth_file: GROUND_TRUTH,
        load: |folder, _| Err(DatasetError::content(folder, "this format has no reader")),
        parse_truth: |path, _| Err(DatasetError::content(path, "this format has no reader")),
        image_folder: Path::to_path_buf,
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

const GROUND_TRUTH: &str = "groundtruth.txt";

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
