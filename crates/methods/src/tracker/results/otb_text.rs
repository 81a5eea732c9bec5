//! Plain text boxes: `x,y,w,h` in each line, as the OTB code base and most trackers write them.
//!
//! Toolkits differ in the separators of the numbers, and in little else: pysot and the LaSOT toolkit write commas,
//! pytracking tabs between integers (its writer cuts the fractions off), others blanks. None of them shifts
//! anything, so a result counts pixels as the annotation did that the tracker was started with. pysot's first
//! line is half a pixel right of and below that annotation, its other lines are not.

use super::{NoBox, drop_empty_end};
use serde::{Deserialize, Serialize};
use std::path::Path;
use trackfail_core::region::{Region, RegionError};
use trackfail_dataset::{DatasetError, text};

/// Index of the left top pixel; `0` or `1` in a file.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(try_from = "u8", into = "u8")]
#[schemars(extend("enum" = [0, 1]))]
pub enum Base {
    /// `(0, 0)`.
    Zero,
    /// `(1, 1)`, as in OTB.
    #[default]
    One,
}

impl From<Base> for u8 {
    fn from(base: Base) -> Self {
        match base {
            Base::Zero => 0,
            Base::One => 1,
        }
    }
}

/// A number that pixels are not counted from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error("{0}; pixels are counted from 0 or from 1")]
pub struct BaseError(pub u8);

impl TryFrom<u8> for Base {
    type Error = BaseError;

    fn try_from(number: u8) -> Result<Self, BaseError> {
        match number {
            0 => Ok(Self::Zero),
            1 => Ok(Self::One),
            other => Err(BaseError(other)),
        }
    }
}

impl Base {
    /// Converts a region of a file to 0-based pixels.
    pub fn to_zero(self, region: Region) -> Region {
        match self {
            Self::Zero => region,
            Self::One => region.shifted(-1.0, -1.0),
        }
    }

    /// Converts a region of 0-based pixels to those of a file.
    pub fn from_zero(self, region: &Region) -> Region {
        match self {
            Self::Zero => region.clone(),
            Self::One => region.shifted(1.0, 1.0),
        }
    }
}

/// Reads `x,y,w,h` a line, after an optional header of four words such as `x,y,w,h`.
///
/// Separators are those of [`text`]; boxes may leave the image.
///
/// # Errors
/// File and line of whatever is no box: other counts of columns, NaN, infinity, sizes of zero or below.
pub fn read_boxes(path: &Path, base: Base) -> Result<Vec<Region>, DatasetError> {
    parse_boxes(path, &text::read_capped(path)?, base)
}

/// As [`read_boxes`], from the file's bytes; `path` names it in messages.
///
/// # Errors
/// As [`read_boxes`].
pub fn parse_boxes(path: &Path, bytes: &[u8], base: Base) -> Result<Vec<Region>, DatasetError> {
    let mut rows = parse_rows(path, bytes)?;
    drop_empty_end(&mut rows, is_empty, |_| false);
    rows.into_iter()
        .map(|(line, row)| {
            let region = row.and_then(|values| Ok(Region::from_numbers(&values)?));
            region.map(|r| base.to_zero(r)).map_err(|e| DatasetError::line(path, line, e.to_string()))
        })
        .collect()
}

/// The four numbers of a line, or the reason why it has none.
pub(crate) type Row = Result<[f64; 4], NoBox>;

/// Whether a row is an empty line.
pub(crate) fn is_empty((_, row): &(usize, Row)) -> bool {
    *row == Err(NoBox::EmptyLine)
}

/// The rows of a file, with the numbers of their lines.
pub(crate) fn parse_rows(path: &Path, bytes: &[u8]) -> Result<Vec<(usize, Row)>, DatasetError> {
    let mut lines = text::lines_or_empty(path, text::decode(path, bytes)?)?;
    if lines.first().is_some_and(|(_, line)| is_header(line)) {
        lines.remove(0);
        if lines.iter().all(|(_, line)| line.is_empty()) {
            return Err(DatasetError::content(path, "a header and no box; one box a frame was expected"));
        }
    }
    lines
        .into_iter()
        .map(|(n, line)| {
            if line.is_empty() {
                return Ok((n, Err(NoBox::EmptyLine)));
            }
            let values = text::numbers(line).map_err(|m| DatasetError::line(path, n, m))?;
            let row: [f64; 4] = values.try_into().map_err(|v: Vec<f64>| {
                DatasetError::line(
                    path,
                    n,
                    format!("{} numbers; a box is x,y,w,h; leave the others out", v.len()),
                )
            })?;
            let is_number = !row.iter().any(|v| v.is_nan());
            Ok((n, if is_number { Ok(row) } else { Err(RegionError::NotFinite.into()) }))
        })
        .collect()
}

