//! The plan of an experiment: sequences with their digests, tracks and cells with their recipes.

use super::confidence;
use super::demand::{Demand, SignalSet, demands, distinct_signals, signal_index, variants};
use super::folds;
use super::job::Job;
use super::recipes::{self, Ingredient, Read};
use crate::error::{CellError, RunError};
use crate::limits::Stop;
use crate::spec::method::{Method, SignalChoice, Variant};
use crate::spec::{Experiment, FoldsBy, TEST};
use crate::store::address::{Address, Recipe, Stage};
use rayon::prelude::*;
use std::collections::{BTreeMap, BTreeSet};
use std::path::PathBuf;
use std::sync::Arc;
use trackfail_core::num::seed;
use trackfail_dataset::Sequence;
use trackfail_dataset::suite::{Loaded, Missing, Origin};
use trackfail_methods::signal::Reads;
use trackfail_methods::tracker::RunContext;

/// The need of what looks at pixels.
const NEEDS_FRAMES: &str = "needs frames, and the suite has boxes only";
/// Why a tracker has no track on a video of another source than its own.
const ELSEWHERE: &str = "runs on videos of other sources";

/// A sequence whose files are present.
pub struct PlannedSequence {
    /// The sequence.
    pub sequence: Arc<Sequence>,
    /// The video that it is of, see [`folds::video`], and the source that it comes from.
    pub origin: Origin,
    /// Its digest; empty if it cannot be read.
    pub digest: String,
    /// Recipe of each job's track; an error for tracks that are not needed or cannot be made.
    pub tracks: Vec<Result<Recipe, CellError>>,
    /// Address of each of these recipes, made once because everything on a track is addressed by it.
    addresses: Vec<Result<Address, CellError>>,
    /// The files that each of the experiment's signals reads besides those of the track.
    signal_files: Vec<Result<Vec<Ingredient>, CellError>>,
    /// Whether each job's tracker gives its confidence here; empty if no signal reads it.
    pub(super) gives_confidence: Vec<bool>,
}

/// A suite with its present and missing sequences.
pub struct PlannedSuite {
    /// Its name.
    pub name: String,
    /// Present sequences, in suite order.
    pub sequences: Vec<PlannedSequence>,
    /// Missing sequences.
    pub missing: Vec<Missing>,
    /// Number of sequences of the whole suite.
    pub wanted: usize,
}

/// Plan of an experiment: its suites, jobs and signals, and the recipes of its results.
pub struct ExperimentPlan<'a> {
    /// The experiment.
    pub experiment: &'a Experiment,
    /// Its distinct signals.
    pub signals: Arc<Vec<SignalChoice>>,
    /// Its trackers and repetitions; not all of them are needed on every suite.
    pub jobs: Vec<Job>,
    /// Its distinct suites; the test suite is the first.
    pub suites: Vec<PlannedSuite>,
    /// Fold of each sequence of the test suite.
    folds: Vec<usize>,
    demands: Vec<Demand<'a>>,
    /// The signals of each variant.
    variant_signals: Vec<SignalSet>,
    /// Trackers whose tracks have no confidence, none of them.
    without_confidence: BTreeSet<usize>,
}

/// Place of a track: indices of its suite, sequence and job.
pub type Place = (usize, usize, usize);

