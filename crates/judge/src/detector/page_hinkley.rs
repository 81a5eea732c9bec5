//! `page-hinkley`: Page's cumulative sum with the running mean as normal level, the form of Hinkley ("Inference
//! about the change-point from cumulative sum tests", Biometrika 58, 1971) that is used on streams of data.
//!
//! ```text
//! mu[t] = mean of the frames up to t         z[t] = (mu[t] - y[t]) / sigma    or    (y[t] - mu[t]) / sigma
//! S[t] = max(0, S[t-1] + z[t] - k)           alarm at t when S[t] >= h
//! ```
//!
//! The left `z` belongs to `below` (a loss lowers the signal), the right one to `above`; the parameter's value is `h`.
//! `y` and `mu` are in the signal's unit; `S` (the score, high is suspicious), `k` and `h` in standard deviations
//! `sigma` of the start; `t` is a 0-based frame. [`control_chart`](super::control_chart) says how `sigma` is
//! found, and that frames of the start score 0. `S` is the usual `m[t] - min m` of `m[t] = sum (z[i] - k)`.
//!
//! The difference from `cusum` is `mu` alone: it follows slow changes of the signal, such as of light, and in time a
//! lasting loss too.
//!
//! Choices: sigma from the first 25 frames, `k = 0.5` and `h = 5` as there. The mean of the start begins the running
//! mean, which has the current frame in it, as in the usual implementations. An alarm stays until the signal is back
//! at `mu`, for the reason given at `cusum`; frames that follow an alarm frame are not in the mean, since the lost
//! target's values are not normal.

use super::control_chart::ControlChart;
use super::prelude::*;

pub(crate) const ENTRY: Entry<dyn Detector> = Entry::of::<ControlChart<true>>(
    "page-hinkley",
    1,
    "alarm when deviations from the running mean of the track add up (Page-Hinkley test)",
)
.example("{ below = 5.0 }")
.more(&["{ above = 0.5, start = 4 }", "{ below = 0.5, start = 4, floor = 0.1 }"]);

#[cfg(test)]
mod tests {
    use super::*;
    use crate::detector::testing::detect;
    use trackfail_testing::assert_near;

    // By hand: the start has mean 0 and standard deviation 1. Frame 3 moves the mean to 1: S = 4 - 1 - 0.5.
    // The mean stays 1 in the alarm: S grows by 2 - 1 - 0.5, and frame 5 ends the alarm. Frame 7 is the sixth in the mean:
    // 1 + 5/6.
    #[test]
    fn sums_by_hand() {
        let signal = [-1.0, 0.0, 1.0, 4.0, 2.0, 1.0, 1.0, 6.0];
        let want = [0.0, 0.0, 0.0, 2.5, 3.0, 0.0, 0.0, 11.0 / 3.0];
        let output = detect(&ENTRY, "{ above = 2.5, start = 3 }", &signal);
        assert_near(&output.score, want, 1e-14, "");
        assert_eq!(output.alarm, want.map(|s| s >= 2.5));
    }
}
