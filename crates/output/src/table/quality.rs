//! How detectors that follow the condition of a tracker came to their labels: `conditions.parquet` and
//! `checks.csv`, in results folders of experiments that have such a method.

use super::folder::FolderError;
use super::frame;
use super::records::{Keys, some_text, sorted_cells};
use crate::detector::{Check, Quality};
use crate::engine::store::StoreError;
use crate::engine::{Cell, Outcome};
use polars::prelude::{Column, DataFrame};

/// The condition of the tracker in each frame.
pub const CONDITIONS: &str = "conditions.parquet";
/// The runs of the tracker backwards.
pub const CHECKS: &str = "checks.csv";

/// The cells that have a [`Quality`], in the order of all files.
fn with_quality<'a>(outcome: &'a Outcome<'_>) -> Result<Vec<(&'a Cell, Quality)>, StoreError> {
    let mut all = Vec::new();
    for cell in sorted_cells(outcome) {
        let Ok(judged) = &cell.result else { continue };
        if !judged.follows {
            continue;
        }
        if let Some(quality) = &outcome.verdict(cell, judged)?.quality {
            all.push((cell, quality.clone()));
        }
    }
    Ok(all)
}

/// Both files, by name; none where no method follows a condition.
///
/// # Errors
/// When polars refuses, or a verdict cannot be had any more.
pub fn files(outcome: &Outcome<'_>) -> Result<Vec<(&'static str, Vec<u8>)>, FolderError> {
    let cells = with_quality(outcome)?;
    if cells.is_empty() {
        return Ok(Vec::new());
    }
    Ok(vec![
        (CONDITIONS, frame::to_parquet(&mut conditions(outcome, &cells)?)?),
        (CHECKS, frame::to_csv(&mut checks(outcome, &cells)?)?),
    ])
}

/// One row a frame of every cell of a method without a grid: 1 locked on, 0.5 locking in, 0 scanning.
fn conditions(outcome: &Outcome<'_>, cells: &[(&Cell, Quality)]) -> Result<DataFrame, FolderError> {
    let mut keys = Keys::default();
    let (mut method, mut condition) = (Vec::new(), Vec::new());
    for (cell, quality) in cells.iter().filter(|(cell, _)| cell.params.is_empty()) {
        keys.push(outcome, cell, quality.condition.len());
        method.extend(std::iter::repeat_n(cell.method.as_str(), quality.condition.len()));
        condition.extend(quality.condition.iter().map(|c| c.level()));
    }
    let mut columns = keys.columns(&outcome.suite);
    columns.extend([Column::new("method".into(), method), Column::new("condition".into(), condition)]);
    Ok(frame::frame(columns)?)
}

/// One row a check of every cell.
fn checks(outcome: &Outcome<'_>, cells: &[(&Cell, Quality)]) -> Result<DataFrame, FolderError> {
    let all: Vec<(&Cell, &Check)> =
        cells.iter().flat_map(|(cell, quality)| quality.checks.iter().map(|c| (*cell, c))).collect();
    let number = |cell: &Cell, t: usize| i64::from(outcome.sequences[cell.sequence].number(t));
    let text = |f: &dyn Fn(&Cell) -> String| all.iter().map(|(cell, _)| f(cell)).collect::<Vec<_>>();
    Ok(frame::frame(vec![
        Column::new("suite".into(), vec![outcome.suite.as_str(); all.len()]),
        Column::new("sequence".into(), text(&|c| outcome.sequences[c.sequence].name.clone())),
        Column::new("tracker".into(), text(&|c| c.tracker.clone())),
        Column::new("run".into(), all.iter().map(|(c, _)| i64::from(c.run)).collect::<Vec<_>>()),
        Column::new("method".into(), text(&|c| c.method.clone())),
        Column::new("params".into(), all.iter().map(|(c, _)| some_text(&c.params)).collect::<Vec<_>>()),
        Column::new("frame".into(), all.iter().map(|(c, k)| number(c, k.frame)).collect::<Vec<_>>()),
        Column::new("reference".into(), all.iter().map(|(c, k)| number(c, k.reference)).collect::<Vec<_>>()),
        Column::new("error".into(), all.iter().map(|(_, k)| k.error).collect::<Vec<_>>()),
        Column::new("accepted".into(), all.iter().map(|(_, k)| i32::from(k.accepted)).collect::<Vec<_>>()),
    ])?)
}
