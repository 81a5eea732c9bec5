//! Kept results beside those of an experiment (`beside = "benchmark/otb"`): whether they can stand there, which of their rows
//! are taken, and how these join the own ones.
//!
//! | both experiments have | rows that are taken | marked `(kept)` |
//! |---|---|---|
//! | trackers | all kept methods on these trackers | the methods |
//! | no tracker, but methods | these methods on all kept trackers | the trackers |
//!
//! Only sequences of both count, so that every bootstrap sample has the same sequences for all rows. Counts are kept by sequence.
//! Everything else is kept for all sequences together, and is empty where the kept results have more sequences.
//!
//! The files that this needs are copied into the folder [`FOLDER`] of the results, which so stand by themselves.

mod partner;

pub use partner::check;

use super::files::{MeasureRow, Measured, Pair, Score};
use super::folder::{MAX_FILE, MAX_MANIFEST, read_file, read_whole};
use super::json::{to_json, write_json};
use super::manifest::{self, FailedCell, sha256};
use super::measures::by_attribute;
use super::rows::{Rows, packed};
use super::scores::CellScore;
use super::{Results, ResultsError, SPEC, USER_SUITES};
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;
use trackfail_engine::spec::method::Method;
use trackfail_engine::spec::{Experiment, Tracker};
use trackfail_engine::store::{self, StoreError};

/// The folder of the copy.
pub const FOLDER: &str = "beside";
/// The manifest of the copy. It has another name than that of a run, by which experiments are found.
pub(super) const FILE: &str = "beside/kept.json";
/// End of the names of kept methods or trackers.
const MARK: &str = " (kept)";
/// Kinds of figures of pooled numbers; the others show single frames, or an axis of the own grids.
const POOLED: [&str; 2] = ["curve", "warning"];

/// Rows of kept results that stand beside those of an experiment.
pub struct Beside {
    /// The origin of the rows in a few words.
    pub source: String,
    /// The same in sentences, with what is empty.
    pub note: String,
    /// Counts of the kept cells.
    pub(super) scores: Vec<CellScore>,
    /// Kept cells without a result.
    pub(super) failed: Vec<FailedCell>,
    /// Differences between kept methods.
    pub(super) pairs: Vec<Pair>,
}

fn marked(name: &str) -> String {
    format!("{name}{MARK}")
}

/// The name without the mark of kept ones.
pub fn plain(name: &str) -> &str {
    name.strip_suffix(MARK).unwrap_or(name)
}

/// Trackers and methods of kept results whose rows are taken, by their kept names.
struct Taken {
    trackers: Vec<String>,
    methods: Vec<String>,
    /// True if methods are marked; otherwise trackers are.
    marks_methods: bool,
}

impl Taken {
    /// `None` where the two have nothing in common.
    fn of(own: &Experiment, kept: &Experiment) -> Option<Self> {
        let labels = |e: &Experiment| e.trackers.iter().map(|t| t.label.clone()).collect::<Vec<String>>();
        let names = |e: &Experiment| e.methods.iter().map(|m| m.name.clone()).collect::<Vec<String>>();
        let (trackers, methods) = (labels(kept), names(kept));
        let common: Vec<String> = labels(own).into_iter().filter(|label| trackers.contains(label)).collect();
        if !common.is_empty() {
            return Some(Self { trackers: common, methods, marks_methods: true });
        }
        let common: Vec<String> = names(own).into_iter().filter(|name| methods.contains(name)).collect();
        (!common.is_empty()).then_some(Self { trackers, methods: common, marks_methods: false })
    }

    /// Marks the method or the tracker of a row; false if the row is not taken.
    fn mark(&self, tracker: &mut String, method: &mut String) -> bool {
        let is_taken = self.trackers.contains(tracker) && self.methods.contains(method);
        if is_taken {
            let name = if self.marks_methods { method } else { tracker };
            name.push_str(MARK);
        }
        is_taken
    }
}

/// Kept results as they are read before a run, with the files that are copied after it, when others may be in their place.
pub struct Kept {
    /// The kept results.
    pub results: Results,
    files: BTreeMap<String, Vec<u8>>,
}

