//! Tracks with their signals.

use super::reverse::Reversal;
use crate::error::CellError;
use std::borrow::Cow;
use std::collections::BTreeMap;
use std::ops::Range;
use std::sync::Arc;
use trackfail_core::region::Region;
use trackfail_dataset::suite::Origin;
use trackfail_methods::detector::{DetectorOutput, Example};
use trackfail_methods::score::{Protocol, TrackScore};
use trackfail_methods::tracker::Status;

/// A tracker's run over a sequence, with the signals computed from it.
#[derive(Clone, Default)]
pub struct Track {
    /// Region of each frame.
    pub regions: Vec<Region>,
    /// Status of each frame.
    pub status: Vec<Status>,
    /// Confidence of the tracker in each frame; empty if the tracker gives none.
    pub confidence: Vec<Option<f64>>,
    /// Overlap error O_t of each frame, 0 to 1; NaN where the target is not annotated.
    pub error: Vec<f64>,
    /// Values of each distinct signal of the experiment; empty for signals that are not needed on this track or
    /// failed. A signal of several values per frame has its series one after the other.
    pub signals: Vec<Vec<f64>>,
    /// Errors of the signals that failed.
    pub faults: BTreeMap<usize, CellError>,
    /// Number of frames that repeat the region before: frames marked failed or skipped, and frames without a
    /// box in a result file.
    pub repeated: usize,
    /// Reverse runs of the tracker, if a method of the experiment needs them.
    pub reversal: Option<Arc<Reversal>>,
}

impl Track {
    /// Checks that none of these signals failed.
    ///
    /// # Errors
    /// Error of the first one that did.
    pub fn check(&self, signals: &[usize]) -> Result<(), CellError> {
        signals.iter().find_map(|k| self.faults.get(k)).map_or(Ok(()), |e| Err(e.clone()))
    }

    /// Values of the signal that a method reads; zeros for methods without a signal.
    pub fn signal(&self, signal: Option<usize>) -> Cow<'_, [f64]> {
        match signal.and_then(|k| self.signals.get(k)) {
            Some(series) => self.values(series).next().unwrap_or_default().into(),
            None => vec![0.0; self.error.len()].into(),
        }
    }

    /// Further series that a method reads, after the first series of its first signal.
    pub fn more(&self, signals: &[usize]) -> Vec<&[f64]> {
        let series = signals.iter().filter_map(|k| self.signals.get(*k));
        series.flat_map(|series| self.values(series)).skip(1).collect()
    }

    /// Splits the values of a signal into series, one for each value per frame.
    fn values<'a>(&self, series: &'a [f64]) -> std::slice::Chunks<'a, f64> {
        series.chunks(self.error.len().max(1))
    }

    /// Score of a detector's output by a protocol. Also the frame ranges of pieces that were scored
    /// separately, if restarts begin new tracks.
    pub fn judge(&self, protocol: &Protocol, output: &DetectorOutput) -> (TrackScore, Vec<Range<usize>>) {
        let pieces = protocol.restarts.pieces(&self.status);
        let score = protocol.judge(&self.error, &output.alarm, &output.changes(), &pieces);
        (score, pieces)
    }

    /// The track with one of its signals, in the form of training data.
    pub fn example(&self, signal: Option<usize>) -> Example<'_> {
        let signal = signal.and_then(|k| self.values(self.signals.get(k)?).next());
        Example::new(signal.unwrap_or_default(), &self.error)
    }

    /// The track with the signals of a method, in the form of training data.
    pub fn example_of(&self, signals: &[usize], origin: &Origin) -> Example<'_> {
        let (video, source) = (origin.video.clone(), origin.source.clone());
        Example { more: self.more(signals), video, source, ..self.example(signals.first().copied()) }
    }
}

/// Tracks of one sequence, one for each job.
pub type Tracks = Vec<Result<Arc<Track>, CellError>>;
