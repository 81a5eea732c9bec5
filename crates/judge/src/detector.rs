//! Detectors: from a signal to a label for each frame.
//!
//! A plugin is one file with parameters, a [`Detector`] that is a [`Plugin`](crate::plugin::Plugin), and an `ENTRY` in
//! [`DETECTORS`].

mod accumulated_validation;
mod agreement;
mod anchors;
pub mod arma_forecast;
mod arte;
mod arte_star;
mod conformal_forecast;
pub mod consistency;
mod control_chart;
mod cusum;
mod example;
mod forecasting;
pub mod fused;
mod joint_drop;
pub mod labels;
mod learning;
pub mod level;
mod matched_kalman_bank;
mod naive_forecast;
mod page_hinkley;
mod relative_drop;
mod sequential_test;
mod standard_score;
mod stream;
pub mod track_quality;
mod two_model_chi_square;

#[cfg(test)]
mod conformance;
/// The example of the documentation, which has to pass what the list has to pass.
#[cfg(test)]
#[path = "../../../docs/examples/deviation.rs"]
mod deviation;

pub use example::Example;
pub use labels::{EVEN, RECOVERY_FRAMES, StateOfTarget, changes, lost, run_starts};
pub use learning::{LearnError, Learner};
pub use stream::{Judgement, Reason, Stream};
pub use track_quality::{Check, Condition, Quality};

use crate::direction::Direction;
use crate::plugin::{Entry, Role};
use serde::{Deserialize, Serialize};
use std::any::Any;
use std::sync::Arc;

/// Runs a tracker backwards in time, for detectors that compare a track with itself.
pub trait Reverse {
    /// Tracking error, in `[0, 1]`, between two regions of frame `to`: the one of the track, and the one that the
    /// tracker gives when it starts in the later frame `from` with its state of that frame and goes back frame by
    /// frame. Frames count from 0, and an error of 0 is agreement. Frames after `from` are not read.
    ///
    /// `None` when the run breaks; the engine then discards the detector's output.
    fn error(&self, from: usize, to: usize) -> Option<f64>;
}

/// Input of a detector: one track.
#[derive(Clone, Copy)]
pub struct Input<'a> {
    /// One finite value for each frame, from the track's first frame on.
    pub signal: &'a [f64],
    /// Further signals, as many as the detector [reads](Detector::signals) beyond the first.
    pub more: &'a [&'a [f64]],
    /// Tracking error O_t of each frame in `[0, 1]`, NaN where there is no ground truth. Only the `oracle`
    /// anchor may read it.
    pub error: &'a [f64],
    /// Seed that is made from names; only the `random` anchor uses it.
    pub seed: u64,
    /// Runs the tracker backwards, for detectors that [need](Detector::needs_reverse) it.
    pub reverse: Option<&'a dyn Reverse>,
}

/// Output of a detector for one track; every list has one value for each frame of the signal.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct DetectorOutput {
    /// The number that is compared with the threshold, for example the signal itself or |z_t| of a forecast.
    pub score: Vec<f64>,
    /// The number that is compared with the threshold where it is not the score: where the score is how likely the target is
    /// lost, and an alarm asks for more, for example that the loss is fresh.
    pub alarm_score: Option<Vec<f64>>,
    /// `true` where the detector calls the track inconsistent (the tracker has failed).
    pub alarm: Vec<bool>,
    /// The forecast of the signal, from detectors that make one; NaN in frames without a forecast.
    pub forecast: Option<Vec<f64>>,
    /// The changes (+1, -1, 0), from detectors that find them directly and may find two of one sign in a
    /// row; `None` where they follow from the alarms.
    pub changes: Option<Vec<i32>>,
    /// Condition of the tracker and recovery checks, from detectors that follow them.
    pub quality: Option<Quality>,
    /// Why there are no labels, from detectors that run a program; then the lists are empty, and the cell fails.
    #[serde(skip)]
    pub failure: Option<String>,
}

