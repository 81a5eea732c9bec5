//! Cells of a run as rows: their names, their order, their results, and what is written at once.

use std::collections::HashMap;
use std::hash::Hash;
use std::sync::Arc;
use trackfail_engine::execute::judge::Judged;
use trackfail_engine::execute::track::Track;
use trackfail_engine::store::StoreError;
use trackfail_engine::{Cell, Outcome};
use trackfail_methods::detector::DetectorOutput;

/// A method's name in `frames.parquet`: with its grid point, where it has one.
pub fn method_label(method: &str, params: &str) -> String {
    if params.is_empty() { method.to_string() } else { format!("{method}[{params}]") }
}

/// Reads a grid point, `horizon=5;window=20`: axis and value.
pub fn parse_point(params: &str) -> Vec<(String, f64)> {
    params
        .split(';')
        .filter_map(|part| {
            let (axis, value) = part.split_once('=')?;
            Some((axis.to_string(), value.parse().ok()?))
        })
        .collect()
}

/// The cells by their names, whatever the order in which they were done.
pub(super) fn sorted_cells<'a>(outcome: &'a Outcome<'_>) -> Vec<&'a Cell> {
    let mut cells: Vec<&Cell> = outcome.cells.iter().collect();
    cells.sort_by_key(|&cell| (track_name(outcome, cell), &cell.method, &cell.params));
    cells
}

/// Sequence, tracker and run of a track.
pub(super) type TrackName<'a> = (&'a str, &'a str, i64);

/// The name of a cell's track.
pub(super) fn track_name<'a>(outcome: &'a Outcome<'_>, cell: &'a Cell) -> TrackName<'a> {
    (&outcome.sequence(cell.sequence).name, &cell.tracker, i64::from(cell.run))
}

/// The track of a cell, where there is one.
pub(super) fn track<'a>(outcome: &'a Outcome<'_>, cell: &Cell) -> Option<&'a Track> {
    outcome.tracks.get(cell.sequence)?.get(cell.job)?.as_ref().ok().map(|track| &**track)
}

/// A cell that has a result, with what its detector says of its track.
pub(super) struct Done<'a> {
    pub cell: &'a Cell,
    pub judged: &'a Judged,
    pub track: &'a Track,
    pub output: Arc<DetectorOutput>,
}

/// Those of the cells that have a result. A detection that cannot be read from the store any more is an error.
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

/// Parts of a list, each of what fits: `size` is that of an item behind those before it in its part. There is at least one
/// part, and an item that is too large is one.
pub(crate) fn in_parts<T>(all: &[T], most: usize, size: impl Fn(&[T], &T) -> usize) -> Vec<&[T]> {
    let mut parts = Vec::new();
    let mut rest = all;
    while !rest.is_empty() || parts.is_empty() {
        let mut used = 0;
        let fits = |k: &usize| {
            used += size(&rest[..*k], &rest[*k]);
            used <= most
        };
        let fitting = (0..rest.len()).take_while(fits).count();
        let (part, later) = rest.split_at(fitting.max(1).min(rest.len()));
        parts.push(part);
        rest = later;
    }
    parts
}

/// What has the same key together, behind the key; groups and their members in the order in which they come.
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
