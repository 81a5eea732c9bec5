//! Errors of experiment files: what is wrong, in which file and line, and the nearest right word.

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
    /// What is wrong and what would be right.
    pub message: String,
}

/// Longest word of the file and longest message that are shown, in characters. Distances between words
/// take time and memory that grow with their length, so only this much of one is looked at.
const LONGEST_WORD: usize = 64;
const LONGEST_MESSAGE: usize = 2000;

/// A text being read, for turning byte ranges into lines.
#[derive(Clone, Copy)]
pub struct Source<'a> {
    /// Name for messages.
    pub file: &'a str,
    /// The whole text.
    pub text: &'a str,
}

impl Source<'_> {
    /// An error at a byte range.
    pub fn error(&self, span: Range<usize>, message: impl Into<String>) -> SpecError {
        let start = span.start.min(self.text.len());
        let line = 1 + self.text.as_bytes()[..start].iter().filter(|b| **b == b'\n').count();
        let message = shorten_to(&message.into(), LONGEST_MESSAGE);
        SpecError { file: self.file.to_string(), line, message }
    }

    /// An error of the TOML reader, with the nearest valid word for unknown ones.
    pub fn toml(&self, e: &toml::de::Error, fallback: Range<usize>) -> SpecError {
        self.error(e.span().unwrap_or(fallback), with_hint(e.message()))
    }

    /// An error of a plugin's parameters: blamed on the parameter where the plugin names one.
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
        self.error(span, unknown(what, &shorten_to(word, LONGEST_WORD), known))
    }
}

/// serde names the unknown word first and the valid ones after it, all in backticks.
fn with_hint(message: &str) -> String {
    if !message.starts_with("unknown ") {
        return message.to_string();
    }
    let words: Vec<&str> = message.split('`').skip(1).step_by(2).collect();
    let Some((word, known)) = words.split_first() else { return message.to_string() };
    let short = shorten_to(word, LONGEST_WORD);
    let message = message.replacen(*word, &short, 1);
    match nearest(&short, known.iter().copied()) {
        Some(near) => format!("{message}; did you mean `{near}`?"),
        None => message,
    }
}
