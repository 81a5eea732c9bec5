//! Methods: signals and a detector under a name. Some are published under a name; one is recommended for
//! given inputs.

use crate::detector::{DETECTORS, Detector};
use crate::plugin::{self, Configured, Entry, RawParams};
use crate::score::Restarts;
use crate::signal::{Reads, SIGNALS, Signal};
use serde::{Deserialize, Serialize};
use serde_json::Value;
use std::fmt::Display;
use std::sync::LazyLock;

/// Named methods as JSON: `name`, `about`, `signal` (one or a list) and `detector`, with parameters as in an
/// experiment file.
pub const METHODS: &str = include_str!("methods.json");

/// Name of the parameter for the budget of false alarms.
const BUDGET: &str = "budget";

/// A signal with checked parameters, its kind and version.
#[derive(Clone)]
pub struct SignalChoice {
    /// Plugin kind.
    pub kind: &'static str,
    /// Plugin version.
    pub version: u32,
    /// Signal with checked parameters.
    pub signal: Configured<dyn Signal>,
    /// Treatment of restarts of the tracker.
    pub restarts: Restarts,
}

impl SignalChoice {
    /// A signal of a kind; restarts of the tracker are parts of its track.
    pub fn new(entry: &Entry<dyn Signal>, signal: Configured<dyn Signal>) -> Self {
        Self { kind: entry.kind, version: entry.version, signal, restarts: Restarts::default() }
    }
}

/// A detector with checked parameters, its kind and version.
#[derive(Clone)]
pub struct FixedDetector {
    /// Plugin kind.
    pub kind: &'static str,
    /// Plugin version.
    pub version: u32,
    /// Detector with checked parameters.
    pub detector: Configured<dyn Detector>,
    /// Treatment of restarts of the tracker.
    pub restarts: Restarts,
}

impl FixedDetector {
    /// A detector of a kind; restarts of the tracker are parts of its track.
    pub fn new(entry: &Entry<dyn Detector>, detector: Configured<dyn Detector>) -> Self {
        Self { kind: entry.kind, version: entry.version, detector, restarts: Restarts::default() }
    }
}

/// Signals and a detector that reads them.
#[derive(Clone)]
pub struct Method {
    /// Name of the method.
    pub name: String,
    /// Signals of the method; empty for a detector that needs none.
    pub signals: Vec<SignalChoice>,
    /// Detector of the method.
    pub detector: FixedDetector,
}

/// Reason why a method cannot be built.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum MethodError {
    /// The threshold of the method is trained in an experiment.
    #[error(
        "method `{0}` has a threshold that is trained on annotated sequences; it runs in an experiment (`trackfail run`)"
    )]
    Trained(String),
    /// There is no such method or plugin, or a budget, a parameter or the number of signals does not fit.
    #[error("{0}")]
    Refused(String),
}

#[derive(Deserialize)]
struct Named {
    name: String,
    signal: Value,
    detector: Value,
}

impl Named {
    fn signals(&self) -> &[Value] {
        self.signal.as_array().map_or(std::slice::from_ref(&self.signal), Vec::as_slice)
    }
}

static NAMED: LazyLock<Vec<Named>> = LazyLock::new(|| serde_json::from_str(METHODS).unwrap_or_default());

fn find(name: &str) -> Option<&'static Named> {
    NAMED.iter().find(|named| named.name == name)
}

/// Names of all named methods.
pub fn names() -> Vec<&'static str> {
    NAMED.iter().map(|named| named.name.as_str()).collect()
}

/// True if the detector of a named method has a budget of false alarms.
pub fn takes_budget(name: &str) -> bool {
    let kind = find(name).and_then(|named| named.detector["kind"].as_str());
    let schema = kind.and_then(|kind| plugin::find(DETECTORS, kind)).map(|entry| (entry.schema)());
    schema.is_some_and(|schema| schema.get("properties").and_then(|p| p.get(BUDGET)).is_some())
}

