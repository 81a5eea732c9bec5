//! One pass over a sequence: each frame is decoded once and given to every tracker and, with the tracker's state, to
//! every signal.
//!
//! A pass consists of steps of a few frames. In each step, three things run in parallel on idle threads:
//! trackers process the frames of the step, signals process those of the step before, and the frames of the
//! next step are decoded. A *strand*, which is a tracker or a signal, processes one frame after the other. It
//! sees nothing of what other strands do in the same step, so that no result depends on the threads. Signals
//! that read companions use the regions that all trackers gave in earlier steps.

use super::supervise::Job;
use super::tracker_run::TrackerRun;
use crate::error::{CellError, RunError, StepError};
use crate::limits::RunLimits;
use crate::spec::method::SignalChoice;
use rayon::ScopeFifo;
use std::borrow::Cow;
use std::sync::Arc;
use std::time::Duration;
use trackfail_core::image::Frame;
use trackfail_core::region::Region;
use trackfail_judge::reader::{SignalFault, SignalReader};
use trackfail_methods::score::Restarts;
use trackfail_methods::signal::Reads;
use trackfail_methods::tracker::{Status, Tracker, TrackerState};

/// Most frames of a step. Three steps are in memory at once.
const MAX_FRAMES: usize = 5;
/// Most bytes of the decoded frames of a step, unless a single frame has more.
const MAX_BYTES: usize = 20 << 20;
/// Frames of a step in which no pixel is read. Longer steps save overhead where each frame is little work.
const FRAMES_WITHOUT_PIXELS: usize = 64;

/// One task of a pass: a track, signals on it, or both.
pub struct Task<'a> {
    /// Run of the tracker.
    pub run: TrackerRun,
    /// States of the tracker, if they are known and only signals are needed.
    pub states: Option<&'a [TrackerState]>,
    /// Signals to compute.
    pub signals: Vec<&'a SignalChoice>,
    /// For signals that read companions: the label of each companion and the index of its task; `None` if it
    /// has no track.
    pub companions: Vec<(&'a str, Option<usize>)>,
}

/// Result of a task: states, signals and time.
#[derive(Debug)]
pub struct PassOutput {
    /// One state per frame; empty if the states were known before.
    pub states: Vec<TrackerState>,
    /// Values of each signal of the task. A signal fails without its track and the other signals.
    pub signals: Vec<Result<Vec<f64>, CellError>>,
    /// Time of the tracker and the signals, with a share of the decoding.
    pub spent: Duration,
}

type Decoded = Result<Arc<Frame>, StepError>;

/// Frame for those that read no pixels.
pub(super) fn blank() -> Arc<Frame> {
    Arc::new(Frame::new(1, 1, vec![0; 3]))
}

/// Consecutive frames of the sequence, decoded.
#[derive(Default)]
struct Batch {
    first: usize,
    frames: Vec<Decoded>,
}

/// States and failure of a task so far.
struct Progress<'a> {
    job: Job<'a>,
    /// States of all frames, if known before; otherwise those of the steps so far.
    states: Cow<'a, [TrackerState]>,
    /// First frame in which the tracker failed, with the error. Failures of signals are kept apart.
    failure: Option<(usize, StepError)>,
}

/// A tracker or a signal, which processes one frame after the other.
struct Strand<'a> {
    task: usize,
    run: &'a TrackerRun,
    reads: Reads,
    work: Work<'a>,
    failure: Option<(usize, StepError)>,
}

enum Work<'a> {
    /// A tracker, `None` until it is started, and its states in the current step.
    Tracker(Option<Box<dyn Tracker>>, Vec<TrackerState>),
    /// A signal, `None` until it is started, and its values in all frames so far.
    Signal(&'a SignalChoice, Option<TrackSignal<'a>>, Vec<f64>),
}

/// Data of one step, shared by all strands.
#[derive(Clone, Copy)]
struct Step<'s> {
    tasks: &'s [Task<'s>],
    progress: &'s [Progress<'s>],
    /// Frames of the step before, which signals process.
    before: &'s Batch,
    /// Frames of this step, which trackers process.
    now: &'s Batch,
}

impl<'a> Strand<'a> {
    /// Creates the strands of a task.
    fn all_of(task: usize, Task { run, states, signals, .. }: &'a Task<'_>) -> Vec<Self> {
        let strand = |reads, work| Self { task, run, reads, work, failure: None };
        let mut strands = Vec::new();
        if states.is_none() {
            let reads = if run.config.facts().reads_pixels { Reads::Pixels } else { Reads::Boxes };
            strands.push(strand(reads, Work::Tracker(None, Vec::new())));
        }
        let signal =
            |choice: &&'a SignalChoice| strand(choice.signal.reads(), Work::Signal(choice, None, Vec::new()));
        strands.extend(signals.iter().map(signal));
        strands
    }

