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
//! `x` and `y` count pixels from 1 in the file and from 0 in memory. A line of four zeros or with a NaN is a
//! frame without annotation (`None`); other sizes of zero or below are errors. Boxes may leave the image. The
//! ground truth may be longer than the range used but not shorter. It starts at the first official frame;
//! only where it has exactly as many lines as the last official frame's number, and that is more than the
//! official range has frames, it starts at frame 1 (Tiger1 is published both ways).
//!
//! Without an `img` folder the images beside the text files are taken.

use super::files::{numbered_images, take_range};
use super::{DatasetError, Digest, Frames, Numbering, Sequence, text};
use crate::region::Region;
use std::path::{Path, PathBuf};

/// Where the ground truth is.
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

/// How a folder is to be read; the default takes all frames there are.
#[derive(Debug, Clone, Default)]
pub struct Options {
    /// Name of the sequence; the folder's name otherwise.
    pub name: Option<String>,
    /// Which of several targets, counted from 1.
    pub target: Option<u32>,
    /// First and last frame used, in the dataset's numbers; all images otherwise.
    pub range: Option<(u32, u32)>,
    /// First and last frame of the dataset's own range; otherwise from the first image on, as many frames as
    /// the ground truth has lines.
    pub official: Option<(u32, u32)>,
    /// Where the ground truth is.
    pub truth: Truth,
}

