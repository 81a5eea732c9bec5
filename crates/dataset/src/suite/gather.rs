//! Makes a suite of a user's sequences: what `trackfail data add` finds below a folder.

use super::load::LoadError;
use super::user::{self, USER_LOCK, check_name, is_below};
use crate::lock::{Entry, Format, PinnedSuite, below};
use crate::{DatasetError, text};
use rayon::prelude::*;
use std::path::{Path, PathBuf};

/// Most folders between the folder of a suite and a sequence.
const MAX_DEPTH: usize = 3;

/// Which sequences a suite is made of.
#[derive(Debug, Clone, Copy)]
pub struct GatherRequest<'w> {
    /// Name of the suite.
    pub name: &'w str,
    /// One line about it; without one, the folder and the number of sequences.
    pub title: Option<&'w str>,
    /// Format of the sequences; not CVML, whose files have several targets.
    pub format: Format,
    /// Folder under the data root, parts separated by `/`.
    pub folder: &'w str,
    /// Names of the sequences to take, in order; without them, all in the order of their folders.
    pub only: Option<&'w [String]>,
}

/// The section of a suite of the sequences below a folder, with ranges, sizes and digests of what is there.
///
/// A folder with a ground-truth file is a sequence of the folder's name; of an OTB folder with several, each
/// is one, `<folder>-<N>`. Hashes all files.
///
/// # Errors
/// No sequence, two of one name, a wanted one that is not there, and the first that cannot be read.
pub fn gather(wanted: &GatherRequest<'_>, data_root: &Path) -> Result<String, DatasetError> {
    let start = below(data_root, wanted.folder);
    let fault = |message: String| DatasetError::content(&start, message);
    check_name(wanted.name).map_err(|m| fault(format!("suite `{}`: {m}", text::shorten(wanted.name))))?;
    if !is_below(wanted.folder) || !start.is_dir() {
        return Err(fault(
            "no folder under the data root; name it as seen from there, such as lasot/test".into(),
        ));
    }
    let mut found = find(wanted.format, &start, data_root)?;
    if let Some(names) = wanted.only {
        let mut chosen = Vec::new();
        for name in names {
            let Some(entry) = found.iter().find(|e| e.name == *name) else {
                return Err(fault(format!(
                    "no sequence `{}` of those that are asked for",
                    text::shorten(name)
                )));
            };
            chosen.push(entry.clone());
        }
        found = chosen;
    }
    if found.is_empty() {
        let file = truth_pattern(wanted.format);
        return Err(fault(format!("no sequence: no folder with {file}, up to {MAX_DEPTH} folders down")));
    }
    let title = format!("{} sequences in {} of the data root", found.len(), wanted.folder);
    let mut suite = PinnedSuite {
        name: wanted.name.into(),
        title: wanted.title.map_or(title, Into::into),
        format: wanted.format,
        source: format!("{} of the data root", wanted.folder),
        licence: "not stated".into(),
        how_to_get: format!(
            "this suite is one of your own, in {USER_LOCK} of the data root; restore its folder"
        ),
        sequence: found,
    };
    user::check(&suite).map_err(&fault)?;
    let facts: Vec<Result<Entry, DatasetError>> = suite
        .sequence
        .par_iter()
        .map(|entry| {
            suite.facts(entry, Some(data_root)).map_err(|e| match e {
                LoadError::Missing(missing) => {
                    DatasetError::content(&entry.path(data_root), missing.how_to_get)
                }
                LoadError::Broken(error) => error,
            })
        })
        .collect();
    // The first in order, whichever was read first.
    let facts = facts.into_iter().collect::<Result<Vec<Entry>, _>>()?;
    suite.sequence = facts;
    Ok(user::section(&suite))
}

fn truth_pattern(format: Format) -> &'static str {
    match format {
        Format::Otb => "groundtruth_rect.txt",
        Format::Vot | Format::Got10k | Format::Lasot => "groundtruth.txt",
        Format::Cvml => "one object; write the lines of a CVML suite by hand",
    }
}

/// The sequences below a folder.
fn find(format: Format, start: &Path, data_root: &Path) -> Result<Vec<Entry>, DatasetError> {
    let mut found: Vec<Entry> = Vec::new();
    let mut walk =
        walkdir::WalkDir::new(start).follow_links(true).max_depth(MAX_DEPTH).sort_by_file_name().into_iter();
    while let Some(next) = walk.next() {
        let next = next.map_err(|e| DatasetError::io(start, e.into()))?;
        if !next.file_type().is_dir() {
            continue;
        }
        let hidden = next.depth() > 0 && next.file_name().as_encoded_bytes().starts_with(b".");
        let targets = if hidden { Vec::new() } else { targets(format, next.path())? };
        if hidden || !targets.is_empty() {
            walk.skip_current_dir();
        }
        for target in targets {
            let entry = entry(next.path(), target, data_root)?;
            if let Some(other) = found.iter().find(|e| e.name == entry.name) {
                let message =
                    format!("a second sequence `{}`, after {}; names are unique", entry.name, other.folder);
                return Err(DatasetError::content(next.path(), message));
            }
            found.push(entry);
        }
    }
    Ok(found)
}

/// The targets of a folder, one without number or several with; none where it is no sequence.
///
/// Some OTB folders have a plain file beside those of several targets, and some a numbered one that is empty.
fn targets(format: Format, folder: &Path) -> Result<Vec<Option<u32>>, DatasetError> {
    let alone = match format {
        Format::Otb => "groundtruth_rect.txt",
        Format::Vot | Format::Got10k | Format::Lasot => "groundtruth.txt",
        Format::Cvml => return Ok(Vec::new()),
    };
    let mut numbers: Vec<u32> = Vec::new();
    if format == Format::Otb {
        for file in std::fs::read_dir(folder).map_err(|e| DatasetError::io(folder, e))? {
            let path = file.map_err(|e| DatasetError::io(folder, e))?.path();
            let name = path.file_name().and_then(|n| n.to_str());
            let number = name
                .and_then(|n| n.strip_prefix("groundtruth_rect.")?.strip_suffix(".txt")?.parse::<u32>().ok());
            let content = path.metadata().is_ok_and(|m| m.is_file() && m.len() > 0);
            numbers.extend(number.filter(|_| content));
        }
    }
    numbers.sort_unstable();
    Ok(match numbers.as_slice() {
        [] if folder.join(alone).is_file() => vec![None],
        _ => numbers.into_iter().map(Some).collect(),
    })
}

fn entry(path: &Path, target: Option<u32>, data_root: &Path) -> Result<Entry, DatasetError> {
    let parts: PathBuf = path.strip_prefix(data_root).unwrap_or(path).into();
    let parts: Option<Vec<&str>> = parts.iter().map(|p| p.to_str()).collect();
    let Some((parts, name)) = parts.as_ref().and_then(|p| Some((p, p.last()?))) else {
        return Err(DatasetError::content(path, "the name is not UTF-8; rename the folder"));
    };
    Ok(Entry {
        name: target.map_or_else(|| (*name).to_owned(), |n| format!("{name}-{n}")),
        folder: parts.join("/"),
        format: None,
        target,
        range: None,
        official: None,
        frames: None,
        size: None,
        target_type: None,
        attributes: Vec::new(),
        digest: None,
        archive: None,
        truth_archive: None,
    })
}

#[cfg(test)]
mod tests;
