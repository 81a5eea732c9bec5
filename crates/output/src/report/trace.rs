//! What a method said of a track, frame by frame, and how the protocol judged it; from results alone.

use super::results::{Results, ResultsError};
use crate::region::Rect;
use crate::score::{Protocol, TrackScore};
use crate::table::frame::{self, FrameError};
use crate::table::quality::{CHECKS, CONDITIONS};
use crate::table::records::method_label;
use polars::prelude::DataFrame;

/// One run on one sequence.
#[derive(Debug, Clone, Default)]
pub struct Trace {
    /// Sequence.
    pub sequence: String,
    /// Repetition.
    pub run: i64,
    /// Frame numbers, as the sequence has them.
    pub numbers: Vec<i64>,
    /// The tracker's rectangles.
    pub rects: Vec<Rect>,
    /// O_t, NaN where unknown.
    pub error: Vec<f64>,
    /// Score compared with the threshold.
    pub score: Vec<f64>,
    /// Alarm.
    pub alarm: Vec<bool>,
    /// Changes of the label: +1, -1, 0.
    pub changes: Vec<i32>,
    /// Condition of the tracker, from 0 (scanning) to 1 (locked on); empty where the method does not follow it.
    pub condition: Vec<f64>,
    /// Runs of the tracker backwards.
    pub checks: Vec<Backwards>,
}

/// A check of a track by running the tracker backwards.
#[derive(Debug, Clone, PartialEq)]
pub struct Backwards {
    /// Number of the frame in which it was made.
    pub frame: i64,
    /// Number of the frame that was run back to.
    pub reference: i64,
    /// Error there between both ways; none where nothing was run.
    pub error: Option<f64>,
    /// Whether the track is taken to be successful again.
    pub accepted: bool,
}

/// What became of an event or a detection.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Outcome {
    /// Both, matched.
    Hit,
    /// An event without a detection.
    Missed,
    /// A detection without an event.
    FalseAlarm,
}

impl Outcome {
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

/// An event with its detection, or either alone; frames count from 0.
#[derive(Debug, Clone, PartialEq)]
pub struct Moment {
    /// Frame of the event.
    pub event: Option<usize>,
    /// Frame of the detection.
    pub detection: Option<usize>,
    /// What became of it.
    pub outcome: Outcome,
    /// The nearest of the other kind, where there is no partner: its frame, and whose partner it is.
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

/// A stretch of frames that count alike where every frame counts.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Stretch {
    /// First frame, from 0.
    pub from: usize,
    /// Last frame.
    pub to: usize,
    /// Whether the target is lost; none where there is no annotation.
    pub lost: Option<bool>,
    /// Whether the detector raises an alarm.
    pub alarm: bool,
}

/// What an event is: the target is lost, or is found again.
pub const EVENT_WORDS: [&str; 2] = ["lost", "found"];
/// What a detection says.
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
    /// The protocol's judgement, made again.
    pub fn judge(&self, protocol: &Protocol) -> TrackScore {
        (protocol.score)(&self.error, &self.alarm, &self.changes)
    }

    /// What an event is: `lost` or `found`.
    pub fn event_word(&self, t: usize) -> &'static str {
        EVENT_WORDS[usize::from(is_recovery(&self.error, t))]
    }

    /// What a detection says: `alarm` or `all clear`.
    pub fn detection_word(&self, t: usize) -> &'static str {
        DETECTION_WORDS[usize::from(is_all_clear(&self.changes, t))]
    }

    /// Frames that follow each other and count alike.
    pub fn stretches(&self) -> Vec<Stretch> {
        let mut stretches: Vec<Stretch> = Vec::new();
        for (t, &alarm) in self.alarm.iter().enumerate() {
            let lost = lost(&self.error, t);
            match stretches.last_mut().filter(|s| s.lost == lost && s.alarm == alarm) {
                Some(last) => last.to = t,
                None => stretches.push(Stretch { from: t, to: t, lost, alarm }),
            }
        }
        stretches
    }
}

