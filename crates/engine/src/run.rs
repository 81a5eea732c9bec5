//! Running a whole experiment on all cores. The outcome does not depend on how many there are, nor on what
//! was computed before: work is handed out in any order, but every result has its place and every seed
//! comes from names.

mod share;

pub use share::{Shared, run_shard};

use super::address::{Address, Recipe};
use super::analyse::{self, Analysed, NotAnalysed};
use super::judge::{
    self, CachedDetectorOutput, Case, Judged, ReadyDetector, StoredDetectorOutput, signal_of,
};
use super::pass::CellError;
use super::plan::{ExperimentPlan, Job, variants};
use super::progress::ProgressWatch;
use super::reverse::FRAMES_IN_MEMORY;
use super::shard::Shard;
use super::store::{Name, Record, Store, StoreError};
use super::supervise::{Interrupted, RunLimits};
use super::tally::Tally;
use super::timing;
use super::tracks::{self, Track, Tracks};
use super::train::{self, Model, Ready};
use crate::dataset::frame_cache::FrameCache;
use crate::dataset::lock::{self, Loaded, Missing};
use crate::dataset::{DatasetError, Sequence};
use crate::detector::DetectorOutput;
use crate::spec::Experiment;
use crate::spec::method::Method;
use rayon::prelude::*;
use serde::de::DeserializeOwned;
use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, AtomicUsize, Ordering};

/// How to run.
#[derive(Clone)]
pub struct Options {
    /// Folder of real data, if the user gave one.
    pub data_root: Option<PathBuf>,
    /// Compute everything anew, whatever the store has.
    pub force: bool,
    /// Time limit a cell, and the flag that ends the run.
    pub limits: RunLimits,
    /// Called as frames are done, with done and total numbers.
    pub progress: Arc<dyn Fn(u64, u64) + Send + Sync>,
    /// Counts what is done, for onlookers.
    pub watch: Arc<ProgressWatch>,
}

impl Default for Options {
    fn default() -> Self {
        let (limits, progress) = (RunLimits::default(), Arc::new(|_, _| {}));
        Self { data_root: None, force: false, limits, progress, watch: Arc::default() }
    }
}

/// Why a run was not finished.
#[derive(Debug, thiserror::Error)]
pub enum RunError {
    /// A suite cannot be read.
    #[error(transparent)]
    Dataset(#[from] DatasetError),
    /// The store cannot be written to.
    #[error(transparent)]
    Store(#[from] StoreError),
    /// It was asked to stop; what was finished is in the store.
    #[error("interrupted; run the same command to go on from what is done")]
    Interrupted,
}

impl From<Interrupted> for RunError {
    fn from(_: Interrupted) -> Self {
        Self::Interrupted
    }
}

/// Verdicts beyond this many bytes are read from the store when they are needed.
const VERDICTS_IN_MEMORY: usize = 128 << 20;

/// What the parts of a run share.
pub struct Context<'a> {
    /// The plan.
    pub plan: &'a ExperimentPlan<'a>,
    /// The store.
    pub store: &'a Store,
    /// How to run.
    pub options: &'a Options,
    /// What was computed.
    pub tally: Tally,
    /// Called once a decoded frame.
    pub on_frame: Arc<dyn Fn() + Send + Sync>,
    /// Decoded frames, kept where trackers run backwards.
    pub frames: Arc<FrameCache>,
    held: AtomicUsize,
}

impl<'a> Context<'a> {
    fn new(plan: &'a ExperimentPlan<'a>, store: &'a Store, options: &'a Options, frames: u64) -> Self {
        let (done, progress, watch) = (AtomicU64::new(0), options.progress.clone(), options.watch.clone());
        watch.frames(0, frames);
        let on_frame = move || {
            let done = (done.fetch_add(1, Ordering::Relaxed) + 1).min(frames);
            watch.frames(done, frames);
            progress(done, frames);
        };
        let tally = Tally::default();
        let frames = Arc::new(FrameCache::new(if plan.needs_reverse() { FRAMES_IN_MEMORY } else { 0 }));
        Self { plan, store, options, tally, on_frame: Arc::new(on_frame), frames, held: AtomicUsize::new(0) }
    }

    /// The content of a record that may be used: none when everything is to be computed anew.
    pub fn kept<T: DeserializeOwned>(&self, address: &Address, rows: usize) -> Option<T> {
        if self.options.force { None } else { self.store.get(address, rows) }
    }

