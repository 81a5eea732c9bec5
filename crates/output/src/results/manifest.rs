//! `manifest.json`: the data, versions and parameters behind a results folder. The same input gives the same
//! bytes; facts that vary from run to run are in `run.json`.

use super::ResultsError;
use super::cells::{grouped, method_label};
use super::json::from_json;
use serde::{Deserialize, Serialize};
use serde_json::Value;
use sha2::{Digest, Sha256};
use std::collections::BTreeMap;
use std::io::Write;
use std::path::Path;
use trackfail_core::num::hexadecimal;
use trackfail_dataset::Frames;
use trackfail_engine::CellError;
use trackfail_engine::execute::analyse::NotAnalysed;
use trackfail_engine::execute::train::{Content, Model};
use trackfail_engine::spec::method::{Method, Variant};
use trackfail_engine::spec::{Experiment, Tracker};
use trackfail_engine::store::StoreError;
use trackfail_engine::{Cell, CellName, Outcome};

/// Name of the file. It is written last, so that a folder with it is complete.
pub const FILE: &str = "manifest.json";

/// Version of the results folder's format.
/// - 1: first version.
/// - 2: host, revision and time of the run are in `run.json`.
/// - 3: cells without a result that differ only in their method share one entry.
pub const FORMAT: u32 = 3;

/// Facts about results that readers need beside the numbers.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct Manifest {
    /// [`FORMAT`] of the program that wrote the folder.
    pub format: u32,
    /// Name of the experiment.
    pub experiment: String,
    /// SHA-256 of the experiment file's text.
    pub spec_digest: String,
    /// Version of the program.
    pub version: String,
    /// Name of the experiment's protocol.
    pub protocol: String,
    /// Seed of the experiment.
    pub seed: u64,
    /// Test suite of the results.
    pub suite: SuiteRecord,
    /// Names and digests of all sequences used, by suite, including training suites.
    pub digests: BTreeMap<String, Vec<(String, String)>>,
    /// Trackers with all parameters.
    pub trackers: Vec<TrackerRecord>,
    /// Methods with all parameters.
    pub methods: Vec<MethodRecord>,
    /// Descriptions of trained thresholds and learned models, by `method (tracker)`.
    #[serde(default)]
    pub models: Vec<(String, String)>,
    /// Number of cells with a result.
    pub cells_done: usize,
    /// Cells without a result, with the reason. Also tracks whose failure no cell reports, and failed
    /// analyses.
    #[serde(serialize_with = "write_failed", deserialize_with = "read_failed")]
    pub cells_failed: Vec<FailedCell>,
    /// Methods and analyses that were not run on a tracker because an input is lacking, and tracks that the
    /// experiment declares absent.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub not_run: Vec<NotRun>,
    /// Rules that replaced missing values, with the number of their uses.
    pub rules: BTreeMap<String, u64>,
    /// Sequences whose digest differs from that in datasets.lock, as `suite/name`.
    pub differing: Vec<String>,
    /// SHA-256 of the files in the folder, by name. Readers refuse files with another digest.
    pub files: BTreeMap<String, String>,
}

/// Test suite, and which part of it was present.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct SuiteRecord {
    /// Name of the suite.
    pub name: String,
    /// Number of targets of the whole suite.
    pub wanted: usize,
    /// Names and numbers of frames of the present sequences.
    pub present: Vec<(String, usize)>,
    /// Names of the missing sequences.
    pub missing: Vec<String>,
    /// Attributes by sequence, for those that have any.
    #[serde(default)]
    pub attributes: BTreeMap<String, Vec<String>>,
    /// Width and height of the frames in pixels, by sequence. Videos and unreadable sequences are left out.
    #[serde(default)]
    pub sizes: BTreeMap<String, (usize, usize)>,
}

/// A tracker with its parameters.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct TrackerRecord {
    /// Name in tables.
    pub label: String,
    /// Plugin kind.
    pub kind: String,
    /// Plugin version.
    pub version: u32,
    /// Number of repetitions.
    pub runs: u32,
    /// Number of repetitions on suites that models are learned from.
    #[serde(default)]
    pub training_runs: u32,
    /// Parameters, including defaults.
    pub params: Value,
}

