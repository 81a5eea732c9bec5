//! Protocols under which a tracker is run: the frames in which it starts, and restarts after it has lost its
//! target. Any tracker can be run under any protocol; `protocol` of a `[[tracker]]` chooses one.
//!
//! | protocol | runs | description |
//! |---|---|---|
//! | `one-pass` | any | started on the truth of the first frame, never again (OTB: OPE) |
//! | `vot-reset` | any (15) | if the overlap with the truth is 0, the frame is a failure; 5 frames later the tracker restarts on the truth (VOT2013 to 2019, baseline) |
//! | `vot-reset-2014` | any (15) | the same, overlaps counted in pixels as the toolkit of 2014 did |
//! | `vot-region-noise` | any (15) | as `vot-reset`, each start on a box that is moved, scaled and turned at random |
//! | `otb-temporal` | 20 | run r starts at the r-th of 20 frames (OTB: TRE) |
//! | `otb-spatial` | 12 | run r starts in the first frame on a shifted or scaled box (OTB: SRE) |
//!
//! **Resets.** After each frame except those of starts, the overlap of answer and truth is computed, by exact
//! areas on the frame or, for `vot-reset-2014`, by [`Areas::Raster2014`] also beyond it; 0 is a failure. The
//! failing region is kept with [`Status::Failed`], the frames f + 1 ... f + 4 repeat it as
//! [`Status::Skipped`], and in f + 5 the tracker is started again, with the same seed; it does not see the
//! frames between. A start needs a truth: frames without one are skipped as well, and no failure is found in
//! them. (Kristan et al., VOT2014.)
//!
//! **Region noise.** Each start box is the truth's rectangle, its sides times U(.9, 1.1), its center moved by
//! U(-.1, .1) of the sides, turned by U(-.1, .1) rad; from the track's seed (VOT2014).
//!
//! **Temporal.** Run r of 20 starts in frame `floor(r (n - 1) / 20)`, 0-based, or the next annotated one, or the last
//! one if there is none. The frames before are [`Status::Waiting`]. The toolkit takes its start frames from a list that
//! came with its results and is not public for all sequences; equal steps follow the paper (Wu, Lim, Yang, 2013: "20 segments").
//!
//! **Spatial.** Runs 0 to 7 move the box by a tenth of its size to the left, right, up, down and the four
//! corners, runs 8 to 11 scale it about its center by .8, .9, 1.1 and 1.2 (the same).

use super::color_particle_filter;
use super::{Facts, RunContext, StartResult, Status, Tracker, TrackerConfig, TrackerError, TrackerState};
use crate::image::Frame;
use crate::num::seed;
use crate::plugin::Configured;
use crate::region::{Areas, Rect, Region};
use crate::sequence::SequenceInfo;
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use std::path::PathBuf;
use std::sync::Arc;

/// Protocol under which a tracker is run.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum RunProtocol {
    /// Started once, in the first frame.
    OnePass,
    /// Restarted five frames after each failure.
    VotReset,
    /// Like [`Self::VotReset`], with overlaps by the raster rule of 2014.
    VotReset2014,
    /// Like [`Self::VotReset`], with disturbed start boxes.
    VotRegionNoise,
    /// Started in a different frame in each run.
    OtbTemporal,
    /// Started on a different box in each run.
    OtbSpatial,
}

/// Number of frames from a failure to the next start.
const SKIPPED: usize = 5;
/// Number of start frames of [`RunProtocol::OtbTemporal`].
pub const TEMPORAL_RUNS: u32 = 20;
/// Number of start boxes of [`RunProtocol::OtbSpatial`].
pub const SPATIAL_RUNS: u32 = 12;

impl RunProtocol {
    /// All protocols.
    pub const ALL: [Self; 6] = [
        Self::OnePass,
        Self::VotReset,
        Self::VotReset2014,
        Self::VotRegionNoise,
        Self::OtbTemporal,
        Self::OtbSpatial,
    ];

