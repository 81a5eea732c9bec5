//! `trackfail explain TABLE ROW COLUMN`

use super::output::{self, Format};
use super::{Failure, report};
use crate::plugin;
use crate::report::explain::{self, Explained};
use crate::report::results::Results;
use crate::report::trace::{self, Moment, Outcome, Trace, frame_range};
use crate::score::measures::Counts;
use crate::score::segmentation;
use crate::spec::table::Table;
use crate::table::layout::{self, Spot};
use crate::table::measures;
use crate::table::records::{CellScore, method_label};
use std::path::PathBuf;

/// Arguments of `explain`.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// A table of an experiment that has results: `quickstart/table1`, or its name alone where only one has it
    #[arg(value_name = "TABLE")]
    table: String,
    /// A row of it
    #[arg(value_name = "ROW")]
    row: String,
    /// A column of it
    #[arg(value_name = "COLUMN")]
    column: String,
    /// Only this tracker, where the table has several
    #[arg(long, value_name = "LABEL")]
    tracker: Option<String>,
    /// Only this method (`DTEF`, `AVU[length=20]`), where neither rows nor columns are methods
    #[arg(long, value_name = "NAME")]
    method: Option<String>,
    /// Go down to the events and detections of this sequence
    #[arg(long, value_name = "NAME")]
    sequence: Option<String>,
    /// Go down to these frames of the sequence: `40-60`
    #[arg(long, value_name = "FROM-TO", requires = "sequence", value_parser = frame_range)]
    frames: Option<(i64, i64)>,
    /// Folder that results are read from
    #[arg(long, value_name = "DIR", default_value = "results")]
    results: PathBuf,
    /// How to print it
    #[arg(long, value_enum, default_value_t)]
    format: Format,
}

/// Runs the verb.
///
/// # Errors
/// See [`Failure`].
pub fn run(args: &Args) -> Result<(), Failure> {
    let (results, table) = find_table(args)?;
    let table = &results.experiment.tables[table];
    let io = |e: &dyn std::fmt::Display| Failure::Io(format!("{}: {e}", results.experiment.name));
    let scores = results.scores().map_err(|e| io(&e))?;
    let spots = find_spots(args, &results, &scores, table)?;
    let mut listed = Listed::default();
    for spot in &spots {
        let explained = explain::explain(&results, &scores, spot).map_err(|e| io(&e))?;
        let Some(sequence) = &args.sequence else {
            listed.block(
                args.format,
                &heading(&results, table, &explained),
                of_sequences(args, &explained),
            )?;
            continue;
        };
        check_sequence(&explained, sequence)?;
        let label = method_label(&spot.method, &spot.params);
        let traces = trace::read(&results, &spot.tracker, &label, Some(sequence)).map_err(|e| io(&e))?;
        check_counts(&explained, sequence, &traces).map_err(|e| io(&e))?;
        let about = about_sequence(&results, &explained, sequence);
        let rows = match args.frames {
            Some(range) => of_frames(args, &explained, &traces, range),
            None if explained.protocol.is_some_and(|p| p.name == segmentation::PROTOCOL.name) => {
                of_stretches(&explained, &traces)
            }
            None => of_moments(args, &results, &explained, &traces),
        };
        listed.block(args.format, &about, rows)?;
    }
    listed.print(args)
}

