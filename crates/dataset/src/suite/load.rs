//! Loads the sequence of an entry from a data root.

use crate::files::numbered_images;
use crate::lock::{Entry, PinnedSuite, attribute_words};
use crate::{DatasetError, Sequence, sorted};
use std::path::{Path, PathBuf};

/// Why all sequences on disk are missing without a data root, and what to do.
pub const NO_DATA_ROOT: &str = "no data root is set (give --data-root DIR or set TRACKFAIL_DATA)";

/// A sequence that is absent, in whole or in part, from the data root.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Missing {
    /// Its name.
    pub name: String,
    /// Its folder under the data root.
    pub folder: String,
    /// Advice on how to get it.
    pub how_to_get: String,
}

/// A sequence that is there but cannot be read.
#[derive(Debug)]
pub struct Broken {
    /// Its name.
    pub name: String,
    /// First error of reading it.
    pub error: DatasetError,
}

/// The video of a sequence, and the source of videos that it comes from.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Origin {
    /// Name of the video, that of the sequence unless another source has it under another name.
    pub video: String,
    /// The source: `otb`, `vot2014`.
    pub source: String,
}

/// The sequences of a suite, by whether they could be loaded.
#[derive(Debug, Default)]
pub struct Loaded {
    /// The sequences that were loaded, in the suite's order.
    pub sequences: Vec<Sequence>,
    /// The data root of each of them; empty for rendered suites.
    pub roots: Vec<PathBuf>,
    /// The origin of each of them; of a rendered suite the source is its name.
    pub origins: Vec<Origin>,
    /// The ones that are missing.
    pub missing: Vec<Missing>,
    /// The ones that cannot be read.
    pub broken: Vec<Broken>,
    /// Number of sequences the suite has.
    pub wanted: usize,
}

/// Why a sequence was not loaded.
#[derive(Debug, thiserror::Error)]
pub(super) enum LoadError {
    /// It is not under the data root, or not whole.
    #[error("{}", .0.how_to_get)]
    Missing(Missing),
    /// It is there but cannot be read.
    #[error(transparent)]
    Broken(#[from] DatasetError),
}

impl PinnedSuite {
    /// Loads an entry's sequence, which must have the pinned frames, from the first root that has all of it.
    pub(super) fn load<'r>(
        &self,
        entry: &Entry,
        data_roots: &'r [PathBuf],
    ) -> Result<(&'r Path, Sequence), LoadError> {
        self.in_first_root(entry, data_roots, |root| self.load_from(entry, root))
    }

    /// Loads an entry's sequence, which must have the pinned frames.
    pub(super) fn load_from(&self, entry: &Entry, data_root: &Path) -> Result<Sequence, LoadError> {
        let (folder, loaded) = self.load_unchecked(entry, data_root)?;
        if let Some(frames) = entry.frames
            && loaded.len() != frames
        {
            let message = format!("{} frames, pinned are {frames}; fetch it again", loaded.len());
            return Err(DatasetError::content(&folder, message).into());
        }
        // Some formats have no way to take a part of a sequence.
        if let Some((first, last)) = entry.range {
            let (from, to) = (loaded.number(0), loaded.number(loaded.len().saturating_sub(1)));
            if (from, to) != (first, last) {
                let message = format!("frames {from} to {to}, pinned are {first} to {last}");
                return Err(DatasetError::content(&folder, message).into());
            }
        }
        Ok(loaded)
    }

    /// The entry with the facts of its copy in the first root that has all of it: ranges, number of frames, size,
    /// digest; and the sequence.
    pub(super) fn facts(
        &self,
        entry: &Entry,
        data_roots: &[PathBuf],
    ) -> Result<(Entry, Sequence), LoadError> {
        let (_, (_, loaded)) =
            self.in_first_root(entry, data_roots, |root| self.load_unchecked(entry, root))?;
        let last = loaded.number(loaded.len().saturating_sub(1));
        let facts = Entry {
            range: Some((loaded.numbering.first, last)),
            official: Some(loaded.numbering.official),
            frames: Some(loaded.len()),
            size: loaded.has_frames().then(|| loaded.size()).transpose()?,
            digest: Some(loaded.digest()?.to_owned()),
            ..entry.clone()
        };
        Ok((facts, loaded))
    }

    /// Result of `look` in the first root that has all of an entry, with that root. Otherwise the first fault of a root
    /// that has a part of it.
    pub(super) fn in_first_root<'r, T>(
        &self,
        entry: &Entry,
        data_roots: &'r [PathBuf],
        look: impl Fn(&Path) -> Result<T, LoadError>,
    ) -> Result<(&'r Path, T), LoadError> {
        let mut fault = None;
        for root in data_roots.iter().filter(|root| entry.path(root).exists()) {
            match look(root) {
                Ok(found) => return Ok((root, found)),
                Err(missing @ LoadError::Missing(_)) => fault = fault.or(Some(missing)),
                Err(broken @ LoadError::Broken(_)) => return Err(broken),
            }
        }
        let hint = if data_roots.is_empty() { format!("{NO_DATA_ROOT}; ") } else { String::new() };
        Err(fault.unwrap_or_else(|| self.missing(entry, &hint)))
    }

    fn missing(&self, entry: &Entry, hint: &str) -> LoadError {
        let (name, folder) = (entry.name.clone(), entry.folder.clone());
        LoadError::Missing(Missing { name, folder, how_to_get: format!("{hint}{}", self.how_to_get) })
    }

    /// An entry's folder and sequence, whatever its frames.
    fn load_unchecked(&self, entry: &Entry, root: &Path) -> Result<(PathBuf, Sequence), LoadError> {
        let missing = |hint: &str| Err(self.missing(entry, hint));
        let folder = entry.path(root);
        let format = self.format(entry);
        if let Some(part) = (format.absent_part)(&folder)? {
            return missing(&format!("no {part} in {}; ", entry.folder));
        }
        if let Some((first, last)) = self.cut_off(entry, &folder)? {
            return missing(&format!("frames {first} to {last} are not in {}; ", entry.folder));
        }
        let mut sequence = (format.load)(&folder, &entry.options(root))?;
        let words = attribute_words(&entry.attributes, entry.target_type);
        sequence.attributes = sorted(std::mem::take(&mut sequence.attributes).into_iter().chain(words));
        Ok((folder, sequence))
    }

    /// First and last of the absent frames that an entry needs, if they are its last ones.
    fn cut_off(&self, entry: &Entry, folder: &Path) -> Result<Option<(u32, u32)>, DatasetError> {
        let Some((first, last)) = entry.range else { return Ok(None) };
        let format = self.format(entry);
        if !(format.takes_ranges)(folder)? {
            return Ok(None);
        }
        let images = numbered_images(&(format.image_folder)(folder))?;
        let absent = (first..=last).find(|n| !images.contains_key(n));
        Ok(absent.filter(|&n| images.range(n..=last).next().is_none()).map(|n| (n, last)))
    }
}
