//! Experiments that give only differences: `extends` names another experiment, groups hold keys shared by
//! several trackers or methods.
//!
//! [`complete`] puts all values of an experiment together, each with its place in the file that it comes
//! from. It also writes them as one text, which is saved beside the results, so that these are
//! self-contained.
//!
//! - A key of the file, a suite of `[suites]` and a key of an item replace those of the base.
//! - An item (`[[tracker]]`, `[[method]]`, `[[table]]` ...) whose name the base has changes that one; others
//!   are added after those of the base, by kind. A tracker's name is its label, a claim's its text, that of
//!   published numbers their table, tracker and row.
//! - `[without]` leaves items of the base out: `table = ["counts"]`.
//! - A `[[tracker-group]]` or `[[method-group]]` lists its members and gives the keys they share. Where it has
//!   a `group` of its own, that name stands for all members in every list of trackers or methods.

mod chain;
mod write;

pub(super) use chain::{Folder, load};

use super::check::check;
use super::error::{Errors, MAX_WORD, Source, SourceFile, SpecError};
use super::limits::MAX_BYTES;
use super::schema::OF_SHORTCUTS;
use std::collections::{BTreeMap, BTreeSet};
use std::ops::Range;
use toml::Spanned;
use toml::de::{DeArray, DeString, DeTable, DeValue};
use trackfail_core::plugin::unknown;
use trackfail_dataset::text::shorten_to;

/// Key that names the experiment to extend.
const EXTENDS: &str = "extends";
/// Table of the base's items that the experiment leaves out.
const WITHOUT: &str = "without";
/// Name of the table of suites.
const SUITES: &str = "suites";
/// Keys that exist only to shorten a file.
const SHORTCUTS: [&str; 4] = [EXTENDS, WITHOUT, GROUPS[0].key, GROUPS[1].key];

/// Kinds of items: heading in the file (`[[tracker]]`), name of the definition in the schema, and the keys
/// that identify an item. A tracker without a label is identified by its name.
pub(super) const KINDS: [(&str, &str, &[&str]); 7] = [
    (TRACKER, "Tracker", &[]),
    ("method", "Method", &["name"]),
    ("analysis", "Analysis", &["name"]),
    ("table", "Table", &["name"]),
    ("figure", "Figure", &["name"]),
    ("published", "Published", &["table", "tracker", "row"]),
    ("claim", "Claim", &["text"]),
];
const TRACKER: &str = "tracker";

/// A kind of group: `[[tracker-group]]` or `[[method-group]]`, with the keys by which it is written out.
struct GroupKind {
    /// Key of the group in the file.
    key: &'static str,
    /// Kind of the members.
    kind: &'static str,
    /// Key of the list of members, also in items of other kinds.
    list: &'static str,
    /// Keys of a member that are written first, in this order.
    order: &'static [&'static str],
}

/// All kinds of groups.
const GROUPS: [GroupKind; 2] = [
    GroupKind { key: "tracker-group", kind: TRACKER, list: "trackers", order: &["name"] },
    GroupKind {
        key: "method-group",
        kind: "method",
        list: "methods",
        order: &["name", "trackers", "protocol", "signal", "detector", "grid"],
    },
];

/// A key with its value. Values that a group implies without stating them have an empty place.
type Entry<'d> = (Spanned<DeString<'d>>, Spanned<DeValue<'d>>);

/// One `[[...]]` item, the table of suites, or the keys before all headings.
#[derive(Default)]
struct Item<'d> {
    /// Word of the heading; empty for the keys before all headings.
    kind: &'static str,
    /// Place of the item in the files.
    place: Range<usize>,
    /// Place of the comment above the heading.
    comment: Range<usize>,
    entries: Vec<Entry<'d>>,
}

impl Item<'_> {
    /// Name that identifies the item among those of its kind.
    fn name(&self) -> Option<Vec<String>> {
        let text = |wanted: &str| {
            let value = self.entries.iter().find(|(key, _)| word(key) == wanted).map(|(_, value)| value);
            value.and_then(|value| value.get_ref().as_str()).map(str::to_string)
        };
        if self.kind == TRACKER {
            return Some(vec![text("label").or_else(|| text("name"))?]);
        }
        let keys = KINDS.iter().find(|(kind, ..)| *kind == self.kind).map(|(_, _, keys)| *keys);
        keys.unwrap_or_default().iter().map(|key| text(key)).collect()
    }

    fn first_name(&self) -> Option<String> {
        self.name()?.into_iter().next()
    }
}

