//! Experiments that say only what differs: `extends` names another experiment, groups give what several
//! trackers or methods share.
//!
//! [`complete`] puts the values of an experiment together as if nobody had shortened it, each with its place in the
//! file that it comes from, and writes the text that is kept beside the results, so that results stand by themselves.
//!
//! - A key of the file, a suite of `[suites]` and a key of an item replace those of the base.
//! - An item (`[[tracker]]`, `[[method]]`, `[[table]]` ...) whose name the base has changes that one; others
//!   are added behind the base's of their kind. A tracker's name is its label, a claim's its text, that of
//!   published numbers their table, tracker and row.
//! - `[without]` leaves items of the base out: `table = ["counts"]`.
//! - A `[[tracker-group]]` or `[[method-group]]` lists its members and gives the keys they share. Where it has
//!   a `group` of its own, that name stands for all members in every list of trackers or methods.

mod chain;
mod write;

pub(super) use chain::{Place, load};

use super::error::{Source, SourceFile, SpecError};
use super::limits::MAX_BYTES;
use std::collections::{BTreeMap, BTreeSet};
use std::ops::Range;
use toml::Spanned;
use toml::de::{DeArray, DeString, DeTable, DeValue};

/// Key that names the experiment to build on.
const EXTENDS: &str = "extends";
/// Table of what the base has and the experiment has not.
const WITHOUT: &str = "without";
/// Kinds of items, as the file heads them: `[[tracker]]`.
const KINDS: [&str; 7] = ["tracker", "method", "analysis", "table", "figure", "published", "claim"];

/// A kind of group.
struct GroupKind {
    /// Key of the file.
    key: &'static str,
    /// Kind of its members.
    kind: &'static str,
    /// Key of the list of its members, and of lists of them in items of other kinds.
    list: &'static str,
    /// Order in which the keys of a member are written, before all others.
    order: &'static [&'static str],
}

/// All kinds of groups.
const GROUPS: [GroupKind; 2] = [
    GroupKind { key: "tracker-group", kind: "tracker", list: "trackers", order: &["name"] },
    GroupKind {
        key: "method-group",
        kind: "method",
        list: "methods",
        order: &["name", "trackers", "protocol", "signal", "detector", "grid"],
    },
];

/// A key with its value. What a group gives without its standing there has an empty place.
type Entry<'d> = (Spanned<DeString<'d>>, Spanned<DeValue<'d>>);

/// One `[[...]]`.
struct Item<'d> {
    kind: &'static str,
    /// First byte of its heading, or of the heading of the group that it is a member of.
    start: usize,
    /// Where it stands.
    place: Range<usize>,
    /// The comment above its heading.
    comment: Range<usize>,
    entries: Vec<Entry<'d>>,
    /// Whether only its name was given, which may be the label of a tracker of the base.
    only_named: bool,
}

impl Item<'_> {
    /// Key that distinguishes it from the others of its kind.
    fn name(&self) -> Option<Vec<String>> {
        let text = |wanted: &str| {
            let value = self.entries.iter().find(|(key, _)| word(key) == wanted).map(|(_, value)| value);
            value.and_then(|value| value.get_ref().as_str()).map(str::to_string)
        };
        match self.kind {
            "tracker" => text("label").or_else(|| text("name")).map(|name| vec![name]),
            "claim" => text("text").map(|name| vec![name]),
            "published" => ["table", "tracker", "row"].into_iter().map(text).collect(),
            _ => text("name").map(|name| vec![name]),
        }
    }

    fn first_name(&self) -> Option<String> {
        self.name()?.into_iter().next()
    }
}

/// A group with a name.
struct Group {
    name: String,
    span: Range<usize>,
    kind: &'static GroupKind,
    /// Names of the members.
    members: Vec<String>,
}

/// A name in `[without]`, with the kind of the item.
struct LeftOut {
    kind: &'static str,
    name: String,
    span: Range<usize>,
}

/// A file, cut up; or several, laid over one another.
#[derive(Default)]
struct Document<'d> {
    keys: Vec<Entry<'d>>,
    suites: Option<(Range<usize>, Vec<Entry<'d>>)>,
    items: Vec<Item<'d>>,
    groups: Vec<Group>,
    without: Vec<LeftOut>,
}

/// Whether a file needs no other and has no groups.
pub(super) fn is_complete(document: &DeTable<'_>) -> bool {
    let mut shortcuts = [EXTENDS, WITHOUT].into_iter().chain(GROUPS.iter().map(|group| group.key));
    !shortcuts.any(|key| document.contains_key(key))
}

