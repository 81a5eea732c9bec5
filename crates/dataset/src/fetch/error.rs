//! Why something was not fetched, and what to do about it.

use std::path::{Path, PathBuf};

/// Why a download or an archive came to nothing.
#[derive(Debug, thiserror::Error)]
pub enum FetchError {
    /// An address that is never asked.
    #[error("{0}; only complete http:// and https:// addresses are fetched")]
    Address(String),
    /// No connection, or one that breaks again and again.
    #[error("{0}")]
    Network(String),
    /// Data that are not at their address, not what is pinned, damaged or hostile.
    #[error("{0}")]
    Data(String),
    /// An I/O error.
    #[error("{}: {source}; make room and check that the folder can be written to", path.display())]
    Disk {
        /// File or folder.
        path: PathBuf,
        /// Error of the system.
        source: std::io::Error,
    },
    /// Another process fetches into the data root; its lock file.
    #[error("{}: another fetch is using this data root; wait until it has ended", .0.display())]
    Busy(PathBuf),
}

impl FetchError {
    pub(super) fn disk(path: &Path, source: std::io::Error) -> Self {
        Self::Disk { path: path.into(), source }
    }

    /// Whether the data at the address are absent or not as pinned; other errors come from the disk, the network or
    /// the arguments.
    pub fn is_data(&self) -> bool {
        matches!(self, Self::Data(_))
    }
}
