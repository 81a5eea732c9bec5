//! Faults of programs.

use crate::tracker::trax::TraxError;
use std::path::PathBuf;
use trackfail_core::image::ImageError;

/// Why a program gave no answer.
#[derive(Debug, thiserror::Error)]
pub enum ProgramFault {
    /// The program has no command.
    #[error("no command")]
    NoCommand,
    /// The system cannot start it.
    #[error("cannot start `{program}`: {source}")]
    Start {
        /// The first word of the command.
        program: String,
        /// The system's reason.
        source: std::io::Error,
    },
    /// The system gives no temporary folder.
    #[error("no temporary folder for its images: {0}")]
    Folder(#[source] std::io::Error),
    /// A frame cannot be encoded as an image.
    #[error("{}: {source}", path.display())]
    Encode {
        /// The image file.
        path: PathBuf,
        /// The encoder's reason.
        source: ImageError,
    },
    /// An image cannot be written.
    #[error("{}: {source}", path.display())]
    Write {
        /// The image file.
        path: PathBuf,
        /// The system's reason.
        source: std::io::Error,
    },
    /// It sent bytes that are not a message.
    #[error(transparent)]
    Message(#[from] TraxError),
    /// It ended, was silent or sent something else than the expected answer; with the last lines of its stderr.
    #[error("{0}")]
    Conduct(String),
}
