//! One file, cut into keys and items, with its groups written out.

use super::{EXTENDS, WITHOUT};
use crate::spec::error::{SHORTCUTS, Source, SpecError};
use crate::spec::limits::MAX_BYTES;
use std::collections::BTreeSet;
use std::ops::Range;
use toml::Spanned;
use toml::de::{DeString, DeTable, DeValue};

/// Kinds of items, as the file heads them: `[[tracker]]`.
const KINDS: [&str; 7] = ["tracker", "method", "analysis", "table", "figure", "published", "claim"];

/// A kind of group.
pub(super) struct GroupKind {
    /// Key of the file.
    pub key: &'static str,
    /// Kind of its members.
    pub kind: &'static str,
    /// Key of the list of its members, and of lists of them in items of other kinds.
    pub list: &'static str,
    /// Order in which the keys of a member are written, before all others.
    order: &'static [&'static str],
}

/// All kinds of groups.
pub(super) const GROUPS: [GroupKind; 2] = [
    GroupKind { key: SHORTCUTS[2], kind: "tracker", list: "trackers", order: &["name"] },
    GroupKind {
        key: SHORTCUTS[3],
        kind: "method",
        list: "methods",
        order: &["name", "trackers", "protocol", "signal", "detector", "grid"],
    },
];

/// A key with its value.
#[derive(Clone)]
pub(super) struct Entry<'d> {
    pub key: &'d str,
    /// Place of the key; empty for the name of a member that is only a name.
    pub key_span: Range<usize>,
    pub value: &'d Spanned<DeValue<'d>>,
    /// Index of the file.
    pub file: usize,
}

impl<'d> Entry<'d> {
    fn new((key, value): (&'d Spanned<DeString<'d>>, &'d Spanned<DeValue<'d>>), file: usize) -> Self {
        Self { key: key.get_ref(), key_span: key.span(), value, file }
    }

    fn word(&self) -> Option<&'d str> {
        self.value.get_ref().as_str()
    }
}

/// One `[[...]]`.
#[derive(Clone)]
pub(super) struct Item<'d> {
    pub kind: &'d str,
    pub file: usize,
    /// First byte of its heading, or of the group that it is a member of.
    pub start: usize,
    /// The comment above its heading.
    pub comment: Range<usize>,
    pub entries: Vec<Entry<'d>>,
    /// Whether only its name was given, which may be the label of a tracker of the base.
    pub only_named: bool,
}

impl<'d> Item<'d> {
    fn word(&self, key: &str) -> Option<&'d str> {
        self.entries.iter().find(|e| e.key == key).and_then(Entry::word)
    }

    /// Key that distinguishes it from the others of its kind.
    pub(super) fn name(&self) -> Option<Vec<&'d str>> {
        match self.kind {
            "tracker" => self.word("label").or_else(|| self.word("name")).map(|name| vec![name]),
            "claim" => self.word("text").map(|text| vec![text]),
            "published" => ["table", "tracker", "row"].into_iter().map(|key| self.word(key)).collect(),
            _ => self.word("name").map(|name| vec![name]),
        }
    }
}

/// A group with a name.
pub(super) struct Group<'d> {
    pub name: &'d str,
    pub span: Range<usize>,
    pub file: usize,
    pub kind: &'static GroupKind,
    /// Names of the members.
    pub members: Vec<&'d str>,
}

/// A file, cut up; or several, laid over one another.
#[derive(Default)]
pub(super) struct Document<'d> {
    pub keys: Vec<Entry<'d>>,
    pub suites: Option<Vec<Entry<'d>>>,
    pub items: Vec<Item<'d>>,
    pub groups: Vec<Group<'d>>,
    /// Kind and name of what the base has and this has not.
    pub without: Vec<(&'d str, &'d Spanned<DeValue<'d>>)>,
}

/// Entries of a table in the order of the file.
pub(super) fn entries<'d>(table: &'d DeTable<'d>, file: usize) -> Vec<Entry<'d>> {
    let mut entries: Vec<Entry<'d>> = table.iter().map(|pair| Entry::new(pair, file)).collect();
    entries.sort_by_key(|entry| entry.key_span.start);
    entries
}

