//! Precision, recall and F of long-term tracking over the tracker's confidence, as evaluation programs compute them
//! (Lukezic et al., "Now you see me: evaluating performance in long-term visual tracking", 2018).
//!
//! ```text
//! Pr(h) = mean overlap of the frames with confidence >= h, 1 if there are none
//! Re(h) = sum of the overlaps of these frames / number of frames in which the target is visible
//! F(h)  = 2 Pr Re / (Pr + Re),  0 for 0 / 0;    the numbers are those at the h with the largest F, the highest of several
//! ```
//!
//! The overlap of a frame is intersection over union in `[0, 1]`, 0 where the target is absent or the tracker says so.
//! High confidence is sure; it has the unit of the tracker. High is good.
//!
//! | | `longterm/vot-toolkit/1` | `longterm/pysot/1` | `longterm/pytracking/1` |
//! |---|---|---|---|
//! | curves | Pr and Re of each sequence, then their means | the same | one of all frames together |
//! | thresholds | inf, 98 of the n scores by descending rank, -inf | the same by ascending rank, half a rank off | inf, every score, -inf |
//! | ranks | round(linspace(d, n - d)), d = floor(n / 98) | floor(linspace(d - 1, n - d) + 1/2) | |
//! | at -inf | every frame | frames with confidence above 0 | every frame |
//! | start | overlap 0 | overlap 0 | its overlap |
//! | no confidence | 0 | 0, but no threshold | 0 |
//!
//! Runs of a sequence are averaged first, pooled frames are those of all runs. Ranks are 0-based; with 98 scores or fewer
//! all of them are thresholds (pysot's program breaks there).
//!
//! Sources: vot-toolkit 0.9.0, `vot/analysis/longterm.py`; pysot, `toolkit/utils/statistics.py` (`determine_thresholds`,
//! `calculate_f1`) and `toolkit/evaluation/f1_benchmark.py`. `pytracking` pools frames as its evaluation is described;
//! its code for it was not found, so that nothing was compared with it. Sequences weigh as their frames there.

/// Number of scores between the infinite thresholds.
const INNER: usize = 98;

/// Rules of an evaluation program.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Rules {
    /// Name and version.
    pub name: &'static str,
    /// One line for `trackfail list`.
    pub summary: &'static str,
    program: Program,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Program {
    VotToolkit,
    Pysot,
    Pytracking,
}

/// All sets of rules.
pub static RULES: &[Rules] = &[
    Rules {
        name: "longterm/vot-toolkit/1",
        summary: "Pr, Re and F over confidence as vot-toolkit computes them",
        program: Program::VotToolkit,
    },
    Rules {
        name: "longterm/pysot/1",
        summary: "Pr, Re and F over confidence as pysot computes them",
        program: Program::Pysot,
    },
    Rules {
        name: "longterm/pytracking/1",
        summary: "Pr, Re and F over confidence of all frames together, as pytracking is described",
        program: Program::Pytracking,
    },
];

/// Frames of one run, with overlap and confidence.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct ConfidentTrack {
    /// Overlap of each frame.
    pub overlap: Vec<f64>,
    /// Confidence of each frame; NaN in one that has 0, but is no threshold.
    pub confidence: Vec<f64>,
    /// Number of frames in which the target is visible.
    pub visible: usize,
}

/// A point of the precision-recall curve.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Point {
    /// Confidence from which on frames count.
    pub threshold: f64,
    /// Precision Pr.
    pub precision: f64,
    /// Recall Re.
    pub recall: f64,
}

impl Point {
    /// F of the point.
    pub fn f_score(&self) -> f64 {
        let sum = self.precision + self.recall;
        if sum > 0.0 { 2.0 * self.precision * self.recall / sum } else { 0.0 }
    }
}

/// `count` equally spaced numbers from `from` to `to`, both included.
fn linspace(from: f64, to: f64, count: usize) -> impl Iterator<Item = f64> {
    let step = (to - from) / (count - 1) as f64;
    (0..count).map(move |k| if k + 1 == count { to } else { from + step * k as f64 })
}

