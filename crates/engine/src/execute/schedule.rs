//! The order in which the work on a sequence is done, by one thread or by several.
//!
//! A lane is split into *strands*: its tracker, and each of its signals. A strand takes the frames in order; a signal
//! takes a frame after its tracker. A thread always takes the strand that is furthest behind, and decodes the next frame
//! when no strand has one to go on with; so one thread alone goes frame by frame. At most [`MAX_FRAMES`] and about
//! [`MAX_BYTES`] of decoded frames are kept at once.
//!
//! No strand sees what the others do, so that the results do not depend on the threads. A lane fails with the error that
//! comes first in the order of one thread, by frame and strand: what comes before an error is always finished.

use super::cores::{Cores, Share};
use super::frame_observer::FrameObserver;
use super::lane::{Lane, LaneSignal, LaneStep, StateSource};
use super::tracker_run::TrackingError;
use crate::limits::Interrupted;
use std::collections::VecDeque;
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::thread::ScopedJoinHandle;
use trackfail_core::image::Frame;
use trackfail_dataset::Sequence;
use trackfail_dataset::frame_cache::FrameCache;
use trackfail_methods::tracker::TrackerState;

/// Maximum number of decoded frames, the one that is furthest behind included.
const MAX_FRAMES: usize = 16;
/// Maximum size of the decoded frames in bytes, unless one frame has more.
const MAX_BYTES: usize = 64 << 20;

/// The work on a sequence.
pub(super) struct Schedule<'a, O> {
    sequence: &'a Arc<Sequence>,
    cache: &'a FrameCache,
    order: Vec<usize>,
    observer: &'a O,
    shared: Mutex<Shared>,
    changed: Condvar,
}

struct Shared {
    strands: Vec<Strand>,
    lanes: Vec<LaneProgress>,
    /// Frames at the places `first..` of the order.
    frames: VecDeque<Slot>,
    first: usize,
    /// Maximum number of frames that are kept.
    max_frames: usize,
    /// Threads that wait for a change.
    waiting: usize,
    /// The work ends before it is done.
    ended: bool,
}

enum Slot {
    Absent,
    Decoding,
    Decoded(Arc<Frame>),
}

/// A tracker or a signal.
struct Strand {
    lane: usize,
    /// 0 for the tracker, from 1 on for the signals.
    rank: usize,
    /// Number of frames done.
    place: usize,
    /// Absent while a thread is at it.
    work: Option<Work>,
}

enum Work {
    Source(StateSource),
    Signal(Option<LaneSignal>),
}

struct LaneProgress {
    reads_pixels: bool,
    /// The tracker's states at the places `first..`.
    states: VecDeque<Arc<TrackerState>>,
    /// Place and rank of the first error, and the error.
    failure: Option<((usize, usize), TrackingError)>,
}

enum Task {
    Decode(usize),
    Step(Step),
}

/// A strand's work in a frame.
struct Step {
    strand: usize,
    lane: usize,
    rank: usize,
    place: usize,
    work: Work,
    frame: Arc<Frame>,
    /// The tracker's state, for a signal.
    state: Option<Arc<TrackerState>>,
}

impl LaneProgress {
    fn fail(&mut self, place: usize, rank: usize, error: TrackingError) {
        if self.is_before_failure(place, rank) {
            self.failure = Some(((place, rank), error));
        }
    }

    fn is_before_failure(&self, place: usize, rank: usize) -> bool {
        self.failure.as_ref().is_none_or(|(first, _)| (place, rank) < *first)
    }
}

impl Shared {
    fn new(lanes: &mut [Result<Lane, TrackingError>]) -> Self {
        let (mut strands, mut progress) = (Vec::new(), Vec::new());
        for (k, entry) in lanes.iter_mut().enumerate() {
            let reads_pixels = entry.as_ref().is_ok_and(Lane::reads_pixels);
            let mut failure = None;
            // The error is replaced when the work ends.
            match std::mem::replace(entry, Err(Interrupted.into())) {
                Ok(Lane { source, signals }) => {
                    let signals = signals.into_iter().map(Work::Signal);
                    for (rank, work) in std::iter::once(Work::Source(source)).chain(signals).enumerate() {
                        strands.push(Strand { lane: k, rank, place: 0, work: Some(work) });
                    }
                }
                Err(e) => failure = Some(((0, 0), e)),
            }
            progress.push(LaneProgress { reads_pixels, states: VecDeque::new(), failure });
        }
        Self {
            strands,
            lanes: progress,
            frames: VecDeque::new(),
            first: 0,
            max_frames: 1,
            waiting: 0,
            ended: false,
        }
    }

    /// Whether a strand has frames before it, of `n`, that its lane needs.
    fn is_pending(&self, strand: &Strand, n: usize) -> bool {
        strand.place < n && self.lanes[strand.lane].is_before_failure(strand.place, strand.rank)
    }

