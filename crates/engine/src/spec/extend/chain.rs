//! The files of an experiment: its own, the one it extends, the one that extends, and so on.

use super::EXTENDS;
use crate::spec::builtin;
use crate::spec::error::{SourceFile, SpecError};
use crate::spec::limits::read_text;
use std::ops::Range;
use std::path::{Component, Path, PathBuf};
use toml::de::DeValue;
use trackfail_core::plugin::unknown;

/// Most files, one extending the other.
const MAX_FILES: usize = 8;

/// Where an experiment comes from, and with it what it may extend.
#[derive(Clone)]
pub(in crate::spec) enum Place {
    /// From the program itself: only built-in experiments can be extended.
    BuiltIn,
    /// From a folder: also files in it and below.
    Folder {
        /// The folder of the first file as the user named it, empty for the current one.
        folder: PathBuf,
        /// The folder of the first file, without links; no file outside it is read.
        root: PathBuf,
        /// The file, without links.
        file: PathBuf,
    },
}

impl Place {
    /// The place of a file that a user named.
    ///
    /// # Errors
    /// When the file is not there.
    pub(in crate::spec) fn of(path: &Path) -> std::io::Result<Self> {
        let file = path.canonicalize()?;
        let root = file.parent().unwrap_or(&file).to_path_buf();
        Ok(Self::Folder { folder: path.parent().unwrap_or(Path::new("")).to_path_buf(), root, file })
    }

    /// Identity of a file; for a built-in experiment its name.
    fn identity(&self, name: &str) -> PathBuf {
        match self {
            Self::BuiltIn => PathBuf::from(name),
            Self::Folder { file, .. } => file.clone(),
        }
    }
}

/// Reads all files that a text extends; the text itself is the first, and each extends the one behind it.
///
/// # Errors
/// A base that cannot be read or leads in a circle.
pub(in crate::spec) fn load(name: &str, text: &str, mut place: Place) -> Result<Vec<SourceFile>, SpecError> {
    let mut seen = vec![place.identity(name)];
    let mut files = Vec::new();
    let mut extended_by = Vec::new();
    let mut last =
        SourceFile { name: name.to_string(), text: text.to_string(), note: String::new(), start: 0 };
    while let Some((target, span)) = extended(&last)? {
        let wrong = |message: String| last.source().error(span.clone(), message);
        let (name, text, next) = open(&place, &target, &wrong)?;
        let identity = next.identity(&name);
        if seen.contains(&identity) {
            return Err(wrong(format!("`{target}` extends itself")));
        }
        if seen.len() == MAX_FILES {
            return Err(wrong(format!("more than {MAX_FILES} files extend one another")));
        }
        seen.push(identity);
        place = next;
        extended_by.insert(0, last.source().file_and_line(span.start));
        let note = format!(" (extended by {})", extended_by.join(", "));
        let start = last.start + last.text.len() + 1;
        files.push(std::mem::replace(&mut last, SourceFile { name, text, note, start }));
    }
    files.push(last);
    Ok(files)
}

/// The value of `extends`, with its place.
fn extended(file: &SourceFile) -> Result<Option<(String, Range<usize>)>, SpecError> {
    let document = file.source().syntax()?;
    let Some(value) = document.get_ref().get(EXTENDS) else { return Ok(None) };
    match value.get_ref() {
        DeValue::String(target) => Ok(Some((target.to_string(), value.span()))),
        _ => Err(file.source().error(value.span(), "`extends` must be text")),
    }
}

/// Name, text and place of a base; `wrong` makes the error of a base that cannot be meant.
fn open(
    from: &Place,
    target: &str,
    wrong: &dyn Fn(String) -> SpecError,
) -> Result<(String, String, Place), SpecError> {
    if !target.ends_with(".toml") {
        let Some((name, text)) = builtin::EXPERIMENTS.iter().find(|(name, _)| *name == target) else {
            let known = builtin::EXPERIMENTS.iter().map(|(name, _)| *name);
            let short = trackfail_dataset::text::shorten_to(target, 64);
            return Err(wrong(unknown("built-in experiment", &short, known) + " (files end in .toml)"));
        };
        return Ok((name.to_string(), text.to_string(), Place::BuiltIn));
    }
    let Place::Folder { folder, root, .. } = from else {
        return Err(wrong("only an experiment that is read from a file can extend a file".to_string()));
    };
    let outside =
        || wrong("`extends` must name a file in the folder of the experiment or below it".to_string());
    if !Path::new(target).components().all(|part| matches!(part, Component::Normal(_))) {
        return Err(outside());
    }
    let path = folder.join(target);
    let shown = path.display().to_string();
    let file = path.canonicalize().map_err(|e| wrong(format!("{shown}: {e}")))?;
    // A link could lead anywhere.
    if !file.starts_with(root) || !file.is_file() {
        return Err(outside());
    }
    let text = read_text(&path)?;
    let folder = path.parent().unwrap_or(Path::new("")).to_path_buf();
    Ok((shown, text, Place::Folder { folder, root: root.clone(), file }))
}
