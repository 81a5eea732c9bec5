//! The parts of a number as rows of text: sequences, events and detections, stretches, frames.

use super::{Explained, Part};
use crate::report::sequences::counted_by;
use crate::report::trace::{self, EventOutcome, Moment, Trace};
use crate::results::Results;
use crate::results::method_label;
use crate::table::layout::CellRef;
use trackfail_engine::spec::table::Table;
use trackfail_methods::score::counts::Place;

/// How many digits numbers have.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Digits {
    /// Four decimals, for people.
    Four,
    /// All, for programs.
    All,
}

/// Columns at the head of every listing, which name the number: tracker, method, params and metric.
pub const NAMED: usize = 4;

/// Headings and rows.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Listing {
    /// Headings of the columns, [`NAMED`] of which name the number.
    pub headings: Vec<&'static str>,
    /// Rows, a text for each heading.
    pub rows: Vec<Vec<String>>,
}

impl Listing {
    fn new(rest: &[&'static str], rows: Vec<Vec<String>>) -> Self {
        let names = ["tracker", "method", "params", "metric"];
        Self { headings: names.iter().chain(rest).copied().collect(), rows }
    }
}

/// A row that begins with the columns that name the number.
fn named(cell: &CellRef, rest: impl IntoIterator<Item = String>) -> Vec<String> {
    let names = [&cell.tracker, &cell.method, &cell.params].map(Clone::clone);
    names.into_iter().chain([cell.metric.name().to_string()]).chain(rest).collect()
}

/// A number as text; empty where there is none.
fn number(digits: Digits, value: Option<f64>) -> String {
    match (value.filter(|v| v.is_finite()), digits) {
        (None, _) => String::new(),
        (Some(v), Digits::Four) => format!("{v:.4}"),
        (Some(v), Digits::All) => v.to_string(),
    }
}

/// Describes a number in lines: its meaning, its formula, and what it leaves out.
pub fn headline(results: &Results, table: &Table, explained: &Explained) -> String {
    let spot = &explained.spot;
    let method = method_label(&spot.method, &spot.params);
    let value = explained.value.map_or("no value".to_string(), |v| v.to_string());
    let mut text = format!(
        "{}/{}, tracker {}: {} of {method} is {value}\n  {}\n",
        results.experiment.name,
        table.name,
        spot.tracker,
        spot.metric.title(),
        explained.formula,
    );
    if let Some(protocol) = explained.protocol {
        text.push_str(&format!("  {}\n", counted_by(protocol)));
    }
    if let Some(attribute) = &spot.attribute {
        text.push_str(&format!("  only sequences with the attribute {attribute}\n"));
    }
    for p in results.experiment.published.iter().filter(|p| p.table == table.name && p.row == spot.row) {
        for (_, printed) in p.values.iter().filter(|(column, _)| *column == spot.column) {
            text.push_str(&format!("  published for {}: {printed}\n", p.tracker));
        }
    }
    text.push_str(&format!(
        "  from {} sequences; `moves` is how far a sequence moves the number, down to its events with --sequence\n",
        explained.parts.len()
    ));
    for (sequence, run, reason) in &explained.failed {
        text.push_str(&format!("  left out: {sequence}, run {run}: {reason}\n"));
    }
    text
}

/// The sequences of a number, those that move it most first.
pub fn sequences(explained: &Explained, digits: Digits) -> Listing {
    let own = ["sequence", "runs", "tp", "fp", "fn", "tn", "alone", "without", "moves"];
    let row = |p: &Part| {
        let counts =
            [p.runs as u64, p.counts.tp, p.counts.fp, p.counts.fn_, p.counts.tn].map(|n| n.to_string());
        let moves = match (digits, p.moves) {
            (Digits::Four, Some(v)) => format!("{v:+.4}"),
            (digits, v) => number(digits, v),
        };
        let ratios = [number(digits, p.alone), number(digits, p.without), moves];
        named(&explained.spot, [p.sequence.clone()].into_iter().chain(counts).chain(ratios))
    };
    Listing::new(&own, explained.parts.iter().map(row).collect())
}

/// Describes a number on one sequence, in lines.
pub fn sequence_headline(results: &Results, explained: &Explained, sequence: &str) -> String {
    let spot = &explained.spot;
    let mut text = format!(
        "{}, {sequence}: {} on tracker {}\n",
        results.experiment.name,
        method_label(&spot.method, &spot.params),
        spot.tracker
    );
    if let Some(protocol) = explained.protocol {
        text.push_str(&format!("  {}\n", counted_by(protocol)));
    }
    if let Some(part) = explained.parts.iter().find(|p| p.sequence == sequence) {
        let c = part.counts;
        text.push_str(&format!("  TP {}, FP {}, FN {}, TN {}\n", c.tp, c.fp, c.fn_, c.tn));
    }
    text
}

/// The number of a frame, as its sequence counts.
fn frame_number(trace: &Trace, t: usize) -> String {
    trace.numbers.get(t).map_or_else(String::new, i64::to_string)
}

/// The threshold of a method on a tracker, where it has one.
fn threshold(results: &Results, spot: &CellRef) -> Option<f64> {
    let records = &results.manifest.methods;
    let record = records.iter().find(|m| m.name == spot.method && m.params == spot.params)?;
    record.thresholds.get(&spot.tracker).copied()
}

/// Events and detections with what became of them, and checks of the track by reverse runs.
pub fn moments(results: &Results, explained: &Explained, traces: &[Trace], digits: Digits) -> Listing {
    let own = [
        "sequence",
        "run",
        "event",
        "what",
        "detection",
        "says",
        "distance",
        "outcome",
        "score",
        "threshold",
        "note",
    ];
    let mut rows = Vec::new();
    let Some(protocol) = explained.protocol else { return Listing::new(&own, rows) };
    let threshold = threshold(results, &explained.spot);
    for trace in traces {
        for moment in trace::moments(&trace.judge(protocol)) {
            let frame = |t: Option<usize>| t.map_or_else(String::new, |t| frame_number(trace, t));
            let word = |t: Option<usize>, of: &dyn Fn(usize) -> &'static str| t.map_or("", of).to_string();
            let t = moment.detection.unwrap_or(moment.frame());
            let distance = moment.distance().filter(|_| moment.outcome == EventOutcome::Hit);
            rows.push(named(
                &explained.spot,
                [
                    trace.sequence.clone(),
                    trace.run.to_string(),
                    frame(moment.event),
                    word(moment.event, &|t| trace.event_word(t)),
                    frame(moment.detection),
                    word(moment.detection, &|t| trace.detection_word(t)),
                    distance.map_or_else(String::new, |d| format!("{d:+}")),
                    moment.outcome.words().to_string(),
                    number(digits, trace.score.get(t).copied()),
                    number(digits, threshold),
                    note(trace, &moment),
                ],
            ));
        }
        for check in &trace.checks {
            let error = check.error.map_or("not run".to_string(), |e| format!("error {e:.4}"));
            let end = if check.accepted { "successful again" } else { "not successful" };
            let note = format!("run backwards to {}: {error}, {end}", check.reference);
            let mut row = named(&explained.spot, [trace.sequence.clone(), trace.run.to_string()]);
            row.extend(["", ""].map(String::from));
            row.extend([check.frame.to_string(), String::new(), String::new(), "check".to_string()]);
            row.extend([String::new(), String::new(), note]);
            rows.push(row);
        }
    }
    Listing::new(&own, rows)
}

/// Why an event or a detection has no partner.
fn note(trace: &Trace, moment: &Moment) -> String {
    let of_event = match moment.outcome {
        EventOutcome::Hit => return String::new(),
        EventOutcome::Missed => true,
        EventOutcome::FalseAlarm => false,
    };
    let other = if of_event { "detection" } else { "event" };
    let Some(((near, partner), distance)) = moment.nearest.zip(moment.distance()) else {
        return format!("there is no {other} in this run");
    };
    let word = if of_event { trace.detection_word(near) } else { trace.event_word(near) };
    // The distance is from the event to the detection; the note gives it from the frame of this row.
    let offset = if of_event { distance } else { -distance };
    let place = frame_number(trace, near);
    let taken = partner.map_or_else(String::new, |t| {
        format!(
            ", which goes with the {} in {}",
            if of_event { "event" } else { "detection" },
            frame_number(trace, t)
        )
    });
    format!("nearest {other}: {place} ({word}, {offset:+}){taken}")
}

/// Stretches of frames that count alike, for protocols that count every frame.
pub fn stretches(explained: &Explained, traces: &[Trace], frame: fn(f64, bool) -> Option<Place>) -> Listing {
    let own = ["sequence", "run", "from", "to", "frames", "track", "detector", "counts as"];
    let row = |(trace, s): (&Trace, trace::Stretch)| {
        let track = match s.lost {
            None => "not annotated",
            Some(false) => "successful",
            Some(true) => "lost",
        };
        let detector = if s.alarm { "in doubt" } else { "successful" };
        named(
            &explained.spot,
            [
                trace.sequence.clone(),
                trace.run.to_string(),
                frame_number(trace, s.from),
                frame_number(trace, s.to),
                (s.to - s.from + 1).to_string(),
                track.to_string(),
                detector.to_string(),
                s.counts.map_or("", Place::name).to_string(),
            ],
        )
    };
    let all = traces.iter().flat_map(|trace| trace.stretches(frame).into_iter().map(move |s| (trace, s)));
    Listing::new(&own, all.map(row).collect())
}

/// The frames with these numbers, the first and the last included.
pub fn frames(explained: &Explained, traces: &[Trace], (from, to): (i64, i64), digits: Digits) -> Listing {
    let own = [
        "sequence",
        "run",
        "frame",
        "x",
        "y",
        "w",
        "h",
        "error",
        "score",
        "label",
        "change",
        "condition",
        "mark",
    ];
    let mut rows = Vec::new();
    for trace in traces {
        let moments = explained.protocol.map_or_else(Vec::new, |p| trace::moments(&trace.judge(p)));
        for (t, frame) in trace.numbers.iter().enumerate().filter(|(_, n)| (from..=to).contains(*n)) {
            let mut marks: Vec<String> = Vec::new();
            for m in &moments {
                let end = match m.outcome {
                    EventOutcome::Hit => String::new(),
                    outcome => format!(" ({})", outcome.words()),
                };
                if m.event == Some(t) {
                    marks.push(format!("event: {}{end}", trace.event_word(t)));
                }
                if m.detection == Some(t) {
                    marks.push(format!("detection: {}{end}", trace.detection_word(t)));
                }
            }
            let rect = trace.rects[t];
            let mut row =
                named(&explained.spot, [trace.sequence.clone(), trace.run.to_string(), frame.to_string()]);
            let numbers = [rect.x, rect.y, rect.w, rect.h, trace.error[t], trace.score[t]];
            row.extend(numbers.map(|v| number(digits, Some(v))));
            row.extend([i32::from(trace.alarm[t]).to_string(), trace.changes[t].to_string()]);
            row.push(number(digits, trace.condition.get(t).copied()));
            row.push(marks.join("; "));
            rows.push(row);
        }
    }
    Listing::new(&own, rows)
}
