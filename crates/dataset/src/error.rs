//! Errors of datasets and result files; each names the file and line, and what to do.

use crate::suite::Missing;
use std::path::{Path, PathBuf};

/// Reason why a dataset or result file could not be read.
#[derive(Debug, thiserror::Error)]
pub enum DatasetError {
    /// The operating system refused.
    #[error("{}: {source}; check that the file is there and readable", path.display())]
    Io {
        /// File or folder.
        path: PathBuf,
        /// Error of the system.
        source: std::io::Error,
    },
    /// A wrong line of a text file.
    #[error("{}, line {line}: {message}", path.display())]
    Line {
        /// The text file.
        path: PathBuf,
        /// Line, counted from 1.
        line: usize,
        /// The fault, and what is expected instead.
        message: String,
    },
    /// A file or folder that is wrong as a whole.
    #[error("{}: {message}", path.display())]
    Content {
        /// The file or folder.
        path: PathBuf,
        /// The fault, and what is expected instead.
        message: String,
    },
    /// Frame files whose names can be put in more than one order.
    #[error(
        "{}: the order of the frames is in doubt: {message}; rename the files so that one number counts them, or give \
         them to `detect` one by one in their order",
        folder.display()
    )]
    FrameOrder {
        /// The folder of the files.
        folder: PathBuf,
        /// The possible orders.
        message: String,
    },
    /// A sequence that is not under the data root, or not whole.
    #[error("{}", .0.how_to_get)]
    Missing(Missing),
    /// A suite or a frame that does not exist.
    #[error("{0}")]
    Unknown(String),
}

/// Result of what reads a dataset.
pub(crate) type Result<T, E = DatasetError> = std::result::Result<T, E>;

impl DatasetError {
    /// Error for a file that the system cannot read.
    pub fn io(path: &Path, source: std::io::Error) -> Self {
        Self::Io { path: path.into(), source }
    }

    /// Error for a wrong line of a file; `line` counts from 1.
    pub fn line(path: &Path, line: usize, message: impl Into<String>) -> Self {
        Self::Line { path: path.into(), line, message: message.into() }
    }

    /// Error for a file whose content is wrong as a whole.
    pub fn content(path: &Path, message: impl Into<String>) -> Self {
        Self::Content { path: path.into(), message: message.into() }
    }
}