    /// Lets go of frames and states that all have done with; returns the number of frames.
    fn advance(&mut self, n: usize) -> usize {
        let pending = self.strands.iter().filter(|s| self.is_pending(s, n)).map(|s| s.place).min();
        let lives = self.lanes.iter().any(|lane| lane.failure.is_none());
        let first = pending.unwrap_or(if lives { n } else { self.first });
        let passed = first - self.first;
        self.frames.drain(..passed.min(self.frames.len()));
        for lane in &mut self.lanes {
            lane.states.drain(..passed.min(lane.states.len()));
        }
        self.first = first;
        passed
    }

    /// The strand furthest behind among those that can go on.
    fn next_strand(&self, n: usize) -> Option<usize> {
        let can = |strand: &Strand| {
            let at = strand.place - self.first;
            strand.work.is_some()
                && matches!(self.frames.get(at), Some(Slot::Decoded(_)))
                && (strand.rank == 0 || at < self.lanes[strand.lane].states.len())
        };
        let candidates =
            self.strands.iter().enumerate().filter(|(_, s)| self.is_pending(s, n)).filter(|(_, s)| can(s));
        candidates.min_by_key(|(_, s)| s.place).map(|(k, _)| k)
    }

    /// The frame to be decoded next.
    fn next_frame(&self, n: usize) -> Option<usize> {
        let end = n.min(self.first + self.max_frames);
        (self.first..end).find(|p| matches!(self.frames.get(p - self.first), None | Some(Slot::Absent)))
    }

    /// A task that can be done now.
    fn next_task(&mut self, n: usize) -> Option<Task> {
        if let Some(k) = self.next_strand(n) {
            let strand = &mut self.strands[k];
            let Strand { lane, rank, place, .. } = *strand;
            let at = place - self.first;
            let state = (rank > 0).then(|| self.lanes[lane].states[at].clone());
            if let (Some(work), Slot::Decoded(frame)) = (strand.work.take(), &self.frames[at]) {
                let frame = frame.clone();
                return Some(Task::Step(Step { strand: k, lane, rank, place, work, frame, state }));
            }
        }
        let place = self.next_frame(n).filter(|_| self.strands.iter().any(|s| self.is_pending(s, n)))?;
        let at = place - self.first;
        while self.frames.len() <= at {
            self.frames.push_back(Slot::Absent);
        }
        self.frames[at] = Slot::Decoding;
        Some(Task::Decode(place))
    }

    fn is_done(&self, n: usize) -> bool {
        self.ended || self.strands.iter().all(|s| s.work.is_some() && !self.is_pending(s, n))
    }
}

impl<'a, O: FrameObserver> Schedule<'a, O> {
    /// The work of giving the frames in `order` to the lanes, which are moved out of the slice until it is done.
    pub(super) fn new(
        sequence: &'a Arc<Sequence>,
        cache: &'a FrameCache,
        order: Vec<usize>,
        lanes: &mut [Result<Lane, TrackingError>],
        observer: &'a O,
    ) -> Self {
        let shared = Mutex::new(Shared::new(lanes));
        Self { sequence, cache, order, observer, shared, changed: Condvar::new() }
    }

    /// Puts the lanes, or their errors, back.
    ///
    /// # Errors
    /// When the work was interrupted.
    pub(super) fn finish(self, lanes: &mut [Result<Lane, TrackingError>]) -> Result<(), Interrupted> {
        let shared = self.shared.into_inner().unwrap_or_else(PoisonError::into_inner);
        if shared.ended {
            return Err(Interrupted);
        }
        let mut strands = shared.strands.into_iter().peekable();
        for (k, (entry, progress)) in lanes.iter_mut().zip(shared.lanes).enumerate() {
            let (mut source, mut signals) = (None, Vec::new());
            while let Some(strand) = strands.next_if(|s| s.lane == k) {
                match strand.work {
                    Some(Work::Source(s)) => source = Some(s),
                    Some(Work::Signal(s)) => signals.push(s),
                    None => {}
                }
            }
            *entry = match (progress.failure, source) {
                (Some((_, e)), _) => Err(e),
                (None, Some(source)) => Ok(Lane { source, signals }),
                (None, None) => Err(Interrupted.into()),
            };
        }
        Ok(())
    }

    fn lock(&self) -> MutexGuard<'_, Shared> {
        self.shared.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Does all the work on this thread.
    pub(super) fn run_on_this_thread(&self) {
        while let Some(task) = self.wait_for_task(None) {
            self.perform(task);
        }
    }

    /// The next task, as soon as there is one; `None` when all is done, or when a helper's core is needed elsewhere. A
    /// helper gives its core back while it waits.
    fn wait_for_task(&self, mut helper: Option<(&Cores, &mut Option<Share>)>) -> Option<Task> {
        let interrupted = self.observer.check_interrupted().is_err();
        let mut shared = self.lock();
        if interrupted {
            shared.ended = true;
            self.changed.notify_all();
        }
        loop {
            if shared.is_done(self.order.len()) {
                return None;
            }
            if let Some((cores, share)) = &mut helper {
                if share.is_none() {
                    **share = cores.take();
                }
                if share.is_none() || cores.are_crowded() {
                    return None;
                }
            }
            if let Some(task) = shared.next_task(self.order.len()) {
                return Some(task);
            }
            if let Some((_, share)) = &mut helper {
                **share = None;
            }
            shared.waiting += 1;
            shared = self.changed.wait(shared).unwrap_or_else(PoisonError::into_inner);
            shared.waiting -= 1;
        }
    }

