//! `pieces.csv`: the parts of tracks that were scored by themselves, because a restart began a new track.

use super::column::{Column, FRAME, RUN, SEQUENCE, SUITE, TRACKER, TableFile};
use super::frame::{TableError, to_csv};
use std::collections::{BTreeMap, BTreeSet};
use trackfail_engine::Outcome;
use trackfail_engine::spec::Experiment;
use trackfail_methods::score::{Restarts, restarts};

const LAST: Column = Column::integer("last", "", "Number of the piece's last frame");

/// The file; only experiments with such a protocol have it.
pub const FILE: TableFile = TableFile {
    name: "pieces.csv",
    about: "One row for each piece of a track under a protocol in which a restart of the tracker begins a new track, such as \
            khalid2016/2. Frames between two pieces were skipped and count for nothing. Tracks without restarts have no row.",
    columns: &[
        SUITE,
        SEQUENCE,
        TRACKER,
        RUN,
        Column { name: "first", meaning: "Number of the piece's first frame", ..FRAME },
        LAST,
    ],
};
const FIRST: Column = FILE.columns[4];

/// Writes the file; `None` where no method has such a protocol.
///
/// # Errors
/// When polars refuses.
pub(super) fn write(experiment: &Experiment, outcome: &Outcome<'_>) -> Result<Option<Vec<u8>>, TableError> {
    if experiment.methods.iter().all(|m| m.protocol.restarts == Restarts::PartOfTrack) {
        return Ok(None);
    }
    let mut rows = BTreeSet::new();
    for cell in &outcome.cells {
        let Some(Ok(track)) = outcome.tracks.get(cell.sequence).and_then(|t| t.get(cell.job)) else {
            continue;
        };
        let pieces = restarts::pieces(&track.status);
        let sequence = &outcome.sequences[cell.sequence];
        if pieces.iter().any(|piece| piece.len() < track.status.len()) {
            let number = |t: usize| i64::from(sequence.number(t));
            rows.extend(pieces.into_iter().map(|piece| {
                let (name, tracker) = (sequence.name.as_str(), cell.tracker.as_str());
                (name, tracker, i64::from(cell.run), number(piece.start), number(piece.end - 1))
            }));
        }
    }
    to_csv(FILE.frame(vec![
        SUITE.of(vec![outcome.suite.as_str(); rows.len()]),
        SEQUENCE.of(rows.iter().map(|row| row.0).collect::<Vec<_>>()),
        TRACKER.of(rows.iter().map(|row| row.1).collect::<Vec<_>>()),
        RUN.of(rows.iter().map(|row| row.2).collect::<Vec<_>>()),
        FIRST.of(rows.iter().map(|row| row.3).collect::<Vec<_>>()),
        LAST.of(rows.iter().map(|row| row.4).collect::<Vec<_>>()),
    ])?)
    .map(Some)
}

/// Numbers of the first and the last frame of each piece, by sequence, tracker and run of the track.
pub(super) type ByTrack = BTreeMap<(String, String, i64), Vec<(i64, i64)>>;

/// Reads all pieces.
///
/// # Errors
/// When the columns are not those of the file, or a number is damaged.
pub(super) fn read(bytes: Vec<u8>) -> Result<ByTrack, TableError> {
    let rows = FILE.read_csv(bytes)?;
    let (sequence, tracker) = (rows.texts(&SEQUENCE)?, rows.texts(&TRACKER)?);
    let run = rows.all_numbers(&RUN)?;
    let (first, last) = (rows.all_numbers(&FIRST)?, rows.all_numbers(&LAST)?);
    let mut all = ByTrack::new();
    for i in 0..rows.len() {
        let track = (sequence[i].to_string(), tracker[i].to_string(), run[i]);
        all.entry(track).or_default().push((first[i], last[i]));
    }
    Ok(all)
}
