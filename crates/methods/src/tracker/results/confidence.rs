//! Files with a tracker's own confidence beside the file of boxes: one number per line, one line per frame.
//!
//! | file beside `<name>.txt` | written by |
//! |---|---|
//! | `<name>_confidence.value` | pysot's long-term runs (`%.6f`; the first line is empty), the VOT toolkit |
//! | `<name>_<property>.value` | the VOT toolkit, for each property that the tracker gives over TraX |
//! | `<name>_object_presence_scores.txt` | pytracking (`%f`; the first frame has 1) |
//! | `<name>_all_scores.txt` | STARK and what is built on it (`%.2f`; no line for the first frame) |
//! | `<name>_scores.txt` beside `<name>_bboxes.txt` | long-term runs of SiamFC; the first frame has 10000 |
//!
//! An empty line or NaN means that the frame has no value. Only STARK's file may have one line fewer than
//! there are boxes: it has no line for the first frame, in which the target was given. In other files a
//! missing line is an error, since it may be missing anywhere. A high value means that the tracker is sure;
//! the scale depends on the tracker.

use super::rows;
use std::path::{Path, PathBuf};
use trackfail_dataset::DatasetError;

/// End of the names of files without a line for the first frame.
const WITHOUT_FIRST: &str = "_all_scores.txt";

/// Ends of the names of files with a confidence.
const ENDS: [&str; 4] = ["_confidence.value", "_object_presence_scores.txt", WITHOUT_FIRST, "_scores.txt"];

/// End of the name of a file of boxes whose scores are in a separate file.
pub const BOXES_END: &str = "_bboxes";

/// Files beside a file of boxes that may have the confidence; with a `property`, only files of that name.
pub fn beside(boxes: &Path, property: Option<&str>) -> Vec<PathBuf> {
    let stem = boxes.file_stem().unwrap_or_default().to_string_lossy();
    let name = stem.strip_suffix(BOXES_END).unwrap_or(&stem);
    let ends = match property {
        None => ENDS.map(str::to_string).to_vec(),
        Some(property) => vec![format!("_{property}.value"), format!("_{property}.txt")],
    };
    ends.iter().map(|end| boxes.with_file_name(format!("{name}{end}"))).collect()
}

/// The confidence of each frame; `path` is for messages.
///
/// # Errors
/// When a line is neither empty nor one number, for infinity, and when the number of lines is wrong.
pub fn parse(path: &Path, bytes: &[u8], frames: usize) -> Result<Vec<Option<f64>>, DatasetError> {
    let mut rows = rows::read(path, bytes)?;
    let read = rows.len();
    // A frame without a value at the end is an empty line as well, so no more of them are dropped than is needed.
    if read > frames {
        rows::drop_empty_end(&mut rows, |n| n == frames);
    }
    let value = |(line, row): rows::Row| match row[..] {
        [] => Ok(None),
        [value] => Ok(Some(value).filter(|v| !v.is_nan())),
        _ => {
            let message = format!("{} numbers; one confidence a line was expected", row.len());
            Err(DatasetError::line(path, line, message))
        }
    };
    let mut values = rows.into_iter().map(value).collect::<Result<Vec<Option<f64>>, _>>()?;
    if values.len() + 1 == frames && path.as_os_str().as_encoded_bytes().ends_with(WITHOUT_FIRST.as_bytes()) {
        values.insert(0, None);
    }
    if values.len() != frames {
        let message = format!(
            "{read} values for {frames} boxes; there must be a line for each box, an empty one where there is no value"
        );
        return Err(DatasetError::content(path, message));
    }
    Ok(values)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: &str, frames: usize) -> Result<Vec<Option<f64>>, DatasetError> {
        parse(Path::new("S_001_confidence.value"), text.as_bytes(), frames)
    }

    // STARK: np.savetxt(file, scores, delimiter='\t', fmt='%.2f'), without the first frame
    #[test]
    fn only_stark_leaves_the_first_frame_out() {
        let short = |name: &str| parse(Path::new(name), b"1.00\n0.25\n", 3).map_err(|e| e.to_string());
        assert_eq!(short("r/S_all_scores.txt").unwrap(), [None, Some(1.0), Some(0.25)]);
        for name in ["S_confidence.value", "S_object_presence_scores.txt", "S_scores.txt", "mine.txt"] {
            let error = short(name).unwrap_err();
            assert!(error.contains(name) && error.contains("2 values for 3 boxes"), "{error}");
        }
    }

    // What the tools write for scores of .9987654, (none) and .25 after a first frame without a score.
    #[test]
    fn files_of_the_tools() {
        for (text, want) in [
            // pysot, tools/test.py: '\n' for None, else "{:.6f}\n".format(x)
            ("\n0.998765\n0.250000\n", vec![None, Some(0.998765), Some(0.25)]),
            // vot-toolkit 0.7.3, Trajectory.write: to_string(e) + "\n", where None is ""
            ("\n0.9987654\n\n0.25\n", vec![None, Some(0.9987654), None, Some(0.25)]),
            ("1.0\n0.9987654\n\n", vec![Some(1.0), Some(0.9987654), None]),
            // pytracking: np.savetxt(file, scores, delimiter='\t', fmt='%f')
            ("1.000000\n0.998765\n0.250000\n", vec![Some(1.0), Some(0.998765), Some(0.25)]),
            // SiamFC: a large number in the first frame
            ("10000\n9.851159\n", vec![Some(10000.0), Some(9.851159)]),
            ("1\r\nnan\r\n-1e-3", vec![Some(1.0), None, Some(-1e-3)]),
        ] {
            assert_eq!(read(text, want.len()).unwrap(), want, "{text:?}");
        }
    }

    #[test]
    fn the_number_of_lines_is_checked() {
        assert_eq!(read("\n0.5\n\n\n", 3).unwrap(), [None, Some(0.5), None]);
        assert_eq!(read("0.5\n\n\n", 1).unwrap(), [Some(0.5)]);
        for (text, frames, words) in [
            ("0.5\n0.5\n", 1, "2 values for 1 boxes"),
            ("0.5\n", 3, "1 values for 3 boxes"),
            ("\n\n", 2, "the file is empty"),
            ("", 0, "the file is empty"),
        ] {
            let error = read(text, frames).unwrap_err().to_string();
            assert!(error.contains(words) && error.contains("S_001_confidence.value"), "{error}");
        }
    }

    #[test]
    fn faults_name_the_line() {
        for bad in ["1,2", "x", "inf", "-inf", "0.5 0.6", "1,", "None"] {
            let error = read(&format!("\n{bad}\n1\n"), 3).unwrap_err();
            assert!(matches!(error, DatasetError::Line { line: 2, .. }), "{bad}: {error}");
        }
    }

    #[test]
    fn names_of_files() {
        let names = |boxes: &str, property| -> Vec<String> {
            beside(Path::new(boxes), property).iter().map(|p| p.display().to_string()).collect()
        };
        assert_eq!(
            names("r/S/S_001.txt", None)[..2],
            ["r/S/S_001_confidence.value", "r/S/S_001_object_presence_scores.txt"]
        );
        assert_eq!(names("r/S_bboxes.txt", None)[3], "r/S_scores.txt");
        assert_eq!(names("S.txt", Some("motion")), ["S_motion.value", "S_motion.txt"]);
    }
}
