//! Uncertainty of a multi-hypothesis tracker: the spread of its hypotheses (SanMiguel and Cavallaro, CVIU
//! 131, 2015, Eq. 4-5). High values speak for a failure.
//!
//! ```text
//! S_ij = sum_n pi(n) (x_i(n) - m_i)(x_j(n) - m_j)            weighted covariance of the particles
//! u_t  = (1 / C) det(S)^(1 / d)
//! ```
//!
//! `S` is the `d x d` covariance of the tracker's posterior, which the tracker delivers with its answer;
//! `C` is a size in square pixels. Where all components are pixels, `u_t` has no unit; with an angle
//! among them it is a geometric mean of unlike variances, and only its ratios mean something.
//!
//! Paper to code: Sigma_t and d are those of `components`, 0-based: all of them in this paper, the center
//! `[0, 1]` in ARTE (SanMiguel, Cavallaro and Martinez, IEEE TIP 21(5), 2012). Choices where the paper is
//! silent: C, "to consider the target size", is Hx Hy, a quarter of the area of the first region's
//! rectangle (`first-size`); a constant C cancels in [`super::uncertainty_change`]. `u_t` is at least
//! `floor`, as particles that agree in one component have determinant 0. A determinant that rounding
//! makes negative, or that is positive by rounding alone, counts as 0.
//!
//! A tracker without posterior, a component it does not have and a region without area give NaN, which
//! the engine reports as the error of that track.

use crate::signal::prelude::*;
use crate::tracker::Moments;

pub(crate) const ENTRY: Entry<dyn Signal> = Entry::of::<Params>(
    "uncertainty",
    1,
    "spread of the tracker's hypotheses: root of the determinant of their covariance",
)
.example("{ normalise = \"first-size\" }");

/// Size C by which uncertainty is divided.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
#[schemars(rename = "Normalise")]
pub enum Normalize {
    /// No division: C = 1.
    None,
    /// A quarter of the area of the region's rectangle in the first frame.
    FirstSize,
    /// A quarter of the area of the region's rectangle in each frame.
    CurrentSize,
}

/// Range of `floor`, also for detectors of this signal.
pub const FLOOR: Range = Range::within("floor", 1e-100, 1.0);

/// Parameters of the signal.
#[derive(Debug, Clone, SmartDefault, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Params {
    /// State components that are used, 0-based, without repetitions; by default all.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub components: Option<Vec<usize>>,
    /// Size C by which uncertainty is divided.
    #[serde(rename = "normalise")]
    #[default(Normalize::FirstSize)]
    pub normalize: Normalize,
    /// Least value, 1e-100 to 1.
    #[default(1e-12)]
    pub floor: f64,
}

impl PlainParams for Params {
    const RANGES: &'static [Range] = &[FLOOR];

    fn check(&self) -> Result<(), ParamError> {
        let Some(components) = &self.components else { return Ok(()) };
        let differ = components.iter().enumerate().all(|(k, c)| !components[..k].contains(c));
        let is_fine = (1..=64).contains(&components.len()) && differ;
        let rule = "1 to 64 different indices of state components";
        ParamError::unless(is_fine, "components", rule, format!("{components:?}"))
    }
}

impl Causal for Params {
    /// A quarter of the area in the first frame.
    type Memory = Option<f64>;

    fn facts(&self) -> Facts {
        let facts = Facts::of(Direction::LowerIsBetter, (self.floor, f64::INFINITY));
        Facts { reads: Reads::Posterior, symbol: "uₜ", ..facts }
    }

    fn push(&self, first_size: &mut Option<f64>, &Observation { state, .. }: &Observation<'_>) -> f64 {
        let quarter = state.region.rect().area() / 4.0;
        let size = match self.normalize {
            Normalize::None => 1.0,
            Normalize::FirstSize => *first_size.get_or_insert(quarter),
            Normalize::CurrentSize => quarter,
        };
        let components = self.components.as_deref();
        let root = state.posterior.as_ref().and_then(|m| root_determinant(m, components));
        // 0 / 0, x / 0 and overflow must not be replaced by the floor.
        match root.map(|root| root / size) {
            Some(u) if u.is_finite() => u.max(self.floor),
            _ => f64::NAN,
        }
    }
}

