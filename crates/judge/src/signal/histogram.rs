//! Shared code of both histogram signals: weights, colors, the reference histogram, and the similarity.

use super::{Direction, Facts};
use crate::image::{Frame, Window};
use crate::plugin::Range;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Reference histogram, with which a frame's is compared.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Reference {
    /// Histogram of the frame before.
    Previous,
    /// Histogram of the first frame.
    First,
    /// A model that is updated: `q <- (1 - rate) q + rate p` after each frame.
    Slow,
}

/// Similarity of two histograms with the shares p and q.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Similarity {
    /// Bhattacharyya coefficient `rho = sum_u sqrt(p_u q_u)`.
    Bhattacharyya,
    /// `1 - sqrt(1 - rho)`, 1 minus the distance for the coefficient.
    Distance,
    /// Intersection `sum_u min(p_u, q_u)`.
    Intersection,
}

/// Weights of the pixels of a box.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Weights {
    /// Weights by [`weight`], which decrease towards the border.
    Parabola,
    /// Equal weights.
    Uniform,
}

impl Weights {
    /// Weight of pixel (`j`, `i`) of a window.
    pub fn of(self, window: &Window, j: usize, i: usize) -> f64 {
        match self {
            Self::Parabola => weight(window, j, i) as f64,
            Self::Uniform => 1.0,
        }
    }
}

/// Color space whose channels are read.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Colors {
    /// Red, green, blue.
    #[default]
    Rgb,
    /// Hue, saturation and value, each scaled to 0..=255.
    Hsv,
}

impl Colors {
    /// Channels of a pixel, 0 to 255.
    pub fn of(self, rgb: [u8; 3]) -> [u8; 3] {
        match self {
            Self::Rgb => rgb,
            Self::Hsv => hsv(rgb),
        }
    }
}

/// Hue, saturation and value (Smith, SIGGRAPH 1978), each scaled to 0..=255; gray has hue 0.
fn hsv(rgb: [u8; 3]) -> [u8; 3] {
    let [r, g, b] = rgb.map(f64::from);
    let (most, least) = (r.max(g).max(b), r.min(g).min(b));
    let range = most - least;
    let sixth = match range {
        0.0 => 0.0,
        _ if most == r => ((g - b) / range).rem_euclid(6.0),
        _ if most == g => (b - r) / range + 2.0,
        _ => (r - g) / range + 4.0,
    };
    let saturation = if most > 0.0 { range / most } else { 0.0 };
    [(sixth / 6.0 * 256.0).min(255.0) as u8, (saturation * 255.0).round() as u8, most as u8]
}

/// Four times the weight `(w / 2)^2 + (h / 2)^2 + 1 - dist^2` of pixel (`j`, `i`) of a window, with `dist`
/// its distance to the center; a positive integer.
pub fn weight(window: &Window, j: usize, i: usize) -> u64 {
    let from_center = |at: usize, side: usize| (2 * at + 1).abs_diff(side) as u64;
    let (w, h) = (window.w as u64, window.h as u64);
    w * w + h * h + 4 - from_center(j, window.w).pow(2) - from_center(i, window.h).pow(2)
}

/// Bin of a color. Each channel (0..=255) is divided into equal bins.
pub fn color_bin(channels: [u8; 3], bins: [usize; 3]) -> usize {
    channels.iter().zip(bins).fold(0, |at, (value, bins)| at * bins + usize::from(*value) * bins / 256)
}

/// Similarity of two histograms, which are first normalized to sum 1; in `[0, 1]`. It is 1 for two empty
/// histograms, 0 for an empty and a nonempty one.
pub fn similarity(kind: Similarity, p: &[f64], q: &[f64]) -> f64 {
    let (all_p, all_q) = (p.iter().sum::<f64>(), q.iter().sum::<f64>());
    if all_p == 0.0 || all_q == 0.0 {
        return if all_p == all_q { 1.0 } else { 0.0 };
    }
    let pairs = p.iter().zip(q);
    let rho = || (pairs.clone().map(|(a, b)| (a * b).sqrt()).sum::<f64>() / (all_p * all_q).sqrt()).min(1.0);
    match kind {
        Similarity::Bhattacharyya => rho(),
        Similarity::Distance => 1.0 - (1.0 - rho()).sqrt(),
        Similarity::Intersection => pairs.map(|(a, b)| (a / all_p).min(b / all_q)).sum::<f64>().min(1.0),
    }
}

/// Range of `rate`, the share of a frame in the slow model.
pub const RATE: Range = Range::of("rate").above(0.0).at_most(1.0);

/// Facts of both signals.
pub const FACTS: Facts = Facts::of(Direction::HigherIsBetter, (0.0, 1.0));

/// Weight sums of a box's pixels by color bin. Pixels without a bin are ignored.
pub fn counts(
    frame: &Frame,
    window: &Window,
    weights: Weights,
    bins: usize,
    bin_of: impl Fn(usize, usize, [u8; 3]) -> Option<usize>,
) -> Vec<f64> {
    let (x0, y0) = (window.x as usize, window.y as usize);
    let mut histogram = vec![0.0; bins];
    for i in 0..window.h {
        let row = &frame.row(y0 + i)[3 * x0..3 * (x0 + window.w)];
        for (j, rgb) in row.chunks_exact(3).enumerate() {
            if let Some(bin) = bin_of(j, i, [rgb[0], rgb[1], rgb[2]]) {
                histogram[bin] += weights.of(window, j, i);
            }
        }
    }
    histogram
}

