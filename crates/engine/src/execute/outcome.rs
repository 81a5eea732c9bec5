//! Outcome of a run.

use super::analyse::{Analysed, NotAnalysed};
use super::detector_outputs::StoredDetectorOutput;
use super::judge::Judged;
use super::track::Tracks;
use super::train::Model;
use crate::error::CellError;
use crate::observe::tally::Tally;
use crate::plan::{ExperimentPlan, Job, Place, PlannedSuite};
use crate::store::{Store, StoreError};
use std::collections::BTreeMap;
use std::sync::Arc;
use trackfail_dataset::Sequence;
use trackfail_methods::detector::DetectorOutput;

/// One cell: a method's variant on a tracker's run over a sequence.
pub struct Cell {
    /// Place among [`Outcome::sequences`].
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
    /// Index of the track's signal that the method reads, if it reads one.
    pub signal: Option<usize>,
    /// Threshold of the detector, for figures.
    pub threshold: Option<f64>,
    /// The result.
    pub result: Result<Judged, CellError>,
}

impl Cell {
    /// Whether it has no result though it was to be run.
    pub fn has_failed(&self) -> bool {
        self.result.as_ref().is_err_and(CellError::is_failure)
    }
}

/// Names a cell, or a track: sequence, tracker and run, and of a cell the method.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub struct CellName {
    /// Sequence; one of another suite than the test suite has that suite's name and `/` before it.
    pub sequence: String,
    /// Label of the tracker.
    pub tracker: String,
    /// Repetition, from 0.
    pub run: u32,
    /// Method; empty for the track itself.
    pub method: String,
    /// Grid point, empty without a grid.
    pub params: String,
}

impl CellName {
    /// Names the track of a job on a sequence of a suite.
    pub(super) fn of_track(plan: &ExperimentPlan<'_>, (suite, sequence, job): Place) -> Self {
        let Job { tracker, run } = plan.jobs[job];
        let PlannedSuite { name, sequences, .. } = &plan.suites[suite];
        let elsewhere = if suite == 0 { String::new() } else { format!("{name}/") };
        Self {
            sequence: elsewhere + &sequences[sequence].sequence.name,
            tracker: plan.experiment.trackers[tracker].label.clone(),
            run,
            method: String::new(),
            params: String::new(),
        }
    }

    pub(super) fn of_cell(plan: &ExperimentPlan<'_>, cell: &Cell) -> Self {
        let (method, params) = (cell.method.clone(), cell.params.clone());
        Self { method, params, ..Self::of_track(plan, (0, cell.sequence, cell.job)) }
    }
}

/// Outcome of a run: what it found on the test suite, and what it trained.
pub struct Outcome<'a> {
    /// The plan.
    pub plan: &'a ExperimentPlan<'a>,
    /// Tracks of the test suite, sequences x jobs.
    pub tracks: Vec<Tracks>,
    /// Cells, sequence by sequence, in the experiment's order.
    pub cells: Vec<Cell>,
    /// Tracks that could not be made, or lack a signal that is read from them, with the reason, where no cell says so.
    pub failed_tracks: Vec<(CellName, CellError)>,
    /// Trained parameters and learned models.
    pub models: Vec<Model>,
    /// Analyses.
    pub analyses: Vec<Analysed>,
    /// Analyses that could not be made, by name, with the reason.
    pub not_analysed: Vec<NotAnalysed>,
    /// Rules that filled in missing values, with the number of their uses.
    pub rules: BTreeMap<String, u64>,
    /// Sequences whose digest differs from the pinned one, as `suite/name`.
    pub differing: Vec<String>,
    /// Numbers of computed and cached results.
    pub tally: Tally,
    pub(super) store: &'a Store,
}

impl Outcome<'_> {
    /// The test suite.
    pub fn test(&self) -> &PlannedSuite {
        self.plan.test()
    }

    /// Name of the test suite.
    pub fn suite(&self) -> &str {
        &self.test().name
    }

    /// Present sequences of the test suite, in its order.
    pub fn sequences(&self) -> impl Iterator<Item = &Sequence> {
        self.test().sequences.iter().map(|planned| &*planned.sequence)
    }

    /// The sequence in a place of [`sequences`](Self::sequences).
    pub fn sequence(&self, place: usize) -> &Sequence {
        &self.test().sequences[place].sequence
    }

    /// Output of a cell's detector.
    ///
    /// # Errors
    /// When it must be read from the store and is no longer there.
    pub fn detector_output(&self, cell: &Cell, judged: &Judged) -> Result<Arc<DetectorOutput>, StoreError> {
        let stored = || {
            let signal = self.tracks[cell.sequence][cell.job].as_ref().ok()?.signal(cell.signal);
            self.store.get::<StoredDetectorOutput>(&judged.address, signal.len())?.on(&signal).map(Arc::new)
        };
        let gone = "a record has gone while it was needed; run again";
        judged.output.clone().or_else(stored).ok_or_else(|| StoreError::new(self.store.folder(), gone))
    }
}
