//! Helpers of the signals' tests.

use super::{Observation, Session, Signal};
use crate::image::Frame;
use crate::num::particles::{effective_number, entropy};
use crate::plugin::Entry;
use crate::region::{Rect, Region};
use crate::tracker::{Moments, TrackerState, testing};
use trackfail_dataset::synthetic;

/// A signal that has been started on a rendered sequence.
pub fn start(signal: &dyn Signal) -> Box<dyn Session> {
    let sequence = synthetic::suite("synthetic-otb").unwrap().swap_remove(0);
    signal.start(&testing::context(&sequence, 1)).unwrap()
}

/// The values of a signal on frames with the tracker's states. Its companion stays where the tracker starts.
pub fn values(
    signal: &dyn Signal,
    frames: &[Frame],
    states: impl IntoIterator<Item = TrackerState>,
) -> Vec<f64> {
    let mut session = start(signal);
    let mut first = None;
    let push = |(frame, state): (&Frame, TrackerState)| {
        let companion = first.get_or_insert_with(|| state.region.clone());
        session.push(&Observation { frame, state: &state, companions: &[&*companion] })
    };
    frames.iter().zip(states).map(push).collect()
}

/// The values of a signal on frames with the tracker's boxes.
pub fn values_on_boxes(signal: &dyn Signal, frames: &[Frame], boxes: &[Rect]) -> Vec<f64> {
    values(signal, frames, boxes.iter().map(|r| TrackerState::tracked(Region::Rect(*r))))
}

/// The value of a signal of a response map in the first frame.
pub fn value_of_map(entry: &Entry<dyn Signal>, params: &str, map: &[f32], width: usize) -> f64 {
    let signal = entry.build_from_text(params).unwrap();
    let (low, high) = signal.facts().bounds;
    let frame = Frame::new(1, 1, vec![0; 3]);
    let value = values(signal.as_ref(), &[frame], [testing::state_of_map(map, width)])[0];
    assert!((low..=high).contains(&value), "{value}");
    value
}

/// The values of a signal of particles with these weights.
pub fn values_of_weights(entry: &Entry<dyn Signal>, clouds: &[[f64; 4]]) -> Vec<f64> {
    let frames = vec![Frame::new(1, 1, vec![0; 3]); clouds.len()];
    let states = clouds.iter().map(|weights| {
        let (effective_samples, entropy) = (effective_number(weights), entropy(weights));
        let moments = Moments { effective_samples, samples: 4.0, entropy, ..Moments::default() };
        let region = Region::Rect(Rect::new(0.0, 0.0, 4.0, 4.0));
        TrackerState { posterior: Some(moments), ..TrackerState::tracked(region) }
    });
    values(entry.build_from_text("{}").unwrap().as_ref(), &frames, states)
}
