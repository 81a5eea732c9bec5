//! `datasets.files`: a short digest of every file of the sequences that have been seen.
//!
//! ```text
//! otb/Girl                               a folder under the data root
//!  groundtruth_rect.txt 1f0d5a3c         a file in it, and the first 8 hexadecimal digits of its SHA-256
//!  img/%04d.jpg 1-500                    numbered files: how number 7 is written, first and last number
//!   9f2c1c6d5e0a...                      their digits one after the other, as many a line as fit
//! ```
//!
//! Lines of a folder start with one space, lines of digits with two; `#` starts a comment. The digits
//! name the first file that differs; the digest in the suite's file decides whether a sequence is as pinned. A folder is listed once, whatever suites use it.

use crate::DatasetError;
use crate::digest::file_digest;
use crate::files::{is_image, number};
use crate::format::FormatEntry;
use crate::lock::{Entry, below};
use rayon::prelude::*;
use std::collections::BTreeMap;
use std::path::Path;
use std::sync::OnceLock;

const FILES: &str = include_str!("../../../../datasets.files");

/// Listed digits of a file's SHA-256.
const DIGITS: usize = 8;

/// Digests a line.
const DIGESTS_PER_LINE: usize = 14;

/// The sections of [`FILES`] by folder.
fn sections() -> &'static BTreeMap<&'static str, &'static str> {
    static SECTIONS: OnceLock<BTreeMap<&'static str, &'static str>> = OnceLock::new();
    SECTIONS.get_or_init(|| {
        let mut found = BTreeMap::new();
        let mut start: Option<(&str, usize)> = None;
        let mut at = 0;
        for line in FILES.split_inclusive('\n') {
            if !line.starts_with([' ', '#']) {
                start.take().map(|(folder, from)| found.insert(folder, &FILES[from..at]));
                start = Some((line.trim_end(), at + line.len()));
            }
            at += line.len();
        }
        start.map(|(folder, from)| found.insert(folder, &FILES[from..at]));
        found
    })
}

/// The files of a section in order, with their digits; names are relative to the folder, parted by `/`.
fn read(section: &str) -> Vec<(String, String)> {
    let mut files = Vec::new();
    let mut run: Option<(&str, u32)> = None;
    for line in section.lines() {
        if let Some(digits) = line.strip_prefix("  ") {
            let Some((pattern, next)) = &mut run else { continue };
            for k in (0..digits.len()).step_by(DIGITS) {
                let Some(digest) = digits.get(k..k + DIGITS) else { break };
                files.push((numbered(pattern, *next), digest.to_owned()));
                *next += 1;
            }
        } else if let Some((name, value)) = line.trim_start().rsplit_once(' ') {
            run = None;
            match value.split_once('-') {
                Some((first, _)) => run = first.parse().ok().map(|first| (name, first)),
                None => files.push((name.to_owned(), value.to_owned())),
            }
        }
    }
    files
}

/// `img/%04d.jpg` and 7: `img/0007.jpg`.
fn numbered(pattern: &str, number: u32) -> String {
    let parts = pattern.split_once("%0").and_then(|(head, rest)| {
        let (width, tail) = rest.split_once('d')?;
        Some((head, width.parse::<usize>().ok()?, tail))
    });
    match parts {
        Some((head, width, tail)) => format!("{head}{number:0width$}{tail}"),
        None => pattern.to_owned(),
    }
}

/// The pattern and number of a numbered image: `img/0007.jpg` is 7 of `img/%04d.jpg`.
fn pattern(name: &str) -> Option<(String, u32)> {
    let (stem, extension) = name.rsplit_once('.')?;
    let digits = stem.bytes().rev().take_while(u8::is_ascii_digit).count();
    let (head, number) = stem.split_at(stem.len() - digits);
    (digits > 0).then_some(())?;
    Some((format!("{head}%0{digits}d.{extension}"), number.parse().ok()?))
}

/// The section of a folder as it is under `root`.
///
/// # Errors
/// When a file cannot be read.
pub(super) fn section(folder: &str, root: &Path, format: &FormatEntry) -> Result<String, DatasetError> {
    let path = below(root, folder);
    let digests: Vec<(String, String)> = present(&path, format)
        .into_par_iter()
        .map(|name| Ok((name.clone(), file_digest(&below(&path, &name))?[..DIGITS].to_owned())))
        .collect::<Result<_, DatasetError>>()?;
    Ok(format!("{folder}\n{}", write(&digests)))
}

