//! The content of a report once it is written.

use super::claims::Finding;
use crate::results::CellScore;
use crate::table::layout::TableLayout;

/// Content of a written report.
pub struct WrittenReport {
    /// The claims, tested on our numbers.
    pub findings: Vec<Finding>,
    /// The experiment's own tables.
    pub tables: Vec<TableLayout>,
    /// Counts of every cell.
    pub scores: Vec<CellScore>,
    /// The answer of the page in a sentence; may be empty.
    pub verdict: String,
}
