//! Result files of trackers: their formats, and the frame that each line belongs to.
//!
//! Nothing is padded, trimmed or guessed: a file with too few or too many lines, or with numbers that are not
//! a box, is an error that names the file and the line or entry. A frame [without a box](NoBox) has its own
//! error, which the reader of a track may take as "the target is absent".

pub mod confidence;
pub mod mot;
pub mod otb_json;
pub mod otb_text;
pub mod oxuva;
pub mod rows;
#[cfg(test)]
mod tests;
#[cfg(test)]
mod toolkit_tests;
pub mod user_boxes;
pub mod vot;
pub mod write;

pub use otb_text::{Base, parse_boxes};

use std::collections::BTreeMap;
use trackfail_core::region::{Region, RegionError};
use trackfail_dataset::{Numbering, SequenceInfo};

/// Message about a trajectory in the VOT toolkit's binary format.
pub(super) const BINARY: &str = "a trajectory of the VOT toolkit in bytes, which are not read; write it as text in Python: `from \
     vot.region.io import read_trajectory, write_trajectory`, then `write_trajectory(\"new.txt\", read_trajectory(\"old.bin\"))`";

/// A tracker's regions from some frame on.
#[derive(Debug, Clone, PartialEq)]
pub struct Boxes {
    /// Number of the first frame in the dataset.
    pub first: u32,
    /// One region per frame, in 0-based pixels, or the reason why there is none.
    pub regions: Vec<Result<Region, BoxError>>,
    /// The tracker's confidence in each frame; empty if the format has none.
    pub confidence: Vec<Option<f64>>,
}

/// The answer for a frame: number of its line, region or the reason for none, and confidence.
type Answer = (usize, Result<Region, NoBox>, Option<f64>);

impl Boxes {
    /// Boxes of the frames that a sequence uses, and of the one before if there are earlier answers, by frame
    /// number; a frame without an answer gets the reason `missing`.
    fn of_rows(sequence: &dyn SequenceInfo, mut answers: BTreeMap<u64, Answer>, missing: &NoBox) -> Self {
        let numbering = sequence.numbering();
        // With the frame before, where the run began earlier: what comes then is no initialization.
        let is_from_start = answers.keys().next().is_none_or(|least| *least >= u64::from(numbering.first));
        let first = if is_from_start { numbering.first } else { numbering.first.saturating_sub(1) };
        let count = sequence.frames() + (numbering.first - first) as usize;
        let of_frame = |number: u64| match answers.remove(&number) {
            None => (Err(BoxError { at: format!("frame {number}"), source: missing.clone() }), None),
            Some((line, region, confidence)) => {
                (region.map_err(|source| BoxError { at: format!("line {line}"), source }), confidence)
            }
        };
        let (regions, confidence) = (u64::from(first)..).take(count).map(of_frame).unzip();
        Self { first, regions, confidence }
    }
}

/// A frame of a result file without a region.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error("{at}: {source}")]
pub struct BoxError {
    /// Line or entry of the file, for messages.
    pub at: String,
    /// The reason.
    pub source: NoBox,
}

/// Reason why a frame of a result file has no region.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum NoBox {
    /// The numbers are not a region.
    #[error(transparent)]
    Numbers(#[from] RegionError),
    /// The line is empty.
    #[error("an empty line; lines are frames, so none may be empty")]
    EmptyLine,
    /// The file says that the target is absent.
    #[error("the tracker says that the target is absent")]
    SaidAbsent,
    /// The file has no row for the frame, which in its format means that the target was not found.
    #[error("no row, so the tracker has not found the target")]
    NoRow,
    /// The tracker was not asked for the frame.
    #[error("the tracker was not asked for this frame")]
    NotAsked,
}

impl NoBox {
    /// True if it can mean that the target is absent: no row, no numbers, NaN, or no area.
    pub fn may_be_absence(&self) -> bool {
        match self {
            Self::Numbers(e) => matches!(e, RegionError::NotFinite | RegionError::Empty),
            Self::EmptyLine | Self::SaidAbsent | Self::NoRow => true,
            Self::NotAsked => false,
        }
    }
}

/// The region of a row, converted from the pixels of the file; a row without numbers gives
/// [`NoBox::EmptyLine`].
fn region(row: &[f64], base: Base) -> Result<Region, NoBox> {
    match row {
        [] => Err(NoBox::EmptyLine),
        row => Ok(base.to_zero(Region::from_numbers(row)?)),
    }
}

/// The dataset's number of the first frame of a result, from the frame numbers that the result states.
///
/// OTB results count either in the dataset's own numbers or from 1 at the first official frame (Struck's
/// count David 1..471, MEEM's count it 300..770). The last official frame tells which. A result for a part of
/// the official range is taken if only one of the two ways to count lies inside of the range.
///
/// # Errors
/// A message if neither way to count fits, or both do.
pub fn align((start, end): (u32, u32), numbering: Numbering) -> Result<u32, String> {
    let (first, last) = numbering.official;
    let span = official_span(numbering);
    let by_dataset = start >= first && end <= last;
    let from_one = start >= 1 && u64::from(end) <= span;
    match (by_dataset, from_one) {
        (true, false) => Ok(start),
        (false, true) => Ok(first + (start - 1)),
        (true, true) if first == 1 || end == last => Ok(start),
        (true, true) if u64::from(end) == span => Ok(first + (start - 1)),
        (true, true) => Err(format!(
            "frames {start} to {end} may be the dataset's own numbers or counted from 1; give results of the whole \
             official range {first} to {last}"
        )),
        (false, false) => Err(format!(
            "frames {start} to {end} lie neither in the official range {first} to {last} nor, counted from 1, in 1 to \
             {span}"
        )),
    }
}

/// Number of frames of the official range.
pub(super) fn official_span(numbering: Numbering) -> u64 {
    let (first, last) = numbering.official;
    (u64::from(last) + 1).saturating_sub(first.into())
}
