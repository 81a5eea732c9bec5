//! Detectors that learn a model from tracks before they can detect.
//!
//! A model depends only on the learner's own parameters and on the examples. Detectors that differ in other
//! parameters (the length of a window, a rate of false alarms) therefore share one model.

use super::Detector;
use super::consistency::ConsistencyError;
use super::example::Example;
use crate::num::accumulation::AccumulationError;
use crate::plugin::ParamError;
use serde_json::Value;
use std::sync::Arc;

/// Reason why a model cannot be learned or used.
#[derive(Debug, thiserror::Error)]
pub enum LearnError {
    /// The examples do not give a model of consistency.
    #[error(transparent)]
    Consistency(#[from] ConsistencyError),
    /// The examples have no window in which all frames are consistent.
    #[error("no window of {0} consistent frames")]
    NoWindow(usize),
    /// The examples have no lost frames, or only lost ones.
    #[error("the training tracks of a fold have no lost frames, or no others")]
    OneKind,
    /// The model cannot be written.
    #[error(transparent)]
    Write(serde_json::Error),
    /// The given text is not a model of consistency.
    #[error("no model of consistency: {0}")]
    Read(#[source] serde_json::Error),
    /// The given model was learned for other inputs, another length or another rate, or gives no probability.
    #[error("a model of other inputs, length or rate, or one that gives no probability")]
    OtherModel,
    /// The distribution of a sum cannot be computed.
    #[error(transparent)]
    Accumulation(#[from] AccumulationError),
    /// The detector's parameters do not match the model.
    #[error(transparent)]
    Params(#[from] ParamError),
}

/// A learner of models for a detector.
pub trait Learner: Send + Sync {
    /// Role of the suite whose tracks are the examples.
    fn role(&self) -> &str;

    /// True if one model is learned from the tracks of all trackers; false for one model per tracker.
    fn pools_trackers(&self) -> bool {
        false
    }

    /// Parameters on which the model depends.
    fn params(&self) -> Value;

    /// Learns from the examples, which are in the order of the suite.
    ///
    /// # Errors
    /// When the examples do not determine a model.
    fn learn(&self, examples: &[Example<'_>]) -> Result<Value, LearnError>;

    /// The detector with a model made by [`learn`](Learner::learn).
    ///
    /// # Errors
    /// When the model is not from this learner.
    fn with_model(&self, model: &Value) -> Result<Arc<dyn Detector>, LearnError>;
}