    /// Name of the protocol in experiment files.
    pub fn name(self) -> &'static str {
        match self {
            Self::OnePass => "one-pass",
            Self::VotReset => "vot-reset",
            Self::VotReset2014 => "vot-reset-2014",
            Self::VotRegionNoise => "vot-region-noise",
            Self::OtbTemporal => "otb-temporal",
            Self::OtbSpatial => "otb-spatial",
        }
    }

    /// Summary in one line, for `trackfail list`.
    pub fn summary(self) -> &'static str {
        match self {
            Self::OnePass => "started on the truth of the first frame, never again (OTB: OPE)",
            Self::VotReset => "started anew five frames after a frame without overlap (VOT baseline)",
            Self::VotReset2014 => "the same, overlaps counted in pixels as the toolkit of 2014 did",
            Self::VotRegionNoise => "as vot-reset, on boxes moved, scaled and turned at random (VOT2014)",
            Self::OtbTemporal => "20 runs that start in different frames (OTB: TRE)",
            Self::OtbSpatial => "12 runs that start on shifted and scaled boxes (OTB: SRE)",
        }
    }

    /// Version, part of the address of a track under any protocol but `one-pass`.
    /// - 1: first version.
    /// - 2, of `vot-reset-2014`: pixels are counted from the corner of both regions.
    fn version(self) -> u32 {
        if self == Self::VotReset2014 { 2 } else { 1 }
    }

    /// Protocol of this name; `None` if it is unknown.
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|p| p.name() == name)
    }

    /// Number of runs; `None` if the protocol does not fix it.
    pub fn runs(self) -> Option<u32> {
        match self {
            Self::OtbTemporal => Some(TEMPORAL_RUNS),
            Self::OtbSpatial => Some(SPATIAL_RUNS),
            _ => None,
        }
    }

    /// Wraps the tracker so that it runs under this protocol.
    pub fn over(self, setup: Configured<dyn TrackerConfig>) -> Configured<dyn TrackerConfig> {
        if self == Self::OnePass {
            return setup;
        }
        let params = setup.params();
        let under = Under { protocol: self, config: setup.plugin };
        let mut setup = Configured::<dyn TrackerConfig>::new(params, Arc::new(under));
        setup.show("protocol", format!("{}/{}", self.name(), self.version()));
        setup
    }
}

/// A tracker under a protocol.
struct Under {
    protocol: RunProtocol,
    config: Arc<dyn TrackerConfig>,
}

impl TrackerConfig for Under {
    fn facts(&self) -> Facts {
        let facts = self.config.facts();
        // A failure is one within the frame, whose size is needed.
        let exact = matches!(self.protocol, RunProtocol::VotReset | RunProtocol::VotRegionNoise);
        Facts {
            uses_seed: facts.uses_seed || self.protocol == RunProtocol::VotRegionNoise,
            uses_run: facts.uses_run || self.protocol.runs().is_some(),
            needs_truth: false,
            reads_pixels: exact || facts.reads_pixels,
            ..facts
        }
    }

    fn gives_confidence(&self, context: &RunContext<'_>) -> bool {
        self.config.gives_confidence(context)
    }

    fn inputs(&self, context: &RunContext<'_>) -> Result<Vec<PathBuf>, TrackerError> {
        self.config.inputs(context)
    }

    fn start(&self, context: &RunContext<'_>, frame: &Frame, region: &Region) -> StartResult {
        let truth = context.sequence.truth();
        let first = match self.protocol {
            RunProtocol::OtbTemporal => start_frame(truth, context.run),
            _ => 0,
        };
        let mut tracker = Supervised {
            protocol: self.protocol,
            config: self.config.clone(),
            sequence: context.sequence.shared(),
            run: context.run,
            seed: context.seed,
            data_roots: context.data_roots.to_vec(),
            first,
            rng: seed::rng(seed::seed(context.seed, &["region noise"])),
            frame: 0,
            phase: Phase::Stopped { until: first },
            last: None,
        };
        let state = tracker.step(frame, Some(region).filter(|_| first == 0))?;
        Ok((Box::new(tracker), state))
    }
}

/// Index of the frame in which a run of the temporal protocol starts.
fn start_frame(truth: &[Option<Region>], run: u32) -> usize {
    let at = run as usize * truth.len().saturating_sub(1) / TEMPORAL_RUNS as usize;
    (at..truth.len()).chain((0..at).rev()).find(|t| truth[*t].is_some()).unwrap_or(0)
}

/// Start box of a run of the spatial protocol.
fn spatial(rect: Rect, run: u32) -> Rect {
    let (dx, dy) = (0.1 * rect.w, 0.1 * rect.h);
    let scaled = |k: f64| {
        let (w, h) = (k * rect.w, k * rect.h);
        Rect::new(rect.x + (rect.w - w) / 2.0, rect.y + (rect.h - h) / 2.0, w, h)
    };
    let shifts = [(-dx, 0.0), (dx, 0.0), (0.0, -dy), (0.0, dy), (-dx, -dy), (dx, -dy), (-dx, dy), (dx, dy)];
    let run = run as usize;
    match shifts.get(run) {
        Some((dx, dy)) => rect.shifted(*dx, *dy),
        None => scaled([0.8, 0.9, 1.1, 1.2][(run - shifts.len()).min(3)]),
    }
}

/// A box moved, scaled and turned at random, as described at the head of this file.
fn disturbed(rect: Rect, rng: &mut ChaCha8Rng) -> Region {
    let mut draw = |low: f64, high: f64| rng.random_range(low..high);
    let (w, h) = (rect.w * draw(0.9, 1.1), rect.h * draw(0.9, 1.1));
    let (x, y) = rect.center();
    let (x, y) = (x + rect.w * draw(-0.1, 0.1), y + rect.h * draw(-0.1, 0.1));
    color_particle_filter::region(&[x, y, w / 2.0, h / 2.0, draw(-0.1, 0.1)])
}

