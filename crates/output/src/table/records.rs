//! The files of a results folder, as frames: `scores.csv`, `measures.csv`, `frames.parquet`,
//! `signals.parquet` and `truth.parquet`. Rows are sorted by their names, never by when they were done.

use super::folder::FolderError;
use super::frame::{self, FrameError};
use super::measures::{Measure, grouped, pool_counts};
use crate::detector::track_quality::Effort;
use crate::engine::CellError;
use crate::engine::{Cell, Outcome};
use crate::region::Region;
use crate::score::measures::{Counts, Metric, Pooled};
use crate::spec::Experiment;
use polars::prelude::{Column, DataFrame};

/// A method's name in `frames.parquet`: with its grid point, where it has one.
pub fn method_label(method: &str, params: &str) -> String {
    if params.is_empty() { method.to_string() } else { format!("{method}[{params}]") }
}

pub(super) fn sorted_cells<'a>(outcome: &'a Outcome<'_>) -> Vec<&'a Cell> {
    let mut cells: Vec<&Cell> = outcome.cells.iter().collect();
    let key = |c: &Cell| {
        let name = outcome.sequences[c.sequence].name.clone();
        (name, c.tracker.clone(), c.run, c.method.clone(), c.params.clone())
    };
    cells.sort_by_key(|c| key(c));
    cells
}

/// One row of `scores.csv`.
struct ScoreRow {
    sequence: String,
    tracker: String,
    run: i64,
    method: String,
    params: String,
    pooled: Option<Pooled>,
    status: String,
}

/// `scores.csv`: one row a cell, and pooled rows with `sequence = *`.
///
/// # Errors
/// When polars refuses.
pub fn scores(experiment: &Experiment, outcome: &Outcome<'_>) -> Result<DataFrame, FrameError> {
    let mut rows: Vec<ScoreRow> = Vec::new();
    let cells = sorted_cells(outcome);
    for cell in &cells {
        rows.push(ScoreRow {
            sequence: outcome.sequences[cell.sequence].name.clone(),
            tracker: cell.tracker.clone(),
            run: i64::from(cell.run),
            method: cell.method.clone(),
            params: cell.params.clone(),
            pooled: cell.result.as_ref().ok().map(|j| Pooled { counts: j.score.counts, ..Pooled::default() }),
            status: match &cell.result {
                Ok(_) => "ok".to_string(),
                Err(CellError::Missing(m)) => format!("missing: {m}"),
                Err(CellError::Failed(m)) => format!("failed: {m}"),
            },
        });
    }
    let key = |c: &Cell| (c.tracker.clone(), c.run, c.method.clone(), c.params.clone());
    for group in grouped(cells, key) {
        let Some(cell) = group.first() else { continue };
        let done = group.iter().filter(|c| c.result.is_ok()).count();
        let complete = done == group.len() && outcome.missing.is_empty();
        rows.push(ScoreRow {
            sequence: "*".to_string(),
            tracker: cell.tracker.clone(),
            run: i64::from(cell.run),
            method: cell.method.clone(),
            params: cell.params.clone(),
            pooled: (done > 0).then(|| Pooled { counts: pool_counts(&group), ..Pooled::default() }),
            status: if complete {
                "ok".to_string()
            } else {
                format!("partial: {done} of {}", outcome.wanted)
            },
        });
    }
    for missing in &outcome.missing {
        for tracker in &experiment.trackers {
            for run in 0..tracker.runs {
                let methods = experiment.methods.iter().filter(|m| m.runs_on(&tracker.label));
                for (method, variant) in methods.flat_map(|m| m.variants.iter().map(move |v| (m, v))) {
                    rows.push(ScoreRow {
                        sequence: missing.name.clone(),
                        tracker: tracker.label.clone(),
                        run: i64::from(run),
                        method: method.name.clone(),
                        params: variant.params(),
                        pooled: None,
                        status: format!("missing: {}", missing.folder),
                    });
                }
            }
        }
    }
    rows.sort_by(|a, b| {
        let key =
            |r: &ScoreRow| (r.sequence.clone(), r.tracker.clone(), r.run, r.method.clone(), r.params.clone());
        key(a).cmp(&key(b))
    });
    let text = |f: fn(&ScoreRow) -> &str| rows.iter().map(f).collect::<Vec<_>>();
    let count = |metric: Metric| {
        rows.iter()
            .map(|r| r.pooled.as_ref().and_then(|p| p.value(metric)).map(|v| v as i64))
            .collect::<Vec<_>>()
    };
    let ratio = |metric: Metric| {
        rows.iter().map(|r| r.pooled.as_ref().and_then(|p| p.value(metric))).collect::<Vec<_>>()
    };
    let mut columns = vec![
        Column::new("suite".into(), vec![outcome.suite.as_str(); rows.len()]),
        Column::new("sequence".into(), text(|r| &r.sequence)),
        Column::new("tracker".into(), text(|r| &r.tracker)),
        Column::new("run".into(), rows.iter().map(|r| r.run).collect::<Vec<_>>()),
        Column::new("method".into(), text(|r| &r.method)),
        Column::new("params".into(), rows.iter().map(|r| some_text(&r.params)).collect::<Vec<_>>()),
    ];
    for metric in [Metric::Tp, Metric::Fp, Metric::Fn, Metric::Tn, Metric::Events, Metric::Detections] {
        columns.push(Column::new(metric.name().into(), count(metric)));
    }
    for metric in [Metric::Precision, Metric::Recall, Metric::FScore, Metric::Fpr] {
        columns.push(Column::new(metric.name().into(), ratio(metric)));
    }
    columns.push(Column::new("status".into(), text(|r| &r.status)));
    frame::frame(columns)
}

