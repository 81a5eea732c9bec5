//! `longterm`: precision, recall and F of trackers over their own confidence, by the rules of an evaluation program.
//!
//! The measures, and what the programs differ in, are in [`crate::score::longterm`]. The signal is the confidence, high
//! values are sure. A frame without annotation is one without target; the overlap there is 0, and so it is in frames in
//! which the tracker says that the target is absent. Frames before a tracker that starts later are left out.
//!
//! Numbers: `lt_precision`, `lt_recall` and `lt_f` at the threshold with the largest F, and `lt_threshold`, the lowest
//! confidence that reaches it. Tables: `overall`, and `sequences` with precision and recall of each at that threshold.
//! Chart: `precision-recall`.

use super::confident::{ConfidentFrame, sequences};
use super::{Analysis, AnalysisError, Chart, Findings, Grid, Names, Population, Reads};
use crate::plugin::{Entry, ParamError, read_params, show_params, unknown};
use crate::region::Areas;
use crate::score::TrackerMetric;
use crate::score::longterm::{ConfidentTrack, Point, RULES, Rules, best};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// The list's entry.
pub const ENTRY: Entry<dyn Analysis> = Entry {
    kind: "longterm",
    version: 1,
    summary: "precision, recall and F of trackers over their confidence, by the rules of an evaluation program",
    example: "{ rules = \"longterm/vot-toolkit/1\" }",
    build: |raw| Ok(Box::new(Longterm::new(read_params(raw)?)?)),
    schema: || schemars::schema_for!(Params),
};

/// Parameters.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Params {
    /// `longterm/vot-toolkit/1`, `longterm/pysot/1` or `longterm/pytracking/1`.
    pub rules: String,
    /// How areas are counted.
    pub overlap: Areas,
    /// Whether only the parts of regions that lie on the frame count, as both programs have it.
    pub bounded: bool,
}

impl Default for Params {
    fn default() -> Self {
        Self { rules: RULES[0].name.to_string(), overlap: Areas::VotToolkit, bounded: true }
    }
}

struct Longterm {
    params: Params,
    rules: &'static Rules,
}

impl Longterm {
    fn new(params: Params) -> Result<Self, ParamError> {
        let known = || RULES.iter().map(|r| r.name);
        let rules = RULES.iter().find(|r| r.name == params.rules).ok_or_else(|| {
            let message = unknown("set of rules", &params.rules, known());
            ParamError { message, key: Some("rules"), span: None }
        })?;
        Ok(Self { params, rules })
    }
}

/// The numbers of the analysis, and the columns of its table.
const NUMBERS: [TrackerMetric; 4] =
    [TrackerMetric::LT_PRECISION, TrackerMetric::LT_RECALL, TrackerMetric::LT_F, TrackerMetric::LT_THRESHOLD];

fn confident(frames: &[ConfidentFrame]) -> ConfidentTrack {
    ConfidentTrack {
        overlap: frames.iter().map(|f| f.overlap.unwrap_or(0.0)).collect(),
        confidence: frames.iter().map(|f| f.confidence).collect(),
        visible: frames.iter().filter(|f| f.overlap.is_some()).count(),
    }
}

impl Analysis for Longterm {
    fn params(&self) -> serde_json::Value {
        show_params(&self.params)
    }

    fn reads(&self) -> Reads {
        Reads::SignalAndRegions
    }

    fn suites(&self) -> (usize, usize) {
        (1, 1)
    }

    fn names(&self, _: usize) -> Names {
        let words = |list: &[&str]| list.iter().map(ToString::to_string).collect();
        Names {
            numbers: NUMBERS.map(|m| m.name.to_string()).into(),
            tables: words(&["overall", "sequences"]),
            charts: words(&["precision-recall"]),
        }
    }

