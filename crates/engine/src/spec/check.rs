//! Check of keys, types, words and ranges of a file against its JSON Schema. All errors are reported at once.
//!
//! The check covers the keywords of JSON Schema that [`schema`](super::schema) uses for single values. Rules
//! on several values, such as the keys of a kind of figure, are checked by the code that reads these values.

use super::error::{Errors, MAX_KEPT, MAX_WORD, Source};
use serde_json::Value;
use std::ops::Range;
use toml::Spanned;
use toml::de::{DeTable, DeValue};
use trackfail_core::plugin::{nearest, unknown};
use trackfail_dataset::text::shorten_to;
use trackfail_methods::score::Metric;

/// Longest quotation of the file in a message, in characters.
const MAX_TEXT: usize = 40;

/// Checks a file against its schema. Returns the file without its wrong keys and wrong items of lists of
/// tables, over the keys that `right` has already.
pub(super) fn check<'i>(
    source: Source<'_>,
    schema: &Value,
    file: Spanned<DeTable<'i>>,
    mut right: DeTable<'i>,
    errors: &Errors,
) -> Spanned<DeValue<'i>> {
    let mut check = Check { source, schema, errors, found: 0 };
    let place = file.span();
    check.keys(file.get_ref(), place.clone(), &[schema]);
    for (key, value) in file.into_inner() {
        let (word, span) = (key.get_ref().to_string(), value.span());
        let Some(property) = schema.get("properties").and_then(|all| all.get(&word)) else { continue };
        let items = property.get("items").map(|items| check.resolved(items));
        match items.filter(|items| items.get("properties").is_some()) {
            Some(_) if !value.get_ref().is_array() => check.tell(span, || format!("write [[{word}]]")),
            Some(items) if fits(property, value.get_ref()) => {
                let DeValue::Array(list) = value.into_inner() else { continue };
                let list = list.into_iter().filter(|item| !check.finds(&word, item, items)).collect();
                right.insert(key, Spanned::new(span, DeValue::Array(list)));
            }
            _ => {
                if !check.finds(&word, &value, property) {
                    right.insert(key, value);
                }
            }
        }
    }
    Spanned::new(place, DeValue::Table(right))
}

/// State of a check of one file.
struct Check<'c> {
    source: Source<'c>,
    /// Schema of the whole file, in which references are looked up.
    schema: &'c Value,
    errors: &'c Errors,
    /// Number of errors found.
    found: usize,
}

impl<'c> Check<'c> {
    /// Reports an error, up to a limit.
    fn tell(&mut self, place: Range<usize>, message: impl FnOnce() -> String) {
        self.found += 1;
        if self.found <= MAX_KEPT {
            self.errors.push(self.source.error(place, message()));
        }
    }

    /// Checks the value of a key. Returns true if an error was found.
    fn finds(&mut self, key: &str, value: &Spanned<DeValue<'_>>, schema: &'c Value) -> bool {
        let before = self.found;
        self.value(key, value, schema);
        self.found > before
    }

