//! Tracks with the series of methods, from `frames.parquet`, `pieces.csv`, `signals.parquet`,
//! `conditions.parquet` and `checks.csv`; and the ground truth.

use super::cells::{TrackName, grouped, method_label};
use super::files::{CheckRow, ConditionRow, Frame, Piece, Signal, Target};
use super::folder::damaged;
use super::rows::{Rows, TableError};
use super::{Results, ResultsError};
use polars::prelude::DataFrame;
use std::collections::BTreeMap;
use std::ops::Range;
use trackfail_core::region::{Rect, Region};
use trackfail_engine::execute::supervise::catch;
use trackfail_methods::score::{Protocol, TrackScore};

/// One run of a tracker over a sequence, with the series of the methods.
#[derive(Debug, Clone, Default)]
pub struct TrackSeries {
    /// Name of the sequence.
    pub sequence: String,
    /// Label of the tracker.
    pub tracker: String,
    /// Repetition of the tracker, from 0.
    pub run: i64,
    /// Frame numbers, as the sequence counts them.
    pub numbers: Vec<i64>,
    /// Boxes of the tracker.
    pub rects: Vec<Rect>,
    /// Overlap error O_t; NaN if it is unknown.
    pub error: Vec<f64>,
    /// Pieces that a protocol may score separately, see `pieces.csv`; empty for tracks without restarts.
    pub pieces: Vec<Range<usize>>,
    /// Methods, sorted by name.
    pub methods: Vec<MethodSeries>,
}

impl TrackSeries {
    fn name(&self) -> TrackName<'_> {
        (&self.sequence, &self.tracker, self.run)
    }

    /// Series of the method called `name`.
    pub fn method(&self, name: &str) -> Option<&MethodSeries> {
        self.methods.iter().find(|m| m.name == name)
    }

    /// Events, and the detections in `changes` with their matches, by the protocol. Without labels there are
    /// no detections.
    pub fn judge(&self, protocol: &Protocol, alarm: &[bool], changes: &[i32]) -> TrackScore {
        protocol.judge(&self.error, alarm, changes, &self.pieces)
    }
}

/// Scores and labels of one method on a track, frame by frame.
#[derive(Debug, Clone, Default)]
pub struct MethodSeries {
    /// Name of the method with its grid point.
    pub name: String,
    /// Score in each frame.
    pub score: Vec<f64>,
    /// Value compared with the threshold in each frame; empty if it is the score.
    pub alarm_score: Vec<f64>,
    /// True in frames for which the method says that the track has failed.
    pub alarm: Vec<bool>,
    /// Changes of the label in each frame: +1, -1 or 0.
    pub changes: Vec<i32>,
    /// Signal in each frame; empty for methods without a signal, and for methods with a grid, which figures
    /// do not show.
    pub signal: Vec<f64>,
    /// Forecast in each frame; NaN if there is none.
    pub forecast: Vec<f64>,
    /// Condition of the tracker in each frame, from 0 (scanning) to 1 (locked on); empty for methods that do
    /// not estimate it.
    pub condition: Vec<f64>,
    /// Checks of the track by reverse runs.
    pub checks: Vec<ReverseCheck>,
}

impl MethodSeries {
    /// Values that are compared with the threshold.
    pub fn compared(&self) -> &[f64] {
        if self.alarm_score.is_empty() { &self.score } else { &self.alarm_score }
    }
}

/// A check of a track by a reverse run.
#[derive(Debug, Clone, PartialEq)]
pub struct ReverseCheck {
    /// Number of the frame in which the check was made.
    pub frame: i64,
    /// Number of the frame at which the reverse run ended.
    pub reference: i64,
    /// Error in that frame between forward and reverse run; `None` if there was no run.
    pub error: Option<f64>,
    /// True if the track is accepted as successful again.
    pub accepted: bool,
}

/// Selection of tracks and methods to read; `None` stands for all.
#[derive(Debug, Clone, Copy, Default)]
pub struct TrackFilter<'a> {
    /// Label of the tracker.
    pub tracker: Option<&'a str>,
    /// Name of the sequence.
    pub sequence: Option<&'a str>,
    /// Method with its grid point.
    pub method: Option<&'a str>,
    /// Repetition of the tracker, from 0.
    pub run: Option<i64>,
}

