//! Suites of one's own sequences: a second `datasets.lock`, in the data root.
//!
//! It is written like the built-in one, without archives: `schema = 2` and `[[suite]]` sections, of which
//! `trackfail data add` makes one from a folder of sequences. What it names is known to experiments and to all
//! commands that are given the data root; a suite of the built-in file cannot be replaced.
//!
//! Suites are looked up by name from everywhere and live as long as the program, so those of a data root are
//! kept for the whole process once they are read. A results folder has a copy of the sections that it used,
//! from which its report is made without the data root.

use super::entry::{Entry, Format, below};
use super::text::Pinned;
use crate::{DatasetError, synthetic, text};
use rayon::prelude::*;
use serde::Deserialize;
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::sync::{PoisonError, RwLock, RwLockReadGuard};

/// The file's name in the data root.
pub const OWN_LOCK: &str = "datasets.lock";
/// Folders that may lie between the folder of a suite and a sequence.
const DEEPEST: usize = 3;

static OWN: RwLock<Own> = RwLock::new(Own(Vec::new()));

/// The suites that are known.
struct Own(Vec<&'static Pinned>);

impl Own {
    /// Adds suites, in the place of others of their names.
    fn add(&mut self, suites: Vec<Pinned>) {
        for suite in suites {
            let known = self.0.iter().position(|o| o.name == suite.name);
            if known.is_some_and(|k| section(self.0[k]) == section(&suite)) {
                continue;
            }
            let suite: &'static Pinned = Box::leak(Box::new(suite));
            match known {
                Some(k) => self.0[k] = suite,
                None => self.0.push(suite),
            }
        }
    }

    fn suite(&self, name: &str) -> Option<&'static Pinned> {
        self.0.iter().find(|s| s.name == name).copied()
    }

    fn text(&self, wanted: &BTreeSet<&str>) -> Option<String> {
        let sections: Vec<String> = wanted.iter().filter_map(|name| self.suite(name)).map(section).collect();
        (!sections.is_empty()).then(|| with_sections("", &sections.join("\n")))
    }
}

fn own() -> RwLockReadGuard<'static, Own> {
    OWN.read().unwrap_or_else(PoisonError::into_inner)
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Wire {
    schema: u32,
    #[serde(default)]
    suite: Vec<Pinned>,
}

/// Makes the suites known that a data root's own `datasets.lock` has; does nothing where there is none.
///
/// # Errors
/// A file that cannot be read, or is wrong.
pub fn read_own(data_root: &Path) -> Result<(), DatasetError> {
    let path = data_root.join(OWN_LOCK);
    if path.exists() { add_own(&path, &text::read_capped(&path)?) } else { Ok(()) }
}

/// Makes the suites of such a file known, in the place of others of their names that came the same way.
///
/// # Errors
/// As [`read_own`]; `path` names the file in messages.
pub fn add_own(path: &Path, bytes: &[u8]) -> Result<(), DatasetError> {
    let suites = parse(path, bytes)?;
    OWN.write().unwrap_or_else(PoisonError::into_inner).add(suites);
    Ok(())
}

/// The names of those suites, in the order in which they became known.
pub(super) fn names() -> Vec<&'static str> {
    own().0.iter().map(|s| s.name.as_str()).collect()
}

/// The suite of a name.
pub(super) fn suite(name: &str) -> Option<&'static Pinned> {
    own().suite(name)
}

/// A file with the suites of these names that are one's own, each once; `None` where none is.
pub fn own_text<'n>(wanted: impl IntoIterator<Item = &'n str>) -> Option<String> {
    own().text(&wanted.into_iter().collect())
}

/// The text of an own file, empty or not, with further sections.
pub fn with_sections(before: &str, sections: &str) -> String {
    let head =
        "# Suites of the sequences below this folder, as `trackfail data add` writes them.\n\nschema = 2\n";
    let before = if before.trim().is_empty() { head } else { before.trim_end() };
    format!("{}\n\n{sections}", before.trim_end())
}

