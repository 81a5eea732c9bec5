//! Errors of the engine: why one cell has no result, and why a whole run did not finish.

use crate::store::StoreError;
use trackfail_methods::tracker::TrackerError;

/// Reason why a cell has no result.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum CellError {
    /// The data or the results of the tracker are absent.
    #[error("{0}")]
    Missing(String),
    /// The computation failed.
    #[error("{0}")]
    Failed(String),
    /// The suite or the tracker lacks an input that the method needs, so the cell is not run.
    #[error("{0}")]
    Unmet(&'static str),
    /// The experiment declares that the tracker has no track on the sequence; the text is the declared
    /// reason.
    #[error("{0}")]
    Absent(String),
}

impl CellError {
    /// Placeholder for a result that no part of the experiment needs.
    pub(crate) fn not_asked_for() -> Self {
        Self::Missing("not asked for".to_string())
    }

    /// True if the result was to be computed and is lacking.
    pub fn is_failure(&self) -> bool {
        !matches!(self, Self::Unmet(_) | Self::Absent(_))
    }
}

impl From<TrackerError> for CellError {
    fn from(e: TrackerError) -> Self {
        match e {
            TrackerError::Missing(m) => Self::Missing(m),
            broken => Self::Failed(broken.to_string()),
        }
    }
}

/// Reason why a step of a run has no result: either only the results that need the step are lost, or the
/// whole run ends.
#[derive(Debug, Clone, thiserror::Error)]
pub enum StepError {
    /// Only the results that need the step are lost.
    #[error(transparent)]
    Cell(#[from] CellError),
    /// As [`Cell`](Self::Cell), with a reason that does not name the sequence yet.
    #[error("{0}")]
    Here(String),
    /// The whole run ends.
    #[error(transparent)]
    Run(#[from] RunError),
}

impl StepError {
    /// Error of a step that failed for this reason.
    pub(crate) fn failed(reason: impl std::fmt::Display) -> Self {
        Self::Cell(CellError::Failed(reason.to_string()))
    }

    /// The error with `context` put before the reason of a failure.
    pub(crate) fn within(self, context: &str) -> Self {
        match self {
            Self::Run(e) => Self::Run(e),
            lost => Self::failed(format!("{context}: {lost}")),
        }
    }

    /// The error of a result on the sequence of this name, which is put into the reason.
    pub(crate) fn on(self, sequence: &str) -> CellError {
        match self {
            Self::Cell(e) => e,
            other => CellError::Failed(format!("{sequence}: {other}")),
        }
    }

    /// Splits off the errors that end the run; other errors are returned as the inner result.
    ///
    /// # Errors
    /// The error that ends the run.
    pub(crate) fn settled<T>(step: Result<T, Self>) -> Result<Result<T, CellError>, RunError> {
        match step {
            Ok(done) => Ok(Ok(done)),
            Err(Self::Cell(e)) => Ok(Err(e)),
            Err(Self::Here(reason)) => Ok(Err(CellError::Failed(reason))),
            Err(Self::Run(e)) => Err(e),
        }
    }
}

impl From<TrackerError> for StepError {
    fn from(e: TrackerError) -> Self {
        Self::Cell(e.into())
    }
}

impl From<StoreError> for StepError {
    fn from(e: StoreError) -> Self {
        Self::Run(e.into())
    }
}

/// Reason why a run did not finish.
#[derive(Debug, Clone, thiserror::Error)]
pub enum RunError {
    /// The store cannot be written to.
    #[error(transparent)]
    Store(#[from] StoreError),
    /// The user interrupted the run; finished results are in the store.
    #[error("interrupted; run the same command to go on from what is done")]
    Interrupted,
}
