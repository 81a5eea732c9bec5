//! Processing times of methods on the tracks of a suite, on one thread, one track after the other. For what is timed,
//! see [`processing_time`](trackfail_methods::analysis::processing_time).

use super::analyse::{Analysed, NotAnalysed};
use super::context::Context;
use super::frame_loop::{Collected, Collector, run_lane};
use super::frame_observer::FrameObserver;
use super::judge::ReadyDetector;
use super::lane::{Companions, Lane, LaneStep};
use super::reverse;
use super::supervise::run_single;
use super::track::{self, Tracks};
use super::tracker_run::{TrackerRun, TrackingError};
use super::train::ReadyDetectors;
use crate::error::{CellError, RunError, StepError};
use crate::plan::{SignalSet, variants};
use crate::spec::analysis::Analysis;
use crate::spec::method::SignalChoice;
use std::cell::{Cell, RefCell};
use std::collections::BTreeSet;
use std::sync::Arc;
use std::time::{Duration, Instant};
use trackfail_core::image::Frame;
use trackfail_core::region::Region;
use trackfail_judge::reader::columns;
use trackfail_methods::analysis::processing_time::{Spent, Timing};
use trackfail_methods::analysis::{Findings, Population, Reads};
use trackfail_methods::detector::{Input, Reverse};
use trackfail_methods::score::overlap;
use trackfail_methods::tracker::TrackerError;

/// Makes every analysis of the clock, on every tracker; `tracks` has the tracks of every suite. An analysis that fails
/// is an error in its place.
///
/// # Errors
/// When the run is interrupted.
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
                all.push(match make(context, tracks, ready, analysis, t) {
                    Ok(analysed) => Ok(analysed),
                    Err(e) => {
                        let (analysis, tracker) = (analysis.name.clone(), tracker.label.clone());
                        Err(NotAnalysed { analysis, tracker, error: e.cell()? })
                    }
                });
            }
        }
    }
    Ok(all)
}

/// A method to be timed.
#[derive(Clone)]
struct TimedMethod {
    /// Its signals; `None` for one without.
    signals: Vec<Option<SignalChoice>>,
    ready_detector: ReadyDetector,
}

fn make(
    context: &Context<'_>,
    tracks: &[Vec<Tracks>],
    ready: &ReadyDetectors,
    analysis: &Analysis,
    tracker: usize,
) -> Result<Analysed, StepError> {
    let plan = context.plan;
    let setup = &plan.experiment.trackers[tracker];
    let (names, repeats) = analysis.plugin.timed();
    let Some(suite) = analysis.roles.first().and_then(|role| plan.suite(role)) else {
        return Err(CellError::Missing("no suite to be timed on".to_string()).into());
    };
    let mut methods = Vec::new();
    for name in names {
        let found = variants(plan.experiment).position(|(m, _)| m.name == *name);
        let Some(v) = found else {
            return Err(StepError::failed(format!("there is no method `{name}` to be timed")));
        };
        if let Some(need) = plan.unmet_on(suite, tracker, plan.signal(v)) {
            return Err(need.into());
        }
        match &ready[v][tracker][0] {
            Ok(ready_detector) => {
                let SignalSet { first, more } = plan.signals_of(v);
                let all = std::iter::once(*first).chain(more.iter().copied().map(Some));
                let signals = all.map(|k| plan.signals.get(k?).cloned()).collect();
                methods.push(TimedMethod { signals, ready_detector: ready_detector.clone() });
            }
            Err(e) => return Err(e.clone().into()),
        }
    }
    let planned = &plan.suites[suite];
    let run =
        |(_, s, j): (_, usize, usize)| context.tracker_run(&planned.sequences[s].sequence, plan.jobs[j]);
    let timed = track::of_runs(plan, tracks, suite, tracker, setup.training_runs, None);
    let sequences: BTreeSet<usize> = timed.iter().map(|(_, s, _)| *s).collect();
    let runs: Vec<TrackerRun> = timed.into_iter().map(run).collect();
    let (plugin, name) = (analysis.plugin.clone(), planned.name.clone());
    let work = move || -> Result<Findings, StepError> {
        let mut timings = Vec::new();
        for repeat in 0..repeats {
            for run in &runs {
                timings.push(Timing { repeat, ..time(run, &methods)? });
            }
        }
        let (tracks, trajectories) = (Vec::new(), Vec::new());
        let population = Population { suite: &name, tracks, trajectories, timings };
        plugin.analyze(&[population]).map_err(StepError::failed)
    };
    let findings = run_single(&context.options.limits, work)?;
    let there = planned.sequences.len();
    Ok(Analysed {
        analysis: analysis.name.clone(),
        tracker: setup.label.clone(),
        runs: setup.training_runs,
        suites: vec![(planned.name.clone(), sequences.len())],
        shares: if sequences.len() == there { Vec::new() } else { vec![(sequences.len(), there)] },
        findings,
    })
}

