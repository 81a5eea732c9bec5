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
//! | | `otb-matlab/1` | `pysot/1` | `got10k/1` |
//! |---|---|---|---|
//! | first frame | replaced by the truth | as reported | replaced by the truth |
//! | frame without annotation | overlap -1: a miss; error -1: a **hit** | the same | a miss |
//! | what counts as annotated | x, y, w and h above 0, 1-based | w and h above 0; for the error, the center above 0 | every box |
//! | tracker without a box | its last box stays | a miss | a miss |
//!
//! Boxes are continuous and 0-based here; in OTB's 1-based pixels x and y are larger by 1 and a center is
//! `x + (w - 1) / 2`, which cancels in both measures and counts only for the rules of the third row. In a frame
//! that a reset protocol skipped, or a replayed file had no box for, the tracker has no box.
//! A run that starts later than the sequence (a temporal restart) is scored from its start on.
//!
//! Sources: OTB toolkit `calcSeqErrRobust.m`, `perfPlot`; pysot-toolkit `success_overlap`, `success_error`;
//! got10k-toolkit `ExperimentOTB`, all read for their rules only.

use super::trajectory::{Trajectory, mean};
use crate::region::{Rect, Region};
use crate::tracker::Status;

/// Number of overlap thresholds, from 0 to 1.
pub const OVERLAPS: usize = 21;
/// Number of error thresholds, from 0 to 50 pixels.
pub const ERRORS: usize = 51;
/// The error threshold that trackers are compared at, in pixels.
pub const PRECISION_AT: usize = 20;

/// Rules of one evaluation program.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Rules {
    /// Name and version.
    pub name: &'static str,
    /// One line for `trackfail list`.
    pub summary: &'static str,
    /// Whether the first box is replaced by the annotation.
    replaces_first: bool,
    /// Whether frames without annotation are hits of the precision.
    absent_is_hit: bool,
    /// Whether a tracker without a box keeps its last one.
    keeps_box: bool,
    /// Which annotations count.
    counts: Annotated,
}

/// Which annotations count.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Annotated {
    /// Those that are positive in all four 1-based numbers.
    Positive,
    /// Those with a positive size and, for the error, with a positive 1-based center.
    PositiveCenter,
    /// All.
    All,
}

/// Every set of rules.
pub static RULES: &[Rules] = &[
    Rules {
        name: "otb-matlab/1",
        summary: "success AUC and precision@20 as the OTB toolkit computes them",
        replaces_first: true,
        absent_is_hit: true,
        keeps_box: true,
        counts: Annotated::Positive,
    },
    Rules {
        name: "pysot/1",
        summary: "success AUC and precision@20 as pysot-toolkit computes them",
        replaces_first: false,
        absent_is_hit: true,
        keeps_box: false,
        counts: Annotated::PositiveCenter,
    },
    Rules {
        name: "got10k/1",
        summary: "success AUC and precision@20 as got10k-toolkit computes them",
        replaces_first: true,
        absent_is_hit: false,
        keeps_box: false,
        counts: Annotated::All,
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

    /// Mean of several runs or sequences; `None` without any.
    pub fn mean<'c>(curves: impl IntoIterator<Item = &'c Self>) -> Option<Self> {
        let mut sum = Self { success: vec![0.0; OVERLAPS], precision: vec![0.0; ERRORS] };
        let mut count = 0;
        for c in curves {
            sum.success.iter_mut().zip(&c.success).for_each(|(s, v)| *s += v);
            sum.precision.iter_mut().zip(&c.precision).for_each(|(s, v)| *s += v);
            count += 1;
        }
        sum.success.iter_mut().chain(&mut sum.precision).for_each(|v| *v /= f64::from(count));
        (count > 0).then_some(sum)
    }
}

/// Overlap threshold number `i`, from 0. It is `i / 20` and not a sum of twentieths, as in the programs.
pub fn overlap_threshold(i: usize) -> f64 {
    i as f64 / (OVERLAPS - 1) as f64
}