impl Method {
    /// Method called `name` with its published threshold. With a budget, the threshold allows at most this
    /// number of false alarms per 1000 frames.
    ///
    /// # Errors
    /// An unknown name, a method that is trained in an experiment, and a budget for a method without one.
    pub fn named(name: &str, budget: Option<f64>) -> Result<Self, MethodError> {
        let unknown = || MethodError::Refused(plugin::unknown("method", name, names()));
        let named = find(name).ok_or_else(unknown)?;
        let mut detector = named.detector.clone();
        let is_trained = |value: &Value| value.get("train").is_some();
        if detector.as_object().is_some_and(|params| params.values().any(is_trained)) {
            return Err(MethodError::Trained(name.to_string()));
        }
        if let Some(budget) = budget {
            if !takes_budget(name) {
                let known: Vec<&str> = names().into_iter().filter(|name| takes_budget(name)).collect();
                return Err(MethodError::Refused(format!(
                    "method `{name}` takes no budget of false alarms; methods that take one: {}",
                    known.join(", ")
                )));
            }
            detector[BUDGET] = budget.into();
        }
        Self::new(name, named.signals(), &detector)
    }

    /// Creates a custom method. Signals and detector are objects with a `kind` and the parameters that
    /// `trackfail list` shows: `{"kind": "level", "below": 0.5}`.
    ///
    /// # Errors
    /// Unknown kinds, refused parameters, and a number of signals that does not match the detector.
    pub fn new(name: &str, signals: &[Value], detector: &Value) -> Result<Self, MethodError> {
        let signal = |value: &Value| {
            let (entry, signal) = build(SIGNALS, "signal", value)?;
            Ok(SignalChoice::new(entry, signal))
        };
        let signals: Vec<SignalChoice> = signals.iter().map(signal).collect::<Result<_, MethodError>>()?;
        let (entry, detector) = build(DETECTORS, "detector", detector)?;
        let facts = detector.facts();
        let reads = if facts.needs_signal { facts.signals } else { 0 };
        let given: usize = signals.iter().map(|choice| choice.signal.width()).sum();
        if given != reads {
            let message = format!("detector `{}` reads {reads} signals, not {given}", entry.kind);
            return Err(MethodError::Refused(message));
        }
        Ok(Self { name: name.to_string(), signals, detector: FixedDetector::new(entry, detector) })
    }

    /// The method with a learned model, as in the files of the folder `models` of an experiment's results.
    ///
    /// # Errors
    /// A method that does not learn, and a model of another method.
    pub fn with_model(mut self, model: &Value) -> Result<Self, MethodError> {
        let kind = self.detector.kind;
        let learner = self.detector.detector.learner().ok_or_else(|| refused(kind, "it does not learn"))?;
        let detector = learner.with_model(model).map_err(|e| refused(kind, e))?;
        self.detector.detector.plugin = detector;
        Ok(self)
    }

    /// Parts of a track that the signals read.
    pub fn reads(&self) -> impl Iterator<Item = Reads> + '_ {
        self.signals.iter().map(|choice| choice.signal.reads())
    }

    /// Description of signals and detector with their parameters.
    pub fn words(&self) -> String {
        let signals = self.signals.iter().map(|s| format!("{} {}", s.kind, s.signal.params()));
        let detector = format!("{} {}", self.detector.kind, self.detector.detector.params());
        signals.chain([detector]).collect::<Vec<_>>().join("; ")
    }
}

/// Error about a signal or a detector.
fn refused(part: &str, message: impl Display) -> MethodError {
    MethodError::Refused(format!("{part}: {message}"))
}

/// Builds a plugin from its kind and its parameters.
fn build<T: ?Sized>(
    list: &'static [Entry<T>],
    what: &str,
    value: &Value,
) -> Result<(&'static Entry<T>, Configured<T>), MethodError> {
    let mut params = match value {
        Value::Object(params) => params.clone(),
        _ => return Err(refused(what, "must be an object with a `kind`")),
    };
    let Some(Value::String(kind)) = params.remove("kind") else {
        return Err(refused(what, "has no `kind`"));
    };
    let entry = plugin::find(list, &kind)
        .ok_or_else(|| refused(what, plugin::unknown(what, &kind, list.iter().map(|e| e.kind))))?;
    let built = (entry.build)(RawParams::Json(&params.into())).map_err(|e| refused(&kind, e))?;
    Ok((entry, built))
}

/// Inputs that are available for a track, beside its boxes.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Inputs {
    /// True if the frames are available.
    pub frames: bool,
    /// True if boxes of other trackers on the same frames are available.
    pub companions: bool,
    /// True if the tracker's own confidence is available.
    pub confidence: bool,
}

impl Inputs {
    /// True if a signal with this input can be computed.
    pub fn has(self, reads: Reads) -> bool {
        match reads {
            Reads::Boxes => true,
            Reads::Pixels => self.frames,
            Reads::Companions => self.companions,
            Reads::Confidence => self.confidence,
            Reads::Posterior | Reads::Response => false,
        }
    }
}

