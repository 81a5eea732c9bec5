//! From the text of an experiment file to a checked [`Experiment`]. The first thing that is wrong ends
//! the reading, with its line.

use super::error::{Source, SpecError};
use super::figure::{Figure, read_figure};
use super::limits::{self, LONGEST, MOST_DETECTORS};
use super::table::{self, Words};
use super::{Experiment, TEST, Tracker, analysis, claim, method, wire};
use crate::dataset::suite::Catalog;
use crate::dataset::text;
use crate::plugin::{self, RawParams};
use crate::score::{self, Protocol};
use crate::tracker::TRACKERS;
use crate::tracker::process::Programs;
use crate::tracker::protocol::RunProtocol;
use serde::Deserialize;
use std::collections::BTreeMap;
use std::sync::Arc;
use toml::Spanned;
use toml::de::{DeTable, DeValue};

/// Version of the format.
const SCHEMA: u32 = 1;

/// Most repetitions of a tracker.
const MOST_RUNS: u32 = 1000;

/// Reads and checks an experiment on built-in suites; `file` names it in messages. Programs that it names are not
/// looked for and cannot be run.
///
/// # Errors
/// The first thing that is wrong.
pub fn parse(file: &str, text: &str) -> Result<Experiment, SpecError> {
    parse_with(file, text, &Catalog::default(), None)
}

