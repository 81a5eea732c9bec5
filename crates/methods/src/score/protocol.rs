//! Protocols: versioned rules from labels and ground truth to counts.

use super::chance::Chance;
use super::counts::{Counts, Place};
use super::restarts::Restarts;
use std::ops::Range;

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

impl Protocol {
    /// Scores the pieces of a track, from [`Restarts::pieces`], or all of it without any; frames count from the track's first.
    pub fn judge(
        &self,
        error: &[f64],
        alarm: &[bool],
        changes: &[i32],
        pieces: Option<&[Range<usize>]>,
    ) -> TrackScore {
        let Some(pieces) = pieces else { return (self.score)(error, alarm, changes) };
        let mut whole = TrackScore::default();
        for (k, piece) in pieces.iter().enumerate() {
            let mut alarm = alarm[piece.clone()].to_vec();
            if k > 0 {
                alarm.iter_mut().take_while(|alarm| **alarm).for_each(|alarm| *alarm = false);
            }
            let changes = changes.get(piece.clone()).unwrap_or_default();
            let part = (self.score)(&error[piece.clone()], &alarm, changes);
            let (events, detections) = (whole.events.len(), whole.detections.len());
            whole.counts = [whole.counts, part.counts].into_iter().sum::<Counts>();
            whole.events.extend(part.events.iter().map(|t| t + piece.start));
            whole.detections.extend(part.detections.iter().map(|t| t + piece.start));
            whole.matches.extend(part.matches.iter().map(|(e, d)| (e + events, d + detections)));
        }
        whole
    }
}
