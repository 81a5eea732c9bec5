//! Score of the Numenta Anomaly Benchmark with its standard profile: early alarms in a loss are worth more, false alarms
//! cost little, and most of all long after a loss (Lavin and Ahmad, "Evaluating real-time anomaly detection algorithms",
//! ICMLA 2015; numenta/NAB, `nab/sweeper.py` and `nab/runner.py` at d62afec and ec449a3).
//!
//! ```text
//! sigma(y) = 2 / (1 + e^(5 y)) - 1
//! in a window:      y = -(last - t + 1) / width                       an alarm is worth sigma(y) / sigma(-1)
//! outside of one:   y = (t - last) / (width - 1) of the window before            it is worth 0.11 sigma(y),
//!                                                            and -0.11 where no window is before or y > 3
//! raw score   = sum over windows of the best alarm in it, -1 without any + sum over false alarms
//! NAB         = 100 (raw + windows) / (2 windows)
//! ```
//!
//! Windows are the ranges of lost frames of `frames/1`, `last` is a window's last frame and `width` its number of
//! frames; `t` is a 0-based frame. Every frame with an alarm counts. The first 15 % of a track (of its first 5000 frames
//! at most) are probation: alarms there and windows that end there do not count, but false alarms after a window have its
//! distance. The normalization is NAB's: a detector without an alarm has 0, all windows found in their first frames 100.
//! High is good; many false alarms make it negative.
//!
//! Deviations: a window of one frame has `width - 1` = 1, where the program divides by 0. NAB's windows are a
//! tenth of a file around a labeled point, and so begin before the event. Here windows begin with the loss,
//! so an alarm before it is a false one.

use super::truth::{Rule, ScoredTrack, runs};
use std::ops::Range;

/// Share of a track that is probation.
const PROBATION: f64 = 0.15;
/// Number of frames from whose share the longest probation follows.
const LONGEST: f64 = 5000.0;
/// Weight of a false alarm in the standard profile. Hits and misses have weight 1.
const FALSE_ALARM: f64 = 0.11;

/// First frame that counts, in a track with this number of frames.
pub fn probation(frames: usize) -> usize {
    (PROBATION * frames as f64).floor().min(PROBATION * LONGEST) as usize
}

fn sigma(y: f64) -> f64 {
    2.0 / (1.0 + (5.0 * y).exp()) - 1.0
}

/// Raw score of a track, and its number of windows that count.
fn raw(lost: &[bool], alarm: &[bool]) -> (f64, u64) {
    let first = probation(lost.len());
    let windows = runs(lost);
    let alarms = |range: Range<usize>| range.filter(|t| alarm.get(*t) == Some(&true));
    let mut sum = 0.0;
    let mut counted = 0;
    let mut before: Option<&Range<usize>> = None;
    let mut from = 0;
    for window in windows.iter().map(Some).chain([None]) {
        let to = window.map_or(lost.len(), |w| w.start);
        for t in alarms(from.max(first)..to) {
            let y = before.map(|w| (t + 1 - w.end) as f64 / (w.len() - 1).max(1) as f64);
            sum += FALSE_ALARM * y.filter(|y| *y <= 3.0).map_or(-1.0, sigma);
        }
        let Some(window) = window else { break };
        if window.end > first {
            let y = |t: usize| -((window.end - t) as f64) / window.len() as f64;
            sum += alarms(window.start.max(first)..window.end)
                .next()
                .map_or(-1.0, |t| sigma(y(t)) / sigma(-1.0));
            counted += 1;
        }
        (before, from) = (Some(window), window.end);
    }
    (sum, counted)
}

/// Score of all tracks; `None` without a window.
pub fn score(tracks: &[ScoredTrack<'_>]) -> Option<f64> {
    let of_track = |t: &ScoredTrack<'_>| raw(&Rule::NoOverlap.lost(t.error), t.alarm);
    let (sum, windows) = tracks.iter().map(of_track).fold((0.0, 0), |a, b| (a.0 + b.0, a.1 + b.1));
    (windows > 0).then(|| 100.0 * (sum + windows as f64) / (2.0 * windows as f64))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::score::testing::{error, oracle, set, value};
    use serde_json::Value;
    use trackfail_testing::assert_near;

    // tests/oracles/frames.py: row by row, as nab/sweeper.py at d62afec goes through a file with weights 1, .11 and 1.
    #[test]
    fn agrees_with_the_sweeper_of_nab() {
        for case in &oracle::<Vec<Value>>("nab") {
            let [lost, alarm] = ["lost", "alarm"].map(|name| value::<Vec<u8>>(case, name));
            let [lost, alarm] = [lost, alarm].map(|list| list.iter().map(|v| *v == 1).collect::<Vec<_>>());
            let (score, windows) = raw(&lost, &alarm);
            assert_near([score], [value::<f64>(case, "score")], 1e-12, "");
            assert_eq!(windows, value::<u64>(case, "windows"));
        }
    }

    // By hand: 15 % of 100 frames are 15, and those of more than 5000 frames 750.
    #[test]
    fn what_ends_with_the_probation_does_not_count() {
        assert_eq!([0, 6, 7, 100, 5000, 6000].map(probation), [0, 0, 1, 15, 750, 750]);
        assert_eq!(raw(&set(100, &[[10, 15]]), &[false; 100]), (0.0, 0));
        assert_eq!(raw(&set(100, &[[10, 16]]), &[false; 100]), (-1.0, 1));
    }

    /// The score of a track of 200 frames.
    fn normalized(lost: &[[usize; 2]], alarm: &[[usize; 2]]) -> f64 {
        let (error, alarm) = (error(200, lost), set(200, alarm));
        score(&[ScoredTrack { sequence: 0, error: &error, score: &[], alarm: &alarm }]).unwrap()
    }

    #[test]
    fn silence_is_0_first_frames_are_100_and_noise_is_negative() {
        let lost = [[50, 70], [150, 200]];
        assert_eq!((normalized(&lost, &[]), normalized(&lost, &[[50, 51], [150, 151]])), (0.0, 100.0));
        assert!(normalized(&lost, &[[0, 200]]) < 0.0);
    }
}
