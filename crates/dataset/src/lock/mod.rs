//! Suites: which sequences they have, where those come from, and what exactly they must be.
//!
//! The facts are in `datasets.lock`, a TOML file beside `Cargo.toml` that is built into the program; its head
//! comment describes it. A suite is parsed when it is first asked for. Nothing of the data itself is built in; a
//! sequence that is not under the data root is reported as missing, with the way to get it. Loading reads
//! file lists and text only, in the order of the file; [`Suite::verify`] hashes.
//!
//! What no source states is left out of the file: an entry without `range` takes all frames that are there.
//!
//! A folder may hold the beginning of what an entry needs, as where one suite cuts a sequence that another
//! uses whole. If only its last frames are absent the sequence is missing, with the numbers of the frames;
//! a gap is damage, and the sequence broken. VOT sequences, which nobody cuts, are broken either way. A CVML
//! folder without its annotation or without any frames is missing too, since the two are downloaded apart.
//!
//! Of the synthetic suites that stand in for a paper's data the file has names, lengths, sizes and attributes
//! (`format = "synthetic"`), which the renderer takes from there.
//!
//! Who has other sequences names them in a file of the same kind in the data root, see [`read_own`].
//!
//! OTB attributes are kept in the file by their published codes and given to sequences spelled out
//! (`occlusion`, `scale-variation` ...), with the type of the target beside them (`target-car`,
//! `target-person`, `target-face`, `target-other`). VOT sequences have the names of their labels, and
//! so have those of GOT-10k and LaSOT.

mod entry;
mod files;
mod load;
mod own;
mod text;
mod verify;

pub use entry::{Entry, Format, TargetType, attribute_word};
pub(crate) use entry::{below, words};
pub use own::{OWN_LOCK, Wanted, add_own, check_name, gather, own_text, read_own, with_sections};
pub use text::LOCK;
pub(crate) use text::{RenderedEntry, rendered};
pub use verify::{Checked, Finding};

use super::archive::Archive;
use super::{DatasetError, Sequence, synthetic};
use crate::plugin::unknown;
use rayon::prelude::*;
use std::path::Path;
use text::Pinned;

/// A named list of sequences.
#[derive(Clone)]
pub struct Suite {
    content: Content,
}

#[derive(Clone)]
enum Content {
    Pinned(&'static Pinned),
    Rendered(&'static synthetic::Suite),
}

/// A sequence that is not, or not whole, under the data root.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Missing {
    /// Its name.
    pub name: String,
    /// Where it would be, under the data root.
    pub folder: String,
    /// What to do.
    pub how_to_get: String,
}

/// A sequence that is there but cannot be read.
#[derive(Debug)]
pub struct Broken {
    /// Its name.
    pub name: String,
    /// What is wrong.
    pub error: DatasetError,
}

/// What of a suite is here.
#[derive(Debug, Default)]
pub struct Loaded {
    /// The sequences that are, in the suite's order.
    pub sequences: Vec<Sequence>,
    /// The ones that are not.
    pub missing: Vec<Missing>,
    /// The ones that cannot be read.
    pub broken: Vec<Broken>,
    /// Number of sequences the suite has.
    pub wanted: usize,
}

/// The download of a name.
pub fn archive(name: &str) -> Option<&'static Archive> {
    text::archives().iter().find(|a| a.name == name)
}

/// The names of all suites: those on disk, rendered ones, and one's own.
pub fn names() -> Vec<&'static str> {
    text::names().chain(synthetic::SUITES.iter().map(|r| r.name)).chain(own::names()).collect()
}

/// The suite of a name.
///
/// # Errors
/// [`DatasetError::UnknownSuite`] with the nearest name.
pub fn suite(name: &str) -> Result<Suite, DatasetError> {
    let on_disk = text::suite(name).map(Content::Pinned);
    let rendered = || synthetic::SUITES.iter().find(|r| r.name == name).map(Content::Rendered);
    let own = || own::suite(name).map(Content::Pinned);
    match on_disk.or_else(rendered).or_else(own) {
        Some(content) => Ok(Suite { content }),
        None => Err(DatasetError::UnknownSuite(unknown("suite", name, names()))),
    }
}