/// Runs `work` and adds its time to `spent`.
fn clocked<T>(spent: &Cell<Duration>, work: impl FnOnce() -> T) -> T {
    let start = Instant::now();
    let done = work();
    spent.set(spent.get() + start.elapsed());
    done
}

/// Times the tracker and the signals of a forward run.
struct ForwardClock {
    tracking: Cell<Duration>,
    reading: Vec<Cell<Duration>>,
    /// Keeps a fork of the tracker in each frame.
    forks: Option<RefCell<Vec<Lane>>>,
    collector: Collector,
}

impl FrameObserver for ForwardClock {
    /// A copy, without what other signals keep with the frame: each is timed as if it were alone.
    fn frame(&self, frame: Arc<Frame>) -> Arc<Frame> {
        Arc::new(Frame::clone(&frame))
    }

    fn time_tracker<T>(&self, work: impl FnOnce() -> T) -> T {
        clocked(&self.tracking, work)
    }

    fn time_signal<T>(&self, signal: usize, work: impl FnOnce() -> T) -> T {
        match self.reading.get(signal) {
            Some(spent) => clocked(spent, work),
            None => work(),
        }
    }

    fn tracked(&self, lane: usize, step: LaneStep<'_>) -> Result<(), TrackingError> {
        if let Some(forks) = &self.forks {
            forks.borrow_mut().push(step.fork(None)?);
        }
        self.collector.tracked(lane, step)
    }

    fn measured(&self, lane: usize, signal: usize, values: &[f64]) {
        self.collector.measured(lane, signal, values);
    }
}

