//! Track quality y_t: how much the target looks like what surrounds it (Khalid, Cavallaro and Rinner,
//! BMVC 2016, Eq. 1-7). Low values mean that the box lies on background.
//!
//! ```text
//! v_t     = (1 / k) (x_{t-1} - x_{t-1-k})                                              Eq. 1
//! B_t     : center x_{t-1} + v_t, width w + ceil((w + h) / 4), height h + ceil((w + h) / 4)
//! y_t^a   = 1 / (w_t h_t M) sum_c omega_c sum_{i,j,m} |d_S(i,j,c,m) - d_{b^a}(i,j,c,m)|    Eq. 2-5
//! omega_c = |mean_S^c - mean_{b^a}^c| / sum_c |mean_S^c - mean_{b^a}^c|                 Eq. 6
//! y_t     = (y_t^1 + y_t^2 + y_t^3 + y_t^4) / 4                                         Eq. 7
//! ```
//!
//! `x_t` is the center of the box in pixels, `w`, `h` (without index) the box of frame t - 1, `S_t` the
//! box of frame t, `b^a` four windows of the size of `S_t` in `B_t`, `c` the channels R, G, B, `d` the
//! distribution fields of [`crate::image::distribution`] with `M` layers. Frames count from 1 in the
//! paper, k = min(history, t - 2). y_t is dimensionless, between 0 and 2 / M.
//!
//! Choices where the paper leaves room; of those that are a parameter the default stands first:
//!
//! - Eq. 1 as printed sums displacements up to the current frame, which a prediction of that frame
//!   cannot use: `displacement` "past" stops at t - 1, "printed" uses (x_t - x_{t-k}) / k.
//! - sigma_1 = 1 (u), 2 (v): `smoothing` "anisotropic" is one Gaussian of support 9 x 15; "two-levels" is
//!   the code of Distribution Field Tracking: isotropic levels of sigma_u and sigma_v, here averaged.
//! - The layer is ceil(value / (255 / M)) with 0 put into layer 1 (Eq. 2).
//! - `border` "uniform" pads each patch with uniform distributions; padding with zeros gives the same y_t,
//!   because both sides of a difference share the padding, so "zero" is another word for it. "replicate"
//!   repeats border pixels.
//! - `regions` "corners" are the four corner windows of `B_t` (it is too small for four disjoint ones);
//!   "sides" are the windows at the middle of its sides. Where `S_t` is larger than `B_t`, `B_t` is
//!   enlarged about its center.
//! - `outside` "shift" moves a window that leaves the frame inside and repeats border pixels only for
//!   windows larger than the frame; "replicate" always repeats border pixels, and cuts windows to twice the
//!   sides of the frame about their center.
//! - Without any difference of means Eq. 6 is 0 / 0; omega_c is then 1/3.
//! - In the first frame x_{t-1} is the box itself and v_t = 0.
//!
//! The distances are computed in `f32`: y_t differs by less than 1e-6 of its value from that in `f64`, and is the
//! same on every processor.

use crate::image::distribution::{Border, FieldDistance, Patch, Smoothing, gaussian};
use crate::signal::prelude::*;

/// The track quality in the list of signals.
pub const ENTRY: Entry<dyn Signal> = Entry::of::<Params>(
    "distribution-field",
    2,
    "track quality y_t: L1 distance of distribution fields, target against surroundings",
)
.example("{ layers = 32, history = 10 }");

/// Reading of the printed sigma_1 = (1, 2).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum SmoothingRule {
    /// One Gaussian, sigma_u across and sigma_v down.
    Anisotropic,
    /// Two isotropic Gaussians, sigma_u with `support_u` and sigma_v with `support_v`; y_t is averaged.
    TwoLevels,
}

/// Values around a patch when it is smoothed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum BorderRule {
    /// Uniform distributions.
    Uniform,
    /// Zeros, which give the same values as `uniform` and are treated like it.
    #[serde(rename(serialize = "uniform"))]
    Zero,
    /// The patch's own border pixels.
    Replicate,
}

/// Positions of the four background windows in B_t.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Regions {
    /// At the corners.
    Corners,
    /// At the middle of the left, right, top and bottom side.
    Sides,
}

/// Displacements that Eq. 1 averages.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Displacement {
    /// Displacements up to frame t - 1.
    Past,
    /// Displacements up to frame t, as printed.
    Printed,
}

/// Values of a window outside the frame.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Outside {
    /// The window is shifted inside first.
    Shift,
    /// Repeated border pixels of the frame.
    Replicate,
}

