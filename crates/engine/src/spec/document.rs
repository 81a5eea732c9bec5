//! Parts of a TOML document with their places in the file.

use super::error::{Source, SpecError};
use toml::Spanned;
use toml::de::{DeTable, DeValue};

/// Tables of an array of tables, each with its place in the file.
pub(super) fn array_of_tables<'i>(
    source: Source<'_>,
    document: &Spanned<DeTable<'i>>,
    key: &str,
) -> Result<Vec<Spanned<DeTable<'i>>>, SpecError> {
    let Some(value) = document.get_ref().get(key) else { return Ok(Vec::new()) };
    let wrong = |span| source.error(span, format!("write [[{key}]]"));
    let DeValue::Array(list) = value.get_ref() else { return Err(wrong(value.span())) };
    list.iter()
        .map(|item| match item.get_ref() {
            DeValue::Table(t) => Ok(Spanned::new(item.span(), t.clone())),
            _ => Err(wrong(item.span())),
        })
        .collect()
}
