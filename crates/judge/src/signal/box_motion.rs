//! `box-motion`: motion, growth and shape change of the tracker's box, and its distance to the frame's
//! border, in units of the box's size. Only the region is read, except for the distance to the border, which
//! needs the size of the frame.
//!
//! ```text
//! displacement  |c[t] - c[t-1]| / s[t-1]
//! acceleration  |c[t] - 2 c[t-1] + c[t-2]| / s[t-1]
//! scale         |ln(w[t] h[t] / (w[t-1] h[t-1]))|
//! aspect        |ln((w[t] / h[t]) / (w[t-1] / h[t-1]))|
//! border        min(x[t], y[t], W - x[t] - w[t], H - y[t] - h[t]) / s[t]
//! ```
//!
//! `x`, `y`, `w` and `h` are the upright box in pixels, `c` its center, `s = sqrt(w h)`, and `W`, `H` the sides of the
//! frame; `t` is a 0-based frame, and values have no unit. High values speak for a failure; of `border`, low ones do,
//! and it is negative where the box leaves the frame. Frames without enough frames before them (the first one; of
//! `acceleration`, the first two) give 0. A displacement of 1 is a jump by the target's own size.
//!
//! Source: none, these are common checks of plausibility. Choices: the unit of a motion is the size of the
//! box before it, as a box that collapses would otherwise enlarge its own motion; polygons are replaced by
//! their upright box; sides below one pixel count as one pixel; values are cut at 1000, those of `border`
//! also at -1000; and a box whose coordinates are no numbers is given the worst of them.

use crate::signal::prelude::*;

pub(crate) const ENTRY: Entry<dyn Signal> = Entry::of::<Params>(
    "box-motion",
    1,
    "motion of the tracker's box, or its distance to the frame's border, relative to its size",
)
.example("{ measure = \"displacement\" }");

/// Largest absolute value of the signal.
const MAX_VALUE: f64 = 1000.0;

/// Measure of the box's motion.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Measure {
    /// Distance between the centers of the box in this frame and in the last one.
    #[default]
    Displacement,
    /// Second difference of the center of the box.
    Acceleration,
    /// Logarithm of the ratio of the box's areas in this frame and in the last one.
    Scale,
    /// Logarithm of the ratio of the box's aspects in this frame and in the last one.
    Aspect,
    /// Distance of its nearest side to the frame's border. Frames are decoded for it.
    Border,
}

/// Parameters of the signal.
#[derive(Debug, Clone, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Params {
    /// Measure of the box's motion.
    pub measure: Measure,
}

impl PlainParams for Params {}

impl Causal for Params {
    /// Boxes of the last frame and of the one before it.
    type Memory = [Option<Rect>; 2];

    fn facts(&self) -> Facts {
        match self.measure {
            // The size of a frame that is not decoded is unknown.
            Measure::Border => Facts::of(Direction::HigherIsBetter, (-MAX_VALUE, MAX_VALUE)),
            _ => Facts { reads: Reads::Boxes, ..Facts::of(Direction::LowerIsBetter, (0.0, MAX_VALUE)) },
        }
    }

    fn push(&self, past: &mut Self::Memory, &Observation { frame, state, .. }: &Observation<'_>) -> f64 {
        let Rect { x, y, w, h } = state.region.rect();
        let now = Rect::new(x, y, w.max(1.0), h.max(1.0));
        let [before, earlier] = *past;
        *past = [Some(now), before];
        if self.measure == Measure::Border {
            let distance = border_distance(&now, frame) / size(&now);
            return if distance.is_nan() { -MAX_VALUE } else { distance.clamp(-MAX_VALUE, MAX_VALUE) };
        }
        let Some(before) = before else { return 0.0 };
        let value = match self.measure {
            Measure::Acceleration => earlier.map_or(0.0, |earlier| {
                let velocity = difference(&before, &earlier);
                length(difference(&now, &before), velocity) / size(&before)
            }),
            Measure::Scale => ((now.w / before.w).ln() + (now.h / before.h).ln()).abs(),
            Measure::Aspect => ((now.w / before.w).ln() - (now.h / before.h).ln()).abs(),
            Measure::Displacement | Measure::Border => {
                length(difference(&now, &before), (0.0, 0.0)) / size(&before)
            }
        };
        value.min(MAX_VALUE)
    }
}

