//! `frames.parquet`: every frame of every cell, with the tracker's box and the method's label.

use super::ResultsError;
use super::cells::{FrameKeys, in_parts, method_label, sorted_cells};
use super::column::{Column, FRAME, METHOD, RUN, SEQUENCE, SUITE, TRACKER, TableFile};
use super::frame::parts_to_parquet;
use polars::prelude::DataFrame;
use std::collections::BTreeSet;
use std::io::Write;
use trackfail_core::region::Region;
use trackfail_engine::{Cell, Outcome};

pub(super) const X: Column = Column::real("x", "pixels", "Left edge of the tracker's box");
pub(super) const Y: Column = Column::real("y", "pixels", "Upper edge of the tracker's box");
pub(super) const W: Column = Column::real("w", "pixels", "Width of the tracker's box");
pub(super) const H: Column = Column::real("h", "pixels", "Height of the tracker's box");
pub(super) const ERROR: Column =
    Column::real("error", "", "Error O_t of the box: 1 - Dice overlap with the ground truth")
        .empty("it is not known");
pub(super) const SCORE: Column =
    Column::real("score", "", "The detector's score: most compare it with their threshold");
pub(super) const ALARM_SCORE: Column =
    Column::real("alarm_score", "", "The number that the detector compares with its threshold")
        .empty("it is the score")
        .recent();
pub(super) const LABEL: Column =
    Column::small("label", "1 in frames in which the method alarms, 0 elsewhere");
pub(super) const CHANGE: Column =
    Column::small("change", "1 where the label becomes 1, -1 where it becomes 0, 0 elsewhere");

/// The file.
pub const FILE: TableFile = TableFile {
    name: "frames.parquet",
    about: "One row for each frame of every cell that has a result, cells sorted by their names.",
    columns: &[
        SUITE,
        SEQUENCE,
        TRACKER,
        RUN,
        FRAME,
        X,
        Y,
        W,
        H,
        ERROR,
        Column { meaning: "Name of the method, with its grid point: `DTEF[horizon=5;window=20]`", ..METHOD },
        SCORE,
        ALARM_SCORE,
        LABEL,
        CHANGE,
    ],
};

/// Writes the file.
///
/// # Errors
/// When a detection cannot be read from the store any more, or polars refuses.
pub(super) fn write(outcome: &Outcome<'_>, file: &mut dyn Write) -> Result<(), ResultsError> {
    let cells = sorted_cells(outcome);
    let has_alarm_score = has_alarm_score(outcome, &cells)?;
    let frames = |cells: &[&Cell]| frames_of(outcome, cells, has_alarm_score);
    parts_to_parquet(file, in_parts(outcome, &cells, |cell| cell).into_iter().map(frames))
}

/// Whether a method compares another number than its score with its threshold; all cells of a method are alike.
fn has_alarm_score(outcome: &Outcome<'_>, cells: &[&Cell]) -> Result<bool, ResultsError> {
    let mut seen = BTreeSet::new();
    for cell in cells {
        let Ok(judged) = &cell.result else { continue };
        if seen.insert(&cell.method) && outcome.detector_output(cell, judged)?.alarm_score.is_some() {
            return Ok(true);
        }
    }
    Ok(false)
}

fn frames_of(
    outcome: &Outcome<'_>,
    cells: &[&Cell],
    has_alarm_score: bool,
) -> Result<DataFrame, ResultsError> {
    let mut keys = FrameKeys::default();
    let (mut x, mut y, mut w, mut h) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
    let (mut error, mut method, mut score) = (Vec::new(), Vec::new(), Vec::new());
    let mut alarm_score = Vec::new();
    let (mut label, mut change) = (Vec::new(), Vec::new());
    let names: Vec<String> = cells.iter().map(|c| method_label(&c.method, &c.params)).collect();
    for (cell, name) in cells.iter().zip(&names) {
        let Ok(judged) = &cell.result else { continue };
        let Some(Ok(track)) = outcome.tracks.get(cell.sequence).and_then(|t| t.get(cell.job)) else {
            continue;
        };
        let detection = outcome.detector_output(cell, judged)?;
        keys.push(outcome, cell, track.regions.len());
        for rect in track.regions.iter().map(Region::rect) {
            x.push(rect.x);
            y.push(rect.y);
            w.push(rect.w);
            h.push(rect.h);
        }
        error.extend(track.error.iter().map(|e| (!e.is_nan()).then_some(*e)));
        method.extend(std::iter::repeat_n(name.as_str(), track.regions.len()));
        score.extend_from_slice(&detection.score);
        match &detection.alarm_score {
            Some(scores) => alarm_score.extend(scores.iter().copied().map(Some)),
            None => alarm_score.extend(std::iter::repeat_n(None, detection.score.len())),
        }
        label.extend(detection.alarm.iter().map(|a| i32::from(*a)));
        change.extend_from_slice(&detection.changes());
    }
    let mut columns = keys.columns(&outcome.suite);
    columns.extend([X.of(x), Y.of(y), W.of(w), H.of(h), ERROR.of(error), METHOD.of(method)]);
    columns.push(SCORE.of(score));
    columns.extend(has_alarm_score.then(|| ALARM_SCORE.of(alarm_score)));
    columns.extend([LABEL.of(label), CHANGE.of(change)]);
    Ok(FILE.frame(columns)?)
}
