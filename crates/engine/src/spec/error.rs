//! Errors of experiment files: file, line with a mark below the wrong part, and the nearest valid word.

mod excerpt;

use serde::Deserialize;
use std::cell::RefCell;
use std::ops::Range;
use toml::Spanned;
use toml::de::{DeTable, DeValue, ValueDeserializer};
use trackfail_core::plugin::unknown;
use trackfail_dataset::text::{line_of, shorten_to};

/// First error of an experiment file, with all others.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub struct SpecError {
    /// File, as the user named it.
    pub file: String,
    /// Line, from 1.
    pub line: usize,
    /// Words for the mistake, and for what would be valid.
    pub message: String,
    /// Line of the file and a mark below the wrong place, as two lines; empty if no place is known.
    pub excerpt: String,
    /// All other errors of the experiment.
    pub others: Vec<SpecError>,
}

impl SpecError {
    /// Error of a file as a whole.
    pub(super) fn of_file(file: String, message: String) -> Self {
        Self { file, line: 1, message, excerpt: String::new(), others: Vec::new() }
    }
}

/// Most errors that are shown at once.
const MAX_ERRORS: usize = 20;
/// Most errors that are counted.
pub(super) const MAX_KEPT: usize = 1000;

impl std::fmt::Display for SpecError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let others = &self.others;
        if !others.is_empty() {
            writeln!(f, "{}: {} errors", self.file, 1 + others.len())?;
        }
        let shown = |Self { file, line, message, excerpt, .. }: &Self| {
            let end = if excerpt.is_empty() { "" } else { "\n" };
            format!("{file}:{line}: {message}{end}{excerpt}")
        };
        let all: Vec<String> = std::iter::once(self).chain(others).take(MAX_ERRORS).map(shown).collect();
        f.write_str(&all.join("\n"))?;
        match (1 + others.len()).saturating_sub(MAX_ERRORS) {
            0 => Ok(()),
            more => write!(f, "\nand {more} more"),
        }
    }
}

/// Errors collected while reading goes on, so that all are shown at once.
#[derive(Default)]
pub(super) struct Errors(RefCell<Vec<SpecError>>);

impl Errors {
    /// Adds an error, unless it is already there.
    pub fn push(&self, error: SpecError) {
        let mut all = self.0.borrow_mut();
        if all.len() < MAX_KEPT && !all.contains(&error) {
            all.push(error);
        }
    }

    /// Returns the value if there are no errors. A missing value must have been reported.
    ///
    /// # Errors
    /// The first error in the order of the files, with the others attached.
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
        first.others = all.collect();
        Err(first)
    }
}

/// A value of a file, with its place and the list of errors of the file.
#[derive(Clone, Copy)]
pub(super) struct At<'a> {
    source: Source<'a>,
    value: &'a Spanned<DeValue<'a>>,
    errors: &'a Errors,
}

impl<'a> At<'a> {
    /// Value of a source, with its place.
    pub fn new(source: Source<'a>, value: &'a Spanned<DeValue<'a>>, errors: &'a Errors) -> Self {
        Self { source, value, errors }
    }

    /// Value of a key; the table itself if it lacks the key.
    pub fn key(self, key: &str) -> Self {
        let value = self.value.get_ref().as_table().and_then(|table| table.get(key));
        Self { value: value.unwrap_or(self.value), ..self }
    }

    /// Item of a list; the value itself if there is no such item.
    pub fn item(self, index: usize) -> Self {
        let value = self.value.get_ref().as_array().and_then(|list| list.get(index));
        Self { value: value.unwrap_or(self.value), ..self }
    }

    /// True if the value is a table with this key.
    pub fn has(self, key: &str) -> bool {
        self.value.get_ref().as_table().is_some_and(|table| table.contains_key(key))
    }

    /// True if the file has no errors so far.
    pub fn is_fine(self) -> bool {
        self.errors.0.borrow().is_empty()
    }

    /// Reports an error at this value.
    pub fn tell(self, message: impl Into<String>) {
        self.errors.push(self.source.error(self.value.span(), message));
    }

    /// Reports an error at this value, and is what is then read from it.
    pub fn refuse<T>(self, message: impl Into<String>) -> Option<T> {
        self.tell(message);
        None
    }

