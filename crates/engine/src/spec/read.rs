//! Reads the text of an experiment file into a checked [`Experiment`]. Reading ends at the first error.

use super::analysis::{self, Analysis};
use super::error::{Source, SpecError};
use super::extend::{self, Place};
use super::figure::{Figure, read_figure};
use super::limits::{self, MAX_BYTES, MAX_DETECTORS};
use super::method::{self, Method};
use super::name::{self, check_file_name, check_label, check_unique};
use super::table::{self, GridAxis, Published, Table, Words, inherit_published};
use super::{Experiment, OTHERS, TEST, Tracker, claim, raw_plugin, wire, written_out};
use crate::dataset::suite::Catalog;
use crate::plugin::{self, RawParams};
use crate::score::{self, Protocol};
use crate::tracker::TRACKERS;
use crate::tracker::process::Programs;
use crate::tracker::protocol::RunProtocol;
use serde::Deserialize;
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;
use std::sync::Arc;
use toml::Spanned;
use toml::de::{DeTable, DeValue};

/// Version of the format.
const SCHEMA: u32 = 1;

/// Largest number of repetitions of a tracker.
const MAX_RUNS: u32 = 1000;

/// Reads and checks an experiment on built-in suites, which can extend built-in experiments only; `file` names it in
/// messages. Programs that it names are not looked for and cannot be run.
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
    Reader { catalog, programs }.read(file, text, Place::BuiltIn)
}

/// Reads and checks an experiment file as [`parse_with`] does; it may extend files of its folder, too.
///
/// # Errors
/// A file that cannot be read, and as [`parse_with`].
pub fn read_file(
    path: &Path,
    catalog: &Catalog,
    programs: Option<&Programs>,
) -> Result<Experiment, SpecError> {
    let text = limits::read_text(path)?;
    let file = path.display().to_string();
    let place = Place::of(path).map_err(|e| Source::new(&file, &text).error(0..0, e.to_string()))?;
    Reader { catalog, programs }.read(&file, &text, place)
}

/// Names that an experiment may use.
struct Reader<'a> {
    catalog: &'a Catalog,
    programs: Option<&'a Programs>,
}

