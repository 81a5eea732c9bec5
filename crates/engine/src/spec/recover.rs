//! Reading goes on after an error, without the key or the item that is wrong, so that all errors are told at once.
//!
//! An error that only follows from such a cut is not told: a key that is missing because it was cut, and a rule about a
//! parameter that was.

use super::error::{Errors, MAX_ERRORS, MAX_WORD, Source};
use super::raw_plugin::as_value;
use super::wire;
use serde::Deserialize;
use std::collections::BTreeSet;
use std::ops::Range;
use toml::Spanned;
use toml::de::{DeTable, DeValue, ValueDeserializer};
use trackfail_core::plugin::nearest;
use trackfail_dataset::text::shorten_to;

/// Stand-ins for keys that every file must have and a wrong one lacks.
const IN_PLACE: &str = "schema = 1\nname = \"unnamed\"\ntitle = \"\"\nsuites = {}\ntracker = []\n";

/// Keys and items of a file, as far as they have the right shape.
pub(super) struct Shape {
    pub wire: wire::Experiment,
    /// Keys of the file in which something has been cut.
    pub cut: BTreeSet<String>,
    /// Places of items of lists in which something has been cut, so that they cannot be judged.
    pub items: Vec<Range<usize>>,
}

/// Reads keys and items. What has a wrong shape is cut from the document; `None` when no more can be read.
pub(super) fn read_shape(
    source: Source<'_>,
    document: &mut Spanned<DeTable<'_>>,
    errors: &mut Errors,
) -> Option<Shape> {
    let root = document.span();
    let mut gone: Vec<(Range<usize>, String)> = Vec::new();
    let (mut cut, mut items) = (BTreeSet::new(), Vec::new());
    for _ in 0..2 * MAX_ERRORS {
        let fault = match wire::Experiment::deserialize(ValueDeserializer::from(as_value(document))) {
            Ok(wire) => return Some(Shape { wire, cut, items }),
            Err(fault) => fault,
        };
        let span = fault.span().unwrap_or(root.clone());
        let missing = missing_key(fault.message()).map(str::to_string);
        let follows = |key: &String| gone.iter().any(|(of, k)| *of == span && k == key);
        if missing.as_ref().is_none_or(|key| !follows(key)) {
            errors.push(source.toml(&fault, root.clone()));
        }
        match missing {
            Some(key) if span == root => {
                insert_placeholder(document.get_mut(), &key)?;
                cut.insert(key);
            }
            _ => {
                let removed = remove(document.get_mut(), &root, &span)?;
                cut.insert(removed.top);
                // A misspelled key stands for the one that was meant.
                if let Some(meant) = meant_key(fault.message()) {
                    gone.push((removed.of.clone(), meant.to_string()));
                }
                gone.push((removed.of, removed.key));
                items.extend(removed.item);
            }
        }
    }
    None
}

/// The key that a message of serde misses.
fn missing_key(message: &str) -> Option<&str> {
    message.strip_prefix("missing field `")?.split('`').next()
}

/// The known key that is nearest to the unknown one of a message of serde.
fn meant_key(message: &str) -> Option<&str> {
    let mut words = message.strip_prefix("unknown field ")?.split('`').skip(1).step_by(2);
    let word = words.next()?;
    nearest(&shorten_to(word, MAX_WORD), words)
}

fn insert_placeholder(table: &mut DeTable<'_>, key: &str) -> Option<()> {
    let mut all = DeTable::parse(IN_PLACE).ok()?.into_inner();
    let (key, value) = all.remove_entry(key)?;
    table.insert(Spanned::new(0..0, key.into_inner()), Spanned::new(0..0, value.into_inner()));
    Some(())
}

/// Part that was cut: a key of a table, or an item of a list of tables.
struct Removed {
    /// The key of the file.
    top: String,
    /// Place of the table.
    of: Range<usize>,
    /// The key in it.
    key: String,
    /// Place of the item of a list of the file that it belongs to.
    item: Option<Range<usize>>,
}

/// Cuts the key, the value or the item at exactly this place. `at` is the place of the table.
fn remove(table: &mut DeTable<'_>, at: &Range<usize>, span: &Range<usize>) -> Option<Removed> {
    let is_it = |key: Range<usize>, value: &Spanned<DeValue<'_>>| key == *span || value.span() == *span;
    let whole =
        table.iter().find(|(key, value)| is_it(key.span(), value)).map(|(key, _)| key.get_ref().to_string());
    let whole = whole.or_else(|| {
        let of_list = |value: &DeValue<'_>| matches!(value, DeValue::Array(list) if holds(list, span));
        table.iter().find(|(_, value)| of_list(value.get_ref())).map(|(key, _)| key.get_ref().to_string())
    });
    if let Some(key) = whole {
        table.remove(key.as_str());
        return Some(Removed { top: key.clone(), of: at.clone(), key, item: None });
    }
    for (key, value) in table.iter_mut() {
        let place = value.span();
        let found = match value.get_mut() {
            DeValue::Table(inner) => remove(inner, &place, span),
            DeValue::Array(list) => {
                if list.iter().any(|item| item.get_ref().is_table() && item.span() == *span) {
                    *list = list.iter().filter(|item| item.span() != *span).cloned().collect();
                    let key = key.get_ref().to_string();
                    return Some(Removed { top: key.clone(), of: place, key, item: None });
                }
                list.iter_mut().find_map(|item| {
                    let place = item.span();
                    match item.get_mut() {
                        DeValue::Table(inner) => {
                            let found = remove(inner, &place, span)?;
                            Some(Removed { item: Some(place), ..found })
                        }
                        _ => None,
                    }
                })
            }
            _ => None,
        };
        if let Some(found) = found {
            return Some(Removed { top: key.get_ref().to_string(), ..found });
        }
    }
    None
}

/// Whether a list, or one in it, has a value other than a table at exactly this place.
fn holds(list: &[Spanned<DeValue<'_>>], span: &Range<usize>) -> bool {
    list.iter().any(|item| match item.get_ref() {
        DeValue::Table(_) => false,
        DeValue::Array(inner) => item.span() == *span || holds(inner, span),
        _ => item.span() == *span,
    })
}

#[cfg(test)]
mod tests;
