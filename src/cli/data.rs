//! `trackfail data`: which sequences are known, which are here, and whether they are what was pinned; and
//! user suites.

use super::Failure;
use super::output::{self, Format, written};
use crate::dataset::format::{self, FORMATS, FormatEntry, vot};
use crate::dataset::lock;
use crate::dataset::suite::{self, Catalog, Finding, Suite};
use crate::dataset::{DatasetError, Sequence, text};
use crate::engine::store;
use clap::Subcommand;
use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};
use serde::Serialize;
use std::collections::BTreeMap;
use std::io::Write;
use std::path::PathBuf;

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
    /// Hash local sequences and compare them with datasets.lock
    Verify {
        /// Suites; by default all that are read from disk
        suites: Vec<String>,
        /// Missing sequences are no failure
        #[arg(long)]
        allow_missing: bool,
    },
    /// Download missing sequences, unpack and check them
    Fetch(super::fetch::Args),
    /// Make a suite of your own sequences, in a datasets.lock in the data root
    Add(AddArgs),
    /// Print the lines of datasets.lock and datasets.files for local sequences, with digests
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

/// Reads the word of a format that suites can be found in.
fn addable_formats() -> impl TypedValueParser<Value = &'static FormatEntry> {
    let addable = FORMATS.iter().filter(|f| f.find_targets.is_some());
    let values = addable.map(|f| PossibleValue::new(f.word).help(f.summary));
    PossibleValuesParser::new(values)
        .try_map(|word| format::find(&word).ok_or_else(|| format!("`{word}` is no format")))
}

/// Runs the verb.
///
/// # Errors
/// [`Failure::Usage`] for unknown suites; [`Failure::Data`] for data that are not as pinned or, in `verify`
/// without `--allow-missing`, not there; [`Failure::Io`] when stdout fails.
pub fn run(args: &Args) -> Result<(), Failure> {
    let roots = &args.data_roots.folders()?;
    let catalog = super::catalog(roots)?;
    let chosen = |names: &[String]| chosen(&catalog, names);
    let mut out = Vec::new();
    let outcome = match &args.verb {
        Verb::List { suites, format: Format::Table } if suites.is_empty() => {
            written(out.write_all(overview(&chosen(suites)?, roots).as_bytes()))
        }
        Verb::List { suites, format } => list(&mut out, &chosen(suites)?, roots, *format),
        Verb::Verify { suites, allow_missing } => verify(&mut out, &chosen(suites)?, roots, *allow_missing),
        Verb::Fetch(args) => super::fetch::run(args, &catalog, roots),
        Verb::Add(args) => add(&mut out, args, &catalog, roots),
        Verb::Lock { suites } => pin(&mut out, &chosen(suites)?, roots),
    };
    output::write(&String::from_utf8_lossy(&out))?;
    outcome
}

/// The suites of these names; all if there are none.
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
    /// The data root that it is taken from.
    root: String,
}

const COLUMNS: [&str; 10] =
    ["suite", "sequence", "status", "frames", "annotated", "digest", "folder", "attributes", "note", "root"];

/// Nothing where a number is not known.
fn number(n: Option<usize>) -> String {
    n.map_or_else(String::new, |n| n.to_string())
}

impl Row {
    fn cells(&self) -> [String; 10] {
        [
            self.suite.clone(),
            self.sequence.clone(),
            self.status.into(),
            number(self.frames),
            number(self.annotated),
            self.digest.into(),
            self.folder.clone(),
            self.attributes.clone(),
            self.note.clone(),
            self.root.clone(),
        ]
    }
}