/// Headings and rows.
type Rows = (Vec<&'static str>, Vec<Vec<String>>);

/// What is printed: blocks for people, one table for programs.
#[derive(Default)]
struct Listed {
    text: String,
    headings: Vec<&'static str>,
    rows: Vec<Vec<String>>,
}

impl Listed {
    fn block(&mut self, format: Format, about: &str, (headings, rows): Rows) -> Result<(), Failure> {
        if format == Format::Table {
            // Who it is about is said above the table.
            let own = |row: &Vec<String>| row[NAMED..].to_vec();
            let rows: Vec<Vec<String>> = rows.iter().map(own).collect();
            let gap = if self.text.is_empty() { "" } else { "\n" };
            let table = output::text(format, &headings[NAMED..], &rows)?;
            self.text.push_str(&format!("{gap}{about}\n{table}"));
        } else {
            self.headings = headings;
            self.rows.extend(rows);
        }
        Ok(())
    }

    fn print(&self, args: &Args) -> Result<(), Failure> {
        match args.format {
            Format::Table => output::write(&self.text),
            format => output::print(format, &self.headings, &self.rows),
        }
    }
}

/// The first columns of every list, which name the number that is explained.
const NAMED: usize = 4;

/// A row behind the columns that name the number.
fn named(spot: &Spot, rest: impl IntoIterator<Item = String>) -> Vec<String> {
    let names = [&spot.tracker, &spot.method, &spot.params].map(Clone::clone);
    names.into_iter().chain([spot.metric.name().to_string()]).chain(rest).collect()
}

fn headings(rest: &[&'static str]) -> Vec<&'static str> {
    ["tracker", "method", "params", "metric"].iter().chain(rest).copied().collect()
}

/// The results and the place of the table among the experiment's.
fn find_table(args: &Args) -> Result<(Results, usize), Failure> {
    let finished = report::finished(&args.results);
    let here = |what: String| Failure::Usage(format!("{}: {what}", args.results.display()));
    if finished.is_empty() {
        return Err(here("no results; run an experiment first".to_string()));
    }
    let read = |name: &str| {
        let results = Results::read(&args.results.join(name));
        results.map_err(|e| Failure::Io(format!("{name}: {e}")))
    };
    let place =
        |results: &Results, table: &str| results.experiment.tables.iter().position(|t| t.name == table);
    if let Some((experiment, table)) = args.table.rsplit_once('/') {
        if !finished.iter().any(|known| known == experiment) {
            let known = finished.iter().map(String::as_str);
            return Err(here(plugin::unknown("finished experiment", experiment, known)));
        }
        let results = read(experiment)?;
        let Some(place) = place(&results, table) else {
            let known = results.experiment.tables.iter().map(|t| t.name.as_str());
            let what = plugin::unknown("table", table, known);
            return Err(Failure::Usage(format!("{experiment}: {what}")));
        };
        return Ok((results, place));
    }
    let mut known: Vec<(String, String)> = Vec::new();
    let mut found = Vec::new();
    for name in &finished {
        let results = read(name)?;
        known.extend(results.experiment.tables.iter().map(|t| (name.clone(), t.name.clone())));
        if let Some(place) = place(&results, &args.table) {
            found.push((results, place));
        }
    }
    if found.len() > 1 {
        let names: Vec<String> =
            found.iter().map(|(r, _)| format!("`{}/{}`", r.experiment.name, args.table)).collect();
        let message =
            format!("several experiments have a table `{}`: write {}", args.table, names.join(" or "));
        return Err(here(message));
    }
    found.pop().ok_or_else(|| here(plugin::unknown("table", &args.table, known.iter().map(|k| k.1.as_str()))))
}

/// The cells of the table that are meant.
fn find_spots(
    args: &Args,
    results: &Results,
    scores: &[CellScore],
    table: &Table,
) -> Result<Vec<Spot>, Failure> {
    let name = format!("{}/{}", results.experiment.name, table.name);
    if let Some(shows) = &table.shows {
        return Err(Failure::Usage(format!(
            "{name} shows `{shows}`, which an analysis made without events and detections; what it found is in {}",
            results.folder.join(crate::table::folder::ANALYSES).display()
        )));
    }
    let parts = measures::by_attribute(scores, &results.manifest.suite.attributes);
    let mut spots =
        layout::spots(&results.experiment, table, &[results.measures.as_slice(), &parts].concat());
    let label = |s: &Spot| method_label(&s.method, &s.params);
    let mut keep =
        |what: &str, wanted: Option<&String>, is: &dyn Fn(&Spot, &str) -> bool, of: fn(&Spot) -> String| {
            let Some(wanted) = wanted else { return Ok(()) };
            let mut known: Vec<String> = Vec::new();
            for spot in &spots {
                if !known.contains(&of(spot)) {
                    known.push(of(spot));
                }
            }
            spots.retain(|s| is(s, wanted));
            if spots.is_empty() {
                let what = plugin::unknown(what, wanted, known.iter().map(String::as_str));
                return Err(Failure::Usage(format!("{name}: {what}")));
            }
            Ok(())
        };
    keep("row", Some(&args.row), &|s, w| s.row == w, |s| s.row.clone())?;
    keep("column", Some(&args.column), &|s, w| s.column == w, |s| s.column.clone())?;
    keep("tracker", args.tracker.as_ref(), &|s, w| s.tracker == w, |s| s.tracker.clone())?;
    let of_method = |s: &Spot| method_label(&s.method, &s.params);
    keep("method", args.method.as_ref(), &|s, w| s.method == w || label(s) == w, of_method)?;
    Ok(spots)
}

fn check_sequence(explained: &Explained, wanted: &str) -> Result<(), Failure> {
    if explained.parts.iter().any(|p| p.sequence == wanted) {
        return Ok(());
    }
    let (tracker, method) = (&explained.spot.tracker, &explained.spot.method);
    if let Some((_, run, reason)) = explained.failed.iter().find(|f| f.0 == wanted) {
        let message = format!("{wanted}: {method} on {tracker}, run {run}, has no result: {reason}");
        return Err(Failure::Usage(message));
    }
    let known = explained.parts.iter().map(|p| p.sequence.as_str());
    Err(Failure::Usage(format!("{method} on {tracker}: {}", plugin::unknown("sequence", wanted, known))))
}

/// Frames and scores were written by one run, and the protocol makes the same counts of them again.
fn check_counts(explained: &Explained, sequence: &str, traces: &[Trace]) -> Result<(), String> {
    let part = explained.parts.iter().find(|p| p.sequence == sequence);
    let (Some(part), Some(protocol)) = (part, explained.protocol) else { return Ok(()) };
    let again: Counts = traces.iter().map(|t| t.judge(protocol).counts).sum();
    if again == part.counts {
        return Ok(());
    }
    Err(format!("{sequence}: frames.parquet gives {again:?}, scores.csv has {:?}; run it again", part.counts))
}

/// A number for people with four decimals, for programs with all digits; empty where there is none.
fn number(format: Format, value: Option<f64>) -> String {
    match (value.filter(|v| v.is_finite()), format) {
        (None, _) => String::new(),
        (Some(v), Format::Table) => format!("{v:.4}"),
        (Some(v), _) => v.to_string(),
    }
}

fn heading(results: &Results, table: &Table, explained: &Explained) -> String {
    let spot = &explained.spot;
    let method = method_label(&spot.method, &spot.params);
    let value = explained.value.map_or("no value".to_string(), |v| v.to_string());
    let mut text = format!(
        "{}/{}, tracker {}: {} of {method} is {value}\n  {}\n",
        results.experiment.name,
        table.name,
        spot.tracker,
        spot.metric.name(),
        explained.formula,
    );
    if let Some(protocol) = explained.protocol {
        text.push_str(&format!("  {}\n", explain::counted_by(protocol)));
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

fn of_sequences(args: &Args, explained: &Explained) -> Rows {
    let own = ["sequence", "runs", "tp", "fp", "fn", "tn", "alone", "without", "moves"];
    let row = |p: &explain::Part| {
        let counts =
            [p.runs as u64, p.counts.tp, p.counts.fp, p.counts.fn_, p.counts.tn].map(|n| n.to_string());
        let moves = match (args.format, p.moves) {
            (Format::Table, Some(v)) => format!("{v:+.4}"),
            (format, v) => number(format, v),
        };
        let ratios = [number(args.format, p.alone), number(args.format, p.without), moves];
        named(&explained.spot, [p.sequence.clone()].into_iter().chain(counts).chain(ratios))
    };
    (headings(&own), explained.parts.iter().map(row).collect())
}

fn about_sequence(results: &Results, explained: &Explained, sequence: &str) -> String {
    let spot = &explained.spot;
    let mut text = format!(
        "{}, {sequence}: {} on tracker {}\n",
        results.experiment.name,
        method_label(&spot.method, &spot.params),
        spot.tracker
    );
    if let Some(protocol) = explained.protocol {
        text.push_str(&format!("  {}\n", explain::counted_by(protocol)));
    }
    if let Some(part) = explained.parts.iter().find(|p| p.sequence == sequence) {
        let c = part.counts;
        text.push_str(&format!("  TP {}, FP {}, FN {}, TN {}\n", c.tp, c.fp, c.fn_, c.tn));
    }
    text
}

/// The number that a sequence gives a frame.
fn frame_number(trace: &Trace, t: usize) -> String {
    trace.numbers.get(t).map_or_else(String::new, i64::to_string)
}

fn threshold(results: &Results, spot: &Spot) -> Option<f64> {
    let records = &results.manifest.methods;
    let record = records.iter().find(|m| m.name == spot.method && m.params == spot.params)?;
    record.thresholds.get(&spot.tracker).copied()
}

fn of_moments(args: &Args, results: &Results, explained: &Explained, traces: &[Trace]) -> Rows {
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
    let Some(protocol) = explained.protocol else { return (headings(&own), rows) };
    let threshold = threshold(results, &explained.spot);
    for trace in traces {
        for moment in trace::moments(&trace.judge(protocol)) {
            let frame = |t: Option<usize>| t.map_or_else(String::new, |t| frame_number(trace, t));
            let word = |t: Option<usize>, of: &dyn Fn(usize) -> &'static str| t.map_or("", of).to_string();
            let t = moment.detection.unwrap_or(moment.frame());
            let distance = moment.distance().filter(|_| moment.outcome == Outcome::Hit);
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
                    number(args.format, trace.score.get(t).copied()),
                    number(args.format, threshold),
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
    (headings(&own), rows)
}

/// Why an event or a detection has no partner.
fn note(trace: &Trace, moment: &Moment) -> String {
    let of_event = match moment.outcome {
        Outcome::Hit => return String::new(),
        Outcome::Missed => true,
        Outcome::FalseAlarm => false,
    };
    let other = if of_event { "detection" } else { "event" };
    let Some(((near, partner), distance)) = moment.nearest.zip(moment.distance()) else {
        return format!("there is no {other} in this run");
    };
    let word = if of_event { trace.detection_word(near) } else { trace.event_word(near) };
    // The distance is from the event to the detection; it is told as seen from the frame of this row.
    let seen = if of_event { distance } else { -distance };
    let place = frame_number(trace, near);
    let taken = partner.map_or_else(String::new, |t| {
        format!(
            ", which goes with the {} in {}",
            if of_event { "event" } else { "detection" },
            frame_number(trace, t)
        )
    });
    format!("nearest {other}: {place} ({word}, {seen:+}){taken}")
}

fn of_stretches(explained: &Explained, traces: &[Trace]) -> Rows {
    let own = ["sequence", "run", "from", "to", "frames", "track", "detector", "counts as"];
    let row = |(trace, s): (&Trace, trace::Stretch)| {
        let (track, counted) = match (s.lost, s.alarm) {
            (None, _) => ("not annotated", ""),
            (Some(false), false) => ("successful", "tp"),
            (Some(true), false) => ("lost", "fp"),
            (Some(false), true) => ("successful", "fn"),
            (Some(true), true) => ("lost", "tn"),
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
                counted.to_string(),
            ],
        )
    };
    let all = traces.iter().flat_map(|trace| trace.stretches().into_iter().map(move |s| (trace, s)));
    (headings(&own), all.map(row).collect())
}

fn of_frames(args: &Args, explained: &Explained, traces: &[Trace], (from, to): (i64, i64)) -> Rows {
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
                    Outcome::Hit => String::new(),
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
            row.extend(numbers.map(|v| number(args.format, Some(v))));
            row.extend([i32::from(trace.alarm[t]).to_string(), trace.changes[t].to_string()]);
            row.push(number(args.format, trace.condition.get(t).copied()));
            row.push(marks.join("; "));
            rows.push(row);
        }
    }
    (headings(&own), rows)
}
