//! Reverse runs of built-in trackers on a rendered square.

use super::*;
use trackfail_core::plugin;
use trackfail_core::region::Rect;
use trackfail_dataset::frame_cache::FrameCache;
use trackfail_dataset::user_frames::without_frames;
use trackfail_dataset::{Frames, Sequence};
use trackfail_methods::tracker::TRACKERS;

const FRAMES: usize = 60;

fn place(t: usize) -> Rect {
    Rect::new(20.0 + t as f64, 30.0, 24.0, 24.0)
}

/// Target of 24 x 24 pixels on gray that moves to the right by one pixel per frame. Nested colored squares
/// make its size visible, stripes across them make shifts visible.
fn square(t: usize) -> Frame {
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

fn sequence() -> Arc<Sequence> {
    Arc::new(Sequence {
        truth: (0..FRAMES).map(|t| Some(Region::Rect(place(t)))).collect(),
        frames: Frames::Rendered(Arc::new(square), FRAMES),
        ..without_frames("square", FRAMES)
    })
}

fn reversal(kind: &str) -> Reversal {
    let entry = plugin::find(TRACKERS, kind).unwrap();
    let config = entry.build_from_text(entry.example).unwrap().plugin;
    let (sequence, frames) = (sequence(), Arc::new(FrameCache::new(1 << 24)));
    let run = TrackerRun { sequence, frames, config, run: 0, seed: 5, data_roots: Vec::new() };
    let (mut tracker, first) = run.start(&run.frame(0).unwrap()).unwrap();
    let mut regions = vec![first.region];
    regions.extend((1..FRAMES).map(|t| tracker.update(&run.frame(t).unwrap()).unwrap().region));
    Reversal::new(run, regions)
}

fn ask(reversal: &Reversal, from: usize, to: usize) -> (Option<f64>, Option<String>) {
    let handle = Handle { reversal, failure: RefCell::default() };
    let error = handle.error(from, to);
    (error, handle.failure.into_inner().map(|e| e.to_string()))
}

const POSTERIOR: [&str; 5] = [
    "color-particle-filter",
    "fragments-particle-filter",
    "sparse-prototypes",
    "ivt",
    "adaptive-local-sparse",
];

// Nothing else in the frame looks like the square, so the reverse run ends where the forward run began.
#[test]
fn without_noise_a_reverse_run_returns_to_the_start() {
    for kind in POSTERIOR {
        let reversal = reversal(kind);
        let (error, failure) = ask(&reversal, 40, 0);
        assert_eq!(failure, None, "{kind}");
        assert!(error.unwrap() < 0.35, "{kind}: {error:?}");
        assert!(overlap::error(&reversal.regions[40], &reversal.regions[0]) == 1.0, "{kind}: no way to go");
    }
}

// Table 5 counts what a run costs a program that has not made it before.
#[test]
fn runs_apart_find_what_shared_ones_find_and_cost_each_the_whole_way() {
    let shared = reversal("color-particle-filter");
    let (mut tracker, _) = shared.run.start(&shared.run.frame(0).unwrap()).unwrap();
    let mut forks = vec![tracker.fork(None).unwrap()];
    for t in 1..FRAMES {
        tracker.update(&shared.run.frame(t).unwrap()).unwrap();
        forks.push(tracker.fork(None).unwrap());
    }
    let apart = Reversal::apart(shared.run.clone(), shared.regions.clone(), forks);
    for (from, to) in [(40, 30), (40, 30), (40, 25), (12, 3)] {
        assert_eq!(ask(&apart, from, to), ask(&shared, from, to), "{from} {to}");
    }
    let frames = |reversal: &Reversal| {
        let cost = reversal.take_cost();
        assert!(cost.tracking > Duration::ZERO && cost.tracking < cost.waiting, "{cost:?}");
        (cost.runs, cost.frames)
    };
    assert_eq!((frames(&apart), frames(&shared)), ((4, 10 + 10 + 15 + 9), (3, 10 + 5 + 9)));
    assert_eq!(apart.take_cost(), ReverseCost::default());
    // Earlier runs change nothing, wherever they began and ended.
    for (from, to) in [(40, 10), (25, 3), (40, 30), (50, 10), (25, 20)] {
        assert_eq!(ask(&apart, from, to), ask(&shared, from, to), "{from} {to}");
    }
}

#[test]
fn runs_that_are_impossible_are_errors() {
    let (error, failure) = ask(&reversal("still"), 5, 2);
    assert_eq!(error, None);
    assert!(failure.unwrap().contains("cannot be copied"));
    let mut one = reversal("color-particle-filter");
    for (from, to) in [(5, 5), (3, 7), (FRAMES, 2)] {
        let (error, failure) = ask(&one, from, to);
        assert!(error.is_none() && failure.unwrap().starts_with("there is no way back"));
    }
    // A track that the tracker does not repeat.
    one.regions[9] = Region::Rect(Rect::new(0.0, 0.0, 1.0, 1.0));
    let failure =
        "the tracker is not deterministic: a second run gave another region in frame 9 (from 0)".to_string();
    assert_eq!(ask(&one, 12, 2), (None, Some(failure)));
    assert!(ask(&one, 8, 2).0.is_some());
}
