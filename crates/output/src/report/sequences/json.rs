//! The series of strips and viewer as JSON that is safe inside a page.
//!
//! Numbers are integers: boxes in tenths of a pixel, O_t in thousandths, scores in powers of ten that keep
//! four digits of the threshold (or of the largest score). Each column holds differences to the value before,
//! `null` for a missing value. An O_t below 1 is never rounded to 1, because 1 means that the target is lost.
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

use super::{Method, Sequence, Sequences, Track};
use crate::report::trace::{self, DETECTION_WORDS, EVENT_WORDS, EventOutcome, Moment};
use crate::results::detections::{JudgedMethod, TargetState};
use crate::results::{MethodSeries, TrackSeries, in_parts};
use rayon::prelude::*;
use serde::Serialize;
use serde_json::json;
use std::collections::BTreeMap;
use std::ops::Range;
use trackfail_core::region::{Rect, Region};
use trackfail_dataset::text::visible;
use trackfail_methods::score::frames::truth::runs;
use trackfail_methods::score::{Counts, TrackScore};

/// Words for both ends of a loss, if there is no ground truth.
const STATE_WORDS: [&str; 2] = ["lost", "loss over"];

/// Largest file of series, in bytes. Only a single longer track exceeds it.
const MAX_FILE: usize = 2 << 20;

/// Rectangle of a frame without a box.
pub const NOWHERE: Rect = Rect { x: f64::NAN, y: f64::NAN, w: f64::NAN, h: f64::NAN };

/// Column of differences between neighboring values.
type Column = Vec<Option<i64>>;

/// A track in the format that the script of the page reads.
#[derive(Serialize)]
struct Packed {
    #[serde(rename = "box")]
    rects: Vec<Column>,
    error: Column,
    said: BTreeMap<usize, Said>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    background: Vec<Column>,
}

/// Results of a method on a track, with the counts of its protocol.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
pub struct Said {
    marks: Vec<(Option<usize>, Option<usize>, u8, u8)>,
    alarms: Vec<usize>,
    digits: i32,
    score: Column,
    /// First and last frame of each run of frames that the method calls lost, one after the other.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub lost: Vec<usize>,
    /// First and last frame of each run of frames without a box, one after the other.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub absent: Vec<usize>,
    #[serde(skip)]
    counts: Counts,
    /// Number of events; without ground truth, of losses.
    #[serde(skip)]
    events: usize,
}

impl Said {
    /// Series of a method on a track, with the result of its protocol. Scores are the values that are compared
    /// with `threshold`.
    pub fn new(
        track: &TrackSeries,
        method: &MethodSeries,
        judged: &TrackScore,
        threshold: Option<f64>,
    ) -> Self {
        let mark = |moment: Moment| {
            let found = moment.event.is_some_and(|t| trace::is_recovery(&track.error, t));
            let clear = moment.detection.is_some_and(|t| trace::is_all_clear(&method.changes, t));
            (moment.event, moment.detection, u8::from(found), u8::from(clear))
        };
        Self {
            marks: trace::moments(judged).into_iter().map(mark).collect(),
            counts: judged.counts,
            events: judged.events.len(),
            ..Self::of_series(method.compared(), &method.alarm, threshold)
        }
    }

    /// Series of a method on a track without ground truth, with the runs of frames in which the target is
    /// lost or absent.
    pub fn of_states(method: &JudgedMethod) -> Self {
        let absent = method.stretches().filter(|(state, _)| *state == TargetState::Absent);
        let absent: Vec<Range<usize>> = absent.map(|(_, run)| run).collect();
        let lost = method.losses();
        let marks = |run: &Range<usize>| {
            let is_over = method.states.get(run.end) == Some(&TargetState::Tracking);
            [Some((None, Some(run.start), 0, 0)), is_over.then_some((None, Some(run.end), 0, 1))]
        };
        let compared = method.alarm_score.as_ref().unwrap_or(&method.score);
        let score: Vec<f64> = compared.iter().map(|score| score.unwrap_or(f64::NAN)).collect();
        Self {
            marks: lost.iter().flat_map(marks).flatten().collect(),
            lost: ends(&lost),
            absent: ends(&absent),
            events: lost.len(),
            ..Self::of_series(&score, &method.label, method.threshold)
        }
    }

