//! Methods: a signal and a detector under a name, with a grid of their parameters and with parameters that are
//! trained instead of given.

mod training;

pub use trackfail_judge::method::{FixedDetector, SignalChoice};
pub(super) use training::can_be_maximised;

use super::error::{Errors, Source, SpecError};
use super::limits::MAX_DETECTORS;
use super::raw_plugin::RawPlugin;
use serde::Deserialize;
use std::sync::Arc;
use toml::Spanned;
use toml::de::{DeTable, DeValue, ValueDeserializer};
use trackfail_core::num::readable;
use trackfail_core::plugin::ParamError;
use trackfail_methods::detector::{DETECTORS, Detector};
use trackfail_methods::score::Metric;
use trackfail_methods::score::{Protocol, Restarts};
use trackfail_methods::signal::{Reads, SIGNALS, Signal};
use trackfail_methods::tracker::process::Programs;

/// A method of an experiment.
pub struct Method {
    /// Name in tables.
    pub name: String,
    /// Name of the method that it is a reading of.
    pub like: Option<String>,
    /// Labels of the trackers it is run on; all when `None`.
    pub trackers: Option<Vec<String>>,
    /// How its labels are scored.
    pub protocol: &'static Protocol,
    /// One variant for each combination of the grid's values, in their order; a single one without a grid.
    pub variants: Vec<Variant>,
}

/// A method with one combination of its grid.
pub struct Variant {
    /// Grid axis -> value, sorted by axis; empty without a grid.
    pub point: Vec<(String, f64)>,
    /// The signal; `None` for detectors that need none.
    pub signal: Option<SignalChoice>,
    /// Further signals, for detectors that read several.
    pub more_signals: Vec<SignalChoice>,
    /// The detector, given or to be trained.
    pub detector: DetectorChoice,
}

impl Variant {
    /// All its signals.
    pub fn signals(&self) -> impl Iterator<Item = &SignalChoice> {
        self.signal.iter().chain(&self.more_signals)
    }

    /// Words for what its signals read, each once; boxes are named only where there is nothing else.
    pub fn needs(&self) -> Vec<&'static str> {
        let mut needs: Vec<&str> = Vec::new();
        for reads in self.signals().map(|choice| choice.signal.reads()) {
            if reads != Reads::Boxes && !needs.contains(&reads.need()) {
                needs.push(reads.need());
            }
        }
        if needs.is_empty() && self.signal.is_some() {
            needs.push(Reads::Boxes.need());
        }
        needs
    }

    /// `horizon=5;window=20`, the `params` column of the results; empty without a grid.
    pub fn params(&self) -> String {
        let parts: Vec<_> =
            self.point.iter().map(|(axis, value)| format!("{axis}={}", readable(value))).collect();
        parts.join(";")
    }
}

/// A detector, or how it is trained.
pub enum DetectorChoice {
    /// All parameters are given.
    Given(FixedDetector),
    /// One parameter is chosen on a suite.
    Trained(Training),
    /// All parameters are given, and a model is learned on a suite.
    Learned(FixedDetector),
}

impl DetectorChoice {
    /// Role of the suite it is trained on or learns from.
    pub fn role(&self) -> Option<&str> {
        match self {
            Self::Given(_) => None,
            Self::Trained(training) => Some(&training.role),
            Self::Learned(fixed) => fixed.detector.learner().map(|l| l.role()),
        }
    }

    /// Whether it is trained for each sequence and tracker on the others.
    pub fn trains_on_others(&self) -> bool {
        self.role() == Some(super::OTHERS)
    }

    /// Whether it learns one model from the tracks of all trackers.
    pub fn pools_trackers(&self) -> bool {
        self.example().detector.learner().is_some_and(|learner| learner.pools_trackers())
    }

    /// The detector; of a trained one, one of its candidates.
    pub fn example(&self) -> &FixedDetector {
        match self {
            Self::Given(fixed) | Self::Learned(fixed) => fixed,
            Self::Trained(training) => &training.example,
        }
    }

