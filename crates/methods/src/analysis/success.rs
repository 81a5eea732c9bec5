//! `success`: success and precision of trackers on a suite, by the rules of an evaluation program.
//!
//! The measures, and the differences between the programs, are in [`crate::score::success`]. Runs of a
//! sequence are averaged first (over start frames and boxes for the temporal and spatial protocol of OTB; by
//! `otb-matlab/1` weighted by their frames, so that late starts count little), then the sequences with equal
//! weights, all of them and those of each attribute. High is good.
//!
//! Numbers: `success_auc`, `precision_20`. Tables: `overall`, `sequences`, `attributes`. Charts: `success`
//! (share of frames over the overlap threshold), `precision` (over the error threshold in pixels); their legends
//! hold the AUC and the precision at 20 pixels.

use super::prelude::*;
use crate::score::success::{self, Curves, RULES, Rules, overlap_threshold};
use std::collections::BTreeSet;

pub(crate) const ENTRY: Entry<dyn Analysis> = Entry::of::<Success>(
    "success",
    3,
    "success AUC and precision@20 of trackers, by the rules of an evaluation program",
)
.example("{ rules = \"otb-matlab/1\" }");

#[derive(Debug, Clone, SmartDefault, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Params {
    /// Rules of the evaluation: `otb-matlab/1`, `pysot/1`, `got10k/1`, `pysot-toolkit/1` or `lasot/1`.
    #[default(RULES[0].name.to_string())]
    pub rules: String,
}

struct Success {
    rules: &'static Rules,
}

impl Plugin for Success {
    type Params = Params;

    fn make(params: Params) -> Result<Self, ParamError> {
        let rules = RULES.iter().find(|r| r.name == params.rules);
        let rules = rules.ok_or_else(|| unknown_rules(&params.rules, RULES.iter().map(|r| r.name)))?;
        Ok(Self { rules })
    }
}

/// The numbers of the analysis, and the columns of its tables.
const NUMBERS: [TrackerMetric; 2] = [TrackerMetric::SUCCESS_AUC, TrackerMetric::PRECISION_20];

/// The values of [`NUMBERS`].
fn numbers(curves: &Curves) -> Vec<Option<f64>> {
    vec![Some(curves.auc()), Some(curves.precision_at_20())]
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

    fn layout(&self, _: usize) -> Layout {
        Layout::of_trackers(&NUMBERS)
            .measures("sequences", "sequence", &NUMBERS)
            .measures("attributes", "attribute", &NUMBERS)
            .chart("success", "overlap threshold", "success")
            .chart("precision", "error threshold (px)", "precision")
    }

    fn values(&self, populations: &[Population<'_>]) -> Result<Values, AnalysisError> {
        let mut sequences: Vec<OfSequence<'_>> = Vec::new();
        for runs in populations[0].trajectories.chunk_by(|a, b| a.sequence == b.sequence) {
            let of_run = |run: &Trajectory<'_>| {
                let frames = (run.regions.len() - run.start()) as f64;
                (if self.rules.pools_runs { frames } else { 1.0 }, self.rules.curves(run))
            };
            let curves: Vec<(f64, Curves)> = runs.iter().map(of_run).collect();
            if let Some(curves) = Curves::mean(curves.iter().map(|(weight, curves)| (*weight, curves))) {
                let (name, attributes) = (runs[0].sequence, runs[0].attributes);
                sequences.push(OfSequence { name, attributes, curves });
            }
        }
        let all = Curves::mean(sequences.iter().map(|s| (1.0, &s.curves))).ok_or(AnalysisError::NoTrack)?;
        let attributes: BTreeSet<&String> = sequences.iter().flat_map(|s| s.attributes).collect();
        let of_attribute = |attribute: &&String| {
            let mine: Vec<_> = sequences.iter().filter(|s| s.attributes.contains(attribute)).collect();
            let mean = Curves::mean(mine.iter().map(|s| (1.0, &s.curves)))?;
            Some((format!("{attribute} ({})", mine.len()), numbers(&mean)))
        };
        let chart = |headline: f64, points: Vec<(f64, f64)>| vec![(format!("[{headline:.3}]"), points)];
        let overlaps = (0..success::OVERLAPS).map(|i| (overlap_threshold(i), all.success[i])).collect();
        let errors = (0..success::ERRORS).map(|e| (e as f64, all.precision[e])).collect();
        let rows: Vec<Row> = sequences.iter().map(|s| (s.name.to_string(), numbers(&s.curves))).collect();
        let mut values = Values::of_tracker(&numbers(&all));
        values.tables.extend([rows, attributes.iter().filter_map(of_attribute).collect()]);
        values.charts = vec![chart(all.auc(), overlaps), chart(all.precision_at_20(), errors)];
        Ok(values)
    }
}
