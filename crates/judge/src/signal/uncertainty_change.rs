//! Change of a multi-hypothesis tracker's uncertainty against the frames before (SanMiguel and Cavallaro,
//! CVIU 131, 2015, Eq. 6-7). High values speak for a failure, or for the end of one.
//!
//! ```text
//! c_t = |u_t - u_r| / |u_r|      r = argmax over j in W of |u_t - u_j| / |u_j|
//! ```
//!
//! `u_t` is [`super::uncertainty`]; `t` is a 0-based frame and W the frames `t - window` to `t - 1`, as far
//! as there are any. `c_t` has no unit, is at least 0, and is 0 in the first frame. A rise has no upper
//! bound; a fall gives less than 1. Constant factors of `u` cancel.
//!
//! Paper to code: |W| is `window`, 25. The formulas have lost their fences in the copy that was read; that
//! they are absolute values is likely, as the paper calls `c_t` positive and looks for falls as well. The
//! other reading is `form = "signed"`, (u_t - min u_j) / min u_j floored at 0, which ignores falls.
//!
//! Deviation: a particle filter that starts with all particles on the annotation has no spread in its first
//! frame, `u` is at its floor there, and 25 frames long every `c_t` would be of the order of 1e12. Frames at
//! the floor are therefore no reference (`skip_degenerate`), and `c_t` is 0 while there is no other.
//!
//! Such a filter then needs some 20 frames until its spread is that of a filter at work; all that time, and
//! as long as those frames are in the window, c_t is large although nothing is lost. The paper shows c_t of a
//! consistent filter close to 0 and its uncertainty almost constant (section 5.1, Fig. 4), so its own filter
//! had no such start. `settling` frames at the start of a track are therefore no reference and have
//! c_t = 0; 0, the default, takes the formulas as they stand.

use super::uncertainty::{self, Normalize};
use crate::signal::prelude::*;
use std::collections::VecDeque;

pub(crate) const ENTRY: Entry<dyn Signal> = Entry::of::<UncertaintyChange>(
    "uncertainty-change",
    1,
    "largest relative change of the uncertainty against the frames of a window before",
)
.example("{ window = 25 }");

/// Changes that count.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Form {
    /// Rises and falls.
    Absolute,
    /// Rises only; falls give 0.
    Signed,
}

/// Parameters: those of [`uncertainty`], and those of the comparison.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Params {
    /// Number of earlier frames with which a frame is compared, 1 to 100000.
    pub window: usize,
    /// Number of frames at the start of a track that are no reference and whose change is 0, 0 to 100000.
    pub settling: usize,
    /// Changes that count.
    pub form: Form,
    /// True if frames whose uncertainty is at the floor are no reference.
    pub skip_degenerate: bool,
    /// State components that are used, 0-based, without repetitions; by default all.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub components: Option<Vec<usize>>,
    /// Size by which uncertainty is divided.
    #[serde(rename = "normalise")]
    pub normalize: Normalize,
    /// Least uncertainty, 1e-100 to 1.
    pub floor: f64,
}

impl Default for Params {
    fn default() -> Self {
        let uncertainty::Params { components, normalize, floor } = uncertainty::Params::default();
        let form = Form::Absolute;
        Self { window: 25, settling: 0, form, skip_degenerate: true, components, normalize, floor }
    }
}

/// The signal with checked parameters.
#[derive(Clone)]
pub struct UncertaintyChange {
    params: Params,
    uncertainty: uncertainty::Params,
}

impl Plugin for UncertaintyChange {
    type Params = Params;

    const RANGES: &'static [Range] = &[
        Range::within("window", 1.0, 100_000.0),
        Range::within("settling", 0.0, 100_000.0),
        uncertainty::FLOOR,
    ];

    fn make(p: Params) -> Result<Self, ParamError> {
        let Params { components, normalize, floor, .. } = p.clone();
        let uncertainty = uncertainty::Params::new(uncertainty::Params { components, normalize, floor })?;
        Ok(Self { params: p, uncertainty })
    }
}

impl Causal for UncertaintyChange {
    /// Number of frames skipped at the start, the memory of the uncertainty, and its values in the window.
    type Memory = (usize, Option<f64>, VecDeque<f64>);

    fn facts(&self) -> Facts {
        let facts = Facts::of(Direction::LowerIsBetter, (0.0, f64::INFINITY));
        Facts { reads: Reads::Posterior, symbol: "cₜ", ..facts }
    }

    fn push(&self, (left_out, size, past): &mut Self::Memory, observation: &Observation<'_>) -> f64 {
        let u = self.uncertainty.push(size, observation);
        if *left_out < self.params.settling {
            *left_out += 1;
            // A value that is not finite is an error in any frame.
            return if u.is_finite() { 0.0 } else { u };
        }
        let Params { window, form, skip_degenerate, floor, .. } = self.params;
        change(past, u, window, form, if skip_degenerate { floor } else { 0.0 })
    }

    fn is_memory(&self, (_, _, past): &Self::Memory) -> bool {
        past.len() <= self.params.window
    }
}

