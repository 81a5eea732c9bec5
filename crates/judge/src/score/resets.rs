//! Accuracy, failures and expected average overlap of trackers under the VOT reset protocol.
//!
//! ```text
//! accuracy   mean overlap of the frames that count
//! failures   number of frames in which the overlap was 0
//! EAO        mean over N = low ..= high of  E(N) = mean over runs of (1/N) sum_{i=1..N} overlap_i
//! ```
//!
//! Frames count for the accuracy unless they are a failure, skipped after one, or one of the first `burn_in`
//! (10, the initialization included) of a start. For the EAO a track is cut into runs from a start to the
//! next failure. Index 0 is the start itself, which is not counted. After a failure a run continues with
//! overlap 0; after the end of the sequence it leaves the mean.
//!
//! Accuracy of a suite: the mean over a sequence's repetitions, then over sequences by their numbers of
//! frames (`accuracy`) or with equal weights (`accuracy_of_sequences`). Failures of a suite: the sum over
//! sequences of the mean over repetitions. Overlaps count on the frame where `bounded`. Low numbers of
//! failures and high values of the rest are good.
//!
//! A frame in which the tracker says that an annotated target is absent counts with overlap 0.
//!
//! An attribute is a set of frames: see [`attributes`].
//!
//! Source: Kristan et al., The Visual Object Tracking VOT2014 and VOT2015 challenge results; agrees with
//! vot-toolkit 0.7.4 on the same result files (tests). Deviations: `f64` throughout, where the toolkit sums
//! EAO curves in `f32`. The interval of EAO is that of VOT2014 and VOT2015, 108 to 371 frames.

pub mod attributes;

use super::trajectory::{Missing, Trajectory, mean};
use crate::region::Areas;
use crate::tracker::Status;

/// Rules of the measurement.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Rules {
    /// Rule by which areas are measured.
    pub areas: Areas,
    /// True if only the part of a region on the frame counts.
    pub bounded: bool,
    /// Number of frames from a start on that do not count for the accuracy.
    pub burn_in: usize,
}

/// Measures of one track.
#[derive(Debug, Clone, PartialEq)]
pub struct Measured {
    /// Mean overlap of the frames that count; `None` if none counts.
    pub accuracy: Option<f64>,
    /// Number of failures in the track.
    pub failures: usize,
    /// Overlap of each frame; 0 if the tracker has no region.
    pub overlaps: Vec<f64>,
    /// For each frame, true if it counts for the accuracy.
    pub counts: Vec<bool>,
}

impl Rules {
    /// Measures one track.
    pub fn measure(&self, trajectory: &Trajectory<'_>) -> Measured {
        let frame = trajectory.frame.filter(|_| self.bounded);
        let mut counts = vec![true; trajectory.regions.len()];
        let mut overlaps = Vec::with_capacity(trajectory.regions.len());
        let regions = trajectory.counted(Missing::Miss);
        for (t, status) in trajectory.status.iter().enumerate() {
            overlaps.push(match (regions[t], &trajectory.truth[t]) {
                (Some(region), Some(truth)) if *status != Status::Initialized => {
                    self.areas.overlap(region, truth, frame)
                }
                _ => 0.0,
            });
            match status {
                Status::Initialized => {
                    let end = (t + self.burn_in.max(1)).min(counts.len());
                    counts[t..end].fill(false);
                }
                Status::Tracked | Status::Repeated | Status::Absent => {
                    counts[t] &= trajectory.truth[t].is_some()
                }
                Status::Failed | Status::Skipped | Status::Waiting => counts[t] = false,
            }
        }
        let failures = trajectory.status.iter().filter(|s| **s == Status::Failed).count();
        let counted = overlaps.iter().zip(&counts).filter(|(_, counts)| **counts).map(|(o, _)| *o);
        Measured { accuracy: mean(counted), failures, overlaps, counts }
    }
}

/// Mean accuracy (0 if no frame counts) and mean number of failures over one sequence's repetitions; `None`
/// without repetitions.
pub fn of_sequence(runs: &[&Measured]) -> Option<(f64, f64)> {
    let accuracy = mean(runs.iter().map(|m| m.accuracy.unwrap_or(0.0)))?;
    Some((accuracy, mean(runs.iter().map(|m| m.failures as f64))?))
}

/// Overlaps of the frames from each start to a failure, with true, or to the end of the sequence.
fn runs<'a>(trajectory: &Trajectory<'_>, measured: &'a Measured) -> Vec<(&'a [f64], bool)> {
    let mut all = Vec::new();
    let mut start = None;
    for (t, status) in trajectory.status.iter().enumerate() {
        match (status, start) {
            (Status::Initialized, _) => start = Some(t),
            (Status::Failed, Some(from)) => {
                all.push((&measured.overlaps[from..t], true));
                start = None;
            }
            _ => {}
        }
    }
    all.extend(start.map(|from| (&measured.overlaps[from..], false)));
    all
}

/// E(N) for N = 0, 1 ... up to the longest run; `None` if no run has that length. E(0) is 0.
pub fn expected_overlap(tracks: &[(Trajectory<'_>, Measured)]) -> Vec<Option<f64>> {
    let all: Vec<(&[f64], bool)> =
        tracks.iter().flat_map(|(trajectory, measured)| runs(trajectory, measured)).collect();
    let longest = all.iter().map(|(overlaps, _)| overlaps.len()).max().unwrap_or(0);
    let mut sums = vec![0.0; longest];
    let mut counts = vec![0_usize; longest];
    for (overlaps, failed) in all {
        let mut total = 0.0;
        let end = if failed { longest } else { overlaps.len() };
        for n in 0..end {
            if n > 0 {
                total += overlaps.get(n).copied().unwrap_or(0.0);
                sums[n] += total / n as f64;
            }
            counts[n] += 1;
        }
    }
    sums.iter().zip(&counts).map(|(s, n)| (*n > 0).then(|| s / *n as f64)).collect()
}

/// Mean of E(N) over `low ..= high`, as far as the curve goes; `None` if it does not reach `low`.
pub fn expected_average_overlap(curve: &[Option<f64>], low: usize, high: usize) -> Option<f64> {
    let part = curve.get(low..(high + 1).min(curve.len()))?;
    mean(part.iter().flatten().copied())
}

#[cfg(test)]
mod tests;
