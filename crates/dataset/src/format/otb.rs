//! Sequences in the layout of the Object Tracking Benchmark (Wu, Lim, Yang; CVPR 2013, PAMI 2015), and
//! plain folders of images.
//!
//! ```text
//! David/img/0300.jpg ...          frames under the dataset's own numbers, .jpg or .png
//! David/groundtruth_rect.txt      x,y,w,h a line; line 1 is the first official frame (300), not frame 1
//! Jogging/groundtruth_rect.1.txt  one file a target where there are several
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

use super::{FormatEntry, SequenceOptions};
use crate::files::{folder_name, image_folder, numbered_images, take_range};
use crate::{DatasetError, Digest, Frames, Numbering, Sequence, sorted, text};
use std::path::{Path, PathBuf};
use trackfail_core::region::Region;

/// Files of several targets have a number before `.txt`.
const TRUTH_PREFIX: &str = "groundtruth_rect";

/// Image folder of a sequence, if it has one.
const IMAGE_FOLDERS: [&str; 1] = ["img"];

/// The entry in the list of formats.
pub const FORMAT: FormatEntry = FormatEntry {
    word: "otb",
    summary: "`img/0001.jpg` and `groundtruth_rect.txt`",
    truth_file: "groundtruth_rect.txt",
    load: |folder, options| load(folder, &options.clone().into()),
    parse_truth,
    image_folder: |folder| image_folder(folder, &IMAGE_FOLDERS),
    reads: |name| {
        name.starts_with(TRUTH_PREFIX) && Path::new(name).extension().is_some_and(|e| e == "txt")
            || name == "attributes.txt"
    },
    belongs,
    takes_ranges: |_| Ok(true),
    find_targets: Some(find_targets),
    ..FormatEntry::BASE
};

/// Whether a file of a folder is part of a sequence. Text other than the ground truth need not be there, and gives
/// attributes only.
fn belongs(options: &SequenceOptions, name: &str, image: Option<u32>) -> bool {
    match (image, options.range) {
        (Some(n), Some((first, last))) => first <= n && n <= last,
        (Some(_), None) => true,
        (None, _) => name == truth_name(options.target),
    }
}

