//! Names that an experiment gives: of itself, of tables and figures, of trackers and methods.

use super::error::{Source, SpecError};
use toml::Spanned;
use trackfail_dataset::text;

/// Most characters of a name of one word, and of a label.
const MAX_WORD: usize = 64;
/// Most characters of an experiment's name.
const MAX_EXPERIMENT_NAME: usize = 128;

/// A name that cannot be used.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum NameError {
    /// Name of an experiment.
    #[error("`name` must be words of a-z, 0-9, `-` and `_`, joined by `/`")]
    Experiment,
    /// Name of a table, figure or analysis.
    #[error("`{0}` must be made of a-z, 0-9, `-` and `_`")]
    File(String),
    /// Name of a tracker or method.
    #[error(
        "the name {0:?} must have 1 to 64 characters, none of [ ] = , ; \", for a method no + either, no outer spaces, no \
         control characters, and not begin with - + or @"
    )]
    Label(String),
}

/// Whether a text can be the name of an experiment, and with it the path of its folders.
///
/// # Errors
/// [`NameError::Experiment`].
pub fn check_experiment_name(name: &str) -> Result<(), NameError> {
    if name.len() > MAX_EXPERIMENT_NAME || !name.split('/').all(is_word) {
        return Err(NameError::Experiment);
    }
    Ok(())
}

/// Whether a name is safe as a file name everywhere: `a-z`, `0-9`, `-`, `_`, at most 64 characters.
pub fn is_word(name: &str) -> bool {
    (1..=MAX_WORD).contains(&name.len())
        && name.bytes().all(|b| b.is_ascii_lowercase() || b.is_ascii_digit() || b == b'-' || b == b'_')
}

/// Refuses a name that is not safe as a file name everywhere.
pub(super) fn check_file_name(source: Source<'_>, name: &Spanned<String>) -> Result<(), SpecError> {
    if is_word(name.get_ref()) {
        return Ok(());
    }
    Err(source.error(name.span(), NameError::File(name.get_ref().clone()).to_string()))
}

/// Refuses a name of a tracker that would be misread in tables, claims or file columns.
pub(super) fn check_label(source: Source<'_>, name: &Spanned<String>) -> Result<(), SpecError> {
    check(source, name, "[]=,;\"")
}

/// Refuses a name of a method that would be misread there, or in panels of figures, which join methods by `+`.
pub(super) fn check_method_name(source: Source<'_>, name: &Spanned<String>) -> Result<(), SpecError> {
    check(source, name, "[]=,;+\"")
}

fn check(source: Source<'_>, name: &Spanned<String>, signs: &str) -> Result<(), SpecError> {
    let label = name.get_ref();
    let forbidden = |c: char| signs.contains(c);
    let is_short = label.chars().count() <= MAX_WORD;
    if label.trim() != label || !text::is_name(label) || !is_short || label.contains(forbidden) {
        let error = NameError::Label(text::shorten_to(label, MAX_WORD));
        return Err(source.error(name.span(), error.to_string()));
    }
    Ok(())
}

/// Refuses a name that one of the same list has already.
pub(super) fn check_unique<'k>(
    source: Source<'_>,
    what: &str,
    name: &Spanned<String>,
    mut known: impl Iterator<Item = &'k str>,
) -> Result<(), SpecError> {
    if known.any(|k| k == name.get_ref()) {
        return Err(source.error(name.span(), format!("{what} `{}` is listed twice", name.get_ref())));
    }
    Ok(())
}
