//! Order of a mixture by information criteria with a weighted penalty (SanMiguel and Cavallaro, CVIU 131,
//! 2015, Eq. 14 and 15, and the vote over the weights in section 5.1).
//!
//! ```text
//! dAIC(d) = argmin_K  -2 ln L_K + d * 2 v_K            v_K = 3 K - 1
//! dBIC(d) = argmin_K  -2 ln L_K + d * v_K ln n         d = 1, 2, ..., D
//! ```
//!
//! `K` is the number of components, `L_K` the largest likelihood, `n` the number of samples; small is
//! good. `d = 1` is the usual AIC and BIC. The order is the `K` that wins for most `d`, where the `d` that
//! are won by `K = 1` do not count: with a heavy penalty it always wins.
//!
//! Deviations: the paper prints `L_K` as a sum of densities, which is read as the likelihood, the product.
//! Chosen: a tie, of the criterion or of the vote, goes to the smaller `K`. `D` is 600 in the paper's
//! Fig. 11; the range of `K` is not given.

use super::Fit;
use super::fit::parameters;
use serde::{Deserialize, Serialize};

/// Largest penalty weight `D`, as in the paper's Fig. 11.
pub const MAX_PENALTY_WEIGHT: usize = 600;

/// Both terms of the criteria for one order. (The paper's Fig. 5 shows that they are comparable.)
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Terms {
    /// Number of components, `K`.
    pub k: usize,
    /// Deviance, `-2 ln L_K`.
    pub deviance: f64,
    /// Penalty of AIC, `2 v_K`, to be multiplied by `d`.
    pub aic_penalty: f64,
    /// Penalty of BIC, `v_K ln n`, to be multiplied by `d`.
    pub bic_penalty: f64,
}

/// Information criterion, which decides the penalty.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Criterion {
    /// dAIC (Eq. 14).
    Aic,
    /// dBIC (Eq. 15).
    Bic,
}

/// Result of choosing by a criterion.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Choice {
    /// Winning `K` for `d = 1, 2, ...`, at index `d - 1`.
    pub winners: Vec<usize>,
    /// Most frequent winner other than 1; `None` if 1 always wins.
    pub order: Option<usize>,
}

/// Terms of fits to `n` samples, one per order.
pub fn terms(fits: &[Fit], n: u64) -> Vec<Terms> {
    let of = |fit: &Fit| of_likelihood(fit.mixture.components.len(), fit.log_likelihood, n);
    fits.iter().map(of).collect()
}

fn of_likelihood(k: usize, log_likelihood: f64, n: u64) -> Terms {
    let v = parameters(k);
    Terms {
        k,
        deviance: -2.0 * log_likelihood,
        aic_penalty: 2.0 * v as f64,
        bic_penalty: v as f64 * (n as f64).ln(),
    }
}

/// Chooses the order by the vote over `d = 1..=max_weight`. Without terms there are no winners.
pub fn choose(terms: &[Terms], criterion: Criterion, max_weight: usize) -> Choice {
    let value = |t: &Terms, d: usize| {
        let penalty = match criterion {
            Criterion::Aic => t.aic_penalty,
            Criterion::Bic => t.bic_penalty,
        };
        t.deviance + d as f64 * penalty
    };
    let winner = |d| terms.iter().min_by(|a, b| value(a, d).total_cmp(&value(b, d)).then(a.k.cmp(&b.k)));
    let winners: Vec<usize> = (1..=max_weight).filter_map(|d| winner(d).map(|t| t.k)).collect();
    let votes = |k: usize| winners.iter().filter(|&&w| w == k).count();
    let candidates = terms.iter().map(|t| t.k).filter(|&k| k > 1 && votes(k) > 0);
    let order = candidates.max_by(|&a, &b| votes(a).cmp(&votes(b)).then(b.cmp(&a)));
    Choice { winners, order }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn of(log_likelihoods: &[f64], n: u64) -> Vec<Terms> {
        log_likelihoods.iter().enumerate().map(|(i, &l)| of_likelihood(i + 1, l, n)).collect()
    }

    // By hand: v = 2, 5, 8, 11. The deviances fall by 60, 12.5 and 0.5; a component costs 6 d. So K = 3 wins
    // while 6 d < 12.5, d = 1 and 2, then K = 2 while 6 d < 60, d = 3..9; at d = 10 K = 1 and 2 tie.
    #[test]
    fn the_vote_leaves_one_component_out() {
        let t = of(&[-100.0, -70.0, -63.75, -63.5], 1000);
        let choice = choose(&t, Criterion::Aic, 12);
        assert_eq!(choice.winners, [3, 3, 2, 2, 2, 2, 2, 2, 2, 1, 1, 1]);
        assert_eq!(choice.order, Some(2));
        assert_eq!(choose(&t, Criterion::Aic, 2).order, Some(3));
        // ln 1000 = 6.9: a component costs 20.7 d.
        assert_eq!(choose(&t, Criterion::Bic, 4).winners, [2, 2, 1, 1]);
    }

    #[test]
    fn ties_go_to_the_smaller_order() {
        let t = of(&[-100.0, -94.0, -91.0], 10);
        // d = 1: 204, 198, 198.
        assert_eq!(choose(&t, Criterion::Aic, 1).winners, [2]);
        let tied = choose(&of(&[-3.0, -3.0], 10), Criterion::Bic, 5);
        assert_eq!(tied, Choice { winners: vec![1; 5], order: None });
        assert_eq!(choose(&[], Criterion::Aic, 5), Choice { winners: vec![], order: None });
        // One vote each for K = 3 and K = 2: d = 1 and d = 2.
        let t = of(&[-100.0, -86.0, -81.0], 10);
        let choice = choose(&t, Criterion::Aic, 2);
        assert_eq!((choice.winners, choice.order), (vec![3, 2], Some(2)));
    }

    proptest! {
        #[test]
        fn a_heavier_penalty_never_asks_for_more_components(
            gains in prop::collection::vec(0.0..900.0_f64, 1..10), n in 2..3_000_000_u64
        ) {
            let l: Vec<f64> = gains.iter().scan(-1e4, |sum, g| { *sum += g; Some(*sum) }).collect();
            for criterion in [Criterion::Aic, Criterion::Bic] {
                let winners = choose(&of(&l, n), criterion, 100).winners;
                prop_assert!(winners.windows(2).all(|w| w[1] <= w[0]));
            }
        }
    }
}
