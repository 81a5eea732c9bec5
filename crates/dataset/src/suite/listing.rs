//! `datasets.files`: a short digest of every file of the sequences that have been seen.
//!
//! ```text
//! otb/Girl                               a folder under the data root
//!  groundtruth_rect.txt 1f0d5a3c         a file in it, and the first 8 hexadecimal digits of its SHA-256
//!  img/0001.jpg 9f2c1c6d
//! ```
//!
//! Lines of a folder start with a space; `#` starts a comment. The digits name the first file that differs; the digest
//! in the suite's file decides whether a sequence is as pinned. A folder is listed once, whatever suites use it.

use crate::DatasetError;
use crate::digest::file_digest;
use crate::files::{image_folder, is_image, number};
use crate::format::FormatEntry;
use crate::lock::{Entry, below};
use rayon::prelude::*;
use std::path::Path;

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
    let images = image_folder(folder, format.image_folders);
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
/// differs or the folder is not listed.
pub(super) fn first_difference(
    entry: &Entry,
    format: &FormatEntry,
    root: &Path,
    wanted: fn(&str) -> bool,
) -> Option<String> {
    // The listing of a folder without a pinned digest may be incomplete.
    entry.digest.as_ref()?;
    compare(entry, format, root, &listed(FILES, &entry.folder), wanted)
}

fn compare(
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

#[cfg(test)]
mod tests;
