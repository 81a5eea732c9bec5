//! Change of the target's region covariance between consecutive frames, after CovF (SanMiguel and Calvo,
//! Electronics Letters 51(3), 2015). High values speak for a failure.
//!
//! ```text
//! z(i, j) = (x, y, R, G, B)                       for each pixel of the box
//! C_t     = 1 / (n - 1) sum (z - m)(z - m)^T      (Tuzel, Porikli and Meer, ECCV 2006, Eq. 1)
//! d_t     = sqrt( sum_k ln^2 lambda_k ),  C_t v = lambda C_{t-1} v      (ibid., Eq. 3; Foerstner)
//! ```
//!
//! `x`, `y` in pixels, colors 0 to 255, `n` the pixels of the box on the frame; `d_t` is dimensionless
//! and at least 0, and 0 in the first frame. A common linear map of all features changes nothing, so
//! units and origin do not matter; dividing positions by each box's own size does, and is not the default.
//!
//! The letter's text was not available; the descriptor and the distance are the likely ones. `distance = "sum"` leaves the
//! root out, `positions = "relative"` divides x and y by the sides of each box, `colors = "hsv"` takes (x, y, H, S, V).
//! `parts = "halves"` compares the box and its four halves, each by itself, and leaves the largest of the five distances out of
//! their sum, as Tuzel's article is recalled to compare objects. `size_history` gives the box the mean sides of its past.
//!
//! Choices: covariances are made definite by adding `ridge * w * h` to the variances of x and y and
//! `ridge * 255^2` to those of the colors; where all pixels of a box are gray (R = G = B, so that C is
//! singular), `grey_ridge` times its own variance is added to each feature as well. A box of one pixel
//! has C = 0 before that. Boxes that leave the frame are shifted inside, larger ones cut to the frame.

use crate::signal::histogram::Colors;
use crate::signal::prelude::*;
use nalgebra::{Cholesky, Matrix5, Vector5};

pub(crate) const ENTRY: Entry<dyn Signal> = Entry::of::<Params>(
    "region-covariance",
    1,
    "distance of the (x, y, R, G, B) covariances of consecutive frames",
)
.example("{ ridge = 1e-6 }");

/// Form of the distance.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Distance {
    /// Root of the sum of squared logarithms.
    Root,
    /// The sum of squared logarithms.
    Sum,
}

/// Unit of the positions x and y.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Positions {
    /// Pixels.
    Pixels,
    /// Width and height of each box.
    Relative,
}

/// Windows whose covariances are compared.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Parts {
    /// The box.
    #[default]
    Whole,
    /// The box and its left, right, upper and lower half: the sum of their five distances without the largest.
    Halves,
}

impl Parts {
    /// The windows of a box on the frame; a middle row or column belongs to both halves.
    fn of(self, whole: Window) -> Vec<Window> {
        let (w, h) = (whole.w.div_ceil(2), whole.h.div_ceil(2));
        let (middle, center) = (whole.x + (whole.w - w) as i64, whole.y + (whole.h - h) as i64);
        match self {
            Self::Whole => vec![whole],
            Self::Halves => vec![
                whole,
                Window { w, ..whole },
                Window { x: middle, w, ..whole },
                Window { h, ..whole },
                Window { y: center, h, ..whole },
            ],
        }
    }
}

/// Parameters of the covariance distance.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Params {
    /// Value added to the variances, relative to w h (positions) and 255^2 (colors); 1e-9 to 1.
    pub ridge: f64,
    /// Form of the distance.
    pub distance: Distance,
    /// Unit of the positions x and y.
    pub positions: Positions,
    /// Value added to the variances of an all-gray box, relative to each variance; 0 to 1.
    #[serde(rename = "grey_ridge")]
    pub gray_ridge: f64,
    /// Color space of the three colors.
    #[serde(skip_serializing_if = "is_default")]
    pub colors: Colors,
    /// Windows whose covariances are compared.
    #[serde(skip_serializing_if = "is_default")]
    pub parts: Parts,
    /// Number of frames before whose boxes' sides are averaged with the box's own, 0 to 1000.
    #[serde(skip_serializing_if = "is_default")]
    pub size_history: usize,
}

impl Default for Params {
    fn default() -> Self {
        let (distance, positions) = (Distance::Root, Positions::Pixels);
        let (colors, parts) = (Colors::default(), Parts::default());
        Self { ridge: 1e-6, distance, positions, gray_ridge: 1e-3, colors, parts, size_history: 0 }
    }
}

impl PlainParams for Params {
    const RANGES: &'static [Range] =
        &[Range::within("ridge", 1e-9, 1.0), Range::within("grey_ridge", 0.0, 1.0), SIZE_HISTORY];
}

impl Causal for Params {
    /// The covariances of the frame before, column by column, one part after the other.
    type Memory = Option<Vec<f64>>;