    /// Whether the detector runs trackers backwards.
    pub fn needs_reverse(&self) -> bool {
        self.example().detector.needs_reverse()
    }
}

/// How a parameter is chosen on a suite.
pub struct Training {
    /// The parameter's name.
    pub key: String,
    /// Role of the suite, or [`OTHERS`](super::OTHERS).
    pub role: String,
    /// The metric that is maximized.
    pub maximise: Metric,
    /// The values that are tried.
    pub candidates: Candidates,
    /// One of the candidates, for what all have in common.
    pub example: FixedDetector,
}

/// Builds the detector with a value of the trained parameter, unless it refuses the value.
pub type BuildWith = Arc<dyn Fn(f64) -> Result<FixedDetector, ParamError> + Send + Sync>;

/// Values that are tried in training.
#[derive(Clone)]
pub enum Candidates {
    /// Value -> detector, ascending.
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
    /// Largest number of candidates.
    pub fn count(&self) -> usize {
        match self {
            Self::Listed(list) => list.len(),
            Self::Quantiles { count, .. } => *count,
        }
    }
}

impl Method {
    /// Whether it is run on a tracker.
    pub fn runs_on(&self, tracker: &str) -> bool {
        self.trackers.as_ref().is_none_or(|mine| mine.iter().any(|t| t == tracker))
    }

    /// Whether it has a variant for each of several parameters.
    pub fn has_grid(&self) -> bool {
        self.variants.iter().any(|v| !v.point.is_empty())
    }

    /// Number of its detectors, including the candidates of training.
    pub fn detectors(&self) -> usize {
        self.variants.iter().map(Variant::detectors).sum()
    }
}

impl Variant {
    /// Lets its signals and detectors treat restarts as their protocol does.
    fn set_restarts(&mut self, restarts: Restarts) {
        self.signal.iter_mut().chain(&mut self.more_signals).for_each(|choice| choice.restarts = restarts);
        match &mut self.detector {
            DetectorChoice::Given(fixed) | DetectorChoice::Learned(fixed) => fixed.restarts = restarts,
            DetectorChoice::Trained(training) => {
                training.example.restarts = restarts;
                match &mut training.candidates {
                    Candidates::Listed(list) => {
                        list.iter_mut().for_each(|(_, fixed)| fixed.restarts = restarts);
                    }
                    Candidates::Quantiles { build, .. } => {
                        let inner = build.clone();
                        *build = Arc::new(move |value| Ok(FixedDetector { restarts, ..inner(value)? }));
                    }
                }
            }
        }
    }

    fn detectors(&self) -> usize {
        match &self.detector {
            DetectorChoice::Given(_) | DetectorChoice::Learned(_) => 1,
            DetectorChoice::Trained(training) => training.candidates.count(),
        }
    }
}

/// Largest number of combinations of a method's grid.
const MAX_VARIANTS: usize = 10_000;

