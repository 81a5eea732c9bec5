//! Protocols: versioned rules from labels and ground truth to counts.

use super::chance::Chance;
use super::counts::{Counts, Place};
use super::restarts::{self, Restarts, counted_alarms};
use std::collections::BTreeSet;
use std::ops::Range;

/// Score of one method on one track.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct TrackScore {
    /// True and false positives and negatives.
    pub counts: Counts,
    /// Frames (0-based) in which the tracker failed, or in which the protocol's event happened.
    pub events: Vec<usize>,
    /// Frames (0-based) in which the detector reports an event.
    pub detections: Vec<usize>,
    /// Matched pairs, as indices into `events` and `detections`.
    pub matches: Vec<(usize, usize)>,
}

impl TrackScore {
    /// Score of events and detections with their matches. True negatives are the `judged` frames that are neither a
    /// detection nor an unmatched event.
    pub(super) fn of_matches(
        judged: Range<usize>,
        events: Vec<usize>,
        detections: Vec<usize>,
        matches: Vec<(usize, usize)>,
    ) -> Self {
        let found: BTreeSet<usize> = matches.iter().map(|(event, _)| *event).collect();
        let missed = (0..events.len()).filter(|k| !found.contains(k)).map(|k| events[k]);
        let taken: BTreeSet<usize> =
            detections.iter().copied().chain(missed).filter(|t| judged.contains(t)).collect();
        let counts = Counts {
            tp: matches.len() as u64,
            fp: (detections.len() - matches.len()) as u64,
            fn_: (events.len() - matches.len()) as u64,
            tn: (judged.len() - taken.len()) as u64,
        };
        Self { counts, events, detections, matches }
    }

    /// Number of frames from each matched event to its detection, negative if the detection comes first.
    pub fn delays(&self) -> impl Iterator<Item = i64> + '_ {
        let frames = |pair: &(usize, usize)| Some((*self.events.get(pair.0)?, *self.detections.get(pair.1)?));
        self.matches.iter().filter_map(frames).map(|(event, detection)| detection as i64 - event as i64)
    }
}

/// Values in the frames of a piece, as far as the track goes.
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
    /// Name of what TP + FN counts, in headings of tables.
    pub positives: &'static str,
    /// Count of a frame, from its tracking error and true for an alarm; `None` if the frame does not count.
    /// Only for protocols that count all frames.
    pub frame: Option<fn(error: f64, alarm: bool) -> Option<Place>>,
    /// Treatment of restarts. If they begin new tracks, `score` scores each piece.
    pub restarts: Restarts,
    /// Rule by which random detections match.
    pub chance: Chance,
    /// Scores one track or piece, from tracking errors (NaN if unknown), alarms, and changes between them,
    /// one per frame. It does not know if it has a whole track; [`Protocol::judge`] does.
    pub(crate) score: fn(error: &[f64], alarm: &[bool], changes: &[i32]) -> TrackScore,
}

impl Protocol {
    /// Scores a track, from the first frame on whose error is known: before it the tracker has not started. `pieces` are
    /// those that restarts begin ([`super::restarts::pieces`]); the protocol decides if each is scored separately.
    /// Pieces may be longer than the track.
    pub fn judge(
        &self,
        error: &[f64],
        alarm: &[bool],
        changes: &[i32],
        pieces: &[Range<usize>],
    ) -> TrackScore {
        let pieces = self.restarts.apart(pieces);
        let mut whole = TrackScore::default();
        let alarm = counted_alarms(pieces, alarm);
        for piece in &restarts::started(pieces, error) {
            let score = (self.score)(part(error, piece), part(&alarm, piece), part(changes, piece));
            let (events, detections) = (whole.events.len(), whole.detections.len());
            whole.counts = [whole.counts, score.counts].into_iter().sum::<Counts>();
            whole.events.extend(score.events.iter().map(|t| t + piece.start));
            whole.detections.extend(score.detections.iter().map(|t| t + piece.start));
            whole.matches.extend(score.matches.iter().map(|(e, d)| (e + events, d + detections)));
        }
        whole
    }
}
