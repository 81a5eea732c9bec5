//! `conditions.parquet`: the condition of the tracker, as methods that follow it see it.

use super::ResultsError;
use super::cells::{FrameKeys, some_text, sorted_cells};
use super::column::{Column, FRAME, METHOD, PARAMS, RUN, SEQUENCE, SUITE, TRACKER, TableFile};
use super::frame::to_parquet;
use trackfail_engine::store::StoreError;
use trackfail_engine::{Cell, Outcome};
use trackfail_methods::detector::Quality;

pub(super) const CONDITION: Column =
    Column::real("condition", "", "Condition of the tracker: 1 locked on, 0.5 locking in, 0 scanning");

/// Grid point; frames of methods with a grid are a matter of later versions.
const POINT: Column = PARAMS.recent();

/// The file; only experiments with a method that follows the condition of a tracker have it.
pub const FILE: TableFile = TableFile {
    name: "conditions.parquet",
    about: "One row for each frame of every cell of a method that follows the tracker's condition. Only experiments with \
            such a method have the file.",
    columns: &[SUITE, SEQUENCE, TRACKER, RUN, FRAME, METHOD, POINT, CONDITION],
};

/// The cells of methods that follow the tracker's condition, sorted by name.
///
/// # Errors
/// When a detection cannot be read from the store any more.
pub(super) fn followed<'a>(outcome: &'a Outcome<'_>) -> Result<Vec<(&'a Cell, Quality)>, StoreError> {
    let mut all = Vec::new();
    for cell in sorted_cells(outcome) {
        let Ok(judged) = &cell.result else { continue };
        if !judged.follows {
            continue;
        }
        if let Some(quality) = &outcome.detector_output(cell, judged)?.quality {
            all.push((cell, quality.clone()));
        }
    }
    Ok(all)
}

/// Writes the file from the cells that [`followed`] gives.
///
/// # Errors
/// When polars refuses.
pub(super) fn write(outcome: &Outcome<'_>, cells: &[(&Cell, Quality)]) -> Result<Vec<u8>, ResultsError> {
    let mut keys = FrameKeys::default();
    let (mut method, mut point, mut condition) = (Vec::new(), Vec::new(), Vec::new());
    for (cell, quality) in cells {
        let frames = quality.condition.len();
        keys.push(outcome, cell, frames);
        method.extend(std::iter::repeat_n(cell.method.as_str(), frames));
        point.extend(std::iter::repeat_n(some_text(&cell.params), frames));
        condition.extend(quality.condition.iter().map(|c| c.level()));
    }
    let mut columns = keys.columns(&outcome.suite);
    columns.extend([METHOD.of(method), POINT.of(point), CONDITION.of(condition)]);
    Ok(to_parquet(FILE.frame(columns)?)?)
}
