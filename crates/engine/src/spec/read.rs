//! Reads the text of an experiment file into a checked [`Experiment`]. Reading goes on after an error: whoever refers to a
//! part that is wrong still finds its name, and what follows only from an error is not told.

mod trackers;
mod words;
mod work;

use super::analysis::{self, Analysis};
use super::document::array_of_tables;
use super::error::{Errors, Source, SpecError};
use super::extend::{self, Place};
use super::figure::{Figure, read_figure};
use super::limits::{self, MAX_BYTES, MAX_DETECTORS};
use super::method::{self, Method};
use super::name::{self, check_file_name, check_label, check_method_name, check_unique};
use super::recover::{self, Shape};
use super::table::{self, Published, Table, Words, inherit_published};
use super::{Experiment, OTHERS, TEST, claim, wire, written_out};
use std::collections::{BTreeMap, BTreeSet};
use std::ops::Range;
use std::path::Path;
use toml::Spanned;
use toml::de::{DeTable, DeValue};
use trackfail_dataset::suite::Catalog;
use trackfail_methods::score::{self, Protocol};
use trackfail_methods::tracker::process::Programs;

/// Version of the format.
pub(super) const SCHEMA: u32 = 1;

/// Largest number of repetitions of a tracker.
pub(super) const MAX_RUNS: u32 = 1000;

