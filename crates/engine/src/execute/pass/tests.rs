//! Passes with trackers that panic, hang or fail.

use super::*;
use crate::dataset::{Frames, Numbering, Render};
use crate::image::Frame;
use crate::region::{Rect, Region};
use crate::signal::SIGNALS;
use crate::tracker::{RunContext, StartResult, Tracker, TrackerConfig, TrackerError};
use std::time::Duration;

/// Gray frames; decoding panics from the frame of its number on.
struct Gray(usize);
impl Render for Gray {
    fn render(&self, t: usize) -> Frame {
        assert!(t < self.0, "no frame {t}");
        Frame::from_fn(32, 24, |x, y| [(x * 7) as u8, (y * 9) as u8, t as u8])
    }
}

fn sequence(good: usize) -> Arc<Sequence> {
    Arc::new(Sequence {
        name: "gray".into(),
        numbering: Numbering { first: 1, official: (1, 6) },
        truth: vec![Some(Region::Rect(Rect::new(4.0, 4.0, 12.0, 10.0))); 6],
        attributes: vec![],
        frame_attributes: vec![],
        digest: Default::default(),
        frames: Frames::Rendered(Arc::new(Gray(good)), 6),
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
    make_on(sequence(6), configs, states, limits)
}

fn make_on(
    sequence: Arc<Sequence>,
    configs: &[Bad],
    states: Option<&Arc<Vec<TrackerState>>>,
    limits: &RunLimits,
) -> Vec<Result<PassOutput, CellError>> {
    let entry = SIGNALS.iter().find(|e| e.kind == "rgb-histogram").unwrap();
    let signal = SignalChoice {
        kind: entry.kind,
        version: entry.version,
        signal: Arc::from(entry.build_from_text(entry.example).unwrap()),
    };
    let frames = Arc::new(FrameCache::new(0));
    let run = |bad: &Bad| TrackerRun {
        sequence: sequence.clone(),
        frames: frames.clone(),
        config: Arc::new(*bad),
        run: 0,
        seed: 1,
        data_root: None,
    };
    let task = |bad: &Bad| Task { run: run(bad), states: states.cloned(), signals: vec![0] };
    let one = Pass {
        sequence: sequence.clone(),
        frames: frames.clone(),
        signals: Arc::new(vec![signal]),
        tasks: configs.iter().map(task).collect(),
        on_frame: Arc::new(|| {}),
    };
    pass(one, limits).unwrap()
}

#[test]
fn a_failing_tracker_fails_no_other() {
    let alone = make(&[Bad::Never], None, &RunLimits::default()).remove(0).unwrap();
    assert_eq!((alone.states.len(), alone.signals[0].len()), (6, 6));
    let limits = RunLimits { timeout: Some(Duration::from_secs(2)), ..RunLimits::default() };
    let made = make(&[Bad::Panics, Bad::Never, Bad::Hangs, Bad::Errs, Bad::Never], None, &limits);
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

#[test]
fn frames_that_cannot_be_decoded_fail_all_trackers_of_the_sequence() {
    let made = make_on(sequence(4), &[Bad::Never, Bad::Never], None, &RunLimits::default());
    for made in made {
        let reason = made.unwrap_err().to_string();
        assert!(
            reason.starts_with("gray: panicked at crates/engine") && reason.ends_with("no frame 4"),
            "{reason}"
        );
    }
}

#[test]
fn signals_on_a_stored_track_equal_those_of_the_first_run() {
    let live = make(&[Bad::Never], None, &RunLimits::default()).remove(0).unwrap();
    // The tracker itself, which would panic, is not run.
    let kept = make(&[Bad::Panics], Some(&live.states), &RunLimits::default()).remove(0).unwrap();
    assert_eq!(kept, live);
}
