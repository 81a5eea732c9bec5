//! Detectors that learn a model from tracks before they detect.
//!
//! A model depends on the learner's own parameters and on the examples alone, so that detectors that differ in
//! other parameters (the length of a window, a rate of false alarms) share one model.

use super::Detector;
use super::consistency::ConsistencyError;
use super::example::Example;
use crate::num::accumulation::AccumulationError;
use crate::plugin::ParamError;
use serde_json::Value;
use std::sync::Arc;

/// Why there is no model, or no detector with it.
#[derive(Debug, thiserror::Error)]
pub enum LearnError {
    /// The examples give no model of consistency.
    #[error(transparent)]
    Consistency(#[from] ConsistencyError),
    /// The examples have no window whose frames are all consistent.
    #[error("no window of {0} consistent frames")]
    NoWindow(usize),
    /// The examples have no lost frames, or no others.
    #[error("the training tracks of a fold have no lost frames, or no others")]
    OneKind,
    /// The model cannot be written.
    #[error(transparent)]
    Write(serde_json::Error),
    /// The model that is given is of another kind.
    #[error("no model of consistency: {0}")]
    Read(#[source] serde_json::Error),
    /// The model that is given was learned for another length or rate.
    #[error("a model of another length or rate")]
    OtherModel,
    /// The distribution of a sum cannot be computed.
    #[error(transparent)]
    Accumulation(#[from] AccumulationError),
    /// The detector's parameters do not go with the model.
    #[error(transparent)]
    Params(#[from] ParamError),
}

/// How a detector learns.
pub trait Learner: Send + Sync {
    /// Role of the suite whose tracks it learns from.
    fn role(&self) -> &str;

    /// Whether one model is learned from the tracks of all trackers, and not one for each tracker from its own.
    fn pools_trackers(&self) -> bool {
        false
    }

    /// The parameters that the model depends on.
    fn params(&self) -> Value;

    /// Learns from the examples, whose order is the suite's.
    ///
    /// # Errors
    /// When the examples do not determine a model.
    fn learn(&self, examples: &[Example<'_>]) -> Result<Value, LearnError>;

    /// The detector with a model that [`learn`](Learner::learn) made.
    ///
    /// # Errors
    /// When the model is not of this learner.
    fn with_model(&self, model: &Value) -> Result<Arc<dyn Detector>, LearnError>;
}