/// Loads one sequence. Reads no image, only the list of files and the text.
///
/// # Errors
/// A folder without images, a missing frame, a ground truth that is absent, broken or too short.
pub fn load(folder: &Path, options: &Options) -> Result<Sequence, DatasetError> {
    let img = folder.join("img");
    let image_folder = if img.is_dir() { img } else { folder.to_path_buf() };
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

pub(super) fn folder_name(folder: &Path) -> String {
    // `.` and `..` have no name of their own.
    let whole = folder.canonicalize().unwrap_or_else(|_| folder.to_path_buf());
    whole.file_name().map_or_else(|| "sequence".into(), |n| n.to_string_lossy().into_owned())
}

fn truth_file(folder: &Path, options: &Options) -> PathBuf {
    match (&options.truth, options.target) {
        (Truth::File(path), _) => path.clone(),
        (_, Some(target)) => folder.join(format!("groundtruth_rect.{target}.txt")),
        (_, None) => folder.join("groundtruth_rect.txt"),
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
    if values.iter().any(|v| v.is_nan()) || values.iter().all(|&v| v == 0.0) {
        return Ok(None);
    }
    let region = Region::from_numbers(&values).map_err(|e| e.to_string())?;
    Ok(Some(region.shifted(-1.0, -1.0)))
}

fn cut(
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
    let text = text::read(&path)?;
    let words = text.split([',', '\n']).map(str::trim).filter(|w| !w.is_empty());
    Ok(super::sorted(words.map(String::from)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::region::Rect;
    use proptest::prelude::*;

    fn folder(first: u32, frames: u32, truth: &[u8]) -> tempfile::TempDir {
        let dir = tempfile::tempdir().unwrap();
        let img = dir.path().join("img");
        std::fs::create_dir(&img).unwrap();
        for n in first..first + frames {
            std::fs::write(img.join(format!("{n:04}.jpg")), b"").unwrap();
        }
        std::fs::write(dir.path().join("groundtruth_rect.txt"), truth).unwrap();
        dir
    }

    fn whole(dir: &tempfile::TempDir) -> Result<Sequence, DatasetError> {
        load(dir.path(), &Options::default())
    }

    fn rect(x: f64, y: f64, w: f64, h: f64) -> Option<Region> {
        Some(Region::Rect(Rect::new(x, y, w, h)))
    }

    #[test]
    fn counts_from_one_in_the_file_and_from_zero_in_memory() {
        let dir = folder(1, 3, b"\xEF\xBB\xBF1,1,10,20\r\n-4\t7\t1.5\t2\r\n3 4, 5 6");
        let s = whole(&dir).unwrap();
        assert_eq!(
            s.truth,
            [rect(0.0, 0.0, 10.0, 20.0), rect(-5.0, 6.0, 1.5, 2.0), rect(2.0, 3.0, 5.0, 6.0)]
        );
        assert_eq!(s.numbering, Numbering { first: 1, official: (1, 3) });
    }

    #[test]
    fn not_annotated_is_none() {
        let s = whole(&folder(1, 3, b"1,1,2,2\n0,0,0,0\nNaN,NaN,NaN,NaN\n")).unwrap();
        assert_eq!(s.truth, [rect(0.0, 0.0, 2.0, 2.0), None, None]);
    }

    #[test]
    fn faults_name_file_and_line() {
        for (bad, line) in [
            (&b"1,1,2,2\n1,1,0,2"[..], 2),
            (b"1,1,2,-2\n1,1,2,2", 1),
            (b"1,1,2,2\n1,1,2", 2),
            (b"1,1,2,2,3\n1,1,2,2", 1),
            (b"1,1,2,2\n\xFF\xFE", 2),
            (b"1,1,2,2\n1,1,inf,2", 2),
            (b"1,1,2,2\n\n1,1,2,2", 2),
            (b"x,y,w,h\n1,1,2,2", 1),
        ] {
            match whole(&folder(1, 2, bad)) {
                Err(DatasetError::Line { path, line: n, .. }) => {
                    assert!(path.ends_with("groundtruth_rect.txt"));
                    assert_eq!(n, line, "{}", String::from_utf8_lossy(bad));
                }
                other => panic!("{:?}", other.map(|s| s.truth)),
            }
        }
        for empty in [&b""[..], b"\n\r\n", b"\xEF\xBB\xBF"] {
            assert!(whole(&folder(1, 1, empty)).unwrap_err().to_string().contains("empty"));
        }
    }

    #[test]
    fn the_first_line_is_the_first_official_frame() {
        let dir = folder(3, 4, b"1,1,3,1\n1,1,4,1\n1,1,5,1\n1,1,6,1\n1,1,7,1\n");
        let s = whole(&dir).unwrap();
        assert_eq!((s.numbering.first, s.numbering.official), (3, (3, 7)));
        assert_eq!(s.truth[1], rect(0.0, 0.0, 4.0, 1.0));
        let cut = Options { range: Some((4, 5)), official: Some((3, 7)), ..Options::default() };
        let s = load(dir.path(), &cut).unwrap();
        assert_eq!((s.len(), s.number(0)), (2, 4));
        assert_eq!(s.truth[0], rect(0.0, 0.0, 4.0, 1.0));
        // Five lines for official frames 3..=5: counted from 1.
        let other = Options { range: Some((4, 5)), official: Some((3, 5)), ..Options::default() };
        assert_eq!(load(dir.path(), &other).unwrap().truth[0], rect(0.0, 0.0, 6.0, 1.0));
        let outside = Options { range: Some((2, 4)), ..Options::default() };
        assert!(load(dir.path(), &outside).unwrap_err().to_string().contains("frame 2 is missing"));
    }

    #[test]
    fn a_short_ground_truth_is_an_error() {
        let error = whole(&folder(1, 3, b"1,1,2,2\n1,1,2,2\n")).unwrap_err().to_string();
        assert!(error.contains("2 lines") && error.contains("1 to 3"), "{error}");
    }

    #[test]
    fn targets_attributes_and_plain_folders() {
        let dir = folder(1, 1, b"1,1,2,2");
        std::fs::write(dir.path().join("groundtruth_rect.2.txt"), "1,1,7,7").unwrap();
        std::fs::write(dir.path().join("attributes.txt"), "occlusion, blur\nblur\n").unwrap();
        let options = Options { name: Some("Two-2".into()), target: Some(2), ..Options::default() };
        let s = load(dir.path(), &options).unwrap();
        assert_eq!((s.name.as_str(), &s.truth[0]), ("Two-2", &rect(0.0, 0.0, 7.0, 7.0)));
        assert_eq!(s.attributes, ["blur", "occlusion"]);

        let plain = tempfile::tempdir().unwrap();
        ["a.png", "b.png"].iter().for_each(|n| std::fs::write(plain.path().join(n), b"").unwrap());
        assert!(matches!(whole(&plain), Err(DatasetError::Io { .. })));
        let options = Options { truth: Truth::Ignored, ..Options::default() };
        // Whatever else lies there does not matter.
        std::fs::write(plain.path().join("groundtruth_rect.txt"), "1,2").unwrap();
        std::fs::write(plain.path().join("attributes.txt"), b"\xFF").unwrap();
        let s = load(plain.path(), &options).unwrap();
        assert_eq!((s.len(), s.truth, s.numbering.official), (2, vec![None, None], (1, 2)));
    }

    // Values read off groundtruth_rect.txt and OTB2013.json (an independent copy of the annotation).
    #[trackfail_testing::needs(real_data)]
    #[test]
    fn real_sequences() {
        let root = trackfail_testing::real_data();
        let david = load(&root.join("otb/David"), &Options::default()).unwrap();
        assert_eq!((david.len(), david.numbering.official), (201, (300, 770)));
        assert_eq!(david.truth[0], rect(128.0, 79.0, 64.0, 78.0));
        let frame = david.frame(200).unwrap();
        assert_eq!((frame.width(), frame.height()), (320, 240));
        let second = Options { target: Some(2), ..Options::default() };
        let jogging = load(&root.join("otb/Jogging"), &second).unwrap();
        assert_eq!((jogging.len(), &jogging.truth[0]), (307, &rect(179.0, 78.0, 37.0, 114.0)));
        let woman = load(&root.join("otb/Woman"), &Options::default()).unwrap();
        assert_eq!((woman.len(), woman.numbering.official), (150, (1, 597)));
    }

    const VALID: &[u8] = b"\xEF\xBB\xBF1,1,10,20\r\n-4\t7\t1.5\t2\r\n0,0,0,0\nNaN NaN NaN NaN\n3 4, 5 6";

    proptest! {
        #[test]
        fn damaged_truth_is_read_or_refused(bytes in trackfail_testing::damaged(VALID)) {
            if let Ok(truth) = parse_truth(Path::new("a.txt"), &bytes) {
                prop_assert!(truth.iter().flatten().all(|r| r.area() > 0.0));
            }
        }

        #[test]
        fn any_bytes_are_read_or_refused(bytes in prop::collection::vec(any::<u8>(), 0..300)) {
            let _ = whole(&folder(1, 2, &bytes));
        }

        #[test]
        fn any_numbers_are_read_or_refused(text in "[0-9NainF.,;\t\r\n -]{0,60}") {
            if let Ok(s) = whole(&folder(1, 2, text.as_bytes())) {
                prop_assert_eq!(s.truth.len(), 2);
                prop_assert!(s.truth.iter().flatten().all(|r| r.area() > 0.0));
            }
        }
    }
}