/// Puts together what an experiment and those it extends say; `files` are as [`load`] gives them. The text needs no other
/// file.
///
/// # Errors
/// What is wrong with groups and `[without]`, and more text than an experiment file may have.
pub(super) fn complete(files: &[SourceFile]) -> Result<(String, Spanned<DeTable<'_>>), SpecError> {
    let source = Source::first_of(files);
    let mut room = MAX_BYTES;
    let mut whole: Option<Document<'_>> = None;
    for file in files.iter().rev() {
        let document = cut(source, file.source().syntax()?.into_inner(), &mut room)?;
        whole = Some(match (whole, document.without.first()) {
            (Some(base), _) => merge(source, base, document)?,
            (None, None) => document,
            (None, Some(left_out)) => {
                let message = "[without] is for experiments that extend another";
                return Err(source.error(left_out.span.clone(), message));
            }
        });
    }
    let mut whole = whole.unwrap_or_default();
    name_members(source, &mut whole, &mut room)?;
    let text = write::write(source, &whole);
    if text.len() > MAX_BYTES {
        let message =
            format!("with what it extends and its groups written out, it has more than {MAX_BYTES} bytes");
        return Err(source.error(0..0, message));
    }
    Ok((text, Spanned::new(0..0, table_of(whole))))
}

fn word<'k>(key: &'k Spanned<DeString<'_>>) -> &'k str {
    key.get_ref()
}

/// Entries of a table in the order of the file.
fn entries(table: DeTable<'_>) -> Vec<Entry<'_>> {
    let mut entries: Vec<Entry<'_>> = table.into_iter().collect();
    entries.sort_by_key(|(key, _)| key.span().start);
    entries
}

/// Takes from the `room` for what groups make, so that a small file does not fill the memory.
fn take(room: &mut usize, size: usize, source: Source<'_>, place: &Range<usize>) -> Result<(), SpecError> {
    let message = format!("the groups make more than {MAX_BYTES} bytes of text");
    *room = room.checked_sub(size).ok_or_else(|| source.error(place.clone(), message))?;
    Ok(())
}

/// Cuts a file up.
fn cut<'d>(source: Source<'_>, table: DeTable<'d>, room: &mut usize) -> Result<Document<'d>, SpecError> {
    let mut document = Document::default();
    for (key, value) in entries(table) {
        let (heading, place) = (word(&key).to_string(), value.span());
        let group = GROUPS.iter().find(|group| group.key == heading);
        let kind = KINDS.into_iter().find(|kind| *kind == heading).or(group.map(|group| group.kind));
        match (heading.as_str(), value.into_inner(), kind) {
            (EXTENDS, ..) => {}
            (WITHOUT, value, _) => document.without = read_without(source, place, value)?,
            ("suites", DeValue::Table(suites), _) => document.suites = Some((place, entries(suites))),
            ("suites", ..) => return Err(source.error(place, "`suites` must be a table, such as [suites]")),
            (_, DeValue::Array(list), Some(kind)) => {
                for item in list {
                    let place = item.span();
                    let DeValue::Table(table) = item.into_inner() else {
                        return Err(source.error(place, format!("write [[{heading}]]")));
                    };
                    let (start, comment) = (place.start, comment_above(source, place.start));
                    let entries = entries(table);
                    let item = Item { kind, start, place, comment, entries, only_named: false };
                    match group {
                        Some(group) => expand(source, group, item, &mut document, room)?,
                        None => document.items.push(item),
                    }
                }
            }
            (.., Some(_)) => return Err(source.error(place, format!("write [[{heading}]]"))),
            (_, value, None) => document.keys.push((key, Spanned::new(place, value))),
        }
    }
    document.items.sort_by_key(|item| item.start);
    Ok(document)
}

/// The comment lines right above a heading.
fn comment_above(source: Source<'_>, start: usize) -> Range<usize> {
    let lines = source.before(start).split_inclusive('\n').rev();
    let comment = lines.take_while(|line| line.ends_with('\n') && line.trim_start().starts_with('#'));
    start - comment.map(str::len).sum::<usize>()..start
}

/// Reads `[without]`.
fn read_without(
    source: Source<'_>,
    place: Range<usize>,
    value: DeValue<'_>,
) -> Result<Vec<LeftOut>, SpecError> {
    let DeValue::Table(table) = value else {
        return Err(source.error(place, "`without` must be a table, such as [without]"));
    };
    let mut without = Vec::new();
    for (key, value) in entries(table) {
        let Some(kind) = KINDS.into_iter().find(|kind| *kind == word(&key)) else {
            return Err(source.unknown(key.span(), "kind of items", word(&key), KINDS));
        };
        let name = |name: &Spanned<DeValue<'_>>| {
            let text = name.get_ref().as_str()?.to_string();
            Some(LeftOut { kind, name: text, span: name.span() })
        };
        let names = value.get_ref().as_array().map(|list| list.iter().map(name).collect::<Option<Vec<_>>>());
        let Some(names) = names.flatten() else {
            return Err(source.error(value.span(), format!("`{kind}` must be a list of names")));
        };
        without.extend(names);
    }
    Ok(without)
}