/// Parameters of y_t; the defaults are the paper's values and the choices of the module's text.
#[derive(Debug, Clone, SmartDefault, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Params {
    /// Number M of layers in a field, 2 to 256.
    #[default(32)]
    pub layers: usize,
    /// Standard deviation of the spatial Gaussian along u (columns) in pixels, above 0.
    #[default(1.0)]
    pub sigma_u: f64,
    /// Standard deviation of the spatial Gaussian along v (rows) in pixels, above 0.
    #[default(2.0)]
    pub sigma_v: f64,
    /// Standard deviation of the Gaussian over layers, in layers, above 0.
    #[default(0.625)]
    pub sigma_layer: f64,
    /// Number of displacements averaged for the prediction (Delta t_1), 1 to 1000.
    #[default(10)]
    pub history: usize,
    /// Support of the Gaussian along u in pixels, odd, 1 to 63.
    #[default(9)]
    pub support_u: usize,
    /// Support of the Gaussian along v in pixels, odd, 1 to 63.
    #[default(15)]
    pub support_v: usize,
    /// Support of the Gaussian over layers, odd, 1 to 63.
    #[default(5)]
    pub support_layer: usize,
    /// Use of sigma_u and sigma_v.
    #[default(SmoothingRule::Anisotropic)]
    pub smoothing: SmoothingRule,
    /// Values around a patch when it is smoothed.
    #[default(BorderRule::Uniform)]
    pub border: BorderRule,
    /// Positions of the four background windows.
    #[default(Regions::Corners)]
    pub regions: Regions,
    /// Displacements that are averaged.
    #[default(Displacement::Past)]
    pub displacement: Displacement,
    /// Values of a window outside the frame.
    #[default(Outside::Shift)]
    pub outside: Outside,
}

impl PlainParams for Params {
    const RANGES: &'static [Range] = &[
        Range::within("layers", 2.0, 256.0),
        Range::within("sigma_u", 1e-3, 1e3),
        Range::within("sigma_v", 1e-3, 1e3),
        Range::within("sigma_layer", 1e-3, 1e3),
        Range::within("history", 1.0, 1000.0),
        Range::within("support_u", 1.0, 63.0),
        Range::within("support_v", 1.0, 63.0),
        Range::within("support_layer", 1.0, 63.0),
    ];

    fn check(&self) -> Result<(), ParamError> {
        let Self { support_u, support_v, support_layer, .. } = *self;
        let supports = [("support_u", support_u), ("support_v", support_v), ("support_layer", support_layer)];
        supports
            .into_iter()
            .try_for_each(|(key, n)| ParamError::unless(n % 2 == 1, key, "odd and at most 63", n))
    }
}

impl Params {
    fn smoothings(&self) -> Vec<Smoothing> {
        let u = gaussian(self.sigma_u, self.support_u / 2);
        let v = gaussian(self.sigma_v, self.support_v / 2);
        let over_layers = gaussian(self.sigma_layer, self.support_layer / 2);
        let border = match self.border {
            BorderRule::Replicate => Border::Replicate,
            _ => Border::Common,
        };
        let make =
            |across: &[f64], down: &[f64]| Smoothing::new(self.layers, across, down, &over_layers, border);
        match self.smoothing {
            SmoothingRule::Anisotropic => vec![make(&u, &v)],
            SmoothingRule::TwoLevels => vec![make(&u, &u), make(&v, &v)],
        }
    }
}

impl Signal for Params {
    fn facts(&self) -> Facts {
        Facts::of(Direction::HigherIsBetter, (0.0, 2.0 / self.layers as f64))
    }

    fn start(&self, _: &RunContext<'_>) -> Result<Box<dyn Session>, TrackerError> {
        Ok(Box::new(Quality {
            params: self.clone(),
            smoothings: self.smoothings(),
            layer_of: layer_table(self.layers),
            past: Vec::new(),
            strips: Vec::new(),
            distance: FieldDistance::default(),
        }))
    }
}

/// The layer, from 0, of each value.
fn layer_table(layers: usize) -> [u8; 256] {
    std::array::from_fn(|value| ((value * layers).div_ceil(255).max(1) - 1) as u8)
}

