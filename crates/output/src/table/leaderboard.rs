//! Methods in order of a measure, and how sure their ranks are.
//!
//! The order is that of the measure pooled over all sequences. How much it hangs on which sequences a suite has
//! is told by bootstrap over sequences: as many as there are, drawn with replacement, all runs of a sequence
//! together and the same draw for all methods; the measure is made anew of the summed counts. `first` is the
//! share of draws in which a method has rank 1, `keeps rank` the share in which it has the rank of the table.
//!
//! A rank is 1 plus the number of methods that are better, so equal methods share theirs, and both are first.
//! Where the counts of a draw give no value (precision without a detection), the method is behind all that have
//! one. Anchors stand where their value puts them, but have no rank and take none from others.
//!
//! Seed: that of the experiment with the names of table and tracker.

use super::layout::{Cell, Group, Row, TableLayout, is_anchor};
use super::number::Style;
use crate::direction::Direction;
use crate::num::seed;
use crate::results::Measure;
use crate::results::{CellScore, method_label};
use crate::score::chance::Chance;
use crate::score::{Counts, Metric, Pooled};
use crate::spec::table::Table;
use crate::spec::{Experiment, TEST};
use rand::RngExt;
use std::cmp::Ordering;
use std::collections::BTreeMap;

/// Bootstrap samples, and random patterns of a test that cannot look at all: a share is sure to about 0.005.
pub const DRAWS: usize = 10_000;
/// On fewer sequences there is nothing to draw from.
pub const FEWEST: usize = 3;

/// One method of a leaderboard.
struct Candidate {
    label: String,
    is_anchor: bool,
    value: Option<f64>,
    /// One for each sequence.
    counts: Vec<Counts>,
    chance: Option<Chance>,
}

/// How sure a rank is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Stability {
    /// The rank on all sequences.
    pub rank: usize,
    /// Share of draws with rank 1.
    pub first: f64,
    /// Share of draws with the rank on all sequences.
    pub keeps: f64,
}

/// A method as it is drawn: its counts on every sequence, and how its protocol matches by chance.
type Drawn<'a> = (&'a [Counts], Option<Chance>);

fn value(counts: Counts, chance: Option<Chance>, metric: Metric) -> Option<f64> {
    metric.value(&Pooled { counts, chance, ..Pooled::default() })
}

/// Better ones come first; a value is better than none.
fn compare(a: Option<f64>, b: Option<f64>, metric: Metric) -> Ordering {
    let order = match (a, b) {
        (Some(a), Some(b)) => a.total_cmp(&b),
        (a, b) => return b.is_some().cmp(&a.is_some()),
    };
    if metric.direction() == Direction::LowerIsBetter { order } else { order.reverse() }
}

/// The rank of each value.
fn ranks(values: &[Option<f64>], metric: Metric) -> Vec<usize> {
    let better = |v: &Option<f64>| values.iter().filter(|w| compare(**w, *v, metric).is_lt()).count();
    values.iter().map(|v| 1 + better(v)).collect()
}

