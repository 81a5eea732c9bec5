//! Loads the sequence of an entry from a data root.

use crate::lock::{Entry, PinnedSuite};
use crate::{DatasetError, Result, Sequence, sorted};
use std::path::{Path, PathBuf};

/// Reason why all sequences on disk are missing without a data root, with what to do.
pub const NO_DATA_ROOT: &str = "no data root is set (give --data-root DIR or set TRACKFAIL_DATA)";

/// A sequence that is absent, in whole or in part, from the data root.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Missing {
    /// Name of the sequence in the suite.
    pub name: String,
    /// Folder of the sequence under the data root.
    pub folder: String,
    /// Advice on how to get the sequence.
    pub how_to_get: String,
}

/// The video that a sequence is taken from, and the source of that video. Empty where the sequence is of no suite.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Origin {
    /// Name of the video, see [`Entry::video`].
    pub video: String,
    /// Source of the video: `otb`, `vot2014`; the suite if it is rendered.
    pub source: String,
    /// Data root of the sequence; empty if it is rendered.
    pub root: PathBuf,
}

/// Sequences of a suite, sorted by the outcome of loading.
#[derive(Debug, Default)]
pub struct Loaded {
    /// The sequences that were loaded, in the suite's order.
    pub sequences: Vec<Sequence>,
    /// Sequences of the suite that no data root has completely.
    pub missing: Vec<Missing>,
    /// Names of sequences that are present but cannot be read, each with the first error found.
    pub broken: Vec<(String, DatasetError)>,
    /// Number of all sequences in the suite.
    pub wanted: usize,
}

impl Loaded {
    /// Keeps the sequences whose names pass; the others count as missing, and `reason` stands in place of their folder.
    pub fn keep_only(&mut self, passes: impl Fn(&str) -> bool, reason: &str) {
        for Sequence { name, .. } in self.sequences.extract_if(.., |sequence| !passes(&sequence.name)) {
            self.missing.push(Missing { name, folder: reason.to_string(), how_to_get: String::new() });
        }
    }
}

impl PinnedSuite {
    /// Result of `look` for the first root that has the entry completely. If none does, the first fault of a
    /// root that has a part of it.
    pub(super) fn in_first_root<T>(
        &self,
        entry: &Entry,
        data_roots: &[PathBuf],
        look: impl Fn(&Path) -> Result<T>,
    ) -> Result<T> {
        let mut fault = None;
        for root in data_roots.iter().filter(|root| entry.path(root).exists()) {
            match look(root) {
                Ok(found) => return Ok(found),
                Err(error) => fault = fault.or(Some(error)),
            }
        }
        let hint = if data_roots.is_empty() { format!("{NO_DATA_ROOT}; ") } else { String::new() };
        Err(fault.unwrap_or_else(|| self.missing(entry, &hint)))
    }

    fn missing(&self, entry: &Entry, hint: &str) -> DatasetError {
        let (name, folder) = (entry.name.clone(), entry.folder.clone());
        DatasetError::Missing(Missing { name, folder, how_to_get: format!("{hint}{}", self.how_to_get) })
    }

    /// Loads the sequence of an entry from a root. It must have the pinned frames.
    pub(super) fn load(&self, entry: &Entry, root: &Path) -> Result<Sequence> {
        let (folder, format) = (entry.path(root), self.format(entry));
        if let Some(what) = (format.absent)(format, &folder, entry)? {
            return Err(self.missing(entry, &format!("{what} in {}; ", entry.folder)));
        }
        let mut sequence = (format.load)(root, entry)?;
        let (video, source) = (entry.video().to_string(), entry.source().to_string());
        sequence.origin = Origin { video, source, root: root.to_path_buf() };
        // Trackers may choose by the type of the target; a file that no digest covers does not change a pinned one.
        let is_taken = |word: &String| entry.target_type.is_none() || !word.starts_with("target-");
        let own = std::mem::take(&mut sequence.attributes).into_iter().filter(is_taken);
        sequence.attributes = sorted(own.chain(entry.attribute_words()));
        let frames = sequence.len();
        if let Some(pinned) = entry.frames.filter(|pinned| *pinned != frames) {
            let message = format!("{frames} frames, pinned are {pinned}; fetch it again");
            return Err(DatasetError::content(&folder, message));
        }
        // Some formats have no way to take a part of a sequence.
        let (from, to) = sequence.range();
        if let Some((first, last)) = entry.range.filter(|pinned| *pinned != (from, to)) {
            let message = format!("frames {from} to {to}, pinned are {first} to {last}");
            return Err(DatasetError::content(&folder, message));
        }
        Ok(sequence)
    }

    /// The entry with the facts of its copy (ranges, number of frames, size, digest), and the sequence. The
    /// copy is that in the first root that has it completely.
    pub(super) fn facts(&self, entry: &Entry, data_roots: &[PathBuf]) -> Result<(Entry, Sequence)> {
        let sequence = self.in_first_root(entry, data_roots, |root| self.load(entry, root))?;
        let facts = Entry {
            range: Some(sequence.range()),
            official: Some(sequence.numbering.official),
            frames: Some(sequence.len()),
            size: sequence.has_frames().then(|| sequence.size()).transpose()?,
            digest: Some(sequence.digest()?.to_owned()),
            ..entry.clone()
        };
        Ok((facts, sequence))
    }
}