/// Events and detections with what became of them, in order of time.
pub fn moments(judged: &TrackScore) -> Vec<Moment> {
    let TrackScore { events, detections, matches, .. } = judged;
    let partner_of_event = |i: usize| matches.iter().find(|m| m.0 == i).map(|m| detections[m.1]);
    let partner_of_detection = |j: usize| matches.iter().find(|m| m.1 == j).map(|m| events[m.0]);
    let nearest = |t: usize, of: &[usize]| (0..of.len()).min_by_key(|k| of[*k].abs_diff(t));
    let mut moments = Vec::new();
    for (i, &event) in events.iter().enumerate() {
        let detection = partner_of_event(i);
        let outcome = if detection.is_some() { Outcome::Hit } else { Outcome::Missed };
        let near = nearest(event, detections).filter(|_| detection.is_none());
        let nearest = near.map(|j| (detections[j], partner_of_detection(j)));
        moments.push(Moment { event: Some(event), detection, outcome, nearest });
    }
    for (j, &detection) in detections.iter().enumerate() {
        if partner_of_detection(j).is_none() {
            let nearest = nearest(detection, events).map(|i| (events[i], partner_of_event(i)));
            let detection = Some(detection);
            moments.push(Moment { event: None, detection, outcome: Outcome::FalseAlarm, nearest });
        }
    }
    moments.sort_by_key(Moment::frame);
    moments
}

/// The rows of a table that are a method's on a tracker's tracks, of one sequence or of all.
struct Rows {
    sequence: Vec<String>,
    run: Vec<i64>,
    mine: Vec<usize>,
}

impl Rows {
    fn of(table: &DataFrame, tracker: &str, method: &str, wanted: Option<&str>) -> Result<Self, FrameError> {
        let (sequence, run) = (frame::texts(table, "sequence")?, frame::integers(table, "run")?);
        let (trackers, methods) = (frame::texts(table, "tracker")?, frame::texts(table, "method")?);
        let is_mine = |i: &usize| {
            trackers[*i] == tracker && methods[*i] == method && wanted.is_none_or(|s| sequence[*i] == s)
        };
        let mine = (0..sequence.len()).filter(is_mine).collect();
        Ok(Self { sequence, run, mine })
    }
}

/// The tracks of a tracker as a method (with its grid point) saw them, of one sequence or of all.
///
/// # Errors
/// When a table is absent or lacks a column.
pub fn read(
    results: &Results,
    tracker: &str,
    method: &str,
    sequence: Option<&str>,
) -> Result<Vec<Trace>, ResultsError> {
    let columns = [
        "sequence", "tracker", "run", "frame", "x", "y", "w", "h", "error", "method", "score", "label",
        "change",
    ];
    let table = results.parquet("frames.parquet", &columns)?;
    let rows = Rows::of(&table, tracker, method, sequence)?;
    let number = frame::integers(&table, "frame")?;
    let [x, y, w, h] = ["x", "y", "w", "h"].map(|c| frame::floats(&table, c));
    let (x, y, w, h) = (x?, y?, w?, h?);
    let (error, score) = (frame::floats(&table, "error")?, frame::floats(&table, "score")?);
    let (label, change) = (frame::small_integers(&table, "label")?, frame::small_integers(&table, "change")?);
    let mut traces: Vec<Trace> = Vec::new();
    for &i in &rows.mine {
        if traces.last().is_none_or(|t| t.sequence != rows.sequence[i] || t.run != rows.run[i]) {
            let (sequence, run) = (rows.sequence[i].clone(), rows.run[i]);
            traces.push(Trace { sequence, run, ..Trace::default() });
        }
        let Some(trace) = traces.last_mut() else { continue };
        trace.numbers.push(number[i]);
        trace.rects.push(Rect::new(x[i], y[i], w[i], h[i]));
        trace.error.push(error[i]);
        trace.score.push(score[i]);
        trace.alarm.push(label[i] != 0);
        trace.changes.push(change[i]);
    }
    if results.manifest.files.contains_key(CONDITIONS) {
        add_conditions(results, tracker, method, sequence, &mut traces)?;
    }
    if results.manifest.files.contains_key(CHECKS) {
        add_checks(results, tracker, method, &mut traces)?;
    }
    Ok(traces)
}

