//! Tracks backwards in time: a track's tracker is brought to where it was, and sent back from there.
//!
//! A track as it is kept holds what the tracker said, not what it believed. So the tracker is run forward
//! again, once at most, with forks left behind every few frames; it must say what it said then. From frame
//! `from` on a fork goes back, with random numbers of its own from the track's seed and `from`. All methods
//! on a track share what was run, so neither their number nor their order changes a result.

use crate::dataset::Sequence;
use crate::dataset::frame_cache::FrameCache;
use crate::detector::{Detector, DetectorOutput, Input, Reverse};
use crate::image::Frame;
use crate::num;
use crate::region::Region;
use crate::score::overlap;
use crate::tracker::{RunContext, Tracker, TrackerConfig};
use std::cell::RefCell;
use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// Frames between the forks that are kept on the way forward.
const STRIDE: usize = 32;

/// Bytes of decoded frames that a run keeps for tracks backwards.
pub const FRAMES_IN_MEMORY: usize = 512 << 20;

/// What is said of a tracker without forks.
pub const CANNOT: &str = "this tracker cannot be started from what it believes, so it cannot run backwards";

/// Seed of the way back from a frame; `track` is the track's.
pub fn seed(track: u64, from: usize) -> u64 {
    num::seed::seed(track, &["reverse", &from.to_string()])
}

/// What a track was made with.
#[derive(Clone)]
pub struct ReverseSource {
    /// The sequence.
    pub sequence: Arc<Sequence>,
    /// Where its frames are had from.
    pub frames: Arc<FrameCache>,
    /// The tracker.
    pub setup: Arc<dyn TrackerConfig>,
    /// Repetition, from 0.
    pub run: u32,
    /// Seed of the tracker.
    pub seed: u64,
    /// Folder of result files, if the user gave one.
    pub data_root: Option<PathBuf>,
}

/// The tracker of one track, backwards.
pub struct Reversal {
    origin: ReverseSource,
    regions: Vec<Region>,
    memory: Mutex<Memory>,
}

#[derive(Default)]
struct Memory {
    /// The tracker after some frames of its way forward.
    forward: BTreeMap<usize, Box<dyn Tracker>>,
    /// By start: the errors of the frames before it, the last one first.
    backward: BTreeMap<usize, Vec<f64>>,
    /// The tracker that went back last: its start, and the frame it is in.
    underway: Option<(usize, usize, Box<dyn Tracker>)>,
}

/// A detector's use of a [`Reversal`].
pub struct ReverseHandle<'a> {
    reversal: &'a Reversal,
    failure: RefCell<Option<String>>,
}

impl std::fmt::Debug for Reversal {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "Reversal of a track on {}", self.origin.sequence.name)
    }
}

impl Reversal {
    /// Of a track with these regions.
    pub fn new(origin: ReverseSource, regions: Vec<Region>) -> Self {
        Self { origin, regions, memory: Mutex::default() }
    }

