//! Errors of the engine: why one cell has no result, and why a whole run did not finish.

use crate::limits::Interrupted;
use crate::store::StoreError;
use trackfail_dataset::DatasetError;
use trackfail_methods::tracker::TrackerError;

/// Why a cell has no result.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum CellError {
    /// Its data or the tracker's results are absent.
    #[error("{0}")]
    Missing(String),
    /// Its computation failed.
    #[error("{0}")]
    Failed(String),
    /// Its method needs what the suite or the tracker does not give, so that it is not run.
    #[error("{0}")]
    Unmet(&'static str),
    /// The experiment declares that the tracker has no track on the sequence, and why.
    #[error("{0}")]
    Absent(String),
}

impl CellError {
    /// Whether it stands for something that was to be run.
    pub fn is_failure(&self) -> bool {
        !matches!(self, Self::Unmet(_) | Self::Absent(_))
    }
}

impl From<&TrackerError> for CellError {
    fn from(e: &TrackerError) -> Self {
        match e {
            TrackerError::Missing(m) => Self::Missing(m.clone()),
            broken => Self::Failed(broken.to_string()),
        }
    }
}

/// Why a step of a run has no result: it failed alone, or the whole run ends.
#[derive(Debug, thiserror::Error)]
pub(crate) enum StepError {
    /// Only the results that need the step are lost.
    #[error(transparent)]
    Cell(#[from] CellError),
    /// The run ends.
    #[error(transparent)]
    Run(#[from] RunError),
}

impl StepError {
    /// A failed step.
    pub fn failed(reason: impl std::fmt::Display) -> Self {
        Self::Cell(CellError::Failed(reason.to_string()))
    }

    /// The error with `context` before the reason of a failure.
    pub fn within(self, context: &str) -> Self {
        match self {
            Self::Cell(e) => Self::failed(format!("{context}: {e}")),
            Self::Run(e) => Self::Run(e),
        }
    }

    /// The result of a step, or the reason why it failed alone.
    ///
    /// # Errors
    /// The error that ends the run.
    pub fn settled<T>(step: Result<T, Self>) -> Result<Result<T, CellError>, RunError> {
        match step {
            Ok(done) => Ok(Ok(done)),
            Err(Self::Cell(e)) => Ok(Err(e)),
            Err(Self::Run(e)) => Err(e),
        }
    }
}

impl From<Interrupted> for StepError {
    fn from(e: Interrupted) -> Self {
        Self::Run(e.into())
    }
}

impl From<StoreError> for StepError {
    fn from(e: StoreError) -> Self {
        Self::Run(e.into())
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
