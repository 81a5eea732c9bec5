//! Division of the target into fragments.

use serde::{Deserialize, Serialize};

/// How a target is cut into fragments.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum FragmentLayout {
    /// The two families of FragTrack: flat strips of about a tenth of the height and half the width, and
    /// upright ones.
    Strips,
    /// Equal cells, `cells` a side.
    Grid,
}

/// A fragment: left, top, right and bottom edge in pixels from the center of the unscaled target.
pub type Fragment = [f64; 4];

impl FragmentLayout {
    /// The fragments of a target of `w` by `h` pixels, at least one, all inside it.
    pub fn fragments(self, w: f64, h: f64, cells: u8) -> Vec<Fragment> {
        match self {
            Self::Strips => {
                let upright = strips(h, w).into_iter().map(|[l, t, r, b]| [t, l, b, r]);
                strips(w, h).into_iter().chain(upright).collect()
            }
            Self::Grid => {
                let n = u32::from(cells.max(1));
                let edge = |k: u32, side: f64| side * (f64::from(k) / f64::from(n) - 0.5);
                let cell = |i, j| [edge(i, w), edge(j, h), edge(i + 1, w), edge(j + 1, h)];
                (0..n).flat_map(|j| (0..n).map(move |i| cell(i, j))).collect()
            }
        }
    }
}

/// FragTrack's flat strips: half height `max(1, floor(0.05 h + 0.5))`, half width `max(1, floor(0.25 w))`,
/// centers a strip's height apart from the top, two beside each other at `floor(w / 4)` from the middle.
fn strips(w: f64, h: f64) -> Vec<Fragment> {
    let (half_w, half_h) = ((0.25 * w).floor().max(1.0), (0.05 * h + 0.5).floor().max(1.0));
    // Centers that keep the strip inside; of a target smaller than the strip, its middle.
    let (reach_x, reach_y) = ((w / 2.0 - half_w).max(0.0), (h / 2.0 - half_h).max(0.0));
    let dx = (w / 4.0).floor().min(reach_x);
    // At most 20 by the half height above, but for rounding.
    let levels = (reach_y / half_h).floor().min(64.0) as u32 + 1;
    let mut all = Vec::new();
    for level in 0..levels {
        let y = f64::from(level) * 2.0 * half_h - reach_y;
        for x in [-dx, dx] {
            let inside = |v: f64, side: f64| v.clamp(-side / 2.0, side / 2.0);
            all.push([
                inside(x - half_w, w),
                inside(y - half_h, h),
                inside(x + half_w, w),
                inside(y + half_h, h),
            ]);
        }
    }
    all
}