/// The suites of a file.
fn parse(path: &Path, bytes: &[u8]) -> Result<Vec<Pinned>, DatasetError> {
    let source = text::decode(path, bytes)?;
    let wire: Wire = toml::from_str(source).map_err(|e| {
        let before = e.span().and_then(|span| source.get(..span.start)).unwrap_or_default();
        let message = text::shorten_to(&text::visible(e.message()), 200);
        DatasetError::line(path, 1 + before.matches('\n').count(), message)
    })?;
    if wire.schema != 2 {
        return Err(DatasetError::content(path, format!("schema = {}; 2 is read", wire.schema)));
    }
    let mut seen = BTreeSet::new();
    for suite in &wire.suite {
        let fault = |message: String| {
            let name = text::shorten(&text::visible(&suite.name));
            DatasetError::content(path, format!("suite `{name}`: {message}"))
        };
        check(suite).map_err(fault)?;
        if !seen.insert(&suite.name) {
            return Err(fault("it stands there twice; names are unique".into()));
        }
    }
    Ok(wire.suite)
}

fn check(suite: &Pinned) -> Result<(), String> {
    check_name(&suite.name)?;
    for line in [&suite.title, &suite.source, &suite.licence, &suite.how_to_get] {
        if !line.chars().all(text::is_plain) {
            return Err(format!("`{}` is no plain line of text", text::shorten(&text::visible(line))));
        }
    }
    if suite.sequence.is_empty() {
        return Err("it has no sequence".into());
    }
    let mut seen = BTreeSet::new();
    for entry in &suite.sequence {
        let shown = text::shorten(&text::visible(&entry.name));
        check_entry(entry).map_err(|message| format!("sequence `{shown}`: {message}"))?;
        if !seen.insert(&entry.name) {
            return Err(format!("sequence `{shown}` stands there twice; names are unique in a suite"));
        }
    }
    Ok(())
}

/// Whether a suite of one's own may have the name.
///
/// # Errors
/// Why not.
pub fn check_name(name: &str) -> Result<(), String> {
    let fits = |c: char| c.is_ascii_alphanumeric() || "-_.".contains(c);
    if name.is_empty() || name.len() > 60 || name.starts_with('.') || !name.chars().all(fits) {
        return Err(
            "a name has 1 to 60 letters, digits, `-`, `_` and `.`, and does not begin with `.`".into()
        );
    }
    if super::text::names().any(|n| n == name) || synthetic::SUITES.iter().any(|s| s.name == name) {
        return Err("this is the name of a built-in suite; take another".into());
    }
    Ok(())
}

fn check_entry(entry: &Entry) -> Result<(), String> {
    // Names stand in addresses of cells, whose parts are separated by slashes.
    let word = |w: &str| !w.is_empty() && w.chars().all(|c| text::is_plain(c) && !"\"\\/".contains(c));
    if !word(&entry.name) {
        return Err("a name is plain text without quotes, slashes and backslashes".into());
    }
    if !is_below(&entry.folder) {
        return Err("`folder` is a path under the data root, parts separated by `/`, without `..`".into());
    }
    if !entry.attributes.iter().all(|a| word(a)) {
        return Err("attributes are plain words without quotes, slashes and backslashes".into());
    }
    if entry.archive.is_some() || entry.truth_archive.is_some() {
        return Err("only sequences of the built-in file come in archives".into());
    }
    let digest =
        |d: &String| d.len() == 64 && d.bytes().all(|b| b.is_ascii_digit() || (b'a'..=b'f').contains(&b));
    if !entry.digest.as_ref().is_none_or(digest) {
        return Err("`digest` is 64 hexadecimal digits in small letters".into());
    }
    for (key, (first, last)) in [("range", entry.range), ("official", entry.official)]
        .into_iter()
        .filter_map(|(key, range)| Some((key, range?)))
    {
        if first > last || last > i32::MAX as u32 {
            return Err(format!("`{key}` goes from a first to a last frame, not from {first} to {last}"));
        }
    }
    let (range, frames) = (entry.range.map(|(a, b)| (b - a) as usize + 1), entry.frames);
    if frames == Some(0) || (range.is_some() && frames.is_some() && range != frames) {
        return Err("`frames` is the number of frames of `range`".into());
    }
    Ok(())
}

