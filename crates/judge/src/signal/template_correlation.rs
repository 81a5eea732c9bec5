//! `template-correlation`: similarity of the target to a template of itself, as the zero-mean normalized
//! cross-correlation (NCC) of gray values. Low values speak for a failure.
//!
//! ```text
//! p[t]   = gray values of the box in frame t, resampled to n pixels
//! rho[t] = sum_i (p_i - mean p)(q_i - mean q) / sqrt(sum_i (p_i - mean p)^2  sum_i (q_i - mean q)^2)
//! q      = p[0] (first), p[t-1] (previous),
//!          or (slow) q[1] = p[0], q[t+1] = (1 - rate) q[t] + rate p[t]
//! ```
//!
//! `rho` has no unit and lies in [-1, 1]; it is 1 in the first frame, and for a box whose gray values are those of the
//! template up to gain (above 0) and offset. `t` is a 0-based frame, `i` one of the `n` pixels.
//!
//! Source: common practice of trackers; no paper defines it. Choices: the template has the shape of the first box, and
//! neither side is longer than `side` (32 pixels, enough to tell targets apart and small enough that slight turns do
//! not matter), so that changes of scale cancel; a pixel of the template is the mean of up to 8 x 8 bilinear samples,
//! as single samples of a large target would depend on chance; the rate of the slow template, .02, is that of common
//! correlation filters; a flat box is like a flat template (1) and unlike any other (0). Boxes that leave the frame
//! are shifted inside, larger ones cut to the frame. The similarity of color histograms with the first frame's is
//! `rgb-histogram` with `reference = "first"`.

use crate::image::patch::{Colors, Patch};
use crate::num::summary::correlation;
use crate::signal::prelude::*;

pub(crate) const ENTRY: Entry<dyn Signal> = Entry::of::<Params>(
    "template-correlation",
    1,
    "normalized cross-correlation of the box's gray values with a template",
)
.example("{ reference = \"first\" }");

/// Variance of gray values up to which a box counts as flat, since rounding may leave some.
const FLAT: f64 = 1e-6;
/// Most samples per template pixel, along either side.
const MAX_SAMPLES: usize = 8;

/// Template with which a frame is compared.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Template {
    /// The box of the first frame.
    First,
    /// The box of the frame before.
    Previous,
    /// Weighted mean over all earlier frames; later ones have more weight.
    Slow,
}

/// Parameters of the signal.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Params {
    /// Template with which a frame is compared.
    pub reference: Template,
    /// Longest side of the template in pixels, 2 to 256.
    pub side: usize,
    /// Share of a new frame in the slow template, 0 to 1.
    pub rate: f64,
}

impl Default for Params {
    fn default() -> Self {
        Self { reference: Template::First, side: 32, rate: 0.02 }
    }
}

impl PlainParams for Params {
    const RANGES: &'static [Range] = &[Range::within("side", 2.0, 256.0), Range::within("rate", 0.0, 1.0)];
}

impl Causal for Params {
    /// Columns, rows and gray values of the template; `None` before the first frame.
    type Memory = Option<(usize, usize, Vec<f64>)>;

    fn facts(&self) -> Facts {
        Facts::of(Direction::HigherIsBetter, (-1.0, 1.0))
    }

    fn push(&self, memory: &mut Self::Memory, &Observation { frame, state, .. }: &Observation<'_>) -> f64 {
        let Params { reference, side, rate } = *self;
        let window = Window::on_frame(&state.region.rect(), frame);
        let Some((width, height, template)) = memory else {
            let (width, height) = template_size(&window, side);
            *memory = Some((width, height, resample(frame, &window, width, height)));
            return 1.0;
        };
        let now = resample(frame, &window, *width, *height);
        let value = correlation(&now, template, FLAT);
        match reference {
            Template::First => {}
            Template::Previous => *template = now,
            Template::Slow => {
                template.iter_mut().zip(&now).for_each(|(q, p)| *q = (1.0 - rate) * *q + rate * p)
            }
        }
        value
    }

