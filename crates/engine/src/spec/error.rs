//! Errors of experiment files: the file, the line with a mark below what is wrong, and the nearest valid word.

mod excerpt;

use serde::Deserialize;
use std::cell::RefCell;
use std::ops::Range;
use toml::Spanned;
use toml::de::{DeTable, DeValue, ValueDeserializer};
use trackfail_core::plugin::unknown;
use trackfail_dataset::text::shorten_to;

/// The first error of an experiment file, with all others.
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
const MAX_ERRORS: usize = 20;
/// Largest number of errors that are counted.
pub(super) const MAX_KEPT: usize = 1000;

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
pub(super) struct Errors(RefCell<Vec<SpecError>>);

impl Errors {
    /// Keeps an error, each once.
    pub fn push(&self, error: SpecError) {
        let mut all = self.0.borrow_mut();
        if all.len() < MAX_KEPT && !all.contains(&error) {
            all.push(error);
        }
    }

    /// Whether nothing is wrong so far.
    pub fn is_empty(&self) -> bool {
        self.0.borrow().is_empty()
    }

    /// The value, if nothing is wrong; what is wrong has been told where there is none.
    ///
    /// # Errors
    /// The first of the errors in the order of the files, with the others behind it.
    pub fn or<T>(self, value: Option<T>) -> Result<T, SpecError> {
        let mut all = self.0.into_inner();
        if let (Some(value), true) = (value, all.is_empty()) {
            return Ok(value);
        }
        all.sort_by(|a, b| (&a.file, a.line).cmp(&(&b.file, b.line)));
        let mut all = all.into_iter();
        let first = all.next();
        let mut first =
            first.unwrap_or_else(|| SpecError::of_file(String::new(), "cannot be read".to_string()));
        first.below.others = all.collect();
        Err(first)
    }
}

/// A value of a file: where it stands, and the list of what is wrong with the file.
#[derive(Clone, Copy)]
pub(super) struct At<'a> {
    source: Source<'a>,
    value: &'a Spanned<DeValue<'a>>,
    errors: &'a Errors,
}

impl<'a> At<'a> {
    /// A value of a source.
    pub fn new(source: Source<'a>, value: &'a Spanned<DeValue<'a>>, errors: &'a Errors) -> Self {
        Self { source, value, errors }
    }

    /// The value of a key; the table itself where it has none.
    pub fn key(self, key: &str) -> Self {
        let value = self.value.get_ref().as_table().and_then(|table| table.get(key));
        Self { value: value.unwrap_or(self.value), ..self }
    }

    /// An item of a list; the value itself where it is none.
    pub fn item(self, index: usize) -> Self {
        let value = self.value.get_ref().as_array().and_then(|list| list.get(index));
        Self { value: value.unwrap_or(self.value), ..self }
    }

    /// Whether it is a table with a key.
    pub fn has(self, key: &str) -> bool {
        self.value.get_ref().as_table().is_some_and(|table| table.contains_key(key))
    }

    /// Whether nothing is wrong with the file so far.
    pub fn is_fine(self) -> bool {
        self.errors.is_empty()
    }

    /// Tells what is wrong here.
    pub fn tell(self, message: impl Into<String>) {
        self.errors.push(self.source.error(self.value.span(), message));
    }

    /// Tells that a word is not among the known ones.
    pub fn tell_unknown<'k>(self, what: &str, word: &str, known: impl IntoIterator<Item = &'k str>) {
        self.tell(unknown(what, &shorten_to(word, MAX_WORD), known));
    }

    /// Tells what is wrong with a part of the text that stands here.
    pub fn tell_part(self, text: &str, part: Option<Range<usize>>, message: String) {
        let span = self.value.span();
        // The words of a text with escapes are elsewhere in the file.
        let start = self.source.slice(span.clone()).find(text).map(|start| span.start + start);
        let place = match (start, part) {
            (Some(start), Some(part)) => start + part.start..start + part.end,
            _ => span,
        };
        self.errors.push(self.source.error(place, message));
    }

    /// Reads the value, of which the shape has been checked.
    pub fn read<T: Deserialize<'a>>(self) -> Option<T> {
        let read = T::deserialize(ValueDeserializer::from(self.value.clone()));
        read.map_err(|e| self.errors.push(self.source.toml(&e, self.value.span()))).ok()
    }
}

/// Longest word of the file and longest message that are shown, in characters. The search for the nearest word
/// takes time and memory that grow with its length.
pub(super) const MAX_WORD: usize = 64;
const MAX_MESSAGE: usize = 2000;

