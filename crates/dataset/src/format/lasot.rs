//! Sequences in the layout of LaSOT (Fan et al.: LaSOT: A High-quality Benchmark for Large-scale Single Object
//! Tracking, CVPR 2019).
//!
//! ```text
//! airplane/airplane-1/img/00000001.jpg ...      frames from 1 on
//! airplane/airplane-1/groundtruth.txt           x,y,w,h per line, one line per frame
//! airplane/airplane-1/full_occlusion.txt        all frames on one line, commas between: 1 where it is hidden
//! airplane/airplane-1/out_of_view.txt           the same: 1 where it has left the image
//! airplane/airplane-1/nlp.txt                   a sentence about the target; not read
//! ```
//!
//! Coordinates count pixels from 1 (the authors, HengLan/LaSOT_Evaluation_Toolkit#14) and are counted from 0 in
//! memory; the later 150 sequences have some boxes at 0, which are taken alike. A frame has no truth where
//! either label is 1, which the authors' evaluation leaves out too, and where the box is of NaN alone or has no area: the
//! published annotation has a few of those (frame 553 of lion-5 is `1,1,-1,-1`, frame 118 of tiger-6
//! `613,731,247,-11`), and a size below zero is no other kind of box.
//!
//! Frame attributes are `full_occlusion` and `out_of_view`; sequence attributes, those that some frame has.
//! Either file may be missing; its attribute is then missing, too. Images, lines of truth and labels must be
//! equal in number.

use super::shared::{boxes, flags, name_of, one_based, read_rows, regions, sequence};
use super::{FormatEntry, GROUND_TRUTH};
use crate::lock::Entry;
use crate::{DatasetError, Sequence};
use std::path::Path;
use trackfail_core::region::Region;

/// LaSOT in the list of formats.
pub const FORMAT: FormatEntry = FormatEntry {
    word: "lasot",
    summary: "`img/00000001.jpg` and `groundtruth.txt`, boxes from pixel 1 on, labels of occlusion",
    load,
    parse_truth: |path, bytes| boxes(path, bytes, with_area),
    image_folders: &["img"],
    reads: |name| {
        name == GROUND_TRUTH || name.strip_suffix(".txt").is_some_and(|label| LABELS.contains(&label))
    },
    ..FormatEntry::BASE
};

/// Names of the label files, without `.txt`.
const LABELS: [&str; 2] = ["full_occlusion", "out_of_view"];

/// Loads one sequence. Reads the list of files and the text, no image.
///
/// # Errors
/// Missing frames, a broken or absent ground truth, and files of another length than the ground truth.
pub fn load(root: &Path, entry: &Entry) -> Result<Sequence, DatasetError> {
    let folder = entry.path(root);
    let (path, rows) = read_rows(&folder)?;
    let mut attributes: Vec<(String, Vec<bool>)> = Vec::new();
    for label in LABELS {
        let found = flags(&folder.join(format!("{label}.txt")), rows.len())?;
        attributes.extend(found.map(|flags| (label.to_owned(), flags)));
    }
    let is_absent = |t: usize| attributes.iter().any(|(_, flags)| flags[t]);
    let truth = regions(&path, rows, is_absent, with_area)?;
    sequence(FORMAT.images(&folder)?, name_of(&folder, entry), truth, attributes, Vec::new())
}

/// Converts a box that counts pixels from 1; `None` if the box has no area.
fn with_area(row: [f64; 4]) -> Result<Option<Region>, String> {
    let [_, _, w, h] = row;
    if row.iter().all(|v| v.is_finite()) && (w <= 0.0 || h <= 0.0) { Ok(None) } else { one_based(row) }
}

#[cfg(test)]
mod tests {
    use super::super::tests::{changed, place, read, rect};

    #[test]
    fn truth_and_labels() {
        let dir = changed("lasot", &[]);
        ::image::RgbImage::new(8, 6).save(dir.path().join("img/00000001.jpg")).unwrap();
        let s = read("lasot", &dir).unwrap();
        assert_eq!(s.truth, [rect(366.0, 100.0, 41.0, 16.0), rect(365.0, 102.0, 45.0, 16.0), None, None]);
        assert_eq!(s.frame_attributes[0], ("full_occlusion".into(), vec![false, false, true, false]));
        assert_eq!(s.frame_attributes[1], ("out_of_view".into(), vec![false, false, false, true]));
        assert_eq!(s.attributes, ["full_occlusion", "out_of_view"]);
        assert_eq!((s.numbering.official, s.size().unwrap()), ((1, 4), (8, 6)));
        let plain = read("lasot", &place("lasot", 1..=1, &[("groundtruth.txt", "0,0,3,3")])).unwrap();
        assert_eq!((plain.truth, plain.frame_attributes.len()), (vec![rect(-1.0, -1.0, 3.0, 3.0)], 0));
    }

    // What is published of tiger-6 and of frames in which nobody marked the target.
    #[test]
    fn boxes_without_area_are_no_truth() {
        let text = "1,1,2,2\n613,731,247,-11\n5,5,0,3\nNaN,NaN,NaN,NaN";
        let none =
            [("groundtruth.txt", text), ("full_occlusion.txt", "0,0,0,0"), ("out_of_view.txt", "0 0 0 0")];
        let s = read("lasot", &changed("lasot", &none)).unwrap();
        assert_eq!(s.truth.iter().flatten().count(), 1);
        assert!(s.attributes.is_empty());
    }
}
