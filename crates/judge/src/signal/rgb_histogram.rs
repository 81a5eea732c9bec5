//! Similarity of the target's RGB histograms, as the detector RgbHist of the DTEF paper uses it (target
//! representation of Ning, Zhang, Zhang and Wu, IJPRAI 23(7), 2009). Low values speak for a failure.
//!
//! ```text
//! p_u   = sum_{pixels of bin u} w(pixel) / sum_{pixels} w(pixel),  bin = floor(value / (256 / 8))
//! w     = (w / 2)^2 + (h / 2)^2 + 1 - dist^2        dist: pixels from the center of the box
//! rho_t = sum_u sqrt(p_u(t) q_u)                    Bhattacharyya coefficient, in [0, 1]
//! ```
//!
//! `q` is the histogram of frame t - 1 or of the first frame (`reference`); rho is 1 in the first frame.
//! Bins, weights and joint binning follow the authors' published demonstration as described in public.
//! The paper does not say which frame DTEF compares with. The frame before is chosen: against a fixed first frame the
//! coefficient soon stays below the printed threshold 0.88. `reference` "slow" is a model that follows; `colors`, `weights`
//! and `similarity` are other readings of what the paper leaves open, the first of each the default. `channels = "separate"` takes
//! three histograms, of one channel each, for one of all colors; `size_history` gives the box the mean sides of its past. Boxes
//! that leave the frame are shifted inside, larger ones cut to the frame.

use super::histogram::{self, Colors, Comparison, Reference, Similarity, Weights, color_bin, counts};
use crate::signal::prelude::*;

pub(crate) const ENTRY: Entry<dyn Signal> = Entry::of::<Params>(
    "rgb-histogram",
    1,
    "Bhattacharyya coefficient of RGB histograms, this frame against the one before",
)
.example("{ bins = 8 }");

/// Channels that share a bin.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Channels {
    /// All three channels.
    #[default]
    Joint,
    /// One channel; the three histograms stand one after the other.
    Separate,
}

/// Parameters of the RGB histogram.
#[derive(Debug, Clone, SmartDefault, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Params {
    /// Bins a channel, 1 to 64; a joint histogram has the third power of it.
    #[default(8)]
    pub bins: usize,
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
    /// Joint or separate bins of the channels.
    #[serde(skip_serializing_if = "is_default")]
    #[default(Channels::Joint)]
    pub channels: Channels,
    /// Number of frames before whose boxes' sides are averaged with the box's own, 0 to 1000.
    #[serde(skip_serializing_if = "is_default")]
    pub size_history: usize,
}

impl Params {
    /// Bins of the whole histogram.
    fn all_bins(&self) -> usize {
        match self.channels {
            Channels::Joint => self.bins.pow(3),
            Channels::Separate => 3 * self.bins,
        }
    }
}

impl PlainParams for Params {
    const RANGES: &'static [Range] = &[Range::within("bins", 1.0, 64.0), histogram::RATE, SIZE_HISTORY];
}

impl Causal for Params {
    type Memory = Option<Vec<f64>>;

    fn facts(&self) -> Facts {
        histogram::FACTS
    }

    fn push(&self, memory: &mut Self::Memory, &Observation { frame, state, .. }: &Observation<'_>) -> f64 {
        let Params { bins, reference, rate, colors, weights, similarity, .. } = *self;
        let window = Window::on_frame(&state.region.rect(), frame);
        let joint = |_: usize, _: usize, rgb: [u8; 3]| Some(color_bin(colors.of(rgb), [bins; 3]));
        let of_channel = |c: usize| {
            let bin_of = |_: usize, _: usize, rgb: [u8; 3]| Some(usize::from(colors.of(rgb)[c]) * bins / 256);
            counts(frame, &window, weights, bins, bin_of)
        };
        let now = match self.channels {
            Channels::Joint => counts(frame, &window, weights, self.all_bins(), joint),
            Channels::Separate => [0, 1, 2].map(of_channel).concat(),
        };
        Comparison { reference, rate, similarity }.push(memory, now)
    }

    fn size_history(&self) -> usize {
        self.size_history
    }

    fn is_memory(&self, memory: &Self::Memory) -> bool {
        histogram::is_memory(memory.as_deref(), self.all_bins())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::signal::testing::run;

    // Two pixels each: (black, white) against (red, cyan) share all marginal bins but no joint one.
    #[test]
    fn bins_are_joint_unless_they_are_separate() {
        let gray = Frame::new(2, 1, vec![0, 0, 0, 255, 255, 255]);
        let colored = Frame::new(2, 1, vec![255, 0, 0, 0, 255, 255]);
        let (frames, boxes) = ([gray, colored.clone(), colored], [Rect::new(0.0, 0.0, 2.0, 1.0); 3]);
        let values = |params: &str| run("rgb-histogram", params, &frames, &boxes);
        assert_eq!(values("{}"), [1.0, 0.0, 1.0]);
        assert_eq!(values("{ channels = \"separate\" }"), [1.0, 1.0, 1.0]);
        // Of a dark red, green and blue share half of their pixels, and red none, which is in bin 3 of 8.
        let red = Frame::new(2, 1, vec![96, 0, 0, 96, 0, 0]);
        let found = run("rgb-histogram", "{ channels = \"separate\" }", &[frames[0].clone(), red], &boxes)[1];
        assert!((found - 2.0 * 2.0_f64.sqrt() / 6.0).abs() < 1e-12, "{found}");
    }
}
