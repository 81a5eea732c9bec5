//! `response-apce`: average peak-to-correlation energy of the tracker's response map: its squared range
//! relative to the mean square above its minimum.
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

use crate::signal::prelude::*;
use crate::tracker::Response;

pub(crate) const ENTRY: Entry<dyn Signal> = Entry::of::<ResponseApce>(
    "response-apce",
    1,
    "average peak-to-correlation energy of the tracker's response map",
);

/// The APCE signal.
#[derive(Clone, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ResponseApce {}

impl PlainParams for ResponseApce {}

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

/// APCE of a map. The mean square above the minimum is computed from mean and variance.
fn peak_to_energy(response: &Response) -> f64 {
    let range = response.peak - response.lowest;
    let energy = (response.mean - response.lowest).powi(2) + response.deviation.powi(2);
    if range > 0.0 && energy > 0.0 { range * range / energy } else { 0.0 }
}
