//! The files of an experiment: its own, the one it extends, the one that extends, and so on.

use super::EXTENDS;
use crate::spec::builtin;
use crate::spec::error::{SourceFile, SpecError};
use crate::spec::limits::read_text;
use std::ops::Range;
use std::path::{Component, Path, PathBuf};
use trackfail_core::plugin::unknown;
use trackfail_dataset::text::shorten_to;

/// Most files, one extending the other.
const MAX_FILES: usize = 8;

/// The folders of files that an experiment may extend, beside built-in ones.
pub(in crate::spec) struct Folder {
    /// The folder of the file read last, as the user named the first one; empty for the current one.
    path: PathBuf,
    /// The folder of the first file, without links; no file outside it is read.
    root: PathBuf,
}

impl Folder {
    /// The folder of a file that a user named.
    ///
    /// # Errors
    /// When the file is not there.
    pub(in crate::spec) fn of(file: &Path) -> std::io::Result<Self> {
        let real = file.canonicalize()?;
        Ok(Self { path: parent(file), root: parent(&real) })
    }
}

fn parent(path: &Path) -> PathBuf {
    path.parent().unwrap_or(Path::new("")).to_path_buf()
}

/// Reads all files that a text extends; the text itself is the first, and each extends the one behind it. Without a folder,
/// only built-in experiments can be extended.
///
/// # Errors
/// A base that cannot be read or leads in a circle.
pub(in crate::spec) fn load(
    name: &str,
    text: &str,
    mut folder: Option<Folder>,
) -> Result<Vec<SourceFile>, SpecError> {
    let mut files = Vec::new();
    let mut extended_by = Vec::new();
    let mut last = SourceFile::new(name.to_string(), text, String::new(), None);
    while let Some((target, span)) = extended(&last)? {
        let wrong = |message: String| last.source().error(span.clone(), message);
        let (name, text) = open(&mut folder, &target, &wrong)?;
        let is_it = |file: &SourceFile| file.name == name;
        if target.ends_with(".toml") && (is_it(&last) || files.iter().any(is_it)) {
            return Err(wrong(format!("`{target}` extends itself")));
        }
        if files.len() + 1 == MAX_FILES {
            return Err(wrong(format!("more than {MAX_FILES} files extend one another")));
        }
        extended_by.insert(0, last.source().file_and_line(span.start));
        let note = format!(" (extended by {})", extended_by.join(", "));
        let base = SourceFile::new(name, &text, note, Some(&last));
        files.push(std::mem::replace(&mut last, base));
    }
    files.push(last);
    Ok(files)
}

/// The value of `extends`, with its place.
fn extended(file: &SourceFile) -> Result<Option<(String, Range<usize>)>, SpecError> {
    let document = file.source().syntax()?;
    let value = document.get_ref().get(EXTENDS);
    Ok(value.and_then(|value| Some((value.get_ref().as_str()?.to_string(), value.span()))))
}

/// Name and text of a base; `wrong` makes the error of a base that cannot be meant.
fn open(
    folder: &mut Option<Folder>,
    target: &str,
    wrong: &dyn Fn(String) -> SpecError,
) -> Result<(String, String), SpecError> {
    if !target.ends_with(".toml") {
        let Some((name, text)) = builtin::EXPERIMENTS.iter().find(|(name, _)| *name == target) else {
            let known = builtin::EXPERIMENTS.iter().map(|(name, _)| *name);
            let message = unknown("built-in experiment", &shorten_to(target, 64), known);
            return Err(wrong(message + " (files end in .toml)"));
        };
        *folder = None;
        return Ok((name.to_string(), text.to_string()));
    }
    let Some(folder) = folder else {
        return Err(wrong("only an experiment that is read from a file can extend a file".to_string()));
    };
    let outside =
        || wrong("`extends` must name a file in the folder of the experiment or below it".to_string());
    if !Path::new(target).components().all(|part| matches!(part, Component::Normal(_))) {
        return Err(outside());
    }
    let path = folder.path.join(target);
    let shown = path.display().to_string();
    let file = path.canonicalize().map_err(|e| wrong(format!("{shown}: {e}")))?;
    // A link could lead anywhere.
    if !file.starts_with(&folder.root) || !file.is_file() {
        return Err(outside());
    }
    folder.path = parent(&path);
    Ok((shown, read_text(&path)?))
}
