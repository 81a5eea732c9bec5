//! The cells of a plan: which jobs have which methods, on which sequences.

use super::demand::variants;
use super::experiment::ExperimentPlan;
use super::job::Job;
use crate::spec::method::Method;

/// A cell of the test suite.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct PlannedCell {
    /// Index of the sequence in the test suite.
    pub sequence: usize,
    /// Index into [`ExperimentPlan::jobs`].
    pub job: usize,
    /// Index into [`variants`].
    pub variant: usize,
}

impl ExperimentPlan<'_> {
    /// Whether a job has cells of a method on the videos of a source.
    pub fn has_cells(&self, job: Job, method: &Method, source: &str) -> bool {
        let tracker = &self.experiment.trackers[job.tracker];
        job.run < tracker.runs && method.runs_on(&tracker.label) && tracker.runs_on(source)
    }

    /// Jobs and variants of the cells of a sequence from a source of videos, in the experiment's order.
    pub fn cells_on(&self, source: &str) -> Vec<(usize, usize)> {
        let of_job = |(j, job): (usize, &Job)| {
            let has_cells = |(_, (method, _)): &(usize, (&Method, _))| self.has_cells(*job, method, source);
            let mine = variants(self.experiment).enumerate().filter(has_cells);
            mine.map(|(v, _)| (j, v)).collect::<Vec<_>>()
        };
        self.jobs.iter().enumerate().flat_map(of_job).collect()
    }

    /// Every cell of the test suite, sequence by sequence, in the experiment's order.
    pub fn cells(&self) -> impl Iterator<Item = PlannedCell> + Clone {
        self.test().sequences.iter().enumerate().flat_map(|(sequence, planned)| {
            let cells = self.cells_on(&planned.origin.source).into_iter();
            cells.map(move |(job, variant)| PlannedCell { sequence, job, variant })
        })
    }
}