    /// True if the task still needs the strand in frame `t` and later.
    fn is_needed(&self, t: usize, progress: &[Progress<'_>]) -> bool {
        self.failure.is_none() && progress[self.task].failure.as_ref().is_none_or(|(first, _)| t <= *first)
    }

    /// Processes the frames of a step from the `k`-th one on. Each frame is a job of its own in the thread
    /// pool, so that threads share the work evenly.
    fn take<'s>(&'s mut self, k: usize, step: Step<'s>, scope: &ScopeFifo<'s>) {
        let Batch { first, frames } = if let Work::Tracker(..) = self.work { step.now } else { step.before };
        let Some(frame) = frames.get(k).filter(|_| self.is_needed(*first, step.progress)) else { return };
        let t = first + k;
        match step.progress[self.task].job.step(|| self.work_in(t, frame, step)) {
            Ok(true) => scope.spawn_fifo(move |scope| self.take(k + 1, step, scope)),
            Ok(false) => {}
            Err(e) => self.failure = Some((t, e)),
        }
    }

    /// Processes frame `t`. Returns `false` if a track that the strand reads has ended before.
    fn work_in(&mut self, t: usize, frame: &Decoded, step: Step<'_>) -> Result<bool, StepError> {
        // Nothing that another strand reads may change this one.
        let unread = (frame.is_err() && self.reads != Reads::Pixels).then(|| Ok(blank()));
        let frame = || unread.as_ref().unwrap_or(frame).as_ref().map_err(StepError::clone);
        let (run, companions) = (self.run, &step.tasks[self.task].companions);
        match &mut self.work {
            Work::Tracker(Some(tracker), states) => states.push(tracker.update(frame()?)?),
            Work::Tracker(tracker, states) => {
                let (started, state) = run.start(frame()?)?;
                *tracker = Some(started);
                states.push(state);
            }
            Work::Signal(choice, signal, values) => {
                let state = |task: usize| step.progress[task].states.get(t);
                let Some(own) = state(self.task) else { return Ok(false) };
                let mut others: Vec<&Region> = Vec::new();
                for (_, companion) in companions.iter().filter(|_| self.reads == Reads::Companions) {
                    let Some(other) = companion.and_then(state) else { return Ok(false) };
                    others.push(&other.region);
                }
                let signal = match signal {
                    Some(signal) => signal,
                    none => none.insert(TrackSignal::start(choice, run)?),
                };
                values.extend(signal.values(frame()?, own, &others, run.sequence.number(t))?);
            }
        }
        Ok(true)
    }
}

/// A signal that is computed frame by frame on a track. Depending on its choice it begins again at each
/// restart of the tracker.
struct TrackSignal<'a> {
    choice: &'a SignalChoice,
    run: &'a TrackerRun,
    reader: SignalReader,
    /// Values of the last frame since the tracker was started. Skipped frames repeat them if restarts begin
    /// new tracks.
    last: Option<Vec<f64>>,
}

impl<'a> TrackSignal<'a> {
    /// Starts a signal on the track of a run.
    ///
    /// # Errors
    /// When the signal cannot start, for example because a file that it reads is absent.
    fn start(choice: &'a SignalChoice, run: &'a TrackerRun) -> Result<Self, StepError> {
        Ok(Self { choice, run, reader: SignalReader::start(choice, &run.context())?, last: None })
    }

    /// Values of the signal in the next frame, whose file name has this number. `companions` are the regions
    /// of other trackers, for signals that read them.
    ///
    /// # Errors
    /// When the signal has no value in the frame.
    fn values(
        &mut self,
        frame: &Frame,
        state: &TrackerState,
        companions: &[&Region],
        number: u32,
    ) -> Result<Vec<f64>, StepError> {
        match (state.status, &self.last) {
            (Status::Skipped, Some(last)) => return Ok(last.clone()),
            (Status::Initialized, Some(_)) => *self = Self::start(self.choice, self.run)?,
            _ => {}
        }
        let values = self.reader.push(Some(frame), state, companions).map_err(|fault| match fault {
            SignalFault::Broke(fault) => fault.into(),
            fault => StepError::Here(fault.in_frame(number)),
        })?;
        if self.choice.restarts == Restarts::NewTrack
            && (self.last.is_some() || state.status == Status::Initialized)
        {
            self.last = Some(values.clone());
        }
        Ok(values)
    }
}

