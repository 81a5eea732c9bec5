//! `success`: success and precision of trackers on a suite, by the rules of an evaluation program.
//!
//! The measures, and what the programs differ in, are in [`crate::score::success`]. Runs of a sequence are
//! averaged first (over start frames and boxes for the temporal and spatial protocol of OTB), then the
//! sequences with equal weights, all of them and those of each attribute. High is good.
//!
//! Numbers: `success_auc`, `precision_20`. Tables: `overall`, `sequences`, `attributes`. Charts: `success`
//! (share of frames over the overlap threshold), `precision` (over the error threshold in pixels); their legends
//! hold the AUC and the precision at 20 pixels.

use super::{Analysis, AnalysisError, Chart, Findings, Grid, Names, Population, Reads};
use crate::score::TrackerMetric;
use crate::score::success::{self, Curves, RULES, Rules, overlap_threshold};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::collections::BTreeSet;
use trackfail_core::plugin::{Entry, ParamError, Plugin, unknown};

pub(crate) const ENTRY: Entry<dyn Analysis> = Entry::of::<Success>(
    "success",
    2,
    "success AUC and precision@20 of trackers, by the rules of an evaluation program",
)
.example("{ rules = \"otb-matlab/1\" }");

#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Params {
    /// `otb-matlab/1`, `pysot/1`, `got10k/1`, `pysot-toolkit/1` or `lasot/1`.
    pub rules: String,
}

impl Default for Params {
    fn default() -> Self {
        Self { rules: RULES[0].name.to_string() }
    }
}

struct Success {
    rules: &'static Rules,
}

impl Plugin for Success {
    type Params = Params;

    fn make(params: Params) -> Result<Self, ParamError> {
        let known = || RULES.iter().map(|r| r.name);
        let rules = RULES.iter().find(|r| r.name == params.rules).ok_or_else(|| {
            let message = unknown("set of rules", &params.rules, known());
            ParamError { message, key: Some("rules"), span: None }
        })?;
        Ok(Self { rules })
    }
}

/// The numbers of the analysis, and the columns of its tables.
const NUMBERS: [TrackerMetric; 2] = [TrackerMetric::SUCCESS_AUC, TrackerMetric::PRECISION_20];

/// The values of [`NUMBERS`].
fn numbers(curves: &Curves) -> [f64; 2] {
    [curves.auc(), curves.precision_at_20()]
}

/// The means of a sequence's runs.
struct OfSequence<'a> {
    name: &'a str,
    attributes: &'a [String],
    curves: Curves,
}

impl Analysis for Success {
    fn reads(&self) -> Reads {
        Reads::Regions
    }

    fn suites(&self) -> (usize, usize) {
        (1, 1)
    }

    fn names(&self, _: usize) -> Names {
        let words = |list: &[&str]| list.iter().map(ToString::to_string).collect();
        Names {
            numbers: NUMBERS.map(|m| m.name.to_string()).into(),
            tables: words(&["overall", "sequences", "attributes"]),
            charts: words(&["success", "precision"]),
        }
    }

    fn analyze(&self, populations: &[Population<'_>]) -> Result<Findings, AnalysisError> {
        let trajectories = populations.first().map_or(&[][..], |p| &p.trajectories);
        let mut sequences: Vec<OfSequence<'_>> = Vec::new();
        for runs in trajectories.chunk_by(|a, b| a.sequence == b.sequence) {
            let curves: Vec<Curves> = runs.iter().map(|c| self.rules.curves(c)).collect();
            if let Some(curves) = Curves::mean(&curves) {
                let (name, attributes) = (runs[0].sequence, runs[0].attributes);
                sequences.push(OfSequence { name, attributes, curves });
            }
        }
        let all = Curves::mean(sequences.iter().map(|s| &s.curves)).ok_or(AnalysisError::NoTrack)?;
        let values = |c: &Curves| numbers(c).map(Some).to_vec();
        let table = |name: &str, corner: &str, rows| Grid {
            name: name.into(),
            corner: corner.into(),
            columns: NUMBERS.map(|m| m.heading.to_string()).into(),
            rows,
        };
        let attributes: BTreeSet<&String> = sequences.iter().flat_map(|s| s.attributes).collect();
        let of_attribute = |attribute: &&String| {
            let mine: Vec<_> = sequences.iter().filter(|s| s.attributes.contains(attribute)).collect();
            let mean = Curves::mean(mine.iter().map(|s| &s.curves))?;
            Some((format!("{attribute} ({})", mine.len()), values(&mean)))
        };
        let chart = |name: &str, x: &str, y: &str, points: Vec<(f64, f64)>, headline: f64| Chart {
            name: name.into(),
            x: x.into(),
            y: y.into(),
            curves: vec![(format!("[{headline:.3}]"), points)],
            ..Chart::default()
        };
        let overlaps = (0..success::OVERLAPS).map(|i| (overlap_threshold(i), all.success[i])).collect();
        let errors = (0..success::ERRORS).map(|e| (e as f64, all.precision[e])).collect();
        let rows = sequences.iter().map(|s| (s.name.to_string(), values(&s.curves))).collect();
        Ok(Findings {
            numbers: NUMBERS.map(|m| m.name.to_string()).into_iter().zip(numbers(&all)).collect(),
            tables: vec![
                table("overall", "tracker", vec![(String::new(), values(&all))]),
                table("sequences", "sequence", rows),
                table("attributes", "attribute", attributes.iter().filter_map(of_attribute).collect()),
            ],
            charts: vec![
                chart("success", "overlap threshold", "success", overlaps, all.auc()),
                chart("precision", "error threshold (px)", "precision", errors, all.precision_at_20()),
            ],
        })
    }
}
