//! Results in the JSON of the OTB authors' Python code: a list with one object per segment.
//!
//! ```text
//! [{ "startFrame": 1, "endFrame": 252, "resType": "rect", "tmplsize": [0, 0],
//!    "res": [[x, y, w, h], ...], ... }]
//! ```
//!
//! `rect` boxes count pixels from 1, unless the caller gives another [`Base`]. `ivtAff` and `affine_ivt` rows are six
//! affine values `p` that map a template of `tmplsize` = `(w, h)` into the image, as that code draws them:
//!
//! ```text
//! corner(u, v) = (p1 + p3 u + p4 v, p2 + p5 u + p6 v)      u = -w/2, w/2     v = -h/2, h/2
//! ```
//!
//! Trackers start with the center at `x + w/2` of the 1-based box, so the corners are 1-based, too, and are
//! shifted by one like the box. Other kinds of rows are refused.

use super::{Base, BoxError, Boxes, align, region};
use serde::Deserialize;
use std::path::Path;
use trackfail_dataset::{DatasetError, Numbering, text};

// The fields that are read; the files have more (tracker, seqName, fps ...).
#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
struct Wire {
    start_frame: u32,
    end_frame: u32,
    res_type: String,
    tmplsize: Option<Vec<f64>>,
    res: Vec<Vec<f64>>,
}

/// Reads entry `run` (0-based) of a file: a segment of a temporal-robustness run, or a repetition. `path` is
/// for messages, `base` is the number of the top left pixel in the file.
///
/// # Errors
/// When the file has another format, the run is not in it, the number of rows is not that of the stated
/// range, or the range cannot be aligned with the frame numbers of the sequence (see [`align`]).
pub fn parse(
    path: &Path,
    bytes: &[u8],
    run: u32,
    numbering: Numbering,
    base: Base,
) -> Result<Boxes, DatasetError> {
    let entries: Vec<Wire> = serde_json::from_slice(text::without_mark(bytes)).map_err(|e| {
        // It quotes the text that it did not expect, whole.
        let message = text::shorten_to(&e.to_string(), 200);
        DatasetError::line(path, e.line(), format!("no OTB result file: {message}"))
    })?;
    let count = entries.len();
    let Some(entry) = entries.into_iter().nth(run as usize) else {
        let message = format!("there is no run {run}; the file has {count}, from 0");
        return Err(DatasetError::content(path, message));
    };
    let fault = |message: String| DatasetError::content(path, format!("entry {}: {message}", run + 1));
    let (start, end) = (entry.start_frame, entry.end_frame);
    let (stated, rows) = ((u64::from(end) + 1).saturating_sub(start.into()), entry.res.len());
    if stated != rows as u64 || stated == 0 {
        let range = format!("frames {start} to {end}, which are {stated}");
        return Err(fault(format!("{rows} boxes for {range}; none is made up or dropped")));
    }
    let first = align((start, end), numbering).map_err(fault)?;
    let affine = match entry.res_type.as_str() {
        "rect" => None,
        "ivtAff" | "affine_ivt" => match entry.tmplsize.as_deref() {
            Some(&[w, h]) if w > 0.0 && h > 0.0 => Some((w, h)),
            _ => return Err(fault("affine boxes need `tmplsize`, two positive numbers".into())),
        },
        other => {
            let other = text::shorten(other);
            return Err(fault(format!(
                "resType `{other}` is not read; `rect`, `ivtAff` and `affine_ivt` are"
            )));
        }
    };
    let mut regions = Vec::with_capacity(rows);
    for (i, row) in entry.res.iter().enumerate() {
        let expected = if affine.is_some() { 6 } else { 4 };
        if row.len() != expected {
            return Err(fault(format!("box {}: {} numbers, not {expected}", i + 1, row.len())));
        }
        let region = match affine {
            None => region(row, base),
            Some(template) => region(affine_corners(row, template).as_flattened(), base),
        };
        let at = || format!("entry {}, box {}", run + 1, i + 1);
        regions.push(region.map_err(|source| BoxError { at: at(), source }));
    }
    Ok(Boxes { first, regions, confidence: Vec::new() })
}

