//! Errors of experiment files: the file, the line with a mark below what is wrong, and the nearest valid word.

mod excerpt;
mod plain_words;

pub(super) use plain_words::{FIRST_NUMBER, in_plain_words};

use std::ops::Range;
use toml::Spanned;
use toml::de::DeTable;
use trackfail_core::plugin::{ParamError, nearest, unknown};
use trackfail_dataset::text::shorten_to;

/// What is wrong with an experiment file: one thing, and what else was found behind it.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub struct SpecError {
    /// The file as the user named it.
    pub file: String,
    /// Line, from 1.
    pub line: usize,
    /// Explanation of the error, with what is valid instead.
    pub message: String,
    /// Lines below the message.
    pub below: Box<BelowMessage>,
}

/// Lines below the message of an error.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct BelowMessage {
    /// The line of the file and a mark below the place, on two lines; empty where there is none.
    pub excerpt: String,
    /// Everything else that is wrong with the experiment.
    pub others: Vec<SpecError>,
}

impl SpecError {
    /// An error of a whole file.
    pub(super) fn of_file(file: String, message: String) -> Self {
        Self { file, line: 1, message, below: Box::default() }
    }
}

/// Largest number of errors that are told at once.
pub(super) const MAX_ERRORS: usize = 20;

impl std::fmt::Display for SpecError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let others = &self.below.others;
        if !others.is_empty() {
            writeln!(f, "{}: {} errors", self.file, 1 + others.len())?;
        }
        for (k, error) in std::iter::once(self).chain(others).take(MAX_ERRORS).enumerate() {
            let Self { file, line, message, below } = error;
            let excerpt = &below.excerpt;
            if k > 0 {
                writeln!(f)?;
            }
            write!(f, "{file}:{line}: {message}")?;
            if !excerpt.is_empty() {
                write!(f, "\n{excerpt}")?;
            }
        }
        match (1 + others.len()).saturating_sub(MAX_ERRORS) {
            0 => Ok(()),
            more => write!(f, "\nand {more} more"),
        }
    }
}

/// Errors of a reading that goes on after them, so that all are told at once.
#[derive(Default)]
pub(super) struct Errors(Vec<SpecError>);

impl Errors {
    /// Keeps an error, and those behind it, each once.
    pub fn push(&mut self, mut error: SpecError) {
        let others = std::mem::take(&mut error.below.others);
        for error in std::iter::once(error).chain(others) {
            if !self.0.contains(&error) {
                self.0.push(error);
            }
        }
    }

    /// The value of a part that is right; of one that is wrong, the error is kept.
    pub fn keep<T>(&mut self, read: Result<T, SpecError>) -> Option<T> {
        read.map_err(|error| self.push(error)).ok()
    }

    /// The values of a list.
    ///
    /// # Errors
    /// Those of all values that are wrong.
    pub fn collect<T>(list: impl IntoIterator<Item = Result<T, SpecError>>) -> Result<Vec<T>, SpecError> {
        let mut errors = Self::default();
        let values = list.into_iter().filter_map(|read| errors.keep(read)).collect();
        errors.check().map(|()| values)
    }

    /// Whether nothing is wrong so far.
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// Whether there are as many errors as are told.
    pub fn is_full(&self) -> bool {
        self.0.len() >= MAX_ERRORS
    }

    /// Success if nothing is wrong.
    ///
    /// # Errors
    /// All errors, in the order of the files.
    pub fn check(self) -> Result<(), SpecError> {
        if self.is_empty() { Ok(()) } else { Err(self.first()) }
    }

    /// The first of the errors in the order of the files, with the others behind it. For places where something is wrong.
    pub fn first(mut self) -> SpecError {
        self.0.sort_by(|a, b| (&a.file, a.line).cmp(&(&b.file, b.line)));
        let mut all = self.0.into_iter();
        let first = all.next();
        let mut first =
            first.unwrap_or_else(|| SpecError::of_file(String::new(), "cannot be read".to_string()));
        first.below.others = all.collect();
        first
    }
}

