//! Compares a local copy with what is pinned, and names the first file that differs.
//!
//! The pinned files digest decides about frames and ground truth. It does not cover the label
//! files beside them, which are compared with the digests of `datasets.files`. If a copy is not as pinned,
//! those digests name the file: ground truth and other text first, then the frames in order.
//!
//! `datasets.files` has a short digest of every file of the sequences that have been seen:
//!
//! ```text
//! otb/Girl                               a folder under the data root
//!  groundtruth_rect.txt 1f0d5a3c         a file in it, and the first 8 hexadecimal digits of its SHA-256
//!  img/0001.jpg 9f2c1c6d
//! ```
//!
//! Lines of a folder start with a space; `#` starts a comment. The digits name the first file that differs; the digest
//! in the suite's file decides whether a sequence is as pinned. A folder is listed once, whatever suites use it.

use super::load::Missing;
use crate::DatasetError;
use crate::digest::file_digest;
use crate::files::{is_image, number};
use crate::format::FormatEntry;
use crate::lock::{Entry, PinnedSuite, below, pinned_suite};
use rayon::prelude::*;
use std::path::{Path, PathBuf};

const FILES: &str = include_str!("../../../../datasets.files");

/// Number of hexadecimal digits of a SHA-256 that are listed.
const DIGITS: usize = 8;

/// Files of a folder, in order, with their digits, read from a text like [`FILES`]. Names are relative to the
/// folder, with `/` between parts.
fn listed<'t>(text: &'t str, folder: &str) -> Vec<(&'t str, &'t str)> {
    let lines = text.lines().skip_while(|line| *line != folder).skip(1);
    lines.map_while(|line| line.strip_prefix(' ')?.rsplit_once(' ')).collect()
}

/// Section of a folder, from the files under `root`.
///
/// # Errors
/// When a file cannot be read.
pub(super) fn section(folder: &str, root: &Path, format: &FormatEntry) -> Result<String, DatasetError> {
    let path = below(root, folder);
    let line = |name: String| Ok(format!(" {name} {}\n", &file_digest(&below(&path, &name))?[..DIGITS]));
    let lines: Vec<String> =
        present(&path, format).into_par_iter().map(line).collect::<Result<_, DatasetError>>()?;
    Ok(format!("{folder}\n{}", lines.concat()))
}

/// Names of the files in a sequence folder: text and videos first, then images by number.
fn present(folder: &Path, format: &FormatEntry) -> Vec<String> {
    let names = |folder: &Path| -> Vec<String> {
        let entries = std::fs::read_dir(folder).into_iter().flatten().flatten();
        let files = entries.filter(|e| e.path().is_file());
        files.filter_map(|e| e.file_name().into_string().ok()).filter(|n| !n.starts_with('.')).collect()
    };
    let mut text: Vec<String> = names(folder).into_iter().filter(|n| (format.reads)(n)).collect();
    text.sort();
    let images = format.image_folder(folder);
    let mut frames: Vec<String> = names(&images).into_iter().filter(|n| is_image(Path::new(n))).collect();
    frames.sort_by_cached_key(|name| (number(Path::new(name)), name.clone()));
    let inside = images.strip_prefix(folder).unwrap_or(Path::new(""));
    text.into_iter()
        .chain(frames.into_iter().map(|n| inside.join(n).to_string_lossy().into_owned()))
        .collect()
}

/// True if a file in the entry's folder is part of the entry's sequence.
fn belongs(entry: &Entry, format: &FormatEntry, name: &str) -> bool {
    let path = Path::new(name);
    (format.belongs)(entry, name, number(path).filter(|_| is_image(path)))
}

/// First file accepted by `wanted` that is absent, differs from the list, or is not listed; `None` if nothing
/// differs or the list is empty.
fn first_difference(
    entry: &Entry,
    format: &FormatEntry,
    root: &Path,
    listed: &[(&str, &str)],
    wanted: fn(&str) -> bool,
) -> Option<String> {
    listed.first()?;
    let folder = entry.path(root);
    let matters = |name: &str| wanted(name) && belongs(entry, format, name);
    let listed: Vec<_> = listed.iter().filter(|(name, _)| matters(name)).collect();
    let changed = listed.par_iter().find_map_first(|(name, pinned)| {
        let path = below(&folder, name);
        if !path.is_file() {
            return Some(format!("{name} is missing"));
        }
        match file_digest(&path) {
            Ok(found) if found.starts_with(pinned) => None,
            Ok(found) => Some(format!(
                "{name} is another file: its SHA-256 starts with {}, pinned is {pinned}",
                &found[..DIGITS]
            )),
            Err(error) => Some(error.to_string()),
        }
    });
    changed.or_else(|| {
        let is_listed = |name: &String| listed.iter().any(|(known, _)| known == name);
        let extra = present(&folder, format).into_iter().find(|name| matters(name) && !is_listed(name));
        extra.map(|name| format!("{name} does not belong there"))
    })
}

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

impl PinnedSuite {
    /// Compares the local copy of an entry with what is pinned. If it differs or is broken, the first such
    /// file is named.
    pub(crate) fn check(&self, entry: &Entry, data_roots: &[PathBuf]) -> Finding {
        match self.in_first_root(entry, data_roots, |root| self.compare(entry, root)) {
            Ok(finding) => finding,
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
        // The listing of a folder without a pinned digest may be incomplete.
        entry.digest.as_ref()?;
        first_difference(entry, self.format(entry), root, &listed(FILES, &entry.folder), wanted)
    }

    fn compare(&self, entry: &Entry, root: &Path) -> Result<Finding, DatasetError> {
        let sequence = self.load(entry, root)?;
        let Some(pinned) = &entry.digest else { return Ok(Finding::NoDigestPinned) };
        let digest = sequence.digest()?;
        let fact = match digest == pinned {
            true => self.first_difference(entry, root, self.format(entry).is_label),
            false => {
                Some(format!("frames or ground truth are other bytes: digest {digest}, pinned {pinned}"))
            }
        };
        let fact = fact.map(|fact| self.with_first_difference(entry, root, fact));
        Ok(fact.map_or(Finding::Same, Finding::Differs))
    }
}

#[cfg(test)]
mod tests;