fn size(r: &Rect) -> f64 {
    (r.w * r.h).sqrt()
}

/// Motion of the center from `b` to `a`.
fn difference(a: &Rect, b: &Rect) -> (f64, f64) {
    let (a, b) = (a.center(), b.center());
    (a.0 - b.0, a.1 - b.1)
}

fn length(a: (f64, f64), b: (f64, f64)) -> f64 {
    let (x, y) = (a.0 - b.0, a.1 - b.1);
    (x * x + y * y).sqrt()
}

/// Distance in pixels between the box and the nearest border of the frame; NaN if a coordinate is NaN.
fn border_distance(r: &Rect, frame: &Frame) -> f64 {
    let (right, bottom) = (frame.width() as f64 - r.x - r.w, frame.height() as f64 - r.y - r.h);
    let least = r.x.min(r.y).min(right).min(bottom);
    if (r.x + r.y).is_nan() { f64::NAN } else { least }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::signal::testing::values_on_boxes;
    use Measure::{Acceleration, Aspect, Border, Displacement, Scale};
    use trackfail_testing::assert_near;

    // By hand, in a frame of 40 x 30. The center goes from (6, 9) to (12, 17): 10 pixels, the size of the first box; then to
    // (12, 21) and on: (0, 4) - (6, 8) = (-6, -4), and (0, 0) - (0, 4). Boxes that are 5 pixels wide are nearest to the left,
    // the top, the right and the bottom. A box of half a pixel counts as one of a pixel, one without numbers is as bad as can be.
    #[test]
    fn values_by_hand() {
        let moving = [
            (-4.0, 6.5, 20.0, 5.0),
            (2.0, 14.5, 20.0, 5.0),
            (7.0, 11.0, 10.0, 20.0),
            (7.0, 11.0, 10.0, 20.0),
        ];
        let near_sides =
            [(-10.0, 12.0), (20.0, -5.0), (38.0, 9.0), (9.0, 29.0)].map(|(x, y)| (x, y, 5.0, 5.0));
        let small = (3.0, 3.0, 0.5, 0.5);
        let lost = [(2.0, 3.0, 5.0, 5.0), (f64::NAN, 3.0, 5.0, 5.0)];
        let root = 200.0_f64.sqrt();
        for (measure, boxes, want) in [
            (Displacement, &moving[..], &[0.0, 1.0, 0.4, 0.0][..]),
            (Acceleration, &moving, &[0.0, 0.0, 52.0_f64.sqrt() / 10.0, 4.0 / root]),
            (Scale, &moving, &[0.0, 0.0, 2.0_f64.ln(), 0.0]),
            (Aspect, &moving, &[0.0, 0.0, 8.0_f64.ln(), 0.0]),
            (Border, &moving, &[-0.4, 0.2, -1.0 / root, -1.0 / root]),
            (Border, &near_sides, &[-2.0, -1.0, -0.6, -0.8]),
            (Displacement, &[small, (6.0, 7.0, 0.5, 0.5)], &[0.0, 5.0]),
            (Scale, &[small, (3.0, 3.0, 1.0, 1.0)], &[0.0, 0.0]),
            (Displacement, &lost, &[0.0, MAX_VALUE]),
            (Border, &lost, &[0.4, -MAX_VALUE]),
        ] {
            let frames = vec![Frame::new(40, 30, vec![0; 3600]); boxes.len()];
            let boxes: Vec<Rect> = boxes.iter().map(|&(x, y, w, h)| Rect::new(x, y, w, h)).collect();
            let values = values_on_boxes(&Params { measure }, &frames, &boxes);
            assert_near(values, want, 1e-12, format!("{measure:?}"));
        }
    }
}