/// Reads and checks an experiment on built-in suites, which can extend built-in experiments only; `file` names it in
/// messages. Programs that it names are not looked for and cannot be run.
///
/// # Errors
/// Everything that is wrong.
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
        let document = source.syntax()?;
        if extend::is_complete(document.get_ref()) {
            return self.check(source, without_directive(text), document);
        }
        let whole = extend::complete(file, text, place)?;
        let source = Source::merged(file, &whole.text, &whole.map);
        let document = source.syntax()?;
        self.check(source, &whole.text, document)
    }

    /// Checks an experiment that needs no other file.
    fn check(
        &self,
        source: Source<'_>,
        text: &str,
        mut document: Spanned<DeTable<'_>>,
    ) -> Result<Experiment, SpecError> {
        let mut errors = Errors::default();
        let mut params = trackers::split_params(source, &mut document)?;
        let incomplete = written_out::complete_methods(source, &mut document, &mut errors)?;
        let Some(Shape { wire, cut, items }) = recover::read_shape(source, &mut document, &mut errors) else {
            return Err(errors.check().err().unwrap_or_else(|| source.error(0..0, "cannot be read")));
        };
        let kept: BTreeSet<usize> = places(&document, "tracker").iter().map(|place| place.start).collect();
        params.retain(|table| kept.contains(&table.span().start));
        let methods_raw = array_of_tables(source, &document, "method")?;

        if *wire.schema.get_ref() != SCHEMA {
            let message =
                format!("schema {} is not known; this program reads {SCHEMA}", wire.schema.get_ref());
            errors.push(source.error(wire.schema.span(), message));
        }
        let name = name::check_experiment_name(wire.name.get_ref());
        errors.keep(name.map_err(|e| source.error(wire.name.span(), e.to_string())));
        // Nothing is built from lists that are too long.
        if errors.keep(limits::check_lists(source, &wire)).is_none() {
            return Err(errors.check().err().unwrap_or_else(|| source.error(0..0, "too much")));
        }
        let protocol = wire.protocol.as_ref().map(|p| read_protocol(source, p));
        // Where the protocol is wrong, methods are not told that they have none.
        let in_place = Some(&score::PROTOCOLS[0]).filter(|_| cut.contains("protocol"));
        let protocol = protocol.map(|read| errors.keep(read).unwrap_or(&score::PROTOCOLS[0])).or(in_place);
        let suites = read_suites(source, &wire, self.catalog, cut.contains("suites"), &mut errors);
        let known = Known { programs: self.programs, labels: labels(&wire), suites: &suites };
        let trackers = trackers::read_trackers(source, &wire, params, &known, &mut errors);
        trackers::check_data(source, &wire, &known, self.catalog, &mut errors);
        if wire.tracker.get_ref().is_empty() && !cut.contains("tracker") {
            errors.push(source.error(wire.tracker.span(), "there is no [[tracker]]"));
        }
        let raw: Vec<_> = wire.method.get_ref().iter().zip(&methods_raw).collect();
        let is_wrong = |place: &Range<usize>| incomplete.contains(place) || items.contains(place);
        let right: Vec<_> = raw.iter().filter(|(_, table)| !is_wrong(&table.span())).copied().collect();
        let methods = read_methods(source, &right, protocol, &known, &mut errors);
        let analyses = read_analyses(source, &wire, &document, &known, (&items, &mut errors))?;
        if raw.is_empty() && wire.analysis.is_empty() && cut.is_empty() {
            errors.push(source.error(wire.method.span(), "there is no [[method]]"));
        }
        if errors.is_empty() {
            let runs = trackers.iter().map(|t| u64::from(t.runs.max(t.training_runs))).sum();
            work::check_work(source, wire.method.span(), runs, &methods)?;
        }

        let words = words::words(self.catalog, &wire, &suites, &known.labels, &methods, &analyses);
        let parts = Parts::of(&wire, &analyses, words.sequences.is_empty(), |key| {
            places(&document, key).iter().map(|place| items.contains(place)).collect()
        });
        let mut tables = read_tables(source, &wire, &words, &parts, &mut errors);
        let mut figures = read_figures(source, &wire, &words, &parts, &mut errors);
        if wire.table.is_empty() && wire.figure.is_empty() && errors.is_empty() && !methods.is_empty() {
            tables.push(Table::of_methods(&words));
            figures.extend(Figure::of_methods(&words));
        }
        let published = read_published(source, &wire, &tables, &parts, &mut errors);
        let published = inherit_published(published, &tables, &methods, &trackers);
        let claims = parts.whole("claim", &wire.claim).map(|(_, claim)| claim);
        let claims = claims.filter(|c| parts.is_readable(c.holds.get_ref()));
        let claims = claims.filter_map(|c| errors.keep(claim::read(source, c, &words))).collect();
        errors.check()?;
        Ok(Experiment {
            name: wire.name.into_inner(),
            title: wire.title,
            paper: wire.paper,
            object: wire.object,
            note: wire.note,
            leaderboard: wire.leaderboard,
            protocol,
            seed: wire.seed,
            folds: wire.folds,
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

/// A text without the line that tells editors where its schema is, which is no part of the experiment.
pub(super) fn without_directive(text: &str) -> &str {
    match text.split_once('\n') {
        Some((first, rest)) if first.starts_with("#:schema ") => rest,
        _ => text,
    }
}

/// Places of the items of a list.
fn places(document: &Spanned<DeTable<'_>>, key: &str) -> Vec<Range<usize>> {
    match document.get_ref().get(key).map(Spanned::get_ref) {
        Some(DeValue::Array(list)) => list.iter().map(Spanned::span).collect(),
        _ => Vec::new(),
    }
}

/// Labels of all trackers, whether or not they are right.
fn labels(wire: &wire::Experiment) -> Vec<String> {
    wire.tracker.get_ref().iter().map(|t| t.label.as_ref().unwrap_or(&t.name).get_ref().clone()).collect()
}

/// Names of the experiment that its items refer to.
struct Known<'a> {
    programs: Option<&'a Programs>,
    /// Labels of trackers.
    labels: Vec<String>,
    /// Role -> suite.
    suites: &'a BTreeMap<String, String>,
}

/// Parts of a wrong experiment that are not known, so that what refers to them cannot be checked.
struct Parts {
    /// `NAME.` of analyses that are wrong.
    analyses: Vec<String>,
    /// Whether the sequences are not known.
    no_sequences: bool,
    /// List -> whether each of its items has lost something.
    cut: BTreeMap<&'static str, Vec<bool>>,
}

impl Parts {
    fn of(
        wire: &wire::Experiment,
        analyses: &[Analysis],
        no_sequences: bool,
        cut: impl Fn(&str) -> Vec<bool>,
    ) -> Self {
        let is_wrong = |name: &&String| analyses.iter().all(|a| a.name != **name);
        let names = wire.analysis.iter().map(|a| a.name.get_ref());
        let analyses = names.filter(is_wrong).map(|name| format!("{name}.")).collect();
        let lists = ["table", "figure", "published", "claim"];
        Self { analyses, no_sequences, cut: lists.map(|key| (key, cut(key))).into() }
    }

    /// The items of a list that have lost nothing, each with its number.
    fn whole<'w, T>(&self, key: &str, items: &'w [T]) -> impl Iterator<Item = (usize, &'w T)> {
        let cut = self.cut.get(key).cloned().unwrap_or_default();
        items.iter().enumerate().filter(move |(k, _)| !cut.get(*k).is_some_and(|cut| *cut))
    }

    fn is_readable(&self, text: &str) -> bool {
        !self.analyses.iter().any(|name| text.contains(name.as_str()))
    }

    fn shown(&self, shows: Option<&Spanned<String>>) -> bool {
        shows.is_none_or(|shows| self.is_readable(shows.get_ref()))
    }
}

fn read_methods(
    source: Source<'_>,
    raw: &[(&wire::Method, &Spanned<DeTable<'_>>)],
    protocol: Option<&'static Protocol>,
    known: &Known<'_>,
    errors: &mut Errors,
) -> Vec<Method> {
    let mut methods: Vec<Method> = Vec::new();
    let mut room = MAX_DETECTORS;
    for (k, (m, table)) in raw.iter().enumerate() {
        let name = m.name.get_ref();
        errors.keep(check_method_name(source, &m.name));
        let before = raw[..k].iter().map(|(m, _)| m.name.get_ref().as_str());
        if errors.keep(check_unique(source, "method", &m.name, before)).is_none() {
            continue;
        }
        let its_own = m.protocol.as_ref().map(|p| read_protocol(source, p));
        let its_own = its_own.map(|read| errors.keep(read).unwrap_or(&score::PROTOCOLS[0]));
        let Some(scored_by) = its_own.or(protocol) else {
            let message = format!("`{name}` has no `protocol`, and neither has the experiment");
            errors.push(source.error(m.name.span(), message));
            continue;
        };
        let trackers = m.trackers.as_ref().map(|t| read_labels(source, t, &known.labels));
        let trackers = trackers.and_then(|read| errors.keep(read));
        let read = method::read(source, known.programs, name, table, scored_by, room);
        let Some(mut method) = errors.keep(read) else { continue };
        method.like = m.like.as_ref().map(|like| like.get_ref().clone());
        method.trackers = trackers;
        errors.keep(check_roles(source, m, &method, known.suites));
        room -= method.detectors();
        methods.push(method);
    }
    methods
}

fn read_analyses(
    source: Source<'_>,
    wire: &wire::Experiment,
    document: &Spanned<DeTable<'_>>,
    known: &Known<'_>,
    (cut, errors): (&[Range<usize>], &mut Errors),
) -> Result<Vec<Analysis>, SpecError> {
    let mut analyses: Vec<Analysis> = Vec::new();
    let all = wire.method.get_ref().iter();
    let without_grid: Vec<&str> =
        all.filter(|m| m.grid.is_none()).map(|m| m.name.get_ref().as_str()).collect();
    for (k, (a, table)) in
        wire.analysis.iter().zip(array_of_tables(source, document, "analysis")?).enumerate()
    {
        if cut.contains(&table.span()) {
            continue;
        }
        errors.keep(check_file_name(source, &a.name));
        let before = wire.analysis[..k].iter().map(|a| a.name.get_ref().as_str());
        if errors.keep(check_unique(source, "analysis", &a.name, before)).is_none() {
            continue;
        }
        let trackers = a.trackers.as_ref().map(|t| read_labels(source, t, &known.labels));
        let trackers = trackers.and_then(|read| errors.keep(read));
        let read = analysis::read(source, known.programs, a, &table, known.suites);
        let Some(mut analysis) = errors.keep(read) else { continue };
        analysis.trackers = trackers;
        let names = || without_grid.iter().copied();
        if let Some(wrong) = analysis.plugin.timed().0.iter().find(|name| !names().any(|k| k == *name)) {
            errors.push(source.unknown(table.span(), "method without a grid", wrong, names()));
        }
        analyses.push(analysis);
    }
    Ok(analyses)
}

fn read_tables(
    source: Source<'_>,
    wire: &wire::Experiment,
    words: &Words,
    parts: &Parts,
    errors: &mut Errors,
) -> Vec<Table> {
    let mut tables: Vec<Table> = Vec::new();
    for (k, t) in parts.whole("table", &wire.table).filter(|(_, t)| parts.shown(t.shows.as_ref())) {
        let before = || wire.table[..k].iter().map(|t| t.name.get_ref().as_str());
        if errors.keep(check_unique(source, "table", &t.name, before())).is_none() {
            continue;
        }
        if let Some(other) = t.published.as_ref().filter(|o| !before().any(|name| name == o.get_ref())) {
            errors.push(source.unknown(other.span(), "table before this one", other.get_ref(), before()));
        }
        tables.extend(errors.keep(table::read_table(source, t, words)));
    }
    tables
}

fn read_figures(
    source: Source<'_>,
    wire: &wire::Experiment,
    words: &Words,
    parts: &Parts,
    errors: &mut Errors,
) -> Vec<Figure> {
    let mut figures: Vec<Figure> = Vec::new();
    let known =
        |f: &wire::Figure| parts.shown(f.shows.as_ref()) && (f.sequences.is_empty() || !parts.no_sequences);
    for (k, f) in parts.whole("figure", &wire.figure).filter(|(_, f)| known(f)) {
        let before = wire.figure[..k].iter().map(|f| f.name.get_ref().as_str());
        if errors.keep(check_unique(source, "figure", &f.name, before)).is_none() {
            continue;
        }
        figures.extend(errors.keep(read_figure(source, f, words)));
    }
    figures
}

/// The published numbers of tables that are right.
fn read_published(
    source: Source<'_>,
    wire: &wire::Experiment,
    tables: &[Table],
    parts: &Parts,
    errors: &mut Errors,
) -> Vec<Published> {
    let mut published: Vec<Published> = Vec::new();
    let is_wrong = |name: &String| {
        wire.table.iter().any(|t| t.name.get_ref() == name) && tables.iter().all(|t| t.name != *name)
    };
    for (_, p) in parts.whole("published", &wire.published).filter(|(_, p)| !is_wrong(p.table.get_ref())) {
        errors.keep(check_label(source, &p.tracker));
        let Some(row) = errors.keep(table::read_published(source, p, tables)) else { continue };
        if published.iter().any(|k| (&k.table, &k.tracker, &k.row) == (&row.table, &row.tracker, &row.row)) {
            let message = format!("`{}` of {} is listed twice", row.row, row.tracker);
            errors.push(source.error(p.row.span(), message));
            continue;
        }
        published.push(row);
    }
    published
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
    labels: &[String],
) -> Result<Vec<String>, SpecError> {
    if let Some(wrong) = list.iter().find(|name| !labels.contains(name.get_ref())) {
        return Err(source.unknown(
            wrong.span(),
            "tracker",
            wrong.get_ref(),
            labels.iter().map(String::as_str),
        ));
    }
    Ok(list.iter().map(|name| name.get_ref().clone()).collect())
}

/// The suite of each role, also of those that are wrong; `cut` tells that some could not be read at all.
fn read_suites(
    source: Source<'_>,
    wire: &wire::Experiment,
    catalog: &Catalog,
    cut: bool,
    errors: &mut Errors,
) -> BTreeMap<String, String> {
    let mut suites = BTreeMap::new();
    for (role, suite) in wire.suites.get_ref() {
        if !catalog.names().any(|known| known == suite.get_ref()) {
            errors.push(source.unknown(suite.span(), "suite", suite.get_ref(), catalog.names()));
        }
        if role == OTHERS {
            let message = "`others` is no role: it stands for the test suite without the sequence and the tracker at hand";
            errors.push(source.error(suite.span(), message));
        }
        suites.insert(role.clone(), suite.get_ref().clone());
    }
    if !suites.contains_key(TEST) && !cut {
        errors.push(source.error(wire.suites.span(), "[suites] has no `test`"));
    }
    suites
}

fn check_roles(
    source: Source<'_>,
    wire: &wire::Method,
    method: &Method,
    suites: &BTreeMap<String, String>,
) -> Result<(), SpecError> {
    for variant in &method.variants {
        if let Some(role) = variant.detector.role()
            && role != OTHERS
            && !suites.contains_key(role)
        {
            let known = suites.keys().map(String::as_str).chain([OTHERS]);
            return Err(source.unknown(wire.name.span(), "suite role", role, known));
        }
    }
    Ok(())
}
