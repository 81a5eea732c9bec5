//! Tracks with what methods made of them, from `frames.parquet`, `pieces.csv`, `signals.parquet`, `conditions.parquet`
//! and `checks.csv`.

use super::checks::{self, ReverseCheck};
use super::column::{Column, FRAME, METHOD, RUN, SEQUENCE, TRACKER};
use super::conditions::{self, CONDITION};
use super::frame::{Rows, TableError};
use super::frames::{self, ALARM_SCORE, CHANGE, ERROR, H, LABEL, SCORE, W, X, Y};
use super::pieces;
use super::signals::{self, FORECAST, SIGNAL};
use super::{Results, ResultsError};
use std::ops::Range;
use trackfail_core::region::Rect;
use trackfail_methods::score::{Protocol, TrackScore};

/// One run of a tracker over a sequence, with what methods made of it.
#[derive(Debug, Clone, Default)]
pub struct TrackSeries {
    /// Sequence.
    pub sequence: String,
    /// Label of the tracker.
    pub tracker: String,
    /// Repetition, from 0.
    pub run: i64,
    /// Frame numbers, as the sequence has them.
    pub numbers: Vec<i64>,
    /// The tracker's boxes.
    pub rects: Vec<Rect>,
    /// Error O_t, NaN where it is not known.
    pub error: Vec<f64>,
    /// Pieces that a protocol may score by themselves, see [`pieces`]; empty for tracks without restarts.
    pub pieces: Vec<Range<usize>>,
    /// Methods, sorted by name.
    pub methods: Vec<MethodSeries>,
}

impl TrackSeries {
    /// The series of a method.
    pub fn method(&self, name: &str) -> Option<&MethodSeries> {
        self.methods.iter().find(|m| m.name == name)
    }

    /// Events, and the detections that labels make with those that match, as the run counted them. Without labels there is
    /// no detection.
    pub fn judge(&self, protocol: &Protocol, alarm: &[bool], changes: &[i32]) -> TrackScore {
        protocol.judge(&self.error, alarm, changes, &self.pieces)
    }
}

/// Scores and labels of one method on a track, frame by frame.
#[derive(Debug, Clone, Default)]
pub struct MethodSeries {
    /// Name with its grid point.
    pub name: String,
    /// Score.
    pub score: Vec<f64>,
    /// The number compared with the threshold; empty where it is the score.
    pub alarm_score: Vec<f64>,
    /// Whether the method says that the track has failed.
    pub alarm: Vec<bool>,
    /// Changes of the label: +1, -1, 0.
    pub changes: Vec<i32>,
    /// Signal; empty for methods with a grid, which figures do not show, or without a signal.
    pub signal: Vec<f64>,
    /// Forecast, NaN where there is none.
    pub forecast: Vec<f64>,
    /// Condition of the tracker, from 0 (scanning) to 1 (locked on); empty for methods that do not follow it.
    pub condition: Vec<f64>,
    /// Checks of the track by running the tracker backwards.
    pub checks: Vec<ReverseCheck>,
}

/// Which tracks and methods to read; `None` is all of them.
#[derive(Debug, Clone, Copy, Default)]
pub struct TrackFilter<'a> {
    /// Label of the tracker.
    pub tracker: Option<&'a str>,
    /// Sequence.
    pub sequence: Option<&'a str>,
    /// Method with its grid point.
    pub method: Option<&'a str>,
    /// Repetition, from 0.
    pub run: Option<i64>,
}

impl TrackFilter<'_> {
    /// Whether row `i` passes.
    fn passes(&self, keys: &Keys<'_>, i: usize) -> bool {
        let is = |wanted: Option<&str>, found: &str| wanted.is_none_or(|w| w == found);
        is(self.tracker, keys.tracker[i])
            && is(self.sequence, keys.sequence[i])
            && is(self.method, keys.method[i])
            && self.run.is_none_or(|r| r == keys.run[i])
    }
}

/// The columns that name a method on a track.
const KEYS: [Column; 4] = [SEQUENCE, TRACKER, RUN, METHOD];

/// The values of [`KEYS`].
struct Keys<'r> {
    sequence: Vec<&'r str>,
    tracker: Vec<&'r str>,
    run: Vec<i64>,
    method: Vec<&'r str>,
}

impl<'r> Keys<'r> {
    fn of(rows: &'r Rows) -> Result<Self, TableError> {
        Ok(Self {
            sequence: rows.texts(&SEQUENCE)?,
            tracker: rows.texts(&TRACKER)?,
            run: rows.integers(&RUN)?,
            method: rows.texts(&METHOD)?,
        })
    }

