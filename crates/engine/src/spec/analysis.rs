//! Analyses of an experiment, computed on whole suites from a signal or from the regions of trackers.

use super::Tracker;
use super::error::At;
use super::method::SignalChoice;
use super::raw_plugin::RawPlugin;
use super::wire;
use super::words::Known;
use trackfail_core::plugin::Configured;
use trackfail_methods::analysis::{ANALYSES, Names};
use trackfail_methods::signal::SIGNALS;

/// An analysis of an experiment.
pub struct Analysis {
    /// Name in the experiment.
    pub name: String,
    /// Plugin kind.
    pub kind: &'static str,
    /// Plugin version.
    pub version: u32,
    /// Plugin with checked parameters.
    pub plugin: Configured<dyn trackfail_methods::analysis::Analysis>,
    /// Signal to analyze; `None` for an analysis of regions.
    pub signal: Option<SignalChoice>,
    /// Roles of the suites, in the order that the analysis expects.
    pub roles: Vec<String>,
    /// Labels of the trackers whose tracks are analyzed; `None` for all.
    pub trackers: Option<Vec<String>>,
}

impl Analysis {
    /// True if the tracks of a tracker are analyzed.
    pub fn runs_on(&self, tracker: &str) -> bool {
        self.trackers.as_ref().is_none_or(|mine| mine.iter().any(|t| t == tracker))
    }

    /// Number of a tracker's runs that are analyzed on the suite at index `place` of [`roles`](Self::roles).
    pub fn runs(&self, place: usize, tracker: &Tracker) -> u32 {
        if self.plugin.is_tested(place) { tracker.runs } else { tracker.training_runs }
    }

    /// Names of the tables, charts and numbers that the analysis computes.
    pub fn names(&self) -> Names {
        self.plugin.layout(self.roles.len()).names()
    }
}

/// Checks an `[[analysis]]`.
pub(super) fn read(at: At<'_>, wire: &wire::Analysis, known: &Known<'_>) -> Option<Analysis> {
    let Known { programs, suites, .. } = *known;
    let compute = RawPlugin::read(at.key("compute"), programs, &wire.compute, "analysis", ANALYSES)?;
    let (kind, version) = (compute.entry.kind, compute.entry.version);
    let plugin: Configured<dyn trackfail_methods::analysis::Analysis> = compute.build(&[], at)?;
    let signal = match (plugin.reads().has_signal(), &wire.signal) {
        (false, None) => None,
        (true, Some(signal)) => {
            let signal = RawPlugin::read(at.key("signal"), programs, signal, "signal", SIGNALS)?;
            Some(SignalChoice::new(signal.entry, signal.build(&[], at)?))
        }
        (has_signal, _) => {
            let wants = if has_signal { "needs a" } else { "takes no" };
            return at.key("name").refuse(format!("{kind} {wants} `signal`"));
        }
    };
    let in_suites = at.key("suites");
    let roles = wire.suites.clone();
    if let Some(role) = roles.iter().find(|role| !suites.is_empty() && !suites.contains_key(*role)) {
        in_suites.tell_unknown("suite role", role, suites.keys().map(String::as_str));
    }
    let (min, max) = plugin.suites();
    if !(min..=max).contains(&roles.len()) {
        in_suites.tell(format!("{kind} takes {min} to {max} suites, not {}", roles.len()));
    }
    let (name, trackers) = (wire.name.clone(), wire.trackers.clone());
    Some(Analysis { name, kind, version, plugin, signal, roles, trackers })
}
