//! Methods written out: with what they take from a published method, or from the one that they are like.

use super::error::{Errors, Source, SpecError};
use std::ops::Range;
use toml::Spanned;
use toml::de::{DeTable, DeValue};

/// Fills in `signal` and `detector` of methods that have neither, from the published method of their name, and of readings
/// from the method that they are like. Those for which there is no such method are given by their places.
pub(super) fn complete_methods<'i>(
    source: Source<'_>,
    document: &mut Spanned<DeTable<'i>>,
    errors: &mut Errors,
) -> Result<Vec<Range<usize>>, SpecError> {
    let mut incomplete = Vec::new();
    let Some(methods) = document.get_mut().get_mut("method") else { return Ok(incomplete) };
    let span = methods.span();
    let DeValue::Array(list) = methods.get_mut() else {
        return Err(source.error(span, "methods are written as [[method]]"));
    };
    let mut known: Vec<(String, DeTable<'i>)> = Vec::new();
    for item in list.iter_mut() {
        let span = item.span();
        let DeValue::Table(table) = item.get_mut() else { continue };
        let Some(name) = table.get("name").and_then(|n| n.get_ref().as_str()).map(str::to_string) else {
            continue;
        };
        if let Some(like) = table.get("like") {
            if errors.keep(complete_reading(source, like.clone(), table, &known)).is_none() {
                incomplete.push(span);
            }
            known.push((name, table.clone()));
            continue;
        }
        if !table.contains_key("signal") && !table.contains_key("detector") {
            let published = super::builtin::method_tables();
            let Some(method) = published.iter().find(|t| t.0 == name) else {
                let names = published.iter().map(|t| t.0.as_str());
                let place = table.get("name").map_or(span.clone(), Spanned::span);
                errors.push(source.unknown(place, "published method", &name, names));
                incomplete.push(span);
                continue;
            };
            for (key, value) in method.1.get_ref() {
                if key.get_ref() != "name" {
                    table.insert(Spanned::new(span.clone(), key.get_ref().clone()), value.clone());
                }
            }
        }
        known.push((name, table.clone()));
    }
    Ok(incomplete)
}

/// Fills in what a reading takes from the method that it is like: one of the `known` ones, or a published one.
fn complete_reading<'i>(
    source: Source<'_>,
    like: Spanned<DeValue<'i>>,
    reading: &mut DeTable<'i>,
    known: &[(String, DeTable<'i>)],
) -> Result<(), SpecError> {
    let Some(name) = like.get_ref().as_str() else {
        return Err(source.error(like.span(), "`like` must be the name of a method"));
    };
    let published = super::builtin::method_tables();
    let of_published = || published.iter().find(|t| t.0 == name).map(|t| t.1.get_ref());
    let Some(base) = known.iter().find(|t| t.0 == name).map(|t| &t.1).or_else(of_published) else {
        let before = known.iter().map(|t| t.0.as_str());
        let names = before.chain(published.iter().map(|t| t.0.as_str()));
        return Err(source.unknown(like.span(), "method before this one", name, names));
    };
    for (key, value) in base {
        if !["signal", "detector", "grid"].contains(&key.get_ref().as_ref()) {
            continue;
        }
        match (reading.get_mut(key.get_ref().as_ref()).map(Spanned::get_mut), value.get_ref()) {
            (None, _) => {
                reading.insert(Spanned::new(like.span(), key.get_ref().clone()), value.clone());
            }
            (Some(DeValue::Table(mine)), DeValue::Table(its)) if !mine.contains_key("kind") => {
                for (key, value) in its {
                    if !mine.contains_key(key.get_ref().as_ref()) {
                        mine.insert(Spanned::new(like.span(), key.get_ref().clone()), value.clone());
                    }
                }
            }
            (Some(_), _) => {}
        }
    }
    Ok(())
}
