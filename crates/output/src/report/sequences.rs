//! Results by sequence: series and counts of all methods on each tracker's first run, for the page's table of
//! counts, strips and frame viewer.
//!
//! Counts are recomputed by the method's protocol from the errors and labels in the results. [`json`] packs
//! the series for the page.

pub mod json;

use super::sentences::say;
use crate::results::manifest::MethodRecord;
use crate::results::{Results, ResultsError, TrackSeries, method_label};
use json::Said;
use rayon::prelude::*;
use serde::Serialize;
use std::collections::{BTreeMap, BTreeSet};
use trackfail_core::region::{Rect, Region};
use trackfail_methods::score::{Counts, Protocol};
use trackfail_methods::signal::distribution_field::{self, background_region};

/// Most methods (with their grid points) on a page. If there are more, only the first point of each method is
/// shown.
const MAX_METHODS: usize = 24;

/// All data that are shown by sequence.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Sequences {
    /// Labels of the trackers, in the experiment's order.
    pub trackers: Vec<String>,
    /// Methods with their grid points, in the experiment's order.
    pub methods: Vec<Method>,
    /// Sequences in the suite's order.
    pub sequences: Vec<Sequence>,
    /// Tracks, sorted by sequence, then tracker.
    pub tracks: Vec<Track>,
    /// Sentences about tracks that were left out; may be empty.
    pub note: String,
    /// True if there is no ground truth, so that states are shown instead of errors.
    pub unannotated: bool,
}

/// First run of a tracker on a sequence: its counts, and its series as text. The text takes less than half
/// the memory.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Track {
    /// Index of the sequence.
    pub sequence: usize,
    /// Index of the tracker.
    pub tracker: usize,
    /// Number of frames.
    pub frames: usize,
    /// Index of each method with its counts and its number of events. Without ground truth, the number is
    /// that of the losses that the method finds.
    pub counts: Vec<(usize, Counts, usize)>,
    /// Series in the format of [`json`].
    pub series: String,
}

/// A method as the page shows it.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Method {
    /// Name of the method with its grid point.
    pub name: String,
    /// Threshold on the score for each tracker; `None` if there is none.
    pub thresholds: Vec<Option<f64>>,
    /// Rule of counting by the method's protocol, in one line; may be empty.
    pub counted: String,
}

/// A sequence as the page shows it.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Sequence {
    /// Name of the sequence.
    pub name: String,
    /// Number of the first frame.
    pub first: i64,
    /// Width and height of the frames in pixels; `None` if unknown.
    pub size: Option<(usize, usize)>,
    /// Names of the attributes of the sequence.
    pub attributes: Vec<String>,
    /// Ground truth, one entry per frame.
    pub truth: Vec<Option<Region>>,
    /// Frames (0-based) with a picture `stills/<sequence>-<frame>.png` beside the page.
    pub stills: BTreeSet<usize>,
    /// Pictures embedded in the page, by frame, as `data:...` URLs.
    pub pictures: BTreeMap<usize, String>,
}

/// Rule of counting of a protocol, in one line.
pub fn counted_by(protocol: &Protocol) -> String {
    format!("counted by {}: {}", protocol.name, protocol.summary)
}

