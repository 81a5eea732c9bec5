//! The output of `trackfail detect`: the labels of every method on one track.

use super::column::{Column, FRAME, METHOD, TableFile};
use super::frame::{TableError, to_csv};
use super::frames::{CHANGE, LABEL, SCORE};
use crate::dataset::Sequence;
use crate::detector::DetectorOutput;

/// The CSV on stdout.
pub const FILE: TableFile = TableFile {
    name: "stdout of `trackfail detect`",
    about: "One row for each frame and method, method by method.",
    columns: &[
        Column { meaning: "Number of the frame, as its file has it", ..FRAME },
        METHOD,
        SCORE,
        LABEL,
        CHANGE,
    ],
};

/// The CSV of what methods say of the frames of a sequence.
///
/// # Errors
/// When polars refuses.
pub fn csv(sequence: &Sequence, methods: &[(&str, DetectorOutput)]) -> Result<Vec<u8>, TableError> {
    let (mut number, mut name, mut score) = (Vec::new(), Vec::new(), Vec::new());
    let (mut label, mut change) = (Vec::new(), Vec::new());
    for (method, detection) in methods {
        number.extend((0..sequence.len()).map(|t| i64::from(sequence.number(t))));
        name.extend(std::iter::repeat_n(*method, sequence.len()));
        score.extend_from_slice(&detection.score);
        label.extend(detection.alarm.iter().map(|a| i32::from(*a)));
        change.extend_from_slice(&detection.changes());
    }
    let columns =
        vec![FRAME.of(number), METHOD.of(name), SCORE.of(score), LABEL.of(label), CHANGE.of(change)];
    to_csv(FILE.frame(columns)?)
}
