//! What detectors are trained on: tracks of the suite of their role, or of the other folds and trackers.

use super::demand::variants;
use super::experiment::ExperimentPlan;
use super::recipes::{self, Read};
use crate::spec::FoldsBy;
use crate::spec::method::{Method, Variant};
use crate::store::address::Recipe;
use rayon::prelude::*;
use std::collections::BTreeMap;

/// Place of a track: indices of its suite, sequence and job.
pub type Place = (usize, usize, usize);

impl ExperimentPlan<'_> {
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
        let on_others = variant.detector.trains_on_others();
        let is_used = |t: usize| match on_others {
            true => t != tracker || self.experiment.folds == FoldsBy::Source,
            false => t == tracker || variant.detector.pools_trackers(),
        };
        let trackers = self.experiment.trackers.iter().enumerate();
        let trackers = trackers.filter(|(t, of)| method.runs_on(&of.label) && is_used(*t));
        let tracks = trackers.flat_map(|(t, of)| self.of_runs(suite, t, of.training_runs, self.signal(v)));
        let tracks = tracks.filter(|(s, _)| !on_others || self.folds[*s] != part);
        tracks.map(|(s, j)| (suite, s, j)).collect()
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

    /// Recipe of the model of each variant, tracker and [part](Self::parts), where the variant is trained and has training
    /// data. A model gets this recipe if every track of its training data can be made.
    pub fn models(&self) -> Vec<Vec<Vec<Option<Recipe>>>> {
        let of_variant = |(v, (method, variant)): (usize, (&Method, &Variant))| -> Vec<Vec<Option<Recipe>>> {
            let reads = self.training_reads(v, variant);
            let of = |t: usize, part: usize| {
                let tracks = self.training_tracks((v, method, variant), t, part);
                let mine: Vec<Read> = tracks.iter().filter_map(|track| reads.get(track).copied()).collect();
                let is_trained = !mine.is_empty() && method.runs_on(&self.experiment.trackers[t].label);
                is_trained.then(|| recipes::of_model(method, variant, &mine)).flatten()
            };
            let of_tracker = |t: usize| (0..self.parts(variant)).map(|part| of(t, part)).collect();
            (0..self.experiment.trackers.len()).map(of_tracker).collect()
        };
        let variants: Vec<_> = variants(self.experiment).collect();
        variants.into_par_iter().enumerate().map(of_variant).collect()
    }
}
