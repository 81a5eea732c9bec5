//! Passes with trackers that panic, take too long or fail, on one thread and on several.

use super::*;
use std::sync::atomic::{AtomicUsize, Ordering};
use trackfail_core::region::Rect;
use trackfail_dataset::frame_cache::FrameCache;
use trackfail_dataset::user_frames::without_frames;
use trackfail_dataset::{Frames, Sequence};
use trackfail_methods::signal::SIGNALS;
use trackfail_methods::tracker::{Facts, RunContext, StartResult, Tracker, TrackerConfig, TrackerError};

/// Gray frames. Decoding panics from a given frame on.
struct Gray {
    good: usize,
    /// Number of decoded frames.
    decoded: AtomicUsize,
}

impl Gray {
    fn render(&self, t: usize) -> Frame {
        assert!(t < self.good, "no frame {t}");
        self.decoded.fetch_add(1, Ordering::Relaxed);
        Frame::from_fn(32, 24, |x, y| [(x * 7) as u8, (y * 9) as u8, t as u8])
    }
}

fn gray(good: usize) -> Arc<Gray> {
    Arc::new(Gray { good, decoded: AtomicUsize::new(0) })
}

fn sequence(frames: usize, gray: &Arc<Gray>) -> Arc<Sequence> {
    let gray = gray.clone();
    Arc::new(Sequence {
        truth: vec![Some(Region::Rect(Rect::new(4.0, 4.0, 12.0, 10.0))); frames],
        frames: Frames::Rendered(Arc::new(move |t| gray.render(t)), frames),
        ..without_frames("gray", frames)
    })
}

fn run(sequence: &Arc<Sequence>, frames: &Arc<FrameCache>, bad: Bad) -> TrackerRun {
    let (sequence, frames, config) = (sequence.clone(), frames.clone(), Arc::new(bad));
    TrackerRun { sequence, frames, config, run: 0, seed: 1, data_roots: Vec::new() }
}

/// Time limit of a task in tests that have one. A slow frame takes longer.
const LIMIT: Duration = Duration::from_secs(1);

/// Tracker that never moves and fails in frame 3, each variant in its own way.
#[derive(Clone, Copy, PartialEq)]
enum Bad {
    Never,
    Panics,
    IsSlow,
    Errs,
}

impl TrackerConfig for Bad {
    fn facts(&self) -> Facts {
        Facts::BOXES
    }

    fn start(&self, _: &RunContext<'_>, _: &Frame, region: &Region) -> StartResult {
        Ok((Box::new(BadTracker(*self, 0)), TrackerState::initialized(region.clone())))
    }
}

/// The tracker with the number of frames that it has seen.
struct BadTracker(Bad, u32);

impl Tracker for BadTracker {
    fn update(&mut self, _: &Frame) -> Result<TrackerState, TrackerError> {
        self.1 += 1;
        match self.0 {
            Bad::Panics if self.1 == 3 => panic!("out of wits"),
            Bad::Errs if self.1 == 3 => return Err(TrackerError::Broken("lost its file".into())),
            Bad::IsSlow if self.1 == 3 => std::thread::sleep(LIMIT + Duration::from_millis(200)),
            _ => {}
        }
        Ok(TrackerState::tracked(Region::Rect(Rect::new(4.0, 4.0, 12.0, 10.0))))
    }
}

fn choice(kind: &str) -> SignalChoice {
    let entry = SIGNALS.iter().find(|e| e.kind == kind).unwrap();
    SignalChoice::new(entry, entry.build_from_text(entry.example).unwrap())
}

type Made = Result<(Vec<TrackerState>, Vec<Vec<f64>>), CellError>;

/// Runs a pass on `threads` threads with a signal on each track, of these kinds in turn. If a signal reads companions,
/// these are all other tracks.
fn make_signals(
    kinds: &[&str],
    threads: usize,
    sequence: &Arc<Sequence>,
    configs: &[Bad],
    states: Option<&[TrackerState]>,
) -> Vec<Made> {
    let frames = Arc::new(FrameCache::new(0));
    let signals: Vec<SignalChoice> = kinds.iter().map(|kind| choice(kind)).collect();
    let others = |k: usize| (0..configs.len()).filter(move |other| *other != k);
    let tasks = configs.iter().enumerate().map(|(k, bad)| Task {
        run: run(sequence, &frames, *bad),
        states,
        signals: vec![&signals[k % signals.len()]],
        companions: others(k).map(|other| ("another", Some(other))).collect(),
    });
    let tasks: Vec<Task<'_>> = tasks.collect();
    let limits = RunLimits { timeout: Some(LIMIT), ..RunLimits::default() };
    let told = AtomicUsize::new(0);
    let count = || {
        told.fetch_add(1, Ordering::Relaxed);
    };
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
    let made = pool.install(|| pass(&tasks, &limits, &count)).unwrap();
    if made.iter().any(Result::is_ok) {
        assert_eq!(told.into_inner(), sequence.len(), "once a frame");
    }
    let whole = |made: PassOutput| -> Made {
        let signals = made.signals.into_iter().collect::<Result<_, CellError>>()?;
        Ok((made.states, signals))
    };
    made.into_iter().map(|made| made.and_then(whole)).collect()
}

fn make(threads: usize, sequence: &Arc<Sequence>, configs: &[Bad]) -> Vec<Made> {
    make_signals(&["rgb-histogram"], threads, sequence, configs, None)
}