impl Reader<'_> {
    fn read(&self, file: &str, text: &str, place: Place) -> Result<Experiment, SpecError> {
        let source = Source::new(file, text);
        if text.len() > MAX_BYTES {
            return Err(source.error(0..0, format!("an experiment file has at most {MAX_BYTES} bytes")));
        }
        let document = DeTable::parse(text).map_err(|e| source.toml(&e, 0..0))?;
        if extend::is_complete(document.get_ref()) {
            return self.check(source, text, document);
        }
        let whole = extend::complete(file, text, place)?;
        let source = Source::merged(file, &whole.text, &whole.map);
        let document = DeTable::parse(&whole.text).map_err(|e| source.toml(&e, 0..0))?;
        self.check(source, &whole.text, document)
    }

    /// Checks an experiment that needs no other file.
    fn check(
        &self,
        source: Source<'_>,
        text: &str,
        mut document: Spanned<DeTable<'_>>,
    ) -> Result<Experiment, SpecError> {
        let tracker_params = split_tracker_params(source, &mut document)?;
        written_out::complete_methods(source, &mut document)?;
        let methods_raw = array_of_tables(source, &document, "method")?;
        let whole = Spanned::new(document.span(), DeValue::Table(document.get_ref().clone()));
        let wire =
            wire::Experiment::deserialize(RawParams::from(whole)).map_err(|e| source.toml(&e, 0..0))?;

        if *wire.schema.get_ref() != SCHEMA {
            let message =
                format!("schema {} is not known; this program reads {SCHEMA}", wire.schema.get_ref());
            return Err(source.error(wire.schema.span(), message));
        }
        name::check_experiment_name(wire.name.get_ref())
            .map_err(|e| source.error(wire.name.span(), e.to_string()))?;
        limits::check_lists(source, &wire)?;
        let protocol = wire.protocol.as_ref().map(|p| read_protocol(source, p)).transpose()?;
        let suites = read_suites(source, &wire, self.catalog)?;
        let trackers = read_trackers(source, &wire, tracker_params, self.programs)?;
        let methods = read_methods(source, self.programs, &wire, &methods_raw, protocol, &trackers)?;
        let analyses = read_analyses(source, self.programs, &wire, &document, &suites, &trackers, &methods)?;
        if methods.is_empty() && analyses.is_empty() {
            return Err(source.error(wire.method.span(), "there is no [[method]]"));
        }
        let runs = trackers.iter().map(|t| u64::from(t.runs.max(t.training_runs))).sum();
        limits::check_work(source, wire.method.span(), runs, &methods)?;
        check_roles(source, &wire, &methods, &suites)?;

        let words = words(self.catalog, &suites, &trackers, &methods, &analyses);
        let mut tables = read_tables(source, &wire, &words)?;
        let mut figures = read_figures(source, &wire, &words)?;
        if tables.is_empty() && figures.is_empty() && !methods.is_empty() {
            tables.push(Table::of_methods(&words));
            figures.extend(Figure::of_methods(&words));
        }
        let published = read_published(source, &wire, &tables)?;
        let published = inherit_published(published, &tables, &methods, &trackers);
        let claims =
            wire.claim.iter().map(|c| claim::read(source, c, &words)).collect::<Result<Vec<_>, _>>()?;
        Ok(Experiment {
            name: wire.name.into_inner(),
            title: wire.title,
            paper: wire.paper,
            object: wire.object,
            note: wire.note,
            leaderboard: wire.leaderboard,
            protocol,
            seed: wire.seed,
            suites,
            catalog: self.catalog.clone(),
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
}

fn read_methods(
    source: Source<'_>,
    programs: Option<&Programs>,
    wire: &wire::Experiment,
    tables: &[Spanned<DeTable<'_>>],
    protocol: Option<&'static Protocol>,
    trackers: &[Tracker],
) -> Result<Vec<Method>, SpecError> {
    let mut methods: Vec<Method> = Vec::new();
    let mut room = MAX_DETECTORS;
    for (m, table) in wire.method.get_ref().iter().zip(tables) {
        let name = m.name.get_ref();
        check_label(source, &m.name)?;
        check_unique(source, "method", &m.name, methods.iter().map(|m| m.name.as_str()))?;
        let its_own = m.protocol.as_ref().map(|p| read_protocol(source, p)).transpose()?;
        let Some(scored_by) = its_own.or(protocol) else {
            let message = format!("`{name}` has no `protocol`, and neither has the experiment");
            return Err(source.error(m.name.span(), message));
        };
        let mut method = method::read(source, programs, name, table, scored_by, room)?;
        method.like = m.like.as_ref().map(|like| like.get_ref().clone());
        method.trackers = m.trackers.as_ref().map(|t| read_labels(source, t, trackers)).transpose()?;
        room -= method.detectors();
        methods.push(method);
    }
    Ok(methods)
}

fn read_analyses(
    source: Source<'_>,
    programs: Option<&Programs>,
    wire: &wire::Experiment,
    document: &Spanned<DeTable<'_>>,
    suites: &BTreeMap<String, String>,
    trackers: &[Tracker],
    methods: &[Method],
) -> Result<Vec<Analysis>, SpecError> {
    let mut analyses: Vec<Analysis> = Vec::new();
    for (a, table) in wire.analysis.iter().zip(array_of_tables(source, document, "analysis")?) {
        check_file_name(source, &a.name)?;
        check_unique(source, "analysis", &a.name, analyses.iter().map(|a| a.name.as_str()))?;
        let mut analysis = analysis::read(source, programs, a, &table, suites)?;
        analysis.trackers = a.trackers.as_ref().map(|t| read_labels(source, t, trackers)).transpose()?;
        let known = || methods.iter().filter(|m| !m.has_grid()).map(|m| m.name.as_str());
        if let Some(wrong) = analysis.plugin.timed().0.iter().find(|name| !known().any(|k| k == *name)) {
            return Err(source.unknown(table.span(), "method without a grid", wrong, known()));
        }
        analyses.push(analysis);
    }
    Ok(analyses)
}

/// The names that tables, figures and claims may refer to.
fn words(
    catalog: &Catalog,
    suites: &BTreeMap<String, String>,
    trackers: &[Tracker],
    methods: &[Method],
    analyses: &[Analysis],
) -> Words {
    let axes: BTreeSet<&String> =
        methods.iter().flat_map(|m| &m.variants).flat_map(|v| v.point.iter().map(|(axis, _)| axis)).collect();
    let names =
        |keep: fn(&Method) -> bool| methods.iter().filter(|m| keep(m)).map(|m| m.name.clone()).collect();
    Words {
        methods: names(|_| true),
        trackers: trackers.iter().map(|t| t.label.clone()).collect(),
        axes: axes.into_iter().cloned().collect(),
        grids: methods.iter().flat_map(grid_axes).collect(),
        sequences: catalog.suite(&suites[TEST]).map_or_else(|_| Vec::new(), |s| s.sequence_names()),
        drawn: names(|m| !m.has_grid()),
        with_signal: names(|m| m.variants.iter().any(|v| v.signal.is_some())),
        analyses: analyses.iter().map(|a| (a.name.clone(), a.names())).collect(),
    }
}

/// The axes of a method's grid.
fn grid_axes(method: &Method) -> Vec<GridAxis> {
    let mut axes: Vec<GridAxis> = Vec::new();
    for (axis, value) in method.variants.iter().flat_map(|v| &v.point) {
        match axes.iter_mut().find(|known| known.axis == *axis) {
            Some(known) if known.values.contains(value) => {}
            Some(known) => known.values.push(*value),
            None => {
                axes.push(GridAxis { method: method.name.clone(), axis: axis.clone(), values: vec![*value] })
            }
        }
    }
    axes
}

fn read_tables(source: Source<'_>, wire: &wire::Experiment, words: &Words) -> Result<Vec<Table>, SpecError> {
    let mut tables: Vec<Table> = Vec::new();
    for t in &wire.table {
        check_unique(source, "table", &t.name, tables.iter().map(|t| t.name.as_str()))?;
        if let Some(other) = t.published.as_ref().filter(|o| tables.iter().all(|t| t.name != *o.get_ref())) {
            let before = tables.iter().map(|t| t.name.as_str());
            return Err(source.unknown(other.span(), "table before this one", other.get_ref(), before));
        }
        tables.push(table::read_table(source, t, words)?);
    }
    Ok(tables)
}

fn read_figures(
    source: Source<'_>,
    wire: &wire::Experiment,
    words: &Words,
) -> Result<Vec<Figure>, SpecError> {
    let mut figures: Vec<Figure> = Vec::new();
    for f in &wire.figure {
        check_unique(source, "figure", &f.name, figures.iter().map(|f| f.name.as_str()))?;
        figures.push(read_figure(source, f, words)?);
    }
    Ok(figures)
}

fn read_published(
    source: Source<'_>,
    wire: &wire::Experiment,
    tables: &[Table],
) -> Result<Vec<Published>, SpecError> {
    let mut published: Vec<Published> = Vec::new();
    for p in &wire.published {
        check_label(source, &p.tracker)?;
        let row = table::read_published(source, p, tables)?;
        if published.iter().any(|k| (&k.table, &k.tracker, &k.row) == (&row.table, &row.tracker, &row.row)) {
            let message = format!("`{}` of {} stands there twice", row.row, row.tracker);
            return Err(source.error(p.row.span(), message));
        }
        published.push(row);
    }
    Ok(published)
}

/// Takes the parameters of the plugin out of every `[[tracker]]`.
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
            ["name", "label", "like", "runs", "training_runs", "protocol"].contains(&key.get_ref().as_ref())
        });
        *table = known;
        all.push(Spanned::new(span, params));
    }
    Ok(all)
}

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

