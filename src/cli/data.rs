//! `trackfail data`: which sequences are known, which are here, and whether they are what was pinned; downloads, rendered
//! suites, and user suites. Results are verified here, too.

mod fetch;
mod render;
mod sent;
#[cfg(test)]
mod tests;

use super::Failure;
use super::output::{self, Format};
use crate::dataset::format::{self, FORMATS, FormatEntry, vot};
use crate::dataset::lock;
use crate::dataset::suite::{self, Catalog, Finding, Suite};
use crate::dataset::{Sequence, text};
use crate::engine::store;
use clap::Subcommand;
use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};
use serde::Serialize;
use serde_json::Value;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// Arguments of `trackfail data`.
#[derive(Debug, clap::Args)]
pub struct Args {
    #[command(subcommand)]
    verb: Verb,
    #[command(flatten)]
    data_roots: super::DataRoots,
}

#[derive(Debug, Subcommand)]
enum Verb {
    /// Show which sequences are here and which are missing: all suites a line each, a SUITE by sequence
    List {
        /// Suites to show by sequence; without SUITE, CSV and JSON show all suites that way
        suites: Vec<String>,
        /// How to print
        #[arg(long, value_enum, default_value_t = Format::Table)]
        format: Format,
    },
    /// Hash local sequences and compare them with what is pinned, or results with their manifest
    Verify {
        /// Suites, by default all that are read from disk; or results: a file of `trackfail pack`, or the folder of an
        /// experiment, such as `results/quickstart`
        #[arg(value_name = "SUITE|RESULTS")]
        names: Vec<String>,
        /// Missing sequences are no failure
        #[arg(long)]
        allow_missing: bool,
        /// Results folder that files of `trackfail pack` are unpacked into if nothing is wrong with them
        #[arg(long, value_name = "DIR")]
        unpack: Option<PathBuf>,
    },
    /// Download missing sequences, unpack and check them
    Fetch(fetch::Args),
    /// Write a synthetic suite to disk in OTB or VOT layout
    Render(render::Args),
    /// Make a suite of your own sequences, in a datasets.lock in the data root
    Add(AddArgs),
    /// Print the lines of datasets/*.toml and datasets.files for local sequences, with digests
    Lock {
        /// Suites; by default all that are read from disk
        suites: Vec<String>,
    },
}

/// Arguments of `trackfail data add`.
#[derive(Debug, clap::Args)]
struct AddArgs {
    /// Name of the suite, as `[suites]` of an experiment gives it
    name: String,
    /// Folder under the data root that has the sequences, up to three folders down: `lasot/test`
    folder: String,
    /// Format of the sequences
    #[arg(long, value_parser = addable_formats())]
    format: &'static FormatEntry,
    /// File with the names of the sequences to take, one a line; by default all are taken
    #[arg(long, value_name = "FILE")]
    list: Option<PathBuf>,
    /// One line about the suite
    #[arg(long)]
    title: Option<String>,
}

/// Parser of the format names for which suites can be added.
fn addable_formats() -> impl TypedValueParser<Value = &'static FormatEntry> {
    let addable = FORMATS.iter().filter(|f| f.find_targets.is_some());
    let values = addable.map(|f| PossibleValue::new(f.word).help(f.summary));
    PossibleValuesParser::new(values)
        .try_map(|word| format::find(&word).ok_or_else(|| format!("`{word}` is no format")))
}