fn rows(suite: &Suite, data_roots: &[PathBuf]) -> Vec<Row> {
    let loaded = suite.load(data_roots);
    let annotated = |s: &Sequence| s.truth.iter().flatten().count();
    if suite.entries().is_empty() {
        let row = |s: &Sequence| Row {
            suite: suite.name().into(),
            sequence: s.name.clone(),
            status: "rendered",
            frames: Some(s.len()),
            annotated: Some(annotated(s)),
            digest: "known",
            folder: String::new(),
            attributes: s.attributes.join(" "),
            note: String::new(),
            root: String::new(),
        };
        return loaded.sequences.iter().map(row).collect();
    }
    let row = |entry: &lock::Entry| {
        let at = loaded.sequences.iter().position(|s| s.name == entry.name);
        let here = at.map(|at| &loaded.sequences[at]);
        let root = at.and_then(|at| loaded.roots.get(at));
        let missing = loaded.missing.iter().find(|m| m.name == entry.name);
        let broken = loaded.broken.iter().find(|b| b.name == entry.name);
        let (status, note) = match (missing, broken) {
            (Some(m), _) => ("missing", m.how_to_get.clone()),
            (_, Some(b)) => ("broken", b.error.to_string()),
            _ => ("present", String::new()),
        };
        Row {
            suite: suite.name().into(),
            sequence: entry.name.clone(),
            status,
            frames: entry.frames.or(here.map(Sequence::len)),
            annotated: here.map(annotated),
            digest: if entry.digest.is_some() { "pinned" } else { "unknown" },
            folder: entry.folder.clone(),
            attributes: here.map_or_else(String::new, |s| s.attributes.join(" ")),
            note,
            root: root.map_or_else(String::new, |root| root.display().to_string()),
        }
    };
    suite.entries().iter().map(row).collect()
}

fn list(
    out: &mut impl Write,
    suites: &[Suite],
    data_roots: &[PathBuf],
    format: Format,
) -> Result<(), Failure> {
    let rows: Vec<(&Suite, Vec<Row>)> = suites.iter().map(|s| (s, rows(s, data_roots))).collect();
    let flat = || rows.iter().flat_map(|(_, rows)| rows);
    let text = match format {
        Format::Csv => {
            let cells: Vec<Vec<String>> = flat().map(|r| r.cells().to_vec()).collect();
            output::text(format, &COLUMNS, &cells)?
        }
        Format::Json => {
            let all: Vec<&Row> = flat().collect();
            serde_json::to_string_pretty(&all).map_err(Failure::io)? + "\n"
        }
        Format::Table => rows.iter().map(|(suite, rows)| table(suite, rows)).collect::<Vec<_>>().join("\n"),
    };
    written(out.write_all(text.as_bytes()))
}

/// Suites, a line each: how many sequences are here, whether the others can be fetched.
fn overview(suites: &[Suite], data_roots: &[PathBuf]) -> String {
    let mut table = comfy_table::Table::new();
    table.load_preset(comfy_table::presets::NOTHING);
    table.set_header(["suite", "here", "of", "broken", "download", "title"]);
    for suite in suites {
        let loaded = suite.load(data_roots);
        let (here, broken) = (loaded.sequences.len(), loaded.broken.len());
        let broken = if broken == 0 { String::new() } else { broken.to_string() };
        let (here, of) = (here.to_string(), loaded.wanted.to_string());
        table.add_row([suite.name(), &here, &of, &broken, download(suite), suite.title()]);
    }
    for column in [1, 2, 3] {
        if let Some(column) = table.column_mut(column) {
            column.set_cell_alignment(comfy_table::CellAlignment::Right);
        }
    }
    let note = if data_roots.is_empty() { format!("{}\n", suite::NO_DATA_ROOT) } else { String::new() };
    let shown = table.trim_fmt();
    format!("{shown}\n{note}`trackfail data list SUITE` shows its sequences and how to get them\n")
}

/// Whether the addresses of a suite's archives are known.
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
    let mut table = comfy_table::Table::new();
    table.load_preset(comfy_table::presets::NOTHING);
    table.set_header(["sequence", "status", "frames", "annotated", "digest", "folder", "root"]);
    for row in rows {
        let [_, sequence, status, frames, annotated, digest, folder, _, _, root] = row.cells();
        table.add_row([sequence, status, frames, annotated, digest, folder, root]);
    }
    for column in [2, 3] {
        if let Some(column) = table.column_mut(column) {
            column.set_cell_alignment(comfy_table::CellAlignment::Right);
        }
    }
    let here = rows.iter().filter(|r| r.status == "present" || r.status == "rendered").count();
    let mut text =
        format!("{}: {}\n{here} of {} sequences are here\n", suite.name(), suite.title(), rows.len());
    if let Some((source, licence)) = suite.source() {
        text += &format!("source: {source}\nlicence: {licence}\n");
    }
    text += &format!("{}\n", table.trim_fmt());
    let mut notes: Vec<&str> = Vec::new();
    for row in rows.iter().filter(|r| !r.note.is_empty() && r.status == "broken") {
        notes.push(&row.note);
    }
    if let Some(row) = rows.iter().find(|r| r.status == "missing") {
        notes.push(&row.note);
    }
    notes.iter().for_each(|note| text += &format!("note: {note}\n"));
    text
}

