//! The clock: what methods cost on the tracks of a suite, one thread, one track after the other. What is
//! timed is told in [`processing_time`](crate::analysis::processing_time).

use super::analyse::{Analysed, NotAnalysed};
use super::context::Context;
use super::judge::ReadyDetector;
use super::reverse::{self, ReverseSource};
use super::supervise::run_single;
use super::track::{self, Tracks};
use super::train::ReadyDetectors;
use crate::analysis::processing_time::{Spent, Timing};
use crate::analysis::{Population, Reads};
use crate::detector::{Input, Reverse};
use crate::error::{CellError, RunError};
use crate::plan::{recipes, variants};
use crate::region::Region;
use crate::score::overlap;
use crate::signal::Session;
use crate::spec::analysis::Analysis;
use crate::spec::method::SignalChoice;
use crate::tracker::{RunContext, Tracker, TrackerState};
use std::cell::{Cell, RefCell};
use std::time::{Duration, Instant};

/// Makes every analysis that reads the clock, on every tracker; `tracks` has those of every suite.
///
/// # Errors
/// When the run is interrupted; what goes wrong in an analysis is in its place, with its name.
pub fn measure(
    context: &Context<'_>,
    tracks: &[Vec<Tracks>],
    ready: &ReadyDetectors,
) -> Result<Vec<Result<Analysed, NotAnalysed>>, RunError> {
    let experiment = context.plan.experiment;
    let mut all = Vec::new();
    for analysis in experiment.analyses.iter().filter(|a| a.plugin.reads() == Reads::Clock) {
        for (t, tracker) in experiment.trackers.iter().enumerate() {
            if analysis.runs_on(&tracker.label) {
                let made = make(context, tracks, ready, analysis, t)?;
                all.push(made.map_err(|e| (format!("{} of {}", analysis.name, tracker.label), e)));
            }
        }
    }
    Ok(all)
}

/// A method that is timed.
#[derive(Clone)]
struct Timed {
    signal: Option<SignalChoice>,
    ready_detector: ReadyDetector,
}

fn make(
    context: &Context<'_>,
    tracks: &[Vec<Tracks>],
    ready: &ReadyDetectors,
    analysis: &Analysis,
    tracker: usize,
) -> Result<Result<Analysed, CellError>, RunError> {
    let plan = context.plan;
    let setup = &plan.experiment.trackers[tracker];
    let (names, repeats) = analysis.plugin.timed();
    let mut methods = Vec::new();
    for name in names {
        let found = variants(plan.experiment).position(|(m, _)| m.name == *name);
        let Some(v) = found else {
            return Ok(Err(CellError::Failed(format!("there is no method `{name}` to be timed"))));
        };
        match &ready[v][tracker] {
            Ok(ready_detector) => {
                let signal = plan.signal(v).and_then(|k| plan.signals.get(k)).cloned();
                methods.push(Timed { signal, ready_detector: ready_detector.clone() });
            }
            Err(e) => return Ok(Err(e.clone())),
        }
    }
    let Some(suite) = analysis.roles.first().and_then(|role| plan.suite(role)) else {
        return Ok(Err(CellError::Missing("no suite to be timed on".to_string())));
    };
    let planned = &plan.suites[suite];
    let origin = |(_, s, j): (_, usize, usize)| {
        let (sequence, run) = (planned.sequences[s].sequence.clone(), plan.jobs[j].run);
        ReverseSource {
            frames: context.frames.clone(),
            setup: setup.setup.clone(),
            run,
            seed: recipes::track_seed(plan.experiment, &sequence, setup, run),
            sequence,
            data_root: context.options.data_root.clone(),
        }
    };
    let origins: Vec<ReverseSource> =
        track::learned_from(plan, tracks, suite, tracker).into_iter().map(origin).collect();
    let (plugin, name) = (analysis.plugin.clone(), planned.name.clone());
    let work = move || {
        let mut timings = Vec::new();
        for repeat in 0..repeats {
            for origin in &origins {
                timings.push(Timing { repeat, ..time(origin, &methods)? });
            }
        }
        let tracks = Population { suite: &name, tracks: Vec::new(), trajectories: Vec::new(), timings };
        plugin.analyze(&[tracks]).map_err(|e| e.to_string())
    };
    let findings = run_single(&context.options.limits, work)?;
    let suites = vec![(planned.name.clone(), planned.sequences.len())];
    Ok(findings.map_err(CellError::Failed).map(|findings| Analysed {
        analysis: analysis.name.clone(),
        tracker: setup.label.clone(),
        runs: setup.training_runs,
        suites,
        findings,
    }))
}

/// Runs `work` and adds what it took.
fn clocked<T>(spent: &mut Duration, work: impl FnOnce() -> T) -> T {
    let start = Instant::now();
    let done = work();
    *spent += start.elapsed();
    done
}

