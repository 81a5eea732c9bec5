//! Methods: a signal and a detector under a name, with a grid of parameters and with trained parameters.

pub use trackfail_judge::method::{FixedDetector, SignalChoice};

use super::error::At;
use super::limits::MAX_DETECTORS;
use super::raw_plugin::{RawPlugin, build, tell};
use super::wire;
use serde_json::{Number, Value};
use std::collections::BTreeMap;
use std::sync::Arc;
use trackfail_core::direction::Direction;
use trackfail_core::num::readable;
use trackfail_core::plugin::ParamError;
use trackfail_methods::detector::{DETECTORS, Detector, Facts};
use trackfail_methods::score::{Metric, Protocol, Restarts};
use trackfail_methods::signal::{Reads, SIGNALS, Signal};
use trackfail_methods::tracker::process::Programs;

/// A method of an experiment.
pub struct Method {
    /// Name in tables.
    pub name: String,
    /// Name of the method of which this one is another reading.
    pub like: Option<String>,
    /// Labels of the trackers on which the method is run; `None` for all.
    pub trackers: Option<Vec<String>>,
    /// Protocol that scores the labels.
    pub protocol: &'static Protocol,
    /// Variants, one for each combination of grid values, in their order; a single one without a grid.
    pub variants: Vec<Variant>,
}

/// A method at one point of its grid.
pub struct Variant {
    /// Values by grid axis, sorted by axis; empty without a grid.
    pub point: Vec<(String, f64)>,
    /// Signals; none for detectors that need none, several for those that read several.
    pub signals: Vec<SignalChoice>,
    /// Detector, complete or to be trained.
    pub detector: DetectorChoice,
}

impl Variant {
    /// Inputs of the signals, in words and without repetitions. Boxes are named only if there is no other
    /// input.
    pub fn needs(&self) -> Vec<&'static str> {
        let mut needs: Vec<&str> = Vec::new();
        for reads in self.signals.iter().map(|choice| choice.signal.reads()) {
            if reads != Reads::Boxes && !needs.contains(&reads.need()) {
                needs.push(reads.need());
            }
        }
        if needs.is_empty() && !self.signals.is_empty() {
            needs.push(Reads::Boxes.need());
        }
        needs
    }

    /// Grid point as in the `params` column of the results: `horizon=5;window=20`. Empty without a grid.
    pub fn params(&self) -> String {
        let parts: Vec<_> =
            self.point.iter().map(|(axis, value)| format!("{axis}={}", readable(value))).collect();
        parts.join(";")
    }

    fn detectors(&self) -> usize {
        self.detector.training.as_ref().map_or(1, |training| training.candidates.count())
    }
}

/// A detector, complete, with one parameter that is chosen on a suite, or with a model that is learned on a suite.
pub struct DetectorChoice {
    /// The detector; one of the candidates, for properties that all share, if a parameter is chosen.
    pub example: FixedDetector,
    /// Rule by which a parameter is chosen; `None` if all are given.
    pub training: Option<Training>,
}

impl DetectorChoice {
    /// Role of the suite used for training; `None` if nothing is trained.
    pub fn role(&self) -> Option<&str> {
        let learned = || self.example.detector.learner().map(|learner| learner.role());
        self.training.as_ref().map(|training| training.role.as_str()).or_else(learned)
    }

    /// True if the detector is trained for each sequence and tracker on the others.
    pub fn trains_on_others(&self) -> bool {
        self.role() == Some(super::OTHERS)
    }

    /// True if one model is learned from the tracks of all trackers.
    pub fn pools_trackers(&self) -> bool {
        self.example.detector.learner().is_some_and(|learner| learner.pools_trackers())
    }
}

/// Rule by which a parameter is chosen on a suite.
pub struct Training {
    /// The parameter's name.
    pub key: String,
    /// Role of the suite, or [`OTHERS`](super::OTHERS).
    pub role: String,
    /// Metric that is maximized.
    pub maximise: Metric,
    /// The values that are tried.
    pub candidates: Candidates,
}

/// Builds the detector with a value of the trained parameter. The detector may refuse the value.
pub type BuildWith = Arc<dyn Fn(f64) -> Result<FixedDetector, ParamError> + Send + Sync>;