fn read_protocol(source: Source<'_>, name: &Spanned<String>) -> Result<&'static Protocol, SpecError> {
    score::protocol(name.get_ref()).ok_or_else(|| {
        let known = score::PROTOCOLS.iter().map(|p| p.name);
        source.unknown(name.span(), "protocol", name.get_ref(), known)
    })
}

/// Checks labels of trackers.
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
        if role == OTHERS {
            let message = "`others` is no role: it stands for the test suite without the sequence and the tracker at hand";
            return Err(source.error(suite.span(), message));
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
        let config =
            raw_plugin::build_entry(entry, &params, programs).map_err(|e| source.params(&e, &params))?;
        let protocol = read_run_protocol(source, entry.kind, t.protocol.as_ref())?;
        let repetitions = |key: &str, wanted: Option<&Spanned<u32>>, default: u32| match wanted {
            None => Ok(default),
            Some(n) if (1..=MAX_RUNS).contains(n.get_ref()) => Ok(*n.get_ref()),
            Some(n) => {
                let message = format!("`{key}` must be 1 to {MAX_RUNS}, not {}", n.get_ref());
                Err(source.error(n.span(), message))
            }
        };
        let runs = repetitions("runs", t.runs.as_ref(), protocol.runs().unwrap_or(1))?;
        let training_runs = repetitions("training_runs", t.training_runs.as_ref(), runs)?;
        let label = t.label.as_ref().unwrap_or(&t.name);
        check_label(source, label)?;
        let (span, label) = (label.span(), label.get_ref().clone());
        if trackers.iter().any(|known| known.label == label) {
            let message = format!("two trackers are called `{label}`; give one a `label`");
            return Err(source.error(span, message));
        }
        let (kind, version) = (entry.kind, entry.version);
        let max_runs = protocol.runs().unwrap_or(MAX_RUNS);
        if runs.max(training_runs) > max_runs {
            let message = format!("`{}` has {max_runs} runs", protocol.name());
            return Err(source.error(t.runs.as_ref().map_or(span, Spanned::span), message));
        }
        let setup = protocol.over(Arc::from(config));
        if let Some(like) = t.like.as_ref().filter(|like| trackers.iter().all(|b| b.label != *like.get_ref()))
        {
            let before = trackers.iter().map(|b| b.label.as_str());
            return Err(source.unknown(like.span(), "tracker before this one", like.get_ref(), before));
        }
        let like = t.like.as_ref().map(|like| like.get_ref().clone());
        trackers.push(Tracker { label, like, kind, version, runs, training_runs, protocol, setup });
    }
    if trackers.is_empty() {
        return Err(source.error(wire.tracker.span(), "there is no [[tracker]]"));
    }
    Ok(trackers)
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

fn check_roles(
    source: Source<'_>,
    wire: &wire::Experiment,
    methods: &[Method],
    suites: &BTreeMap<String, String>,
) -> Result<(), SpecError> {
    for (m, wire) in methods.iter().zip(wire.method.get_ref()) {
        for variant in &m.variants {
            if let Some(role) = variant.detector.role()
                && role != OTHERS
                && !suites.contains_key(role)
            {
                let known = suites.keys().map(String::as_str).chain([OTHERS]);
                return Err(source.unknown(wire.name.span(), "suite role", role, known));
            }
        }
    }
    Ok(())
}
