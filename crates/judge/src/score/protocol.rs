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

/// The values of a track in the frames of a piece, as far as the track goes.
fn part<'v, T>(values: &'v [T], piece: &Range<usize>) -> &'v [T] {
    let end = piece.end.min(values.len());
    &values[piece.start.min(end)..end]
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
    /// Scores one track, or a piece of one: tracking errors (NaN where unknown), alarms and changes between them, one a
    /// frame. Only [`Protocol::judge`] knows which it is.
    pub(crate) score: fn(error: &[f64], alarm: &[bool], changes: &[i32]) -> TrackScore,
}

impl Protocol {
    /// Scores a track whose restarts begin these pieces, from [`super::restarts::pieces`], or none; whether each is scored by
    /// itself is the protocol's choice. Frames count from the track's first. Pieces may be longer than the track.
    pub fn judge(
        &self,
        error: &[f64],
        alarm: &[bool],
        changes: &[i32],
        pieces: &[Range<usize>],
    ) -> TrackScore {
        let pieces = self.restarts.apart(pieces);
        if pieces.is_empty() {
            return (self.score)(error, alarm, changes);
        }
        let mut whole = TrackScore::default();
        for (k, piece) in pieces.iter().enumerate() {
            let mut alarm = part(alarm, piece).to_vec();
            if k > 0 {
                alarm.iter_mut().take_while(|alarm| **alarm).for_each(|alarm| *alarm = false);
            }
            let score = (self.score)(part(error, piece), &alarm, part(changes, piece));
            let (events, detections) = (whole.events.len(), whole.detections.len());
            whole.counts = [whole.counts, score.counts].into_iter().sum::<Counts>();
            whole.events.extend(score.events.iter().map(|t| t + piece.start));
            whole.detections.extend(score.detections.iter().map(|t| t + piece.start));
            whole.matches.extend(score.matches.iter().map(|(e, d)| (e + events, d + detections)));
        }
        whole
    }
}