impl Suite {
    /// Its name.
    pub fn name(&self) -> &'static str {
        match self.content {
            Content::Pinned(p) => &p.name,
            Content::Rendered(r) => r.name,
        }
    }

    /// One line about it.
    pub fn title(&self) -> &'static str {
        match self.content {
            Content::Pinned(p) => &p.title,
            Content::Rendered(r) => r.summary,
        }
    }

    /// Address and paper of the data, and what is known of their licence; `None` for rendered suites.
    pub fn source(&self) -> Option<(&'static str, &'static str)> {
        match self.content {
            Content::Pinned(p) => Some((&p.source, &p.licence)),
            Content::Rendered(_) => None,
        }
    }

    /// The pinned sequences in order; none for rendered suites.
    pub fn entries(&self) -> &'static [Entry] {
        match self.content {
            Content::Pinned(p) => &p.sequence,
            Content::Rendered(_) => &[],
        }
    }

    /// The names of its sequences, in order.
    pub fn sequence_names(&self) -> Vec<String> {
        match self.content {
            Content::Pinned(p) => p.sequence.iter().map(|e| e.name.clone()).collect(),
            Content::Rendered(r) => r.names().map(String::from).collect(),
        }
    }

    /// Loads what is under `data_root`; without one, all sequences on disk are missing.
    ///
    /// Cheap: no image or video is opened. Digests are not compared here, see [`Suite::verify`].
    pub fn load(&self, data_root: Option<&Path>) -> Loaded {
        match self.content {
            Content::Rendered(r) => {
                let sequences = r.sequences();
                Loaded { wanted: sequences.len(), sequences, ..Loaded::default() }
            }
            Content::Pinned(p) => {
                let mut loaded = Loaded { wanted: p.sequence.len(), ..Loaded::default() };
                for entry in &p.sequence {
                    match p.load(entry, data_root) {
                        Ok(Ok(sequence)) => loaded.sequences.push(sequence),
                        Ok(Err(missing)) => loaded.missing.push(missing),
                        Err(error) => loaded.broken.push(Broken { name: entry.name.clone(), error }),
                    }
                }
                loaded
            }
        }
    }

    /// Compares every sequence under `data_root` with what is pinned, hashing its files; in the suite's
    /// order. Rendered suites have nothing to compare.
    pub fn verify(&self, data_root: Option<&Path>) -> Vec<Checked> {
        self.verify_some(data_root, |_| true)
    }

    /// [`Suite::verify`] for the sequences with the names that `wanted` accepts.
    pub fn verify_some(
        &self,
        data_root: Option<&Path>,
        wanted: impl Fn(&str) -> bool + Sync,
    ) -> Vec<Checked> {
        let Content::Pinned(p) = self.content else { return Vec::new() };
        p.sequence
            .par_iter()
            .filter(|entry| wanted(&entry.name))
            .map(|entry| Checked { name: entry.name.clone(), finding: p.check(entry, data_root) })
            .collect()
    }

    /// The lines of `datasets.lock` for the sequences under `data_root`, with the facts found there.
    ///
    /// # Errors
    /// The first sequence that is there but cannot be read.
    pub fn pin(&self, data_root: Option<&Path>) -> Result<Vec<String>, DatasetError> {
        let Content::Pinned(p) = self.content else { return Ok(Vec::new()) };
        let lines: Vec<Option<String>> = p
            .sequence
            .par_iter()
            .map(|entry| Ok(p.facts(entry, data_root)?.ok().map(|facts| facts.line())))
            .collect::<Result<_, DatasetError>>()?;
        Ok(lines.into_iter().flatten().collect())
    }

    /// The sections of `datasets.files` for the suite's folders under `data_root`, sorted, by folder.
    ///
    /// # Errors
    /// When a file cannot be read.
    pub fn pin_files(&self, data_root: &Path) -> Result<Vec<(String, String)>, DatasetError> {
        let Content::Pinned(p) = self.content else { return Ok(Vec::new()) };
        let folders: std::collections::BTreeMap<&str, Format> =
            p.sequence.iter().map(|e| (e.folder.as_str(), p.format(e))).collect();
        let here = folders.into_iter().filter(|(f, _)| entry::below(data_root, f).is_dir());
        here.map(|(f, format)| Ok((f.to_owned(), files::section(f, data_root, format)?))).collect()
    }
}

#[cfg(test)]
mod tests;