/// The ranks of methods with these counts, a list with one for each sequence for every method, and how often
/// `draws` bootstrap samples give the same.
fn stability(methods: &[Drawn<'_>], metric: Metric, draws: usize, seed: u64) -> Vec<Stability> {
    let all: Vec<Option<f64>> =
        methods.iter().map(|(c, chance)| value(c.iter().copied().sum(), *chance, metric)).collect();
    let on_all = ranks(&all, metric);
    let sequences = methods.first().map_or(0, |(c, _)| c.len());
    let (mut first, mut keeps) = (vec![0_usize; methods.len()], vec![0_usize; methods.len()]);
    let mut rng = seed::rng(seed);
    for _ in 0..draws {
        let drawn: Vec<usize> = (0..sequences).map(|_| rng.random_range(0..sequences)).collect();
        let sum =
            |(counts, chance): &Drawn<'_>| value(drawn.iter().map(|k| counts[*k]).sum(), *chance, metric);
        let values: Vec<Option<f64>> = methods.iter().map(sum).collect();
        for (k, rank) in ranks(&values, metric).into_iter().enumerate() {
            first[k] += usize::from(rank == 1);
            keeps[k] += usize::from(rank == on_all[k]);
        }
    }
    let share = |n: usize| n as f64 / draws.max(1) as f64;
    let of = |(k, rank): (usize, usize)| Stability { rank, first: share(first[k]), keeps: share(keeps[k]) };
    on_all.into_iter().enumerate().map(of).collect()
}

/// The methods of a tracker with their counts, in the order of the experiment.
fn candidates(
    experiment: &Experiment,
    table: &Table,
    metric: Metric,
    measures: &[Measure],
    scores: &[CellScore],
    tracker: &str,
) -> Vec<Candidate> {
    let shown = |m: &&Measure| {
        m.tracker == tracker && m.attribute.is_none() && table.methods.contains(&m.method) && m.done > 0
    };
    let shown: Vec<&Measure> = measures.iter().filter(shown).collect();
    // One place for each sequence on which any of them has a result, by name.
    let mut places: BTreeMap<&str, usize> = BTreeMap::new();
    let mut mine: BTreeMap<(&str, &str), Vec<&CellScore>> = BTreeMap::new();
    for s in scores.iter().filter(|s| s.tracker == tracker && table.methods.contains(&s.method)) {
        places.insert(&s.sequence, 0);
        mine.entry((&s.method, &s.params)).or_default().push(s);
    }
    places.values_mut().enumerate().for_each(|(k, place)| *place = k);
    let candidate = |m: &&Measure| {
        let mut counts = vec![Counts::default(); places.len()];
        for s in mine.get(&(m.method.as_str(), m.params.as_str())).into_iter().flatten() {
            let sum = &mut counts[places[s.sequence.as_str()]];
            *sum = [*sum, s.counts].into_iter().sum();
        }
        Candidate {
            label: method_label(&m.method, &m.params),
            is_anchor: is_anchor(experiment, &m.method),
            value: m.value(metric),
            counts,
            chance: m.pooled.chance,
        }
    };
    shown.iter().map(candidate).collect()
}

/// Makes the table of a `rank`, a group for each tracker.
pub fn leaderboard(
    experiment: &Experiment,
    table: &Table,
    measures: &[Measure],
    scores: &[CellScore],
    data_note: &str,
) -> TableLayout {
    let metric = table.ranked.unwrap_or(Metric::F_SCORE);
    let mut groups = Vec::new();
    for tracker in experiment.trackers.iter().map(|t| t.label.as_str()) {
        let mut all = candidates(experiment, table, metric, measures, scores, tracker);
        if all.is_empty() {
            continue;
        }
        // Equal ones stay in the order of the experiment.
        all.sort_by(|a, b| compare(a.value, b.value, metric));
        let ranked: Vec<Drawn<'_>> =
            all.iter().filter(|c| !c.is_anchor).map(|c| (c.counts.as_slice(), c.chance)).collect();
        let enough = all[0].counts.len() >= FEWEST;
        let seed = seed::seed(experiment.seed, &["leaderboard", &table.name, tracker]);
        let mut sure = stability(&ranked, metric, if enough { DRAWS } else { 0 }, seed).into_iter();
        let rows = all.iter().map(|c| {
            let sure = if c.is_anchor { None } else { sure.next() };
            let cells = [
                (sure.map(|s| s.rank as f64), Style::COUNT),
                (c.value, Style::of_metric(metric)),
                (sure.filter(|_| enough).map(|s| s.first), Style::DEFAULT),
                (sure.filter(|_| enough).map(|s| s.keeps), Style::DEFAULT),
            ];
            let cell = |(value, style): (Option<f64>, Style)| Cell {
                value,
                ours: value.map(|v| style.format(v)),
                ..Cell::default()
            };
            Row { label: c.label.clone(), direction: Direction::Neither, cells: cells.map(cell).into() }
        });
        groups.push(Group {
            label: format!("{tracker} ({} sequences)", all[0].counts.len()),
            key: tracker.to_string(),
            published_tracker: None,
            has_ours: true,
            rows: rows.collect(),
        });
    }
    let mut caption = table.caption.clone().unwrap_or_else(|| experiment.title.clone());
    if !caption.ends_with('.') {
        caption.push('.');
    }
    let suite = &experiment.suites[TEST];
    let name = metric.name();
    TableLayout {
        name: table.name.clone(),
        caption: format!(
            "{caption} In order of {name}; first, keeps rank: shares of {DRAWS} bootstrap samples of the sequences \
             in which a method is first, and in which it has its rank here (equal ones share a rank; anchors \
             have none). Suite {suite}: {data_note}."
        ),
        data: data_note.to_string(),
        corner: "method".to_string(),
        columns: ["rank", name, "first", "keeps rank"].map(String::from).into(),
        groups,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn counts(tp: u64, fp: u64, fn_: u64) -> Counts {
        Counts { tp, fp, fn_, tn: 10 }
    }

    #[test]
    fn equal_methods_share_a_rank_and_none_is_behind_all() {
        let values = [Some(0.5), None, Some(0.7), Some(0.5), Some(0.1)];
        assert_eq!(ranks(&values, Metric::F_SCORE), [2, 5, 1, 2, 4]);
        assert_eq!(ranks(&values, Metric::FPR), [2, 5, 4, 2, 1]);
    }

    // A method that is better on every sequence is first in every draw.
    #[test]
    fn what_holds_on_every_sequence_holds_in_every_draw() {
        let (good, bad) = ([counts(3, 0, 1); 4], [counts(2, 1, 2); 4]);
        let sure = stability(&[(&bad, None), (&good, None)], Metric::F_SCORE, 500, 1);
        assert_eq!(sure[1], Stability { rank: 1, first: 1.0, keeps: 1.0 });
        assert_eq!(sure[0], Stability { rank: 2, first: 0.0, keeps: 1.0 });
    }

    // Both hit every event; only the chance of a wide window is taken from what the first has.
    #[test]
    fn chance_is_of_each_methods_own_protocol() {
        let list = [counts(2, 1, 0); 4];
        let both: [Drawn<'_>; 2] = [(&list, Some(Chance::within(5))), (&list, Some(Chance::within(0)))];
        let sure = stability(&both, Metric::F_OVER_CHANCE, 50, 1);
        assert_eq!((sure[0].rank, sure[1].rank), (2, 1));
        assert_eq!(sure[1].first, 1.0);
    }

    // Closed form: A finds the events of sequence 1 only, B those of the n - 1 others, one each. In a draw of n,
    // A has k hits with k ~ Binomial(n, 1 / n), B has n - k. For n = 3, A is first when k >= 2, with
    // probability 3 (1/9)(2/3) + 1/27 = 7/27; there are no ties. Standard error of 10000 draws: 0.0044.
    #[test]
    fn shares_are_those_of_the_binomial_distribution() {
        let (hit, miss) = (counts(1, 0, 0), counts(0, 0, 1));
        let (a, b) = ([hit, miss, miss], [miss, hit, hit]);
        let two: [Drawn<'_>; 2] = [(&a, None), (&b, None)];
        let sure = stability(&two, Metric::RECALL, DRAWS, 7);
        assert_eq!((sure[0].rank, sure[1].rank), (2, 1));
        assert!((sure[0].first - 7.0 / 27.0).abs() < 4.0 * 0.0044, "{sure:?}");
        assert_eq!(sure[0].first, 1.0 - sure[1].keeps);
        assert_eq!(sure, stability(&two, Metric::RECALL, DRAWS, 7));
    }

    proptest! {
        #[test]
        fn somebody_is_first_in_every_draw_and_order_does_not_matter(
            list in prop::collection::vec(prop::collection::vec((0..4_u64, 0..4_u64, 0..4_u64), 5), 1..5),
        ) {
            let list: Vec<Vec<Counts>> =
                list.iter().map(|m| m.iter().map(|c| counts(c.0, c.1, c.2)).collect()).collect();
            let methods: Vec<Drawn<'_>> = list.iter().map(|m| (m.as_slice(), None)).collect();
            let sure = stability(&methods, Metric::F_SCORE, 50, 3);
            prop_assert!(sure.iter().map(|s| s.first).sum::<f64>() >= 1.0 - 1e-9);
            let turned: Vec<Drawn<'_>> = methods.iter().rev().copied().collect();
            let mut again = stability(&turned, Metric::F_SCORE, 50, 3);
            again.reverse();
            prop_assert_eq!(sure, again);
        }
    }
}
