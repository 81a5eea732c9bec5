//! Rows of the files that tell of single frames, from the cells of a run.

use super::ResultsError;
use super::cells::{in_parts, method_label, sorted_cells};
use super::files::{CheckRow, ConditionRow, Frame, Piece, Signal, Target};
use super::rows::{Rows, TableError, parts_to_parquet};
use polars::prelude::DataFrame;
use std::collections::BTreeSet;
use std::io::Write;
use trackfail_core::region::Region;
use trackfail_engine::execute::track::Track;
use trackfail_engine::spec::Experiment;
use trackfail_engine::store::StoreError;
use trackfail_engine::{Cell, Outcome};
use trackfail_methods::detector::{DetectorOutput, Quality};
use trackfail_methods::score::{Restarts, restarts};

/// What columns of several files say of a cell: sequence, tracker and run.
fn names<'a>(outcome: &'a Outcome<'_>, cell: &'a Cell) -> (&'a str, &'a str, i64) {
    (&outcome.sequences[cell.sequence].name, &cell.tracker, i64::from(cell.run))
}

fn number(outcome: &Outcome<'_>, cell: &Cell, t: usize) -> i64 {
    i64::from(outcome.sequences[cell.sequence].number(t))
}

fn track<'a>(outcome: &'a Outcome<'_>, cell: &Cell) -> Option<&'a Track> {
    outcome.tracks.get(cell.sequence)?.get(cell.job)?.as_ref().ok().map(|track| &**track)
}

fn known(value: f64) -> Option<f64> {
    Some(value).filter(|v| !v.is_nan())
}

/// Writes `frames.parquet`.
pub(super) fn frames(outcome: &Outcome<'_>, file: &mut dyn Write) -> Result<(), ResultsError> {
    let cells = sorted_cells(outcome);
    let has_alarm_score = has_alarm_score(outcome, &cells)?;
    let frames = |cells: &[&Cell]| -> Result<DataFrame, ResultsError> {
        let mut frame = frames_of(outcome, cells)?;
        if !has_alarm_score {
            frame.drop_in_place("alarm_score").map_err(TableError::from)?;
        }
        Ok(frame)
    };
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

fn frames_of(outcome: &Outcome<'_>, cells: &[&Cell]) -> Result<DataFrame, ResultsError> {
    let mut shown = Vec::new();
    for cell in cells {
        let (Ok(judged), Some(track)) = (&cell.result, track(outcome, cell)) else { continue };
        let label = method_label(&cell.method, &cell.params);
        shown.push((*cell, track, outcome.detector_output(cell, judged)?, label));
    }
    let rows = shown.iter().flat_map(|(cell, track, output, method)| {
        let (sequence, tracker, run) = names(outcome, cell);
        let DetectorOutput { score, alarm_score, alarm, .. } = &**output;
        let changes = output.changes();
        (0..track.regions.len()).map(move |t| {
            let rect = track.regions[t].rect();
            Frame {
                sequence,
                tracker,
                run,
                frame: number(outcome, cell, t),
                x: rect.x,
                y: rect.y,
                w: rect.w,
                h: rect.h,
                error: known(track.error[t]),
                method,
                score: score[t],
                alarm_score: alarm_score.as_ref().map(|scores| scores[t]),
                label: i32::from(alarm[t]),
                change: changes[t],
            }
        })
    });
    Ok(Frame::frame(&outcome.suite, rows)?)
}

/// Writes `signals.parquet`: signal and forecast of a method once where all points of its grid share them.
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
    let parts = in_parts(outcome, &shown, |(cell, _)| cell);
    parts_to_parquet(file, parts.into_iter().map(|shown| signals_of(outcome, shown)))
}

/// Whether all points of a method's grid on a track read the same signal and make no forecast.
fn is_shared(outcome: &Outcome<'_>, points: &[&Cell]) -> Result<bool, ResultsError> {
    let ([first, _, ..], Ok(judged)) = (points, &points[0].result) else { return Ok(false) };
    let same_signal = points.iter().all(|point| point.signal == first.signal);
    // Points are those of one detector: either all of them make a forecast or none does.
    Ok(same_signal && outcome.detector_output(first, judged)?.forecast.is_none())
}

