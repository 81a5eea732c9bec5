//! Cells of a run as rows: names, order, results, and how many are written at once.

use std::collections::HashMap;
use std::hash::Hash;
use std::sync::Arc;
use trackfail_engine::execute::judge::Judged;
use trackfail_engine::execute::track::Track;
use trackfail_engine::store::StoreError;
use trackfail_engine::{Cell, Outcome};
use trackfail_methods::detector::DetectorOutput;

/// Name of a method in `frames.parquet`, with its grid point if it has one.
pub fn method_label(method: &str, params: &str) -> String {
    if params.is_empty() { method.to_string() } else { format!("{method}[{params}]") }
}

/// Parses a grid point like `horizon=5;window=20` into axes and values.
pub fn parse_point(params: &str) -> Vec<(String, f64)> {
    let parts = params.split(';').filter_map(|part| part.split_once('='));
    parts.filter_map(|(axis, value)| Some((axis.to_string(), value.parse().ok()?))).collect()
}

/// Cells sorted by name, independent of the order in which they were computed.
pub(super) fn sorted_cells<'a>(outcome: &'a Outcome<'_>) -> Vec<&'a Cell> {
    let mut cells: Vec<&Cell> = outcome.cells.iter().collect();
    cells.sort_by_key(|&cell| (track_name(outcome, cell), &cell.method, &cell.params));
    cells
}

/// Sequence, tracker and run of a track.
pub(super) type TrackName<'a> = (&'a str, &'a str, i64);

/// Name of a cell's track.
pub(super) fn track_name<'a>(outcome: &'a Outcome<'_>, cell: &'a Cell) -> TrackName<'a> {
    (&outcome.sequence(cell.sequence).name, &cell.tracker, i64::from(cell.run))
}

/// Track of a cell; `None` if it failed.
pub(super) fn track<'a>(outcome: &'a Outcome<'_>, cell: &Cell) -> Option<&'a Track> {
    outcome.tracks.get(cell.sequence)?.get(cell.job)?.as_ref().ok().map(|track| &**track)
}

/// A cell with a result, and the output of its detector.
pub(super) struct Done<'a> {
    pub cell: &'a Cell,
    pub judged: &'a Judged,
    pub track: &'a Track,
    pub output: Arc<DetectorOutput>,
}

/// Cells that have a result, with their outputs. An output that can no longer be read from the store is an
/// error.
pub(super) fn done<'a>(
    outcome: &'a Outcome<'_>,
    cells: impl IntoIterator<Item = &'a Cell>,
) -> Result<Vec<Done<'a>>, StoreError> {
    let mut all = Vec::new();
    for cell in cells {
        let (Ok(judged), Some(track)) = (&cell.result, track(outcome, cell)) else { continue };
        let output = outcome.detector_output(cell, judged)?;
        all.push(Done { cell, judged, track, output });
    }
    Ok(all)
}

/// Splits a list into parts of total size at most `most`. `size` is that of an item after those before it in
/// its part. There is at least one part, and an item that is too large forms its own part.
pub(crate) fn in_parts<T>(all: &[T], most: usize, size: impl Fn(&[T], &T) -> usize) -> Vec<&[T]> {
    let (mut parts, mut from, mut used) = (Vec::new(), 0, 0);
    for (k, item) in all.iter().enumerate() {
        used += size(&all[from..k], item);
        if used > most && k > from {
            parts.push(&all[from..k]);
            (from, used) = (k, size(&[], item));
        }
    }
    parts.push(&all[from..]);
    parts
}

/// Groups items by key. Groups and their members stay in order of first occurrence.
pub(crate) fn grouped<T: Copy, K: Clone + Eq + Hash>(
    all: impl IntoIterator<Item = T>,
    key: impl Fn(T) -> K,
) -> Vec<(K, Vec<T>)> {
    let mut places = HashMap::new();
    let mut groups: Vec<(K, Vec<T>)> = Vec::new();
    for one in all {
        let key = key(one);
        // The map only finds a group's place, its own order plays no part.
        let place = *places.entry(key.clone()).or_insert(groups.len());
        if place == groups.len() {
            groups.push((key, Vec::new()));
        }
        groups[place].1.push(one);
    }
    groups
}