/// Runs tasks on one sequence in one pass and returns a result for each, in order. A task that panics, fails
/// or runs out of time fails alone. `on_frame` is called after each frame.
///
/// # Errors
/// [`RunError::Interrupted`].
pub fn pass(
    tasks: &[Task<'_>],
    limits: &RunLimits,
    on_frame: &dyn Fn(),
) -> Result<Vec<Result<PassOutput, CellError>>, RunError> {
    let Some(run) = tasks.first().map(|task| &task.run) else { return Ok(Vec::new()) };
    let (mut progress, mut strands): (Vec<Progress<'_>>, Vec<Strand<'_>>) = (Vec::new(), Vec::new());
    for (k, task) in tasks.iter().enumerate() {
        let states = task.states.map_or_else(Cow::default, Cow::Borrowed);
        progress.push(Progress { job: Job::new(limits), states, failure: None });
        strands.extend(Strand::all_of(k, task));
    }
    let decoding = Job::new(limits);
    let decode = |t: usize| decoding.step(|| run.frame(t));
    let (mut before, mut now, mut length) = (Batch::default(), Batch::default(), 1);
    loop {
        if limits.stop.is_set() {
            return Err(RunError::Interrupted);
        }
        let needed = strands.iter().filter(|strand| strand.is_needed(before.first, &progress));
        let reads: Vec<Reads> = needed.map(|strand| strand.reads).collect();
        if before.first == run.sequence.len() || reads.is_empty() {
            break;
        }
        let reads_pixels = reads.contains(&Reads::Pixels);
        let first = now.first + now.frames.len();
        let count =
            (run.sequence.len() - first).min(if reads_pixels { length } else { FRAMES_WITHOUT_PIXELS });
        let mut next: Vec<Option<Decoded>> = vec![(!reads_pixels).then(|| Ok(blank())); count];
        let step = Step { tasks, progress: &progress, before: &before, now: &now };
        rayon::scope_fifo(|scope| {
            for strand in &mut strands {
                scope.spawn_fifo(move |scope| strand.take(0, step, scope));
            }
            for (t, slot) in (first..).zip(&mut next).filter(|(_, slot)| slot.is_none()) {
                scope.spawn_fifo(move |_| *slot = Some(decode(t)));
            }
        });
        for strand in &mut strands {
            let one = &mut progress[strand.task];
            if let Work::Tracker(_, states) = &mut strand.work {
                one.states.to_mut().append(states);
                one.failure = one.failure.take().or_else(|| strand.failure.clone());
            }
        }
        before.frames.iter().for_each(|_| on_frame());
        let next = Batch { first, frames: next.into_iter().flatten().collect() };
        let largest = next.frames.iter().flatten().map(|frame| frame.bytes().len()).max();
        length = (MAX_BYTES / largest.unwrap_or(1).max(1)).clamp(1, MAX_FRAMES);
        before = std::mem::replace(&mut now, next);
    }
    Ok(outputs(tasks, progress, strands, decoding.spent()))
}

/// Results of the tasks after a pass; `decoding` is the time that decoding took.
fn outputs(
    tasks: &[Task<'_>],
    progress: Vec<Progress<'_>>,
    strands: Vec<Strand<'_>>,
    decoding: Duration,
) -> Vec<Result<PassOutput, CellError>> {
    let failed = |task: usize, e: StepError| e.on(&tasks[task].run.sequence.name);
    let lacks = |task: usize| {
        let has_failed = |companion: &Option<usize>| companion.is_none_or(|c| progress[c].failure.is_some());
        let first = tasks[task].companions.iter().find(|(_, companion)| has_failed(companion));
        first.map(|(label, _)| StepError::failed(format!("there is no track of its companion {label}")))
    };
    let mut signals: Vec<Vec<Result<Vec<f64>, CellError>>> = tasks.iter().map(|_| Vec::new()).collect();
    for Strand { task, reads, work, failure, .. } in strands {
        if let Work::Signal(_, _, values) = work {
            let alone = lacks(task).filter(|_| reads == Reads::Companions).or(failure.map(|(_, e)| e));
            signals[task].push(alone.map_or(Ok(values), |e| Err(failed(task, e))));
        }
    }
    let trackers = tasks.iter().filter(|task| task.states.is_none()).count();
    let share = decoding / u32::try_from(trackers.max(1)).unwrap_or(u32::MAX);
    let output = |(task, (one, signals)): (usize, (Progress<'_>, _))| match (one.failure, one.states) {
        (Some((_, e)), _) => Err(failed(task, e)),
        (None, states) => {
            let states = if let Cow::Owned(states) = states { states } else { Vec::new() };
            Ok(PassOutput { states, signals, spent: one.job.spent() + share })
        }
    };
    progress.into_iter().zip(signals).enumerate().map(output).collect()
}

#[cfg(test)]
mod tests;
