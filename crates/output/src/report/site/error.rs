//! Errors of the page over all reports.

use crate::report::page::ReportError;
use crate::results::ResultsError;
use trackfail_engine::store::StoreError;

/// A site that could not be written.
#[derive(Debug, thiserror::Error)]
pub enum SiteError {
    /// A file.
    #[error(transparent)]
    Store(#[from] StoreError),
    /// A summary cannot be JSON.
    #[error(transparent)]
    Json(#[from] ResultsError),
    /// The page cannot be rendered.
    #[error(transparent)]
    Report(#[from] ReportError),
}
