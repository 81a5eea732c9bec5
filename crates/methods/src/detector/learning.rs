//! Detectors that learn a model from tracks before they detect.
//!
//! What is learned depends on the learner's own parameters and on the examples alone, so that detectors
//! that differ in the rest (the length of a window, a rate of false alarms) share one model.

use super::Detector;
use serde_json::Value;

/// One track to learn from.
#[derive(Debug, Clone, Copy)]
pub struct Example<'a> {
    /// The signal, one value a frame.
    pub signal: &'a [f64],
    /// Tracking error O_t a frame in `[0, 1]`, NaN where there is no ground truth.
    pub error: &'a [f64],
}

/// How a detector learns.
pub trait Learner: Send + Sync {
    /// Role of the suite whose tracks it learns from.
    fn role(&self) -> &str;

    /// Everything of its parameters that the model depends on.
    fn params(&self) -> Value;

    /// Learns from the examples, whose order is the suite's.
    ///
    /// # Errors
    /// In words, when there is nothing to learn from them.
    fn learn(&self, examples: &[Example<'_>]) -> Result<Value, String>;

    /// The detector with a model that [`learn`](Learner::learn) made.
    ///
    /// # Errors
    /// In words, when it is no such model.
    fn with_model(&self, model: &Value) -> Result<Box<dyn Detector>, String>;
}