/// Name of the method that the benchmark recommends for the given inputs, see `docs/which-detector.md`; with a budget of
/// false alarms, among those that have one.
pub fn recommended(inputs: Inputs, budget: Option<f64>) -> &'static str {
    match inputs {
        Inputs { frames: true, companions: true, .. } => "Fused deep and companions",
        Inputs { companions: true, .. } => "Fused companions",
        Inputs { frames: true, .. } => "Fused deep",
        Inputs { confidence: true, .. } if budget.is_none() => "Confidence",
        Inputs { .. } => "Fused boxes",
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;
    use trackfail_testing::assert_says;

    fn message(name: &str, budget: Option<f64>) -> String {
        Method::named(name, budget).err().unwrap().to_string()
    }

    #[test]
    fn recommended_methods_have_a_name() {
        for bits in 0..8 {
            let [frames, companions, confidence] = [1, 2, 4].map(|bit| bits & bit > 0);
            let inputs = Inputs { frames, companions, confidence };
            let method = Method::named(recommended(inputs, None), None).unwrap();
            assert!(method.reads().all(|reads| inputs.has(reads)), "{inputs:?}");
            assert!(takes_budget(recommended(inputs, Some(1.0))), "{inputs:?}");
        }
    }

    #[test]
    fn named_methods_build_unless_they_are_trained() {
        let all = "DTEF, NAIVE, RAW, CovF, RgbHist, RLHist, AVU, Two-MChi, M-model, EmpTh, ARTE, ARTE*, Companions, \
                   Watchdog, Displacement, Scale, Forward-backward, First colors, Object colors, Template, CUSUM, \
                   Page-Hinkley, Sequential test, Conformal DTEF, PSR, APCE, LMCF, FuCoLoT, Confidence, Fused boxes, \
                   Fused companions, Agreement, Fused deep, Fused deep full, Fused deep v3, Fused deep and companions";
        assert_eq!(names().join(", "), all);
        for name in names() {
            match Method::named(name, None) {
                Ok(method) => {
                    assert_eq!(method.name, name);
                    let learns = method.detector.detector.learner().is_some();
                    assert_eq!(learns, ["AVU", "ARTE*"].contains(&name), "{name}");
                    assert!(method.with_model(&json!({ "none": 3 })).is_err(), "{name}");
                }
                Err(e) => assert_eq!((name, e), ("EmpTh", MethodError::Trained("EmpTh".into()))),
            }
        }
        assert_eq!(message("Watchdgo", None), "unknown method `Watchdgo`; did you mean `Watchdog`?");
    }

    #[test]
    fn a_method_takes_another_budget() {
        assert!(takes_budget("Fused boxes") && !takes_budget("CovF") && !takes_budget("none"));
        let method = Method::named("Fused boxes", Some(7.0)).unwrap();
        assert_eq!(method.detector.detector.params()["budget"], 7.0);
        for wrong in [0.0, 1e9] {
            let told = message("Fused boxes", Some(wrong));
            assert_says(told, "fused: `budget` must be from 0.000001 to 1000, not ");
        }
        assert!(Method::named("Fused boxes", Some(f64::NAN)).is_err());
        assert_says(message("CovF", Some(1.0)), "method `CovF` takes no budget of false alarms");
    }

    #[test]
    fn a_method_of_ones_own_is_checked() {
        let of = |signals: &[Value], detector: &Value| match Method::new("mine", signals, detector) {
            Ok(method) => method.words(),
            Err(e) => e.to_string(),
        };
        let colors = [json!({ "kind": "rgb-histogram" })];
        let level = json!({ "kind": "level", "below": 0.5 });
        let misspelled = json!({ "kind": "levle", "below": 0.5 });
        for (signals, detector, words) in [
            (&colors[..], &level, r#"; level {"below":0.5}"#),
            (&[], &level, "detector `level` reads 1 signals, not 0"),
            (&[json!(3)], &level, "signal: must be an object with a `kind`"),
            (&[json!({})], &level, "signal: has no `kind`"),
            (&colors, &misspelled, "detector: unknown detector `levle`; did you mean `level`?"),
        ] {
            let told = of(signals, detector);
            assert!(told.ends_with(words), "{told}");
        }
        let told = of(&colors, &json!({ "kind": "level", "below": "low" }));
        assert!(told.starts_with("level: ") && told.contains("below"), "{told}");
    }
}
