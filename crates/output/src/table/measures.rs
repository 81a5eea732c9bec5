//! Pooled numbers of an experiment, by tracker, method and grid point.

use super::records::CellScore;
use crate::engine::store::StoreError;
use crate::engine::{Cell, Outcome};
use crate::score::measures::{Counts, Metric, Pooled, median_delay, normalised_mean_std};
use std::collections::{BTreeMap, BTreeSet, HashMap};
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
    /// The attribute of the sequences it is about; all of them when `None`.
    pub attribute: Option<String>,
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
                attribute: None,
                pooled: pool_cells(outcome, &cells)?,
                done: cells.iter().filter(|c| c.result.is_ok()).count(),
                failed: cells.iter().filter(|c| c.result.is_err()).count(),
            })
        })
        .collect()
}

/// Pools the counts of the sequences with each attribute, attributes by name; trackers and variants in the
/// order in which they come. There are no scores and no efforts: these are not known cell by cell.
pub fn by_attribute(scores: &[CellScore], attributes: &BTreeMap<String, Vec<String>>) -> Vec<Measure> {
    let mut sequences: BTreeMap<&str, BTreeSet<&str>> = BTreeMap::new();
    for (sequence, list) in attributes {
        for attribute in list {
            sequences.entry(attribute).or_default().insert(sequence);
        }
    }
    let mut measures: Vec<Measure> = Vec::new();
    for (attribute, sequences) in sequences {
        let mut places: BTreeMap<(&str, &str, &str), usize> = BTreeMap::new();
        for score in scores.iter().filter(|s| sequences.contains(s.sequence.as_str())) {
            let place = *places.entry((&score.tracker, &score.method, &score.params)).or_insert_with(|| {
                measures.push(Measure {
                    tracker: score.tracker.clone(),
                    method: score.method.clone(),
                    params: score.params.clone(),
                    attribute: Some(attribute.to_string()),
                    pooled: Pooled::default(),
                    done: 0,
                    failed: 0,
                });
                measures.len() - 1
            });
            let measure = &mut measures[place];
            measure.pooled.counts = [measure.pooled.counts, score.counts].into_iter().sum();
            measure.done += 1;
        }
    }
    measures
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
    let delays = cells.iter().filter_map(|c| c.result.as_ref().ok()).flat_map(|j| j.score.delays());
    let delay = median_delay(delays.collect());
    Ok(Pooled { counts: pool_counts(cells), score, effort, delay, ..Pooled::default() })
}

/// The counts of cells that have a result, together.
pub fn pool_counts(cells: &[&Cell]) -> Counts {
    cells.iter().filter_map(|c| c.result.as_ref().ok()).map(|j| j.score.counts).sum()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::score::measures::Metric;

    // By hand: two sequences are dark, one of them small too; F is that of the summed counts.
    #[test]
    fn counts_are_pooled_over_the_sequences_of_an_attribute() {
        let score = |sequence: &str, run, tp, fp| CellScore {
            sequence: sequence.into(),
            tracker: "t".into(),
            run,
            method: "m".into(),
            params: String::new(),
            counts: Counts { tp, fp, fn_: 1, tn: 5 },
        };
        let scores = [score("a", 0, 1, 0), score("a", 1, 2, 0), score("b", 0, 0, 4), score("c", 0, 9, 9)];
        let words = |list: &[&str]| list.iter().map(|w| w.to_string()).collect();
        let attributes = [
            ("a", words(&["small", "dark"])),
            ("b", words(&["dark", "dark"])),
            ("c", words(&[])),
            ("d", words(&["gone"])),
        ];
        let attributes = attributes.into_iter().map(|(name, list)| (name.to_string(), list)).collect();
        let measures = by_attribute(&scores, &attributes);
        let told: Vec<_> =
            measures.iter().map(|m| (m.attribute.as_deref(), m.done, m.value(Metric::FScore))).collect();
        assert_eq!(told, [(Some("dark"), 3, Some(6.0 / 13.0)), (Some("small"), 2, Some(6.0 / 8.0))]);
    }
}