/// Parameters that both signals share.
#[derive(Debug, Clone, Copy)]
pub struct Comparison {
    /// Reference histogram.
    pub reference: Reference,
    /// Share of a frame in the slow model.
    pub rate: f64,
    /// Similarity of two histograms.
    pub similarity: Similarity,
}

impl Comparison {
    /// Compares the histogram of the next frame with the reference, which is then updated; 1 in the first
    /// frame.
    pub fn push(self, memory: &mut Option<Vec<f64>>, now: Vec<f64>) -> f64 {
        let Some(before) = memory else {
            *memory = Some(now);
            return 1.0;
        };
        let value = similarity(self.similarity, &now, before);
        match self.reference {
            Reference::First => {}
            Reference::Previous => *before = now,
            Reference::Slow => blend(before, &now, self.rate),
        }
        value
    }
}

/// True if a memory is a valid histogram with this number of bins.
pub fn is_memory(memory: Option<&[f64]>, bins: usize) -> bool {
    memory.is_none_or(|shares| shares.len() == bins && shares.iter().all(|v| (0.0..1e18).contains(v)))
}

/// Moves the shares of a model towards those of a histogram. An empty histogram is ignored.
fn blend(model: &mut [f64], now: &[f64], rate: f64) {
    let (all_model, all_now) = (model.iter().sum::<f64>(), now.iter().sum::<f64>());
    if all_now == 0.0 {
        return;
    }
    for (q, p) in model.iter_mut().zip(now) {
        let share = if all_model > 0.0 { *q / all_model } else { *p / all_now };
        *q = (1.0 - rate) * share + rate * p / all_now;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn bhattacharyya(p: &[f64], q: &[f64]) -> f64 {
        similarity(Similarity::Bhattacharyya, p, q)
    }

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
        assert_eq!(bhattacharyya(&[1.0, 3.0], &[5.0, 0.0]), 0.5);
        assert_eq!(bhattacharyya(&[0.0, 0.0], &[0.0, 0.0]), 1.0);
        assert_eq!(bhattacharyya(&[0.0, 0.0], &[0.0, 2.0]), 0.0);
        assert_eq!(similarity(Similarity::Intersection, &[1.0, 3.0], &[5.0, 0.0]), 0.25);
        assert_eq!(similarity(Similarity::Intersection, &[1.0, 0.0], &[1.0, 3.0]), 0.25);
        assert_eq!(similarity(Similarity::Distance, &[1.0, 3.0], &[1.0, 3.0]), 1.0);
        let distance = similarity(Similarity::Distance, &[1.0, 3.0], &[5.0, 0.0]);
        assert!((distance - (1.0 - 0.5_f64.sqrt())).abs() < 1e-15);
    }

    #[test]
    fn a_slow_model_by_hand() {
        // Half of (1, 0) and half of (0, 1); a frame without pixels changes nothing.
        let comparison =
            Comparison { reference: Reference::Slow, rate: 0.5, similarity: Similarity::Intersection };
        let mut memory = None;
        let mut push = |p: [f64; 2]| comparison.push(&mut memory, p.to_vec());
        assert_eq!(
            [push([4.0, 0.0]), push([0.0, 3.0]), push([0.0, 0.0]), push([7.0, 7.0]), push([1.0, 3.0])],
            [1.0, 0.0, 0.0, 1.0, 0.75]
        );
        // A model without pixels becomes the first histogram with some.
        let mut memory = None;
        let mut push = |p: [f64; 2]| comparison.push(&mut memory, p.to_vec());
        assert_eq!([push([0.0, 0.0]), push([0.0, 3.0]), push([1.0, 3.0])], [1.0, 0.0, 0.75]);
    }

    // colorsys.rgb_to_hsv(1, .5, 0) = (1/12, 1, 1); (0, 0, 1): hue 2/3; (.2, .4, .2): (1/3, .5, .4); (.2, .4, 0): hue 1/4;
    // (.4, 0, .8): hue 3/4; (.2, .4, .8): hue 11/18 (Python 3.12).
    #[test]
    fn hues_agree_with_colorsys() {
        assert_eq!(hsv([255, 128, 0]), [(256.0_f64 * 128.0 / 255.0 / 6.0) as u8, 255, 255]);
        assert_eq!(hsv([0, 0, 255]), [170, 255, 255]);
        assert_eq!(hsv([51, 102, 51]), [85, 128, 102]);
        assert_eq!([[51, 102, 0], [102, 0, 204], [51, 102, 204]].map(|rgb| hsv(rgb)[0]), [64, 192, 156]);
        assert_eq!(hsv([9, 9, 9]), [0, 0, 9]);
        assert_eq!(hsv([0, 0, 0]), [0, 0, 0]);
        assert_eq!(hsv([255, 0, 1])[0], 255);
    }
}
