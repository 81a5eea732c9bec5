//! Writes the text of an experiment. Values in its files are copied; values under separate headings are put
//! on one line.

use super::{Entry, Item, SUITES, entries, word};
use crate::spec::error::Source;
use toml::Spanned;
use toml::de::DeValue;

/// Text of items whose values come from the files of `source`.
pub(super) fn write(source: Source<'_>, items: &[Item<'_>]) -> String {
    let mut text = String::new();
    for item in items {
        match item.kind {
            "" => {}
            SUITES => text.push_str("\n[suites]\n"),
            kind => text.push_str(&format!("\n{}[[{kind}]]\n", source.slice(item.comment.clone()))),
        }
        for entry in &item.entries {
            text.push_str(&key_and_value(source, entry));
            text.push('\n');
        }
    }
    text
}

/// `key = value`.
fn key_and_value(source: Source<'_>, (key, value): &Entry<'_>) -> String {
    let place = key.span();
    let between = source.slice(place.end..value.span().start).trim();
    let key = if place.is_empty() { word(key) } else { source.slice(place) };
    format!("{key} = {}", written(source, value, between == "="))
}

/// Text of a value. Text after a key is copied as it is. Values under a heading or dotted keys, and lists with
/// members of groups, are copied part by part.
fn written(source: Source<'_>, value: &Spanned<DeValue<'_>>, is_behind_key: bool) -> String {
    let is_made = |item: &Spanned<DeValue<'_>>| item.span().is_empty();
    match value.get_ref() {
        DeValue::String(text) if is_made(value) => toml::Value::from(&**text).to_string(),
        DeValue::Table(table) if !is_behind_key && table.is_empty() => "{ }".to_string(),
        DeValue::Table(table) if !is_behind_key => {
            let all = entries(table.clone());
            let all: Vec<String> = all.iter().map(|entry| key_and_value(source, entry)).collect();
            format!("{{ {} }}", all.join(", "))
        }
        DeValue::Array(list) if !is_behind_key || list.iter().any(is_made) => {
            let all: Vec<String> = list.iter().map(|item| written(source, item, is_behind_key)).collect();
            format!("[{}]", all.join(", "))
        }
        _ => source.slice(value.span()).to_string(),
    }
}
