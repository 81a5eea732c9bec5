//! Standings: the methods of one experiment with all of its trackers pooled, as the leaderboard shows them.

use crate::report::standings;
use crate::results::Results;
use crate::results::frame_measures::EVERY_TRACKER;
use crate::sampling::{Units, metric_of_sum, sum_of};
use crate::table::layout;
use crate::table::number::Style;
use serde::{Deserialize, Serialize};
use trackfail_engine::spec::method::Method;
use trackfail_methods::analysis::Grid;
use trackfail_methods::score::Metric;

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
    fn printed(style: Style, of: standings::Estimate) -> Self {
        let [value, low, high] = of.cells(|v| style.format(v)).map(|cell| cell.ours.unwrap_or_default());
        Self { value, low, high }
    }
}

/// The standings of an experiment that asks for them, in its order; methods without a result and the points of grids are
/// left out.
pub fn standings(results: &Results, units: &Units) -> Vec<Standing> {
    let experiment = &results.experiment;
    if !experiment.leaderboard {
        return Vec::new();
    }
    let standing = |method: &Method| {
        let variant = method.variants.first().filter(|_| !method.has_grid())?;
        let name = &method.name;
        let key = [EVERY_TRACKER, name.as_str(), ""].map(str::to_string);
        let frames = results.frame_measures.get(&key)?;
        let trackers = results.measures.iter().filter(|m| m.method == *name && m.done > 0).count();
        let of = |style, measure| Estimate::printed(style, standings::Estimate::of_frames(frames, measure));
        let (needs, (real, rate)) =
            (variant.needs(), (Style::DEFAULT, Style { decimals: 1, ..Style::DEFAULT }));
        (trackers > 0).then(|| Standing {
            method: name.clone(),
            needs: if needs.is_empty() { "nothing".to_string() } else { needs.join(", ") },
            anchor: layout::is_anchor(experiment, name),
            trackers: trackers as u64,
            auroc: of(real, "auroc"),
            auprc: of(real, "auprc"),
            false_alarms: of(rate, "false_alarms_at_half"),
            f_over_chance: Estimate::printed(real, f_over_chance(results, units, name)),
            cost: cost(results, name),
        })
    };
    experiment.methods.iter().filter_map(standing).collect()
}

/// F over chance of the counts of all trackers.
fn f_over_chance(results: &Results, units: &Units, method: &str) -> standings::Estimate {
    let (counts, chance) = (units.pooled(method, None), results.experiment.chance_of(method));
    let of = |sum: &[i64; 4]| metric_of_sum(Metric::F_OVER_CHANCE, chance, sum);
    let list: Vec<[i64; 4]> = counts.values().copied().collect();
    standings::Estimate { value: of(&sum_of(&counts)), bounds: units.sampling.interval(&list, of) }
}

/// Milliseconds a frame of a method, for its signal, detection and reverse runs, where an analysis of the experiment has timed
/// it; else empty.
fn cost(results: &Results, method: &str) -> String {
    let tables = results.analyses.iter().flat_map(|a| &a.findings.tables).filter(|t| t.name == "stages");
    let total = |stages: &Grid| {
        let column = stages.columns.iter().position(|name| name == method)?;
        let (_, values) = stages.rows.iter().find(|(heading, _)| heading == "total")?;
        values.get(column).copied().flatten()
    };
    // The last one that has it.
    tables.filter_map(total).next_back().map_or_else(String::new, |value| format!("{value:.3}"))
}
