//! ARTE: judges a track from changes of the tracker's uncertainty and runs backwards in time (SanMiguel,
//! Cavallaro and Martinez, IEEE TIP 21(5), 2012; as described in SanMiguel and Cavallaro, "Temporal
//! validation of particle filters for video tracking", CVIU 131, 2015, section 6).
//!
//! ```text
//! S_t = mean of u over the frames t - smoothing + 1 to t
//! increase(W)_t = (S_t - min S_j) / min S_j            j in t - W, ..., t - 1
//! decrease(W)_t = (S_t - max S_j) / S_t                same j, `over-current`
//!                 (S_t - max S_j) / max S_j            same j, `over-reference`
//! large increase:  increase(long)_t > tau_1  or  increase(short)_t > tau_1
//! large decrease:  decrease(long)_t < tau_2  or  decrease(short)_t < tau_2        tau_2 = -tau_1
//! small decrease:  decrease(short)_t < tau_3                                      tau_3 = -tau_1 / 2
//! ```
//!
//! `u` is the spatial uncertainty of the tracker (`uncertainty` of the center, `components = [0, 1]`); a
//! constant factor of it cancels. The changes have no unit; `t` is a 0-based frame, and windows are cut off
//! at the track's start. The effect of the events is in [`super::track_quality::machine`], the recovery check
//! in [`super::track_quality`]; the alarm holds while the track is unsuccessful. The score is the
//! larger of the two increases, high is suspicious, the threshold is `tau_1`. Frame t is labeled from frames
//! up to t alone.
//!
//! Source: four signals of two windows, smoothing, and three thresholds tied to tau_1 are in section 6 of the
//! second paper. Reconstruction, as the first was not at hand:
//!
//! * references: the least value of the window for a rise, the largest for a fall. A fall is taken over the
//!   current value, as one over the old value never gets below -1 and could not reach the thresholds: a rise
//!   from 1 to 5 is +4, a fall from 5 to 1 is -4. The other form, `decrease = "over-reference"`, needs
//!   thresholds of its own. That the changes, and not their onsets, are events is a choice, too;
//! * windows of 25 (slow changes) and 10 frames (sudden ones) and tau_1 = 2.05, from defaults in the authors'
//!   released program; the paper tuned tau_1 by hand, and it can be trained here. The short window is a part
//!   of the long one, so with these references its large changes are always large in the long one as well;
//!   the short window decides on small decreases alone;
//! * `smoothing` of 5 frames, causal; the kind of filter is not known.
//!
//! As in [`crate::signal::uncertainty_change`], frames whose uncertainty is at its floor are no reference:
//! they are left out of the mean, and S_t, which is the floor where nothing else is left, is no reference
//! then. As a current value it stays, and is a large fall. `settling` frames at the start of a track enter
//! neither means nor windows and cause no event, as a filter that starts on the annotation needs some 20
//! frames until its spread is that of a filter at work; the default takes the formulas as they stand.

use super::prelude::*;
use super::track_quality::machine::Events;
use super::track_quality::{self, Rules};
use crate::signal::uncertainty;

pub(crate) const ENTRY: Entry<dyn Detector> = Entry::of::<Params>(
    "arte",
    1,
    "alarm from a large rise of the uncertainty until a run backwards confirms a recovery (ARTE)",
)
.example("{ tau_1 = 2.05 }")
.more(&[
    "{ long = 4, short = 2, smoothing = 1, tau_1 = 0.2, settling = 3, locking_in_limit = 2 }",
    "{ decrease = \"over-reference\", tau_1 = 0.1, tau_2 = -0.3, tau_3 = -0.05, floor = 0.01 }",
]);

/// Reference value by which a fall is divided.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Decrease {
    /// The current value; a fall can be arbitrarily far below 0.
    OverCurrent,
    /// The value before the fall; a fall is above -1.
    OverReference,
}

#[derive(Debug, Clone, SmartDefault, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Params {
    /// Length in frames of the window for slow changes, 1 to 100000.
    #[default(25)]
    pub long: usize,
    /// Length in frames of the window for sudden changes, 1 to `long`.
    #[default(10)]
    pub short: usize,
    /// Number of frames over which the uncertainty is averaged, 1 to 100000.
    #[default(5)]
    pub smoothing: usize,
    /// Threshold of a large increase; above 0.
    #[default(2.05)]
    pub tau_1: f64,
    /// Threshold of a large decrease; below 0, by default -tau_1.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub tau_2: Option<f64>,
    /// Threshold of a small decrease in the short window; below 0, by default -tau_1 / 2.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub tau_3: Option<f64>,
    /// Reference value by which a fall is divided.
    #[default(Decrease::OverCurrent)]
    pub decrease: Decrease,
    /// Frames at the start of a track that are no reference and cause no event, 0 to 100000.
    pub settling: usize,
    /// Floor of the signal, 1e-100 to 1; frames at or below it are no reference.
    #[default(uncertainty::Params::default().floor)]
    pub floor: f64,
    /// Error below which a recovery check is accepted, tau_4, above 0 and at most 1.
    #[default(0.8)]
    pub accept_below: f64,
    /// Most frames of a run backwards, 0 to 100000.
    #[default(200)]
    pub reverse_limit: usize,
    /// Number of frames after which LOCKING-IN ends, 1 to 100000; by default `long`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub locking_in_limit: Option<usize>,
    /// Number of frames from the reference of a check to the frame in which the track was lost, 1 to 100000.
    #[default(1)]
    pub reference_lag: usize,
}

