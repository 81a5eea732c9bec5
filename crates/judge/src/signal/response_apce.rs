//! `response-apce`: average peak-to-correlation energy of the tracker's response map, how much higher its range is than
//! the typical value above its minimum.
//!
//! ```text
//! APCE = (max F - min F)^2 / mean((F - min F)^2)
//! ```
//!
//! `F` is the response map. The value has no unit and is the same after any gain and offset of the map; it is 1 or more, up
//! to the number of cells for a single spike, and 0 (a choice) for a map without contrast. High values are good: one
//! sharp peak over a calm background.
//!
//! Source: Wang, Liu and Huang, "Large margin object tracking with circulant feature maps", CVPR 2017, eq. 9, where a
//! tracker is reliable while this and the peak are above shares of their own running means: see the detector
//! `relative-drop`.

use super::causal::Causal;
use super::{Direction, Facts, Observation, Reads, Signal};
use crate::plugin::{Entry, NoParams, ParamError, Plugin};
use crate::tracker::Response;

pub(crate) const ENTRY: Entry<dyn Signal> = Entry::of::<ResponseApce>(
    "response-apce",
    1,
    "average peak-to-correlation energy of the tracker's response map",
);

/// The energy.
#[derive(Clone)]
pub struct ResponseApce;

impl Plugin for ResponseApce {
    type Params = NoParams;

    fn make(_: NoParams) -> Result<Self, ParamError> {
        Ok(Self)
    }
}

impl Causal for ResponseApce {
    type Memory = ();

    fn facts(&self) -> Facts {
        let bounds = (0.0, f64::INFINITY);
        Facts { reads: Reads::Response, ..Facts::of(Direction::HigherIsBetter, bounds) }
    }

    fn push(&self, (): &mut (), observation: &Observation<'_>) -> f64 {
        observation.state.response.as_ref().map_or(f64::NAN, peak_to_energy)
    }
}

/// The value of a map; its mean square above the minimum is that of the mean and the variance.
fn peak_to_energy(response: &Response) -> f64 {
    let range = response.peak - response.lowest;
    let energy = (response.mean - response.lowest).powi(2) + response.deviation.powi(2);
    if range > 0.0 && energy > 0.0 { range * range / energy } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::signal::testing::value_of_map;
    use crate::tracker::testing::two_peaks;
    use proptest::prelude::*;

    fn apce(values: &[f32], width: usize) -> f64 {
        value_of_map(&ENTRY, "{}", values, width)
    }

    // python3: with F of `tracker/correlation/response/tests.rs`, NumPy 2.4.6:
    // (F.max() - F.min())**2 / ((F - F.min())**2).mean()
    #[test]
    fn agrees_with_numpy() {
        assert!((apce(&two_peaks(), 20) / 17.049655672345054 - 1.0).abs() < 1e-13);
    }

    // By hand: a spike over zeros has a^2 / (a^2 / n) = n; half of the cells at either end have a^2 / (a^2 / 2) = 2.
    #[test]
    fn closed_cases() {
        let mut spike = vec![-1.0; 144];
        spike[100] = 4.0;
        assert!((apce(&spike, 12) - 144.0).abs() < 1e-9);
        assert!((apce(&[0.0, 3.0].repeat(8), 4) - 2.0).abs() < 1e-12);
        assert_eq!(apce(&[0.7; 16], 4), 0.0);
    }

    proptest! {
        #[test]
        fn gain_and_offset_change_nothing(gain in 1..9_i16, offset in -50..50_i16) {
            let values = two_peaks();
            let other: Vec<f32> = values.iter().map(|v| f32::from(gain) * v + f32::from(offset)).collect();
            prop_assert!((apce(&other, 20) / apce(&values, 20) - 1.0).abs() < 1e-10);
        }
    }
}