/// An empty text is a missing value, so that the CSV field is empty and not `""`.
pub(super) fn some_text(text: &str) -> Option<&str> {
    (!text.is_empty()).then_some(text)
}

/// The counts of one cell, as read back from `scores.csv`.
#[derive(Debug, Clone, PartialEq)]
pub struct CellScore {
    /// Sequence.
    pub sequence: String,
    /// Label of the tracker.
    pub tracker: String,
    /// Repetition.
    pub run: i64,
    /// Method.
    pub method: String,
    /// Grid point, empty without a grid.
    pub params: String,
    /// What was counted.
    pub counts: Counts,
}

/// Reads the cells of `scores.csv` back that have counts; pooled rows are left out.
///
/// # Errors
/// When a column is missing or a count is none.
pub fn read_scores(bytes: Vec<u8>) -> Result<Vec<CellScore>, FrameError> {
    let table = frame::from_csv(bytes)?;
    let text = |name: &str| frame::texts(&table, name);
    let (sequences, trackers, methods) = (text("sequence")?, text("tracker")?, text("method")?);
    let (params, status, run) = (text("params")?, text("status")?, text("run")?);
    let (tp, fp, fn_, tn) = (text("tp")?, text("fp")?, text("fn")?, text("tn")?);
    let count = |text: &str| text.parse::<u64>().map_err(|_| FrameError::number(text));
    let done = (0..sequences.len()).filter(|i| sequences[*i] != "*" && status[*i] == "ok");
    done.map(|i| {
        let (tp, fp) = (count(&tp[i])?, count(&fp[i])?);
        Ok(CellScore {
            sequence: sequences[i].clone(),
            tracker: trackers[i].clone(),
            run: count(&run[i])? as i64,
            method: methods[i].clone(),
            params: params[i].clone(),
            counts: Counts { tp, fp, fn_: count(&fn_[i])?, tn: count(&tn[i])? },
        })
    })
    .collect()
}

/// Columns of `measures.csv`, besides one for each metric.
const MEASURE_METRICS: [Metric; 15] = [
    Metric::Tp,
    Metric::Fp,
    Metric::Fn,
    Metric::Tn,
    Metric::Events,
    Metric::Detections,
    Metric::Precision,
    Metric::Recall,
    Metric::FScore,
    Metric::Fpr,
    Metric::ScoreMean,
    Metric::ScoreStd,
    Metric::ReverseRuns,
    Metric::ReverseFrames,
    Metric::DelayMedian,
];

/// `measures.csv`: everything pooled over sequences and runs, one row a tracker and variant.
///
/// # Errors
/// When polars refuses.
pub fn measures(suite: &str, measures: &[Measure]) -> Result<DataFrame, FrameError> {
    let mut columns = vec![
        Column::new("suite".into(), vec![suite; measures.len()]),
        Column::new("tracker".into(), measures.iter().map(|m| m.tracker.as_str()).collect::<Vec<_>>()),
        Column::new("method".into(), measures.iter().map(|m| m.method.as_str()).collect::<Vec<_>>()),
        Column::new("params".into(), measures.iter().map(|m| some_text(&m.params)).collect::<Vec<_>>()),
        Column::new("done".into(), measures.iter().map(|m| m.done as i64).collect::<Vec<_>>()),
        Column::new("failed".into(), measures.iter().map(|m| m.failed as i64).collect::<Vec<_>>()),
    ];
    for metric in MEASURE_METRICS {
        let name = metric.name().into();
        let values = measures.iter().map(|m| m.value(metric));
        columns.push(if metric.is_count() {
            Column::new(name, values.map(|v| v.map(|v| v as i64)).collect::<Vec<_>>())
        } else {
            Column::new(name, values.collect::<Vec<_>>())
        });
    }
    frame::frame(columns)
}

