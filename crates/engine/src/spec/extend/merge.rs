//! Lays a file over the one it extends.

use super::document::{Document, Entry, Item};
use crate::spec::error::{Source, SpecError};
use std::collections::{BTreeMap, BTreeSet};
use toml::Spanned;
use toml::de::DeValue;

/// The base with what `child` changes, adds and leaves out.
///
/// # Errors
/// `[without]` names what the base does not have.
pub(super) fn merge<'d>(
    mut base: Document<'d>,
    child: Document<'d>,
    source: Source<'_>,
) -> Result<Document<'d>, SpecError> {
    replace(&mut base.keys, child.keys);
    if let Some(suites) = child.suites {
        replace(base.suites.get_or_insert_default(), suites);
    }
    let removed = removed(&base, &child.without, source)?;
    let mut known: BTreeMap<(&str, Vec<&str>), usize> = BTreeMap::new();
    for (index, item) in base.items.iter().enumerate().filter(|(index, _)| !removed.contains(index)) {
        if let Some(name) = item.name() {
            known.entry((item.kind, name)).or_insert(index);
        }
    }
    let last: BTreeMap<&str, usize> =
        base.items.iter().enumerate().map(|(index, item)| (item.kind, index)).collect();
    let mut added: BTreeMap<&str, Vec<Item<'d>>> = BTreeMap::new();
    let mut of_new_kinds = Vec::new();
    for mut item in child.items {
        // The second item of a name in one file finds none to change, and is refused as every name that stands
        // there twice.
        match item.name().and_then(|name| known.remove(&(item.kind, name))) {
            Some(index) => {
                item.entries.retain(|entry| !(item.only_named && entry.key == "name"));
                replace(&mut base.items[index].entries, item.entries);
            }
            None if last.contains_key(item.kind) => added.entry(item.kind).or_default().push(item),
            None => of_new_kinds.push(item),
        }
    }
    let mut items = Vec::new();
    for (index, item) in std::mem::take(&mut base.items).into_iter().enumerate() {
        let kind = item.kind;
        if !removed.contains(&index) {
            items.push(item);
        }
        if last.get(kind) == Some(&index) {
            items.extend(added.remove(kind).unwrap_or_default());
        }
    }
    items.extend(of_new_kinds);
    base.items = items;
    let is_new = |name: &str, key: &str| !child.groups.iter().any(|g| g.name == name && g.kind.key == key);
    base.groups.retain(|group| is_new(group.name, group.kind.key));
    base.groups.extend(child.groups);
    Ok(base)
}

/// Puts entries in the place of those with the same key, and others behind.
fn replace<'d>(known: &mut Vec<Entry<'d>>, with: Vec<Entry<'d>>) {
    let places: BTreeMap<&str, usize> = known.iter().enumerate().map(|(k, entry)| (entry.key, k)).collect();
    for entry in with {
        match places.get(entry.key) {
            Some(&place) => known[place] = entry,
            None => known.push(entry),
        }
    }
}

/// Indices of the items of the base that `without` leaves out.
fn removed(
    base: &Document<'_>,
    without: &[(&str, &Spanned<DeValue<'_>>)],
    source: Source<'_>,
) -> Result<BTreeSet<usize>, SpecError> {
    // Published numbers are left out by the name of their table.
    let mut known: BTreeMap<(&str, &str), Vec<usize>> = BTreeMap::new();
    for (index, item) in base.items.iter().enumerate() {
        if let Some(name) = item.name().and_then(|name| name.first().copied()) {
            known.entry((item.kind, name)).or_default().push(index);
        }
    }
    let mut removed = BTreeSet::new();
    for &(kind, value) in without {
        let word = value.get_ref().as_str().unwrap_or_default();
        let group = base.groups.iter().find(|group| group.kind.kind == kind && group.name == word);
        let names = group.map_or_else(|| vec![word], |group| group.members.clone());
        let found: Vec<usize> =
            names.iter().filter_map(|name| known.get(&(kind, *name))).flatten().copied().collect();
        if found.is_empty() {
            let words = known.keys().filter(|(of, _)| *of == kind).map(|(_, name)| *name);
            return Err(source.unknown(value.span(), &format!("{kind} of the base"), word, words));
        }
        removed.extend(found);
    }
    Ok(removed)
}
