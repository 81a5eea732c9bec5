//! Builds a user suite from the sequences that `trackfail data add` finds below a folder.

use super::user::{self, USER_LOCK, check_name, is_below};
use crate::format::{FindTargets, FormatEntry};
use crate::lock::{Entry, PinnedSuite, below, pinned_suites};
use crate::{DatasetError, text};
use rayon::prelude::*;
use std::ffi::OsStr;
use std::path::Path;
use walkdir::WalkDir;

/// Most folder levels between the folder of a suite and a sequence.
const MAX_DEPTH: usize = 3;

/// Request for a new suite: its name and where its sequences are.
#[derive(Debug, Clone, Copy)]
pub struct GatherRequest<'w> {
    /// Name of the suite.
    pub name: &'w str,
    /// Title of the suite; `None` for one made of the folder and the number of sequences.
    pub title: Option<&'w str>,
    /// Format of the sequences.
    pub format: &'static FormatEntry,
    /// Folder under the data root to search, parts separated by `/`.
    pub folder: &'w str,
    /// Names of the sequences to take, in order; `None` for all, in the order of their folders.
    pub only: Option<&'w [String]>,
}

/// Writes the section of a suite with the sequences below a folder: ranges, sizes and digests as found.
/// Hashes all files.
///
/// A folder with a ground-truth file is a sequence of the folder's name. An OTB folder with several
/// ground-truth files gives one sequence for each, `<folder>-<N>`.
///
/// # Errors
/// No sequence, two of one name, an absent wanted one. Also the first sequence that cannot be read, has no
/// annotated frame, or has more ground truth than frames.
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
        let of = |name: &String| {
            let known = found.iter().find(|entry| entry.name == *name).cloned();
            let name = text::shorten(name);
            known.ok_or_else(|| fault(format!("no sequence `{name}` of those that are asked for")))
        };
        found = names.iter().map(of).collect::<Result<_, _>>()?;
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
    user::check(&suite).map_err(fault)?;
    let facts = suite.sequence.par_iter().map(|entry| facts(&suite, entry, data_root));
    // The first fault in order, whichever was read first.
    let facts: Vec<Result<Entry, DatasetError>> = facts.collect();
    suite.sequence = facts.into_iter().collect::<Result<_, _>>()?;
    Ok(user::section(&suite))
}

/// Fills an entry with the facts of its local copy. Two kinds of ground truth are refused. Without a box in
/// any frame, nothing can be started or compared. With more lines than frames, the two may be shifted against
/// each other; only a sequence that a built-in suite pins with these ranges is let through.
fn facts(suite: &PinnedSuite, entry: &Entry, data_root: &Path) -> Result<Entry, DatasetError> {
    let folder = entry.path(data_root);
    let (facts, sequence) = suite.facts(entry, &[data_root.to_path_buf()]).map_err(|e| match e {
        DatasetError::Missing(missing) => DatasetError::content(&folder, missing.how_to_get),
        error => error,
    })?;
    if sequence.truth.iter().all(Option::is_none) {
        let file = Path::new(suite.format.truth_file);
        let file = entry.target.map_or(file.into(), |n| file.with_extension(format!("{n}.txt")));
        let message = "no frame has a box, so there is nothing to start from or to compare with; give the file a box for \
                       each frame in which the target is seen, or leave the sequence out by --list";
        return Err(DatasetError::content(&folder.join(file), message));
    }
    let ((first, last), (_, covered)) = (sequence.range(), sequence.numbering.official);
    let is_it = |e: &Entry| (&e.name, e.range, e.official) == (&facts.name, facts.range, facts.official);
    if covered > last && !pinned_suites().flat_map(|suite| &suite.sequence).any(is_it) {
        let message = format!(
            "{} lines of ground truth for {} frames; there must be a line for each frame, so add the frames that are \
             missing or take out the lines that are too many",
            u64::from(covered) + 1 - u64::from(first),
            sequence.len()
        );
        return Err(DatasetError::content(&folder, message));
    }
    Ok(facts)
}

/// Finds the sequences below a folder.
fn find(find_targets: FindTargets, start: &Path, data_root: &Path) -> Result<Vec<Entry>, DatasetError> {
    let mut found: Vec<Entry> = Vec::new();
    let is_hidden = |name: &OsStr| name.as_encoded_bytes().starts_with(b".");
    let walk = WalkDir::new(start).follow_links(true).max_depth(MAX_DEPTH).sort_by_file_name().into_iter();
    let mut folders =
        walk.filter_entry(|e| e.depth() == 0 || (e.file_type().is_dir() && !is_hidden(e.file_name())));
    while let Some(next) = folders.next() {
        let next = next.map_err(|e| DatasetError::io(start, e.into()))?;
        let targets = find_targets(next.path())?;
        if !targets.is_empty() {
            folders.skip_current_dir();
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
    let inside = path.strip_prefix(data_root).unwrap_or(path);
    let parts: Option<Vec<&str>> = inside.iter().map(OsStr::to_str).collect();
    let parts = parts.unwrap_or_default();
    let Some(name) = parts.last() else {
        return Err(DatasetError::content(path, "the name is not UTF-8; rename the folder"));
    };
    Ok(Entry {
        name: target.map_or_else(|| String::from(*name), |n| format!("{name}-{n}")),
        folder: parts.join("/"),
        target,
        ..Entry::default()
    })
}

#[cfg(test)]
mod tests;