    fn perform(&self, task: Task) {
        // A thread that panics must not leave others waiting for it.
        let end = EndOnPanic(self);
        let passed = match task {
            Task::Decode(place) => self.decode(place),
            Task::Step(step) => self.step(step),
        };
        for _ in 0..passed {
            self.observer.frame_done();
        }
        drop(end);
    }

    /// Decodes a frame; returns the number of frames that all are done with now.
    fn decode(&self, place: usize) -> usize {
        let (lanes, wanted) = {
            let shared = self.lock();
            let wanted = shared.lanes.iter().any(|l| l.reads_pixels && l.failure.is_none());
            (shared.lanes.len(), wanted)
        };
        let t = self.order[place];
        let frame = if wanted {
            self.observer.supervise(lanes, || Ok(self.cache.frame(self.sequence, t).map_err(Arc::new)?))
        } else {
            Ok(Arc::new(Frame::from_fn(1, 1, |_, _| [0; 3])))
        };
        let mut shared = self.lock();
        match frame {
            Ok(frame) => {
                shared.max_frames = (MAX_BYTES / frame.bytes().len().max(1)).clamp(1, MAX_FRAMES);
                let at = place - shared.first;
                if let Some(slot) = shared.frames.get_mut(at) {
                    *slot = Slot::Decoded(frame);
                }
            }
            Err(e) => shared.lanes.iter_mut().for_each(|lane| lane.fail(place, 0, e.clone())),
        }
        self.announce(shared)
    }

    /// Gives a frame to a strand; returns the number of frames that all are done with now.
    fn step(&self, step: Step) -> usize {
        let Step { strand, lane, rank, place, mut work, frame, state } = step;
        let t = self.order[place];
        let frame = self.observer.frame(frame);
        let done = self.observer.supervise(lane, || match (&mut work, &state) {
            (Work::Source(source), _) => {
                let state = Arc::new(self.observer.time_tracker(|| source.state(t, &frame))?);
                let step = LaneStep { t, state: state.clone(), tracker: source.tracker() };
                self.observer.tracked(lane, step)?;
                Ok(Some(state))
            }
            (Work::Signal(Some(signal)), Some(state)) => {
                let values = || signal.values(&frame, state, t, self.sequence.number(t));
                let values = self.observer.time_signal(rank - 1, values)?;
                self.observer.measured(lane, rank - 1, &values);
                Ok(None)
            }
            (Work::Signal(_), _) => {
                self.observer.measured(lane, rank - 1, &[0.0]);
                Ok(None)
            }
        });
        let mut shared = self.lock();
        shared.strands[strand].work = Some(work);
        match done {
            Ok(found) => {
                shared.strands[strand].place = place + 1;
                shared.lanes[lane].states.extend(found);
            }
            Err(e) => shared.lanes[lane].fail(place, rank, e),
        }
        self.announce(shared)
    }

    fn announce(&self, mut shared: MutexGuard<'_, Shared>) -> usize {
        let passed = shared.advance(self.order.len());
        if shared.waiting > 0 {
            self.changed.notify_all();
        }
        passed
    }
}

impl<O: FrameObserver + Sync> Schedule<'_, O> {
    /// Does the work on this thread and on cores that are free.
    pub(super) fn work_on(&self, cores: &Cores) {
        let (strands, reads_pixels) = {
            let shared = self.lock();
            (shared.strands.len(), shared.lanes.iter().any(|lane| lane.reads_pixels))
        };
        // Without pixels there is too little to do.
        let most = if reads_pixels { strands.min(cores.total().saturating_sub(1)) } else { 0 };
        std::thread::scope(|scope| {
            let mut helpers: Vec<ScopedJoinHandle<'_, ()>> = Vec::new();
            while let Some(task) = self.wait_for_task(None) {
                helpers.retain(|helper| !helper.is_finished());
                if helpers.len() < most
                    && let Some(share) = cores.take()
                {
                    helpers.push(scope.spawn(|| self.help(cores, share)));
                }
                self.perform(task);
            }
        });
    }

    fn help(&self, cores: &Cores, share: Share) {
        let mut share = Some(share);
        while let Some(task) = self.wait_for_task(Some((cores, &mut share))) {
            self.perform(task);
        }
    }
}

/// Ends the work when it is dropped by a panic.
struct EndOnPanic<'a, 'b, O: FrameObserver>(&'a Schedule<'b, O>);

impl<O: FrameObserver> Drop for EndOnPanic<'_, '_, O> {
    fn drop(&mut self) {
        if std::thread::panicking() {
            self.0.lock().ended = true;
            self.0.changed.notify_all();
        }
    }
}
