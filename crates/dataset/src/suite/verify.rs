//! Compares a local copy with what is pinned, and names the first file that differs.
//!
//! The pinned files digest decides about frames and ground truth. It does not cover the label
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
    pub(crate) fn check(&self, entry: &Entry, data_roots: &[PathBuf]) -> Finding {
        match self.in_first_root(entry, data_roots, |root| self.check_in(entry, root)) {
            Ok((_, finding)) => finding,
            Err(LoadError::Missing(missing)) => Finding::Missing(missing),
            Err(LoadError::Broken(error)) => Finding::Differs(error.to_string()),
        }
    }

    /// Compares the copy in a root; one that differs or is broken is named by the first file that does.
    fn check_in(&self, entry: &Entry, root: &Path) -> Result<Finding, LoadError> {
        let found = self.load_from(entry, root).and_then(|sequence| self.compare(entry, root, &sequence));
        let fact = match found {
            Ok(Finding::Differs(fact)) => fact,
            Err(LoadError::Broken(error)) => error.to_string(),
            done => return done,
        };
        Ok(Finding::Differs(match listing::first_difference(entry, self.format(entry), root) {
            Some(first) => format!("{first}; {fact}"),
            None => fact,
        }))
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