impl TrackerRecord {
    /// The record of a tracker.
    pub(super) fn of(tracker: &Tracker) -> Self {
        let Tracker { label, kind, version, runs, training_runs, setup, .. } = tracker;
        Self {
            label: label.clone(),
            kind: kind.to_string(),
            version: *version,
            runs: *runs,
            training_runs: *training_runs,
            params: setup.params(),
        }
    }
}

/// A variant of a method with its parameters.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct MethodRecord {
    /// Name in tables.
    pub name: String,
    /// Grid point; empty without a grid.
    pub params: String,
    /// Kind, version and parameters of the signal.
    pub signal: Option<(String, u32, Value)>,
    /// Kind, version and parameters of the detector; for a trained one, those of the first candidate.
    pub detector: (String, u32, Value),
    /// Name of the trained parameter, and the suite it was trained on.
    pub trained: Option<(String, String)>,
    /// Threshold on the score, by tracker; only if the detector has one.
    pub thresholds: BTreeMap<String, f64>,
}

/// A method or an analysis that was not run on a tracker, or a track that is declared absent.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct NotRun {
    /// Label of the tracker.
    pub tracker: String,
    /// Method with its grid point, or `analysis` with a name; empty for a track.
    pub method: String,
    /// Unmet need; for a track, its sequence and the reason of its absence.
    pub reason: String,
    /// Number of cells; 0 for an analysis.
    pub cells: usize,
}

impl NotRun {
    /// Tracks of the test suite that are declared absent, then methods that were not run, in the order of
    /// their first cells, then analyses.
    fn of(experiment: &Experiment, outcome: &Outcome<'_>) -> Vec<Self> {
        let entry = |tracker: &str, method: String, reason: &str, cells: usize| Self {
            tracker: tracker.to_string(),
            method,
            reason: reason.to_string(),
            cells,
        };
        let mut all: Vec<Self> = Vec::new();
        for (sequence, tracks) in outcome.tracks.iter().enumerate() {
            for (job, track) in outcome.plan.jobs.iter().zip(tracks) {
                let Err(CellError::Absent(reason)) = track else { continue };
                let tracker = &experiment.trackers[job.tracker].label;
                // It is declared for all runs.
                if all.iter().all(|known| (&known.tracker, &known.reason) != (tracker, reason)) {
                    let is_mine = |cell: &&Cell| cell.sequence == sequence && cell.tracker == *tracker;
                    let cells = outcome.cells.iter().filter(is_mine).count();
                    all.push(entry(tracker, String::new(), reason, cells));
                }
            }
        }
        let unmet = outcome.cells.iter().filter_map(|cell| match cell.result {
            Err(CellError::Unmet(need)) => Some((&*cell.tracker, &*cell.method, &*cell.params, need)),
            _ => None,
        });
        for ((tracker, method, params, need), cells) in grouped(unmet, |what| what) {
            all.push(entry(tracker, method_label(method, params), need, cells.len()));
        }
        for NotAnalysed { analysis, tracker, error } in &outcome.not_analysed {
            if !error.is_failure() {
                all.push(entry(tracker, format!("analysis {analysis}"), &error.to_string(), 0));
            }
        }
        all
    }
}

impl std::fmt::Display for NotRun {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self { tracker, method, reason, cells } = self;
        let cells = match cells {
            0 => String::new(),
            1 => " (1 cell)".to_string(),
            more => format!(" ({more} cells)"),
        };
        match method.as_str() {
            "" => write!(f, "{tracker} {reason}{cells}"),
            method => write!(f, "{method} was not run on {tracker}{cells}: it {reason}"),
        }
    }
}

/// A cell without a result.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct FailedCell {
    /// Name of the sequence.
    pub sequence: String,
    /// Label of the tracker.
    pub tracker: String,
    /// Repetition of the tracker, from 0.
    pub run: u32,
    /// Method with its grid point; empty for the track itself.
    pub method: String,
    /// True if data are missing; false if the computation failed.
    pub missing: bool,
    /// Reason why there is no result.
    pub reason: String,
}

