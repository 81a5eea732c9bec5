//! A method on a track, frame by frame, with its events and detections as the protocol matches them; from results alone.

use crate::results::{MethodSeries, Results, ResultsError, TrackFilter, TrackSeries};
use std::ops::Range;
use trackfail_methods::score::counts::Place;
use trackfail_methods::score::{Protocol, TrackScore};

/// The series of a method on one run of a tracker over one sequence.
#[derive(Debug, Clone, Default)]
pub struct Trace {
    /// The track; its other methods are left out.
    pub track: TrackSeries,
    /// The method.
    pub method: MethodSeries,
}

/// The outcome of an event or a detection.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum EventOutcome {
    /// A matched pair of both.
    Hit,
    /// An event without a detection.
    Missed,
    /// A detection without an event.
    FalseAlarm,
}

impl EventOutcome {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::Hit, Self::Missed, Self::FalseAlarm];

    /// In words.
    pub fn words(self) -> &'static str {
        match self {
            Self::Hit => "hit",
            Self::Missed => "missed",
            Self::FalseAlarm => "false alarm",
        }
    }
}

/// An event with its detection, or one of them without the other; frames count from 0.
#[derive(Debug, Clone, PartialEq)]
pub struct Moment {
    /// Frame of the event.
    pub event: Option<usize>,
    /// Frame of the detection.
    pub detection: Option<usize>,
    /// The outcome.
    pub outcome: EventOutcome,
    /// Without a partner: the frame of the nearest one of the other kind, and the frame of that one's partner.
    pub nearest: Option<(usize, Option<usize>)>,
}

impl Moment {
    /// The frame it is about.
    pub fn frame(&self) -> usize {
        self.event.or(self.detection).unwrap_or_default()
    }

    /// Frames from the event to the detection, to the nearest one of the other kind where there is no partner.
    pub fn distance(&self) -> Option<i64> {
        let near = self.nearest.map(|(t, _)| t);
        let (event, detection) = (self.event.or(near)?, self.detection.or(near)?);
        Some(detection as i64 - event as i64)
    }
}

/// Common properties of frames that count alike, where every frame counts: whether the target is lost (none where there
/// is no annotation), whether the detector raises an alarm, and how they count (none where they do not).
pub type Alike = (Option<bool>, bool, Option<Place>);

/// Words of events: the target is lost, or is found again.
pub const EVENT_WORDS: [&str; 2] = ["lost", "found"];
/// Words of detections.
pub const DETECTION_WORDS: [&str; 2] = ["alarm", "all clear"];

/// Whether the target is lost in a frame, whose error may be unknown.
fn lost(error: &[f64], t: usize) -> Option<bool> {
    error.get(t).filter(|e| !e.is_nan()).map(|e| *e >= 1.0)
}

/// Whether an event is that the target is found again.
pub fn is_recovery(error: &[f64], t: usize) -> bool {
    lost(error, t) == Some(false)
}

/// Whether a detection says that all is well again.
pub fn is_all_clear(changes: &[i32], t: usize) -> bool {
    changes.get(t).is_some_and(|c| *c < 0)
}

impl Trace {
    fn of_first_method(mut track: TrackSeries) -> Option<Self> {
        let methods = std::mem::take(&mut track.methods);
        Some(Self { method: methods.into_iter().next()?, track })
    }

    /// The number that is compared with the threshold.
    pub fn compared(&self) -> &[f64] {
        let MethodSeries { score, alarm_score, .. } = &self.method;
        if alarm_score.is_empty() { score } else { alarm_score }
    }

    /// Events, detections and matches, computed again by the protocol.
    pub fn judge(&self, protocol: &Protocol) -> TrackScore {
        self.track.judge(protocol, &self.method.alarm, &self.method.changes)
    }

    /// Word of an event: `lost` or `found`.
    pub fn event_word(&self, t: usize) -> &'static str {
        EVENT_WORDS[usize::from(is_recovery(&self.track.error, t))]
    }

    /// Word of a detection: `alarm` or `all clear`.
    pub fn detection_word(&self, t: usize) -> &'static str {
        DETECTION_WORDS[usize::from(is_all_clear(&self.method.changes, t))]
    }

    /// Runs of frames, from 0, that count alike, for protocols that say how a frame counts.
    pub fn stretches(&self, frame: fn(f64, bool) -> Option<Place>) -> Vec<(Range<usize>, Alike)> {
        let alike = |t: usize| {
            let (error, alarm) = (&self.track.error, self.method.alarm[t]);
            (lost(error, t), alarm, error.get(t).and_then(|e| frame(*e, alarm)))
        };
        let frames: Vec<usize> = (0..self.method.alarm.len()).collect();
        let runs = frames.chunk_by(|a, b| alike(*a) == alike(*b));
        runs.map(|run| (run[0]..run[0] + run.len(), alike(run[0]))).collect()
    }
}

