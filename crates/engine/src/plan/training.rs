//! Training data of detectors: tracks of the training suite, or of the other folds and trackers.

use super::demand::variants;
use super::experiment::ExperimentPlan;
use super::recipes::{self, Read};
use crate::error::CellError;
use crate::spec::FoldsBy;
use crate::spec::method::{DetectorChoice, Method, Variant};
use crate::store::address::{Address, Recipe, Stage};
use rayon::prelude::*;
use std::collections::BTreeMap;

/// Place of a track: indices of its suite, sequence and job.
pub type Place = (usize, usize, usize);

/// Indices of a variant, of a tracker, and of a [part](ExperimentPlan::parts) of the test suite.
pub type Key = (usize, usize, usize);

/// A parameter or model that a variant needs on a tracker, for one part of the test suite.
pub struct TrainingNeed<'a> {
    /// Indices of the variant, the tracker and the part.
    pub key: Key,
    /// Method that needs training.
    pub method: &'a Method,
    /// Variant of the method that needs training.
    pub variant: &'a Variant,
    /// Tracks of the training data.
    pub tracks: Vec<Place>,
    /// Recipe of the parameter or model.
    pub recipe: Recipe,
    /// Address of the recipe.
    pub address: Address,
}

impl<'a> ExperimentPlan<'a> {
    /// Jobs of the first `runs` runs of a tracker.
    pub fn jobs_of(&self, tracker: usize, runs: u32) -> impl Iterator<Item = usize> {
        let jobs = self.jobs.iter().enumerate();
        jobs.filter(move |(_, job)| job.tracker == tracker && job.run < runs).map(|(j, _)| j)
    }

    /// Sequences and jobs of a suite that belong to a tracker's first `runs` runs and have the signal.
    pub fn of_runs(
        &self,
        suite: usize,
        tracker: usize,
        runs: u32,
        signal: Option<usize>,
    ) -> Vec<(usize, usize)> {
        let sequences = self.suites[suite].sequences.iter().enumerate();
        let of = |(s, planned)| {
            let met = self.jobs_of(tracker, runs).filter(move |j| self.unmet(planned, *j, signal).is_none());
            met.map(move |j| (s, j))
        };
        sequences.flat_map(of).collect()
    }

    /// Number of detectors that a variant has on each tracker: one, or one per fold if it is trained on
    /// others.
    pub fn parts(&self, variant: &Variant) -> usize {
        let folds = || self.folds.iter().max().map_or(1, |last| last + 1);
        if variant.detector.trains_on_others() { folds() } else { 1 }
    }

    /// Index of a variant's detector for a sequence of the test suite, among its [parts](Self::parts).
    pub fn part(&self, variant: &Variant, sequence: usize) -> usize {
        if variant.detector.trains_on_others() { self.folds[sequence] } else { 0 }
    }

    /// Tracks from which the detector of a variant learns, for a tracker and a part.
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
        let signal = self.signals_of(v).first().copied();
        let trackers = self.experiment.trackers.iter().enumerate();
        let trackers = trackers.filter(|(t, of)| method.runs_on(&of.label) && is_used(*t));
        let tracks = trackers.flat_map(|(t, of)| self.of_runs(suite, t, of.training_runs, signal));
        let tracks = tracks.filter(|(s, _)| !on_others || self.folds[*s] != part);
        tracks.map(|(s, j)| (suite, s, j)).collect()
    }

    /// Inputs of a variant's detector on all tracks of a suite.
    fn reads(&self, v: usize, suite: usize) -> BTreeMap<Place, Read> {
        let sequences = self.suites[suite].sequences.iter().enumerate();
        let of = |(s, planned)| {
            let read = move |j: usize| Some(((suite, s, j), self.input(planned, j, v).ok()?));
            (0..self.jobs.len()).filter_map(read)
        };
        sequences.flat_map(of).collect()
    }

    /// Digest of the videos and sources of tracks.
    fn origins(&self, tracks: &[Place]) -> Address {
        let origin = |(suite, s, _): &Place| &self.suites[*suite].sequences[*s].sequence.origin;
        let all = tracks.iter().map(origin);
        all.fold(Recipe::new(Stage::Model), |all, origin| all.with(&origin.video, &origin.source)).address()
    }

    /// Parameters and models to train, by variant, tracker and part, from the tracks that `is_there` accepts
    /// with the signals of the variant. An error if there is no such track.
    pub fn needs(
        &self,
        is_there: impl Fn(&Place, &[usize]) -> bool + Sync,
    ) -> Vec<(Key, Result<TrainingNeed<'a>, CellError>)> {
        let of_variant = |(v, (method, variant)): (usize, (&'a Method, &'a Variant))| {
            let mut needs = Vec::new();
            let Some(role) = variant.detector.role() else { return needs };
            let reads = self.suite(role).map(|suite| self.reads(v, suite)).unwrap_or_default();
            let signals = self.signals_of(v);
            let trackers = self.experiment.trackers.iter().enumerate();
            let trackers = trackers.filter(|(_, tracker)| method.runs_on(&tracker.label));
            for (t, part) in trackers.flat_map(|(t, _)| (0..self.parts(variant)).map(move |part| (t, part))) {
                let mut tracks = self.training_tracks((v, method, variant), t, part);
                tracks.retain(|place| is_there(place, signals) && reads.contains_key(place));
                let mine: Vec<Read> = tracks.iter().map(|place| reads[place]).collect();
                let recipe = recipes::of_model(method, variant, &mine).filter(|_| !mine.is_empty());
                let recipe = recipe.map(|recipe| match &variant.detector.training {
                    // Who learns may weigh examples by their video and source.
                    None => recipe.with("videos and sources", self.origins(&tracks)),
                    Some(_) => recipe,
                });
                let missing = || CellError::Missing(format!("no track in role `{role}` to learn from"));
                let key = (v, t, part);
                let need = recipe.ok_or_else(missing).map(|recipe| {
                    let address = recipe.address();
                    TrainingNeed { key, method, variant, tracks, recipe, address }
                });
                needs.push((key, need));
            }
            needs
        };
        let variants: Vec<_> = variants(self.experiment).collect();
        variants.into_par_iter().enumerate().flat_map_iter(of_variant).collect()
    }

    /// Detectors that need no training.
    pub fn given(&self) -> impl Iterator<Item = (Key, &'a DetectorChoice)> {
        let all = variants(self.experiment).map(|(_, variant)| &variant.detector).enumerate();
        let given = all.filter(|(_, detector)| detector.role().is_none());
        let trackers = 0..self.experiment.trackers.len();
        given.flat_map(move |(v, detector)| trackers.clone().map(move |t| ((v, t, 0), detector)))
    }
}
