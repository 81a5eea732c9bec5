//! Success and precision of trackers, as the evaluation programs of OTB compute them.
//!
//! ```text
//! S(u) = #{t: overlap_t >  u} / n    u = 0, .05, ... 1      success AUC = mean of the 21 values
//! P(e) = #{t: error_t  <= e} / n    e = 0, 1, ... 50 px     precision@20 = P(20)
//! ```
//!
//! `overlap_t` is intersection over union of the two rectangles in frame t, `error_t` the distance of their
//! centers in pixels, n the number of all frames. High is good. Both are computed for every sequence and
//! then averaged with equal weights (Wu, Lim, Yang, CVPR 2013 and TPAMI 37(9), 2015).
//!
//! The programs agree on these formulas and differ in the rules below, so that the same boxes have different scores:
//!
//! | | `otb-matlab/1` | `pysot/1` | `got10k/1` | `pysot-toolkit/1` | `lasot/1` |
//! |---|---|---|---|---|---|
//! | first frame | replaced by the truth | as reported | replaced by the truth | as reported | replaced by the truth |
//! | frame without truth | a miss of the overlap, a **hit** of the error | the same | a miss of both | as `pysot/1` | a miss of both |
//! | truth that does not count for the overlap | x or y not above 0 | none | none | x or y not above 0 | x or y not above 0 |
//! | truth that does not count for the error | the same | center not above 0 | none | center not above 0 | x or y not above 0 |
//! | tracker without a box | its last box stands | a miss | a miss | a miss | its last box stands |
//! | runs of a sequence | their frames are pooled | equal weights | equal weights | equal weights | equal weights |
//!
//! A truth that does not count is a miss of the overlap and a **hit** of the error. x, y and the center are 1-based there.
//! `lasot/1` leaves frames in which the target is absent out of both counts, but not out of n, which makes them misses.
//!
//! Boxes are continuous and 0-based here; in OTB's 1-based pixels x and y are larger by 1 and a center is
//! `x + (w - 1) / 2`, which cancels in both measures and counts only for the truths that do not count.
//! [`Trajectory::counted`] defines frames without a box. A line of four zeros in a file is such a frame; the
//! programs of pysot and got10k measure the distance of its center instead. A run that starts later than the
//! sequence (OTB's temporal runs) is scored from its start on.
//!
//! Sources: OTB toolkit `calcSeqErrRobust.m`, `genPerfMat.m`, `perfPlot.m`; STVIR/pysot (c7fd71c) and its
//! elder, StrangerZhang/pysot-toolkit, `success_overlap`, `success_error`; got10k-toolkit `ExperimentOTB`;
//! HengLan/LaSOT_Evaluation_Toolkit `calc_seq_err_robust.m`, `eval_tracker.m`; all read for their rules only.

use super::trajectory::{Missing, Trajectory, mean};
use crate::region::{Areas, Rect, Region};

/// Number of overlap thresholds, from 0 to 1.
pub const OVERLAPS: usize = 21;
/// Number of error thresholds, from 0 to 50 pixels.
pub const ERRORS: usize = 51;
/// Error threshold at which trackers are compared, in pixels.
pub const PRECISION_AT: usize = 20;

/// Rules of an evaluation program.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Rules {
    /// Name and version.
    pub name: &'static str,
    /// One line for `trackfail list`.
    pub summary: &'static str,
    /// True if the first box is replaced by the annotation.
    replaces_first: bool,
    /// True if frames without annotation are hits of the precision.
    absent_is_hit: bool,
    /// Treatment of a tracker without a box.
    missing: Missing,
    /// Annotations that count for the overlap.
    overlap: Annotated,
    /// Annotations that count for the error.
    error: Annotated,
    /// Language of the program, on which the last digit of thresholds depends.
    language: Language,
    /// True if the frames of a sequence's runs are pooled; otherwise runs have equal weights.
    pub pools_runs: bool,
}

/// Language of an evaluation program.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Language {
    Matlab,
    Python,
}

impl Language {
    /// Overlap threshold of index `i`, from 0: `0:0.05:1`, which MATLAB computes from both ends, or
    /// `numpy.arange(0, 1.05, 0.05)`.
    fn overlap_threshold(self, i: usize) -> f64 {
        match self {
            Self::Matlab if i > OVERLAPS / 2 => 1.0 - (OVERLAPS - 1 - i) as f64 * 0.05,
            _ => i as f64 * 0.05,
        }
    }

    /// Number of overlap thresholds below the overlap.
    fn overlaps_below(self, overlap: f64) -> usize {
        // Rounding may put the product on the wrong side of a threshold; the threshold itself decides.
        let near = (overlap * (OVERLAPS - 1) as f64) as usize;
        let from = near.saturating_sub(1).min(OVERLAPS);
        from + (from..OVERLAPS).take_while(|i| overlap > self.overlap_threshold(*i)).count()
    }
}

/// Annotations that count.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Annotated {
    /// Annotations whose left top corner is positive, 1-based.
    Corner,
    /// Annotations whose center is positive, 1-based.
    Center,
    /// All annotations.
    All,
}

impl Annotated {
    fn includes(self, truth: &Rect) -> bool {
        let (x, y) = match self {
            Self::Corner => (truth.x + 1.0, truth.y + 1.0),
            Self::Center => {
                let (x, y) = truth.center();
                (x + 0.5, y + 0.5)
            }
            Self::All => return true,
        };
        x > 0.0 && y > 0.0
    }
}

const OTB_MATLAB: Rules = Rules {
    name: "otb-matlab/1",
    summary: "success AUC and precision@20 as the OTB toolkit computes them",
    replaces_first: true,
    absent_is_hit: true,
    missing: Missing::LastBox,
    overlap: Annotated::Corner,
    error: Annotated::Corner,
    language: Language::Matlab,
    pools_runs: true,
};