/// Change (Eq. 6-7) at the next value `u`, which is at least 0, against the values of the window before; NaN
/// if `u` is not finite. Values up to `degenerate` are no reference.
fn change(past: &mut VecDeque<f64>, u: f64, window: usize, form: Form, degenerate: f64) -> f64 {
    if !u.is_finite() {
        return f64::NAN;
    }
    // The largest ratio is that of the argmax; signed ratios are largest against the minimum.
    let change = past.iter().filter(|r| **r > degenerate).fold(0.0_f64, |most, r| {
        let ratio = (u - r) / r;
        most.max(match form {
            Form::Absolute => ratio.abs(),
            Form::Signed => ratio,
        })
    });
    if past.len() == window {
        past.pop_front();
    }
    past.push_back(u);
    change
}

/// Change at each value of `u`; see [`change`].
#[cfg(test)]
pub(crate) fn changes(u: &[f64], window: usize, form: Form, degenerate: f64) -> Vec<f64> {
    let mut past = VecDeque::new();
    u.iter().map(|&u| change(&mut past, u, window, form, degenerate)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::signal::testing::{run_on_states, takes};
    use crate::tracker::{Moments, TrackerState};
    use proptest::prelude::*;

    // python3: u=[2.,3.,1.,4.,4.,.5]; [max([abs(u[t]-v)/v for v in u[max(0,t-W):t]], default=0.) for t in range(6)]
    // with W = 2, and max([0.]+[(u[t]-v)/v ...]) for the signed form.
    #[test]
    fn by_hand() {
        let u = [2.0, 3.0, 1.0, 4.0, 4.0, 0.5];
        assert_eq!(changes(&u, 2, Form::Absolute, 0.0), [0.0, 0.5, 2.0 / 3.0, 3.0, 3.0, 0.875]);
        assert_eq!(changes(&u, 2, Form::Signed, 0.0), [0.0, 0.5, 0.0, 3.0, 3.0, 0.0]);
        // References are above 2: none, 3, 3, 4 and twice 4.
        assert_eq!(changes(&u, 2, Form::Absolute, 2.0), [0.0, 0.0, 2.0 / 3.0, 1.0 / 3.0, 0.0, 0.875]);
        assert!(changes(&[1.0, f64::NAN], 2, Form::Absolute, 0.0)[1].is_nan());
    }

    #[test]
    fn a_memory_has_no_more_values_than_the_window() {
        let takes = |values: usize| {
            takes("uncertainty-change", "{ window = 2 }", &(0_usize, None::<f64>, vec![0.5_f64; values]))
        };
        assert_eq!([0, 2, 3].map(takes), [true, true, false]);
    }

    fn track(roots: &[f64]) -> Vec<TrackerState> {
        let state = |root: &f64| {
            let (mean, covariance) = (vec![50.0, 60.0], vec![*root, 0.0, 0.0, *root]);
            let posterior = Moments { mean, covariance, effective_samples: 9.0, ..Moments::default() };
            let region = Region::Rect(Rect::new(0.0, 0.0, 8.0, 4.0));
            TrackerState { posterior: Some(posterior), ..TrackerState::tracked(region) }
        };
        roots.iter().map(state).collect()
    }

    fn run(text: &str, roots: &[f64]) -> Vec<f64> {
        run_on_states("uncertainty-change", text, &track(roots))
    }

    // By hand: the first frame has no spread, the second no reference, the third doubles the second.
    #[test]
    fn a_start_without_spread_is_no_reference() {
        let near = |a: f64, b: f64| (a - b).abs() < 1e-12 * b.max(1.0);
        let c = run("{}", &[0.0, 4.0, 8.0]);
        assert!(c[..2] == [0.0, 0.0] && near(c[2], 1.0), "{c:?}");
        let c = run("{ skip_degenerate = false }", &[0.0, 4.0, 8.0]);
        assert!(c[0] == 0.0 && near(c[1], 5e11 - 1.0) && near(c[2], 1e12 - 1.0), "{c:?}");
    }

    // By hand: the first two frames are no reference; the fourth is half as much again as the third.
    #[test]
    fn settling_frames_are_no_reference_and_do_not_change() {
        assert_eq!(run("{ settling = 2 }", &[2.0, 16.0, 4.0, 6.0, 4.0]), [0.0, 0.0, 0.0, 0.5, 1.0 / 3.0]);
        assert_eq!(run("{ settling = 9 }", &[2.0, 16.0, 4.0]), [0.0; 3]);
        assert!(run("{ components = [5], settling = 9 }", &[2.0])[0].is_nan());
    }

    proptest! {
        // Of all references in a window the lowest and the highest are the farthest.
        #[test]
        fn changes_are_those_against_the_extremes(
            u in proptest::collection::vec(0.1..10.0_f64, 1..60), window in 1..30_usize,
        ) {
            let [signed, absolute] = [Form::Signed, Form::Absolute].map(|form| changes(&u, window, form, 0.0));
            for t in 1..u.len() {
                let past = &u[t.saturating_sub(window)..t];
                let (least, most) = past.iter().fold((f64::MAX, 0.0_f64), |(a, b), v| (a.min(*v), b.max(*v)));
                let rise = ((u[t] - least) / least).max(0.0);
                prop_assert_eq!(signed[t], rise);
                prop_assert!((absolute[t] - rise.max((most - u[t]) / most)).abs() < 1e-12);
            }
        }

        #[test]
        fn the_signal_is_the_change_of_the_uncertainty(
            roots in proptest::collection::vec(prop_oneof![Just(0.0), 0.1..100.0_f64], 1..40),
        ) {
            let u = run_on_states("uncertainty", "{}", &track(&roots));
            prop_assert_eq!(run("{}", &roots), changes(&u, 25, Form::Absolute, 1e-12));
        }
    }
}
