//! Sequences in the layout of GOT-10k (Huang, Zhao, Huang: GOT-10k: A Large High-Diversity Benchmark for
//! Generic Object Tracking in the Wild, PAMI 2021).
//!
//! ```text
//! GOT-10k_Train_000001/00000001.jpg ...      frames from 1 on
//! GOT-10k_Train_000001/groundtruth.txt       x,y,w,h per line, one line per frame
//! GOT-10k_Train_000001/absence.label         a frame a line: 1 where the target is absent
//! GOT-10k_Train_000001/cover.label           a frame a line: 0 to 8, how much of it is visible
//! GOT-10k_Train_000001/cut_by_image.label    a frame a line: 1 where the image's border cuts it
//! GOT-10k_Train_000001/meta_info.ini         lines `key: value`
//! ```
//!
//! Coordinates count pixels from 1 (the authors, got-10k/toolkit#6) and are counted from 0 in memory. Levels of
//! cover are 0, nothing; 1 to 7, up to 15, 30, 45, 60, 75, 90 and below 100 %; 8, all of it. A frame has no
//! truth where the target is absent, where nothing of it is visible, and where the box is four zeros or of NaN
//! alone; the first two are what the authors' evaluation leaves out. Other boxes without area are errors.
//!
//! Frame attributes: `absence` and `cut_by_image` as labelled; `occlusion` at levels 1 to 7, and
//! `heavy-occlusion` at 1 to 3, where at most 45 % are visible. Sequence attributes are those that some frame
//! has, and of `meta_info.ini` `class-<object_class>` and `motion-<motion_class>`, in small letters. Each of
//! the four files beside the truth may be missing; the attributes that it gives are then missing, too.
//!
//! Images, lines of truth and entries of each label file must be equal in number. Of the test set only the
//! first box is published, so its sequences are refused.

use super::shared::{boxes, flags, labels, name_of, one_based, read_rows, regions, sequence};
use super::{FormatEntry, GROUND_TRUTH};
use crate::lock::Entry;
use crate::{DatasetError, Sequence, text};
use std::path::Path;

/// GOT-10k in the list of formats.
pub const FORMAT: FormatEntry = FormatEntry {
    word: "got10k",
    summary: "`00000001.jpg` and `groundtruth.txt`, boxes from pixel 1 on, labels of cover and absence",
    load,
    parse_truth: |path, bytes| boxes(path, bytes, one_based),
    reads: |name| FILES.contains(&name),
    ..FormatEntry::BASE
};

/// Names of the text files that are read, beside the images.
const FILES: [&str; 5] =
    [GROUND_TRUTH, "meta_info.ini", "absence.label", "cover.label", "cut_by_image.label"];

/// Level of cover of a fully visible target.
const WHOLE: u8 = 8;

/// Loads one sequence. Reads the list of files and the text, no image.
///
/// # Errors
/// Missing frames, a broken or absent ground truth, and files of another length than the ground truth.
pub fn load(root: &Path, entry: &Entry) -> Result<Sequence, DatasetError> {
    let folder = entry.path(root);
    let (path, rows) = read_rows(&folder)?;
    let absence = flags(&folder.join("absence.label"), rows.len())?;
    let cut = flags(&folder.join("cut_by_image.label"), rows.len())?;
    let cover = labels(&folder.join("cover.label"), rows.len(), WHOLE)?;
    let is_absent = |t: usize| {
        absence.as_ref().is_some_and(|absence| absence[t])
            || cover.as_ref().is_some_and(|cover| cover[t] == 0)
    };
    let truth = regions(&path, rows, is_absent, one_based)?;
    let at = |levels: std::ops::RangeInclusive<u8>| -> Option<Vec<bool>> {
        Some(cover.as_ref()?.iter().map(|level| levels.contains(level)).collect())
    };
    let attributes = [
        ("occlusion", at(1..=WHOLE - 1)),
        ("heavy-occlusion", at(1..=3)),
        ("absence", absence),
        ("cut_by_image", cut),
    ];
    let attributes = attributes.into_iter().filter_map(|(name, flags)| Some((name.to_owned(), flags?)));
    let meta = meta(&folder.join("meta_info.ini"))?;
    sequence(FORMAT.images(&folder)?, name_of(&folder, entry), truth, attributes.collect(), meta)
}

/// Attributes of the target in `meta_info.ini`; empty without the file.
fn meta(path: &Path) -> Result<Vec<String>, DatasetError> {
    if text::is_absent(path) {
        return Ok(Vec::new());
    }
    let mut words = Vec::new();
    for (k, line) in text::read(path)?.lines().enumerate().map(|(k, line)| (k + 1, line.trim())) {
        if line.is_empty() || line.starts_with('[') {
            continue;
        }
        let Some((key, value)) = line.split_once([':', '=']) else {
            let message = format!("`{}`; a line is `key: value`", text::shorten(line));
            return Err(DatasetError::line(path, k, message));
        };
        let prefix = match key.trim() {
            "object_class" => "class",
            "motion_class" => "motion",
            _ => continue,
        };
        let plain = |c: char| if c.is_alphanumeric() { c } else { '-' };
        let value: String = value.trim().to_lowercase().chars().map(plain).collect();
        if !value.is_empty() {
            words.push(format!("{prefix}-{}", text::shorten(&value)));
        }
    }
    Ok(words)
}

#[cfg(test)]
mod tests;