/// Longest word of the file and longest message that are shown, in characters. The search for the nearest word
/// takes time and memory that grow with its length.
pub(super) const MAX_WORD: usize = 64;
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
        let span = start..span.end.clamp(start, self.text.len());
        let message = shorten_to(&message.into(), MAX_MESSAGE);
        match self.map {
            Some(map) => map.error(span, message),
            None => {
                let line = self.line(start);
                SpecError {
                    file: self.file.to_string(),
                    line,
                    message: message + self.note,
                    below: Box::new(BelowMessage {
                        excerpt: excerpt::excerpt(self.text, line, &span),
                        others: Vec::new(),
                    }),
                }
            }
        }
    }

    /// The key whose value begins at a byte, where it stands right before it.
    pub(super) fn key_of(&self, value: usize) -> Option<&'a str> {
        let before = self.text.get(..value)?.trim_end().strip_suffix('=')?.trim_end();
        let is_bare = |c: char| c.is_ascii_alphanumeric() || c == '_' || c == '-';
        let start = before.rfind(|c| !is_bare(c)).map_or(0, |at| at + 1);
        before.get(start..).filter(|key| !key.is_empty())
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
        let span = e.span().unwrap_or(fallback);
        let key = self.key_of(span.start);
        let first =
            || FIRST_NUMBER.iter().find(|(known, _)| Some(*known) == key).map_or(0, |(_, first)| *first);
        let message = in_plain_words(e.message(), key, first);
        self.error(span, message.unwrap_or_else(|| with_hint(e.message())))
    }

    /// Everything that the TOML reader does not understand.
    ///
    /// # Errors
    /// At least one of it.
    pub(super) fn syntax(&self) -> Result<Spanned<DeTable<'a>>, SpecError> {
        let (document, wrong) = DeTable::parse_recoverable(self.text);
        let mut errors = Errors::default();
        let mut last = 0;
        for error in wrong.iter().take(MAX_ERRORS).map(|e| self.toml(e, 0..0)) {
            // What is told of the rest of a line follows from its first error.
            if error.line != std::mem::replace(&mut last, error.line) {
                errors.push(error);
            }
        }
        errors.check().map(|()| document)
    }

    /// An error of a plugin's parameters, at the parameter where the plugin names one.
    pub fn params(&self, e: &ParamError, table: &Spanned<DeTable<'_>>) -> SpecError {
        let named = || table.get_ref().get_key_value(e.key?).map(|(_, value)| value.span());
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
    fn error(&self, span: Range<usize>, message: String) -> SpecError {
        let after = self.pieces.partition_point(|piece| piece.start <= span.start);
        let Some(piece) = self.pieces.get(after.saturating_sub(1)) else {
            return SpecError::of_file(String::new(), message);
        };
        let (offset, length) = if piece.copied { (span.start - piece.start, span.len()) } else { (0, 0) };
        let place = piece.origin + offset;
        self.files[piece.file].source().error(place..place + length, message)
    }
}

/// Keys of a file that shorten it: they are written out before the keys are read, so that serde does not know them.
pub(super) const SHORTCUTS: [&str; 4] = ["extends", "without", "tracker-group", "method-group"];

/// serde names the unknown word first and the valid ones after it, all in backticks.
fn with_hint(message: &str) -> String {
    if !message.starts_with("unknown ") {
        return message.to_string();
    }
    let is_of_file = message.contains("expected one of `schema`, ");
    let shortcuts: String = SHORTCUTS.iter().filter(|_| is_of_file).map(|key| format!(", `{key}`")).collect();
    let message = &(message.to_string() + &shortcuts);
    let words: Vec<&str> = message.split('`').skip(1).step_by(2).collect();
    let Some((word, known)) = words.split_first() else { return message.to_string() };
    let short = shorten_to(word, MAX_WORD);
    let message = message.replacen(*word, &short, 1);
    match nearest(&short, known.iter().copied()) {
        Some(near) => format!("{message}; did you mean `{near}`?"),
        None => message,
    }
}
