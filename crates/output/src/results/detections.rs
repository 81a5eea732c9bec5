//! The output of `trackfail detect`: the labels of every method on one track.

use super::column::{Column, FRAME, METHOD, TableFile};
use super::frame::{TableError, to_csv};
use super::frames::{CHANGE, LABEL, SCORE};
use crate::dataset::Sequence;
use crate::detector::{DetectorOutput, lost};

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
        STATE,
    ],
};

const STATE: Column = Column::text(
    "state",
    "`lost` from an alarm on, until the recovery is confirmed: in the frame without an alarm itself for methods whose alarm \
     lasts as long as the loss, in the tenth frame in a row without one for the others; else `tracking`",
);

/// A method on a track.
pub struct MethodOutput<'m> {
    /// Its name.
    pub method: &'m str,
    /// Its labels.
    pub output: DetectorOutput,
    /// See [`Detector::frames_to_recover`](crate::detector::Detector::frames_to_recover).
    pub frames_to_recover: usize,
}

/// The CSV of what methods say of the frames of a sequence.
///
/// # Errors
/// When polars refuses.
pub fn csv(sequence: &Sequence, methods: &[MethodOutput<'_>]) -> Result<Vec<u8>, TableError> {
    let (mut number, mut name, mut score) = (Vec::new(), Vec::new(), Vec::new());
    let (mut label, mut change, mut state) = (Vec::new(), Vec::new(), Vec::new());
    for MethodOutput { method, output: detection, frames_to_recover } in methods {
        number.extend((0..sequence.len()).map(|t| i64::from(sequence.number(t))));
        name.extend(std::iter::repeat_n(*method, sequence.len()));
        score.extend_from_slice(&detection.score);
        label.extend(detection.alarm.iter().map(|a| i32::from(*a)));
        change.extend_from_slice(&detection.changes());
        let lost = lost(&detection.alarm, *frames_to_recover).into_iter();
        state.extend(lost.map(|lost| if lost { "lost" } else { "tracking" }));
    }
    let labels = [LABEL.of(label), CHANGE.of(change), STATE.of(state)];
    let keys = [FRAME.of(number), METHOD.of(name), SCORE.of(score)];
    to_csv(FILE.frame(keys.into_iter().chain(labels).collect())?)
}
