//! Standings: the methods of one experiment with all of its trackers pooled, as the leaderboard shows them.

use crate::results::frame_measures::EVERY_TRACKER;
use crate::results::{CellScore, Results};
use crate::sampling::{Sampling, metric_of_sum, numbers};
use crate::table::layout;
use crate::table::number::Style;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use trackfail_engine::spec::method::Method;
use trackfail_methods::score::{Counts, Metric, Pooled};

/// A method on all trackers of an experiment together. Numbers are as they are printed; empty where there is none.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Standing {
    /// The method.
    pub method: String,
    /// Its first need beside the boxes of the tracker: `boxes alone`, `frames` ...
    pub needs: String,
    /// Whether it is an anchor, which does not compete.
    pub anchor: bool,
    /// Number of trackers that it was run on.
    pub trackers: u64,
    /// Area under the ROC curve of lost frames against good ones.
    pub auroc: Estimate,
    /// Average precision of lost frames.
    pub auprc: Estimate,
    /// False alarms per 1000 good frames where half of the losses are found.
    pub false_alarms: Estimate,
    /// F-score beyond that of random detections, with the method's own threshold.
    pub f_over_chance: Estimate,
    /// Milliseconds a frame, from an analysis of times; empty without one.
    pub cost: String,
}

/// A number with its 95 % bootstrap interval over sequences.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Estimate {
    /// The number.
    pub value: String,
    /// Its lower bound.
    pub low: String,
    /// Its upper bound.
    pub high: String,
}

impl Estimate {
    fn new(style: Style, [value, low, high]: [Option<f64>; 3]) -> Self {
        let shown = |number: Option<f64>| number.map_or(String::new(), |n| style.format(n));
        Self { value: shown(value), low: shown(low), high: shown(high) }
    }
}

/// The standings of an experiment that asks for them, in its order; `scores` are those of [`Results::scores`]; methods without a result and the points of grids are
/// left out.
pub fn standings(results: &Results, scores: &[CellScore]) -> Vec<Standing> {
    let experiment = &results.experiment;
    if !experiment.leaderboard {
        return Vec::new();
    }
    let (costs, sampling) = (costs(results), Sampling::new(experiment));
    let standing = |method: &Method| {
        let variant = method.variants.first().filter(|_| !method.has_grid())?;
        let name = &method.name;
        let key = [EVERY_TRACKER.to_string(), name.clone(), String::new()];
        let frames = results.frame_measures.get(&key)?;
        let mine = || results.measures.iter().filter(|m| m.method == *name && m.done > 0);
        let needs = variant.needs().join(", ");
        let (real, rate) = (Style::DEFAULT, Style { decimals: 1, ..Style::DEFAULT });
        let of = |[value, low, high]: [&str; 3]| [value, low, high].map(|column| frames.get(column));
        let alarms = of(["false_alarms_at_half", "false_alarms_at_half_low", "false_alarms_at_half_high"]);
        (mine().count() > 0).then(|| Standing {
            method: name.clone(),
            needs: if needs.is_empty() { "nothing".to_string() } else { needs },
            anchor: layout::is_anchor(experiment, name),
            trackers: mine().count() as u64,
            auroc: Estimate::new(real, of(["auroc", "auroc_low", "auroc_high"])),
            auprc: Estimate::new(real, of(["auprc", "auprc_low", "auprc_high"])),
            false_alarms: Estimate::new(rate, alarms),
            f_over_chance: Estimate::new(real, f_over_chance(results, scores, name, &sampling)),
            cost: costs.get(name).cloned().unwrap_or_default(),
        })
    };
    experiment.methods.iter().filter_map(standing).collect()
}

/// F over chance of the counts of all trackers, with its interval.
fn f_over_chance(
    results: &Results,
    scores: &[CellScore],
    method: &str,
    sampling: &Sampling,
) -> [Option<f64>; 3] {
    let mut by_sequence: BTreeMap<&str, Counts> = BTreeMap::new();
    for score in scores.iter().filter(|s| s.method == method && s.params.is_empty()) {
        let sum = by_sequence.entry(&score.sequence).or_default();
        *sum = [*sum, score.counts].into_iter().sum();
    }
    let chance = results.experiment.chance_of(method);
    let value = |counts: Counts| Metric::F_OVER_CHANCE.value(&Pooled { counts, chance, ..Pooled::default() });
    let list: Vec<[i64; 4]> = by_sequence.values().copied().map(numbers).collect();
    let bounds = sampling.interval(&list, |sum| metric_of_sum(Metric::F_OVER_CHANCE, chance, sum));
    [value(by_sequence.values().copied().sum()), bounds.map(|b| b.0), bounds.map(|b| b.1)]
}

/// Milliseconds a frame of the methods that an analysis of the experiment has timed: signal, detection and reverse runs.
fn costs(results: &Results) -> BTreeMap<String, String> {
    let mut costs = BTreeMap::new();
    for stages in results.analyses.iter().flat_map(|a| &a.findings.tables).filter(|t| t.name == "stages") {
        let total = stages.rows.iter().find(|(heading, _)| heading == "total");
        for (method, value) in stages.columns.iter().zip(total.map_or(&[][..], |(_, values)| values)) {
            if let Some(value) = value {
                costs.insert(method.clone(), format!("{value:.3}"));
            }
        }
    }
    costs
}
