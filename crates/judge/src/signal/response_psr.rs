//! `response-psr`: peak-to-sidelobe ratio of the tracker's response map, how far its peak stands out from the rest.
//!
//! ```text
//! PSR = (max F - mean(S)) / std(S)
//! ```
//!
//! `F` is the response map and `S`, the sidelobe, are its cells outside a window around the peak; the map wraps around.
//! The ratio has no unit, is at least 0 and the same after any gain and offset of the map. High values are good:
//! Bolme et al. found 20 to 60 while their filter tracks and about 7 or less when the target is occluded or lost.
//!
//! | `sidelobe` | window | source |
//! |---|---|---|
//! | `window` | 11 x 11 cells | Bolme, Beveridge, Draper and Lui, CVPR 2010, section 3.5 |
//! | `five-percent` | 5 % of the map's sides each way | FuCoLoT (Lukezic et al., ACCV 2018), `calculate_resp_quality` |
//! | `whole` | none | OpenCV's MOSSE, `mosseTracker.cpp`, which calls the target lost below 5.7 |
//!
//! Choices: a map that is nowhere above its sidelobe has ratio 0, and one whose sidelobe is flat has 1e6, the largest
//! value (OpenCV and FuCoLoT add 1e-5 and 1e-4 to the deviation, which depends on the map's gain). Cells of the trackers
//! here are 1 to 16 pixels, so that 11 cells are more of the target than in the paper, where a cell is a pixel; where the
//! map is not wider, the whole map is the sidelobe.

use super::causal::Causal;
use super::{Direction, Facts, Observation, Reads, Signal};
use crate::plugin::{Entry, PlainParams};
use crate::tracker::Response;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

pub(crate) const ENTRY: Entry<dyn Signal> =
    Entry::of::<Params>("response-psr", 1, "peak-to-sidelobe ratio of the tracker's response map")
        .example("{ sidelobe = \"window\" }");

/// Largest ratio, that of a flat sidelobe.
const MAX_RATIO: f64 = 1e6;

/// Cells that the peak is compared with.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Sidelobe {
    /// All but the 11 x 11 cells around the peak.
    #[default]
    Window,
    /// All but those within 5 % of the map's sides from the peak.
    FivePercent,
    /// All.
    Whole,
}

/// Parameters of the ratio.
#[derive(Debug, Clone, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Params {
    /// Cells that the peak is compared with.
    pub sidelobe: Sidelobe,
}

impl PlainParams for Params {}

impl Causal for Params {
    type Memory = ();

    fn facts(&self) -> Facts {
        Facts { reads: Reads::Response, ..Facts::of(Direction::HigherIsBetter, (0.0, MAX_RATIO)) }
    }

    fn push(&self, (): &mut (), observation: &Observation<'_>) -> f64 {
        let response = observation.state.response.as_ref();
        response.map_or(f64::NAN, |response| peak_to_sidelobe(response, self.sidelobe))
    }
}

/// The ratio of a map.
fn peak_to_sidelobe(response: &Response, sidelobe: Sidelobe) -> f64 {
    let (mean, deviation) = match sidelobe {
        Sidelobe::Window => (response.sidelobe_mean, response.sidelobe_deviation),
        Sidelobe::FivePercent => (response.narrow_sidelobe_mean, response.narrow_sidelobe_deviation),
        Sidelobe::Whole => (response.mean, response.deviation),
    };
    let height = response.peak - mean;
    if height > 0.0 { height / deviation.max(height / MAX_RATIO) } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::signal::testing::value_of_map;
    use crate::tracker::testing::two_peaks;
    use proptest::prelude::*;

    fn psr(sidelobe: &str, values: &[f32], width: usize) -> f64 {
        value_of_map(&ENTRY, &format!("{{ sidelobe = \"{sidelobe}\" }}"), values, width)
    }

    // python3: with F and side of `tracker/correlation/response/tests.rs`, NumPy 2.4.6:
    // [(F.max() - S.mean()) / S.std() for S in (side(5, 5), side(1, 1), F)]
    #[test]
    fn agrees_with_numpy() {
        let ratios = ["window", "five-percent", "whole"].map(|s| psr(s, &two_peaks(), 20));
        for (got, want) in ratios.iter().zip([7.349575370134235, 5.63208832905963, 4.4777501056186315]) {
            assert!((got / want - 1.0).abs() < 1e-13, "{ratios:?}");
        }
    }

    // By hand: a spike a over n - 1 zeros has mean a / n and deviation a sqrt(n - 1) / n, thus the ratio sqrt(n - 1).
    #[test]
    fn closed_cases() {
        let mut spike = vec![0.0; 401];
        spike[7] = 0.5;
        assert!((psr("whole", &spike, 401) - 20.0).abs() < 1e-12);
        let mut spike = vec![0.0; 400];
        spike[7] = 0.5;
        assert_eq!([psr("window", &spike, 20), psr("five-percent", &spike, 20)], [1e6; 2]);
        assert_eq!(["window", "five-percent", "whole"].map(|s| psr(s, &[3.0; 400], 20)), [0.0; 3]);
    }

    proptest! {
        #[test]
        fn gain_and_offset_change_nothing(gain in 1..9_i16, offset in -50..50_i16) {
            let values = two_peaks();
            let other: Vec<f32> = values.iter().map(|v| f32::from(gain) * v + f32::from(offset)).collect();
            for sidelobe in ["window", "five-percent", "whole"] {
                let ratio = psr(sidelobe, &other, 20) / psr(sidelobe, &values, 20);
                prop_assert!((ratio - 1.0).abs() < 1e-9, "{} {}", sidelobe, ratio);
            }
        }
    }
}
