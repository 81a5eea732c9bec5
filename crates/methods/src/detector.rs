//! Detectors: from a signal to a label a frame.
//!
//! A plugin is one file with parameters, a [`Detector`] and an `ENTRY` in [`DETECTORS`].

pub mod accumulated_validation;
pub mod always;
pub mod arma_forecast;
pub mod arte;
pub mod arte_star;
pub mod consistency;
pub mod forecasting;
pub mod labels;
pub mod learning;
pub mod level;
pub mod matched_kalman_bank;
pub mod naive_forecast;
pub mod never;
pub mod oracle;
pub mod periodic;
pub mod random;
pub mod track_quality;
pub mod two_model_chi_square;

#[cfg(test)]
mod conformance;
/// The example of the documentation, which has to pass what the list has to pass.
#[cfg(test)]
#[path = "../../../docs/examples/deviation.rs"]
mod deviation;

pub use labels::{changes, run_starts};
pub use learning::{Example, LearnError, Learner};
pub use track_quality::{Check, Condition, Quality};

use crate::plugin::Entry;
use serde::{Deserialize, Serialize};

/// Runs a tracker backwards in time, for detectors that hold a track against itself.
pub trait Reverse {
    /// Tracking error, in `[0, 1]`, between what the tracker said of frame `to` on its way forward and what it
    /// says of it when it starts in the later frame `from` with what it believed there and goes back frame by
    /// frame; frames count from 0, and 0 is agreement. The frames after `from` are not looked at.
    ///
    /// `None` when the run breaks; whoever lent this throws the output away then.
    fn error(&self, from: usize, to: usize) -> Option<f64>;
}

/// What a detector is given.
#[derive(Clone, Copy)]
pub struct Input<'a> {
    /// One finite value a frame, from the track's first frame.
    pub signal: &'a [f64],
    /// Tracking error O_t a frame in `[0, 1]`, NaN where there is no ground truth. Only the `oracle`
    /// anchor may look at it.
    pub error: &'a [f64],
    /// Seed made from names; only the `random` anchor uses it.
    pub seed: u64,
    /// The tracker backwards, for detectors that [need](Detector::needs_reverse) it.
    pub reverse: Option<&'a dyn Reverse>,
}

/// What a detector says, each field as long as the signal.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct DetectorOutput {
    /// The number that is compared with the threshold: the signal itself, or |z_t| of a forecast.
    pub score: Vec<f64>,
    /// `true` where the track is called inconsistent (the tracker has failed).
    pub alarm: Vec<bool>,
    /// The forecast of the signal, from detectors that make one; NaN where there is none yet.
    pub forecast: Option<Vec<f64>>,
    /// The changes (+1, -1, 0), from detectors that find them directly and may find two of one sign in a
    /// row; elsewhere they are where the label changes.
    pub changes: Option<Vec<i32>>,
    /// How it came to its labels, from detectors that follow the condition of the tracker.
    pub quality: Option<Quality>,
}

impl DetectorOutput {
    /// The change into each frame: +1 from consistent to inconsistent, -1 back, 0 where there is none.
    pub fn changes(&self) -> std::borrow::Cow<'_, [i32]> {
        self.changes.as_deref().map_or_else(|| changes(&self.alarm).into(), Into::into)
    }
}

/// A checked configuration of a detector.
pub trait Detector: Send + Sync {
    /// Checked parameters, defaults filled in.
    fn params(&self) -> serde_json::Value;

    /// Whether it reads the signal at all; anchors do not.
    fn needs_signal(&self) -> bool {
        true
    }

    /// Whether its labels depend on the seed; where they do not, another seed recomputes nothing.
    fn uses_seed(&self) -> bool {
        false
    }

    /// Whether it runs the tracker backwards; without [`Input::reverse`] no check of it succeeds.
    fn needs_reverse(&self) -> bool {
        false
    }

    /// How it learns its model, for detectors that must have one before they can detect.
    fn learner(&self) -> Option<&dyn Learner> {
        None
    }

    /// The threshold on the score that is drawn in figures, where there is one.
    fn threshold(&self) -> Option<f64> {
        None
    }

    /// Labels every frame.
    fn detect(&self, input: &Input<'_>) -> DetectorOutput;
}

/// Every detector, by kind.
pub static DETECTORS: &[Entry<dyn Detector>] = &[
    arma_forecast::ENTRY,
    naive_forecast::ENTRY,
    level::ENTRY,
    accumulated_validation::ENTRY,
    two_model_chi_square::ENTRY,
    matched_kalman_bank::ENTRY,
    arte::ENTRY,
    arte_star::ENTRY,
    never::ENTRY,
    always::ENTRY,
    periodic::ENTRY,
    random::ENTRY,
    oracle::ENTRY,
];