impl Rules {
    /// Thresholds in descending order, from the confidences of all tracks.
    pub fn thresholds(&self, tracks: &[ConfidentTrack]) -> Vec<f64> {
        let mut scores: Vec<f64> =
            tracks.iter().flat_map(|t| &t.confidence).copied().filter(|c| !c.is_nan()).collect();
        scores.sort_by(|a, b| b.total_cmp(a));
        let n = scores.len();
        let step = (n / INNER) as f64;
        let at = |rank: f64| scores[rank as usize];
        let inner = match self.program {
            Program::Pytracking => {
                scores.dedup();
                scores
            }
            _ if n <= INNER => scores,
            Program::VotToolkit => {
                linspace(step, n as f64 - step, INNER).map(|r| at(r.round_ties_even())).collect()
            }
            // The same ranks from the other end.
            Program::Pysot => {
                let ranks = linspace(step - 1.0, n as f64 - step, INNER).map(|r| (r + 0.5).floor());
                let mut inner: Vec<f64> = ranks.map(|r| at((n - 1) as f64 - r)).collect();
                inner.reverse();
                inner
            }
        };
        [f64::INFINITY].into_iter().chain(inner).chain([f64::NEG_INFINITY]).collect()
    }

    /// True if the program knows the frame of a start by a mark instead of a region, so that its overlap is 0.
    pub fn marks_starts(&self) -> bool {
        self.program != Program::Pytracking
    }

    /// Confidence of a frame for which the tracker gives none.
    pub fn no_confidence(&self) -> f64 {
        if self.program == Program::Pysot { f64::NAN } else { 0.0 }
    }

    /// True if a frame of this confidence counts at the threshold.
    pub fn counts(&self, threshold: f64, confidence: f64) -> bool {
        let confidence = if confidence.is_nan() { 0.0 } else { confidence };
        let above_0 = self.program == Program::Pysot && threshold == f64::NEG_INFINITY;
        if above_0 { confidence > 0.0 } else { confidence >= threshold }
    }

    /// Pr and Re of a track at a threshold.
    fn point(&self, track: &ConfidentTrack, threshold: f64) -> (f64, f64) {
        let frames = track.overlap.iter().zip(&track.confidence).filter(|(_, c)| self.counts(threshold, **c));
        let (sum, count) = frames.fold((0.0, 0_usize), |(sum, n), (overlap, _)| (sum + overlap, n + 1));
        if count == 0 { (1.0, 0.0) } else { (sum / count as f64, sum / track.visible.max(1) as f64) }
    }

    /// Curve over sequences with their runs, by descending threshold.
    pub fn curve(&self, sequences: &[Vec<ConfidentTrack>]) -> Vec<Point> {
        let all = sequences.concat();
        let thresholds = self.thresholds(&all);
        let pooled = [vec![ConfidentTrack {
            overlap: all.iter().flat_map(|t| t.overlap.clone()).collect(),
            confidence: all.iter().flat_map(|t| t.confidence.clone()).collect(),
            visible: all.iter().map(|t| t.visible).sum(),
        }]];
        let sequences = if self.program == Program::Pytracking { &pooled } else { sequences };
        thresholds.into_iter().map(|threshold| self.mean_point(sequences, threshold)).collect()
    }

    /// Means over sequences of the means over their runs, at a threshold.
    pub fn mean_point(&self, sequences: &[Vec<ConfidentTrack>], threshold: f64) -> Point {
        let add = |(p, r): (f64, f64), (q, s): (f64, f64)| (p + q, r + s);
        let mean = |points: Vec<(f64, f64)>| {
            let n = points.len().max(1) as f64;
            let (p, r) = points.into_iter().fold((0.0, 0.0), add);
            (p / n, r / n)
        };
        let of_sequence =
            |runs: &Vec<ConfidentTrack>| mean(runs.iter().map(|t| self.point(t, threshold)).collect());
        let (precision, recall) = mean(sequences.iter().map(of_sequence).collect());
        Point { threshold, precision, recall }
    }
}

