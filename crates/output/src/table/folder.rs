//! Writing a results folder: `results/<experiment>/`.

use super::frame::{self, FrameError};
use super::layout::{self, Layout};
use super::macros::Fact;
use super::manifest::{self, Manifest, TrackerRecord};
use super::measures::{self, Measure};
use super::records::CellScore;
use super::{latex, leaderboard, macros, number, quality, records, render};
use crate::engine::Outcome;
use crate::engine::execute::analyse::Analysed;
use crate::engine::store::{self, StoreError};
use crate::spec::table::{Side, Table};
use crate::spec::{Experiment, Tracker};
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

/// A results folder that could not be written or read.
#[derive(Debug, thiserror::Error)]
pub enum FolderError {
    /// A file.
    #[error(transparent)]
    Store(#[from] StoreError),
    /// A table in it.
    #[error(transparent)]
    Frame(#[from] FrameError),
    /// JSON in it.
    #[error("{}: {error}", path.display())]
    Json {
        /// The file.
        path: PathBuf,
        /// What is wrong with it.
        error: serde_json::Error,
    },
}

/// The file that says that a results folder is whole.
pub const MANIFEST: &str = "manifest.json";
/// What analyses found out, in a results folder of an experiment that has any.
pub const ANALYSES: &str = "analyses.json";
/// The user suites that the experiment names; absent if it names none.
pub const USER_SUITES: &str = "suites.lock";
/// The folders in a results folder in which nothing else lies.
pub const OWNED: [&str; 3] = ["tables", "models", "stills"];

/// Pretty JSON with a final newline.
///
/// # Errors
/// When the value cannot be JSON.
pub fn to_json<T: serde::Serialize>(path: &Path, value: &T) -> Result<Vec<u8>, FolderError> {
    let mut bytes = serde_json::to_vec_pretty(value)
        .map_err(|error| FolderError::Json { path: path.to_path_buf(), error })?;
    bytes.push(b'\n');
    Ok(bytes)
}

/// Writes everything a run found out into an empty folder, but for the tables, which the report makes
/// from it.
///
/// # Errors
/// When a file cannot be written.
pub fn write(
    folder: &Path,
    experiment: &Experiment,
    outcome: &Outcome<'_>,
    wall_seconds: f64,
) -> Result<(), FolderError> {
    let manifest_path = folder.join(MANIFEST);
    let pooled = measures::pool(outcome)?;
    let mut files = BTreeMap::new();
    let mut keep = |name: &str, bytes: &[u8]| -> Result<(), FolderError> {
        files.insert(name.to_string(), manifest::sha256(bytes));
        Ok(store::write(&folder.join(name), bytes)?)
    };
    keep("experiment.toml", experiment.source.as_bytes())?;
    if let Some(suites) = experiment.catalog.user_text(experiment.suites.values().map(String::as_str)) {
        keep(USER_SUITES, suites.as_bytes())?;
    }
    keep("scores.csv", &frame::to_csv(&mut records::scores(experiment, outcome)?)?)?;
    keep("measures.csv", &frame::to_csv(&mut records::measures(&outcome.suite, &pooled)?)?)?;
    keep("frames.parquet", &records::frames(outcome)?)?;
    keep("signals.parquet", &frame::to_parquet(&mut records::signals(outcome)?)?)?;
    keep("truth.parquet", &frame::to_parquet(&mut records::truth(outcome)?)?)?;
    for (name, bytes) in quality::files(outcome)? {
        keep(name, &bytes)?;
    }
    if !outcome.analyses.is_empty() {
        keep(ANALYSES, &to_json(&folder.join(ANALYSES), &outcome.analyses)?)?;
    }
    for (k, model) in outcome.models.iter().enumerate() {
        let path =
            folder.join(format!("models/{:03}-{}-{}.json", k + 1, slug(&model.method), slug(&model.tracker)));
        store::write(&path, &to_json(&path, model)?)?;
    }
    let manifest = Manifest { files, ..Manifest::new(experiment, outcome, wall_seconds) };
    store::write(&manifest_path, &to_json(&manifest_path, &manifest)?)?;
    Ok(())
}

/// A name as part of a file name; the number before it keeps different names apart.
fn slug(name: &str) -> String {
    let safe = |c: char| if c.is_ascii_alphanumeric() { c.to_ascii_lowercase() } else { '-' };
    name.chars().take(40).map(safe).collect()
}

/// `12 of 21 targets, 10 runs`, as every table and figure says what it rests on; with what the experiment
/// asks for, where less was run.
pub fn data_note(experiment: &Experiment, manifest: &Manifest) -> String {
    let mut note = layout::data_note(manifest.suite.present.len(), manifest.suite.wanted);
    let trackers = || experiment.trackers.iter().zip(&manifest.trackers);
    let several = manifest.trackers.len() > 1;
    let mut add = |what: &str, done: fn(&TrackerRecord) -> u32, asked: fn(&Tracker) -> u32| {
        let told = |(t, record): (&Tracker, &TrackerRecord)| {
            let (done, asked) = (done(record), asked(t));
            let who = if several { format!("{}: ", t.label) } else { String::new() };
            let of = if done == asked { String::new() } else { format!(" of {asked}") };
            (done > 1 || asked > 1).then(|| format!("{who}{}{of}{what}", number::runs(done)))
        };
        let told: Vec<String> = trackers().filter_map(told).collect();
        if !told.is_empty() {
            note.push_str(&format!(", {}", told.join(", ")));
        }
    };
    add("", |r| r.runs, |t| t.runs);
    let learns = experiment.methods.iter().flat_map(|m| &m.variants).any(|v| v.detector.role().is_some());
    if learns || experiment.analyses.iter().any(|a| a.signal.is_some()) {
        add(" to learn from", |r| r.training_runs, |t| t.training_runs);
    }
    note
}

fn by_attribute(table: &Table) -> bool {
    [&table.rows, &table.columns].contains(&&Side::Attribute)
}

/// The experiment's tables; `scores` are the counts of every cell.
pub fn layouts(
    experiment: &Experiment,
    pooled: &[Measure],
    scores: &[CellScore],
    analyses: &[Analysed],
    manifest: &Manifest,
) -> Vec<Layout> {
    let note = data_note(experiment, manifest);
    let attributes = &manifest.suite.attributes;
    let mut parts = measures::by_attribute(scores, attributes);
    parts.iter_mut().for_each(|part| part.pooled.chance = experiment.chance_of(&part.method));
    let all = [pooled, &parts].concat();
    let layout = |t: &Table| match &t.shows {
        Some(shows) => layout::analysed(experiment, t, shows, analyses, &note),
        None if t.ranked.is_some() => leaderboard::leaderboard(experiment, t, pooled, scores, &note),
        None if by_attribute(t) => {
            let mut layout = layout::layout(experiment, t, &all, &note);
            layout.caption.push_str(&attributes_note(attributes));
            layout
        }
        None => layout::layout(experiment, t, pooled, &note),
    };
    experiment.tables.iter().map(layout).collect()
}

/// How many targets have each attribute.
fn attributes_note(attributes: &BTreeMap<String, Vec<String>>) -> String {
    let mut targets: BTreeMap<&str, usize> = BTreeMap::new();
    for list in attributes.values() {
        let different: BTreeSet<&str> = list.iter().map(String::as_str).collect();
        different.into_iter().for_each(|attribute| *targets.entry(attribute).or_default() += 1);
    }
    let told: Vec<String> = targets.iter().map(|(attribute, n)| format!("{attribute} {n}")).collect();
    if told.is_empty() {
        return " No attributes are known here.".to_string();
    }
    format!(" Targets: {}.", told.join(", "))
}

/// Writes the tables into `tables`, each as CSV, Parquet, Markdown and LaTeX, and a command for every number of
/// theirs as `macros.tex`.
///
/// # Errors
/// When a file cannot be written.
pub fn write_tables(
    folder: &Path,
    experiment: &Experiment,
    facts: &[Fact],
    layouts: &[Layout],
) -> Result<(), FolderError> {
    for layout in layouts {
        write_table(folder, layout)?;
    }
    if !layouts.is_empty() {
        let commands = macros::macros(&experiment.name, facts, layouts);
        store::write(&folder.join("tables").join(macros::FILE), commands.as_bytes())?;
    }
    Ok(())
}

/// Writes one table as CSV, Parquet, Markdown and LaTeX.
///
/// # Errors
/// When a file cannot be written.
pub fn write_table(folder: &Path, layout: &Layout) -> Result<(), FolderError> {
    let path = |ending: &str| folder.join("tables").join(format!("{}.{ending}", layout.name));
    store::write(&path("csv"), &render::csv(layout)?)?;
    store::write(&path("md"), render::markdown(layout).as_bytes())?;
    store::write(&path("parquet"), &render::parquet(layout)?)?;
    store::write(&path("tex"), latex::latex(layout).as_bytes())?;
    store::write(&path("body.tex"), latex::body(layout).as_bytes())?;
    Ok(())
}
