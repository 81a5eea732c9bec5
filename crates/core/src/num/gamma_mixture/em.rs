//! Expectation and maximization on cells.
//!
//! ```text
//! ln L(xi)  = sum_c n_c ln gm(c),      gm(c) = sum_k gamma_k f_k(c),
//! ln f_k(c) = (eta_k - 1) ln_c - x_c / theta_k - eta_k ln theta_k - ln Gamma(eta_k)
//! r_kc = gamma_k f_k(c) / gm(c),       N_k = sum_c n_c r_kc,     mean_k g = sum_c n_c r_kc g_c / N_k
//! gamma_k = N_k / n,    ln eta_k - psi(eta_k) = ln(mean_k x) - mean_k(ln),    theta_k = mean_k x / eta_k
//! ```
//!
//! `n_c`, `x_c` and `ln_c` are count, mean and mean logarithm of cell `c`. `ln f_k` is linear in
//! `(ln_c, x_c)`: for one component this is the likelihood of the samples themselves, for several it is
//! below it by what the responsibilities vary within a cell (Jensen), the same for every `K`. The limits
//! (shape at most 1e4, weight at least 1e-6) are met by the constrained maximum of each step, so that an
//! iteration never lowers `ln L`. Overlapping components make EM slow (thousands of iterations): every two
//! of them are followed by an extrapolation, which is kept only where it raises `ln L` further. The fixed
//! points are those of EM.

use super::binned::Cells;
use super::{Component, MAX_SHAPE, MIN_WEIGHT};
use crate::num::special::{gamma_shape, ln_gamma};
use rayon::prelude::*;

/// Number of cells in a block. Sums run within blocks and then over them, in this order on any number of
/// threads.
const BLOCK: usize = 512;

/// Least number of blocks for which threads are worth their cost.
const PARALLEL: usize = 6;

/// A model with its likelihood, and the sums for the next iteration.
pub(super) struct Run {
    pub components: Vec<Component>,
    /// `ln L` of `components`.
    pub log_likelihood: f64,
    sums: Vec<Sums>,
}

/// Sums `N_k`, `sum n r x` and `sum n r ln` of a component.
type Sums = [f64; 3];

/// Iterates until a cycle gains less than `tolerance` per sample, or after about `max_iterations` passes over
/// the cells. `watch` receives the log-likelihood of each accepted model.
///
/// A cycle is two iterations of EM, `xi0 -> xi1 -> xi2`, a leap from them, and one more iteration after it.
pub(super) fn run(
    cells: &Cells,
    start: Vec<Component>,
    max_iterations: usize,
    tolerance: f64,
    mut watch: impl FnMut(f64),
) -> Run {
    let mut at = Run::new(cells, start);
    let (mut iterations, mut converged, mut reach) = (0, false, 4.0);
    while iterations < max_iterations && !converged {
        let before = at.log_likelihood;
        let first = at.next(cells);
        let second = first.next(cells);
        iterations += 2;
        watch(first.log_likelihood);
        watch(second.log_likelihood);
        let leapt = leap(&at, &first, &second, reach).map(|(components, step)| {
            iterations += 2;
            (Run::new(cells, components).next(cells), step)
        });
        let (mut short, mut next) = (true, second);
        match leapt {
            Some((far, step)) if far.log_likelihood >= next.log_likelihood => {
                if step >= reach {
                    reach *= 4.0;
                }
                watch(far.log_likelihood);
                next = far;
            }
            // The leap is rejected. A small gain does not mean convergence until smaller leaps have failed as well.
            Some(_) => {
                short = reach <= 1.0;
                reach = (reach / 4.0).max(1.0);
            }
            None => {}
        }
        converged = short && next.log_likelihood - before < tolerance * cells.total;
        // Within rounding a last cycle may lose; it is not taken.
        if next.log_likelihood >= before {
            at = next;
        }
    }
    at
}

impl Run {
    fn new(cells: &Cells, components: Vec<Component>) -> Self {
        let (log_likelihood, sums) = expectation(cells, &components);
        Self { components, log_likelihood, sums }
    }

    fn next(&self, cells: &Cells) -> Self {
        Self::new(cells, maximization(&self.components, &self.sums, cells.total))
    }
}

