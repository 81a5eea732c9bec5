//! Errors of the engine: why one cell has no result, and why a whole run did not finish.

use crate::dataset::DatasetError;
use crate::limits::Interrupted;
use crate::store::StoreError;
use crate::tracker::TrackerError;

/// Why a cell has no result.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum CellError {
    /// Its data or the tracker's results are absent.
    #[error("{0}")]
    Missing(String),
    /// Its computation failed.
    #[error("{0}")]
    Failed(String),
}

impl From<TrackerError> for CellError {
    fn from(e: TrackerError) -> Self {
        match e {
            TrackerError::Missing(m) => Self::Missing(m),
            broken => Self::Failed(broken.to_string()),
        }
    }
}

/// Why a run did not finish.
#[derive(Debug, thiserror::Error)]
pub enum RunError {
    /// A suite cannot be read.
    #[error(transparent)]
    Dataset(#[from] DatasetError),
    /// The store cannot be written to.
    #[error(transparent)]
    Store(#[from] StoreError),
    /// The user interrupted it; finished results are in the store.
    #[error("interrupted; run the same command to go on from what is done")]
    Interrupted,
}

impl From<Interrupted> for RunError {
    fn from(_: Interrupted) -> Self {
        Self::Interrupted
    }
}