impl<'a> ExperimentPlan<'a> {
    /// Plans an experiment on loaded suites, by role. Reads every file of them once, for the digests, on the threads of
    /// the current pool.
    ///
    /// # Errors
    /// [`RunError::Interrupted`]. A sequence that cannot be read has an error in place of each track.
    pub fn new(
        experiment: &'a Experiment,
        loaded: BTreeMap<String, Loaded>,
        data_roots: &[PathBuf],
        stop: &Stop,
    ) -> Result<Self, RunError> {
        let signals = distinct_signals(experiment);
        let set = |(_, v): (&Method, &Variant)| SignalSet {
            first: v.signal.as_ref().and_then(|s| signal_index(&signals, s)),
            more: v.more_signals.iter().filter_map(|s| signal_index(&signals, s)).collect(),
        };
        let variant_signals: Vec<SignalSet> = variants(experiment).map(set).collect();
        let demands = demands(experiment, &signals, &variant_signals);
        let most = |tracker: usize| {
            let mine = demands.iter().filter(move |d| d.tracker == tracker);
            mine.map(|d| d.runs).max().unwrap_or(0)
        };
        let trackers = 0..experiment.trackers.len();
        let jobs = trackers.flat_map(|tracker| (0..most(tracker)).map(move |run| Job { tracker, run }));
        let jobs: Vec<Job> = jobs.collect();
        let mut suites: Vec<PlannedSuite> = Vec::new();
        let mut by_role: Vec<_> = loaded.into_iter().collect();
        by_role.sort_by_key(|(role, _)| role != TEST);
        for (role, suite) in by_role {
            let name = &experiment.suites[&role];
            if suites.iter().any(|known| known.name == *name) {
                continue;
            }
            let plan = |(sequence, origin): (Sequence, Origin)| {
                if stop.is_set() {
                    return Err(RunError::Interrupted);
                }
                // A sequence that cannot be read fails alone.
                let digest = sequence.digest().map(str::to_string);
                let digest = digest.map_err(|e| CellError::Failed(format!("{}: {e}", sequence.name)));
                let common = digest.clone().and_then(|digest| recipes::sequence(&sequence, &digest));
                let wanted = |job: &Job| demands.iter().any(|d| d.is_for(name, *job));
                let track = |job: &Job| match &common {
                    _ if !experiment.trackers[job.tracker].runs_on(&origin.source) => {
                        Err(CellError::Unmet(ELSEWHERE))
                    }
                    _ if !wanted(job) => Err(CellError::Missing("not asked for".to_string())),
                    _ if !sequence.has_frames() && experiment.trackers[job.tracker].setup.reads_pixels() => {
                        Err(CellError::Unmet(NEEDS_FRAMES))
                    }
                    Ok(common) => recipes::track(experiment, &sequence, common, *job, data_roots),
                    Err(e) => Err(e.clone()),
                };
                let tracks: Vec<_> = jobs.iter().map(track).collect();
                let address = |track: &Result<Recipe, CellError>| {
                    track.as_ref().map(Recipe::address).map_err(Clone::clone)
                };
                let files = |choice: &SignalChoice| recipes::signal_files(&sequence, choice, data_roots);
                let reads_confidence = signals.iter().any(|s| s.signal.reads() == Reads::Confidence);
                let gives_confidence = |job: &Job| {
                    let tracker = &experiment.trackers[job.tracker].setup;
                    let sequence = &sequence;
                    let context = RunContext { sequence, start_frame: 0, run: job.run, seed: 0, data_roots };
                    tracker.gives_confidence(&context)
                };
                let confident = jobs.iter().filter(|_| reads_confidence);
                Ok(PlannedSequence {
                    digest: digest.unwrap_or_default(),
                    signal_files: signals.iter().map(files).collect(),
                    gives_confidence: confident.map(gives_confidence).collect(),
                    addresses: tracks.iter().map(address).collect(),
                    tracks,
                    origin: Origin { video: folds::video(&origin.video), ..origin },
                    sequence: Arc::new(sequence),
                })
            };
            let sequences = suite.sequences.into_par_iter().zip(suite.origins);
            let sequences = sequences.map(plan).collect::<Result<_, RunError>>()?;
            suites.push(PlannedSuite {
                name: name.clone(),
                sequences,
                missing: suite.missing,
                wanted: suite.wanted,
            });
        }
        let origins: Vec<&Origin> = suites[0].sequences.iter().map(|s| &s.origin).collect();
        let folds = folds::folds(experiment.folds, &origins, experiment.seed);
        let (signals, without_confidence) = (Arc::new(signals), confidence::trackers_without(&suites, &jobs));
        Ok(Self { experiment, jobs, suites, folds, demands, variant_signals, signals, without_confidence })
    }

    /// The test suite.
    pub fn test(&self) -> &PlannedSuite {
        &self.suites[0]
    }

    /// Index of the suite of a role.
    pub fn suite(&self, role: &str) -> Option<usize> {
        let name = self.experiment.suite_of(role)?;
        self.suites.iter().position(|s| s.name == *name)
    }

    /// Index of the distinct signal that a variant reads, if it reads one.
    pub fn signal(&self, variant: usize) -> Option<usize> {
        self.variant_signals.get(variant)?.first
    }

    /// All signals that a variant reads.
    pub fn signals_of(&self, variant: usize) -> &SignalSet {
        &self.variant_signals[variant]
    }