/// Data of the tracks that are given, or else of all tracks, without the stills.
///
/// # Errors
/// When the results cannot be read.
pub fn collect(results: &Results, given: Option<Vec<TrackSeries>>) -> Result<Sequences, ResultsError> {
    let (manifest, experiment) = (&results.manifest, &results.experiment);
    let trackers: Vec<String> = manifest.trackers.iter().map(|t| t.label.clone()).collect();
    let mut records: Vec<&MethodRecord> = manifest.methods.iter().collect();
    let all = Some(records.len()).filter(|all| *all > MAX_METHODS);
    let has_runs = manifest.trackers.iter().any(|t| t.runs > 1);
    let note = say("sequences", serde_json::json!({ "has_runs": has_runs, "all": all }));
    if all.is_some() {
        let mut known = BTreeSet::new();
        records.retain(|m| known.insert(m.name.as_str()));
    }
    let method = |record: &&MethodRecord| Method {
        name: method_label(&record.name, &record.params),
        thresholds: trackers.iter().map(|t| record.thresholds.get(t).copied()).collect(),
        counted: experiment.protocol_of(&record.name).map_or_else(String::new, counted_by),
    };
    let methods: Vec<Method> = records.iter().map(method).collect();
    let regions = background_rules(results);
    let pack = |track: &TrackSeries| {
        let tracker = trackers.iter().position(|t| *t == track.tracker)?;
        let rects = &track.rects;
        let background = |rule: &distribution_field::Params| {
            let at = |t| background_region(&rects[..t], &rects[t], rule.history, rule.displacement);
            (0..rects.len()).map(at).collect()
        };
        let background: Vec<Rect> = regions.get(track.tracker.as_str()).map_or_else(Vec::new, background);
        let frames = track.error.len();
        let said = |(k, (record, method)): (usize, (&&MethodRecord, &Method))| {
            let series = track.method(&method.name)?;
            let protocol = experiment.protocol_of(&record.name)?;
            // A results folder from elsewhere may lack rows.
            if [series.score.len(), series.alarm.len(), series.changes.len()] != [frames; 3] {
                return None;
            }
            let judged = track.judge(protocol, &series.alarm, &series.changes);
            Some((k, Said::new(track, series, &judged, method.thresholds[tracker])))
        };
        let said = records.iter().zip(&methods).enumerate().filter_map(said).collect();
        Some((track.sequence.clone(), Track::new([0, tracker], track, &background, said)))
    };
    // Frame numbers by sequence, and tracks with the names of their sequences.
    let (mut numbers, mut packed) = (BTreeMap::new(), Vec::<(String, Track)>::new());
    let mut add = |tracks: Vec<TrackSeries>| {
        for track in &tracks {
            numbers.entry(track.sequence.clone()).or_insert_with(|| track.numbers.clone());
        }
        packed.extend(tracks.par_iter().filter_map(pack).collect::<Vec<_>>());
    };
    match given {
        Some(tracks) => add(tracks),
        None => results.each_track(add)?,
    }
    if numbers.is_empty() {
        return Ok(Sequences::default());
    }
    let mut truth = results.truth()?;
    let sequence = |(name, numbers): (String, Vec<i64>)| {
        let mut regions = truth.remove(&name).unwrap_or_default();
        Sequence {
            first: numbers.first().copied().unwrap_or(1),
            size: manifest.suite.sizes.get(&name).copied(),
            attributes: manifest.suite.attributes.get(&name).cloned().unwrap_or_default(),
            truth: numbers.iter().map(|number| regions.remove(number)).collect(),
            name,
            ..Sequence::default()
        }
    };
    let mut sequences: Vec<Sequence> = numbers.into_iter().map(sequence).collect();
    // Others than those of the suite come last, in order of name.
    let in_suite = |s: &Sequence| manifest.suite.present.iter().position(|(name, _)| *name == s.name);
    sequences.sort_by_cached_key(|s| in_suite(s).unwrap_or(usize::MAX));
    let place = |name: &str| sequences.iter().position(|sequence| sequence.name == name);
    let placed = |(name, track): (String, Track)| Some(Track { sequence: place(&name)?, ..track });
    let mut tracks: Vec<Track> = packed.into_iter().filter_map(placed).collect();
    tracks.sort_by_key(|t| (t.sequence, t.tracker));
    Ok(Sequences { trackers, methods, sequences, tracks, note, unannotated: false })
}

/// Rule of the background region's motion, for each tracker with a method that reads distribution fields.
fn background_rules(results: &Results) -> BTreeMap<&str, distribution_field::Params> {
    let mut rules = BTreeMap::new();
    let methods = results.experiment.methods.iter();
    for (method, signal) in methods.flat_map(|m| m.variants.iter().map(move |v| (m, v.signals.first()))) {
        let fields = signal.filter(|s| s.kind == distribution_field::ENTRY.kind);
        let Some(signal) = fields else { continue };
        let Ok(params) = serde_json::from_value::<distribution_field::Params>(signal.signal.params()) else {
            continue;
        };
        for tracker in results.experiment.trackers.iter().filter(|t| method.runs_on(&t.label)) {
            rules.entry(tracker.label.as_str()).or_insert_with(|| params.clone());
        }
    }
    rules
}

