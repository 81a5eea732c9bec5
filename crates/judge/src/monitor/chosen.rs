//! The method that a monitor uses, with its state.

use super::MonitorError;
use crate::detector::{Facts, Judgement, Stream};
use crate::judge::Unannotated;
use crate::method::{self, FixedDetector, Inputs, Method, MethodError, SignalChoice};
use crate::num::hexadecimal;
use crate::reader::{Reader, Seen, SignalFault, SignalReader};
use crate::region::Region;
use crate::signal::Reads;
use crate::tracker::RunContext;
use sha2::{Digest, Sha256};

/// A method with the states of its signals and its detector.
pub(super) struct Chosen {
    pub name: String,
    /// Digest of everything on which the state depends, apart from the track.
    pub digest: String,
    /// Facts of the detector.
    pub facts: Facts,
    pub reader: Reader,
    pub stream: Box<dyn Stream>,
}

impl Chosen {
    /// Named method before its first frame, with a budget of false alarms if one is given.
    pub fn start(name: &str, budget: Option<f64>) -> Result<Self, MonitorError> {
        let unfit = |reason| MonitorError::Unfit { method: name.to_string(), reason };
        let method = Method::named(name, budget).map_err(|e| match e {
            MethodError::Trained(_) => unfit("is trained for each experiment"),
            e => e.into(),
        })?;
        if method.detector.detector.learner().is_some() {
            return Err(unfit("is trained for each experiment"));
        }
        if method.reads().any(|reads| matches!(reads, Reads::Posterior | Reads::Response)) {
            return Err(unfit("needs more of a tracker than boxes and a confidence"));
        }
        let stream = method.detector.detector.stream().ok_or_else(|| unfit("judges whole tracks"))?;
        let context =
            RunContext { sequence: &Unannotated(0), start_frame: 0, run: 0, seed: 0, data_roots: &[] };
        let reader = Reader::start(&method.signals, &context)?;
        let digest = digest(&method.signals, &method.detector);
        let facts = method.detector.detector.facts();
        Ok(Self { name: method.name, digest, facts, reader, stream })
    }

    /// Recommended method for the inputs; with a budget, one that has a budget.
    pub fn recommended(inputs: Inputs, budget: Option<f64>) -> Result<Self, MonitorError> {
        Self::start(method::recommended(inputs, budget), budget)
    }

    /// Judges the next frame, from the first region on. The text says why a signal has no value.
    pub fn push(&mut self, seen: &Seen<'_>) -> Option<(Judgement, Option<String>)> {
        let values = self.reader.push(seen)?;
        let has_confidence = seen.confidence.is_some_and(f64::is_finite);
        let is_told = |(reads, value): (Reads, &Result<Vec<f64>, SignalFault>)| {
            // Where the tracker gives no confidence, the signal has the last one again.
            value.is_ok() && (reads != Reads::Confidence || has_confidence)
        };
        let reads = self.reader.signals().iter().map(|signal| signal.reads());
        let needs = if reads.zip(&values).any(is_told) { None } else { self.needs() };
        let fault = values.iter().find_map(|value| match value {
            Err(SignalFault::Broke(fault)) => Some(fault.to_string()),
            _ => None,
        });
        let known = |(signal, values): (&SignalReader, Result<Vec<f64>, SignalFault>)| {
            values.unwrap_or_else(|_| vec![f64::NAN; signal.width()])
        };
        let values: Vec<f64> = self.reader.signals().iter().zip(values).flat_map(known).collect();
        Some((self.stream.push(&values), fault.or(needs)))
    }

    /// Note on a frame in which no signal has a value.
    fn needs(&self) -> Option<String> {
        let first = self.reader.signals().first()?;
        Some(format!("nothing to judge by: the method needs {}", first.reads().need()))
    }

    /// Restores saved states of the same method. Returns `false` if they do not match.
    pub fn restore(&mut self, signals: &[Vec<u8>], stream: &[u8], last: Option<Region>) -> bool {
        self.stream.restore(stream) && self.reader.restore(signals, last)
    }
}

/// Names of the methods that can monitor.
pub fn able() -> Vec<&'static str> {
    method::names().into_iter().filter(|name| Chosen::start(name, None).is_ok()).collect()
}

fn digest(signals: &[SignalChoice], detector: &FixedDetector) -> String {
    let mut all: Vec<_> = signals.iter().map(|s| (s.kind, s.version, s.signal.params())).collect();
    all.push((detector.kind, detector.version, detector.detector.params()));
    let text = serde_json::to_string(&all).unwrap_or_default();
    hexadecimal(&Sha256::digest(text))
}