/// Values that are tried in training.
#[derive(Clone)]
pub enum Candidates {
    /// Listed values with their detectors, ascending.
    Listed(Vec<(f64, FixedDetector)>),
    /// Quantiles of the signal on the training suite.
    Quantiles {
        /// Number of quantiles.
        count: usize,
        /// Builds the detector with a value.
        build: BuildWith,
    },
}

impl Candidates {
    /// Most candidates that there can be.
    pub fn count(&self) -> usize {
        match self {
            Self::Listed(list) => list.len(),
            Self::Quantiles { count, .. } => *count,
        }
    }
}

impl Method {
    /// True if the method is run on a tracker.
    pub fn runs_on(&self, tracker: &str) -> bool {
        self.trackers.as_ref().is_none_or(|mine| mine.iter().any(|t| t == tracker))
    }

    /// True if the method has a grid.
    pub fn has_grid(&self) -> bool {
        self.variants.iter().any(|v| !v.point.is_empty())
    }

    /// Number of detectors of the method, including the candidates of training.
    pub fn detectors(&self) -> usize {
        self.variants.iter().map(Variant::detectors).sum()
    }
}

/// Most combinations in the grid of a method.
const MAX_VARIANTS: usize = 10_000;
/// Most candidates of a trained parameter.
const MAX_CANDIDATES: usize = 1_000;

/// Checks a `[[method]]` of at most `room` detectors, which is run on all trackers and scored by `protocol`.
///
/// Its signals and detectors may run `programs`. Without that list, those that name a program cannot run.
pub(super) fn read(
    at: At<'_>,
    programs: Option<&Programs>,
    wire: &wire::Method,
    protocol: &'static Protocol,
    room: usize,
) -> Option<Method> {
    let name = &wire.name;
    let Some(detector) = &wire.detector else {
        return at.refuse(format!("method `{name}` has no detector, and no published method has that name"));
    };
    let signals = match &wire.signal {
        Some(Value::Array(list)) => list.as_slice(),
        one => one.as_slice(),
    };
    let in_signal = at.key("signal");
    let read = |(k, params)| RawPlugin::read(in_signal.item(k), programs, params, "signal", SIGNALS);
    let signals: Option<Vec<RawPlugin<'_, dyn Signal>>> = signals.iter().enumerate().map(read).collect();
    let detector = RawPlugin::read(at.key("detector"), programs, detector, "detector", DETECTORS);
    let (signals, detector) = (signals?, detector?);
    let training = trained(&detector).ok()?;
    let parts = Parts { at, name, detector, signals, training, restarts: protocol.restarts };
    let axes = parts.axes(wire.grid.as_ref())?;
    let mut variants = Vec::new();
    let mut detectors = 0;
    for point in combinations(&axes) {
        let variant = parts.variant(&point)?;
        let goes_back = variant.detector.example.detector.facts().needs_reverse;
        if protocol.restarts == Restarts::NewTrack && goes_back {
            return at.refuse(format!(
                "method `{name}` runs trackers backwards, which is not possible under {}: a restart begins a new track there",
                protocol.name
            ));
        }
        detectors += variant.detectors();
        if detectors > room {
            return at.refuse(format!("the experiment tries more than {MAX_DETECTORS} detectors"));
        }
        variants.push(variant);
    }
    let (name, like, trackers) = (name.clone(), wire.like.clone(), wire.trackers.clone());
    Some(Method { name, like, trackers, protocol, variants })
}

/// Axis of the grid: a parameter of the signal or the detector, and its values.
struct Axis<'g> {
    name: &'g str,
    of_signal: bool,
    values: &'g [Number],
}

/// The value of each axis.
type Point<'a> = Vec<(&'a Axis<'a>, &'a Number)>;

fn combinations<'a>(axes: &'a [Axis<'a>]) -> Vec<Point<'a>> {
    axes.iter().fold(vec![Vec::new()], |points, axis| {
        let with = |point: &Point<'a>| -> Vec<Point<'a>> {
            axis.values.iter().map(|value| [point.as_slice(), &[(axis, value)]].concat()).collect()
        };
        points.iter().flat_map(with).collect()
    })
}

/// Parts of a method from which its variants are built.
struct Parts<'a> {
    at: At<'a>,
    name: &'a str,
    detector: RawPlugin<'a, dyn Detector>,
    signals: Vec<RawPlugin<'a, dyn Signal>>,
    /// Name of the detector's trained parameter, and how it is trained.
    training: Option<(String, wire::Train)>,
    /// Treatment of restarts by the method's protocol.
    restarts: Restarts,
}

