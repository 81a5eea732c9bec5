//! Plugins of an experiment file: reading their parameters, and building them with the programs that they
//! name.

use super::error::At;
use serde_json::{Map, Value};
use trackfail_core::plugin::{self, Configured, Entry, ParamError, RawParams};
use trackfail_methods::tracker::process::{Bind, Programs};

/// A plugin whose kind is known and whose parameters are not yet read.
pub(super) struct RawPlugin<'a, T: ?Sized + 'static> {
    pub entry: &'static Entry<T>,
    pub params: Map<String, Value>,
    /// Programs that the plugin may run; `None` if there is no list of programs.
    pub programs: Option<&'a Programs>,
    /// Place of the plugin in the file.
    pub at: At<'a>,
}

impl<'a, T: ?Sized + Bind> RawPlugin<'a, T> {
    /// Looks up the kind in a list of plugins.
    pub fn read(
        at: At<'a>,
        programs: Option<&'a Programs>,
        params: &Value,
        what: &str,
        list: &'static [Entry<T>],
    ) -> Option<Self> {
        let mut params = params.as_object().cloned().unwrap_or_default();
        let kind = params.remove("kind");
        let entry = kind.as_ref().and_then(Value::as_str).and_then(|kind| plugin::find(list, kind));
        if entry.is_none() {
            at.tell(format!("the {what} has no `kind`"));
        }
        Some(Self { entry: entry?, params, programs, at })
    }

    /// Names of the parameters, from the plugin's schema.
    pub fn keys(&self) -> Vec<String> {
        let schema = (self.entry.schema)();
        let properties = schema.get("properties").and_then(Value::as_object);
        properties.map(|p| p.keys().cloned().collect()).unwrap_or_default()
    }

    /// Parameters, with some values replaced.
    pub fn with(&self, set: &[(String, Value)]) -> Map<String, Value> {
        let mut params = self.params.clone();
        params.extend(set.iter().cloned());
        params
    }

    /// Builds the plugin with the values `set`, which stand in the `grid`.
    pub fn build(&self, set: &[(String, Value)], grid: At<'_>) -> Option<Configured<T>> {
        let built = build(self.entry, self.with(set), self.programs);
        let is_set = |e: &ParamError| set.iter().any(|(key, _)| parameter(e) == Some(key.as_str()));
        built.map_err(|e| tell(if is_set(&e) { grid } else { self.at }, &e)).ok()
    }
}

/// Builds a plugin, which may run `programs`.
///
/// # Errors
/// The first rule that the parameters break.
pub(super) fn build<T: ?Sized + Bind>(
    entry: &Entry<T>,
    params: Map<String, Value>,
    programs: Option<&Programs>,
) -> Result<Configured<T>, ParamError> {
    let mut built = (entry.build)(RawParams::Json(&Value::Object(params)))?;
    programs.map_or(Ok(()), |programs| T::bind(&mut built, programs))?;
    Ok(built)
}

/// Reports why the parameters in a table are refused, at the wrong one.
pub(super) fn tell(at: At<'_>, fault: &ParamError) {
    parameter(fault).map_or(at, |key| at.key(key)).tell(fault.message.as_str());
}

/// Name of the wrong parameter: the one that is named, or with which the message begins.
fn parameter(fault: &ParamError) -> Option<&str> {
    let first = || fault.message.strip_prefix('`')?.split(['`', '.', '[']).next();
    fault.key.or_else(first)
}
