//! Forecast error of an ARMA model: Khalid, Cavallaro and Rinner, "Detecting tracking errors via
//! forecasting" (BMVC 2016), section 3, Eqs. 8 and 9; the method DTEF on its distribution field signal.
//!
//! ```text
//! |z[t]| = |y[t] - y^[t]|        alarm at t when |z[t]| >= threshold
//! ```
//!
//! `y` is the signal and `y^` its forecast, both in the signal's unit; `t` is a 0-based frame. High
//! values of `|z|` are bad. The forecast comes from an ARMA model fitted to the last `window` frames
//! before its origin, see [`crate::num::arma`]; frames before the first forecast have `|z| = 0`.
//!
//! Paper to code: P, Q are `order`, Delta t_2 is `window`, l is `horizon`, tau_1 is `threshold`. The
//! defaults are the paper's values for its tests on OTB.
//!
//! The paper leaves open, and the parameters choose: which origin serves which frame (`scheme`; default
//! `block`, since the paper says that its naive rival forecasts "at time t for the complete forecast
//! length"), and the responses before the window (`start`; default `backcast`, as its software does). If
//! a window cannot be fitted because its values overflow, its last value is the forecast.

use super::forecasting::{self, Forecaster, Plan, Scheme};
use super::prelude::*;
use crate::num::arma::{self, Presample};

/// ARMA forecasts in the list of detectors.
pub const ENTRY: Entry<dyn Detector> = Entry::of::<Params>(
    "arma-forecast",
    1,
    "forecasts the signal with an ARMA model; alarm when the forecast is off by the threshold",
)
.example("{ order = [1, 1], window = 20, horizon = 5, threshold = 0.004 }")
.more(&[
    "{}",
    "{ scheme = \"rolling\", start = \"drop-first\", window = 10, horizon = 3 }",
    "{ order = [2, 1], window = 12, horizon = 10, threshold = 0.1 }",
    "{ order = [0, 0], window = 3, horizon = 1, threshold = 0.1 }",
]);

/// Parameters of the detector.
#[derive(Debug, Clone, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Params {
    /// Autoregressive and moving average order, each 0 to 5.
    pub order: [usize; 2],
    /// Number of frames to which a model is fitted, at least `2 p + q + 3`.
    pub window: usize,
    /// Number of frames that a forecast looks ahead, at least 1.
    pub horizon: usize,
    /// Least forecast error that is an alarm, in the signal's unit, above 0.
    pub threshold: f64,
    /// Assignment of forecast origins to frames.
    pub scheme: Scheme,
    /// Values assumed before the window.
    pub start: Presample,
}

impl Default for Params {
    fn default() -> Self {
        let (scheme, start) = (Scheme::Block, Presample::Backcast);
        Self { order: [1, 1], window: 20, horizon: 5, threshold: 0.004, scheme, start }
    }
}

impl Params {
    /// Returns the forecast of the next frame (NaN if there is none yet), then adds its actual value `y`.
    pub(super) fn push(&self, memory: &mut Forecaster, y: f64) -> f64 {
        let Self { window, horizon, scheme, .. } = *self;
        memory.push(y, Plan { window, horizon, scheme }, |y, ahead| {
            match arma::fit(y, self.order, self.start) {
                Some(model) => model.forecast(ahead),
                None => vec![y[y.len() - 1]; ahead],
            }
        })
    }
}

impl PlainParams for Params {
    const RANGES: &'static [Range] = &[
        Range::within("order", 0.0, arma::MAX_ORDER as f64),
        forecasting::WINDOW,
        forecasting::HORIZON,
        forecasting::THRESHOLD,
    ];

    /// The window must be long enough for the order.
    fn check(&self) -> Result<(), ParamError> {
        let least = arma::least_window(self.order);
        let rule = format!("from {least} to 100000");
        ParamError::unless(self.window >= least, "window", &rule, self.window)
    }
}

impl Causal for Params {
    type Memory = Forecaster;

    fn facts(&self) -> Facts {
        Facts { threshold: Some(self.threshold), ..Facts::default() }
    }

    fn step(&self, memory: &mut Forecaster, values: &[f64]) -> Step {
        let forecast = self.push(memory, values[0]);
        forecasting::judge(values[0], forecast, self.threshold)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::detector::testing::alone;

    fn detect(params: Params, signal: &[f64]) -> DetectorOutput {
        params.detect(&alone(signal))
    }

    // A step of 0.02 at frame 30, itself the first frame of a block: the model of the level before it cannot
    // foresee it, so the block's forecasts miss by the step. From frame 50 on the window lies behind it.
    #[test]
    fn a_step_is_an_alarm_where_it_happens() {
        let signal: Vec<f64> = (0..80).map(|t| if t < 30 { 0.05 } else { 0.03 }).collect();
        let output = detect(Params::default(), &signal);
        assert!(output.alarm[..30].iter().all(|a| !a));
        assert!(output.alarm[30..35].iter().all(|&a| a));
        assert!(output.score[30..35].iter().all(|z| (z - 0.02).abs() < 1e-12));
        assert!(output.alarm[50..].iter().all(|a| !a));
    }

    // Block forecasts of frame 24 and rolling ones five ahead share origin 19, and so on every five frames.
    #[test]
    fn schemes_begin_after_the_window_and_agree_where_they_share_an_origin() {
        let signal: Vec<f64> = (0..40).map(|t| f64::from(t * 7 % 10) / 10.0).collect();
        let [block, rolling] =
            [(Scheme::Block, 20), (Scheme::Rolling, 24)].map(|(scheme, first)| {
                let output = detect(Params { scheme, ..Params::default() }, &signal);
                let forecast = output.forecast.unwrap();
                assert!((0..40).all(
                    |t| forecast[t].is_finite() == (t >= first) && (t >= first || output.score[t] == 0.0)
                ));
                forecast
            });
        assert!([24, 29, 34, 39].iter().all(|t| block[*t] == rolling[*t]));
    }
}
