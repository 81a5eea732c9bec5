//! Results of MOTChallenge: a row for each frame and target, `frame,id,x,y,w,h,conf,...`.
//!
//! Frames count from 1, the first of the official range, or from 0 in a file that has a frame 0; pixels count from 1. Rows
//! have 7 columns, and up to three more, which are not read; `conf` is the confidence, or -1 where there is none, as
//! everywhere in this format. A frame without a row is one in which the tracker has not found the target. Rows may be in
//! any order.
//!
//! A track is of one target. In a file of several, `id` has to name it.

use super::{Base, BoxError, Boxes, NoBox};
use std::collections::BTreeSet;
use std::path::Path;
use trackfail_core::region::Region;
use trackfail_dataset::{DatasetError, SequenceInfo, text};

/// Numbers of columns of a row.
const COLUMNS: std::ops::RangeInclusive<usize> = 7..=10;
/// A value that is not given.
const NOT_GIVEN: f64 = -1.0;
/// Identities that a message lists.
const MAX_LISTED: usize = 8;

/// Whether a text is of this format, by the columns of its first line. A line of eight may be a polygon, too.
pub fn is_mot(bytes: &[u8]) -> bool {
    let first = bytes.split(|b| *b == b'\n').next().unwrap_or_default();
    let numbers = std::str::from_utf8(first).ok().and_then(|line| text::numbers(line.trim()).ok());
    numbers.is_some_and(|v| v.len() != 8 && COLUMNS.contains(&v.len()))
}

/// Reads the rows of one target, the one of number `id` or the only one; `path` names the file in messages.
///
/// # Errors
/// Rows of another form, frames outside the official range, two rows of one frame, and no target or several.
pub fn parse(
    path: &Path,
    bytes: &[u8],
    sequence: &dyn SequenceInfo,
    base: Base,
    id: Option<i64>,
) -> Result<Boxes, DatasetError> {
    let (first, count) = (sequence.numbering().first, sequence.frames());
    let (from, to) = sequence.numbering().official;
    let no_row = |k: usize| {
        Err(BoxError { at: format!("frame {}", u64::from(first) + k as u64), source: NoBox::NoRow })
    };
    let mut boxes = Boxes { first, regions: (0..count).map(no_row).collect(), confidence: vec![None; count] };
    let mut ids = BTreeSet::new();
    let mut rows = Vec::new();
    for (n, line) in text::lines(path, text::decode(path, bytes)?)? {
        let fault = |message: String| DatasetError::line(path, n, message);
        let values = text::numbers(line).map_err(|e| fault(e.to_string()))?;
        let &[frame, target, x, y, w, h, conf, ..] = values.as_slice() else {
            return Err(fault(format!("{} columns; a row is frame,id,x,y,w,h,conf,...", values.len())));
        };
        let numbers = (whole(frame), whole(target));
        let (Some(frame), Some(target)) = numbers else {
            return Err(fault("frame and id are whole numbers".into()));
        };
        if values.len() > *COLUMNS.end() || [x, y, w, h, conf].iter().any(|v| !v.is_finite()) {
            return Err(fault("more than 10 columns, or a number that is not finite".into()));
        }
        ids.insert(target);
        rows.push((n, frame, target, [x, y, w, h], conf));
    }
    let start = i64::from(rows.iter().all(|(_, frame, ..)| *frame != 0));
    let mut seen = BTreeSet::new();
    for (n, frame, target, numbers, conf) in rows.into_iter().filter(|row| id.is_none_or(|id| id == row.2)) {
        let fault = |message: String| DatasetError::line(path, n, message);
        let number = i64::from(from) + frame - start;
        if frame < start || number > i64::from(to) {
            let end = i64::from(to) - i64::from(from) + start;
            return Err(fault(format!("frame {frame} is outside {}'s {start} to {end}", sequence.name())));
        }
        if !seen.insert((target, frame)) {
            return Err(fault(format!("a second row of target {target} in frame {frame}")));
        }
        let Some(k) = usize::try_from(number - i64::from(first)).ok().filter(|k| *k < count) else {
            continue;
        };
        let region = Region::from_numbers(&numbers).map(|r| base.to_zero(r));
        boxes.regions[k] = region.map_err(|e| BoxError { at: format!("line {n}"), source: e.into() });
        boxes.confidence[k] = Some(conf).filter(|v| *v != NOT_GIVEN);
    }
    match (id, ids.len()) {
        (Some(id), _) if !ids.contains(&id) => {
            let message = format!("no row of target {id}; there is {}", listed(&ids));
            Err(DatasetError::content(path, message))
        }
        (None, 2..) => {
            let message =
                format!("rows of several targets ({}); give the one that is meant, `id = N`", listed(&ids));
            Err(DatasetError::content(path, message))
        }
        _ => Ok(boxes),
    }
}

