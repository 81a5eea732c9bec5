//! Result files of the VOT reset protocol (VOT2014 and its toolkit): one line per frame.
//!
//! A line with one number is a mark: `1`, initialized with the ground truth; `2`, failure in this frame; `0`,
//! skipped or unknown. Other lines are regions: 4 values `x,y,w,h` or the corners of a polygon, in the ground
//! truth's coordinates, which count from 0 unless the caller gives another [`Base`]. The box of the failure
//! is not in the file, so frames marked `2` or `0` repeat the last region, with the status [`Status::Failed`]
//! or [`Status::Skipped`].

use super::rows::{Row, drop_empty_end};
use super::{Base, region};
use crate::tracker::{Status, TrackerState};
use std::path::Path;
use trackfail_core::region::Region;
use trackfail_dataset::DatasetError;

const NO_START: &str = "the run does not begin with an initialization (a line `1`)";

/// Reads one run. `path` is for messages, `base` is the number of the top left pixel in the file. `truth` is
/// the ground truth of the sequence, one 0-based entry per frame. `without_box` is the status of a frame
/// whose line is empty, has NaN or no area; its region repeats the last one. If it is `None`, such lines are
/// errors.
///
/// # Errors
/// When the number of lines is not the number of frames, for other marks, numbers that are not a region, a
/// mark before the first initialization, and an initialization in a frame without ground truth.
pub fn parse(
    path: &Path,
    mut rows: Vec<Row>,
    truth: &[Option<Region>],
    base: Base,
    without_box: Option<Status>,
) -> Result<Vec<TrackerState>, DatasetError> {
    drop_empty_end(&mut rows, |n| n == truth.len());
    if rows.len() != truth.len() {
        let message = format!(
            "{} lines for {} frames; none is made up or dropped, so the file or the sequence is another one",
            rows.len(),
            truth.len()
        );
        return Err(DatasetError::content(path, message));
    }
    let mut states: Vec<TrackerState> = Vec::with_capacity(rows.len());
    for ((line, row), truth) in rows.iter().zip(truth) {
        let fault = |message: &str| DatasetError::line(path, *line, message);
        let repeat = |status| match states.last() {
            Some(last) => Ok(TrackerState::new(last.region.clone(), status)),
            None => Err(fault(NO_START)),
        };
        let state = match row[..] {
            [1.0] => match truth {
                Some(region) => TrackerState::initialized(region.clone()),
                None => return Err(fault("an initialization in a frame without ground truth")),
            },
            [2.0] => repeat(Status::Failed)?,
            [0.0] => repeat(Status::Skipped)?,
            [_] => return Err(fault("a mark is 0 (skipped), 1 (initialized) or 2 (failure)")),
            _ if states.is_empty() => return Err(fault(NO_START)),
            _ => match (region(row, base), without_box) {
                (Ok(region), _) => TrackerState::tracked(region),
                (Err(reason), Some(status)) if reason.may_be_absence() => repeat(status)?,
                (Err(reason), _) => return Err(fault(&reason.to_string())),
            },
        };
        states.push(state);
    }
    Ok(states)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tracker::results::rows;
    use trackfail_core::region::Rect;

    fn rect(x: f64) -> Region {
        Region::Rect(Rect::new(x, 0.0, 1.0, 1.0))
    }

    fn read_text(text: &[u8], frames: usize) -> Result<Vec<TrackerState>, DatasetError> {
        let mut truth: Vec<_> = (0..frames).map(|t| Some(rect(t as f64))).collect();
        if let Some(last) = truth.get_mut(7) {
            *last = None;
        }
        let path = Path::new("S_001.txt");
        parse(path, rows::read(path, text)?, &truth, Base::Zero, None)
    }

    #[test]
    fn marks_and_regions() {
        let states = read_text(b"1\r\n9,0,1,1\r\n2\r\n0\r\n1\r\n0,0,0,5,6,5,6,0", 6).unwrap();
        let (status, regions): (Vec<_>, Vec<_>) = states.into_iter().map(|s| (s.status, s.region)).unzip();
        let polygon = Region::Polygon(vec![(0.0, 0.0), (0.0, 5.0), (6.0, 5.0), (6.0, 0.0)]);
        use Status::{Failed, Initialized, Skipped, Tracked};
        assert_eq!(status, [Initialized, Tracked, Failed, Skipped, Initialized, Tracked]);
        assert_eq!(regions, [rect(0.0), rect(9.0), rect(9.0), rect(9.0), rect(4.0), polygon]);
    }

    #[test]
    fn faults_name_the_line() {
        let second = ["3", "1.5", "nan", "1,2,3", "1,2,0,3", "nan,nan,nan,nan", "1,2,inf,3", "\u{b7}"];
        let second = second.map(|line| (format!("1\n{line}"), 2));
        let others = [("0\n1", 1), ("2\n1", 1), ("5,5,1,1\n1", 1), ("1\n0\n0\n0\n0\n0\n0\n1", 8)];
        for (text, line) in others.map(|(text, line)| (text.to_string(), line)).into_iter().chain(second) {
            match read_text(text.as_bytes(), text.lines().count()) {
                Err(DatasetError::Line { line: n, .. }) => assert_eq!(n, line, "{text}"),
                other => panic!("{text}: {other:?}"),
            }
        }
        assert!(read_text(b"1\n0", 3).unwrap_err().to_string().contains("2 lines for 3"));
        assert!(read_text(b"1\n0\n0\n0", 3).is_err());
        assert!(read_text(b"", 0).is_err());
    }
}
