//! Compares a local copy with what is pinned, and names the first file that differs.
//!
//! The pinned files digest decides about frames and ground truth. It does not cover the label
//! files beside them, which are compared with the digests of `datasets.files`. If a copy is not as pinned,
//! those digests name the file: ground truth and other text first, then the frames in order.

use super::listing::first_difference;
use super::load::Missing;
use crate::DatasetError;
use crate::lock::{Entry, PinnedSuite};
use std::path::{Path, PathBuf};

/// Result of comparing a local copy with what is pinned.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Finding {
    /// As pinned.
    Same,
    /// Readable and of the pinned number of frames, if any, but without a pinned digest.
    NoDigestPinned,
    /// Absent, in whole or in part.
    Missing(Missing),
    /// Different or unreadable, with the first difference.
    Differs(String),
}

/// One sequence of [`Suite::verify`](super::Suite::verify).
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Checked {
    /// Name of the sequence.
    pub name: String,
    /// Result for the sequence.
    pub finding: Finding,
}

impl PinnedSuite {
    /// Compares the local copy of an entry with what is pinned. If it differs or is broken, the first such
    /// file is named.
    pub(crate) fn check(&self, entry: &Entry, data_roots: &[PathBuf]) -> Finding {
        let found = self.in_first_root(entry, data_roots, |root| {
            let fact = match self.compare(entry, root) {
                Ok(Finding::Differs(fact)) => fact,
                Ok(finding) => return Ok(finding),
                Err(missing @ DatasetError::Missing(_)) => return Err(missing),
                Err(broken) => broken.to_string(),
            };
            let first = first_difference(entry, self.format(entry), root, |_| true);
            Ok(Finding::Differs(first.map(|first| format!("{first}; {fact}")).unwrap_or(fact)))
        });
        match found {
            Ok((_, finding)) => finding,
            Err(DatasetError::Missing(missing)) => Finding::Missing(missing),
            Err(broken) => Finding::Differs(broken.to_string()),
        }
    }

    fn compare(&self, entry: &Entry, root: &Path) -> Result<Finding, DatasetError> {
        let sequence = self.load(entry, root)?;
        let Some(pinned) = &entry.digest else { return Ok(Finding::NoDigestPinned) };
        let digest = sequence.digest()?;
        if digest != pinned {
            return Ok(Finding::Differs(format!(
                "frames or ground truth are other bytes: digest {digest}, pinned {pinned}"
            )));
        }
        let format = self.format(entry);
        Ok(first_difference(entry, format, root, format.is_label).map_or(Finding::Same, Finding::Differs))
    }
}
