//! Running a whole experiment on all cores. The outcome does not depend on how many there are: work is
//! handed out in any order, but every result has its place and every seed comes from names.

use super::judge::{self, Judged, Model, Ready, SuiteTracks};
use super::pass::{self, CellError, Track};
use crate::dataset::lock::{self, Loaded, Missing};
use crate::dataset::{DatasetError, Sequence};
use crate::num::seed;
use crate::spec::method::DetectorChoice;
use crate::spec::{Experiment, TEST};
use rayon::prelude::*;
use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::atomic::{AtomicU64, Ordering};

/// How to run.
pub struct Options<'a> {
    /// Folder of real data, if the user gave one.
    pub data_root: Option<PathBuf>,
    /// Worker threads; `None` for one a core.
    pub jobs: Option<usize>,
    /// Called as frames are done, with done and total numbers.
    pub progress: &'a (dyn Fn(u64, u64) + Sync),
}

/// Why a run did not start.
#[derive(Debug, thiserror::Error)]
pub enum RunError {
    /// A suite cannot be read.
    #[error(transparent)]
    Dataset(#[from] DatasetError),
    /// The worker threads could not be started.
    #[error("cannot start worker threads: {0}")]
    Threads(String),
}

/// One cell: a method's variant on a tracker's run over a sequence.
pub struct Cell {
    /// Index into [`Outcome::sequences`].
    pub sequence: usize,
    /// Label of the tracker.
    pub tracker: String,
    /// Repetition, from 0.
    pub run: u32,
    /// Method.
    pub method: String,
    /// Grid point, empty without a grid.
    pub params: String,
    /// Index of the track in [`Outcome::tracks`]`[sequence]`.
    pub job: usize,
    /// Which of the track's signals the method reads.
    pub signal: Option<usize>,
    /// Threshold of the detector, for figures.
    pub threshold: Option<f64>,
    /// The result.
    pub result: Result<Judged, CellError>,
}

/// Everything that a run found out about the test suite.
pub struct Outcome {
    /// Name of the suite.
    pub suite: String,
    /// Sequences that are there, in suite order.
    pub sequences: Vec<Sequence>,
    /// Sequences that are not.
    pub missing: Vec<Missing>,
    /// How many the suite has.
    pub wanted: usize,
    /// Tracks, sequences x jobs.
    pub tracks: Vec<Vec<Result<Track, CellError>>>,
    /// Cells, sequence by sequence, in the experiment's order.
    pub cells: Vec<Cell>,
    /// Trained thresholds.
    pub models: Vec<Model>,
    /// Digests of all sequences used, by suite.
    pub digests: BTreeMap<String, Vec<(String, String)>>,
    /// Rules that stood in for missing values, with how often.
    pub rules: BTreeMap<String, u64>,
    /// Sequences whose digest is not the pinned one, as `suite/name`.
    pub differing: Vec<String>,
}

/// The suites an experiment needs: the test suite, and those it trains on.
pub fn needed_roles(experiment: &Experiment) -> Vec<&str> {
    let mut roles = vec![TEST];
    for variant in experiment.methods.iter().flat_map(|m| &m.variants) {
        if let DetectorChoice::Trained(t) = &variant.detector
            && !roles.contains(&t.role.as_str())
        {
            roles.push(&t.role);
        }
    }
    roles
}

/// Loads the suites of an experiment, by role.
///
/// # Errors
/// When a suite that is there cannot be read.
pub fn load(
    experiment: &Experiment,
    data_root: Option<&std::path::Path>,
) -> Result<BTreeMap<String, Loaded>, DatasetError> {
    needed_roles(experiment)
        .into_iter()
        .map(|role| Ok((role.to_string(), lock::suite(&experiment.suites[role])?.load(data_root))))
        .collect()
}

/// Tracks and signals of all suites: all that is costly about a run.
#[derive(Clone)]
pub struct Tracked {
    /// Tracks by role.
    by_role: BTreeMap<String, SuiteTracks>,
    /// Name and digest of all sequences, by suite.
    digests: BTreeMap<String, Vec<(String, String)>>,
}

/// Runs an experiment over suites that were loaded by [`load`].
///
/// # Errors
/// When the worker threads cannot be started or a sequence cannot be digested. What goes wrong inside
/// a cell is recorded in the cell.
pub fn run(
    experiment: &Experiment,
    suites: BTreeMap<String, Loaded>,
    options: &Options<'_>,
) -> Result<Outcome, RunError> {
    let threads = rayon::ThreadPoolBuilder::new().num_threads(options.jobs.unwrap_or(0)).build();
    let threads = threads.map_err(|e| RunError::Threads(e.to_string()))?;
    threads.install(|| {
        let tracked = track(experiment, &suites, options)?;
        Ok(judge_all(experiment, suites, tracked)?)
    })
}

/// Goes over the frames of all sequences, on the threads of the current pool.
///
/// # Errors
/// When a sequence cannot be digested.
pub fn track(
    experiment: &Experiment,
    suites: &BTreeMap<String, Loaded>,
    options: &Options<'_>,
) -> Result<Tracked, DatasetError> {
    let signals = pass::distinct_signals(experiment);
    let jobs = pass::jobs(experiment);
    let total: u64 = suites.values().flat_map(|s| &s.sequences).map(|s| s.len() as u64).sum();
    let done = AtomicU64::new(0);
    let on_frame = || (options.progress)(done.fetch_add(1, Ordering::Relaxed) + 1, total);

    // Longest first, so that the last sequence does not keep one core busy alone.
    let mut work: Vec<(&str, usize, &Sequence)> = suites
        .iter()
        .flat_map(|(role, suite)| suite.sequences.iter().enumerate().map(move |(i, s)| (role.as_str(), i, s)))
        .collect();
    work.sort_by_key(|(_, _, s)| std::cmp::Reverse(s.len()));
    let done = work.into_par_iter().with_max_len(1).map(|(role, i, sequence)| {
        let root = options.data_root.as_deref();
        let tracks = pass::pass(sequence, &jobs, &signals, experiment.seed, root, &on_frame);
        let digest = sequence.digest()?.to_string();
        Ok((role, i, (sequence.name.clone(), digest), tracks))
    });
    let mut done: Vec<_> = done.collect::<Result<_, DatasetError>>()?;
    done.sort_by_key(|d| (d.0, d.1));

    let mut tracked = Tracked { by_role: BTreeMap::new(), digests: BTreeMap::new() };
    for (role, _, name_and_digest, tracks) in done {
        let suite = &experiment.suites[role];
        let known = tracked.digests.entry(suite.clone()).or_default();
        if !known.contains(&name_and_digest) {
            known.push(name_and_digest.clone());
        }
        let of_role = tracked.by_role.entry(role.to_string()).or_insert_with(|| SuiteTracks::new(suite));
        of_role.sequences.push(name_and_digest);
        of_role.tracks.push(tracks);
    }
    Ok(tracked)
}

/// Trains, detects and scores, on the threads of the current pool.
///
/// # Errors
/// When a suite is not in datasets.lock, which reading the experiment excludes.
pub fn judge_all(
    experiment: &Experiment,
    mut suites: BTreeMap<String, Loaded>,
    mut tracked: Tracked,
) -> Result<Outcome, DatasetError> {
    let signals = pass::distinct_signals(experiment);
    let jobs = pass::jobs(experiment);
    let test = suites.remove(TEST).unwrap_or_default();
    let empty = SuiteTracks::new(&experiment.suites[TEST]);
    let of_role = |role: &str| tracked.by_role.get(role).unwrap_or(&empty);
    let (ready, models) = judge::make_ready(experiment, &signals, &jobs, &of_role);
    let tracks = &of_role(TEST).tracks;
    let cells = (0..test.sequences.len())
        .into_par_iter()
        .flat_map_iter(|s| judge_sequence(experiment, s, &test.sequences[s], &jobs, &tracks[s], &ready))
        .collect();
    let tracks = tracked.by_role.remove(TEST).map(|t| t.tracks).unwrap_or_default();
    Ok(Outcome {
        suite: experiment.suites[TEST].clone(),
        rules: count_rules(&test.sequences, &jobs, &tracks),
        differing: differing(&tracked.digests)?,
        sequences: test.sequences,
        missing: test.missing,
        wanted: test.wanted,
        tracks,
        cells,
        models,
        digests: tracked.digests,
    })
}

/// Sequences that are not what datasets.lock pins.
fn differing(digests: &BTreeMap<String, Vec<(String, String)>>) -> Result<Vec<String>, DatasetError> {
    let mut all = Vec::new();
    for (suite, sequences) in digests {
        let entries = lock::suite(suite)?.entries();
        let pinned = |name: &str| entries.iter().find(|e| e.name == name).and_then(|e| e.digest.as_deref());
        let differs = |(name, digest): &&(String, String)| pinned(name).is_some_and(|p| p != digest);
        all.extend(sequences.iter().filter(differs).map(|(name, _)| format!("{suite}/{name}")));
    }
    Ok(all)
}

fn count_rules(
    sequences: &[Sequence],
    jobs: &[pass::Job<'_>],
    tracks: &[Vec<Result<Track, CellError>>],
) -> BTreeMap<String, u64> {
    let mut rules = BTreeMap::new();
    let mut count = |rule: String, times: usize| {
        if times > 0 {
            *rules.entry(rule).or_insert(0) += times as u64;
        }
    };
    for sequence in sequences {
        let unknown = sequence.truth.iter().filter(|r| r.is_none()).count();
        count("frames without ground truth, which keep the state before them".into(), unknown);
    }
    for (job, track) in tracks.iter().flat_map(|t| jobs.iter().zip(t)) {
        let repeated = track.as_ref().map_or(0, |t| t.repeated);
        let label = &job.tracker.label;
        count(format!("{label}: frames marked failed or skipped, whose last region is repeated"), repeated);
    }
    rules
}

fn judge_sequence(
    experiment: &Experiment,
    index: usize,
    sequence: &Sequence,
    jobs: &[pass::Job<'_>],
    tracks: &[Result<Track, CellError>],
    ready: &[Ready<'_>],
) -> Vec<Cell> {
    let mut cells = Vec::new();
    for (j, job) in jobs.iter().enumerate() {
        for variant in ready {
            let params = variant.variant.params();
            let run = job.run.to_string();
            let names = [variant.method, &params, &sequence.name, &job.tracker.label, &run];
            let seed = seed::seed(experiment.seed, &names);
            let result = match (&tracks[j], &variant.detectors[job.index]) {
                (Ok(track), Ok(detector)) => {
                    Ok(judge::judge(track, variant.signal, &**detector, seed, experiment.protocol))
                }
                (Err(e), _) | (_, Err(e)) => Err(e.clone()),
            };
            let threshold = variant.detectors[job.index].as_ref().ok().and_then(|d| d.threshold());
            cells.push(Cell {
                sequence: index,
                tracker: job.tracker.label.clone(),
                run: job.run,
                method: variant.method.to_string(),
                params,
                job: j,
                signal: variant.signal,
                threshold,
                result,
            });
        }
    }
    cells
}