/// Checks a `[[method]]` of at most `room` detectors, which is run on all trackers and scored by `protocol`.
///
/// It may run `programs`; without a list of them, a signal or detector that names one cannot run.
pub fn read(
    source: Source<'_>,
    programs: Option<&Programs>,
    name: &str,
    table: &Spanned<DeTable<'_>>,
    protocol: &'static Protocol,
    room: usize,
) -> Result<Method, SpecError> {
    let span = table.span();
    let part = |key: &str| -> Result<Option<Spanned<DeTable<'_>>>, SpecError> {
        match table.get_ref().get(key) {
            None => Ok(None),
            Some(value) => match value.get_ref() {
                DeValue::Table(t) => Ok(Some(Spanned::new(value.span(), t.clone()))),
                other => Err(source
                    .error(value.span(), format!("`{key}` must be a table, not a {}", other.type_str()))),
            },
        }
    };
    let (signals, detector, grid) = (signals(source, table)?, part("detector")?, part("grid")?);
    let Some(detector) = detector else {
        return Err(source
            .error(span, format!("method `{name}` has no detector, and no published method has that name")));
    };
    let mut errors = Errors::default();
    let signals = signals.into_iter().map(|t| RawPlugin::read(source, programs, t, "signal", SIGNALS));
    let signals: Vec<RawPlugin<'_, dyn Signal>> = signals.filter_map(|read| errors.keep(read)).collect();
    let detector = errors.keep(RawPlugin::read(source, programs, detector, "detector", DETECTORS));
    if let Some(detector) = detector.as_ref().filter(|_| !errors.is_empty()) {
        // A grid may give what the detector lacks.
        if grid.is_none() && detector.training(source)?.is_none() {
            errors.keep(detector.build(source, Vec::new()));
        }
    }
    errors.check()?;
    let Some(detector) = detector else { return Err(source.error(span, "the method has no detector")) };
    let axes = match &grid {
        None => Vec::new(),
        Some(grid) => read_axes(source, grid, &detector, signals.first())?,
    };
    let mut variants = Vec::new();
    let mut detectors = 0;
    for point in combinations(&axes) {
        let mut variant = build_variant(source, name, span.clone(), &detector, &signals, &point)?;
        if protocol.restarts == Restarts::NewTrack && variant.detector.needs_reverse() {
            let message = format!(
                "method `{name}` runs trackers backwards, which is not possible under {}: a restart begins a new track there",
                protocol.name
            );
            return Err(source.error(span, message));
        }
        variant.set_restarts(protocol.restarts);
        detectors += variant.detectors();
        if detectors > room {
            let message = format!("the experiment tries more than {MAX_DETECTORS} detectors");
            return Err(source.error(span, message));
        }
        variants.push(variant);
    }
    Ok(Method { name: name.to_string(), like: None, trackers: None, protocol, variants })
}

/// The tables of a method's signals: none, one, or a list.
fn signals<'i>(
    source: Source<'_>,
    table: &Spanned<DeTable<'i>>,
) -> Result<Vec<Spanned<DeTable<'i>>>, SpecError> {
    let Some(value) = table.get_ref().get("signal") else { return Ok(Vec::new()) };
    let of = |value: &Spanned<DeValue<'i>>| match value.get_ref() {
        DeValue::Table(t) => Ok(Spanned::new(value.span(), t.clone())),
        other => {
            let message = format!("`signal` must be a table or a list of tables, not a {}", other.type_str());
            Err(source.error(value.span(), message))
        }
    };
    match value.get_ref() {
        DeValue::Array(list) => list.iter().map(of).collect(),
        _ => Ok(vec![of(value)?]),
    }
}

/// An axis of the grid: the parameter it sets, of the signal or the detector, and its values.
struct Axis<'i> {
    name: String,
    of_signal: bool,
    key: String,
    values: Vec<(f64, Spanned<DeValue<'i>>)>,
}

fn combinations<'a, 'i>(axes: &'a [Axis<'i>]) -> Vec<Vec<(&'a Axis<'i>, usize)>> {
    axes.iter().fold(vec![Vec::new()], |points, axis| {
        points
            .iter()
            .flat_map(|point| (0..axis.values.len()).map(|i| [point.clone(), vec![(axis, i)]].concat()))
            .collect()
    })
}