/// Times one pass over one track.
fn time(run: &TrackerRun, methods: &[TimedMethod]) -> Result<Timing, TrackingError> {
    let TrackerRun { sequence, frames, .. } = run;
    let goes_back = methods.iter().any(|m| m.ready_detector.fixed.detector.needs_reverse());
    let count = methods.iter().map(|m| m.signals.len()).sum();
    let clock = ForwardClock {
        tracking: Cell::default(),
        reading: vec![Cell::default(); count],
        forks: goes_back.then(RefCell::default),
        collector: Collector::new([count]),
    };
    let lane = Lane::of_run(run.clone());
    let all = methods.iter().flat_map(|m| m.signals.iter().map(Option::as_ref));
    let lane = lane.with_signals(&run.context(), &Companions::default(), all)?;
    run_lane(sequence, frames, 0..sequence.len(), lane, &clock)?;
    let ForwardClock { tracking, reading, forks, collector } = clock;
    let Collected { states, signals } = collector.into_collected().swap_remove(0);
    let regions: Vec<Region> = states.into_iter().map(|state| state.region).collect();
    let forks = forks.map(RefCell::into_inner).unwrap_or_default();
    let error = vec![f64::NAN; sequence.len()];
    let mut spent = Vec::new();
    let mut series = signals.iter().map(Vec::as_slice).zip(reading);
    for method in methods {
        let (mine, reading): (Vec<&[f64]>, Vec<Cell<Duration>>) =
            series.by_ref().take(method.signals.len()).unzip();
        let widths = method.signals.iter().map(|choice| choice.as_ref().map_or(1, |c| c.signal.width()));
        let columns = columns(mine.into_iter().zip(widths));
        let mine: Vec<&[f64]> = columns.iter().map(Vec::as_slice).collect();
        let Some((signal, more)) = mine.split_first() else { continue };
        let timed = TimedReversal::new(run, &regions, &forks);
        let detector = &method.ready_detector.fixed.detector;
        let detecting = Cell::default();
        let output = clocked(&detecting, || {
            detector.detect(&Input { signal, more, error: &error, seed: 0, reverse: Some(&timed) })
        });
        if let Some(failure) = output.failure {
            return Err(TrackerError::Broken(failure).into());
        }
        if let Some(e) = timed.failure.into_inner() {
            return Err(e);
        }
        spent.push(Spent {
            signal: reading.iter().map(|spent| spent.get().as_secs_f64()).sum(),
            detection: detecting.get().saturating_sub(timed.inside.get()).as_secs_f64(),
            reverse: timed.running.get().as_secs_f64(),
            runs: timed.runs.get(),
            frames: timed.frames.get(),
        });
    }
    Ok(Timing { repeat: 0, frames: sequence.len(), tracking: tracking.get().as_secs_f64(), methods: spent })
}

/// Reverse runs from the forks of every frame, with the clock on and without reuse.
struct TimedReversal<'a> {
    run: &'a TrackerRun,
    regions: &'a [Region],
    forks: &'a [Lane],
    /// Time of all calls.
    inside: Cell<Duration>,
    /// Time of the tracker alone, without the decoding of frames.
    running: Cell<Duration>,
    runs: Cell<u64>,
    frames: Cell<u64>,
    failure: RefCell<Option<TrackingError>>,
}

/// Times the tracker of a reverse run, and keeps its last region.
struct ReverseClock {
    running: Cell<Duration>,
    region: RefCell<Option<Region>>,
}

impl FrameObserver for ReverseClock {
    fn time_tracker<T>(&self, work: impl FnOnce() -> T) -> T {
        clocked(&self.running, work)
    }

    fn tracked(&self, _: usize, step: LaneStep<'_>) -> Result<(), TrackingError> {
        self.region.replace(Some(step.state.region.clone()));
        Ok(())
    }
}

impl<'a> TimedReversal<'a> {
    fn new(run: &'a TrackerRun, regions: &'a [Region], forks: &'a [Lane]) -> Self {
        Self {
            run,
            regions,
            forks,
            inside: Cell::default(),
            running: Cell::default(),
            runs: Cell::default(),
            frames: Cell::default(),
            failure: RefCell::default(),
        }
    }

    fn backward(&self, from: usize, to: usize) -> Result<f64, TrackingError> {
        let no_way = TrackingError::NoWayBack { from, to };
        let Some(start) = self.forks.get(from).filter(|_| to < from) else { return Err(no_way) };
        let clock = ReverseClock { running: Cell::default(), region: RefCell::default() };
        let seed = reverse::seed(self.run.seed, from);
        let lane = clocked(&clock.running, || start.fork(Some(seed)))?;
        run_lane(&self.run.sequence, &self.run.frames, (to..from).rev(), lane, &clock)?;
        self.running.set(self.running.get() + clock.running.get());
        self.runs.set(self.runs.get() + 1);
        self.frames.set(self.frames.get() + (from - to) as u64);
        Ok(overlap::error(&clock.region.into_inner().ok_or(no_way)?, &self.regions[to]))
    }
}

impl Reverse for TimedReversal<'_> {
    fn error(&self, from: usize, to: usize) -> Option<f64> {
        let error = clocked(&self.inside, || self.backward(from, to));
        error.map_err(|e| self.failure.replace(Some(e))).ok()
    }
}
