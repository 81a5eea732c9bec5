//! Plugins of an experiment file: the tables of their parameters, checked and bound to the programs that they name.

use super::error::{Source, SpecError};
use super::recover;
use crate::analysis::Analysis;
use crate::detector::Detector;
use crate::plugin::{self, Entry, ParamError, RawParams};
use crate::signal::Signal;
use crate::tracker::TrackerConfig;
use crate::tracker::process::Programs;
use toml::Spanned;
use toml::de::{DeTable, DeValue};

/// A plugin's table: its kind is known, its parameters are not yet read.
pub(super) struct RawPlugin<'i, T: ?Sized + 'static> {
    pub(super) entry: &'static Entry<T>,
    pub(super) table: Spanned<DeTable<'i>>,
    /// The programs that it may run.
    pub(super) programs: Option<&'i Programs>,
}

/// A plugin that may name a program.
pub(super) trait Bind {
    /// Binds it to its program, if it names one.
    fn bind_to(&mut self, programs: &Programs) -> Result<(), ParamError>;
}

impl Bind for dyn Signal {
    fn bind_to(&mut self, programs: &Programs) -> Result<(), ParamError> {
        self.bind(programs)
    }
}

impl Bind for dyn Detector {
    fn bind_to(&mut self, programs: &Programs) -> Result<(), ParamError> {
        self.bind(programs)
    }
}

impl Bind for dyn TrackerConfig {
    fn bind_to(&mut self, programs: &Programs) -> Result<(), ParamError> {
        self.bind(programs)
    }
}

impl Bind for dyn Analysis {
    fn bind_to(&mut self, _: &Programs) -> Result<(), ParamError> {
        Ok(())
    }
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
        recover::build(source, self.entry, &table, self.programs)
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
    let mut built = (entry.build)(RawParams::from(as_value(table)))?;
    programs.map_or(Ok(()), |programs| built.bind_to(programs))?;
    Ok(built)
}

pub(super) fn as_value<'t>(table: &Spanned<DeTable<'t>>) -> Spanned<DeValue<'t>> {
    Spanned::new(table.span(), DeValue::Table(table.get_ref().clone()))
}