/// Whether a path stays below the folder that it starts from.
fn is_below(folder: &str) -> bool {
    let part = |p: &str| !p.is_empty() && p != "." && p != "..";
    folder.split('/').all(part) && folder.chars().all(|c| text::is_plain(c) && !"\"\\:".contains(c))
}

/// The section of a suite, as it is read.
fn section(suite: &Pinned) -> String {
    // A JSON string of plain text is a TOML string.
    let quoted = |text: &String| serde_json::Value::from(text.as_str()).to_string();
    let mut out = format!("[[suite]]\nname = {}\n", quoted(&suite.name));
    out += &format!("title = {}\nformat = \"{}\"\n", quoted(&suite.title), suite.format.word());
    let about = [("source", &suite.source), ("licence", &suite.licence), ("how_to_get", &suite.how_to_get)];
    for (key, value) in about {
        out += &format!("{key} = {}\n", quoted(value));
    }
    out += "sequence = [\n";
    for entry in &suite.sequence {
        out += &format!("    {}\n", entry.line());
    }
    out + "]\n"
}

/// What to look for, and where.
#[derive(Debug, Clone, Copy)]
pub struct Wanted<'w> {
    /// Name of the suite.
    pub name: &'w str,
    /// One line about it; the folder and the number of sequences otherwise.
    pub title: Option<&'w str>,
    /// Layout of the sequences: not CVML, whose files have several.
    pub format: Format,
    /// Folder under the data root, parts separated by `/`.
    pub folder: &'w str,
    /// Names of the sequences to take, in order; all that are there in the order of their folders otherwise.
    pub only: Option<&'w [String]>,
}

/// The section of a suite of the sequences below a folder, with ranges, sizes and digests of what is there.
///
/// A folder with a ground-truth file is a sequence of the folder's name; of an OTB folder with several, each
/// is one, `<folder>-<N>`. Hashes all files.
///
/// # Errors
/// No sequence, two of one name, a wanted one that is not there, and the first that cannot be read.
pub fn gather(wanted: &Wanted<'_>, data_root: &Path) -> Result<String, DatasetError> {
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
        return Err(fault(format!("no sequence: no folder with {file}, up to {DEEPEST} folders down")));
    }
    let title = format!("{} sequences in {} of the data root", found.len(), wanted.folder);
    let mut suite = Pinned {
        name: wanted.name.into(),
        title: wanted.title.map_or(title, Into::into),
        format: wanted.format,
        source: format!("{} of the data root", wanted.folder),
        licence: "not stated".into(),
        how_to_get: format!(
            "this suite is one of your own, in {OWN_LOCK} of the data root; restore its folder"
        ),
        sequence: found,
    };
    check(&suite).map_err(&fault)?;
    let facts: Vec<Result<Entry, DatasetError>> = suite
        .sequence
        .par_iter()
        .map(|entry| match suite.facts(entry, Some(data_root))? {
            Ok(facts) => Ok(facts),
            Err(missing) => Err(DatasetError::content(&entry.path(data_root), missing.how_to_get)),
        })
        .collect();
    // The first in order, whichever was read first.
    let facts = facts.into_iter().collect::<Result<Vec<Entry>, _>>()?;
    suite.sequence = facts;
    Ok(section(&suite))
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
        walkdir::WalkDir::new(start).follow_links(true).max_depth(DEEPEST).sort_by_file_name().into_iter();
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
