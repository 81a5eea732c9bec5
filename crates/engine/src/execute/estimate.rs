//! What is left to be done of an experiment or of a share of it, and how long it may take.
//!
//! A track takes its frames times what a frame of its tracker with its signals has taken before, in earlier runs on the
//! store or in a [`probe`]. Reverse runs, training and analyses come on top.

use super::frame_loop::run_lane;
use super::frame_observer::FrameObserver;
use super::lane::{Companions, Lane, LaneStep};
use super::supervise::run_single;
use super::tracker_run::{TrackerRun, TrackingError};
use super::units::units;
use crate::limits::{Interrupted, RunLimits, Stop};
use crate::observe::costs::{Cost, Costs};
use crate::plan::{CellState, ExperimentPlan, PlannedSequence, Shard, recipes, variants};
use crate::spec::method::{DetectorChoice, SignalChoice};
use crate::store::Store;
use rayon::prelude::*;
use std::path::PathBuf;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};
use trackfail_dataset::frame_cache::FrameCache;
use trackfail_methods::signal::Reads;

/// Work of a run, or of a share of it.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Remaining {
    /// Number of tracks, those that cannot be made left out.
    pub tracks: usize,
    /// Number of those that the store has with all their signals.
    pub tracks_at_hand: usize,
    /// Number of cells in each state, in the order of [`CellState::ALL`].
    pub cells: [usize; 4],
    /// Frames of the tracks that are to be computed.
    pub frames: u64,
    /// Seconds on one core, without reverse runs, training and analyses; `None` where the cost of a tracker is not known.
    pub seconds: Option<f64>,
}

impl Remaining {
    /// Whether the store has all that can be computed.
    pub fn is_done(&self) -> bool {
        let [_, stale, missing, _] = self.cells;
        self.tracks == self.tracks_at_hand && stale + missing == 0
    }

    /// Number of cells.
    pub fn all_cells(&self) -> usize {
        self.cells.iter().sum()
    }
}

/// A plan beside what a store has of it.
pub struct Standing<'p> {
    plan: &'p ExperimentPlan<'p>,
    /// State of each cell, in the order of [`ExperimentPlan::cells`].
    pub states: Vec<CellState>,
    /// Place of the first cell of each sequence among them.
    starts: Vec<usize>,
    /// Whether each track is at hand, suites x sequences x jobs.
    at_hand: Vec<Vec<Vec<bool>>>,
    costs: Costs,
}

impl<'p> Standing<'p> {
    /// Counts the parts of a plan that a store has; `costs` are for the estimates.
    pub fn new(plan: &'p ExperimentPlan<'p>, store: &Store, costs: Costs) -> Self {
        let of_sequence = |suite: usize, planned: &PlannedSequence| -> Vec<bool> {
            (0..plan.jobs.len()).map(|job| plan.is_cached(store, suite, planned, job)).collect()
        };
        let suites = plan.suites.iter().enumerate();
        let at_hand =
            suites.map(|(k, suite)| suite.sequences.par_iter().map(|s| of_sequence(k, s)).collect());
        let mut starts = Vec::new();
        let mut cells = 0;
        for planned in &plan.test().sequences {
            starts.push(cells);
            cells += plan.cells_on(&planned.origin.source).len();
        }
        Self { plan, states: plan.states(store), starts, at_hand: at_hand.collect(), costs }
    }

    /// The work of a run, or of a share. What a method trains is left to the run behind the shares.
    pub fn remaining(&self, shard: Option<Shard>) -> Remaining {
        let plan = self.plan;
        let variants: Vec<_> = variants(plan.experiment).collect();
        let is_mine =
            |v: usize| shard.is_none() || matches!(variants[v].1.detector, DetectorChoice::Given(_));
        let mut left = Remaining { seconds: Some(0.0), ..Remaining::default() };
        for (suite, s, jobs) in units(plan, shard) {
            let planned = &plan.suites[suite].sequences[s];
            for &job in jobs.iter().filter(|job| planned.tracks[**job].is_ok()) {
                left.tracks += 1;
                if self.at_hand[suite][s][job] {
                    left.tracks_at_hand += 1;
                    continue;
                }
                let frames = planned.sequence.len() as u64;
                left.frames += frames;
                let cost = self.costs.per_frame(plan, suite, plan.jobs[job].tracker);
                left.seconds = left.seconds.zip(cost).map(|(sum, cost)| sum + cost * frames as f64);
            }
            if suite == 0 {
                let cells = plan.cells_on(&planned.origin.source);
                let states = cells.iter().zip(&self.states[self.starts[s]..]);
                for (_, state) in states.filter(|((job, v), _)| jobs.contains(job) && is_mine(*v)) {
                    left.cells[*state as usize] += 1;
                }
            }
        }
        left
    }