/// Track and signal of a good tracker on six frames.
fn alone() -> (Vec<TrackerState>, Vec<Vec<f64>>) {
    make(1, &sequence(6, &gray(6)), &[Bad::Never]).remove(0).unwrap()
}

const THREADS: [usize; 3] = [1, 2, 5];

#[track_caller]
fn assert_panic(reason: &str, message: &str) {
    assert!(reason.starts_with("gray: panicked at crates/engine") && reason.ends_with(message), "{reason}");
}

#[test]
fn a_failing_tracker_fails_no_other() {
    let alone = alone();
    assert_eq!((alone.0.len(), alone.1[0].len()), (6, 6));
    for threads in THREADS {
        let bad = [Bad::Panics, Bad::Never, Bad::IsSlow, Bad::Errs, Bad::Never];
        let made = make(threads, &sequence(6, &gray(6)), &bad);
        let reason = |k: usize| made[k].as_ref().unwrap_err().to_string();
        assert_panic(&reason(0), "out of wits");
        assert_eq!(reason(2), "gray: took longer than 1 s (--timeout)");
        assert_eq!(reason(3), "lost its file");
        assert_eq!((made[1].as_ref(), made[4].as_ref()), (Ok(&alone), Ok(&alone)));
    }
}

#[test]
fn frames_that_cannot_be_decoded_fail_the_trackers_that_get_to_them() {
    for threads in THREADS {
        let mut made = make(threads, &sequence(6, &gray(4)), &[Bad::Never, Bad::Never, Bad::Errs]);
        assert_eq!(made.remove(2).unwrap_err().to_string(), "lost its file");
        made.into_iter().for_each(|made| assert_panic(&made.unwrap_err().to_string(), "no frame 4"));
    }
}

// Neither of the others reads pixels; one of them reads the track of the signal that fails.
#[test]
fn a_signal_that_fails_leaves_the_track_to_others() {
    let (states, _) = alone();
    for (kind, value) in [("box-motion", 0.0), ("companion-overlap", 1.0)] {
        let kinds = [kind, "rgb-histogram"];
        let made = make_signals(&kinds, 2, &sequence(6, &gray(4)), &[Bad::Never; 2], Some(&states));
        assert_eq!(made[0], Ok((Vec::new(), vec![vec![value; 6]])), "{kind}");
        assert_panic(&made[1].as_ref().unwrap_err().to_string(), "no frame 4");
    }
}

#[test]
fn more_threads_change_no_result_and_do_not_decode_far_ahead() {
    let made = THREADS.map(|threads| make(threads, &sequence(80, &gray(80)), &[Bad::Never; 4]));
    assert!(made[0].iter().all(|made| made.as_ref().is_ok_and(|made| made.1[0].len() == 80)));
    assert!(made[1] == made[0] && made[2] == made[0]);
    // It fails in the frame of index 3.
    let gray = gray(80);
    assert!(make(4, &sequence(80, &gray), &[Bad::Errs])[0].is_err());
    let decoded = gray.decoded.load(Ordering::Relaxed);
    assert!((4..=3 + 16).contains(&decoded), "{decoded} frames");
}

#[test]
fn frames_are_decoded_once_for_any_number_of_tracks_and_their_companions() {
    for (kind, count) in [("rgb-histogram", 70), ("companion-overlap", 3)] {
        let gray = gray(20);
        let made = make_signals(&[kind], 2, &sequence(20, &gray), &vec![Bad::Never; count], None);
        assert!(made.iter().all(|made| made.as_ref().is_ok_and(|made| made.1[0].len() == 20)));
        assert_eq!(gray.decoded.load(Ordering::Relaxed), 20, "{kind}");
        if kind == "companion-overlap" {
            assert_eq!(made[0].as_ref().unwrap().1[0], [1.0; 20]);
        }
    }
}

#[test]
fn signals_that_read_a_failed_companion_fail_with_it() {
    for threads in THREADS {
        let bad = [Bad::Never, Bad::Errs, Bad::Never];
        let made = make_signals(&["companion-overlap"], threads, &sequence(6, &gray(6)), &bad, None);
        let reasons: Vec<String> = made.into_iter().map(|made| made.unwrap_err().to_string()).collect();
        let lacks = "there is no track of its companion another";
        assert_eq!(reasons, [lacks, "lost its file", lacks]);
    }
}

// The tracker itself, which would panic, is not run.
#[test]
fn signals_on_a_stored_track_equal_those_of_the_first_run_and_those_of_regions_need_no_frame() {
    let (states, signals) = alone();
    for (kind, frames, signals) in [("rgb-histogram", 6, signals), ("box-motion", 0, vec![vec![0.0; 6]])] {
        for threads in THREADS {
            let gray = gray(frames);
            let made = make_signals(&[kind], threads, &sequence(6, &gray), &[Bad::Panics], Some(&states));
            assert_eq!(made, [Ok((Vec::new(), signals.clone()))], "{kind}");
            assert_eq!(gray.decoded.load(Ordering::Relaxed), frames, "{kind}");
        }
    }
}

#[test]
fn an_interrupted_pass_ends() {
    let run = run(&sequence(6, &gray(6)), &Arc::new(FrameCache::new(0)), Bad::Never);
    let limits = RunLimits::default();
    let task = Task { run, states: None, signals: Vec::new(), companions: Vec::new() };
    let stop = || limits.stop.set();
    assert!(matches!(pass(&[task], &limits, &stop), Err(RunError::Interrupted)));
}