    /// Whether a row is about a track.
    fn is_on(&self, i: usize, track: &TrackSeries) -> bool {
        self.sequence[i] == track.sequence && self.tracker[i] == track.tracker && self.run[i] == track.run
    }

    /// The rows that follow each other with the same keys.
    fn stretches(&self) -> Vec<Range<usize>> {
        let row = |i: usize| (self.method[i], self.run[i], self.tracker[i], self.sequence[i]);
        let mut from = 0;
        let mut all = Vec::new();
        for i in 1..=self.method.len() {
            if i == self.method.len() || row(i) != row(i - 1) {
                all.push(from..i);
                from = i;
            }
        }
        all
    }
}

impl Results {
    /// Reads the tracks of every tracker's first run, without signals and conditions.
    ///
    /// # Errors
    /// When the file is absent or damaged.
    pub fn all_tracks(&self) -> Result<Vec<TrackSeries>, ResultsError> {
        self.read_frames(&TrackFilter { run: Some(0), ..TrackFilter::default() })
    }

    /// Copies of tracks of a tracker's first run, with signals and conditions.
    ///
    /// # Errors
    /// When a file is absent or damaged.
    pub fn with_signals(
        &self,
        tracker: &str,
        tracks: &[&TrackSeries],
    ) -> Result<Vec<TrackSeries>, ResultsError> {
        let mut tracks: Vec<TrackSeries> = tracks.iter().map(|track| (*track).clone()).collect();
        let filter = TrackFilter { tracker: Some(tracker), run: Some(0), ..TrackFilter::default() };
        self.add_signals(&filter, &mut tracks)?;
        self.add_conditions(&filter, &mut tracks)?;
        Ok(tracks)
    }

    /// Reads the tracks that pass a filter, with conditions and checks.
    ///
    /// # Errors
    /// When a file is absent or damaged.
    pub fn checked_tracks(&self, filter: &TrackFilter<'_>) -> Result<Vec<TrackSeries>, ResultsError> {
        let mut tracks = self.read_frames(filter)?;
        self.add_conditions(filter, &mut tracks)?;
        self.add_checks(&mut tracks)?;
        Ok(tracks)
    }

    /// Gives `take` the tracks of [`Results::all_tracks`] as they are read, some at a time.
    ///
    /// # Errors
    /// When the file is absent or damaged.
    pub fn each_track(&self, take: impl FnMut(Vec<TrackSeries>)) -> Result<(), ResultsError> {
        self.each_frames(&TrackFilter { run: Some(0), ..TrackFilter::default() }, take)
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
        let pieces = self.table_if_any(pieces::FILE.name, pieces::read)?;
        let mut take = |mut tracks: Vec<TrackSeries>| {
            tracks.iter_mut().for_each(|track| add_pieces(track, &pieces));
            take(tracks);
        };
        self.table_if_any(frames::FILE.name, |bytes| {
            let mut tracks: Vec<TrackSeries> = Vec::new();
            frames::FILE.read_parquet_parts(bytes, &frames::FILE.columns[1..], |rows| {
                add_frames(&rows, filter, &mut tracks)?;
                // The last one may go on in the next part.
                let last = tracks.pop();
                take(std::mem::take(&mut tracks));
                tracks.extend(last);
                Ok(())
            })?;
            take(tracks);
            Ok(())
        })
    }

    fn add_signals(&self, filter: &TrackFilter<'_>, tracks: &mut [TrackSeries]) -> Result<(), ResultsError> {
        self.table_if_any(signals::FILE.name, |bytes| {
            let [sequence, tracker, run, method] = KEYS;
            let columns = [sequence, tracker, run, method, SIGNAL, FORECAST];
            signals::FILE.read_parquet_parts(bytes, &columns, |rows| {
                let (signal, forecast) = (rows.reals(&SIGNAL)?, rows.reals(&FORECAST)?);
                add_rows(tracks, filter, &Keys::of(&rows)?, |series, rows| {
                    series.signal.extend_from_slice(&signal[rows.clone()]);
                    series.forecast.extend_from_slice(&forecast[rows]);
                });
                Ok(())
            })
        })
    }

    /// Adds the conditions, if the experiment has a method that follows them.
    fn add_conditions(
        &self,
        filter: &TrackFilter<'_>,
        tracks: &mut [TrackSeries],
    ) -> Result<(), ResultsError> {
        self.table_if_any(conditions::FILE.name, |bytes| {
            let [sequence, tracker, run, method] = KEYS;
            let columns = [sequence, tracker, run, method, CONDITION];
            conditions::FILE.read_parquet_parts(bytes, &columns, |rows| {
                let condition = rows.reals(&CONDITION)?;
                add_rows(tracks, filter, &Keys::of(&rows)?, |series, rows| {
                    series.condition.extend_from_slice(&condition[rows]);
                });
                Ok(())
            })
        })
    }

