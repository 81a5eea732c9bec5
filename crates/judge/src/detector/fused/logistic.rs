//! L2 logistic regression by Newton's method.
//!
//! ```text
//! minimize over w, b:  sum_i v_i ln(1 + exp(-y_i (w . x_i + b))) + lambda / 2 |w|^2        y_i = 1 (lost) or -1
//! ```
//!
//! `x_i` are standardized features, `v_i` weights; `b` has no penalty. For
//! `lambda > 0` the objective is strictly convex in `w`, so the result does not depend on the start of the
//! search. Rows are summed in order, on one thread.

use nalgebra::{DMatrix, DVector};

/// Rows of equal length with their labels and weights.
#[derive(Debug, Clone, Default)]
pub struct Rows {
    /// Number of values in a row.
    pub columns: usize,
    /// All rows, one after the other.
    pub values: Vec<f64>,
    /// For each row, true if the target is lost.
    pub lost: Vec<bool>,
    /// Weight of each row.
    pub weight: Vec<f64>,
}

impl Rows {
    /// The rows with their labels and weights.
    pub fn iter(&self) -> impl Iterator<Item = (&[f64], bool, f64)> {
        let rows = self.values.chunks_exact(self.columns.max(1));
        rows.zip(&self.lost).zip(&self.weight).map(|((row, lost), weight)| (row, *lost, *weight))
    }
}

/// Most steps of the search. About ten are needed.
const MAX_STEPS: usize = 100;
/// Largest change of a weight at which the search ends.
const TOLERANCE: f64 = 1e-7;

/// Logistic function 1 / (1 + exp(-score)).
pub fn sigmoid(score: f64) -> f64 {
    if score >= 0.0 { 1.0 / (1.0 + (-score).exp()) } else { score.exp() / (1.0 + score.exp()) }
}

/// Logistic loss ln(1 + exp(-margin)).
fn loss(margin: f64) -> f64 {
    if margin > 0.0 { (-margin).exp().ln_1p() } else { margin.exp().ln_1p() - margin }
}

/// Weights of the columns and bias that minimize the objective; `None` if all rows have the same label, or if a value is not
/// finite.
pub fn fit(rows: &Rows, lambda: f64) -> Option<(Vec<f64>, f64)> {
    let n = rows.columns + 1;
    if rows.lost.iter().all(|l| *l) || !rows.lost.contains(&true) {
        return None;
    }
    let objective = |theta: &DVector<f64>| {
        let of_row = |(row, lost, weight): (&[f64], bool, f64)| {
            let score = score(theta, row);
            weight * loss(if lost { score } else { -score })
        };
        rows.iter().map(of_row).sum::<f64>() + lambda / 2.0 * theta.rows(0, n - 1).norm_squared()
    };
    let mut theta = DVector::<f64>::zeros(n);
    let mut value = objective(&theta);
    for _ in 0..MAX_STEPS {
        let (gradient, hessian) = derivatives(rows, lambda, &theta);
        let step = hessian.cholesky()?.solve(&gradient);
        let mut length = 1.0;
        // Newton's steps can be too long far from the minimum, and no longer descend at it.
        let (next, reached) = loop {
            let next = &theta - &step * length;
            let reached = objective(&next);
            if reached <= value || length < 1e-6 {
                break (next, reached);
            }
            length /= 2.0;
        };
        if !reached.is_finite() {
            return None;
        }
        let change = (&next - &theta).amax();
        if reached > value {
            break;
        }
        (theta, value) = (next, reached);
        if change < TOLERANCE {
            break;
        }
    }
    Some((theta.rows(0, n - 1).iter().copied().collect(), theta[n - 1]))
}

fn score(theta: &DVector<f64>, row: &[f64]) -> f64 {
    row.iter().zip(theta.iter()).map(|(x, w)| x * w).sum::<f64>() + theta[row.len()]
}

/// Adds `scale` times the first values to as many sums.
#[multiversion::multiversion(targets("x86_64+avx+avx2"))]
fn add_scaled(sums: &mut [f64], values: &[f64], scale: f64) {
    sums.iter_mut().zip(values).for_each(|(sum, value)| *sum += scale * value);
}

/// Gradient and second derivatives of the objective, with the bias as the last column.
fn derivatives(rows: &Rows, lambda: f64, theta: &DVector<f64>) -> (DVector<f64>, DMatrix<f64>) {
    let n = rows.columns + 1;
    let mut gradient = DVector::<f64>::zeros(n);
    let mut lower = vec![0.0; n * n];
    let mut x = vec![1.0; n];
    for (row, lost, weight) in rows.iter() {
        let probability = sigmoid(score(theta, row));
        let residual = weight * (probability - f64::from(u8::from(lost)));
        let curvature = weight * probability * (1.0 - probability);
        x[..row.len()].copy_from_slice(row);
        for (i, xi) in x.iter().enumerate() {
            gradient[i] += residual * xi;
            add_scaled(&mut lower[i * n..=i * n + i], &x, curvature * xi);
        }
    }
    let mut hessian = DMatrix::from_fn(n, n, |i, j| lower[i.max(j) * n + i.min(j)]);
    for i in 0..n - 1 {
        gradient[i] += lambda * theta[i];
        hessian[(i, i)] += lambda;
    }
    (gradient, hessian)
}

#[cfg(test)]
mod tests {
    // By hand: far from 0 the loss is 0 on the right side and the distance on the other.
    #[test]
    fn a_loss_is_finite_for_every_margin() {
        assert_eq!([1000.0, 0.0, -1000.0].map(super::loss), [0.0, std::f64::consts::LN_2, 1000.0]);
    }
}
