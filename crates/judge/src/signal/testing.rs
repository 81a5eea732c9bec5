//! Helpers for tests of signals.

use super::{Observation, SIGNALS, Session, Signal};
use crate::image::Frame;
use crate::plugin::{Configured, find};
use crate::region::{Rect, Region};
use crate::saved;
use crate::tracker::{TrackerState, testing};
use serde::Serialize;
use trackfail_dataset::synthetic;

/// A signal of this kind.
pub fn build(kind: &str, params: &str) -> Configured<dyn Signal> {
    find(SIGNALS, kind).unwrap().build_from_text(params).unwrap()
}

/// Starts a signal on a rendered sequence.
pub fn start(signal: &dyn Signal) -> Box<dyn Session> {
    let sequence = synthetic::suite("synthetic-otb").unwrap().swap_remove(0);
    signal.start(&testing::context(&sequence, 1)).unwrap()
}

/// True if a signal of this kind goes on from a memory.
pub fn takes(kind: &str, params: &str, memory: &impl Serialize) -> bool {
    start(&*build(kind, params)).restore(&saved::to_bytes(memory).unwrap())
}

/// All values of a signal on frames with the tracker's states, a row per frame. The companion stays at the tracker's
/// first place.
pub fn rows(signal: &dyn Signal, frames: &[Frame], states: &[TrackerState]) -> Vec<Vec<f64>> {
    let mut session = start(signal);
    let row = |(frame, state): (&Frame, &TrackerState)| {
        let row = session.push(&Observation { frame, state, companions: &[&states[0].region] }).unwrap();
        assert_eq!(row.len(), signal.width());
        row
    };
    frames.iter().zip(states).map(row).collect()
}

/// First values of a signal on frames with the tracker's states.
pub fn values(signal: &dyn Signal, frames: &[Frame], states: &[TrackerState]) -> Vec<f64> {
    rows(signal, frames, states).iter().map(|row| row[0]).collect()
}

/// Values of a signal on frames with the tracker's boxes.
pub fn values_on_boxes(signal: &dyn Signal, frames: &[Frame], boxes: &[Rect]) -> Vec<f64> {
    let states: Vec<_> = boxes.iter().map(|r| TrackerState::tracked(Region::Rect(*r))).collect();
    values(signal, frames, &states)
}

/// Values of a signal of this kind on frames with the tracker's boxes.
pub fn run(kind: &str, params: &str, frames: &[Frame], boxes: &[Rect]) -> Vec<f64> {
    values_on_boxes(&*build(kind, params), frames, boxes)
}

/// Values of a signal of this kind, which does not look at frames, on states of the tracker.
pub fn run_on_states(kind: &str, params: &str, states: &[TrackerState]) -> Vec<f64> {
    let frames = vec![Frame::new(1, 1, vec![0; 3]); states.len()];
    values(&*build(kind, params), &frames, states)
}

/// The value of a signal of a response map in the first frame.
pub fn value_of_map(kind: &str, params: &str, map: &[f32], width: usize) -> f64 {
    let (low, high) = build(kind, params).facts().bounds;
    let value = run_on_states(kind, params, &[testing::state_of_map(map, width)])[0];
    assert!((low..=high).contains(&value), "{value}");
    value
}
