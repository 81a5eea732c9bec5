//! Reasons why a fetch failed, each with what to do.

use std::path::{Path, PathBuf};

/// Reason why a download or an archive failed.
#[derive(Debug, thiserror::Error)]
pub enum FetchError {
    /// An address that is malformed or neither http nor https.
    #[error("{0}; only complete http:// and https:// addresses are fetched")]
    Address(String),
    /// No connection, or one that breaks again and again.
    #[error("{0}")]
    Network(String),
    /// Data that are absent at the address, not as pinned, damaged or hostile.
    #[error("{0}")]
    Data(String),
    /// An I/O error.
    #[error("{}: {source}; {}", path.display(), advice(source))]
    Disk {
        /// File or folder.
        path: PathBuf,
        /// Error of the system.
        source: std::io::Error,
    },
    /// Another process fetches into the data root; the path is its lock file.
    #[error("{}: another fetch is using this data root; wait until it has ended", .0.display())]
    Busy(PathBuf),
}

fn advice(error: &std::io::Error) -> &'static str {
    match error.kind() {
        std::io::ErrorKind::CrossesDevices => {
            "its folder is a link to another file system; give that one as the data root"
        }
        _ => "make room and check that the folder can be written to",
    }
}

impl FetchError {
    pub(super) fn disk(path: &Path, source: std::io::Error) -> Self {
        Self::Disk { path: path.into(), source }
    }

    /// True if the data at the address are absent or not as pinned; false if the disk, the network or the
    /// arguments are at fault.
    pub fn is_data(&self) -> bool {
        matches!(self, Self::Data(_))
    }
}