/// Runs the verb.
///
/// # Errors
/// `Usage` for unknown suites; `Data` for data that are not as pinned or, in `verify`
/// without `--allow-missing`, not there, and for results that are not as their manifest says; `Io` when stdout
/// fails; and those of `fetch` and `render`.
pub fn run(args: &Args) -> Result<(), Failure> {
    // What is rendered needs no data.
    let needs_data = match &args.verb {
        Verb::Render(_) => false,
        Verb::Verify { names, .. } => names.is_empty() || !names.iter().all(|name| sent::is_results(name)),
        _ => true,
    };
    let roots = &if needs_data { args.data_roots.folders()? } else { Vec::new() };
    let catalog = super::catalog(roots)?;
    let chosen = |names: &[String]| chosen(&catalog, names);
    output::write(&match &args.verb {
        Verb::List { suites, format: Format::Table } if suites.is_empty() => {
            overview(&chosen(suites)?, roots)
        }
        Verb::List { suites, format } => list(&chosen(suites)?, roots, *format)?,
        Verb::Verify { names, allow_missing, unpack } => {
            let is_suite = |name: &String| !sent::is_results(name) || catalog.suite(name).is_ok();
            let (suites, results): (Vec<String>, Vec<String>) = names.iter().cloned().partition(is_suite);
            if results.is_empty() && unpack.is_some() {
                return Err(Failure::usage("--unpack: name a file of `trackfail pack` to unpack"));
            }
            results.iter().try_for_each(|path| sent::verify(Path::new(path), unpack.as_deref()))?;
            if suites.is_empty() && !results.is_empty() {
                return Ok(());
            }
            let (text, outcome) = verify(&chosen(&suites)?, roots, *allow_missing);
            output::write(&text)?;
            return outcome;
        }
        Verb::Fetch(args) => return fetch::run(args, &catalog, roots),
        Verb::Render(args) => return render::run(args),
        Verb::Add(args) => add(args, &catalog, roots)?,
        Verb::Lock { suites } => pin(&chosen(suites)?, roots)?,
    })
}

/// Suites of these names; all suites if no name is given.
fn chosen(catalog: &Catalog, names: &[String]) -> Result<Vec<Suite>, Failure> {
    if names.is_empty() {
        return Ok(catalog.suites().collect());
    }
    names.iter().map(|n| catalog.suite(n).map_err(Failure::usage)).collect()
}

/// One line of `data list`.
#[derive(Debug, Serialize)]
struct Row {
    suite: String,
    sequence: String,
    status: &'static str,
    frames: Option<usize>,
    annotated: Option<usize>,
    digest: &'static str,
    folder: String,
    attributes: String,
    note: String,
    /// Data root that has the sequence.
    root: String,
}

const COLUMNS: [&str; 10] =
    ["suite", "sequence", "status", "frames", "annotated", "digest", "folder", "attributes", "note", "root"];

/// Indices of the columns that are shown in a table.
const SHOWN: [usize; 7] = [1, 2, 3, 4, 5, 6, 9];

impl Row {
    /// Columns as text; empty for unknown numbers.
    fn cells(&self) -> Vec<String> {
        let fields = serde_json::to_value(self).unwrap_or_default();
        let text = |column: &str| match &fields[column] {
            Value::Null => String::new(),
            Value::String(text) => text.clone(),
            number => number.to_string(),
        };
        COLUMNS.into_iter().map(text).collect()
    }
}

fn rows(suite: &Suite, data_roots: &[PathBuf]) -> Vec<Row> {
    let loaded = suite.load(data_roots);
    // Only rendered suites have no entries.
    let row = |name: &str, entry: Option<&lock::Entry>| {
        let here = loaded.sequences.iter().find(|s| s.name == name);
        let missing = loaded.missing.iter().find(|m| m.name == name);
        let broken = loaded.broken.iter().find(|(broken, _)| broken == name);
        let (status, note) = match (missing, broken) {
            (Some(m), _) => ("missing", m.how_to_get.clone()),
            (_, Some((_, error))) => ("broken", error.to_string()),
            _ => (if entry.is_some() { "present" } else { "rendered" }, String::new()),
        };
        Row {
            suite: suite.name().into(),
            sequence: name.into(),
            status,
            frames: entry.and_then(|entry| entry.frames).or(here.map(Sequence::len)),
            annotated: here.map(|s| s.truth.iter().flatten().count()),
            digest: entry.map_or("known", |e| if e.digest.is_some() { "pinned" } else { "unknown" }),
            folder: entry.map(|entry| entry.folder.clone()).unwrap_or_default(),
            attributes: here.map(|s| s.attributes.join(" ")).unwrap_or_default(),
            note,
            root: here.map(|s| s.origin.root.display().to_string()).unwrap_or_default(),
        }
    };
    if suite.entries().is_empty() {
        return loaded.sequences.iter().map(|s| row(&s.name, None)).collect();
    }
    suite.entries().iter().map(|entry| row(&entry.name, Some(entry))).collect()
}

