//! Plugins of an experiment file: the tables of their parameters, checked and bound to the programs that they name.

use super::error::{Errors, Source, SpecError, in_plain_words};
use std::ops::Range;
use toml::Spanned;
use toml::de::{DeTable, DeValue, ValueDeserializer};
use trackfail_core::plugin::{self, Entry, ParamError, RawParams};
use trackfail_methods::tracker::process::{Bind, Programs};

/// Most numbers that are tried to find the first that a plugin takes.
const MAX_TRIED: u64 = 64;

/// A plugin's table: its kind is known, its parameters are not yet read.
pub(super) struct RawPlugin<'i, T: ?Sized + 'static> {
    pub(super) entry: &'static Entry<T>,
    pub(super) table: Spanned<DeTable<'i>>,
    /// The programs that it may run.
    pub(super) programs: Option<&'i Programs>,
}

impl<'i, T: ?Sized + Bind> RawPlugin<'i, T> {
    pub(super) fn read(
        source: Source<'_>,
        programs: Option<&'i Programs>,
        mut table: Spanned<DeTable<'i>>,
        what: &str,
        list: &'static [Entry<T>],
    ) -> Result<Self, SpecError> {
        let Some(kind) = table.get_mut().remove("kind") else {
            return Err(source.error(table.span(), format!("the {what} has no `kind`")));
        };
        let kinds = list.iter().map(|e| e.kind);
        let Some(word) = kind.get_ref().as_str() else {
            return Err(source.error(kind.span(), format!("the {what}'s `kind` must be text")));
        };
        let Some(entry) = plugin::find(list, word) else {
            return Err(source.unknown(kind.span(), what, word, kinds));
        };
        Ok(Self { entry, table, programs })
    }

    /// Names of the parameters, from the plugin's schema.
    pub(super) fn keys(&self) -> Vec<String> {
        let schema = (self.entry.schema)();
        let properties = schema.get("properties").and_then(serde_json::Value::as_object);
        properties.map(|p| p.keys().cloned().collect()).unwrap_or_default()
    }

    pub(super) fn build(
        &self,
        source: Source<'_>,
        set: Vec<(&str, Spanned<DeValue<'_>>)>,
    ) -> Result<Box<T>, SpecError> {
        let table = self.with(set);
        build(source, self.entry, &table, self.programs)
    }

    /// The table with some values set.
    pub(super) fn with<'t>(&'t self, set: Vec<(&str, Spanned<DeValue<'t>>)>) -> Spanned<DeTable<'t>> {
        let mut table: Spanned<DeTable<'t>> = self.table.clone();
        for (key, value) in set {
            table.get_mut().remove(key);
            // The key gets the value's place, so that the error of a refused grid value points at the grid.
            table.get_mut().insert(Spanned::new(value.span(), key.to_string().into()), value);
        }
        table
    }
}

/// Builds a plugin from a table of the file; it may run `programs`.
pub(super) fn build_entry<T: ?Sized + Bind>(
    entry: &Entry<T>,
    table: &Spanned<DeTable<'_>>,
    programs: Option<&Programs>,
) -> Result<Box<T>, ParamError> {
    let mut built = (entry.build)(RawParams::Toml(ValueDeserializer::from(as_value(table))))?;
    programs.map_or(Ok(()), |programs| built.bind(programs))?;
    Ok(built)
}

pub(super) fn as_value<'t>(table: &Spanned<DeTable<'t>>) -> Spanned<DeValue<'t>> {
    Spanned::new(table.span(), DeValue::Table(table.get_ref().clone()))
}

/// Builds a plugin from a table of the file; it may run `programs`.
///
/// # Errors
/// All parameters that are wrong.
pub(super) fn build<T: ?Sized + Bind>(
    source: Source<'_>,
    entry: &Entry<T>,
    table: &Spanned<DeTable<'_>>,
    programs: Option<&Programs>,
) -> Result<Box<T>, SpecError> {
    let mut rest = table.clone();
    let mut errors = Errors::default();
    let mut gone: Vec<String> = Vec::new();
    while let Err(fault) = build_entry(entry, &rest, programs) {
        let key = key_at_fault(&fault, &rest);
        let follows = key.is_none() || gone.iter().any(|known| fault.message.contains(&format!("`{known}`")));
        if !gone.is_empty() && follows {
            break;
        }
        let plain = key.as_deref().and_then(|key| {
            in_plain_words(&fault.message, Some(key), || first_number(entry, &rest, key, programs))
        });
        let fault = ParamError { message: plain.unwrap_or_else(|| fault.message.clone()), ..fault };
        errors.push(source.params(&fault, &rest));
        let Some(key) = key.filter(|_| !errors.is_full()) else { break };
        rest.get_mut().remove(key.as_str());
        gone.push(key);
    }
    errors.check()?;
    build_entry(entry, table, programs).map_err(|fault| source.params(&fault, table))
}

/// The parameter that a plugin refuses.
fn key_at_fault(fault: &ParamError, table: &Spanned<DeTable<'_>>) -> Option<String> {
    let at = |key: Range<usize>, value: Range<usize>| {
        let span = fault.span.clone()?;
        (key == span || (value.start <= span.start && span.end <= value.end)).then_some(())
    };
    let named = |key: &str| fault.span.is_none() && fault.key == Some(key);
    let found = table
        .get_ref()
        .iter()
        .find(|(key, value)| named(key.get_ref()) || at(key.span(), value.span()).is_some());
    found.map(|(key, _)| key.get_ref().to_string())
}

/// The smallest whole number that a plugin does not refuse as this parameter.
fn first_number<T: ?Sized + Bind>(
    entry: &Entry<T>,
    table: &Spanned<DeTable<'_>>,
    key: &str,
    programs: Option<&Programs>,
) -> u64 {
    let is_refused = |number: &u64| {
        let text = number.to_string();
        let Ok(number) = DeValue::parse(&text) else { return false };
        let mut tried: Spanned<DeTable<'_>> = table.clone();
        tried.get_mut().insert(Spanned::new(0..0, key.to_string().into()), number);
        build_entry(entry, &tried, programs).is_err_and(|fault| fault.key == Some(key))
    };
    (0..MAX_TRIED).find(|number| !is_refused(number)).unwrap_or(0)
}
