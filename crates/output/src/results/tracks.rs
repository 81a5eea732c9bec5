//! Tracks with what methods made of them, from `frames.parquet`, `signals.parquet`, `conditions.parquet` and
//! `checks.csv`.

use super::checks::{self, ReverseCheck};
use super::column::{Column, FRAME, METHOD, RUN, SEQUENCE, TRACKER};
use super::conditions::{self, CONDITION};
use super::frame::{Rows, TableError};
use super::frames::{self, CHANGE, ERROR, H, LABEL, SCORE, W, X, Y};
use super::signals::{self, FORECAST, SIGNAL};
use super::{Results, ResultsError};
use crate::region::Rect;

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
    /// Methods, sorted by name.
    pub methods: Vec<MethodSeries>,
}

impl TrackSeries {
    /// The series of a method.
    pub fn method(&self, name: &str) -> Option<&MethodSeries> {
        self.methods.iter().find(|m| m.name == name)
    }
}

/// Scores and labels of one method on a track, frame by frame.
#[derive(Debug, Clone, Default)]
pub struct MethodSeries {
    /// Name with its grid point.
    pub name: String,
    /// Score compared with the threshold.
    pub score: Vec<f64>,
    /// Whether the method says that the track has failed.
    pub alarm: Vec<bool>,
    /// Changes of the label: +1, -1, 0.
    pub changes: Vec<i32>,
    /// Signal; empty for methods with a grid or without a signal.
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
    /// The rows that pass.
    fn of(&self, rows: Rows) -> Result<Rows, TableError> {
        let is = |wanted: Option<&str>, found: &str| wanted.is_none_or(|w| w == found);
        let names = rows.texts(&TRACKER)?.into_iter().zip(rows.texts(&SEQUENCE)?);
        let cells = names.zip(rows.texts(&METHOD)?).zip(rows.integers(&RUN)?);
        let keep = cells.map(|(((tracker, sequence), method), run)| {
            is(self.tracker, tracker)
                && is(self.sequence, sequence)
                && is(self.method, method)
                && self.run.is_none_or(|r| r == run)
        });
        let keep = keep.collect();
        rows.filter(keep)
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
}

impl Results {
    /// Reads the tracks of one tracker's first run, with signals and conditions.
    ///
    /// # Errors
    /// When a file is absent or damaged.
    pub fn tracks(&self, tracker: &str) -> Result<Vec<TrackSeries>, ResultsError> {
        let filter = TrackFilter { tracker: Some(tracker), run: Some(0), ..TrackFilter::default() };
        let mut tracks = self.read_frames(&filter)?;
        self.add_signals(&filter, &mut tracks)?;
        self.add_conditions(&filter, &mut tracks)?;
        Ok(tracks)
    }

    /// Reads the tracks of every tracker's first run, without signals and conditions.
    ///
    /// # Errors
    /// When the file is absent or damaged.
    pub fn all_tracks(&self) -> Result<Vec<TrackSeries>, ResultsError> {
        self.read_frames(&TrackFilter { run: Some(0), ..TrackFilter::default() })
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

    fn read_frames(&self, filter: &TrackFilter<'_>) -> Result<Vec<TrackSeries>, ResultsError> {
        self.table(frames::FILE.name, |bytes| {
            let rows = filter.of(frames::FILE.read_parquet(bytes, &frames::FILE.columns[1..])?)?;
            let (keys, number) = (Keys::of(&rows)?, rows.integers(&FRAME)?);
            let (x, y, w, h) = (rows.reals(&X)?, rows.reals(&Y)?, rows.reals(&W)?, rows.reals(&H)?);
            let (error, score) = (rows.reals(&ERROR)?, rows.reals(&SCORE)?);
            let (label, change) = (rows.small(&LABEL)?, rows.small(&CHANGE)?);
            let mut tracks: Vec<TrackSeries> = Vec::new();
            for i in 0..rows.len() {
                if tracks.last().is_none_or(|track| !keys.is_on(i, track)) {
                    let (sequence, tracker) = (keys.sequence[i].to_string(), keys.tracker[i].to_string());
                    tracks.push(TrackSeries {
                        sequence,
                        tracker,
                        run: keys.run[i],
                        ..TrackSeries::default()
                    });
                }
                let Some(track) = tracks.last_mut() else { continue };
                if track.methods.last().is_none_or(|m| m.name != keys.method[i]) {
                    let name = keys.method[i].to_string();
                    track.methods.push(MethodSeries { name, ..MethodSeries::default() });
                }
                // The boxes are the same for every method.
                if track.methods.len() == 1 {
                    track.numbers.push(number[i]);
                    track.rects.push(Rect::new(x[i], y[i], w[i], h[i]));
                    track.error.push(error[i]);
                }
                if let Some(m) = track.methods.last_mut() {
                    m.score.push(score[i]);
                    m.alarm.push(label[i] != 0);
                    m.changes.push(change[i]);
                }
            }
            Ok(tracks)
        })
    }

    fn add_signals(&self, filter: &TrackFilter<'_>, tracks: &mut [TrackSeries]) -> Result<(), ResultsError> {
        self.table(signals::FILE.name, |bytes| {
            let [sequence, tracker, run, method] = KEYS;
            let columns = [sequence, tracker, run, method, SIGNAL, FORECAST];
            let rows = filter.of(signals::FILE.read_parquet(bytes, &columns)?)?;
            let (signal, forecast) = (rows.reals(&SIGNAL)?, rows.reals(&FORECAST)?);
            add_rows(tracks, &Keys::of(&rows)?, |series, i| {
                series.signal.push(signal[i]);
                series.forecast.push(forecast[i]);
            });
            Ok(())
        })
    }

    /// Adds the conditions, if the experiment has a method that follows them.
    fn add_conditions(
        &self,
        filter: &TrackFilter<'_>,
        tracks: &mut [TrackSeries],
    ) -> Result<(), ResultsError> {
        if !self.has(conditions::FILE.name) {
            return Ok(());
        }
        self.table(conditions::FILE.name, |bytes| {
            let [sequence, tracker, run, method] = KEYS;
            let columns = [sequence, tracker, run, method, CONDITION];
            let rows = filter.of(conditions::FILE.read_parquet(bytes, &columns)?)?;
            let condition = rows.reals(&CONDITION)?;
            add_rows(tracks, &Keys::of(&rows)?, |series, i| series.condition.push(condition[i]));
            Ok(())
        })
    }

    /// Adds the checks, if the experiment has a method that makes any.
    fn add_checks(&self, tracks: &mut [TrackSeries]) -> Result<(), ResultsError> {
        if !self.has(checks::FILE.name) {
            return Ok(());
        }
        for of_cell in self.table(checks::FILE.name, checks::read)? {
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

/// Gives each row to the method on the track that it is about.
fn add_rows(tracks: &mut [TrackSeries], keys: &Keys<'_>, mut add: impl FnMut(&mut MethodSeries, usize)) {
    let mut place = (0, 0);
    for i in 0..keys.method.len() {
        let is_here = |(t, m): (usize, usize), tracks: &[TrackSeries]| {
            let track = tracks.get(t).filter(|track| keys.is_on(i, track));
            track.and_then(|track| track.methods.get(m)).is_some_and(|s| s.name == keys.method[i])
        };
        // The rows of a method on a track follow each other.
        if !is_here(place, tracks) {
            let Some(t) = tracks.iter().position(|track| keys.is_on(i, track)) else { continue };
            let Some(m) = tracks[t].methods.iter().position(|s| s.name == keys.method[i]) else { continue };
            place = (t, m);
        }
        add(&mut tracks[place.0].methods[place.1], i);
    }
}