fn list(suites: &[Suite], data_roots: &[PathBuf], format: Format) -> Result<String, Failure> {
    let rows: Vec<(&Suite, Vec<Row>)> = suites.iter().map(|s| (s, rows(s, data_roots))).collect();
    let flat = || rows.iter().flat_map(|(_, rows)| rows);
    match format {
        Format::Csv => output::text(format, &COLUMNS, &flat().map(Row::cells).collect::<Vec<_>>()),
        Format::Json => {
            let text = serde_json::to_string_pretty(&flat().collect::<Vec<_>>());
            Ok(text.map_err(Failure::io)? + "\n")
        }
        Format::Table => {
            Ok(rows.iter().map(|(suite, rows)| table(suite, rows)).collect::<Vec<_>>().join("\n"))
        }
    }
}

/// Overview of suites, one line each: how many sequences are present, and if the others can be downloaded.
fn overview(suites: &[Suite], data_roots: &[PathBuf]) -> String {
    let row = |suite: &Suite| {
        let loaded = suite.load(data_roots);
        let (here, broken) = (loaded.sequences.len(), loaded.broken.len());
        let broken = if broken == 0 { String::new() } else { broken.to_string() };
        let (name, title) = (suite.name().to_string(), suite.title().to_string());
        vec![name, here.to_string(), loaded.wanted.to_string(), broken, download(suite).to_string(), title]
    };
    let headings = ["suite", "here", "of", "broken", "download", "title"];
    let shown = output::table(&headings, &suites.iter().map(row).collect::<Vec<_>>(), &[1, 2, 3], None);
    let note = if data_roots.is_empty() { format!("{}\n", suite::NO_DATA_ROOT) } else { String::new() };
    format!("{shown}{note}`trackfail data list SUITE` shows its sequences and how to get them\n")
}

/// Tells if the addresses of a suite's archives are known: for all, some or no sequences.
fn download(suite: &Suite) -> &'static str {
    let entries = suite.entries();
    match entries.iter().filter(|e| e.archives().next().is_some()).count() {
        _ if entries.is_empty() => "rendered",
        0 => "by hand",
        n if n == entries.len() => "known",
        _ => "partly",
    }
}

fn table(suite: &Suite, rows: &[Row]) -> String {
    let cells = rows.iter().map(Row::cells).map(|cells| SHOWN.map(|column| cells[column].clone()).to_vec());
    let headings = SHOWN.map(|column| COLUMNS[column]);
    let shown = output::table(&headings, &cells.collect::<Vec<_>>(), &[2, 3], None);
    let here = rows.iter().filter(|r| r.status == "present" || r.status == "rendered").count();
    let mut text =
        format!("{}: {}\n{here} of {} sequences are here\n", suite.name(), suite.title(), rows.len());
    if let Some((source, licence)) = suite.source() {
        text += &format!("source: {source}\nlicence: {licence}\n");
    }
    text += &shown;
    let broken = rows.iter().filter(|r| r.status == "broken" && !r.note.is_empty());
    for row in broken.chain(rows.iter().find(|r| r.status == "missing")) {
        text += &format!("note: {}\n", row.note);
    }
    text
}

/// Results of comparing sequences with their pins.
#[derive(Debug, Default)]
struct Checks {
    /// Text with one line for each sequence.
    text: String,
    /// Names, each with what is to be done.
    differing: Vec<(String, String)>,
    missing: Vec<String>,
}

impl Checks {
    /// Hashes the sequences of a suite that `wanted` accepts.
    fn add(&mut self, suite: &Suite, data_roots: &[PathBuf], wanted: impl Fn(&str) -> bool + Sync) {
        for (entry, finding) in suite.verify(data_roots, wanted) {
            let name = format!("{}/{}", suite.name(), entry.name);
            let word = match finding {
                Finding::Same => "ok".to_owned(),
                Finding::NoDigestPinned => "unpinned: there, but no digest to compare with".to_owned(),
                Finding::Missing(m) => {
                    self.missing.push(name.clone());
                    format!("missing: {}", m.how_to_get)
                }
                Finding::Differs(fact) => {
                    self.differing.push((name.clone(), remedy(suite, entry)));
                    format!("differs: {fact}")
                }
            };
            self.text += &format!("{name}  {word}\n");
        }
    }
}

