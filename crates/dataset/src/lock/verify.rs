//! Is a local copy what was pinned, and if not, which file is the first that differs?
//!
//! The files digest of `datasets.lock` decides about frames and ground truth. It has no say over the label
//! files beside them, which are compared with the digests of `datasets.files`. Where a copy is not as pinned,
//! those digests name the file: ground truth and other text first, then the frames in order.

use super::text::Pinned;
use super::{Entry, Missing, files};
use crate::DatasetError;
use std::path::Path;

/// How a local copy compares with what is pinned.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Finding {
    /// As pinned.
    Same,
    /// It can be read and has as many frames as pinned, if that is; no digest is.
    NoDigestPinned,
    /// Not there, or not whole.
    Missing(Missing),
    /// Something else, or unreadable; the first difference.
    Differs(String),
}

/// One sequence of [`Suite::verify`](super::Suite::verify).
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Checked {
    /// The sequence.
    pub name: String,
    /// What was found.
    pub finding: Finding,
}

impl Pinned {
    pub(super) fn check(&self, entry: &Entry, data_root: Option<&Path>) -> Finding {
        let finding = self.compare(entry, data_root).unwrap_or_else(|e| Finding::Differs(e.to_string()));
        match (finding, data_root) {
            (Finding::Differs(fact), Some(root)) => {
                Finding::Differs(match files::first_difference(entry, self.format(entry), root) {
                    Some(first) => format!("{first}; {fact}"),
                    None => fact,
                })
            }
            (finding, _) => finding,
        }
    }

    fn compare(&self, entry: &Entry, data_root: Option<&Path>) -> Result<Finding, DatasetError> {
        let sequence = match self.load(entry, data_root)? {
            Err(missing) => return Ok(Finding::Missing(missing)),
            Ok(sequence) => sequence,
        };
        let Some(pinned) = &entry.digest else { return Ok(Finding::NoDigestPinned) };
        let digest = sequence.digest()?;
        if digest != pinned {
            return Ok(Finding::Differs(format!(
                "frames or ground truth are other bytes: digest {digest}, pinned {pinned}"
            )));
        }
        let labels =
            data_root.and_then(|root| files::first_label_difference(entry, self.format(entry), root));
        Ok(labels.map_or(Finding::Same, Finding::Differs))
    }
}
