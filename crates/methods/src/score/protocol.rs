//! Protocols: versioned rules from labels and ground truth to counts.

use super::chance::Chance;
use super::counts::{Counts, Place};
use super::restarts::Restarts;

/// The score of one method on one track.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct TrackScore {
    /// True and false positives and negatives.
    pub counts: Counts,
    /// Frames (0-based) in which the tracker failed, or in which what the protocol looks for happened.
    pub events: Vec<usize>,
    /// Frames (0-based) in which the detector reports an event.
    pub detections: Vec<usize>,
    /// Matched pairs, as indices into `events` and `detections`.
    pub matches: Vec<(usize, usize)>,
}

impl TrackScore {
    /// Frames from each matched event to its detection, negative where the detection comes first.
    pub fn delays(&self) -> impl Iterator<Item = i64> + '_ {
        let frames = |pair: &(usize, usize)| Some((*self.events.get(pair.0)?, *self.detections.get(pair.1)?));
        self.matches.iter().filter_map(frames).map(|(event, detection)| detection as i64 - event as i64)
    }
}

/// Rules that turn errors and alarms into counts, under a versioned name.
pub struct Protocol {
    /// Name and version: `khalid2016/1`.
    pub name: &'static str,
    /// One line for `trackfail list`.
    pub summary: &'static str,
    /// Name of the things that TP + FN counts, in headings of tables.
    pub positives: &'static str,
    /// How a frame counts, for protocols that count every frame: its tracking error and whether it has an alarm. `None` where
    /// it does not count.
    pub frame: Option<fn(error: f64, alarm: bool) -> Option<Place>>,
    /// Whether a restart of the tracker begins a new track; `score` then scores each piece.
    pub restarts: Restarts,
    /// How random detections match.
    pub chance: Chance,
    /// Scores one track: tracking errors (NaN where unknown), alarms and changes between them, one a frame.
    pub score: fn(error: &[f64], alarm: &[bool], changes: &[i32]) -> TrackScore,
}
