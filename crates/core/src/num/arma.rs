//! ARMA(p, q) by conditional Gaussian maximum likelihood, and its forecasts.
//!
//! ```text
//! y[t] = c + sum_i phi[i] y[t-i] + e[t] + sum_j theta[j] e[t-j],   i = 1..p, j = 1..q, t = 1..n
//! ```
//!
//! `y` and `c` are in the series' unit, `phi` and `theta` have none; in code `ar[0]` is phi\[1\] and
//! `ma[0]` is theta\[1\]. With the presample innovations `e[0], e[-1], ...` set to 0 the likelihood is
//! largest where the sum of the squared innovations is smallest (Box, Jenkins and Reinsel, chapter 7),
//! over stationary and invertible models. [`Presample`] chooses the values of `y` before the window. The constant is found exactly for each trial of the coefficients; the coefficients by a
//! lattice and Nelder-Mead, without any random number. The window is standardized first, so shifting or
//! scaling it shifts or scales the forecasts.
//!
//! The forecast with the smallest mean squared error sets the innovations that are still to come to 0:
//!
//! ```text
//! y^[n+k] = c + sum_i phi[i] y^[n+k-i] + sum_{j >= k} theta[j] e[n+k-j]      with y^[s] = y[s] for s <= n
//! ```
//!
//! This is Eq. 8 of Khalid, Cavallaro and Rinner (BMVC 2016), read in the usual way: the printed sum
//! starts at p = 0 and its moving average part ends at l < Q, while the text says it is zero for l > Q.
//!
//! Chosen where the paper (which used MATLAB's `arima` and `estimate`) leaves it open: back-forecasts are
//! made anew for each trial of the coefficients; partial autocorrelations are kept within `+-(1 - 1e-6)`;
//! a window without variation gives its last value as forecast. With 20 values the best `theta` is often
//! on the border.

mod recursion;
mod search;

use serde::{Deserialize, Serialize};

/// Largest number of coefficients of either kind.
pub const MAX_ORDER: usize = 5;

/// Largest absolute partial autocorrelation.
const LIMIT: f64 = 1.0 - 1e-6;

/// Relative variation below which a window counts as constant.
const CONSTANT: f64 = 1e-12;

/// Values assumed before the window.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Presample {
    /// Forecasts of the reversed window by the same model.
    Backcast,
    /// The first `p` values of the window serve as presample and have no innovations.
    DropFirst,
}

/// A fitted model, and the end of its window.
#[derive(Debug, Clone, PartialEq)]
pub struct Fit {
    /// `c`, in the series' unit.
    pub constant: f64,
    /// `phi[1..=p]`.
    pub ar: Vec<f64>,
    /// `theta[1..=q]`.
    pub ma: Vec<f64>,
    /// Sum of the squared innovations.
    pub sse: f64,
    /// Innovations, oldest first: `n` of them, `n - p` with [`Presample::DropFirst`].
    pub innovations: Vec<f64>,
    /// The last `p` values, newest first.
    recent: Vec<f64>,
}

/// Least length of a window for an order: two more innovations than parameters, even if `p` values are
/// dropped.
pub fn least_window([p, q]: [usize; 2]) -> usize {
    2 * p + q + 3
}

/// Fits a model of order `[p, q]` to a window, oldest value first.
///
/// `None` for orders above [`MAX_ORDER`], windows shorter than [`least_window`], and values that are not finite,
/// or so large that sums overflow.
pub fn fit(y: &[f64], order: [usize; 2], start: Presample) -> Option<Fit> {
    let [p, q] = order;
    if p.max(q) > MAX_ORDER || y.len() < least_window(order) {
        return None;
    }
    let count = y.len() as f64;
    let mean = y.iter().sum::<f64>() / count;
    let largest = y.iter().fold(0.0_f64, |m, v| m.max(v.abs()));
    let reach = y.iter().fold(0.0_f64, |m, v| m.max((v - mean).abs()));
    // Where values are not finite, their mean is not either.
    if !mean.is_finite() || !reach.is_finite() {
        return None;
    }
    if reach <= (CONSTANT * largest).max(f64::MIN_POSITIVE) {
        let dropped = if start == Presample::DropFirst { p } else { 0 };
        return Some(Fit {
            constant: y[y.len() - 1],
            ar: vec![0.0; p],
            ma: vec![0.0; q],
            sse: 0.0,
            innovations: vec![0.0; y.len() - dropped],
            recent: newest(y, p),
        });
    }
    let mut z: Vec<f64> = y.iter().map(|v| (v - mean) / reach).collect();
    let deviation = (z.iter().map(|v| v * v).sum::<f64>() / count).sqrt();
    z.iter_mut().for_each(|v| *v /= deviation);
    let scale = reach * deviation;

    let partials = if p + q > 0 { search::minimize(&z, p, q, start) } else { Vec::new() };
    let (ar, ma) = search::coefficients(&partials, p);
    let (ar, ma) = (ar[..p].to_vec(), ma[..q].to_vec());
    let (constant, _) = recursion::best_constant(&z, &ar, &ma, start);
    let mut innovations = recursion::innovations(&z, constant, &ar, &ma, start);
    innovations.iter_mut().for_each(|e| *e *= scale);
    Some(Fit {
        constant: scale * constant + mean * (1.0 - ar.iter().sum::<f64>()),
        sse: innovations.iter().map(|e| e * e).sum(),
        ar,
        ma,
        innovations,
        recent: newest(y, p),
    })
}

impl Fit {
    /// Forecasts of the `length` values after the window.
    pub fn forecast(&self, length: usize) -> Vec<f64> {
        let mut path: Vec<f64> = Vec::with_capacity(length);
        for k in 0..length {
            let mut value = self.constant;
            for (i, phi) in self.ar.iter().enumerate() {
                value += phi * if i < k { path[k - 1 - i] } else { self.recent[i - k] };
            }
            let known = self.innovations.iter().rev();
            value += self.ma.iter().skip(k).zip(known).map(|(theta, e)| theta * e).sum::<f64>();
            path.push(value);
        }
        path
    }
}

fn newest(y: &[f64], count: usize) -> Vec<f64> {
    y.iter().rev().take(count).copied().collect()
}

#[cfg(test)]
mod tests;