    /// Reports a word that is not among the known ones.
    pub fn tell_unknown<'k>(self, what: &str, word: &str, known: impl IntoIterator<Item = &'k str>) {
        self.tell(unknown(what, &shorten_to(word, MAX_WORD), known));
    }

    /// True if a word is among the known ones; another word is reported.
    pub fn knows<'k>(self, what: &str, word: &str, known: impl IntoIterator<Item = &'k str>) -> bool {
        let known: Vec<&str> = known.into_iter().collect();
        let is_known = known.contains(&word);
        if !is_known {
            self.tell_unknown(what, word, known);
        }
        is_known
    }

    /// Reports an error in a part of the text of this value.
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

    /// Deserializes the value, whose shape has been checked.
    pub fn read<T: Deserialize<'a>>(self) -> Option<T> {
        let read = T::deserialize(ValueDeserializer::from(self.value.clone()));
        let tell = |e: toml::de::Error| {
            self.errors.push(self.source.error(e.span().unwrap_or(self.value.span()), e.message()));
        };
        read.map_err(tell).ok()
    }
}

/// Longest quoted word and longest message, in characters. The search for the nearest word would be slow for
/// longer ones.
pub(super) const MAX_WORD: usize = 64;
const MAX_MESSAGE: usize = 2000;

/// Files that are being read, of which each extends the next. It converts byte ranges to lines of files.
///
/// The files share one range of byte positions, so that the position of a value tells its file. The text of
/// each file starts after the end of the file that extends it; the positions before are blank.
#[derive(Clone, Copy)]
pub(super) struct Source<'a>(pub &'a [SourceFile]);

impl<'a> Source<'a> {
    /// File that contains a position.
    fn at(self, place: usize) -> &'a SourceFile {
        self.0.iter().rev().find(|file| file.start <= place).unwrap_or(&self.0[0])
    }

    /// Error at a byte range.
    pub fn error(self, span: Range<usize>, message: impl Into<String>) -> SpecError {
        self.at(span.start).error(span, message)
    }

    /// Text of a byte range; empty if there is none.
    pub fn slice(self, span: Range<usize>) -> &'a str {
        self.at(span.start).text.get(span).unwrap_or_default()
    }

    /// Text of the file of a position, up to the position.
    pub fn before(self, place: usize) -> &'a str {
        self.at(place).text.get(..place).unwrap_or_default()
    }
}

/// A file that is being read.
#[derive(Debug)]
pub struct SourceFile {
    /// Name in messages.
    pub(super) name: String,
    /// Whole text, after blanks up to its start.
    pub(super) text: String,
    /// Text appended to messages about the file: the files that extend it.
    note: String,
    /// Position of the first byte.
    start: usize,
}

impl SourceFile {
    /// A file that no other extends.
    pub fn new(name: &str, text: &str) -> Self {
        let text = text.trim_start_matches('\u{feff}').to_string();
        Self { name: name.to_string(), text, note: String::new(), start: 0 }
    }

    /// A file placed after the one that extends it.
    pub(super) fn after(last: &Self, name: &str, text: &str, note: String) -> Self {
        let mut file = Self { note, start: last.text.len() + 1, ..Self::new(name, text) };
        file.text.insert_str(0, &(" ".repeat(last.text.len()) + "\n"));
        file
    }

    /// Error at a byte range.
    pub fn error(&self, span: Range<usize>, message: impl Into<String>) -> SpecError {
        let start = span.start.clamp(self.start, self.text.len());
        let line = self.line(start);
        let excerpt = excerpt::excerpt(&self.text, line, &(start..span.end.clamp(start, self.text.len())));
        let message = shorten_to(&message.into(), MAX_MESSAGE) + &self.note;
        SpecError { file: self.name.clone(), line, message, excerpt, others: Vec::new() }
    }

    /// Line of a position, from 1.
    fn line(&self, place: usize) -> usize {
        line_of(&self.text.as_bytes()[self.start..], place.saturating_sub(self.start))
    }

    /// `FILE:LINE` of a position.
    pub(super) fn file_and_line(&self, place: usize) -> String {
        format!("{}:{}", self.name, self.line(place))
    }

    /// Converts an error of the TOML parser.
    pub(super) fn toml(&self, e: &toml::de::Error) -> SpecError {
        self.error(e.span().unwrap_or(0..0), e.message())
    }

    /// Keys and values of the text, without those of the files that it extends.
    ///
    /// # Errors
    /// All errors of the TOML parser.
    pub(super) fn syntax(&self) -> Result<Spanned<DeTable<'_>>, SpecError> {
        let (document, wrong) = DeTable::parse_recoverable(&self.text);
        let errors = Errors::default();
        let mut last = 0;
        for error in wrong.iter().take(MAX_ERRORS).map(|fault| self.toml(fault)) {
            // What is told of the rest of a line follows from its first error.
            if error.line != std::mem::replace(&mut last, error.line) {
                errors.push(error);
            }
        }
        errors.or(Some(document))
    }
}
