//! The plan of an experiment: sequences with their digests and the recipes of their tracks.

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
    /// The sequence.
    pub sequence: Arc<Sequence>,
    /// The video that it is of, see [`folds::video`], and the source that it comes from.
    pub origin: Origin,
    /// Its digest; empty if it cannot be read.
    pub digest: String,
    /// Recipe of each job's track; an error for tracks that are not needed or cannot be made.
    pub tracks: Vec<Result<Recipe, CellError>>,
    /// Address of each of these recipes, made once because everything on a track is addressed by it.
    pub(super) addresses: Vec<Result<Address, CellError>>,
    /// The files that each of the experiment's signals reads besides those of the track.
    pub(super) signal_files: Vec<Result<Vec<Ingredient>, CellError>>,
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

impl PlannedSuite {
    /// Names and digests of its present sequences.
    pub fn digests(&self) -> Vec<(String, String)> {
        let digest = |s: &PlannedSequence| (s.sequence.name.clone(), s.digest.clone());
        self.sequences.iter().map(digest).collect()
    }
}

/// Plan of an experiment: its suites, jobs and signals, and the recipes of its results.
pub struct ExperimentPlan<'a> {
    /// The experiment.
    pub experiment: &'a Experiment,
    /// Its distinct signals.
    pub signals: Vec<SignalChoice>,
    /// Its trackers and repetitions; not all of them are needed on every suite.
    pub jobs: Vec<Job>,
    /// Its distinct suites; the test suite is the first.
    pub suites: Vec<PlannedSuite>,
    /// Fold of each sequence of the test suite.
    pub(super) folds: Vec<usize>,
    pub(super) demands: Vec<Demand<'a>>,
    /// The signals of each variant.
    variant_signals: Vec<Vec<usize>>,
    /// Trackers none of whose tracks has a confidence.
    pub(super) without_confidence: BTreeSet<usize>,
}

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
        let set = |(_, v): (&Method, &Variant)| -> Vec<usize> {
            v.signals().filter_map(|choice| signal_index(&signals, choice)).collect()
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
            let wanted: Vec<bool> =
                jobs.iter().map(|job| demands.iter().any(|d| d.is_for(name, *job))).collect();
            let plan = |(sequence, origin)| match stop.is_set() {
                true => Err(RunError::Interrupted),
                false => {
                    Ok(planned(experiment, sequence, origin, (&jobs[..], &wanted[..]), &signals, data_roots))
                }
            };
            let sequences = suite.sequences.into_par_iter().zip(suite.origins);
            let sequences = sequences.map(plan).collect::<Result<_, RunError>>()?;
            let (name, missing, wanted) = (name.clone(), suite.missing, suite.wanted);
            suites.push(PlannedSuite { name, sequences, missing, wanted });
        }
        let origins: Vec<&Origin> = suites[0].sequences.iter().map(|s| &s.origin).collect();
        let folds = folds::folds(experiment.folds, &origins, experiment.seed);
        let without_confidence = inputs::trackers_without_confidence(&suites, &jobs);
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

    /// Indices of the distinct signals that a variant reads; figures and files show the first.
    pub fn signals_of(&self, variant: usize) -> &[usize] {
        &self.variant_signals[variant]
    }

    /// Whether any method runs trackers backwards.
    pub fn needs_reverse(&self) -> bool {
        variants(self.experiment).any(|(_, v)| v.detector.needs_reverse())
    }

    /// Whether any signal reads the regions of other trackers.
    pub fn reads_companions(&self) -> bool {
        self.signals.iter().any(|choice| choice.signal.reads() == Reads::Companions)
    }

    /// Demands for a job's track on a suite.
    pub(super) fn demands_for(&self, suite: usize, job: usize) -> impl Iterator<Item = &Demand<'a>> {
        let (suite, job) = (&self.suites[suite].name, self.jobs[job]);
        self.demands.iter().filter(move |demand| demand.is_for(suite, job))
    }

    /// Whether a job's track is needed on a suite.
    pub fn wants(&self, suite: usize, job: usize) -> bool {
        self.demands_for(suite, job).next().is_some()
    }

    /// Indices of the signals that are read from the tracks of a tracker on a suite.
    pub fn signals_on(&self, suite: usize, tracker: usize) -> BTreeSet<usize> {
        let suite = &self.suites[suite].name;
        let mine = self.demands.iter().filter(|d| d.tracker == tracker && d.suite == suite);
        mine.filter_map(|d| d.signal).collect()
    }

    /// Seed of a cell's detector.
    pub fn seed(&self, method: &str, params: &str, sequence: &str, job: Job) -> u64 {
        let tracker = &self.experiment.trackers[job.tracker].label;
        seed::seed(self.experiment.seed, &[method, params, sequence, tracker, &job.run.to_string()])
    }

    /// Name of a cell in the store: `suite/sequence/tracker/run/method[params]`.
    pub fn cell_name(&self, sequence: &str, job: Job, method: &str, params: &str) -> String {
        let params = if params.is_empty() { String::new() } else { format!("[{params}]") };
        format!("{}/{method}{params}", self.track_name(0, sequence, job))
    }

    /// Name of a result of the experiment in the store.
    pub fn name(&self, cell: String) -> Name {
        Name { experiment: self.experiment.name.clone(), cell }
    }

    /// Name of a track: `suite/sequence/tracker/run`.
    pub fn track_name(&self, suite: usize, sequence: &str, job: Job) -> String {
        let tracker = &self.experiment.trackers[job.tracker].label;
        format!("{}/{sequence}/{tracker}/{}", self.suites[suite].name, job.run)
    }
}

/// A sequence with the recipes of its tracks. `jobs` are all jobs and whether each is wanted on the suite.
fn planned(
    experiment: &Experiment,
    sequence: Sequence,
    origin: Origin,
    (jobs, wanted): (&[Job], &[bool]),
    signals: &[SignalChoice],
    data_roots: &[PathBuf],
) -> PlannedSequence {
    // A sequence that cannot be read fails alone.
    let digest = sequence.digest().map(str::to_string);
    let digest = digest.map_err(|e| CellError::Failed(format!("{}: {e}", sequence.name)));
    let common = digest.clone().and_then(|digest| recipes::sequence(&sequence, &digest));
    let track = |(job, is_wanted): (&Job, &bool)| {
        if let Some(need) = inputs::unmet_by(&experiment.trackers[job.tracker], &origin, &sequence, None) {
            return Err(need);
        }
        if !is_wanted {
            return Err(CellError::not_asked_for());
        }
        let common = common.as_ref().map_err(Clone::clone)?;
        recipes::track(experiment, &sequence, common, *job, data_roots)
    };
    let tracks: Vec<_> = jobs.iter().zip(wanted).map(track).collect();
    let address =
        |track: &Result<Recipe, CellError>| track.as_ref().map(Recipe::address).map_err(Clone::clone);
    let gives_confidence = |job: &Job| {
        let context = RunContext { sequence: &sequence, start_frame: 0, run: job.run, seed: 0, data_roots };
        experiment.trackers[job.tracker].setup.gives_confidence(&context)
    };
    let reads_confidence = signals.iter().any(|s| s.signal.reads() == Reads::Confidence);
    PlannedSequence {
        digest: digest.unwrap_or_default(),
        addresses: tracks.iter().map(address).collect(),
        signal_files: signals.iter().map(|s| recipes::signal_files(&sequence, s, data_roots)).collect(),
        gives_confidence: jobs.iter().filter(|_| reads_confidence).map(gives_confidence).collect(),
        tracks,
        origin: Origin { video: folds::video(&origin.video), ..origin },
        sequence: Arc::new(sequence),
    }
}