const PYSOT: Rules = Rules {
    name: "pysot/1",
    summary: "success AUC and precision@20 as STVIR/pysot computes them",
    replaces_first: false,
    absent_is_hit: true,
    missing: Missing::Miss,
    overlap: Annotated::All,
    error: Annotated::Center,
    language: Language::Python,
    pools_runs: false,
};

/// All sets of rules.
pub static RULES: &[Rules] = &[
    OTB_MATLAB,
    PYSOT,
    Rules {
        name: "got10k/1",
        summary: "success AUC and precision@20 as got10k-toolkit computes them",
        replaces_first: true,
        absent_is_hit: false,
        error: Annotated::All,
        ..PYSOT
    },
    Rules {
        name: "pysot-toolkit/1",
        summary: "success AUC and precision@20 as StrangerZhang/pysot-toolkit computes them",
        overlap: Annotated::Corner,
        ..PYSOT
    },
    Rules {
        name: "lasot/1",
        summary: "success AUC and precision@20 as LaSOT's toolkit computes them, absent frames in the length alone",
        absent_is_hit: false,
        pools_runs: false,
        ..OTB_MATLAB
    },
];

/// Success and precision of one run.
#[derive(Debug, Clone, PartialEq)]
pub struct Curves {
    /// Share of frames with an overlap above each threshold.
    pub success: Vec<f64>,
    /// Share of frames with a center error of at most 0, 1, ... 50 pixels.
    pub precision: Vec<f64>,
}

impl Curves {
    /// Area under the success curve.
    pub fn auc(&self) -> f64 {
        mean(self.success.iter().copied()).unwrap_or(0.0)
    }

    /// Precision at [`PRECISION_AT`] pixels.
    pub fn precision_at_20(&self) -> f64 {
        self.precision[PRECISION_AT]
    }

    /// Mean over several runs or sequences with their weights; `None` without any.
    pub fn mean<'c>(curves: impl IntoIterator<Item = (f64, &'c Self)>) -> Option<Self> {
        let mut sum = Self { success: vec![0.0; OVERLAPS], precision: vec![0.0; ERRORS] };
        let mut all = 0.0;
        for (weight, c) in curves {
            sum.success.iter_mut().zip(&c.success).for_each(|(s, v)| *s += weight * v);
            sum.precision.iter_mut().zip(&c.precision).for_each(|(s, v)| *s += weight * v);
            all += weight;
        }
        sum.success.iter_mut().chain(&mut sum.precision).for_each(|v| *v /= all);
        (all > 0.0).then_some(sum)
    }
}

/// Overlap threshold of index `i`, from 0, for charts.
pub fn overlap_threshold(i: usize) -> f64 {
    i as f64 / (OVERLAPS - 1) as f64
}

/// Number of error thresholds below the error; all of them if the error is NaN.
fn errors_below(error: f64) -> usize {
    if error <= (ERRORS - 1) as f64 { error.max(0.0).ceil() as usize } else { ERRORS }
}

/// Intersection over union, at most 1.
pub(super) fn iou(a: &Rect, b: &Rect) -> f64 {
    Areas::Exact.overlap(&Region::Rect(*a), &Region::Rect(*b), None)
}

impl Rules {
    /// Success and precision of one run; all 0 for a run without frames.
    pub fn curves(&self, trajectory: &Trajectory<'_>) -> Curves {
        let start = trajectory.start();
        let boxes: Vec<Option<Rect>> =
            trajectory.counted(self.missing).into_iter().skip(start).map(|r| r.map(Region::rect)).collect();
        let truth: Vec<Option<Rect>> =
            trajectory.truth.iter().skip(start).map(|t| t.as_ref().map(Region::rect)).collect();
        self.of_boxes(&boxes, &truth)
    }

    /// Success and precision of plain boxes; `None` in frames without a box.
    pub fn of_boxes(&self, boxes: &[Option<Rect>], truth: &[Option<Rect>]) -> Curves {
        // How many frames pass exactly so many of the thresholds, which rise.
        let (mut success, mut precision) = ([0_u64; OVERLAPS + 1], [0_u64; ERRORS + 1]);
        for (t, (reported, truth)) in boxes.iter().zip(truth).enumerate() {
            let tracked = if t == 0 && self.replaces_first { *truth } else { *reported };
            let overlap = match (truth.filter(|truth| self.overlap.includes(truth)), tracked) {
                (Some(truth), Some(tracked)) => iou(&tracked, &truth),
                _ => -1.0,
            };
            let error = match (truth.filter(|truth| self.error.includes(truth)), tracked) {
                (None, _) if truth.is_some() || self.absent_is_hit => -1.0,
                (Some(truth), Some(tracked)) => {
                    let (a, b) = (tracked.center(), truth.center());
                    (a.0 - b.0).hypot(a.1 - b.1)
                }
                _ => f64::INFINITY,
            };
            success[self.language.overlaps_below(overlap)] += 1;
            precision[errors_below(error)] += 1;
        }
        let frames = boxes.len().max(1) as f64;
        // An overlap passes the thresholds below it, the first ones; an error those that are not below it, the last ones.
        let above = |i: usize| success[i + 1..].iter().sum::<u64>() as f64 / frames;
        let within = |e: usize| precision[..=e].iter().sum::<u64>() as f64 / frames;
        Curves { success: (0..OVERLAPS).map(above).collect(), precision: (0..ERRORS).map(within).collect() }
    }
}

#[cfg(test)]
mod tests;
