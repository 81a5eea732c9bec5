//! The labels of a plan's cells: name, recipe and address, each made when it is asked for. The recipes of a million cells
//! would need more than a gigabyte at once, and most cells are asked for their address alone.

use super::cells::PlannedCell;
use super::demand::variants;
use super::experiment::{ExperimentPlan, PlannedSequence};
use super::job::Job;
use super::recipes::{self, DetectorKey, LabelsOn};
use crate::error::CellError;
use crate::spec::method::{DetectorChoice, Method, Variant};
use crate::store::address::{Address, Recipe};
use rayon::prelude::*;

/// The labels of a cell, before they are made.
pub struct PlannedLabels<'p> {
    /// The cell.
    pub cell: PlannedCell,
    plan: &'p ExperimentPlan<'p>,
    job: Job,
    sequence: &'p str,
    method: &'p str,
    params: &'p str,
    /// Input and detector of the labels, or the reason why they have no recipe.
    from: Result<(&'p LabelsOn, &'p DetectorKey), CellError>,
}

impl PlannedLabels<'_> {
    /// Name of the cell, see [`ExperimentPlan::cell_name`].
    pub fn name(&self) -> String {
        self.plan.cell_name(self.sequence, self.job, self.method, self.params)
    }

    /// Recipe of the labels. Trained parameters are those of [`ExperimentPlan::models`].
    ///
    /// # Errors
    /// When there is no track, or nothing to learn from.
    pub fn recipe(&self) -> Result<Recipe, CellError> {
        let (on, key) = self.from.clone()?;
        Ok(recipes::labels(on.read, key, self.seed(key)))
    }

    /// Address of the recipe; `None` without one.
    pub fn address(&self) -> Option<Address> {
        let (on, key) = self.from.as_ref().ok()?;
        Some(on.address(key, self.seed(key)))
    }

    fn seed(&self, key: &DetectorKey) -> u64 {
        if !key.uses_seed() {
            return 0;
        }
        self.plan.seed(self.method, self.params, self.sequence, self.job)
    }
}

impl ExperimentPlan<'_> {
    /// Maps the labels of every cell, in the order of [`ExperimentPlan::cells`].
    pub fn map_labels<T: Send>(&self, of: impl Fn(PlannedLabels<'_>) -> T + Sync) -> Vec<T> {
        let variants: Vec<_> = variants(self.experiment).collect();
        let params: Vec<String> = variants.iter().map(|(_, v)| v.params()).collect();
        let keys = self.detector_keys(&variants);
        let of_job = |s: usize, cells: &[(usize, usize)], all: &mut Vec<T>| {
            let Some((j, _)) = cells.first() else { return };
            let (planned, job) = (&self.test().sequences[s], self.jobs[*j]);
            let read = |signal: Option<usize>| self.read(planned, *j, signal).map(LabelsOn::new);
            let track = read(None);
            let signals: Vec<_> = (0..self.signals.len()).map(|k| read(Some(k))).collect();
            let cell = |&(_, v): &(usize, usize)| {
                let one = self.signal(v).and_then(|k| signals.get(k)).unwrap_or(&track);
                let several = || self.input(planned, *j, v).map(LabelsOn::new);
                let several = (!self.signals_of(v).more.is_empty()).then(several);
                let read = several.as_ref().unwrap_or(one);
                let part = self.part(variants[v].1, s);
                let from = match (read, &keys[v][job.tracker][part]) {
                    (Err(e), _) | (Ok(_), Err(e)) => Err(e.clone()),
                    (Ok(read), Ok(key)) => Ok((read, key)),
                };
                of(PlannedLabels {
                    cell: PlannedCell { sequence: s, job: *j, variant: v },
                    plan: self,
                    job,
                    sequence: &planned.sequence.name,
                    method: &variants[v].0.name,
                    params: &params[v],
                    from,
                })
            };
            all.extend(cells.iter().map(cell));
        };
        let of_sequence = |(s, planned): (usize, &PlannedSequence)| {
            let cells = self.cells_on(&planned.origin.source);
            let mut all = Vec::with_capacity(cells.len());
            cells.chunk_by(|a, b| a.0 == b.0).for_each(|cells| of_job(s, cells, &mut all));
            all
        };
        let sequences = self.test().sequences.par_iter().enumerate();
        let parts: Vec<Vec<T>> = sequences.map(of_sequence).collect();
        let mut all = Vec::with_capacity(parts.iter().map(Vec::len).sum());
        parts.into_iter().for_each(|part| all.extend(part));
        all
    }

    /// The detector ingredients of every variant's recipes, by variant, tracker and part.
    fn detector_keys(
        &self,
        variants: &[(&Method, &Variant)],
    ) -> Vec<Vec<Vec<Result<DetectorKey, CellError>>>> {
        let models = self.models();
        let key = |v: usize, tracker: usize, part: usize| {
            let model = || {
                let model =
                    models[v].get(tracker).and_then(|parts| parts.get(part)?.as_ref()).map(Recipe::address);
                let role = variants[v].1.detector.role().unwrap_or_default();
                model.ok_or_else(|| CellError::Missing(format!("no track in role `{role}` to learn from")))
            };
            Ok(match &variants[v].1.detector {
                DetectorChoice::Given(fixed) => DetectorKey::given(fixed),
                DetectorChoice::Trained(training) => DetectorKey::model(model()?, &training.example),
                DetectorChoice::Learned(fixed) => DetectorKey::learned(model()?, fixed),
            })
        };
        let of_tracker = |v: usize, tracker: usize| {
            (0..self.parts(variants[v].1)).map(|part| key(v, tracker, part)).collect()
        };
        let of_variant =
            |v: usize| (0..self.experiment.trackers.len()).map(|tracker| of_tracker(v, tracker)).collect();
        (0..variants.len()).map(of_variant).collect()
    }
}
