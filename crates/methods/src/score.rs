//! Scores: labels and ground truth in, counts and measures out. Pure functions.
//!
//! [`overlap`] gives the tracking error O_t, [`matching`] pairs detections with events, [`measures`]
//! turns counts into numbers, [`chance`] tells what random detections would have, and each protocol is one file with the exact rules of one paper under a
//! versioned name. Trackers themselves, instead of detectors, are scored by [`success`] (OTB) and [`resets`]
//! (VOT).

pub mod chance;
pub mod khalid2016;
pub mod matching;
pub mod measures;
pub mod overlap;
pub mod resets;
pub mod sanmiguel2015;
pub mod segmentation;
pub mod success;
pub mod trajectory;

use chance::Chance;
use measures::Counts;

/// The score of one method on one track.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct TrackScore {
    /// True and false positives and negatives.
    pub counts: Counts,
    /// Frames (0-based) in which the tracker failed.
    pub events: Vec<usize>,
    /// Frames (0-based) in which the detector says so.
    pub detections: Vec<usize>,
    /// Matched pairs, as indices into `events` and `detections`.
    pub matches: Vec<(usize, usize)>,
}

impl TrackScore {
    /// Frames from each matched event to its detection, negative where this comes first.
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
    /// What TP + FN counts, in headings of tables.
    pub positives: &'static str,
    /// How random detections match.
    pub chance: Chance,
    /// Scores one track: tracking errors (NaN where unknown), alarms and changes between them, one a frame.
    pub score: fn(error: &[f64], alarm: &[bool], changes: &[i32]) -> TrackScore,
}

/// Every protocol, by name.
pub static PROTOCOLS: &[Protocol] =
    &[khalid2016::PROTOCOL, sanmiguel2015::SIGNED, sanmiguel2015::UNSIGNED, segmentation::PROTOCOL];

/// The protocol of a name.
pub fn protocol(name: &str) -> Option<&'static Protocol> {
    PROTOCOLS.iter().find(|p| p.name == name)
}