impl TrackFilter<'_> {
    fn passes(&self, (sequence, tracker, run): TrackName<'_>, method: &str) -> bool {
        let is = |wanted: Option<&str>, found: &str| wanted.is_none_or(|w| w == found);
        is(self.tracker, tracker)
            && is(self.sequence, sequence)
            && is(self.method, method)
            && self.run.is_none_or(|r| r == run)
    }
}

/// Series of the method on the track of a row; `None` if it was not read.
fn find<'t>(all: &'t mut [TrackSeries], track: TrackName<'_>, method: &str) -> Option<&'t mut MethodSeries> {
    let track = all.iter_mut().find(|known| known.name() == track)?;
    track.methods.iter_mut().find(|known| known.name == method)
}

/// First run of all trackers.
const FIRST_RUNS: TrackFilter<'static> =
    TrackFilter { tracker: None, sequence: None, method: None, run: Some(0) };

/// Ground truth by sequence and frame number.
pub type Truth = BTreeMap<String, BTreeMap<i64, Region>>;

impl Results {
    /// Reads the tracks of all trackers' first runs, without signals and conditions.
    ///
    /// # Errors
    /// When the file is absent or damaged.
    pub fn all_tracks(&self) -> Result<Vec<TrackSeries>, ResultsError> {
        self.read_frames(&FIRST_RUNS)
    }

    /// Copies tracks and adds signals and conditions.
    ///
    /// # Errors
    /// When a file is absent or damaged.
    pub fn with_signals(&self, tracks: &[&TrackSeries]) -> Result<Vec<TrackSeries>, ResultsError> {
        let mut tracks: Vec<TrackSeries> = tracks.iter().map(|track| (*track).clone()).collect();
        self.each_part::<Signal<'_>>(|part| {
            for rows in Signal::rows(&part)?.chunk_by(|a, b| (a.track, a.method) == (b.track, b.method)) {
                let Some(series) = find(&mut tracks, rows[0].track, rows[0].method) else { continue };
                series.signal.extend(rows.iter().map(|row| row.signal));
                series.forecast.extend(rows.iter().map(|row| row.forecast.unwrap_or(f64::NAN)));
            }
            Ok(())
        })?;
        self.add_conditions(&mut tracks)?;
        Ok(tracks)
    }

    /// Reads the tracks that pass a filter, with conditions and checks.
    ///
    /// # Errors
    /// When a file is absent or damaged.
    pub fn checked_tracks(&self, filter: &TrackFilter<'_>) -> Result<Vec<TrackSeries>, ResultsError> {
        let mut tracks = self.read_frames(filter)?;
        self.add_conditions(&mut tracks)?;
        self.table_if_any(CheckRow::NAME, |bytes| {
            for row in CheckRow::rows(&CheckRow::read(bytes)?)? {
                let label = method_label(row.method, row.params);
                let Some(series) = find(&mut tracks, row.track, &label) else { continue };
                let CheckRow { frame, reference, error, accepted, .. } = row;
                series.checks.push(ReverseCheck { frame, reference, error, accepted: accepted == 1 });
            }
            Ok(())
        })?;
        Ok(tracks)
    }

    /// Passes the tracks of [`Results::all_tracks`] to `take` as they are read, some at a time.
    ///
    /// # Errors
    /// When the file is absent or damaged.
    pub fn each_track(&self, take: impl FnMut(Vec<TrackSeries>)) -> Result<(), ResultsError> {
        self.each_frames(&FIRST_RUNS, take)
    }

    fn read_frames(&self, filter: &TrackFilter<'_>) -> Result<Vec<TrackSeries>, ResultsError> {
        let mut all = Vec::new();
        self.each_frames(filter, |tracks| all.extend(tracks))?;
        Ok(all)
    }

    fn each_frames(
        &self,
        filter: &TrackFilter<'_>,
        mut take: impl FnMut(Vec<TrackSeries>),
    ) -> Result<(), ResultsError> {
        let pieces = self.table_if_any(Piece::NAME, |bytes| Piece::rows(&Piece::read(bytes)?))?;
        let pieces: BTreeMap<_, _> = grouped(&pieces, |piece| &piece.track).into_iter().collect();
        let mut take = |mut tracks: Vec<TrackSeries>| {
            for track in &mut tracks {
                let name = (track.sequence.clone(), track.tracker.clone(), track.run);
                for piece in pieces.get(&name).into_iter().flatten() {
                    let from = track.numbers.partition_point(|n| *n < piece.first);
                    let to = track.numbers.partition_point(|n| *n <= piece.last);
                    track.pieces.push(from..to);
                }
            }
            take(tracks);
        };
        let mut tracks: Vec<TrackSeries> = Vec::new();
        self.each_part::<Frame<'_>>(|part| {
            for rows in Frame::rows(&part)?.chunk_by(|a, b| (a.track, a.method) == (b.track, b.method)) {
                if filter.passes(rows[0].track, rows[0].method) {
                    add_frames(rows, &mut tracks);
                }
            }
            // The last one may go on in the next part.
            let last = tracks.pop();
            take(std::mem::take(&mut tracks));
            tracks.extend(last);
            Ok(())
        })?;
        // What is read may be damaged in ways that are not met before.
        Ok(catch(|| take(tracks)).map_err(|_| damaged(&self.folder.join(Frame::NAME)))?)
    }

    /// Passes a file with a row for each frame to `take`, part by part. Does nothing if the run wrote no such
    /// file.
    fn each_part<'a, R: Rows<'a>>(
        &self,
        take: impl FnMut(DataFrame) -> Result<(), TableError>,
    ) -> Result<(), ResultsError> {
        self.table_if_any(R::NAME, |bytes| R::each_part(bytes, take))
    }

    /// Adds conditions, if the experiment has a method that estimates them.
    fn add_conditions(&self, tracks: &mut [TrackSeries]) -> Result<(), ResultsError> {
        self.each_part::<ConditionRow<'_>>(|part| {
            for rows in ConditionRow::rows(&part)?.chunk_by(|a, b| (a.track, a.method) == (b.track, b.method))
            {
                let Some(series) = find(tracks, rows[0].track, rows[0].method) else { continue };
                series.condition.extend(rows.iter().map(|row| row.condition));
            }
            Ok(())
        })
    }

    /// Reads the ground truth; frames without annotation are left out.
    ///
    /// # Errors
    /// When the file is absent or damaged.
    pub fn truth(&self) -> Result<Truth, ResultsError> {
        let mut truth = Truth::new();
        self.each_part::<Target<'_>>(|part| {
            for rows in Target::rows(&part)?.chunk_by(|a, b| a.sequence == b.sequence) {
                let region = |row: &Target<'_>| Some((row.frame, Region::from_numbers(&row.corners?).ok()?));
                let of_sequence = truth.entry(rows[0].sequence.to_string()).or_default();
                of_sequence.extend(rows.iter().filter_map(region));
            }
            Ok(())
        })?;
        Ok(truth)
    }
}

