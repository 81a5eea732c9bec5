//! The method of a monitor at work.

use super::{MonitorError, Update};
use crate::dataset::user_frames;
use crate::detector::{Judgement, Stream};
use crate::image::Frame;
use crate::num::hexadecimal;
use crate::plugin;
use crate::region::Region;
use crate::signal::{Observation, Reads, Session};
use crate::spec::builtin::{self, Inputs};
use crate::spec::method::{DetectorChoice, FixedDetector, Method, SignalChoice};
use crate::tracker::{RunContext, TrackerState};
use sha2::{Digest, Sha256};

/// A method with the memory of its signals and of its detector.
pub(super) struct Chosen {
    pub name: String,
    /// Digest of everything that the memory depends on beside the track.
    pub digest: String,
    pub detector: FixedDetector,
    pub signals: Vec<Watched>,
    pub stream: Box<dyn Stream>,
    /// Stands for a frame that is not there.
    blank: Frame,
}

/// A signal of the track.
pub(super) struct Watched {
    pub kind: &'static str,
    reads: Reads,
    pub session: Box<dyn Session>,
}

impl Chosen {
    /// The method of this name before its first frame, with a budget of false alarms if it is given one.
    pub fn start(name: &str, budget: Option<f64>) -> Result<Self, MonitorError> {
        let names = builtin::method_names;
        let unknown = || MonitorError::UnknownMethod(plugin::unknown("method", name, names()));
        let method = match budget {
            Some(budget) if builtin::takes_budget(name) => {
                builtin::published_method_with_budget(name, budget)
            }
            Some(_) if names().contains(&name) => {
                let known = builtin::methods_with_budget();
                return Err(MonitorError::NoBudget { method: name.to_string(), known });
            }
            _ => builtin::published_method(name),
        };
        let method = method.ok_or_else(unknown)??;
        Self::of_method(&method).map_err(|reason| match reason {
            Refusal::Unfit(reason) => MonitorError::Unfit { method: name.to_string(), reason, known: able() },
            Refusal::Error(error) => error,
        })
    }

    /// The method that is recommended for the inputs, of those that take a budget if there is one.
    pub fn recommended(inputs: Inputs, budget: Option<f64>) -> Result<Self, MonitorError> {
        let name = match budget {
            Some(_) => builtin::recommended_with_budget(inputs),
            None => builtin::recommended(inputs),
        };
        Self::start(name, budget)
    }

    /// The method before its first frame, or why it cannot monitor.
    pub fn of_method(method: &Method) -> Result<Self, Refusal> {
        let variant = method.variants.first().ok_or(Refusal::Unfit("has no detector"))?;
        let DetectorChoice::Given(detector) = &variant.detector else {
            return Err(Refusal::Unfit("is trained for each experiment"));
        };
        if variant.signals().any(|s| matches!(s.signal.reads(), Reads::Posterior | Reads::Response)) {
            return Err(Refusal::Unfit("needs more of a tracker than boxes and a confidence"));
        }
        let stream = detector.detector.stream().ok_or(Refusal::Unfit("judges whole tracks"))?;
        let signals: Vec<&SignalChoice> = variant.signals().collect();
        let sequence = user_frames::without_frames("stream", 0);
        let context = RunContext { sequence: &sequence, start_frame: 0, run: 0, seed: 0, data_roots: &[] };
        let watched = |choice: &&SignalChoice| {
            let session = choice.signal.start(&context).map_err(|e| Refusal::Error(e.into()))?;
            Ok(Watched { kind: choice.kind, reads: choice.signal.reads(), session })
        };
        Ok(Self {
            name: method.name.clone(),
            digest: digest(&signals, detector),
            detector: detector.clone(),
            signals: signals.iter().map(watched).collect::<Result<_, _>>()?,
            stream,
            blank: Frame::new(1, 1, vec![0; 3]),
        })
    }

    /// Judges the next frame; the text is the fault of a signal, if there is one.
    pub fn push(&mut self, update: &Update<'_>, state: &TrackerState) -> (Judgement, Option<String>) {
        let companions: Vec<&Region> = update.companions.iter().collect();
        let frame = update.frame.unwrap_or(&self.blank);
        let mut note = None;
        let mut is_told = false;
        let mut value = |signal: &mut Watched| {
            if signal.reads == Reads::Pixels && update.frame.is_none() {
                return f64::NAN;
            }
            // Where the tracker gives no confidence, the signal has the last one again.
            let value = signal.session.push(&Observation { frame, state, companions: &companions });
            let fault = signal.session.fault().map(|fault| fault.to_string());
            note = note.take().or(fault);
            is_told |= !value.is_nan() && (signal.reads != Reads::Confidence || state.confidence.is_some());
            value
        };
        let values: Vec<f64> = self.signals.iter_mut().map(&mut value).collect();
        if !is_told {
            note = note.or_else(|| self.needs());
        }
        (self.stream.push(&values), note)
    }

    /// Note on a frame of which no signal has a value.
    fn needs(&self) -> Option<String> {
        let first = self.signals.first()?;
        Some(format!("nothing to judge by: the method needs {}", first.reads.need()))
    }

    /// Whether a signal looks at pixels.
    pub fn reads_frames(&self) -> bool {
        self.signals.iter().any(|signal| signal.reads == Reads::Pixels)
    }

    /// Takes over the memory of another one of the same method; `false` if it does not fit.
    pub fn restore(&mut self, signals: &[Vec<u8>], stream: &[u8]) -> bool {
        let Some(stream) = self.detector.detector.resume(stream) else { return false };
        self.stream = stream;
        let pairs = self.signals.iter_mut().zip(signals);
        signals.len() == pairs.len() && pairs.into_iter().all(|(signal, saved)| signal.session.restore(saved))
    }
}

/// Why a method cannot monitor.
pub(super) enum Refusal {
    Unfit(&'static str),
    Error(MonitorError),
}

/// The methods that can monitor.
pub(super) fn able() -> Vec<&'static str> {
    let can = |name: &&str| {
        let method = builtin::published_method(name).and_then(Result::ok);
        method.is_some_and(|method| Chosen::of_method(&method).is_ok())
    };
    builtin::method_names().into_iter().filter(can).collect()
}

fn digest(signals: &[&SignalChoice], detector: &FixedDetector) -> String {
    let mut all: Vec<_> = signals.iter().map(|s| (s.kind, s.version, s.signal.params())).collect();
    all.push((detector.kind, detector.version, detector.detector.params()));
    let text = serde_json::to_string(&all).unwrap_or_default();
    hexadecimal(&Sha256::digest(text))
}
