use super::*;
use crate::sampling::{Sampling, sum_of};
use proptest::prelude::*;
use trackfail_core::num::pooled::Draws;
use trackfail_methods::score::chance::Chance;

/// Counts of true positives, false positives and misses, without true negatives.
fn counts(tp: i64, fp: i64, fn_: i64) -> [i64; 4] {
    [tp, fp, fn_, 10]
}

/// Certainty of the ranks of methods that have counts on the same number of sequences.
fn sure(methods: &[(&[[i64; 4]], Option<Chance>)], metric: Metric) -> Vec<Stability> {
    let sampling = Sampling::with_seed(7);
    let values = |(counts, chance): &(&[[i64; 4]], Option<Chance>)| {
        let of = |sum: &[i64; 4]| metric_of_sum(metric, *chance, sum);
        (of(&sum_of(*counts)), sampling.values(counts, of).unwrap())
    };
    let (values, sampled): (Vec<_>, Vec<_>) = methods.iter().map(values).unzip();
    stability(&values, &sampled, metric.direction())
}

#[test]
fn equal_methods_share_a_rank_and_those_without_a_value_come_last() {
    let values = [Some(0.5), None, Some(0.7), Some(0.5), Some(0.1)];
    assert_eq!(ranks(&values, Direction::HigherIsBetter), [2, 5, 1, 2, 4]);
    assert_eq!(ranks(&values, Direction::LowerIsBetter), [2, 5, 4, 2, 1]);
}

#[test]
fn a_method_that_is_better_on_every_sequence_is_first_in_every_draw() {
    let (good, bad) = ([counts(3, 0, 1); 4], [counts(2, 1, 2); 4]);
    let sure = sure(&[(&bad, None), (&good, None)], Metric::F_SCORE);
    assert_eq!(sure[1], Stability { rank: 1, first: 1.0, keeps: 1.0 });
    assert_eq!(sure[0], Stability { rank: 2, first: 0.0, keeps: 1.0 });
}

// Both hit every event; only the chance of a wide window is taken from what the first has.
#[test]
fn every_method_is_compared_with_chance_by_its_own_protocol() {
    let list = [counts(2, 1, 0); 4];
    let both = [(&list[..], Some(Chance::within(5))), (&list[..], Some(Chance::within(0)))];
    let sure = sure(&both, Metric::F_OVER_CHANCE);
    assert_eq!((sure[0].rank, sure[1].rank), (2, 1));
    assert_eq!(sure[1].first, 1.0);
}

// Closed form: A finds the events of sequence 1 only, B those of the n - 1 others, one each. In a draw of n,
// A has k hits with k ~ Binomial(n, 1 / n), B has n - k. For n = 3, A is first when k >= 2, with
// probability 3 (1/9)(2/3) + 1/27 = 7/27; there are no ties. Standard error of 5000 samples: 0.0062.
#[test]
fn shares_are_those_of_the_binomial_distribution() {
    let (hit, miss) = (counts(1, 0, 0), counts(0, 0, 1));
    let (a, b) = ([hit, miss, miss], [miss, hit, hit]);
    let two = [(&a[..], None), (&b[..], None)];
    let found = sure(&two, Metric::RECALL);
    assert_eq!((found[0].rank, found[1].rank), (2, 1));
    assert!((found[0].first - 7.0 / 27.0).abs() < 4.0 * 0.0062, "{found:?}");
    assert!((found[0].first - (1.0 - found[1].keeps)).abs() < 1e-12);
    assert_eq!(found, sure(&two, Metric::RECALL));
}

proptest! {
    #[test]
    fn every_draw_has_a_first_method_and_the_order_of_methods_does_not_matter(
        list in prop::collection::vec(prop::collection::vec((0..4_i64, 0..4_i64, 0..4_i64), 5), 1..5),
    ) {
        let f = |sum: &[i64; 4]| metric_of_sum(Metric::F_SCORE, None, sum);
        let few = Draws::new(5, 50, 3);
        let of = |method: &Vec<(i64, i64, i64)>| {
            let list: Vec<[i64; 4]> = method.iter().map(|c| counts(c.0, c.1, c.2)).collect();
            (f(&sum_of(&list)), few.values(&list, f).unwrap())
        };
        let (mut values, mut sampled): (Vec<_>, Vec<_>) = list.iter().map(of).unzip();
        let sure = stability(&values, &sampled, Direction::HigherIsBetter);
        prop_assert!(sure.iter().map(|s| s.first).sum::<f64>() >= 1.0 - 1e-9);
        values.reverse();
        sampled.reverse();
        let mut again = stability(&values, &sampled, Direction::HigherIsBetter);
        again.reverse();
        prop_assert_eq!(sure, again);
    }
}
