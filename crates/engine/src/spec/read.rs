//! Reads the text of an experiment file into a checked [`Experiment`]. Reading goes on after errors.
//! References to wrong parts still find the name, so that errors which only follow from others are not
//! reported.

use super::analysis::{self, Analysis};
use super::check;
use super::error::{At, Errors, Source, SourceFile, SpecError};
use super::extend::{self, Folder};
use super::figure::Figure;
use super::limits::{self, MAX_BYTES, MAX_DETECTORS};
use super::method::{self, Method};
use super::name::{self, check_file_name, check_label, named};
use super::schema::OF_WHOLE_FILES;
use super::table::{self, Published, Table, Words, all_known};
use super::words::Known;
use super::{Experiment, OTHERS, TEST, Tracker, builtin, claim, raw_plugin, wire, written_out};
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;
use toml::Spanned;
use toml::de::DeTable;
use trackfail_core::plugin;
use trackfail_dataset::suite::Catalog;
use trackfail_methods::score;
use trackfail_methods::tracker::TRACKERS;
use trackfail_methods::tracker::process::Programs;
use trackfail_methods::tracker::protocol::RunProtocol;

/// Version of the format.
pub(super) const SCHEMA: u32 = 1;

/// Most repetitions of a tracker.
pub(super) const MAX_RUNS: u32 = 1000;

/// Reads and checks an experiment on built-in suites, which can extend built-in experiments only; `file` is
/// its name in messages. Programs that it names are neither looked up nor run.
///
/// # Errors
/// All errors of the text.
pub fn parse(file: &str, text: &str) -> Result<Experiment, SpecError> {
    parse_with(file, text, &Catalog::default(), None)
}

/// Reads and checks an experiment as [`parse`] does, with the suites of `catalog` and with `programs`.
///
/// # Errors
/// The errors of [`parse`], and an unknown program.
pub fn parse_with(
    file: &str,
    text: &str,
    catalog: &Catalog,
    programs: Option<&Programs>,
) -> Result<Experiment, SpecError> {
    Reader { catalog, programs }.read(file, text, None)
}

/// Reads and checks an experiment file as [`parse_with`] does. The experiment may also extend files of its
/// folder.
///
/// # Errors
/// The errors of [`parse_with`], and a file that cannot be read.
pub fn read_file(
    path: &Path,
    catalog: &Catalog,
    programs: Option<&Programs>,
) -> Result<Experiment, SpecError> {
    let text = limits::read_text(path)?;
    let file = path.display().to_string();
    let folder = Folder::of(path).map_err(|e| SpecError::of_file(file.clone(), e.to_string()))?;
    Reader { catalog, programs }.read(&file, &text, Some(folder))
}

/// Suites and programs that an experiment may use.
struct Reader<'a> {
    catalog: &'a Catalog,
    programs: Option<&'a Programs>,
}

