//! ARTE and ARTE* on rendered sequences whose losses, recoveries and distractors are scripted, with the color
//! particle filter as the tracker and its reverse runs.

use std::sync::Arc;
use trackfail::dataset::frame_cache::FrameCache;
use trackfail::dataset::user_frames::without_frames;
use trackfail::dataset::{Frames, Sequence};
use trackfail::detector::{Condition, DETECTORS, DetectorOutput, Input};
use trackfail::engine::execute::pass::{PassOutput, Task, pass};
use trackfail::engine::execute::reverse::{self, Reversal};
use trackfail::engine::execute::tracker_run::TrackerRun;
use trackfail::engine::limits::RunLimits;
use trackfail::image::Frame;
use trackfail::plugin;
use trackfail::region::{Rect, Region};
use trackfail::signal::SIGNALS;
use trackfail::spec::method::SignalChoice;
use trackfail::tracker::TRACKERS;

/// Where something colored like the target is in a frame.
type Place = fn(usize) -> Option<(f64, f64)>;

/// A target, and something that looks like it.
#[derive(Clone, Copy)]
struct Scene {
    frames: usize,
    target: Place,
    distractor: Place,
}

const SIDE: f64 = 28.0;

/// Three squares in each other, so that the colors tell the size.
fn color(u: f64, v: f64) -> Option<[u8; 3]> {
    match f64::max(u.abs(), v.abs()) {
        d if d < 5.0 => Some([30, 190, 60]),
        d if d < 10.0 => Some([40, 40, 200]),
        d if d < SIDE / 2.0 => Some([210, 30, 40]),
        _ => None,
    }
}

impl Scene {
    fn render(&self, t: usize) -> Frame {
        let places = [(self.distractor)(t), (self.target)(t)];
        Frame::from_fn(200, 140, |x, y| {
            let shown = places.iter().flatten().rev();
            let mut seen = shown.filter_map(|(cx, cy)| color(x as f64 + 0.5 - cx, y as f64 + 0.5 - cy));
            // A background that is nowhere quite the same.
            let shade = 110 + ((x * 7 + y * 13) % 23) as u8;
            seen.next().unwrap_or([shade, shade, shade.wrapping_add(6)])
        })
    }
}

/// The target moves slowly to the right.
fn path(t: usize) -> (f64, f64) {
    (60.0 + 0.25 * t as f64, 60.0)
}

/// Lost for 40 frames, and back where it would have been.
const RECOVERY: Scene =
    Scene { frames: 180, target: |t| (!(60..100).contains(&t)).then(|| path(t)), distractor: |_| None };

/// Lost for good; something else that looks like it comes where the filter looks for it.
const DISTRACTION: Scene = Scene {
    frames: 180,
    target: |t| (t < 60).then(|| path(t)),
    distractor: |t| (t >= 75).then_some((110.0, 95.0)),
};

/// Lost, distracted and lost again, and found in the end.
const BOTH: Scene = Scene {
    frames: 300,
    target: |t| (!(60..200).contains(&t)).then(|| path(t.min(140))),
    distractor: |t| (75..140).contains(&t).then_some((110.0, 95.0)),
};

fn sequence(scene: Scene) -> Arc<Sequence> {
    let region = |(x, y): (f64, f64)| Region::Rect(Rect::new(x - SIDE / 2.0, y - SIDE / 2.0, SIDE, SIDE));
    let mut sequence = without_frames("scene", scene.frames);
    sequence.truth = (0..scene.frames).map(|t| (scene.target)(t).map(region)).collect();
    sequence.frames = Frames::Rendered(Arc::new(move |t| scene.render(t)), scene.frames);
    Arc::new(sequence)
}

/// A method on a scene.
fn on(scene: Scene, [signal, detector]: [(&str, &str); 2], seed: u64) -> DetectorOutput {
    let sequence = sequence(scene);
    let entry = plugin::find(TRACKERS, "color-particle-filter").unwrap();
    let config = entry.build_from_text("{}").unwrap().plugin;
    let signal_entry = plugin::find(SIGNALS, signal.0).unwrap();
    let signal = SignalChoice::new(signal_entry, signal_entry.build_from_text(signal.1).unwrap());
    let cache = Arc::new(FrameCache::new(1 << 26));
    let run = TrackerRun { sequence, frames: cache, config, run: 0, seed, data_roots: Vec::new() };
    let task = Task { run: run.clone(), states: None, signals: vec![&signal], companions: Vec::new() };
    let made = pass(&[task], &RunLimits::default(), &|| {}).unwrap().remove(0);
    let PassOutput { states, mut signals, .. } = made.unwrap();
    let values = signals.remove(0).unwrap();
    let reversal = Reversal::new(run, states.into_iter().map(|state| state.region).collect());
    let detector = plugin::find(DETECTORS, detector.0).unwrap().build_from_text(detector.1).unwrap();
    let error = vec![f64::NAN; scene.frames];
    let input = Input { signal: &values, error: &error, seed: 0, reverse: None, more: &[] };
    reverse::detect(&*detector, input, Some(&reversal)).unwrap()
}

const ARTE: [(&str, &str); 2] = [("uncertainty", "{ components = [0, 1] }"), ("arte", "{ settling = 25 }")];
const ARTE_STAR: [(&str, &str); 2] =
    [("uncertainty-change", "{ settling = 25 }"), ("arte-star", "{ length = 5, beta = 4.0 }")];

#[test]
fn a_recovery_is_credited() {
    for method in [ARTE, ARTE_STAR] {
        for seed in [1, 2] {
            let said = on(RECOVERY, method, seed);
            let quality = said.quality.unwrap();
            let label = method[1].0;
            assert!(said.alarm[..60].iter().all(|a| !a), "{label}: an alarm before anything happens");
            assert!(said.alarm[75..100].iter().all(|a| *a), "{label}: the loss is not noticed");
            assert!(!said.alarm[179], "{label}: the recovery is not noticed");
            let accepted = quality.checks.iter().find(|c| c.accepted).unwrap();
            assert!((100..140).contains(&accepted.frame) && (50..75).contains(&accepted.reference));
            assert_eq!(quality.condition[179], Condition::LockedOn);
        }
    }
}

#[test]
fn a_distractor_is_not() {
    for method in [ARTE, ARTE_STAR] {
        let said = on(DISTRACTION, method, 1);
        let quality = said.quality.unwrap();
        assert!(!quality.checks.is_empty() && quality.checks.iter().all(|c| !c.accepted), "{method:?}");
        assert!(said.alarm[75..].iter().all(|a| *a), "{method:?}");
        // It is locked on all the same, only not on its target.
        assert_eq!(quality.condition[179], Condition::LockedOn, "{method:?}");
        // The target itself is credited after it.
        let checks = on(BOTH, method, 1).quality.unwrap().checks;
        assert!(checks.len() >= 2 && !checks[0].accepted, "{method:?} {checks:?}");
    }
}
