//! Sequences in the layout of the Object Tracking Benchmark (Wu, Lim, Yang; CVPR 2013, PAMI 2015), and
//! plain folders of images.
//!
//! ```text
//! David/img/0300.jpg ...          frames under the dataset's own numbers, .jpg or .png
//! David/groundtruth_rect.txt      x,y,w,h a line; line 1 is the first official frame (300), not frame 1
//! Jogging/groundtruth_rect.1.txt  one file per target if there are several
//! David/attributes.txt            optional: words, separated by commas or line ends
//! ```
//!
//! `x` and `y` count pixels from 1 in the file and from 0 in memory. A line of four zeros or of four NaN is a
//! frame without annotation (`None`); other sizes of zero or below are errors. Boxes may leave the image. The
//! ground truth may be longer than the range used but not shorter. It starts at the first official frame;
//! only where it has exactly as many lines as the last official frame's number, and that is more than the
//! official range has frames, it starts at frame 1 (Tiger1 is published both ways).
//!
//! Without an `img` folder the images beside the text files are taken.
//!
//! Boxes may also come alone, a file for each target without frames ([`BOXES`]). Such sequences serve methods that
//! read boxes only; methods that read pixels are not run on them.
//!
//! ```text
//! otb-annotations/otb100/Jogging-1.txt  x,y,w,h a line; line 1 is the first official frame
//! ```

use super::shared::{attribute, boxes, name_of, one_based};
use super::{FormatEntry, Truth};
use crate::files::entries;
use crate::lock::Entry;
use crate::{DatasetError, Frames, Numbering, Result, Sequence, sorted, text};
use std::path::Path;

/// Start of the names of ground-truth files. A folder with several targets has a number before `.txt`.
const TRUTH_PREFIX: &str = "groundtruth_rect";

/// OTB in the list of formats.
pub const FORMAT: FormatEntry = FormatEntry {
    word: "otb",
    summary: "`img/0001.jpg` and `groundtruth_rect.txt`",
    truth_file: "groundtruth_rect.txt",
    load,
    parse_truth: |path, bytes| boxes(path, bytes, one_based),
    image_folders: &["img"],
    reads: |name| {
        name.starts_with(TRUTH_PREFIX) && Path::new(name).extension().is_some_and(|e| e == "txt")
            || name == "attributes.txt"
    },
    belongs,
    absent: FormatEntry::cut_off,
    find_targets: Some(find_targets),
    ..FormatEntry::BASE
};

/// OTB without frames in the list of formats.
pub const BOXES: FormatEntry = FormatEntry {
    word: "otb-boxes",
    summary: "`Jogging-1.txt`: boxes of OTB for each target, no frames",
    truth_file: "SEQUENCE.txt",
    load: load_boxes,
    parse_truth: |path, bytes| boxes(path, bytes, one_based),
    reads: |name| Path::new(name).extension().is_some_and(|e| e == "txt"),
    find_targets: None,
    ..FormatEntry::BASE
};

/// True if a file of a folder belongs to an entry's sequence. Text beside the ground truth is optional and
/// gives attributes only.
fn belongs(entry: &Entry, name: &str, image: Option<u32>) -> bool {
    match (image, entry.range) {
        (Some(n), Some((first, last))) => first <= n && n <= last,
        (Some(_), None) => true,
        (None, _) => name == truth_name(entry.target),
    }
}

/// Targets of a folder. Some folders have a plain file beside the numbered ones, and some have an empty
/// numbered one.
fn find_targets(folder: &Path) -> Result<Vec<Option<u32>>> {
    let mut numbers: Vec<u32> = Vec::new();
    for path in entries(folder)? {
        let name = path.file_name().and_then(|n| n.to_str());
        let number = name.and_then(|n| n.strip_prefix(TRUTH_PREFIX)?.strip_prefix('.')?.strip_suffix(".txt"));
        let content = path.metadata().is_ok_and(|m| m.is_file() && m.len() > 0);
        numbers.extend(number.filter(|_| content).and_then(|n| n.parse::<u32>().ok()));
    }
    numbers.sort_unstable();
    Ok(match numbers.as_slice() {
        [] if folder.join(truth_name(None)).is_file() => vec![None],
        _ => numbers.into_iter().map(Some).collect(),
    })
}

/// Name of the ground-truth file of a target.
fn truth_name(target: Option<u32>) -> String {
    target.map_or_else(|| format!("{TRUTH_PREFIX}.txt"), |n| format!("{TRUTH_PREFIX}.{n}.txt"))
}

