//! `signals.parquet`: the signal and the forecast of every method, once where all points of its grid share them.

use super::ResultsError;
use super::cells::{FrameKeys, in_parts, some_text, sorted_cells};
use super::column::{Column, FRAME, METHOD, RUN, SEQUENCE, SUITE, TRACKER, TableFile};
use super::frame::parts_to_parquet;
use polars::prelude::DataFrame;
use std::io::Write;
use trackfail_engine::{Cell, Outcome};

pub(super) const SIGNAL: Column = Column::real("signal", "", "Value of the method's signal");
pub(super) const FORECAST: Column =
    Column::real("forecast", "", "What the detector expected the signal to be, made before it saw the frame")
        .empty("the detector has no forecast there");

/// Grid point; frames of methods with a grid are a matter of later versions.
const POINT: Column = Column::text("params", "Point of the method's grid: `horizon=5;window=20`")
    .empty("the method has no grid, or the row is that of all its points")
    .recent();

/// The file.
pub const FILE: TableFile = TableFile {
    name: "signals.parquet",
    about: "One row for each frame of every cell that has a result, of methods that read a signal. Cells that differ in the \
            point of a method's grid alone share their rows where all of them read the same signal and none makes a forecast.",
    columns: &[SUITE, SEQUENCE, TRACKER, RUN, FRAME, METHOD, POINT, SIGNAL, FORECAST],
};

/// Writes the file.
///
/// # Errors
/// When a detection cannot be read from the store any more, or polars refuses.
pub(super) fn write(outcome: &Outcome<'_>, file: &mut dyn Write) -> Result<(), ResultsError> {
    let mut cells = sorted_cells(outcome);
    cells.retain(|cell| cell.result.is_ok() && cell.signal.is_some());
    let mut shown: Vec<Shown<'_>> = Vec::new();
    let same = |a: &&Cell, b: &&Cell| a.sequence == b.sequence && a.job == b.job && a.method == b.method;
    for points in cells.chunk_by(same) {
        let shared = is_shared(outcome, points)?;
        let kept = &points[..if shared { 1 } else { points.len() }];
        shown.extend(kept.iter().map(|cell| Shown { cell, point: if shared { "" } else { &cell.params } }));
    }
    let parts = in_parts(outcome, &shown, |shown| shown.cell);
    parts_to_parquet(file, parts.into_iter().map(|shown| frames_of(outcome, shown)))
}

/// A cell whose frames have rows, and what these say of its grid point.
struct Shown<'a> {
    cell: &'a Cell,
    point: &'a str,
}

/// Whether all points of a method's grid on a track read the same signal and make no forecast.
fn is_shared(outcome: &Outcome<'_>, points: &[&Cell]) -> Result<bool, ResultsError> {
    let ([first, _, ..], Ok(judged)) = (points, &points[0].result) else { return Ok(false) };
    let same_signal = points.iter().all(|point| point.signal == first.signal);
    // Points are those of one detector: either all of them make a forecast or none does.
    Ok(same_signal && outcome.detector_output(first, judged)?.forecast.is_none())
}

fn frames_of(outcome: &Outcome<'_>, shown: &[Shown<'_>]) -> Result<DataFrame, ResultsError> {
    let mut keys = FrameKeys::default();
    let (mut method, mut params) = (Vec::new(), Vec::new());
    let (mut signal, mut forecast) = (Vec::new(), Vec::new());
    for Shown { cell, point } in shown {
        let (Ok(judged), Some(index)) = (&cell.result, cell.signal) else { continue };
        let Some(Ok(track)) = outcome.tracks.get(cell.sequence).and_then(|t| t.get(cell.job)) else {
            continue;
        };
        let values = &*track.signal(Some(index));
        keys.push(outcome, cell, values.len());
        method.extend(std::iter::repeat_n(cell.method.as_str(), values.len()));
        params.extend(std::iter::repeat_n(some_text(point), values.len()));
        signal.extend_from_slice(values);
        match &outcome.detector_output(cell, judged)?.forecast {
            Some(f) => forecast.extend(f.iter().map(|v| (!v.is_nan()).then_some(*v))),
            None => forecast.extend(std::iter::repeat_n(None, values.len())),
        }
    }
    let mut columns = keys.columns(&outcome.suite);
    columns.extend([METHOD.of(method), POINT.of(params), SIGNAL.of(signal), FORECAST.of(forecast)]);
    Ok(FILE.frame(columns)?)
}