/// Table of counts by sequence.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
pub struct Tallies {
    /// Sentences about tracks that were left out; may be empty.
    pub note: String,
    /// True if there is no ground truth, so that cells are numbers of losses.
    pub unannotated: bool,
    /// Headings of the columns.
    pub methods: Vec<String>,
    /// All attributes that some sequence has.
    pub attributes: Vec<String>,
    /// One row per track.
    pub rows: Vec<TallyRow>,
    /// Sums over all rows.
    pub totals: Vec<String>,
}

/// A row of the table of counts: all methods on one track.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
pub struct TallyRow {
    /// Index of the sequence.
    pub s: usize,
    /// Index of the tracker.
    pub t: usize,
    /// Name of the sequence.
    pub sequence: String,
    /// Label of the tracker.
    pub tracker: String,
    /// Number of frames.
    pub frames: usize,
    /// Attributes in one line.
    pub attributes: String,
    /// Indices of the sequence's attributes among all, separated by blanks.
    pub marks: String,
    /// Cells: `hits / misses / false alarms`, or the number of losses without ground truth. Empty for a
    /// method that is not run on the tracker.
    pub cells: Vec<String>,
}

impl Sequences {
    /// Table of counts: hits, misses and false alarms of each method on each track.
    pub fn tallies(&self) -> Tallies {
        let attributes: BTreeSet<&String> = self.sequences.iter().flat_map(|s| &s.attributes).collect();
        let mut totals: Vec<Option<Counts>> = vec![None; self.methods.len()];
        let row = |track: &Track| {
            let sequence = &self.sequences[track.sequence];
            let mut cells = vec![String::new(); self.methods.len()];
            for (k, counts, events) in &track.counts {
                cells[*k] = if self.unannotated { events.to_string() } else { tally(counts) };
                totals[*k] = Some(totals[*k].into_iter().chain([*counts]).sum());
            }
            let marks = attributes.iter().enumerate().filter(|(_, a)| sequence.attributes.contains(a));
            TallyRow {
                s: track.sequence,
                t: track.tracker,
                sequence: sequence.name.clone(),
                tracker: self.trackers[track.tracker].clone(),
                frames: track.frames,
                attributes: sequence.attributes.join(", "),
                marks: marks.map(|(k, _)| k.to_string()).collect::<Vec<_>>().join(" "),
                cells,
            }
        };
        Tallies {
            note: self.note.clone(),
            unannotated: self.unannotated,
            methods: self.methods.iter().map(|m| m.name.clone()).collect(),
            rows: self.tracks.iter().map(row).collect(),
            attributes: attributes.iter().map(|a| (*a).clone()).collect(),
            totals: totals.iter().map(|c| c.as_ref().map_or_else(String::new, tally)).collect(),
        }
    }

    /// Sequence, tracker and method to show first: the track and method with most events, the first of equal
    /// ones. Without ground truth, the first method, since the verdict is about it.
    fn start(&self) -> Option<[usize; 3]> {
        let of_tracks = self.tracks.iter().flat_map(|t| t.counts.iter().map(move |of| (t, of)));
        let all = of_tracks.filter(|(_, (method, ..))| *method == 0 || !self.unannotated);
        // `min_by_key` takes the first of equal ones.
        let most = all.min_by_key(|(_, (.., events))| std::cmp::Reverse(*events));
        most.map(|(track, (method, ..))| [track.sequence, track.tracker, *method])
    }
}

fn tally(counts: &Counts) -> String {
    format!("{} / {} / {}", counts.tp, counts.fn_, counts.fp)
}

#[cfg(test)]
mod tests;