/// Loads one sequence. Reads the list of files and the text, no image.
///
/// # Errors
/// A folder without images, a missing frame, a ground truth that is absent, broken or too short.
pub fn load(root: &Path, entry: &Entry) -> Result<Sequence> {
    let folder = entry.path(root);
    let without_truth = load_frames(&folder, name_of(&folder, entry), entry.range)?;
    let path = folder.join(truth_name(entry.target));
    let (rows, official) = read_rows(&path, entry, without_truth.numbering.official.0)?;
    let truth = cut(rows, &path, official, without_truth.range())?;
    let numbering = Numbering { official, ..without_truth.numbering };
    Ok(Sequence { numbering, truth, attributes: read_attributes(&folder)?, ..without_truth })
}

/// Loads the boxes of one file as a sequence without frames.
///
/// # Errors
/// A file that is absent, broken or does not cover the range.
fn load_boxes(root: &Path, entry: &Entry) -> Result<Sequence> {
    let file = entry.path(root);
    let (rows, official) = read_rows(&file, entry, 1)?;
    let range = not_empty(&file, entry.range.unwrap_or(official))?;
    let truth = cut(rows, &file, official, range)?;
    let name = name_of(&file.with_extension(""), entry);
    let numbering = Numbering { first: range.0, official };
    Ok(Sequence { name, numbering, truth, ..Sequence::default() })
}

/// Regions of a ground-truth file, and the official range of frames: that of the entry, else one from `first` on.
fn read_rows(path: &Path, entry: &Entry, first: u32) -> Result<(Truth, (u32, u32))> {
    let rows = boxes(path, &text::read_capped(path)?, one_based)?;
    let lines = u32::try_from(rows.len()).unwrap_or(u32::MAX);
    let official = (first, first.saturating_add(lines).saturating_sub(1));
    Ok((rows, entry.official.unwrap_or(official)))
}

/// Frames of a folder as a sequence without annotation, whatever other files the folder has. The official
/// range covers all images.
///
/// # Errors
/// A folder without images, or a missing frame.
pub(crate) fn load_frames(folder: &Path, name: String, range: Option<(u32, u32)>) -> Result<Sequence> {
    let images = FORMAT.images(folder)?;
    let ends = images.files.first_key_value().zip(images.files.last_key_value());
    let official = ends.map_or((1, 0), |((first, _), (last, _))| (*first, *last));
    let range = not_empty(&images.folder, range.unwrap_or(official))?;
    let files = images.range(range)?;
    let truth = vec![None; files.len()];
    let numbering = Numbering { first: range.0, official };
    Ok(Sequence { name, numbering, truth, frames: Frames::Files(files), ..Sequence::default() })
}

/// Checks that a range of frames is not empty.
fn not_empty(place: &Path, range: (u32, u32)) -> Result<(u32, u32)> {
    if range.0 > range.1 {
        return Err(DatasetError::content(place, format!("the range {} to {} is empty", range.0, range.1)));
    }
    Ok(range)
}

/// Entries for frames `first..=last`, out of a file that starts at the official first frame or at frame 1.
fn cut(rows: Truth, path: &Path, official: (u32, u32), (first, last): (u32, u32)) -> Result<Truth> {
    let count = rows.len() as u64;
    let span = (u64::from(official.1) + 1).saturating_sub(official.0.into());
    let from_one = count == u64::from(official.1) && count > span;
    let start = if from_one { 1 } else { official.0 };
    if first < start || u64::from(last) >= u64::from(start) + count {
        let message = format!(
            "{count} lines from frame {start} on do not cover frames {first} to {last}; none is made up"
        );
        return Err(DatasetError::content(path, message));
    }
    let length = (last - first) as usize + 1;
    Ok(rows.into_iter().skip((first - start) as usize).take(length).collect())
}

/// Words of `attributes.txt`, sorted, without repetitions; empty if the file is absent.
fn read_attributes(folder: &Path) -> Result<Vec<String>> {
    let path = folder.join("attributes.txt");
    if text::is_absent(&path) {
        return Ok(Vec::new());
    }
    let mut words = Vec::new();
    for (k, line) in text::read(&path)?.lines().enumerate() {
        for word in line.split(',').map(str::trim).filter(|word| !word.is_empty()) {
            words.push(attribute(word).map_err(|message| DatasetError::line(&path, k + 1, message))?);
        }
    }
    Ok(sorted(words))
}

#[cfg(test)]
mod tests;