/// Reads `measures.csv` back.
///
/// # Errors
/// When a column is missing or a number is none.
pub fn read_measures(bytes: Vec<u8>) -> Result<Vec<Measure>, FrameError> {
    let table = frame::from_csv(bytes)?;
    let text = |name: &str| frame::texts(&table, name);
    let (trackers, methods, params) = (text("tracker")?, text("method")?, text("params")?);
    let mut numbers = Vec::new();
    for name in ["done", "failed"].into_iter().chain(MEASURE_METRICS.iter().map(|m| m.name())) {
        let new = [Metric::ReverseRuns, Metric::ReverseFrames, Metric::DelayMedian];
        let is_new = Metric::from_name(name).is_some_and(|m| new.contains(&m));
        // Results of earlier programs, none of whose methods ran trackers backwards, lack these.
        numbers.push(
            text(name).or_else(|e| if is_new { Ok(vec![String::new(); trackers.len()]) } else { Err(e) })?,
        );
    }
    let mut measures = Vec::new();
    for i in 0..trackers.len() {
        // Without a value the field is empty; anything else that is no number is damage.
        let count = |k: usize| match numbers[k][i].as_str() {
            "" => Ok(0),
            text => text.parse::<u64>().map_err(|_| FrameError::number(text)),
        };
        let real = |k: usize| match numbers[k][i].as_str() {
            "" => Ok(None),
            text => text.parse::<f64>().map(Some).map_err(|_| FrameError::number(text)),
        };
        let counts = Counts { tp: count(2)?, fp: count(3)?, fn_: count(4)?, tn: count(5)? };
        measures.push(Measure {
            tracker: trackers[i].clone(),
            method: methods[i].clone(),
            params: params[i].clone(),
            attribute: None,
            pooled: Pooled {
                counts,
                score: real(12)?.zip(real(13)?),
                effort: Effort { runs: count(14)?, frames: count(15)? },
                delay: real(16)?,
                ..Pooled::default()
            },
            done: count(0)? as usize,
            failed: count(1)? as usize,
        });
    }
    Ok(measures)
}

/// Rows of `frames.parquet` that are in memory at once, about.
const ROWS_AT_ONCE: usize = 1 << 19;

/// `frames.parquet`, as Parquet: one row for every frame of every cell that has a result.
///
/// # Errors
/// When polars refuses, or a verdict cannot be had any more.
pub fn frames(outcome: &Outcome<'_>) -> Result<Vec<u8>, FolderError> {
    let cells = sorted_cells(outcome);
    let mut parts: Vec<&[&Cell]> = Vec::new();
    let mut rest = cells.as_slice();
    while !rest.is_empty() {
        let mut rows = 0;
        let fits = |cell: &&&Cell| {
            rows += outcome.sequences[cell.sequence].len();
            rows <= ROWS_AT_ONCE
        };
        let (part, later) = rest.split_at(rest.iter().take_while(fits).count().max(1));
        parts.push(part);
        rest = later;
    }
    if parts.is_empty() {
        parts.push(&[]);
    }
    frame::parts_to_parquet(parts.into_iter().map(|cells| some_frames(outcome, cells)))
}

fn some_frames(outcome: &Outcome<'_>, cells: &[&Cell]) -> Result<DataFrame, FolderError> {
    let mut keys = Keys::default();
    let (mut x, mut y, mut w, mut h) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
    let (mut error, mut method, mut score) = (Vec::new(), Vec::new(), Vec::new());
    let (mut label, mut change) = (Vec::new(), Vec::new());
    for cell in cells {
        let Ok(judged) = &cell.result else { continue };
        let Some(Ok(track)) = outcome.tracks.get(cell.sequence).and_then(|t| t.get(cell.job)) else {
            continue;
        };
        let verdict = outcome.verdict(cell, judged)?;
        let name = method_label(&cell.method, &cell.params);
        keys.push(outcome, cell, track.regions.len());
        for rect in track.regions.iter().map(Region::rect) {
            x.push(rect.x);
            y.push(rect.y);
            w.push(rect.w);
            h.push(rect.h);
        }
        error.extend(track.error.iter().map(|e| (!e.is_nan()).then_some(*e)));
        method.extend(std::iter::repeat_n(name, track.regions.len()));
        score.extend_from_slice(&verdict.score);
        label.extend(verdict.alarm.iter().map(|a| i32::from(*a)));
        change.extend_from_slice(&verdict.changes());
    }
    let mut columns = keys.columns(&outcome.suite);
    columns.extend([
        Column::new("x".into(), x),
        Column::new("y".into(), y),
        Column::new("w".into(), w),
        Column::new("h".into(), h),
        Column::new("error".into(), error),
        Column::new("method".into(), method),
        Column::new("score".into(), score),
        Column::new("label".into(), label),
        Column::new("change".into(), change),
    ]);
    Ok(frame::frame(columns)?)
}

