//! Result files of trackers: their formats, and the frame that each line belongs to.
//!
//! Nothing is padded, trimmed or guessed: a file with too few or too many lines, or with numbers that are not a
//! box, is an error that names the file and the line or entry. A frame [without a box](NoBox) is an error of its own,
//! which the reader of a track may take as the target's absence.

pub mod confidence;
pub mod got10k;
pub mod mot;
pub mod otb_json;
pub mod otb_text;
pub mod oxuva;
#[cfg(test)]
mod toolkit_tests;
pub mod user_boxes;
pub mod vot;
pub mod write;

pub use otb_text::{Base, parse_boxes, read_boxes};

use trackfail_core::region::{Region, RegionError};
use trackfail_dataset::Numbering;

/// What is said of a trajectory that the VOT toolkit wrote as bytes.
pub(super) const BINARY: &str = "a trajectory of the VOT toolkit in bytes, which are not read; write it as text in Python: `from \
     vot.region.io import read_trajectory, write_trajectory`, then `write_trajectory(\"new.txt\", read_trajectory(\"old.bin\"))`";

/// A tracker's regions from some frame on.
#[derive(Debug, Clone, PartialEq)]
pub struct Boxes {
    /// The dataset's number of the first frame.
    pub first: u32,
    /// One region per frame, in 0-based pixels, or the reason why there is none.
    pub regions: Vec<Result<Region, BoxError>>,
    /// The tracker's confidence in each frame; empty for formats without one.
    pub confidence: Vec<Option<f64>>,
}

/// A frame of a result file without a region.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error("{at}: {source}")]
pub struct BoxError {
    /// Place in the file.
    pub at: String,
    /// The reason.
    pub source: NoBox,
}

/// Why a frame of a result file has no region.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum NoBox {
    /// Its numbers are no region.
    #[error(transparent)]
    Numbers(#[from] RegionError),
    /// Its line is empty.
    #[error("an empty line; lines are frames, so none may be empty")]
    EmptyLine,
    /// The file says so.
    #[error("the tracker says that the target is absent")]
    SaidAbsent,
    /// The file has no row for it, which in its format means that the target was not found.
    #[error("no row, so the tracker has not found the target")]
    NoRow,
    /// The tracker was not asked for it.
    #[error("the tracker was not asked for this frame")]
    NotAsked,
}

impl NoBox {
    /// Whether it can be taken as the target's absence: no row, no numbers, NaN, or no area.
    pub fn may_be_absence(&self) -> bool {
        match self {
            Self::Numbers(e) => matches!(e, RegionError::NotFinite | RegionError::Empty),
            Self::EmptyLine | Self::SaidAbsent | Self::NoRow => true,
            Self::NotAsked => false,
        }
    }
}

/// Drops empty rows at the end: all of them, or as few as are needed for a number of rows that fits.
pub(super) fn drop_empty_end<T>(
    rows: &mut Vec<T>,
    is_empty: impl Fn(&T) -> bool,
    fits: impl Fn(usize) -> bool,
) {
    let full = rows.iter().rposition(|row| !is_empty(row)).map_or(0, |last| last + 1);
    rows.truncate((full..=rows.len()).find(|n| fits(*n)).unwrap_or(full));
}

/// Why a result cannot be aligned with the frames of its sequence.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum AlignError {
    /// Both readings fit.
    #[error(
        "frames {start} to {end} may be the dataset's own numbers or counted from 1; give results of the whole \
         official range {first} to {last}"
    )]
    Ambiguous {
        /// First frame that the result states.
        start: u32,
        /// Last frame that the result states.
        end: u32,
        /// First official frame.
        first: u32,
        /// Last official frame.
        last: u32,
    },
    /// Neither reading fits.
    #[error(
        "frames {start} to {end} lie neither in the official range {first} to {last} nor, counted from 1, in 1 to \
         {span}"
    )]
    Outside {
        /// First frame that the result states.
        start: u32,
        /// Last frame that the result states.
        end: u32,
        /// First official frame.
        first: u32,
        /// Last official frame.
        last: u32,
        /// Number of official frames.
        span: u64,
    },
}

/// The dataset's number of a result's first frame, from the numbers the result states.
///
/// OTB results count either in the dataset's own numbers or from 1 at the first official frame (Struck's
/// count David 1..471, MEEM's count it 300..770). The last official frame tells which; results of a part of
/// the official range are taken where only one of the two readings lies inside it.
///
/// # Errors
/// When neither reading fits or both do.
pub fn align((start, end): (u32, u32), numbering: Numbering) -> Result<u32, AlignError> {
    let (first, last) = numbering.official;
    let span = official_span(numbering);
    let by_dataset = start >= first && end <= last;
    let from_one = start >= 1 && u64::from(end) <= span;
    match (by_dataset, from_one) {
        (true, _) if first == 1 => Ok(start),
        (true, false) => Ok(start),
        (false, true) => Ok(first + (start - 1)),
        (true, true) if end == last => Ok(start),
        (true, true) if u64::from(end) == span => Ok(first + (start - 1)),
        (true, true) => Err(AlignError::Ambiguous { start, end, first, last }),
        (false, false) => Err(AlignError::Outside { start, end, first, last, span }),
    }
}

/// Number of frames of the official range.
pub(super) fn official_span(numbering: Numbering) -> u64 {
    let (first, last) = numbering.official;
    (u64::from(last) + 1).saturating_sub(first.into())
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn numbering(first: u32, last: u32) -> Numbering {
        Numbering { first, official: (first, last) }
    }

    #[test]
    fn david_and_tiger1_are_counted_both_ways() {
        let david = numbering(300, 770);
        assert_eq!(align((300, 770), david), Ok(300));
        assert_eq!(align((1, 471), david), Ok(300));
        assert_eq!(align((24, 471), david), Ok(323));
        assert_eq!(align((300, 500), david), Ok(300));
        assert_eq!(align((1, 201), david), Ok(300));
        assert!(align((1, 770), david).is_err());
        assert!(align((310, 400), david).is_err());
        let tiger = numbering(6, 354);
        assert_eq!(align((6, 354), tiger), Ok(6));
        assert_eq!(align((1, 349), tiger), Ok(6));
        assert_eq!(align((18, 349), tiger), Ok(23));
        assert!(align((6, 300), tiger).is_err());
        assert_eq!(align((1, 252), numbering(1, 252)), Ok(1));
        assert!(align((0, 252), numbering(1, 252)).is_err());
        assert_eq!(align((1, 10), numbering(0, 9)), Ok(0));
        assert_eq!(align((0, 9), numbering(0, 9)), Ok(0));
        assert!(align((1, 1), numbering(9, 5)).is_err());
    }

    proptest! {
        #[test]
        fn an_aligned_result_lies_in_the_official_range(
            first in 0..400_u32, span in 1..500_u32, start in 0..900_u32, count in 1..900_u32,
        ) {
            let n = numbering(first, first + span - 1);
            // Half of the cases end where real results end.
            let start = if start % 2 == 0 { (first + span).saturating_sub(count) } else { start };
            if let Ok(at) = align((start, start + count - 1), n) {
                prop_assert!(at >= n.official.0 && at + count - 1 <= n.official.1);
            }
        }
    }
}
