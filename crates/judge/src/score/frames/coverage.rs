//! Risk-coverage curve: share of lost frames among those in which a detector is most confident of the track.
//!
//! ```text
//! frames by ascending failure score;  E(k) = lost frames among the first k of n,  coverage c(k) = k / n
//! risk r(k) = E(k) / k                                            generalized risk g(k) = E(k) / n = r(k) c(k)
//! AURC = trapezoidal area of r over c from c(1) to c(n), divided by 1 - 1 / n             AUGRC: the same of g
//! ```
//!
//! Both lie in `[0, 1]`, low is good; scores in random order have the share of lost frames as AURC. They need
//! two frames. Source: torch-uncertainty, `risk_coverage.py` (`AURC`, `AUGRC`; confidence is minus the
//! failure score). Deviation: there, frames of equal score are in the order of the sort. Here lost frames are
//! spread evenly over them, which gives the mean of g over all orders.

use super::sweep::Sweep;

/// AURC and AUGRC.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Areas {
    /// Area under the risk-coverage curve.
    pub aurc: f64,
    /// Area under the generalized risk-coverage curve.
    pub augrc: f64,
}

/// Coverage, risk and generalized risk after each frame.
pub fn curve(sweep: &Sweep) -> impl Iterator<Item = (f64, f64, f64)> {
    let frames = sweep.frames.len() as f64;
    let (mut before, mut errors) = (0.0, 0.0);
    sweep.ties().rev().flat_map(move |tie| {
        let share = tie.iter().filter(|f| f.lost).count() as f64 / tie.len() as f64;
        let (first, already) = (before, errors);
        before += tie.len() as f64;
        errors += share * tie.len() as f64;
        (1..=tie.len()).map(move |j| {
            let (k, errors) = (first + j as f64, already + share * j as f64);
            (k / frames, errors / k, errors / frames)
        })
    })
}

/// Areas under the curves; `None` with fewer than two frames.
pub fn areas(sweep: &Sweep) -> Option<Areas> {
    let frames = sweep.frames.len() as f64;
    let (mut aurc, mut augrc) = (0.0, 0.0);
    let mut before: Option<(f64, f64)> = None;
    for (_, risk, generalized) in curve(sweep) {
        if let Some((r, g)) = before {
            aurc += (r + risk) / 2.0;
            augrc += (g + generalized) / 2.0;
        }
        before = Some((risk, generalized));
    }
    // A step is 1 / n wide, and 1 / n / (1 - 1 / n) is 1 / (n - 1).
    (sweep.frames.len() > 1).then(|| Areas { aurc: aurc / (frames - 1.0), augrc: augrc / (frames - 1.0) })
}

#[cfg(test)]
mod tests {
    use super::super::sweep::tests::{frames, scored, sweep};
    use super::*;
    use crate::score::testing::{oracle, value};
    use proptest::prelude::*;
    use serde_json::Value;

    /// Checks both areas of some frames.
    fn near(frames: &[(f64, bool)], want: [f64; 2]) {
        let areas = areas(&sweep(frames)).unwrap();
        trackfail_testing::assert_near([areas.aurc, areas.augrc], want, 1e-13, "");
    }

    // torch-uncertainty's test of AUGRC and AURC: probabilities .1 .4 .7 against targets 0 1 1 are confidences .9 .6
    // .7, and the second is wrong. AURC is ((0 + 0) / 2 + (0 + 1/3) / 2) / 2 = .0833.
    #[test]
    fn the_example_of_three_samples() {
        near(&[(-0.9, false), (-0.6, true), (-0.7, false)], [1.0 / 12.0; 2]);
    }

    // By hand: the wrong sample first gives risks 1, 1/2, 1/3 and generalized risks 1/3.
    #[test]
    fn a_confident_error_costs_most() {
        near(&[(-0.9, true), (-0.6, false), (-0.7, false)], [(0.75 + 5.0 / 12.0) / 2.0, 1.0 / 3.0]);
        assert!(areas(&sweep(&[(-0.9, true)])).is_none());
    }

    // tests/oracles/frames.py: the equations of torch-uncertainty at 7df97be in NumPy 1.26.4, on cases without ties.
    #[test]
    fn agrees_with_torch_uncertainty() {
        for case in &oracle::<Vec<Value>>("coverage") {
            near(&scored(case), ["aurc", "augrc"].map(|name| value(case, name)));
        }
    }

    proptest! {
        // AUGRC is the mean share of pairs of frames: (1 - AUROC) p (1 - p) + p^2 / 2 for many frames (Traub et al.).
        #[test]
        fn equal_scores_have_the_share_of_lost_frames(lost in prop::collection::vec(any::<bool>(), 2..40)) {
            let frames: Vec<_> = lost.iter().map(|l| (1.0, *l)).collect();
            let share = lost.iter().filter(|l| **l).count() as f64 / lost.len() as f64;
            let areas = areas(&sweep(&frames)).unwrap();
            prop_assert!((areas.aurc - share).abs() < 1e-12);
        }

        #[test]
        fn the_last_point_is_the_share_of_lost_frames(frames in frames()) {
            let swept = sweep(&frames);
            let share = swept.totals().0 as f64 / frames.len() as f64;
            if let Some((coverage, risk, generalized)) = curve(&swept).last() {
                prop_assert!((coverage - 1.0).abs() < 1e-15);
                prop_assert!((risk - share).abs() < 1e-12 && (generalized - share).abs() < 1e-12);
            }
        }
    }
}