/// One pass over one track.
fn time(origin: &ReverseSource, methods: &[Timed]) -> Result<Timing, String> {
    let ReverseSource { sequence, setup, run, seed, data_root, .. } = origin;
    let data_root = data_root.as_deref();
    let context = RunContext { sequence, start_frame: 0, run: *run, seed: *seed, data_root };
    let mut tracker: Option<Box<dyn Tracker>> = None;
    let first = sequence.truth.first().and_then(Option::as_ref);
    let first = first.ok_or("the first frame has no ground truth to start from")?;
    let goes_back = methods.iter().any(|m| m.ready_detector.fixed.detector.needs_reverse());
    let mut sessions: Vec<Option<Box<dyn Session>>> =
        methods.iter().map(|m| m.signal.as_ref().map(|s| s.signal.start())).collect();
    let mut signals = vec![Vec::new(); methods.len()];
    let (mut tracking, mut reading) = (Duration::ZERO, vec![Duration::ZERO; methods.len()]);
    let (mut regions, mut forks) = (Vec::new(), Vec::new());
    for t in 0..sequence.len() {
        let frame = origin.frames.frame(sequence, t).map_err(|e| e.to_string())?;
        let step = || match &mut tracker {
            Some(tracker) => tracker.update(&frame),
            None => setup.start(&context, &frame, first).map(|(started, state)| {
                tracker = Some(started);
                state
            }),
        };
        let state: TrackerState = clocked(&mut tracking, step).map_err(|e| e.to_string())?;
        for ((session, series), spent) in sessions.iter_mut().zip(&mut signals).zip(&mut reading) {
            let read = || session.as_mut().map_or(0.0, |s| s.push(&frame, &state));
            series.push(clocked(spent, read));
        }
        if goes_back {
            forks.push(tracker.as_ref().and_then(|tracker| tracker.fork(None)).ok_or(reverse::CANNOT)?);
        }
        regions.push(state.region);
    }
    let error = vec![f64::NAN; sequence.len()];
    let mut spent = Vec::new();
    for ((method, signal), reading) in methods.iter().zip(&signals).zip(reading) {
        let live = Live::new(origin, &regions, &forks);
        let detector = &method.ready_detector.fixed.detector;
        let mut detecting = Duration::ZERO;
        clocked(&mut detecting, || {
            detector.detect(&Input { signal, error: &error, seed: 0, reverse: Some(&live) })
        });
        if let Some(reason) = live.failure.into_inner() {
            return Err(reason);
        }
        spent.push(Spent {
            signal: reading.as_secs_f64(),
            detection: detecting.saturating_sub(live.inside.get()).as_secs_f64(),
            reverse: live.running.get().as_secs_f64(),
            runs: live.runs.get(),
            frames: live.frames.get(),
        });
    }
    let (frames, tracking) = (sequence.len(), tracking.as_secs_f64());
    Ok(Timing { repeat: 0, frames, tracking, methods: spent })
}

/// The tracker as it was in each frame, to be sent back with the clock on.
struct Live<'a> {
    origin: &'a ReverseSource,
    regions: &'a [Region],
    forks: &'a [Box<dyn Tracker>],
    /// Time in here altogether, and that of the tracker alone, without the decoding of frames.
    inside: Cell<Duration>,
    running: Cell<Duration>,
    runs: Cell<u64>,
    frames: Cell<u64>,
    failure: RefCell<Option<String>>,
}

impl<'a> Live<'a> {
    fn new(origin: &'a ReverseSource, regions: &'a [Region], forks: &'a [Box<dyn Tracker>]) -> Self {
        Self {
            origin,
            regions,
            forks,
            inside: Cell::default(),
            running: Cell::default(),
            runs: Cell::default(),
            frames: Cell::default(),
            failure: RefCell::default(),
        }
    }

    fn run(&self, from: usize, to: usize) -> Result<f64, String> {
        let start = self.forks.get(from).filter(|_| to < from).ok_or("no way back")?;
        let mut running = Duration::ZERO;
        let seed = reverse::seed(self.origin.seed, from);
        let mut tracker = clocked(&mut running, || start.fork(Some(seed))).ok_or(reverse::CANNOT)?;
        let mut region = None;
        for t in (to..from).rev() {
            let frame = self.origin.frames.frame(&self.origin.sequence, t).map_err(|e| e.to_string())?;
            let state = clocked(&mut running, || tracker.update(&frame)).map_err(|e| e.to_string())?;
            region = Some(state.region);
        }
        self.running.set(self.running.get() + running);
        self.runs.set(self.runs.get() + 1);
        self.frames.set(self.frames.get() + (from - to) as u64);
        Ok(overlap::error(&region.ok_or("no way back")?, &self.regions[to]))
    }
}

impl Reverse for Live<'_> {
    fn error(&self, from: usize, to: usize) -> Option<f64> {
        let mut inside = self.inside.get();
        let error = clocked(&mut inside, || self.run(from, to));
        self.inside.set(inside);
        error.map_err(|reason| self.failure.replace(Some(reason))).ok()
    }
}