/// `signals.parquet`: each method's signal and forecast, for methods without a grid.
///
/// # Errors
/// When polars refuses, or a verdict cannot be had any more.
pub fn signals(outcome: &Outcome<'_>) -> Result<DataFrame, FolderError> {
    let mut keys = Keys::default();
    let (mut method, mut signal, mut forecast) = (Vec::new(), Vec::new(), Vec::new());
    for cell in sorted_cells(outcome) {
        let (Ok(judged), Some(index)) = (&cell.result, cell.signal) else { continue };
        let Some(Ok(track)) = outcome.tracks.get(cell.sequence).and_then(|t| t.get(cell.job)) else {
            continue;
        };
        if !cell.params.is_empty() {
            continue;
        }
        let values = &track.signals[index];
        keys.push(outcome, cell, values.len());
        method.extend(std::iter::repeat_n(cell.method.as_str(), values.len()));
        signal.extend_from_slice(values);
        match &outcome.verdict(cell, judged)?.forecast {
            Some(f) => forecast.extend(f.iter().map(|v| (!v.is_nan()).then_some(*v))),
            None => forecast.extend(std::iter::repeat_n(None, values.len())),
        }
    }
    let mut columns = keys.columns(&outcome.suite);
    columns.extend([
        Column::new("method".into(), method),
        Column::new("signal".into(), signal),
        Column::new("forecast".into(), forecast),
    ]);
    Ok(frame::frame(columns)?)
}

/// `truth.parquet`: the corners of the ground truth, empty where the target is not annotated.
///
/// # Errors
/// When polars refuses.
pub fn truth(outcome: &Outcome<'_>) -> Result<DataFrame, FrameError> {
    let mut sequences: Vec<_> = outcome.sequences.iter().collect();
    sequences.sort_by(|a, b| a.name.cmp(&b.name));
    let (mut name, mut number) = (Vec::new(), Vec::new());
    let mut corners: Vec<Vec<Option<f64>>> = vec![Vec::new(); 8];
    for sequence in sequences {
        for (t, region) in sequence.truth.iter().enumerate() {
            name.push(sequence.name.as_str());
            number.push(i64::from(sequence.number(t)));
            let points = region.as_ref().map(|r| match r.corners() {
                four if four.len() == 4 => four,
                _ => r.rect().corners().to_vec(),
            });
            for (k, column) in corners.iter_mut().enumerate() {
                let point = points.as_ref().map(|p| p[k / 2]);
                column.push(point.map(|p| if k % 2 == 0 { p.0 } else { p.1 }));
            }
        }
    }
    let mut columns = vec![
        Column::new("suite".into(), vec![outcome.suite.as_str(); name.len()]),
        Column::new("sequence".into(), name),
        Column::new("frame".into(), number),
    ];
    for (label, values) in ["x1", "y1", "x2", "y2", "x3", "y3", "x4", "y4"].into_iter().zip(corners) {
        columns.push(Column::new(label.into(), values));
    }
    frame::frame(columns)
}

/// The leading columns that name a frame of a track.
#[derive(Default)]
pub(super) struct Keys<'a> {
    sequence: Vec<&'a str>,
    tracker: Vec<&'a str>,
    run: Vec<i64>,
    frame: Vec<i64>,
}

impl<'a> Keys<'a> {
    pub(super) fn push(&mut self, outcome: &'a Outcome<'_>, cell: &'a Cell, length: usize) {
        let sequence = &outcome.sequences[cell.sequence];
        self.sequence.extend(std::iter::repeat_n(sequence.name.as_str(), length));
        self.tracker.extend(std::iter::repeat_n(cell.tracker.as_str(), length));
        self.run.extend(std::iter::repeat_n(i64::from(cell.run), length));
        self.frame.extend((0..length).map(|t| i64::from(sequence.number(t))));
    }

    pub(super) fn columns(self, suite: &str) -> Vec<Column> {
        vec![
            Column::new("suite".into(), vec![suite; self.frame.len()]),
            Column::new("sequence".into(), self.sequence),
            Column::new("tracker".into(), self.tracker),
            Column::new("run".into(), self.run),
            Column::new("frame".into(), self.frame),
        ]
    }
}
