//! Experiments that say only what differs: `extends` names another experiment, groups give what several
//! trackers or methods share.
//!
//! [`complete`] puts the text of an experiment together as if nobody had shortened it. Only that text is
//! checked, planned and kept beside the results, so that results stand by themselves. [`chain`] reads the files,
//! [`document`] cuts each into keys and items and writes its groups out, [`merge`] lays a file over the one it
//! extends, [`write`] makes the text and remembers which line of which file each piece of it comes from.
//!
//! - A key of the file, a suite of `[suites]` and a key of an item replace those of the base.
//! - An item (`[[tracker]]`, `[[method]]`, `[[table]]` ...) whose name the base has changes that one; others
//!   are added behind the base's of their kind. A tracker's name is its label, a claim's its text, that of
//!   published numbers their table, tracker and row.
//! - `[without]` leaves items of the base out: `table = ["counts"]`.
//! - A `[[tracker-group]]` or `[[method-group]]` lists its members and gives the keys they share. Where it has
//!   a `group` of its own, that name stands for all members in every list of trackers or methods.

mod chain;
mod document;
mod merge;
mod write;

use super::error::{Piece, SHORTCUTS, Source, SourceFile, SourceMap, SpecError};
pub(super) use chain::Place;
use document::Document;
use toml::de::DeTable;

/// Key that names the experiment to build on.
const EXTENDS: &str = SHORTCUTS[0];
/// Table of what the base has and the experiment has not.
const WITHOUT: &str = SHORTCUTS[1];

/// Text of an experiment that needs no other file, and where its pieces come from.
pub(super) struct Complete {
    pub text: String,
    pub map: SourceMap,
}

/// Whether a file needs no other and has no groups.
pub(super) fn is_complete(document: &DeTable<'_>) -> bool {
    !SHORTCUTS.iter().any(|key| document.contains_key(*key))
}

/// Puts together what an experiment and those it extends say.
///
/// # Errors
/// A base that cannot be read or leads in a circle, a group that is wrong, and more text than an
/// experiment file may have.
pub(super) fn complete(file: &str, text: &str, place: Place) -> Result<Complete, SpecError> {
    let files = chain::load(file, text, place)?;
    let (text, pieces) = merge_all(&files)?;
    Ok(Complete { text, map: SourceMap { files, pieces } })
}

fn merge_all(files: &[SourceFile]) -> Result<(String, Vec<Piece>), SpecError> {
    let parsed = files.iter().map(chain::parse).collect::<Result<Vec<_>, _>>()?;
    let mut whole: Option<Document<'_>> = None;
    // The last file extends none.
    for (index, (file, table)) in files.iter().zip(&parsed).enumerate().rev() {
        let document = document::cut(file.source(), index, table)?;
        whole = Some(match whole {
            Some(base) => merge::merge(base, document, file.source())?,
            None if document.without.is_empty() => document,
            None => {
                let span = document.without[0].1.span();
                return Err(file.source().error(span, "[without] is for experiments that extend another"));
            }
        });
    }
    let sources: Vec<Source<'_>> = files.iter().map(SourceFile::source).collect();
    write::write(&whole.unwrap_or_default(), &sources)
}

#[cfg(test)]
mod tests;