impl FailedCell {
    /// Record of a cell or a track without a result.
    pub fn new(CellName { sequence, tracker, run, method, params }: &CellName, error: &CellError) -> Self {
        let (sequence, tracker, reason) = (sequence.clone(), tracker.clone(), error.to_string());
        let (method, missing) = (method_label(method, params), matches!(error, CellError::Missing(_)));
        Self { sequence, tracker, run: *run, method, missing, reason }
    }
}

/// Cells without a result as stored in the file: consecutive ones that differ only in their method are
/// grouped.
#[derive(Serialize, Deserialize)]
struct FailedGroup {
    sequence: String,
    tracker: String,
    run: u32,
    /// Name of the method, in files of format 2 only.
    #[serde(default, skip_serializing)]
    method: Option<String>,
    #[serde(default)]
    methods: Vec<String>,
    missing: bool,
    reason: String,
}

fn write_failed<S: serde::Serializer>(cells: &[FailedCell], to: S) -> Result<S::Ok, S::Error> {
    fn but_method(c: &FailedCell) -> (&str, &str, u32, bool, &str) {
        (&c.sequence, &c.tracker, c.run, c.missing, &c.reason)
    }
    to.collect_seq(cells.chunk_by(|a, b| but_method(a) == but_method(b)).map(|group| {
        let FailedCell { sequence, tracker, run, missing, reason, .. } = group[0].clone();
        let methods = group.iter().map(|cell| cell.method.clone()).collect();
        FailedGroup { sequence, tracker, run, method: None, methods, missing, reason }
    }))
}

/// Longest texts of failed cells together, in bytes.
const MAX_FAILURES: usize = 1 << 28;

fn read_failed<'de, D: serde::Deserializer<'de>>(from: D) -> Result<Vec<FailedCell>, D::Error> {
    let groups = Vec::<FailedGroup>::deserialize(from)?;
    // Each method of a group gets a copy of its reason.
    let bytes =
        groups.iter().map(|g| g.methods.len() * (g.reason.len() + g.sequence.len() + g.tracker.len()));
    if bytes.sum::<usize>() > MAX_FAILURES {
        return Err(serde::de::Error::custom(format!("the failures take more than {MAX_FAILURES} bytes")));
    }
    let cells = groups.into_iter().flat_map(|group| {
        let FailedGroup { sequence, tracker, run, method, methods, missing, reason } = group;
        method.into_iter().chain(methods).map(move |method| {
            let (sequence, tracker, reason) = (sequence.clone(), tracker.clone(), reason.clone());
            FailedCell { sequence, tracker, run, method, missing, reason }
        })
    });
    Ok(cells.collect())
}

/// SHA-256 of the bytes in hexadecimal.
pub fn sha256(bytes: &[u8]) -> String {
    hexadecimal(&Sha256::digest(bytes))
}

/// Writer that computes the SHA-256 of what passes through.
struct Hashed<'w> {
    to: &'w mut dyn Write,
    hash: Sha256,
    failure: Option<std::io::Error>,
}

/// SHA-256, in hexadecimal, of what `fill` writes to the file at `path`. Errors of the file are reported before those of
/// `fill`, since polars hides them.
pub(super) fn hashed(
    path: &Path,
    to: &mut dyn Write,
    fill: impl FnOnce(&mut dyn Write) -> Result<(), ResultsError>,
) -> Result<String, ResultsError> {
    let mut file = Hashed { to, hash: Sha256::new(), failure: None };
    let filled = fill(&mut file);
    if let Some(error) = file.failure {
        return Err(StoreError::new(path, error).into());
    }
    filled.map(|()| hexadecimal(&file.hash.finalize()))
}

impl Write for Hashed<'_> {
    fn write(&mut self, bytes: &[u8]) -> std::io::Result<usize> {
        let written = self.to.write(bytes).map_err(|error| {
            let kind = error.kind();
            self.failure = Some(error).filter(|_| kind != std::io::ErrorKind::Interrupted);
            kind
        })?;
        self.hash.update(&bytes[..written]);
        Ok(written)
    }

    fn flush(&mut self) -> std::io::Result<()> {
        self.to.flush()
    }
}

