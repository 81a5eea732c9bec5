//! `scores.csv`: the counts of every cell; in compact results `scores.parquet`, with the same columns.

use super::cells::{grouped, sorted_cells};
use super::files::Score;
use super::folder::Detail;
use super::rows::{Column, Field, Rows, TableError, group};
use polars::prelude::{Column as Values, DataFrame};
use trackfail_engine::spec::Experiment;
use trackfail_engine::{Cell, CellError, Outcome};
use trackfail_methods::score::{Counts, Metric, Pooled};

/// The four counts, and the metrics that are made of them.
impl<'a> Field<'a> for Option<Counts> {
    fn write(columns: &[Column], values: Vec<Self>) -> Vec<Values> {
        let value = |counts: &Self, k: usize| {
            Metric::from_name(columns[k].name)?.value(&Pooled { counts: (*counts)?, ..Pooled::default() })
        };
        group(columns, &values, value)
    }

    fn read(columns: &[Column], frame: &'a DataFrame) -> Result<Vec<Self>, TableError> {
        let of = |column: &Column| <Option<i64> as Field>::read(&[*column], frame);
        let four = columns[..4].iter().map(of).collect::<Result<Vec<_>, _>>()?;
        let count = |i: usize, k: usize| {
            let refused = || columns[k].not_a_number(&four[k][i].map_or(String::new(), |n| n.to_string()));
            four[k][i].and_then(|n| u64::try_from(n).ok()).ok_or_else(refused)
        };
        let counts = |i: usize| match four.iter().all(|numbers| numbers[i].is_none()) {
            true => Ok(None),
            false => {
                Ok(Some(Counts { tp: count(i, 0)?, fp: count(i, 1)?, fn_: count(i, 2)?, tn: count(i, 3)? }))
            }
        };
        (0..frame.height()).map(counts).collect()
    }
}

/// The rows of the file.
pub(super) fn rows(experiment: &Experiment, outcome: &Outcome<'_>, detail: Detail) -> Vec<Score> {
    let cells = sorted_cells(outcome);
    let mut rows: Vec<Score> = cells.iter().map(|cell| of_cell(outcome, cell)).collect();
    let runs = grouped(cells, |c| (&c.tracker, c.run, &c.method, &c.params));
    rows.extend(runs.iter().map(|(_, cells)| of_run(outcome, cells)));
    if detail == Detail::Frames {
        rows.extend(of_missing(experiment, outcome));
    }
    fn key(r: &Score) -> (&str, &str, i64, &str, &str) {
        (&r.sequence, &r.tracker, r.run, &r.method, &r.params)
    }
    rows.sort_by(|a, b| key(a).cmp(&key(b)));
    rows
}

fn row(sequence: &str, cell: &Cell, counts: Option<Counts>, status: String) -> Score {
    let Cell { tracker, run, method, params, .. } = cell;
    let [tracker, method, params] = [tracker, method, params].map(String::clone);
    Score { sequence: sequence.to_string(), tracker, run: i64::from(*run), method, params, counts, status }
}

fn of_cell(outcome: &Outcome<'_>, cell: &Cell) -> Score {
    let status = match &cell.result {
        Ok(_) => "ok".to_string(),
        Err(CellError::Missing(m)) => format!("missing: {m}"),
        Err(CellError::Failed(m)) => format!("failed: {m}"),
        Err(e @ (CellError::Unmet(_) | CellError::Absent(_))) => format!("not run: {e}"),
    };
    let counts = cell.result.as_ref().ok().map(|judged| judged.score.counts);
    row(&outcome.sequences[cell.sequence].name, cell, counts, status)
}

/// The row with sequence `*` of the cells of a run.
fn of_run(outcome: &Outcome<'_>, cells: &[&Cell]) -> Score {
    let done = cells.iter().filter(|c| c.result.is_ok()).count();
    let complete = done == cells.len() && outcome.missing.is_empty();
    let status = if complete { "ok".to_string() } else { format!("partial: {done} of {}", outcome.wanted) };
    row("*", cells[0], (done > 0).then(|| sum_of_cells(cells)), status)
}

/// Rows for the cells of sequences that are not there.
fn of_missing(experiment: &Experiment, outcome: &Outcome<'_>) -> Vec<Score> {
    let mut rows = Vec::new();
    for missing in &outcome.missing {
        for tracker in &experiment.trackers {
            let methods = experiment.methods.iter().filter(|m| m.runs_on(&tracker.label));
            for (method, variant) in methods.flat_map(|m| m.variants.iter().map(move |v| (m, v))) {
                rows.extend((0..tracker.runs).map(|run| Score {
                    sequence: missing.name.clone(),
                    tracker: tracker.label.clone(),
                    run: i64::from(run),
                    method: method.name.clone(),
                    params: variant.params(),
                    counts: None,
                    status: format!("missing: {}", missing.folder),
                }));
            }
        }
    }
    rows
}

/// The summed counts of the cells that have a result.
pub(super) fn sum_of_cells(cells: &[&Cell]) -> Counts {
    cells.iter().filter_map(|c| c.result.as_ref().ok()).map(|judged| judged.score.counts).sum()
}

/// The counts of one cell.
#[derive(Debug, Clone, PartialEq)]
pub struct CellScore {
    /// Sequence.
    pub sequence: String,
    /// Label of the tracker.
    pub tracker: String,
    /// Repetition, from 0.
    pub run: i64,
    /// Method.
    pub method: String,
    /// Grid point, empty without a grid.
    pub params: String,
    /// Counts of the protocol.
    pub counts: Counts,
}

/// Reads the cells that have a result; pooled rows are left out.
///
/// # Errors
/// When the columns are not those of the file, or a count is not a number.
pub fn read(bytes: Vec<u8>) -> Result<Vec<CellScore>, TableError> {
    let rows = Score::rows(&Score::read(bytes)?)?;
    let done = rows.into_iter().filter(|row| row.sequence != "*" && row.status == "ok");
    let cell = |Score { sequence, tracker, run, method, params, counts, .. }: Score| {
        let lacking = || TableError::Number { column: "tp", found: String::new() };
        let of = |counts| CellScore { sequence, tracker, run, method, params, counts };
        counts.map(of).ok_or_else(lacking)
    };
    done.map(cell).collect()
}
