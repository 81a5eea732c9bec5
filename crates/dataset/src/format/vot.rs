//! Sequences in the layout of the Visual Object Tracking challenge (VOT2014, Kristan et al., ECCVW 2014).
//!
//! ```text
//! ball/00000001.jpg ...     frames from 1 on, .jpg or .png; or in ball/color
//! ball/groundtruth.txt      a frame a line: 8 values x1,y1,...,x4,y4 or 4 values x,y,w,h
//! ball/occlusion.label      a frame a line: 0 or 1; or occlusion.tag
//! list.txt                  beside the folders: the names of all sequences, one per line
//! ```
//!
//! Coordinates are taken as they are written, i.e. 0-based, as the current VOT toolkit does; the toolkit of
//! 2014 used them as MATLAB pixel coordinates, counted from 1, which moves truth and results alike. Polygons
//! must be convex, as the rotated boxes of VOT2014 are. A line of NaN alone, of four zeros, or of a single
//! zero (as the current toolkit writes it) is a frame without annotation. Masks (`m10,20,...`) are refused.
//! The number of frames is the number of lines; other counts are errors, except that frame number 0, an extra
//! file in `ball`, is not part of the sequence. Sequence attributes are the labels that are 1 in some frame.

use super::shared::{flags, name_of, sequence};
use super::{FormatEntry, GROUND_TRUTH};
use crate::files::entries;
use crate::lock::Entry;
use crate::{DatasetError, Sequence, text};
use std::path::Path;
use trackfail_core::region::Region;

/// VOT in the list of formats.
pub const FORMAT: FormatEntry = FormatEntry {
    word: "vot",
    summary: "`00000001.jpg` and `groundtruth.txt`, regions of 4 or 8 numbers from pixel 0 on",
    load,
    parse_truth,
    reads: |name| name == GROUND_TRUTH || is_label(name),
    // Frame 0 is an extra file and not part of a sequence.
    belongs: |_, _, image| image.is_none_or(|n| n > 0),
    is_label,
    image_folders: &["color"],
    ..FormatEntry::BASE
};

/// True for labels, which newer toolkits call tags.
fn is_label(name: &str) -> bool {
    !name.starts_with('.') && (name.ends_with(".label") || name.ends_with(".tag"))
}

/// Loads one sequence. Reads the list of files and the text, no image.
///
/// # Errors
/// Missing frames, and text files that are absent, broken or of another length than the frames.
pub fn load(root: &Path, entry: &Entry) -> Result<Sequence, DatasetError> {
    let folder = entry.path(root);
    let path = folder.join(GROUND_TRUTH);
    let truth = parse_truth(&path, &text::read_capped(&path)?)?;
    let mut attributes = Vec::new();
    let mut labels = entries(&folder)?;
    labels.retain(|path| is_label(&path.file_name().unwrap_or_default().to_string_lossy()));
    for path in labels {
        let Some(label) = path.file_stem().and_then(|stem| stem.to_str()) else {
            return Err(DatasetError::content(&path, "the name is not UTF-8; rename the file"));
        };
        if attributes.iter().any(|(known, _)| known == label) {
            let message = format!("`{label}` is both a label and a tag; keep one");
            return Err(DatasetError::content(&path, message));
        }
        attributes.extend(flags(&path, truth.len())?.map(|flags| (label.to_owned(), flags)));
    }
    let mut images = FORMAT.images(&folder)?;
    images.files.remove(&0);
    sequence(images, name_of(&folder, entry), truth, attributes, Vec::new())
}

/// Regions of a ground-truth file, one per line; `path` is for messages.
///
/// # Errors
/// The first line that is neither a region nor a mark of a frame without annotation.
pub fn parse_truth(path: &Path, bytes: &[u8]) -> Result<Vec<Option<Region>>, DatasetError> {
    text::rows(path, bytes, annotation)
}

fn annotation(row: &str) -> Result<Option<Region>, String> {
    if row.starts_with('m') {
        return Err(
            "a mask, and masks are not read; write their bounding boxes, left,top,width,height".into()
        );
    }
    let values = text::numbers(row)?;
    if values.iter().all(|v| v.is_nan()) || values == [0.0; 4] || values == [0.0] {
        return Ok(None);
    }
    Region::from_numbers(&values).map(Some).map_err(|e| e.to_string())
}

