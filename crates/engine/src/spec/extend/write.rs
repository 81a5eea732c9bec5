//! Writes the text of an experiment. Values in its files are copied; values under separate headings are put
//! on one line.

use super::{Entry, Item, SUITES, entries, word};
use crate::spec::error::Source;
use toml::Spanned;
use toml::de::DeValue;

/// Text of items whose values come from the files of `source`.
pub(super) fn write(source: Source<'_>, items: &[Item<'_>]) -> String {
    let mut writer = Writer { source, text: String::new() };
    for item in items {
        match item.kind {
            "" => {}
            SUITES => writer.text.push_str("\n[suites]\n"),
            kind => writer.text.push_str(&format!("\n{}[[{kind}]]\n", source.slice(item.comment.clone()))),
        }
        for entry in &item.entries {
            writer.entry(entry);
            writer.text.push('\n');
        }
    }
    writer.text
}

struct Writer<'w> {
    source: Source<'w>,
    text: String,
}

impl Writer<'_> {
    /// Writes `key = value`.
    fn entry(&mut self, (key, value): &Entry<'_>) {
        let place = key.span();
        self.text.push_str(if place.is_empty() { word(key) } else { self.source.slice(place.clone()) });
        self.text.push_str(" = ");
        let between = self.source.slice(place.end..value.span().start).trim();
        self.value(value, between == "=");
    }

    /// Writes a value. Text after a key is copied as it is. Values under a heading or dotted keys, and lists
    /// with members of groups, are copied part by part.
    fn value(&mut self, value: &Spanned<DeValue<'_>>, is_behind_key: bool) {
        let is_made = |item: &Spanned<DeValue<'_>>| item.span().is_empty();
        match value.get_ref() {
            DeValue::String(text) if is_made(value) => {
                self.text.push_str(&toml::Value::from(&**text).to_string());
            }
            DeValue::Table(table) if !is_behind_key => {
                for (k, entry) in entries(table.clone()).iter().enumerate() {
                    self.text.push_str(if k == 0 { "{ " } else { ", " });
                    self.entry(entry);
                }
                self.text.push_str(if table.is_empty() { "{ }" } else { " }" });
            }
            DeValue::Array(list) if !is_behind_key || list.iter().any(is_made) => {
                self.text.push('[');
                for (k, item) in list.iter().enumerate() {
                    self.text.push_str(if k == 0 { "" } else { ", " });
                    self.value(item, is_behind_key);
                }
                self.text.push(']');
            }
            _ => self.text.push_str(self.source.slice(value.span())),
        }
    }
}
