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

use super::{Method, Sequence, Sequences, Track};
use crate::figure::spans_where;
use crate::report::trace::{self, DETECTION_WORDS, EVENT_WORDS, EventOutcome, Moment};
use crate::results::{MethodSeries, TrackSeries};
use rayon::prelude::*;
use serde::Serialize;
use serde_json::json;
use std::collections::BTreeMap;
use std::fmt::Display;
use std::ops::Range;
use trackfail_core::region::{Rect, Region};
use trackfail_dataset::text::visible;
use trackfail_methods::score::{Counts, TrackScore};

/// Words of the ends of a loss, where there is no ground truth.
const STATE_WORDS: [&str; 2] = ["lost", "loss over"];

/// Maximum size of a file of series in bytes, which only a single longer track exceeds.
const MAX_FILE: usize = 2 << 20;

/// The rectangle of a frame without one.
pub const NOWHERE: Rect = Rect { x: f64::NAN, y: f64::NAN, w: f64::NAN, h: f64::NAN };

/// A column of differences.
type Column = Vec<Option<i64>>;

/// A track as the page's script reads it.
#[derive(Serialize)]
struct Packed {
    #[serde(rename = "box")]
    rects: Vec<Column>,
    error: Column,
    said: BTreeMap<usize, Said>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    background: Vec<Column>,
}

/// What a method says of a track, and what its protocol counts there.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
pub struct Said {
    marks: Vec<(Option<usize>, Option<usize>, u8, u8)>,
    alarms: Vec<usize>,
    digits: i32,
    score: Column,
    /// First and last frame of each run of frames in which the method's state is lost, one after the other.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub lost: Vec<usize>,
    /// The same of the runs in which the tracker gives no box.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub absent: Vec<usize>,
    #[serde(skip)]
    counts: Counts,
    /// Number of events, or of losses without ground truth.
    #[serde(skip)]
    events: usize,
}

impl Said {
    /// The series of a method on a track, as its protocol judged them; `threshold` is that of the score.
    pub fn new(
        track: &TrackSeries,
        method: &MethodSeries,
        judged: &TrackScore,
        threshold: Option<f64>,
    ) -> Self {
        let digits = digits(&method.score, threshold);
        let mark = |moment: &Moment| {
            let found = moment.event.is_some_and(|t| trace::is_recovery(&track.error, t));
            let clear = moment.detection.is_some_and(|t| trace::is_all_clear(&method.changes, t));
            (moment.event, moment.detection, u8::from(found), u8::from(clear))
        };
        Self {
            marks: trace::moments(judged).iter().map(mark).collect(),
            alarms: ends(&spans_where(&method.alarm)),
            digits,
            score: differences(method.score.iter().map(|v| whole(v * 10_f64.powi(digits)))),
            counts: judged.counts,
            events: judged.events.len(),
            ..Self::default()
        }
    }

    /// The same with the runs of frames in which the target is lost and absent, where there is no ground truth.
    #[must_use]
    pub fn in_states(self, lost: &[Range<usize>], absent: &[Range<usize>]) -> Self {
        Self { lost: ends(lost), absent: ends(absent), events: lost.len(), ..self }
    }
}

impl Track {
    /// Packs the track of a tracker, with the regions of its background, if there are any, and what each method says of it.
    pub fn new(
        [sequence, tracker]: [usize; 2],
        track: &TrackSeries,
        background: &[Rect],
        said: BTreeMap<usize, Said>,
    ) -> Self {
        let counts = said.iter().map(|(k, said)| (*k, said.counts, said.events)).collect();
        let packed = Packed {
            rects: boxes(&track.rects),
            error: differences(track.error.iter().map(|error| thousandths(*error))),
            said,
            background: if background.is_empty() { Vec::new() } else { boxes(background) },
        };
        Self { sequence, tracker, frames: track.error.len(), counts, series: text(&packed) }
    }

    fn key(&self) -> String {
        format!("{}-{}", self.sequence, self.tracker)
    }
}

/// Packs all series into the page; `None` where that takes more than `most` bytes.
pub fn embedded(all: &Sequences, most: usize) -> Option<String> {
    if all.tracks.iter().map(|track| track.series.len()).sum::<usize>() > most {
        return None;
    }
    let truth = object(all.sequences.iter().map(truth).enumerate());
    let series = object(all.tracks.iter().map(|track| (track.key(), &track.series)));
    let index = index(all, &vec![None; all.tracks.len()], &[], &parts(&truth, &series));
    (index.len() <= most).then_some(index)
}

