//! Helpers of the signals' tests.

use super::{Observation, Session, Signal};
use crate::dataset::synthetic;
use crate::image::Frame;
use crate::region::{Rect, Region};
use crate::tracker::{TrackerState, testing};

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
