//! The innovations of a window under given coefficients, as affine functions of the constant.
//!
//! With the autoregressive and moving average coefficients held fixed, every back-forecast response and
//! every innovation is `base + slope * c` in the constant `c`. Pairs `[base, slope]` are carried through
//! the recursions, so the sum of squares is a parabola in `c` and its minimum is exact.
//! Times are 0-based here: the window is `y[0]..y[n-1]`, the presample `y[-1], y[-2], ...`.

use super::{MAX_ORDER, Presample};

/// The affine function `base + slope * c`.
pub(super) type Affine = [f64; 2];

/// Calls `visit` with each innovation, oldest first. Needs `ar.len() <= y.len()` and orders of at most
/// [`MAX_ORDER`].
#[inline(always)]
fn walk(y: &[f64], ar: &[f64], ma: &[f64], start: Presample, mut visit: impl FnMut(Affine)) {
    let mut presample = [[0.0; 2]; MAX_ORDER];
    let first = match start {
        Presample::DropFirst => ar.len(),
        Presample::Backcast => {
            back_forecast(y, ar, ma, &mut presample);
            0
        }
    };
    let mut recent = [[0.0; 2]; MAX_ORDER];
    for (t, &value) in y.iter().enumerate().skip(first) {
        let mut innovation = [value, -1.0];
        for (i, &phi) in ar.iter().enumerate() {
            if i < t {
                innovation[0] -= phi * y[t - 1 - i];
            } else {
                subtract(&mut innovation, phi, presample[i - t]);
            }
        }
        for (j, &theta) in ma.iter().enumerate() {
            subtract(&mut innovation, theta, recent[j]);
        }
        push(&mut recent, ma.len(), innovation);
        visit(innovation);
    }
}

/// Forecasts `y[-1], y[-2], ...` by the same model on the reversed series, with future innovations 0.
#[inline(always)]
fn back_forecast(y: &[f64], ar: &[f64], ma: &[f64], presample: &mut [Affine; MAX_ORDER]) {
    let mut ahead = [[0.0; 2]; MAX_ORDER];
    for t in (0..y.len() - ar.len()).rev() {
        let mut innovation = [y[t], -1.0];
        for (i, &phi) in ar.iter().enumerate() {
            innovation[0] -= phi * y[t + 1 + i];
        }
        for (j, &theta) in ma.iter().enumerate() {
            subtract(&mut innovation, theta, ahead[j]);
        }
        push(&mut ahead, ma.len(), innovation);
    }
    for k in 0..ar.len() {
        let mut value = [0.0, 1.0];
        for (i, &phi) in ar.iter().enumerate() {
            let later = if i >= k { [y[i - k], 0.0] } else { presample[k - 1 - i] };
            subtract(&mut value, -phi, later);
        }
        for (j, &theta) in ma.iter().enumerate().skip(k) {
            subtract(&mut value, -theta, ahead[j - k]);
        }
        presample[k] = value;
    }
}

#[inline(always)]
fn subtract(from: &mut Affine, factor: f64, what: Affine) {
    from[0] -= factor * what[0];
    from[1] -= factor * what[1];
}

/// Inserts the newest innovation at the front of the last `q`.
#[inline(always)]
fn push(recent: &mut [Affine; MAX_ORDER], q: usize, newest: Affine) {
    for j in (1..q).rev() {
        recent[j] = recent[j - 1];
    }
    if q > 0 {
        recent[0] = newest;
    }
}

/// Constant with the smallest sum of squared innovations, and that sum.
pub(super) fn best_constant(y: &[f64], ar: &[f64], ma: &[f64], start: Presample) -> (f64, f64) {
    // The usual orders have loops of known lengths, which are several times faster.
    let (mut bb, mut bs, mut ss) = (0.0, 0.0, 0.0);
    let add = |[base, slope]: Affine| {
        bb += base * base;
        bs += base * slope;
        ss += slope * slope;
    };
    match (ar, ma) {
        (&[phi], &[theta]) => walk(y, &[phi], &[theta], start, add),
        (&[phi], &[]) => walk(y, &[phi], &[], start, add),
        (&[], &[theta]) => walk(y, &[], &[theta], start, add),
        _ => walk(y, ar, ma, start, add),
    }
    if ss > 0.0 {
        let constant = -bs / ss;
        (constant, (bb - bs * bs / ss).max(0.0))
    } else {
        (0.0, bb)
    }
}

/// Innovations for a given constant, oldest first.
pub(super) fn innovations(y: &[f64], constant: f64, ar: &[f64], ma: &[f64], start: Presample) -> Vec<f64> {
    let mut all = Vec::with_capacity(y.len());
    walk(y, ar, ma, start, |[base, slope]| all.push(base + constant * slope));
    all
}