/// Writes a group out: its members with the keys they share.
fn expand<'d>(
    source: Source<'_>,
    kind: &'static GroupKind,
    group: Item<'d>,
    document: &mut Document<'d>,
    room: &mut usize,
) -> Result<(), SpecError> {
    let heading = group.start..group.start;
    let (mut name, mut members, mut shared) = (None, DeArray::new(), Vec::new());
    for (key, value) in group.entries {
        let place = value.span();
        match (word(&key), value.get_ref()) {
            ("group", DeValue::String(word)) => name = Some((word.to_string(), place)),
            ("group", _) => return Err(source.error(place, "`group` must be text")),
            (list, DeValue::Array(all)) if list == kind.list => members = all.clone(),
            (list, _) if list == kind.list => {
                return Err(source.error(place, format!("`{list}` must be a list of names and tables")));
            }
            _ => shared.push((key, value)),
        }
    }
    if members.is_empty() {
        return Err(source.error(heading, format!("a [[{}]] needs `{}`", kind.key, kind.list)));
    }
    let mut names = Vec::new();
    for (index, member) in members.into_iter().enumerate() {
        let place = member.span();
        let (mut own, only_named) = match member.into_inner() {
            DeValue::Table(table) => (entries(table), false),
            DeValue::String(text) => {
                let key = Spanned::new(place.start..place.start, DeString::from("name"));
                (vec![(key, Spanned::new(place.clone(), DeValue::String(text)))], true)
            }
            _ => return Err(source.error(place, "a member must be a name or a table")),
        };
        let size_of = |(key, value): &Entry<'_>| word(key).len() + value.span().len() + 4;
        let size = own.iter().chain(&shared).map(size_of).sum::<usize>();
        take(room, size, source, &heading)?;
        let given: BTreeSet<String> = own.iter().map(|(key, _)| word(key).to_string()).collect();
        own.extend(shared.iter().filter(|(key, _)| !given.contains(word(key))).cloned());
        let rank = |key: &str| kind.order.iter().position(|known| *known == key);
        own.sort_by_key(|(key, _)| rank(word(key)).unwrap_or(kind.order.len()));
        let comment = if index == 0 { group.comment.clone() } else { 0..0 };
        let item = Item { kind: kind.kind, start: group.start, place, comment, entries: own, only_named };
        names.extend(item.first_name());
        document.items.push(item);
    }
    if let Some((name, span)) = name {
        if document.groups.iter().any(|known| known.kind.key == kind.key && known.name == name) {
            return Err(source.error(span, format!("two groups are called `{name}`")));
        }
        document.groups.push(Group { name, span, kind, members: names });
    }
    Ok(())
}

/// The base with what `child` changes, adds and leaves out.
fn merge<'d>(
    source: Source<'_>,
    mut base: Document<'d>,
    child: Document<'d>,
) -> Result<Document<'d>, SpecError> {
    replace(&mut base.keys, child.keys);
    if let Some((place, suites)) = child.suites {
        replace(&mut base.suites.get_or_insert((place, Vec::new())).1, suites);
    }
    let removed = removed(source, &base, &child.without)?;
    let mut known: BTreeMap<(&str, Vec<String>), usize> = BTreeMap::new();
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
                item.entries.retain(|(key, _)| !(item.only_named && word(key) == "name"));
                replace(&mut base.items[index].entries, item.entries);
            }
            None if last.contains_key(item.kind) => added.entry(item.kind).or_default().push(item),
            None => of_new_kinds.push(item),
        }
    }
    let mut items = Vec::new();
    for (index, item) in base.items.into_iter().enumerate() {
        let kind = item.kind;
        if !removed.contains(&index) {
            items.push(item);
        }
        if last.get(kind) == Some(&index) {
            items.extend(added.remove(kind).unwrap_or_default());
        }
    }
    items.extend(of_new_kinds);
    let is_new = |g: &Group| !child.groups.iter().any(|c| c.name == g.name && c.kind.key == g.kind.key);
    base.groups.retain(is_new);
    base.groups.extend(child.groups);
    Ok(Document { items, ..base })
}

/// Puts entries in the place of those with the same key, and others behind.
fn replace<'d>(known: &mut Vec<Entry<'d>>, with: Vec<Entry<'d>>) {
    let places: BTreeMap<String, usize> =
        known.iter().enumerate().map(|(place, (key, _))| (word(key).to_string(), place)).collect();
    for entry in with {
        match places.get(word(&entry.0)) {
            Some(&place) => known[place] = entry,
            None => known.push(entry),
        }
    }
}