fn add_conditions(
    results: &Results,
    tracker: &str,
    method: &str,
    sequence: Option<&str>,
    traces: &mut [Trace],
) -> Result<(), ResultsError> {
    let table = results.parquet(CONDITIONS, &["sequence", "tracker", "run", "method", "condition"])?;
    let rows = Rows::of(&table, tracker, method, sequence)?;
    let condition = frame::floats(&table, "condition")?;
    for &i in &rows.mine {
        let mine = |t: &&mut Trace| t.sequence == rows.sequence[i] && t.run == rows.run[i];
        if let Some(trace) = traces.iter_mut().find(mine) {
            trace.condition.push(condition[i]);
        }
    }
    Ok(())
}

fn add_checks(
    results: &Results,
    tracker: &str,
    method: &str,
    traces: &mut [Trace],
) -> Result<(), ResultsError> {
    let table = frame::from_csv(results.bytes(CHECKS)?)?;
    let text = |name: &str| frame::texts(&table, name);
    let (sequences, trackers, methods) = (text("sequence")?, text("tracker")?, text("method")?);
    let (params, run) = (text("params")?, text("run")?);
    let (number, reference, error) = (text("frame")?, text("reference")?, text("error")?);
    let accepted = text("accepted")?;
    let whole = |text: &str| text.parse::<i64>().map_err(|_| FrameError::number(text));
    for i in 0..sequences.len() {
        if trackers[i] != tracker || method_label(&methods[i], &params[i]) != method {
            continue;
        }
        let run = whole(&run[i])?;
        let mine = |t: &&mut Trace| t.sequence == sequences[i] && t.run == run;
        let Some(trace) = traces.iter_mut().find(mine) else { continue };
        let error = match error[i].as_str() {
            "" => None,
            text => Some(text.parse().map_err(|_| FrameError::number(text))?),
        };
        trace.checks.push(Backwards {
            frame: whole(&number[i])?,
            reference: whole(&reference[i])?,
            error,
            accepted: accepted[i] == "1",
        });
    }
    Ok(())
}

/// The frames that `40-60` or `40` names, in the sequence's own numbers.
///
/// # Errors
/// In words.
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
    use crate::score::khalid2016;

    // By hand: failures at 20 and 45, alarms from 18, 30 and 52; 18 matches 20, 52 is 7 late.
    #[test]
    fn tells_hits_misses_and_false_alarms_in_order() {
        let on = |runs: &[std::ops::Range<usize>]| {
            (0..60).map(|t| runs.iter().any(|r| r.contains(&t))).collect::<Vec<bool>>()
        };
        let error = on(&[20..30, 45..60]).iter().map(|lost| if *lost { 1.0 } else { 0.3 }).collect();
        let alarm = on(&[18..22, 30..31, 52..60]);
        let trace = Trace { error, alarm, ..Trace::default() };
        let told: Vec<_> = moments(&trace.judge(&khalid2016::PROTOCOL))
            .into_iter()
            .map(|m| (m.frame(), m.outcome, m.distance(), m.nearest))
            .collect();
        assert_eq!(
            told,
            [
                (20, Outcome::Hit, Some(-2), None),
                (30, Outcome::FalseAlarm, Some(10), Some((20, Some(18)))),
                (45, Outcome::Missed, Some(7), Some((52, None))),
                (52, Outcome::FalseAlarm, Some(7), Some((45, None))),
            ]
        );
        let stretches = trace.stretches();
        assert_eq!(stretches[0], Stretch { from: 0, to: 17, lost: Some(false), alarm: false });
        assert_eq!(stretches.len(), 8);
        assert_eq!(stretches.iter().map(|s| s.to - s.from + 1).sum::<usize>(), 60);
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
