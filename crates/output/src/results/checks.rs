//! `checks.csv`: the checks of tracks by running the tracker backwards.

use super::cells::{method_label, some_text};
use super::column::{Column, FRAME, METHOD, PARAMS, RUN, SEQUENCE, SUITE, TRACKER, TableFile};
use super::frame::{TableError, to_csv};
use trackfail_engine::{Cell, Outcome};
use trackfail_methods::detector::Quality;

const REFERENCE: Column =
    Column::integer("reference", "", "Number of the earlier frame that the tracker was run back to");
const ERROR: Column =
    Column::real("error", "", "1 - Dice overlap of the forward and the backward box in that frame")
        .empty("the tracker was not run");
const ACCEPTED: Column =
    Column::small("accepted", "1 where the track counts as successful again, 0 elsewhere");

/// The file; only experiments with a method that follows the condition of a tracker have it.
pub const FILE: TableFile = TableFile {
    name: "checks.csv",
    about: "One row for each time a method checked a track by running the tracker backwards, cells sorted by their \
            names. Only experiments with a method that follows the tracker's condition have the file.",
    columns: &[
        SUITE,
        SEQUENCE,
        TRACKER,
        RUN,
        METHOD,
        PARAMS,
        Column { meaning: "Number of the frame in which the check was made", ..FRAME },
        REFERENCE,
        ERROR,
        ACCEPTED,
    ],
};

/// Writes the file from the cells of methods that follow the tracker's condition.
///
/// # Errors
/// When polars refuses.
pub(super) fn write(outcome: &Outcome<'_>, cells: &[(&Cell, Quality)]) -> Result<Vec<u8>, TableError> {
    let all: Vec<_> = cells.iter().flat_map(|(cell, q)| q.checks.iter().map(|c| (*cell, c))).collect();
    let number = |cell: &Cell, t: usize| i64::from(outcome.sequences[cell.sequence].number(t));
    let text = |f: &dyn Fn(&Cell) -> String| all.iter().map(|(cell, _)| f(cell)).collect::<Vec<_>>();
    to_csv(FILE.frame(vec![
        SUITE.of(vec![outcome.suite.as_str(); all.len()]),
        SEQUENCE.of(text(&|c| outcome.sequences[c.sequence].name.clone())),
        TRACKER.of(text(&|c| c.tracker.clone())),
        RUN.of(all.iter().map(|(c, _)| i64::from(c.run)).collect::<Vec<_>>()),
        METHOD.of(text(&|c| c.method.clone())),
        PARAMS.of(all.iter().map(|(c, _)| some_text(&c.params)).collect::<Vec<_>>()),
        FRAME.of(all.iter().map(|(c, k)| number(c, k.frame)).collect::<Vec<_>>()),
        REFERENCE.of(all.iter().map(|(c, k)| number(c, k.reference)).collect::<Vec<_>>()),
        ERROR.of(all.iter().map(|(_, k)| k.error).collect::<Vec<_>>()),
        ACCEPTED.of(all.iter().map(|(_, k)| i32::from(k.accepted)).collect::<Vec<_>>()),
    ])?)
}

/// A check of a track by running the tracker backwards.
#[derive(Debug, Clone, PartialEq)]
pub struct ReverseCheck {
    /// Number of the frame in which it was made.
    pub frame: i64,
    /// Number of the frame that was run back to.
    pub reference: i64,
    /// Error there between both ways; none where nothing was run.
    pub error: Option<f64>,
    /// Whether the track is taken to be successful again.
    pub accepted: bool,
}

/// A check with the cell it belongs to.
pub(super) struct CheckOfCell {
    pub sequence: String,
    pub tracker: String,
    pub run: i64,
    /// With its grid point.
    pub method: String,
    pub check: ReverseCheck,
}

/// Reads all checks.
///
/// # Errors
/// When the columns are not those of the file, or a number is damaged.
pub(super) fn read(bytes: Vec<u8>) -> Result<Vec<CheckOfCell>, TableError> {
    let rows = FILE.read_csv(bytes)?;
    let (sequence, tracker) = (rows.texts(&SEQUENCE)?, rows.texts(&TRACKER)?);
    let (method, params) = (rows.texts(&METHOD)?, rows.texts(&PARAMS)?);
    let (run, frame) = (rows.all_numbers(&RUN)?, rows.all_numbers(&FRAME)?);
    let (reference, error) = (rows.all_numbers(&REFERENCE)?, rows.numbers(&ERROR)?);
    let accepted: Vec<i32> = rows.all_numbers(&ACCEPTED)?;
    let check = |i: usize| CheckOfCell {
        sequence: sequence[i].to_string(),
        tracker: tracker[i].to_string(),
        run: run[i],
        method: method_label(method[i], params[i]),
        check: ReverseCheck {
            frame: frame[i],
            reference: reference[i],
            error: error[i],
            accepted: accepted[i] == 1,
        },
    };
    Ok((0..rows.len()).map(check).collect())
}
