//! Trackers of an experiment file.

use super::{Known, MAX_RUNS};
use crate::spec::error::{Errors, Source, SpecError};
use crate::spec::name::check_label;
use crate::spec::{Absence, Tracker, raw_plugin, wire};
use std::collections::BTreeSet;
use std::sync::Arc;
use toml::Spanned;
use toml::de::{DeTable, DeValue};
use trackfail_core::plugin;
use trackfail_dataset::suite::Catalog;
use trackfail_methods::tracker::TRACKERS;
use trackfail_methods::tracker::process::Programs;
use trackfail_methods::tracker::protocol::RunProtocol;

/// Takes the parameters of the plugin out of every `[[tracker]]`.
pub(super) fn split_params<'i>(
    source: Source<'_>,
    document: &mut Spanned<DeTable<'i>>,
) -> Result<Vec<Spanned<DeTable<'i>>>, SpecError> {
    let Some(trackers) = document.get_mut().get_mut("tracker") else { return Ok(Vec::new()) };
    let span = trackers.span();
    let DeValue::Array(list) = trackers.get_mut() else {
        return Err(source.error(span, "trackers are written as [[tracker]]"));
    };
    let mut all = Vec::new();
    for item in list.iter_mut() {
        let span = item.span();
        let DeValue::Table(table) = item.get_mut() else {
            return Err(source.error(span, "trackers are written as [[tracker]]"));
        };
        let (known, params) = std::mem::take(table).into_iter().partition(|(key, _)| {
            let own =
                ["name", "label", "family", "like", "runs", "training_runs", "protocol", "sources", "absent"];
            own.contains(&key.get_ref().as_ref())
        });
        *table = known;
        all.push(Spanned::new(span, params));
    }
    Ok(all)
}

/// Checks every `[[tracker]]`; `params` are the parameters of their plugins.
pub(super) fn read_trackers(
    source: Source<'_>,
    wire: &wire::Experiment,
    params: Vec<Spanned<DeTable<'_>>>,
    known: &Known<'_>,
    errors: &mut Errors,
) -> Vec<Tracker> {
    let all = wire.tracker.get_ref();
    let mut trackers: Vec<Tracker> = Vec::new();
    for (k, (t, params)) in all.iter().zip(params).enumerate() {
        let label = t.label.as_ref().unwrap_or(&t.name);
        for word in t.family.iter().chain([label]) {
            errors.keep(check_label(source, word));
        }
        let before = || known.labels[..k].iter().map(String::as_str);
        if before().any(|other| other == label.get_ref()) {
            let message = format!("two trackers are called `{}`; give one a `label`", label.get_ref());
            errors.push(source.error(label.span(), message));
            continue;
        }
        if let Some(like) = t.like.as_ref().filter(|like| !before().any(|b| b == like.get_ref())) {
            errors.push(source.unknown(like.span(), "tracker before this one", like.get_ref(), before()));
        }
        trackers.extend(read_tracker(source, t, &params, known.programs, errors));
    }
    trackers
}

