//! Sessions of signals that are a function of each tracker state alone.

use super::{Observation, Session};
use crate::tracker::TrackerState;

/// A session whose value is what `of` finds in the state; not a number where it finds nothing.
pub fn of_state(of: impl Fn(&TrackerState) -> Option<f64> + Send + 'static) -> Box<dyn Session> {
    Box::new(StateValue(of))
}

struct StateValue<F>(F);

impl<F: Fn(&TrackerState) -> Option<f64> + Send> Session for StateValue<F> {
    fn push(&mut self, observation: &Observation<'_>) -> f64 {
        (self.0)(observation.state).unwrap_or(f64::NAN)
    }
}