/// The lines of a section; numbered files of one pattern and without gaps become one run.
fn write(files: &[(String, String)]) -> String {
    let mut text = String::new();
    let mut rest = files;
    while let Some((name, digest)) = rest.first() {
        let length = match pattern(name) {
            Some((pattern, first)) => {
                let next = |k: usize| numbered(&pattern, first.saturating_add(k as u32));
                rest.iter().enumerate().take_while(|(k, (name, _))| *name == next(*k)).count()
            }
            None => 0,
        };
        let (run, others) = rest.split_at(length.max(1));
        match pattern(name).filter(|_| length > 1) {
            Some((pattern, first)) => {
                text += &format!(" {pattern} {first}-{}\n", first as usize + length - 1);
                for line in run.chunks(DIGESTS_PER_LINE) {
                    let digits: String = line.iter().map(|(_, digest)| digest.as_str()).collect();
                    text += &format!("  {digits}\n");
                }
            }
            None => text += &format!(" {name} {digest}\n"),
        }
        rest = others;
    }
    text
}

/// The names of a sequence folder's files: text and videos, then images by number.
fn present(folder: &Path, format: &FormatEntry) -> Vec<String> {
    let names = |folder: &Path| -> Vec<String> {
        let entries = std::fs::read_dir(folder).into_iter().flatten().flatten();
        let files = entries.filter(|e| e.path().is_file());
        files.filter_map(|e| e.file_name().into_string().ok()).filter(|n| !n.starts_with('.')).collect()
    };
    let images = (format.image_folder)(folder);
    let mut text: Vec<String> = names(folder).into_iter().filter(|n| (format.reads)(n)).collect();
    text.sort();
    let mut frames: Vec<(Option<u32>, String)> = names(&images)
        .into_iter()
        .filter(|n| is_image(Path::new(n)))
        .map(|n| (number(Path::new(&n)), n))
        .collect();
    frames.sort();
    let prefix = images.strip_prefix(folder).unwrap_or(Path::new("")).to_string_lossy().into_owned();
    let frames = frames.into_iter().map(|(_, name)| match prefix.as_str() {
        "" => name,
        prefix => format!("{prefix}/{name}"),
    });
    text.into_iter().chain(frames).collect()
}

/// Whether a file of the entry's folder is part of its sequence.
fn belongs(entry: &Entry, format: &FormatEntry, root: &Path, name: &str) -> bool {
    let path = Path::new(name);
    (format.belongs)(&entry.options(root), name, number(path).filter(|_| is_image(path)))
}

/// The first file of the entry under `root` that is absent, other than listed, or not listed; `None` where
/// nothing differs or the folder is not listed.
pub(super) fn first_difference(entry: &Entry, format: &FormatEntry, root: &Path) -> Option<String> {
    difference(entry, format, root, |_| true)
}

/// As [`first_difference`], of the label files alone.
pub(super) fn first_label_difference(entry: &Entry, format: &FormatEntry, root: &Path) -> Option<String> {
    difference(entry, format, root, format.is_label)
}

fn difference(entry: &Entry, format: &FormatEntry, root: &Path, wanted: fn(&str) -> bool) -> Option<String> {
    // The listing of a folder without a pinned digest may be incomplete.
    entry.digest.as_ref()?;
    compare(entry, format, root, &read(sections().get(entry.folder.as_str())?), wanted)
}

fn compare(
    entry: &Entry,
    format: &FormatEntry,
    root: &Path,
    listed: &[(String, String)],
    wanted: fn(&str) -> bool,
) -> Option<String> {
    let folder = entry.path(root);
    let matters = |name: &str| wanted(name) && belongs(entry, format, root, name);
    let listed: Vec<_> = listed.iter().filter(|(name, _)| matters(name)).collect();
    let changed = listed.par_iter().find_map_first(|(name, pinned)| {
        let path = below(&folder, name);
        if !path.is_file() {
            return Some(format!("{name} is missing"));
        }
        match file_digest(&path) {
            Ok(found) if found.starts_with(pinned.as_str()) => None,
            Ok(found) => Some(format!(
                "{name} is another file: its SHA-256 starts with {}, pinned is {pinned}",
                &found[..DIGITS]
            )),
            Err(error) => Some(error.to_string()),
        }
    });
    changed.or_else(|| {
        let names: std::collections::BTreeSet<&str> = listed.iter().map(|(n, _)| n.as_str()).collect();
        let extra = present(&folder, format).into_iter().find(|n| matters(n) && !names.contains(n.as_str()));
        extra.map(|name| format!("{name} does not belong there"))
    })
}

#[cfg(test)]
mod tests;