impl Parts<'_> {
    /// Checks the axes of the grid. They must be parameters of the detector or of the first signal.
    fn axes<'g>(&self, grid: Option<&'g BTreeMap<String, Vec<Number>>>) -> Option<Vec<Axis<'g>>> {
        let of_detector = self.detector.keys();
        let of_signal = self.signals.first().map(RawPlugin::keys).unwrap_or_default();
        let mut axes = Vec::new();
        let mut size = 1usize;
        for (name, values) in grid.into_iter().flatten() {
            let at = self.at.key("grid").key(name);
            if self.training.as_ref().is_some_and(|(key, _)| key == name) {
                return at.refuse(format!("`{name}` is trained; it cannot be an axis of the grid too"));
            }
            let of_signal = match (of_detector.contains(name), of_signal.contains(name)) {
                (true, true) => {
                    return at.refuse(format!("both the signal and the detector have a `{name}`"));
                }
                (false, false) => {
                    let known = of_detector.iter().chain(&of_signal);
                    at.tell_unknown("parameter", name, known.map(String::as_str));
                    return None;
                }
                (_, of_signal) => of_signal,
            };
            // The check comes before the values are compared, each with all others.
            size = size.saturating_mul(values.len());
            if size > MAX_VARIANTS {
                let message = format!("the grid needs 1 to {MAX_VARIANTS} combinations, this makes {size}");
                return at.refuse(message);
            }
            let twice =
                (1..values.len()).find(|k| values[..*k].iter().any(|v| v.as_f64() == values[*k].as_f64()));
            if let Some(k) = twice {
                let value = readable(&values[k]);
                return at.item(k).refuse(format!("grid `{name}`: {value} is listed twice"));
            }
            axes.push(Axis { name, of_signal, values });
        }
        Some(axes)
    }

    /// Builds the variant at one point of the grid.
    fn variant(&self, point: &Point<'_>) -> Option<Variant> {
        let Self { at, name, detector, signals, training, restarts } = self;
        let (grid, restarts) = (at.key("grid"), *restarts);
        let set = |of_signal: bool| -> Vec<(String, Value)> {
            let mine = point.iter().filter(|(axis, _)| axis.of_signal == of_signal);
            mine.map(|(axis, value)| (axis.name.to_string(), Value::Number((*value).clone()))).collect()
        };
        let built = |(k, raw): (usize, &RawPlugin<'_, dyn Signal>)| {
            let signal = raw.build(&if k == 0 { set(true) } else { Vec::new() }, grid)?;
            Some(SignalChoice { restarts, ..SignalChoice::new(raw.entry, signal) })
        };
        // All are built before one that is refused ends it.
        let signals: Vec<Option<SignalChoice>> = signals.iter().enumerate().map(built).collect();
        let detector = match training {
            Some(training) => train_choice(detector, training, &set(false), restarts),
            None => detector.build(&set(false), grid).map(|built| {
                let example = FixedDetector { restarts, ..FixedDetector::new(detector.entry, built) };
                DetectorChoice { example, training: None }
            }),
        };
        let (signals, detector) = (signals.into_iter().collect::<Option<Vec<_>>>()?, detector?);
        let given: usize = signals.iter().map(|choice| choice.signal.width()).sum();
        let Facts { needs_signal, signals: reads, .. } = detector.example.detector.facts();
        if needs_signal && signals.is_empty() {
            return at.refuse(format!("method `{name}` needs a signal for its detector"));
        }
        if !signals.is_empty() && given != reads.max(1) {
            at.tell(format!("the detector of method `{name}` reads {reads} signals, and {given} are given"));
            return None;
        }
        let number = |(axis, value): &(&Axis<'_>, &Number)| Some((axis.name.to_string(), value.as_f64()?));
        let point = point.iter().filter_map(number).collect();
        Some(Variant { point, signals, detector })
    }
}

