//! Rows of the files with data of single frames, from the cells of a run.

use super::ResultsError;
use super::bytes::parts_to_parquet;
use super::cells::{Done, done, in_parts, method_label, sorted_cells, track, track_name};
use super::files::{CheckRow, ConditionRow, Frame, Piece, Signal, Target};
use super::rows::{Rows, TableError};
use polars::prelude::DataFrame;
use std::collections::BTreeSet;
use std::io::Write;
use trackfail_core::region::Region;
use trackfail_engine::spec::Experiment;
use trackfail_engine::store::StoreError;
use trackfail_engine::{Cell, Outcome};
use trackfail_methods::score::{Restarts, restarts};

/// Approximate number of rows in memory at once, for files with a row per frame. A row group has the same
/// size.
const ROWS_AT_ONCE: usize = 1 << 17;

/// Name and bytes of a file.
type NamedFile = (&'static str, Vec<u8>);

fn number(outcome: &Outcome<'_>, cell: &Cell, t: usize) -> i64 {
    i64::from(outcome.sequence(cell.sequence).number(t))
}

fn known(value: f64) -> Option<f64> {
    Some(value).filter(|v| !v.is_nan())
}

/// Writes `frames.parquet`.
pub(super) fn frames(outcome: &Outcome<'_>, file: &mut dyn Write) -> Result<(), ResultsError> {
    let cells = sorted_cells(outcome);
    // Of a method either all cells or none compare another number than the score with the threshold.
    let mut seen = BTreeSet::new();
    let one_of_each = cells.iter().copied().filter(|cell| cell.result.is_ok() && seen.insert(&cell.method));
    let has_alarm_score = done(outcome, one_of_each)?.iter().any(|one| one.output.alarm_score.is_some());
    let part = |cells: &[&Cell]| -> Result<DataFrame, ResultsError> {
        let shown = done(outcome, cells.iter().copied())?;
        let labels: Vec<String> =
            shown.iter().map(|Done { cell, .. }| method_label(&cell.method, &cell.params)).collect();
        let rows = shown.iter().zip(&labels).flat_map(|(Done { cell, track, output, .. }, method)| {
            let changes = output.changes();
            (0..track.regions.len()).map(move |t| {
                let rect = track.regions[t].rect();
                Frame {
                    track: track_name(outcome, cell),
                    frame: number(outcome, cell, t),
                    x: rect.x,
                    y: rect.y,
                    w: rect.w,
                    h: rect.h,
                    error: known(track.error[t]),
                    method,
                    score: output.score[t],
                    alarm_score: output.alarm_score.as_ref().map(|scores| scores[t]),
                    label: i32::from(output.alarm[t]),
                    change: changes[t],
                }
            })
        });
        let mut frame = Frame::frame(outcome.suite(), rows)?;
        if !has_alarm_score {
            frame.drop_in_place("alarm_score").map_err(TableError::from)?;
        }
        Ok(frame)
    };
    let parts = in_parts(&cells, ROWS_AT_ONCE, |_, cell| outcome.sequence(cell.sequence).len());
    parts_to_parquet(file, parts.into_iter().map(part))
}

/// Writes `signals.parquet`. Signal and forecast are written once if all points of a grid share them.
pub(super) fn signals(outcome: &Outcome<'_>, file: &mut dyn Write) -> Result<(), ResultsError> {
    let mut cells = sorted_cells(outcome);
    cells.retain(|cell| cell.result.is_ok() && cell.signal.is_some());
    let mut shown: Vec<(&Cell, &str)> = Vec::new();
    let same = |a: &&Cell, b: &&Cell| a.sequence == b.sequence && a.job == b.job && a.method == b.method;
    for points in cells.chunk_by(same) {
        if is_shared(outcome, points)? {
            shown.push((points[0], ""));
        } else {
            shown.extend(points.iter().map(|cell| (*cell, cell.params.as_str())));
        }
    }
    let parts = in_parts(&shown, ROWS_AT_ONCE, |_, (cell, _)| outcome.sequence(cell.sequence).len());
    parts_to_parquet(file, parts.into_iter().map(|shown| signals_of(outcome, shown)))
}

/// True if all grid points of a method on a track read the same signal and make no forecast.
fn is_shared(outcome: &Outcome<'_>, points: &[&Cell]) -> Result<bool, StoreError> {
    let [first, _, ..] = points else { return Ok(false) };
    let same_signal = points.iter().all(|point| point.signal == first.signal);
    // Points are those of one detector: either all of them make a forecast or none does.
    Ok(same_signal && done(outcome, [*first])?.iter().all(|one| one.output.forecast.is_none()))
}

/// Rows of cells with a result, each with a label of its grid point.
fn signals_of(outcome: &Outcome<'_>, cells: &[(&Cell, &str)]) -> Result<DataFrame, ResultsError> {
    let shown = done(outcome, cells.iter().map(|(cell, _)| *cell))?;
    let rows = shown.iter().zip(cells).flat_map(|(Done { cell, track, output, .. }, (_, params))| {
        let signal = track.signal(cell.signal);
        (0..signal.len()).map(move |t| Signal {
            track: track_name(outcome, cell),
            frame: number(outcome, cell, t),
            method: &cell.method,
            params,
            signal: signal[t],
            forecast: output.forecast.as_ref().and_then(|forecast| known(forecast[t])),
        })
    });
    Ok(Signal::frame(outcome.suite(), rows)?)
}

/// Bytes of `truth.parquet`.
pub(super) fn truth(outcome: &Outcome<'_>) -> Result<Vec<u8>, TableError> {
    let mut sequences: Vec<_> = outcome.sequences().collect();
    sequences.sort_by(|a, b| a.name.cmp(&b.name));
    let corners = |region: &Region| {
        let points = match region.corners() {
            four if four.len() == 4 => four,
            _ => region.rect().corners().to_vec(),
        };
        std::array::from_fn(|k| if k % 2 == 0 { points[k / 2].0 } else { points[k / 2].1 })
    };
    let rows = sequences.into_iter().flat_map(|sequence| {
        sequence.truth.iter().enumerate().map(move |(t, region)| Target {
            sequence: &sequence.name,
            frame: i64::from(sequence.number(t)),
            corners: region.as_ref().map(corners),
        })
    });
    Target::parquet(outcome.suite(), rows)
}

/// `pieces.csv`; `None` if no method has a protocol that scores parts of tracks separately.
pub(super) fn pieces(
    experiment: &Experiment,
    outcome: &Outcome<'_>,
) -> Result<Option<NamedFile>, TableError> {
    if experiment.methods.iter().all(|m| m.protocol.restarts == Restarts::PartOfTrack) {
        return Ok(None);
    }
    let mut all = BTreeSet::new();
    for cell in &outcome.cells {
        let Some(track) = track(outcome, cell) else { continue };
        let pieces = restarts::pieces(&track.status);
        if pieces.iter().any(|piece| piece.len() < track.status.len()) {
            let number = |t: usize| number(outcome, cell, t);
            let of_piece = |piece: std::ops::Range<usize>| (number(piece.start), number(piece.end - 1));
            all.extend(pieces.into_iter().map(|piece| (track_name(outcome, cell), of_piece(piece))));
        }
    }
    let rows = all.into_iter().map(|((sequence, tracker, run), (first, last))| {
        let track = (sequence.to_string(), tracker.to_string(), run);
        Piece { track, first, last }
    });
    Ok(Some((Piece::NAME, Piece::csv(outcome.suite(), rows)?)))
}

/// `conditions.parquet` and `checks.csv`; empty if no method estimates the tracker's condition.
pub(super) fn followed(outcome: &Outcome<'_>) -> Result<Vec<NamedFile>, ResultsError> {
    let mut cells = sorted_cells(outcome);
    cells.retain(|cell| cell.result.as_ref().is_ok_and(|judged| judged.effort.is_some()));
    let cells = done(outcome, cells)?;
    let followed = || cells.iter().filter_map(|one| Some((one.cell, one.output.quality.as_ref()?)));
    if followed().next().is_none() {
        return Ok(Vec::new());
    }
    let conditions = followed().flat_map(|(cell, quality)| {
        quality.condition.iter().enumerate().map(move |(t, condition)| ConditionRow {
            track: track_name(outcome, cell),
            frame: number(outcome, cell, t),
            method: &cell.method,
            params: &cell.params,
            condition: condition.level(),
        })
    });
    let checks = followed().flat_map(|(cell, quality)| {
        quality.checks.iter().map(move |check| CheckRow {
            track: track_name(outcome, cell),
            method: &cell.method,
            params: &cell.params,
            frame: number(outcome, cell, check.frame),
            reference: number(outcome, cell, check.reference),
            error: check.error,
            accepted: i32::from(check.accepted),
        })
    });
    Ok(vec![
        (ConditionRow::NAME, ConditionRow::parquet(outcome.suite(), conditions)?),
        (CheckRow::NAME, CheckRow::csv(outcome.suite(), checks)?),
    ])
}