impl Reader<'_> {
    fn read(&self, file: &str, text: &str, folder: Option<Folder>) -> Result<Experiment, SpecError> {
        let first = SourceFile::new(file, text);
        if text.len() > MAX_BYTES {
            return Err(first.error(0..0, format!("an experiment file has at most {MAX_BYTES} bytes")));
        }
        let files = extend::load(first, folder)?;
        let document = files[0].syntax()?;
        if extend::is_complete(document.get_ref()) {
            return self.check(Source(&files), without_directive(text), document);
        }
        let (text, document) = extend::complete(&files)?;
        self.check(Source(&files), &text, document)
    }

    /// Checks an experiment that is complete in itself.
    fn check(
        &self,
        source: Source<'_>,
        text: &str,
        mut document: Spanned<DeTable<'_>>,
    ) -> Result<Experiment, SpecError> {
        let errors = Errors::default();
        if let Err(place) = written_out::complete_methods(document.get_mut()) {
            let message = format!("methods take more than {MAX_BYTES} bytes from those that they are `like`");
            return Err(source.error(place, message));
        }
        let mut words = Words::of(document.get_ref());
        let stand_ins = DeTable::parse(STAND_INS).map(Spanned::into_inner).unwrap_or_default();
        let document = check::check(source, &OF_WHOLE_FILES, document, stand_ins, &errors);
        let at = At::new(source, &document, &errors);
        let wire = at.read::<wire::Experiment>();
        let experiment = wire.map(|wire| self.build(at, wire, &mut words, text));
        errors.or(experiment)
    }

    /// Builds an experiment and reports its errors: unknown names, refused parameters of plugins, and invalid
    /// claims.
    fn build(&self, at: At<'_>, wire: wire::Experiment, words: &mut Words, text: &str) -> Experiment {
        let (in_trackers, in_methods) = (at.key("tracker"), at.key("method"));
        if wire.schema != SCHEMA {
            let message = format!("schema {} is not known; this program reads {SCHEMA}", wire.schema);
            at.key("schema").tell(message);
        }
        if let Err(fault) = name::check_experiment_name(&wire.name) {
            at.key("name").tell(fault);
        }
        let wrong = wire.beside.as_ref().and_then(|beside| match name::check_experiment_name(beside) {
            Err(_) => Some("`beside` must be the name of an experiment, such as `benchmark/otb`"),
            Ok(()) if *beside == wire.name => Some("`beside` must name another experiment"),
            Ok(()) => wire.method.is_empty().then_some("`beside` needs a [[method]]"),
        });
        wrong.into_iter().for_each(|wrong| at.key("beside").tell(wrong));
        // Where the protocol is wrong, methods are not told that they have none.
        let in_place = score::PROTOCOLS.first().filter(|_| words.has_protocol);
        let protocol = wire.protocol.as_deref().and_then(score::protocol).or(in_place);
        read_suites(at.key("suites"), &wire.suites, self.catalog);
        let known = Known { programs: self.programs, suites: &wire.suites, words, protocol };
        let trackers = read_trackers(in_trackers, &wire.tracker, &known);
        check_data(in_trackers, &wire.tracker, &known, self.catalog);
        if wire.tracker.is_empty() && at.is_fine() {
            in_trackers.tell("there is no [[tracker]]");
        }
        let methods = read_methods(in_methods, &wire.method, &known);
        let analyses = read_analyses(at.key("analysis"), &wire.analysis, &known);
        if wire.method.is_empty() && wire.analysis.is_empty() && at.is_fine() {
            at.tell("there is no [[method]]");
        }
        if at.is_fine() {
            let runs = trackers.iter().map(|t| u64::from(t.runs.max(t.training_runs))).sum();
            limits::check_cells(in_methods, runs, &methods);
        }

        words.learn(&methods, &analyses);
        let test = wire.suites.get(TEST).and_then(|name| self.catalog.suite(name).ok());
        words.sequences = test.map_or_else(Vec::new, |suite| suite.sequence_names());
        let mut tables = Vec::new();
        for (at, t) in named(at.key("table"), "table", &wire.table, |t| &t.name) {
            let before = words.tables.iter().map(String::as_str).take_while(|name| *name != t.name);
            if let Some(other) = &t.published {
                at.key("published").knows("table before this one", other, before);
            }
            tables.extend(Table::read(at, t, words));
        }
        let figures = named(at.key("figure"), "figure", &wire.figure, |f| &f.name);
        let mut figures: Vec<Figure> = figures.filter_map(|(at, f)| Figure::read(at, f, words)).collect();
        if wire.table.is_empty() && wire.figure.is_empty() && !methods.is_empty() {
            tables.push(Table::of_methods(words));
            figures.extend(Figure::of_methods(words));
        }
        let published = read_published(at.key("published"), &wire.published, &tables, words);
        let published = table::inherit_published(published, &tables, &methods, &trackers);
        let claims = wire.claim.iter().enumerate();
        let claims = claims.filter_map(|(k, c)| claim::read(at.key("claim").item(k), c, words)).collect();
        Experiment {
            name: wire.name,
            title: wire.title,
            paper: wire.paper,
            object: wire.object,
            note: wire.note,
            leaderboard: wire.leaderboard,
            beside: wire.beside,
            protocol,
            seed: wire.seed,
            folds: wire.folds,
            suites: wire.suites,
            catalog: self.catalog.clone(),
            trackers,
            methods,
            analyses,
            tables,
            figures,
            published,
            claims,
            source: text.to_string(),
        }
    }
}

/// Text without the line that tells editors where the schema is. That line is not part of the experiment.
fn without_directive(text: &str) -> &str {
    match text.split_once('\n') {
        Some((first, rest)) if first.starts_with("#:schema ") => rest,
        _ => text,
    }
}

/// Defaults for required keys that a wrong file lacks, so that the rest can be checked.
const STAND_INS: &str = "schema = 1\nname = \"unnamed\"\ntitle = \"\"\nsuites = {}\ntracker = []\n";

/// Name of a tracker in tables.
fn label_of(wire: &wire::Tracker) -> &String {
    wire.label.as_ref().unwrap_or(&wire.name)
}

