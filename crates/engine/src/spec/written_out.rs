//! Methods written out: keys taken from a published method, or from the one that they are like.

use super::builtin::METHOD_TABLES;
use super::limits::{MAX_BYTES, MAX_ITEMS};
use std::borrow::Cow;
use std::ops::Range;
use toml::Spanned;
use toml::de::{DeTable, DeValue};

type DeString<'i> = Cow<'i, str>;

/// Completes methods: one without `signal` and `detector` gets those of the published method of its name, and
/// a reading gets those of the method that it is like. Methods without such a model stay unchanged.
///
/// # Errors
/// The place of a method with which the values taken from others get longer than a file may be.
pub(super) fn complete_methods<'i>(document: &mut DeTable<'i>) -> Result<(), Range<usize>> {
    let Some(DeValue::Array(list)) = document.get_mut("method").map(Spanned::get_mut) else { return Ok(()) };
    // Too long a list is refused later.
    if list.len() > MAX_ITEMS {
        return Ok(());
    }
    let mut room = MAX_BYTES;
    let mut known: Vec<(String, DeTable<'i>)> = Vec::new();
    for item in list.iter_mut() {
        let span = item.span();
        let DeValue::Table(table) = item.get_mut() else { continue };
        let text = |key: &str| Some(table.get(key)?.get_ref().as_str()?.to_string());
        let Some(name) = text("name") else { continue };
        let published = |name: &str| {
            let table = METHOD_TABLES.iter().find(|t| t.0 == name)?.1.get_ref();
            Some(placed(table, &span))
        };
        let base = match text("like") {
            Some(like) => {
                known.iter().find(|t| t.0 == like).map(|t| t.1.clone()).or_else(|| published(&like))
            }
            None if table.contains_key("signal") || table.contains_key("detector") => None,
            None => published(&name),
        };
        let taken = |(key, _): &(Spanned<DeString<'i>>, _)| {
            ["signal", "detector", "grid"].contains(&key.get_ref().as_ref())
        };
        for (key, value) in base.into_iter().flatten().filter(taken) {
            let at = value.span();
            room = room.checked_sub(at.len()).ok_or(span.clone())?;
            match (table.get_mut(key.get_ref().as_ref()).map(Spanned::get_mut), value.into_inner()) {
                (None, value) => {
                    table.insert(Spanned::new(span.clone(), key.into_inner()), Spanned::new(at, value));
                }
                (Some(DeValue::Table(mine)), DeValue::Table(its)) if !mine.contains_key("kind") => {
                    for (key, value) in its {
                        mine.entry(key).or_insert(value);
                    }
                }
                _ => {}
            }
        }
        known.push((name, table.clone()));
    }
    Ok(())
}

/// A table of a published method at the place of the method that takes its keys.
fn placed<'i>(table: &DeTable<'static>, span: &Range<usize>) -> DeTable<'i> {
    let of = |(key, value): (&Spanned<DeString<'static>>, &Spanned<DeValue<'static>>)| {
        (Spanned::new(span.clone(), key.get_ref().clone()), placed_value(value, span))
    };
    table.iter().map(of).collect()
}

fn placed_value<'i>(value: &Spanned<DeValue<'static>>, span: &Range<usize>) -> Spanned<DeValue<'i>> {
    let value = match value.get_ref() {
        DeValue::Table(table) => DeValue::Table(placed(table, span)),
        DeValue::Array(list) => DeValue::Array(list.iter().map(|item| placed_value(item, span)).collect()),
        other => other.clone(),
    };
    Spanned::new(span.clone(), value)
}