fn read_tracker(
    source: Source<'_>,
    wire: &wire::Tracker,
    params: &Spanned<DeTable<'_>>,
    programs: Option<&Programs>,
    errors: &mut Errors,
) -> Option<Tracker> {
    let mut repetitions = |key: &str, wanted: Option<&Spanned<u32>>| match wanted {
        Some(n) if !(1..=MAX_RUNS).contains(n.get_ref()) => {
            let message = format!("`{key}` must be 1 to {MAX_RUNS}, not {}", n.get_ref());
            errors.push(source.error(n.span(), message));
            None
        }
        given => given.map(|n| *n.get_ref()),
    };
    let (runs, training_runs) =
        (repetitions("runs", wire.runs.as_ref()), repetitions("training_runs", wire.training_runs.as_ref()));
    let kinds = TRACKERS.iter().map(|e| e.kind);
    let entry = plugin::find(TRACKERS, wire.name.get_ref())
        .ok_or_else(|| source.unknown(wire.name.span(), "tracker", wire.name.get_ref(), kinds));
    let entry = errors.keep(entry)?;
    let config = errors.keep(raw_plugin::build(source, entry, params, programs));
    let protocol = errors.keep(read_run_protocol(source, entry.kind, wire.protocol.as_ref()))?;
    let runs = runs.unwrap_or(protocol.runs().unwrap_or(1));
    let training_runs = training_runs.unwrap_or(runs);
    let absent =
        wire.absent.iter().flatten().filter_map(|a| errors.keep(read_absence(source, entry.kind, a)));
    let absent = absent.collect();
    let label = wire.label.as_ref().unwrap_or(&wire.name);
    let max_runs = protocol.runs().unwrap_or(MAX_RUNS);
    if runs.max(training_runs) > max_runs {
        let message = format!("`{}` has {max_runs} runs", protocol.name());
        let span = wire.runs.as_ref().map_or(label.span(), Spanned::span);
        errors.push(source.error(span, message));
    }
    Some(Tracker {
        label: label.get_ref().clone(),
        family: wire.family.as_ref().map(|family| family.get_ref().clone()),
        like: wire.like.as_ref().map(|like| like.get_ref().clone()),
        kind: entry.kind,
        version: entry.version,
        runs,
        training_runs,
        sources: wire.sources.as_ref().map(|list| list.iter().map(|s| s.get_ref().clone()).collect()),
        absent,
        protocol,
        setup: protocol.over(Arc::from(config?)),
    })
}

/// A track that is declared not to be there; only results that are replayed are known beforehand.
fn read_absence(
    source: Source<'_>,
    kind: &str,
    wire::Absence { sequence, reason }: &wire::Absence,
) -> Result<Absence, SpecError> {
    if kind != "replay" {
        let message =
            "only results that are replayed can be declared `absent`; a tracker that is run has failed";
        return Err(source.error(sequence.span(), message));
    }
    if reason.get_ref().trim().is_empty() {
        return Err(source.error(reason.span(), "`reason` must say why there is no track"));
    }
    Ok(Absence { sequence: sequence.get_ref().clone(), reason: reason.get_ref().clone() })
}

/// Checks that tracks are declared absent on sequences that the experiment has.
pub(super) fn check_data(
    source: Source<'_>,
    wire: &wire::Experiment,
    known: &Known<'_>,
    catalog: &Catalog,
    errors: &mut Errors,
) {
    let suites = known.suites.values().map(|name| catalog.suite(name).ok());
    // Where a suite is wrong, its sequences are not known.
    let Some(suites) = suites.collect::<Option<Vec<_>>>() else { return };
    let names: BTreeSet<String> = suites.iter().flat_map(|suite| suite.sequence_names()).collect();
    for absence in wire.tracker.get_ref().iter().flat_map(|t| t.absent.iter().flatten()) {
        let name = &absence.sequence;
        if !names.is_empty() && !names.contains(name.get_ref()) {
            let known = names.iter().map(String::as_str);
            errors.push(source.unknown(name.span(), "sequence", name.get_ref(), known));
        }
    }
    let sources: BTreeSet<String> = suites.iter().flat_map(|suite| suite.sources()).collect();
    for name in wire.tracker.get_ref().iter().flat_map(|t| t.sources.iter().flatten()) {
        if !sources.contains(name.get_ref()) {
            let known = sources.iter().map(String::as_str);
            errors.push(source.unknown(name.span(), "source of videos", name.get_ref(), known));
        }
    }
}

/// Run protocol of a tracker; replayed results have theirs already.
fn read_run_protocol(
    source: Source<'_>,
    kind: &str,
    name: Option<&Spanned<String>>,
) -> Result<RunProtocol, SpecError> {
    let Some(name) = name else { return Ok(RunProtocol::OnePass) };
    if kind == "replay" {
        let message =
            "results that are replayed were made under a protocol already; it cannot be chosen here";
        return Err(source.error(name.span(), message));
    }
    RunProtocol::from_name(name.get_ref()).ok_or_else(|| {
        let known = RunProtocol::ALL.iter().map(|p| p.name());
        source.unknown(name.span(), "protocol of trackers", name.get_ref(), known)
    })
}