/// Checks all `[[tracker]]` items; `at` is their list.
fn read_trackers(at: At<'_>, all: &[wire::Tracker], known: &Known<'_>) -> Vec<Tracker> {
    let mut trackers: Vec<Tracker> = Vec::new();
    for (k, tracker) in all.iter().enumerate() {
        let (at, label) = (at.item(k), label_of(tracker));
        let in_label = at.key(if tracker.label.is_some() { "label" } else { "name" });
        check_label(in_label, label, false);
        tracker.family.iter().for_each(|family| check_label(at.key("family"), family, false));
        if all[..k].iter().any(|other| label_of(other) == label) {
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
        label: label_of(wire).clone(),
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
fn check_data(at: At<'_>, all: &[wire::Tracker], known: &Known<'_>, catalog: &Catalog) {
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

fn read_methods(at: At<'_>, wire: &[wire::Method], known: &Known<'_>) -> Vec<Method> {
    let words = known.words;
    let mut methods: Vec<Method> = Vec::new();
    let mut room = MAX_DETECTORS;
    for (at, m) in named(at, "method", wire, |m| &m.name) {
        let in_name = at.key("name");
        check_label(in_name, &m.name, true);
        all_known(at.key("trackers"), "tracker", m.trackers.as_deref().unwrap_or_default(), &words.trackers);
        let published = builtin::METHOD_TABLES.iter().map(|(name, _)| name.as_str());
        let before = words.methods.iter().map(String::as_str).take_while(|name| *name != m.name);
        let bases = before.chain(published.clone());
        if m.like.as_ref().is_some_and(|like| !at.key("like").knows("method before this one", like, bases)) {
            continue;
        }
        if m.signal.is_none() && m.detector.is_none() {
            in_name.tell_unknown("published method", &m.name, published);
            continue;
        }
        let its_own = m.protocol.as_deref().map(|name| score::protocol(name).unwrap_or(&score::PROTOCOLS[0]));
        let Some(protocol) = its_own.or(known.protocol) else {
            in_name.tell(format!("`{}` has no `protocol`, and neither has the experiment", m.name));
            continue;
        };
        let Some(method) = method::read(at, known.programs, m, protocol, room) else { continue };
        let roles = method.variants.iter().filter_map(|variant| variant.detector.role());
        let is_wrong = |role: &&str| *role != OTHERS && !known.suites.contains_key(*role);
        if let Some(role) = roles.filter(|_| !known.suites.is_empty()).find(is_wrong) {
            let known = known.suites.keys().map(String::as_str).chain([OTHERS]);
            in_name.tell_unknown("suite role", role, known);
        }
        room -= method.detectors();
        methods.push(method);
    }
    methods
}

fn read_analyses(at: At<'_>, wire: &[wire::Analysis], known: &Known<'_>) -> Vec<Analysis> {
    let words = known.words;
    let mut analyses: Vec<Analysis> = Vec::new();
    let has_grid = |name: &&String| words.grids.iter().any(|grid| grid.method == **name);
    let without_grid = words.methods.iter().filter(|name| !has_grid(name)).map(String::as_str);
    for (at, a) in named(at, "analysis", wire, |a| &a.name) {
        check_file_name(at.key("name"), &a.name);
        all_known(at.key("trackers"), "tracker", a.trackers.as_deref().unwrap_or_default(), &words.trackers);
        let Some(analysis) = analysis::read(at, a, known) else { continue };
        let timed = analysis.plugin.timed().0;
        if let Some(wrong) = timed.iter().find(|name| !without_grid.clone().any(|known| known == *name)) {
            at.tell_unknown("method without a grid", wrong, without_grid.clone());
        }
        analyses.push(analysis);
    }
    analyses
}

/// Reads the published numbers of the tables that are valid.
fn read_published(at: At<'_>, wire: &[wire::Published], tables: &[Table], words: &Words) -> Vec<Published> {
    let mut published: Vec<Published> = Vec::new();
    for (k, p) in wire.iter().enumerate() {
        let Some(row) = table::read_published(at.item(k), p, tables, words) else { continue };
        if published.iter().any(|k| (&k.table, &k.tracker, &k.row) == (&row.table, &row.tracker, &row.row)) {
            at.item(k).key("row").tell(format!("`{}` of {} is listed twice", row.row, row.tracker));
        }
        published.push(row);
    }
    published
}

/// Checks the suite of each role.
fn read_suites(at: At<'_>, suites: &BTreeMap<String, String>, catalog: &Catalog) {
    for (role, suite) in suites {
        at.key(role).knows("suite", suite, catalog.names());
        if role == OTHERS {
            let message = "`others` is no role: it stands for the test suite without the sequence and the tracker at hand";
            at.key(role).tell(message);
        }
    }
    if !suites.contains_key(TEST) && at.is_fine() {
        at.tell("[suites] has no `test`");
    }
}