/// Reads and checks an experiment on suites of `catalog` that may run `programs`, as [`parse`] does.
///
/// # Errors
/// As [`parse`], and a program that is not among them.
pub fn parse_with(
    file: &str,
    text: &str,
    catalog: &Catalog,
    programs: Option<&Programs>,
) -> Result<Experiment, SpecError> {
    let source = Source { file, text };
    if text.len() > LONGEST {
        return Err(source.error(0..0, format!("an experiment file has at most {LONGEST} bytes")));
    }
    let mut document = DeTable::parse(text).map_err(|e| source.toml(&e, 0..0))?;
    let tracker_params = split_tracker_params(source, &mut document)?;
    complete_methods(source, &mut document)?;
    let methods_raw = array_of_tables(source, &document, "method")?;
    let whole = Spanned::new(document.span(), DeValue::Table(document.get_ref().clone()));
    let wire = wire::Experiment::deserialize(RawParams::from(whole)).map_err(|e| source.toml(&e, 0..0))?;

    if *wire.schema.get_ref() != SCHEMA {
        let message = format!("schema {} is not known; this program reads {SCHEMA}", wire.schema.get_ref());
        return Err(source.error(wire.schema.span(), message));
    }
    check_experiment_name(wire.name.get_ref()).map_err(|message| source.error(wire.name.span(), message))?;
    limits::check_lists(source, &wire)?;
    let protocol = wire.protocol.as_ref().map(|p| read_protocol(source, p)).transpose()?;
    let suites = read_suites(source, &wire, catalog)?;
    let trackers = read_trackers(source, &wire, tracker_params, programs)?;
    let mut methods: Vec<method::Method> = Vec::new();
    let mut room = MOST_DETECTORS;
    for (m, raw) in wire.method.get_ref().iter().zip(&methods_raw) {
        let name = m.name.get_ref();
        check_label(source, &m.name)?;
        if methods.iter().any(|known| known.name == *name) {
            return Err(source.error(m.name.span(), format!("method `{name}` stands there twice")));
        }
        let own = m.protocol.as_ref().map(|p| read_protocol(source, p)).transpose()?;
        let Some(scored_by) = own.or(protocol) else {
            let message = format!("`{name}` has no `protocol`, and neither has the experiment");
            return Err(source.error(m.name.span(), message));
        };
        let mut method = method::read(source, name, raw, scored_by, room)?;
        method.trackers = m.trackers.as_ref().map(|t| read_labels(source, t, &trackers)).transpose()?;
        room -= method.detectors();
        methods.push(method);
    }
    let mut analyses: Vec<analysis::Analysis> = Vec::new();
    for (a, raw) in wire.analysis.iter().zip(array_of_tables(source, &document, "analysis")?) {
        table::check_file_name(source, &a.name)?;
        check_twice(source, "analysis", &a.name, analyses.iter().map(|a| a.name.as_str()))?;
        let mut analysis = analysis::read(source, a, &raw, &suites)?;
        analysis.trackers = a.trackers.as_ref().map(|t| read_labels(source, t, &trackers)).transpose()?;
        let timed = |m: &&method::Method| m.variants.iter().all(|v| v.point.is_empty());
        let known = || methods.iter().filter(timed).map(|m| m.name.as_str());
        if let Some(wrong) = analysis.plugin.timed().0.iter().find(|name| !known().any(|k| k == *name)) {
            return Err(source.unknown(raw.span(), "method without a grid", wrong, known()));
        }
        analyses.push(analysis);
    }
    if methods.is_empty() && analyses.is_empty() {
        return Err(source.error(wire.method.span(), "there is no [[method]]"));
    }
    let runs = trackers.iter().map(|t| u64::from(t.runs.max(t.training_runs))).sum();
    limits::check_work(source, wire.method.span(), runs, &methods)?;
    check_roles(source, &wire, &methods, &suites)?;

    let mut axes: Vec<String> = methods
        .iter()
        .flat_map(|m| &m.variants)
        .flat_map(|v| v.point.iter().map(|(axis, _)| axis.clone()))
        .collect();
    axes.sort();
    axes.dedup();
    let name = |m: &method::Method| m.name.clone();
    let words = Words {
        methods: methods.iter().map(|m| m.name.clone()).collect(),
        trackers: trackers.iter().map(|t| t.label.clone()).collect(),
        axes,
        sequences: catalog.suite(&suites[TEST]).map_or_else(|_| Vec::new(), |s| s.sequence_names()),
        drawn: methods.iter().filter(|m| m.variants.iter().all(|v| v.point.is_empty())).map(name).collect(),
        with_signal: methods
            .iter()
            .filter(|m| m.variants.iter().any(|v| v.signal.is_some()))
            .map(name)
            .collect(),
        analyses: analyses.iter().map(|a| (a.name.clone(), a.names())).collect(),
    };
    let mut tables = Vec::new();
    for t in &wire.table {
        check_twice(source, "table", &t.name, tables.iter().map(|t: &table::Table| t.name.as_str()))?;
        tables.push(table::read_table(source, t, &words)?);
    }
    let mut figures = Vec::new();
    for f in &wire.figure {
        check_twice(source, "figure", &f.name, figures.iter().map(|f: &Figure| f.name.as_str()))?;
        figures.push(read_figure(source, f, &words)?);
    }
    let mut published: Vec<table::Published> = Vec::new();
    for p in &wire.published {
        check_label(source, &p.tracker)?;
        let row = table::read_published(source, p, &tables)?;
        if published.iter().any(|k| (&k.table, &k.tracker, &k.row) == (&row.table, &row.tracker, &row.row)) {
            let message = format!("`{}` of {} stands there twice", row.row, row.tracker);
            return Err(source.error(p.row.span(), message));
        }
        published.push(row);
    }
    let claims = wire.claim.iter().map(|c| claim::read(source, c, &words)).collect::<Result<Vec<_>, _>>()?;
    Ok(Experiment {
        name: wire.name.into_inner(),
        title: wire.title,
        paper: wire.paper,
        object: wire.object,
        note: wire.note,
        protocol,
        seed: wire.seed,
        suites,
        catalog: catalog.clone(),
        trackers,
        methods,
        analyses,
        tables,
        figures,
        published,
        claims,
        source: text.to_string(),
    })
}

fn check_twice<'k>(
    source: Source<'_>,
    what: &str,
    name: &Spanned<String>,
    mut known: impl Iterator<Item = &'k str>,
) -> Result<(), SpecError> {
    if known.any(|k| k == name.get_ref()) {
        return Err(source.error(name.span(), format!("{what} `{}` stands there twice", name.get_ref())));
    }
    Ok(())
}

