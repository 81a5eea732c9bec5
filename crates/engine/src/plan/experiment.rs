//! Plan of an experiment: sequences with their digests, and the recipes of their tracks.

use super::demand::{Demand, demands, distinct_signals, signal_index, variants};
use super::recipes::{self, Ingredient};
use super::{Job, folds, inputs};
use crate::error::{CellError, RunError};
use crate::limits::Stop;
use crate::spec::method::{Method, SignalChoice, Variant};
use crate::spec::{Experiment, TEST};
use crate::store::Name;
use crate::store::address::{Address, Recipe};
use rayon::prelude::*;
use std::collections::{BTreeMap, BTreeSet};
use std::path::PathBuf;
use std::sync::Arc;
use trackfail_core::num::seed;
use trackfail_dataset::Sequence;
use trackfail_dataset::suite::{Loaded, Missing, Origin};
use trackfail_methods::signal::Reads;
use trackfail_methods::tracker::RunContext;

/// A sequence whose files are present.
pub struct PlannedSequence {
    /// Index of the suite.
    pub suite: usize,
    /// Frames and ground truth of the sequence. The video of its origin is as [`folds::video`] writes it.
    pub sequence: Arc<Sequence>,
    /// Files digest of the sequence; empty if it cannot be read.
    pub digest: String,
    /// Recipe of each job's track; an error if the track is not needed or cannot be computed.
    pub tracks: Vec<Result<Recipe, CellError>>,
    /// Addresses of these recipes, computed once because addresses of all results on the track include them.
    pub(super) addresses: Vec<Result<Address, CellError>>,
    /// Files that each signal of the experiment reads besides those of the track.
    pub(crate) signal_files: Vec<Result<Vec<Ingredient>, CellError>>,
    /// For each job, true if the tracker gives its confidence on the sequence. Empty if no signal reads it.
    pub(super) gives_confidence: Vec<bool>,
}

/// A suite with its present and missing sequences.
pub struct PlannedSuite {
    /// Name of the suite.
    pub name: String,
    /// Present sequences, in suite order.
    pub sequences: Vec<PlannedSequence>,
    /// Missing sequences, with advice.
    pub missing: Vec<Missing>,
    /// Number of all sequences of the suite.
    pub wanted: usize,
}

impl PlannedSuite {
    /// Names and digests of the present sequences.
    pub fn digests(&self) -> Vec<(String, String)> {
        let digest = |s: &PlannedSequence| (s.sequence.name.clone(), s.digest.clone());
        self.sequences.iter().map(digest).collect()
    }
}

/// Plan of an experiment: suites, jobs and signals, and the recipes of its results.
pub struct ExperimentPlan<'a> {
    /// Experiment that is planned.
    pub experiment: &'a Experiment,
    /// Distinct signals of all methods and analyses.
    pub signals: Vec<SignalChoice>,
    /// Trackers with their repetitions. Some are needed on some suites only.
    pub jobs: Vec<Job>,
    /// Distinct suites; the test suite is the first.
    pub suites: Vec<PlannedSuite>,
    /// Fold of each sequence of the test suite.
    pub(super) folds: Vec<usize>,
    pub(super) demands: Vec<Demand<'a>>,
    /// Indices of the signals of each variant.
    variant_signals: Vec<Vec<usize>>,
    /// Indices of the trackers that give no confidence on any track.
    pub(super) without_confidence: BTreeSet<usize>,
}

impl<'a> ExperimentPlan<'a> {
    /// Plans an experiment on loaded suites, given by role. All their files are read once for the digests, on
    /// the threads of the current pool.
    ///
    /// # Errors
    /// [`RunError::Interrupted`]. An unreadable sequence is no error here; its tracks are.
    pub fn new(
        experiment: &'a Experiment,
        loaded: BTreeMap<String, Loaded>,
        data_roots: &[PathBuf],
        stop: &Stop,
    ) -> Result<Self, RunError> {
        let signals = distinct_signals(experiment);
        let set = |(_, v): (&Method, &Variant)| -> Vec<usize> {
            v.signals.iter().filter_map(|choice| signal_index(&signals, choice)).collect()
        };
        let variant_signals: Vec<Vec<usize>> = variants(experiment).map(set).collect();
        let demands = demands(experiment, &signals, &variant_signals);
        let runs = |tracker: usize| {
            let mine = demands.iter().filter(|demand| demand.tracker == tracker);
            0..mine.map(|demand| demand.runs).max().unwrap_or(0)
        };
        let trackers = 0..experiment.trackers.len();
        let jobs: Vec<Job> =
            trackers.flat_map(|tracker| runs(tracker).map(move |run| Job { tracker, run })).collect();
        let mut suites: Vec<PlannedSuite> = Vec::new();
        let mut by_role: Vec<_> = loaded.into_iter().collect();
        by_role.sort_by_key(|(role, _)| role != TEST);
        for (role, suite) in by_role {
            let name = &experiment.suites[&role];
            if suites.iter().any(|known| known.name == *name) {
                continue;
            }
            let is_wanted = |job: &Job| demands.iter().any(|demand| demand.is_for(name, *job));
            let wanted: Vec<(Job, bool)> = jobs.iter().map(|job| (*job, is_wanted(job))).collect();
            let index = suites.len();
            let plan = |sequence| match stop.is_set() {
                true => Err(RunError::Interrupted),
                false => Ok(planned(experiment, index, sequence, &wanted, &signals, data_roots)),
            };
            let sequences = suite.sequences.into_par_iter().map(plan).collect::<Result<_, RunError>>()?;
            let (name, missing, wanted) = (name.clone(), suite.missing, suite.wanted);
            suites.push(PlannedSuite { name, sequences, missing, wanted });
        }
        // A video whose decoding was interrupted is no failure.
        if stop.is_set() {
            return Err(RunError::Interrupted);
        }
        let origins: Vec<&Origin> = suites[0].sequences.iter().map(|s| &s.sequence.origin).collect();
        let folds = folds::folds(experiment.folds, &origins, experiment.seed);
        let without_confidence = inputs::trackers_without_confidence(&suites, &jobs);
        Ok(Self { experiment, jobs, suites, folds, demands, variant_signals, signals, without_confidence })
    }

