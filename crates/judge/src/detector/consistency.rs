//! Model of a consistent filter: a mixture of Gammas fitted to the values of c_t in consistent frames
//! (SanMiguel and Cavallaro, CVIU 131, 2015, Eq. 12-15, 18 and 24).
//!
//! ```text
//! consistent frames C = {t : e[t] < tau}           Eq. 24        p_1 = mixture of Gammas fitted to c[t], t in C
//! ```
//!
//! `e` is the tracking error in `[0, 1]`, `c` the change signal c_t, without unit; `t` is a 0-based frame. Frames
//! without ground truth are left out, and so are the frames at the start of a track in which c_t is exactly 0
//! because it has no reference yet.

use super::DetectorOutput;
use super::example::Example;
use crate::num::accumulation::sums;
use crate::num::gamma_mixture::select::{self, Criterion, MAX_PENALTY_WEIGHT};
use crate::num::gamma_mixture::{Binned, Clipped, Fit, FitError, FitOptions, Mixture, SampleError, fit_all};
use serde::{Deserialize, Serialize};

/// Number of frames at the start of a track in which c_t is exactly 0, because it has no reference yet.
pub fn undefined_frames(signal: &[f64]) -> usize {
    signal.iter().position(|c| *c != 0.0).unwrap_or(signal.len())
}

/// Runs `detect` on the frames in which c_t is defined. Earlier frames have score 0 and no alarm.
pub fn on_defined_frames(signal: &[f64], detect: impl Fn(&[f64]) -> DetectorOutput) -> DetectorOutput {
    let undefined = undefined_frames(signal);
    let mut output = detect(&signal[undefined..]);
    output.score.splice(0..0, std::iter::repeat_n(0.0, undefined));
    output.alarm.splice(0..0, std::iter::repeat_n(false, undefined));
    if let Some(changes) = &mut output.changes {
        changes.splice(0..0, std::iter::repeat_n(0, undefined));
    }
    output
}

/// Values of c_t in the consistent frames of a track.
pub fn consistent_changes<'a>(example: &Example<'a>, tau: f64) -> impl Iterator<Item = f64> + use<'a> {
    let (signal, error) = (example.signal, example.error);
    let first = undefined_frames(signal);
    let frames = signal.iter().zip(error).skip(first);
    frames.filter(move |(_, e)| **e < tau).map(|(c, _)| *c)
}

/// Sums of `length` successive values of c_t in consistent frames of a track.
pub fn consistent_sums(example: &Example<'_>, tau: f64, length: usize) -> Vec<f64> {
    let (signal, error) = (example.signal, example.error);
    let first = undefined_frames(signal);
    let (signal, error) = (&signal[first..], &error[first.min(error.len())..]);
    let mut run = 0;
    let mut ends = Vec::new();
    for (s, e) in sums(signal, length).into_iter().zip(error) {
        run = if *e < tau { run + 1 } else { 0 };
        if run >= length {
            ends.push(s);
        }
    }
    ends
}

/// An order of the mixture that was tried.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Order {
    /// Number of components.
    pub components: usize,
    /// Largest log-likelihood of a mixture of this order.
    pub log_likelihood: f64,
    /// Number of penalty weights for which dAIC chooses this order.
    pub wins_daic: usize,
    /// Number of penalty weights for which dBIC chooses this order.
    pub wins_dbic: usize,
}

/// Learned model of c_t for a consistent filter.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ConsistencyModel {
    /// Error below which a frame counts as consistent.
    pub tau: f64,
    /// Number of values of c_t used for learning.
    pub samples: u64,
    /// Numbers of values that were raised to the floor, and of values beyond the last cell.
    pub clipped: Clipped,
    /// Mean of the values of c_t.
    pub mean: f64,
    /// Variance of the values of c_t.
    pub variance: f64,
    /// All orders that were tried.
    pub orders: Vec<Order>,
    /// Order that dAIC chooses most often, other than 1; 1 if there is no other.
    pub order_daic: usize,
    /// Order that dBIC chooses most often, other than 1; 1 if there is no other.
    pub order_dbic: usize,
    /// Mixture of the chosen order, p_1.
    pub mixture: Mixture,
}

/// Settings of a fit.
#[derive(Debug, Clone)]
pub struct Fitting {
    /// Error below which a frame is consistent.
    pub tau: f64,
    /// Order of the mixture; `None` to choose it.
    pub components: Option<usize>,
    /// Largest order to try.
    pub max_components: usize,
    /// Criterion that chooses the order.
    pub criterion: Criterion,
}

impl Fitting {
    /// Settings that choose the order by dBIC.
    pub fn by_bic(tau: f64, max_components: usize) -> Self {
        Self { tau, components: None, max_components, criterion: Criterion::Bic }
    }
}

/// A model, and the fits from which it was chosen.
pub struct Fitted {
    /// Model of consistent frames that was learned.
    pub model: ConsistencyModel,
    /// The fits of all orders.
    pub fits: Vec<Fit>,
    /// Order that dAIC chooses for each penalty weight.
    pub daic: Vec<usize>,
    /// Order that dBIC chooses for each penalty weight.
    pub dbic: Vec<usize>,
}

