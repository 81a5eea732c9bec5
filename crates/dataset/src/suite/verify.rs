//! Compares a local copy with what is pinned, and names the first file that differs.
//!
//! The files digest of `datasets.lock` decides about frames and ground truth. It does not cover the label
//! files beside them, which are compared with the digests of `datasets.files`. If a copy is not as pinned,
//! those digests name the file: ground truth and other text first, then the frames in order.

use super::listing;
use super::load::{LoadError, Missing};
use crate::Sequence;
use crate::lock::{Entry, PinnedSuite};
use std::path::{Path, PathBuf};

/// Result of comparing a local copy with what is pinned.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Finding {
    /// As pinned.
    Same,
    /// Readable, with the pinned number of frames if there is one; but no digest is pinned.
    NoDigestPinned,
    /// Absent, in whole or in part.
    Missing(Missing),
    /// Different or unreadable; the first difference.
    Differs(String),
}

/// One sequence of [`Suite::verify`](super::Suite::verify).
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Checked {
    /// The sequence.
    pub name: String,
    /// The finding.
    pub finding: Finding,
}

impl PinnedSuite {
    /// Compares the local copy of an entry.
    pub(super) fn check(&self, entry: &Entry, data_roots: &[PathBuf]) -> Finding {
        let (root, finding) = match self.load(entry, data_roots) {
            Ok((root, sequence)) => (Some(root), self.compare(entry, root, &sequence)),
            Err(error) => {
                let holds = |root: &&PathBuf| entry.path(root).exists();
                (data_roots.iter().find(holds).map(PathBuf::as_path), Err(error))
            }
        };
        match (finding, root) {
            (Ok(Finding::Differs(fact)), Some(root)) => self.differs(entry, root, fact),
            (Ok(finding), _) => finding,
            (Err(LoadError::Missing(missing)), _) => Finding::Missing(missing),
            (Err(LoadError::Broken(error)), Some(root)) => self.differs(entry, root, error.to_string()),
            (Err(LoadError::Broken(error)), None) => Finding::Differs(error.to_string()),
        }
    }

    /// The first file that differs, before the fact that some do.
    fn differs(&self, entry: &Entry, root: &Path, fact: String) -> Finding {
        Finding::Differs(match listing::first_difference(entry, self.format(entry), root) {
            Some(first) => format!("{first}; {fact}"),
            None => fact,
        })
    }

    fn compare(&self, entry: &Entry, root: &Path, sequence: &Sequence) -> Result<Finding, LoadError> {
        let Some(pinned) = &entry.digest else { return Ok(Finding::NoDigestPinned) };
        let digest = sequence.digest()?;
        if digest != pinned {
            return Ok(Finding::Differs(format!(
                "frames or ground truth are other bytes: digest {digest}, pinned {pinned}"
            )));
        }
        let labels = listing::first_label_difference(entry, self.format(entry), root);
        Ok(labels.map_or(Finding::Same, Finding::Differs))
    }
}