/// Region B_t around the expected place of the target in the current frame (Eq. 1).
///
/// `past` has the boxes of earlier frames, oldest first; only the last `history + 1` are used. In the first
/// frame it is empty and `current`, the box of the current frame, replaces it. In later frames only
/// [`Displacement::Printed`] reads `current`. The region may leave the frame.
pub fn background_region(past: &[Rect], current: &Rect, history: usize, rule: Displacement) -> Rect {
    let Some(last) = past.last() else { return enlarged(current, current.center()) };
    let (end, frame) = match rule {
        Displacement::Past => (last, past.len() - 1),
        Displacement::Printed => (current, past.len()),
    };
    let steps = history.min(frame);
    let (from, to, at) = (past[frame - steps].center(), end.center(), last.center());
    let k = steps.max(1) as f64;
    enlarged(last, (at.0 + (to.0 - from.0) / k, at.1 + (to.1 - from.1) / k))
}

/// Box of the size of B_t around `center`, for a target of the size of `last`.
fn enlarged(last: &Rect, center: (f64, f64)) -> Rect {
    let margin = ((last.w + last.h) / 4.0).ceil();
    let (w, h) = (last.w + margin, last.h + margin);
    Rect::new(center.0 - w / 2.0, center.1 - h / 2.0, w, h)
}

/// Four windows of the size of `state` in the region `background`.
fn background_windows(background: &Rect, state: &Rect, regions: Regions) -> [Rect; 4] {
    let (cx, cy) = background.center();
    let (w, h) = (background.w.max(state.w), background.h.max(state.h));
    let (left, top) = (cx - w / 2.0, cy - h / 2.0);
    let (right, bottom) = (left + w - state.w, top + h - state.h);
    let (middle_x, middle_y) = (cx - state.w / 2.0, cy - state.h / 2.0);
    let places = match regions {
        Regions::Corners => [(left, top), (right, top), (left, bottom), (right, bottom)],
        Regions::Sides => [(left, middle_y), (right, middle_y), (middle_x, top), (middle_x, bottom)],
    };
    places.map(|(x, y)| Rect::new(x, y, state.w, state.h))
}

/// Windows that start in the same column: their layers and channel sums.
struct Strip {
    /// Layers of each channel, column by column.
    layers: [Vec<u8>; 3],
    /// Channel sums of each row.
    sums: Vec<[u64; 3]>,
}

/// Strips that contain these windows of one size, and the position of each window in them.
fn strips(windows: &[Window; 5]) -> (Vec<Window>, [Patch; 5]) {
    let mut strips: Vec<Window> = Vec::new();
    let mut strip_of = [0; 5];
    for (window, strip) in windows.iter().zip(&mut strip_of) {
        let with = |other: &Window| {
            let y = other.y.min(window.y);
            let end = (other.y + other.h as i64).max(window.y + window.h as i64);
            Window { y, h: (end - y) as usize, ..*other }
        };
        let near = |other: &Window| other.x == window.x && with(other).h <= other.h + window.h;
        *strip = strips.iter().position(near).unwrap_or(strips.len());
        match strips.get_mut(*strip) {
            Some(other) => *other = with(other),
            None => strips.push(*window),
        }
    }
    let patch = |a: usize| {
        let strip = strip_of[a];
        Patch { strip, top: (windows[a].y - strips[strip].y) as usize }
    };
    let patches = [0, 1, 2, 3, 4].map(patch);
    (strips, patches)
}

impl Strip {
    /// Reads a strip. Pixels outside the frame repeat its border.
    fn read(frame: &Frame, window: Window, layer_of: &[u8; 256]) -> Self {
        let Window { x, y, w, h } = window;
        let mut layers: [Vec<u8>; 3] = std::array::from_fn(|_| vec![0; w * h]);
        let [red, green, blue] = &mut layers;
        let inside = |at: i64, len: usize| at.clamp(0, len as i64 - 1) as usize;
        let sums = (0..h).map(|i| {
            let row = frame.row(inside(y + i as i64, frame.height()));
            let mut sums = [0_u32; 3];
            for j in 0..w {
                let at = 3 * inside(x + j as i64, frame.width());
                let Some(&[r, g, b]) = row[at..].first_chunk() else { continue };
                sums[0] += u32::from(r);
                sums[1] += u32::from(g);
                sums[2] += u32::from(b);
                red[j * h + i] = layer_of[usize::from(r)];
                green[j * h + i] = layer_of[usize::from(g)];
                blue[j * h + i] = layer_of[usize::from(b)];
            }
            sums.map(u64::from)
        });
        let sums = sums.collect();
        Self { layers, sums }
    }
}