/// Number of overlap thresholds below the overlap.
fn overlaps_below(overlap: f64) -> usize {
    // Rounding may put the product on the wrong side of a threshold; the threshold itself decides.
    let near = (overlap * (OVERLAPS - 1) as f64) as usize;
    let from = near.saturating_sub(1).min(OVERLAPS);
    from + (from..OVERLAPS).take_while(|i| overlap > overlap_threshold(*i)).count()
}

/// Number of error thresholds below the error, all of them for one that is not a number.
fn errors_below(error: f64) -> usize {
    if error <= (ERRORS - 1) as f64 { error.max(0.0).ceil() as usize } else { ERRORS }
}

fn iou(a: &Rect, b: &Rect) -> f64 {
    let inside = Region::Rect(*a).intersection(&Region::Rect(*b));
    let all = a.area() + b.area() - inside;
    if all > 0.0 { inside / all } else { 0.0 }
}

impl Rules {
    /// Success and precision of one run; all 0 for a run without frames.
    pub fn curves(&self, trajectory: &Trajectory<'_>) -> Curves {
        let started = trajectory.status.iter().position(|s| *s != Status::Waiting).unwrap_or(0);
        let boxes: Vec<Option<Rect>> = trajectory.regions[started..]
            .iter()
            .zip(&trajectory.status[started..])
            .map(|(r, s)| (!matches!(s, Status::Failed | Status::Skipped)).then(|| r.rect()))
            .collect();
        let truth: Vec<Option<Rect>> =
            trajectory.truth[started..].iter().map(|t| t.as_ref().map(Region::rect)).collect();
        self.of_boxes(&boxes, &truth)
    }

    /// Success and precision of plain boxes, `None` in frames without a box.
    pub fn of_boxes(&self, boxes: &[Option<Rect>], truth: &[Option<Rect>]) -> Curves {
        // How many frames pass exactly so many of the thresholds, which rise.
        let (mut success, mut precision) = ([0_u64; OVERLAPS + 1], [0_u64; ERRORS + 1]);
        let mut last = None;
        for (t, (reported, truth)) in boxes.iter().zip(truth).enumerate() {
            let mut tracked = *reported;
            if tracked.is_none() && self.keeps_box {
                tracked = last;
            }
            last = tracked;
            if t == 0 && self.replaces_first {
                tracked = *truth;
            }
            let (for_overlap, for_error) = self.annotated(truth.as_ref());
            let overlap = match (for_overlap, tracked) {
                (Some(truth), Some(tracked)) => iou(&tracked, &truth),
                _ => -1.0,
            };
            let error = match (for_error, tracked) {
                (None, _) if self.absent_is_hit => -1.0,
                (Some(truth), Some(tracked)) => {
                    let (a, b) = (tracked.center(), truth.center());
                    (a.0 - b.0).hypot(a.1 - b.1)
                }
                _ => f64::INFINITY,
            };
            success[overlaps_below(overlap)] += 1;
            precision[errors_below(error)] += 1;
        }
        let frames = boxes.len().max(1) as f64;
        // An overlap passes the thresholds below it, the first ones; an error those that are not below it, the last ones.
        let above = |i: usize| success[i + 1..].iter().sum::<u64>() as f64 / frames;
        let within = |e: usize| precision[..=e].iter().sum::<u64>() as f64 / frames;
        Curves { success: (0..OVERLAPS).map(above).collect(), precision: (0..ERRORS).map(within).collect() }
    }

    /// The annotation that counts for the overlap, and the one that counts for the error.
    fn annotated(&self, truth: Option<&Rect>) -> (Option<Rect>, Option<Rect>) {
        let Some(truth) = truth else { return (None, None) };
        let keep = |good: bool| good.then_some(*truth);
        match self.counts {
            Annotated::All => (keep(true), keep(true)),
            Annotated::Positive => {
                let good = truth.x + 1.0 > 0.0 && truth.y + 1.0 > 0.0;
                (keep(good), keep(good))
            }
            Annotated::PositiveCenter => {
                let (x, y) = truth.center();
                (keep(true), keep(x + 0.5 > 0.0 && y + 0.5 > 0.0))
            }
        }
    }
}

#[cfg(test)]
mod tests;
