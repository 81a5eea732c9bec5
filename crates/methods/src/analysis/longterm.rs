//! `longterm`: precision, recall and F of trackers over their own confidence, by the rules of an evaluation program.
//!
//! The measures, and what the programs differ in, are in [`crate::score::longterm`]. The signal is used as
//! the confidence; a high value means that the tracker is sure. A frame without annotation counts as a frame
//! without target. The overlap is 0 in such frames, and in frames in which the tracker has no box, for
//! example because it says that the target is absent; vot-toolkit and pysot also have 0 in the frame of the start. Where the
//! signal is the tracker's own confidence, a frame for which the tracker gives none, the first one included, has
//! confidence 0, as in the programs. If a tracker starts after the first frame, the frames before its start are left out.
//!
//! Deviation: where target and tracker are absent, vot-toolkit has overlap 1 if both are told by empty rectangles, so
//! that its recall can be above 1; here it is 0.
//!
//! Numbers: `lt_precision`, `lt_recall` and `lt_f` at the threshold with the largest F, and `lt_threshold`, the lowest
//! confidence that reaches it. Tables: `overall`, and `sequences` with precision and recall of each at that threshold.
//! Chart: `precision-recall`.

use super::confident::{ConfidentFrame, sequences};
use super::prelude::*;
use crate::score::longterm::{ConfidentTrack, Point, RULES, Rules, best};

pub(crate) const ENTRY: Entry<dyn Analysis> = Entry::of::<Longterm>(
    "longterm",
    4,
    "precision, recall and F of trackers over their confidence, by the rules of an evaluation program",
)
.example("{ rules = \"longterm/vot-toolkit/1\" }");

#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Params {
    /// `longterm/vot-toolkit/1`, `longterm/pysot/1` or `longterm/pytracking/1`.
    pub rules: String,
    /// How areas are measured: `exact`, `raster-2014` or `vot-toolkit`.
    pub overlap: Areas,
    /// If true, only the part of a region on the frame counts, as in both programs.
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

impl Plugin for Longterm {
    type Params = Params;

    fn make(params: Params) -> Result<Self, ParamError> {
        let rules = RULES.iter().find(|r| r.name == params.rules);
        let rules = rules.ok_or_else(|| unknown_rules(&params.rules, RULES.iter().map(|r| r.name)))?;
        Ok(Self { params, rules })
    }
}

/// The numbers of the analysis, and the columns of its table.
const NUMBERS: [TrackerMetric; 4] =
    [TrackerMetric::LT_PRECISION, TrackerMetric::LT_RECALL, TrackerMetric::LT_F, TrackerMetric::LT_THRESHOLD];

fn confident(frames: &[ConfidentFrame], rules: &Rules) -> ConfidentTrack {
    let overlap = |f: &ConfidentFrame| match f.status {
        Status::Initialized if rules.marks_starts() => 0.0,
        _ => f.overlap.unwrap_or(0.0),
    };
    let confidence = |f: &ConfidentFrame| f.confidence.unwrap_or(rules.no_confidence());
    ConfidentTrack {
        overlap: frames.iter().map(overlap).collect(),
        confidence: frames.iter().map(confidence).collect(),
        visible: frames.iter().filter(|f| f.overlap.is_some()).count(),
    }
}

impl Analysis for Longterm {
    fn reads(&self) -> Reads {
        Reads::SignalAndRegions
    }

    fn layout(&self, _: usize) -> Layout {
        Layout::of_trackers(&NUMBERS).measures("sequences", "sequence", &NUMBERS[..2]).chart(
            "precision-recall",
            "recall",
            "precision",
        )
    }