    fn facts(&self) -> Facts {
        Facts::of(Direction::LowerIsBetter, (0.0, f64::INFINITY))
    }

    fn push(&self, last: &mut Self::Memory, &Observation { frame, state, .. }: &Observation<'_>) -> f64 {
        let windows = self.parts.of(Window::on_frame(&state.region.rect(), frame));
        let now: Vec<Matrix5<f64>> = windows.iter().map(|window| covariance(frame, window, self)).collect();
        let numbers = now.iter().flat_map(|c| c.iter().copied()).collect();
        let Some(before) = last.replace(numbers) else { return 0.0 };
        let distances = now.iter().zip(before.chunks_exact(25)).map(|(now, before)| {
            let distance = distance(now, &Matrix5::from_column_slice(before));
            match self.distance {
                Distance::Root => distance,
                Distance::Sum => distance * distance,
            }
        });
        let (sum, largest) =
            distances.fold((0.0_f64, 0.0_f64), |(sum, largest), d| (sum + d, largest.max(d)));
        match self.parts {
            Parts::Whole => sum,
            Parts::Halves => sum - largest,
        }
    }

    fn size_history(&self) -> usize {
        self.size_history
    }

    fn is_memory(&self, last: &Self::Memory) -> bool {
        // Every window has as many parts.
        let length = 25 * self.parts.of(Window { x: 0, y: 0, w: 1, h: 1 }).len();
        // What pixels give is far within; beyond it, quotients would overflow.
        let is_variance = |v: &f64| (1e-20..1e20).contains(v);
        last.as_ref().is_none_or(|last| {
            last.len() == length
                && last.iter().all(|v| v.abs() < 1e20)
                && last.chunks(25).all(|matrix| matrix.iter().step_by(6).all(is_variance))
        })
    }
}

/// The regularized covariance of (x, y, R, G, B), or of other colors, over a window that lies on the frame.
fn covariance(frame: &Frame, window: &Window, p: &Params) -> Matrix5<f64> {
    let (x0, y0) = (window.x as usize, window.y as usize);
    // Sums of integers, exact in any order: linear and bilinear terms of (x, y, R, G, B).
    let mut sums = [0_i64; 5];
    let mut products = [[0_i64; 5]; 5];
    let mut gray = true;
    for i in 0..window.h {
        for pixel in frame.row(y0 + i)[3 * x0..3 * (x0 + window.w)].chunks_exact(3).zip(0_i64..) {
            let (rgb, j) = pixel;
            let [c0, c1, c2] = p.colors.of([rgb[0], rgb[1], rgb[2]]).map(i64::from);
            let z = [j, i as i64, c0, c1, c2];
            gray &= rgb[0] == rgb[1] && rgb[1] == rgb[2];
            for a in 0..5 {
                sums[a] += z[a];
                for b in 0..=a {
                    products[a][b] += z[a] * z[b];
                }
            }
        }
    }
    let pixels = (window.w * window.h) as i128;
    let scale = (pixels * (pixels - 1).max(1)) as f64;
    let mut c = Matrix5::from_fn(|a, b| {
        let (a, b) = (a.max(b), a.min(b));
        let centered = pixels * i128::from(products[a][b]) - i128::from(sums[a]) * i128::from(sums[b]);
        centered as f64 / scale
    });
    let position = p.ridge * (window.w * window.h) as f64;
    let color = p.ridge * 255.0 * 255.0;
    for (a, unit) in [position, position, color, color, color].into_iter().enumerate() {
        c[(a, a)] += unit + if gray { p.gray_ridge * c[(a, a)] } else { 0.0 };
    }
    match p.positions {
        Positions::Pixels => c,
        Positions::Relative => {
            let unit = Vector5::new(1.0 / window.w as f64, 1.0 / window.h as f64, 1.0, 1.0, 1.0);
            Matrix5::from_fn(|a, b| c[(a, b)] * unit[a] * unit[b])
        }
    }
}

