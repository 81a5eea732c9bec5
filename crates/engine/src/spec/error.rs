//! Errors of experiment files: the file, the line, what is wrong and the nearest valid word.

use crate::dataset::text::shorten_to;
use crate::plugin::{ParamError, nearest, unknown};
use std::ops::Range;
use toml::Spanned;
use toml::de::DeTable;

/// The first thing that is wrong with an experiment file.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{file}:{line}: {message}")]
pub struct SpecError {
    /// The file as the user named it.
    pub file: String,
    /// Line, from 1.
    pub line: usize,
    /// Explanation of the error, with what is valid instead.
    pub message: String,
}

/// Longest word of the file and longest message that are shown, in characters. The search for the nearest word
/// takes time and memory that grow with its length.
const MAX_WORD: usize = 64;
const MAX_MESSAGE: usize = 2000;

/// A text that is being read, with what turns byte ranges of it into lines of files.
#[derive(Clone, Copy)]
pub struct Source<'a> {
    file: &'a str,
    text: &'a str,
    /// Text that every message ends with.
    note: &'a str,
    map: Option<&'a SourceMap>,
}

impl<'a> Source<'a> {
    /// The whole text of one file; `file` names it in messages.
    pub fn new(file: &'a str, text: &'a str) -> Self {
        Self { file, text, note: "", map: None }
    }

    /// A text that was put together from several files.
    pub(super) fn merged(file: &'a str, text: &'a str, map: &'a SourceMap) -> Self {
        Self { file, text, note: "", map: Some(map) }
    }

    /// An error at a byte range.
    pub fn error(&self, span: Range<usize>, message: impl Into<String>) -> SpecError {
        let start = span.start.min(self.text.len());
        let message = shorten_to(&message.into(), MAX_MESSAGE);
        match self.map {
            Some(map) => map.error(start, message),
            None => SpecError {
                file: self.file.to_string(),
                line: self.line(start),
                message: message + self.note,
            },
        }
    }

    /// Line of a byte, from 1; of a text of one file.
    pub(super) fn line(&self, position: usize) -> usize {
        1 + self.text.as_bytes()[..position.min(self.text.len())].iter().filter(|b| **b == b'\n').count()
    }

    /// A piece of the text, empty where there is none.
    pub(super) fn slice(&self, span: Range<usize>) -> &'a str {
        self.text.get(span).unwrap_or_default()
    }

    /// An error of the TOML reader, with the nearest valid word for unknown ones.
    pub fn toml(&self, e: &toml::de::Error, fallback: Range<usize>) -> SpecError {
        self.error(e.span().unwrap_or(fallback), with_hint(e.message()))
    }

    /// An error of a plugin's parameters, at the parameter where the plugin names one.
    pub fn params(&self, e: &ParamError, table: &Spanned<DeTable<'_>>) -> SpecError {
        let named = || table.get_ref().get_key_value(e.key?).map(|(key, _)| key.span());
        let span = e.span.clone().or_else(named).unwrap_or_else(|| table.span());
        self.error(span, with_hint(&e.message))
    }

    /// An unknown word among known ones.
    pub fn unknown<'k>(
        &self,
        span: Range<usize>,
        what: &str,
        word: &str,
        known: impl IntoIterator<Item = &'k str>,
    ) -> SpecError {
        self.error(span, unknown(what, &shorten_to(word, MAX_WORD), known))
    }
}

/// A file that a merged text was made from.
#[derive(Debug)]
pub(super) struct SourceFile {
    /// Name in messages.
    pub name: String,
    /// The whole text.
    pub text: String,
    /// Text that messages about the file end with: the files that extend it.
    pub note: String,
}

impl SourceFile {
    /// The text for reading it.
    pub fn source(&self) -> Source<'_> {
        Source { file: &self.name, text: &self.text, note: &self.note, map: None }
    }
}

/// Says from which line of which file each piece of a merged text comes.
#[derive(Debug)]
pub(super) struct SourceMap {
    /// The files.
    pub files: Vec<SourceFile>,
    /// The pieces, by rising start.
    pub pieces: Vec<Piece>,
}

/// A piece of a merged text, up to the start of the next one.
#[derive(Debug)]
pub(super) struct Piece {
    /// First byte in the merged text.
    pub start: usize,
    /// The file, an index into [`SourceMap::files`].
    pub file: usize,
    /// Byte of the file that it begins with, or belongs to.
    pub origin: usize,
    /// Whether it is a copy of what the file has there.
    pub copied: bool,
}

impl SourceMap {
    fn error(&self, position: usize, message: String) -> SpecError {
        let after = self.pieces.partition_point(|piece| piece.start <= position);
        let Some(piece) = self.pieces.get(after.saturating_sub(1)) else {
            return SpecError { file: String::new(), line: 1, message };
        };
        let offset = if piece.copied { position - piece.start } else { 0 };
        let place = piece.origin + offset;
        self.files[piece.file].source().error(place..place, message)
    }
}

/// serde names the unknown word first and the valid ones after it, all in backticks.
fn with_hint(message: &str) -> String {
    if !message.starts_with("unknown ") {
        return message.to_string();
    }
    let words: Vec<&str> = message.split('`').skip(1).step_by(2).collect();
    let Some((word, known)) = words.split_first() else { return message.to_string() };
    let short = shorten_to(word, MAX_WORD);
    let message = message.replacen(*word, &short, 1);
    match nearest(&short, known.iter().copied()) {
        Some(near) => format!("{message}; did you mean `{near}`?"),
        None => message,
    }
}