/// Names of methods and trackers appear in tables, claims and file columns.
fn check_label(source: Source<'_>, name: &Spanned<String>) -> Result<(), SpecError> {
    check_label_text(name.get_ref()).map_err(|message| source.error(name.span(), message))
}

fn check_label_text(name: &str) -> Result<(), String> {
    let forbidden = |c: char| !text::is_plain(c) || "[]=,;+\"".contains(c);
    // Spreadsheets take a field that begins with one of = + - @ for a formula.
    let formula = name.starts_with(['-', '@']);
    let length = name.chars().count();
    if name.trim() != name || !(1..=64).contains(&length) || name.contains(forbidden) || formula {
        let name = text::shorten_to(name, 64);
        return Err(format!(
            "the name {name:?} must have 1 to 64 characters, none of [ ] = , ; + \", no outer spaces, no \
             control characters, and not begin with - or @"
        ));
    }
    Ok(())
}

/// Whether a text can be the name of an experiment, and with it the path of its folders.
///
/// # Errors
/// What a name must be.
pub fn check_experiment_name(name: &str) -> Result<(), String> {
    if name.len() > 128 || !name.split('/').all(table::is_word) {
        return Err("`name` must be words of a-z, 0-9, `-` and `_`, joined by `/`".to_string());
    }
    Ok(())
}

/// Takes the plugin's own keys out of every `[[tracker]]`.
fn split_tracker_params<'i>(
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
            ["name", "label", "runs", "training_runs", "protocol"].contains(&key.get_ref().as_ref())
        });
        *table = known;
        all.push(Spanned::new(span, params));
    }
    Ok(all)
}

/// Fills `signal` and `detector` of methods that give only a published name.
fn complete_methods<'i>(source: Source<'_>, document: &mut Spanned<DeTable<'i>>) -> Result<(), SpecError> {
    let Some(methods) = document.get_mut().get_mut("method") else { return Ok(()) };
    let span = methods.span();
    let DeValue::Array(list) = methods.get_mut() else {
        return Err(source.error(span, "methods are written as [[method]]"));
    };
    for item in list.iter_mut() {
        let span = item.span();
        let DeValue::Table(table) = item.get_mut() else { continue };
        let Some(name) = table.get("name").and_then(|n| n.get_ref().as_str()).map(str::to_string) else {
            continue;
        };
        if table.contains_key("signal") || table.contains_key("detector") {
            continue;
        }
        let catalogue = super::builtin::method_tables();
        let Some(known) = catalogue.iter().find(|t| t.0 == name) else {
            let names = catalogue.iter().map(|t| t.0.as_str());
            return Err(source.unknown(span, "published method", &name, names.clone()));
        };
        for (key, value) in known.1.get_ref() {
            if key.get_ref() != "name" {
                table.insert(Spanned::new(span.clone(), key.get_ref().clone()), value.clone());
            }
        }
    }
    Ok(())
}

/// The tables of an array of tables, each with its place.
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

