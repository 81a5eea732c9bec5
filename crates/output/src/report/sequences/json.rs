//! The series of strips and viewer as JSON that is safe inside a page.
//!
//! Numbers are integers: boxes in tenths of a pixel, O_t in thousandths, scores in steps of a power of ten that keeps
//! four digits of the threshold (or of the largest score); each column holds differences to the value before, `null`
//! where there is none. An O_t below 1 stays below 1, because 1 means that the target is lost.
//!
//! ```text
//! index  {trackers, methods, sequences, start, tracks: [[sequence, tracker, file]], files, words, truth, data}
//! truth  {"<sequence>": [4 columns x, y, w, h, or 8 columns of corners]}
//! data   {"<sequence>-<tracker>": {box: [4 columns], background: [4 columns], error, said: {"<method>":
//!         {marks: [[event, detection, word, word]], alarms: [first, last, ...], digits, score}}}}
//! ```
//!
//! Without ground truth (`unannotated`) a method also has the runs of frames `lost` and `absent`, and its marks are the
//! frames in which a loss begins and ends. Pictures are in the page itself there.
//!
//! A mark is a [moment](crate::report::trace::Moment): an event, a detection, or both that match, in order of time, each
//! with its word as an index into the page's words.
//!
//! `truth` and `data` are in the index, or, where that would be too long, in files of their own, each with one call of
//! `trackfail({truth, data})`.

use super::{JudgedSeries, Method, PackedTrack, Sequence, Sequences, Track};
use crate::figure::spans_where;
use crate::report::trace::{self, DETECTION_WORDS, EVENT_WORDS, EventOutcome};
use rayon::prelude::*;
use serde_json::{Value, json};
use std::collections::BTreeMap;
use std::fmt::Write;
use std::ops::Range;
use trackfail_core::region::{Rect, Region};
use trackfail_dataset::text::visible;

/// Words of the ends of a loss, where there is no ground truth.
const STATE_WORDS: [&str; 2] = ["lost", "loss over"];

/// Maximum size of a file of series in bytes, which only a single longer track exceeds.
const MAX_FILE: usize = 2 << 20;

/// Packs all series into the page; `None` where that takes more than `most` bytes.
pub fn embedded(all: &Sequences<PackedTrack>, most: usize) -> Option<String> {
    let places: Vec<Option<usize>> = vec![None; all.tracks.len()];
    let mut left = most;
    let mut fits = |text: &str| {
        left = left.checked_sub(text.len())?;
        Some(())
    };
    all.tracks.iter().try_for_each(|track| fits(&track.series))?;
    let mut truths = Vec::new();
    for (s, sequence) in all.sequences.iter().enumerate() {
        let truth = truth(sequence);
        fits(&truth)?;
        truths.push((s, truth));
    }
    let series = object(all.tracks.iter().map(|track| (key(track), &track.series)));
    let index = index(all, &places, &[], &object(truths), &series);
    (index.len() <= most).then_some(index)
}

/// Packs only names into the page, and series into files beside it, as many sequences of a tracker per file as fit;
/// `keep` is given the name and the text of each. Returns the JSON in the page, and the number of files.
///
/// # Errors
/// Those of `keep`.
pub fn beside<E>(
    all: &Sequences<PackedTrack>,
    mut keep: impl FnMut(&str, &str) -> Result<(), E>,
) -> Result<(String, usize), E> {
    let mut places: Vec<Option<usize>> = vec![None; all.tracks.len()];
    let mut names: Vec<String> = Vec::new();
    let truths: Vec<String> = all.sequences.par_iter().map(truth).collect();
    for tracker in 0..all.trackers.len() {
        let mine = all.tracks.iter().enumerate().filter(|(_, t)| t.tracker == tracker);
        let (mut of_file, mut size): (Vec<&PackedTrack>, usize) = (Vec::new(), 0);
        let mut part = 0;
        let mut finish = |of_file: &mut Vec<&PackedTrack>| {
            if !of_file.is_empty() {
                let truth = object(of_file.iter().map(|t| (t.sequence, &truths[t.sequence])));
                let series = object(of_file.drain(..).map(|t| (key(t), &t.series)));
                let text = json_of_parts(&truth, &series);
                let name = format!("data/{tracker:02}-{part:03}.js");
                keep(&name, &format!("trackfail({text});\n"))?;
                names.push(name);
                part += 1;
            }
            Ok(names.len())
        };
        let mut next = finish(&mut of_file)?;
        for (k, t) in mine {
            let more = truths[t.sequence].len() + t.series.len();
            size += more;
            if size > MAX_FILE {
                next = finish(&mut of_file)?;
                size = more;
            }
            places[k] = Some(next);
            of_file.push(t);
        }
        finish(&mut of_file)?;
    }
    let names: Vec<&str> = names.iter().map(String::as_str).collect();
    Ok((index(all, &places, &names, "{}", "{}"), names.len()))
}

