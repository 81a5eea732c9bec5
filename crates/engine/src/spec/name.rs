//! Rules for names in an experiment: of itself, tables and figures, trackers and methods.

use super::error::At;
use trackfail_dataset::text;

/// Longest word and longest label, in characters.
const MAX_WORD: usize = 64;
/// Longest name of an experiment, in characters.
const MAX_EXPERIMENT_NAME: usize = 128;

/// Checks that a text can be the name of an experiment, which is also the path of its folders.
///
/// # Errors
/// A message about what a name is.
pub fn check_experiment_name(name: &str) -> Result<(), &'static str> {
    let is_right = name.len() <= MAX_EXPERIMENT_NAME && name.split('/').all(is_word);
    is_right.then_some(()).ok_or("`name` must be words of a-z, 0-9, `-` and `_`, joined by `/`")
}

/// True if a name is safe as a file name on all systems: `a-z`, `0-9`, `-`, `_`, at most 64 characters.
pub fn is_word(name: &str) -> bool {
    (1..=MAX_WORD).contains(&name.len())
        && name.bytes().all(|b| b.is_ascii_lowercase() || b.is_ascii_digit() || b == b'-' || b == b'_')
}

/// Reports a name that is not safe as a file name on all systems.
pub(super) fn check_file_name(at: At<'_>, name: &str) {
    if !is_word(name) {
        at.tell(format!("`{name}` must be made of a-z, 0-9, `-` and `_`"));
    }
}

/// Reports the name of a tracker or a method that could be misread in tables, claims or file columns. Panels of
/// figures join methods by `+`.
pub(super) fn check_label(at: At<'_>, label: &str, is_method: bool) {
    let is_short = label.chars().count() <= MAX_WORD;
    let is_forbidden = label.contains(|c: char| "[]=,;\"".contains(c) || (is_method && c == '+'));
    if label.trim() != label || !text::is_name(label) || !is_short || is_forbidden {
        at.tell(format!(
            "the name {:?} must have 1 to 64 characters, none of [ ] = , ; \", for a method no + either, no outer spaces, \
             no control characters, and not begin with - + or @",
            text::shorten_to(label, MAX_WORD)
        ));
    }
}

/// Items of a list with their places. Reports a name that an earlier item already has.
pub(super) fn named<'a, 'i, T>(
    at: At<'a>,
    what: &'static str,
    items: &'i [T],
    name: fn(&T) -> &String,
) -> impl Iterator<Item = (At<'a>, &'i T)> {
    items.iter().enumerate().map(move |(k, item)| {
        if items[..k].iter().any(|other| name(other) == name(item)) {
            at.item(k).key("name").tell(format!("{what} `{}` is listed twice", name(item)));
        }
        (at.item(k), item)
    })
}