    /// A cell of the test suite that is to be judged; `cell` is its name in the plan.
    fn case(
        &self,
        cell: &str,
        track: &Arc<Track>,
        (variant, method): (usize, &Method),
        ready_detector: ReadyDetector,
        seed: u64,
    ) -> Case {
        let cell = self.plan.stored_name(cell);
        Case {
            protocol: method.protocol,
            name: Name { experiment: self.plan.experiment.name.clone(), cell },
            track: track.clone(),
            signal: self.plan.signal(variant),
            ready_detector,
            seed,
        }
    }

    /// Keeps records; those that are computed anew although they were there are compared with what was.
    ///
    /// # Errors
    /// When the store cannot be written to.
    pub fn put(&self, records: Vec<Record>) -> Result<(), RunError> {
        if self.options.force {
            let other = |r: &&Record| self.store.differs(r);
            let addresses: Vec<Address> =
                records.iter().filter(other).map(|r| r.head.recipe.address()).collect();
            self.store.forget(&addresses);
        }
        Ok(self.store.put(&records)?)
    }

    /// A verdict in memory as long as there is room, where it is in the store.
    pub fn hold(&self, recipe: &Recipe, verdict: DetectorOutput) -> CachedDetectorOutput {
        let extra = [verdict.forecast.is_some(), verdict.quality.is_some()].map(|has| 8 * usize::from(has));
        let bytes = verdict.score.len() * (9 + extra[0] + extra[1]);
        if self.held.fetch_add(bytes, Ordering::Relaxed) + bytes <= VERDICTS_IN_MEMORY {
            CachedDetectorOutput::Here(Arc::new(verdict))
        } else {
            CachedDetectorOutput::Stored(recipe.address())
        }
    }
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
pub struct Outcome<'a> {
    /// Name of the suite.
    pub suite: String,
    /// Sequences that are there, in suite order.
    pub sequences: Vec<Arc<Sequence>>,
    /// Sequences that are not.
    pub missing: Vec<Missing>,
    /// How many the suite has.
    pub wanted: usize,
    /// Tracks, sequences x jobs.
    pub tracks: Vec<Tracks>,
    /// The jobs.
    pub jobs: Vec<Job>,
    /// Cells, sequence by sequence, in the experiment's order.
    pub cells: Vec<Cell>,
    /// What was trained or learned.
    pub models: Vec<Model>,
    /// Analyses.
    pub analyses: Vec<Analysed>,
    /// Analyses that could not be made, by name, with the reason.
    pub not_analysed: Vec<NotAnalysed>,
    /// Digests of all sequences used, by suite.
    pub digests: BTreeMap<String, Vec<(String, String)>>,
    /// Rules that stood in for missing values, with how often.
    pub rules: BTreeMap<String, u64>,
    /// Sequences whose digest is not the pinned one, as `suite/name`.
    pub differing: Vec<String>,
    /// What was computed and what was there.
    pub tally: Tally,
    store: &'a Store,
}

impl Outcome<'_> {
    /// What the detector of a cell said.
    ///
    /// # Errors
    /// When it was to be read from the store and has gone.
    pub fn verdict(&self, cell: &Cell, judged: &Judged) -> Result<Arc<DetectorOutput>, StoreError> {
        let address = match &judged.verdict {
            CachedDetectorOutput::Here(verdict) => return Ok(verdict.clone()),
            CachedDetectorOutput::Stored(address) => address,
        };
        let track =
            self.tracks.get(cell.sequence).and_then(|t| t.get(cell.job)).and_then(|t| t.as_ref().ok());
        let verdict = track.and_then(|track| {
            let signal = signal_of(track, cell.signal);
            self.store.get::<StoredDetectorOutput>(address, signal.len())?.on(&signal)
        });
        let gone =
            || StoreError::new(self.store.folder(), "a record has gone while it was needed; run again");
        verdict.map(Arc::new).ok_or_else(gone)
    }
}

/// Loads the suites of an experiment, by role.
///
/// # Errors
/// When a suite that is there cannot be read.
pub fn load(
    experiment: &Experiment,
    data_root: Option<&std::path::Path>,
) -> Result<BTreeMap<String, Loaded>, DatasetError> {
    super::plan::needed_roles(experiment)
        .into_iter()
        .map(|role| Ok((role.to_string(), lock::suite(&experiment.suites[role])?.load(data_root))))
        .collect()
}

/// Work on one sequence: suite, sequence, jobs.
type Unit = (usize, usize, Vec<usize>);

