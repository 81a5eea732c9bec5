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
mod conformance_tests;
/// Example of the documentation, which must pass the same tests as the list.
#[cfg(test)]
#[path = "../../../docs/examples/deviation.rs"]
mod deviation;
#[cfg(test)]
mod testing;
#[cfg(test)]
mod tests;

pub use example::Example;
pub use labels::{EVEN, RECOVERY_FRAMES, StateOfTarget, changes, lost, run_starts};
pub use learning::{LearnError, Learner};
pub use stream::{Judgement, Stream};
pub use track_quality::{Check, Condition, Quality};

use crate::direction::Direction;
use crate::plugin::{Entry, Role};
use serde::{Deserialize, Serialize};
use std::any::Any;
use std::sync::Arc;

/// Names that most files of detectors import.
mod prelude {
    pub(super) use super::stream::{Causal, Step};
    pub(super) use super::{Detector, DetectorOutput, Facts, Input, RECOVERY_FRAMES, Stream};
    pub(super) use super::{Example, LearnError, Learner};
    pub(super) use crate::direction::Direction;
    pub(super) use crate::plugin::{Entry, ParamError, PlainParams, Plugin, Range};
    pub(super) use serde::{Deserialize, Serialize};
    pub(super) use smart_default::SmartDefault;
}

/// Runs a tracker backwards in time, for detectors that compare a track with itself.
pub trait Reverse {
    /// Tracking error, in `[0, 1]`, between two regions of frame `to`: that of the track, and that of the
    /// tracker when it starts in the later frame `from`, with its state of that frame, and runs backwards.
    /// Frames count from 0; an error of 0 is agreement. Frames after `from` are not read.
    ///
    /// `None` if the run fails; the engine then discards the detector's output.
    fn error(&self, from: usize, to: usize) -> Option<f64>;
}

/// Input of a detector: one track.
#[derive(Clone, Copy)]
pub struct Input<'a> {
    /// One finite value for each frame, from the track's first frame on.
    pub signal: &'a [f64],
    /// Further signals, as many as the detector [reads](Facts::signals) beyond the first.
    pub more: &'a [&'a [f64]],
    /// Tracking error O_t of each frame in `[0, 1]`, NaN where there is no ground truth. Only the `oracle`
    /// anchor may read it.
    pub error: &'a [f64],
    /// Seed made from names. Only the `random` anchor uses it.
    pub seed: u64,
    /// Runs the tracker backwards, for detectors that [need](Facts::needs_reverse) it.
    pub reverse: Option<&'a dyn Reverse>,
}

/// Output of a detector for one track. Each list has one value for each frame of the signal.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct DetectorOutput {
    /// Score in each frame, normally the value that is compared with the threshold: the signal itself, |z_t|
    /// of a forecast ...
    pub score: Vec<f64>,
    /// Value that is compared with the threshold, if it is not the score. This is the case if the score is
    /// the probability of a loss and an alarm requires more, for example a fresh loss.
    pub alarm_score: Option<Vec<f64>>,
    /// `true` where the detector calls the track inconsistent (the tracker has failed).
    pub alarm: Vec<bool>,
    /// Forecast of the signal, NaN in frames without one; `None` from detectors that make no forecasts.
    pub forecast: Option<Vec<f64>>,
    /// Changes (+1, -1, 0) from detectors that find them directly, perhaps two of one sign in a row; `None`
    /// if the changes follow from the alarms.
    pub changes: Option<Vec<i32>>,
    /// Condition of the tracker and recovery checks, from detectors that estimate them.
    pub quality: Option<Quality>,
    /// Reason why there are no labels, from detectors that run a program. The lists are then empty, and the
    /// cell fails.
    #[serde(skip)]
    pub failure: Option<String>,
}

impl DetectorOutput {
    /// Values that are compared with the threshold.
    pub fn compared(&self) -> &[f64] {
        self.alarm_score.as_deref().unwrap_or(&self.score)
    }

    /// Change into each frame: +1 from consistent to inconsistent, -1 back, 0 for no change.
    pub fn changes(&self) -> std::borrow::Cow<'_, [i32]> {
        self.changes.as_deref().map_or_else(|| changes(&self.alarm).into(), Into::into)
    }
}

/// Properties of a detector that are independent of the track.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Facts {
    /// True if the detector reads a signal; false for anchors.
    pub needs_signal: bool,
    /// Number of signals that the detector reads, if it reads any.
    pub signals: usize,
    /// True if the labels depend on the seed. Otherwise another seed recomputes nothing.
    pub uses_seed: bool,
    /// True if the detector runs the tracker backwards. Without [`Input::reverse`] its checks are rejected.
    pub needs_reverse: bool,
    /// Threshold on the score, as figures draw it; `None` if there is no fixed one.
    pub threshold: Option<f64>,
    /// Direction in which scores are better. Anchors may have either direction: their score is 0 or 1, the
    /// alarm itself.
    pub direction: Direction,
    /// True if the score is the signal itself.
    pub scores_signal: bool,
    /// True if the score is the probability of a loss.
    pub gives_probability: bool,
    /// Frames without an alarm in a row after which a lost target counts as found again, see [`lost`]. It is
    /// 1 for detectors whose alarm lasts until they find that the track is good again.
    pub frames_to_recover: usize,
}

impl Default for Facts {
    /// Facts of a detector of one signal whose low scores mean a good track.
    fn default() -> Self {
        Self {
            needs_signal: true,
            signals: 1,
            uses_seed: false,
            needs_reverse: false,
            threshold: None,
            direction: Direction::LowerIsBetter,
            scores_signal: false,
            gives_probability: false,
            frames_to_recover: RECOVERY_FRAMES,
        }
    }
}

/// A detector with checked parameters.
pub trait Detector: Any + Send + Sync {
    /// Properties of the detector.
    fn facts(&self) -> Facts;

    /// Learner of the model, for detectors that need a model before they can detect.
    fn learner(&self) -> Option<&dyn Learner> {
        None
    }

    /// Stream before the first frame of a live track; `None` for detectors that need the whole track.
    fn stream(&self) -> Option<Box<dyn Stream>> {
        None
    }

    /// Labels all frames of a track.
    fn detect(&self, input: &Input<'_>) -> DetectorOutput;
}

impl<P: Detector> Role<P> for dyn Detector {
    fn hold(plugin: P) -> Arc<Self> {
        Arc::new(plugin)
    }
}

/// Threshold of the largest budget up to `budget`, or of the smallest budget if all are larger. `thresholds`
/// has pairs of budget and threshold, by ascending budget.
fn threshold_within(thresholds: &[(f64, f64)], budget: f64) -> Option<f64> {
    let within = thresholds.iter().rev().find(|(most, _)| *most <= budget);
    within.or(thresholds.first()).map(|(_, threshold)| *threshold)
}

/// All detectors, by kind.
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