    fn of_series(score: &[f64], alarm: &[bool], threshold: Option<f64>) -> Self {
        // Four digits of the threshold, or of the largest score where there is none.
        let largest = score.iter().filter(|v| v.is_finite()).fold(0.0, |a: f64, v| a.max(v.abs()));
        let typical = threshold.map(f64::abs).filter(|t| *t > 0.0 && *t < largest).unwrap_or(largest);
        let digits = if typical > 0.0 { (3 - typical.log10().floor() as i32).clamp(-300, 300) } else { 0 };
        let score = differences(score.iter().map(|v| whole(v * 10_f64.powi(digits))));
        Self { alarms: ends(&runs(alarm)), digits, score, ..Self::default() }
    }
}

impl Track {
    /// Packs a track with its background regions (or none) and the results of each method.
    pub fn new(
        [sequence, tracker]: [usize; 2],
        track: &TrackSeries,
        background: &[Rect],
        said: BTreeMap<usize, Said>,
    ) -> Self {
        let counts = said.iter().map(|(k, said)| (*k, said.counts, said.events)).collect();
        // An error below 1 stays below 1.
        let thousandths = |error: &f64| {
            let rounded = whole(error * 1000.0)?;
            Some(if *error < 1.0 { rounded.min(999) } else { rounded })
        };
        let packed = Packed {
            rects: boxes(&track.rects),
            error: differences(track.error.iter().map(thousandths)),
            said,
            background: if background.is_empty() { Vec::new() } else { boxes(background) },
        };
        Self { sequence, tracker, frames: track.error.len(), counts, series: text(&packed) }
    }
}

/// Packs all series into the page; `None` if that takes more than `most` bytes.
pub fn embedded(all: &Sequences, most: usize) -> Option<String> {
    if all.tracks.iter().map(|track| track.series.len()).sum::<usize>() > most {
        return None;
    }
    let truths: Vec<String> = all.sequences.iter().map(truth).collect();
    let parts = parts(truths.iter().enumerate(), all.tracks.iter());
    Some(index(all, &vec![None; all.tracks.len()], &[], &parts)).filter(|index| index.len() <= most)
}

/// Packs only names into the page, and series into files beside it, as many sequences of a tracker per file
/// as fit. `keep` receives name and text of each file. Returns the JSON for the page, and the number of
/// files.
///
/// # Errors
/// Errors of `keep`.
pub fn beside<E>(
    all: &Sequences,
    mut keep: impl FnMut(&str, &str) -> Result<(), E>,
) -> Result<(String, usize), E> {
    let truths: Vec<String> = all.sequences.par_iter().map(truth).collect();
    let mut places: Vec<Option<usize>> = vec![None; all.tracks.len()];
    let mut files: Vec<String> = Vec::new();
    for tracker in 0..all.trackers.len() {
        let mine: Vec<(usize, &Track)> =
            all.tracks.iter().enumerate().filter(|(_, track)| track.tracker == tracker).collect();
        let parted = in_parts(&mine, MAX_FILE, |_, (_, t)| truths[t.sequence].len() + t.series.len());
        for (part, tracks) in parted.into_iter().filter(|tracks| !tracks.is_empty()).enumerate() {
            tracks.iter().for_each(|(place, _)| places[*place] = Some(files.len()));
            let truths = tracks.iter().map(|(_, track)| (track.sequence, &truths[track.sequence]));
            let text = format!("trackfail({});\n", parts(truths, tracks.iter().map(|(_, track)| *track)));
            files.push(format!("data/{tracker:02}-{part:03}.js"));
            keep(&files[files.len() - 1], &text)?;
        }
    }
    Ok((index(all, &places, &files, "{\"truth\":{},\"data\":{}}"), files.len()))
}

