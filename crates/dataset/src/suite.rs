//! Suites: named lists of sequences, loaded from a data root and compared with what is pinned.
//!
//! A [`Catalog`] knows all suites by name: the built-in ones (see [`crate::lock`]), the
//! rendered ones, and the user's own. No data is built in: a sequence that is not under the data root is reported
//! as missing, with the way to get it. Loading reads file lists and text only, in the order of the suite;
//! [`Suite::verify`] hashes.
//!
//! A folder may hold only the beginning of what an entry needs, for example where one suite cuts a sequence that
//! another uses whole. If only its last frames are absent, the sequence is missing, with the numbers of the frames;
//! a gap is damage, and the sequence is broken. VOT sequences, which are never cut, are broken either way. A CVML
//! folder without its annotation or without any frames is missing too, since the two are downloaded apart.

mod catalog;
mod gather;
mod listing;
mod load;
mod user;

pub use catalog::Catalog;
pub use gather::{GatherRequest, gather};
pub use listing::Finding;
pub use load::{Loaded, Missing, NO_DATA_ROOT, Origin};
pub use user::{USER_LOCK, check_name, with_sections};

use crate::lock::{Entry, PinnedSuite, below};
use crate::{DatasetError, synthetic};
use rayon::prelude::*;
use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::Arc;

/// A named list of sequences.
#[derive(Debug, Clone)]
pub struct Suite(SuiteContent);

#[derive(Debug, Clone)]
enum SuiteContent {
    OnDisk(Arc<PinnedSuite>),
    Rendered(&'static synthetic::RenderedSuite),
}

impl Suite {
    /// Pinned facts of the suite; `None` for rendered suites.
    fn pinned(&self) -> Option<&PinnedSuite> {
        match &self.0 {
            SuiteContent::OnDisk(pinned) => Some(pinned),
            SuiteContent::Rendered(_) => None,
        }
    }

    /// Name of the suite, unique in a catalog.
    pub fn name(&self) -> &str {
        match &self.0 {
            SuiteContent::OnDisk(pinned) => &pinned.name,
            SuiteContent::Rendered(rendered) => rendered.name,
        }
    }

    /// Title of the suite: one line.
    pub fn title(&self) -> &str {
        match &self.0 {
            SuiteContent::OnDisk(pinned) => &pinned.title,
            SuiteContent::Rendered(rendered) => &rendered.scenes().title,
        }
    }

    /// Source (address and paper) and licence of the data; `None` for rendered suites.
    pub fn source(&self) -> Option<(&str, &str)> {
        self.pinned().map(|p| (p.source.as_str(), p.licence.as_str()))
    }

    /// Advice on how to get the data, also where archives have no address; empty for rendered suites.
    pub fn how_to_get(&self) -> &str {
        self.pinned().map_or("", |p| &p.how_to_get)
    }

    /// Pinned sequences in order; empty for rendered suites.
    pub fn entries(&self) -> &[Entry] {
        self.pinned().map_or(&[], |p| &p.sequence)
    }

    /// Names of all sequences, in order.
    pub fn sequence_names(&self) -> Vec<String> {
        match &self.0 {
            SuiteContent::OnDisk(pinned) => pinned.sequence.iter().map(|e| e.name.clone()).collect(),
            SuiteContent::Rendered(rendered) => rendered.scenes().names().map(String::from).collect(),
        }
    }

    /// Source of the video of each sequence; for rendered suites, the name of the suite.
    pub fn sources(&self) -> Vec<String> {
        match &self.0 {
            SuiteContent::OnDisk(pinned) => pinned.sequence.iter().map(|e| e.source().to_string()).collect(),
            SuiteContent::Rendered(_) => vec![self.name().to_string(); self.sequence_names().len()],
        }
    }

    /// Loads the sequences found under `data_roots`, each from the first root that has it completely. Without
    /// a root, all sequences on disk are missing.
    ///
    /// Cheap: no image or video is opened. Digests are not compared here, see [`Suite::verify`].
    pub fn load(&self, data_roots: &[PathBuf]) -> Loaded {
        let pinned = match &self.0 {
            SuiteContent::OnDisk(pinned) => pinned,
            SuiteContent::Rendered(rendered) => {
                let sequences = rendered.sequences();
                return Loaded { wanted: sequences.len(), sequences, ..Loaded::default() };
            }
        };
        let mut loaded = Loaded { wanted: pinned.sequence.len(), ..Loaded::default() };
        for entry in &pinned.sequence {
            match pinned.in_first_root(entry, data_roots, |root| pinned.load(entry, root)) {
                Ok(sequence) => loaded.sequences.push(sequence),
                Err(DatasetError::Missing(missing)) => loaded.missing.push(missing),
                Err(error) => loaded.broken.push((entry.name.clone(), error)),
            }
        }
        loaded
    }

    /// Compares the sequences that `wanted` accepts with what is pinned, by hashing their files. Results are
    /// in the order of the suite. Rendered suites have nothing to compare.
    pub fn verify(&self, roots: &[PathBuf], wanted: impl Fn(&str) -> bool + Sync) -> Vec<(&Entry, Finding)> {
        let Some(pinned) = self.pinned() else { return Vec::new() };
        let asked = pinned.sequence.par_iter().filter(|entry| wanted(&entry.name));
        asked.map(|entry| (entry, pinned.check(entry, roots))).collect()
    }

    /// Lines of the suite file for the sequences under `data_roots`, with the facts found there.
    ///
    /// # Errors
    /// A sequence that is present but cannot be read or lacks the pinned frames.
    pub fn pin(&self, data_roots: &[PathBuf]) -> Result<Vec<String>, DatasetError> {
        let Some(pinned) = self.pinned() else { return Ok(Vec::new()) };
        let line = |entry: &Entry| match pinned.facts(entry, data_roots) {
            Ok((facts, _)) => Some(Ok(facts.line())),
            Err(DatasetError::Missing(_)) => None,
            Err(error) => Some(Err(error)),
        };
        pinned.sequence.par_iter().filter_map(line).collect()
    }

    /// Sections of `datasets.files` for the suite's folders under `data_roots`, each with its folder, sorted
    /// by folder.
    ///
    /// # Errors
    /// When a file cannot be read.
    pub fn pin_files(&self, data_roots: &[PathBuf]) -> Result<Vec<(String, String)>, DatasetError> {
        let Some(pinned) = self.pinned() else { return Ok(Vec::new()) };
        let formats: BTreeMap<&str, _> =
            pinned.sequence.iter().map(|entry| (entry.folder.as_str(), pinned.format(entry))).collect();
        let mut sections = Vec::new();
        for (folder, format) in formats {
            if let Some(root) = data_roots.iter().find(|root| below(root, folder).is_dir()) {
                sections.push((folder.to_owned(), listing::section(folder, root, format)?));
            }
        }
        Ok(sections)
    }
}

#[cfg(test)]
mod tests;
