//! Signals whose value is a function of the frame and of what they remember of the frames before.
//!
//! A signal may see a box whose sides are means over its own past (`size_history`): a reading of methods whose text does not
//! say what happens when the tracker's box jumps in size. The center is that of the frame.

use super::{Facts, Observation, Session, Signal};
use crate::plugin::Range;
use crate::region::{Rect, Region};
use crate::saved;
use crate::tracker::{RunContext, TrackerError, TrackerState};
use serde::Serialize;
use serde::de::DeserializeOwned;

/// A signal that defines how one frame changes its memory. That suffices for a [`Session`] that can be
/// interrupted.
pub trait Causal: Clone + Send + Sync + 'static {
    /// Memory of earlier frames. The default is the memory before the first frame.
    type Memory: Default + Serialize + DeserializeOwned + Send;

    /// Properties of the signal's values.
    fn facts(&self) -> Facts;

    /// Value in the next frame; not finite if the state lacks the signal's input.
    fn push(&self, memory: &mut Self::Memory, observation: &Observation<'_>) -> f64;

    /// Number of frames before whose boxes' sides are averaged with those of the box that it sees; 0: its own sides.
    fn size_history(&self) -> usize {
        0
    }

    /// Reason why the value is not finite after which the memory is this one; `None` if there is nothing to tell.
    fn fault(&self, _memory: &Self::Memory) -> Option<String> {
        None
    }

    /// True if a memory can be one of this signal with these parameters.
    fn is_memory(&self, _memory: &Self::Memory) -> bool {
        true
    }
}

/// Number of frames in a box's history of sizes.
pub const SIZE_HISTORY: Range = Range::within("size_history", 0.0, 1000.0);

/// True if a parameter is left out where it is shown: one that came later, at its default, which changes no address.
pub fn is_default<T: Default + PartialEq>(value: &T) -> bool {
    *value == T::default()
}

impl<S: Causal> Signal for S {
    fn facts(&self) -> Facts {
        Causal::facts(self)
    }

    fn start(&self, _: &RunContext<'_>) -> Result<Box<dyn Session>, TrackerError> {
        Ok(Box::new(Following { signal: self.clone(), memory: S::Memory::default(), sides: Vec::new() }))
    }
}

/// A signal on one track.
struct Following<S: Causal> {
    signal: S,
    memory: S::Memory,
    /// Width and height of the last boxes, at most `size_history` and the current one.
    sides: Vec<(f64, f64)>,
}

impl<S: Causal> Following<S> {
    /// The box of a frame with the mean sides of its history; its own where they are not finite in any frame.
    fn averaged(&mut self, own: Rect) -> Rect {
        if own.w.is_finite() && own.h.is_finite() {
            self.sides.push((own.w, own.h));
        }
        if self.sides.len() > self.signal.size_history() + 1 {
            self.sides.remove(0);
        }
        if self.sides.is_empty() {
            return own;
        }
        let count = self.sides.len() as f64;
        let (w, h) = self.sides.iter().fold((0.0, 0.0), |(w, h), side| (w + side.0, h + side.1));
        let ((cx, cy), (w, h)) = (own.center(), (w / count, h / count));
        Rect::new(cx - w / 2.0, cy - h / 2.0, w, h)
    }
}

impl<S: Causal> Session for Following<S> {
    fn push(&mut self, observation: &Observation<'_>) -> Result<Vec<f64>, TrackerError> {
        let value = if self.signal.size_history() == 0 {
            self.signal.push(&mut self.memory, observation)
        } else {
            let region = Region::Rect(self.averaged(observation.state.region.rect()));
            let state = TrackerState { region, ..observation.state.clone() };
            let Observation { frame, companions, .. } = *observation;
            self.signal.push(&mut self.memory, &Observation { frame, state: &state, companions })
        };
        let fault = if value.is_finite() { None } else { self.signal.fault(&self.memory) };
        fault.map_or_else(|| Ok(vec![value]), |fault| Err(TrackerError::Broken(fault)))
    }

    fn save(&self) -> Option<Vec<u8>> {
        match self.signal.size_history() {
            0 => saved::to_bytes(&self.memory),
            _ => saved::to_bytes(&(&self.memory, &self.sides)),
        }
    }

    fn restore(&mut self, saved: &[u8]) -> bool {
        let history = self.signal.size_history();
        let both = match history {
            0 => saved::from_bytes(saved).map(|memory: S::Memory| (memory, Vec::new())),
            _ => saved::from_bytes(saved),
        };
        let finite = |sides: &[(f64, f64)]| sides.iter().all(|(w, h)| w.is_finite() && h.is_finite());
        let both = both.filter(|(memory, sides)| {
            self.signal.is_memory(memory) && sides.len() <= history + 1 && finite(sides)
        });
        both.map(|both| (self.memory, self.sides) = both).is_some()
    }
}

#[cfg(test)]
mod tests {
    use crate::image::Frame;
    use crate::region::{Rect, Region};
    use crate::saved;
    use crate::signal::Observation;
    use crate::signal::testing::{build, run, start, takes};
    use crate::tracker::TrackerState;

    // Sides 8, 16 and 24 around (20, 20): the mean of two is 8, 12, 20.
    #[test]
    fn a_box_has_the_mean_sides_of_its_history() {
        let frame =
            |t: usize| Frame::from_fn(40, 40, |x, y| [(x * 37 + t) as u8, (y * 53) as u8, (x * y + t) as u8]);
        let frames = [frame(0), frame(30), frame(60)];
        let around = |side: f64| Rect::new(20.0 - side / 2.0, 20.0 - side / 2.0, side, side);
        let (own, mean) = ([8.0, 16.0, 24.0].map(around), [8.0, 12.0, 20.0].map(around));
        for kind in ["region-covariance", "rgb-histogram", "rgb-lbp-histogram"] {
            let averaged = run(kind, "{ size_history = 1 }", &frames, &own);
            assert_eq!(averaged, run(kind, "{}", &frames, &mean), "{kind}");
            assert_ne!(averaged, run(kind, "{}", &frames, &own), "{kind}");
        }
        // A side that is no number leaves the history as it was.
        let mut session = start(&*build("rgb-histogram", "{ size_history = 1 }"));
        for r in [own[0], Rect { h: f64::NAN, ..own[1] }, own[1]] {
            session.push(&Observation::new(&frames[0], &TrackerState::tracked(Region::Rect(r)))).unwrap();
        }
        let (memory, sides): (Option<Vec<f64>>, Vec<(f64, f64)>) =
            saved::from_bytes(&session.save().unwrap()).unwrap();
        assert_eq!(sides, [(8.0, 8.0), (16.0, 16.0)]);
        for (side, is_taken) in [(8.0, true), (f64::NAN, false)] {
            let memory = (&memory, vec![(8.0, side)]);
            assert_eq!(takes("rgb-histogram", "{ size_history = 1 }", &memory), is_taken, "{side}");
        }
    }
}