/// Every sequence with the jobs that belong to a share, the longest first, so that the last one does not
/// keep one core busy alone.
fn units(plan: &ExperimentPlan<'_>, shard: Option<Shard>) -> Vec<Unit> {
    let sequences = plan.suites.iter().enumerate();
    let all: Vec<(usize, usize, usize)> = sequences
        .flat_map(|(suite, s)| (0..s.sequences.len()).map(move |sequence| (suite, sequence)))
        .flat_map(|(suite, sequence)| (0..plan.jobs.len()).map(move |job| (suite, sequence, job)))
        .filter(|(suite, _, job)| plan.wants(*suite, *job))
        .collect();
    let frames = |(suite, sequence, _): &(usize, usize, usize)| {
        plan.suites[*suite].sequences[*sequence].sequence.len() as u64
    };
    let mine = shard.map(|shard| shard.of(&all.iter().map(frames).collect::<Vec<_>>()));
    let mut units: Vec<Unit> = Vec::new();
    for (k, (suite, sequence, job)) in all.into_iter().enumerate() {
        if mine.as_ref().is_some_and(|mine| !mine[k]) {
            continue;
        }
        match units.last_mut() {
            Some((last_suite, last_sequence, jobs)) if (*last_suite, *last_sequence) == (suite, sequence) => {
                jobs.push(job);
            }
            _ => units.push((suite, sequence, vec![job])),
        }
    }
    units.sort_by_key(|(suite, sequence, _)| std::cmp::Reverse(frames(&(*suite, *sequence, 0))));
    units
}

/// Frames that have to be gone over.
fn frames_to_do(plan: &ExperimentPlan<'_>, store: &Store, options: &Options, units: &[Unit]) -> u64 {
    let of_unit = |(suite, sequence, jobs): &Unit| {
        let planned = &plan.suites[*suite].sequences[*sequence];
        let to_do = |j: usize, track: &Recipe| options.force || !plan.is_kept(store, *suite, j, track);
        let to_do = jobs.iter().any(|j| planned.tracks[*j].as_ref().is_ok_and(|track| to_do(*j, track)));
        if to_do { planned.sequence.len() as u64 } else { 0 }
    };
    units.par_iter().map(of_unit).sum()
}

/// Runs an experiment that was laid out, on the threads of the current pool.
///
/// # Errors
/// When it is interrupted or the store cannot be written to. What goes wrong inside a cell is recorded
/// in the cell.
pub fn run<'s>(
    plan: &ExperimentPlan<'_>,
    store: &'s Store,
    options: &Options,
) -> Result<Outcome<'s>, RunError> {
    let (units, watch) = (units(plan, None), &options.watch);
    watch.all_cells(plan.cells().len());
    watch.stage("running trackers");
    let context = Context::new(plan, store, options, frames_to_do(plan, store, options, &units));
    let of_unit = |(suite, sequence, jobs): &Unit| {
        let planned = &plan.suites[*suite].sequences[*sequence];
        let _at = watch.at(&planned.sequence.name);
        let not_wanted = || Err(CellError::Missing("not asked for".to_string()));
        let mut row: Tracks = plan.jobs.iter().map(|_| not_wanted()).collect();
        for (j, track) in jobs.iter().zip(tracks::tracks(&context, *suite, planned, jobs)?) {
            row[*j] = track;
        }
        Ok((*suite, *sequence, row))
    };
    let mut done: Vec<_> = units.par_iter().with_max_len(1).map(of_unit).collect::<Result<_, RunError>>()?;
    done.sort_by_key(|(suite, sequence, _)| (*suite, *sequence));
    let mut tracks: Vec<Vec<Tracks>> = plan.suites.iter().map(|_| Vec::new()).collect();
    for (suite, _, of_sequence) in done {
        tracks[suite].push(of_sequence);
    }
    watch.stage("training and analysing");
    let (ready, models) = train::make_ready(&context, &tracks)?;
    let mut found = analyse::analyse(&context, &tracks)?;
    let test = plan.test();
    watch.stage("judging");
    let judged =
        (0..test.sequences.len()).into_par_iter().map(|s| judge_sequence(&context, s, &tracks[0][s], &ready));
    let cells = judged.collect::<Result<Vec<_>, RunError>>()?.into_iter().flatten().collect();
    watch.stage("measuring times");
    found.extend(timing::measure(&context, &tracks, &ready)?);
    let (mut analyses, mut not_analysed) = (Vec::new(), Vec::new());
    for analysed in found {
        match analysed {
            Ok(analysed) => analyses.push(analysed),
            Err(failed) => not_analysed.push(failed),
        }
    }
    let tracks = tracks.swap_remove(0);
    let mut digests = BTreeMap::new();
    for suite in &plan.suites {
        let names = suite.sequences.iter().map(|s| (s.sequence.name.clone(), s.digest.clone()));
        digests.insert(suite.name.clone(), names.collect());
    }
    Ok(Outcome {
        suite: test.name.clone(),
        rules: count_rules(plan, &tracks),
        differing: differing(&digests)?,
        sequences: test.sequences.iter().map(|s| s.sequence.clone()).collect(),
        missing: test.missing.clone(),
        wanted: test.wanted,
        tracks,
        jobs: plan.jobs.clone(),
        cells,
        models,
        analyses,
        not_analysed,
        digests,
        tally: context.tally,
        store,
    })
}

