//! `object-color`: difference in color between the box and its surroundings, measured by similarity to the
//! target's colors. Low values speak for a failure.
//!
//! ```text
//! f[t](c) = share of color c in the ellipse that fills the box            b[t](c) = its share in the surroundings
//! F[0] = f[0],  F[t+1] = F[t] (first)  or  (1 - rate) F[t] + rate f[t] (slow)
//! B[0] = b[0],  B[t+1] = (1 - rate) B[t] + rate b[t]
//! P[t](c) = (F[t](c) + e) / (F[t](c) + B[t](c) + 2 e)                     probability that a pixel of color c is the target's
//! y[t] = sum_c P[t](c) (f[t](c) - b[t](c))                                mean inside the box less mean around it
//! ```
//!
//! `y` has no unit and lies in [-1, 1]; `t` is a 0-based frame, `c` one of `bins`^3 colors, `e` = 0.0001. The surroundings are
//! what lies between a box 1.1 times as large and one twice as large. A box that stands beside the target, or on a part of the
//! background that has the target's colors everywhere, has a value near 0 or below.
//!
//! Source: a Bayes probability of target against surroundings from two histograms is common practice of color trackers, such as that of
//! Possegger, Mauthner and Bischof, "In defense of color-based model-free tracking" (CVPR 2015), and Staple (Bertinetto et
//! al., CVPR 2016), which weigh colors to find the target; no equation was taken from either. The difference between box
//! and surroundings as a sign of failure is ours.
//!
//! Choices: the box is sampled at 48 x 48 places and its surroundings at the same distances, so that the size of a target
//! does not matter; the frame's border is repeated beyond it. A target of `first` is known for sure, but not what it
//! looks like later; `slow` follows the target into other light, and a tracker that has drifted away too.

use crate::image::patch::{Axis, Colors, Outside, Patch};
use crate::signal::prelude::*;

pub(crate) const ENTRY: Entry<dyn Signal> = Entry::of::<Params>(
    "object-color",
    1,
    "how much more the colors in the box look like the target than those around it",
)
.example("{ object = \"first\" }");

/// Number of samples along each side of the box.
const SIDE: usize = 48;
/// Number of samples along each side of the box with its surroundings, which is twice as large.
const WIDE: usize = 2 * SIDE;
/// Side of the inner box that the surroundings exclude, relative to the tracker's box.
const MARGIN: f64 = 1.1;
/// Constant e of the formula.
const SMALL: f64 = 1e-4;
/// Value added before samples are rounded down. Samples are often integers or halves, up to rounding errors,
/// and must not lie on the bounds of bins.
const ROUNDING: f32 = 0.414;
/// Shortest side of a box, in pixels.
const MIN_SIDE: f64 = 1.0;

/// Model of the target's colors.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Object {
    /// Colors of the box in the first frame.
    First,
    /// Weighted mean over all earlier frames; later ones have more weight.
    Slow,
}

/// Parameters of the signal.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Params {
    /// Model of the target's colors.
    pub object: Object,
    /// Number of bins per channel, 1 to 32. The number of colors is its third power.
    pub bins: usize,
    /// Share of a new frame in the model of the surroundings, and in a slow model of the target, 0 to 1.
    pub rate: f64,
}

impl Default for Params {
    fn default() -> Self {
        Self { object: Object::First, bins: 16, rate: 0.02 }
    }
}

impl PlainParams for Params {
    const RANGES: &'static [Range] = &[Range::within("bins", 1.0, 32.0), Range::within("rate", 0.0, 1.0)];
}

/// Color shares of the target and of its surroundings.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Shares {
    target: Vec<f64>,
    around: Vec<f64>,
}

impl Causal for Params {
    /// Models F and B; `None` before the first frame.
    type Memory = Option<Shares>;

    fn facts(&self) -> Facts {
        Facts::of(Direction::HigherIsBetter, (-1.0, 1.0))
    }

    fn push(&self, memory: &mut Self::Memory, &Observation { frame, state, .. }: &Observation<'_>) -> f64 {
        let Params { object, bins, rate } = *self;
        let now = shares(frame, &state.region.rect(), bins);
        let model = memory.get_or_insert_with(|| now.clone());
        let term = |c: usize| {
            let (target, around) = (model.target[c] + SMALL, model.around[c] + SMALL);
            target / (target + around) * (now.target[c] - now.around[c])
        };
        let value: f64 = (0..now.target.len()).map(term).sum();
        let follow = |model: &mut [f64], now: &[f64]| {
            model.iter_mut().zip(now).for_each(|(m, n)| *m = (1.0 - rate) * *m + rate * n);
        };
        follow(&mut model.around, &now.around);
        if object == Object::Slow {
            follow(&mut model.target, &now.target);
        }
        value.clamp(-1.0, 1.0)
    }