fn read_protocol(source: Source<'_>, name: &Spanned<String>) -> Result<&'static Protocol, SpecError> {
    score::protocol(name.get_ref()).ok_or_else(|| {
        let known = score::PROTOCOLS.iter().map(|p| p.name);
        source.unknown(name.span(), "protocol", name.get_ref(), known)
    })
}

/// Labels of trackers of the experiment, at least one.
fn read_labels(
    source: Source<'_>,
    list: &[Spanned<String>],
    trackers: &[Tracker],
) -> Result<Vec<String>, SpecError> {
    let known = || trackers.iter().map(|t| t.label.as_str());
    if let Some(wrong) = list.iter().find(|name| !known().any(|k| k == name.get_ref())) {
        return Err(source.unknown(wrong.span(), "tracker", wrong.get_ref(), known()));
    }
    Ok(list.iter().map(|name| name.get_ref().clone()).collect())
}

fn read_suites(
    source: Source<'_>,
    wire: &wire::Experiment,
    catalog: &Catalog,
) -> Result<BTreeMap<String, String>, SpecError> {
    let mut suites = BTreeMap::new();
    for (role, suite) in wire.suites.get_ref() {
        if !catalog.names().any(|known| known == suite.get_ref()) {
            return Err(source.unknown(suite.span(), "suite", suite.get_ref(), catalog.names()));
        }
        suites.insert(role.clone(), suite.get_ref().clone());
    }
    if !suites.contains_key(TEST) {
        return Err(source.error(wire.suites.span(), "[suites] has no `test`"));
    }
    Ok(suites)
}

fn read_trackers(
    source: Source<'_>,
    wire: &wire::Experiment,
    params: Vec<Spanned<DeTable<'_>>>,
    programs: Option<&Programs>,
) -> Result<Vec<Tracker>, SpecError> {
    let mut trackers: Vec<Tracker> = Vec::new();
    for (t, params) in wire.tracker.get_ref().iter().zip(params) {
        let kinds = TRACKERS.iter().map(|e| e.kind);
        let entry = plugin::find(TRACKERS, t.name.get_ref())
            .ok_or_else(|| source.unknown(t.name.span(), "tracker", t.name.get_ref(), kinds))?;
        let mut setup = method::build_entry(entry, &params).map_err(|e| source.params(&e, &params))?;
        if let Some(programs) = programs {
            setup.bind(programs).map_err(|e| source.params(&e, &params))?;
        }
        let protocol = read_run_protocol(source, entry.kind, t.protocol.as_ref())?;
        let repetitions = |key: &str, wanted: Option<&Spanned<u32>>, default: u32| match wanted {
            None => Ok(default),
            Some(n) if (1..=MOST_RUNS).contains(n.get_ref()) => Ok(*n.get_ref()),
            Some(n) => {
                let message = format!("`{key}` must be 1 to {MOST_RUNS}, not {}", n.get_ref());
                Err(source.error(n.span(), message))
            }
        };
        let runs = repetitions("runs", t.runs.as_ref(), protocol.runs().unwrap_or(1))?;
        let training_runs = repetitions("training_runs", t.training_runs.as_ref(), runs)?;
        let span = t.label.as_ref().map_or(t.name.span(), Spanned::span);
        let label = t.label.as_ref().map_or_else(|| entry.kind.to_string(), |l| l.get_ref().clone());
        check_label_text(&label).map_err(|message| source.error(span.clone(), message))?;
        if trackers.iter().any(|known| known.label == label) {
            let message = format!("two trackers are called `{label}`; give one a `label`");
            return Err(source.error(span, message));
        }
        let (kind, version) = (entry.kind, entry.version);
        let most = protocol.runs().unwrap_or(MOST_RUNS);
        if runs.max(training_runs) > most {
            let message = format!("`{}` has {most} runs", protocol.name());
            return Err(source.error(t.runs.as_ref().map_or(span, Spanned::span), message));
        }
        let setup = protocol.over(Arc::from(setup));
        trackers.push(Tracker { label, kind, version, runs, training_runs, protocol, setup });
    }
    if trackers.is_empty() {
        return Err(source.error(wire.tracker.span(), "there is no [[tracker]]"));
    }
    Ok(trackers)
}

/// How a tracker is run; results that are replayed were made under one already.
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

fn check_roles(
    source: Source<'_>,
    wire: &wire::Experiment,
    methods: &[method::Method],
    suites: &BTreeMap<String, String>,
) -> Result<(), SpecError> {
    for (m, wire) in methods.iter().zip(wire.method.get_ref()) {
        for variant in &m.variants {
            if let Some(role) = variant.detector.role()
                && !suites.contains_key(role)
            {
                let known = suites.keys().map(String::as_str);
                return Err(source.unknown(wire.name.span(), "suite role", role, known));
            }
        }
    }
    Ok(())
}