/// Computation of y_t for one track.
struct Quality {
    params: Params,
    smoothings: Vec<Smoothing>,
    layer_of: [u8; 256],
    /// Boxes before the current frame, at most `history + 1`.
    past: Vec<Rect>,
    strips: Vec<Strip>,
    distance: FieldDistance,
}

impl Session for Quality {
    fn push(&mut self, observation: &Observation<'_>) -> Result<Vec<f64>, TrackerError> {
        let Observation { frame, state, .. } = *observation;
        let current = state.region.rect();
        let p = &self.params;
        let background = background_region(&self.past, &current, p.history, p.displacement);
        let [a, b, c, d] = background_windows(&background, &current, p.regions);
        let outside = p.outside;
        let windows = [current, a, b, c, d].map(|r| place(&r, frame, outside));
        if self.past.len() > p.history {
            self.past.remove(0);
        }
        self.past.push(current);
        Ok(vec![self.quality(frame, &windows)])
    }

    fn save(&self) -> Option<Vec<u8>> {
        saved::to_bytes(&self.past)
    }

    fn restore(&mut self, saved: &[u8]) -> bool {
        let past = saved::from_bytes(saved).filter(|past: &Vec<Rect>| past.len() <= self.params.history + 1);
        past.map(|past| self.past = past).is_some()
    }
}

/// Longest sides of a window that leaves the frame, in sides of the frame.
const MOST: usize = 2;

/// Window of a box; a single pixel for a box with numbers that are not finite.
fn place(r: &Rect, frame: &Frame, outside: Outside) -> Window {
    let window = Window::from_rect(r);
    let window = Window { w: window.w.max(1), h: window.h.max(1), ..window };
    match outside {
        Outside::Shift => window.shifted_inside(frame),
        // Of what lies beyond, nothing is seen but copies of the border.
        Outside::Replicate => {
            let (w, h) = (window.w.min(MOST * frame.width()), window.h.min(MOST * frame.height()));
            let (x, y) = (window.x + (window.w - w) as i64 / 2, window.y + (window.h - h) as i64 / 2);
            Window { x, y, w, h }
        }
    }
}

impl Quality {
    /// Value of Eq. 2-7 for the window of the target and those of the background.
    fn quality(&mut self, frame: &Frame, windows: &[Window; 5]) -> f64 {
        let differs: [bool; 4] = std::array::from_fn(|a| windows[a + 1] != windows[0]);
        if differs == [false; 4] {
            return 0.0;
        }
        let (strips, patches) = strips(windows);
        self.strips.clear();
        self.strips.extend(strips.iter().map(|window| Strip::read(frame, *window, &self.layer_of)));
        let strips = &self.strips;
        let others = std::array::from_fn::<_, 4, _>(|a| differs[a].then_some(patches[a + 1]));
        let (w, h) = (windows[0].w, windows[0].h);
        // L1 distances a channel and window; channels that agree (gray frames) are computed once.
        let mut distances = [[0.0; 4]; 3];
        for c in 0..3 {
            if let Some(twin) = (0..c).find(|&e| strips.iter().all(|s| s.layers[c] == s.layers[e])) {
                distances[c] = distances[twin];
                continue;
            }
            let layers: Vec<&[u8]> = strips.iter().map(|s| s.layers[c].as_slice()).collect();
            for smoothing in &self.smoothings {
                self.distance.l1(smoothing, (w, h), &layers, patches[0], &others, &mut distances[c]);
            }
        }
        let scale = (w * h * self.params.layers * self.smoothings.len()) as f64;
        let [target, sums @ ..] = patches.map(|p| {
            let rows = &strips[p.strip].sums[p.top..][..h];
            rows.iter().fold([0; 3], |all, row| [0, 1, 2].map(|c| all[c] + row[c]))
        });
        let scores = sums.iter().enumerate().map(|(a, sums)| {
            let weights = channel_weights(&target, sums);
            (0..3).map(|c| weights[c] * distances[c][a]).sum::<f64>() / scale
        });
        // Rounding may pass the bound.
        (scores.sum::<f64>() / 4.0).min(2.0 / self.params.layers as f64)
    }
}

/// omega_c of Eq. 6.
fn channel_weights(target: &[u64; 3], other: &[u64; 3]) -> [f64; 3] {
    let gaps: [u64; 3] = std::array::from_fn(|c| target[c].abs_diff(other[c]));
    match gaps.iter().sum::<u64>() {
        0 => [1.0 / 3.0; 3],
        all => gaps.map(|gap| gap as f64 / all as f64),
    }
}

#[cfg(test)]
mod tests;
