//! Results of OxUvA (Valmadre et al., ECCV 2018): one row per frame in which the tracker was asked.
//!
//! ```text
//! video,object,frame_num,present,score,xmin,xmax,ymin,ymax
//! ```
//!
//! The first row may be these words, in any order; without such a row the columns are in this order.
//! `frame_num` is the number of the frame in the dataset. `present` is `true`, `false`, or another word that
//! the benchmark's reader takes for one of them. Coordinates are fractions of the image's width and height, 0
//! to 1, so the size of the frames must be known:
//!
//! ```text
//! x = xmin W    y = ymin H    w = (xmax - xmin) W    h = (ymax - ymin) H      pixels from 0
//! ```
//!
//! A row with `false` may leave the coordinates out. There is no row for the frame in which the tracker was
//! started, nor for frames that were not asked for. `score` is the confidence; a high value means that the
//! tracker is sure. Source: `oxuva/io_pred.py` of oxuva/long-term-tracking-benchmark, and pytracking, which
//! writes the same.

use super::{Boxes, NoBox};
use std::collections::BTreeMap;
use std::path::Path;
use trackfail_core::region::Region;
use trackfail_dataset::{DatasetError, SequenceInfo, text};

const COLUMNS: [&str; 9] =
    ["video", "object", "frame_num", "present", "score", "xmin", "xmax", "ymin", "ymax"];

/// A row: number of the frame, the answer, and the score.
type Row = (u32, Result<Region, NoBox>, Option<f64>);

/// Reads the rows of a sequence; `path` is for messages.
///
/// # Errors
/// When a row has another form, a frame is outside of the official range, the frames do not ascend, rows have
/// two objects, or the size of the frames is unknown.
pub fn parse(path: &Path, bytes: &[u8], sequence: &dyn SequenceInfo) -> Result<Boxes, DatasetError> {
    let (width, height) = sequence.size().map_err(|e| DatasetError::content(path, e.to_string()))?;
    let size = (width as f64, height as f64);
    let mut lines = text::lines(path, text::decode(path, bytes)?)?;
    let named = lines.first().and_then(|(_, line)| columns(line));
    if named.is_some() {
        lines.remove(0);
    }
    let order = named.unwrap_or_else(|| std::array::from_fn(|k| k));
    let (from, to) = sequence.numbering().official;
    let mut answers: BTreeMap<u64, _> = BTreeMap::new();
    let mut object: Option<(&str, &str)> = None;
    for (n, line) in lines {
        let fault = |message: String| DatasetError::line(path, n, message);
        let cells: Vec<&str> = line.split(',').map(str::trim).collect();
        let cells: [&str; 9] = cells.try_into().map_err(|cells: Vec<&str>| {
            fault(format!("{} columns, not {}: {}", cells.len(), COLUMNS.len(), COLUMNS.join(",")))
        })?;
        let cells = order.map(|k| cells[k]);
        let (frame, region, score) = row(&cells, size).map_err(fault)?;
        if *object.get_or_insert((cells[0], cells[1])) != (cells[0], cells[1]) {
            return Err(fault("another object than in the first row; a file has one".into()));
        }
        if !(from..=to).contains(&frame) {
            let message = format!("frame {frame} is outside {}'s range {from} to {to}", sequence.name());
            return Err(fault(message));
        }
        if answers.last_key_value().is_some_and(|(last, _)| *last >= u64::from(frame)) {
            return Err(fault(format!("frame {frame} after one that is not before it")));
        }
        answers.insert(u64::from(frame), (n, region, score));
    }
    Ok(Boxes::of_rows(sequence, answers, &NoBox::NotAsked))
}

/// For each of [`COLUMNS`] the index of the column, from a first row of names; `None` if the row has values.
fn columns(line: &str) -> Option<[usize; 9]> {
    let names: Vec<&str> = line.split(',').map(str::trim).collect();
    if names.len() != COLUMNS.len() {
        return None;
    }
    let place = |column: &&str| names.iter().position(|name| name == column);
    COLUMNS.iter().map(place).collect::<Option<Vec<usize>>>()?.try_into().ok()
}

