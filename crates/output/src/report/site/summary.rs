//! Summary of a report: the file `summary.json` beside its page. For experiments of the leaderboard it
//! includes the methods.

use crate::report::claims::ClaimCounts;
use crate::report::page::Page;
use crate::report::standings::{self, of_every_tracker};
use crate::report::write::SUMMARY;
use crate::results::{Results, beside};
use crate::sampling::{Units, metric_of_sum};
use crate::table::layout::is_anchor;
use crate::table::{self, number::Style};
use serde::{Deserialize, Serialize};
use serde_json::Value;
use std::path::Path;
use trackfail_dataset::{synthetic, text};
use trackfail_engine::spec::method::Method;
use trackfail_methods::analysis::Grid;
use trackfail_methods::score::Metric;

/// Version of the summary's format.
/// - 1: first version;
/// - 2: undecided claims, and checks beside claims;
/// - 3: the verdict;
/// - 4: no best methods, since the verdict names them.
pub const FORMAT: u32 = 4;
/// Largest summary that is read, in bytes.
pub(super) const MAX_SUMMARY: u64 = 1 << 20;

/// Summary of the report of an experiment.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Summary {
    /// [`FORMAT`] of the program that wrote the summary.
    pub format: u32,
    /// Name of the experiment.
    pub experiment: String,
    /// Title of the experiment.
    pub title: String,
    /// The paper that is replicated; may be empty.
    pub paper: String,
    /// The table or figure of the paper; may be empty.
    pub object: String,
    /// Numbers of the paper's claims, by outcome.
    pub claims: ClaimCounts,
    /// Numbers of the checks of the arithmetic, by outcome.
    #[serde(default)]
    pub checks: ClaimCounts,
    /// Name of the test suite.
    pub suite: String,
    /// Share of the suite that was present, in words: `12 of 21 targets, 10 runs`.
    pub data: String,
    /// Number of targets that were present.
    pub present: u64,
    /// Number of targets of the whole suite.
    pub wanted: u64,
    /// True if the suite is synthetic.
    pub synthetic: bool,
    /// Number of cells without a result.
    pub failed: u64,
    /// Answer of the page in one sentence; may be empty.
    #[serde(default)]
    pub verdict: String,
    /// Methods for the leaderboard; empty unless the experiment has `leaderboard = true`.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub standings: Vec<Standing>,
}

/// A method on all trackers of an experiment together. Numbers are texts as printed; empty if there is none.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Standing {
    /// Name of the method.
    pub method: String,
    /// Inputs that the method needs: `boxes alone`, or all other inputs, as in `frames, the tracker's
    /// confidence`; `nothing` for a method without a signal.
    pub needs: String,
    /// True for an anchor, which does not compete.
    pub anchor: bool,
    /// Number of trackers that the method was run on.
    pub trackers: u64,
    /// Area under the ROC curve of lost frames against good ones.
    pub auroc: Estimate,
    /// Average precision of lost frames.
    pub auprc: Estimate,
    /// False alarms per 1000 good frames, at the threshold that finds half of the losses.
    pub false_alarms: Estimate,
    /// F-score above that of random detections, with the method's own threshold.
    pub f_over_chance: Estimate,
    /// Milliseconds per frame, from an analysis of times; empty without one.
    pub cost: String,
}

/// A number with its 95 % bootstrap interval over sequences.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Estimate {
    /// The number, as printed.
    pub value: String,
    /// Lower bound, as printed.
    pub low: String,
    /// Upper bound, as printed.
    pub high: String,
}