fn key(track: &PackedTrack) -> String {
    format!("{}-{}", track.sequence, track.tracker)
}

fn json_of_parts(truth: &str, data: &str) -> String {
    format!("{{\"truth\":{truth},\"data\":{data}}}")
}

/// A JSON object of values that are JSON already, under keys that need no escapes.
fn object<K: std::fmt::Display, T: AsRef<str>>(parts: impl IntoIterator<Item = (K, T)>) -> String {
    let mut out = String::from("{");
    for (k, (key, json)) in parts.into_iter().enumerate() {
        // Writing to a string cannot fail.
        let _ = write!(out, "{}\"{key}\":", if k > 0 { "," } else { "" });
        out.push_str(json.as_ref());
    }
    out.push('}');
    out
}

fn index(
    all: &Sequences<PackedTrack>,
    places: &[Option<usize>],
    files: &[&str],
    truth: &str,
    data: &str,
) -> String {
    let shown = |names: Vec<&str>| -> Vec<String> { names.into_iter().map(visible).collect() };
    let method =
        |m: &Method| json!({"name": visible(&m.name), "thresholds": m.thresholds, "counted": m.counted});
    let sequence = |s: &Sequence| {
        json!({
            "name": visible(&s.name),
            "first": s.first,
            "frames": s.truth.len(),
            "size": s.size,
            "stills": s.stills,
            "pictures": s.pictures,
            "attributes": visible(&s.attributes.join(", ")),
        })
    };
    let track = |(t, place): (&PackedTrack, &Option<usize>)| json!([t.sequence, t.tracker, place]);
    let names = json!({
        "unannotated": all.unannotated,
        "trackers": shown(all.trackers.iter().map(String::as_str).collect()),
        "methods": all.methods.iter().map(method).collect::<Vec<_>>(),
        "sequences": all.sequences.iter().map(sequence).collect::<Vec<_>>(),
        "start": all.start(),
        "tracks": all.tracks.iter().zip(places).map(track).collect::<Vec<_>>(),
        "files": files,
        "words": {
            "event": EVENT_WORDS,
            "detection": if all.unannotated { STATE_WORDS } else { DETECTION_WORDS },
            "outcome": EventOutcome::ALL.map(EventOutcome::words),
        },
    });
    let parts = json_of_parts(truth, data);
    let names = names.to_string();
    // Both are objects: the second one's members follow the first one's.
    let (names, parts) = (names.strip_suffix('}'), parts.strip_prefix('{'));
    in_a_page(&format!("{},{}", names.unwrap_or_default(), parts.unwrap_or_default()))
}

/// JSON that is safe in a script element: characters that could end it, begin a comment or end a line are escaped, which
/// JSON allows because they can only be in strings.
pub fn in_a_page(json: &str) -> String {
    let mut out = String::with_capacity(json.len());
    for c in json.chars() {
        match c {
            '<' | '>' | '&' | '\u{2028}' | '\u{2029}' => out.push_str(&format!("\\u{:04x}", c as u32)),
            c => out.push(c),
        }
    }
    out
}

fn truth(sequence: &Sequence) -> String {
    let rects = sequence.truth.iter().flatten().all(is_upright);
    let column = |number: &dyn Fn(&Region) -> f64| {
        differences(sequence.truth.iter().map(|r| r.as_ref().and_then(|r| tenths(number(r)))))
    };
    let columns: Vec<String> = if rects {
        let sides: [fn(&Rect) -> f64; 4] = [|r| r.x, |r| r.y, |r| r.w, |r| r.h];
        sides.iter().map(|side| column(&|r| side(&r.rect()))).collect()
    } else {
        let corner = |k: usize| {
            column(&|r: &Region| {
                let corners = match r.corners() {
                    four if four.len() == 4 => four,
                    _ => r.rect().corners().to_vec(),
                };
                corners.get(k / 2).map_or(f64::NAN, |p| if k.is_multiple_of(2) { p.0 } else { p.1 })
            })
        };
        (0..8).map(corner).collect()
    };
    format!("[{}]", columns.join(","))
}