impl DetectorOutput {
    /// The number that is compared with the threshold.
    pub fn compared(&self) -> &[f64] {
        self.alarm_score.as_deref().unwrap_or(&self.score)
    }

    /// The change into each frame: +1 from consistent to inconsistent, -1 back, 0 where there is none.
    pub fn changes(&self) -> std::borrow::Cow<'_, [i32]> {
        self.changes.as_deref().map_or_else(|| changes(&self.alarm).into(), Into::into)
    }
}

/// A checked configuration of a detector.
pub trait Detector: Any + Send + Sync {
    /// Whether it reads the signal; anchors do not.
    fn needs_signal(&self) -> bool {
        true
    }

    /// Number of signals that it reads, if it reads any.
    fn signals(&self) -> usize {
        1
    }

    /// Whether its labels depend on the seed; if not, another seed recomputes nothing.
    fn uses_seed(&self) -> bool {
        false
    }

    /// Whether it runs the tracker backwards; without [`Input::reverse`] its checks are rejected.
    fn needs_reverse(&self) -> bool {
        false
    }

    /// Learner of its model, for detectors that need a model before they can detect.
    fn learner(&self) -> Option<&dyn Learner> {
        None
    }

    /// The threshold on the score, as figures draw it, where there is one.
    fn threshold(&self) -> Option<f64> {
        None
    }

    /// Which scores speak for a good track; by default low ones. Neither way of anchors matters, whose score is the alarm.
    fn score_direction(&self) -> Direction {
        Direction::LowerIsBetter
    }

    /// Whether its score is the signal, as it is.
    fn scores_signal(&self) -> bool {
        false
    }

    /// Whether its score is the probability of a loss.
    fn gives_probability(&self) -> bool {
        false
    }

    /// Frames in a row without an alarm after which a lost target counts as found again, see [`lost`]: 1 for detectors
    /// whose alarm lasts until they themselves have found that the track is good again.
    fn frames_to_recover(&self) -> usize {
        RECOVERY_FRAMES
    }

    /// The detector before the first frame of a track that goes on, from detectors that judge frame by frame.
    fn stream(&self) -> Option<Box<dyn Stream>> {
        None
    }

    /// The detector as it was when [`Stream::save`] was called; `None` if the bytes are not those of this detector.
    fn resume(&self, _saved: &[u8]) -> Option<Box<dyn Stream>> {
        None
    }

    /// Labels every frame of a track.
    fn detect(&self, input: &Input<'_>) -> DetectorOutput;
}

impl<P: Detector> Role<P> for dyn Detector {
    fn hold(plugin: P) -> Arc<Self> {
        Arc::new(plugin)
    }
}

/// The threshold of the largest budget that is within `budget`, of budgets in rising order with their thresholds; of those
/// that are all larger, the smallest.
fn threshold_within(thresholds: &[(f64, f64)], budget: f64) -> Option<f64> {
    let within = thresholds.iter().rev().find(|(most, _)| *most <= budget);
    within.or(thresholds.first()).map(|(_, threshold)| *threshold)
}

/// Every detector, by kind.
pub static DETECTORS: &[Entry<dyn Detector>] = &[
    arma_forecast::ENTRY,
    naive_forecast::ENTRY,
    level::ENTRY,
    standard_score::ENTRY,
    relative_drop::ENTRY,
    joint_drop::ENTRY,
    fused::ENTRY,
    cusum::ENTRY,
    page_hinkley::ENTRY,
    sequential_test::ENTRY,
    conformal_forecast::ENTRY,
    accumulated_validation::ENTRY,
    two_model_chi_square::ENTRY,
    matched_kalman_bank::ENTRY,
    arte::ENTRY,
    arte_star::ENTRY,
    anchors::NEVER,
    anchors::ALWAYS,
    anchors::PERIODIC,
    anchors::RANDOM,
    anchors::ORACLE,
    agreement::ENTRY,
];