    /// Whether any method runs trackers backwards.
    pub fn needs_reverse(&self) -> bool {
        variants(self.experiment).any(|(_, v)| v.detector.needs_reverse())
    }

    /// Whether a job's track is needed on a suite.
    pub fn wants(&self, suite: usize, job: usize) -> bool {
        self.demands.iter().any(|d| d.is_for(&self.suites[suite].name, self.jobs[job]))
    }

    /// Indices of the signals that are read from the tracks of a tracker on a suite.
    pub fn signals_on(&self, suite: usize, tracker: usize) -> BTreeSet<usize> {
        let suite = &self.suites[suite].name;
        let mine = self.demands.iter().filter(|d| d.tracker == tracker && d.suite == suite);
        mine.filter_map(|d| d.signal).collect()
    }

    /// Whether a signal is needed, and can be computed, on a job's track.
    pub fn wants_signal(&self, suite: usize, planned: &PlannedSequence, job: usize, signal: usize) -> bool {
        let suite = &self.suites[suite].name;
        self.demands.iter().any(|d| d.signal == Some(signal) && d.is_for(suite, self.jobs[job]))
            && self.unmet(planned, job, Some(signal)).is_none()
    }

    /// The need of a job's tracker, or of a signal on its track, that the sequence or the tracker does not meet, if there
    /// is one; what has such a need is not run. Or the reason why a file that the signal reads cannot be read.
    pub fn unmet(&self, planned: &PlannedSequence, job: usize, signal: Option<usize>) -> Option<CellError> {
        let place = self.jobs[job].tracker;
        let tracker = &self.experiment.trackers[place];
        if !tracker.runs_on(&planned.origin.source) {
            return Some(CellError::Unmet(ELSEWHERE));
        }
        let reads = signal.and_then(|k| self.signals.get(k)).map(|choice| choice.signal.reads());
        let reads_pixels = tracker.setup.reads_pixels() || reads == Some(Reads::Pixels);
        if reads_pixels && !planned.sequence.has_frames() {
            return Some(CellError::Unmet(NEEDS_FRAMES));
        }
        let given = match reads {
            None | Some(Reads::Pixels | Reads::Boxes) => true,
            Some(Reads::Posterior) => tracker.setup.gives_posterior(),
            Some(Reads::Response) => tracker.setup.gives_response(),
            Some(Reads::Confidence) if self.without_confidence.contains(&place) => false,
            // A track that cannot be read has a reason of its own.
            Some(Reads::Confidence) if planned.tracks[job].is_err() => true,
            Some(Reads::Confidence) if planned.gives_confidence.get(job) == Some(&true) => true,
            Some(Reads::Confidence) => {
                return Some(confidence::missing(planned, job, &tracker.label));
            }
            Some(Reads::Companions) => self.companions(planned, job).next().is_some(),
        };
        let unmet = reads.filter(|_| !given).and_then(Reads::need_of_tracker).map(CellError::Unmet);
        unmet.or_else(|| planned.signal_files.get(signal?)?.as_ref().err().cloned())
    }

    /// Why a job's track, which was made unless there is an `error`, or a signal that is read from it on a suite is not there
    /// although it was to be made.
    pub fn failure(
        &self,
        suite: usize,
        planned: &PlannedSequence,
        job: usize,
        error: Option<&CellError>,
    ) -> Option<CellError> {
        let mine = self.demands.iter().filter(|d| d.is_for(&self.suites[suite].name, self.jobs[job]));
        // A track of which nothing could be read is not missed.
        let mut reads = mine.map(|d| self.unmet(planned, job, d.signal));
        match error {
            Some(e) => {
                let is_read = reads.any(|unmet| unmet.is_none_or(|unmet| unmet.is_failure()));
                Some(e.clone()).filter(|e| is_read && e.is_failure())
            }
            None => reads.flatten().find(CellError::is_failure),
        }
    }

    /// The first [unmet](Self::unmet) need of a tracker, or of a signal on its tracks, on a suite.
    pub fn unmet_on(&self, suite: usize, tracker: usize, signal: Option<usize>) -> Option<CellError> {
        let of = |planned: &PlannedSequence| {
            let mut mine = (0..self.jobs.len()).filter(|j| self.jobs[*j].tracker == tracker);
            mine.find_map(|j| self.unmet(planned, j, signal))
        };
        let runs_on =
            |planned: &&PlannedSequence| self.experiment.trackers[tracker].runs_on(&planned.origin.source);
        self.suites[suite].sequences.iter().filter(runs_on).find_map(of)
    }

