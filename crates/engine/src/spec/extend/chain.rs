//! The files of an experiment: its own, the one it extends, the one that extends, and so on.

use super::EXTENDS;
use crate::spec::builtin;
use crate::spec::error::{Source, SourceFile, SpecError};
use crate::spec::limits::read_text;
use std::ops::Range;
use std::path::{Component, Path, PathBuf};
use toml::Spanned;
use toml::de::{DeTable, DeValue};
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

/// The keys and items of a file.
pub(super) fn parse(file: &SourceFile) -> Result<Spanned<DeTable<'_>>, SpecError> {
    file.source().syntax()
}

/// Reads all files that a text extends; the text itself is the first, and each extends the one behind it.
pub(super) fn load(name: &str, text: &str, mut place: Place) -> Result<Vec<SourceFile>, SpecError> {
    let mut seen = vec![place.identity(name)];
    let mut files = vec![SourceFile { name: name.to_string(), text: text.to_string(), note: String::new() }];
    let mut extended_by = Vec::new();
    while let Some((target, span)) = files.last().map(extends).transpose()?.flatten() {
        let last = files.last().map(SourceFile::source).unwrap_or(Source::new(name, text));
        let wrong = |message: String| last.error(span.clone(), message);
        let (file, text, next) = open(&place, &target).map_err(|e| match e {
            Refusal::Target(message) => wrong(message),
            Refusal::Base(error) => error,
        })?;
        if seen.contains(&next.identity(&file)) {
            return Err(wrong(format!("`{target}` extends itself")));
        }
        if files.len() == MAX_FILES {
            return Err(wrong(format!("more than {MAX_FILES} files extend one another")));
        }
        let line = last.line(span.start);
        extended_by.insert(0, format!("{}:{line}", files.last().map_or(name, |f| f.name.as_str())));
        seen.push(next.identity(&file));
        place = next;
        let note = format!(" (extended by {})", extended_by.join(", "));
        files.push(SourceFile { name: file, text, note });
    }
    Ok(files)
}

/// The value of `extends`, with its place.
fn extends(file: &SourceFile) -> Result<Option<(String, Range<usize>)>, SpecError> {
    let document = parse(file)?;
    let Some(value) = document.get_ref().get(EXTENDS) else { return Ok(None) };
    match value.get_ref() {
        DeValue::String(target) => Ok(Some((target.to_string(), value.span()))),
        _ => Err(file.source().error(value.span(), "`extends` must be text")),
    }
}

/// Why a base is not read.
enum Refusal {
    /// It cannot be meant.
    Target(String),
    /// It is there and wrong.
    Base(SpecError),
}

/// Name, text and place of a base.
fn open(from: &Place, target: &str) -> Result<(String, String, Place), Refusal> {
    let refuse = |message: String| Err(Refusal::Target(message));
    if !target.ends_with(".toml") {
        let Some((name, text)) = builtin::EXPERIMENTS.iter().find(|(name, _)| *name == target) else {
            let known = builtin::EXPERIMENTS.iter().map(|(name, _)| *name);
            let short = trackfail_dataset::text::shorten_to(target, 64);
            return refuse(unknown("built-in experiment", &short, known) + " (files end in .toml)");
        };
        return Ok((name.to_string(), text.to_string(), Place::BuiltIn));
    }
    let Place::Folder { folder, root, .. } = from else {
        return refuse("only an experiment that is read from a file can extend a file".to_string());
    };
    let outside = || refuse("`extends` must name a file in the folder of the experiment or below it".into());
    if !Path::new(target).components().all(|part| matches!(part, Component::Normal(_))) {
        return outside();
    }
    let path = folder.join(target);
    let shown = path.display().to_string();
    let file = path.canonicalize().map_err(|e| Refusal::Target(format!("{shown}: {e}")))?;
    // A link could lead anywhere.
    if !file.starts_with(root) || !file.is_file() {
        return outside();
    }
    let text = read_text(&path).map_err(Refusal::Base)?;
    let folder = path.parent().unwrap_or(Path::new("")).to_path_buf();
    Ok((shown, text, Place::Folder { folder, root: root.clone(), file }))
}