    fn is_memory(&self, memory: &Self::Memory) -> bool {
        let colors = self.bins.pow(3);
        let fits = |shares: &[f64]| shares.len() == colors && shares.iter().all(|s| (0.0..=1.0).contains(s));
        memory.as_ref().is_none_or(|model| fits(&model.target) && fits(&model.around))
    }
}

/// Distance of a sample from the center, in units of the tracker's box.
fn from_center(at: usize) -> f64 {
    ((at as f64 + 0.5) / WIDE as f64 - 0.5) * 2.0
}

/// Shares of the colors in a box and around it.
fn shares(frame: &Frame, rect: &Rect, bins: usize) -> Shares {
    let axis = |start: f64, side: f64| Axis::around(start + side / 2.0, 2.0 * side.max(MIN_SIDE), WIDE);
    let (across, down) = (axis(rect.x, rect.w), axis(rect.y, rect.h));
    let patch = Patch::sampled(frame, &across, &down, Outside::Repeated, Colors::Rgb);
    let planes: Vec<&[f32]> = patch.values.chunks_exact(WIDE * WIDE).collect();
    let bin = |value: f32| ((value + ROUNDING) as usize).min(255) * bins / 256;
    let (mut target, mut around) = (vec![0_u32; bins.pow(3)], vec![0_u32; bins.pow(3)]);
    for y in 0..WIDE {
        for x in 0..WIDE {
            let (dx, dy) = (from_center(x), from_center(y));
            let counts = if dx * dx + dy * dy <= 0.25 {
                &mut target
            } else if dx.abs().max(dy.abs()) > MARGIN / 2.0 {
                &mut around
            } else {
                continue;
            };
            counts[planes.iter().fold(0, |color, plane| color * bins + bin(plane[y * WIDE + x]))] += 1;
        }
    }
    let normalized = |counts: Vec<u32>| {
        let sum = f64::from(counts.iter().sum::<u32>());
        counts.into_iter().map(|count| f64::from(count) / sum).collect()
    };
    Shares { target: normalized(target), around: normalized(around) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::signal::testing::{run, takes};

    const TARGET: [u8; 3] = [200, 30, 30];
    const GROUND: [u8; 3] = [30, 120, 40];

    /// Target of 21 x 21 pixels on plain ground, half a pixel larger on each side than a box at (50.5, 30.5).
    fn scene(target: [u8; 3]) -> Frame {
        let inside = |i, j| (50..71).contains(&i) && (30..51).contains(&j);
        Frame::from_fn(120, 80, |i, j| if inside(i, j) { target } else { GROUND })
    }

    fn values(params: &str, frames: &[Frame], lefts: &[f64]) -> Vec<f64> {
        let boxes: Vec<Rect> = lefts.iter().map(|x| Rect::new(*x, 30.5, 20.0, 20.0)).collect();
        run("object-color", params, frames, &boxes)
    }

    // Ellipse and surroundings have one color each: P is (1 + e) / (1 + 2 e) for the target's, e / (1 + 2 e) for the
    // ground's, and y their difference, 1 / (1 + 2 e). On plain ground y is 0.
    #[test]
    fn by_hand() {
        let found = values("{}", &[TARGET; 3].map(scene), &[50.5, 50.5, 5.5]);
        assert!((found[0] - 1.0 / 1.0002).abs() < 1e-12 && (found[1] - found[0]).abs() < 1e-12, "{found:?}");
        assert_eq!(found[2], 0.0);
    }

    #[test]
    fn a_memory_is_two_lists_of_shares() {
        let takes =
            |target: &[f64], around: &[f64]| takes("object-color", "{ bins = 2 }", &Some((target, around)));
        let (shares, more) = ([0.125; 8], [0.125, 0.125, 0.125, 0.125, 0.125, 0.125, 0.125, 1.125]);
        assert!(takes(&shares, &shares));
        assert!(!takes(&shares, &more) && !takes(&more, &shares));
        assert!(!takes(&shares, &shares[1..]) && !takes(&shares[1..], &shares));
    }

    #[test]
    fn a_slow_model_follows_the_target_into_other_light() {
        let mut frames = vec![scene(TARGET); 5];
        frames.extend(vec![scene([70, 10, 10]); 100]);
        let of = |params: &str| values(params, &frames, &[50.5; 105]);
        let (first, slow) = (of("{}"), of("{ object = \"slow\" }"));
        assert_eq!(first[..5], slow[..5]);
        // Of a new color P is 1/2, as it is not seen around either.
        assert!((first[104] - 0.5).abs() < 0.01 && slow[104] > 0.95, "{} {}", first[104], slow[104]);
        assert_eq!(of("{ object = \"slow\", rate = 0.0 }"), of("{ rate = 0.0 }"));
    }
}