/// JSON object with the ground truth of some sequences and the series of some tracks.
fn parts<'a>(
    truths: impl Iterator<Item = (usize, &'a String)>,
    tracks: impl Iterator<Item = &'a Track>,
) -> String {
    let truths: Vec<String> = truths.map(|(sequence, json)| format!("\"{sequence}\":{json}")).collect();
    let series = |t: &Track| format!("\"{}-{}\":{}", t.sequence, t.tracker, t.series);
    let series: Vec<String> = tracks.map(series).collect();
    format!("{{\"truth\":{{{}}},\"data\":{{{}}}}}", truths.join(","), series.join(","))
}

/// Serializes a value as JSON, which cannot fail for these types.
fn text(value: &impl Serialize) -> String {
    serde_json::to_string(value).unwrap_or_default()
}

fn index(all: &Sequences, places: &[Option<usize>], files: &[String], parts: &str) -> String {
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
    let track = |(track, place): (&Track, &Option<usize>)| json!([track.sequence, track.tracker, place]);
    let names = json!({
        "unannotated": all.unannotated,
        "trackers": all.trackers.iter().map(|name| visible(name)).collect::<Vec<_>>(),
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
    // Both are objects: the second one's members follow the first one's.
    let names = names.to_string();
    in_a_page(&format!("{},{}", &names[..names.len() - 1], &parts[1..]))
}

/// JSON that is safe in a script element. Characters that could close the element, start a comment or end a
/// line are escaped. They occur only in strings, where JSON allows escapes.
pub fn in_a_page(json: &str) -> String {
    let escaped = |text: String, c: char| text.replace(c, &format!("\\u{:04x}", u32::from(c)));
    ['<', '>', '&', '\u{2028}', '\u{2029}'].into_iter().fold(json.to_string(), escaped)
}

/// Ground truth in four columns if all regions are upright, else in eight columns of corners.
fn truth(sequence: &Sequence) -> String {
    let rect = |region: &Option<Region>| region.as_ref().map_or(NOWHERE, Region::rect);
    if sequence.truth.iter().flatten().all(is_upright) {
        return text(&boxes(&sequence.truth.iter().map(rect).collect::<Vec<_>>()));
    }
    let corners = |region: &Option<Region>| {
        let corners = region.as_ref().map(Region::corners).unwrap_or_default();
        corners.try_into().unwrap_or_else(|_| rect(region).corners())
    };
    let corners: Vec<[(f64, f64); 4]> = sequence.truth.iter().map(corners).collect();
    let x = |k: usize| differences(corners.iter().map(|corners| tenths(corners[k].0)));
    let y = |k: usize| differences(corners.iter().map(|corners| tenths(corners[k].1)));
    text(&[x(0), y(0), x(1), y(1), x(2), y(2), x(3), y(3)])
}

/// True if the corners are those of the bounding rectangle, at the precision shown.
fn is_upright(region: &Region) -> bool {
    let shown = |p: &(f64, f64)| (tenths(p.0), tenths(p.1));
    region.corners().iter().map(shown).eq(region.rect().corners().iter().map(shown))
}

fn boxes(rects: &[Rect]) -> Vec<Column> {
    let sides: [fn(&Rect) -> f64; 4] = [|r| r.x, |r| r.y, |r| r.w, |r| r.h];
    sides.iter().map(|side| differences(rects.iter().map(|rect| tenths(side(rect))))).collect()
}

/// First and last index of each run, one after the other.
fn ends(runs: &[Range<usize>]) -> Vec<usize> {
    runs.iter().flat_map(|run| [run.start, run.end - 1]).collect()
}

fn tenths(v: f64) -> Option<i64> {
    whole(v * 10.0)
}

/// Nearest integer that JavaScript represents exactly; `None` for NaN and infinity.
fn whole(v: f64) -> Option<i64> {
    const LARGEST: f64 = 1e15;
    v.is_finite().then(|| v.round().clamp(-LARGEST, LARGEST) as i64)
}

/// Difference of each value to the one before.
fn differences(values: impl Iterator<Item = Option<i64>>) -> Column {
    let mut last = 0;
    values.map(|value| value.map(|v| v - std::mem::replace(&mut last, v))).collect()
}
