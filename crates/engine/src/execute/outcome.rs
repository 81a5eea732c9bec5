//! Outcome of a run: its cells, models and analyses.

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
    /// Index in [`Outcome::sequences`].
    pub sequence: usize,
    /// Label of the tracker.
    pub tracker: String,
    /// Repetition of the tracker, from 0.
    pub run: u32,
    /// Name of the method.
    pub method: String,
    /// Grid point of the method; empty without a grid.
    pub params: String,
    /// Index of the track in [`Outcome::tracks`]`[sequence]`.
    pub job: usize,
    /// Index of the track's signal that the method reads; `None` without a signal.
    pub signal: Option<usize>,
    /// Threshold of the detector, drawn in figures; `None` if it has no single one.
    pub threshold: Option<f64>,
    /// Result, or the reason why there is none.
    pub result: Result<Judged, CellError>,
}

impl Cell {
    /// True if the cell was to be run and has no result.
    pub fn has_failed(&self) -> bool {
        self.result.as_ref().is_err_and(CellError::is_failure)
    }
}

/// Name of a cell or of a track: sequence, tracker, run and, for a cell, the method.
#[derive(Debug, Clone, Default, PartialEq, Eq, PartialOrd, Ord)]
pub struct CellName {
    /// Name of the sequence; outside the test suite with the suite's name and `/` before it.
    pub sequence: String,
    /// Label of the tracker.
    pub tracker: String,
    /// Repetition of the tracker, from 0.
    pub run: u32,
    /// Name of the method; empty for the track itself.
    pub method: String,
    /// Grid point of the method; empty without a grid.
    pub params: String,
}

impl CellName {
    /// Name of the track of a job on a sequence of a suite.
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

    /// Name of a cell of a plan.
    pub fn of_cell(plan: &ExperimentPlan<'_>, cell: &Cell) -> Self {
        let (method, params) = (cell.method.clone(), cell.params.clone());
        Self { method, params, ..Self::of_track(plan, (0, cell.sequence, cell.job)) }
    }
}

/// Outcome of a run: its results on the test suite, and what it trained.
pub struct Outcome<'a> {
    /// Plan that was executed.
    pub plan: &'a ExperimentPlan<'a>,
    /// Tracks of the test suite, by sequence and job.
    pub tracks: Vec<Tracks>,
    /// Cells, by sequence, in the experiment's order.
    pub cells: Vec<Cell>,
    /// Tracks that failed or lack a needed signal, with the reason. Tracks whose failure a cell already
    /// reports are left out.
    pub failed_tracks: Vec<(CellName, CellError)>,
    /// Trained parameters and learned models.
    pub models: Vec<Model>,
    /// Results of the analyses that could be computed.
    pub analyses: Vec<Analysed>,
    /// Analyses that failed, with the reason.
    pub not_analysed: Vec<NotAnalysed>,
    /// Names of the rules that filled in missing values, with the number of their uses.
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

    /// Present sequences of the test suite, in the suite's order.
    pub fn sequences(&self) -> impl Iterator<Item = &Sequence> {
        self.test().sequences.iter().map(|planned| &*planned.sequence)
    }

    /// Sequence at an index of [`sequences`](Self::sequences).
    pub fn sequence(&self, place: usize) -> &Sequence {
        &self.test().sequences[place].sequence
    }

    /// Output of the detector of a cell, from memory or the store.
    ///
    /// # Errors
    /// When the output must be read from the store and is no longer there.
    pub fn detector_output(&self, cell: &Cell, judged: &Judged) -> Result<Arc<DetectorOutput>, StoreError> {
        let stored = || {
            let signal = self.tracks[cell.sequence][cell.job].as_ref().ok()?.signal(cell.signal);
            self.store.get::<StoredDetectorOutput>(&judged.address, signal.len())?.on(&signal).map(Arc::new)
        };
        let gone = "a record has gone while it was needed; run again";
        judged.output.clone().or_else(stored).ok_or_else(|| StoreError::new(self.store.folder(), gone))
    }
}