fn is_header(line: &str) -> bool {
    let words: Vec<_> = line.split(|c: char| ",;".contains(c) || c.is_whitespace()).collect();
    let words: Vec<_> = words.into_iter().filter(|w| !w.is_empty()).collect();
    words.len() == 4 && words.iter().all(|w| w.parse::<f64>().is_err() && w.contains(char::is_alphabetic))
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use trackfail_core::region::Rect;

    fn read(bytes: &[u8], base: Base) -> Result<Vec<Region>, DatasetError> {
        let f = tempfile::NamedTempFile::new().unwrap();
        std::fs::write(f.path(), bytes).unwrap();
        read_boxes(f.path(), base)
    }

    #[test]
    fn header_base_and_separators() {
        let want = Region::Rect(Rect::new(4.0, -3.0, 10.0, 2.5));
        for text in
            ["5,-2,10,2.5", "x,y,w,h\n5,-2,10,2.5\n", "\u{feff}X Y Width Height\r\n5\t-2\t10\t2.5\r\n"]
        {
            assert_eq!(read(text.as_bytes(), Base::One).unwrap(), std::slice::from_ref(&want), "{text}");
        }
        assert_eq!(read(b"4,-3,10,2.5", Base::Zero).unwrap(), [want]);
    }

    #[test]
    fn faults_name_the_line() {
        for bad in
            ["1,2,3", "1,2,3,4,5", "NaN,1,1,1", "inf,1,1,1", "1,1,0,1", "1,1,1,-1", "a,b,c,d", "\u{e9}"]
        {
            let error = read(format!("1,1,2,2\n{bad}\n1,1,2,2").as_bytes(), Base::One).unwrap_err();
            assert!(matches!(error, DatasetError::Line { line: 2, .. }), "{bad}: {error}");
        }
        assert!(matches!(read(b"1,1,2,2\n\xC3", Base::One), Err(DatasetError::Line { line: 2, .. })));
        assert!(matches!(read(b"nan,nan,nan,nan", Base::One), Err(DatasetError::Line { line: 1, .. })));
        assert!(read(b"", Base::One).is_err());
        assert!(read(b"x,y,w,h\n", Base::One).is_err());
    }

    const VALID: &[u8] = b"x,y,w,h\r\n5,-2,10,2.5\r\n1e2\t1E-2\t1\t1\n7 8 9 10";

    proptest! {
        #[test]
        fn damaged_boxes_are_read_or_refused(bytes in trackfail_testing::damaged(VALID)) {
            if let Ok(boxes) = parse_boxes(Path::new("a.txt"), &bytes, Base::One) {
                prop_assert!(!boxes.is_empty() && boxes.iter().all(|r| r.area() > 0.0));
            }
        }

        #[test]
        fn any_bytes_are_read_or_refused(bytes in prop::collection::vec(any::<u8>(), 0..300)) {
            let _ = read(&bytes, Base::One);
        }

        #[test]
        fn written_boxes_are_read_back(
            boxes in prop::collection::vec((-99.0..99.0, -99.0..99.0, 0.01..99.0, 0.01..99.0), 1..20),
        ) {
            let text: String = boxes.iter().map(|b| format!("{},{},{},{}\n", b.0, b.1, b.2, b.3)).collect();
            let read = read(text.as_bytes(), Base::Zero).unwrap();
            prop_assert_eq!(read.len(), boxes.len());
            for (r, b) in read.iter().zip(&boxes) {
                prop_assert_eq!(r, &Region::Rect(Rect::new(b.0, b.1, b.2, b.3)));
            }
        }
    }
}