    /// The test suite.
    pub fn test(&self) -> &PlannedSuite {
        &self.suites[0]
    }

    /// Names and digests of the present sequences, by suite.
    pub fn digests(&self) -> BTreeMap<String, Vec<(String, String)>> {
        self.suites.iter().map(|suite| (suite.name.clone(), suite.digests())).collect()
    }

    /// Index of the suite that has a role.
    pub fn suite(&self, role: &str) -> Option<usize> {
        let name = self.experiment.suite_of(role)?;
        self.suites.iter().position(|s| s.name == *name)
    }

    /// Indices of the distinct signals that a variant reads. Figures and files show the first.
    pub fn signals_of(&self, variant: usize) -> &[usize] {
        &self.variant_signals[variant]
    }

    /// True if a method of the experiment runs trackers backwards.
    pub fn needs_reverse(&self) -> bool {
        variants(self.experiment).any(|(_, v)| v.detector.example.detector.facts().needs_reverse)
    }

    /// True if a signal of the experiment reads the regions of other trackers.
    pub fn reads_companions(&self) -> bool {
        self.signals.iter().any(|choice| choice.signal.reads() == Reads::Companions)
    }

    /// Demands for a job's track on a suite.
    pub(super) fn demands_for(&self, suite: usize, job: usize) -> impl Iterator<Item = &Demand<'a>> {
        let (suite, job) = (&self.suites[suite].name, self.jobs[job]);
        self.demands.iter().filter(move |demand| demand.is_for(suite, job))
    }

    /// True if a job's track is needed on a suite.
    pub fn wants(&self, suite: usize, job: usize) -> bool {
        self.demands_for(suite, job).next().is_some()
    }

    /// Indices of the signals that are read from the tracks of a tracker on a suite.
    pub fn signals_on(&self, suite: usize, tracker: usize) -> BTreeSet<usize> {
        let suite = &self.suites[suite].name;
        let mine = self.demands.iter().filter(|d| d.tracker == tracker && d.suite == suite);
        mine.filter_map(|d| d.signal).collect()
    }

    /// Seed of the detector of a cell.
    pub fn seed(&self, method: &str, params: &str, sequence: &str, job: Job) -> u64 {
        let tracker = &self.experiment.trackers[job.tracker].label;
        seed::seed(self.experiment.seed, &[method, params, sequence, tracker, &job.run.to_string()])
    }

    /// Name of a cell in the store: `suite/sequence/tracker/run/method[params]`.
    pub fn cell_name(&self, sequence: &str, job: Job, method: &str, params: &str) -> String {
        let params = if params.is_empty() { String::new() } else { format!("[{params}]") };
        format!("{}/{method}{params}", self.track_name(0, sequence, job))
    }

    /// Name of a result in the store, with the experiment.
    pub fn name(&self, cell: String) -> Name {
        Name { experiment: self.experiment.name.clone(), cell }
    }

    /// Name of a track: `suite/sequence/tracker/run`.
    pub fn track_name(&self, suite: usize, sequence: &str, job: Job) -> String {
        let tracker = &self.experiment.trackers[job.tracker].label;
        format!("{}/{sequence}/{tracker}/{}", self.suites[suite].name, job.run)
    }
}

/// A sequence of a suite with the recipes of its tracks. `jobs` are all jobs, each with true if it is needed
/// on the suite.
fn planned(
    experiment: &Experiment,
    suite: usize,
    mut sequence: Sequence,
    jobs: &[(Job, bool)],
    signals: &[SignalChoice],
    data_roots: &[PathBuf],
) -> PlannedSequence {
    sequence.origin.video = folds::video(&sequence.origin.video);
    // A sequence that cannot be read fails alone.
    let digest = sequence.digest().map(str::to_string);
    let digest = digest.map_err(|e| CellError::Failed(format!("{}: {e}", sequence.name)));
    let common = digest.clone().and_then(|digest| recipes::sequence(&sequence, &digest));
    let track = |(job, is_wanted): &(Job, bool)| {
        if let Some(need) = inputs::unmet_by(&experiment.trackers[job.tracker], &sequence, None) {
            return Err(need);
        }
        if !is_wanted {
            return Err(CellError::not_asked_for());
        }
        let common = common.as_ref().map_err(Clone::clone)?;
        recipes::track(experiment, &sequence, common, *job, data_roots)
    };
    let tracks: Vec<_> = jobs.iter().map(track).collect();
    let address =
        |track: &Result<Recipe, CellError>| track.as_ref().map(Recipe::address).map_err(Clone::clone);
    let gives_confidence = |(job, _): &(Job, bool)| {
        let context = RunContext { sequence: &sequence, start_frame: 0, run: job.run, seed: 0, data_roots };
        experiment.trackers[job.tracker].setup.gives_confidence(&context)
    };
    let reads_confidence = signals.iter().any(|s| s.signal.reads() == Reads::Confidence);
    PlannedSequence {
        suite,
        digest: digest.unwrap_or_default(),
        addresses: tracks.iter().map(address).collect(),
        signal_files: signals.iter().map(|s| recipes::signal_files(&sequence, s, data_roots)).collect(),
        gives_confidence: jobs.iter().filter(|_| reads_confidence).map(gives_confidence).collect(),
        tracks,
        sequence: Arc::new(sequence),
    }
}
