//! Contributions to a number as rows of text: sequences, events and detections, stretches, frames.

use super::select::has_frames;
use super::{Explained, Part};
use crate::report::sequences::counted_by;
use crate::report::trace::{self, Alike, EventOutcome, Moment, Trace};
use crate::results::Results;
use crate::table::layout::Origin;
use std::ops::Range;
use trackfail_engine::spec::table::Table;
use trackfail_methods::score::Counts;
use trackfail_methods::score::counts::Place;

/// Number of decimals shown, such as four for people; `None` for all digits, for programs.
pub type Digits = Option<usize>;

/// Number of leading columns in all listings, which name the number: tracker, method, params and metric.
pub const NAMED: usize = 4;

/// Headings and rows.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Listing {
    /// Headings of the columns; the first [`NAMED`] name the number.
    pub headings: Vec<&'static str>,
    /// Rows, a text for each heading.
    pub rows: Vec<Vec<String>>,
}

impl Listing {
    /// Listing of rows with these columns (separated by commas) after the columns that name the number.
    fn new(of: &Origin, columns: &'static str, rows: impl IntoIterator<Item = Vec<String>>) -> Self {
        let names = [of.tracker.as_str(), &of.method, &of.params, of.metric.name()];
        let named = |row: Vec<String>| names.map(String::from).into_iter().chain(row).collect();
        let rows = rows.into_iter().map(named).collect();
        Self { headings: "tracker,method,params,metric".split(',').chain(columns.split(',')).collect(), rows }
    }
}

/// A number as text; empty for `None`.
fn number(digits: Digits, value: Option<f64>) -> String {
    match (value.filter(|v| v.is_finite()), digits) {
        (None, _) => String::new(),
        (Some(v), Some(digits)) => format!("{v:.digits$}"),
        (Some(v), None) => v.to_string(),
    }
}

/// Describes a number in lines: its meaning, its formula, and what it leaves out.
pub fn about(results: &Results, table: &Table, explained: &Explained) -> String {
    let (of, experiment) = (&explained.of, &results.experiment);
    let value = explained.value.map_or("no value".to_string(), |v| v.to_string());
    let (title, label) = (of.metric.title(), of.label());
    let number =
        format!("{}/{}, tracker {}: {title} of {label} is {value}", experiment.name, table.name, of.tracker);
    let mut lines = vec![number, explained.formula.clone()];
    lines.extend(explained.protocol.map(counted_by));
    lines.extend(of.attribute.as_ref().map(|a| format!("only sequences with the attribute {a}")));
    for p in experiment.published.iter().filter(|p| p.table == table.name && p.row == of.row) {
        let printed = p.values.iter().filter(|(column, _)| *column == of.column);
        lines.extend(printed.map(|(_, text)| format!("published for {}: {text}", p.tracker)));
    }
    let down = if has_frames(results, of) { ", down to its events with --sequence" } else { "" };
    let count = explained.parts.len();
    lines.push(format!("from {count} sequences; `moves` is how far a sequence moves the number{down}"));
    let left_out = explained.failed.iter();
    lines.extend(left_out.map(|(sequence, run, why)| format!("left out: {sequence}, run {run}: {why}")));
    lines.join("\n  ") + "\n"
}

/// Counts in words.
pub(super) fn in_words(Counts { tp, fp, fn_, tn }: Counts) -> String {
    format!("TP {tp}, FP {fp}, FN {fn_}, TN {tn}")
}

/// Describes a number on one sequence, in several lines.
pub fn about_sequence(results: &Results, explained: &Explained, sequence: &str) -> String {
    let of = &explained.of;
    let mut lines =
        vec![format!("{}, {sequence}: {} on tracker {}", results.experiment.name, of.label(), of.tracker)];
    lines.extend(explained.protocol.map(counted_by));
    let part = explained.parts.iter().find(|p| p.sequence == sequence);
    lines.extend(part.map(|p| in_words(p.counts)));
    lines.join("\n  ") + "\n"
}

/// Contributions of the sequences, the largest first.
pub fn sequences(explained: &Explained, digits: Digits) -> Listing {
    let row = |p: &Part| {
        let Counts { tp, fp, fn_, tn } = p.counts;
        let moves = match (digits, p.moves) {
            (Some(digits), Some(v)) => format!("{v:+.digits$}"),
            (digits, v) => number(digits, v),
        };
        let mut row = vec![p.sequence.clone(), p.runs.to_string()];
        row.extend([tp, fp, fn_, tn].map(|n| n.to_string()));
        row.extend([number(digits, p.alone), number(digits, p.without), moves]);
        row
    };
    let columns = "sequence,runs,tp,fp,fn,tn,alone,without,moves";
    Listing::new(&explained.of, columns, explained.parts.iter().map(row))
}

/// Number of a frame as the sequence counts it; empty for `None`.
fn frame_number(trace: &Trace, t: Option<usize>) -> String {
    t.and_then(|t| trace.track.numbers.get(t)).map_or_else(String::new, i64::to_string)
}

/// Cells that name the track: sequence and run.
fn track(trace: &Trace) -> [String; 2] {
    [trace.track.sequence.clone(), trace.track.run.to_string()]
}

/// Threshold of a method on a tracker; `None` if it has none.
fn threshold(results: &Results, of: &Origin) -> Option<f64> {
    let records = &results.manifest.methods;
    let record = records.iter().find(|m| m.name == of.method && m.params == of.params)?;
    record.thresholds.get(&of.tracker).copied()
}