    /// Adds the checks, if the experiment has a method that makes any.
    fn add_checks(&self, tracks: &mut [TrackSeries]) -> Result<(), ResultsError> {
        for of_cell in self.table_if_any(checks::FILE.name, checks::read)? {
            let is_on = |t: &&mut TrackSeries| {
                t.sequence == of_cell.sequence && t.tracker == of_cell.tracker && t.run == of_cell.run
            };
            let Some(track) = tracks.iter_mut().find(is_on) else { continue };
            if let Some(series) = track.methods.iter_mut().find(|m| m.name == of_cell.method) {
                series.checks.push(of_cell.check);
            }
        }
        Ok(())
    }
}

/// Adds its pieces to a track; only tracks with restarts have any.
fn add_pieces(track: &mut TrackSeries, pieces: &pieces::ByTrack) {
    let key = (track.sequence.clone(), track.tracker.clone(), track.run);
    for (first, last) in pieces.get(&key).into_iter().flatten() {
        let from = track.numbers.partition_point(|n| n < first);
        let to = track.numbers.partition_point(|n| n <= last);
        track.pieces.push(from..to);
    }
}

/// Adds rows of the file of frames to the tracks that they are about.
fn add_frames(
    rows: &Rows,
    filter: &TrackFilter<'_>,
    tracks: &mut Vec<TrackSeries>,
) -> Result<(), TableError> {
    let (keys, number) = (Keys::of(rows)?, rows.integers(&FRAME)?);
    let (x, y, w, h) = (rows.reals(&X)?, rows.reals(&Y)?, rows.reals(&W)?, rows.reals(&H)?);
    let (error, score) = (rows.reals(&ERROR)?, rows.reals(&SCORE)?);
    // Files of earlier versions have none.
    let alarm_score = rows.reals(&ALARM_SCORE).unwrap_or_default();
    let (label, change) = (rows.small(&LABEL)?, rows.small(&CHANGE)?);
    for rows in keys.stretches().into_iter().filter(|rows| filter.passes(&keys, rows.start)) {
        let (track, series) = place_of(tracks, &keys, rows.start);
        // The boxes are the same for every method.
        if series == 0 {
            track.numbers.extend_from_slice(&number[rows.clone()]);
            track.rects.extend(rows.clone().map(|i| Rect::new(x[i], y[i], w[i], h[i])));
            track.error.extend_from_slice(&error[rows.clone()]);
        }
        let series = &mut track.methods[series];
        series.score.extend_from_slice(&score[rows.clone()]);
        if let Some(scores) =
            alarm_score.get(rows.clone()).filter(|scores| scores.iter().all(|s| s.is_finite()))
        {
            series.alarm_score.extend_from_slice(scores);
        }
        series.alarm.extend(label[rows.clone()].iter().map(|label| *label != 0));
        series.changes.extend_from_slice(&change[rows]);
    }
    Ok(())
}

/// The track that row `i` is about, and the place of the method among its methods; both are added where the row before
/// was about another.
fn place_of<'t>(tracks: &'t mut Vec<TrackSeries>, keys: &Keys<'_>, i: usize) -> (&'t mut TrackSeries, usize) {
    let place = match tracks.last() {
        Some(track) if keys.is_on(i, track) => tracks.len() - 1,
        _ => {
            let (sequence, tracker) = (keys.sequence[i].to_string(), keys.tracker[i].to_string());
            tracks.push(TrackSeries { sequence, tracker, run: keys.run[i], ..TrackSeries::default() });
            tracks.len() - 1
        }
    };
    let track = &mut tracks[place];
    if track.methods.last().is_none_or(|m| m.name != keys.method[i]) {
        let name = keys.method[i].to_string();
        track.methods.push(MethodSeries { name, ..MethodSeries::default() });
    }
    let last = track.methods.len() - 1;
    (track, last)
}

/// Gives the rows that pass to the method on the track that they are about.
fn add_rows(
    tracks: &mut [TrackSeries],
    filter: &TrackFilter<'_>,
    keys: &Keys<'_>,
    mut add: impl FnMut(&mut MethodSeries, Range<usize>),
) {
    for rows in keys.stretches().into_iter().filter(|rows| filter.passes(keys, rows.start)) {
        let track = tracks.iter_mut().find(|track| keys.is_on(rows.start, track));
        let methods = track.into_iter().flat_map(|track| &mut track.methods);
        if let Some(series) = methods.into_iter().find(|m| m.name == keys.method[rows.start]) {
            add(series, rows);
        }
    }
}
