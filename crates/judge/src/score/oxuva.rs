//! True positive and true negative rate of long-term tracking (OxUvA: Valmadre et al., "Long-term tracking in the wild: a
//! benchmark", ECCV 2018; oxuva/long-term-tracking-benchmark, `python/oxuva/assess.py` at 0137356).
//!
//! ```text
//! TPR = frames with target, said to be present, overlap >= 1/2 / frames with target
//! TNR = frames without target, said to be absent / frames without target
//! GM = sqrt(TPR TNR)           MaxGM = max over p in [0, 1] of sqrt((1 - p) TPR ((1 - p) TNR + p))
//! ```
//!
//! Overlap is intersection over union; all numbers lie in `[0, 1]`, high is good. MaxGM is the best value
//! reached by reporting absence at random with probability p; it is for trackers that never report absence.
//! Counts are summed over all frames of all tracks.

use super::counts::{Counts, Place, ratio};

/// Overlap from which on a target counts as found.
pub const OVERLAP: f64 = 0.5;

/// Rates computed from the counts.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Rates {
    /// True positive rate.
    pub tpr: f64,
    /// True negative rate.
    pub tnr: f64,
    /// Geometric mean of both rates.
    pub gm: f64,
    /// Largest geometric mean with absences reported at random.
    pub max_gm: f64,
}

/// Count of a frame, which is positive if it has a target. `overlap` is that with the target, or `None` without target;
/// `says_present` is true if the tracker reports the target as present.
pub fn place(overlap: Option<f64>, says_present: bool) -> Place {
    Place::of(overlap.is_some(), says_present && overlap.is_none_or(|o| o >= OVERLAP))
}

impl Rates {
    /// Rates of counted frames; `None` without frames with target, or without frames without target.
    pub fn of(counts: &Counts) -> Option<Self> {
        let (tpr, tnr) = (counts.recall()?, ratio(counts.tn, counts.tn + counts.fp)?);
        let gm = |p: f64| ((1.0 - p) * tpr * ((1.0 - p) * tnr + p)).sqrt();
        // The derivative of (1 - p) ((1 - p) TNR + p) is 0 there; the ends are candidates, too.
        let peak = (1.0 - 2.0 * tnr) / (2.0 * (1.0 - tnr));
        let max_gm = if (0.0..=1.0).contains(&peak) { gm(peak).max(gm(0.0)) } else { gm(0.0) };
        Some(Self { tpr, tnr, gm: gm(0.0), max_gm })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use trackfail_testing::assert_near;

    // assess.py at 0137356, quality_metrics({"TP": tp, "FN": fn, "TN": tn, "FP": fp}): its equations in Python 3.11.
    #[test]
    fn agrees_with_the_benchmark() {
        let rates = |tp, fn_, tn, fp| Rates::of(&Counts { tp, fp, fn_, tn }).unwrap();
        let near = |r: Rates, want: [f64; 4]| assert_near([r.tpr, r.tnr, r.gm, r.max_gm], want, 1e-12, "");
        // p = 4/9: sqrt(5/9 3/4 (1/18 + 4/9)) = sqrt(5/24).
        near(rates(30, 10, 1, 9), [0.75, 0.1, 0.075_f64.sqrt(), (5.0_f64 / 24.0).sqrt()]);
        // A tracker that never says absent has half of the root of its TPR.
        near(rates(16, 9, 0, 5), [0.64, 0.0, 0.0, 0.4]);
        near(rates(9, 1, 9, 1), [0.9; 4]);
        assert_eq!(Rates::of(&Counts { tp: 3, ..Counts::default() }), None);
    }

    #[test]
    fn frames_by_hand() {
        let of = |overlap: Option<f64>| [true, false].map(|says_present| place(overlap, says_present).name());
        let found = [Some(0.5), Some(0.9), Some(0.49), None].map(of);
        assert_eq!(found, [["tp", "fn"], ["tp", "fn"], ["fn", "fn"], ["fp", "tn"]]);
    }

    proptest! {
        // The second way: the largest of many probabilities.
        #[test]
        fn max_gm_is_the_largest(tp in 0..40_u64, fn_ in 1..40_u64, tn in 0..40_u64, fp in 0..40_u64) {
            let r = Rates::of(&Counts { tp, fp: fp + u64::from(tn == 0), fn_, tn }).unwrap();
            let gm = |k: i32| {
                let p = f64::from(k) / 1000.0;
                ((1.0 - p) * r.tpr * ((1.0 - p) * r.tnr + p)).sqrt()
            };
            let most = (0..=1000).map(gm).fold(0.0, f64::max);
            prop_assert!(r.max_gm >= most - 1e-12 && r.max_gm <= most + 1e-4);
            prop_assert!(r.max_gm >= r.gm);
        }
    }
}