/// Summary of a report with this page.
pub fn summary(results: &Results, units: &Units, page: &Page) -> Summary {
    let manifest = &results.manifest;
    let suite = &manifest.suite;
    let counts = |checks: bool| {
        ClaimCounts::of(page.claims.iter().filter(|f| f.is_check == checks).map(|f| f.outcome))
    };
    Summary {
        format: FORMAT,
        experiment: page.experiment.clone(),
        title: page.title.clone(),
        paper: page.paper.clone(),
        object: page.object.clone(),
        claims: counts(false),
        checks: counts(true),
        suite: suite.name.clone(),
        data: table::data_note(&results.experiment, manifest),
        present: suite.present.len() as u64,
        wanted: suite.wanted as u64,
        synthetic: synthetic::is_rendered(&suite.name),
        failed: manifest.cells_failed.len() as u64,
        verdict: page.verdict.join(" "),
        standings: standings(results, units),
    }
}

/// Methods of an experiment with `leaderboard = true`, in its order. Methods without a result and with a grid
/// are left out.
fn standings(results: &Results, units: &Units) -> Vec<Standing> {
    let experiment = &results.experiment;
    let standing = |method: &Method| {
        let variant = method.variants.first().filter(|_| !method.has_grid())?;
        let name = &method.name;
        // A kept method has its own name on the leaderboard, unless the experiment has one of that name.
        let shown = results.beside.as_ref().map_or(name.as_str(), |_| beside::plain(name));
        let is_shown = shown == name || experiment.methods.iter().all(|m| m.name != shown);
        let frames = of_every_tracker(results, name)?;
        let trackers = results.measures.iter().filter(|m| m.method == *name && m.done > 0);
        let trackers = trackers.filter(|m| results.is_own(&m.tracker)).count();
        let printed = |style: Style, of: standings::Estimate| {
            let [value, low, high] = of.cells(|v| style.format(v)).map(|cell| cell.ours.unwrap_or_default());
            Estimate { value, low, high }
        };
        let of = |style, measure| printed(style, standings::Estimate::of_frames(frames, measure));
        let (needs, real) = (variant.needs(), Style::DEFAULT);
        (trackers > 0 && is_shown).then(|| Standing {
            method: shown.to_string(),
            needs: if needs.is_empty() { "nothing".to_string() } else { needs.join(", ") },
            anchor: is_anchor(experiment, name),
            trackers: trackers as u64,
            auroc: of(real, "auroc"),
            auprc: of(real, "auprc"),
            false_alarms: of(Style { decimals: 1, ..real }, "false_alarms_at_half"),
            f_over_chance: printed(real, f_over_chance(results, units, name)),
            cost: cost(results, name),
        })
    };
    let asked = experiment.methods.iter().filter(|_| experiment.leaderboard);
    asked.filter_map(standing).collect()
}

/// F over chance, from the counts of all trackers.
fn f_over_chance(results: &Results, units: &Units, method: &str) -> standings::Estimate {
    let chance = results.experiment.chance_of(method);
    let of = |sum: &[i64; 4]| metric_of_sum(Metric::F_OVER_CHANCE, chance, sum);
    let own = units.pooled(method, |tracker| results.is_own(tracker));
    standings::Estimate::of_counts(&own, of, &units.sampling)
}

/// Milliseconds per frame of a method's signal, detection and reverse runs, if an analysis of the experiment
/// timed it; else empty.
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

/// Reads the summary of the experiment `name` at `path`. The error says why it cannot be shown.
pub fn read_summary(path: &Path, name: &str) -> Result<Summary, String> {
    if !path.exists() {
        return Err(format!("it has no {SUMMARY}; `trackfail report {name}` writes it"));
    }
    let foreign = |e: serde_json::Error| format!("{SUMMARY} is none of this program: {e}");
    let bytes = text::read_at_most(path, MAX_SUMMARY).map_err(|_| format!("{SUMMARY} cannot be read"))?;
    let mut value: Value = serde_json::from_slice(&bytes).map_err(foreign)?;
    let format = value.get("format").and_then(Value::as_u64);
    if let Some(later) = format.filter(|format| *format > u64::from(FORMAT)) {
        return Err(format!("{SUMMARY} has format {later}; this program reads up to {FORMAT}"));
    }
    // Up to format 3.
    value.as_object_mut().and_then(|fields| fields.remove("best"));
    serde_json::from_value(value).map_err(foreign)
}
