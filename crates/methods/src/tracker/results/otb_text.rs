//! Plain text boxes: `x,y,w,h` on each line, as the OTB code base and most trackers write them.
//!
//! Toolkits differ in the separators: pysot and the LaSOT toolkit write commas, pytracking tabs between
//! integers (it cuts the fractions off), others blanks. No toolkit shifts boxes, so a result counts pixels
//! from the same number as the annotation with which the tracker was started. The first line of pysot is half
//! a pixel to the right of and below that annotation; its other lines are not.

use super::rows::{self, Row, drop_empty_end};
use super::{BoxError, Boxes, official_span, region};
use serde::{Deserialize, Serialize};
use std::path::Path;
use trackfail_core::region::Region;
use trackfail_dataset::{DatasetError, SequenceInfo};

/// Coordinates of the top left pixel; `0` or `1` in a file.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(try_from = "u8", into = "u8")]
#[schemars(extend("enum" = [0, 1]))]
pub enum Base {
    /// The top left pixel is (0, 0).
    Zero,
    /// The top left pixel is (1, 1), as in OTB.
    #[default]
    One,
}

impl From<Base> for u8 {
    fn from(base: Base) -> Self {
        base as Self
    }
}

impl TryFrom<u8> for Base {
    type Error = String;

    fn try_from(number: u8) -> Result<Self, String> {
        match number {
            0 => Ok(Self::Zero),
            1 => Ok(Self::One),
            other => Err(format!("{other}; pixels are counted from 0 or from 1")),
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

    /// Converts a region from 0-based pixels to those of a file.
    pub fn from_zero(self, region: &Region) -> Region {
        match self {
            Self::Zero => region.clone(),
            Self::One => region.shifted(1.0, 1.0),
        }
    }
}

/// Reads one `x,y,w,h` per line, after an optional header such as `x,y,w,h`; `path` is for messages.
///
/// Boxes may leave the image.
///
/// # Errors
/// The first line that is not a box: another number of columns, NaN, infinity, a size of zero or below.
pub fn parse_boxes(path: &Path, bytes: &[u8], base: Base) -> Result<Vec<Region>, DatasetError> {
    let mut rows = rows::read_after_header(path, bytes)?;
    drop_empty_end(&mut rows, |_| false);
    check_columns(path, &rows)?;
    let of_row = |(line, row): &Row| {
        region(row, base).map_err(|reason| DatasetError::line(path, *line, reason.to_string()))
    };
    rows.iter().map(of_row).collect()
}

/// The boxes of a sequence, from rows for the official range or for the used frames.
///
/// # Errors
/// When a row has another number of columns than four, or the number of rows does not fit.
pub fn parse(
    path: &Path,
    mut rows: Vec<Row>,
    sequence: &dyn SequenceInfo,
    base: Base,
) -> Result<Boxes, DatasetError> {
    check_columns(path, &rows)?;
    let (span, used) = (official_span(sequence.numbering()), sequence.frames());
    if rows.len() as u64 != span {
        drop_empty_end(&mut rows, |n| n as u64 == span || n == used);
    }
    let first = match rows.len() {
        n if n as u64 == span => sequence.numbering().official.0,
        n if n == used => sequence.numbering().first,
        n => {
            let name = sequence.name();
            let message = format!(
                "{n} boxes; {name} has {span} frames, {used} of them used, and none is made up or dropped"
            );
            return Err(DatasetError::content(path, message));
        }
    };
    let of_row = |(line, row): &Row| {
        region(row, base).map_err(|source| BoxError { at: format!("line {line}"), source })
    };
    Ok(Boxes { first, regions: rows.iter().map(of_row).collect(), confidence: Vec::new() })
}

/// Refuses rows that are neither empty nor four numbers.
fn check_columns(path: &Path, rows: &[Row]) -> Result<(), DatasetError> {
    let Some((line, row)) = rows.iter().find(|(_, row)| !matches!(row.len(), 0 | 4)) else { return Ok(()) };
    let message = format!("{} numbers; a box is x,y,w,h; leave the others out", row.len());
    Err(DatasetError::line(path, *line, message))
}

#[cfg(test)]
mod tests {
    use super::*;
    use trackfail_core::region::Rect;

    fn read(bytes: &[u8], base: Base) -> Result<Vec<Region>, DatasetError> {
        parse_boxes(Path::new("a.txt"), bytes, base)
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
}