/// The targets of a folder. Some folders have a plain file beside those of several targets, and some a numbered one
/// that is empty.
fn find_targets(folder: &Path) -> Result<Vec<Option<u32>>, DatasetError> {
    let mut numbers: Vec<u32> = Vec::new();
    for file in std::fs::read_dir(folder).map_err(|e| DatasetError::io(folder, e))? {
        let path = file.map_err(|e| DatasetError::io(folder, e))?.path();
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

/// Source of the ground truth.
#[derive(Debug, Clone, Default)]
pub enum Truth {
    /// `groundtruth_rect.txt` (`groundtruth_rect.N.txt` with a target), which must be there.
    #[default]
    Required,
    /// None: frames stay without annotation, whatever files lie beside them.
    Ignored,
    /// Another file of the same format.
    File(PathBuf),
}

/// How a folder is read; the default takes all its frames.
#[derive(Debug, Clone, Default)]
pub struct Options {
    /// Name of the sequence; without one, the folder's name.
    pub name: Option<String>,
    /// Which of several targets, counted from 1.
    pub target: Option<u32>,
    /// First and last frame used, in the dataset's numbers; without it, all images.
    pub range: Option<(u32, u32)>,
    /// First and last frame of the dataset's own range; without it, from the first image on as many frames as
    /// the ground truth has lines.
    pub official: Option<(u32, u32)>,
    /// Source of the ground truth.
    pub truth: Truth,
}

impl From<SequenceOptions> for Options {
    fn from(options: SequenceOptions) -> Self {
        let SequenceOptions { name, target, range, official, decoded: _ } = options;
        Self { name, target, range, official, truth: Truth::Required }
    }
}

/// Loads one sequence. Reads no image, only the list of files and the text.
///
/// # Errors
/// A folder without images, a missing frame, a ground truth that is absent, broken or too short.
pub fn load(folder: &Path, options: &Options) -> Result<Sequence, DatasetError> {
    let image_folder = image_folder(folder, &IMAGE_FOLDERS);
    let images = numbered_images(&image_folder)?;
    let present = match (images.keys().next(), images.keys().next_back()) {
        (Some(&first), Some(&last)) => (first, last),
        _ => return Err(DatasetError::content(&image_folder, "no images")),
    };
    let (first, last) = options.range.unwrap_or(present);
    if first > last {
        return Err(DatasetError::content(folder, format!("the range {first} to {last} is empty")));
    }
    let frames = take_range(&image_folder, &images, (first, last))?;

    let truth_file = truth_file(folder, options);
    let ignored = matches!(options.truth, Truth::Ignored);
    let rows = if ignored { None } else { Some(parse_truth(&truth_file, &text::read_capped(&truth_file)?)?) };
    let official = options.official.unwrap_or_else(|| {
        let lines = rows.as_ref().map_or(images.len(), Vec::len) as u64;
        let end = (u64::from(present.0) + lines).saturating_sub(1);
        (present.0, u32::try_from(end).unwrap_or(u32::MAX))
    });
    let truth = match rows {
        None => vec![None; frames.len()],
        Some(rows) => cut(rows, &truth_file, official, (first, last))?,
    };
    let name = options.name.clone().unwrap_or_else(|| folder_name(folder));
    Ok(Sequence {
        name,
        numbering: Numbering { first, official },
        truth,
        attributes: if ignored { Vec::new() } else { read_attributes(folder)? },
        frame_attributes: Vec::new(),
        digest: Digest::default(),
        frames: Frames::Files(frames.into()),
    })
}

fn truth_file(folder: &Path, options: &Options) -> PathBuf {
    match (&options.truth, options.target) {
        (Truth::File(path), _) => path.clone(),
        (_, target) => folder.join(truth_name(target)),
    }
}

/// The rows of a ground-truth file, 0-based, one a line; `path` names it in messages.
///
/// # Errors
/// The first line that is neither a box nor one of those without annotation.
pub fn parse_truth(path: &Path, bytes: &[u8]) -> Result<Vec<Option<Region>>, DatasetError> {
    text::rows(path, bytes, rectangle)
}

fn rectangle(row: &str) -> Result<Option<Region>, String> {
    let values = text::numbers(row)?;
    if values.len() != 4 {
        return Err(format!("{} numbers; an OTB box is x,y,w,h", values.len()));
    }
    if values.iter().all(|v| v.is_nan()) || values.iter().all(|&v| v == 0.0) {
        return Ok(None);
    }
    let region = Region::from_numbers(&values).map_err(|e| e.to_string())?;
    Ok(Some(region.shifted(-1.0, -1.0)))
}

pub(super) fn cut(
    rows: Vec<Option<Region>>,
    path: &Path,
    official: (u32, u32),
    (first, last): (u32, u32),
) -> Result<Vec<Option<Region>>, DatasetError> {
    let count = rows.len() as u64;
    let span = (u64::from(official.1) + 1).saturating_sub(official.0.into());
    let from_one = count == u64::from(official.1) && count > span;
    let start = if from_one { 1 } else { official.0 };
    if first < start || u64::from(last) >= u64::from(start) + count {
        return Err(DatasetError::content(
            path,
            format!(
                "{count} lines from frame {start} on do not cover frames {first} to {last}; none is made up"
            ),
        ));
    }
    let length = (last - first) as usize + 1;
    Ok(rows.into_iter().skip((first - start) as usize).take(length).collect())
}

/// The words of `attributes.txt`, sorted, each once; none when there is no such file.
fn read_attributes(folder: &Path) -> Result<Vec<String>, DatasetError> {
    let path = folder.join("attributes.txt");
    if !path.exists() {
        return Ok(Vec::new());
    }
    let mut words = Vec::new();
    for (k, line) in text::read(&path)?.lines().enumerate() {
        for word in line.split(',').map(str::trim).filter(|word| !word.is_empty()) {
            if !text::is_name(word) {
                let word = text::shorten(&text::visible(word));
                return Err(DatasetError::line(
                    &path,
                    k + 1,
                    format!("`{word}`: an attribute is {}", text::NAME),
                ));
            }
            words.push(word.to_string());
        }
    }
    Ok(sorted(words))
}

#[cfg(test)]
mod tests;
