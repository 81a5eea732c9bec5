//! Similarity of the target's joint color and texture histograms, as the detector RLHist of the DTEF
//! paper uses it (Ning, Zhang, Zhang and Wu, IJPRAI 23(7), 2009). Low values speak for a failure.
//!
//! ```text
//! code  = number of ones among the bits [g_k >= g + a], k = 0..7, where the ring of bits has at most two
//!         changes, else 9                                  (rotation invariant uniform LBP, P 8, R 1)
//! p_u   = weighted share of the pixels with code 2..6 that fall into bin u = (R, G, B, code)
//! rho_t = sum_u sqrt(p_u(t) q_u)                           Bhattacharyya coefficient, in [0, 1]
//! ```
//!
//! `g` is the gray value round(0.2989 R + 0.5870 G + 0.1140 B), `g_k` the gray values at distance 1 around
//! it (those on the diagonals interpolated bilinearly; 1e-6 is added so that equal values count as equal),
//! `a` the threshold 8. The frame is surrounded by zeros. Codes 0, 1, 7, 8 and 9 (flat places, spots and
//! what is not uniform) are left out; what remains are line ends, edges and corners. Weights are those
//! of [`super::rgb_histogram`], `q` too.
//!
//! Choices: 8 x 8 x 1 x 5 bins as in the authors' demonstration (the article is recalled to say
//! 8 x 8 x 8 x 5: `blue_bins = 8`); rho is 1 when no pixel remains in either frame and 0 when none remains
//! in one of them. `codes`, `colors`, `weights`, `similarity` and `reference` are other readings, the first of each the default;
//! `size_history` gives the box the mean sides of its past.

use super::histogram::{self, Colors, Comparison, Reference, Similarity, Weights, color_bin, counts};
use crate::image::luma;
use crate::signal::prelude::*;
use std::f64::consts::FRAC_1_SQRT_2;

pub(crate) const ENTRY: Entry<dyn Signal> = Entry::of::<Params>(
    "rgb-lbp-histogram",
    1,
    "Bhattacharyya coefficient of joint color and LBP histograms, this frame against the one before",
)
.example("{ lbp_threshold = 8.0 }");

/// Code of rings with more than two changes.
const NOT_UNIFORM: usize = 9;

/// Codes that are kept.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Codes {
    /// Codes 2 to 6: line ends, edges and corners.
    Edges,
    /// Codes 0 to 8: all that are uniform.
    Uniform,
    /// Codes 0 to 9: all.
    All,
}

impl Codes {
    fn kept(self) -> std::ops::Range<usize> {
        match self {
            Self::Edges => 2..7,
            Self::Uniform => 0..NOT_UNIFORM,
            Self::All => 0..NOT_UNIFORM + 1,
        }
    }
}

/// Parameters of the signal.
#[derive(Debug, Clone, SmartDefault, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Params {
    /// Number of bins for red, 1 to 256.
    #[default(8)]
    pub red_bins: usize,
    /// Number of bins for green, 1 to 256.
    #[default(8)]
    pub green_bins: usize,
    /// Number of bins for blue, 1 to 256; the product of all three is at most 262144.
    #[default(1)]
    pub blue_bins: usize,
    /// Least difference in gray values at which a neighbor counts as brighter, 0 to 255.
    #[default(8.0)]
    pub lbp_threshold: f64,
    /// Reference histogram.
    #[default(Reference::Previous)]
    pub reference: Reference,
    /// Share of a frame in the slow model, above 0 and at most 1.
    #[default(0.05)]
    pub rate: f64,
    /// Color space whose channels are binned.
    #[default(Colors::Rgb)]
    pub colors: Colors,
    /// Weights of the pixels.
    #[default(Weights::Parabola)]
    pub weights: Weights,
    /// Similarity of two histograms.
    #[default(Similarity::Bhattacharyya)]
    pub similarity: Similarity,
    /// Codes that are kept.
    #[default(Codes::Edges)]
    pub codes: Codes,
    /// Number of frames before whose boxes' sides are averaged with the box's own, 0 to 1000.
    #[serde(skip_serializing_if = "is_default")]
    pub size_history: usize,
}

impl Params {
    /// Numbers of bins of the color channels.
    fn color_bins(&self) -> [usize; 3] {
        [self.red_bins, self.green_bins, self.blue_bins]
    }

    /// Number of bins of the joint histogram.
    fn bins(&self) -> usize {
        self.color_bins().iter().product::<usize>() * self.codes.kept().len()
    }
}

impl PlainParams for Params {
    const RANGES: &'static [Range] = &[
        Range::within("red_bins", 1.0, 256.0),
        Range::within("green_bins", 1.0, 256.0),
        Range::within("blue_bins", 1.0, 256.0),
        Range::within("lbp_threshold", 0.0, 255.0),
        histogram::RATE,
        SIZE_HISTORY,
    ];

    fn check(&self) -> Result<(), ParamError> {
        let all: usize = self.color_bins().iter().product();
        ParamError::unless(all <= 262_144, "blue_bins", "small enough for 262144 bins in all", all)
    }
}

