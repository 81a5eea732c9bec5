//! Makes one text of keys and items, and remembers where its pieces come from.

use super::document::{Document, Entry, GROUPS, Group, Item, entries};
use crate::spec::error::{Piece, Source, SpecError};
use crate::spec::limits::MAX_BYTES;
use std::collections::{BTreeMap, BTreeSet};
use std::ops::Range;
use toml::de::{DeTable, DeValue};

/// Writes a document; `sources` are its files.
///
/// # Errors
/// A group with the name of a tracker or method, and a text that is too long.
pub(super) fn write(
    document: &Document<'_>,
    sources: &[Source<'_>],
) -> Result<(String, Vec<Piece>), SpecError> {
    let mut names: BTreeSet<(&str, &str)> = BTreeSet::new();
    for item in &document.items {
        names.extend(item.name().and_then(|name| Some((item.kind, *name.first()?))));
    }
    let mut groups = BTreeMap::new();
    for group in &document.groups {
        if names.contains(&(group.kind.kind, group.name)) {
            let message = format!("`{}` is the name of a {} already", group.name, group.kind.kind);
            return Err(sources[group.file].error(group.span.clone(), message));
        }
        groups.insert((group.kind.list, group.name), group);
    }
    let mut writer = Writer { text: String::new(), pieces: Vec::new(), sources, groups, names };
    for entry in &document.keys {
        writer.entry(entry, None)?;
    }
    if let Some(suites) = &document.suites {
        let (file, start) = suites.first().map_or((0, 0), |entry| (entry.file, entry.key_span.start));
        writer.made("\n[suites]\n", file, start)?;
        for entry in suites {
            writer.entry(entry, None)?;
        }
    }
    for item in &document.items {
        writer.item(item)?;
    }
    Ok((writer.text, writer.pieces))
}

struct Writer<'w> {
    text: String,
    pieces: Vec<Piece>,
    sources: &'w [Source<'w>],
    /// Groups by the key of lists of their kind, and their name.
    groups: BTreeMap<(&'static str, &'w str), &'w Group<'w>>,
    /// Kind and name of every item.
    names: BTreeSet<(&'w str, &'w str)>,
}

impl Writer<'_> {
    fn push(&mut self, text: &str, file: usize, start: usize, copied: bool) -> Result<(), SpecError> {
        let source = self.sources[file];
        if self.text.len() + text.len() > MAX_BYTES {
            let message = format!(
                "with what it extends and its groups written out, it has more than {MAX_BYTES} bytes"
            );
            return Err(source.error(start..start, message));
        }
        self.pieces.push(Piece { start: self.text.len(), file, origin: start, copied });
        self.text.push_str(text);
        Ok(())
    }

    /// Writes a text that belongs to a place of a file but does not stand there.
    fn made(&mut self, text: &str, file: usize, start: usize) -> Result<(), SpecError> {
        self.push(text, file, start, false)
    }

    /// Copies a piece of a file.
    fn copy(&mut self, file: usize, span: Range<usize>) -> Result<(), SpecError> {
        self.push(self.sources[file].slice(span.clone()), file, span.start, true)
    }

    fn item(&mut self, item: &Item<'_>) -> Result<(), SpecError> {
        self.made("\n", item.file, item.start)?;
        self.copy(item.file, item.comment.clone())?;
        self.made(&format!("[[{}]]\n", item.kind), item.file, item.start)?;
        item.entries.iter().try_for_each(|entry| self.entry(entry, Some(item.kind)))
    }

    /// Writes a line `key = value`, of an item of a kind.
    fn entry(&mut self, entry: &Entry<'_>, kind: Option<&str>) -> Result<(), SpecError> {
        self.key(entry)?;
        let start = entry.value.span().start;
        match GROUPS.iter().find(|group| group.list == entry.key && kind.is_some_and(|k| k != group.kind)) {
            Some(group) if self.names_a_group(group.list, entry.value.get_ref()) => {
                self.list(group.list, group.kind, entry)?;
            }
            _ => self.value(entry)?,
        }
        self.made("\n", entry.file, start)
    }

    fn key(&mut self, entry: &Entry<'_>) -> Result<(), SpecError> {
        let start = entry.key_span.start;
        if entry.key_span.is_empty() {
            self.made(entry.key, entry.file, start)?;
        } else {
            self.copy(entry.file, entry.key_span.clone())?;
        }
        self.made(" = ", entry.file, start)
    }

    /// Copies a value, or writes on one line what the file has under headings or dotted keys.
    fn value(&mut self, entry: &Entry<'_>) -> Result<(), SpecError> {
        let (file, span) = (entry.file, entry.value.span());
        let between = self.sources[file].slice(entry.key_span.end..span.start).trim();
        match entry.value.get_ref() {
            DeValue::Table(table) if between != "=" => self.table(table, file, span.start),
            DeValue::Array(list) if between != "=" => {
                self.made("[", file, span.start)?;
                for (k, item) in list.iter().enumerate() {
                    self.made(if k == 0 { "" } else { ", " }, file, item.span().start)?;
                    match item.get_ref() {
                        DeValue::Table(table) => self.table(table, file, item.span().start)?,
                        _ => self.copy(file, item.span())?,
                    }
                }
                self.made("]", file, span.start)
            }
            _ => self.copy(file, span),
        }
    }

    fn table(&mut self, table: &DeTable<'_>, file: usize, start: usize) -> Result<(), SpecError> {
        self.made("{", file, start)?;
        for (k, entry) in entries(table, file).iter().enumerate() {
            self.made(if k == 0 { " " } else { ", " }, file, entry.key_span.start)?;
            self.key(entry)?;
            self.value(entry)?;
        }
        self.made(" }", file, start)
    }

    fn names_a_group(&self, list: &'static str, value: &DeValue<'_>) -> bool {
        let DeValue::Array(items) = value else { return false };
        items
            .iter()
            .filter_map(|item| item.get_ref().as_str())
            .any(|word| self.groups.contains_key(&(list, word)))
    }

    /// Writes a list of names with the members of groups in place of the groups, each name once.
    fn list(&mut self, list: &'static str, kind: &str, entry: &Entry<'_>) -> Result<(), SpecError> {
        let DeValue::Array(items) = entry.value.get_ref() else { return Ok(()) };
        let (file, mut written) = (entry.file, BTreeSet::new());
        self.made("[", file, entry.value.span().start)?;
        for item in items.iter() {
            let start = item.span().start;
            let group = item.get_ref().as_str().and_then(|word| self.groups.get(&(list, word)).copied());
            let names = match group {
                // What has been left out of the experiment is left out of its groups.
                Some(group) => {
                    let there = group.members.iter().filter(|name| self.names.contains(&(kind, **name)));
                    there.map(|name| toml::Value::from(*name).to_string()).collect()
                }
                None => vec![self.sources[file].slice(item.span()).to_string()],
            };
            for name in names {
                if written.insert(name.clone()) {
                    self.made(if written.len() == 1 { "" } else { ", " }, file, start)?;
                    self.made(&name, file, start)?;
                }
            }
        }
        if written.is_empty() {
            let message = format!("nothing is left of the groups that `{list}` names");
            return Err(self.sources[file].error(entry.value.span(), message));
        }
        self.made("]", file, entry.value.span().start)
    }
}