/// Reason why no model can be learned.
#[derive(Debug, thiserror::Error)]
pub enum ConsistencyError {
    /// A value of c_t is negative, not finite or too large.
    #[error("c_t of the training tracks: {0}")]
    Sample(#[source] SampleError),
    /// The values cannot be fitted, usually because there are too few.
    #[error("a mixture of Gammas for errors below {tau}: {source}")]
    Mixture {
        /// Error below which a frame counts as consistent.
        tau: f64,
        /// Error of the fit.
        source: FitError,
    },
    /// The requested order was not fitted.
    #[error("no mixture of {0} components")]
    Order(usize),
}

/// Fits a model to the consistent frames of tracks.
///
/// # Errors
/// See [`ConsistencyError`].
pub fn fit(examples: &[Example<'_>], how: &Fitting) -> Result<Fitted, ConsistencyError> {
    let mut binned = Binned::default();
    let (mut sum, mut n) = (0.0, 0.0);
    for c in examples.iter().flat_map(|e| consistent_changes(e, how.tau)) {
        binned.add(c).map_err(ConsistencyError::Sample)?;
        (sum, n) = (sum + c, n + 1.0);
    }
    let mean = sum / n;
    let squares = examples.iter().flat_map(|e| consistent_changes(e, how.tau)).map(|c| (c - mean).powi(2));
    let variance = squares.sum::<f64>() / n;
    let most = how.components.unwrap_or(how.max_components);
    let options = FitOptions::default();
    let mut fits = fit_all(&binned, most, &options);
    // Few samples carry few components.
    for fewer in (1..most).rev() {
        if how.components.is_some() || !matches!(fits, Err(FitError::TooFew { .. })) {
            break;
        }
        fits = fit_all(&binned, fewer, &options);
    }
    let fits = fits.map_err(|source| ConsistencyError::Mixture { tau: how.tau, source })?;
    let terms = select::terms(&fits, binned.count());
    let choose = |criterion| select::choose(&terms, criterion, MAX_PENALTY_WEIGHT);
    let (daic, dbic) = (choose(Criterion::Aic), choose(Criterion::Bic));
    let chosen = match how.criterion {
        Criterion::Aic => daic.order,
        Criterion::Bic => dbic.order,
    };
    let order = how.components.or(chosen).unwrap_or(1);
    let fit = fits.get(order.wrapping_sub(1)).ok_or(ConsistencyError::Order(order))?;
    let wins = |winners: &[usize], k: usize| winners.iter().filter(|w| **w == k).count();
    let orders = fits.iter().enumerate().map(|(i, fit)| Order {
        components: i + 1,
        log_likelihood: fit.log_likelihood,
        wins_daic: wins(&daic.winners, i + 1),
        wins_dbic: wins(&dbic.winners, i + 1),
    });
    let model = ConsistencyModel {
        tau: how.tau,
        samples: binned.count(),
        clipped: binned.clipped(),
        mean,
        variance,
        orders: orders.collect(),
        order_daic: daic.order.unwrap_or(1),
        order_dbic: dbic.order.unwrap_or(1),
        mixture: fit.mixture.clone(),
    };
    Ok(Fitted { model, fits, daic: daic.winners, dbic: dbic.winners })
}

#[cfg(test)]
mod tests {
    use super::*;

    // By hand: the first two frames have no reference, frames 4 and 5 are lost, frame 7 is not annotated.
    #[test]
    fn lost_unknown_and_undefined_frames_are_left_out() {
        let signal = [0.0, 0.0, 1.0, 2.0, 4.0, 8.0, 16.0, 32.0, 64.0, 128.0, 0.0];
        let error = [0.1, 0.1, 0.1, 0.1, 1.0, 0.95, 0.1, f64::NAN, 0.1, 0.1, 0.1];
        let example = Example::new(&signal, &error);
        let changes = |tau| consistent_changes(&example, tau).collect::<Vec<_>>();
        assert_eq!(changes(0.9), [1.0, 2.0, 16.0, 64.0, 128.0, 0.0]);
        assert_eq!(changes(1.0), [1.0, 2.0, 8.0, 16.0, 64.0, 128.0, 0.0]);
        assert_eq!(consistent_sums(&example, 0.9, 2), [3.0, 192.0, 128.0]);
        for tau in [0.9, 0.95] {
            assert_eq!(consistent_sums(&example, tau, 1), changes(tau));
        }
        assert!(consistent_sums(&example, 0.9, 12).is_empty());
        let never = Example::new(&[0.0; 5], &[0.0; 5]);
        assert_eq!(consistent_changes(&never, 0.9).count() + consistent_sums(&never, 0.9, 1).len(), 0);
    }

    #[test]
    fn few_samples_carry_few_components_and_none_are_an_error() {
        let signal = [0.5, 0.25, 0.7, 0.1, 0.9, 1.5, 0.4];
        let example = Example::new(&signal, &[0.0; 7]);
        let how = Fitting::by_bic(0.9, 10);
        let fitted = fit(&[example], &how).unwrap();
        assert_eq!((fitted.model.samples, fitted.fits.len()), (7, 2));
        let terms = select::terms(&fitted.fits, 7);
        for (k, order) in fitted.model.orders.iter().enumerate() {
            let wins = [Criterion::Aic, Criterion::Bic].map(|criterion| {
                let winners = select::choose(&terms, criterion, MAX_PENALTY_WEIGHT).winners;
                winners.into_iter().filter(|winner| *winner == k + 1).count()
            });
            assert_eq!((order.components, [order.wins_daic, order.wins_dbic]), (k + 1, wins));
        }
        assert!((fitted.model.mean - signal.iter().sum::<f64>() / 7.0).abs() < 1e-12);
        let lost = Example::new(&signal, &[1.0; 7]);
        assert!(fit(&[lost], &how).is_err());
    }
}