impl Causal for Params {
    type Memory = Option<Vec<f64>>;

    fn facts(&self) -> Facts {
        histogram::FACTS
    }

    fn push(&self, memory: &mut Self::Memory, &Observation { frame, state, .. }: &Observation<'_>) -> f64 {
        let Params { lbp_threshold, reference, rate, colors, weights, similarity, .. } = *self;
        let window = Window::on_frame(&state.region.rect(), frame);
        let (gray, stride) = (read_gray(frame, &window), window.w + 2);
        let (kept, color_bins) = (self.codes.kept(), self.color_bins());
        let bin_of = |j: usize, i: usize, rgb: [u8; 3]| {
            let code = lbp_code(&gray, stride, (i + 1) * stride + j + 1, lbp_threshold);
            kept.contains(&code)
                .then(|| color_bin(colors.of(rgb), color_bins) * kept.len() + code - kept.start)
        };
        let now = counts(frame, &window, weights, self.bins(), bin_of);
        Comparison { reference, rate, similarity }.push(memory, now)
    }

    fn size_history(&self) -> usize {
        self.size_history
    }

    fn is_memory(&self, memory: &Self::Memory) -> bool {
        histogram::is_memory(memory.as_deref(), self.bins())
    }
}

/// Gray values of a window on the frame with a rim of one pixel, `(w + 2) * (h + 2)`; 0 outside the frame.
fn read_gray(frame: &Frame, window: &Window) -> Vec<f64> {
    let mut gray = Vec::with_capacity((window.w + 2) * (window.h + 2));
    for y in window.y - 1..=window.y + window.h as i64 {
        for x in window.x - 1..=window.x + window.w as i64 {
            let inside = (0..frame.width() as i64).contains(&x) && (0..frame.height() as i64).contains(&y);
            gray.push(if inside { f64::from(luma(frame.pixel(x as usize, y as usize))) } else { 0.0 });
        }
    }
    gray
}

/// Rotation invariant uniform LBP code of the value at `at`, 0..=9.
fn lbp_code(gray: &[f64], stride: usize, at: usize, threshold: f64) -> usize {
    let center = gray[at];
    let (up, down, left, right) = (gray[at - stride], gray[at + stride], gray[at - 1], gray[at + 1]);
    // The place (s, s) between four pixels, s = cos 45 degrees.
    let (s, t) = (FRAC_1_SQRT_2, 1.0 - FRAC_1_SQRT_2);
    let diagonal = |corner: f64, a: f64, b: f64| s * s * corner + s * t * (a + b) + t * t * center;
    let ring = [
        right,
        diagonal(gray[at - stride + 1], right, up),
        up,
        diagonal(gray[at - stride - 1], up, left),
        left,
        diagonal(gray[at + stride - 1], left, down),
        down,
        diagonal(gray[at + stride + 1], down, right),
    ];
    let bits = ring.map(|value| value + 1e-6 >= center + threshold);
    let changes = (0..8).filter(|&k| bits[k] != bits[(k + 1) % 8]).count();
    if changes > 2 { NOT_UNIFORM } else { bits.iter().filter(|&&bit| bit).count() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn codes_by_hand() {
        let code = |gray: [u8; 9]| lbp_code(&gray.map(f64::from), 3, 4, 8.0);
        assert_eq!(code([7; 9]), 0);
        // An edge: the three to the right are brighter, the diagonals above and below among them.
        assert_eq!(code([0, 0, 100, 0, 0, 100, 0, 0, 100]), 3);
        // A dark spot.
        assert_eq!(code([100, 100, 100, 100, 0, 100, 100, 100, 100]), 8);
        // Exactly the threshold is enough for one neighbor.
        assert_eq!(code([0, 0, 0, 0, 0, 8, 0, 0, 0]), 1);
        assert_eq!(code([0, 0, 0, 0, 0, 7, 0, 0, 0]), 0);
        // Between 8, 8, 8 and the center 0 lies 8 (1 - (1 - s)^2) = 7.3: the diagonals stay below.
        assert_eq!(code([8, 8, 8, 8, 0, 8, 8, 8, 8]), 9);
        // Without a threshold equal values count, interpolated ones too.
        assert_eq!(lbp_code(&[7.0; 9], 3, 4, 0.0), 8);
        assert_eq!([Codes::Edges, Codes::Uniform, Codes::All].map(Codes::kept), [2..7, 0..9, 0..10]);
        // A cross: right and left alone.
        assert_eq!(code([0, 0, 0, 10, 0, 10, 0, 0, 0]), 9);
    }
}
