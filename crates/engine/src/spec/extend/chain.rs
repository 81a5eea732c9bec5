//! Files of an experiment: its own, the one that it extends, the one that this extends, and so on.

use super::EXTENDS;
use crate::spec::builtin;
use crate::spec::error::{SourceFile, SpecError};
use crate::spec::limits::read_text;
use std::path::{Component, Path, PathBuf};
use trackfail_core::plugin::unknown;
use trackfail_dataset::text::shorten_to;

/// Longest chain of files that extend each other.
const MAX_FILES: usize = 8;

/// Folder in which an experiment may extend files, besides built-in ones.
pub(in crate::spec) struct Folder {
    /// Folder of the last file read, relative to the name that the user gave; empty for the current folder.
    path: PathBuf,
    /// Folder of the first file, with links resolved. Files outside it are refused.
    root: PathBuf,
}

impl Folder {
    /// Folder of a file that a user named.
    ///
    /// # Errors
    /// When the file does not exist.
    pub(in crate::spec) fn of(file: &Path) -> std::io::Result<Self> {
        let real = file.canonicalize()?;
        Ok(Self { path: parent(file), root: parent(&real) })
    }
}

fn parent(path: &Path) -> PathBuf {
    path.parent().unwrap_or(Path::new("")).to_path_buf()
}

/// Reads the chain of files that a file extends. The file comes first, each one extends the next. Without a
/// folder, only built-in experiments can be extended.
///
/// # Errors
/// A base that cannot be read, or a circle of bases.
pub(in crate::spec) fn load(
    first: SourceFile,
    mut folder: Option<Folder>,
) -> Result<Vec<SourceFile>, SpecError> {
    let mut files = Vec::new();
    let mut extended_by = Vec::new();
    let mut next = Some(first);
    while let Some(file) = next.take() {
        files.push(file);
        let last = &files[files.len() - 1];
        let document = last.syntax()?;
        let Some(value) = document.get_ref().get(EXTENDS) else { break };
        let Some(target) = value.get_ref().as_str() else { break };
        let wrong = |message: String| last.error(value.span(), message);
        let (name, text) = open(&mut folder, target, &wrong)?;
        if target.ends_with(".toml") && files.iter().any(|file| file.name == name) {
            return Err(wrong(format!("`{target}` extends itself")));
        }
        if files.len() == MAX_FILES {
            return Err(wrong(format!("more than {MAX_FILES} files extend one another")));
        }
        extended_by.insert(0, last.file_and_line(value.span().start));
        let note = format!(" (extended by {})", extended_by.join(", "));
        next = Some(SourceFile::after(last, &name, &text, note));
    }
    Ok(files)
}

/// Reads name and text of a base. `wrong` makes the error for a name that is no valid base.
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
