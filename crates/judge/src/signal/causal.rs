//! Signals whose value is a function of the frame and of what they remember of the frames before.

use super::{Facts, Observation, Session, Signal};
use crate::saved;
use crate::tracker::{RunContext, TrackerError};
use serde::Serialize;
use serde::de::DeserializeOwned;

/// A signal that says what one frame does to its memory, which is all that makes a [`Session`] that can be interrupted.
pub trait Causal: Clone + Send + Sync + 'static {
    /// Memory of the frames before; the default is that before the first frame.
    type Memory: Default + Serialize + DeserializeOwned + Send;

    /// Properties of its values.
    fn facts(&self) -> Facts;

    /// The value of the next frame; not finite where the state lacks what the signal reads.
    fn push(&self, memory: &mut Self::Memory, observation: &Observation<'_>) -> f64;

    /// Whether a memory can be one of this signal with these parameters.
    fn is_memory(&self, _memory: &Self::Memory) -> bool {
        true
    }
}

impl<S: Causal> Signal for S {
    fn facts(&self) -> Facts {
        Causal::facts(self)
    }

    fn start(&self, _: &RunContext<'_>) -> Result<Box<dyn Session>, TrackerError> {
        Ok(Box::new(Following { signal: self.clone(), memory: S::Memory::default() }))
    }
}

/// A signal on one track.
struct Following<S: Causal> {
    signal: S,
    memory: S::Memory,
}

impl<S: Causal> Session for Following<S> {
    fn push(&mut self, observation: &Observation<'_>) -> f64 {
        self.signal.push(&mut self.memory, observation)
    }

    fn save(&self) -> Option<Vec<u8>> {
        saved::to_bytes(&self.memory)
    }

    fn restore(&mut self, saved: &[u8]) -> bool {
        let memory = saved::from_bytes(saved).filter(|memory| self.signal.is_memory(memory));
        memory.map(|memory| self.memory = memory).is_some()
    }
}
