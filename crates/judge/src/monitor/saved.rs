//! Saved monitors as bytes: a line with the number of the format, the SHA-256 digest of the rest, and the
//! state of the method.
//!
//! Formats:
//! - 1: first version.
//! - 2: adds whether the current loss was raised in a frame with a box, the inputs, and the pixel base.
//! - 3: a missing confidence repeats the last one, as in `detect`; adds whether the
//!   method was named, and how long a probability of one half still counts.
//! - 4: adds what tells an alarm that is raised from one that is held.

use super::chosen::Chosen;
use super::{Monitor, MonitorError, Options, State, checked};
use crate::method::Inputs;
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};

const NAME: &[u8] = b"trackfail-monitor ";
const FORMAT: &[u8] = b"4";
/// Length of a digest in bytes.
const DIGEST: usize = 32;

#[derive(Serialize, Deserialize)]
struct MethodMemory {
    name: String,
    digest: String,
    signals: Vec<Vec<u8>>,
    stream: Vec<u8>,
}

/// Serializes a state after a line with its name and format, and its own digest.
pub(super) fn sealed(name: &[u8], format: &[u8], memory: &impl Serialize) -> Result<Vec<u8>, MonitorError> {
    let memory = postcard::to_stdvec(memory).map_err(|_| MonitorError::Damaged)?;
    Ok([name, format, b"\n", Sha256::digest(&memory).as_slice(), &memory].concat())
}

/// Deserializes a [`sealed`] state of this name and format; `None` after another name.
pub(super) fn unsealed<M: DeserializeOwned>(
    saved: &[u8],
    name: &[u8],
    format: &[u8],
) -> Result<Option<M>, MonitorError> {
    let Some(rest) = saved.strip_prefix(name) else { return Ok(None) };
    let end = rest.iter().take(20).position(|b| *b == b'\n').ok_or(MonitorError::Damaged)?;
    if rest[..end] != *format {
        return Err(MonitorError::OtherFormat(String::from_utf8_lossy(&rest[..end]).into_owned()));
    }
    let (digest, memory) = rest[end + 1..].split_at_checked(DIGEST).ok_or(MonitorError::Damaged)?;
    if Sha256::digest(memory).as_slice() != digest {
        return Err(MonitorError::Damaged);
    }
    postcard::from_bytes(memory).map(Some).map_err(|_| MonitorError::Damaged)
}

impl Monitor {
    /// Saves the state for [`Monitor::resume`].
    ///
    /// # Errors
    /// When the method has a signal that cannot be saved.
    pub fn save(&self) -> Result<Vec<u8>, MonitorError> {
        let method = match &self.chosen {
            None => None,
            Some(chosen) => Some(MethodMemory {
                name: chosen.name.clone(),
                digest: chosen.digest.clone(),
                signals: chosen.reader.save().map_err(MonitorError::NotSaved)?,
                stream: chosen.stream.save(),
            }),
        };
        let last = self.chosen.as_ref().and_then(|chosen| chosen.reader.last().cloned());
        sealed(NAME, FORMAT, &(State { last, ..self.state.clone() }, method))
    }

    /// Restores a monitor from a [saved](Monitor::save) state; it then gives the same answers.
    ///
    /// # Errors
    /// Bytes that are not a state, damaged, or of another version; a state with a method, budget, inputs or
    /// base other than those of the options.
    pub fn resume(options: &Options, saved: &[u8]) -> Result<Self, MonitorError> {
        let of_several = saved.starts_with(super::targets::NAME);
        let refused = if of_several { MonitorError::SeveralTargets } else { MonitorError::NoState };
        let memory: (State, Option<MethodMemory>) = unsealed(saved, NAME, FORMAT)?.ok_or(refused)?;
        let (mut state, method) = memory;
        state.last.as_ref().map(checked).transpose().map_err(|_| MonitorError::Damaged)?;
        let other = |saved, given| Err(MonitorError::OtherOptions { saved, given });
        if let (Some(given), Some(saved)) = (&options.method, &method)
            && *given != saved.name
        {
            return other(format!("of method `{}`", saved.name), format!("of `{given}`"));
        }
        let mut monitor = Self::new(&Options {
            method: options.method.clone(),
            budget: options.budget.or(state.budget),
            inputs: options.inputs.or(state.inputs),
            base: options.base.or(Some(state.base)),
        })?;
        let State { budget, inputs, base, is_free, .. } = monitor.state;
        if let Some(saved) = method {
            if budget != state.budget {
                return other(with_budget(state.budget), with_budget(budget));
            }
            if inputs != state.inputs {
                return other(for_inputs(state.inputs), for_inputs(inputs));
            }
            if base != state.base {
                let saved = format!("of boxes that count pixels from {}", state.base);
                return other(saved, format!("from {base}"));
            }
            let mut chosen = Chosen::start(&saved.name, budget)?;
            if chosen.digest != saved.digest {
                return Err(MonitorError::OtherVersion(saved.name));
            }
            if !chosen.restore(&saved.signals, &saved.stream, state.last.take()) {
                return Err(MonitorError::Damaged);
            }
            monitor.chosen = Some(chosen);
        }
        monitor.state = State { budget, inputs, base, is_free: is_free && state.is_free, ..state };
        Ok(monitor)
    }
}

fn with_budget(budget: Option<f64>) -> String {
    budget.map_or_else(|| "with the usual budget".to_string(), |budget| format!("with a budget of {budget}"))
}

fn for_inputs(inputs: Option<Inputs>) -> String {
    let Some(Inputs { frames, companions, confidence }) = inputs else {
        return "for no inputs in particular".to_string();
    };
    let named = [(frames, ", frames"), (confidence, ", confidence"), (companions, ", companions")];
    let named = named.into_iter().filter_map(|(is_named, word)| is_named.then_some(word));
    std::iter::once("for boxes").chain(named).collect()
}