/// The rows of cells with what these say of their grid point.
fn signals_of(outcome: &Outcome<'_>, cells: &[(&Cell, &str)]) -> Result<DataFrame, ResultsError> {
    let mut shown = Vec::new();
    for (cell, params) in cells {
        let (Ok(judged), Some(track)) = (&cell.result, track(outcome, cell)) else { continue };
        if cell.signal.is_some() {
            shown.push((*cell, *params, track.signal(cell.signal), outcome.detector_output(cell, judged)?));
        }
    }
    let rows = shown.iter().flat_map(|(cell, params, values, output)| {
        let ((sequence, tracker, run), method) = (names(outcome, cell), cell.method.as_str());
        values.iter().enumerate().map(move |(t, signal)| Signal {
            sequence,
            tracker,
            run,
            frame: number(outcome, cell, t),
            method,
            params,
            signal: *signal,
            forecast: output.forecast.as_ref().and_then(|forecast| known(forecast[t])),
        })
    });
    Ok(Signal::frame(&outcome.suite, rows)?)
}

/// The bytes of `truth.parquet`.
pub(super) fn truth(outcome: &Outcome<'_>) -> Result<Vec<u8>, TableError> {
    let mut sequences: Vec<_> = outcome.sequences.iter().collect();
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
    Target::parquet(&outcome.suite, rows)
}

/// The bytes of `pieces.csv`; `None` where no method has a protocol that scores parts of tracks by themselves.
pub(super) fn pieces(experiment: &Experiment, outcome: &Outcome<'_>) -> Result<Option<Vec<u8>>, TableError> {
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
            all.extend(pieces.into_iter().map(|piece| (names(outcome, cell), of_piece(piece))));
        }
    }
    let rows = all.into_iter().map(|((sequence, tracker, run), (first, last))| {
        let [sequence, tracker] = [sequence, tracker].map(str::to_string);
        Piece { sequence, tracker, run, first, last }
    });
    Piece::csv(&outcome.suite, rows).map(Some)
}

/// The cells of methods that follow the tracker's condition, sorted by name.
pub(super) fn followed<'a>(outcome: &'a Outcome<'_>) -> Result<Vec<(&'a Cell, Quality)>, StoreError> {
    let mut all = Vec::new();
    for cell in sorted_cells(outcome) {
        let Ok(judged) = &cell.result else { continue };
        if !judged.follows {
            continue;
        }
        if let Some(quality) = &outcome.detector_output(cell, judged)?.quality {
            all.push((cell, quality.clone()));
        }
    }
    Ok(all)
}

/// The bytes of `conditions.parquet`, from what [`followed`] gives.
pub(super) fn conditions(outcome: &Outcome<'_>, cells: &[(&Cell, Quality)]) -> Result<Vec<u8>, TableError> {
    let rows = cells.iter().flat_map(|(cell, quality)| {
        let (sequence, tracker, run) = names(outcome, cell);
        quality.condition.iter().enumerate().map(move |(t, condition)| ConditionRow {
            sequence,
            tracker,
            run,
            frame: number(outcome, cell, t),
            method: &cell.method,
            params: &cell.params,
            condition: condition.level(),
        })
    });
    ConditionRow::parquet(&outcome.suite, rows)
}

/// The bytes of `checks.csv`, from what [`followed`] gives.
pub(super) fn checks(outcome: &Outcome<'_>, cells: &[(&Cell, Quality)]) -> Result<Vec<u8>, TableError> {
    let rows = cells.iter().flat_map(|(cell, quality)| {
        let (sequence, tracker, run) = names(outcome, cell);
        quality.checks.iter().map(move |check| CheckRow {
            sequence: sequence.to_string(),
            tracker: tracker.to_string(),
            run,
            method: cell.method.clone(),
            params: cell.params.clone(),
            frame: number(outcome, cell, check.frame),
            reference: number(outcome, cell, check.reference),
            error: check.error,
            accepted: i32::from(check.accepted),
        })
    });
    CheckRow::csv(&outcome.suite, rows)
}
