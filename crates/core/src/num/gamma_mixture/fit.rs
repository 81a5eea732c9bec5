//! Maximum-likelihood fits from many starts, for one order or all orders up to a limit.
//!
//! The paper names its EM by a reference only (\[29\] in section 5.1), without start or stop. Chosen here:
//! each order starts from equal groups, from a normal mixture on `x^(1/3)`, from `restarts` random groups,
//! and from the best model of one order less with each component split in turn. These short runs (as in
//! Biernacki, Celeux and Govaert 2003) and the convergence of the best of them are done on cells that are
//! up to 16 times wider; the result is then iterated on all cells. A fit that ends below the one before it
//! starts again from that one, so the likelihood never falls with the order.

use super::binned::Cells;
use super::em::{Run, run};
use super::{Binned, MAX_COMPONENTS, Mixture, start};
use crate::num::seed;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

/// Number of neighboring cells that are merged while the starts are tried.
const COARSE: usize = 16;

/// Least number of cells after merging. Fewer neighbors are merged if needed.
const MIN_COARSE_CELLS: usize = 300;

/// Number of iterations of a short run.
const SHORT: usize = 100;

/// Options of a fit.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct FitOptions {
    /// Number of random starts for each order.
    pub restarts: usize,
    /// Most iterations (passes over the cells) of a fit. The last cycle may exceed it.
    pub max_iterations: usize,
    /// Least gain of the log-likelihood per sample in a cycle of four iterations, above 0; below it a fit
    /// stops. A gain per sample does not depend on the unit of the samples, unlike a gain relative to the
    /// log-likelihood.
    pub tolerance: f64,
    /// Seed of the random starts.
    pub seed: u64,
}

impl Default for FitOptions {
    fn default() -> Self {
        Self { restarts: 10, max_iterations: 1000, tolerance: 1e-9, seed: 2015 }
    }
}

/// A fitted mixture.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Fit {
    /// The model.
    pub mixture: Mixture,
    /// Sum over the samples of the natural logarithm of the density, from the means of the cells.
    pub log_likelihood: f64,
}

/// Reason why a mixture cannot be fitted.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum FitError {
    /// An order of 0 or above [`MAX_COMPONENTS`].
    #[error("a mixture has 1 to {MAX_COMPONENTS} components, not {0}")]
    Order(usize),
    /// Fewer samples than the model has parameters, or fewer different ones (at least 2) than components.
    #[error("{k} components need {needed} samples or more in {cells} cells, not {samples} in {filled}")]
    TooFew {
        /// Number of components.
        k: usize,
        /// Number of samples required.
        needed: u64,
        /// Number of different cells required.
        cells: usize,
        /// Number of samples.
        samples: u64,
        /// Number of nonempty cells.
        filled: usize,
    },
    /// A tolerance that is not above 0.
    #[error("the tolerance must be above 0 and finite, not {0}")]
    Tolerance(f64),
    /// Parameters left the range of floats during the iterations.
    #[error("the fit of {0} components gave no valid mixture")]
    Invalid(usize),
}

/// Number of parameters of a mixture, `v_K = 3 K - 1`.
pub(super) fn parameters(k: usize) -> usize {
    3 * k - 1
}

/// Fits `k` components: the last of [`fit_all`], since smaller orders are among the starts of larger ones.
///
/// # Errors
/// See [`FitError`].
pub fn fit(samples: &Binned, k: usize, options: &FitOptions) -> Result<Fit, FitError> {
    fit_all(samples, k, options)?.pop().ok_or(FitError::Order(k))
}

/// Fits `1..=k_max` components. The log-likelihoods do not fall from one order to the next.
///
/// # Errors
/// See [`FitError`]; the conditions are those of `k_max`.
pub fn fit_all(samples: &Binned, k_max: usize, options: &FitOptions) -> Result<Vec<Fit>, FitError> {
    let cells = check(samples, k_max, options)?;
    let polish = |of: Run| run(&cells, of.components, options.max_iterations, options.tolerance, |_| ());
    let mut runs: Vec<Run> = coarse(samples, k_max, options).into_par_iter().map(polish).collect();
    for k in 1..runs.len() {
        if runs[k].log_likelihood < runs[k - 1].log_likelihood {
            runs[k] = resume(&cells, &runs[k - 1], options);
        }
    }
    runs.into_iter().map(finish).collect()
}