impl Manifest {
    /// Creates the manifest of an outcome.
    pub fn new(experiment: &Experiment, outcome: &Outcome<'_>) -> Self {
        let failed = outcome.cells.iter().filter_map(|cell| {
            let error = cell.result.as_ref().err().filter(|_| cell.has_failed())?;
            Some(FailedCell::new(&CellName::of_cell(outcome.plan, cell), error))
        });
        let tracks = outcome.failed_tracks.iter().map(|(name, e)| FailedCell::new(name, e));
        let not_analysed = outcome.not_analysed.iter().filter(|n| n.error.is_failure());
        let not_analysed = not_analysed.map(|NotAnalysed { analysis, tracker, error }| {
            let method = format!("analysis {analysis} of {tracker}");
            FailedCell::new(&CellName { sequence: "*".to_string(), method, ..CellName::default() }, error)
        });
        let attributed = outcome.sequences().filter(|s| !s.attributes.is_empty());
        let attributes = attributed.map(|s| (s.name.clone(), s.attributes.clone()));
        // The size of a video's frames is known only after decoding it.
        let still = outcome.sequences().filter(|s| !matches!(s.frames, Frames::Video(_)));
        let sizes = still.filter_map(|s| Some((s.name.clone(), s.size().ok()?)));
        Self {
            format: FORMAT,
            experiment: experiment.name.clone(),
            spec_digest: sha256(experiment.source.as_bytes()),
            version: env!("CARGO_PKG_VERSION").to_string(),
            protocol: experiment.protocol.map_or_else(String::new, |p| p.name.to_string()),
            seed: experiment.seed,
            suite: SuiteRecord {
                name: outcome.suite().to_string(),
                wanted: outcome.test().wanted,
                present: outcome.sequences().map(|s| (s.name.clone(), s.len())).collect(),
                missing: outcome.test().missing.iter().map(|m| m.name.clone()).collect(),
                attributes: attributes.collect(),
                sizes: sizes.collect(),
            },
            digests: outcome.plan.digests(),
            trackers: experiment.trackers.iter().map(TrackerRecord::of).collect(),
            methods: method_records(experiment, outcome),
            models: model_records(&outcome.models),
            cells_done: outcome.cells.iter().filter(|c| c.result.is_ok()).count(),
            cells_failed: failed.chain(tracks).chain(not_analysed).collect(),
            not_run: NotRun::of(experiment, outcome),
            rules: outcome.rules.clone(),
            differing: outcome.differing.clone(),
            files: BTreeMap::new(),
        }
    }

    /// Record of a method; `None` if it has a grid.
    pub fn method(&self, name: &str) -> Option<&MethodRecord> {
        self.methods.iter().find(|m| m.name == name && m.params.is_empty())
    }
}

/// Describes trained thresholds and learned models. A model that several variants share is described once.
fn model_records<'m>(models: &'m [Model]) -> Vec<(String, String)> {
    let mut written: Vec<&'m Value> = Vec::new();
    let record = |m: &'m Model| {
        let text = match &m.content {
            Content::Chosen { parameter, value, maximise, reached, candidates } => {
                let reached = reached.map_or("no value".to_string(), |r| format!("{r:.4}"));
                let tried = candidates.len();
                format!("{parameter} = {value} of {tried} values, {maximise} {reached}")
            }
            Content::OnOthers { folds } => {
                let values = folds.iter().filter_map(|fold| {
                    let Content::Chosen { value, .. } = &fold.content else { return None };
                    Some(value.to_string())
                });
                let values: Vec<String> = values.collect();
                format!("{} folds, without this tracker: {}", folds.len(), values.join(", "))
            }
            Content::Learned { model, threshold } => {
                let threshold = threshold.map_or(String::new(), |t| format!("threshold {t}; "));
                if written.contains(&model) {
                    threshold + "the same model"
                } else {
                    written.push(model);
                    format!("{threshold}{model}")
                }
            }
        };
        let name = format!("{} ({})", method_label(&m.method, &m.params), m.tracker);
        (name, format!("{}, {}: {text}", m.suite, runs(m.runs)))
    };
    models.iter().map(record).collect()
}