/// Extrapolation by scheme S3 of Varadhan and Roland (2008, Scand. J. Statist. 35) on the logarithms of the
/// parameters, and its length: `xi0 + 2 a r + a^2 v` with `r = xi1 - xi0`, `v = xi2 - 2 xi1 + xi0` and
/// `a = |r| / |v|`, between 1 (which gives `xi2`) and `reach`. `None` if `a` is at most 1.
fn leap(zero: &Run, one: &Run, two: &Run, reach: f64) -> Option<(Vec<Component>, f64)> {
    let logs = |s: &Run| -> Vec<f64> {
        s.components.iter().flat_map(|c| [c.weight.ln(), c.shape.ln(), c.scale.ln()]).collect()
    };
    let (zero, one, two) = (logs(zero), logs(one), logs(two));
    let (mut rr, mut vv) = (0.0, 0.0);
    for ((zero, one), two) in zero.iter().zip(&one).zip(&two) {
        rr += (one - zero) * (one - zero);
        vv += (two - 2.0 * one + zero) * (two - 2.0 * one + zero);
    }
    let step = (rr / vv).sqrt().min(reach);
    // Without any change the ratio is 0 / 0.
    if step.is_nan() || step <= 1.0 {
        return None;
    }
    let beyond = |((zero, one), two): ((&f64, &f64), &f64)| {
        (zero + 2.0 * step * (one - zero) + step * step * (two - 2.0 * one + zero)).exp()
    };
    let leapt: Vec<f64> = zero.iter().zip(&one).zip(&two).map(beyond).collect();
    if !leapt.iter().all(|v| v.is_finite() && *v > 0.0) {
        return None;
    }
    let weights = weights(leapt.iter().step_by(3).copied().collect());
    let component =
        |(p, weight): (&[f64], f64)| Component { weight, shape: p[1].min(MAX_SHAPE), scale: p[2] };
    Some((leapt.chunks_exact(3).zip(weights).map(component).collect(), step))
}

/// Log-likelihood of a model, and the sums from which the next model is computed.
fn expectation(cells: &Cells, components: &[Component]) -> (f64, Vec<Sums>) {
    let blocks = cells.count.len().div_ceil(BLOCK);
    let parts: Vec<(f64, Vec<Sums>)> = if blocks < PARALLEL {
        (0..blocks).map(|b| block(cells, components, b)).collect()
    } else {
        (0..blocks).into_par_iter().map(|b| block(cells, components, b)).collect()
    };
    let mut total = (0.0, vec![[0.0; 3]; components.len()]);
    for (log_likelihood, sums) in parts {
        total.0 += log_likelihood;
        for (to, from) in total.1.iter_mut().flatten().zip(sums.iter().flatten()) {
            *to += from;
        }
    }
    total
}

fn block(cells: &Cells, components: &[Component], b: usize) -> (f64, Vec<Sums>) {
    let range = b * BLOCK..((b + 1) * BLOCK).min(cells.count.len());
    let (count, x, ln) = (&cells.count[range.clone()], &cells.x[range.clone()], &cells.ln[range]);
    let size = count.len();
    let mut joint = vec![0.0; components.len() * size];
    let mut largest = [f64::NEG_INFINITY; BLOCK];
    for (c, row) in components.iter().zip(joint.chunks_exact_mut(size)) {
        let constant = c.weight.ln() - c.shape * c.scale.ln() - ln_gamma(c.shape);
        let (power, rate) = (c.shape - 1.0, 1.0 / c.scale);
        for (((to, top), x), ln) in row.iter_mut().zip(&mut largest).zip(x).zip(ln) {
            *to = constant + power * ln - rate * x;
            *top = top.max(*to);
        }
    }
    let mut density = [0.0; BLOCK];
    for row in joint.chunks_exact_mut(size) {
        for ((to, top), sum) in row.iter_mut().zip(&largest).zip(&mut density) {
            *to = (*to - top).exp();
            *sum += *to;
        }
    }
    let mut log_likelihood = 0.0;
    // From here on `density` is the factor that makes a row's entries the samples of that component.
    for ((sum, top), n) in density.iter_mut().zip(&largest).zip(count) {
        log_likelihood += n * (top + sum.ln());
        *sum = n / *sum;
    }
    let sums = joint.chunks_exact(size).map(|row| {
        let mut sums = [0.0; 3];
        for (((share, factor), x), ln) in row.iter().zip(&density).zip(x).zip(ln) {
            let n = share * factor;
            sums[0] += n;
            sums[1] += n * x;
            sums[2] += n * ln;
        }
        sums
    });
    let sums = sums.collect();
    (log_likelihood, sums)
}