    /// Suites and trackers with tracks that are to be computed, whose cost is not known.
    pub fn unknown_costs(&self) -> Vec<(usize, usize)> {
        let mut found = Vec::new();
        for (suite, of_suite) in self.at_hand.iter().enumerate() {
            for (planned, at_hand) in self.plan.suites[suite].sequences.iter().zip(of_suite) {
                for (job, _) in at_hand.iter().enumerate().filter(|(_, at_hand)| !**at_hand) {
                    let pair = (suite, self.plan.jobs[job].tracker);
                    if planned.tracks[job].is_ok() && !found.contains(&pair) {
                        found.push(pair);
                    }
                }
            }
        }
        found.retain(|(suite, tracker)| self.costs.per_frame(self.plan, *suite, *tracker).is_none());
        found
    }

    /// Tries the trackers whose cost is not known on a few frames each, see [`probe`]. Returns how many were tried.
    pub fn probe_unknown(&mut self, data_roots: &[PathBuf], stop: &Stop) -> usize {
        let unknown = self.unknown_costs();
        let start = Instant::now();
        for &(suite, tracker) in unknown.iter().take_while(|_| start.elapsed() < PROBES_TIME) {
            if let Some(cost) = probe(self.plan, (suite, tracker), data_roots, stop) {
                self.costs.set(self.plan, suite, tracker, cost);
            }
        }
        unknown.len()
    }
}

/// Time after which no further tracker is tried.
const PROBES_TIME: Duration = Duration::from_secs(60);
/// Frames of a probe.
const PROBE_FRAMES: usize = 12;
/// Time after which a probe takes no further frame.
const PROBE_TIME: Duration = Duration::from_secs(2);
/// Time after which a probe is given up.
const PROBE_LIMIT: Duration = Duration::from_secs(20);

/// Runs a tracker with its signals on the first frames of a suite's first sequence, on one thread, and measures what a
/// frame takes after the first one. `None` where it cannot be run.
pub fn probe(
    plan: &ExperimentPlan<'_>,
    (suite, tracker): (usize, usize),
    data_roots: &[PathBuf],
    stop: &Stop,
) -> Option<Cost> {
    let is_mine = |job: &usize| plan.jobs[*job].tracker == tracker && plan.wants(suite, *job);
    let job = (0..plan.jobs.len()).find(is_mine)?;
    let planned = plan.suites[suite].sequences.iter().find(|s| s.tracks[job].is_ok())?;
    let setup = &plan.experiment.trackers[tracker];
    let run = TrackerRun {
        sequence: planned.sequence.clone(),
        frames: Arc::new(FrameCache::new(0)),
        config: setup.setup.clone(),
        run: plan.jobs[job].run,
        seed: recipes::track_seed(plan.experiment, &planned.sequence, setup, plan.jobs[job].run),
        data_roots: data_roots.to_vec(),
    };
    // Those that read the tracks of other trackers cost little beside these.
    let reads = |k: &usize| {
        plan.signals[*k].signal.reads() != Reads::Companions && plan.wants_signal(suite, planned, job, *k)
    };
    let signals: Vec<SignalChoice> =
        (0..plan.signals.len()).filter(reads).map(|k| plan.signals[k].clone()).collect();
    let limits = RunLimits { timeout: Some(PROBE_LIMIT), stop: stop.clone() };
    let clock = Arc::new(ProbeClock::default());
    let shared = clock.clone();
    let work = move || -> Result<(), TrackingError> {
        let lane = Lane::of_run(run.clone());
        let lane = lane.with_signals(&run.context(), &Companions::default(), signals.iter().map(Some))?;
        let frames = 0..run.sequence.len().min(PROBE_FRAMES);
        run_lane(&run.sequence, &run.frames, frames, lane, &*shared).map(drop)
    };
    // A probe that is cut short has measured what it has seen.
    let _ = run_single(&limits, work);
    let marks = clock.0.lock().unwrap_or_else(PoisonError::into_inner);
    let (first, last) = (marks.first()?, marks.last()?);
    let frames = marks.len() as u64 - 1;
    (frames > 0).then(|| Cost { frames, seconds: last.duration_since(*first).as_secs_f64() })
}

/// Notes when each frame was done.
#[derive(Default)]
struct ProbeClock(Mutex<Vec<Instant>>);

impl FrameObserver for ProbeClock {
    fn check_interrupted(&self) -> Result<(), Interrupted> {
        let marks = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        match marks.first() {
            Some(first) if marks.len() > 2 && first.elapsed() > PROBE_TIME => Err(Interrupted),
            _ => Ok(()),
        }
    }

    fn tracked(&self, _: usize, _: LaneStep<'_>) -> Result<(), TrackingError> {
        Ok(())
    }

    fn frame_done(&self) {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).push(Instant::now());
    }
}

#[cfg(test)]
mod tests;
