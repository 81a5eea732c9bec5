//! `cusum`: the one-sided cumulative sum of Page ("Continuous inspection schemes", Biometrika 41, 1954), with the
//! normal level from the start of the track.
//!
//! ```text
//! mu = mean of y[0], ..., y[start - 1]       z[t] = (mu - y[t]) / sigma    or    (y[t] - mu) / sigma
//! S[t] = max(0, S[t-1] + z[t] - k)           alarm at t when S[t] >= h
//! ```
//!
//! The left `z` belongs to `below` (a loss lowers the signal), the right one to `above`; the parameter's value is `h`.
//! `y` and `mu` are in the signal's unit; `S` (the score, high is suspicious), `k` and `h` in standard deviations
//! `sigma` of the start; `t` is a 0-based frame. [`control_chart`](super::control_chart) says how `sigma` is
//! found, and that frames of the start score 0.
//!
//! Choices, as the source knows `mu` and `sigma`: both are those of the first 25 frames, where a tracker has just
//! been told its target. `k = 0.5` finds a shift of one sigma best; `h = 5` then lets an independent normal signal
//! alarm once in some 930 frames. The source has the process stopped and repaired at an alarm. A track goes on, and
//! a loss lasts, so that an alarm stays until the signal is back at `mu`: a shift of d sigma comes back to there by
//! chance with probability Phi(-d) a frame, and a target that is found does within a few frames.

use super::control_chart::ControlChart;
use super::prelude::*;

pub(crate) const ENTRY: Entry<dyn Detector> = Entry::of::<ControlChart<false>>(
    "cusum",
    1,
    "alarm when deviations from the mean of the track's start add up (Page's cumulative sum)",
)
.example("{ below = 5.0 }")
.more(&["{ above = 0.5, start = 4, k = 0.1 }", "{ below = 0.5, start = 4, release = 0.3 }"]);

#[cfg(test)]
mod tests {
    use super::*;
    use crate::detector::testing::detect;

    fn scores(text: &str, signal: &[f64]) -> Vec<f64> {
        let output = detect(&ENTRY, text, signal);
        assert!(output.score.iter().zip(&output.alarm).all(|(s, alarm)| *alarm == (*s >= 2.0)), "{text}");
        output.score
    }

    // By hand: the start has mean 0 and standard deviation 1, so that z = y; 0.5 is taken off in each frame. The
    // alarm of frame 5 lasts until y is 0 again in frame 8.
    #[test]
    fn sums_by_hand() {
        let signal = [-1.0, 0.0, 1.0, 0.0, 1.0, 2.0, 0.25, 0.5, 0.0, 1.0];
        let plain = "{ above = 2.0, start = 3 }";
        assert_eq!(scores(plain, &signal), [0.0, 0.0, 0.0, 0.0, 0.5, 2.0, 2.0, 2.0, 0.0, 0.5]);
        let early = "{ above = 2.0, start = 3, release = 0.25 }";
        assert_eq!(scores(early, &signal), [0.0, 0.0, 0.0, 0.0, 0.5, 2.0, 0.0, 0.0, 0.0, 0.5]);
        assert_eq!(scores("{ below = 2.0, start = 3, k = 0.0 }", &signal), [0.0; 10]);
    }

    // Siegmund ("Sequential Analysis", 1985): mean run length of about (exp(b) - b - 1) / 0.5 for normal values, where
    // k = 0.5 and b = h + 1.166, here 938; a table's value is 930. A long start stands for known mu and sigma. Any value
    // ends an alarm, so that the sum begins anew after it.
    #[test]
    fn a_normal_signal_alarms_once_in_930_frames() {
        use rand_distr::{Distribution, StandardNormal};
        let mut rng = crate::num::seed::rng(1954);
        let signal: Vec<f64> = (0..2_100_000).map(|_| StandardNormal.sample(&mut rng)).collect();
        let text = "{ above = 5.0, start = 100000, release = 1000.0 }";
        let alarm = detect(&ENTRY, text, &signal).alarm;
        let runs = alarm.iter().filter(|a| **a).count() as f64;
        // Some 2150 runs, whose lengths have a standard deviation near their mean; mu is known to 0.003 sigma.
        assert!((2e6 / runs / 930.0 - 1.0).abs() < 0.12, "{}", 2e6 / runs);
    }
}
