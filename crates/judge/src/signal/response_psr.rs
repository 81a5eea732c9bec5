//! `response-psr`: peak-to-sidelobe ratio of the tracker's response map: distance of the peak from the rest
//! in standard deviations.
//!
//! ```text
//! PSR = (max F - mean(S)) / std(S)
//! ```
//!
//! `F` is the response map and `S`, the sidelobe, are its cells outside the 11 x 11 cells around the peak; the map wraps
//! around. The ratio has no unit, is at least 0 and the same after any gain and offset of the map. High values are good:
//! Bolme et al. found 20 to 60 while their filter tracks and about 7 or less when the target is occluded or lost.
//!
//! Source: Bolme, Beveridge, Draper and Lui, "Visual object tracking using adaptive correlation filters", CVPR 2010,
//! section 3.5.
//!
//! Choices: a map that is nowhere above its sidelobe has ratio 0, and one whose sidelobe is flat has 1e6, the largest
//! value (OpenCV adds 1e-5 to the deviation, which depends on the map's gain). Cells of the trackers here are 1 to 16
//! pixels, so that 11 cells are more of the target than in the paper, where a cell is a pixel; where the map is not wider,
//! the whole map is the sidelobe.

use crate::signal::prelude::*;
use crate::tracker::Response;

pub(crate) const ENTRY: Entry<dyn Signal> =
    Entry::of::<ResponsePsr>("response-psr", 1, "peak-to-sidelobe ratio of the tracker's response map");

/// Largest ratio, that of a flat sidelobe.
const MAX_RATIO: f64 = 1e6;

/// The ratio.
#[derive(Clone, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ResponsePsr {}

impl PlainParams for ResponsePsr {}

impl Causal for ResponsePsr {
    type Memory = ();

    fn facts(&self) -> Facts {
        Facts { reads: Reads::Response, ..Facts::of(Direction::HigherIsBetter, (0.0, MAX_RATIO)) }
    }

    fn push(&self, (): &mut (), observation: &Observation<'_>) -> f64 {
        observation.state.response.as_ref().map_or(f64::NAN, peak_to_sidelobe)
    }
}

/// The ratio of a map.
fn peak_to_sidelobe(response: &Response) -> f64 {
    let height = response.peak - response.sidelobe_mean;
    if height > 0.0 { height / response.sidelobe_deviation.max(height / MAX_RATIO) } else { 0.0 }
}