    /// To be lent to a detector.
    pub fn asked(&self) -> ReverseHandle<'_> {
        ReverseHandle { reversal: self, failure: RefCell::new(None) }
    }

    /// Lets go of the trackers; what they said is kept.
    pub fn rest(&self) {
        let mut memory = self.memory();
        memory.forward.clear();
        memory.underway = None;
    }

    fn memory(&self) -> MutexGuard<'_, Memory> {
        self.memory.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn frame(&self, t: usize) -> Result<Arc<Frame>, String> {
        self.origin.frames.frame(&self.origin.sequence, t).map_err(|e| e.to_string())
    }

    /// The tracker after frame `t` of its way forward.
    fn forward(&self, memory: &mut Memory, t: usize) -> Result<Box<dyn Tracker>, String> {
        let fork = |tracker: &dyn Tracker| tracker.fork(None).ok_or_else(|| CANNOT.to_string());
        let (mut at, mut tracker) = match memory.forward.range(..=t).next_back() {
            Some((at, kept)) => (*at, fork(&**kept)?),
            None => {
                let ReverseSource { sequence, setup, run, seed, data_root, .. } = &self.origin;
                let data_root = data_root.as_deref();
                let context = RunContext { sequence, start_frame: 0, run: *run, seed: *seed, data_root };
                let truth = sequence.truth.first().and_then(Option::as_ref);
                let first = truth.ok_or("the first frame has no ground truth to start from")?;
                let started = setup.start(&context, &*self.frame(0)?, first);
                (0, started.map_err(|e| e.to_string())?.0)
            }
        };
        memory.forward.entry(at).or_insert(fork(&*tracker)?);
        while at < t {
            at += 1;
            let state = tracker.update(&*self.frame(at)?).map_err(|e| e.to_string())?;
            if Some(&state.region) != self.regions.get(at) {
                return Err(format!("run again, the tracker gave another answer in frame {at} (from 0)"));
            }
            if at % STRIDE == 0 {
                memory.forward.insert(at, fork(&*tracker)?);
            }
        }
        Ok(tracker)
    }

    /// Error of frame `to` on the way back from `from`, later than `to`.
    fn backward(&self, memory: &mut Memory, from: usize, to: usize) -> Result<f64, String> {
        let known = |memory: &Memory| memory.backward.get(&from).and_then(|e| e.get(from - to - 1)).copied();
        if let Some(error) = known(memory) {
            return Ok(error);
        }
        let (mut at, mut tracker) = match memory.underway.take() {
            Some((start, at, tracker)) if start == from => (at, tracker),
            _ => {
                let start = self.forward(memory, from)?;
                (from, start.fork(Some(seed(self.origin.seed, from))).ok_or(CANNOT)?)
            }
        };
        while at > to {
            at -= 1;
            let state = tracker.update(&*self.frame(at)?).map_err(|e| e.to_string())?;
            let errors = memory.backward.entry(from).or_default();
            // What is run again for an earlier frame says the same of the later ones.
            if errors.len() == from - at - 1 {
                errors.push(overlap::error(&state.region, &self.regions[at]));
            }
        }
        memory.underway = Some((from, at, tracker));
        known(memory).ok_or_else(|| "a frame was not reached".to_string())
    }
}

impl ReverseHandle<'_> {
    /// Why a run broke, if one did.
    pub fn failure(self) -> Option<String> {
        self.failure.into_inner()
    }
}

impl Reverse for ReverseHandle<'_> {
    fn error(&self, from: usize, to: usize) -> Option<f64> {
        let regions = &self.reversal.regions;
        let error = if to < from && from < regions.len() {
            self.reversal.backward(&mut self.reversal.memory(), from, to)
        } else {
            Err(format!("there is no way back from frame {from} to frame {to} (from 0)"))
        };
        error.map_err(|reason| self.failure.borrow_mut().get_or_insert(reason).clone()).ok()
    }
}

