//! Analyses of an experiment: what is computed from a signal, or from the regions of trackers, on whole suites.

use super::Tracker;
use super::error::{Source, SpecError};
use super::method::SignalChoice;
use super::raw_plugin::RawPlugin;
use super::wire;
use std::collections::BTreeMap;
use std::sync::Arc;
use toml::Spanned;
use toml::de::{DeTable, DeValue};
use trackfail_methods::analysis::{ANALYSES, Names};
use trackfail_methods::score::Restarts;
use trackfail_methods::signal::SIGNALS;
use trackfail_methods::tracker::process::Programs;

/// An analysis of an experiment.
pub struct Analysis {
    /// Name in the experiment.
    pub name: String,
    /// Plugin kind.
    pub kind: &'static str,
    /// Plugin version.
    pub version: u32,
    /// The checked analysis.
    pub plugin: Arc<dyn trackfail_methods::analysis::Analysis>,
    /// The signal; none for an analysis of regions.
    pub signal: Option<SignalChoice>,
    /// Roles of the suites, in order.
    pub roles: Vec<String>,
    /// Labels of the trackers whose tracks are analysed; all when `None`.
    pub trackers: Option<Vec<String>>,
}

impl Analysis {
    /// Whether tracks of a tracker are analysed.
    pub fn runs_on(&self, tracker: &str) -> bool {
        self.trackers.as_ref().is_none_or(|mine| mine.iter().any(|t| t == tracker))
    }

    /// Number of a tracker's runs that it takes of the suite in a place of [`roles`](Self::roles).
    pub fn runs(&self, place: usize, tracker: &Tracker) -> u32 {
        if self.plugin.is_tested(place) { tracker.runs } else { tracker.training_runs }
    }

    /// Names of the tables, charts and numbers that it computes.
    pub fn names(&self) -> Names {
        self.plugin.names(self.roles.len())
    }
}

/// Checks an `[[analysis]]`; `table` is the same item as `wire`, with the parameters of plugins not yet read.
pub(super) fn read(
    source: Source<'_>,
    programs: Option<&Programs>,
    wire: &wire::Analysis,
    table: &Spanned<DeTable<'_>>,
    suites: &BTreeMap<String, String>,
) -> Result<Analysis, SpecError> {
    let part = |key: &str| match table.get_ref().get(key).map(|value| (value.span(), value.get_ref())) {
        Some((span, DeValue::Table(t))) => Ok(Spanned::new(span, t.clone())),
        _ => Err(source.error(wire.name.span(), format!("an [[analysis]] needs a table `{key}`"))),
    };
    let plugin = RawPlugin::read(source, programs, part("compute")?, "analysis", ANALYSES)?;
    let (kind, version) = (plugin.entry.kind, plugin.entry.version);
    let plugin: Arc<dyn trackfail_methods::analysis::Analysis> = Arc::from(plugin.build(source, Vec::new())?);
    let signal = match (plugin.reads().has_signal(), wire.signal.is_some()) {
        (false, true) => {
            return Err(source.error(wire.name.span(), format!("{kind} takes no `signal`")));
        }
        (false, false) => None,
        (true, _) => {
            let signal = RawPlugin::read(source, programs, part("signal")?, "signal", SIGNALS)?;
            Some(SignalChoice {
                kind: signal.entry.kind,
                version: signal.entry.version,
                signal: Arc::from(signal.build(source, Vec::new())?),
                restarts: Restarts::default(),
            })
        }
    };
    for role in wire.suites.get_ref() {
        if !suites.contains_key(role) {
            return Err(source.unknown(
                wire.suites.span(),
                "suite role",
                role,
                suites.keys().map(String::as_str),
            ));
        }
    }
    let (min, max) = plugin.suites();
    let roles = wire.suites.get_ref().clone();
    if !(min..=max).contains(&roles.len()) {
        let message = format!("{kind} takes {min} to {max} suites, not {}", roles.len());
        return Err(source.error(wire.suites.span(), message));
    }
    Ok(Analysis { name: wire.name.get_ref().clone(), kind, version, plugin, signal, roles, trackers: None })
}