/// A named group of trackers or methods.
struct Group {
    kind: &'static GroupKind,
    name: Spanned<String>,
    /// Names of the members.
    members: Vec<String>,
}

/// Items of one spec file, or of a file merged over those it extends.
#[derive(Default)]
struct Document<'d> {
    items: Vec<Item<'d>>,
    groups: Vec<Group>,
    /// Lists of names in `[without]`, by kind of item.
    without: Vec<Entry<'d>>,
}

/// True if a file extends no other and has no groups.
pub(super) fn is_complete(document: &DeTable<'_>) -> bool {
    !SHORTCUTS.iter().any(|key| document.contains_key(*key))
}

/// Merges an experiment with those that it extends; `files` come from [`load`]. The resulting text is
/// self-contained.
///
/// # Errors
/// Errors in groups and in `[without]`, and a result longer than an experiment file may be.
pub(super) fn complete(files: &[SourceFile]) -> Result<(String, Spanned<DeTable<'_>>), SpecError> {
    let source = Source(files);
    let mut assembly = Assembly { source, room: MAX_BYTES };
    let mut whole = Document::default();
    for file in files.iter().rev() {
        let document = assembly.cut(file.syntax()?)?;
        whole = assembly.merge(whole, document)?;
    }
    assembly.name_members(&mut whole)?;
    let text = write::write(source, &whole.items);
    if text.len() > MAX_BYTES {
        let message =
            format!("with what it extends and its groups written out, it has more than {MAX_BYTES} bytes");
        return Err(source.error(0..0, message));
    }
    Ok((text, Spanned::new(0..0, table_of(whole.items))))
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

/// Comment lines directly above a heading.
fn comment_above(source: Source<'_>, start: usize) -> Range<usize> {
    let lines = source.before(start).split_inclusive('\n').rev();
    let comment = lines.take_while(|line| line.ends_with('\n') && line.trim_start().starts_with('#'));
    start - comment.map(str::len).sum::<usize>()..start
}

/// State of merging an experiment.
struct Assembly<'s> {
    source: Source<'s>,
    /// Bytes that groups may still add. The limit keeps a small file from filling the memory.
    room: usize,
}

