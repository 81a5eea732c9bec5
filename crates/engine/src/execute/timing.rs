//! Processing times of methods on the tracks of a suite, on one thread, one track after the other. What is
//! timed is described at [`processing_time`](trackfail_methods::analysis::processing_time).

use super::analyse::{self, Analyses, Made};
use super::context::Context;
use super::judge::ReadyDetectors;
use super::pass::blank;
use super::reverse::{self, Reversal, clocked};
use super::supervise::run_single;
use super::track::Tracks;
use super::tracker_run::TrackerRun;
use crate::error::{CellError, RunError, StepError};
use crate::plan::variants;
use crate::spec::analysis::Analysis;
use crate::spec::method::SignalChoice;
use std::cell::Cell;
use std::collections::BTreeSet;
use std::time::Duration;
use trackfail_core::image::Frame;
use trackfail_judge::method::Method;
use trackfail_judge::reader::{SignalReader, columns};
use trackfail_methods::analysis::processing_time::{Spent, Timing};
use trackfail_methods::analysis::{Findings, Population};
use trackfail_methods::detector::Input;
use trackfail_methods::signal::Reads;
use trackfail_methods::tracker::Tracker;

/// Computes all analyses of processing time on all trackers. `tracks` has the tracks of every suite. A failed
/// analysis is an error in its place.
///
/// # Errors
/// When the run is interrupted.
pub fn measure(
    context: &Context<'_>,
    tracks: &[Vec<Tracks>],
    ready: &ReadyDetectors,
) -> Result<Analyses, RunError> {
    let experiment = context.plan.experiment;
    let one = |(a, t): (usize, usize)| {
        let made = make(context, tracks, ready, &experiment.analyses[a], t);
        analyse::analysed(experiment, (a, t), made)
    };
    analyse::pairs(experiment, true).into_iter().map(one).collect()
}

fn make(
    context: &Context<'_>,
    tracks: &[Vec<Tracks>],
    ready: &ReadyDetectors,
    analysis: &Analysis,
    tracker: usize,
) -> Result<Made, StepError> {
    let plan = context.plan;
    let (names, repeats) = analysis.plugin.timed();
    let suite = analysis.roles.first().and_then(|role| plan.suite(role));
    let suite = suite.ok_or_else(|| CellError::Missing("no suite to be timed on".to_string()))?;
    let mut methods = Vec::new();
    for name in names {
        let found = variants(plan.experiment).position(|(m, _)| m.name == *name);
        let unknown = || StepError::failed(format!("there is no method `{name}` to be timed"));
        let v = found.ok_or_else(unknown)?;
        let mine = plan.signals_of(v);
        if let Some(need) = plan.unmet_on(suite, tracker, mine.first().copied()) {
            return Err(need.into());
        }
        let not_run = || CellError::Missing("not run on this tracker".to_string());
        let detector = ready.get(&(v, tracker, 0)).ok_or_else(not_run)?.clone()?;
        let signals: Vec<SignalChoice> = mine.iter().map(|k| plan.signals[*k].clone()).collect();
        if signals.iter().any(|choice| choice.signal.reads() == Reads::Companions) {
            return Err(StepError::failed(format!(
                "`{name}` reads other trackers, and cannot be timed alone"
            )));
        }
        methods.push(Method { name: name.clone(), signals, detector: detector.fixed.clone() });
    }
    let planned = &plan.suites[suite];
    let run = |(s, j): (usize, usize)| context.tracker_run(&planned.sequences[s].sequence, plan.jobs[j]);
    let runs = analysis.runs(0, &plan.experiment.trackers[tracker]);
    let mut timed = plan.of_runs(suite, tracker, runs, None);
    timed.retain(|(s, j)| tracks[suite][*s][*j].is_ok());
    let made_on = timed.iter().map(|(s, _)| *s).collect::<BTreeSet<usize>>().len();
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
    Ok((vec![(planned.name.clone(), made_on)], vec![(made_on, there)], findings))
}

/// A signal with its values on one track.
struct TimedSignal {
    reader: SignalReader,
    values: Vec<f64>,
    spent: Cell<Duration>,
}

/// Times one pass over one track. The tracker and each signal get their own copy of each frame, without
/// cached data of others, so that each is timed as if it ran alone.
fn time(run: &TrackerRun, methods: &[Method]) -> Result<Timing, StepError> {
    let frames = run.sequence.len();
    let goes_back = methods.iter().any(|method| method.detector.detector.facts().needs_reverse);
    let (mut signals, mut reads_pixels) = (Vec::new(), run.config.facts().reads_pixels);
    for choice in methods.iter().flat_map(|method| &method.signals) {
        reads_pixels |= choice.signal.reads() == Reads::Pixels;
        let reader = SignalReader::start(choice, &run.context())?;
        signals.push(TimedSignal { reader, values: Vec::new(), spent: Cell::default() });
    }
    let (mut regions, mut forks, tracking) = (Vec::new(), Vec::new(), Cell::default());
    let mut started: Option<Box<dyn Tracker>> = None;
    for t in 0..frames {
        let frame = if reads_pixels { reverse::frame(run, t)? } else { blank() };
        let alone = Frame::clone(&frame);
        let state = match &mut started {
            None => {
                let (tracker, state) = clocked(&tracking, || run.start(&alone))?;
                started = Some(tracker);
                state
            }
            Some(tracker) => clocked(&tracking, || tracker.update(&alone))?,
        };
        if let Some(tracker) = started.as_deref().filter(|_| goes_back) {
            forks.push(reverse::fork(tracker, None)?);
        }
        for TimedSignal { reader, values, spent } in &mut signals {
            let alone = Frame::clone(&frame);
            let read = clocked(spent, || reader.push(Some(&alone), &state, &[]));
            values.extend(read.map_err(StepError::failed)?);
        }
        regions.push(state.region);
    }
    let reversal = Reversal::apart(run.clone(), regions, forks);
    let (error, zeros) = (vec![f64::NAN; frames], vec![0.0; frames]);
    let mut spent = Vec::new();
    let mut signals = signals.iter();
    for method in methods {
        let mine: Vec<&TimedSignal> = signals.by_ref().take(method.signals.len()).collect();
        let columns = columns(mine.iter().map(|signal| (signal.values.as_slice(), signal.reader.width())));
        let columns: Vec<&[f64]> = columns.iter().map(Vec::as_slice).collect();
        let (signal, more) =
            columns.split_first().map_or((&zeros[..], &[][..]), |(first, more)| (*first, more));
        let input = Input { signal, more, error: &error, seed: 0, reverse: None };
        let detecting = Cell::default();
        clocked(&detecting, || reverse::detect(&*method.detector.detector, input, Some(&reversal)))?;
        let back = reversal.take_cost();
        spent.push(Spent {
            signal: mine.iter().map(|signal| signal.spent.get()).sum::<Duration>().as_secs_f64(),
            detection: detecting.get().saturating_sub(back.waiting).as_secs_f64(),
            reverse: back.tracking.as_secs_f64(),
            runs: back.runs,
            frames: back.frames,
        });
    }
    Ok(Timing { repeat: 0, frames, tracking: tracking.get().as_secs_f64(), methods: spent })
}
