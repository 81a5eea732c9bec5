//! The distribution of a sum over a sliding window: `L`-fold convolution, its quantile `beta`, and the
//! approximations it is compared with (SanMiguel and Cavallaro, CVIU 131, 2015, Eq. 8, 11, 16 and 17, section 5.2).
//!
//! ```text
//! s[t] = c[t - L + 1] + ... + c[t]                          p_2 = p_1 * p_1 * ... * p_1,  L factors
//! m_k = F((k + 1) h) - F(k h),  k = 0, 1, ...               M = m^(*L), M_j at v_j = (j + L / 2) h
//! beta(alpha) = smallest v_j with M_0 + ... + M_j >= 1 - alpha
//! ```
//!
//! `F` is the distribution function of one non-negative value `c`, `h` the step in its unit, `alpha` the
//! probability of a false alarm. The mass of a cell of one value sits at the cell's center, hence the
//! `L h / 2`. A window is inconsistent when `s[t] > beta`.
//!
//! The paper convolves a histogram of random draws of `p_1`; the default here takes the masses from `F`
//! itself, [`Accumulated::from_samples`] is the paper's variant. The convolutions are one power of a
//! discrete Fourier transform. Errors of the masses, all absolute:
//!
//! * cells: a value is off its center by at most `h / 2`. Only the mean of this matters for the sum: the
//!   law of `S` is shifted by `L (E c - E center)`, which is of order `L h^2` for a smooth density and at most
//!   `L m_0 h / 2` more from a density with a pole at 0;
//! * tails: one value is cut where `L (1 - F) <= tail`, its grid being doubled until that holds. Sums up to
//!   that value are not touched by it, larger ones by at most the mass that was cut. A distribution with so
//!   heavy a tail that [`MAX_CELLS`] are not enough loses more, nothing worse;
//! * period: the transform is as long as Chernoff's bound says that the sum needs, `P(S > period) <= tail`;
//!   what exceeds it comes back at the low end, as it would not with full padding to `L` times the cells of
//!   one value, which is used where it is shorter;
//! * rounding: about 1e-15 `L`. Masses that it makes negative are set to 0, and the tail above `1 - tail` of
//!   the rest is dropped.

mod power;
mod window;

pub use window::{clt_quantile, empirical_quantile, sums};

use super::gamma_mixture::Mixture;

/// Maximum number of cells of one value.
pub const MAX_CELLS: usize = 1 << 18;

/// Maximum number of cells of a sum.
pub const MAX_SUM_CELLS: usize = 1 << 21;

/// Maximum number of values in a window.
pub const MAX_LENGTH: usize = 100_000;

/// `h`, width of a cell, in the unit of the values.
pub const STEP: f64 = 0.005;

/// `tail`, probability that may be lost at each of the steps listed above.
const TAIL: f64 = 1e-10;

/// Reason why the distribution of a sum cannot be computed.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum AccumulationError {
    /// A window that is empty or too long.
    #[error("a window has 1 to {MAX_LENGTH} values, not {0}")]
    Length(usize),
    /// A distribution function that decreases or leaves `[0, 1]`, or samples that are negative or not finite.
    #[error("values must be 0 or more and finite, and their distribution function must rise from 0 to 1")]
    Distribution,
    /// The sum needs more than [`MAX_SUM_CELLS`] cells, or a sample lies beyond [`MAX_CELLS`].
    #[error("the values or their sums reach over too many cells of {STEP}; take a larger step")]
    TooWide,
    /// A probability outside (0, 1), or a quantile in the tail that was cut off.
    #[error("the distribution has no quantile for the tail probability {0}")]
    Quantile(f64),
}

/// Distribution of a sum of `L` independent values.
#[derive(Debug, Clone, PartialEq)]
pub struct Accumulated {
    length: usize,
    masses: Vec<f64>,
    /// Cumulated masses: entry `j` is `M_0 + ... + M_j`.
    cumulative: Vec<f64>,
}

impl Accumulated {
    /// Distribution of the sum of `length` independent values of a mixture. The masses agree with the
    /// mixture's distribution function up to 1e-12.
    ///
    /// # Errors
    /// Parameters out of range, and sums that need too many cells.
    pub fn of_mixture(mixture: &Mixture, length: usize) -> Result<Self, AccumulationError> {
        check(length)?;
        let cells = cells(|v| mixture.survival(v), length);
        Self::of_masses(power::mixture_masses(mixture, cells), length)
    }

