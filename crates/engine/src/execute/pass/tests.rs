//! Passes with trackers that panic, hang or fail, on one core and on several.

use super::*;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::Duration;
use trackfail_core::image::Frame;
use trackfail_core::region::{Rect, Region};
use trackfail_dataset::{Frames, Numbering, Render};
use trackfail_methods::signal::SIGNALS;
use trackfail_methods::tracker::{RunContext, StartResult, Tracker, TrackerConfig, TrackerError};

/// Gray frames; decoding panics from the frame of its number on.
struct Gray {
    good: usize,
    /// Number of the last frame that was decoded, from 1.
    last: AtomicUsize,
}

impl Render for Gray {
    fn render(&self, t: usize) -> Frame {
        assert!(t < self.good, "no frame {t}");
        self.last.fetch_max(t + 1, Ordering::Relaxed);
        Frame::from_fn(32, 24, |x, y| [(x * 7) as u8, (y * 9) as u8, t as u8])
    }
}

fn sequence(good: usize) -> Arc<Sequence> {
    sequence_of(6, &Arc::new(Gray { good, last: AtomicUsize::new(0) }))
}

fn sequence_of(frames: usize, gray: &Arc<Gray>) -> Arc<Sequence> {
    Arc::new(Sequence {
        name: "gray".into(),
        numbering: Numbering { first: 1, official: (1, frames as u32) },
        truth: vec![Some(Region::Rect(Rect::new(4.0, 4.0, 12.0, 10.0))); frames],
        attributes: vec![],
        frame_attributes: vec![],
        digest: Default::default(),
        frames: Frames::Rendered(gray.clone(), frames),
    })
}

/// A tracker that stays where it is, and fails in frame 3 in its own way.
#[derive(Clone, Copy, PartialEq)]
enum Bad {
    Never,
    Panics,
    Hangs,
    Errs,
}

impl TrackerConfig for Bad {
    fn params(&self) -> serde_json::Value {
        serde_json::Value::Null
    }

    fn start(&self, _: &RunContext<'_>, _: &Frame, region: &Region) -> StartResult {
        Ok((Box::new(BadTracker(*self, 0)), TrackerState::initialized(region.clone())))
    }
}

/// The tracker, and the frames it has seen.
struct BadTracker(Bad, u32);

impl Tracker for BadTracker {
    fn update(&mut self, _: &Frame) -> Result<TrackerState, TrackerError> {
        self.1 += 1;
        match self.0 {
            Bad::Panics if self.1 == 3 => panic!("out of wits"),
            Bad::Hangs if self.1 == 3 => loop {
                std::thread::park();
            },
            Bad::Errs if self.1 == 3 => Err(TrackerError::Broken("lost its file".into())),
            _ => Ok(TrackerState::tracked(Region::Rect(Rect::new(4.0, 4.0, 12.0, 10.0)))),
        }
    }
}

fn make(
    configs: &[Bad],
    states: Option<&Arc<Vec<TrackerState>>>,
    limits: &RunLimits,
) -> Vec<Result<PassOutput, CellError>> {
    make_on(1, sequence(6), configs, states, limits)
}

fn make_on(
    cores: usize,
    sequence: Arc<Sequence>,
    configs: &[Bad],
    states: Option<&Arc<Vec<TrackerState>>>,
    limits: &RunLimits,
) -> Vec<Result<PassOutput, CellError>> {
    make_signal("rgb-histogram", cores, sequence, configs, states, limits)
}

fn make_signal(
    kind: &str,
    cores: usize,
    sequence: Arc<Sequence>,
    configs: &[Bad],
    states: Option<&Arc<Vec<TrackerState>>>,
    limits: &RunLimits,
) -> Vec<Result<PassOutput, CellError>> {
    let entry = SIGNALS.iter().find(|e| e.kind == kind).unwrap();
    let signal = SignalChoice {
        kind: entry.kind,
        version: entry.version,
        signal: Arc::from(entry.build_from_text(entry.example).unwrap()),
        restarts: Default::default(),
    };
    let frames = Arc::new(FrameCache::new(0));
    let run = |bad: &Bad| TrackerRun {
        sequence: sequence.clone(),
        frames: frames.clone(),
        config: Arc::new(*bad),
        run: 0,
        seed: 1,
        data_roots: Vec::new(),
    };
    let companions = Arc::default();
    let task = |bad: &Bad| Task {
        run: run(bad),
        states: states.cloned(),
        signals: vec![0],
        companions: Arc::clone(&companions),
    };
    let one = Pass {
        sequence: sequence.clone(),
        frames: frames.clone(),
        signals: Arc::new(vec![signal]),
        tasks: configs.iter().map(task).collect(),
        on_frame: Arc::new(|| {}),
        spent: Arc::new(|_, _| {}),
        cores: Cores::new(cores),
    };
    pass(one, limits).unwrap()
}