/// Foerstner's distance between two positive definite matrices; 0 for equal ones.
fn distance(a: &Matrix5<f64>, b: &Matrix5<f64>) -> f64 {
    if a == b {
        return 0.0;
    }
    // lambda are the squares of the singular values of root(b)^-1 root(a). The roots keep twice as many
    // digits of the small ones as the matrices; scaling by the deviations of `b` changes none of them.
    let scale = Vector5::from_fn(|k, _| b[(k, k)].sqrt().recip());
    let root = |m: &Matrix5<f64>| {
        let scaled = Matrix5::from_fn(|i, j| m[(i, j)] * scale[i] * scale[j]);
        Cholesky::new(scaled).map(|root| root.unpack())
    };
    // The ridge keeps both definite, so that there are roots and quotients.
    let (Some(root_a), Some(root_b)) = (root(a), root(b)) else { return 0.0 };
    let quotient = root_b.solve_lower_triangular(&root_a).unwrap_or_default();
    let logs = quotient.singular_values().map(|s| 2.0 * s.max(f64::MIN_POSITIVE).ln());
    logs.norm()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::signal::testing::{run, takes};

    #[test]
    fn distance_of_diagonal_matrices() {
        // lambda = 4, 1, 1/2, 1, 1: sqrt(ln^2 4 + ln^2 2).
        let a = Matrix5::from_diagonal(&Vector5::new(4.0, 9.0, 1.0, 1.0, 1.0));
        let b = Matrix5::from_diagonal(&Vector5::new(1.0, 9.0, 2.0, 1.0, 1.0));
        assert!((distance(&a, &b) - 1.549_924).abs() < 5e-7);
        assert!((distance(&a, &b) - 5.0_f64.sqrt() * 2.0_f64.ln()).abs() < 1e-14);
    }

    // With a variance near 0 in it, a search for singular values would never end.
    #[test]
    fn a_memory_is_a_matrix_that_pixels_may_have() {
        let takes = |place: usize, value: f64| {
            let mut matrix = Matrix5::<f64>::identity().as_slice().to_vec();
            matrix[place] = value;
            takes("region-covariance", "{}", &Some(matrix))
        };
        assert!(takes(0, 6e-14) && takes(24, 5e3) && takes(1, -2.0));
        let bad = [(0, 1e-320), (6, 0.0), (24, -1.0), (12, f64::NAN), (1, 1e300), (5, f64::INFINITY)];
        assert!(bad.into_iter().all(|(place, value)| !takes(place, value)));
    }

    /// Values of a box without a pattern that grows to twice its sides.
    fn resized(params: &str) -> Vec<f64> {
        let frames = [Frame::new(40, 40, vec![90; 4800]), Frame::new(40, 40, vec![90; 4800])];
        let boxes = [Rect::new(3.0, 2.0, 10.0, 10.0), Rect::new(3.0, 2.0, 20.0, 20.0)];
        run("region-covariance", params, &frames, &boxes)
    }

    // Of a diagonal C a frame scaled by 2 along x has lambda = 4 in x; as a share of its box it is unchanged.
    #[test]
    fn the_sum_is_the_square_and_relative_positions_forget_the_size() {
        let frame = Frame::from_fn(40, 40, |x, y| [(x * 5) as u8, (y * 5) as u8, ((x * y) % 251) as u8]);
        let boxes = [Rect::new(3.0, 2.0, 12.0, 9.0), Rect::new(5.0, 2.0, 20.0, 11.0)];
        let value =
            |params: &str| run("region-covariance", params, &[frame.clone(), frame.clone()], &boxes)[1];
        let (root, sum) = (value("{}"), value("{ distance = \"sum\" }"));
        assert!(root > 0.1 && (sum - root * root).abs() < 1e-12);
        let found = resized("{ positions = \"relative\", grey_ridge = 0.0 }")[1];
        let pixels = resized("{ grey_ridge = 0.0 }")[1];
        // The variance of x over n pixels is (n^2 - 1) / 12 * n / (n - 1): nearly the square of the side.
        assert!(found < 0.05 && (pixels - 2.0_f64.sqrt() * 4.0_f64.ln()).abs() < 0.05, "{found} {pixels}");
    }

    // As above: four of the five distances of a box without a pattern, all near that of the whole.
    #[test]
    fn halves_leave_the_largest_distance_out() {
        let found = resized("{ parts = \"halves\", grey_ridge = 0.0 }");
        assert!(found[0] == 0.0 && (found[1] - 4.0 * 2.0_f64.sqrt() * 4.0_f64.ln()).abs() < 0.2, "{found:?}");
        let whole = Window { x: 4, y: 6, w: 5, h: 1 };
        let of = |x: i64, w: usize| Window { x, w, ..whole };
        assert_eq!(Parts::Halves.of(whole), [whole, of(4, 3), of(6, 3), whole, whole]);
    }

    // Red that turns green is another hue, the same in each pixel: of (H, S, V) only V varies.
    #[test]
    fn a_change_of_hue_is_none_of_the_covariance() {
        let squares = |x: usize, y: usize| 100 + 100 * ((x / 2 + y / 3) % 2) as u8;
        let red = Frame::from_fn(20, 20, |x, y| [squares(x, y), 0, 0]);
        let green = Frame::from_fn(20, 20, |x, y| [0, squares(x, y), 0]);
        let (frames, boxes) = ([red, green], [Rect::new(3.0, 2.0, 12.0, 9.0); 2]);
        let value = |params: &str| run("region-covariance", params, &frames, &boxes);
        assert_eq!(value("{ colors = \"hsv\" }"), [0.0, 0.0]);
        assert!(value("{}")[1] > 5.0);
    }
}