fn row(cells: &[&str; 9], (width, height): (f64, f64)) -> Result<Row, String> {
    let [_, _, frame, present, score, coordinates @ ..] = cells;
    let number = |name: &str, word: &str| text::number(word).map_err(|e| format!("{name}: {e}"));
    let frame = frame
        .parse()
        .map_err(|_| format!("frame_num is a whole number from 0, not `{}`", text::shorten(frame)))?;
    let present = match present.to_lowercase().as_str() {
        "t" | "true" | "y" | "yes" | "1" => true,
        "f" | "false" | "n" | "no" | "0" => false,
        _ => return Err(format!("present is `true` or `false`, not `{}`", text::shorten(present))),
    };
    let score = Some(number("score", score)?).filter(|v| !v.is_nan());
    let region = if present {
        let share = |k: usize| number(COLUMNS[5 + k], coordinates[k]);
        let (x0, x1, y0, y1) = (share(0)?, share(1)?, share(2)?, share(3)?);
        Region::from_numbers(&[x0 * width, y0 * height, (x1 - x0) * width, (y1 - y0) * height])
            .map_err(NoBox::from)
    } else {
        Err(NoBox::SaidAbsent)
    };
    Ok((frame, region, score))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tracker::testing;
    use trackfail_core::region::Rect;
    use trackfail_dataset::{Frames, Numbering, Sequence};

    /// Six frames of 320 x 240 pixels with numbers 1 to 6; the sequence uses 2 to 5.
    fn sequence() -> Sequence {
        let mut sequence = testing::rendered("S", 4);
        sequence.numbering = Numbering { first: 2, official: (1, 6) };
        sequence
    }

    fn read(text: &str) -> Result<Boxes, DatasetError> {
        parse(Path::new("vid0001_obj0000.csv"), text.as_bytes(), &sequence())
    }

    // dump_predictions_csv of the benchmark ends lines with "\r\n", as the module csv does, and writes no header; where
    // the target is absent, its example writes no coordinates.
    const WRITTEN: &[u8] =
        b"vid0001,obj0000,3,true,0.75,0.25,0.5,0.5,0.75\r\nvid0001,obj0000,5,false,-1.5,,,,\r\n";

    #[test]
    fn rows_of_asked_frames() {
        let text = std::str::from_utf8(WRITTEN).unwrap();
        let header = "present,video,object,frame_num,score,xmin,xmax,ymin,ymax\r\n\
            True,vid0001,obj0000,3,0.75,0.25,0.5,0.5,0.75\r\nF,vid0001,obj0000,5,-1.5,0,0,0,0";
        for text in [text, header] {
            let boxes = read(text).unwrap();
            assert_eq!(boxes.first, 2);
            assert_eq!(boxes.regions[1], Ok(Region::Rect(Rect::new(80.0, 120.0, 80.0, 60.0))), "{text}");
            let reason = |k: usize| boxes.regions[k].clone().unwrap_err().source;
            assert_eq!([0, 2, 3].map(reason), [NoBox::NotAsked, NoBox::NotAsked, NoBox::SaidAbsent]);
            assert_eq!(boxes.confidence, [None, Some(0.75), None, Some(-1.5)]);
        }
        // Frames of the official range that are not used are no error.
        let other = read("v,o,1,true,1,0,1,0,1\nv,o,6,true,1,0,1,0,1\n").unwrap();
        assert!(other.first == 1 && other.regions[1..].iter().all(Result::is_err));
        let empty = read("v,o,2,true,1,0.5,0.5,0,1\n").unwrap().regions[0].clone().unwrap_err();
        assert!(empty.source.may_be_absence() && empty.to_string().contains("line 1"), "{empty}");
    }

    #[test]
    fn faults_name_the_line() {
        for (bad, words) in [
            ("v,o,4,true,1,0,1,0", "8 columns"),
            ("v,o,4,maybe,1,0,1,0,1", "present is"),
            ("v,o,4.5,true,1,0,1,0,1", "frame_num"),
            ("v,o,4,true,,0,1,0,1", "score"),
            ("v,o,4,true,1,0,inf,0,1", "xmax"),
            ("v,o,4,true,1,0,1,,1", "ymin"),
            ("v,o,7,true,1,0,1,0,1", "range 1 to 6"),
            ("v,o,3,true,1,0,1,0,1", "not before it"),
            ("v,p,4,true,1,0,1,0,1", "another object"),
        ] {
            let error = read(&format!("v,o,3,true,1,0,1,0,1\n{bad}\n")).unwrap_err();
            assert!(matches!(error, DatasetError::Line { line: 2, .. }), "{bad}: {error}");
            assert!(error.to_string().contains(words), "{bad}: {error}");
        }
        let boxes_only = Sequence { frames: Frames::Absent, ..sequence() };
        assert!(parse(Path::new("a.csv"), WRITTEN, &boxes_only).is_err());
    }
}
