//! Pooled numbers of an experiment, by tracker, method and grid point.

use crate::engine::run::{Cell, Outcome};
use crate::engine::store::StoreError;
use crate::score::measures::{Counts, Metric, Pooled, normalised_mean_std};
use std::collections::HashMap;
use std::hash::Hash;

/// The pooled numbers of one tracker and one variant of a method, over all sequences and runs.
#[derive(Debug, Clone, PartialEq)]
pub struct Measure {
    /// Label of the tracker.
    pub tracker: String,
    /// Method.
    pub method: String,
    /// Grid point as in `scores.csv`, empty without a grid.
    pub params: String,
    /// The numbers, from the cells that have a result.
    pub pooled: Pooled,
    /// Cells with a result.
    pub done: usize,
    /// Cells that failed or whose data is missing although their sequence is there.
    pub failed: usize,
}

impl Measure {
    /// Grid axis -> value.
    pub fn point(&self) -> Vec<(String, f64)> {
        parse_point(&self.params)
    }

    /// The value of a metric, where there is one.
    pub fn value(&self, metric: Metric) -> Option<f64> {
        (self.done > 0).then(|| self.pooled.value(metric)).flatten()
    }
}

/// Reads `horizon=5;window=20`.
pub fn parse_point(params: &str) -> Vec<(String, f64)> {
    params
        .split(';')
        .filter_map(|part| {
            let (axis, value) = part.split_once('=')?;
            Some((axis.to_string(), value.parse().ok()?))
        })
        .collect()
}

/// Pools an outcome's cells, in the order in which trackers and variants first appear.
///
/// # Errors
/// When a verdict cannot be had any more.
pub fn pool(outcome: &Outcome<'_>) -> Result<Vec<Measure>, StoreError> {
    let key = |cell: &Cell| (cell.tracker.clone(), cell.method.clone(), cell.params.clone());
    let groups = grouped(outcome.cells.iter(), key);
    groups
        .into_iter()
        .filter_map(|cells| Some((key(cells.first()?), cells)))
        .map(|((tracker, method, params), cells)| {
            Ok(Measure {
                tracker,
                method,
                params,
                pooled: pool_cells(outcome, &cells)?,
                done: cells.iter().filter(|c| c.result.is_ok()).count(),
                failed: cells.iter().filter(|c| c.result.is_err()).count(),
            })
        })
        .collect()
}

/// Cells with the same key together; groups and their cells in the order in which they come.
pub fn grouped<'a, K: Eq + Hash>(
    cells: impl IntoIterator<Item = &'a Cell>,
    key: impl Fn(&Cell) -> K,
) -> Vec<Vec<&'a Cell>> {
    let mut places = HashMap::new();
    let mut groups: Vec<Vec<&Cell>> = Vec::new();
    for cell in cells {
        // The map only finds a group's place, its own order plays no part.
        let place = *places.entry(key(cell)).or_insert_with(|| {
            groups.push(Vec::new());
            groups.len() - 1
        });
        groups[place].push(cell);
    }
    groups
}

/// Pools cells that have a result.
fn pool_cells(outcome: &Outcome<'_>, cells: &[&Cell]) -> Result<Pooled, StoreError> {
    let judged = cells.iter().filter_map(|c| Some((c, c.result.as_ref().ok()?)));
    let verdicts =
        judged.map(|(cell, judged)| outcome.verdict(cell, judged)).collect::<Result<Vec<_>, StoreError>>()?;
    let effort = cells.iter().filter_map(|c| c.result.as_ref().ok()).map(|j| j.effort).sum();
    let score = normalised_mean_std(verdicts.iter().map(|v| &v.score));
    Ok(Pooled { counts: pool_counts(cells), score, effort })
}

/// The counts of cells that have a result, together.
pub fn pool_counts(cells: &[&Cell]) -> Counts {
    cells.iter().filter_map(|c| c.result.as_ref().ok()).map(|j| j.score.counts).sum()
}
