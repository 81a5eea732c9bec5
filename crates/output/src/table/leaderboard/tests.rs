use super::*;
use proptest::prelude::*;

fn counts(tp: u64, fp: u64, fn_: u64) -> Counts {
    Counts { tp, fp, fn_, tn: 10 }
}

fn draws(sequences: usize) -> Option<std::sync::Arc<Draws>> {
    Sampling::with_seed(7).draws(sequences)
}

#[test]
fn equal_methods_share_a_rank_and_those_without_a_value_come_last() {
    let values = [Some(0.5), None, Some(0.7), Some(0.5), Some(0.1)];
    assert_eq!(ranks(&values, Metric::F_SCORE), [2, 5, 1, 2, 4]);
    assert_eq!(ranks(&values, Metric::FPR), [2, 5, 4, 2, 1]);
}

#[test]
fn a_method_that_is_better_on_every_sequence_is_first_in_every_draw() {
    let (good, bad) = ([counts(3, 0, 1); 4], [counts(2, 1, 2); 4]);
    let sure = stability(&[(&bad, None), (&good, None)], Metric::F_SCORE, draws(4).as_deref());
    assert_eq!(sure[1], Stability { rank: 1, first: 1.0, keeps: 1.0 });
    assert_eq!(sure[0], Stability { rank: 2, first: 0.0, keeps: 1.0 });
}

// Both hit every event; only the chance of a wide window is taken from what the first has.
#[test]
fn every_method_is_compared_with_chance_by_its_own_protocol() {
    let list = [counts(2, 1, 0); 4];
    let both: [CountsOfMethod<'_>; 2] = [(&list, Some(Chance::within(5))), (&list, Some(Chance::within(0)))];
    let sure = stability(&both, Metric::F_OVER_CHANCE, draws(4).as_deref());
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
    let two: [CountsOfMethod<'_>; 2] = [(&a, None), (&b, None)];
    let sure = stability(&two, Metric::RECALL, draws(3).as_deref());
    assert_eq!((sure[0].rank, sure[1].rank), (2, 1));
    assert!((sure[0].first - 7.0 / 27.0).abs() < 4.0 * 0.0062, "{sure:?}");
    assert!((sure[0].first - (1.0 - sure[1].keeps)).abs() < 1e-12);
    assert_eq!(sure, stability(&two, Metric::RECALL, draws(3).as_deref()));
}

proptest! {
    #[test]
    fn every_draw_has_a_first_method_and_the_order_of_methods_does_not_matter(
        list in prop::collection::vec(prop::collection::vec((0..4_u64, 0..4_u64, 0..4_u64), 5), 1..5),
    ) {
        let list: Vec<Vec<Counts>> =
            list.iter().map(|m| m.iter().map(|c| counts(c.0, c.1, c.2)).collect()).collect();
        let methods: Vec<CountsOfMethod<'_>> = list.iter().map(|m| (m.as_slice(), None)).collect();
        let few = Draws::new(5, 50, 3);
        let sure = stability(&methods, Metric::F_SCORE, Some(&few));
        prop_assert!(sure.iter().map(|s| s.first).sum::<f64>() >= 1.0 - 1e-9);
        let turned: Vec<CountsOfMethod<'_>> = methods.iter().rev().copied().collect();
        let mut again = stability(&turned, Metric::F_SCORE, Some(&few));
        again.reverse();
        prop_assert_eq!(sure, again);
    }
}
