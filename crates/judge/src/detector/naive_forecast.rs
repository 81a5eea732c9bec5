//! Forecast error of the naive model, the rival NAIVE in Khalid, Cavallaro and Rinner, "Detecting
//! tracking errors via forecasting" (BMVC 2016), section 4.1.
//!
//! ```text
//! y^[o+k] = y[o], k = 1..horizon        |z[t]| = |y[t] - y^[t]|        alarm at t when |z[t]| >= threshold
//! ```
//!
//! `y` is the signal, `o` the origin of the forecast and `t` a 0-based frame; `y`, `y^` and `threshold`
//! are in the signal's unit. High values of `|z|` are bad.
//!
//! Paper to code: l is `horizon`; the threshold is the paper's, trained on its set D1. The model needs
//! the origin's value alone. `window` (20 by default) only says where the first forecast is made, so
//! that this detector and `arma-forecast` start in the same frame; the paper does not say where its own
//! starts. `scheme` is chosen as there: one origin serves `horizon` frames.

use super::forecasting::{self, Forecaster, Plan, Scheme};
use super::prelude::*;

pub(crate) const ENTRY: Entry<dyn Detector> = Entry::of::<Params>(
    "naive-forecast",
    1,
    "forecasts the last value; alarm when the signal leaves it by the threshold",
)
.example("{ window = 20, horizon = 5, threshold = 0.004 }")
.more(&["{ scheme = \"rolling\", window = 1, horizon = 1, threshold = 0.3 }"]);

#[derive(Debug, Clone, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Params {
    /// Number of frames before the first forecast, at least 1.
    pub window: usize,
    /// Number of frames that a forecast looks ahead, at least 1.
    pub horizon: usize,
    /// Least forecast error that is an alarm, in the signal's unit, above 0.
    pub threshold: f64,
    /// Assignment of forecast origins to frames.
    pub scheme: Scheme,
}

impl Default for Params {
    fn default() -> Self {
        Self { window: 20, horizon: 5, threshold: 0.004, scheme: Scheme::Block }
    }
}

impl PlainParams for Params {
    const RANGES: &'static [Range] = &[forecasting::WINDOW, forecasting::HORIZON, forecasting::THRESHOLD];
}

impl Causal for Params {
    type Memory = Forecaster;

    fn facts(&self) -> Facts {
        Facts { threshold: Some(self.threshold), ..Facts::default() }
    }

    fn step(&self, memory: &mut Forecaster, values: &[f64]) -> Step {
        let Self { window, horizon, threshold, scheme } = *self;
        let last = |y: &[f64], ahead| vec![y[y.len() - 1]; ahead];
        let forecast = memory.push(values[0], Plan { window, horizon, scheme }, last);
        forecasting::judge(values[0], forecast, threshold)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    // By hand: origins are frames 1, 3 and 5; rolling forecasts compare each frame with the one two before it, from frame 3
    // on.
    #[test]
    fn schemes_by_hand() {
        let signal = [9.0, 1.0, 2.0, 5.0, 5.0, 4.0, 4.5];
        let output = |scheme| {
            let params = Params { window: 2, horizon: 2, threshold: 1.0, scheme };
            params.detect(&crate::detector::testing::alone(&signal))
        };
        let block = output(Scheme::Block);
        assert_eq!(block.score, [0.0, 0.0, 1.0, 4.0, 0.0, 1.0, 0.5]);
        assert_eq!(block.alarm, [false, false, true, true, false, true, false]);
        assert_eq!(output(Scheme::Rolling).score, [0.0, 0.0, 0.0, 4.0, 3.0, 1.0, 0.5]);
    }
}