    /// Whether any signal reads the regions of other trackers.
    pub fn reads_companions(&self) -> bool {
        self.signals.iter().any(|choice| choice.signal.reads() == Reads::Companions)
    }

    /// Jobs of the companions of a job: the first run of each other tracker whose track can be made.
    pub fn companions<'p>(
        &'p self,
        planned: &'p PlannedSequence,
        job: usize,
    ) -> impl Iterator<Item = usize> + 'p {
        let own = self.jobs[job].tracker;
        let others = self.jobs.iter().enumerate().filter(move |(_, j)| j.tracker != own && j.run == 0);
        others.map(|(j, _)| j).filter(|j| planned.tracks[*j].is_ok())
    }

    /// Recipe of a signal on a job's track.
    ///
    /// # Errors
    /// When the track cannot be made, or the signal cannot be computed on it.
    pub fn signal_recipe(
        &self,
        planned: &PlannedSequence,
        job: usize,
        signal: usize,
    ) -> Result<Recipe, CellError> {
        let track = planned.addresses[job].clone()?;
        let files = planned.signal_files[signal].as_ref().map_err(Clone::clone)?;
        let choice = &self.signals[signal];
        let reads_companions = choice.signal.reads() == Reads::Companions;
        let companions = self.companions(planned, job).filter(|_| reads_companions);
        let companions = companions.filter_map(|j| planned.addresses[j].as_ref().ok().copied());
        let companions: Vec<Address> = companions.collect();
        Ok(recipes::signal(track, choice, &companions, files))
    }

    /// Input of a method with this signal: the signal on a job's track, or the track itself.
    ///
    /// # Errors
    /// When a need is [not met](Self::unmet), or the track cannot be made.
    pub fn read(
        &self,
        planned: &PlannedSequence,
        job: usize,
        signal: Option<usize>,
    ) -> Result<Read, CellError> {
        if let Some(need) = self.unmet(planned, job, signal) {
            return Err(need);
        }
        Ok(match signal {
            Some(k) => Read::Signal(self.signal_recipe(planned, job, k)?.address()),
            None => Read::Track(planned.addresses[job].clone()?),
        })
    }

    /// Seed of a cell's detector.
    pub fn seed(&self, method: &str, params: &str, sequence: &str, job: Job) -> u64 {
        let tracker = &self.experiment.trackers[job.tracker].label;
        seed::seed(self.experiment.seed, &[method, params, sequence, tracker, &job.run.to_string()])
    }

    /// Sequences and jobs of a suite whose tracks of a tracker, with a signal, serve as training data.
    pub fn learned_from(&self, suite: usize, tracker: usize, signal: Option<usize>) -> Vec<(usize, usize)> {
        self.of_runs(suite, tracker, self.experiment.trackers[tracker].training_runs, signal)
    }

    /// Sequences and jobs of a suite that are among a tracker's first runs and have a signal.
    pub fn of_runs(
        &self,
        suite: usize,
        tracker: usize,
        runs: u32,
        signal: Option<usize>,
    ) -> Vec<(usize, usize)> {
        let mine = |j: &usize| self.jobs[*j].tracker == tracker && self.jobs[*j].run < runs;
        let jobs: Vec<usize> = (0..self.jobs.len()).filter(mine).collect();
        let sequences = self.suites[suite].sequences.iter().enumerate();
        let of = |(s, planned)| {
            let met = jobs.iter().filter(move |j| self.unmet(planned, **j, signal).is_none());
            met.map(move |j| (s, *j))
        };
        sequences.flat_map(of).collect()
    }

    /// Input of a variant's detector on a job's track.
    ///
    /// # Errors
    /// As [`read`](Self::read).
    pub fn input(&self, planned: &PlannedSequence, job: usize, variant: usize) -> Result<Read, CellError> {
        let SignalSet { first, more } = self.signals_of(variant);
        let read = self.read(planned, job, *first)?;
        if more.is_empty() {
            return Ok(read);
        }
        let mut all = read.add_to(Recipe::new(Stage::Signal));
        for signal in more {
            all = self.read(planned, job, Some(*signal))?.add_to(all);
        }
        Ok(Read::Signal(all.address()))
    }

    /// Number of detectors that a variant has on each tracker: one, or one for each fold if it is trained on others.
    pub fn parts(&self, variant: &Variant) -> usize {
        let folds = || self.folds.iter().max().map_or(1, |last| last + 1);
        if variant.detector.trains_on_others() { folds() } else { 1 }
    }

    /// Index of the detector of a variant for a sequence of the test suite, among its [parts](Self::parts).
    pub fn part(&self, variant: &Variant, sequence: usize) -> usize {
        if variant.detector.trains_on_others() { self.folds[sequence] } else { 0 }
    }

    /// The tracks that the detector of a variant learns from, for a tracker and a part.
    pub fn training_tracks(
        &self,
        (v, method, variant): (usize, &Method, &Variant),
        tracker: usize,
        part: usize,
    ) -> Vec<Place> {
        let Some(suite) = variant.detector.role().and_then(|role| self.suite(role)) else {
            return Vec::new();
        };
        let signal = self.signal(v);
        let of = |tracker: usize| self.learned_from(suite, tracker, signal).into_iter();
        let trackers = self.experiment.trackers.iter().enumerate();
        let trackers = trackers.filter(|(_, other)| method.runs_on(&other.label));
        if !variant.detector.trains_on_others() {
            let mine = trackers.filter(|(t, _)| *t == tracker || variant.detector.pools_trackers());
            return mine.flat_map(|(t, _)| of(t)).map(|(s, j)| (suite, s, j)).collect();
        }
        let others = trackers.filter(|(t, _)| *t != tracker || self.experiment.folds == FoldsBy::Source);
        let pairs = others.flat_map(|(t, _)| of(t)).filter(|(s, _)| self.folds[*s] != part);
        pairs.map(|(s, j)| (suite, s, j)).collect()
    }

    /// Inputs of a variant's detector on every track that it may learn from.
    pub fn training_reads(&self, v: usize, variant: &Variant) -> BTreeMap<Place, Read> {
        let Some(suite) = variant.detector.role().and_then(|role| self.suite(role)) else {
            return BTreeMap::new();
        };
        let sequences = self.suites[suite].sequences.iter().enumerate();
        let of = |(s, planned)| {
            let read = move |j: usize| Some(((suite, s, j), self.input(planned, j, v).ok()?));
            (0..self.jobs.len()).filter_map(read)
        };
        sequences.flat_map(of).collect()
    }

    /// Name of a cell: `sequence/tracker/run/method[params]`.
    pub fn cell_name(&self, sequence: &str, job: Job, method: &str, params: &str) -> String {
        let tracker = &self.experiment.trackers[job.tracker].label;
        let params = if params.is_empty() { String::new() } else { format!("[{params}]") };
        format!("{sequence}/{tracker}/{}/{method}{params}", job.run)
    }

    /// Name of a track: `suite/sequence/tracker/run`.
    pub fn track_name(&self, suite: usize, sequence: &str, job: Job) -> String {
        let tracker = &self.experiment.trackers[job.tracker].label;
        format!("{}/{sequence}/{tracker}/{}", self.suites[suite].name, job.run)
    }

    /// Recipe of the model of each variant, tracker and [part](Self::parts), where the variant is trained and has training
    /// data. A model gets this recipe if every track of its training data can be made.
    pub fn models(&self) -> Vec<Vec<Vec<Option<Recipe>>>> {
        let variants: Vec<_> = variants(self.experiment).collect();
        let of_variant = |v: usize| {
            let (method, variant) = variants[v];
            if variant.detector.role().is_none() {
                return Vec::new();
            }
            let reads = self.training_reads(v, variant);
            let of = |t: usize, part: usize| {
                if !method.runs_on(&self.experiment.trackers[t].label) {
                    return None;
                }
                let tracks = self.training_tracks((v, method, variant), t, part);
                let mine: Vec<Read> = tracks.iter().filter_map(|track| reads.get(track).copied()).collect();
                if mine.is_empty() { None } else { recipes::of_model(method, variant, &mine) }
            };
            let parts = self.parts(variant);
            let of_tracker = |t: usize| (0..parts).map(|part| of(t, part)).collect();
            (0..self.experiment.trackers.len()).map(of_tracker).collect()
        };
        (0..variants.len()).into_par_iter().map(of_variant).collect()
    }

    /// Name of a cell in the store.
    pub fn stored_name(&self, cell: &str) -> String {
        format!("{}/{cell}", self.test().name)
    }
}
