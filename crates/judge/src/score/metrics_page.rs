//! The page of the docs that lists all metrics, made from the lists.

use super::metric::{Kind, METRICS};
use super::tracker_metric::TRACKER_METRICS;
use crate::direction::Direction;

const HEAD: &str = "\
# Metrics

Made from `crates/judge/src/score/metric/list.rs` and `tracker_metric.rs`; a test compares this page with them
(`UPDATE=1 cargo test -p trackfail-judge metrics_page` writes it again).

## Detectors

TP, FP, FN and TN are counted by the protocol, summed over sequences and runs, and only then made into ratios. A ratio
whose denominator is 0 has no value: its cell is empty. F is the F1 score, TP0 the number of true positives expected of
as many detections at random, and F0 the F1 score that follows from it.

Metrics from `auroc` on are made of the score and the alarm of every frame, whatever the protocol: of all frames of the suite
together, and with an interval of 95 % from a bootstrap over sequences for most of them. An experiment has them in
`frame_measures.csv`. Those from `auroc_within_5` to `auroc_within_30` ask for a warning before the loss, from frames in which
the tracker is still on target.

";

const WITHOUT_BOX: &str = "
### Frames without a box

What a frame counts as that has no box of the tracker. A result file has none where a line is empty, has NaN or has no area;
`without_area` of `replay` says what that means. A box of four zeros is none to any rule.

| frame | `otb-matlab/1`, `lasot/1` | `got10k/1`, `pysot/1`, `pysot-toolkit/1`, `average-overlap` | `longterm/...` | `oxuva/1` | `resets` | error O, which detectors are judged by |
|---|---|---|---|---|---|---|
| the tracker says that the target is absent; no box and `without_area = \"absent\"` | the last box | a miss | overlap 0 | said to be absent | overlap 0 | 1 |
| no box and `without_area = \"repeat\"` | the last box | the last box | the last box | the last box | the last box | that of the last box |
| failed or skipped by a reset protocol (`2` and `0` in VOT's files); not asked for in OxUvA's | the last box | a miss | overlap 0 | overlap 0, said to be present | a failure, or in no mean | 1 |
| before the tracker's start | left out | left out | left out | left out | in no mean | left out |
| no confidence, where it is the signal | | | confidence 0 | confidence 0 | | |
| no ground truth | a miss; by `otb-matlab/1` a hit of the precision | a miss; by pysot's two a hit of the precision; left out of `average-overlap` | no target | no target | in no mean | left out |
";

const INTERVALS: &str = "
## Intervals and tests

Bounds are 95 % intervals by bootstrap over sequences: 5000 samples for counts, the same for all numbers of a page, and up to 1000
for measures of frames. Pairs are compared by a two-sided permutation test that exchanges the numbers of the two within
sequences: all patterns of up to 16 sequences that differ, else 5000 random ones. Holm's correction is for all pairs of a
group; of more than 12 methods, the best is tested against each of the others. Mean ranks are means over sequences, with
Friedman's test and Nemenyi's critical difference. In a leaderboard `first` and `keeps rank` are shares of the bootstrap
samples; equal methods share a rank, and anchors have none.
";

fn better(direction: Direction) -> &'static str {
    match direction {
        Direction::HigherIsBetter => "higher",
        Direction::LowerIsBetter => "lower",
        Direction::Neither => "",
    }
}

fn kind(kind: Kind) -> &'static str {
    match kind {
        Kind::Count => "count",
        Kind::Ratio => "ratio",
        Kind::Real => "number",
        Kind::MeanAndDeviation => "mean±deviation",
    }
}

/// `docs/metrics.md`: a table of the metrics of detectors and one of those of trackers, in Markdown.
pub fn metrics_page() -> String {
    let mut page = HEAD.to_string();
    page += "| name | what | kind | unit | better | formula |\n|---|---|---|---|---|---|\n";
    for m in METRICS {
        let (name, heading, unit, formula) = (m.name(), m.heading(), m.unit(), m.formula());
        let (kind, better) = (kind(m.kind()), better(m.direction()));
        page += &format!("| `{name}` | {heading} | {kind} | {unit} | {better} | {formula} |\n");
    }
    page += "\n## Trackers\n\nMade by the analyses `success`, `average-overlap`, `resets`, `longterm` and `oxuva`.\n\n";
    page += "| name | heading | unit | better | what |\n|---|---|---|---|---|\n";
    for m in TRACKER_METRICS {
        let better = better(m.direction);
        page += &format!("| `{}` | {} | {} | {better} | {} |\n", m.name, m.heading, m.unit, m.formula);
    }
    page + WITHOUT_BOX + INTERVALS
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_metrics_page_of_the_docs_is_that_of_the_lists() {
        let file = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/metrics.md");
        if std::env::var_os("UPDATE").is_some() {
            std::fs::write(&file, metrics_page()).unwrap();
        }
        let written = std::fs::read_to_string(&file).unwrap();
        assert!(
            written == metrics_page(),
            "docs/metrics.md is not what the lists of metrics say: run with UPDATE=1"
        );
    }
}