    fn analyze(&self, populations: &[Population<'_>]) -> Result<Findings, AnalysisError> {
        let sequences = sequences(populations, self.params.overlap, self.params.bounded)?;
        let (names, runs): (Vec<&str>, Vec<Vec<ConfidentTrack>>) = sequences
            .iter()
            .map(|(name, runs)| (*name, runs.iter().map(|frames| confident(frames)).collect()))
            .unzip();
        let curve = self.rules.curve(&runs);
        let best = best(&curve).ok_or(AnalysisError::NoTrack)?;
        let confidences = || runs.iter().flatten().flat_map(|t| t.confidence.iter().copied());
        let lowest = confidences().filter(|c| *c >= best.threshold).fold(f64::INFINITY, f64::min);
        let highest = confidences().fold(f64::NEG_INFINITY, f64::max);
        let threshold = if lowest.is_finite() { lowest } else { highest };
        let numbers = [best.precision, best.recall, best.f_score(), threshold];
        let row = |(name, runs): (&&str, &Vec<ConfidentTrack>)| {
            let Point { precision, recall, .. } =
                self.rules.mean_point(std::slice::from_ref(runs), best.threshold);
            (name.to_string(), vec![Some(precision), Some(recall)])
        };
        let table = |name: &str, corner: &str, columns: &[TrackerMetric], rows| Grid {
            name: name.into(),
            corner: corner.into(),
            columns: columns.iter().map(|m| m.heading.to_string()).collect(),
            rows,
        };
        let mut points: Vec<(f64, f64)> = curve.iter().map(|p| (p.recall, p.precision)).collect();
        points.sort_by(|a, b| a.0.total_cmp(&b.0));
        let rows = names.iter().zip(&runs).map(row).collect();
        Ok(Findings {
            numbers: NUMBERS.map(|m| m.name.to_string()).into_iter().zip(numbers).collect(),
            tables: vec![
                table("overall", "tracker", &NUMBERS, vec![(String::new(), numbers.map(Some).to_vec())]),
                table("sequences", "sequence", &NUMBERS[..2], rows),
            ],
            charts: vec![Chart {
                name: "precision-recall".into(),
                x: "recall".into(),
                y: "precision".into(),
                y_log: false,
                curves: vec![(format!("[{:.3}]", best.f_score()), points)],
            }],
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::detector::Example;
    use crate::region::{Rect, Region};
    use crate::score::trajectory::Trajectory;
    use crate::tracker::Status;

    // By hand: overlaps 1, 1/3, 0 (said to be absent), and no target with confidence 0.9. At 0.9 precision is
    // (1 + 0) / 2 and recall 1 / 3; at 0.5 they are 4/9 and 4/9, F is 4/9.
    #[test]
    fn frames_without_target_cost_precision_and_absence_recall() {
        let square = |x: f64| Region::Rect(Rect::new(x, 0.0, 10.0, 10.0));
        let regions = [square(0.0), square(5.0), square(0.0), square(0.0)];
        let status = [Status::Initialized, Status::Tracked, Status::Absent, Status::Tracked];
        let truth = [Some(square(0.0)), Some(square(0.0)), Some(square(0.0)), None];
        let confidence = [1.0, 0.5, 0.1, 0.9];
        let trajectory = Trajectory {
            sequence: "s",
            run: 0,
            regions: &regions,
            status: &status,
            truth: &truth,
            confidence: &[],
            frame: None,
            attributes: &[],
            frame_attributes: &[],
        };
        let population = Population {
            suite: "suite",
            tracks: vec![Example::new(&confidence, &[0.0; 4])],
            trajectories: vec![trajectory],
            timings: vec![],
        };
        let of = |rules: &str| {
            let text = format!("{{ rules = \"{rules}\", overlap = \"exact\" }}");
            ENTRY.build_from_text(&text).unwrap().analyze(std::slice::from_ref(&population)).unwrap()
        };
        let findings = of("longterm/vot-toolkit/1");
        let number = |name: &str| findings.number(name).unwrap();
        assert!((number("lt_f") - 0.5).abs() < 1e-12, "{findings:?}");
        assert_eq!((number("lt_precision"), number("lt_threshold")), (1.0, 1.0));
        assert!((number("lt_recall") - 1.0 / 3.0).abs() < 1e-12);
        let curve = &findings.charts[0].curves[0].1;
        assert!(curve.iter().any(|p| (p.0 - 1.0 / 3.0).abs() < 1e-12 && (p.1 - 0.5).abs() < 1e-12));
        assert!(curve.iter().any(|p| (p.0 - 4.0 / 9.0).abs() < 1e-12 && (p.1 - 4.0 / 9.0).abs() < 1e-12));
        assert!(ENTRY.build_from_text("{ rules = \"longterm/vot/1\" }").is_err());
    }
}