/// What a detector says, with the tracker lent to it where it needs it.
///
/// # Errors
/// In words, when the tracker had to be run backwards and that broke.
pub fn detect(
    detector: &dyn Detector,
    input: Input<'_>,
    reversal: Option<&Reversal>,
) -> Result<DetectorOutput, String> {
    let asked = reversal.filter(|_| detector.needs_reverse()).map(Reversal::asked);
    let reverse = asked.as_ref().map(|asked| asked as &dyn Reverse);
    let verdict = detector.detect(&Input { reverse, ..input });
    asked.and_then(ReverseHandle::failure).map_or(Ok(verdict), Err)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::dataset::{Frames, Numbering, Render};
    use crate::plugin;
    use crate::region::Rect;
    use crate::tracker::TRACKERS;

    const FRAMES: usize = 60;

    /// A target of 24 x 24 pixels that moves by a pixel to the right in each frame, on grey: colored squares, one in
    /// the other, so that its colors tell its size, with stripes across, so that a shift is seen.
    struct Square;
    fn place(t: usize) -> Rect {
        Rect::new(20.0 + t as f64, 30.0, 24.0, 24.0)
    }
    impl Render for Square {
        fn render(&self, t: usize) -> Frame {
            let r = place(t);
            Frame::from_fn(140, 90, |x, y| {
                let (x, y) = (x as f64, y as f64);
                let (u, v) = (x + 0.5 - r.x - 12.0, y + 0.5 - r.y - 12.0);
                let stripe = if ((u + v) / 4.0).floor() % 2.0 == 0.0 { 0 } else { 24 };
                match f64::max(u.abs(), v.abs()) {
                    d if d < 5.0 => [30, 180 + stripe, 60],
                    d if d < 9.0 => [40, 40, 190 + stripe],
                    d if d < 12.0 => [200 + stripe, 30, 40],
                    _ => [120, 125, 118],
                }
            })
        }
    }

    fn sequence() -> Arc<Sequence> {
        Arc::new(Sequence {
            name: "square".into(),
            numbering: Numbering { first: 1, official: (1, FRAMES as u32) },
            truth: (0..FRAMES).map(|t| Some(Region::Rect(place(t)))).collect(),
            attributes: vec![],
            frame_attributes: vec![],
            digest: Default::default(),
            frames: Frames::Rendered(Arc::new(Square), FRAMES),
        })
    }

    fn reversal(kind: &str) -> Reversal {
        let entry = plugin::find(TRACKERS, kind).unwrap();
        let setup: Arc<dyn TrackerConfig> = Arc::from(entry.build_from_text(entry.example).unwrap());
        let sequence = sequence();
        let context = RunContext { sequence: &sequence, start_frame: 0, run: 0, seed: 5, data_root: None };
        let frame = |t: usize| sequence.frame(t).unwrap();
        let (mut tracker, first) =
            setup.start(&context, &frame(0), sequence.truth[0].as_ref().unwrap()).unwrap();
        let mut regions = vec![first.region];
        regions.extend((1..FRAMES).map(|t| tracker.update(&frame(t)).unwrap().region));
        let frames = Arc::new(FrameCache::new(1 << 24));
        Reversal::new(ReverseSource { sequence, frames, setup, run: 0, seed: 5, data_root: None }, regions)
    }

    fn ask(reversal: &Reversal, from: usize, to: usize) -> (Option<f64>, Option<String>) {
        let asked = reversal.asked();
        let error = asked.error(from, to);
        (error, asked.failure())
    }

    const POSTERIOR: [&str; 5] = [
        "color-particle-filter",
        "fragments-particle-filter",
        "sparse-prototypes",
        "ivt",
        "adaptive-local-sparse",
    ];

    // Nothing else in the frame looks like the square, so the way back ends where the way forward began.
    #[test]
    fn without_noise_the_way_back_returns_to_the_start() {
        for kind in POSTERIOR {
            let reversal = reversal(kind);
            let (error, failure) = ask(&reversal, 40, 0);
            assert_eq!(failure, None, "{kind}");
            assert!(error.unwrap() < 0.35, "{kind}: {error:?}");
            assert!(
                overlap::error(&reversal.regions[40], &reversal.regions[0]) == 1.0,
                "{kind}: no way to go"
            );
        }
    }

    #[test]
    fn what_was_asked_before_changes_nothing() {
        let asked = [(40, 10), (25, 3), (40, 30), (50, 10), (25, 20)];
        let one = reversal("color-particle-filter");
        let errors = asked.map(|(from, to)| ask(&one, from, to).0.unwrap());
        for (k, (from, to)) in asked.into_iter().enumerate() {
            let fresh = reversal("color-particle-filter");
            assert_eq!(ask(&fresh, from, to).0, Some(errors[k]), "{from} {to}");
        }
        let other = reversal("color-particle-filter");
        let mut turned: Vec<f64> =
            asked.iter().rev().map(|(from, to)| ask(&other, *from, *to).0.unwrap()).collect();
        turned.reverse();
        assert_eq!(turned, errors);
    }

    #[test]
    fn what_cannot_be_run_is_told() {
        let (error, failure) = ask(&reversal("still"), 5, 2);
        assert_eq!(error, None);
        assert!(failure.unwrap().contains("cannot be started from what it believes"));
        let mut one = reversal("color-particle-filter");
        for (from, to) in [(5, 5), (3, 7), (FRAMES, 2)] {
            let (error, failure) = ask(&one, from, to);
            assert!(error.is_none() && failure.unwrap().starts_with("there is no way back"));
        }
        // A track that the tracker does not repeat.
        one.regions[9] = Region::Rect(Rect::new(0.0, 0.0, 1.0, 1.0));
        let failure = "run again, the tracker gave another answer in frame 9 (from 0)".to_string();
        assert_eq!(ask(&one, 12, 2), (None, Some(failure)));
        assert!(ask(&one, 8, 2).0.is_some());
    }
}