impl Assembly<'_> {
    fn take(&mut self, size: usize, place: &Range<usize>) -> Result<(), SpecError> {
        let message = || format!("the groups make more than {MAX_BYTES} bytes of text");
        self.room = self.room.checked_sub(size).ok_or_else(|| self.source.error(place.clone(), message()))?;
        Ok(())
    }

    /// Splits a file into items and writes out its groups. Values of a wrong type are kept; a later check
    /// reports them.
    fn cut<'d>(&mut self, document: Spanned<DeTable<'d>>) -> Result<Document<'d>, SpecError> {
        let errors = Errors::default();
        let shortcuts = document.get_ref().iter().filter(|(key, _)| SHORTCUTS.contains(&word(key)));
        let shortcuts = shortcuts.map(|(key, value)| (key.clone(), value.clone())).collect();
        check(self.source, &OF_SHORTCUTS, Spanned::new(document.span(), shortcuts), DeTable::new(), &errors);
        errors.or(Some(()))?;
        let (mut keys, mut suites, mut headed) = (Item::default(), None, Vec::new());
        let mut cut = Document::default();
        for (key, value) in entries(document.into_inner()) {
            let (heading, place) = (word(&key).to_string(), value.span());
            let group = GROUPS.iter().find(|group| group.key == heading);
            let known = || KINDS.iter().map(|(kind, ..)| *kind).find(|kind| *kind == heading);
            let kind = group.map(|group| group.kind).or_else(known);
            match (heading.as_str(), value.into_inner(), kind) {
                (EXTENDS, ..) => {}
                (WITHOUT, DeValue::Table(without), _) => cut.without = entries(without),
                (SUITES, DeValue::Table(table), _) => {
                    suites = Some(Item { kind: SUITES, place, entries: entries(table), ..Item::default() });
                }
                (_, DeValue::Array(list), Some(kind))
                    if list.iter().all(|item| item.get_ref().is_table()) =>
                {
                    headed.extend(list.into_iter().map(|item| (kind, group, item)));
                }
                (_, value, _) => keys.entries.push((key, Spanned::new(place, value))),
            }
        }
        headed.sort_by_key(|(_, _, item)| item.span().start);
        cut.items = std::iter::once(keys).chain(suites).collect();
        for (kind, group, item) in headed {
            let place = item.span();
            let comment = comment_above(self.source, place.start);
            let DeValue::Table(table) = item.into_inner() else { continue };
            let item = Item { kind, place, comment, entries: entries(table) };
            match group {
                Some(group) => self.expand(group, item, &mut cut)?,
                None => cut.items.push(item),
            }
        }
        Ok(cut)
    }

    /// Writes out a group: its members, each with the shared keys.
    fn expand<'d>(
        &mut self,
        kind: &'static GroupKind,
        group: Item<'d>,
        cut: &mut Document<'d>,
    ) -> Result<(), SpecError> {
        let heading = group.place.start..group.place.start;
        let (mut name, mut members, mut shared) = (None, DeArray::new(), Vec::new());
        for (key, value) in group.entries {
            match (word(&key), value.get_ref()) {
                ("group", DeValue::String(word)) => name = Some(Spanned::new(value.span(), word.to_string())),
                (list, DeValue::Array(all)) if list == kind.list => members = all.clone(),
                _ => shared.push((key, value)),
            }
        }
        let (mut names, mut comment) = (Vec::new(), group.comment);
        for member in members {
            let place = member.span();
            let mut own = match member.into_inner() {
                DeValue::Table(table) => entries(table),
                name => {
                    let key = Spanned::new(place.start..place.start, DeString::from("name"));
                    vec![(key, Spanned::new(place.clone(), name))]
                }
            };
            let given: BTreeSet<String> = own.iter().map(|(key, _)| word(key).to_string()).collect();
            own.extend(shared.iter().filter(|(key, _)| !given.contains(word(key))).cloned());
            let size_of = |(key, value): &Entry<'_>| word(key).len() + value.span().len() + 4;
            self.take(own.iter().map(size_of).sum(), &heading)?;
            let rank = |key: &str| kind.order.iter().position(|known| *known == key);
            own.sort_by_key(|(key, _)| rank(word(key)).unwrap_or(kind.order.len()));
            let item = Item { kind: kind.kind, place, comment: std::mem::take(&mut comment), entries: own };
            names.extend(item.first_name());
            cut.items.push(item);
        }
        if let Some(name) = name {
            let word = name.get_ref();
            if cut.groups.iter().any(|known| known.kind.key == kind.key && known.name.get_ref() == word) {
                return Err(self.source.error(name.span(), format!("two groups are called `{word}`")));
            }
            cut.groups.push(Group { kind, name, members: names });
        }
        Ok(())
    }

    /// Merges `child` over `base`: changed, added and left-out items. An empty base gives `child`.
    fn merge<'d>(&self, base: Document<'d>, child: Document<'d>) -> Result<Document<'d>, SpecError> {
        let removed = self.removed(&base, &child)?;
        let mut known: BTreeMap<(&str, Vec<String>), usize> = BTreeMap::new();
        let mut last: BTreeMap<&str, usize> = BTreeMap::new();
        for (index, item) in base.items.iter().enumerate() {
            last.insert(item.kind, index);
            if let Some(name) = item.name().filter(|_| !removed.contains(&index)) {
                known.entry((item.kind, name)).or_insert(index);
            }
        }
        // Each with its place: an index of the base, and whether it is added behind that one.
        let mut items: Vec<((usize, bool), Item<'d>)> = Vec::new();
        items.extend(base.items.into_iter().enumerate().map(|(index, item)| ((index, false), item)));
        for mut item in child.items {
            // The second item of a name in one file finds none to change, and is refused as every name that stands
            // there twice.
            match item.name().and_then(|name| known.remove(&(item.kind, name))) {
                Some(index) => {
                    // A lone name in a group may be the label of a tracker of the base.
                    item.entries.retain(|(key, _)| !key.span().is_empty());
                    replace(&mut items[index].1.entries, item.entries);
                }
                None => items.push(((last.get(item.kind).copied().unwrap_or(usize::MAX), true), item)),
            }
        }
        items.retain(|((index, is_added), _)| *is_added || !removed.contains(index));
        items.sort_by_key(|(place, _)| *place);
        let mut groups = base.groups;
        groups.retain(|old| {
            let is_it =
                |new: &Group| new.kind.key == old.kind.key && new.name.get_ref() == old.name.get_ref();
            !child.groups.iter().any(is_it)
        });
        groups.extend(child.groups);
        let items = items.into_iter().map(|(_, item)| item).collect();
        Ok(Document { items, groups, without: Vec::new() })
    }

    /// Indices of the items of the base that the child leaves out.
    fn removed(&self, base: &Document<'_>, child: &Document<'_>) -> Result<BTreeSet<usize>, SpecError> {
        // Published numbers are left out by the name of their table.
        let mut known: BTreeMap<(&str, String), Vec<usize>> = BTreeMap::new();
        for (index, item) in base.items.iter().enumerate() {
            if let Some(name) = item.first_name() {
                known.entry((item.kind, name)).or_default().push(index);
            }
        }
        let mut removed = BTreeSet::new();
        for (kind, names) in &child.without {
            let kind = word(kind);
            let names = names.get_ref().as_array().into_iter().flat_map(|names| names.iter());
            for (span, name) in names.filter_map(|name| Some((name.span(), name.get_ref().as_str()?))) {
                if base.items.is_empty() {
                    return Err(self.source.error(span, "[without] is for experiments that extend another"));
                }
                let group = base.groups.iter().find(|g| g.kind.kind == kind && g.name.get_ref() == name);
                let names = group.map_or_else(|| vec![name.to_string()], |group| group.members.clone());
                let found = names.into_iter().filter_map(|name| known.get(&(kind, name))).flatten();
                let found: Vec<usize> = found.copied().collect();
                if found.is_empty() {
                    let words = known.keys().filter(|(of, _)| *of == kind).map(|(_, name)| name.as_str());
                    let message = unknown(&format!("{kind} of the base"), &shorten_to(name, MAX_WORD), words);
                    return Err(self.source.error(span, message));
                }
                removed.extend(found);
            }
        }
        Ok(removed)
    }

    /// Replaces names of groups by those of their members, in lists of trackers and methods.
    fn name_members(&mut self, document: &mut Document<'_>) -> Result<(), SpecError> {
        let Document { items, groups, .. } = document;
        let names: BTreeSet<(&str, String)> =
            items.iter().filter_map(|item| Some((item.kind, item.first_name()?))).collect();
        let mut known: BTreeMap<(&str, &str), Vec<&String>> = BTreeMap::new();
        for Group { kind, name, members } in groups.iter() {
            let is_there = |name: &String| names.contains(&(kind.kind, name.clone()));
            if is_there(name.get_ref()) {
                let message = format!("`{}` is the name of a {} already", name.get_ref(), kind.kind);
                return Err(self.source.error(name.span(), message));
            }
            // What has been left out of the experiment is left out of its groups.
            let members = members.iter().filter(|member| is_there(member)).collect();
            known.insert((kind.list, name.get_ref().as_str()), members);
        }
        for item in items {
            for (key, value) in &mut item.entries {
                let place = value.span();
                let kind = GROUPS.iter().find(|group| group.list == word(key) && group.kind != item.kind);
                let (Some(kind), DeValue::Array(list)) = (kind, value.get_mut()) else { continue };
                let is_group = |text: &str| known.contains_key(&(kind.list, text));
                if !list.iter().any(|name| name.get_ref().as_str().is_some_and(is_group)) {
                    continue;
                }
                let (mut written, mut all) = (BTreeSet::new(), Vec::new());
                for name in list.iter() {
                    let (at, text) = (name.span().start, name.get_ref().as_str());
                    let Some(members) = text.and_then(|text| known.get(&(kind.list, text))) else {
                        all.push(name.clone());
                        continue;
                    };
                    for member in members {
                        self.take(member.len() + 4, &place)?;
                        all.push(Spanned::new(at..at, DeValue::String(member.to_string().into())));
                    }
                }
                all.retain(|name| {
                    name.get_ref().as_str().is_none_or(|text| written.insert(text.to_string()))
                });
                if all.is_empty() {
                    let message = format!("nothing is left of the groups that `{}` names", kind.list);
                    return Err(self.source.error(place, message));
                }
                *list = all.into_iter().collect();
            }
        }
        Ok(())
    }
}

/// Replaces entries that have the same key and appends the others.
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

/// Puts all items into one table. The first has the keys before all headings.
fn table_of(items: Vec<Item<'_>>) -> DeTable<'_> {
    let mut items = items.into_iter();
    let (mut table, keys) = (DeTable::new(), items.next().unwrap_or_default().entries);
    for Item { kind, place, entries, .. } in items {
        let item = Spanned::new(place.clone(), DeValue::Table(entries.into_iter().collect()));
        let key = Spanned::new(place.clone(), DeString::from(kind));
        if kind == SUITES {
            table.insert(key, item);
        } else if let DeValue::Array(list) =
            table.entry(key).or_insert(Spanned::new(place, DeValue::Array(DeArray::new()))).get_mut()
        {
            list.push(item);
        }
    }
    table.extend(keys);
    table
}

#[cfg(test)]
mod tests;
