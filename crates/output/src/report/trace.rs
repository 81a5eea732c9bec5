//! A method on a track, frame by frame, with events and detections matched by the protocol; from results
//! alone.

use crate::results::{MethodSeries, Results, ResultsError, TrackFilter, TrackSeries};
use std::ops::Range;
use trackfail_methods::score::counts::Place;
use trackfail_methods::score::{Protocol, TrackScore};

/// Series of a method on one run of a tracker over one sequence.
#[derive(Debug, Clone, Default)]
pub struct Trace {
    /// The track, without its other methods.
    pub track: TrackSeries,
    /// Series of the method.
    pub method: MethodSeries,
}

/// Outcome of an event or a detection.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum EventOutcome {
    /// An event with its matching detection.
    Hit,
    /// An event without a detection.
    Missed,
    /// A detection without an event.
    FalseAlarm,
}

impl EventOutcome {
    /// All outcomes.
    pub const ALL: [Self; 3] = [Self::Hit, Self::Missed, Self::FalseAlarm];

    /// The outcome in words.
    pub fn words(self) -> &'static str {
        ["hit", "missed", "false alarm"][self as usize]
    }
}

/// An event with its detection, or one of the two without the other. Frames count from 0.
#[derive(Debug, Clone, PartialEq)]
pub struct Moment {
    /// Frame of the event, if there is one.
    pub event: Option<usize>,
    /// Frame of the detection, if there is one.
    pub detection: Option<usize>,
    /// Outcome of the event or detection.
    pub outcome: EventOutcome,
    /// Only for moments without a partner: the frame of the nearest moment of the other kind, and the frame
    /// of that one's partner.
    pub nearest: Option<(usize, Option<usize>)>,
}

impl Moment {
    /// Frame of the event or, without an event, of the detection.
    pub fn frame(&self) -> usize {
        self.event.or(self.detection).unwrap_or_default()
    }

    /// Number of frames from the event to the detection. Without a partner, to the nearest moment of the
    /// other kind.
    pub fn distance(&self) -> Option<i64> {
        let near = self.nearest.map(|(t, _)| t);
        let (event, detection) = (self.event.or(near)?, self.detection.or(near)?);
        Some(detection as i64 - event as i64)
    }
}

/// Properties that frames of a stretch share, in protocols that count all frames: true if the target is lost
/// (`None` without annotation), true if the detector alarms, and how the frames count (`None` if they do
/// not).
pub type Alike = (Option<bool>, bool, Option<Place>);

/// Words for events: the target is lost, or found again.
pub const EVENT_WORDS: [&str; 2] = ["lost", "found"];
/// Words for detections: an alarm begins or ends.
pub const DETECTION_WORDS: [&str; 2] = ["alarm", "all clear"];

/// True if the target is lost in frame `t`; `None` if the error is unknown.
fn lost(error: &[f64], t: usize) -> Option<bool> {
    error.get(t).filter(|e| !e.is_nan()).map(|e| *e >= 1.0)
}

/// True if the event is a recovery, that is, the target is found again.
pub fn is_recovery(error: &[f64], t: usize) -> bool {
    lost(error, t) == Some(false)
}

/// True if the detection is the end of an alarm.
pub fn is_all_clear(changes: &[i32], t: usize) -> bool {
    changes.get(t).is_some_and(|c| *c < 0)
}

impl Trace {
    /// Events, detections and matches, computed by the protocol.
    pub fn judge(&self, protocol: &Protocol) -> TrackScore {
        self.track.judge(protocol, &self.method.alarm, &self.method.changes)
    }

    /// Word for an event: `lost` or `found`.
    pub fn event_word(&self, t: usize) -> &'static str {
        EVENT_WORDS[usize::from(is_recovery(&self.track.error, t))]
    }

    /// Word for a detection: `alarm` or `all clear`.
    pub fn detection_word(&self, t: usize) -> &'static str {
        DETECTION_WORDS[usize::from(is_all_clear(&self.method.changes, t))]
    }

    /// Stretches of frames (0-based) that count the same, for protocols that count single frames.
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

/// Reads the tracks of a tracker with the series of a method (with its grid point), for one sequence or all.
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
    let of_method = |mut track: TrackSeries| {
        let method = std::mem::take(&mut track.methods).into_iter().next()?;
        Some(Trace { track, method })
    };
    Ok(results.checked_tracks(&filter)?.into_iter().filter_map(of_method).collect())
}

/// Parses `40-60` or `40` as first and last frame, in the sequence's own numbers.
///
/// # Errors
/// When the text is not one number, or two in ascending order.
pub fn frame_range(text: &str) -> Result<(i64, i64), String> {
    let number = |part: &str| part.trim().parse::<i64>().ok().filter(|n| *n >= 0);
    let (from, to) = text.split_once('-').unwrap_or((text, text));
    match (number(from), number(to)) {
        (Some(from), Some(to)) if from <= to => Ok((from, to)),
        _ => Err(format!("`{text}` names no frames; write `40-60`, or `40` for one")),
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