fn method_records(experiment: &Experiment, outcome: &Outcome<'_>) -> Vec<MethodRecord> {
    let mut thresholds: BTreeMap<(&str, &str), BTreeMap<String, f64>> = BTreeMap::new();
    for cell in &outcome.cells {
        let of_variant = thresholds.entry((&cell.method, &cell.params)).or_default();
        of_variant.extend(cell.threshold.map(|threshold| (cell.tracker.clone(), threshold)));
    }
    let variants = experiment.methods.iter().flat_map(|m| m.variants.iter().map(move |v| (m, v)));
    let record = |(method, variant): (&Method, &Variant)| {
        let params = variant.params();
        let fixed = &variant.detector.example;
        let model = || fixed.detector.learner().map(|_| "model".to_string());
        let key = variant.detector.training.as_ref().map(|training| training.key.clone()).or_else(model);
        let suite = variant.detector.role().and_then(|role| experiment.suite_of(role));
        let on_others = variant.detector.trains_on_others();
        let learned_on = |suite: &String| match on_others {
            true => format!("other videos and other trackers of {suite}"),
            false => suite.clone(),
        };
        // Every fold has its own, see the models.
        let thresholds = thresholds.get(&(&*method.name, &*params)).filter(|_| !on_others);
        MethodRecord {
            name: method.name.clone(),
            signal: variant.signals.first().map(|s| (s.kind.to_string(), s.version, s.signal.params())),
            detector: (fixed.kind.to_string(), fixed.version, fixed.detector.params()),
            trained: key.zip(suite.map(learned_on)),
            thresholds: thresholds.cloned().unwrap_or_default(),
            params,
        }
    };
    variants.map(record).collect()
}

/// Number of runs in words: `1 run`, `10 runs`.
pub fn runs(n: u32) -> String {
    if n == 1 { "1 run".to_string() } else { format!("{n} runs") }
}

/// Parses a manifest; `path` is for messages.
///
/// # Errors
/// When the bytes are not a manifest, or are of a later format.
pub fn parse(path: &Path, bytes: &[u8]) -> Result<Manifest, ResultsError> {
    let manifest: Manifest = from_json(path, bytes)?;
    if manifest.format > FORMAT {
        let what = format!("results format {}; this program reads up to {FORMAT}", manifest.format);
        return Err(StoreError::new(path.parent().unwrap_or(path), what).into());
    }
    Ok(manifest)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::results::bytes::parts_to_parquet;
    use polars::prelude::{Column, DataFrame};

    // A reason is kept once for many methods in a file, and once for each of them in memory.
    #[test]
    fn failures_have_room_for_their_reasons_and_no_more() {
        let of = |methods: usize, reason: usize| {
            let (methods, reason) = (vec![""; methods], "x".repeat(reason));
            let group = serde_json::json!({
                "sequence": "s", "tracker": "t", "run": 0, "methods": methods, "missing": false, "reason": reason
            });
            read_failed(serde_json::json!([group])).map(|cells| cells.len())
        };
        assert_eq!(of(3, 1000).unwrap(), 3);
        trackfail_testing::assert_says(of(100_000, 10_000).unwrap_err(), "the failures take more than");
    }

    // Before: "table: Invalid thrift: transport error", without the file's name.
    #[cfg(target_os = "linux")]
    #[test]
    fn a_full_disk_is_told_of_a_parquet_file() {
        let values: Vec<i64> = (0..1000).map(|k| k * k).collect();
        let frame = DataFrame::new(1000, vec![Column::new("score".into(), values)]).unwrap();
        let fill = |disk: &mut dyn Write| {
            hashed(Path::new("frames.parquet"), disk, |file| parts_to_parquet(file, [Ok(frame.clone())]))
        };
        assert_eq!(fill(&mut std::io::sink()).unwrap().len(), 64);
        for room in [0, 4, 100, 1000] {
            let full = std::fs::File::create("/dev/full").unwrap();
            let mut disk = std::io::BufWriter::with_capacity(room, full);
            let told = fill(&mut disk).unwrap_err().to_string();
            assert!(told.starts_with("frames.parquet: No space left on device"), "{room}: {told}");
        }
    }
}