/// A tracker that is started, and restarted after failures.
struct Supervised {
    protocol: RunProtocol,
    config: Arc<dyn TrackerConfig>,
    sequence: Arc<dyn SequenceInfo>,
    run: u32,
    seed: u64,
    data_roots: Vec<PathBuf>,
    /// Index of the first start frame.
    first: usize,
    /// Random stream for the noise of start boxes, which continues over all starts.
    rng: ChaCha8Rng,
    /// Index of the next frame.
    frame: usize,
    phase: Phase,
    /// Last answer of the tracker.
    last: Option<Region>,
}

/// Phase of the run: the tracker is running or stopped.
enum Phase {
    Running(Box<dyn Tracker>),
    /// The tracker starts in frame `until`, or the next one with a truth.
    Stopped {
        until: usize,
    },
}

impl Supervised {
    /// True if the protocol restarts a tracker after a failure.
    fn restarts(&self) -> bool {
        use RunProtocol::{VotRegionNoise, VotReset, VotReset2014};
        matches!(self.protocol, VotReset | VotRegionNoise | VotReset2014)
    }

    /// True if an answer is a failure; only under protocols with restarts.
    fn is_failure(&self, region: &Region, frame: &Frame) -> bool {
        let (areas, frame) = match self.protocol {
            RunProtocol::VotReset | RunProtocol::VotRegionNoise => {
                (Areas::Exact, Some((frame.width(), frame.height())))
            }
            RunProtocol::VotReset2014 => (Areas::Raster2014, None),
            _ => return false,
        };
        self.truth(self.frame).is_some_and(|truth| areas.overlap(region, truth, frame) <= 0.0)
    }

    fn truth(&self, t: usize) -> Option<&Region> {
        self.sequence.truth().get(t).and_then(Option::as_ref)
    }

    /// Region to start with in this frame: `given`, or else the ground truth if there is one.
    fn start_region(&mut self, given: Option<&Region>) -> Option<Region> {
        let region = given.or(self.truth(self.frame)).cloned()?;
        Some(match self.protocol {
            RunProtocol::OtbSpatial => Region::Rect(spatial(region.rect(), self.run)),
            RunProtocol::VotRegionNoise => disturbed(region.rect(), &mut self.rng),
            _ => region,
        })
    }

    /// Processes one frame. `given` is the caller's region of the target in it.
    fn step(&mut self, frame: &Frame, given: Option<&Region>) -> Result<TrackerState, TrackerError> {
        let t = self.frame;
        let start = match self.phase {
            Phase::Stopped { until } if t >= until => self.start_region(given),
            _ => None,
        };
        let mut state = match (&mut self.phase, start) {
            (Phase::Running(tracker), _) => tracker.update(frame)?,
            (Phase::Stopped { .. }, Some(region)) => {
                let context = RunContext {
                    sequence: &*self.sequence,
                    start_frame: t,
                    run: self.run,
                    seed: self.seed,
                    data_roots: &self.data_roots,
                };
                let (tracker, state) = self.config.start(&context, frame, &region)?;
                self.phase = Phase::Running(tracker);
                state
            }
            (Phase::Stopped { .. }, None) => {
                let none = || TrackerError::Broken("no frame has a ground truth to start from".into());
                let status = if self.last.is_some() { Status::Skipped } else { Status::Waiting };
                let region = self.last.as_ref().or(self.truth(self.first)).cloned().ok_or_else(none)?;
                TrackerState::new(region, status)
            }
        };
        let fails = match state.status {
            Status::Tracked | Status::Repeated => self.is_failure(&state.region, frame),
            Status::Absent => self.restarts() && self.truth(t).is_some(),
            _ => false,
        };
        if fails {
            state.status = Status::Failed;
            self.phase = Phase::Stopped { until: t + SKIPPED };
        }
        self.frame = t + 1;
        if state.status != Status::Waiting {
            self.last = Some(state.region.clone());
        }
        Ok(state)
    }
}

impl Tracker for Supervised {
    fn update(&mut self, frame: &Frame) -> Result<TrackerState, TrackerError> {
        self.step(frame, None)
    }

    fn fork(&self, seed: Option<u64>) -> Option<Box<dyn Tracker>> {
        // Restarts go by the truth of each frame, in their order.
        if self.restarts() {
            return None;
        }
        let phase = match &self.phase {
            Phase::Running(tracker) => Phase::Running(tracker.fork(seed)?),
            // With a seed of its own a copy runs backwards, where the frame of the start never comes.
            Phase::Stopped { .. } if seed.is_some() => Phase::Stopped { until: usize::MAX },
            Phase::Stopped { until } => Phase::Stopped { until: *until },
        };
        Some(Box::new(Self {
            phase,
            config: self.config.clone(),
            sequence: self.sequence.clone(),
            data_roots: self.data_roots.clone(),
            rng: self.rng.clone(),
            last: self.last.clone(),
            ..*self
        }))
    }
}

#[cfg(test)]
mod tests;
