use super::*;
use crate::tracker::testing;
use proptest::prelude::*;
use trackfail_dataset::{Sequence, synthetic};

fn square(x: f64) -> Region {
    Region::Rect(Rect::new(x, 10.0, 10.0, 10.0))
}

fn sequence(truth: Vec<Option<Region>>) -> Sequence {
    Sequence { truth, ..synthetic::suite("synthetic-otb").unwrap().swap_remove(0) }
}

/// Tracker that moves the start's region to the right by 4 pixels per frame, and reports the frame index as
/// likelihood.
struct Drifting;

impl TrackerConfig for Drifting {
    fn facts(&self) -> Facts {
        Facts::BOXES
    }

    fn start(&self, context: &RunContext<'_>, _: &Frame, region: &Region) -> StartResult {
        let tracker = (region.clone(), context.start_frame);
        Ok((Box::new(tracker), TrackerState::initialized(region.clone())))
    }
}

impl Tracker for (Region, usize) {
    fn update(&mut self, _: &Frame) -> Result<TrackerState, TrackerError> {
        *self = (self.0.shifted(4.0, 0.0), self.1 + 1);
        let posterior = crate::tracker::Moments { likelihood: self.1 as f64, ..Default::default() };
        Ok(TrackerState { posterior: Some(posterior), ..TrackerState::tracked(self.0.clone()) })
    }

    fn fork(&self, _seed: Option<u64>) -> Option<Box<dyn Tracker>> {
        Some(Box::new(self.clone()))
    }
}

fn under(protocol: RunProtocol) -> Configured<dyn TrackerConfig> {
    protocol.over(Configured::<dyn TrackerConfig>::new(serde_json::json!({}), Arc::new(Drifting)))
}

fn track(protocol: RunProtocol, q: &Sequence, run: u32) -> Vec<TrackerState> {
    let config = under(protocol);
    let frames = vec![Frame::new(64, 48, vec![0; 3 * 64 * 48]); q.len()];
    let region = q.truth[0].clone().unwrap_or(square(0.0));
    let context = RunContext { run, ..testing::context(q, 5) };
    let go = || -> Vec<TrackerState> {
        let (mut tracker, first) = config.start(&context, &frames[0], &region).unwrap();
        std::iter::once(first).chain(frames[1..].iter().map(|f| tracker.update(f).unwrap())).collect()
    };
    assert_eq!(go(), go(), "started again, everything is as before");
    go()
}

fn words(states: &[TrackerState]) -> String {
    states.iter().map(|s| format!("{:?}", s.status).chars().next().unwrap()).collect()
}

// The target stands at 0..10; the tracker is at 4, 8, 12 in the frames after a start, so that the third has
// overlap 0. Restart in the fifth frame after it.
#[test]
fn starts_anew_five_frames_after_a_failure() {
    let q = sequence(vec![Some(square(0.0)); 12]);
    let states = track(RunProtocol::VotReset, &q, 0);
    assert_eq!(words(&states), "ITTFSSSSITTF");
    let lefts: Vec<f64> = states.iter().map(|s| s.region.rect().x).collect();
    assert_eq!(lefts, [0.0, 4.0, 8.0, 12.0, 12.0, 12.0, 12.0, 12.0, 0.0, 4.0, 8.0, 12.0]);
    let index = |t: usize| states[t].posterior.as_ref().unwrap().likelihood;
    assert_eq!((index(2), index(9)), (2.0, 9.0), "the tracker knows the frame after a pause");
    assert_eq!(words(&track(RunProtocol::OnePass, &q, 0)), "ITTTTTTTTTTT");
}

#[test]
fn a_start_waits_for_a_truth_and_gaps_are_no_failures() {
    let mut truth = vec![Some(square(0.0)); 14];
    truth[3] = None;
    truth[9] = None;
    // In frame 3 nobody can tell that it is lost; in frame 9, five after the failure in 4, it cannot start.
    assert_eq!(words(&track(RunProtocol::VotReset, &sequence(truth), 0)), "ITTTFSSSSSITTF");
}

// A sliver of a quarter of a pixel overlaps exactly, and has no pixel of its own in 2014's raster.
#[test]
fn the_raster_of_2014_finds_failures_earlier() {
    let wide = Region::Rect(Rect::new(0.0, 10.0, 8.25, 10.0));
    let q = sequence(vec![Some(wide); 4]);
    assert_eq!(words(&track(RunProtocol::VotReset, &q, 0)), "ITTF");
    assert_eq!(words(&track(RunProtocol::VotReset2014, &q, 0)), "ITFS");
}

