//! Compares a local copy with what is pinned, and names the first file that differs.
//!
//! The pinned files digest decides about frames and ground truth. It does not cover the label
//! files beside them, which are compared with the digests of `datasets.files`. If a copy is not as pinned,
//! those digests name the file: ground truth and other text first, then the frames in order.

use super::listing::first_difference;
use super::load::Missing;
use crate::DatasetError;
use crate::lock::{Entry, PinnedSuite, pinned_suite};
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
                finding => return finding,
            };
            Ok(Finding::Differs(self.with_first_difference(entry, root, fact)))
        });
        match found {
            Ok((_, finding)) => finding,
            Err(DatasetError::Missing(missing)) => Finding::Missing(missing),
            Err(broken) => {
                // It is the fault of the first root that has a part of the sequence.
                let fact = broken.to_string();
                Finding::Differs(match data_roots.iter().find(|root| entry.path(root).exists()) {
                    Some(root) => self.with_first_difference(entry, root, fact),
                    None => fact,
                })
            }
        }
    }

    fn with_first_difference(&self, entry: &Entry, root: &Path, fact: String) -> String {
        self.first_difference(entry, root, |_| true).map(|first| format!("{first}; {fact}")).unwrap_or(fact)
    }

    /// First file that differs from the list of the built-in suites. A suite of the user's is pinned by its own
    /// digests alone.
    fn first_difference(&self, entry: &Entry, root: &Path, wanted: fn(&str) -> bool) -> Option<String> {
        pinned_suite(&self.name)?;
        first_difference(entry, self.format(entry), root, wanted)
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
        let labels = self.first_difference(entry, root, self.format(entry).is_label);
        Ok(labels.map_or(Finding::Same, Finding::Differs))
    }
}