/// det(S)^(1/d) of the chosen components; 0 if the covariance is singular up to rounding, `None` if a
/// component does not exist or a number is not finite.
fn root_determinant(moments: &Moments, components: Option<&[usize]>) -> Option<f64> {
    let dimension = moments.mean.len();
    let picked: Vec<usize> = components.map_or_else(|| (0..dimension).collect(), <[usize]>::to_vec);
    let n = picked.len();
    if n == 0 || picked.iter().any(|k| *k >= dimension) || moments.covariance.len() != dimension * dimension {
        return None;
    }
    let mut s: Vec<f64> =
        (0..n * n).map(|k| moments.covariance[picked[k / n] * dimension + picked[k % n]]).collect();
    if s.iter().chain(&moments.mean).any(|v| !v.is_finite()) {
        return None;
    }
    // Elimination without pivoting is stable for covariances. A pivot is the variance of a component given
    // those before it; below these bounds it is the rounding of its variance, or of the mean's digits.
    let least = |(k, i): (usize, &usize)| 1e-13 * s[k * n + k].abs() + (1e-13 * moments.mean[*i]).powi(2);
    let least: Vec<f64> = picked.iter().enumerate().map(least).collect();
    let mut log_determinant = 0.0;
    for k in 0..n {
        let pivot = s[k * n + k];
        if pivot <= least[k] {
            return Some(0.0);
        }
        log_determinant += pivot.ln();
        for i in k + 1..n {
            let factor = s[i * n + k] / pivot;
            for j in k + 1..n {
                s[i * n + j] -= factor * s[k * n + j];
            }
        }
    }
    Some((log_determinant / n as f64).exp())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::signal::testing::run_on_states;
    use crate::tracker::TrackerState;
    use proptest::prelude::*;
    use trackfail_testing::assert_near;

    fn moments(covariance: &[f64]) -> Moments {
        let dimension = covariance.len().isqrt();
        let mean = vec![0.0; dimension];
        Moments { mean, covariance: covariance.to_vec(), effective_samples: 100.0, ..Moments::default() }
    }

    fn state(w: f64, h: f64, covariance: &[f64]) -> TrackerState {
        let region = Region::Rect(Rect::new(3.0, 4.0, w, h));
        TrackerState { posterior: Some(moments(covariance)), ..TrackerState::tracked(region) }
    }

    // By hand: 3e-13 is below 1e-13 of a variance of 4, and 5e-13 below the square of 1e-13 of a mean of 10^7.
    #[test]
    fn what_is_rounding_is_no_variance() {
        let singular = |covariance: &[f64], mean: f64| {
            root_determinant(&Moments { mean: vec![0.0, mean], ..moments(covariance) }, None) == Some(0.0)
        };
        assert!(singular(&[1.0, 2.0, 2.0, 4.0 + 3e-13], 0.0));
        assert!(!singular(&[1.0, 2.0, 2.0, 4.0 + 8e-13], 0.0));
        assert!(singular(&[1.0, 0.0, 0.0, 5e-13], 1e7) && !singular(&[1.0, 0.0, 0.0, 5e-13], 1e6));
    }

    #[test]
    fn up_to_64_components_are_taken() {
        let built = |count: usize| {
            let components: Vec<usize> = (0..count).collect();
            ENTRY.build_from_text(&format!("{{ components = {components:?} }}")).is_ok()
        };
        assert_eq!([0, 1, 64, 65].map(built), [false, true, true, false]);
    }

    fn run(text: &str, states: &[TrackerState]) -> Vec<f64> {
        run_on_states("uncertainty", text, states)
    }

    // python3: import numpy as np; S=np.array([[25,3,.5,-.2,.1],[3,16,.4,.3,-.2],[.5,.4,.6,.05,.01],
    // [-.2,.3,.05,.5,.02],[.1,-.2,.01,.02,.04]]); np.linalg.det(S)**.2, np.sqrt(np.linalg.det(S[:2,:2])),
    // np.linalg.det(S[np.ix_([4,1,2],[4,1,2])])**(1/3)
    const S: [f64; 25] = [
        25.0, 3.0, 0.5, -0.2, 0.1, 3.0, 16.0, 0.4, 0.3, -0.2, 0.5, 0.4, 0.6, 0.05, 0.01, -0.2, 0.3, 0.05,
        0.5, 0.02, 0.1, -0.2, 0.01, 0.02, 0.04,
    ];

    #[test]
    fn agrees_with_numpy() {
        let track = [state(10.0, 8.0, &S)];
        for (text, want) in [
            ("{ normalise = \"none\" }", FULL),
            ("{}", FULL / 20.0),
            ("{ components = [0, 1], normalise = \"none\" }", CENTER),
            ("{ components = [4, 1, 2], normalise = \"none\" }", THREE),
        ] {
            let got = run(text, &track)[0];
            assert!((got / want - 1.0).abs() < 1e-14, "{text}: {got} {want}");
        }
    }
    const FULL: f64 = 1.314083800119825;
    const CENTER: f64 = 19.77371993328519;
    const THREE: f64 = 0.7049982395207787;

    // By hand: det = 36, root 6; quarters of the areas are 1, 2 and 4.
    #[test]
    fn sizes_by_hand() {
        let s = [4.0, 0.0, 0.0, 9.0];
        let track = [state(2.0, 2.0, &s), state(4.0, 2.0, &s), state(4.0, 4.0, &s)];
        for (normalize, states, want) in [
            ("first-size", &track[1..], &[3.0; 2][..]),
            ("current-size", &track, &[6.0, 3.0, 1.5]),
            ("none", &track, &[6.0; 3]),
        ] {
            assert_near(run(&format!("{{ normalise = \"{normalize}\" }}"), states), want, 5e-14, normalize);
        }
    }

    // Nothing spread; one component fixed; a line; a line that rounding bends to either side; a variance
    // that is the last digit of the mean.
    #[test]
    fn singular_covariances_are_at_the_floor() {
        let up = 1.0 + f64::EPSILON;
        for s in [
            [0.0; 4],
            [9.0, 0.0, 0.0, 0.0],
            [0.0, 0.0, 0.0, 9.0],
            [9.0, 6.0, 6.0, 4.0],
            [9.0, 6.0 * up, 6.0 * up, 4.0],
            [9.0, 6.0, 6.0, 4.0 * up],
        ] {
            assert_eq!(run("{}", &[state(4.0, 4.0, &s)]), [1e-12], "{s:?}");
        }
        let mut digits = state(4.0, 4.0, &[9.0, 0.0, 0.0, 1e-28]);
        digits.posterior.as_mut().unwrap().mean = vec![3.0, 300.0];
        assert_eq!(run("{ floor = 1e-9 }", &[digits]), [1e-9]);
    }

    #[test]
    fn what_has_no_uncertainty_is_not_a_number() {
        let sound = [1.0, 0.0, 0.0, 1.0];
        let mut short = state(4.0, 4.0, &sound);
        short.posterior.as_mut().unwrap().covariance.pop();
        for (text, state) in [
            ("{}", TrackerState::tracked(Region::Rect(Rect::new(0.0, 0.0, 4.0, 4.0)))),
            ("{ components = [0, 2] }", state(4.0, 4.0, &sound)),
            ("{}", state(0.0, 4.0, &sound)),
            ("{}", state(0.0, 4.0, &[0.0; 4])),
            ("{}", state(4.0, 4.0, &[f64::NAN, 0.0, 0.0, 1.0])),
            ("{}", state(4.0, 4.0, &[])),
            ("{}", short),
        ] {
            assert!(run(text, std::slice::from_ref(&state))[0].is_nan(), "{text} {state:?}");
        }
    }

    fn covariance(d: usize) -> impl Strategy<Value = Vec<f64>> {
        proptest::collection::vec(-3.0..3.0_f64, d * d).prop_map(move |a| {
            let product = |i: usize, j: usize| (0..d).map(|k| a[i * d + k] * a[j * d + k]).sum::<f64>();
            let ridge = |i, j| if i == j { 0.1 } else { 0.0 };
            (0..d * d).map(|n| product(n / d, n % d) + ridge(n / d, n % d)).collect()
        })
    }

    proptest! {
        #[test]
        fn scaling_scales_and_order_does_not_matter(s in covariance(4), by in 0.01..100.0_f64) {
            let root = |s: &[f64], picked: &[usize]| root_determinant(&moments(s), Some(picked)).unwrap();
            let u = root(&s, &[0, 1, 2, 3]);
            prop_assert!((root(&s, &[2, 0, 3, 1]) / u - 1.0).abs() < 1e-9);
            let scaled: Vec<f64> = s.iter().map(|v| v * by).collect();
            prop_assert!((root(&scaled, &[0, 1, 2, 3]) / (by * u) - 1.0).abs() < 1e-12);
            // Uncorrelated parts: det of a block matrix is the product of those of its blocks.
            let mut blocks = s.clone();
            for (i, j) in [(0, 2), (0, 3), (1, 2), (1, 3)] {
                blocks[i * 4 + j] = 0.0;
                blocks[j * 4 + i] = 0.0;
            }
            let parts = (root(&s, &[0, 1]) * root(&s, &[2, 3])).sqrt();
            prop_assert!((root(&blocks, &[0, 1, 2, 3]) / parts - 1.0).abs() < 1e-12);
        }
    }
}