#[test]
fn temporal_runs_start_later_and_wait() {
    let mut truth: Vec<_> = (0..41).map(|t| Some(square(f64::from(t)))).collect();
    truth[20] = None;
    let q = sequence(truth);
    // floor(10 * 40 / 20) = 20 is not annotated.
    let states = track(RunProtocol::OtbTemporal, &q, 10);
    assert_eq!(words(&states), format!("{}I{}", "W".repeat(21), "T".repeat(19)));
    assert_eq!((&states[0].region, &states[21].region), (&square(21.0), &square(21.0)));
    assert_eq!(words(&track(RunProtocol::OtbTemporal, &q, 0)), format!("I{}", "T".repeat(40)));
    assert_eq!(start_frame(&q.truth, 19), 38);
    // By hand: after frame 20 the target is never seen again.
    let gone: Vec<_> = (0..41).map(|t| Some(square(0.0)).filter(|_| t < 20)).collect();
    assert_eq!([9, 10, 19].map(|run| start_frame(&gone, run)), [18, 19, 19]);
    let errors = crate::score::overlap::errors(&states, &q.truth);
    assert!(errors[..21].iter().all(|e| e.is_nan()) && errors[21] == 0.0);
}

// Forked before the start and after it, a copy goes on as the whole does; with restarts there is none.
#[test]
fn a_copy_goes_on_under_protocols_without_restarts() {
    let q = sequence((0..20).map(|t| Some(square(f64::from(t)))).collect());
    let frame = Frame::new(64, 48, vec![0; 3 * 64 * 48]);
    for protocol in RunProtocol::ALL {
        let context = RunContext { run: 10, ..testing::context(&q, 5) };
        let (mut tracker, _) = under(protocol).start(&context, &frame, &square(0.0)).unwrap();
        for t in 1..15 {
            let copy = tracker.fork(None);
            let next = tracker.update(&frame).unwrap();
            assert_eq!(copy.is_none(), protocol.name().starts_with("vot"), "{protocol:?}");
            assert!(copy.is_none_or(|mut copy| copy.update(&frame).unwrap() == next), "{protocol:?} {t}");
        }
    }
}

#[test]
fn spatial_runs_start_beside() {
    let r = Rect::new(20.0, 10.0, 10.0, 20.0);
    let all: Vec<Rect> = (0..SPATIAL_RUNS).map(|run| spatial(r, run)).collect();
    assert_eq!(all[0], Rect::new(19.0, 10.0, 10.0, 20.0));
    assert_eq!(all[3], Rect::new(20.0, 12.0, 10.0, 20.0));
    assert_eq!(all[7], Rect::new(21.0, 12.0, 10.0, 20.0));
    assert_eq!(all[8], Rect::new(21.0, 12.0, 8.0, 16.0));
    assert_eq!(all[11], Rect::new(19.0, 8.0, 12.0, 24.0));
    let states = track(RunProtocol::OtbSpatial, &sequence(vec![Some(square(20.0)); 3]), 1);
    assert_eq!(states[0].region, square(21.0));
}

#[test]
fn uses_seed_and_uses_run_are_those_of_the_protocol() {
    for p in RunProtocol::ALL {
        assert_eq!(RunProtocol::from_name(p.name()), Some(p));
        let config = under(p);
        assert_eq!(config.facts().uses_run, p.runs().is_some());
        assert_eq!(config.facts().uses_seed, p == RunProtocol::VotRegionNoise);
        let shown = config.params().to_string();
        assert_eq!(shown.contains(p.name()), p != RunProtocol::OnePass, "{shown}");
    }
}

#[test]
fn a_sequence_without_truth_starts_where_the_caller_says() {
    let q = sequence(vec![None; 3]);
    let states = track(RunProtocol::OtbTemporal, &q, 3);
    assert_eq!((words(&states), &states[0].region), ("ITT".into(), &square(0.0)));
}

proptest! {
    #[test]
    fn disturbed_boxes_stay_near(seed in any::<u64>(), w in 4.0..90.0, h in 4.0..90.0) {
        let rect = Rect::new(7.0, 9.0, w, h);
        let region = disturbed(rect, &mut seed::rng(seed));
        let (near, (x, y)) = (region.rect(), rect.center());
        prop_assert!((near.w / w - 1.0).abs() <= 0.1 && (near.h / h - 1.0).abs() <= 0.1);
        prop_assert!((near.center().0 - x).abs() <= 0.1 * w + 1e-9);
        prop_assert!((near.center().1 - y).abs() <= 0.1 * h + 1e-9);
        prop_assert!(Areas::Exact.overlap(&region, &Region::Rect(rect), None) > 0.0);
    }
}
