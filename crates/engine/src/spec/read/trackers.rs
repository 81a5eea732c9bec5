//! Trackers of an experiment file.

use super::{Known, MAX_RUNS};
use crate::spec::error::At;
use crate::spec::name::check_label;
use crate::spec::{Tracker, raw_plugin, wire};
use std::collections::BTreeSet;
use trackfail_core::plugin;
use trackfail_dataset::suite::Catalog;
use trackfail_methods::tracker::TRACKERS;
use trackfail_methods::tracker::protocol::RunProtocol;

fn label(wire: &wire::Tracker) -> &String {
    wire.label.as_ref().unwrap_or(&wire.name)
}

/// Checks all `[[tracker]]` items; `at` is their list.
pub(super) fn read_trackers(at: At<'_>, all: &[wire::Tracker], known: &Known<'_>) -> Vec<Tracker> {
    let mut trackers: Vec<Tracker> = Vec::new();
    for (k, tracker) in all.iter().enumerate() {
        let (at, label) = (at.item(k), label(tracker));
        let in_label = at.key(if tracker.label.is_some() { "label" } else { "name" });
        check_label(in_label, label, false);
        tracker.family.iter().for_each(|family| check_label(at.key("family"), family, false));
        if all[..k].iter().any(|other| self::label(other) == label) {
            in_label.tell(format!("two trackers are called `{label}`; give one a `label`"));
        }
        let before = known.words.trackers.iter().map(String::as_str).take_while(|other| *other != label);
        if let Some(like) = &tracker.like {
            at.key("like").knows("tracker before this one", like, before);
        }
        trackers.extend(read_tracker(at, tracker, known));
    }
    trackers
}

fn read_tracker(at: At<'_>, wire: &wire::Tracker, known: &Known<'_>) -> Option<Tracker> {
    let entry = plugin::find(TRACKERS, &wire.name)?;
    let is_replayed = entry.kind == "replay";
    if wire.protocol.is_some() && is_replayed {
        let message =
            "results that are replayed were made under a protocol already; it cannot be chosen here";
        at.key("protocol").tell(message);
    }
    let protocol = wire.protocol.as_deref().and_then(RunProtocol::from_name).unwrap_or(RunProtocol::OnePass);
    let runs = wire.runs.unwrap_or(protocol.runs().unwrap_or(1));
    let training_runs = wire.training_runs.unwrap_or(runs);
    let max_runs = protocol.runs().unwrap_or(MAX_RUNS);
    if runs.max(training_runs) > max_runs {
        at.key("runs").tell(format!("`{}` has {max_runs} runs", protocol.name()));
    }
    let absent = wire.absent.clone().unwrap_or_default();
    for (k, absence) in absent.iter().enumerate() {
        let at = at.key("absent").item(k);
        // Only results that are replayed are known beforehand.
        if !is_replayed {
            let message =
                "only results that are replayed can be declared `absent`; a tracker that is run has failed";
            at.key("sequence").tell(message);
        } else if absence.reason.trim().is_empty() {
            at.key("reason").tell("`reason` must say why there is no track");
        }
    }
    let setup = raw_plugin::build(entry, wire.params.clone(), known.programs);
    let setup = setup.map_err(|fault| raw_plugin::tell(at, &fault)).ok()?;
    Some(Tracker {
        label: label(wire).clone(),
        family: wire.family.clone(),
        like: wire.like.clone(),
        kind: entry.kind,
        version: entry.version,
        runs,
        training_runs,
        sources: wire.sources.clone(),
        absent,
        protocol,
        setup: protocol.over(setup),
    })
}

/// Checks that tracks are declared absent, and trackers limited to sources, only for sequences and sources of
/// the experiment; `at` is the list of trackers.
pub(super) fn check_data(at: At<'_>, all: &[wire::Tracker], known: &Known<'_>, catalog: &Catalog) {
    let suites = known.suites.values().map(|name| catalog.suite(name).ok());
    // Where a suite is wrong, its sequences are not known.
    let Some(suites) = suites.collect::<Option<Vec<_>>>().filter(|suites| !suites.is_empty()) else { return };
    let names: BTreeSet<String> = suites.iter().flat_map(|suite| suite.sequence_names()).collect();
    let sources: BTreeSet<String> = suites.iter().flat_map(|suite| suite.sources()).collect();
    for (k, tracker) in all.iter().enumerate() {
        let at = at.item(k);
        for (k, absence) in tracker.absent.iter().flatten().enumerate() {
            if !names.is_empty() && !names.contains(&absence.sequence) {
                let at = at.key("absent").item(k).key("sequence");
                at.tell_unknown("sequence", &absence.sequence, names.iter().map(String::as_str));
            }
        }
        for (k, name) in tracker.sources.iter().flatten().enumerate() {
            let at = at.key("sources").item(k);
            at.knows("source of videos", name, sources.iter().map(String::as_str));
        }
    }
}
