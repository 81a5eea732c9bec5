//! Results of MOTChallenge: one row per frame and target, `frame,id,x,y,w,h,conf,...`.
//!
//! Frames count from 1, the first of the official range, or from 0 in a file that has a frame 0; pixels count
//! from 1. Rows have 7 columns, and up to three more, which are not read. `conf` is the confidence; -1 means
//! "no value", as everywhere in this format. If a frame has no row, the tracker has not found the target.
//! Rows may be in any order.
//!
//! A track has one target. In a file of several targets, `id` must choose one.

use super::rows::{Row, by_target, drop_empty_end};
use super::{Base, Boxes, NoBox, official_span, region};
use std::path::Path;
use trackfail_dataset::{DatasetError, SequenceInfo};

/// Possible numbers of columns.
const COLUMNS: std::ops::RangeInclusive<usize> = 7..=10;
/// Value that means "not given".
const NOT_GIVEN: f64 = -1.0;
/// Largest number of targets that a message lists.
const MAX_LISTED: usize = 8;

/// True if the number of columns of the first row is that of this format. Eight columns are not taken, since
/// they may be a polygon.
pub fn is_mot(rows: &[Row]) -> bool {
    rows.first().is_some_and(|(_, row)| row.len() != 8 && COLUMNS.contains(&row.len()))
}

/// Reads the rows of target `id`, or of the only target; `path` is for messages.
///
/// # Errors
/// When a row has another form, a frame is outside of the official range, a target has two rows in a frame,
/// and when the target is missing or not chosen.
pub fn parse(
    path: &Path,
    mut rows: Vec<Row>,
    sequence: &dyn SequenceInfo,
    base: Base,
    id: Option<i64>,
) -> Result<Boxes, DatasetError> {
    drop_empty_end(&mut rows, |_| false);
    for (line, row) in &rows {
        let message = match row.get(2..7) {
            Some(values) if COLUMNS.contains(&row.len()) => match values.iter().all(|v| v.is_finite()) {
                true => continue,
                false => "a number that is not finite".to_string(),
            },
            _ => format!("{} columns; a row is frame,id,x,y,w,h,conf and has up to 10 columns", row.len()),
        };
        return Err(DatasetError::line(path, *line, message));
    }
    let span = usize::try_from(official_span(sequence.numbering())).ok();
    let (_, targets) = by_target(path, &rows, (0, Some(1)), span, None)?;
    let ids: Vec<String> = targets.keys().flatten().map(i64::to_string).collect();
    let mut listed = ids.iter().take(MAX_LISTED).cloned().collect::<Vec<_>>().join(", ");
    if ids.len() > MAX_LISTED {
        listed += ", ...";
    }
    let mut meant = targets.into_iter().filter(|(target, _)| id.is_none() || *target == id);
    let rows = match (meant.next(), meant.next()) {
        (Some((_, rows)), None) => rows,
        (None, _) => {
            let id = id.unwrap_or_default();
            return Err(DatasetError::content(path, format!("no row of target {id}; there is {listed}")));
        }
        (Some(_), Some(_)) => {
            let message = format!("rows of several targets ({listed}); give the one that is meant, `id = N`");
            return Err(DatasetError::content(path, message));
        }
    };
    let from = u64::from(sequence.numbering().official.0);
    let answer = |(index, (line, row)): (usize, &Row)| {
        let confidence = Some(row[6]).filter(|v| *v != NOT_GIVEN);
        (from + index as u64, (*line, region(&row[2..6], base), confidence))
    };
    Ok(Boxes::of_rows(sequence, rows.into_iter().map(answer).collect(), &NoBox::NoRow))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tracker::results::rows;
    use crate::tracker::testing;
    use trackfail_core::region::{Rect, Region};
    use trackfail_dataset::{Frames, Numbering, Sequence};
    use trackfail_testing::assert_says;

    /// A sequence that uses frames 11 to 13 of the official range 10 to 14.
    fn sequence() -> Sequence {
        let numbering = Numbering { first: 11, official: (10, 14) };
        Sequence { numbering, frames: Frames::Absent, ..testing::rendered("S", 3) }
    }

    fn read(text: &str, id: Option<i64>) -> Result<Boxes, DatasetError> {
        let path = Path::new("S.txt");
        parse(path, rows::read(path, text.as_bytes())?, &sequence(), Base::One, id)
    }

    // SORT's sort.py: print('%d,%d,%.2f,%.2f,%.2f,%.2f,1,-1,-1,-1'%(frame,d[4],d[0],d[1],d[2]-d[0],d[3]-d[1]))
    const WRITTEN: &str = "2,3,5.00,6.00,7.50,8.25,1,-1,-1,-1\n4,3,6.00,6.00,7.50,8.25,-1,-1,-1,-1\n";

    #[test]
    fn rows_of_one_target() {
        let rect = |x| Ok(Region::Rect(Rect::new(x, 5.0, 7.5, 8.25)));
        let zero = "0,3,1,1,1,1,1\n1,3,5,6,7.5,8.25,1\n3,3,6,6,7.5,8.25,-1\n";
        let two = WRITTEN.replace("\n4", "\n2,8,1,1,1,1,0.5,-1,-1,-1\n4");
        for (text, id) in [(WRITTEN, None), (WRITTEN, Some(3)), (&*two, Some(3)), (zero, None)] {
            let boxes = read(text, id).unwrap();
            // With frame 10, before the frames used, where it has a row.
            let before = usize::from(text == zero);
            assert_eq!((boxes.first as usize, boxes.regions.len()), (11 - before, 3 + before));
            let used = &boxes.regions[before..];
            assert_eq!((&used[0], &used[2]), (&rect(4.0), &rect(5.0)));
            assert_eq!(used[1].clone().unwrap_err().source, NoBox::NoRow);
            assert_eq!(boxes.confidence[before..], [Some(1.0), None, None]);
        }
        let known = |text: &str| is_mot(&rows::read(Path::new("S.txt"), text.as_bytes()).unwrap());
        assert!(known(WRITTEN) && known("1,1,2,3,4,5,0.25\r\n"));
        assert!(!known("1,2,3,4") && !known("1") && !known("0,0,9,0,9,9,0,9"));
    }

    #[test]
    fn faults_are_told() {
        for (text, id, words) in [
            ("2,3,5,6,7,8,1\n3,4,5,6,7,8,1", None, "several targets (3, 4)"),
            ("2,3,5,6,7,8,1", Some(4), "no row of target 4; there is 3"),
            ("2,3,5,6,7,8,1\n2,3,5,6,7,8,1", None, "line 2: a second row of target 3 in frame 2"),
            ("6,3,5,6,7,8,1", None, "line 1: frame 6, but there are 5 frames, counted from 1"),
            ("0,3,5,6,7,8,1\n5,3,5,6,7,8,1", None, "line 2: frame 5, but there are 5 frames, counted from 0"),
            ("-1,3,5,6,7,8,1", None, "whole numbers"),
            ("1.5,3,5,6,7,8,1", None, "whole numbers"),
            ("2,3,5,6,7,8", None, "6 columns"),
            ("2,3,5,6,7,8,1\n\n3,3,5,6,7,8,1", None, "line 2: 0 columns"),
            ("2,3,5,nan,7,8,1", None, "not finite"),
            ("2,3,5,6,7,8,1,1,1,1,1", None, "10 columns"),
        ] {
            assert_says(read(text, id).unwrap_err(), words);
        }
    }
}
