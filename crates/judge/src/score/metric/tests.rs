use super::*;
use crate::score::chance::Chance;
use crate::score::{Counts, FrameMeasures};

#[test]
fn names_are_unique_and_found() {
    for (k, metric) in METRICS.iter().enumerate() {
        assert!(METRICS[..k].iter().all(|other| other != metric), "{metric:?} twice");
        assert_eq!(Metric::from_name(metric.name), Some(*metric));
        assert!(!metric.heading.is_empty() && !metric.formula.is_empty(), "{metric:?}");
    }
    assert_eq!(Metric::from_name("no_such_metric"), None);
    assert!(Metric::unknown("f1").starts_with("unknown metric `f1`; did you mean `f_score` or"));
    assert_eq!(Metric::unknown("recal"), "unknown metric `recal`; did you mean `recall`?");
}

#[test]
fn every_formula_gives_the_number() {
    let counts = Counts { tp: 3, fp: 4, fn_: 5, tn: 60 };
    let pooled = Pooled { counts, ..Pooled::default() };
    assert_eq!(Metric::F_SCORE.filled(&pooled), "2 TP / (2 TP + FP + FN) = 6 / (6 + 4 + 5)");
    assert_eq!(Metric::F_SCORE.value(&pooled), Some(6.0 / 15.0));
    assert_eq!(Metric::FPR.filled(&pooled), "FP / (FP + TN) = 4 / (4 + 60)");
    assert_eq!(Metric::FPR.value(&pooled), Some(4.0 / 64.0));
    // Every quotient that a formula ends with is the value.
    for metric in METRICS.iter().filter(|m| m.kind == Kind::Ratio) {
        let filled = metric.filled(&pooled);
        let Some((numerator, denominator)) = filled.rsplit_once(" = ").and_then(|(_, q)| q.split_once(" / "))
        else {
            continue;
        };
        let number = |text: &str| -> f64 {
            let terms = |c| {
                move |t: &str| {
                    t.trim_matches(['(', ')', ' ']).split(c).map(str::to_string).collect::<Vec<_>>()
                }
            };
            let product =
                |t: String| terms('*')(&t).iter().map(|f| f.trim().parse::<f64>().unwrap()).product::<f64>();
            terms('+')(text).into_iter().map(product).sum()
        };
        let (value, expected) = (metric.value(&pooled).unwrap(), number(numerator) / number(denominator));
        assert!((value / expected - 1.0).abs() < 1e-12, "{filled}: {value}");
    }
}

#[test]
fn what_is_unknown_has_no_value() {
    let counts = Counts { tp: 3, fp: 4, fn_: 1, tn: 492 };
    let pooled = Pooled { counts, delay: Some(2.0), ..Pooled::default() };
    assert_eq!(Metric::DELAY_MEDIAN.value(&pooled), Some(2.0));
    assert_eq!(Metric::F_OVER_CHANCE.value(&pooled), None);
    assert_eq!(Metric::SCORE_MEAN.value(&pooled), None);
    let known = Pooled { chance: Some(Chance::within(5)), ..pooled };
    assert!(Metric::F_OVER_CHANCE.value(&known).is_some_and(|v| v < 1.0));
    assert!(Metric::F_OVER_CHANCE.filled(&known).starts_with("(F - F0) / (1 - F0); F = 6 / 11; F0 = 2 * "));
}

#[test]
fn metrics_of_frames_are_known_with_their_measures() {
    let mut measures = FrameMeasures::default();
    for (column, number) in [("auroc", 0.7), ("auroc_low", 0.6), ("auroc_high", 0.8)] {
        measures.set(column, Some(number));
    }
    let pooled = Pooled { frames: Some(measures), ..Pooled::default() };
    for metric in METRICS.iter().filter(|m| m.source == Source::Frames) {
        assert_eq!(metric.value(&Pooled::default()), None, "{metric:?}");
        assert_eq!(metric.value(&pooled).is_some(), metric.name == "auroc", "{metric:?}");
        assert_eq!(metric.interval(&pooled), (metric.name == "auroc").then_some((0.6, 0.8)), "{metric:?}");
    }
}
