//! Result files of the VOT reset protocol (VOT2014 and its toolkit): one line per frame.
//!
//! A line with one number is a mark: `1`, initialized with the ground truth; `2`, failure in this frame; `0`,
//! skipped or unknown. Other lines are regions: 4 values `x,y,w,h` or the corners of a polygon, in the
//! ground truth's coordinates, which count from 0 unless the caller gives another [`Base`]. The failed box is not in
//! the file, so frames marked `2` and `0` repeat the last region, with the status [`Status::Failed`] or
//! [`Status::Skipped`].

use super::{Base, NoBox, drop_empty_end};
use crate::tracker::{Status, TrackerState};
use std::path::Path;
use trackfail_core::region::Region;
use trackfail_dataset::{DatasetError, text};

/// Reads one run; `truth` is the sequence's, one entry a frame.
///
/// # Errors
/// Another number of lines than frames, other marks, numbers that are not a region, a mark before the first
/// initialization, and an initialization in a frame without ground truth.
pub fn read(path: &Path, truth: &[Option<Region>]) -> Result<Vec<TrackerState>, DatasetError> {
    parse(path, &text::read_capped(path)?, truth)
}

/// As [`read`], from the file's bytes; `path` names it in messages.
///
/// # Errors
/// As [`read`].
pub fn parse(path: &Path, bytes: &[u8], truth: &[Option<Region>]) -> Result<Vec<TrackerState>, DatasetError> {
    parse_from(path, bytes, truth, Base::Zero, None)
}