/// Events and detections with their outcomes, and checks of the track by reverse runs.
pub fn moments(results: &Results, explained: &Explained, traces: &[Trace], digits: Digits) -> Listing {
    let threshold = threshold(results, &explained.of);
    let mut rows = Vec::new();
    for (trace, protocol) in traces.iter().filter_map(|trace| Some((trace, explained.protocol?))) {
        for moment in trace::moments(&trace.judge(protocol)) {
            let Moment { event, detection, outcome, .. } = moment;
            let t = detection.unwrap_or(moment.frame());
            let distance = moment.distance().filter(|_| outcome == EventOutcome::Hit);
            let mut row = track(trace).to_vec();
            row.extend([
                frame_number(trace, event),
                event.map_or("", |t| trace.event_word(t)).to_string(),
                frame_number(trace, detection),
                detection.map_or("", |t| trace.detection_word(t)).to_string(),
                distance.map_or_else(String::new, |d| format!("{d:+}")),
                outcome.words().to_string(),
                number(digits, trace.method.compared().get(t).copied()),
                number(digits, threshold),
                note(trace, &moment),
            ]);
            rows.push(row);
        }
        for check in &trace.method.checks {
            let error = check.error.map_or("not run".to_string(), |e| format!("error {e:.4}"));
            let end = if check.accepted { "successful again" } else { "not successful" };
            let note = format!("run backwards to {}: {error}, {end}", check.reference);
            let frame = check.frame.to_string();
            let cells = ["", "", &frame, "", "", "check", "", "", &note].map(String::from);
            rows.push(track(trace).into_iter().chain(cells).collect());
        }
    }
    let columns = "sequence,run,event,what,detection,says,distance,outcome,score,threshold,note";
    Listing::new(&explained.of, columns, rows)
}

/// Reason why an event or a detection has no partner; empty if it has one.
fn note(trace: &Trace, moment: &Moment) -> String {
    let (this, other) = match moment.outcome {
        EventOutcome::Hit => return String::new(),
        EventOutcome::Missed => ("event", "detection"),
        EventOutcome::FalseAlarm => ("detection", "event"),
    };
    let Some(((near, partner), distance)) = moment.nearest.zip(moment.distance()) else {
        return format!("there is no {other} in this run");
    };
    // The distance is from the event to the detection; the note gives it from the frame of this row.
    let (word, offset) = match moment.outcome {
        EventOutcome::Missed => (trace.detection_word(near), distance),
        _ => (trace.event_word(near), -distance),
    };
    let frame = |t: usize| frame_number(trace, Some(t));
    let taken = partner.map_or_else(String::new, |t| format!(", which goes with the {this} in {}", frame(t)));
    format!("nearest {other}: {} ({word}, {offset:+}){taken}", frame(near))
}

/// Stretches of frames that count the same, for protocols that count all frames.
pub fn stretches(explained: &Explained, traces: &[Trace], frame: fn(f64, bool) -> Option<Place>) -> Listing {
    let row = |(trace, (run, (lost, alarm, counts))): (&Trace, (Range<usize>, Alike))| {
        let state = match lost {
            None => "not annotated",
            Some(false) => "successful",
            Some(true) => "lost",
        };
        let mut row = track(trace).to_vec();
        row.extend([run.start, run.end - 1].map(|t| frame_number(trace, Some(t))));
        row.push(run.len().to_string());
        let detector = if alarm { "in doubt" } else { "successful" };
        row.extend([state, detector, counts.map_or("", Place::name)].map(String::from));
        row
    };
    let all = traces.iter().flat_map(|trace| trace.stretches(frame).into_iter().map(move |s| (trace, s)));
    let columns = "sequence,run,from,to,frames,track,detector,counts as";
    Listing::new(&explained.of, columns, all.map(row))
}

/// Frames with the numbers `from` to `to`, both included.
pub fn frames(explained: &Explained, traces: &[Trace], (from, to): (i64, i64), digits: Digits) -> Listing {
    let mut rows = Vec::new();
    for trace in traces {
        let Trace { track: of_track, method } = trace;
        let moments = explained.protocol.map_or_else(Vec::new, |p| trace::moments(&trace.judge(p)));
        for (t, frame) in of_track.numbers.iter().enumerate().filter(|(_, n)| (from..=to).contains(*n)) {
            let mut marks: Vec<String> = Vec::new();
            for m in &moments {
                let end = match m.outcome {
                    EventOutcome::Hit => String::new(),
                    outcome => format!(" ({})", outcome.words()),
                };
                let event = (m.event == Some(t)).then(|| format!("event: {}{end}", trace.event_word(t)));
                marks.extend(event);
                let word = trace.detection_word(t);
                marks.extend((m.detection == Some(t)).then(|| format!("detection: {word}{end}")));
            }
            let rect = of_track.rects[t];
            let mut row = track(trace).to_vec();
            row.push(frame.to_string());
            let numbers = [rect.x, rect.y, rect.w, rect.h, of_track.error[t], method.score[t]];
            row.extend(numbers.map(|v| number(digits, Some(v))));
            row.extend([i32::from(method.alarm[t]), method.changes[t]].map(|n| n.to_string()));
            row.push(number(digits, method.condition.get(t).copied()));
            row.push(marks.join("; "));
            rows.push(row);
        }
    }
    let columns = "sequence,run,frame,x,y,w,h,error,score,label,change,condition,mark";
    Listing::new(&explained.of, columns, rows)
}