impl Kept {
    /// Reads the folder of kept results.
    ///
    /// # Errors
    /// When a file cannot be read, or is not that of the manifest.
    pub fn read(folder: &Path) -> Result<Self, ResultsError> {
        let results = Results::read_alone(folder)?;
        let taken = [SPEC, USER_SUITES, Score::NAME, Measured::NAME, MeasureRow::NAME, Pair::NAME];
        let is_taken = |name: &&String| taken.iter().any(|file| *name == file || **name == packed(file));
        let mut files = BTreeMap::new();
        for name in results.manifest.files.keys().filter(is_taken) {
            files.insert(name.clone(), read_whole(folder, &results.manifest, name, MAX_FILE)?);
        }
        Ok(Self { results, files })
    }
}

/// Copies what an experiment takes from kept results into its own results, a folder that [`write`](super::write) filled.
///
/// # Errors
/// When a file cannot be written.
pub fn keep(kept: &Kept, folder: &Path) -> Result<(), ResultsError> {
    let mut copied = kept.results.manifest.clone();
    copied.files.retain(|name, _| kept.files.contains_key(name));
    for (name, bytes) in &kept.files {
        store::write(&folder.join(FOLDER).join(name), bytes)?;
    }
    let bytes = to_json(&folder.join(FILE), &copied)?;
    store::write(&folder.join(FILE), &bytes)?;
    let path = folder.join(manifest::FILE);
    let mut own = manifest::parse(&path, &read_file(&path, MAX_MANIFEST)?)?;
    own.files.insert(FILE.to_string(), sha256(&bytes));
    Ok(write_json(&path, &own)?)
}

/// Puts the rows that are taken from kept results beside the own ones, once it is checked that they can stand there.
pub(super) fn join(results: &mut Results, kept: Results) -> Result<(), ResultsError> {
    check(&results.experiment, Some(&results.manifest), &results.manifest.digests, &kept).map_err(|e| {
        let again = format!("{e}; run {} again", results.experiment.name);
        StoreError::new(&results.folder.join(FILE), again)
    })?;
    let Some(taken) = Taken::of(&results.experiment, &kept.experiment) else { return Ok(()) };
    // All sequences of both as one attribute.
    let own = results.manifest.suite.present.iter();
    let own: BTreeMap<String, Vec<String>> =
        own.map(|(name, _)| (name.clone(), vec![String::new()])).collect();
    let theirs = &kept.manifest.suite.present;
    let is_whole = theirs.iter().all(|(name, _)| own.contains_key(name));
    let families = |experiment: &Experiment| -> BTreeSet<(String, Option<String>)> {
        experiment.trackers.iter().map(|t| (t.label.clone(), t.family.clone())).collect()
    };
    // Numbers of all trackers together are of the same tracks only where the trackers are the same.
    let is_pooled = is_whole
        && taken.marks_methods
        && results.experiment.leaderboard
        && families(&results.experiment) == families(&kept.experiment);
    let mut scores = kept.scores()?;
    scores.retain(|score| own.contains_key(&score.sequence));
    let mut measures = match is_whole {
        true => kept.measures.clone(),
        false => by_attribute(&scores, &kept.manifest.cells_failed, &own),
    };
    for measure in &mut measures {
        measure.attribute = None;
        measure.pooled.chance = kept.experiment.chance_of(&measure.method);
    }
    measures.retain_mut(|m| taken.mark(&mut m.tracker, &mut m.method));
    scores.retain_mut(|s| taken.mark(&mut s.tracker, &mut s.method));
    results.measures.append(&mut measures);
    let mut failed = kept.manifest.cells_failed.clone();
    failed.retain_mut(|cell| {
        // No name of a method has a bracket: what is behind it is a point of its grid.
        let (name, point) = cell.method.split_at(cell.method.find('[').unwrap_or(cell.method.len()));
        let (mut method, point) = (name.to_string(), point.to_string());
        let is_taken = own.contains_key(&cell.sequence) && taken.mark(&mut cell.tracker, &mut method);
        cell.method = method + &point;
        is_taken
    });
    let mut pairs = if is_pooled { kept.frame_pairs()? } else { Vec::new() };
    for pair in &mut pairs {
        pair.method.push_str(MARK);
        pair.other.push_str(MARK);
    }
    let frame_measures = kept.frame_measures.iter().filter(|_| is_whole);
    for ([tracker, method, params], measures) in frame_measures {
        let (mut tracker, mut method) = (tracker.clone(), method.clone());
        // Of a tracker, or else of a pool.
        if taken.mark(&mut tracker, &mut method) {
            results.frame_measures.insert([tracker, method, params.clone()], *measures);
        } else if is_pooled {
            results.frame_measures.insert([tracker, marked(&method), params.clone()], *measures);
        }
    }
    let manifest::Manifest { experiment: name, version, spec_digest, .. } = &kept.manifest;
    let mut note = format!(
        "Rows marked (kept) are those of {name}, run by trackfail {version} with the same suite, protocol and seed; its \
         report says what is to be known of them."
    );
    if !is_whole {
        note.push_str(&format!(
            " They rest on those of its {} sequences that are here; scores, delays and measures of frames are known only of \
             all of them together, and are empty.",
            theirs.len()
        ));
        let learns = |m: &Method| {
            taken.methods.contains(&m.name) && m.variants.iter().any(|v| v.detector.trains_on_others())
        };
        if kept.experiment.methods.iter().any(learns) {
            note.push_str(" Kept methods that are trained on other videos learned from all of these.");
        }
    }
    let learns_from_several = |m: &&Method| {
        let mut detectors = m.variants.iter().map(|variant| &variant.detector);
        !taken.marks_methods
            && taken.methods.contains(&m.name)
            && detectors.any(|detector| detector.trains_on_others() || detector.pools_trackers())
    };
    let several = results.experiment.methods.iter().filter(learns_from_several);
    let several: Vec<&str> = several.map(|method| method.name.as_str()).collect();
    // The own and the kept trackers are others.
    if !several.is_empty() {
        note.push_str(&format!(
            " Methods that learn from several trackers ({}) were trained without the new trackers in kept rows, \
             and without the kept trackers in the others.",
            several.join(", ")
        ));
    }
    let source = format!("{name}, trackfail {version}, SHA-256 of its experiment file {spec_digest}");
    results.beside = Some(Beside { source, note, scores, failed, pairs });
    extend(&mut results.experiment, kept.experiment);
    results.put_in_order();
    Ok(())
}

