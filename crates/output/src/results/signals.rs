//! `signals.parquet`: the signal and the forecast of every method without a grid.

use super::ResultsError;
use super::cells::{FrameKeys, in_parts, sorted_cells};
use super::column::{Column, FRAME, METHOD, RUN, SEQUENCE, SUITE, TRACKER, TableFile};
use super::frame::parts_to_parquet;
use crate::engine::{Cell, Outcome};
use polars::prelude::DataFrame;
use std::io::Write;

pub(super) const SIGNAL: Column = Column::real("signal", "", "Value of the method's signal");
pub(super) const FORECAST: Column =
    Column::real("forecast", "", "What the detector expected the signal to be, made before it saw the frame")
        .empty("the detector has no forecast there");

/// The file.
pub const FILE: TableFile = TableFile {
    name: "signals.parquet",
    about: "One row for each frame of every cell that has a result, of methods that read a signal and have no grid.",
    columns: &[SUITE, SEQUENCE, TRACKER, RUN, FRAME, METHOD, SIGNAL, FORECAST],
};

/// Writes the file.
///
/// # Errors
/// When a detection cannot be read from the store any more, or polars refuses.
pub(super) fn write(outcome: &Outcome<'_>, file: &mut dyn Write) -> Result<(), ResultsError> {
    let mut cells = sorted_cells(outcome);
    cells.retain(|cell| cell.result.is_ok() && cell.signal.is_some() && cell.params.is_empty());
    parts_to_parquet(file, in_parts(outcome, &cells).into_iter().map(|cells| frames_of(outcome, cells)))
}

fn frames_of(outcome: &Outcome<'_>, cells: &[&Cell]) -> Result<DataFrame, ResultsError> {
    let mut keys = FrameKeys::default();
    let (mut method, mut signal, mut forecast) = (Vec::new(), Vec::new(), Vec::new());
    for cell in cells {
        let (Ok(judged), Some(index)) = (&cell.result, cell.signal) else { continue };
        let Some(Ok(track)) = outcome.tracks.get(cell.sequence).and_then(|t| t.get(cell.job)) else {
            continue;
        };
        let values = &track.signals[index];
        keys.push(outcome, cell, values.len());
        method.extend(std::iter::repeat_n(cell.method.as_str(), values.len()));
        signal.extend_from_slice(values);
        match &outcome.detector_output(cell, judged)?.forecast {
            Some(f) => forecast.extend(f.iter().map(|v| (!v.is_nan()).then_some(*v))),
            None => forecast.extend(std::iter::repeat_n(None, values.len())),
        }
    }
    let mut columns = keys.columns(&outcome.suite);
    columns.extend([METHOD.of(method), SIGNAL.of(signal), FORECAST.of(forecast)]);
    Ok(FILE.frame(columns)?)
}