    fn values(&self, populations: &[Population<'_>]) -> Result<Values, AnalysisError> {
        let sequences = sequences(&populations[0], self.params.overlap, self.params.bounded)?;
        let (names, runs): (Vec<&str>, Vec<Vec<ConfidentTrack>>) = sequences
            .iter()
            .map(|(name, runs)| (*name, runs.iter().map(|frames| confident(frames, self.rules)).collect()))
            .unzip();
        let curve = self.rules.curve(&runs);
        let best = best(&curve).ok_or(AnalysisError::NoTrack)?;
        let confidences = || runs.iter().flatten().flat_map(|t| t.confidence.iter().copied());
        let lowest =
            confidences().filter(|c| self.rules.counts(best.threshold, *c)).fold(f64::INFINITY, f64::min);
        let highest = confidences().fold(f64::NEG_INFINITY, f64::max);
        let threshold = if lowest.is_finite() { lowest } else { highest };
        let numbers = [best.precision, best.recall, best.f_score(), threshold];
        let row = |(name, runs): (&&str, &Vec<ConfidentTrack>)| {
            let Point { precision, recall, .. } =
                self.rules.mean_point(std::slice::from_ref(runs), best.threshold);
            (name.to_string(), vec![Some(precision), Some(recall)])
        };
        let mut points: Vec<(f64, f64)> = curve.iter().map(|p| (p.recall, p.precision)).collect();
        points.sort_by(|a, b| a.0.total_cmp(&b.0));
        let mut values = Values::of_tracker(&numbers.map(Some));
        values.tables.push(names.iter().zip(&runs).map(row).collect());
        values.charts.push(vec![(format!("[{:.3}]", best.f_score()), points)]);
        Ok(values)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::analysis::Findings;
    use crate::detector::Example;
    use proptest::prelude::*;
    use trackfail_core::region::Rect;
    use trackfail_testing::assert_near;

    fn square(x: f64) -> Region {
        Region::Rect(Rect::new(x, 0.0, 10.0, 10.0))
    }

    /// A random track: regions, status, ground truth, signal, and the confidence that the signal is made of.
    struct Drawn {
        regions: Vec<Region>,
        status: Vec<Status>,
        truth: Vec<Option<Region>>,
        signal: Vec<f64>,
        confidence: Vec<Option<f64>>,
    }

    fn findings(rules: &str, drawn: &Drawn) -> Findings {
        let trajectory = Trajectory {
            sequence: "s",
            regions: &drawn.regions,
            status: &drawn.status,
            truth: &drawn.truth,
            confidence: &drawn.confidence,
            ..Trajectory::default()
        };
        let error = vec![0.0; drawn.signal.len()];
        let population = Population {
            suite: "suite",
            tracks: vec![Example::new(&drawn.signal, &error)],
            trajectories: vec![trajectory],
            timings: vec![],
        };
        let text = format!("{{ rules = \"{rules}\", overlap = \"exact\" }}");
        ENTRY.build_from_text(&text).unwrap().analyze(&[population]).unwrap()
    }

    /// Precision, recall and F at the largest F.
    fn at_best(findings: &Findings) -> [f64; 3] {
        ["lt_precision", "lt_recall", "lt_f"].map(|name| findings.number(name).unwrap())
    }

    /// 40 frames of a tracker that is always right, but says "absent" in frames 21 to 25 with this
    /// confidence. The signal repeats the last confidence where there is none.
    fn said_absent(is_absent: bool, confidence: Option<f64>) -> Drawn {
        let gone = |t: &usize| (20..25).contains(t);
        let status = |t: usize| match t {
            0 => Status::Initialized,
            _ if gone(&t) => Status::Absent,
            _ => Status::Tracked,
        };
        let given = |t| if gone(&t) { confidence } else { Some(0.9) };
        Drawn {
            regions: vec![square(0.0); 40],
            status: (0..40).map(status).collect(),
            truth: (0..40).map(|t| (!(is_absent && gone(&t))).then(|| square(0.0))).collect(),
            signal: (0..40).map(|t| given(t).filter(|c| !c.is_nan()).unwrap_or(0.9)).collect(),
            confidence: (0..40).map(given).collect(),
        }
    }

    // By hand: at .9 the 35 frames with that confidence count, or all 40. The overlap is 0 in frames 21 to 25, and in the first
    // one for the programs that know it as a start. `visible` frames have the target.
    #[test]
    fn a_frame_without_a_confidence_has_0() {
        for (is_absent, confidence, count, visible) in [
            (true, None, 35.0, 35.0),
            (true, Some(0.0), 35.0, 35.0),
            (true, Some(f64::NAN), 35.0, 35.0),
            (true, Some(0.9), 40.0, 35.0),
            // It is said to be absent and is not.
            (false, None, 35.0, 40.0),
            (false, Some(0.0), 35.0, 40.0),
        ] {
            let drawn = said_absent(is_absent, confidence);
            for (program, sum) in [("vot-toolkit", 34.0), ("pysot", 34.0), ("pytracking", 35.0)] {
                let (precision, recall) = (sum / count, sum / visible);
                let expected = [precision, recall, 2.0 * precision * recall / (precision + recall)];
                let what = format!("{program} {is_absent} {confidence:?}");
                let found = findings(&format!("longterm/{program}/1"), &drawn);
                assert_near(at_best(&found), expected, 1e-12, what);
            }
        }
    }

    // vot-toolkit 0.9.0, compute_tpr_curves on a trajectory of `Special(INITIALIZATION)` and four boxes on the target, with
    // `properties(i).get("confidence", 0)`. In pysot's determine_thresholds the first confidence is NaN.
    #[test]
    fn a_start_has_no_overlap_and_in_pysot_no_rank() {
        let mut status = vec![Status::Tracked; 5];
        status[0] = Status::Initialized;
        let confidence = vec![None, Some(-1.0), Some(-1.0), Some(-1.0), Some(-1.0)];
        let (regions, truth) = (vec![square(0.0); 5], vec![Some(square(0.0)); 5]);
        let drawn = Drawn { regions, status, truth, signal: vec![-1.0; 5], confidence };
        for (program, expected, points) in
            [("vot-toolkit", 0.8, 7), ("pysot", 0.8, 6), ("pytracking", 1.0, 4)]
        {
            let found = findings(&format!("longterm/{program}/1"), &drawn);
            assert_near(at_best(&found), [expected; 3], 1e-12, program);
            assert_eq!(found.charts[0].curves[0].1.len(), points, "{program}");
        }
    }

    // The same functions with overlaps 1, 1/3, 0, 0, 0, three frames with target, confidence none, .5, none, .9, none.
    #[test]
    fn a_first_frame_without_one_has_0_too_and_other_signals_have_theirs() {
        let mut drawn = Drawn {
            regions: vec![square(0.0), square(5.0), square(90.0), square(0.0), square(0.0)],
            status: vec![Status::Tracked; 5],
            truth: vec![Some(square(0.0)), Some(square(0.0)), Some(square(0.0)), None, None],
            signal: vec![1.0, 0.5, 0.5, 0.9, 0.9],
            confidence: vec![None, Some(0.5), None, Some(0.9), None],
        };
        let found = findings("longterm/vot-toolkit/1", &drawn);
        assert_near(at_best(&found), [4.0 / 15.0, 4.0 / 9.0, 1.0 / 3.0], 1e-12, "");
        drawn.confidence.clear();
        let found = findings("longterm/vot-toolkit/1", &drawn);
        assert_eq!((found.number("lt_precision"), found.number("lt_threshold")), (Some(1.0), Some(1.0)));
    }

    // By hand: overlaps 1, 1/3, 0 (said to be absent), and no target with confidence 0.9. At 0.9 precision is
    // (1 + 0) / 2 and recall 1 / 3; at 0.5 they are 4/9 and 4/9, F is 4/9.
    #[test]
    fn frames_without_target_cost_precision_and_absence_recall() {
        let drawn = Drawn {
            regions: vec![square(0.0), square(5.0), square(0.0), square(0.0)],
            status: vec![Status::Initialized, Status::Tracked, Status::Absent, Status::Tracked],
            truth: vec![Some(square(0.0)), Some(square(0.0)), Some(square(0.0)), None],
            signal: vec![1.0, 0.5, 0.1, 0.9],
            confidence: vec![],
        };
        let findings = findings("longterm/pytracking/1", &drawn);
        assert_near(at_best(&findings), [1.0, 1.0 / 3.0, 0.5], 1e-12, "");
        assert_eq!(findings.number("lt_threshold"), Some(1.0));
        for (recall, precision) in [(1.0 / 3.0, 0.5), (4.0 / 9.0, 4.0 / 9.0)] {
            let mut curve = findings.charts[0].curves[0].1.iter();
            assert!(curve.any(|p| (p.0 - recall).abs() < 1e-12 && (p.1 - precision).abs() < 1e-12));
        }
        assert!(ENTRY.build_from_text("{ rules = \"longterm/vot/1\" }").is_err());
    }

    proptest! {
        #[test]
        fn no_confidence_is_a_confidence_of_0(
            frames in prop::collection::vec((0.0..20.0_f64, prop::option::of(-1.0..1.0_f64), any::<bool>()), 1..40),
        ) {
            let mut last = 1.0;
            let repeat = |c: &Option<f64>| {
                last = c.unwrap_or(last);
                last
            };
            let confidence: Vec<Option<f64>> = frames.iter().map(|f| f.1).collect();
            let empty = Drawn {
                regions: frames.iter().map(|f| square(f.0)).collect(),
                status: frames.iter().map(|f| if f.2 { Status::Tracked } else { Status::Absent }).collect(),
                truth: vec![Some(square(0.0)); frames.len()],
                signal: confidence.iter().map(repeat).collect(),
                confidence,
            };
            let given: Vec<f64> = empty.confidence.iter().map(|c| c.unwrap_or(0.0)).collect();
            let zero = Drawn {
                regions: empty.regions.clone(),
                status: empty.status.clone(),
                truth: empty.truth.clone(),
                confidence: given.iter().copied().map(Some).collect(),
                signal: given,
            };
            // In pysot it is no threshold.
            for rules in RULES.iter().filter(|rules| !rules.no_confidence().is_nan()) {
                prop_assert_eq!(findings(rules.name, &empty), findings(rules.name, &zero));
            }
        }
    }
}
