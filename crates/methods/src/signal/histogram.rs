//! Shared by the two histogram signals: weights, the frame that is compared with, and the coefficient.

use crate::image::Window;
use crate::plugin::ParamError;
use crate::saved;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Histogram that a frame's is compared with.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Reference {
    /// The histogram of the frame before.
    Previous,
    /// The histogram of the first frame.
    First,
}

/// Four times the weight `(w / 2)^2 + (h / 2)^2 + 1 - dist^2` of pixel (`j`, `i`) of a window, where
/// `dist` is its distance to the center; a whole number, above 0.
pub fn weight(window: &Window, j: usize, i: usize) -> u64 {
    let from_center = |at: usize, side: usize| (2 * at + 1).abs_diff(side) as u64;
    let (w, h) = (window.w as u64, window.h as u64);
    w * w + h * h + 4 - from_center(j, window.w).pow(2) - from_center(i, window.h).pow(2)
}

/// Bin of a value when 0..=255 is divided into `bins` equal ones.
pub fn bin(value: u8, bins: usize) -> usize {
    usize::from(value) * bins / 256
}

/// Checks a number of bins.
pub fn check_bins(key: &'static str, bins: usize) -> Result<(), ParamError> {
    let good = (1..=256).contains(&bins);
    good.then_some(()).ok_or_else(|| ParamError::out_of_range(key, "1 to 256", bins))
}

/// Bhattacharyya coefficient `sum_u sqrt(p_u q_u)` of two histograms that are first normalized to sum 1;
/// in `[0, 1]`. Two empty histograms are alike (1), an empty one is unlike any other (0).
pub fn bhattacharyya(p: &[u64], q: &[u64]) -> f64 {
    let (all_p, all_q) = (p.iter().sum::<u64>() as f64, q.iter().sum::<u64>() as f64);
    if all_p == 0.0 || all_q == 0.0 {
        return if all_p == all_q { 1.0 } else { 0.0 };
    }
    let common: f64 = p.iter().zip(q).map(|(&a, &b)| (a as f64 * b as f64).sqrt()).sum();
    (common / (all_p * all_q).sqrt()).min(1.0)
}

/// Histograms of a track: the reference, and room for the next one.
pub struct Memory {
    rule: Reference,
    reference: Vec<u64>,
    now: Vec<u64>,
    started: bool,
}

impl Memory {
    /// Before the first frame.
    pub fn new(rule: Reference, bins: usize) -> Self {
        Self { rule, reference: vec![0; bins], now: vec![0; bins], started: false }
    }

    /// Fills the histogram of the next frame and compares it; 1 in the first frame.
    pub fn push(&mut self, fill: impl FnOnce(&mut [u64])) -> f64 {
        self.now.fill(0);
        fill(&mut self.now);
        let value = if self.started { bhattacharyya(&self.now, &self.reference) } else { 1.0 };
        if !self.started || self.rule == Reference::Previous {
            std::mem::swap(&mut self.now, &mut self.reference);
        }
        self.started = true;
        value
    }

    /// The reference, if there is one yet.
    pub fn save(&self) -> Option<Vec<u8>> {
        saved::to_bytes(&self.started.then_some(&self.reference))
    }

    /// Takes over a saved reference; `false` if it is none of this size.
    pub fn restore(&mut self, saved: &[u8]) -> bool {
        let Some(reference) = saved::from_bytes::<Option<Vec<u64>>>(saved) else { return false };
        let Some(reference) = reference else { return true };
        let sum = reference.iter().try_fold(0_u64, |sum, v| sum.checked_add(*v));
        if reference.len() != self.reference.len() || sum.is_none() {
            return false;
        }
        (self.reference, self.started) = (reference, true);
        true
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn weights_of_a_small_window() {
        // 3 x 2 pixels, center (1.5, 1): at the corner dist^2 = 1 + 1/4, at the middle 1/4; wmax 17/4.
        let window = Window { x: 7, y: 9, w: 3, h: 2 };
        assert_eq!(weight(&window, 0, 0), 17 - 5);
        assert_eq!(weight(&window, 1, 1), 17 - 1);
    }

    #[test]
    fn coefficient_by_hand() {
        // p = (1/4, 3/4), q = (1, 0): sqrt(1/4).
        assert_eq!(bhattacharyya(&[1, 3], &[5, 0]), 0.5);
        assert_eq!(bhattacharyya(&[0, 0], &[0, 0]), 1.0);
        assert_eq!(bhattacharyya(&[0, 0], &[0, 2]), 0.0);
    }

    proptest! {
        #[test]
        fn coefficient_is_bounded_and_symmetric(
            p in proptest::collection::vec(0..1_000_000_u64, 12),
            q in proptest::collection::vec(0..1_000_000_u64, 12),
        ) {
            let rho = bhattacharyya(&p, &q);
            prop_assert!((0.0..=1.0).contains(&rho));
            prop_assert_eq!(rho, bhattacharyya(&q, &p));
            prop_assert_eq!(bhattacharyya(&p, &p), 1.0);
            // Only the shape counts.
            let doubled: Vec<u64> = p.iter().map(|v| 2 * v).collect();
            prop_assert!((bhattacharyya(&doubled, &q) - rho).abs() < 1e-12);
        }
    }
}
