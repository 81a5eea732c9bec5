//! Names that an experiment gives: of itself, of tables and figures, of trackers and methods.

use super::error::At;
use trackfail_dataset::text;

/// Most characters of a name of one word, and of a label.
const MAX_WORD: usize = 64;
/// Most characters of an experiment's name.
const MAX_EXPERIMENT_NAME: usize = 128;

/// A name that no experiment can have.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error("`name` must be words of a-z, 0-9, `-` and `_`, joined by `/`")]
pub struct NameError;

/// Whether a text can be the name of an experiment, and with it the path of its folders.
///
/// # Errors
/// [`NameError`].
pub fn check_experiment_name(name: &str) -> Result<(), NameError> {
    let is_right = name.len() <= MAX_EXPERIMENT_NAME && name.split('/').all(is_word);
    is_right.then_some(()).ok_or(NameError)
}

/// Whether a name is safe as a file name everywhere: `a-z`, `0-9`, `-`, `_`, at most 64 characters.
pub fn is_word(name: &str) -> bool {
    (1..=MAX_WORD).contains(&name.len())
        && name.bytes().all(|b| b.is_ascii_lowercase() || b.is_ascii_digit() || b == b'-' || b == b'_')
}

/// Refuses a name that is not safe as a file name everywhere.
pub(super) fn check_file_name(at: At<'_>, name: &str) {
    if !is_word(name) {
        at.tell(format!("`{name}` must be made of a-z, 0-9, `-` and `_`"));
    }
}

/// Refuses a name of a tracker that would be misread in tables, claims or file columns.
pub(super) fn check_label(at: At<'_>, name: &str) {
    check(at, name, "[]=,;\"");
}

/// Refuses a name of a method that would be misread there, or in panels of figures, which join methods by `+`.
pub(super) fn check_method_name(at: At<'_>, name: &str) {
    check(at, name, "[]=,;+\"");
}

fn check(at: At<'_>, label: &str, signs: &str) {
    let is_short = label.chars().count() <= MAX_WORD;
    let is_forbidden = label.contains(|c: char| signs.contains(c));
    if label.trim() != label || !text::is_name(label) || !is_short || is_forbidden {
        at.tell(format!(
            "the name {:?} must have 1 to 64 characters, none of [ ] = , ; \", for a method no + either, no outer spaces, \
             no control characters, and not begin with - + or @",
            text::shorten_to(label, MAX_WORD)
        ));
    }
}

/// Refuses a name that an item before it has already.
pub(super) fn check_unique<T>(at: At<'_>, what: &str, items: &[T], index: usize, name: fn(&T) -> &String) {
    let wanted = name(&items[index]);
    if items[..index].iter().any(|item| name(item) == wanted) {
        at.item(index).key("name").tell(format!("{what} `{wanted}` is listed twice"));
    }
}
