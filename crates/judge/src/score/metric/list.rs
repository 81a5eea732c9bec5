//! List of the metrics of detectors.

use super::{Kind, Metric, Of, Source, Value};
use crate::direction::Direction::{self, HigherIsBetter, LowerIsBetter, Neither};
use crate::score::counts::Counts;
use crate::score::frames::list::FRAME_METRICS;
use crate::score::pooled::Pooled;

/// All metrics of detectors, by name: those of counts, scores and runs, then those of frames.
pub const METRICS: &[Metric] = &{
    let mut all = [OTHERS[0]; OTHERS.len() + FRAME_METRICS.len()];
    let mut k = 0;
    while k < all.len() {
        all[k] = if k < OTHERS.len() { OTHERS[k] } else { FRAME_METRICS[k - OTHERS.len()].metric };
        k += 1;
    }
    all
};

const OTHERS: &[Metric] = &[
    ratio("precision", "precision", HigherIsBetter, Counts::precision).with_formula("TP / (TP + FP)"),
    ratio("recall", "recall", HigherIsBetter, Counts::recall).with_formula("TP / (TP + FN)"),
    ratio("f_score", "F1 score", HigherIsBetter, Counts::f_score).with_formula("2 TP / (2 TP + FP + FN)"),
    ratio("fpr", "false positive rate", LowerIsBetter, Counts::fpr).with_formula("FP / (FP + TN)"),
    of_scores("score_mean", "mean normalized score", |p| Some(p.score?.0)),
    of_scores("score_std", "deviation of normalized scores", |p| Some(p.score?.1)),
    of_scores("score_mean_std", "normalized score", |p| Some(p.score?.0)).shown_as(Kind::MeanAndDeviation),
    count("tp", "true positives", HigherIsBetter, |c| Some(c.tp as f64)).with_unit("detections"),
    count("fp", "false positives", LowerIsBetter, |c| Some(c.fp as f64)).with_unit("detections"),
    count("fn", "false negatives", LowerIsBetter, |c| Some(c.fn_ as f64)).with_unit("events"),
    count("tn", "true negatives", Neither, |c| Some(c.tn as f64)).with_unit("frames"),
    count("events", "ground-truth events", Neither, |c| Some((c.tp + c.fn_) as f64))
        .with_unit("events")
        .with_formula("TP + FN"),
    count("detections", "detections", Neither, |c| Some((c.tp + c.fp) as f64))
        .with_unit("detections")
        .with_formula("TP + FP"),
    ratio("accuracy", "accuracy", HigherIsBetter, Counts::accuracy)
        .with_formula("(TP + TN) / (TP + FP + FN + TN)"),
    ratio("informedness", "informedness (Youden's J)", HigherIsBetter, Counts::informedness)
        .shown_as(Kind::Real)
        .with_formula("TP / (TP + FN) - FP / (FP + TN)"),
    of_reverse_runs("reverse_runs", "runs backwards in time", |p| Some(p.effort?.runs as f64))
        .with_unit("runs"),
    of_reverse_runs("reverse_frames", "frames of all runs backwards", |p| Some(p.effort?.frames as f64))
        .with_unit("frames"),
    Metric::new("f_by_chance", "F1 by chance", Neither, (Kind::Ratio, Source::Counts), BY_CHANCE)
        .with_formula("2 TP0 / (2 TP + FP + FN)"),
    Metric::new("f_over_chance", "F1 over chance", HigherIsBetter, (Kind::Real, Source::Counts), OVER_CHANCE)
        .with_formula("(F - F0) / (1 - F0)"),
    ratio("miss_rate", "miss rate", LowerIsBetter, Counts::miss_rate).with_formula("FN / (TP + FN)"),
    ratio("false_alarms_per_1000", "false alarms per 1000 frames", LowerIsBetter, |c| c.per_1000(c.fp))
        .with_unit("per 1000 frames")
        .with_formula("1000 FP / (TP + FP + FN + TN)"),
    ratio("detections_per_1000", "detections per 1000 frames", Neither, |c| c.per_1000(c.tp + c.fp))
        .with_unit("per 1000 frames")
        .with_formula("(1000 TP + 1000 FP) / (TP + FP + FN + TN)"),
    ratio("events_per_1000", "events per 1000 frames", Neither, |c| c.per_1000(c.tp + c.fn_))
        .with_unit("per 1000 frames")
        .with_formula("(1000 TP + 1000 FN) / (TP + FP + FN + TN)"),
    Metric::new("delay_median", "median delay", Neither, (Kind::Real, Source::Delays), DELAY)
        .with_unit("frames")
        .with_formula("median over the matched detections of their frame less that of the event"),
];

const BY_CHANCE: Value = Value::Noted(
    |p| p.chance?.expected_f1(&p.counts),
    |p| format!("; TP0 = {:.2}, the {}", expected(p), at_random(p)),
);

const OVER_CHANCE: Value = Value::Noted(
    |p| p.chance?.f_over_chance(&p.counts),
    |p| {
        let (twice, both, hits) =
            (2 * p.counts.tp, 2 * p.counts.tp + p.counts.fp + p.counts.fn_, expected(p));
        format!("; F = {twice} / {both}; F0 = 2 * {hits:.2} / {both}, with the {}", at_random(p))
    },
);

const DELAY: Value = Value::Noted(|p| p.delay, |p| format!("; {} detections are matched", p.counts.tp));

/// Expected true positives of the same number of random detections; NaN for an unknown protocol.
fn expected(pooled: &Pooled) -> f64 {
    pooled.chance.map_or(f64::NAN, |chance| chance.expected_true_positives(&pooled.counts))
}

fn at_random(pooled: &Pooled) -> String {
    format!("true positives expected of {} detections at random", pooled.counts.tp + pooled.counts.fp)
}

/// A ratio of counts.
const fn ratio(name: &'static str, heading: &'static str, direction: Direction, of: Of<Counts>) -> Metric {
    Metric::new(name, heading, direction, (Kind::Ratio, Source::Counts), Value::Counts(of))
}

/// A count, pooled by sum unless the formula says otherwise.
const fn count(name: &'static str, heading: &'static str, direction: Direction, of: Of<Counts>) -> Metric {
    Metric::new(name, heading, direction, (Kind::Count, Source::Counts), Value::Counts(of))
        .with_formula("sum over sequences and runs")
}

/// A metric of the normalized scores.
const fn of_scores(name: &'static str, heading: &'static str, of: Of<Pooled>) -> Metric {
    Metric::new(name, heading, Neither, (Kind::Real, Source::Scores), Value::Pooled(of)).with_formula(
        "mean and standard deviation of the scores of all frames, each run's brought to 0..1 by its own minimum \
         and maximum; runs of constant score are left out",
    )
}

/// A metric of the runs backwards in time.
const fn of_reverse_runs(name: &'static str, heading: &'static str, of: Of<Pooled>) -> Metric {
    Metric::new(name, heading, LowerIsBetter, (Kind::Count, Source::Effort), Value::Pooled(of)).with_formula(
        "sum over sequences and runs; counted while the tracker was run backwards, see checks.csv",
    )
}
