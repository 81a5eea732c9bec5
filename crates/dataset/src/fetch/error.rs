//! Why something was not fetched, and what to do about it.

use super::member::MemberFault;
use std::path::{Path, PathBuf};

/// Why a download or an archive came to nothing.
#[derive(Debug, thiserror::Error)]
pub enum FetchError {
    /// An address that is never asked.
    #[error("{url}: {reason}; only complete http:// and https:// addresses are fetched")]
    Address {
        /// As it was given.
        url: String,
        /// Part of the address that is not allowed.
        reason: String,
    },
    /// A name or folder of `datasets.lock` that cannot be one on disk.
    #[error("archive {archive}: `{name}` in datasets.lock cannot be a path below the data root: {reason}")]
    Entry {
        /// The archive.
        archive: String,
        /// The name.
        name: String,
        /// Rule that the name breaks.
        reason: MemberFault,
    },
    /// An answer that trying again does not change.
    #[error("{url}: the server answers {status}{}", advice(*status))]
    Status {
        /// The address asked last.
        url: String,
        /// HTTP status.
        status: u16,
    },
    /// A redirect that is not followed.
    #[error("{url}: sent on to {to:?}, {reason}; get the file by hand, or from a --mirror")]
    Redirect {
        /// The address asked last.
        url: String,
        /// Where it points.
        to: String,
        /// Why not.
        reason: &'static str,
    },
    /// No connection, or one that breaks again and again.
    #[error(
        "{url}: {reason} (attempt {attempts}, then given up). Is this machine online, and is HTTPS_PROXY set if \
         it needs a proxy? {kept} bytes have arrived and are kept: the same command goes on from there"
    )]
    Network {
        /// The address asked first.
        url: String,
        /// Last failure.
        reason: String,
        /// Number of attempts.
        attempts: u32,
        /// Bytes in the part file.
        kept: u64,
    },
    /// A file of another size than expected.
    #[error(
        "{url}: {got} bytes, expected are {expected} ({source_of}); the file at this address is another one \
         than was pinned, or was cut: try again later or use a --mirror"
    )]
    Size {
        /// The address.
        url: String,
        /// Bytes expected.
        expected: u64,
        /// Bytes found.
        got: u64,
        /// Source of the expected size.
        source_of: &'static str,
    },
    /// More bytes than any archive should have.
    #[error("{url}: more than {limit} bytes, the most that is fetched without a size in datasets.lock")]
    Limit {
        /// The address.
        url: String,
        /// The limit in bytes.
        limit: u64,
    },
    /// Another file than the pinned one.
    #[error(
        "{url}: SHA-256 is {got}, pinned is {expected}; the download is deleted: fetch again, and if it stays \
         so, the file at this address has been changed (use a --mirror that has the pinned one)"
    )]
    Digest {
        /// The address.
        url: String,
        /// Digest in datasets.lock.
        expected: String,
        /// Digest found.
        got: String,
    },
    /// An archive that is damaged or hostile.
    #[error("archive {archive}, member {}: {reason}; nothing of it is kept", shown(member))]
    Member {
        /// The archive.
        archive: String,
        /// Name of the member, as far as it is text.
        member: String,
        /// Rule that the member breaks.
        reason: MemberFault,
    },
    /// A file that is no archive of its kind, or a cut one.
    #[error("archive {archive}: {reason}; nothing of it is kept, fetch it again")]
    NotAnArchive {
        /// The archive.
        archive: String,
        /// Error of reading it.
        reason: String,
    },
    /// A whole archive without what it was fetched for.
    #[error(
        "archive {archive} has no folder {folder}, but {}; `into` or `below` of its entry in datasets.lock \
         are wrong", if found.is_empty() { "nothing at all".into() } else { found.join(", ") }
    )]
    NoFolder {
        /// The archive.
        archive: String,
        /// The folder under the data root that was to be filled.
        folder: String,
        /// Some of the archive's own top folders.
        found: Vec<String>,
    },
    /// An I/O error.
    #[error("{}: {source}; make room and check that the folder can be written to", path.display())]
    Disk {
        /// File or folder.
        path: PathBuf,
        /// Error of the system.
        source: std::io::Error,
    },
    /// Another process fetches into the data root.
    #[error("{}: another fetch is using this data root; wait until it has ended", path.display())]
    Busy {
        /// The lock file.
        path: PathBuf,
    },
}

impl FetchError {
    pub(super) fn disk(path: &Path, source: std::io::Error) -> Self {
        Self::Disk { path: path.into(), source }
    }

    /// Whether the data at the address are absent or not as pinned; other errors come from the disk, the network or
    /// the arguments.
    pub fn is_data(&self) -> bool {
        !matches!(self, Self::Address { .. } | Self::Network { .. } | Self::Disk { .. } | Self::Busy { .. })
    }
}

fn advice(status: u16) -> &'static str {
    match status {
        401 | 403 | 407 => " (not allowed): get the file by hand, or from a --mirror",
        404 | 410 => " (not there): the file has moved; get it by hand, or from a --mirror",
        429 => " (too many requests) and asks to wait long: try again in an hour",
        _ => ": try again later, or use a --mirror",
    }
}

/// A name from outside as it may be printed: no control characters, not too long.
pub(super) fn shown(name: &str) -> String {
    let mut text: String = name.chars().take(120).flat_map(char::escape_debug).collect();
    if name.chars().nth(120).is_some() {
        text.push_str("...");
    }
    format!("`{text}`")
}