fn read_axes<'i>(
    source: Source<'_>,
    grid: &Spanned<DeTable<'i>>,
    detector: &RawPlugin<'i, dyn Detector>,
    signal: Option<&RawPlugin<'i, dyn Signal>>,
) -> Result<Vec<Axis<'i>>, SpecError> {
    let mut axes = Vec::new();
    let mut size = 1usize;
    let trained = detector.training(source)?.map(|(key, _)| key);
    for (key, values) in grid.get_ref() {
        let (name, span) = (key.get_ref().to_string(), key.span());
        if trained.as_ref() == Some(&name) {
            let message = format!("`{name}` is trained; it cannot be an axis of the grid too");
            return Err(source.error(span, message));
        }
        let of_detector = detector.keys();
        let of_signal = signal.map(RawPlugin::keys).unwrap_or_default();
        let is_signal = match (of_detector.contains(&name), of_signal.contains(&name)) {
            (true, false) => false,
            (false, true) => true,
            (true, true) => {
                return Err(source.error(span, format!("both the signal and the detector have a `{name}`")));
            }
            (false, false) => {
                let known: Vec<&str> = of_detector.iter().chain(&of_signal).map(String::as_str).collect();
                return Err(source.unknown(span, "parameter", &name, known));
            }
        };
        let DeValue::Array(list) = values.get_ref() else {
            return Err(source.error(values.span(), format!("grid `{name}` must be a list of numbers")));
        };
        // The check comes before the values are compared, each with all others.
        size = size.saturating_mul(list.len());
        if list.is_empty() || size > MAX_VARIANTS {
            return Err(source.error(
                values.span(),
                format!("the grid needs 1 to {MAX_VARIANTS} combinations, this makes {size}"),
            ));
        }
        let mut numbers: Vec<(f64, Spanned<DeValue<'i>>)> = Vec::new();
        for item in list.iter() {
            let number = f64::deserialize(ValueDeserializer::from(item.clone()))
                .map_err(|e| source.toml(&e, item.span()))?;
            if !number.is_finite() || numbers.iter().any(|(known, _)| *known == number) {
                return Err(source.error(
                    item.span(),
                    format!("grid `{name}`: {} is not finite or is listed twice", readable(number)),
                ));
            }
            numbers.push((number, item.clone()));
        }
        axes.push(Axis { name: name.clone(), of_signal: is_signal, key: name, values: numbers });
    }
    axes.sort_by(|a, b| a.name.cmp(&b.name));
    Ok(axes)
}

fn build_variant<'i>(
    source: Source<'_>,
    name: &str,
    span: std::ops::Range<usize>,
    detector: &RawPlugin<'i, dyn Detector>,
    signals: &[RawPlugin<'i, dyn Signal>],
    point: &[(&Axis<'i>, usize)],
) -> Result<Variant, SpecError> {
    let set = |of_signal: bool| -> Vec<(&str, Spanned<DeValue<'i>>)> {
        let mine = point.iter().filter(|(axis, _)| axis.of_signal == of_signal);
        mine.map(|(axis, i)| (axis.key.as_str(), axis.values[*i].1.clone())).collect()
    };
    let built = |(k, raw): (usize, &RawPlugin<'i, dyn Signal>)| {
        // Axes of the grid are parameters of the first signal.
        let built = raw.build(source, if k == 0 { set(true) } else { Vec::new() })?;
        Ok(SignalChoice {
            kind: raw.entry.kind,
            version: raw.entry.version,
            signal: Arc::from(built),
            restarts: Restarts::default(),
        })
    };
    let mut errors = Errors::default();
    let signals: Vec<SignalChoice> =
        signals.iter().enumerate().filter_map(|raw| errors.keep(built(raw))).collect();
    let choose = || match detector.training(source)? {
        Some((key, train)) => training::train_choice(source, detector, &key, &train, set(false)),
        None => {
            let fixed = detector.fixed(Arc::from(detector.build(source, set(false))?));
            Ok(match fixed.detector.learner() {
                Some(_) => DetectorChoice::Learned(fixed),
                None => DetectorChoice::Given(fixed),
            })
        }
    };
    let detector = errors.keep(choose());
    errors.check()?;
    let Some(detector) = detector else { return Err(source.error(span, "the method has no detector")) };
    let given: usize = signals.iter().map(|choice| choice.signal.width()).sum();
    let mut signals = signals.into_iter();
    let (signal, more_signals) = (signals.next(), signals.collect::<Vec<_>>());
    if detector.example().detector.needs_signal() && signal.is_none() {
        return Err(source.error(span, format!("method `{name}` needs a signal for its detector")));
    }
    let reads = detector.example().detector.signals();
    if signal.is_some() && given != reads.max(1) {
        let message = format!("the detector of method `{name}` reads {reads} signals, and {given} are given");
        return Err(source.error(span, message));
    }
    let point = point.iter().map(|(axis, i)| (axis.name.clone(), axis.values[*i].0)).collect();
    Ok(Variant { point, signal, more_signals, detector })
}
