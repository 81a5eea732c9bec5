use super::*;
use crate::detector::track_quality::Effort;
use crate::score::chance::Chance;
use crate::score::frames::list::FRAME_METRICS;
use crate::score::{Counts, FrameMeasures, TRACKER_METRICS, TrackerMetric};

#[test]
fn names_are_unique_and_found() {
    for (k, metric) in METRICS.iter().enumerate() {
        assert!(METRICS[..k].iter().all(|other| other != metric), "{metric:?} twice");
        assert_eq!(Metric::from_name(metric.name), Some(*metric));
        assert!(!metric.heading.is_empty() && !metric.formula.is_empty(), "{metric:?}");
    }
    assert_eq!(Metric::from_name("no_such_metric"), None);
    let named = |m: &TrackerMetric| TrackerMetric::of_heading(m.heading) == Some(*m);
    assert!(TRACKER_METRICS.iter().all(named) && TrackerMetric::of_heading("none").is_none());
    assert_eq!(Metric::F_SCORE.title() + &Metric::FPR.title(), "F1 scoreFalse positive rate");
    let of = |name: &str| Metric::from_name(name).unwrap();
    let is =
        ["tp", "delay_median", "auroc"].map(of).map(|m| (m.is_count(), m.is_of_counts(), m.is_of_frames()));
    assert_eq!(of("tp").filled(&Pooled::default()), "sum over sequences and runs");
    assert_eq!(is, [(true, true, false), (false, true, false), (false, false, true)]);
    assert!(Metric::unknown("f1").starts_with("unknown metric `f1`; did you mean `f_score` or"));
    assert_eq!(Metric::unknown("recal"), "unknown metric `recal`; did you mean `recall`?");
}