const CORES: [usize; 3] = [1, 2, 5];

#[test]
fn a_failing_tracker_fails_no_other() {
    let alone = make(&[Bad::Never], None, &RunLimits::default()).remove(0).unwrap();
    assert_eq!((alone.states.len(), alone.signals[0].len()), (6, 6));
    let limits = RunLimits { timeout: Some(Duration::from_secs(2)), ..RunLimits::default() };
    for cores in CORES {
        let bad = [Bad::Panics, Bad::Never, Bad::Hangs, Bad::Errs, Bad::Never];
        let made = make_on(cores, sequence(6), &bad, None, &limits);
        let reason = |k: usize| made[k].as_ref().unwrap_err().to_string();
        assert!(
            reason(0).starts_with("gray: panicked at crates/engine") && reason(0).ends_with("out of wits"),
            "{}",
            reason(0)
        );
        assert_eq!(reason(2), "gray: took longer than 2 s (--timeout)");
        assert_eq!(reason(3), "lost its file");
        assert_eq!((made[1].as_ref(), made[4].as_ref()), (Ok(&alone), Ok(&alone)));
    }
}

#[test]
fn frames_that_cannot_be_decoded_fail_the_trackers_that_get_to_them() {
    for cores in CORES {
        let bad = [Bad::Never, Bad::Never, Bad::Errs];
        let mut made = make_on(cores, sequence(4), &bad, None, &RunLimits::default());
        assert_eq!(made.remove(2).unwrap_err().to_string(), "lost its file");
        for made in made {
            let reason = made.unwrap_err().to_string();
            assert!(
                reason.starts_with("gray: panicked at crates/engine") && reason.ends_with("no frame 4"),
                "{reason}"
            );
        }
    }
}

#[test]
fn more_cores_change_no_result_and_do_not_decode_far_ahead() {
    let long = || sequence_of(80, &Arc::new(Gray { good: 80, last: AtomicUsize::new(0) }));
    let limits = RunLimits::default();
    let made = CORES.map(|cores| make_on(cores, long(), &[Bad::Never; 4], None, &limits));
    assert!(made[0].iter().all(|made| made.as_ref().is_ok_and(|made| made.signals[0].len() == 80)));
    assert!(made[1] == made[0] && made[2] == made[0]);
    // Held up in the frame of index 3.
    let gray = Arc::new(Gray { good: 80, last: AtomicUsize::new(0) });
    let limits = RunLimits { timeout: Some(Duration::from_millis(500)), ..RunLimits::default() };
    assert!(make_on(4, sequence_of(80, &gray), &[Bad::Hangs], None, &limits)[0].is_err());
    let decoded = gray.last.load(Ordering::Relaxed);
    assert!((4..=3 + 16).contains(&decoded), "{decoded} frames");
}

#[test]
fn signals_on_a_stored_track_equal_those_of_the_first_run() {
    let live = make(&[Bad::Never], None, &RunLimits::default()).remove(0).unwrap();
    // The tracker itself, which would panic, is not run.
    let kept = make(&[Bad::Panics], Some(&live.states), &RunLimits::default()).remove(0).unwrap();
    assert_eq!(kept, live);
}

#[test]
fn signals_of_regions_need_no_frame() {
    let live = make(&[Bad::Never], None, &RunLimits::default()).remove(0).unwrap();
    let limits = RunLimits::default();
    for cores in CORES {
        let gray = Arc::new(Gray { good: 0, last: AtomicUsize::new(0) });
        let stored = Some(&live.states);
        let mut made =
            make_signal("box-motion", cores, sequence_of(6, &gray), &[Bad::Panics], stored, &limits);
        assert_eq!(made.remove(0).unwrap().signals[0], [0.0; 6]);
        assert_eq!(gray.last.load(Ordering::Relaxed), 0);
    }
}