/// Appends the frames of rows to the tracks and methods that they belong to.
fn add_frames(rows: &[Frame<'_>], tracks: &mut Vec<TrackSeries>) {
    let Frame { track: (sequence, tracker, run), method, .. } = rows[0];
    if tracks.last().is_none_or(|track| track.name() != (sequence, tracker, run)) {
        let (sequence, tracker) = (sequence.to_string(), tracker.to_string());
        tracks.push(TrackSeries { sequence, tracker, run, ..TrackSeries::default() });
    }
    let Some(track) = tracks.last_mut() else { return };
    if track.methods.last().is_none_or(|m| m.name != method) {
        track.methods.push(MethodSeries { name: method.to_string(), ..MethodSeries::default() });
    }
    // The boxes are the same for every method.
    if track.methods.len() == 1 {
        track.numbers.extend(rows.iter().map(|row| row.frame));
        track.rects.extend(rows.iter().map(|row| Rect::new(row.x, row.y, row.w, row.h)));
        track.error.extend(rows.iter().map(|row| row.error.unwrap_or(f64::NAN)));
    }
    let Some(series) = track.methods.last_mut() else { return };
    series.score.extend(rows.iter().map(|row| row.score));
    let scores = rows.iter().map(|row| row.alarm_score.filter(|s| s.is_finite()));
    series.alarm_score.extend(scores.collect::<Option<Vec<_>>>().unwrap_or_default());
    series.alarm.extend(rows.iter().map(|row| row.label != 0));
    series.changes.extend(rows.iter().map(|row| row.change));
}