/// Events and detections with their outcomes, in order of time.
pub fn moments(judged: &TrackScore) -> Vec<Moment> {
    let TrackScore { events, detections, matches, .. } = judged;
    let of_event = |i: usize| matches.iter().find(|m| m.0 == i).map(|m| detections[m.1]);
    let of_detection = |j: usize| matches.iter().find(|m| m.1 == j).map(|m| events[m.0]);
    let nearest = |t: usize, of: &[usize]| (0..of.len()).min_by_key(|k| of[*k].abs_diff(t));
    let event = |(i, &event): (usize, &usize)| {
        let detection = of_event(i);
        let outcome = if detection.is_some() { EventOutcome::Hit } else { EventOutcome::Missed };
        let near = nearest(event, detections).filter(|_| detection.is_none());
        let nearest = near.map(|j| (detections[j], of_detection(j)));
        Moment { event: Some(event), detection, outcome, nearest }
    };
    let alone = detections.iter().enumerate().filter(|(j, _)| of_detection(*j).is_none());
    let false_alarm = |(_, &detection): (usize, &usize)| {
        let nearest = nearest(detection, events).map(|i| (events[i], of_event(i)));
        Moment { event: None, detection: Some(detection), outcome: EventOutcome::FalseAlarm, nearest }
    };
    let mut moments: Vec<Moment> =
        events.iter().enumerate().map(event).chain(alone.map(false_alarm)).collect();
    moments.sort_by_key(Moment::frame);
    moments
}

/// Reads the tracks of a tracker as a method (with its grid point) saw them, of one sequence or of all.
///
/// # Errors
/// When a file is absent or damaged.
pub fn read(
    results: &Results,
    tracker: &str,
    method: &str,
    sequence: Option<&str>,
) -> Result<Vec<Trace>, ResultsError> {
    let filter = TrackFilter { tracker: Some(tracker), method: Some(method), sequence, run: None };
    let tracks = results.checked_tracks(&filter)?;
    Ok(tracks.into_iter().filter_map(Trace::of_first_method).collect())
}

/// Text that does not name frames.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("`{0}` names no frames; write `40-60`, or `40` for one")]
pub struct FrameRangeError(String);

/// The frames that `40-60` or `40` names: first and last, in the sequence's own numbers.
///
/// # Errors
/// For anything but one number, or two in order.
pub fn frame_range(text: &str) -> Result<(i64, i64), FrameRangeError> {
    let number = |part: &str| part.trim().parse::<i64>().ok().filter(|n| *n >= 0);
    let (from, to) = text.split_once('-').unwrap_or((text, text));
    match (number(from), number(to)) {
        (Some(from), Some(to)) if from <= to => Ok((from, to)),
        _ => Err(FrameRangeError(text.to_string())),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use trackfail_methods::score::khalid2016;

    // By hand: failures at 20 and 45, alarms from 18, 30 and 52; 18 matches 20, 52 is 7 late.
    #[test]
    fn tells_hits_misses_and_false_alarms_in_order() {
        let on = |runs: &[std::ops::Range<usize>]| {
            (0..60).map(|t| runs.iter().any(|r| r.contains(&t))).collect::<Vec<bool>>()
        };
        let error = on(&[20..30, 45..60]).iter().map(|lost| if *lost { 1.0 } else { 0.3 }).collect();
        let alarm = on(&[18..22, 30..31, 52..60]);
        let trace = Trace {
            track: TrackSeries { error, ..TrackSeries::default() },
            method: MethodSeries { alarm, ..MethodSeries::default() },
        };
        let told: Vec<_> = moments(&trace.judge(&khalid2016::PROTOCOL))
            .into_iter()
            .map(|m| (m.frame(), m.outcome, m.distance(), m.nearest))
            .collect();
        let expected = [
            (20, EventOutcome::Hit, Some(-2), None),
            (30, EventOutcome::FalseAlarm, Some(10), Some((20, Some(18)))),
            (45, EventOutcome::Missed, Some(7), Some((52, None))),
            (52, EventOutcome::FalseAlarm, Some(7), Some((45, None))),
        ];
        assert_eq!(told, expected);
        let frame = trackfail_methods::score::segmentation::PROTOCOL.frame.unwrap();
        let stretches = trace.stretches(frame);
        assert_eq!(stretches[0], (0..18, (Some(false), false, Some(Place::TruePositive))));
        assert_eq!(stretches.len(), 8);
        assert_eq!(stretches.iter().map(|(run, _)| run.len()).sum::<usize>(), 60);
    }

    #[test]
    fn frames_are_named_by_numbers() {
        assert_eq!(frame_range("40-60"), Ok((40, 60)));
        assert_eq!(frame_range("7"), Ok((7, 7)));
        for bad in ["", "-", "60-40", "a-b", "-3", "1-2-3", "99999999999999999999"] {
            assert!(frame_range(bad).is_err(), "{bad}");
        }
    }
}
