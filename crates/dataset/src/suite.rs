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
mod verify;

pub use catalog::Catalog;
pub use gather::{GatherRequest, gather};
pub use load::{Broken, Loaded, Missing, NO_DATA_ROOT, Origin};
pub use user::{USER_LOCK, UserSuiteError, check_name, with_sections};
pub use verify::{Checked, Finding};

use crate::format::FormatEntry;
use crate::lock::{Entry, PinnedSuite, below};
use crate::{DatasetError, Sequence, synthetic};
use load::LoadError;
use rayon::prelude::*;
use std::path::PathBuf;
use std::sync::Arc;

/// A named list of sequences.
#[derive(Debug, Clone)]
pub struct Suite {
    content: SuiteContent,
}

#[derive(Debug, Clone)]
enum SuiteContent {
    BuiltIn(&'static PinnedSuite),
    User(Arc<PinnedSuite>),
    Rendered(&'static synthetic::RenderedSuite),
}

impl Suite {
    /// Its pinned facts; `None` for rendered suites.
    fn pinned(&self) -> Option<&PinnedSuite> {
        match &self.content {
            SuiteContent::BuiltIn(pinned) => Some(pinned),
            SuiteContent::User(pinned) => Some(pinned),
            SuiteContent::Rendered(_) => None,
        }
    }

    /// Its name.
    pub fn name(&self) -> &str {
        match &self.content {
            SuiteContent::BuiltIn(pinned) => &pinned.name,
            SuiteContent::User(pinned) => &pinned.name,
            SuiteContent::Rendered(rendered) => rendered.name,
        }
    }

    /// One line about it.
    pub fn title(&self) -> &str {
        match &self.content {
            SuiteContent::BuiltIn(pinned) => &pinned.title,
            SuiteContent::User(pinned) => &pinned.title,
            SuiteContent::Rendered(rendered) => &rendered.scenes().title,
        }
    }

    /// Address and paper of the data, and what is known of their licence; `None` for rendered suites.
    pub fn source(&self) -> Option<(&str, &str)> {
        self.pinned().map(|p| (p.source.as_str(), p.licence.as_str()))
    }

    /// The pinned sequences in order; none for rendered suites.
    pub fn entries(&self) -> &[Entry] {
        self.pinned().map_or(&[], |p| &p.sequence)
    }

    /// The names of its sequences, in order.
    pub fn sequence_names(&self) -> Vec<String> {
        match &self.content {
            SuiteContent::Rendered(rendered) => rendered.scenes().names().map(String::from).collect(),
            _ => self.entries().iter().map(|e| e.name.clone()).collect(),
        }
    }

    /// The source of videos of each of its sequences; of a rendered suite its name.
    pub fn sources(&self) -> Vec<String> {
        match &self.content {
            SuiteContent::Rendered(rendered) => {
                rendered.scenes().names().map(|_| self.name().to_string()).collect()
            }
            _ => self.entries().iter().map(|e| e.source().to_string()).collect(),
        }
    }

    /// Loads the sequences that are under one of `data_roots`, each from the first root that has all of it; without
    /// a root all sequences on disk are missing.
    ///
    /// Cheap: no image or video is opened. Digests are not compared here, see [`Suite::verify`].
    pub fn load(&self, data_roots: &[PathBuf]) -> Loaded {
        if let SuiteContent::Rendered(rendered) = self.content {
            let sequences = rendered.sequences();
            let origin = |s: &Sequence| Origin { video: s.name.clone(), source: self.name().to_string() };
            let origins = sequences.iter().map(origin).collect();
            return Loaded { wanted: sequences.len(), sequences, origins, ..Loaded::default() };
        }
        let Some(pinned) = self.pinned() else { return Loaded::default() };
        let mut loaded = Loaded { wanted: pinned.sequence.len(), ..Loaded::default() };
        for entry in &pinned.sequence {
            match pinned.load(entry, data_roots) {
                Ok((root, sequence)) => {
                    loaded.sequences.push(sequence);
                    loaded.roots.push(root.to_path_buf());
                    let (video, source) = (entry.video().to_string(), entry.source().to_string());
                    loaded.origins.push(Origin { video, source });
                }
                Err(LoadError::Missing(missing)) => loaded.missing.push(missing),
                Err(LoadError::Broken(error)) => {
                    loaded.broken.push(Broken { name: entry.name.clone(), error });
                }
            }
        }
        loaded
    }

    /// Compares every sequence under `data_roots` with what is pinned, hashing its files; in the suite's
    /// order. Rendered suites have nothing to compare.
    pub fn verify(&self, data_roots: &[PathBuf]) -> Vec<Checked> {
        self.verify_some(data_roots, |_| true)
    }

    /// [`Suite::verify`] for the sequences with the names that `wanted` accepts.
    pub fn verify_some(&self, data_roots: &[PathBuf], wanted: impl Fn(&str) -> bool + Sync) -> Vec<Checked> {
        let Some(pinned) = self.pinned() else { return Vec::new() };
        pinned
            .sequence
            .par_iter()
            .filter(|entry| wanted(&entry.name))
            .map(|entry| Checked { name: entry.name.clone(), finding: pinned.check(entry, data_roots) })
            .collect()
    }

    /// The lines of the suite's file for the sequences under `data_roots`, with the facts found there.
    ///
    /// # Errors
    /// The first sequence that is there but cannot be read.
    pub fn pin(&self, data_roots: &[PathBuf]) -> Result<Vec<String>, DatasetError> {
        let Some(pinned) = self.pinned() else { return Ok(Vec::new()) };
        let lines: Vec<Option<String>> = pinned
            .sequence
            .par_iter()
            .map(|entry| match pinned.facts(entry, data_roots) {
                Ok((facts, _)) => Ok(Some(facts.line())),
                Err(LoadError::Missing(_)) => Ok(None),
                Err(LoadError::Broken(error)) => Err(error),
            })
            .collect::<Result<_, DatasetError>>()?;
        Ok(lines.into_iter().flatten().collect())
    }

    /// The sections of `datasets.files` for the suite's folders under `data_roots`, sorted, by folder.
    ///
    /// # Errors
    /// When a file cannot be read.
    pub fn pin_files(&self, data_roots: &[PathBuf]) -> Result<Vec<(String, String)>, DatasetError> {
        let Some(pinned) = self.pinned() else { return Ok(Vec::new()) };
        let folders: std::collections::BTreeMap<&str, &FormatEntry> =
            pinned.sequence.iter().map(|e| (e.folder.as_str(), pinned.format(e))).collect();
        let root = |folder: &str| data_roots.iter().find(|root| below(root, folder).is_dir());
        let here = folders.into_iter().filter_map(|(f, format)| Some((f, format, root(f)?)));
        here.map(|(f, format, root)| Ok((f.to_owned(), listing::section(f, root, format)?))).collect()
    }
}

#[cfg(test)]
mod tests;
