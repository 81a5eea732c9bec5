//! Parameters that are trained instead of given: the candidates that an experiment file asks for.

use super::{Candidates, DetectorChoice, FixedDetector, Training};
use crate::spec::error::{Source, SpecError};
use crate::spec::raw_plugin::{RawPlugin, as_value};
use crate::spec::table::metric;
use crate::spec::wire;
use serde::Deserialize;
use std::sync::Arc;
use toml::Spanned;
use toml::de::{DeValue, ValueDeserializer};
use trackfail_core::direction::Direction;
use trackfail_methods::detector::Detector;
use trackfail_methods::score::{Metric, Restarts};
use trackfail_methods::tracker::process::Bind;

/// Largest number of candidates of a trained parameter.
const MAX_CANDIDATES: usize = 1_000;

/// Whether training can look for the largest value of a metric: a measure of counts of which more is better.
pub fn can_be_maximised(metric: &Metric) -> bool {
    metric.direction() == Direction::HigherIsBetter && metric.is_of_counts()
}

/// A choice among the candidates of the parameter `key`, with the other parameters `set`.
pub(super) fn train_choice(
    source: Source<'_>,
    raw: &RawPlugin<'_, dyn Detector>,
    key: &str,
    train: &Spanned<wire::Train>,
    set: Vec<(&str, Spanned<DeValue<'_>>)>,
) -> Result<DetectorChoice, SpecError> {
    let wire = train.get_ref();
    let metric = metric(source, &wire.maximise)?;
    if !can_be_maximised(&metric) {
        let good = Metric::names().filter(|n| Metric::from_name(n).as_ref().is_some_and(can_be_maximised));
        let good = good.collect::<Vec<_>>().join(", ");
        let message = format!("`maximise` takes a metric of counts for which higher is better: {good}");
        return Err(source.error(wire.maximise.span(), message));
    }
    let build = |value: f64| {
        let mut set = set.clone();
        // Twelve digits, so that .003 + .001 is the .004 a person would write.
        let text = format!("{value:.12e}");
        let parsed = DeValue::parse(&text).map_err(|e| source.toml(&e, wire.grid.span()))?;
        set.push((key, Spanned::new(wire.grid.span(), parsed.into_inner())));
        let value = text.parse().map_err(|_| source.error(wire.grid.span(), "not a number"))?;
        Ok((value, raw.fixed(Arc::from(raw.build(source, set)?))))
    };
    let (candidates, example) = match wire.grid.get_ref() {
        wire::Grid { from: Some(from), to: Some(to), step: Some(step), values: None, quantiles: None } => {
            let count = ((to - from) / step + 1e-9).floor();
            let usable = [*from, *to, *step].iter().all(|v| v.is_finite()) && *step > 0.0;
            if !usable || !(0.0..MAX_CANDIDATES as f64).contains(&count) {
                let message =
                    format!("the grid needs from <= to, step > 0 and at most {MAX_CANDIDATES} values");
                return Err(source.error(wire.grid.span(), message));
            }
            let values = (0..=count as usize).map(|i| build(from + i as f64 * step));
            let list = values.collect::<Result<Vec<(f64, FixedDetector)>, SpecError>>()?;
            let first = list[0].1.clone();
            (Candidates::Listed(list), first)
        }
        wire::Grid { from: None, to: None, step: None, values: Some(values), quantiles: None } => {
            let ascends = values.iter().all(|v| v.is_finite()) && values.is_sorted_by(|a, b| a < b);
            if !(1..=MAX_CANDIDATES).contains(&values.len()) || !ascends {
                let message = format!("`values` must be 1 to {MAX_CANDIDATES} ascending numbers");
                return Err(source.error(wire.grid.span(), message));
            }
            let list = values.iter().map(|value| build(*value)).collect::<Result<Vec<_>, SpecError>>()?;
            let first = list[0].1.clone();
            (Candidates::Listed(list), first)
        }
        wire::Grid { from: None, to: None, step: None, values: None, quantiles: Some(count) } => {
            if !(2..=MAX_CANDIDATES).contains(count) {
                let message = format!("`quantiles` must be 2 to {MAX_CANDIDATES}, not {count}");
                return Err(source.error(wire.grid.span(), message));
            }
            // The quantiles are not known yet; any number shows whether the parameter takes one.
            let (_, example) = build(1.0)?;
            let (entry, key) = (raw.entry, key.to_string());
            let mut table = raw.with(set);
            table.get_mut().remove(key.as_str());
            let table = toml::Table::deserialize(ValueDeserializer::from(as_value(&table)))
                .map_err(|e| source.toml(&e, wire.grid.span()))?;
            let programs = raw.programs.cloned();
            let build = move |value: f64| {
                let mut table = table.clone();
                table.insert(key.clone(), toml::Value::Float(value));
                let mut detector = entry.build_from_text(&toml::Value::Table(table).to_string())?;
                programs.as_ref().map_or(Ok(()), |programs| detector.bind(programs))?;
                Ok(FixedDetector {
                    kind: entry.kind,
                    version: entry.version,
                    detector: Arc::from(detector),
                    restarts: Restarts::default(),
                })
            };
            (Candidates::Quantiles { count: *count, build: Arc::new(build) }, example)
        }
        _ => {
            let message = "`grid` needs `from`, `to` and `step`, or `values` alone, or `quantiles` alone";
            return Err(source.error(wire.grid.span(), message));
        }
    };
    Ok(DetectorChoice::Trained(Training {
        key: key.to_string(),
        role: wire.train.get_ref().clone(),
        maximise: metric,
        candidates,
        example,
    }))
}

impl RawPlugin<'_, dyn Detector> {
    /// A detector of this kind, with kind and version.
    pub(super) fn fixed(&self, detector: Arc<dyn Detector>) -> FixedDetector {
        let (kind, version) = (self.entry.kind, self.entry.version);
        FixedDetector { kind, version, detector, restarts: Restarts::default() }
    }

    /// The parameter that is to be trained, if one is.
    pub(super) fn training(
        &self,
        source: Source<'_>,
    ) -> Result<Option<(String, Spanned<wire::Train>)>, SpecError> {
        let mut found = None;
        for (key, value) in self.table.get_ref() {
            let is_training = matches!(value.get_ref(), DeValue::Table(t) if t.contains_key("train") || t.contains_key("maximise"));
            if !is_training {
                continue;
            }
            if found.is_some() {
                return Err(source.error(key.span(), "only one parameter of a method can be trained"));
            }
            let train = wire::Train::deserialize(ValueDeserializer::from(value.clone()))
                .map_err(|e| source.toml(&e, value.span()))?;
            found = Some((key.get_ref().to_string(), Spanned::new(value.span(), train)));
        }
        Ok(found)
    }
}
