//! Trackers that give a confidence: all their tracks have one, or it is missing.

use super::experiment::{PlannedSequence, PlannedSuite};
use super::job::Job;
use crate::error::CellError;
use std::collections::BTreeSet;

/// Trackers that have tracks, none of them with a confidence.
pub(super) fn trackers_without(suites: &[PlannedSuite], jobs: &[Job]) -> BTreeSet<usize> {
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

/// Why a signal of the confidence has no value on a job's track, which has none though others of its tracker do.
pub(super) fn missing(planned: &PlannedSequence, job: usize, tracker: &str) -> CellError {
    let files = planned.tracks[job].iter().flat_map(|recipe| &recipe.ingredients);
    let file = files.map(|(name, _)| name).find_map(|name| name.strip_prefix("file "));
    let place = file.unwrap_or(&planned.sequence.name);
    CellError::Missing(format!(
        "there is no confidence in or beside {place}, and other tracks of {tracker} have one"
    ))
}
