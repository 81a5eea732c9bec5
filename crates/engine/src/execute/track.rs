//! Tracks with their signals.

use super::reverse::Reversal;
use crate::error::CellError;
use crate::plan::ExperimentPlan;
use std::borrow::Cow;
use std::ops::Range;
use std::sync::Arc;
use trackfail_core::region::Region;
use trackfail_dataset::suite::Origin;
use trackfail_methods::detector::{DetectorOutput, Example};
use trackfail_methods::score::{Protocol, TrackScore};
use trackfail_methods::tracker::Status;

/// A tracker's run over a sequence, with the signals computed from it.
#[derive(Debug, Clone)]
pub struct Track {
    /// The region of each frame.
    pub regions: Vec<Region>,
    /// The status of each frame.
    pub status: Vec<Status>,
    /// The tracker's confidence in each frame; empty if it gives none.
    pub confidence: Vec<Option<f64>>,
    /// Overlap error O_t of each frame, 0 to 1; NaN where the target is not annotated.
    pub error: Vec<f64>,
    /// One series for each of the experiment's distinct signals, of several values a frame one series after the other;
    /// empty for those not needed on this track.
    pub signals: Vec<Vec<f64>>,
    /// Frames whose region repeats the last one: those marked failed or skipped, and those of a result file without a box
    /// that were passed over.
    pub repeated: usize,
    /// Reverse runs of its tracker, where a method of the experiment needs them.
    pub reversal: Option<Arc<Reversal>>,
}

impl Track {
    /// The signal that a method reads; zeros for methods without one.
    pub fn signal(&self, signal: Option<usize>) -> Cow<'_, [f64]> {
        match signal.and_then(|k| self.signals.get(k)) {
            Some(series) => self.values(series).next().unwrap_or_default().into(),
            None => vec![0.0; self.error.len()].into(),
        }
    }

    /// The further series of the signals that a method reads, behind the first of all.
    pub fn more(&self, signals: &[usize]) -> Vec<&[f64]> {
        let series = signals.iter().filter_map(|k| self.signals.get(*k));
        series.flat_map(|series| self.values(series)).skip(1).collect()
    }

    /// The series of each value of a signal.
    fn values<'a>(&self, series: &'a [f64]) -> std::slice::Chunks<'a, f64> {
        series.chunks(self.error.len().max(1))
    }

    /// The score of a detector's output by a protocol, with the pieces that were scored by themselves, where a restart
    /// begins a new track.
    pub fn judge(&self, protocol: &Protocol, output: &DetectorOutput) -> (TrackScore, Vec<Range<usize>>) {
        let pieces = protocol.restarts.pieces(&self.status);
        let score = protocol.judge(&self.error, &output.alarm, &output.changes(), &pieces);
        (score, pieces)
    }

    /// The track with one of its signals, as training data.
    pub fn example(&self, signal: Option<usize>) -> Example<'_> {
        let signal = signal.and_then(|k| self.values(self.signals.get(k)?).next());
        Example::new(signal.unwrap_or_default(), &self.error)
    }

    /// The track with the signals of a method, as training data.
    pub fn example_of(&self, signals: &[usize], origin: &Origin) -> Example<'_> {
        let Origin { video, source } = origin.clone();
        Example { more: self.more(signals), video, source, ..self.example(signals.first().copied()) }
    }
}

/// The tracks of one sequence, one for each job.
pub type Tracks = Vec<Result<Arc<Track>, CellError>>;

/// The tracks of a tracker's first runs on a suite that could be made and have the signal, with the indices of their
/// sequence and job. `tracks` has those of every suite.
pub fn of_runs(
    plan: &ExperimentPlan<'_>,
    tracks: &[Vec<Tracks>],
    suite: usize,
    tracker: usize,
    runs: u32,
    signal: Option<usize>,
) -> Vec<(Arc<Track>, usize, usize)> {
    let pairs = plan.of_runs(suite, tracker, runs, signal).into_iter();
    pairs.filter_map(|(s, j)| Some((tracks[suite][s][j].as_ref().ok()?.clone(), s, j))).collect()
}