fn maximization(old: &[Component], sums: &[Sums], total: f64) -> Vec<Component> {
    let weights = weights(sums.iter().map(|s| s[0] / total).collect());
    let component = |((old, &[n, x, ln]), weight): ((&Component, &Sums), f64)| {
        let (mean, mean_ln) = (x / n, ln / n);
        // Without samples to speak of a component stays where it is.
        if n < f64::MIN_POSITIVE.sqrt() || !(mean > 0.0 && mean.is_finite() && mean_ln.is_finite()) {
            return Component { weight, ..*old };
        }
        let shape = gamma_shape(mean.ln() - mean_ln).min(MAX_SHAPE);
        Component { weight, shape, scale: mean / shape }
    };
    old.iter().zip(sums).zip(weights).map(component).collect()
}

/// Weights of greatest likelihood among those of at least [`MIN_WEIGHT`]: smaller ones are raised to it, the
/// others keep their proportions.
fn weights(mut share: Vec<f64>) -> Vec<f64> {
    let mut raised = vec![false; share.len()];
    loop {
        let kept: f64 = share.iter().zip(&raised).filter(|(_, raised)| !**raised).map(|(s, _)| s).sum();
        let room = 1.0 - MIN_WEIGHT * raised.iter().filter(|&&raised| raised).count() as f64;
        let mut again = false;
        for (s, raised) in share.iter_mut().zip(&mut raised).filter(|(_, raised)| !**raised) {
            *s *= room / kept;
            if *s < MIN_WEIGHT {
                (*s, *raised, again) = (MIN_WEIGHT, true, true);
            }
        }
        if !again {
            return share;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::num::gamma_mixture::Binned;
    use crate::num::seed;
    use crate::testing::{drawn_mixture, mixture};
    use proptest::prelude::*;

    #[test]
    fn small_weights_are_raised_and_the_rest_keeps_its_proportions() {
        assert_eq!(weights(vec![0.25, 0.75]), [0.25, 0.75]);
        let got = weights(vec![0.0, 0.2, 1e-9, 0.8 - 1e-9]);
        assert_eq!((got[0], got[2]), (MIN_WEIGHT, MIN_WEIGHT));
        assert!((got[1] / got[3] - 0.25).abs() < 1e-8 && (got.iter().sum::<f64>() - 1.0).abs() < 1e-15);
    }

    fn cells(seed: u64, n: usize) -> Cells {
        let mixture = mixture(&[(0.6, 0.5, 0.1), (0.3, 3.0, 0.2), (0.1, 40.0, 0.05)]);
        let mut rng = seed::rng(seed);
        Binned::new((0..n).map(|_| mixture.sample(&mut rng))).unwrap().cells(1)
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(40))]
        // From anywhere, also where the limits of shape and weight are at work.
        #[test]
        fn the_likelihood_never_falls(
            seed in 0..1000_u64, start in prop::collection::vec((0.01..1.0_f64, -2.0..4.0_f64, -4.0..3.0_f64), 1..7)
        ) {
            let cells = cells(seed, 500);
            let start = drawn_mixture(&start).components;
            let mut seen = vec![expectation(&cells, &start).0];
            let run = run(&cells, start, 60, -1.0, |l| seen.push(l));
            prop_assert!(seen.len() > 20);
            for pair in seen.windows(2) {
                prop_assert!(pair[1] >= pair[0] - 1e-11 * (1.0 + pair[0].abs()), "{} after {}", pair[1], pair[0]);
            }
            prop_assert!((run.components.iter().map(|c| c.weight).sum::<f64>() - 1.0).abs() < 1e-12);
            prop_assert!(run.components.iter().all(|c| c.shape <= MAX_SHAPE && c.weight >= MIN_WEIGHT));
        }
    }
}