/// Point with the largest F, the first of several; `None` for an empty curve.
pub fn best(curve: &[Point]) -> Option<Point> {
    curve.iter().copied().reduce(|best, p| if best.f_score() >= p.f_score() { best } else { p })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::score::testing::value;
    use proptest::prelude::*;
    use serde_json::Value;
    use trackfail_testing::assert_near;

    fn rules(name: &str) -> &'static Rules {
        RULES.iter().find(|r| r.name == name).unwrap()
    }

    // tests/oracles/longterm.py: vot-toolkit 0.9.0, determine_thresholds and compute_tpr_curves; pysot's two functions from
    // their equations.
    #[test]
    fn agrees_with_vot_toolkit_and_pysot() {
        let cases: Vec<Value> =
            serde_json::from_str(include_str!("../../../../tests/oracles/longterm.json")).unwrap();
        for case in cases {
            let track = |s: &Value| {
                let (overlap, confidence) = (value(s, "overlap"), value(s, "confidence"));
                vec![ConfidentTrack { overlap, confidence, visible: value(s, "visible") }]
            };
            let sequences: Vec<_> = case["sequences"].as_array().unwrap().iter().map(track).collect();
            for (name, expected) in
                [("longterm/vot-toolkit/1", &case["vot"]), ("longterm/pysot/1", &case["pysot"])]
            {
                let curve = rules(name).curve(&sequences);
                let inner: Vec<f64> = curve[1..curve.len() - 1].iter().map(|p| p.threshold).collect();
                assert_eq!(inner, value::<Vec<f64>>(expected, "thresholds"), "{name}");
                let found = best(&curve).unwrap();
                let theirs = ["precision", "recall", "f"].map(|part| value::<f64>(expected, part));
                assert_near([found.precision, found.recall, found.f_score()], theirs, 1e-12, name);
            }
        }
    }

    // By hand. Sequence a: overlaps 1, 0 at confidences 2, -1; b: 0.5, 0.5, 0 at 1, 1, -2; visible 1 and 2.
    #[test]
    fn the_three_rules_differ() {
        let track = |overlap: &[f64], confidence: &[f64], visible| {
            vec![ConfidentTrack { overlap: overlap.into(), confidence: confidence.into(), visible }]
        };
        let sequences = [track(&[1.0, 0.0], &[2.0, -1.0], 1), track(&[0.5, 0.5, 0.0], &[1.0, 1.0, -2.0], 2)];
        let at = |name: &str, threshold: f64| {
            let curve = rules(name).curve(&sequences);
            let p = curve.iter().rev().find(|p| p.threshold == threshold).unwrap();
            (p.precision, p.recall)
        };
        let all = f64::NEG_INFINITY;
        assert_eq!(at("longterm/vot-toolkit/1", all), ((0.5 + 1.0 / 3.0) / 2.0, 0.75));
        assert_eq!(at("longterm/pysot/1", all), (0.75, 0.75));
        assert_eq!(at("longterm/pytracking/1", all), (0.4, 2.0 / 3.0));
        assert_eq!(at("longterm/vot-toolkit/1", 2.0), (1.0, 0.5));
        assert_eq!(at("longterm/pytracking/1", 2.0), (1.0, 1.0 / 3.0));
        let best = best(&rules("longterm/vot-toolkit/1").curve(&sequences)).unwrap();
        assert_eq!((best.threshold, best.f_score()), (1.0, 0.75));
    }

    // By hand: 98 scores are all thresholds; pysot leaves out the frame of confidence 0.
    #[test]
    fn few_scores_are_all_thresholds_and_a_confidence_of_0_is_none() {
        let confidence: Vec<f64> = (0..98).map(f64::from).collect();
        let all: Vec<f64> = confidence.iter().rev().copied().collect();
        let track = ConfidentTrack { overlap: vec![1.0; 98], confidence, visible: 98 };
        let zero = ConfidentTrack { overlap: vec![1.0, 0.5], confidence: vec![1.0, 0.0], visible: 2 };
        for (name, expected) in [("vot-toolkit", (0.75, 0.75)), ("pysot", (1.0, 0.5))] {
            let rules = rules(&format!("longterm/{name}/1"));
            assert_eq!(rules.thresholds(std::slice::from_ref(&track))[1..99], all, "{name}");
            assert_eq!(rules.point(&zero, f64::NEG_INFINITY), expected, "{name}");
        }
    }

    #[test]
    fn f_of_nothing_is_0_and_the_first_of_equal_points_is_best() {
        let point = |threshold, recall| Point { threshold, precision: recall, recall };
        assert_eq!(point(0.0, 0.0).f_score(), 0.0);
        assert_eq!(best(&[point(2.0, 0.5), point(1.0, 0.5)]).unwrap().threshold, 2.0);
        // As numpy.linspace(0, 0.9, 4)[-1]; three times 0.3 is less.
        assert_eq!(linspace(0.0, 0.9, 4).last(), Some(0.9));
    }

    proptest! {
        #[test]
        fn one_sequence_is_pooled_and_recall_grows(
            frames in prop::collection::vec((0.0..1.0_f64, -5..6_i32), 1..60),
        ) {
            let (overlap, confidence) = frames.iter().map(|(o, c)| (*o, f64::from(*c))).unzip();
            let sequences = [vec![ConfidentTrack { overlap, confidence, visible: frames.len() }]];
            let (vot, pooled) = (rules("longterm/vot-toolkit/1"), rules("longterm/pytracking/1"));
            let curve = vot.curve(&sequences);
            prop_assert!(curve.is_sorted_by(|a, b| a.recall <= b.recall + 1e-12));
            // With few frames all scores are thresholds of both.
            prop_assert_eq!(best(&curve), best(&pooled.curve(&sequences)));
        }
    }
}