/// Advice for a sequence that is not as pinned: to fetch it again or, where that cannot be, how its suite says to get it.
fn remedy(suite: &Suite, entry: &lock::Entry) -> String {
    if entry.archives().next().is_some() {
        return "fetch them again".to_string();
    }
    let how = suite.how_to_get();
    if how.is_empty() { "put back what was pinned" } else { how }.to_string()
}

/// Results for each sequence as text, and an error unless all are as pinned.
fn verify(suites: &[Suite], data_roots: &[PathBuf], allow_missing: bool) -> (String, Result<(), Failure>) {
    let mut checks = Checks::default();
    suites.iter().for_each(|suite| checks.add(suite, data_roots, |_| true));
    let Checks { text, differing, missing } = checks;
    let mut by_remedy: BTreeMap<&str, Vec<&str>> = BTreeMap::new();
    for (name, remedy) in &differing {
        by_remedy.entry(remedy).or_default().push(name);
    }
    let told = |(remedy, names): (&str, Vec<&str>)| format!("not as pinned: {}; {remedy}", names.join(", "));
    let wrong = match missing.len() {
        _ if !differing.is_empty() => by_remedy.into_iter().map(told).collect::<Vec<_>>().join("\n"),
        count if count > 0 && !allow_missing => {
            format!("{count} sequences are missing; give --allow-missing to accept that")
        }
        _ => return (text, Ok(())),
    };
    (text, Err(Failure::data(wrong)))
}

/// First data root, which a verb writes to or reads from.
fn first_root<'r>(verb: &str, data_roots: &'r [PathBuf]) -> Result<&'r PathBuf, Failure> {
    data_roots.first().ok_or_else(|| {
        let how = "give --data-root DIR or set TRACKFAIL_DATA";
        Failure::usage(format!("`data {verb}` needs a data root, a folder; {how}"))
    })
}

fn add(args: &AddArgs, catalog: &Catalog, data_roots: &[PathBuf]) -> Result<String, Failure> {
    let first = first_root("add", data_roots)?;
    let root = data_roots.iter().find(|root| root.join(&args.folder).is_dir()).unwrap_or(first);
    suite::check_name(&args.name)
        .map_err(|m| Failure::usage(format!("{}: {m}", text::visible(&args.name))))?;
    let path = root.join(suite::USER_LOCK);
    if catalog.names().any(|known| known == args.name.as_str()) {
        let file = suite::USER_LOCK;
        let message =
            format!("{} is in the {file} of a data root; remove its section there first", args.name);
        return Err(Failure::usage(message));
    }
    let only = args.list.as_deref().map(vot::read_list).transpose().map_err(Failure::data)?;
    let wanted = suite::GatherRequest {
        name: &args.name,
        title: args.title.as_deref(),
        format: args.format,
        folder: args.folder.trim_end_matches('/'),
        only: only.as_deref(),
    };
    let section = suite::gather(&wanted, root).map_err(Failure::data)?;
    let before =
        if text::is_absent(&path) { String::new() } else { text::read(&path).map_err(Failure::data)? };
    let whole = suite::with_sections(&before, &section);
    let mut catalog = catalog.clone();
    catalog.add_file(&path, whole.as_bytes()).map_err(Failure::data)?;
    store::write(&path, whole.as_bytes()).map_err(Failure::io)?;
    let count = catalog.suite(&args.name).map_err(Failure::data)?.entries().len();
    let what = if count == 1 { "sequence" } else { "sequences" };
    Ok(format!("{}: {count} {what}, in {}\n", args.name, path.display()))
}

fn pin(suites: &[Suite], data_roots: &[PathBuf]) -> Result<String, Failure> {
    first_root("lock", data_roots)?;
    let (mut text, mut files) = (String::new(), BTreeMap::new());
    for suite in suites {
        let lines = suite.pin(data_roots).map_err(Failure::data)?;
        if !lines.is_empty() {
            text += &format!("# {}\n", suite.name());
        }
        lines.iter().for_each(|line| text += &format!("    {line}\n"));
        files.extend(suite.pin_files(data_roots).map_err(Failure::data)?);
    }
    let heading = if files.is_empty() { "" } else { "\n# datasets.files\n" };
    Ok(text + heading + &files.into_values().collect::<String>())
}
