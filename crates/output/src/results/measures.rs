//! `measures.csv`: everything pooled over sequences and runs.

use super::ResultsError;
use super::cells::{grouped, method_label, parse_point, some_text};
use super::column::{
    Column, DETECTIONS, EVENTS, F_SCORE, FN, FP, FPR, METHOD, PARAMS, PRECISION, RECALL, SUITE, TN, TP,
    TRACKER, TableFile,
};
use super::frame::{TableError, to_csv};
use super::manifest::FailedCell;
use super::scores::{CellScore, sum_of_cells};
use std::collections::{BTreeMap, BTreeSet};
use trackfail_engine::store::StoreError;
use trackfail_engine::{Cell, Outcome};
use trackfail_methods::detector::track_quality::Effort;
use trackfail_methods::score::pooled::{median_delay, normalized_mean_std};
use trackfail_methods::score::restarts;
use trackfail_methods::score::{Counts, Metric, Pooled};

const DONE: Column = Column::integer("done", "cells", "Cells that have a result");
const FAILED: Column = Column::integer(
    "failed",
    "cells",
    "Cells that failed, or whose data is missing although their sequence is there",
);
const NO_SCORES: &str = "no sequence has scores that differ";
const SCORE_MEAN: Column =
    Column::real("score_mean", "", "Mean of the scores of all frames, each sequence's scaled to 0..1")
        .empty(NO_SCORES);
const SCORE_STD: Column =
    Column::real("score_std", "", "Standard deviation of the same scaled scores").empty(NO_SCORES);
const REVERSE_RUNS: Column = Column::integer("reverse_runs", "", "Runs of the tracker backwards in time")
    .empty("there is no result")
    .recent();
const REVERSE_FRAMES: Column = Column::integer("reverse_frames", "frames", "Frames of all runs backwards")
    .empty("there is no result")
    .recent();
const DELAY_MEDIAN: Column =
    Column::real("delay_median", "frames", "Median delay from an event to the detection that matches it")
        .empty("no detection matches an event")
        .recent();

/// The file.
pub const FILE: TableFile = TableFile {
    name: "measures.csv",
    about: "One row for each tracker and method (with its grid point), pooled over sequences and runs: ratios are those \
            of the summed counts.",
    columns: &[
        SUITE,
        TRACKER,
        METHOD,
        PARAMS,
        DONE,
        FAILED,
        TP,
        FP,
        FN,
        TN,
        EVENTS,
        DETECTIONS,
        PRECISION,
        RECALL,
        F_SCORE,
        FPR,
        SCORE_MEAN,
        SCORE_STD,
        REVERSE_RUNS,
        REVERSE_FRAMES,
        DELAY_MEDIAN,
    ],
};

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
    /// Those of them whose data is missing. The file does not tell them apart, the manifest does.
    pub not_there: usize,
}

impl Measure {
    /// The grid point: axis and value.
    pub fn point(&self) -> Vec<(String, f64)> {
        parse_point(&self.params)
    }

    /// The value of a metric, where there is one.
    pub fn value(&self, metric: Metric) -> Option<f64> {
        (self.done > 0).then(|| metric.value(&self.pooled)).flatten()
    }
}

/// Pools an outcome's cells, in the order in which trackers and variants first appear.
///
/// # Errors
/// When a detection cannot be read from the store any more.
pub(super) fn pool(outcome: &Outcome<'_>) -> Result<Vec<Measure>, StoreError> {
    let groups = grouped(outcome.cells.iter(), |cell| (&cell.tracker, &cell.method, &cell.params));
    groups
        .into_iter()
        .filter_map(|cells| Some((*cells.first()?, cells)))
        .map(|(first, cells)| {
            Ok(Measure {
                tracker: first.tracker.clone(),
                method: first.method.clone(),
                params: first.params.clone(),
                attribute: None,
                pooled: pool_cells(outcome, &cells)?,
                done: cells.iter().filter(|c| c.result.is_ok()).count(),
                failed: cells.iter().filter(|c| c.has_failed()).count(),
                not_there: 0,
            })
        })
        .collect()
}

/// Pools the cells that have a result.
fn pool_cells(outcome: &Outcome<'_>, cells: &[&Cell]) -> Result<Pooled, StoreError> {
    let judged = || cells.iter().filter_map(|c| Some((c, c.result.as_ref().ok()?)));
    let detections = judged().map(|(cell, judged)| outcome.detector_output(cell, judged));
    let detections = detections.collect::<Result<Vec<_>, StoreError>>()?;
    Ok(Pooled {
        counts: sum_of_cells(cells),
        score: normalized_mean_std(
            judged().zip(&detections).map(|((_, judged), d)| restarts::counted(&judged.pieces, &d.score)),
        ),
        effort: judged().map(|(_, judged)| judged.effort).sum(),
        delay: median_delay(judged().flat_map(|(_, judged)| judged.score.delays()).collect()),
        ..Pooled::default()
    })
}

