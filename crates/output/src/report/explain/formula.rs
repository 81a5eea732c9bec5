//! How metrics come about from counts, in a line.

use crate::score::Protocol;
use crate::score::measures::{Counts, Metric};

/// How a metric comes about, with the counts filled in.
pub fn formula(metric: Metric, counts: Counts, protocol: Option<&Protocol>) -> String {
    let Counts { tp, fp, fn_, tn } = counts;
    match metric {
        Metric::Precision => format!("TP / (TP + FP) = {tp} / ({tp} + {fp})"),
        Metric::Recall => format!("TP / (TP + FN) = {tp} / ({tp} + {fn_})"),
        Metric::FScore => format!("2 TP / (2 TP + FP + FN) = {} / ({} + {fp} + {fn_})", 2 * tp, 2 * tp),
        Metric::Fpr => format!("FP / (FP + TN) = {fp} / ({fp} + {tn})"),
        Metric::Accuracy => {
            format!("(TP + TN) / (TP + FP + FN + TN) = ({tp} + {tn}) / ({tp} + {fp} + {fn_} + {tn})")
        }
        Metric::Informedness => {
            format!("TP / (TP + FN) - FP / (FP + TN) = {tp} / ({tp} + {fn_}) - {fp} / ({fp} + {tn})")
        }
        Metric::FByChance => format!(
            "2 TP0 / (2 TP + FP + FN); TP0 = {:.2}, the true positives expected of {} detections at random",
            protocol.map_or(f64::NAN, |p| p.chance.true_positives(&counts)),
            tp + fp
        ),
        Metric::FOverChance => {
            let by_chance = protocol.map_or(f64::NAN, |p| p.chance.true_positives(&counts));
            let both = 2 * tp + fp + fn_;
            format!(
                "(F - F0) / (1 - F0); F = {} / {both}; F0 = 2 * {by_chance:.2} / {both}, with the true positives \
                 expected of {} detections at random",
                2 * tp,
                tp + fp
            )
        }
        Metric::MissRate => format!("FN / (TP + FN) = {fn_} / ({tp} + {fn_})"),
        Metric::FalseAlarms => {
            format!("1000 FP / (TP + FP + FN + TN) = 1000 * {fp} / ({tp} + {fp} + {fn_} + {tn})")
        }
        Metric::DelayMedian => {
            format!("median over the {tp} matched detections of their frame less that of the event")
        }
        Metric::Events => format!("TP + FN = {tp} + {fn_}"),
        Metric::Detections => format!("TP + FP = {tp} + {fp}"),
        Metric::Tp | Metric::Fp | Metric::Fn | Metric::Tn => "sum over sequences and runs".to_string(),
        Metric::ScoreMean | Metric::ScoreStd | Metric::ScoreMeanStd => {
            "mean and standard deviation of the scores of all frames, each run's brought to 0..1 by its own \
             minimum and maximum; runs of constant score are left out"
                .to_string()
        }
        Metric::ReverseRuns | Metric::ReverseFrames => {
            "sum over sequences and runs; counted while the tracker was run backwards, see checks.csv"
                .to_string()
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::direction::Direction;
    use crate::score::measures::Pooled;

    #[test]
    fn every_formula_gives_the_number() {
        let counts = Counts { tp: 3, fp: 4, fn_: 5, tn: 60 };
        let pooled = Pooled { counts, ..Pooled::default() };
        assert_eq!(formula(Metric::FScore, counts, None), "2 TP / (2 TP + FP + FN) = 6 / (6 + 4 + 5)");
        assert_eq!(pooled.value(Metric::FScore), Some(6.0 / 15.0));
        assert_eq!(formula(Metric::Fpr, counts, None), "FP / (FP + TN) = 4 / (4 + 60)");
        assert_eq!(pooled.value(Metric::Fpr), Some(4.0 / 64.0));
        // Every metric with a direction says how it is made.
        let metrics = Metric::names().filter_map(Metric::from_name);
        assert!(
            metrics
                .filter(|m| m.direction() != Direction::Neither)
                .all(|m| !formula(m, counts, None).is_empty())
        );
    }
}