/// Sequences that are not what datasets.lock pins.
fn differing(digests: &BTreeMap<String, Vec<(String, String)>>) -> Result<Vec<String>, DatasetError> {
    let mut all = Vec::new();
    for (suite, sequences) in digests {
        let suite_entries = lock::suite(suite)?;
        let entries = suite_entries.entries();
        let pinned = |name: &str| entries.iter().find(|e| e.name == name).and_then(|e| e.digest.as_deref());
        let differs = |(name, digest): &&(String, String)| pinned(name).is_some_and(|p| p != digest);
        all.extend(sequences.iter().filter(differs).map(|(name, _)| format!("{suite}/{name}")));
    }
    Ok(all)
}

fn count_rules(plan: &ExperimentPlan<'_>, tracks: &[Tracks]) -> BTreeMap<String, u64> {
    let mut rules = BTreeMap::new();
    let mut count = |rule: String, times: usize| {
        if times > 0 {
            *rules.entry(rule).or_insert(0) += times as u64;
        }
    };
    for planned in &plan.test().sequences {
        let unknown = planned.sequence.truth.iter().filter(|r| r.is_none()).count();
        count("frames without ground truth, which keep the state before them".into(), unknown);
    }
    let shown = |job: &Job| job.run < plan.experiment.trackers[job.tracker].runs;
    let tracks = tracks.iter().flat_map(|t| plan.jobs.iter().zip(t));
    for (job, track) in tracks.filter(|(job, _)| shown(job)) {
        let repeated = track.as_ref().map_or(0, |t| t.repeated);
        let label = &plan.experiment.trackers[job.tracker].label;
        count(format!("{label}: frames marked failed or skipped, whose last region is repeated"), repeated);
    }
    rules
}

fn judge_sequence(
    context: &Context<'_>,
    index: usize,
    tracks: &Tracks,
    ready: &Ready,
) -> Result<Vec<Cell>, RunError> {
    let plan = context.plan;
    let sequence = &plan.test().sequences[index].sequence;
    let _at = context.options.watch.at(&sequence.name);
    let mut cells: Vec<Cell> = Vec::new();
    let mut cases: Vec<(usize, Case)> = Vec::new();
    let variants: Vec<_> = variants(plan.experiment).collect();
    for (j, v) in plan.cells_of_sequence() {
        let (job, (method, variant)) = (plan.jobs[j], variants[v]);
        let params = variant.params();
        let ready_detector = &ready[v][job.tracker];
        let result = match (&tracks[j], ready_detector) {
            (Err(e), _) | (_, Err(e)) => Err(e.clone()),
            (Ok(track), Ok(ready_detector)) => {
                let name = plan.cell_name(&sequence.name, job, &method.name, &params);
                let seed = plan.seed(&method.name, &params, &sequence.name, job);
                cases.push((
                    cells.len(),
                    context.case(&name, track, (v, method), ready_detector.clone(), seed),
                ));
                // Replaced below.
                Err(CellError::Missing(String::new()))
            }
        };
        cells.push(Cell {
            sequence: index,
            tracker: plan.experiment.trackers[job.tracker].label.clone(),
            run: job.run,
            method: method.name.clone(),
            params,
            job: j,
            signal: plan.signal(v),
            threshold: ready_detector.as_ref().ok().and_then(|a| a.fixed.detector.threshold()),
            result,
        });
    }
    let (places, cases): (Vec<_>, Vec<_>) = cases.into_iter().unzip();
    for (place, judged) in places.into_iter().zip(judge::judge(context, cases)?) {
        cells[place].result = judged;
    }
    context.options.watch.cells(cells.len());
    Ok(cells)
}
