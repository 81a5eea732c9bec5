//! `scores.csv`: counts of all cells; in compact results `scores.parquet`, with the same columns.

use super::cells::{grouped, sorted_cells, track_name};
use super::files::Score;
use super::folder::Detail;
use super::rows::{Column, Field, Rows, TableError, group};
use polars::prelude::{Column as Values, DataFrame};
use trackfail_dataset::suite::Missing;
use trackfail_engine::spec::Experiment;
use trackfail_engine::spec::method::Method;
use trackfail_engine::{Cell, CellError, Outcome};
use trackfail_methods::score::{Counts, Metric, Pooled};

/// Four counts, and the metrics computed from them.
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
            let found = || four[k][i].map_or(String::new(), |n| n.to_string());
            let refused = || TableError::not_a_number(columns[k].name, found());
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

/// Rows of the file: cells, runs of a tracker with a method, and missing sequences.
pub(super) fn frame(
    experiment: &Experiment,
    outcome: &Outcome<'_>,
    detail: Detail,
) -> Result<DataFrame, TableError> {
    let cells = sorted_cells(outcome);
    let mut rows: Vec<Score<'_>> = cells.iter().map(|cell| of_cell(outcome, cell)).collect();
    let runs = grouped(cells, |c| (&c.tracker, c.run, &c.method, &c.params));
    rows.extend(runs.iter().map(|(_, cells)| of_run(outcome, cells)));
    let variants = experiment.methods.iter().flat_map(|m| m.variants.iter().map(move |v| (m, v.params())));
    let variants: Vec<(&Method, String)> = variants.collect();
    let not_there: &[Missing] = if detail == Detail::Frames { &outcome.test().missing } else { &[] };
    for (missing, tracker) in not_there.iter().flat_map(|m| experiment.trackers.iter().map(move |t| (m, t))) {
        for (method, params) in variants.iter().filter(|(method, _)| method.runs_on(&tracker.label)) {
            rows.extend((0..tracker.runs).map(|run| Score {
                track: (&missing.name, &tracker.label, i64::from(run)),
                method: &method.name,
                params,
                counts: None,
                status: format!("missing: {}", missing.folder),
            }));
        }
    }
    rows.sort_by_key(|row| (row.track, row.method, row.params));
    Score::frame(outcome.suite(), rows)
}

fn of_cell<'a>(outcome: &'a Outcome<'_>, cell: &'a Cell) -> Score<'a> {
    let status = match &cell.result {
        Ok(_) => "ok".to_string(),
        Err(CellError::Missing(m)) => format!("missing: {m}"),
        Err(CellError::Failed(m)) => format!("failed: {m}"),
        Err(e @ (CellError::Unmet(_) | CellError::Absent(_))) => format!("not run: {e}"),
    };
    let counts = cell.result.as_ref().ok().map(|judged| judged.score.counts);
    Score { track: track_name(outcome, cell), method: &cell.method, params: &cell.params, counts, status }
}

/// Row for all cells of a run, with sequence `*`.
fn of_run<'a>(outcome: &'a Outcome<'_>, cells: &[&'a Cell]) -> Score<'a> {
    let counts = cells.iter().filter_map(|cell| Some(cell.result.as_ref().ok()?.score.counts));
    let counts: Vec<Counts> = counts.collect();
    let (done, first) = (counts.len(), of_cell(outcome, cells[0]));
    let is_complete = done == cells.len() && outcome.test().missing.is_empty();
    let status =
        if is_complete { "ok".to_string() } else { format!("partial: {done} of {}", outcome.test().wanted) };
    let (_, tracker, run) = first.track;
    let counts = (done > 0).then(|| counts.into_iter().sum());
    Score { track: ("*", tracker, run), counts, status, ..first }
}

/// Counts of one cell.
#[derive(Debug, Clone, PartialEq)]
pub struct CellScore {
    /// Name of the sequence.
    pub sequence: String,
    /// Label of the tracker.
    pub tracker: String,
    /// Repetition of the tracker, from 0.
    pub run: i64,
    /// Name of the method.
    pub method: String,
    /// Grid point; empty without a grid.
    pub params: String,
    /// Counts by the method's protocol.
    pub counts: Counts,
}

/// Reads the cells that have a result. Pooled rows are left out.
///
/// # Errors
/// When the columns are not those of the file, or a count is not a number.
pub fn read(bytes: Vec<u8>) -> Result<Vec<CellScore>, TableError> {
    let frame = Score::read(bytes)?;
    let rows = Score::rows(&frame)?;
    let done = rows.into_iter().filter(|row| row.track.0 != "*" && row.status == "ok");
    let cell = |Score { track: (sequence, tracker, run), method, params, counts, .. }: Score<'_>| {
        let [sequence, tracker, method, params] = [sequence, tracker, method, params].map(str::to_string);
        let score = counts.map(|counts| CellScore { sequence, tracker, run, method, params, counts });
        score.ok_or_else(|| TableError::not_a_number("tp", ""))
    };
    done.map(cell).collect()
}