/// A number without a fraction, exactly.
fn whole(value: f64) -> Option<i64> {
    (value.fract() == 0.0 && value.abs() < 1e9).then_some(value as i64)
}

fn listed(ids: &BTreeSet<i64>) -> String {
    let mut words: Vec<String> = ids.iter().take(MAX_LISTED).map(i64::to_string).collect();
    if ids.len() > MAX_LISTED {
        words.push("...".into());
    }
    words.join(", ")
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use trackfail_core::region::Rect;
    use trackfail_dataset::{Frames, Numbering, Sequence};

    /// Frames 11 to 13 of official 10 to 14.
    fn sequence() -> Sequence {
        Sequence {
            name: "S".into(),
            numbering: Numbering { first: 11, official: (10, 14) },
            truth: vec![Some(Region::Rect(Rect::new(9.0, 9.0, 9.0, 9.0))); 3],
            attributes: vec![],
            frame_attributes: vec![],
            digest: "0".into(),
            frames: Frames::Absent,
        }
    }

    fn read(text: &str, id: Option<i64>) -> Result<Boxes, DatasetError> {
        parse(Path::new("S.txt"), text.as_bytes(), &sequence(), Base::One, id)
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
            assert_eq!((&boxes.regions[0], &boxes.regions[2]), (&rect(4.0), &rect(5.0)));
            assert_eq!(boxes.regions[1].clone().unwrap_err().source, NoBox::NoRow);
            assert_eq!(boxes.confidence, [Some(1.0), None, None]);
        }
        assert!(is_mot(WRITTEN.as_bytes()) && is_mot(b"1,1,2,3,4,5,0.25\r\n"));
        for other in ["1,2,3,4", "1", "", "x,y,w,h,a,b,c", "0,0,9,0,9,9,0,9"] {
            assert!(!is_mot(other.as_bytes()), "{other}");
        }
    }

    #[test]
    fn faults_are_told() {
        for (text, id, words) in [
            ("2,3,5,6,7,8,1\n3,4,5,6,7,8,1", None, "several targets (3, 4)"),
            ("2,3,5,6,7,8,1", Some(4), "no row of target 4; there is 3"),
            ("2,3,5,6,7,8,1\n2,3,5,6,7,8,1", None, "line 2: a second row of target 3 in frame 2"),
            ("6,3,5,6,7,8,1", None, "frame 6 is outside S's 1 to 5"),
            ("-1,3,5,6,7,8,1", None, "frame -1 is outside S's 1 to 5"),
            ("0,3,5,6,7,8,1\n5,3,5,6,7,8,1", None, "line 2: frame 5 is outside S's 0 to 4"),
            ("1.5,3,5,6,7,8,1", None, "whole numbers"),
            ("2,3,5,6,7,8", None, "6 columns"),
            ("2,3,5,nan,7,8,1", None, "not finite"),
            ("2,3,5,6,7,8,1,1,1,1,1", None, "10 columns"),
        ] {
            let error = read(text, id).unwrap_err().to_string();
            assert!(error.contains(words), "{text}: {error}");
        }
    }

    proptest! {
        #[test]
        fn damaged_files_are_read_or_refused(bytes in trackfail_testing::damaged(WRITTEN.as_bytes())) {
            if let Ok(boxes) = parse(Path::new("a.txt"), &bytes, &sequence(), Base::One, None) {
                prop_assert_eq!((boxes.regions.len(), boxes.confidence.len()), (3, 3));
            }
        }
    }
}
