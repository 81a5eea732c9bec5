//! Errors of experiment files: the file, the line with a mark below what is wrong, and the nearest valid word.

mod excerpt;

use serde::Deserialize;
use std::cell::RefCell;
use std::ops::Range;
use toml::Spanned;
use toml::de::{DeTable, DeValue, ValueDeserializer};
use trackfail_core::plugin::unknown;
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
pub(super) struct Errors(Vec<SpecError>);

impl Errors {
    /// Keeps an error, each once.
    pub fn push(&mut self, error: SpecError) {
        if self.0.len() < MAX_KEPT && !self.0.contains(&error) {
            self.0.push(error);
        }
    }

    /// Whether nothing is wrong so far.
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// The value, if nothing is wrong; what is wrong has been told where there is none.
    ///
    /// # Errors
    /// The first of the errors in the order of the files, with the others behind it.
    pub fn or<T>(mut self, value: Option<T>) -> Result<T, SpecError> {
        if let (Some(value), true) = (value, self.is_empty()) {
            return Ok(value);
        }
        self.0.sort_by(|a, b| (&a.file, a.line).cmp(&(&b.file, b.line)));
        let mut all = self.0.into_iter();
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
    errors: &'a RefCell<Errors>,
}

impl<'a> At<'a> {
    /// A value of a source.
    pub fn new(source: Source<'a>, value: &'a Spanned<DeValue<'a>>, errors: &'a RefCell<Errors>) -> Self {
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
        self.errors.borrow().is_empty()
    }

    /// Tells what is wrong here.
    pub fn tell(self, message: impl Into<String>) {
        self.errors.borrow_mut().push(self.source.error(self.value.span(), message));
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
        self.errors.borrow_mut().push(self.source.error(place, message));
    }

    /// Reads the value, of which the shape has been checked.
    pub fn read<T: Deserialize<'a>>(self) -> Option<T> {
        let read = T::deserialize(ValueDeserializer::from(self.value.clone()));
        read.map_err(|e| self.errors.borrow_mut().push(self.source.toml(&e, self.value.span()))).ok()
    }
}

/// Longest word of the file and longest message that are shown, in characters. The search for the nearest word
/// takes time and memory that grow with its length.
pub(super) const MAX_WORD: usize = 64;
const MAX_MESSAGE: usize = 2000;

/// A text that is being read, with what turns byte ranges of it into lines of files.
///
/// The text of an experiment and those of the files that it extends share one space of places, so that a value of any of
/// them says itself where it comes from.
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
        let Self { file, text, note, start, .. } = self.at(span.start);
        let inside = |place: usize| place.saturating_sub(start).min(text.len());
        let span = inside(span.start)..inside(span.end).max(inside(span.start));
        let line = line(text, span.start);
        let excerpt = excerpt::excerpt(text, line, &span);
        SpecError {
            file: file.to_string(),
            line,
            message: shorten_to(&message.into(), MAX_MESSAGE) + note,
            below: Box::new(BelowMessage { excerpt, others: Vec::new() }),
        }
    }

    /// `FILE:LINE` of a place.
    pub(super) fn file_and_line(&self, place: usize) -> String {
        let at = self.at(place);
        format!("{}:{}", at.file, line(at.text, place.saturating_sub(at.start)))
    }

    /// A piece of the text, empty where there is none.
    pub(super) fn slice(&self, span: Range<usize>) -> &'a str {
        let at = self.at(span.start);
        let inside = |place: usize| place.checked_sub(at.start);
        let piece = || at.text.get(inside(span.start)?..inside(span.end)?);
        piece().unwrap_or_default()
    }

    /// The text of the file of a place, up to the place.
    pub(super) fn before(&self, place: usize) -> &'a str {
        let at = self.at(place);
        at.text.get(..place - at.start).unwrap_or_default()
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
        let mut errors = Errors::default();
        let mut last = 0;
        for fault in wrong.iter().take(MAX_ERRORS) {
            let error = self.error(moved(fault.span().unwrap_or(0..0), self.start), fault.message());
            // What is told of the rest of a line follows from its first error.
            if error.line != std::mem::replace(&mut last, error.line) {
                errors.push(error);
            }
        }
        let document = errors.or(Some(document))?;
        if self.start == 0 {
            return Ok(document);
        }
        let span = moved(document.span(), self.start);
        Ok(Spanned::new(span, table_moved(document.into_inner(), self.start)))
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

/// Line of a byte, from 1.
fn line(text: &str, position: usize) -> usize {
    1 + text.as_bytes()[..position.min(text.len())].iter().filter(|b| **b == b'\n').count()
}

fn moved(span: Range<usize>, by: usize) -> Range<usize> {
    span.start + by..span.end + by
}

/// A table whose places all lie further behind.
fn table_moved(table: DeTable<'_>, by: usize) -> DeTable<'_> {
    let entries = table.into_iter().map(|(key, value)| {
        let key = Spanned::new(moved(key.span(), by), key.into_inner());
        (key, value_moved(value, by))
    });
    entries.collect()
}

fn value_moved(value: Spanned<DeValue<'_>>, by: usize) -> Spanned<DeValue<'_>> {
    let span = moved(value.span(), by);
    let value = match value.into_inner() {
        DeValue::Table(table) => DeValue::Table(table_moved(table, by)),
        DeValue::Array(list) => DeValue::Array(list.into_iter().map(|item| value_moved(item, by)).collect()),
        plain => plain,
    };
    Spanned::new(span, value)
}

/// A file of a chain in which each extends the next.
#[derive(Debug)]
pub(super) struct SourceFile {
    /// Name in messages.
    pub name: String,
    /// The whole text.
    pub text: String,
    /// Text that messages about the file end with: the files that extend it.
    pub note: String,
    /// Place of its first byte, behind all of the file that extends it.
    pub start: usize,
}

impl SourceFile {
    /// The text for reading it.
    pub fn source(&self) -> Source<'_> {
        Source { file: &self.name, text: &self.text, note: &self.note, start: self.start, bases: &[] }
    }
}