/// Pools the counts of the sequences with each attribute, attributes by name; trackers and variants in the
/// order in which they come. Scores, delays and runs backwards are not known of a single cell and are left out; `without` are
/// the cells without a result.
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
        let without: Vec<&FailedCell> =
            without.iter().filter(|cell| sequences.contains(cell.sequence.as_str())).collect();
        let mut places: BTreeMap<(&str, &str, &str), usize> = BTreeMap::new();
        for score in scores.iter().filter(|s| sequences.contains(s.sequence.as_str())) {
            let place = *places.entry((&score.tracker, &score.method, &score.params)).or_insert_with(|| {
                let label = method_label(&score.method, &score.params);
                let mine = without.iter().filter(|c| c.tracker == score.tracker && c.method == label);
                measures.push(Measure {
                    tracker: score.tracker.clone(),
                    method: score.method.clone(),
                    params: score.params.clone(),
                    attribute: Some(attribute.to_string()),
                    pooled: Pooled::default(),
                    done: 0,
                    failed: mine.clone().count(),
                    not_there: mine.filter(|c| c.missing).count(),
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

/// Writes the file.
///
/// # Errors
/// When a detection cannot be read from the store any more, or polars refuses.
pub(super) fn write(outcome: &Outcome<'_>) -> Result<Vec<u8>, ResultsError> {
    let measures = pool(outcome)?;
    let text = |f: fn(&Measure) -> &str| measures.iter().map(f).collect::<Vec<_>>();
    let count = |f: fn(&Measure) -> usize| measures.iter().map(|m| f(m) as i64).collect::<Vec<_>>();
    let mut columns = vec![
        SUITE.of(vec![outcome.suite.as_str(); measures.len()]),
        TRACKER.of(text(|m| &m.tracker)),
        METHOD.of(text(|m| &m.method)),
        PARAMS.of(measures.iter().map(|m| some_text(&m.params)).collect::<Vec<_>>()),
        DONE.of(count(|m| m.done)),
        FAILED.of(count(|m| m.failed)),
    ];
    for column in &FILE.columns[columns.len()..] {
        let metric = Metric::from_name(column.name);
        columns.push(column.of_metric(measures.iter().map(|m| m.value(metric?))));
    }
    Ok(to_csv(FILE.frame(columns)?)?)
}

/// Reads the file; the expected numbers of random detections are not in it.
///
/// # Errors
/// When the columns are not those of the file, or a number is damaged.
pub fn read(bytes: Vec<u8>) -> Result<Vec<Measure>, TableError> {
    let rows = FILE.read_csv(bytes)?;
    let (tracker, method, params) = (rows.texts(&TRACKER)?, rows.texts(&METHOD)?, rows.texts(&PARAMS)?);
    // Where no cell has a result the fields are empty.
    let count = |column| -> Result<Vec<u64>, TableError> {
        Ok(rows.numbers(column)?.into_iter().map(Option::unwrap_or_default).collect())
    };
    let (tp, fp, fn_, tn) = (count(&TP)?, count(&FP)?, count(&FN)?, count(&TN)?);
    let (mean, std): (Vec<Option<f64>>, _) = (rows.numbers(&SCORE_MEAN)?, rows.numbers(&SCORE_STD)?);
    let (runs, frames) = (count(&REVERSE_RUNS)?, count(&REVERSE_FRAMES)?);
    let delay = rows.numbers(&DELAY_MEDIAN)?;
    let (done, failed) = (count(&DONE)?, count(&FAILED)?);
    let measure = |i: usize| Measure {
        tracker: tracker[i].to_string(),
        method: method[i].to_string(),
        params: params[i].to_string(),
        attribute: None,
        pooled: Pooled {
            counts: Counts { tp: tp[i], fp: fp[i], fn_: fn_[i], tn: tn[i] },
            score: mean[i].zip(std[i]),
            effort: Effort { runs: runs[i], frames: frames[i] },
            delay: delay[i],
            ..Pooled::default()
        },
        done: done[i] as usize,
        failed: failed[i] as usize,
        not_there: 0,
    };
    Ok((0..rows.len()).map(measure).collect())
}

/// Counts the cells of each measure whose data is not there.
pub(super) fn count_not_there(measures: &mut [Measure], cells: &[FailedCell]) {
    for measure in measures {
        let label = method_label(&measure.method, &measure.params);
        let is_mine = |c: &&FailedCell| c.missing && c.tracker == measure.tracker && c.method == label;
        measure.not_there = cells.iter().filter(is_mine).count();
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use trackfail_methods::score::Metric;

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
        let gone = |sequence: &str, method: &str, missing| FailedCell {
            sequence: sequence.into(),
            tracker: "t".into(),
            run: 1,
            method: method.into(),
            missing,
            reason: "it ended".into(),
        };
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
