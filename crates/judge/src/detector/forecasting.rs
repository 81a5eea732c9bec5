//! Shared code of detectors that forecast the signal: when forecasts are made, and how they become alarms.
//!
//! Frames are 0-based. A forecast made at origin `o` knows frames up to `o` and no later one. The first
//! origin is `window - 1`, the first frame that has `window` values behind it.

use super::stream::Step;
use crate::plugin::Range;
use serde::{Deserialize, Serialize};
use std::collections::VecDeque;

/// Assignment of forecast origins to frames.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Scheme {
    /// Origins are `horizon` frames apart; each serves the `horizon` frames after it. The first forecast
    /// frame is `window`.
    Block,
    /// Each frame is an origin that serves only the frame `horizon` later. The first forecast frame is
    /// `window + horizon - 1`.
    Rolling,
}

/// Range of the number of frames that a model sees.
pub(super) const WINDOW: Range = Range::within("window", 1.0, 100_000.0);

/// Range of the number of frames that a forecast looks ahead.
pub(super) const HORIZON: Range = Range::within("horizon", 1.0, 100_000.0);

/// Range of a fixed threshold on the forecast error. Frames without a forecast score 0 and must not be
/// alarms, so it is above 0.
pub(super) const THRESHOLD: Range = Range::of("threshold").above(0.0);

/// Frames from which forecasts are made, and frames for which they are made.
#[derive(Debug, Clone, Copy)]
pub(super) struct Plan {
    /// Number of frames that a model sees.
    pub window: usize,
    /// Number of frames that a forecast looks ahead.
    pub horizon: usize,
    /// Assignment of forecast origins to frames.
    pub scheme: Scheme,
}

/// The last values of a signal, and the forecasts made from them.
#[derive(Debug, Default, Serialize, Deserialize)]
pub(super) struct Forecaster {
    /// The last `window` values.
    window: VecDeque<f64>,
    /// Forecasts of coming frames.
    path: VecDeque<f64>,
}

impl Forecaster {
    /// Returns the forecast of the next frame (NaN if there is none yet), then adds its actual value `y`.
    /// `model` receives the last `window` values and the number of frames to forecast, and returns that many
    /// values.
    pub fn push(&mut self, y: f64, plan: Plan, model: impl Fn(&[f64], usize) -> Vec<f64>) -> f64 {
        let mut forecast = None;
        if self.window.len() >= plan.window {
            match plan.scheme {
                Scheme::Block => {
                    if self.path.is_empty() {
                        self.path = model(self.window.make_contiguous(), plan.horizon).into();
                    }
                    forecast = self.path.pop_front();
                }
                Scheme::Rolling => {
                    self.path.extend(model(self.window.make_contiguous(), plan.horizon).last());
                    if self.path.len() == plan.horizon {
                        forecast = self.path.pop_front();
                    }
                }
            }
            self.window.pop_front();
        }
        self.window.push_back(y);
        forecast.unwrap_or(f64::NAN)
    }
}

/// Forecast error |y - y^|; 0 without a forecast.
pub(super) fn error(y: f64, forecast: f64) -> f64 {
    if forecast.is_nan() { 0.0 } else { (y - forecast).abs().min(f64::MAX) }
}

/// Step with the forecast error as score, and an alarm if it reaches the threshold.
pub(super) fn judge(y: f64, forecast: f64, threshold: f64) -> Step {
    let score = error(y, forecast);
    Step { forecast: Some(forecast), ..Step::new(score, score >= threshold) }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Forecasts of the origin's value plus k / 10 for the frame k ahead; the windows are of values that rise by 1.
    fn forecasts(signal: &[f64], scheme: Scheme) -> Vec<f64> {
        let mut forecaster = Forecaster::default();
        let echo = |window: &[f64], horizon: usize| -> Vec<f64> {
            assert!(window.len() == 3 && window[2] - window[0] == 2.0, "{window:?}");
            (1..=horizon).map(|k| window[2] + k as f64 / 10.0).collect()
        };
        signal.iter().map(|y| forecaster.push(*y, Plan { window: 3, horizon: 2, scheme }, echo)).collect()
    }

    fn shown(all: &[f64]) -> Vec<Option<f64>> {
        all.iter().map(|v| if v.is_nan() { None } else { Some(*v) }).collect()
    }

    // Worked by hand: windows of 3 frames, 2 ahead.
    #[test]
    fn schemes_by_hand() {
        let y = [10.0, 11.0, 12.0, 13.0, 14.0, 15.0];
        for (scheme, want) in [
            (Scheme::Block, [None, None, None, Some(12.1), Some(12.2), Some(14.1)]),
            (Scheme::Rolling, [None, None, None, None, Some(12.2), Some(13.2)]),
        ] {
            assert_eq!(shown(&forecasts(&y, scheme)), want);
        }
    }

    // By hand: 0.25 away from each side reaches 0.25, the NaN does not.
    #[test]
    fn judging_by_hand() {
        let steps = [f64::NAN, 1.25, 0.75, 0.76].map(|forecast| judge(1.0, forecast, 0.25));
        assert_eq!(steps.map(|step| step.alarm), [false, true, true, false]);
        assert_eq!(steps.map(|step| step.score)[..3], [0.0, 0.25, 0.25]);
    }
}
