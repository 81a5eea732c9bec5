//! One pass over one sequence: each frame is decoded once and given to every tracker and, with the
//! tracker's answer, to every signal.

use crate::dataset::Sequence;
use crate::plugin;
use crate::region::Rect;
use crate::score::overlap;
use crate::signal::{self, SIGNALS};
use crate::spec::method::SignalChoice;
use crate::spec::{Experiment, Tracker};
use crate::tracker::{self, Start, State, Status, TrackerError};
use std::path::Path;

/// Why a cell has no result.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum CellError {
    /// Its data or the tracker's results are not there.
    #[error("{0}")]
    Missing(String),
    /// Something broke.
    #[error("{0}")]
    Failed(String),
}

impl From<TrackerError> for CellError {
    fn from(e: TrackerError) -> Self {
        match e {
            TrackerError::Missing(m) => Self::Missing(m),
            TrackerError::Broken(m) => Self::Failed(m),
        }
    }
}

/// What one tracker did on one sequence, with the signals computed from it.
#[derive(Debug, Clone)]
pub struct Track {
    /// The rectangle of each frame's region.
    pub rects: Vec<Rect>,
    /// O_t of each frame; NaN where the target is not annotated.
    pub error: Vec<f64>,
    /// One series for each of the experiment's distinct signals.
    pub signals: Vec<Vec<f64>>,
    /// Frames whose region repeats the last one, because the tracker was marked failed or skipped.
    pub repeated: usize,
}

/// A tracker and a repetition.
#[derive(Clone, Copy)]
pub struct Job<'a> {
    /// The tracker.
    pub tracker: &'a Tracker,
    /// Its place in the experiment.
    pub index: usize,
    /// Repetition, from 0.
    pub run: u32,
}

/// Every tracker with every repetition, in the experiment's order.
pub fn jobs(experiment: &Experiment) -> Vec<Job<'_>> {
    let trackers = experiment.trackers.iter().enumerate();
    trackers
        .flat_map(|(index, tracker)| (0..tracker.runs).map(move |run| Job { tracker, index, run }))
        .collect()
}

/// A track being made.
struct Running<'a> {
    tracker: Box<dyn tracker::Tracker>,
    sessions: Vec<Box<dyn signal::Session>>,
    names: &'a [SignalChoice],
    states: Vec<State>,
    signals: Vec<Vec<f64>>,
}

impl Running<'_> {
    fn step(&mut self, sequence: &Sequence, t: usize, frame: &crate::image::Frame) -> Result<(), CellError> {
        let state = if t == 0 {
            let Some(Some(region)) = sequence.truth.first() else {
                return Err(CellError::Failed(format!(
                    "{}: the first frame has no ground truth to start from",
                    sequence.name
                )));
            };
            self.tracker.init(frame, region)?
        } else {
            self.tracker.update(frame)?
        };
        for ((session, series), name) in self.sessions.iter_mut().zip(&mut self.signals).zip(self.names) {
            let value = session.push(frame, &state);
            if !value.is_finite() {
                let frame = sequence.number(t);
                let message = format!("{}: signal {} is {value} in frame {frame}", sequence.name, name.kind);
                return Err(CellError::Failed(message));
            }
            series.push(value);
        }
        self.states.push(state);
        Ok(())
    }
}

/// Tracks and signals of one sequence, a result for each of `jobs` in their order.
///
/// `on_frame` is called once a decoded frame, for progress.
pub fn pass(
    sequence: &Sequence,
    jobs: &[Job<'_>],
    signals: &[SignalChoice],
    seed: u64,
    data_root: Option<&Path>,
    on_frame: &dyn Fn(),
) -> Vec<Result<Track, CellError>> {
    let mut running: Vec<Result<Running<'_>, CellError>> =
        jobs.iter().map(|job| open(sequence, job, signals, seed, data_root)).collect();
    for t in 0..sequence.len() {
        if running.iter().all(Result::is_err) {
            break;
        }
        let frame = sequence.frame(t);
        for track in &mut running {
            let Ok(active) = track else { continue };
            let done = match &frame {
                Ok(frame) => active.step(sequence, t, frame),
                Err(e) => Err(CellError::Failed(e.to_string())),
            };
            if let Err(e) = done {
                *track = Err(e);
            }
        }
        on_frame();
    }
    running
        .into_iter()
        .map(|track| {
            let Running { states, signals, .. } = track?;
            let error = overlap::errors(&states, &sequence.truth);
            let is_repeated = |s: &&State| matches!(s.status, Status::Failed | Status::Skipped);
            let repeated = states.iter().filter(is_repeated).count();
            Ok(Track { rects: states.iter().map(|s| s.region.rect()).collect(), error, signals, repeated })
        })
        .collect()
}

fn open<'a>(
    sequence: &Sequence,
    job: &Job<'_>,
    signals: &'a [SignalChoice],
    seed: u64,
    data_root: Option<&Path>,
) -> Result<Running<'a>, CellError> {
    let run = job.run.to_string();
    let seed = crate::num::seed::seed(seed, &[&sequence.name, &job.tracker.label, &run]);
    let tracker = job.tracker.setup.open(&Start { sequence, run: job.run, seed, data_root })?;
    Ok(Running {
        tracker,
        sessions: signals.iter().map(|s| s.signal.start()).collect(),
        names: signals,
        states: Vec::with_capacity(sequence.len()),
        signals: vec![Vec::with_capacity(sequence.len()); signals.len()],
    })
}

/// The distinct signals of an experiment, in order of first use.
pub fn distinct_signals(experiment: &Experiment) -> Vec<SignalChoice> {
    let mut distinct: Vec<SignalChoice> = Vec::new();
    for choice in experiment.methods.iter().flat_map(|m| &m.variants).filter_map(|v| v.signal.as_ref()) {
        if signal_index(&distinct, choice).is_none() {
            distinct.push(choice.clone());
        }
    }
    distinct
}

/// Where a signal stands among the distinct ones.
pub fn signal_index(distinct: &[SignalChoice], choice: &SignalChoice) -> Option<usize> {
    debug_assert!(plugin::find(SIGNALS, choice.kind).is_some());
    distinct.iter().position(|d| d.kind == choice.kind && d.signal.params() == choice.signal.params())
}