    /// Target of a reference; any other schema is returned as it is.
    fn resolved(&self, schema: &'c Value) -> &'c Value {
        let target = schema.get("$ref").and_then(Value::as_str).and_then(|target| target.strip_prefix('#'));
        target.and_then(|place| self.schema.pointer(place)).unwrap_or(schema)
    }

    /// Checks the value of a key against its schema, with all that it contains.
    fn value(&mut self, key: &str, value: &Spanned<DeValue<'_>>, described: &'c Value) {
        let (schema, place) = (self.resolved(described), value.span());
        let choices = choices(schema);
        let kinds: Vec<_> = choices.iter().flat_map(|choice| self.kinds(choice)).collect();
        if let Some(kind) = value.get_ref().as_table().and_then(|table| table.get("kind"))
            && let Some(word) = kind.get_ref().as_str().filter(|_| !kinds.is_empty())
            && !kinds.iter().any(|(_, known, _)| *known == word)
        {
            let short = shorten_to(word, MAX_WORD);
            return self.tell(kind.span(), || unknown(noun(key), &short, kinds.iter().map(|kind| kind.1)));
        }
        if let Some(meant) = self.meant(value.get_ref(), choices) {
            return self.value(key, value, meant);
        }
        if !kinds.is_empty() && value.get_ref().is_table() {
            return self.tell(place, || format!("the {} has no `kind`", noun(key)));
        }
        let words = words(schema);
        match value.get_ref() {
            DeValue::String(word) if words.contains(&word.as_ref()) => {}
            DeValue::String(word) if !words.is_empty() => {
                let (short, before) = (shorten_to(word, MAX_WORD), self.found);
                self.tell(place, || match key {
                    "metric" | "rank" => Metric::unknown(&short),
                    key => unknown(noun(key), &short, words),
                });
                // Words of an `enum` are texts for those who read them, who go on without this one.
                if schema.get("enum").is_some() {
                    self.found = before;
                }
            }
            given if !choices.is_empty() || !words.is_empty() || !fits(schema, given) => {
                let (wanted, given) = (self.wanted(schema, given), shown(given, schema));
                let about = described.get("description").and_then(Value::as_str).unwrap_or_default();
                let about = about.replace('\n', " ");
                self.tell(place, || match about.trim_end_matches('.') {
                    "" => format!("`{key}` must be {wanted}, not {given}"),
                    about => format!("`{key}` must be {wanted}, not {given} ({about})"),
                });
            }
            DeValue::Array(list) => {
                if let Some(items) = schema.get("items") {
                    list.iter().for_each(|item| self.value(key, item, items));
                }
            }
            DeValue::Table(table) => self.table(value, table, schema),
            _ => {}
        }
    }

    /// Checks the keys and values of a table.
    fn table(&mut self, value: &Spanned<DeValue<'_>>, table: &DeTable<'_>, schema: &'c Value) {
        // A tracker has its own keys and the parameters of its kind on one level.
        let kind = self.meant(value.get_ref(), list(schema, "anyOf"));
        let parts: Vec<&'c Value> = std::iter::once(schema).chain(kind).collect();
        self.keys(table, value.span(), &parts);
        for (key, value) in table {
            let word: &str = key.get_ref();
            let known = parts.iter().find_map(|part| part.get("properties")?.get(word));
            let any = || schema.get("additionalProperties").filter(|any| any.is_object());
            if let Some(schema) = known.or_else(any) {
                self.value(word, value, schema);
            }
        }
    }

    /// Reports unknown and missing keys of a table.
    fn keys(&mut self, table: &DeTable<'_>, place: Range<usize>, parts: &[&'c Value]) {
        let properties = parts.iter().filter_map(|part| part.get("properties")?.as_object());
        let known: Vec<&str> = properties.flat_map(|all| all.keys()).map(String::as_str).collect();
        let says = |key: &str, what: bool| parts.iter().any(|part| part.get(key) == Some(&Value::Bool(what)));
        let is_closed = says("additionalProperties", false) || says("unevaluatedProperties", false);
        let is_open = !is_closed || says("additionalProperties", true);
        let mut meant: Vec<String> = Vec::new();
        for (key, _) in table {
            let word: &str = key.get_ref();
            if is_open || known.contains(&word) || self.found >= MAX_KEPT {
                continue;
            }
            let short = shorten_to(word, MAX_WORD);
            self.tell(key.span(), || unknown("key", &short, known.iter().copied()));
            // A misspelled key stands for the one that was meant.
            meant.extend(nearest(&short, known.iter().copied()).map(str::to_string));
        }
        for key in parts.iter().flat_map(|part| list(part, "required")).filter_map(Value::as_str) {
            if !table.contains_key(key) && !meant.iter().any(|meant| meant == key) {
                self.tell(place.clone(), || format!("`{key}` is missing"));
            }
        }
    }

    /// Alternative that a value is probably meant to be: that of its kind, or the first of its type.
    fn meant(&self, value: &DeValue<'_>, choices: &'c [Value]) -> Option<&'c Value> {
        let kind_of = |key: &str| value.as_table()?.get(key)?.get_ref().as_str();
        let mut kinds = choices.iter().flat_map(|choice| self.kinds(choice));
        if let Some((_, _, schema)) = kinds.find(|(key, kind, _)| kind_of(key) == Some(*kind)) {
            return Some(schema);
        }
        let plain = choices.iter().filter(|choice| self.kinds(choice).is_empty());
        plain.map(|choice| self.resolved(choice)).find(|choice| fits(choice, value))
    }

    /// Plugins of an alternative: the key that holds the kind, the kind, and the schema.
    fn kinds(&self, choice: &'c Value) -> Vec<(&'static str, &'c str, &'c Value)> {
        let schema = self.resolved(choice);
        let kind = |key: &'static str| {
            let kind = schema.get("properties")?.get(key)?.get("const")?.as_str()?;
            Some((key, kind, schema))
        };
        match ["kind", "name"].into_iter().find_map(kind) {
            Some(kind) => vec![kind],
            None => choices(schema).iter().flat_map(|choice| self.kinds(choice)).collect(),
        }
    }

    /// Values that a schema accepts, in words.
    fn wanted(&self, schema: &'c Value, given: &DeValue<'_>) -> String {
        let schema = self.resolved(schema);
        if let [first, others @ ..] = choices(schema) {
            let mut all = vec![self.wanted(first, given)];
            for choice in others.iter().map(|choice| self.wanted(choice, given)) {
                if !all.contains(&choice) {
                    all.push(choice);
                }
            }
            return all.join(" or ");
        }
        let limit = |key: &str| schema.get(key).filter(|limit| limit.is_number());
        let is_negative = matches!(given, DeValue::Integer(number) if number.as_str().starts_with('-'));
        let number = |what: &str| match (limit("minimum"), limit("maximum")) {
            (Some(low), Some(high)) => format!("{what} from {low} to {high}"),
            // What counts something begins with 0 for the schema, and may begin later for its plugin.
            (Some(low), None) if low.as_u64() != Some(0) || is_negative => format!("{what} from {low} on"),
            _ => what.to_string(),
        };
        match schema.get("type").and_then(Value::as_str) {
            Some("integer") => number("a whole number"),
            Some("number") => number("a number"),
            Some("boolean") => "true or false".to_string(),
            Some("object") => limit("maxProperties")
                .map_or_else(|| "a table".to_string(), |most| format!("a table of at most {most}")),
            Some("array") => match (limit("minItems"), limit("maxItems")) {
                (Some(least), Some(most)) if least == most => format!("a list of {least}"),
                (_, Some(most)) => format!("a list of at most {most}"),
                (Some(_), None) => "a list that is not empty".to_string(),
                (None, None) => "a list".to_string(),
            },
            _ => "text in quotes".to_string(),
        }
    }
}