fn check(samples: &Binned, k: usize, options: &FitOptions) -> Result<Cells, FitError> {
    if k == 0 || k > MAX_COMPONENTS {
        return Err(FitError::Order(k));
    }
    if !(options.tolerance > 0.0 && options.tolerance.is_finite()) {
        return Err(FitError::Tolerance(options.tolerance));
    }
    let cells = samples.cells(1);
    let (needed, least) = (parameters(k) as u64, k.max(2));
    let filled = cells.count.len();
    if samples.count() < needed || filled < least {
        return Err(FitError::TooFew { k, needed, cells: least, samples: samples.count(), filled });
    }
    Ok(cells)
}

/// Best model of each order on merged cells.
fn coarse(samples: &Binned, k_max: usize, options: &FitOptions) -> Vec<Run> {
    let mut group = COARSE;
    let mut cells = samples.cells(group);
    while group > 1 && cells.count.len() < MIN_COARSE_CELLS.max(k_max) {
        group /= 2;
        cells = samples.cells(group);
    }
    let cells = &cells;
    let short = |start| run(cells, start, SHORT, options.tolerance, |_| ());

    let jobs: Vec<(usize, usize)> =
        (1..=k_max).flat_map(|k| (0..options.restarts + 2).map(move |start| (k, start))).collect();
    let attempt = |(k, number): (usize, usize)| match number {
        0 => short(start::quantiles(cells, k)),
        1 => short(start::cube_root(cells, k)),
        _ => {
            let number = number - 2;
            let names = ["gamma-mixture", &k.to_string(), &number.to_string()];
            let mut rng = seed::rng(seed::seed(options.seed, &names));
            short(start::random(cells, k, &mut rng))
        }
    };
    let independent: Vec<Run> = jobs.into_par_iter().map(attempt).collect();

    let mut best: Vec<Run> = Vec::with_capacity(k_max);
    for tried in independent.chunks(options.restarts + 2) {
        let splits: Vec<Run> = best.last().map_or_else(Vec::new, |before| {
            let model = &before.components;
            let split = |at| short(start::split(model, at, 1.0));
            (0..model.len()).into_par_iter().map(split).collect()
        });
        let all = tried.iter().chain(&splits);
        // The first of equals, so that nothing depends on what rounding makes of ties.
        let winner = all.reduce(|a, b| if b.log_likelihood > a.log_likelihood { b } else { a });
        best.extend(winner.map(|won| {
            run(cells, won.components.clone(), options.max_iterations, options.tolerance, |_| ())
        }));
    }
    best
}

/// Start from the model of one order less. Its heaviest component is split into two different ones or, if
/// that gives a lower likelihood, into two equal ones.
fn resume(cells: &Cells, before: &Run, options: &FitOptions) -> Run {
    let model = &before.components;
    let weight = |at: usize| model[at].weight;
    let at = (0..model.len()).max_by(|&a, &b| weight(a).total_cmp(&weight(b))).unwrap_or(0);
    let from =
        |apart| run(cells, start::split(model, at, apart), options.max_iterations, options.tolerance, |_| ());
    let mut run = from(1.0);
    if run.log_likelihood < before.log_likelihood {
        // The halves are the same model, whose likelihood must not differ by the rounding of a longer sum.
        run = from(0.0);
        run.log_likelihood = run.log_likelihood.max(before.log_likelihood);
    }
    run
}

fn finish(run: Run) -> Result<Fit, FitError> {
    let k = run.components.len();
    let mixture = Mixture::new(run.components).ok().filter(|_| run.log_likelihood.is_finite());
    Ok(Fit { mixture: mixture.ok_or(FitError::Invalid(k))?, log_likelihood: run.log_likelihood })
}