fn verify(
    out: &mut impl Write,
    suites: &[Suite],
    data_roots: &[PathBuf],
    allow_missing: bool,
) -> Result<(), Failure> {
    let (mut differing, mut missing) = (Vec::new(), Vec::new());
    for suite in suites {
        for checked in suite.verify(data_roots) {
            let name = format!("{}/{}", suite.name(), checked.name);
            let word = match checked.finding {
                Finding::Same => "ok".to_owned(),
                Finding::NoDigestPinned => "unpinned: there, but no digest to compare with".to_owned(),
                Finding::Missing(m) => {
                    missing.push(name.clone());
                    format!("missing: {}", m.how_to_get)
                }
                Finding::Differs(fact) => {
                    differing.push(name.clone());
                    format!("differs: {fact}")
                }
            };
            written(writeln!(out, "{name}  {word}"))?;
        }
    }
    if !differing.is_empty() {
        let message = format!("not as pinned: {}; fetch them again", differing.join(", "));
        return Err(Failure::data(message));
    }
    if !missing.is_empty() && !allow_missing {
        let count = missing.len();
        return Err(Failure::data(format!(
            "{count} sequences are missing; give --allow-missing to accept that"
        )));
    }
    Ok(())
}

fn add(
    out: &mut impl Write,
    args: &AddArgs,
    catalog: &Catalog,
    data_roots: &[PathBuf],
) -> Result<(), Failure> {
    let folder = |root: &&PathBuf| root.join(&args.folder).is_dir();
    let Some(root) = data_roots.iter().find(folder).or(data_roots.first()) else {
        return Err(Failure::usage(
            "`data add` needs a data root; give --data-root DIR or set TRACKFAIL_DATA",
        ));
    };
    let data = |e: DatasetError| Failure::data(e.to_string());
    suite::check_name(&args.name)
        .map_err(|m| Failure::usage(format!("{}: {m}", text::visible(&args.name))))?;
    let path = root.join(suite::USER_LOCK);
    if catalog.names().any(|known| known == args.name.as_str()) {
        let message = format!("{} is in {}; remove its section there first", args.name, path.display());
        return Err(Failure::usage(message));
    }
    let only = args.list.as_deref().map(vot::read_list).transpose().map_err(data)?;
    let wanted = suite::GatherRequest {
        name: &args.name,
        title: args.title.as_deref(),
        format: args.format,
        folder: args.folder.trim_end_matches('/'),
        only: only.as_deref(),
    };
    let section = suite::gather(&wanted, root).map_err(data)?;
    let before = if path.exists() { text::read(&path).map_err(data)? } else { String::new() };
    let whole = suite::with_sections(&before, &section);
    let mut catalog = catalog.clone();
    catalog.add_file(&path, whole.as_bytes()).map_err(data)?;
    store::write(&path, whole.as_bytes()).map_err(Failure::io)?;
    let count = catalog.suite(&args.name).map_err(data)?.entries().len();
    let what = if count == 1 { "sequence" } else { "sequences" };
    written(writeln!(out, "{}: {count} {what}, in {}", args.name, path.display()))
}

fn pin(out: &mut impl Write, suites: &[Suite], data_roots: &[PathBuf]) -> Result<(), Failure> {
    if data_roots.is_empty() {
        return Err(Failure::usage(
            "`data lock` needs a data root; give --data-root DIR or set TRACKFAIL_DATA",
        ));
    }
    let fail = |e: DatasetError| Failure::data(e.to_string());
    let mut files = BTreeMap::new();
    for suite in suites {
        let lines = suite.pin(data_roots).map_err(fail)?;
        if !lines.is_empty() {
            written(writeln!(out, "# {}", suite.name()))?;
        }
        for line in lines {
            written(writeln!(out, "    {line}"))?;
        }
        files.extend(suite.pin_files(data_roots).map_err(fail)?);
    }
    if !files.is_empty() {
        written(writeln!(out, "\n# datasets.files"))?;
    }
    for section in files.values() {
        written(out.write_all(section.as_bytes()))?;
    }
    Ok(())
}

#[cfg(test)]
mod tests;