/// Packs only names into the page, and series into files beside it, as many sequences of a tracker per file as fit;
/// `keep` is given the name and the text of each. Returns the JSON in the page, and the number of files.
///
/// # Errors
/// Those of `keep`.
pub fn beside<E>(
    all: &Sequences,
    mut keep: impl FnMut(&str, &str) -> Result<(), E>,
) -> Result<(String, usize), E> {
    let truths: Vec<String> = all.sequences.par_iter().map(truth).collect();
    let mut places: Vec<Option<usize>> = vec![None; all.tracks.len()];
    let mut files: Vec<(String, Vec<&Track>)> = Vec::new();
    for tracker in 0..all.trackers.len() {
        // Nothing fits into the file of the tracker before.
        let (mut part, mut size) = (0, MAX_FILE);
        for (place, track) in places.iter_mut().zip(&all.tracks).filter(|(_, t)| t.tracker == tracker) {
            let more = truths[track.sequence].len() + track.series.len();
            size += more;
            if size > MAX_FILE {
                files.push((format!("data/{tracker:02}-{part:03}.js"), Vec::new()));
                (part, size) = (part + 1, more);
            }
            *place = files.len().checked_sub(1);
            if let Some((_, tracks)) = files.last_mut() {
                tracks.push(track);
            }
        }
    }
    for (name, tracks) in &files {
        let truth = object(tracks.iter().map(|track| (track.sequence, &truths[track.sequence])));
        let series = object(tracks.iter().map(|track| (track.key(), &track.series)));
        keep(name, &format!("trackfail({});\n", parts(&truth, &series)))?;
    }
    let names: Vec<&str> = files.iter().map(|(name, _)| name.as_str()).collect();
    Ok((index(all, &places, &names, &parts("{}", "{}")), names.len()))
}

fn parts(truth: &str, data: &str) -> String {
    format!("{{\"truth\":{truth},\"data\":{data}}}")
}

/// A JSON object of values that are JSON already, under keys that need no escapes.
fn object<K: Display, V: Display>(parts: impl Iterator<Item = (K, V)>) -> String {
    let parts: Vec<String> = parts.map(|(key, json)| format!("\"{key}\":{json}")).collect();
    format!("{{{}}}", parts.join(","))
}

/// Numbers under names as JSON, which cannot fail.
fn text(value: &impl Serialize) -> String {
    serde_json::to_string(value).unwrap_or_default()
}

fn index(all: &Sequences, places: &[Option<usize>], files: &[&str], parts: &str) -> String {
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
    let names = names.to_string();
    // Both are objects: the second one's members follow the first one's.
    let (names, parts) = (names.strip_suffix('}'), parts.strip_prefix('{'));
    in_a_page(&format!("{},{}", names.unwrap_or_default(), parts.unwrap_or_default()))
}

/// JSON that is safe in a script element: characters that could end it, begin a comment or end a line are escaped, which
/// JSON allows because they can only be in strings.
pub fn in_a_page(json: &str) -> String {
    let escaped = |text: String, c: char| text.replace(c, &format!("\\u{:04x}", u32::from(c)));
    ['<', '>', '&', '\u{2028}', '\u{2029}'].into_iter().fold(json.to_string(), escaped)
}

/// The ground truth: four columns where all regions are upright, else the eight of their corners.
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

/// Whether the corners are those of its rectangle, to the precision that is shown.
fn is_upright(region: &Region) -> bool {
    let shown = |p: &(f64, f64)| (tenths(p.0), tenths(p.1));
    region.corners().iter().map(shown).eq(region.rect().corners().iter().map(shown))
}

fn boxes(rects: &[Rect]) -> Vec<Column> {
    let sides: [fn(&Rect) -> f64; 4] = [|r| r.x, |r| r.y, |r| r.w, |r| r.h];
    sides.iter().map(|side| differences(rects.iter().map(|rect| tenths(side(rect))))).collect()
}

/// First and last frame of each run, one after the other.
fn ends(runs: &[Range<usize>]) -> Vec<usize> {
    runs.iter().flat_map(|run| [run.start, run.end - 1]).collect()
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

/// Each value less the one before.
fn differences(values: impl Iterator<Item = Option<i64>>) -> Column {
    let mut last = 0;
    values.map(|value| value.map(|v| v - std::mem::replace(&mut last, v))).collect()
}