impl PlainParams for Params {
    const RANGES: &'static [Range] = &[
        Range::within("long", 1.0, 100_000.0),
        Range::within("short", 1.0, 100_000.0),
        Range::within("smoothing", 1.0, 100_000.0),
        Range::of("tau_1").above(0.0),
        Range::of("tau_2").below(0.0),
        Range::of("tau_3").below(0.0),
        Range::within("settling", 0.0, 100_000.0),
        uncertainty::FLOOR,
        track_quality::ACCEPT_BELOW,
        track_quality::REVERSE_LIMIT,
        track_quality::LOCKING_IN_LIMIT,
        track_quality::REFERENCE_LAG,
    ];

    fn check(&self) -> Result<(), ParamError> {
        ParamError::unless(self.short <= self.long, "short", "1 to `long` frames", self.short)
    }
}

impl Params {
    /// S_t: the mean of the last values of `u` above the floor, or the floor if there are none.
    fn smoothed(&self, u: &[f64]) -> Vec<f64> {
        let Params { smoothing, settling, floor, .. } = *self;
        let mean = |t: usize| {
            let first = settling.max((t + 1).saturating_sub(smoothing)).min(t + 1);
            let above = u[first..=t].iter().filter(|u| **u > floor);
            // A running mean: no sum overflows, and that of equal values is their value.
            let (n, mean) = above.fold((0.0, 0.0), |(n, mean), u| (n + 1.0, mean + (u - mean) / (n + 1.0)));
            if n > 0.0 { f64::max(mean, floor) } else { floor }
        };
        (0..u.len()).map(mean).collect()
    }

    /// Relative increase and decrease over the long and the short window in frame `t` of the smoothed series,
    /// without unit; 0 if there is no reference.
    fn changes(&self, smoothed: &[f64], t: usize) -> [(f64, f64); 2] {
        let Params { long, short, settling, floor, decrease, .. } = *self;
        let now = smoothed[t];
        let within = |window: usize| {
            let first = settling.max(t.saturating_sub(window)).min(t);
            let past = smoothed[first..t].iter().copied().filter(|s| *s > floor);
            let bounds = past.clone().reduce(f64::min).zip(past.reduce(f64::max));
            let Some((least, most)) = bounds.filter(|_| t >= settling) else { return (0.0, 0.0) };
            let over = match decrease {
                Decrease::OverCurrent => now,
                Decrease::OverReference => most,
            };
            // Ratios of numbers that have little to do with each other may be too large for a number.
            (((now - least) / least).min(f64::MAX), ((now - most) / over).max(-f64::MAX))
        };
        [within(long), within(short)]
    }

    /// Score and events in each frame, from the uncertainty `u`.
    fn events(&self, u: &[f64]) -> (Vec<f64>, Vec<Events>) {
        let tau_1 = self.tau_1;
        let tau_2 = self.tau_2.unwrap_or(-tau_1);
        let tau_3 = self.tau_3.unwrap_or(-tau_1 / 2.0);
        let smoothed = self.smoothed(u);
        let frame = |t: usize| {
            let [(long_rise, long_fall), (short_rise, short_fall)] = self.changes(&smoothed, t);
            let score = long_rise.max(short_rise);
            (score, [score > tau_1, long_fall.min(short_fall) < tau_2, short_fall < tau_3])
        };
        (0..u.len()).map(frame).unzip()
    }
}

impl Detector for Params {
    fn facts(&self) -> Facts {
        Facts { needs_reverse: true, threshold: Some(self.tau_1), frames_to_recover: 1, ..Facts::default() }
    }

    fn detect(&self, input: &Input<'_>) -> DetectorOutput {
        let Params { accept_below, reverse_limit, reference_lag, .. } = *self;
        let locking_in_limit = self.locking_in_limit.unwrap_or(self.long);
        let rules = Rules { accept_below, reverse_limit, locking_in_limit, reference_lag };
        rules.follow(input, self.events(input.signal))
    }
}

#[cfg(test)]
mod tests;
