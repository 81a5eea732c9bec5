//! `response-peak`: height of the peak in the tracker's response map, or a comparison with other peaks.
//!
//! ```text
//! peak          max F
//! second-peak   max(0, F2) / max F                 F2: largest value outside a box around the peak
//! quality       q[t] / q[1],  q = max F (max F - mean(S)) / (std(S) + 1e-4)
//! ```
//!
//! `F` is the response map, `S` its cells farther than 5 % of its sides from the peak, and `t` a frame counted from the
//! one that the track starts in, 0. Values have no unit. High values are good, but of `second-peak` low ones are.
//!
//! | `measure` | source |
//! |---|---|
//! | `peak` | Ma et al., "Long-term correlation tracking" (LCT), CVPR 2015: searches again below 0.15 |
//! | `second-peak` | ATOM and DiMP, `localize_advanced`: from 0.8 on uncertain or a distractor, from 0.5 on a hard negative |
//! | `quality` | FuCoLoT (Lukezic et al., ACCV 2018), `calculate_resp_quality`: lost when the mean of the last 100 exceeds 2.7 times the value |
//!
//! The box of the second peak is described at the trackers' option `response.neighborhood`. It wraps around with the map,
//! while that of ATOM ends at the map's border. As there, masked values count as 0.
//!
//! Choices: a map whose highest value is 0 or less has a `second-peak` of 1. The deviation of `quality` is that of
//! all cells of `S`, without the correction for their number that FuCoLoT's has. Frame 0 has quality 1: its map is
//! the filter's response to the patch that it was trained on. Where `q[1]` is not above 0, it counts as 1.

use crate::signal::prelude::*;
use crate::tracker::Response;

pub(crate) const ENTRY: Entry<dyn Signal> = Entry::of::<Params>(
    "response-peak",
    1,
    "highest value of the tracker's response map, its second peak, or its quality relative to the first frame's",
)
.example("{ measure = \"peak\" }");

/// Measure of the peak.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Measure {
    /// The highest value.
    #[default]
    Peak,
    /// Second peak divided by the highest value.
    SecondPeak,
    /// Highest value times peak-to-sidelobe ratio, relative to that of the first tracked frame.
    Quality,
}

/// Parameters of the signal.
#[derive(Debug, Clone, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Params {
    /// Measure of the peak.
    pub measure: Measure,
}

impl PlainParams for Params {}

impl Causal for Params {
    /// True after the first frame, and the value to which a quality is relative.
    type Memory = (bool, Option<f64>);

    fn facts(&self) -> Facts {
        let (direction, bounds) = match self.measure {
            Measure::Peak | Measure::Quality => {
                (Direction::HigherIsBetter, (f64::NEG_INFINITY, f64::INFINITY))
            }
            Measure::SecondPeak => (Direction::LowerIsBetter, (0.0, 1.0)),
        };
        Facts { reads: Reads::Response, ..Facts::of(direction, bounds) }
    }

    fn push(&self, (started, first): &mut Self::Memory, observation: &Observation<'_>) -> f64 {
        let Some(response) = &observation.state.response else { return f64::NAN };
        match self.measure {
            Measure::Peak => response.peak,
            Measure::SecondPeak => second_peak(response),
            Measure::Quality if !std::mem::replace(started, true) => 1.0,
            Measure::Quality => {
                let quality = quality(response);
                quality / *first.get_or_insert(if quality > 0.0 { quality } else { 1.0 })
            }
        }
    }
}

/// Second peak divided by the first.
fn second_peak(response: &Response) -> f64 {
    if response.peak > 0.0 { (response.second_peak / response.peak).clamp(0.0, 1.0) } else { 1.0 }
}

/// FuCoLoT's quality of a map.
fn quality(response: &Response) -> f64 {
    let height = response.peak - response.narrow_sidelobe_mean;
    response.peak * height / (response.narrow_sidelobe_deviation + 1e-4)
}

#[cfg(test)]
mod tests {
    use crate::signal::testing::run_on_states;
    use crate::tracker::TrackerState;
    use crate::tracker::testing::{state_of_map, two_peaks};

    fn qualities(maps: &[Vec<f32>]) -> Vec<f64> {
        let states: Vec<TrackerState> = maps.iter().map(|map| state_of_map(map, 20)).collect();
        run_on_states("response-peak", "{ measure = \"quality\" }", &states)
    }

    // python3: with F, dx and dy of `tracker/correlation/response/tests.rs`, NumPy 2.4.6:
    // def q(F): S = F[(abs(dx) > 1) | (abs(dy) > 1)]; return (F.max() - S.mean()) / (S.std() + 1e-4) * F.max()
    // q(F / 2 + .25) / q(F)
    #[test]
    fn quality_is_relative_to_the_first_tracked_frame() {
        let map = two_peaks();
        let other: Vec<f32> = map.iter().map(|v| 0.5 * v + 0.25).collect();
        let got = qualities(&[other.clone(), map.clone(), other, map]);
        assert_eq!((got[0], got[1], got[3]), (1.0, 1.0, 1.0));
        assert!((got[2] / 0.7534719908317802 - 1.0).abs() < 1e-12, "{got:?}");
        // Nothing to be relative to: the quality itself.
        let flat = vec![0.0; 320];
        let got = qualities(&[flat.clone(), flat, two_peaks()]);
        assert!(got[..2] == [1.0, 0.0] && (got[2] / 5.540435418387902 - 1.0).abs() < 1e-12, "{got:?}");
    }
}