/// Whether the corners are those of its rectangle, to the precision that is shown.
fn is_upright(region: &Region) -> bool {
    let shown = |p: &(f64, f64)| (tenths(p.0), tenths(p.1));
    region.corners().iter().map(shown).eq(region.rect().corners().iter().map(shown))
}

fn boxes(rects: &[Rect]) -> String {
    let sides: [fn(&Rect) -> f64; 4] = [|r| r.x, |r| r.y, |r| r.w, |r| r.h];
    let columns = sides.map(|side| differences(rects.iter().map(|r| tenths(side(r)))));
    format!("[{}]", columns.join(","))
}

/// Packs a track, with the series of the methods.
pub fn pack(methods: &[Method], track: &Track) -> PackedTrack {
    let error = differences(track.error.iter().map(|e| thousandths(*e)));
    let threshold = |k: usize| methods.get(k).and_then(|m| m.thresholds.get(track.tracker).copied()?);
    let said = track.methods.iter().map(|(k, s)| (*k, series(track, s, threshold(*k))));
    let said = object(said.collect::<BTreeMap<_, _>>());
    let mut parts = vec![("box", boxes(&track.rects)), ("error", error), ("said", said)];
    if !track.background.is_empty() {
        parts.push(("background", boxes(&track.background)));
    }
    PackedTrack {
        sequence: track.sequence,
        tracker: track.tracker,
        frames: track.error.len(),
        counts: track
            .methods
            .iter()
            .map(|(k, s)| (*k, s.judged.counts, s.judged.events.len() + s.lost.len()))
            .collect(),
        series: object(parts),
    }
}

fn series(track: &Track, series: &JudgedSeries, threshold: Option<f64>) -> String {
    let digits = digits(&series.score, threshold);
    let step = |v: &f64| whole(v * 10_f64.powi(digits));
    let marks: Vec<Value> = trace::moments(&series.judged)
        .iter()
        .map(|m| {
            let found = m.event.is_some_and(|t| trace::is_recovery(&track.error, t));
            let clear = m.detection.is_some_and(|t| trace::is_all_clear(&series.changes, t));
            json!([m.event, m.detection, u8::from(found), u8::from(clear)])
        })
        .collect();
    let text = |value: Value| value.to_string();
    let mut parts = vec![
        ("marks", text(json!(marks))),
        ("alarms", text(ends(&spans_where(&series.alarm)))),
        ("digits", digits.to_string()),
        ("score", differences(series.score.iter().map(step))),
    ];
    for (name, runs) in [("lost", &series.lost), ("absent", &series.absent)] {
        if !runs.is_empty() {
            parts.push((name, text(ends(runs))));
        }
    }
    object(parts)
}

/// First and last frame of each run, one after the other.
fn ends(runs: &[Range<usize>]) -> Value {
    json!(runs.iter().flat_map(|run| [run.start, run.end - 1]).collect::<Vec<_>>())
}

/// Decimals that leave four digits of the threshold, or of the largest score where there is none.
fn digits(score: &[f64], threshold: Option<f64>) -> i32 {
    let largest = score.iter().copied().filter(|v| v.is_finite()).fold(0.0, |a: f64, v| a.max(v.abs()));
    let typical = threshold.map(f64::abs).filter(|t| *t > 0.0 && *t < largest).unwrap_or(largest);
    if typical > 0.0 { (3 - typical.log10().floor() as i32).clamp(-300, 300) } else { 0 }
}

fn tenths(v: f64) -> Option<i64> {
    whole(v * 10.0)
}

fn thousandths(error: f64) -> Option<i64> {
    let rounded = whole(error * 1000.0)?;
    Some(if error < 1.0 { rounded.min(999) } else { rounded })
}

/// The nearest integer that JavaScript represents exactly; `None` for NaN and infinity.
fn whole(v: f64) -> Option<i64> {
    const LARGEST: f64 = 1e15;
    v.is_finite().then(|| v.round().clamp(-LARGEST, LARGEST) as i64)
}

fn differences(values: impl Iterator<Item = Option<i64>>) -> String {
    let mut last = 0;
    let mut out = String::from("[");
    for (k, value) in values.enumerate() {
        if k > 0 {
            out.push(',');
        }
        match value {
            Some(v) => {
                out.push_str(itoa::Buffer::new().format(v - last));
                last = v;
            }
            None => out.push_str("null"),
        }
    }
    out.push(']');
    out
}