/// Corners of an affine box, clockwise from the top left corner of the template.
fn affine_corners(p: &[f64], (w, h): (f64, f64)) -> [[f64; 2]; 4] {
    [(-0.5, -0.5), (0.5, -0.5), (0.5, 0.5), (-0.5, 0.5)].map(|(u, v)| {
        let (u, v) = (u * w, v * h);
        [p[0] + p[2] * u + p[3] * v, p[1] + p[4] * u + p[5] * v]
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use trackfail_core::region::{Rect, Region};
    use trackfail_testing::assert_says;

    const FIVE: Numbering = Numbering { first: 1, official: (1, 5) };

    fn read_text(text: &[u8], run: u32) -> Result<Boxes, DatasetError> {
        parse(Path::new("a.json"), text, run, FIVE, Base::One)
    }

    fn entry(start: u32, end: u32, kind: &str, rows: &str) -> String {
        format!(
            r#"{{"tracker":"T","startFrame":{start},"endFrame":{end},"resType":"{kind}",
            "tmplsize":[32.0,32.0],"res":[{rows}]}}"#
        )
    }

    #[test]
    fn boxes_and_segments() {
        let one = entry(1, 2, "rect", "[1,1,4,4],[2.5,1,4,4]");
        let text = format!("[{one},{}]", entry(2, 2, "rect", "[7,7,1,1]"));
        let first = read_text(text.as_bytes(), 0).unwrap();
        assert_eq!(first.first, 1);
        assert_eq!(first.regions[1], Ok(Region::Rect(Rect::new(1.5, 0.0, 4.0, 4.0))));
        assert_eq!(read_text(text.as_bytes(), 1).unwrap().first, 2);
        assert!(read_text(text.as_bytes(), 2).unwrap_err().to_string().contains("no run 2"));
    }

    // IVT, CarScale, frame 1: the ground truth is x,y,w,h = 6,166,42,26 counted from 1.
    #[test]
    fn affine_boxes_are_where_the_truth_is() {
        let text = format!("[{}]", entry(1, 1, "affine_ivt", "[27.0,179.0,1.3125,0.0,0.0,0.8125]"));
        let region = read_text(text.as_bytes(), 0).unwrap().regions.remove(0).unwrap();
        assert_eq!(region.rect(), Rect::new(5.0, 165.0, 42.0, 26.0));
        assert_eq!(region.corners()[0], (5.0, 165.0));
    }

    // A quarter turn: p = (cx, cy, 0, -s, s, 0) sends the template's top to the image's right.
    #[test]
    fn affine_boxes_turn() {
        let text = format!("[{}]", entry(1, 1, "ivtAff", "[101,51,0,-0.5,1,0]"));
        let region = read_text(text.as_bytes(), 0).unwrap().regions.remove(0).unwrap();
        assert_eq!(region.corners(), [(108.0, 34.0), (108.0, 66.0), (92.0, 66.0), (92.0, 34.0)]);
    }

    #[test]
    fn faults_are_named() {
        let no_size = entry(1, 1, "ivtAff", "[1,1,1,0,0,1]").replace("[32.0,32.0]", "null");
        for (text, word) in [
            ("".into(), "line 1"),
            ("{}".into(), "line 1"),
            ("[]".into(), "no run 0"),
            (format!("[{}]", entry(1, 2, "rect", "[1,1,4,4]")), "1 boxes"),
            (format!("[{}]", entry(1, 1, "rect", "[1,1,4,4],[1,1,4,4]")), "2 boxes"),
            (format!("[{}]", entry(2, 1, "rect", "")), "0 boxes"),
            (format!("[{}]", entry(4, 6, "rect", "[1,1,4,4],[1,1,4,4],[1,1,4,4]")), "official range"),
            (format!("[{}]", entry(1, 1, "rect", "[1,1,4]")), "box 1: 3 numbers"),
            (format!("[{}]", entry(1, 1, "rect", "[1,1,NaN,4]")), "line 2"),
            (format!("[{}]", entry(1, 1, "rect", "[1,1,null,4]")), "line 2"),
            (format!("[{}]", entry(1, 1, "rect", "[1,1,1e999,4]")), "line 2"),
            (format!("[{}]", entry(1, 1, "4corner", "[1,1,4,4]")), "4corner"),
            (no_size.clone(), "line 1"),
            (format!("[{no_size}]"), "tmplsize"),
        ] {
            assert_says(read_text(text.as_bytes(), 0).unwrap_err(), word);
        }
        let empty = format!("[{}]", entry(1, 2, "rect", "[1,1,4,4],[1,1,0,4]"));
        let boxes = read_text(empty.as_bytes(), 0).unwrap();
        assert!(boxes.regions[0].is_ok());
        assert!(boxes.regions[1].as_ref().unwrap_err().to_string().contains("entry 1, box 2"));
    }

    #[test]
    fn unexpected_text_is_quoted_in_part() {
        let text = format!("[{{\"startFrame\": \"{}\"}}]", "x".repeat(1 << 20));
        let message = read_text(text.as_bytes(), 0).unwrap_err().to_string();
        assert!(message.contains("no OTB result file") && message.len() < 500, "{}", message.len());
        assert!(read_text("[".repeat(1 << 20).as_bytes(), 0).is_err());
    }
}