/// As [`parse`]; `base` is the file's index of the left top pixel. The truth is 0-based. `without_box` is the status of a
/// frame whose line is empty, has NaN or no area, and whose region repeats the last one; without it they are errors.
///
/// # Errors
/// As [`read`].
pub fn parse_from(
    path: &Path,
    bytes: &[u8],
    truth: &[Option<Region>],
    base: Base,
    without_box: Option<Status>,
) -> Result<Vec<TrackerState>, DatasetError> {
    let mut rows = text::lines_or_empty(path, text::decode(path, bytes)?)?;
    drop_empty_end(&mut rows, |(_, line)| line.is_empty(), |n| n == truth.len());
    if rows.len() != truth.len() {
        let message = format!(
            "{} lines for {} frames; none is made up or dropped, so the file or the sequence is another one",
            rows.len(),
            truth.len()
        );
        return Err(DatasetError::content(path, message));
    }
    let mut states: Vec<TrackerState> = Vec::with_capacity(rows.len());
    for ((line, row), truth) in rows.into_iter().zip(truth) {
        let fault = |message: &str| DatasetError::line(path, line, message);
        let last = states.last().map(|s| s.region.clone());
        let repeat = |status| match last {
            Some(region) => Ok(TrackerState::new(region, status)),
            None => Err(fault("the run does not begin with an initialization (a line `1`)")),
        };
        let values = match row {
            "" => Vec::new(),
            _ => text::numbers(row).map_err(|e| fault(&e.to_string()))?,
        };
        states.push(match values[..] {
            [1.0] => match truth {
                Some(region) => TrackerState::initialized(region.clone()),
                None => return Err(fault("an initialization in a frame without ground truth")),
            },
            [2.0] => repeat(Status::Failed)?,
            [0.0] => repeat(Status::Skipped)?,
            [_] => return Err(fault("a mark is 0 (skipped), 1 (initialized) or 2 (failure)")),
            _ if states.is_empty() => {
                return Err(fault("the run does not begin with an initialization (a line `1`)"));
            }
            _ => {
                let no_box = match Region::from_numbers(&values) {
                    Ok(region) => {
                        states.push(TrackerState::tracked(base.to_zero(region)));
                        continue;
                    }
                    Err(_) if row.is_empty() => NoBox::EmptyLine,
                    Err(e) => e.into(),
                };
                match without_box.filter(|_| no_box.may_be_absence()) {
                    Some(status) => repeat(status)?,
                    None => return Err(fault(&no_box.to_string())),
                }
            }
        });
    }
    Ok(states)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use trackfail_core::region::Rect;

    fn rect(x: f64) -> Region {
        Region::Rect(Rect::new(x, 0.0, 1.0, 1.0))
    }

    fn read_text(text: &[u8], frames: usize) -> Result<Vec<TrackerState>, DatasetError> {
        let f = tempfile::NamedTempFile::new().unwrap();
        std::fs::write(f.path(), text).unwrap();
        let mut truth: Vec<_> = (0..frames).map(|t| Some(rect(t as f64))).collect();
        if let Some(last) = truth.get_mut(7) {
            *last = None;
        }
        read(f.path(), &truth)
    }

    #[test]
    fn marks_and_regions() {
        let states = read_text(b"1\r\n9,0,1,1\r\n2\r\n0\r\n1\r\n0,0,0,5,6,5,6,0", 6).unwrap();
        let what: Vec<_> = states.iter().map(|s| (s.status, s.region.clone())).collect();
        let polygon = Region::Polygon(vec![(0.0, 0.0), (0.0, 5.0), (6.0, 5.0), (6.0, 0.0)]);
        use Status::{Failed, Initialized, Skipped, Tracked};
        assert_eq!(
            what,
            [
                (Initialized, rect(0.0)),
                (Tracked, rect(9.0)),
                (Failed, rect(9.0)),
                (Skipped, rect(9.0)),
                (Initialized, rect(4.0)),
                (Tracked, polygon)
            ]
        );
    }

    #[test]
    fn faults_name_the_line() {
        for (text, line) in [
            ("1\n3", 2),
            ("1\n1.5", 2),
            ("1\nnan", 2),
            ("0\n1", 1),
            ("2\n1", 1),
            ("5,5,1,1\n1", 1),
            ("1\n1,2,3", 2),
            ("1\n1,2,0,3", 2),
            ("1\nnan,nan,nan,nan", 2),
            ("1\n1,2,inf,3", 2),
            ("1\n\u{b7}", 2),
            ("1\n0\n0\n0\n0\n0\n0\n1", 8),
        ] {
            match read_text(text.as_bytes(), text.lines().count()) {
                Err(DatasetError::Line { line: n, .. }) => assert_eq!(n, line, "{text}"),
                other => panic!("{text}: {other:?}"),
            }
        }
        assert!(read_text(b"1\n0", 3).unwrap_err().to_string().contains("2 lines for 3"));
        assert!(read_text(b"1\n0\n0\n0", 3).is_err());
        assert!(read_text(b"", 0).is_err());
    }

    // Failures the official VOT toolkit counts on all 25 sequences, summed over sequences, mean over runs:
    // GOTURN 36, PFTracker 118, CFTTracker 64.
    #[trackfail_testing::needs(real_data)]
    #[test]
    fn real_results_have_the_failures_of_the_vot_toolkit() {
        let root = trackfail_testing::real_data();
        let suite = trackfail_dataset::suite::Catalog::default().suite("vot2014").unwrap();
        for (folder, runs, failures) in [
            ("GOTURN/baseline", 3, 36),
            ("PFTracker/baseline_lite", 1, 118),
            ("CFTTracker/baseline_lite", 1, 64),
        ] {
            let mut failed = 0;
            for entry in suite.entries() {
                let truth = vec![Some(rect(0.0)); entry.frames.unwrap()];
                for run in 1..=runs {
                    let name = &entry.name;
                    let path = root.join(format!("results/vot2014/{folder}/{name}/{name}_{run:03}.txt"));
                    let states = read(&path, &truth).unwrap();
                    failed += states.iter().filter(|s| s.status == Status::Failed).count();
                }
            }
            assert_eq!(failed, failures * runs, "{folder}");
        }
    }

    const VALID: &[u8] = b"1\r\n9,0,1,1\r\n2\n0\n1\n0,0,0,5,6,5,6,0\n";

    proptest! {
        #[test]
        fn damaged_runs_are_read_or_refused(bytes in trackfail_testing::damaged(VALID)) {
            if let Ok(states) = parse(Path::new("a.txt"), &bytes, &vec![Some(rect(1.0)); 6]) {
                prop_assert_eq!(states.len(), 6);
            }
        }

        #[test]
        fn any_bytes_are_read_or_refused(bytes in prop::collection::vec(any::<u8>(), 0..300)) {
            let _ = read_text(&bytes, 3);
        }

        #[test]
        fn any_marks_are_read_or_refused(text in "1\n([0-2]\n|[0-9.,]{0,20}\n){0,5}") {
            let frames = text.lines().count();
            if let Ok(states) = read_text(text.as_bytes(), frames) {
                prop_assert_eq!(states.len(), frames);
            }
        }
    }
}
