//! Area under the ROC curve and average precision of scores that tell lost frames from good ones.
//!
//! ```text
//! AUROC = P(s_lost > s_good) + P(s_lost = s_good) / 2           a lost and a good frame drawn at random
//! AP    = sum over thresholds h, descending, of (R(h) - R(h')) P(h)              h' the next higher threshold
//! P(h)  = share of lost frames among those with s >= h           R(h) = share of the lost frames that have s >= h
//! ```
//!
//! `s` is the score, high is suspicious. Both lie in `[0, 1]`, high is good. A score without information has
//! an AUROC of 0.5, and its AP is the share of lost frames. Without lost frames both have no value; without
//! good frames AUROC has none. AP does not interpolate between thresholds, unlike the trapezoidal area.
//! Values are those of scikit-learn's `roc_auc_score` and `average_precision_score`.

use super::sweep::Sweep;

/// Area under the ROC curve. Ties count half.
pub fn auroc(sweep: &Sweep) -> Option<f64> {
    let (lost, good) = sweep.totals();
    let (mut above, mut twice) = (0_u64, 0_u64);
    for tie in sweep.ties() {
        let here = tie.iter().filter(|f| f.lost).count() as u64;
        twice += (tie.len() as u64 - here) * (2 * above + here);
        above += here;
    }
    (lost > 0 && good > 0).then(|| twice as f64 / (2.0 * lost as f64 * good as f64))
}

/// Average precision, the area under the precision-recall curve by steps.
pub fn average_precision(sweep: &Sweep) -> Option<f64> {
    let (lost, _) = sweep.totals();
    let (mut above, mut frames, mut sum) = (0_u64, 0_u64, 0.0);
    for tie in sweep.ties() {
        let here = tie.iter().filter(|f| f.lost).count() as u64;
        above += here;
        frames += tie.len() as u64;
        sum += here as f64 * (above as f64 / frames as f64);
    }
    (lost > 0).then(|| sum / lost as f64)
}

#[cfg(test)]
mod tests {
    use super::super::sweep::tests::{frames, scored, sweep};
    use super::*;
    use crate::score::testing::{oracle, value};
    use proptest::prelude::*;
    use serde_json::Value;
    use trackfail_testing::assert_near;

    // tests/oracles/frames.py, scikit-learn 1.9.1: roc_auc_score(lost, score), average_precision_score(lost, score).
    #[test]
    fn agree_with_scikit_learn() {
        for case in &oracle::<Vec<Value>>("ranking") {
            let swept = sweep(&scored(case));
            let found = [auroc(&swept), average_precision(&swept)].map(Option::unwrap);
            let theirs = ["auroc", "average_precision"].map(|name| value::<f64>(case, name));
            assert_near(found, theirs, 1e-14, "");
        }
    }

    // By hand: of 2 x 3 pairs 4 are in order and 1 ties; precision is 1 at the first lost frame, 2/4 at the second.
    #[test]
    fn by_hand() {
        let swept = sweep(&[(5.0, true), (4.0, false), (3.0, false), (3.0, true), (1.0, false)]);
        assert_eq!(auroc(&swept), Some(4.5 / 6.0));
        assert_eq!(average_precision(&swept), Some((1.0 + 0.5) / 2.0));
    }

    #[test]
    fn constant_scores_say_nothing() {
        let swept = sweep(&[(1.0, true), (1.0, false), (1.0, false), (1.0, false)]);
        assert_eq!((auroc(&swept), average_precision(&swept)), (Some(0.5), Some(0.25)));
        let good = sweep(&[(1.0, false)]);
        assert_eq!((auroc(&good), average_precision(&good)), (None, None));
        assert_eq!(auroc(&sweep(&[(1.0, true)])), None);
    }

    proptest! {
        #[test]
        fn negation_turns_auroc_round(frames in frames()) {
            let turned: Vec<_> = frames.iter().map(|f| (-f.0, f.1)).collect();
            let (one, other) = (auroc(&sweep(&frames)), auroc(&sweep(&turned)));
            prop_assert_eq!(one.is_some(), other.is_some());
            prop_assert!((one.unwrap_or(0.5) + other.unwrap_or(0.5) - 1.0).abs() < 1e-12);
        }

        #[test]
        fn only_the_order_of_scores_matters(frames in frames(), by in 0..60_usize) {
            let mut moved: Vec<_> = frames.iter().rev().map(|f| ((0.7 * f.0).exp() - 3.0, f.1)).collect();
            moved.rotate_left(by % frames.len().max(1));
            let (one, other) = (sweep(&frames), sweep(&moved));
            prop_assert_eq!(auroc(&one), auroc(&other));
            prop_assert_eq!(average_precision(&one), average_precision(&other));
        }
    }
}