/// A text that is being read, with what turns byte ranges of it into lines of files.
///
/// An experiment and the files that it extends share one space of places, so that a value of any of them says itself
/// where it comes from: the text of each begins behind all of the file that extends it, and is blank before.
#[derive(Clone, Copy)]
pub struct Source<'a> {
    file: &'a str,
    text: &'a str,
    /// Text that every message ends with.
    note: &'a str,
    /// Place of the first byte.
    start: usize,
    /// The files that it extends, by rising start.
    bases: &'a [SourceFile],
}

impl<'a> Source<'a> {
    /// The whole text of one file; `file` names it in messages.
    pub fn new(file: &'a str, text: &'a str) -> Self {
        Self { file, text, note: "", start: 0, bases: &[] }
    }

    /// The first of several files, each of which extends the one behind it.
    pub(super) fn first_of(files: &'a [SourceFile]) -> Self {
        match files {
            [first, bases @ ..] => Self { bases, ..first.source() },
            [] => Self::new("", ""),
        }
    }

    /// The file in which a place is.
    fn at(self, place: usize) -> Self {
        let base = self.bases.iter().rev().find(|file| file.start <= place);
        base.map_or(Self { bases: &[], ..self }, SourceFile::source)
    }

    /// An error at a byte range.
    pub fn error(&self, span: Range<usize>, message: impl Into<String>) -> SpecError {
        let at = self.at(span.start);
        let start = span.start.clamp(at.start, at.text.len());
        let line = at.line(start);
        let excerpt = excerpt::excerpt(at.text, line, &(start..span.end.clamp(start, at.text.len())));
        SpecError {
            file: at.file.to_string(),
            line,
            message: shorten_to(&message.into(), MAX_MESSAGE) + at.note,
            below: Box::new(BelowMessage { excerpt, others: Vec::new() }),
        }
    }

    /// Line of a place in this file, from 1.
    fn line(&self, place: usize) -> usize {
        let before = self.text.as_bytes().get(self.start..place).unwrap_or_default();
        1 + before.iter().filter(|b| **b == b'\n').count()
    }

    /// `FILE:LINE` of a place in this file.
    pub(super) fn file_and_line(&self, place: usize) -> String {
        format!("{}:{}", self.file, self.line(place))
    }

    /// A piece of the text, empty where there is none.
    pub(super) fn slice(&self, span: Range<usize>) -> &'a str {
        self.at(span.start).text.get(span).unwrap_or_default()
    }

    /// The text of the file of a place, up to the place.
    pub(super) fn before(&self, place: usize) -> &'a str {
        self.at(place).text.get(..place).unwrap_or_default()
    }

    /// An error of the TOML reader.
    pub fn toml(&self, e: &toml::de::Error, fallback: Range<usize>) -> SpecError {
        self.error(e.span().unwrap_or(fallback), e.message())
    }

    /// The keys and values of the text, without those of its bases.
    ///
    /// # Errors
    /// Everything that the TOML reader does not understand.
    pub(super) fn syntax(&self) -> Result<Spanned<DeTable<'a>>, SpecError> {
        let (document, wrong) = DeTable::parse_recoverable(self.text);
        let errors = Errors::default();
        let mut last = 0;
        for fault in wrong.iter().take(MAX_ERRORS) {
            let error = self.toml(fault, 0..0);
            // What is told of the rest of a line follows from its first error.
            if error.line != std::mem::replace(&mut last, error.line) {
                errors.push(error);
            }
        }
        errors.or(Some(document))
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

/// A file of a chain in which each extends the next.
#[derive(Debug)]
pub(super) struct SourceFile {
    /// Name in messages.
    pub name: String,
    /// The whole text, behind blanks up to its place.
    text: String,
    /// Text that messages about the file end with: the files that extend it.
    note: String,
    /// Place of its first byte.
    start: usize,
}

impl SourceFile {
    /// A file behind the one that extends it, if there is one.
    pub fn new(name: String, text: &str, note: String, behind: Option<&Self>) -> Self {
        let blanks = behind.map_or(String::new(), |file| " ".repeat(file.text.len()) + "\n");
        let start = blanks.len();
        Self { name, text: blanks + text.trim_start_matches('\u{feff}'), note, start }
    }

    /// The text for reading it.
    pub fn source(&self) -> Source<'_> {
        Source { file: &self.name, text: &self.text, note: &self.note, start: self.start, bases: &[] }
    }
}