/// Sequence names in a `list.txt`, in the order of the file.
///
/// # Errors
/// An unreadable or empty file.
pub fn read_list(path: &Path) -> Result<Vec<String>, DatasetError> {
    let text = text::read(path)?;
    Ok(text::lines(path, &text)?.into_iter().map(|(_, name)| name.to_owned()).collect())
}

#[cfg(test)]
mod tests {
    use super::super::tests::{place, read, rect};
    use super::*;
    use crate::Frames;
    use trackfail_testing::assert_says;

    #[test]
    fn polygons_rectangles_and_frame_zero() {
        let files = [
            ("groundtruth.txt", "1,2,3,4\r\n0,0,0,5,6,5,6,0\r\nnan,nan,nan,nan"),
            ("occlusion.label", "0\n1\n0"),
            ("blur.label", "0\r\n0\r\n0\r\n"),
        ];
        let s = read("vot", &place("vot", 0..=3, &files)).unwrap();
        let polygon = Region::Polygon(vec![(0.0, 0.0), (0.0, 5.0), (6.0, 5.0), (6.0, 0.0)]);
        assert_eq!(s.truth, [rect(1.0, 2.0, 3.0, 4.0), Some(polygon), None]);
        assert_eq!((s.number(0), s.numbering.official), (1, (1, 3)));
        assert_eq!(s.attributes, ["occlusion"]);
        assert_eq!(s.frame_attributes[0], ("blur".into(), vec![false; 3]));
        assert_eq!(s.frame_attributes[1], ("occlusion".into(), vec![false, true, false]));
        let Frames::Files(files) = &s.frames else { panic!("files") };
        assert!(files[0].ends_with("00000001.jpg"));
    }

    #[test]
    fn folders_of_newer_toolkits_are_read() {
        let files =
            [("groundtruth.txt", "1,2,3,4\n5,6,7,8"), ("occlusion.tag", "0\n1"), ("color/00000001.jpg", "")];
        let dir = place("vot", [], &files);
        trackfail_testing::put(dir.path(), "color/00000002.jpg", "");
        let s = read("vot", &dir).unwrap();
        assert_eq!((s.len(), s.attributes), (2, vec!["occlusion".to_string()]));
        trackfail_testing::put(dir.path(), "occlusion.label", "0\n1");
        assert_says(read("vot", &dir).unwrap_err(), "`occlusion` is both a label and a tag");
    }

    // vot-toolkit 0.9.0, vot.region.io: a line of one number is no region, `0` where the target is not there, and one that
    // begins with `m` is a mask.
    #[test]
    fn a_zero_is_no_region_and_a_mask_has_a_remedy() {
        let truth = |text: &[u8]| parse_truth(Path::new("groundtruth.txt"), text);
        let found = truth(b"1,2,3,4\n0\n0.0\n5,6,7,8\n").unwrap();
        assert_eq!(found.iter().map(Option::is_some).collect::<Vec<_>>(), [true, false, false, true]);
        for words in ["groundtruth.txt, line 2: a mask", "bounding boxes"] {
            assert_says(truth(b"1,2,3,4\nm10,20,3,2,0,6\n").unwrap_err(), words);
        }
        // Starts and failures are marks of results.
        for mark in ["1", "2", "0,0", "0,0,0"] {
            assert!(truth(format!("1,2,3,4\n{mark}\n").as_bytes()).is_err(), "{mark}");
        }
    }

    #[trackfail_testing::needs(real_data)]
    #[test]
    fn real_sequences() {
        let root = trackfail_testing::real_data();
        let names = read_list(&root.join("vot2014/list.txt")).unwrap();
        assert_eq!(names.len(), 25);
        let diving = load(&root.join("vot2014/diving"), &Entry::default()).unwrap();
        // grep -c 1 *.label: camera_motion 219, motion_change 54, size_change 74, others 0.
        assert_eq!(diving.attributes, ["camera_motion", "motion_change", "size_change"]);
        let ones = |k: usize| diving.frame_attributes[k].1.iter().filter(|&&f| f).count();
        assert_eq!([0, 1, 2, 3, 4].map(ones), [219, 0, 54, 0, 74]);
    }
}
