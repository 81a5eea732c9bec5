//! Inputs of signals and detectors: what can be computed from which track, and the reason if something
//! cannot.

use super::Job;
use super::experiment::{ExperimentPlan, PlannedSequence, PlannedSuite};
use super::recipes::{self, Read};
use crate::error::CellError;
use crate::spec::Tracker;
use crate::store::address::{Address, Recipe, Stage};
use std::collections::BTreeSet;
use trackfail_dataset::Sequence;
use trackfail_methods::signal::Reads;

/// First need of a tracker, or of a reader of its track, that the sequence itself does not meet.
pub(super) fn unmet_by(tracker: &Tracker, sequence: &Sequence, reads: Option<Reads>) -> Option<CellError> {
    let reads_pixels = tracker.setup.facts().reads_pixels || reads == Some(Reads::Pixels);
    if !tracker.runs_on(&sequence.origin.source) {
        Some(CellError::Unmet("runs on videos of other sources"))
    } else if reads_pixels && !sequence.has_frames() {
        Some(CellError::Unmet("needs frames, and the suite has boxes only"))
    } else {
        None
    }
}

/// Indices of the trackers that have tracks, all of them without confidence.
pub(super) fn trackers_without_confidence(suites: &[PlannedSuite], jobs: &[Job]) -> BTreeSet<usize> {
    let (mut with_track, mut with_confidence) = (BTreeSet::new(), BTreeSet::new());
    for planned in suites.iter().flat_map(|suite| &suite.sequences) {
        for (j, job) in jobs.iter().enumerate().filter(|(j, _)| planned.tracks[*j].is_ok()) {
            with_track.insert(job.tracker);
            if planned.gives_confidence.get(j) == Some(&true) {
                with_confidence.insert(job.tracker);
            }
        }
    }
    &with_track - &with_confidence
}

impl ExperimentPlan<'_> {
    /// True if a signal is needed, and can be computed, on a job's track.
    pub fn wants_signal(&self, planned: &PlannedSequence, job: usize, signal: usize) -> bool {
        self.demands_for(planned.suite, job).any(|demand| demand.signal == Some(signal))
            && self.unmet(planned, job, Some(signal)).is_none()
    }

    /// First need of a job's tracker, or of a signal on its track, that the sequence or the tracker does not
    /// meet. Results with an unmet need are not computed. Also the error of a file that the signal cannot
    /// read.
    pub fn unmet(&self, planned: &PlannedSequence, job: usize, signal: Option<usize>) -> Option<CellError> {
        let place = self.jobs[job].tracker;
        let tracker = &self.experiment.trackers[place];
        let reads = signal.and_then(|k| self.signals.get(k)).map(|choice| choice.signal.reads());
        if let Some(need) = unmet_by(tracker, &planned.sequence, reads) {
            return Some(need);
        }
        let given = match reads {
            None | Some(Reads::Pixels | Reads::Boxes) => true,
            Some(Reads::Posterior) => tracker.setup.facts().gives_posterior,
            Some(Reads::Response) => tracker.setup.facts().gives_response,
            Some(Reads::Companions) => self.companions(planned, job).next().is_some(),
            Some(Reads::Confidence) if self.without_confidence.contains(&place) => false,
            Some(Reads::Confidence) => match &planned.tracks[job] {
                Ok(track) if planned.gives_confidence.get(job) != Some(&true) => {
                    let mut files =
                        track.ingredients.iter().filter_map(|(name, _)| name.strip_prefix("file "));
                    let (file, tracker) = (files.next().unwrap_or(&planned.sequence.name), &tracker.label);
                    return Some(CellError::Missing(format!(
                        "there is no confidence in or beside {file}, and other tracks of {tracker} have one"
                    )));
                }
                // A track that cannot be read has a reason of its own.
                _ => true,
            },
        };
        let unmet = reads.filter(|_| !given).and_then(Reads::need_of_tracker).map(CellError::Unmet);
        unmet.or_else(|| planned.signal_files.get(signal?)?.as_ref().err().cloned())
    }

    /// Reason why a job's track, or a needed signal on it, is lacking although it was to be computed. `error`
    /// is that of the track; `None` if the track was computed.
    pub fn failure(
        &self,
        planned: &PlannedSequence,
        job: usize,
        error: Option<&CellError>,
    ) -> Option<CellError> {
        let demands = self.demands_for(planned.suite, job);
        let mut unmet = demands.map(|demand| self.unmet(planned, job, demand.signal));
        match error {
            // A track of which nothing could be read is not missed.
            Some(e) => {
                let is_missed = e.is_failure() && unmet.any(|need| need.is_none_or(|need| need.is_failure()));
                is_missed.then(|| e.clone())
            }
            None => unmet.flatten().find(CellError::is_failure),
        }
    }

    /// First [unmet](Self::unmet) need of a tracker, or of a signal on its tracks, on a suite.
    pub fn unmet_on(&self, suite: usize, tracker: usize, signal: Option<usize>) -> Option<CellError> {
        let runs_on = |planned: &PlannedSequence| {
            self.experiment.trackers[tracker].runs_on(&planned.sequence.origin.source)
        };
        let mut there = self.suites[suite].sequences.iter().filter(|planned| runs_on(planned));
        there.find_map(|planned| self.jobs_of(tracker, u32::MAX).find_map(|j| self.unmet(planned, j, signal)))
    }

    /// Companion jobs of a job: the first run of each other tracker whose track can be computed.
    pub fn companions(&self, planned: &PlannedSequence, job: usize) -> impl Iterator<Item = usize> {
        let own = self.jobs[job].tracker;
        let others = self.jobs.iter().enumerate().filter(move |(_, j)| j.tracker != own && j.run == 0);
        others.map(|(j, _)| j).filter(|j| planned.tracks[*j].is_ok())
    }

    /// Recipe of a signal on a job's track.
    ///
    /// # Errors
    /// When the track, or the signal on it, cannot be computed.
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
        let companions = companions.map(|j| planned.addresses[j].clone());
        Ok(recipes::signal(track, choice, &companions.collect::<Result<Vec<Address>, _>>()?, files))
    }

    /// Input of a method: the signal on a job's track, or the track itself if the method has no signal.
    ///
    /// # Errors
    /// When a need is [not met](Self::unmet), or the track cannot be computed.
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
            Some(k) => ("signal", self.signal_recipe(planned, job, k)?.address()),
            None => ("track", planned.addresses[job].clone()?),
        })
    }

    /// Input of a variant's detector on a job's track.
    ///
    /// # Errors
    /// The errors of [`read`](Self::read).
    pub fn input(&self, planned: &PlannedSequence, job: usize, variant: usize) -> Result<Read, CellError> {
        let signals = self.signals_of(variant);
        let first = self.read(planned, job, signals.first().copied())?;
        if signals.len() < 2 {
            return Ok(first);
        }
        let mut all = Recipe::new(Stage::Signal).with(first.0, first.1);
        for signal in &signals[1..] {
            let (name, address) = self.read(planned, job, Some(*signal))?;
            all = all.with(name, address);
        }
        Ok(("signal", all.address()))
    }
}
