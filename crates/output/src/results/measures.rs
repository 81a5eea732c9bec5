//! `measures.csv`: numbers pooled over sequences and runs.

use super::cells::{done, grouped, method_label, parse_point};
use super::files::MeasureRow;
use super::manifest::FailedCell;
use super::rows::{Rows, TableError};
use super::scores::CellScore;
use std::collections::{BTreeMap, BTreeSet};
use trackfail_engine::store::StoreError;
use trackfail_engine::{Cell, Outcome};
use trackfail_methods::detector::track_quality::Effort;
use trackfail_methods::score::pooled::{median_delay, normalized_mean_std};
use trackfail_methods::score::restarts;
use trackfail_methods::score::{Metric, Pooled};

/// Name of the file.
pub const FILE: &str = MeasureRow::NAME;

/// Pooled numbers of one tracker and one variant of a method, over sequences and runs.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Measure {
    /// Label of the tracker.
    pub tracker: String,
    /// Name of the method.
    pub method: String,
    /// Grid point as in `scores.csv`; empty without a grid.
    pub params: String,
    /// Attribute that restricts the sequences; `None` for all sequences.
    pub attribute: Option<String>,
    /// Numbers pooled from the cells that have a result.
    pub pooled: Pooled,
    /// Number of cells with a result.
    pub done: usize,
    /// Number of cells on present sequences that failed or whose data are missing.
    pub failed: usize,
    /// Number of those cells whose data are missing. Not in the file; computed from the manifest.
    pub not_there: usize,
}

impl Measure {
    /// Grid point as axes and values.
    pub fn point(&self) -> Vec<(String, f64)> {
        parse_point(&self.params)
    }

    /// Value of a metric; `None` if it has none.
    pub fn value(&self, metric: Metric) -> Option<f64> {
        (self.done > 0).then(|| metric.value(&self.pooled)).flatten()
    }
}

/// Rows of the file, in the order in which trackers and variants first appear.
///
/// # Errors
/// When a detector output can no longer be read from the store.
pub(super) fn rows<'a>(outcome: &'a Outcome<'_>) -> Result<Vec<MeasureRow<'a>>, StoreError> {
    let groups =
        grouped(&outcome.cells, |cell| (cell.tracker.as_str(), cell.method.as_str(), cell.params.as_str()));
    let row = |(of, cells): (_, Vec<&'a Cell>)| {
        let done = done(outcome, cells.iter().copied())?;
        let scores = done.iter().map(|one| restarts::counted(&one.judged.pieces, &one.output.score));
        let some = !done.is_empty();
        let effort: Effort = done.iter().filter_map(|one| one.judged.effort).sum();
        Ok(MeasureRow {
            of,
            done: done.len() as i64,
            failed: cells.iter().filter(|c| c.has_failed()).count() as i64,
            counts: some.then(|| done.iter().map(|one| one.judged.score.counts).sum()),
            score: normalized_mean_std(scores).map(<[f64; 2]>::from),
            reverse_runs: some.then_some(effort.runs as i64),
            reverse_frames: some.then_some(effort.frames as i64),
            delay: median_delay(done.iter().flat_map(|one| one.judged.score.delays()).collect()),
        })
    };
    groups.into_iter().map(row).collect()
}

/// Pools the counts of the sequences with each attribute, sorted by attribute; trackers and variants in order
/// of first occurrence. Scores, delays and reverse runs are left out, since they are not known for single
/// cells. `without` are the cells without a result.
pub fn by_attribute(
    scores: &[CellScore],
    without: &[FailedCell],
    attributes: &BTreeMap<String, Vec<String>>,
) -> Vec<Measure> {
    let mut sequences: BTreeMap<&str, BTreeSet<&str>> = BTreeMap::new();
    for (sequence, list) in attributes {
        for attribute in list {
            sequences.entry(attribute).or_default().insert(sequence);
        }
    }
    let mut measures: Vec<Measure> = Vec::new();
    for (attribute, sequences) in sequences {
        let is_mine = |sequence: &String| sequences.contains(sequence.as_str());
        let scores = scores.iter().filter(|s| is_mine(&s.sequence));
        for ((tracker, method, params), cells) in grouped(scores, |s| (&s.tracker, &s.method, &s.params)) {
            let label = method_label(method, params);
            let is_it = |c: &&FailedCell| is_mine(&c.sequence) && c.tracker == *tracker && c.method == label;
            let failed: Vec<&FailedCell> = without.iter().filter(is_it).collect();
            let counts = cells.iter().map(|cell| cell.counts).sum();
            measures.push(Measure {
                tracker: tracker.clone(),
                method: method.clone(),
                params: params.clone(),
                attribute: Some(attribute.to_string()),
                pooled: Pooled { counts, ..Pooled::default() },
                done: cells.len(),
                failed: failed.len(),
                not_there: failed.iter().filter(|c| c.missing).count(),
            });
        }
    }
    measures
}

/// Reads the file. The expected numbers of random detections are not in it.
///
/// # Errors
/// When the columns are not those of the file, or a number is damaged.
pub fn read(bytes: Vec<u8>) -> Result<Vec<Measure>, TableError> {
    let count = |column: &str, number: i64| {
        u64::try_from(number).map_err(|_| TableError::not_a_number(column, number))
    };
    let frame = MeasureRow::read(bytes)?;
    let measure = |row: MeasureRow<'_>| {
        let [tracker, method, params] = <[&str; 3]>::from(row.of).map(str::to_string);
        let [runs, frames] = [("reverse_runs", row.reverse_runs), ("reverse_frames", row.reverse_frames)]
            .map(|(column, number)| number.map(|number| count(column, number)).transpose());
        // Where no cell has a result the fields are empty.
        let counts = row.counts.unwrap_or_default();
        let effort = runs?.zip(frames?).map(|(runs, frames)| Effort { runs, frames });
        let score = row.score.map(<(f64, f64)>::from);
        let pooled = Pooled { counts, score, effort, delay: row.delay, ..Pooled::default() };
        let done = count("done", row.done)? as usize;
        let failed = count("failed", row.failed)? as usize;
        Ok(Measure { tracker, method, params, attribute: None, pooled, done, failed, not_there: 0 })
    };
    MeasureRow::rows(&frame)?.into_iter().map(measure).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::failed_cell;
    use trackfail_methods::score::Counts;

    // By hand: two sequences are dark, one of them small too; F is that of the summed counts.
    #[test]
    fn counts_are_pooled_over_the_sequences_of_an_attribute() {
        let score = |sequence: &str, run, tp, fp| {
            let [sequence, tracker, method, params] = [sequence, "t", "m", ""].map(String::from);
            CellScore { sequence, tracker, run, method, params, counts: Counts { tp, fp, fn_: 1, tn: 5 } }
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
        let gone = |sequence, method, missing| failed_cell(sequence, "t", method, missing, "it ended");
        let without =
            [gone("b", "m", false), gone("b", "n", false), gone("c", "m", true), gone("a", "m", true)];
        let measures = by_attribute(&scores, &without, &attributes);
        let pooled: Vec<_> =
            measures.iter().map(|m| (m.attribute.as_deref(), m.done, m.value(Metric::F_SCORE))).collect();
        assert_eq!(pooled, [(Some("dark"), 3, Some(6.0 / 13.0)), (Some("small"), 2, Some(6.0 / 8.0))]);
        let without: Vec<_> = measures.iter().map(|m| (m.failed, m.not_there)).collect();
        assert_eq!(without, [(2, 1), (1, 1)]);
    }
}