/// Indices of the items of the base that `without` leaves out.
fn removed(
    source: Source<'_>,
    base: &Document<'_>,
    without: &[LeftOut],
) -> Result<BTreeSet<usize>, SpecError> {
    // Published numbers are left out by the name of their table.
    let mut known: BTreeMap<(&str, String), Vec<usize>> = BTreeMap::new();
    for (index, item) in base.items.iter().enumerate() {
        if let Some(name) = item.first_name() {
            known.entry((item.kind, name)).or_default().push(index);
        }
    }
    let mut removed = BTreeSet::new();
    for LeftOut { kind, name, span } in without {
        let group = base.groups.iter().find(|group| group.kind.kind == *kind && group.name == *name);
        let names = group.map_or(std::slice::from_ref(name), |group| group.members.as_slice());
        let found = names.iter().filter_map(|name| known.get(&(*kind, name.clone()))).flatten();
        let found: Vec<usize> = found.copied().collect();
        if found.is_empty() {
            let words = known.keys().filter(|(of, _)| of == kind).map(|(_, name)| name.as_str());
            return Err(source.unknown(span.clone(), &format!("{kind} of the base"), name, words));
        }
        removed.extend(found);
    }
    Ok(removed)
}

/// Puts the members of groups in the place of the names of the groups, in lists of trackers and methods.
fn name_members(source: Source<'_>, document: &mut Document<'_>, room: &mut usize) -> Result<(), SpecError> {
    let Document { items, groups, .. } = document;
    let names: BTreeSet<(&str, String)> =
        items.iter().filter_map(|item| Some((item.kind, item.first_name()?))).collect();
    for Group { name, span, kind, .. } in groups.iter() {
        if names.contains(&(kind.kind, name.clone())) {
            let message = format!("`{name}` is the name of a {} already", kind.kind);
            return Err(source.error(span.clone(), message));
        }
    }
    let groups: BTreeMap<(&str, &str), &Group> =
        groups.iter().map(|group| ((group.kind.list, group.name.as_str()), group)).collect();
    for item in items {
        for (key, value) in &mut item.entries {
            let place = value.span();
            let kind = GROUPS.iter().find(|group| group.list == word(key) && group.kind != item.kind);
            let (Some(kind), DeValue::Array(list)) = (kind, value.get_mut()) else { continue };
            let group =
                |name: &Spanned<DeValue<'_>>| groups.get(&(kind.list, name.get_ref().as_str()?)).copied();
            if !list.iter().any(|name| group(name).is_some()) {
                continue;
            }
            let (mut written, mut all) = (BTreeSet::new(), DeArray::new());
            for name in list.iter() {
                let at = name.span().start;
                match group(name) {
                    Some(group) => {
                        for member in &group.members {
                            take(room, member.len() + 4, source, &place)?;
                            // What has been left out of the experiment is left out of its groups.
                            let is_there = names.contains(&(kind.kind, member.clone()));
                            if is_there && written.insert(member.clone()) {
                                all.push(Spanned::new(at..at, DeValue::String(member.clone().into())));
                            }
                        }
                    }
                    None => {
                        let is_new = |word: &str| written.insert(word.to_string());
                        if name.get_ref().as_str().is_none_or(is_new) {
                            all.push(name.clone());
                        }
                    }
                }
            }
            if all.is_empty() {
                let message = format!("nothing is left of the groups that `{}` names", kind.list);
                return Err(source.error(place, message));
            }
            *list = all;
        }
    }
    Ok(())
}

/// The whole document as one table.
fn table_of(document: Document<'_>) -> DeTable<'_> {
    let mut table: DeTable<'_> = document.keys.into_iter().collect();
    let mut insert = |key: &'static str, place: Range<usize>, value| {
        table.insert(Spanned::new(place.clone(), DeString::from(key)), Spanned::new(place, value));
    };
    if let Some((place, suites)) = document.suites {
        insert("suites", place, DeValue::Table(suites.into_iter().collect()));
    }
    let mut lists: BTreeMap<&str, DeArray<'_>> = BTreeMap::new();
    for Item { kind, place, entries, .. } in document.items {
        let item = Spanned::new(place, DeValue::Table(entries.into_iter().collect()));
        lists.entry(kind).or_insert_with(|| DeArray::from_iter([])).push(item);
    }
    for (kind, list) in lists {
        insert(kind, list[0].span(), DeValue::Array(list));
    }
    table
}

#[cfg(test)]
mod tests;