/// List under a key of a schema; empty without the key.
fn list<'v>(schema: &'v Value, key: &str) -> &'v [Value] {
    schema.get(key).and_then(Value::as_array).map(Vec::as_slice).unwrap_or_default()
}

/// Alternatives of a schema; empty if the schema has properties of its own, too.
fn choices(schema: &Value) -> &[Value] {
    if schema.get("properties").is_some() { &[] } else { list(schema, "anyOf") }
}

/// The words of a closed list.
fn words(schema: &Value) -> Vec<&str> {
    let described = list(schema, "oneOf").iter().filter_map(|choice| choice.get("const"));
    described.chain(list(schema, "enum")).filter_map(Value::as_str).collect()
}

/// Noun for the values of a key, used in messages.
fn noun(key: &str) -> &str {
    match key {
        "compute" => "analysis",
        "kind" => "figure kind",
        "maximise" => "metric to maximise",
        "name" => "tracker",
        key => key,
    }
}

/// True if a value has the type and is in the range of a schema.
fn fits(schema: &Value, value: &DeValue<'_>) -> bool {
    let limit = |key: &str| schema.get(key).and_then(Value::as_f64);
    let is_in = |number: f64, least: &str, most: &str| {
        limit(least).is_none_or(|least| number >= least) && limit(most).is_none_or(|most| number <= most)
    };
    match (schema.get("type").and_then(Value::as_str), value) {
        (None | Some("string"), DeValue::String(_)) | (Some("boolean"), DeValue::Boolean(_)) => true,
        // A closed list of words has a type for each of them.
        (None, _) => words(schema).is_empty(),
        (Some("object"), DeValue::Table(table)) => {
            is_in(table.len() as f64, "minProperties", "maxProperties")
        }
        (Some("array"), DeValue::Array(list)) => is_in(list.len() as f64, "minItems", "maxItems"),
        (Some("integer" | "number"), DeValue::Integer(number)) => {
            let number = i128::from_str_radix(number.as_str(), number.radix());
            let is_whole = |n: i128| (i128::from(i64::MIN)..=i128::from(u64::MAX)).contains(&n);
            number.is_ok_and(|n| is_whole(n) && is_in(n as f64, "minimum", "maximum"))
        }
        (Some("number"), DeValue::Float(number)) => {
            let number = number.as_str().parse::<f64>();
            number.is_ok_and(|n| n.is_finite() && is_in(n, "minimum", "maximum"))
        }
        _ => false,
    }
}

/// Description of a value for messages. A value of the right type and wrong length is described by its
/// length.
fn shown(value: &DeValue<'_>, wanted: &Value) -> String {
    let is_wanted = |word: &str| wanted.get("type").and_then(Value::as_str) == Some(word);
    let text = match value {
        DeValue::String(text) => return format!("{:?}", shorten_to(text, MAX_TEXT)),
        DeValue::Array(list) if list.is_empty() => "an empty list".to_string(),
        DeValue::Array(list) if is_wanted("array") => format!("a list of {}", list.len()),
        DeValue::Array(_) => "a list".to_string(),
        DeValue::Table(table) if is_wanted("object") => format!("a table of {}", table.len()),
        DeValue::Table(_) => "a table".to_string(),
        DeValue::Integer(number) => number.to_string(),
        DeValue::Float(number) => number.to_string(),
        DeValue::Boolean(truth) => truth.to_string(),
        DeValue::Datetime(time) => time.to_string(),
    };
    shorten_to(&text, MAX_TEXT)
}

#[cfg(test)]
pub(super) mod tests;
