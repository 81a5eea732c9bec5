//! `scores.csv`: the counts of every cell; in compact results `scores.parquet`, with the same columns.

use super::cells::{grouped, some_text, sorted_cells};
use super::column::{
    Column, DETECTIONS, EVENTS, F_SCORE, FN, FP, FPR, METHOD, PARAMS, PRECISION, RECALL, RUN, SEQUENCE,
    SUITE, TN, TP, TRACKER, TableFile,
};
use super::frame::TableError;
use super::write::Detail;
use polars::prelude::DataFrame;
use trackfail_engine::CellError;
use trackfail_engine::spec::Experiment;
use trackfail_engine::{Cell, Outcome};
use trackfail_methods::score::{Counts, Metric, Pooled};

const STATUS: Column = Column::text(
    "status",
    "`ok`, or the reason why there is no result (`missing: ...`, `failed: ...`, `not run: ...`) or only a part of it (`partial: 3 of 4`)",
);

/// The file.
pub const FILE: TableFile = TableFile {
    name: "scores.csv",
    about: "One row for each cell (a method on one run of a tracker over a sequence), sorted by its names, and one \
            with sequence `*` for each run of a tracker with a method, pooled over its sequences.",
    columns: &[
        SUITE,
        Column { meaning: "Name of the sequence; `*` for all of them", ..SEQUENCE },
        TRACKER,
        RUN,
        METHOD,
        PARAMS,
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
        STATUS,
    ],
};

/// One row of the file.
struct Row {
    sequence: String,
    tracker: String,
    run: i64,
    method: String,
    params: String,
    counts: Option<Counts>,
    status: String,
}

/// The rows of the file.
///
/// # Errors
/// When polars refuses.
pub(super) fn frame(
    experiment: &Experiment,
    outcome: &Outcome<'_>,
    detail: Detail,
) -> Result<DataFrame, TableError> {
    let cells = sorted_cells(outcome);
    let mut rows: Vec<Row> = cells.iter().map(|cell| row_of_cell(outcome, cell)).collect();
    rows.extend(pooled_rows(outcome, cells));
    if detail == Detail::Frames {
        rows.extend(rows_of_missing(experiment, outcome));
    }
    fn key(r: &Row) -> (&str, &str, i64, &str, &str) {
        (&r.sequence, &r.tracker, r.run, &r.method, &r.params)
    }
    rows.sort_by(|a, b| key(a).cmp(&key(b)));
    let text = |f: fn(&Row) -> &str| rows.iter().map(f).collect::<Vec<_>>();
    let mut columns = vec![
        SUITE.of(vec![outcome.suite.as_str(); rows.len()]),
        SEQUENCE.of(text(|r| &r.sequence)),
        TRACKER.of(text(|r| &r.tracker)),
        RUN.of(rows.iter().map(|r| r.run).collect::<Vec<_>>()),
        METHOD.of(text(|r| &r.method)),
        PARAMS.of(rows.iter().map(|r| some_text(&r.params)).collect::<Vec<_>>()),
    ];
    for column in &FILE.columns[columns.len()..FILE.columns.len() - 1] {
        let value = |row: &Row| {
            let metric = Metric::from_name(column.name)?;
            metric.value(&Pooled { counts: row.counts?, ..Pooled::default() })
        };
        columns.push(column.of_metric(rows.iter().map(value)));
    }
    columns.push(STATUS.of(text(|r| &r.status)));
    FILE.frame(columns)
}

fn row_of_cell(outcome: &Outcome<'_>, cell: &Cell) -> Row {
    Row {
        sequence: outcome.sequences[cell.sequence].name.clone(),
        tracker: cell.tracker.clone(),
        run: i64::from(cell.run),
        method: cell.method.clone(),
        params: cell.params.clone(),
        counts: cell.result.as_ref().ok().map(|judged| judged.score.counts),
        status: match &cell.result {
            Ok(_) => "ok".to_string(),
            Err(CellError::Missing(m)) => format!("missing: {m}"),
            Err(CellError::Failed(m)) => format!("failed: {m}"),
            Err(e @ (CellError::Unmet(_) | CellError::Absent(_))) => format!("not run: {e}"),
        },
    }
}

/// The rows with sequence `*`.
fn pooled_rows(outcome: &Outcome<'_>, cells: Vec<&Cell>) -> Vec<Row> {
    let pooled = |group: Vec<&Cell>| {
        let first = group.first()?;
        let (tracker, method, params) = (first.tracker.clone(), first.method.clone(), first.params.clone());
        let done = group.iter().filter(|c| c.result.is_ok()).count();
        let complete = done == group.len() && outcome.missing.is_empty();
        let status =
            if complete { "ok".to_string() } else { format!("partial: {done} of {}", outcome.wanted) };
        let counts = (done > 0).then(|| sum_of_cells(&group));
        let run = i64::from(first.run);
        Some(Row { sequence: "*".to_string(), tracker, run, method, params, counts, status })
    };
    let groups = grouped(cells, |c| (&c.tracker, c.run, &c.method, &c.params));
    groups.into_iter().filter_map(pooled).collect()
}

/// Rows for the cells of sequences that are not there.
fn rows_of_missing(experiment: &Experiment, outcome: &Outcome<'_>) -> Vec<Row> {
    let mut rows = Vec::new();
    for missing in &outcome.missing {
        for tracker in &experiment.trackers {
            for run in 0..tracker.runs {
                let methods = experiment.methods.iter().filter(|m| m.runs_on(&tracker.label));
                for (method, variant) in methods.flat_map(|m| m.variants.iter().map(move |v| (m, v))) {
                    rows.push(Row {
                        sequence: missing.name.clone(),
                        tracker: tracker.label.clone(),
                        run: i64::from(run),
                        method: method.name.clone(),
                        params: variant.params(),
                        counts: None,
                        status: format!("missing: {}", missing.folder),
                    });
                }
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
    let rows = FILE.read(bytes)?;
    let named = rows.texts(&SEQUENCE)?.into_iter().zip(rows.texts(&STATUS)?);
    let done = named.map(|(sequence, status)| sequence != "*" && status == "ok").collect();
    let rows = rows.filter(done)?;
    let (sequence, tracker) = (rows.texts(&SEQUENCE)?, rows.texts(&TRACKER)?);
    let (method, params) = (rows.texts(&METHOD)?, rows.texts(&PARAMS)?);
    let run: Vec<u32> = rows.all_numbers(&RUN)?;
    let (tp, fp) = (rows.all_numbers(&TP)?, rows.all_numbers(&FP)?);
    let (fn_, tn) = (rows.all_numbers(&FN)?, rows.all_numbers(&TN)?);
    let cell = |i: usize| CellScore {
        sequence: sequence[i].to_string(),
        tracker: tracker[i].to_string(),
        run: i64::from(run[i]),
        method: method[i].to_string(),
        params: params[i].to_string(),
        counts: Counts { tp: tp[i], fp: fp[i], fn_: fn_[i], tn: tn[i] },
    };
    Ok((0..rows.len()).map(cell).collect())
}