/// Adds the kept methods or trackers that are taken to an experiment, and kept methods to those of its tables and figures that
/// show all methods.
pub(super) fn extend(experiment: &mut Experiment, kept: Experiment) {
    let Some(taken) = Taken::of(experiment, &kept) else { return };
    let Experiment { trackers, methods, tables, figures, .. } = experiment;
    if !taken.marks_methods {
        for method in methods.iter_mut() {
            let same = kept.methods.iter().find(|m| m.name == method.name);
            let on_kept = kept.trackers.iter().filter(|t| same.is_some_and(|m| m.runs_on(&t.label)));
            let on_own = trackers.iter().filter(|t| method.runs_on(&t.label)).map(|t| t.label.clone());
            let all: Vec<String> = on_own.chain(on_kept.map(|t| marked(&t.label))).collect();
            method.trackers = Some(all);
        }
        let kept = kept.trackers.into_iter();
        trackers.extend(kept.map(|t| Tracker { label: marked(&t.label), like: None, ..t }));
        return;
    }
    let add = |method: Method| {
        let on = taken.trackers.iter().filter(|label| method.runs_on(label));
        let on: Vec<String> = on.cloned().collect();
        (!on.is_empty()).then(|| Method {
            name: marked(&method.name),
            like: None,
            trackers: Some(on),
            ..method
        })
    };
    let added: Vec<Method> = kept.methods.into_iter().filter_map(add).collect();
    for table in tables.iter_mut() {
        show(&mut table.methods, methods, &added, |_| true);
    }
    for figure in figures.iter_mut().filter(|figure| POOLED.contains(&figure.kind.word)) {
        let takes_grids = figure.kind.word != "warning";
        show(&mut figure.params.methods, methods, &added, |method| takes_grids || !method.has_grid());
    }
    methods.extend(added);
}

/// Adds to the methods shown those that fit, where all own methods that fit are shown.
fn show(shown: &mut Vec<String>, own: &[Method], added: &[Method], fits: impl Fn(&Method) -> bool) {
    let shows_all = own.iter().filter(|&method| fits(method)).all(|method| shown.contains(&method.name));
    if shows_all && !shown.is_empty() {
        shown.extend(added.iter().filter(|&method| fits(method)).map(|method| method.name.clone()));
    }
}

#[cfg(test)]
mod tests;
