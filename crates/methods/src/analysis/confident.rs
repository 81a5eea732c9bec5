//! Helpers of the analyses that read a tracker's confidence and its regions.

use super::{AnalysisError, Population};
use crate::score::trajectory::{Missing, Trajectory};
use crate::tracker::Status;
use trackfail_core::region::Areas;

/// A frame of a track with the overlap and the confidence.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ConfidentFrame {
    /// Status of the tracker in the frame.
    pub status: Status,
    /// Overlap with the target: 0 where the tracker has no box, `None` where the target is not annotated.
    pub overlap: Option<f64>,
    /// Value of the signal; `None` if the signal is the tracker's own confidence and the tracker gives none.
    pub confidence: Option<f64>,
}

/// The frames of a run, from the frame in which the tracker was started.
fn frames(trajectory: &Trajectory<'_>, signal: &[f64], areas: Areas, bounded: bool) -> Vec<ConfidentFrame> {
    let frame = trajectory.frame.filter(|_| bounded);
    let regions = trajectory.counted(Missing::Miss);
    let of_frame = |t: usize| {
        let overlap = |truth| regions[t].map_or(0.0, |region| areas.overlap(region, truth, frame));
        // The signal repeats its last value where none is given.
        let is_given = trajectory.confidence.get(t).is_none_or(|c| c.is_some_and(f64::is_finite));
        ConfidentFrame {
            status: trajectory.status[t],
            overlap: trajectory.truth[t].as_ref().map(overlap),
            confidence: is_given.then_some(signal[t]),
        }
    };
    (0..signal.len()).filter(|t| trajectory.status[*t] != Status::Waiting).map(of_frame).collect()
}

/// A sequence with the frames of its runs.
pub type Sequence<'a> = (&'a str, Vec<Vec<ConfidentFrame>>);

/// The sequences of a suite.
///
/// # Errors
/// When there is no track.
pub fn sequences<'a>(
    population: &Population<'a>,
    areas: Areas,
    bounded: bool,
) -> Result<Vec<Sequence<'a>>, AnalysisError> {
    let mut sequences: Vec<Sequence<'a>> = Vec::new();
    for (trajectory, track) in population.trajectories.iter().zip(&population.tracks) {
        let run = frames(trajectory, track.signal, areas, bounded);
        match sequences.last_mut().filter(|(name, _)| *name == trajectory.sequence) {
            Some((_, runs)) => runs.push(run),
            None => sequences.push((trajectory.sequence, vec![run])),
        }
    }
    if sequences.is_empty() { Err(AnalysisError::NoTrack) } else { Ok(sequences) }
}
