//! Makes a suite of a user's sequences: what `trackfail data add` finds below a folder.

use super::load::LoadError;
use super::user::{self, USER_LOCK, check_name, is_below};
use crate::format::FormatEntry;
use crate::lock::{Entry, PinnedSuite, below, pinned_suite, pinned_suite_names};
use crate::{DatasetError, Sequence, text};
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
    /// Format of the sequences.
    pub format: &'static FormatEntry,
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
/// No sequence, two of one name, a wanted one that is not there, and the first that cannot be read, has no ground truth in any
/// frame, or has more of it than frames.
pub fn gather(wanted: &GatherRequest<'_>, data_root: &Path) -> Result<String, DatasetError> {
    let start = below(data_root, wanted.folder);
    let fault = |message: String| DatasetError::content(&start, message);
    check_name(wanted.name).map_err(|m| fault(format!("suite `{}`: {m}", text::shorten(wanted.name))))?;
    if !is_below(wanted.folder) || !start.is_dir() {
        return Err(fault(
            "no folder under the data root; name it as seen from there, such as lasot/test".into(),
        ));
    }
    let Some(find_targets) = wanted.format.find_targets else {
        let word = wanted.format.word;
        return Err(fault(format!(
            "write the lines of a suite of format {word} by hand, one for each object"
        )));
    };
    let mut found = find(find_targets, &start, data_root)?;
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
        let file = wanted.format.truth_file;
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
        includes: Vec::new(),
        sequence: found,
    };
    user::check(&suite).map_err(|e| fault(e.to_string()))?;
    let facts: Vec<Result<Entry, DatasetError>> = suite
        .sequence
        .par_iter()
        .map(|entry| {
            let (facts, sequence) = suite.facts(entry, &[data_root.to_path_buf()]).map_err(|e| match e {
                LoadError::Missing(missing) => {
                    DatasetError::content(&entry.path(data_root), missing.how_to_get)
                }
                LoadError::Broken(error) => error,
            })?;
            check_truth(&sequence, entry, wanted.format, data_root)?;
            check_surplus(&facts, data_root).map(|()| facts)
        })
        .collect();
    // The first in order, whichever was read first.
    let facts = facts.into_iter().collect::<Result<Vec<Entry>, _>>()?;
    suite.sequence = facts;
    Ok(user::section(&suite))
}

/// Refuses ground truth that tells of no frame where the target is, with which nothing can be started or compared.
fn check_truth(
    sequence: &Sequence,
    entry: &Entry,
    format: &FormatEntry,
    data_root: &Path,
) -> Result<(), DatasetError> {
    if sequence.truth.iter().any(Option::is_some) {
        return Ok(());
    }
    let target = entry.target.map(|n| Path::new(format.truth_file).with_extension(format!("{n}.txt")));
    let file = target.unwrap_or_else(|| format.truth_file.into());
    let message = "no frame has a box, so there is nothing to start from or to compare with; give the file a box for each \
                   frame in which the target is seen, or leave the sequence out by --list";
    Err(DatasetError::content(&entry.path(data_root).join(file), message))
}

/// Refuses more ground truth than frames, unless a built-in suite pins a sequence of the name with just these ranges: of any
/// other, lines and frames that differ in number may be shifted against each other.
fn check_surplus(facts: &Entry, data_root: &Path) -> Result<(), DatasetError> {
    let (Some((first, last)), Some((_, covered))) = (facts.range, facts.official) else { return Ok(()) };
    let mut pinned = pinned_suite_names().filter_map(pinned_suite).flat_map(|suite| &suite.sequence);
    let is_it = |e: &Entry| (&e.name, e.range, e.official) == (&facts.name, facts.range, facts.official);
    if covered <= last || pinned.any(is_it) {
        return Ok(());
    }
    let lines = u64::from(covered) + 1 - u64::from(first);
    let message = format!(
        "{lines} lines of ground truth for {} frames; there must be a line for each frame, so add the frames that are \
         missing or take out the lines that are too many",
        facts.frames.unwrap_or_default()
    );
    Err(DatasetError::content(&facts.path(data_root), message))
}

type FindTargets = fn(&Path) -> Result<Vec<Option<u32>>, DatasetError>;

/// The sequences below a folder.
fn find(find_targets: FindTargets, start: &Path, data_root: &Path) -> Result<Vec<Entry>, DatasetError> {
    let mut found: Vec<Entry> = Vec::new();
    let mut walk =
        walkdir::WalkDir::new(start).follow_links(true).max_depth(MAX_DEPTH).sort_by_file_name().into_iter();
    while let Some(next) = walk.next() {
        let next = next.map_err(|e| DatasetError::io(start, e.into()))?;
        if !next.file_type().is_dir() {
            continue;
        }
        let hidden = next.depth() > 0 && next.file_name().as_encoded_bytes().starts_with(b".");
        let targets = if hidden { Vec::new() } else { find_targets(next.path())? };
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

fn entry(path: &Path, target: Option<u32>, data_root: &Path) -> Result<Entry, DatasetError> {
    let parts: PathBuf = path.strip_prefix(data_root).unwrap_or(path).into();
    let parts: Option<Vec<&str>> = parts.iter().map(|p| p.to_str()).collect();
    let Some((parts, name)) = parts.as_ref().and_then(|p| Some((p, p.last()?))) else {
        return Err(DatasetError::content(path, "the name is not UTF-8; rename the folder"));
    };
    Ok(Entry {
        name: target.map_or_else(|| (*name).to_owned(), |n| format!("{name}-{n}")),
        folder: parts.join("/"),
        target,
        ..Entry::default()
    })
}

#[cfg(test)]
mod tests;
