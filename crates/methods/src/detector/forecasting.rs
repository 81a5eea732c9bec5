//! Shared by the detectors that forecast the signal: when forecasts are made, and how they become alarms.
//!
//! Frames are 0-based. A forecast made at origin `o` knows frames up to `o` and no later one. The first
//! origin is `window - 1`, the first frame that has `window` values behind it.

use super::DetectorOutput;
use crate::plugin::ParamError;
use serde::{Deserialize, Serialize};

/// Which origin the forecast of a frame comes from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Scheme {
    /// Origins are `horizon` frames apart; each serves the `horizon` frames that follow it. The first
    /// forecast frame is `window`.
    Block,
    /// Every frame is an origin and serves only the frame `horizon` later. The first forecast frame is
    /// `window + horizon - 1`.
    Rolling,
}

/// Checks the parameters of a forecast; `least` is the smallest window of the model.
pub(super) fn check(window: usize, least: usize, horizon: usize) -> Result<(), ParamError> {
    if !(least..=100_000).contains(&window) {
        return Err(ParamError::out_of_range("window", &format!("from {least} to 100000 frames"), window));
    }
    if !(1..=100_000).contains(&horizon) {
        return Err(ParamError::out_of_range("horizon", "from 1 to 100000 frames", horizon));
    }
    Ok(())
}

/// Checks a fixed threshold on the forecast error.
pub(super) fn check_threshold(threshold: f64) -> Result<(), ParamError> {
    // Frames without a forecast score 0 and must not be alarms, hence above 0.
    if !(threshold.is_finite() && threshold > 0.0) {
        return Err(ParamError::out_of_range("threshold", "finite and above 0", threshold));
    }
    Ok(())
}

/// The forecast of every frame, NaN where there is none yet. `model` takes the last `window` values up to
/// the origin and the number of frames to forecast, and returns that many values.
pub(super) fn forecasts(
    signal: &[f64],
    window: usize,
    horizon: usize,
    scheme: Scheme,
    model: impl Fn(&[f64], usize) -> Vec<f64>,
) -> Vec<f64> {
    let mut all = vec![f64::NAN; signal.len()];
    let mut next = window;
    while next < signal.len() {
        let path = model(&signal[next - window..next], horizon);
        match scheme {
            Scheme::Block => {
                all[next..].iter_mut().zip(path).for_each(|(frame, value)| *frame = value);
                next += horizon;
            }
            Scheme::Rolling => {
                if let (Some(frame), Some(&value)) = (all.get_mut(next + horizon - 1), path.last()) {
                    *frame = value;
                } else {
                    break;
                }
                next += 1;
            }
        }
    }
    all
}

/// The forecast error |y - y^| of every frame, 0 where there is no forecast.
pub(super) fn errors(signal: &[f64], forecast: &[f64]) -> Vec<f64> {
    let error = |(y, f): (&f64, &f64)| if f.is_nan() { 0.0 } else { (y - f).abs().min(f64::MAX) };
    signal.iter().zip(forecast).map(error).collect()
}

/// Scores |y - y^|, 0 where there is no forecast, and alarms where they reach the threshold.
pub(super) fn judge(signal: &[f64], forecast: Vec<f64>, threshold: f64) -> DetectorOutput {
    let score = errors(signal, &forecast);
    let alarm = score.iter().map(|&z| z >= threshold).collect();
    DetectorOutput { score, alarm, forecast: Some(forecast), ..DetectorOutput::default() }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Forecasts the origin's value plus k / 10 for the frame k ahead.
    fn echo(window: &[f64], horizon: usize) -> Vec<f64> {
        (1..=horizon).map(|k| window[window.len() - 1] + k as f64 / 10.0).collect()
    }

    fn shown(all: &[f64]) -> Vec<Option<f64>> {
        all.iter().map(|v| if v.is_nan() { None } else { Some(*v) }).collect()
    }

    // Worked by hand: windows of 3 frames, 2 ahead.
    #[test]
    fn schemes_by_hand() {
        let y = [10.0, 11.0, 12.0, 13.0, 14.0, 15.0];
        let block = forecasts(&y, 3, 2, Scheme::Block, echo);
        assert_eq!(shown(&block), [None, None, None, Some(12.1), Some(12.2), Some(14.1)]);
        let rolling = forecasts(&y, 3, 2, Scheme::Rolling, echo);
        assert_eq!(shown(&rolling), [None, None, None, None, Some(12.2), Some(13.2)]);
    }

    #[test]
    fn windows_are_the_last_frames() {
        let y: Vec<f64> = (0..9).map(f64::from).collect();
        forecasts(&y, 4, 3, Scheme::Block, |window, ahead| {
            assert_eq!((window.len(), ahead), (4, 3));
            assert!(window == [0.0, 1.0, 2.0, 3.0] || window == [3.0, 4.0, 5.0, 6.0]);
            vec![0.0; 3]
        });
    }

    // By hand: 0.25 away from each side reaches 0.25, the NaN does not.
    #[test]
    fn judging_by_hand() {
        let output = judge(&[1.0, 1.0, 1.0, 1.0], vec![f64::NAN, 1.25, 0.75, 0.76], 0.25);
        assert_eq!(output.alarm, [false, true, true, false]);
        assert_eq!(output.score[..3], [0.0, 0.25, 0.25]);
    }
}