/// True if training can maximize the metric, that is, if it is computed from counts and larger values are
/// better.
pub(super) fn can_be_maximised(metric: &Metric) -> bool {
    metric.direction() == Direction::HigherIsBetter && metric.is_of_counts()
}

/// Builds the choice among candidates of the parameter `key`, which treat restarts as the protocol does; `set`
/// has the values of other parameters.
fn train_choice(
    raw: &RawPlugin<'_, dyn Detector>,
    (key, train): &(String, wire::Train),
    set: &[(String, Value)],
    restarts: Restarts,
) -> Option<DetectorChoice> {
    let refuse = |message: String| raw.at.key(key).key("grid").refuse(message);
    let (entry, params) = (raw.entry, raw.with(set));
    let (programs, trained) = (raw.programs.cloned(), key.clone());
    let build: BuildWith = Arc::new(move |value| {
        let mut params = params.clone();
        params.insert(trained.clone(), value.into());
        let built = build(entry, params, programs.as_ref())?;
        Ok(FixedDetector { restarts, ..FixedDetector::new(entry, built) })
    });
    let grid = &train.grid;
    let listed = match (grid.from, grid.to, grid.step, &grid.values, grid.quantiles) {
        (Some(from), Some(to), Some(step), None, None) => {
            let count = ((to - from) / step + 1e-9).floor();
            if !(step > 0.0 && (0.0..MAX_CANDIDATES as f64).contains(&count)) {
                let message =
                    format!("the grid needs from <= to, step > 0 and at most {MAX_CANDIDATES} values");
                return refuse(message);
            }
            Some((0..=count as usize).map(|i| from + i as f64 * step).collect())
        }
        (None, None, None, Some(values), None) => {
            if !(1..=MAX_CANDIDATES).contains(&values.len()) || !values.is_sorted_by(|a, b| a < b) {
                return refuse(format!("`values` must be 1 to {MAX_CANDIDATES} ascending numbers"));
            }
            Some(values.clone())
        }
        (None, None, None, None, Some(count)) => {
            if !(2..=MAX_CANDIDATES).contains(&count) {
                return refuse(format!("`quantiles` must be 2 to {MAX_CANDIDATES}, not {count}"));
            }
            None
        }
        _ => {
            let rule = "`grid` needs `from`, `to` and `step`, or `values` alone, or `quantiles` alone";
            return refuse(rule.to_string());
        }
    };
    let candidates = || -> Result<(FixedDetector, Candidates), ParamError> {
        let Some(values) = listed else {
            // The quantiles are not known yet; any number shows whether the parameter takes one.
            let count = grid.quantiles.unwrap_or_default();
            return Ok((build(1.0)?, Candidates::Quantiles { count, build }));
        };
        // Twelve digits, so that .003 + .001 is the .004 a person would write.
        let rounded = |value: f64| format!("{value:.12e}").parse().unwrap_or(value);
        let list = values.into_iter().map(rounded).map(|value| Ok((value, build(value)?)));
        let list: Vec<(f64, FixedDetector)> = list.collect::<Result<_, ParamError>>()?;
        Ok((list[0].1.clone(), Candidates::Listed(list)))
    };
    let (example, candidates) = candidates().map_err(|e| tell(raw.at, &e)).ok()?;
    let (key, role) = (key.clone(), train.train.clone());
    let maximise = Metric::from_name(&train.maximise)?;
    Some(DetectorChoice { example, training: Some(Training { key, role, maximise, candidates }) })
}

/// Trained parameter of a detector, if it has one. Errors have already been reported.
fn trained(raw: &RawPlugin<'_, dyn Detector>) -> Result<Option<(String, wire::Train)>, ()> {
    let is_trained = |value: &Value| value.get("train").is_some() || value.get("maximise").is_some();
    let mut all = raw.params.iter().filter(|(_, value)| is_trained(value));
    let Some((key, value)) = all.next() else { return Ok(None) };
    if let Some((second, _)) = all.next() {
        raw.at.key(second).tell("only one parameter of a method can be trained");
        return Err(());
    }
    let train = serde_json::from_value(value.clone()).map_err(|e| raw.at.key(key).tell(e.to_string()))?;
    Ok(Some((key.clone(), train)))
}
