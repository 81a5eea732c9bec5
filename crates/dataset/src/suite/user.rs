//! Files of user suites: a `datasets.lock` in a data root.
//!
//! Such a file has `schema = 2` and `[[suite]]` sections, of which `trackfail data add` makes one from a
//! folder of sequences, but no archives. Its suites are known to experiments and to all commands that are
//! given the data root; a built-in suite cannot be replaced. A results folder keeps a copy of the sections
//! that it used, so that its report can be made without the data root.

use crate::lock::{Entry, PinnedSuite, pinned_suite_names};
use crate::{DatasetError, synthetic, text};
use serde::Deserialize;
use std::collections::BTreeSet;
use std::path::Path;
use trackfail_core::plugin::unknown;

/// Name of the file in the data root.
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

/// Appends sections to the text of a user file, which may be empty.
pub fn with_sections(before: &str, sections: &str) -> String {
    let head =
        "# Suites of the sequences below this folder, as `trackfail data add` writes them.\n\nschema = 2\n";
    let before = if before.trim().is_empty() { head } else { before };
    format!("{}\n\n{sections}", before.trim_end())
}

/// Parses the suites of a user file.
pub(super) fn parse(path: &Path, bytes: &[u8]) -> Result<Vec<PinnedSuite>, DatasetError> {
    let source = text::decode(path, bytes)?;
    let file: UserFile = toml::from_str(source).map_err(|e| {
        let line = text::line_of(source.as_bytes(), e.span().map_or(0, |span| span.start));
        DatasetError::line(path, line, text::shorten_to(&text::visible(e.message()), 200))
    })?;
    if file.schema != 2 {
        return Err(DatasetError::content(path, format!("schema = {}; 2 is read", file.schema)));
    }
    let mut suites: Vec<PinnedSuite> = Vec::new();
    for suite in file.suite {
        let name = text::shorten(&text::visible(&suite.name));
        let fault = |message: String| DatasetError::content(path, format!("suite `{name}`: {message}"));
        let no_suite = |other: String| unknown("suite in `includes`", &other, pinned_suite_names());
        let own = suite.sequence.len();
        let mut suite = suite.complete().map_err(no_suite).map_err(fault)?;
        // Archives are fetched for the suites that they belong to.
        let included = suite.sequence.len() - own;
        for entry in &mut suite.sequence[..included] {
            (entry.archive, entry.truth_archive) = (None, None);
        }
        check(&suite).map_err(fault)?;
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
/// The first rule that the suite breaks.
pub(super) fn check(suite: &PinnedSuite) -> Result<(), String> {
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
        let name = text::shorten(&text::visible(&entry.name));
        check_entry(entry).map_err(|message| format!("sequence `{name}`: {message}"))?;
        if !seen.insert(&entry.name) {
            return Err(format!("sequence `{name}` is listed twice; names are unique in a suite"));
        }
    }
    Ok(())
}

/// Checks whether a user suite may have the name.
///
/// # Errors
/// The rule that the name breaks.
pub fn check_name(name: &str) -> Result<(), String> {
    let fits = |c: char| c.is_ascii_alphanumeric() || "-_.".contains(c);
    if name.is_empty() || name.len() > MAX_NAME || name.starts_with(['.', '-']) || !name.chars().all(fits) {
        return Err(format!(
            "a name has 1 to {MAX_NAME} letters, digits, `-`, `_` and `.`, and does not begin with `.` or `-`"
        ));
    }
    if pinned_suite_names().any(|n| n == name) || synthetic::is_rendered(name) {
        return Err("this is the name of a built-in suite; take another".into());
    }
    Ok(())
}

fn check_entry(entry: &Entry) -> Result<(), String> {
    // Names stand in addresses of cells, whose parts are separated by slashes.
    let is_word = |w: &str| text::is_name(w) && !w.contains(['"', '\\', '/']);
    let word = format!("{} and has no quotes, slashes and backslashes", text::NAME);
    let order = |key: &str, range: Option<(u32, u32)>| {
        let (first, last) = range.unwrap_or_default();
        let message = format!("`{key}` goes from a first to a last frame, not from {first} to {last}");
        (first <= last && last <= i32::MAX as u32, message)
    };
    let length = |(first, last): (u32, u32)| i64::from(last) - i64::from(first) + 1;
    let is_counted = |frames: usize| frames > 0 && entry.range.is_none_or(|r| length(r) == frames as i64);
    let rules = [
        (is_word(&entry.name), format!("a name is {word}")),
        (
            is_below(&entry.folder),
            "`folder` is a path under the data root, parts separated by `/`, without `..`".into(),
        ),
        (entry.attributes.iter().all(|a| is_word(a)), format!("an attribute is {word}")),
        (
            entry.archive.is_none() && entry.truth_archive.is_none(),
            "only sequences of the built-in suites come in archives".into(),
        ),
        (
            entry.digest.as_deref().is_none_or(is_digest),
            "`digest` is 64 hexadecimal digits in small letters".into(),
        ),
        order("range", entry.range),
        order("official", entry.official),
        (entry.frames.is_none_or(is_counted), "`frames` is the number of frames of `range`".into()),
    ];
    rules.into_iter().find(|(holds, _)| !holds).map_or(Ok(()), |(_, message)| Err(message))
}

/// True if the text is a SHA-256 in hexadecimal.
pub(super) fn is_digest(text: &str) -> bool {
    text.len() == 64 && text.bytes().all(|b| b.is_ascii_digit() || (b'a'..=b'f').contains(&b))
}

/// True if a relative path stays below the folder that it starts from.
pub(super) fn is_below(folder: &str) -> bool {
    let part = |p: &str| !p.is_empty() && p != "." && p != "..";
    folder.split('/').all(part) && folder.chars().all(|c| text::is_plain(c) && !"\"\\:".contains(c))
}

/// Writes a suite as the section that [`parse`] reads.
pub(super) fn section(suite: &PinnedSuite) -> String {
    let head = toml::to_string(suite).expect("a suite has texts alone");
    let lines: String = suite.sequence.iter().map(|entry| format!("    {}\n", entry.line())).collect();
    format!("[[suite]]\n{head}sequence = [\n{lines}]\n")
}

#[cfg(test)]
pub(super) mod tests;
