//! `response-apce` and `response-psr`: how far the peak of the tracker's response map stands out.
//!
//! ```text
//! APCE = (max F - min F)^2 / mean((F - min F)^2)         average peak-to-correlation energy
//! PSR  = (max F - mean(S)) / std(S)                      peak-to-sidelobe ratio
//! ```
//!
//! `F` is the response map and `S`, the sidelobe, are its cells outside the 11 x 11 cells around the peak; the map wraps
//! around. Neither value has a unit, and both are the same after any gain and offset of the map. High values are good: one
//! sharp peak over a calm background.
//!
//! The APCE is 1 or more, up to the number of cells for a single spike, and 0 (a choice) for a map without contrast. Source:
//! Wang, Liu and Huang, "Large margin object tracking with circulant feature maps", CVPR 2017, eq. 9, where a tracker is
//! reliable while this and the peak are above shares of their own running means: see the detector `relative-drop`.
//!
//! The PSR is at least 0. Source: Bolme, Beveridge, Draper and Lui, "Visual object tracking using adaptive correlation
//! filters", CVPR 2010, section 3.5, who found 20 to 60 while their filter tracks and about 7 or less when the target is
//! occluded or lost. Choices: a map that is nowhere above its sidelobe has ratio 0, and one whose sidelobe is flat has 1e6,
//! the largest value (OpenCV adds 1e-5 to the deviation, which depends on the map's gain). Cells of the trackers here are 1
//! to 16 pixels, so that 11 cells are more of the target than in the paper, where a cell is a pixel; where the map is not
//! wider, the whole map is the sidelobe.

use crate::signal::prelude::*;
use crate::tracker::Response;

pub(crate) const APCE: Entry<dyn Signal> = Entry::of::<Ratio<true>>(
    "response-apce",
    1,
    "average peak-to-correlation energy of the tracker's response map",
);

pub(crate) const PSR: Entry<dyn Signal> =
    Entry::of::<Ratio<false>>("response-psr", 1, "peak-to-sidelobe ratio of the tracker's response map");

/// Largest ratio to a sidelobe, that of a flat one.
const MAX_RATIO: f64 = 1e6;

/// Ratio of the peak to the energy of the map, or to its sidelobe.
#[derive(Clone, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Ratio<const ENERGY: bool> {}

impl<const ENERGY: bool> PlainParams for Ratio<ENERGY> {}

impl<const ENERGY: bool> Causal for Ratio<ENERGY> {
    type Memory = ();

    fn facts(&self) -> Facts {
        let most = if ENERGY { f64::INFINITY } else { MAX_RATIO };
        Facts { reads: Reads::Response, ..Facts::of(Direction::HigherIsBetter, (0.0, most)) }
    }

    fn push(&self, (): &mut (), observation: &Observation<'_>) -> f64 {
        let Some(map) = &observation.state.response else { return f64::NAN };
        if ENERGY { peak_to_energy(map) } else { peak_to_sidelobe(map) }
    }
}

/// APCE of a map. The mean square above the minimum is computed from mean and variance.
fn peak_to_energy(response: &Response) -> f64 {
    let range = response.peak - response.lowest;
    let energy = (response.mean - response.lowest).powi(2) + response.deviation.powi(2);
    if range > 0.0 && energy > 0.0 { range * range / energy } else { 0.0 }
}

/// PSR of a map.
fn peak_to_sidelobe(response: &Response) -> f64 {
    let height = response.peak - response.sidelobe_mean;
    if height > 0.0 { height / response.sidelobe_deviation.max(height / MAX_RATIO) } else { 0.0 }
}