    fn is_memory(&self, memory: &Self::Memory) -> bool {
        let fits = |side: usize| (1..=self.side).contains(&side);
        let is_gray = |value: &f64| (0.0..=256.0).contains(value);
        memory.as_ref().is_none_or(|(w, h, values)| {
            fits(*w) && fits(*h) && values.len() == w * h && values.iter().all(is_gray)
        })
    }
}

/// Columns and rows of a template with the shape of a window.
fn template_size(window: &Window, side: usize) -> (usize, usize) {
    let longest = window.w.max(window.h);
    if longest <= side {
        return (window.w, window.h);
    }
    // Rounded to the nearest.
    let shrunk = |length: usize| ((2 * length * side + longest) / (2 * longest)).max(1);
    (shrunk(window.w), shrunk(window.h))
}

/// Gray values of a window, resampled to `width` columns and `height` rows.
fn resample(frame: &Frame, window: &Window, width: usize, height: usize) -> Vec<f64> {
    let samples = |pixels: usize, parts: usize| pixels.div_ceil(parts).clamp(1, MAX_SAMPLES);
    let (across, down) = (samples(window.w, width), samples(window.h, height));
    let fine = Patch::resized(frame, window, across * width, down * height, Colors::Gray);
    let mut sums = vec![0.0; width * height];
    for (i, row) in fine.values.chunks_exact(across * width).enumerate() {
        let out = &mut sums[i / down * width..][..width];
        for (out, samples) in out.iter_mut().zip(row.chunks_exact(across)) {
            *out += samples.iter().map(|v| f64::from(*v)).sum::<f64>();
        }
    }
    let share = 1.0 / (across * down) as f64;
    sums.iter_mut().for_each(|v| *v *= share);
    sums
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::signal::testing::{run, takes};

    #[test]
    fn templates_have_the_shape_of_the_box() {
        let size = |w, h| template_size(&Window { x: 0, y: 0, w, h }, 32);
        assert_eq!((size(32, 7), size(64, 31), size(31, 500)), ((32, 7), (32, 16), (2, 32)));
        assert_eq!(size(1, 400), (1, 32));
    }

    #[test]
    fn a_memory_has_a_value_for_each_pixel() {
        let of = |w: usize, h: usize, values: Vec<f64>| {
            takes("template-correlation", "{ side = 4 }", &Some((w, h, values)))
        };
        let takes = |w: usize, h: usize, values: usize| of(w, h, vec![0.5; values]);
        assert!(takes(4, 3, 12) && of(1, 2, vec![0.0, 255.0]));
        assert!(!of(1, 2, vec![0.0, f64::NAN]) && !of(1, 2, vec![-1.0, 0.0]) && !of(1, 2, vec![0.0, 1e9]));
        let bad = [(4, 3, 11), (5, 3, 15), (3, 5, 15), (0, 3, 0), (3, 0, 0)];
        assert!(bad.into_iter().all(|(w, h, values)| !takes(w, h, values)));
    }

    // The same square of 2 x 2 blocks at three scales, on a frame that is flat elsewhere, in other light.
    #[test]
    fn scale_gain_and_offset_cancel() {
        let frame = |(side, gain): (usize, u8)| {
            Frame::from_fn(80, 70, |x, y| {
                let block = |at: usize| (at - 5) * 2 / side;
                let inside = (5..5 + side).contains(&x) && (5..5 + side).contains(&y);
                let value = if inside { [[5, 45], [100, 20]][block(y)][block(x)] } else { 0 };
                [gain * value + 30; 3]
            })
        };
        let boxes = [16.0, 64.0, 32.0].map(|side| Rect::new(5.0, 5.0, side, side));
        for value in run("template-correlation", "{}", &[(16, 1), (64, 2), (32, 2)].map(frame), &boxes) {
            assert!(value > 0.99, "{value}");
        }
    }
}
