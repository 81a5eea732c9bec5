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
use super::{Monitor, MonitorError, Options, checked};
use crate::detector::StateOfTarget;
use crate::judged::Raising;
use crate::method::Inputs;
use crate::region::Region;
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};

const NAME: &[u8] = b"trackfail-monitor ";
const FORMAT: &[u8] = b"4";
/// Length of a digest in bytes.
const DIGEST: usize = 32;

#[derive(Serialize, Deserialize)]
struct Memory {
    index: u64,
    size: Option<(usize, usize)>,
    last: Option<Region>,
    raising: Raising,
    target: StateOfTarget,
    base: u8,
    budget: Option<f64>,
    inputs: Option<Inputs>,
    is_free: bool,
    method: Option<MethodMemory>,
}

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
        let Self { index, size, raising, target, base, budget, inputs, is_free, .. } = *self;
        let last = self.chosen.as_ref().and_then(|chosen| chosen.reader.last().cloned());
        let memory = Memory { index, size, last, raising, target, base, budget, inputs, is_free, method };
        sealed(NAME, FORMAT, &memory)
    }

    /// Restores a monitor from a [saved](Monitor::save) state; it then gives the same answers.
    ///
    /// # Errors
    /// Bytes that are not a state, damaged, or of another version; a state with a method, budget, inputs or
    /// base other than those of the options.
    pub fn resume(options: &Options, saved: &[u8]) -> Result<Self, MonitorError> {
        let of_several = saved.starts_with(super::targets::NAME);
        let refused = if of_several { MonitorError::SeveralTargets } else { MonitorError::NoState };
        let memory: Memory = unsealed(saved, NAME, FORMAT)?.ok_or(refused)?;
        memory.last.as_ref().map(checked).transpose().map_err(|_| MonitorError::Damaged)?;
        let other = |saved, given| Err(MonitorError::OtherOptions { saved, given });
        if let (Some(given), Some(saved)) = (&options.method, &memory.method)
            && *given != saved.name
        {
            return other(format!("of method `{}`", saved.name), format!("of `{given}`"));
        }
        let mut monitor = Self::new(&Options {
            method: options.method.clone(),
            budget: options.budget.or(memory.budget),
            inputs: options.inputs.or(memory.inputs),
            base: options.base.or(Some(memory.base)),
        })?;
        (monitor.index, monitor.size) = (memory.index, memory.size);
        (monitor.raising, monitor.target) = (memory.raising, memory.target);
        monitor.is_free &= memory.is_free;
        if let Some(saved) = memory.method {
            if monitor.budget != memory.budget {
                return other(with_budget(memory.budget), with_budget(monitor.budget));
            }
            if monitor.inputs != memory.inputs {
                return other(for_inputs(memory.inputs), for_inputs(monitor.inputs));
            }
            if monitor.base != memory.base {
                let saved = format!("of boxes that count pixels from {}", memory.base);
                return other(saved, format!("from {}", monitor.base));
            }
            let mut chosen = Chosen::start(&saved.name, memory.budget)?;
            if chosen.digest != saved.digest {
                return Err(MonitorError::OtherVersion(saved.name));
            }
            if !chosen.restore(&saved.signals, &saved.stream, memory.last) {
                return Err(MonitorError::Damaged);
            }
            monitor.chosen = Some(chosen);
        }
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