#[test]
fn every_formula_gives_the_number() {
    let counts = Counts { tp: 3, fp: 4, fn_: 5, tn: 60 };
    let pooled = Pooled { counts, ..Pooled::default() };
    assert_eq!(Metric::F_SCORE.filled(&pooled), "2 TP / (2 TP + FP + FN) = 6 / (6 + 4 + 5)");
    assert_eq!(Metric::FPR.filled(&pooled), "FP / (FP + TN) = 4 / (4 + 60)");
    // Every quotient that a formula ends with is the value.
    for metric in METRICS.iter().filter(|m| m.kind == Kind::Ratio) {
        let filled = metric.filled(&pooled);
        let quotient = filled.rsplit_once(" = ").and_then(|(_, quotient)| quotient.split_once(" / "));
        let Some((numerator, denominator)) = quotient else { continue };
        let number = |text: &str| -> f64 {
            let factors = |term: &str| -> Vec<f64> {
                term.trim_matches(['(', ')', ' ']).split('*').map(|f| f.trim().parse().unwrap()).collect()
            };
            text.split('+').map(|term| factors(term).iter().product::<f64>()).sum()
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
    // scipy.stats.hypergeom(500, 7, 11).sf(0) * 4 = 0.580
    let filled = "(F - F0) / (1 - F0); F = 6 / 11; F0 = 2 * 0.58 / 11, with the true positives expected of 7 detections \
                  at random";
    assert_eq!(Metric::F_OVER_CHANCE.filled(&known), filled);
}

// By hand. 7 detections in 72 frames hit a frame by chance with 7 / 72, and 8 events 56 / 72 times.
#[test]
fn every_metric_reads_its_own_number() {
    let mut measures = FrameMeasures::default();
    for (measure, k) in FRAME_METRICS.iter().zip(1..) {
        for (end, more) in [("", 0.0), ("_low", -0.25), ("_high", 0.5)] {
            measures.set(&format!("{}{end}", measure.metric.name), Some(f64::from(k) + more));
        }
    }
    let pooled = Pooled {
        counts: Counts { tp: 3, fp: 4, fn_: 5, tn: 60 },
        score: Some((0.5, 0.125)),
        effort: Some(Effort { runs: 9, frames: 90 }),
        chance: Some(Chance::after(0)),
        delay: Some(2.5),
        frames: Some(measures),
    };
    let (f, by_chance) = (6.0 / 15.0, 2.0 * (56.0 / 72.0) / 15.0);
    let of_counts = [
        ("precision", 3.0 / 7.0),
        ("recall", 3.0 / 8.0),
        ("f_score", f),
        ("fpr", 4.0 / 64.0),
        ("score_mean", 0.5),
        ("score_std", 0.125),
        ("score_mean_std", 0.5),
        ("tp", 3.0),
        ("fp", 4.0),
        ("fn", 5.0),
        ("tn", 60.0),
        ("events", 8.0),
        ("detections", 7.0),
        ("accuracy", 63.0 / 72.0),
        ("informedness", 3.0 / 8.0 - 4.0 / 64.0),
        ("reverse_runs", 9.0),
        ("reverse_frames", 90.0),
        ("f_by_chance", by_chance),
        ("f_over_chance", (f - by_chance) / (1.0 - by_chance)),
        ("miss_rate", 5.0 / 8.0),
        ("false_alarms_per_1000", 4000.0 / 72.0),
        ("detections_per_1000", 7000.0 / 72.0),
        ("events_per_1000", 8000.0 / 72.0),
        ("delay_median", 2.5),
    ];
    assert_eq!(METRICS.len(), of_counts.len() + FRAME_METRICS.len());
    for (metric, (name, expected)) in METRICS.iter().zip(of_counts) {
        let value = metric.value(&pooled).unwrap();
        assert!(metric.name == name && (value - expected).abs() < 1e-12, "{name}: {value}, not {expected}");
        assert_eq!(metric.interval(&pooled), None, "{name}");
    }
    for ((metric, measure), k) in METRICS[of_counts.len()..].iter().zip(FRAME_METRICS).zip(1..) {
        let number = f64::from(k);
        assert_eq!((metric.name, metric.source), (measure.metric.name, Source::Frames));
        let values = [&pooled, &Pooled::default()].map(|pooled| metric.value(pooled));
        assert_eq!(values, [Some(number), None], "{metric:?}");
        let bounds = measure.bounds.map(|_| (number - 0.25, number + 0.5));
        assert_eq!(metric.interval(&pooled), bounds, "{metric:?}");
    }
}

#[test]
fn the_tables_of_the_metrics_page_are_those_of_the_lists() {
    let file = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/metrics.md");
    let better = |direction: Direction| match direction {
        Direction::HigherIsBetter => "higher",
        Direction::LowerIsBetter => "lower",
        Direction::Neither => "",
    };
    let kind = |kind: Kind| match kind {
        Kind::Count => "count",
        Kind::Ratio => "ratio",
        Kind::Real => "number",
        Kind::MeanAndDeviation => "mean±deviation",
    };
    let of_detectors = METRICS.iter().map(|m| {
        let (kind, better) = (kind(m.kind), better(m.direction));
        format!("| `{}` | {} | {kind} | {} | {better} | {} |\n", m.name, m.heading, m.unit, m.formula)
    });
    let of_trackers = TRACKER_METRICS.iter().map(|m| {
        let better = better(m.direction);
        format!("| `{}` | {} | {} | {better} | {} |\n", m.name, m.heading, m.unit, m.formula)
    });
    let mut page = String::new();
    for line in std::fs::read_to_string(&file).unwrap().lines().filter(|line| !line.starts_with("| `")) {
        page = page + line + "\n";
        match line {
            "|---|---|---|---|---|---|" => page.extend(of_detectors.clone()),
            "|---|---|---|---|---|" => page.extend(of_trackers.clone()),
            _ => {}
        }
    }
    let tables = of_detectors.collect::<String>() + &of_trackers.collect::<String>();
    assert!(page.lines().filter(|line| line.starts_with("| `")).eq(tables.lines()), "a table is not there");
    if std::env::var_os("UPDATE").is_some() {
        std::fs::write(&file, &page).unwrap();
    }
    assert!(std::fs::read_to_string(&file).unwrap() == page, "docs/metrics.md: run with UPDATE=1");
}
