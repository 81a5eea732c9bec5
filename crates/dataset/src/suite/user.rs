//! Files of user suites: a `datasets.lock` in a data root.
//!
//! Such a file has `schema = 2` and `[[suite]]` sections, of which `trackfail data add` makes one from a folder
//! of sequences, but no archives. Its suites are known to experiments and to all commands that are given the
//! data root; a built-in suite cannot be replaced. A results folder has a copy of the sections that
//! it used, from which its report is made without the data root.

use crate::lock::{Entry, PinnedSuite, pinned_suite_names};
use crate::{DatasetError, synthetic, text};
use serde::Deserialize;
use std::collections::BTreeSet;
use std::path::Path;

/// The file's name in the data root.
pub const USER_LOCK: &str = "datasets.lock";
/// Longest name of a user suite, in bytes.
const MAX_NAME: usize = 60;

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct UserFile {
    schema: u32,
    #[serde(default)]
    suite: Vec<PinnedSuite>,
}

/// The text of a user file, which may be empty, with further sections.
pub fn with_sections(before: &str, sections: &str) -> String {
    let head =
        "# Suites of the sequences below this folder, as `trackfail data add` writes them.\n\nschema = 2\n";
    let before = if before.trim().is_empty() { head } else { before.trim_end() };
    format!("{}\n\n{sections}", before.trim_end())
}

/// The suites of a file.
pub(super) fn parse(path: &Path, bytes: &[u8]) -> Result<Vec<PinnedSuite>, DatasetError> {
    let source = text::decode(path, bytes)?;
    let wire: UserFile = toml::from_str(source).map_err(|e| {
        let before = e.span().and_then(|span| source.get(..span.start)).unwrap_or_default();
        let message = text::shorten_to(&text::visible(e.message()), 200);
        DatasetError::line(path, 1 + before.matches('\n').count(), message)
    })?;
    if wire.schema != 2 {
        return Err(DatasetError::content(path, format!("schema = {}; 2 is read", wire.schema)));
    }
    let mut suites: Vec<PinnedSuite> = Vec::new();
    for suite in wire.suite {
        let name = text::shorten(&text::visible(&suite.name));
        let fault = |message: String| DatasetError::content(path, format!("suite `{name}`: {message}"));
        let unknown = |other: String| {
            fault(trackfail_core::plugin::unknown("suite in `includes`", &other, pinned_suite_names()))
        };
        let suite = suite.complete().map_err(unknown)?;
        check(&suite).map_err(|e| fault(e.to_string()))?;
        if suites.iter().any(|known| known.name == suite.name) {
            return Err(fault("it is listed twice; names are unique".into()));
        }
        suites.push(suite);
    }
    Ok(suites)
}

/// Checks whether a suite can be a user suite.
///
/// # Errors
/// The first rule that it breaks.
pub(super) fn check(suite: &PinnedSuite) -> Result<(), UserSuiteError> {
    check_name(&suite.name)?;
    let fault = |message: String| Err(UserSuiteError(message));
    for line in [&suite.title, &suite.source, &suite.licence, &suite.how_to_get] {
        if !line.chars().all(text::is_plain) {
            return fault(format!("`{}` is no plain line of text", text::shorten(&text::visible(line))));
        }
    }
    if suite.sequence.is_empty() {
        return fault("it has no sequence".into());
    }
    let mut seen = BTreeSet::new();
    for entry in &suite.sequence {
        let name = text::shorten(&text::visible(&entry.name));
        if let Err(message) = check_entry(entry) {
            return fault(format!("sequence `{name}`: {message}"));
        }
        if !seen.insert(&entry.name) {
            return fault(format!("sequence `{name}` is listed twice; names are unique in a suite"));
        }
    }
    Ok(())
}

/// The rule that a suite breaks, so that it cannot be a user suite.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{0}")]
pub struct UserSuiteError(String);

/// Checks whether a user suite may have the name.
///
/// # Errors
/// Why not.
pub fn check_name(name: &str) -> Result<(), UserSuiteError> {
    let fits = |c: char| c.is_ascii_alphanumeric() || "-_.".contains(c);
    if name.is_empty() || name.len() > MAX_NAME || name.starts_with(['.', '-']) || !name.chars().all(fits) {
        let message = format!(
            "a name has 1 to {MAX_NAME} letters, digits, `-`, `_` and `.`, and does not begin with `.` or `-`"
        );
        return Err(UserSuiteError(message));
    }
    if pinned_suite_names().any(|n| n == name) || synthetic::is_rendered(name) {
        return Err(UserSuiteError("this is the name of a built-in suite; take another".into()));
    }
    Ok(())
}

fn check_entry(entry: &Entry) -> Result<(), String> {
    let word = |w: &str| text::is_name(w) && !w.contains(['"', '\\', '/']);
    let is_digest =
        |d: &String| d.len() == 64 && d.bytes().all(|b| b.is_ascii_digit() || (b'a'..=b'f').contains(&b));
    let ranges = [("range", entry.range), ("official", entry.official)];
    let mut ranges =
        ranges.into_iter().filter_map(|(key, range)| range.map(|(first, last)| (key, first, last)));
    let frames = entry.range.map(|(first, last)| u64::from(last).wrapping_sub(first.into()).wrapping_add(1));
    // Names stand in addresses of cells, whose parts are separated by slashes.
    let fault = if !word(&entry.name) {
        format!("a name is {} and has no quotes, slashes and backslashes", text::NAME)
    } else if !is_below(&entry.folder) {
        "`folder` is a path under the data root, parts separated by `/`, without `..`".into()
    } else if !entry.attributes.iter().all(|a| word(a)) {
        format!("an attribute is {} and has no quotes, slashes and backslashes", text::NAME)
    } else if entry.archive.is_some() || entry.truth_archive.is_some() {
        "only sequences of the built-in suites come in archives".into()
    } else if !entry.digest.as_ref().is_none_or(is_digest) {
        "`digest` is 64 hexadecimal digits in small letters".into()
    } else if let Some((key, first, last)) =
        ranges.find(|(_, first, last)| first > last || *last > i32::MAX as u32)
    {
        format!("`{key}` goes from a first to a last frame, not from {first} to {last}")
    } else if entry.frames == Some(0)
        || frames.zip(entry.frames).is_some_and(|(range, frames)| range != frames as u64)
    {
        "`frames` is the number of frames of `range`".into()
    } else {
        return Ok(());
    };
    Err(fault)
}

/// Whether a path stays below the folder that it starts from.
pub(super) fn is_below(folder: &str) -> bool {
    let part = |p: &str| !p.is_empty() && p != "." && p != "..";
    folder.split('/').all(part) && folder.chars().all(|c| text::is_plain(c) && !"\"\\:".contains(c))
}

/// The section of a suite, as [`parse`] reads it.
pub(super) fn section(suite: &PinnedSuite) -> String {
    // A JSON string of plain text is a TOML string.
    let quoted = |text: &String| serde_json::Value::from(text.as_str()).to_string();
    let mut out = format!("[[suite]]\nname = {}\n", quoted(&suite.name));
    out += &format!("title = {}\nformat = \"{}\"\n", quoted(&suite.title), suite.format.word);
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

#[cfg(test)]
pub(super) mod tests;