    /// Distribution of the sum of `length` independent values distributed like `samples`. In the paper's
    /// variant, these are random draws of a mixture ([`Mixture::sample`]).
    ///
    /// # Errors
    /// The errors of [`Accumulated::of_mixture`]; also an empty list, and samples that are negative, not finite,
    /// or beyond the cells.
    pub fn from_samples(samples: &[f64], length: usize) -> Result<Self, AccumulationError> {
        check(length)?;
        if samples.is_empty() || !samples.iter().all(|x| x.is_finite() && *x >= 0.0) {
            return Err(AccumulationError::Distribution);
        }
        let largest = samples.iter().fold(0.0_f64, |m, x| m.max(*x)) / STEP;
        if largest >= MAX_CELLS as f64 {
            return Err(AccumulationError::TooWide);
        }
        let mut counts = vec![0_u64; largest as usize + 1];
        for x in samples {
            counts[(x / STEP) as usize] += 1;
        }
        let masses = counts.iter().map(|&n| n as f64 / samples.len() as f64).collect();
        Self::of_masses(masses, length)
    }

    /// Distribution of the sum of values whose cells have these masses.
    fn of_masses(one: Vec<f64>, length: usize) -> Result<Self, AccumulationError> {
        let kept: f64 = one.iter().sum();
        // A distribution function may be off by rounding, its weights by what `Mixture` takes; NaN fails the
        // comparisons.
        let valid = one.iter().all(|m| *m >= -1e-12) && kept > 0.0 && kept <= 1.0 + 2e-6;
        if !valid {
            return Err(AccumulationError::Distribution);
        }
        let one: Vec<f64> = one.into_iter().map(|m| m.max(0.0)).collect();
        let mut masses = if length == 1 { one } else { power::power(&one, length)? };
        let total: f64 = masses.iter().sum();
        let mut above = 0.0;
        while masses.len() > 1 && above + masses[masses.len() - 1] <= TAIL * total {
            above += masses.pop().unwrap_or(0.0);
        }
        let running = |sum: &mut f64, m: &f64| {
            *sum += m;
            Some(sum.min(1.0))
        };
        let cumulative = masses.iter().scan(0.0, running).collect();
        Ok(Self { length, masses, cumulative })
    }

    /// Grid points `v_j` with their masses `M_j`. Divided by the step, the masses are the density `p_2`.
    pub fn masses(&self) -> impl Iterator<Item = (f64, f64)> {
        self.masses.iter().enumerate().map(|(j, &m)| (self.point(j as f64), m))
    }

    /// Probability of a sum up to `v`. Each mass is spread evenly over `h / 2` on both sides of its point.
    /// For `L = 1` this is the distribution function of one value at all multiples of `h`.
    pub fn cdf(&self, v: f64) -> f64 {
        if v.is_nan() {
            return f64::NAN;
        }
        let last = self.masses.len() - 1;
        // In cells from the lower end of the first mass.
        let at = v / STEP - (self.length as f64 - 1.0) / 2.0;
        if at <= 0.0 {
            return 0.0;
        }
        let j = at as usize;
        if j > last {
            return self.cumulative[last];
        }
        let below = if j == 0 { 0.0 } else { self.cumulative[j - 1] };
        below + (self.cumulative[j] - below) * (at - j as f64)
    }

    /// `beta`: the smallest grid point at which the cumulated masses reach `1 - alpha`. It is within `h / 2`
    /// of the value at which [`Accumulated::cdf`] is `1 - alpha`.
    ///
    /// # Errors
    /// An `alpha` outside (0, 1), or in the tail that was cut off.
    pub fn upper_quantile(&self, alpha: f64) -> Result<f64, AccumulationError> {
        Ok(self.point(self.reaches(alpha)? as f64))
    }

    fn reaches(&self, alpha: f64) -> Result<usize, AccumulationError> {
        if !(alpha > 0.0 && alpha < 1.0) {
            return Err(AccumulationError::Quantile(alpha));
        }
        let j = self.cumulative.partition_point(|&sum| sum < 1.0 - alpha);
        if j < self.cumulative.len() { Ok(j) } else { Err(AccumulationError::Quantile(alpha)) }
    }

    fn point(&self, j: f64) -> f64 {
        (j + self.length as f64 / 2.0) * STEP
    }
}

fn check(length: usize) -> Result<(), AccumulationError> {
    if (1..=MAX_LENGTH).contains(&length) { Ok(()) } else { Err(AccumulationError::Length(length)) }
}

/// Number of cells for one value: doubled until `L` tails are small enough, then reduced by bisection.
fn cells(survival: impl Fn(f64) -> f64, length: usize) -> usize {
    let enough = |cells: usize| length as f64 * survival(cells as f64 * STEP) <= TAIL;
    let mut high = 1;
    while high < MAX_CELLS && !enough(high) {
        high *= 2;
    }
    let mut low = high / 2;
    // To within a part in 64; the number need not be the least.
    while high - low > 1 + high / 64 {
        let middle = low + (high - low) / 2;
        if enough(middle) {
            high = middle;
        } else {
            low = middle;
        }
    }
    high.min(MAX_CELLS)
}

#[cfg(test)]
mod tests;
