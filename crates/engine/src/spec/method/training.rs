//! Trained parameters: the candidates that an experiment file defines.

use super::{BuildWith, Candidates, DetectorChoice, FixedDetector, Training};
use crate::spec::raw_plugin::{RawPlugin, build, tell};
use crate::spec::wire;
use serde_json::Value;
use std::sync::Arc;
use trackfail_core::direction::Direction;
use trackfail_core::plugin::ParamError;
use trackfail_methods::detector::Detector;
use trackfail_methods::score::{Metric, Restarts};

/// Most candidates of a trained parameter.
const MAX_CANDIDATES: usize = 1_000;

/// True if training can maximize the metric, that is, if it is computed from counts and larger values are
/// better.
pub fn can_be_maximised(metric: &Metric) -> bool {
    metric.direction() == Direction::HigherIsBetter && metric.is_of_counts()
}

/// Builds the choice among candidates of the parameter `key`, which treat restarts as the protocol does; `set`
/// has the values of other parameters.
pub(super) fn train_choice(
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
pub(super) fn trained(raw: &RawPlugin<'_, dyn Detector>) -> Result<Option<(String, wire::Train)>, ()> {
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