/// Cuts up the file with an index.
pub(super) fn cut<'d>(
    source: Source<'d>,
    file: usize,
    table: &'d Spanned<DeTable<'d>>,
) -> Result<Document<'d>, SpecError> {
    let mut document = Document::default();
    let mut groups = Vec::new();
    for entry in entries(table.get_ref(), file) {
        let kind = KINDS.into_iter().find(|kind| *kind == entry.key);
        let group = GROUPS.iter().find(|group| group.key == entry.key);
        match (entry.key, entry.value.get_ref()) {
            (EXTENDS, _) => {}
            (WITHOUT, value) => read_without(source, value, &entry, &mut document)?,
            ("suites", DeValue::Table(suites)) => document.suites = Some(self::entries(suites, file)),
            (_, DeValue::Array(list)) if group.is_some() || kind.is_some() => {
                for value in list.iter() {
                    let DeValue::Table(table) = value.get_ref() else {
                        return Err(source.error(value.span(), format!("write [[{}]]", entry.key)));
                    };
                    let item = Item {
                        kind: kind.unwrap_or(entry.key),
                        file,
                        start: value.span().start,
                        comment: comment_above(source, value.span().start),
                        entries: self::entries(table, file),
                        only_named: false,
                    };
                    match group {
                        Some(group) => groups.push((group, item)),
                        None => document.items.push(item),
                    }
                }
            }
            _ if group.is_some() => {
                let message = format!("groups are written as [[{}]]", entry.key);
                return Err(source.error(entry.value.span(), message));
            }
            _ => document.keys.push(entry),
        }
    }
    let mut room = MAX_BYTES;
    for (kind, item) in groups {
        expand(source, kind, item, &mut document, &mut room)?;
    }
    document.items.sort_by_key(|item| item.start);
    Ok(document)
}

/// The comment lines right above a heading.
fn comment_above(source: Source<'_>, start: usize) -> Range<usize> {
    let mut first = start;
    while let Some(line) = source.slice(0..first).strip_suffix('\n').map(|above| above.rsplit('\n').next())
        && let Some(line) = line.filter(|line| line.trim_start().starts_with('#'))
    {
        first -= line.len() + 1;
    }
    first..start
}

/// Reads `[without]`.
fn read_without<'d>(
    source: Source<'d>,
    value: &'d DeValue<'d>,
    entry: &Entry<'d>,
    document: &mut Document<'d>,
) -> Result<(), SpecError> {
    let DeValue::Table(table) = value else {
        return Err(source.error(entry.value.span(), "`without` must be a table, such as [without]"));
    };
    for entry in entries(table, entry.file) {
        let Some(kind) = KINDS.into_iter().find(|kind| *kind == entry.key) else {
            return Err(source.unknown(entry.key_span, "kind of items", entry.key, KINDS));
        };
        let list = match entry.value.get_ref() {
            DeValue::Array(list) if list.iter().all(|name| name.get_ref().is_str()) => list,
            _ => {
                let message = format!("`{kind}` must be a list of names");
                return Err(source.error(entry.value.span(), message));
            }
        };
        document.without.extend(list.iter().map(|name| (kind, name)));
    }
    Ok(())
}

/// Writes a group out: its members with the keys they share, of at most `room` bytes.
fn expand<'d>(
    source: Source<'d>,
    kind: &'static GroupKind,
    group: Item<'d>,
    document: &mut Document<'d>,
    room: &mut usize,
) -> Result<(), SpecError> {
    let heading = group.start..group.start;
    let (mut name, mut members, mut shared) = (None, None, Vec::new());
    for entry in group.entries {
        match (entry.key, entry.value.get_ref()) {
            ("group", DeValue::String(word)) => name = Some((word.as_ref(), entry.value.span())),
            ("group", _) => return Err(source.error(entry.value.span(), "`group` must be text")),
            (key, DeValue::Array(list)) if key == kind.list => members = Some(list),
            (key, _) if key == kind.list => {
                let message = format!("`{key}` must be a list of names and tables");
                return Err(source.error(entry.value.span(), message));
            }
            _ => shared.push(entry),
        }
    }
    let Some(members) = members.filter(|list| !list.is_empty()) else {
        return Err(source.error(heading, format!("a [[{}]] needs `{}`", kind.key, kind.list)));
    };
    let mut names = Vec::new();
    for (index, member) in members.iter().enumerate() {
        let (mut own, only_named) = match member.get_ref() {
            DeValue::Table(table) => (entries(table, group.file), false),
            DeValue::String(_) => {
                let start = member.span().start;
                let name = Entry { key: "name", key_span: start..start, value: member, file: group.file };
                (vec![name], true)
            }
            _ => return Err(source.error(member.span(), "a member must be a name or a table")),
        };
        let given: BTreeSet<&str> = own.iter().map(|entry| entry.key).collect();
        own.extend(shared.iter().filter(|entry| !given.contains(entry.key)).cloned());
        let rank = |key: &str| kind.order.iter().position(|known| *known == key);
        own.sort_by_key(|entry| rank(entry.key).unwrap_or(kind.order.len()));
        let size = own.iter().map(|e| e.key.len() + e.value.span().len() + 4).sum();
        *room = room.checked_sub(size).ok_or_else(|| {
            source.error(heading.clone(), format!("the groups make more than {MAX_BYTES} bytes of text"))
        })?;
        let comment = if index == 0 { group.comment.clone() } else { 0..0 };
        let item =
            Item { kind: kind.kind, file: group.file, start: group.start, comment, entries: own, only_named };
        names.extend(item.name().and_then(|name| name.first().copied()));
        document.items.push(item);
    }
    if let Some((name, span)) = name {
        if document.groups.iter().any(|known| known.kind.key == kind.key && known.name == name) {
            return Err(source.error(span, format!("two groups are called `{name}`")));
        }
        document.groups.push(Group { name, span, file: group.file, kind, members: names });
    }
    Ok(())
}
